// Bone weights at the vertices of a triangle mesh: harmonic weights, and bone heat. `bind_bones` and
// `skin_weights` accept them. Not included by cageform.hpp.
#pragma once

#include <cageform/fields/detail/surface_skinner.hpp>
#include <cageform/fields/types/surface_skin.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Computes harmonic weights: 1 at the vertices of a bone's group, 0 at the vertices of other bones' groups
/// (SurfaceSkinOptions::groups), and harmonic in between (fields/surface.hpp).
///
///   returns  #vertices · #bones weights, contiguous per vertex; zero if the vertex has no face. They sum
///            to 1 and are in [0, 1] up to rounding, unless SurfaceReport::negative_weights is positive.
///            The mesh may be open
///   cost     one factorisation for all bones; O(#vertices · #bones) for the groups
///   fails    as cotangent_weights; bone_weights_do_not_match (no bones), value_not_finite (a bone, also if
///            it is farther away than 1e100 times the mesh's size), labels_do_not_match and
///            index_out_of_range (the groups), cells_unreached (a component of the mesh without a bone),
///            not_converged (only with negative weights); cancelled; out_of_memory
template <PointRange R, FaceRange F>
    requires(range_dimension<R> == 2 || range_dimension<R> == 3)
Result<std::vector<range_scalar_t<R>>, SurfaceSkinReport>
harmonic_skin(const R& points, const F& faces, std::span<const BoneSegment> bones,
              const SurfaceSkinOptions& options = {}, const Running& running = {}) {
    return detail::surface_skin(points, faces, bones, options,
                                [&](auto& skinner) { return skinner.solve_harmonic(running); });
}

/// Computes weights by bone heat (Baran, Popović, Automatic rigging and animation of 3D characters, SIGGRAPH
/// 2007, sec. 4): the equilibrium of heat that flows along the mesh and from the nearest bone, (L + M H) w =
/// M H p. M is a third of the area of a vertex's faces. H is c / d² if the nearest bone, at the distance d,
/// is visible from the vertex; otherwise it is 0. p is the bone's share of the heat at a vertex. Bones at
/// equal distance within 1e-9 have equal shares. Distances below 1e-6 of the mesh's size are set to this
/// value. Weights do not depend on the unit.
///
///   returns  weights that sum to 1, in [0, 1] as those of harmonic_skin
///   cost     as harmonic_skin; visibility usually O(log #F) per test
///   fails    as harmonic_skin; cage_not_closed if visibility is tested and an edge has only one face
///            (SurfaceReport::mesh); weights_not_positive (the heat); cells_unreached (a component of the
///            mesh without a visible bone)
template <PointRange R, FaceRange F>
    requires(range_dimension<R> == 2 || range_dimension<R> == 3)
Result<std::vector<range_scalar_t<R>>, SurfaceSkinReport>
bone_heat(const R& points, const F& faces, std::span<const BoneSegment> bones,
          const SurfaceSkinOptions& options = {}, const Running& running = {}) {
    return detail::surface_skin(points, faces, bones, options,
                                [&](auto& skinner) { return skinner.solve_heat(running); });
}

} // namespace cageform::inline CAGEFORM_ABI
