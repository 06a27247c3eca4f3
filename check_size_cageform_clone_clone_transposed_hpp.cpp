#include <cageform/clone/clone_transposed.hpp>
