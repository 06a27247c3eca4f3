// The roles of grid cells in the Dirichlet problem, and the options of its solver.
#pragma once

#include <cageform/core/vec.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

enum class Cell : std::uint8_t {
    unknown, ///< its value is the mean of its neighbours' values
    given,   ///< keeps its value
    outside, ///< not part of the problem and not a neighbour
};

enum class Rim : std::uint8_t {
    given,    ///< cells at the boundary of the grid must not be unknown
    mirrored, ///< cells have no neighbours beyond the grid, so no flux crosses the boundary
};

struct DirichletOptions {
    double tolerance = 1e-6;     ///< maximum estimated error, relative to the range of a field's given values
    std::size_t max_cycles = 60; ///< if more are needed: not_converged
    Rim rim = Rim::given;
};

} // namespace cageform::inline CAGEFORM_ABI
