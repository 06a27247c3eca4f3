// A link of the lattice that the boundary cuts. The equations contain no other information on the boundary.
#pragma once

#include <cageform/core/vec.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// A link that ends on the boundary before it reaches the neighbouring node.
struct CutLink {
    std::uint32_t node;     ///< index of the unknown
    std::uint8_t direction; ///< 2·axis, + 1 towards larger indices
    double weight;          ///< 1/θ, where θ in (0, 1] is the fraction of the link before the boundary
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
