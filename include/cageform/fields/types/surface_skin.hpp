// The bones of a mesh, and the options and the report of their weights.
#pragma once

#include <cageform/core/vec.hpp>
#include <cageform/fields/types/cotangent_weights.hpp>
#include <cageform/grid/types/solver_report.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A bone at rest; a point if both ends coincide. A mesh in the plane lies where the third
/// coordinate is 0.
struct BoneSegment {
    Vec<double, 3> head, tail;
};

/// Marks vertices without a bone in SurfaceSkinOptions::groups.
inline constexpr std::uint32_t no_bone = ~std::uint32_t{0};

enum class BoneVisibility : std::uint8_t {
    inside,  ///< a bone heats a vertex if the segment to the bone's nearest point stays inside the mesh
    ignored, ///< a bone heats the vertices it is nearest to; for open meshes and meshes in the plane
};

struct SurfaceSkinOptions {
    /// For bone heat: c > 0, the influence of bones relative to that of neighbours. Dimensionless.
    double heat = 1;
    BoneVisibility visibility = BoneVisibility::inside; ///< for bone heat
    /// For `harmonic_skin`: for every vertex, the bone whose weight is 1 there, or no_bone. If
    /// empty, a bone gets the vertices whose nearest point on all bones lies in its middle third.
    std::span<const std::uint32_t> groups{};
};

struct SurfaceSkinReport {
    Status status = Status::ok;
    SurfaceReport mesh;                  ///< faults of the mesh, flips, negative weights
    SolverReport solver;                 ///< culprit: a vertex (cells_unreached), else a bone or a label
    std::vector<std::size_t> idle_bones; ///< bones nearest to no vertex that sees them; their weights are
                                         ///< zero
    std::size_t hidden = 0;              ///< number of vertices that do not see their nearest bones
    double seconds = 0;                  ///< wall-clock time
};

} // namespace cageform::inline CAGEFORM_ABI
