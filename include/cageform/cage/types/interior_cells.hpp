// The cells inside a cage, given by the numbers of their handles.
#pragma once

#include <cageform/config.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A point (`i` = `j`) or, in space, an edge of a chain. A bone needs a radius: a point or a thin
/// edge has no capacity, so a harmonic function would ignore its value. Points within the radius
/// take the value of the bone's nearest point.
struct Bone {
    std::uint32_t i = 0, j = 0; ///< handles
    double radius = 0;          ///< in the units of the cage
};

/// The cells inside a cage, given by their handles.
template <std::size_t D>
struct InteriorCells {
    std::vector<std::array<std::uint32_t, D>> facets; ///< edges of chains in the plane, faces in space
    std::vector<Bone> bones;                          ///< points, and chains in space

    bool empty() const noexcept { return facets.empty() && bones.empty(); }
};

} // namespace cageform::inline CAGEFORM_ABI
