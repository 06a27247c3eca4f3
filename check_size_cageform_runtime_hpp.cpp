#include <cageform/runtime.hpp>
