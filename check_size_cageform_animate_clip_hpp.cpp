#include <cageform/animate/clip.hpp>
