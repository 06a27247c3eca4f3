// The roles of grid cells in the Dirichlet problem, and the options of its solver.
#pragma once

#include <cageform/core/vec.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

enum class Cell : std::uint8_t {
    unknown, ///< the mean of its neighbours
    given,   ///< keeps its value
    outside, ///< not part of the problem and not a neighbour
};

enum class Rim : std::uint8_t {
    given,    ///< cells there must not be unknown
    mirrored, ///< no neighbours beyond, so there is no flux through the boundary
};

struct DirichletOptions {
    double tolerance = 1e-6;     ///< maximum estimated error, relative to the range of a field's given values
    std::size_t max_cycles = 60; ///< then not_converged
    Rim rim = Rim::given;
};

} // namespace cageform::inline CAGEFORM_ABI
