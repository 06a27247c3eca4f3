#include <cageform/clone/glsl.hpp>
