// Every header behind the macros of windows.h, those of min and max too, with any compiler.
#include "macros.hpp"

#include "all_headers.hpp"
#include <cageform/adapt/glm.hpp>
#include <cageform/core/threads.hpp>

#if !defined(min) || !defined(max) || !defined(near)
#error "a header has undefined the macros: this file checks nothing"
#endif
