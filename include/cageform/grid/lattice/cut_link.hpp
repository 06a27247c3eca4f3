// A link of the lattice that boundary data cuts: all that the equations know of a boundary.
#pragma once

#include <cageform/core/vec.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// A link of the lattice that ends on given data before it reaches the neighbouring node.
struct CutLink {
    std::uint32_t node;     ///< number of the unknown
    std::uint8_t direction; ///< 2·axis, + 1 towards larger indices
    double weight;          ///< 1/θ, θ in (0, 1] the part of the link up to the data
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
