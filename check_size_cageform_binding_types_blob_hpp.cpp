#include <cageform/binding/types/blob.hpp>
