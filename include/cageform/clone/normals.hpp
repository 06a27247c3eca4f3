// Normals and tangents of a clone, every frame, from tangents that `bind_vectors` bound.
#pragma once

#include <cageform/clone/clone.hpp>
#include <cageform/clone/detail/frames.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Computes the unit normals of the moved figure from moved tangents: n' = cross(t', b') / |…| in 3D, the
/// tangent rotated counter-clockwise by 90 degrees in 2D. These are exact normals of the deformed surface,
/// not of its triangles.
///
///   tangents      bindings by `bind_vectors` of the result of `tangents_of`: in 3D tangents and bitangents
///                 with cross(tangent, bitangent) along the normal, of the same points in the same order; in
///                 2D one binding. Dense or packed, owners or views
///   pose          as for `clone`
///   normals       out, any MutablePointRange of at least #points points
///   parallel_for  as for `clone`
///   degenerate    if tangents become parallel or vanish (to some roundings of their size at rest), the
///                 normal at rest is returned; if they are degenerate at rest, zero
///   returns       bindings_differ, or as `clone`; `normals` is then untouched
///   cost          one clone per binding, a square root a point, and a comparison of the orders; no
///                 allocation
///
/// A mirroring pose flips normals, as it flips the winding of triangles.
template <AnyBinding B, std::size_t K, PointRangeIn<B::dimension> Pose, MutablePointRangeIn<B::dimension> Out,
          class Parallel = SerialFor>
    requires(K + 1 == B::dimension)
Status clone_normals(const std::array<B, K>& tangents, const Pose& pose, Out&& normals,
                     const Parallel& parallel_for = {}) noexcept {
    const auto views = detail::views_of(tangents);
    const Status status = detail::check_clone(views, pose, normals);
    if (status != Status::ok) return status;
    detail::for_moved_frames(views, pose, parallel_for, [&](std::size_t i, const auto& frame) {
        store_point(normals, i, frame.normal);
    });
    return Status::ok;
}

/// Computes normals as `clone_normals`, and the moved tangents, of unit length and orthogonal to the normals.
///
///   unit_tangents  out, at least #points points. For glTF tangents of four numbers pass StridedPoints with a
///                  stride of 16 bytes: the fourth number, the texture's handedness, is not written
///   degenerate     a point with the normal at rest has the tangent at rest
template <AnyBinding B, PointRangeIn<3> Pose, MutablePointRangeIn<3> Out, MutablePointRangeIn<3> TangentsOut,
          class Parallel = SerialFor>
    requires(B::dimension == 3)
Status clone_tangent_frames(const std::array<B, 2>& tangents, const Pose& pose, Out&& normals,
                            TangentsOut&& unit_tangents, const Parallel& parallel_for = {}) noexcept {
    const auto views = detail::views_of(tangents);
    if (std::size(unit_tangents) < views[0].point_count()) return Status::output_too_small;
    const Status status = detail::check_clone(views, pose, normals);
    if (status != Status::ok) return status;
    detail::for_moved_frames(views, pose, parallel_for, [&](std::size_t i, const auto& frame) {
        store_point(normals, i, frame.normal);
        store_point(unit_tangents, i, frame.tangent);
    });
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI
