#pragma once

// The coordinate types with every solver: for the files that compile them.

#include "cli/coordinates.hpp"

#include <cageform/papers/pyramid_solver.hpp>

namespace cageform_examples {

/// Harmonic coordinates by every solver that there is for a kind of cage.
template <class C>
using Harmonic =
    cageform::HarmonicCoordinates<typename C::scalar, C::dimension, C, cageform::WithAveragingPyramid>;

} // namespace cageform_examples
