// Defines the functions behind `bind`. binders.hpp includes it, unless the program links
// cageform::compiled.
#pragma once

#include <cageform/binding/detail/point_binder.hpp>
#include <cageform/binding/detail/vector_binder.hpp>
