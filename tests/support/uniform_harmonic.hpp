#pragma once

#include <cageform/coordinates/uniform_harmonic.hpp>

namespace cageform_tests {

/// Harmonic coordinates on a uniform grid, as a type of their own.
template <class T, std::size_t D, class C = typename cageform::HarmonicCoordinates<T, D>::Cage>
struct UniformHarmonic : cageform::HarmonicCoordinates<T, D, C> {
    template <class Cage>
    explicit UniformHarmonic(const Cage& cage, const cageform::HarmonicOptions& options = {.resolution = 64})
        : cageform::HarmonicCoordinates<T, D, C>(cage, options, cageform::UniformGrid{}) {}
};

} // namespace cageform_tests
