// The bones of a mesh, and the options and the report of their weights.
#pragma once

#include <cageform/core/vec.hpp>
#include <cageform/fields/types/cotangent_weights.hpp>
#include <cageform/grid/types/solver_report.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A bone at rest; a point if both ends coincide. For meshes in 2D the third coordinate is 0.
struct BoneSegment {
    Vec<double, 3> head, tail;
};

/// Marks vertices without a bone in SurfaceSkinOptions::groups.
inline constexpr std::uint32_t no_bone = ~std::uint32_t{0};

enum class BoneVisibility : std::uint8_t {
    inside,  ///< a bone heats a vertex if the segment to the bone's nearest point is inside the mesh
    ignored, ///< a bone heats all vertices that it is nearest to; for open meshes and 2D
};

struct SurfaceSkinOptions {
    /// `bone_heat`: the constant c > 0. A larger value increases the influence of bones relative to that of
    /// neighbouring vertices. Dimensionless.
    double heat = 1;
    BoneVisibility visibility = BoneVisibility::inside; ///< for bone heat
    /// `harmonic_skin`: per vertex, the bone whose weight is 1 there, or no_bone. If empty, the group of a
    /// bone has the vertices that are nearest to this bone alone. The nearest point must lie in the middle
    /// third of the bone, unless both ends coincide.
    std::span<const std::uint32_t> groups{};
};

struct SurfaceSkinReport {
    Status status = Status::ok;
    SurfaceReport mesh;                  ///< faults of the mesh, flips, negative weights
    SolverReport solver;                 ///< culprit: index of a vertex (cells_unreached), bone or label
    std::vector<std::size_t> idle_bones; ///< bones that no vertex uses; their weights are zero
    std::size_t hidden = 0;              ///< number of vertices whose nearest bones are not visible
    double seconds = 0;                  ///< wall-clock time
};

} // namespace cageform::inline CAGEFORM_ABI
