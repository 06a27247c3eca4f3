#include <cageform/clone/normals.hpp>
