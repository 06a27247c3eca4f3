#include <cageform/clone/clone.hpp>
