// The interior cells of a cage, given by handle indices.
#pragma once

#include <cageform/config.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A point (`i` = `j`) or, in 3D, an edge of a chain. It needs a radius, because a harmonic function ignores
/// the value at a point or on a curve. Points within the radius have the value of the bone's nearest point.
struct Bone {
    std::uint32_t i = 0, j = 0; ///< handles
    double radius = 0;          ///< in the units of the cage
};

template <std::size_t D>
struct InteriorCells {
    std::vector<std::array<std::uint32_t, D>> facets; ///< edges of chains in 2D, faces in 3D
    std::vector<Bone> bones;                          ///< points, and chains in 3D

    bool empty() const noexcept { return facets.empty() && bones.empty(); }
};

} // namespace cageform::inline CAGEFORM_ABI
