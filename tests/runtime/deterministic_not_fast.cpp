// BROKEN: CAGEFORM_DETERMINISTIC and -ffast-math contradict each other
#define CAGEFORM_DETERMINISTIC
#if defined(BROKEN)
#define __FAST_MATH__ 1 // as -ffast-math does
#endif
#include <cageform/clone/clone.hpp>
