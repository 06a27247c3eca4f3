// Normals and tangents of a clone, every frame, from the tangents that `bind_vectors` bound.
#pragma once

#include <cageform/clone/clone.hpp>
#include <cageform/clone/detail/frames.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The normals of the moved figure, of unit length, from bound tangents as the pose moves them: in
/// space n' = cross(t', b') / |…|, in the plane the tangent turned counter-clockwise by 90 degrees.
/// They are those of the deformed surface itself, not of its triangles.
///
///   tangents      as `bind_vectors` binds what `tangents_of` makes: in space tangents and
///                 bitangents with cross(tangent, bitangent) along the normal, of the same points
///                 in the same order; in the plane one binding. Dense or packed, owners or views
///   pose          as for `clone`
///   normals       out, any MutablePointRange of at least #points places
///   parallel_for  as for `clone`
///   degenerate    where the tangents are moved onto one line or to nothing (to some roundings of
///                 what they were), the normal at rest; where they are so at rest, zero
///   returns       bindings_differ, or as `clone`; `normals` is then untouched
///   cost          that of a clone by each binding, a square root a point, and a comparison of the
///                 orders; no allocation
///
/// A pose that mirrors turns normals as it turns the winding of triangles: they stay cross(t', b').
template <AnyBinding B, std::size_t K, PointRangeIn<B::dimension> Pose, MutablePointRangeIn<B::dimension> Out,
          class Parallel = SerialFor>
    requires(K + 1 == B::dimension)
Status clone_normals(const std::array<B, K>& tangents, const Pose& pose, Out&& normals,
                     const Parallel& parallel_for = {})
noexcept {
    const auto views = detail::views_of(tangents);
    const Status status = detail::check_clone(views, pose, normals);
    if (status != Status::ok) return status;
    detail::for_moved_frames(views, pose, parallel_for, [&](std::size_t i, const auto& frame) {
        store_point(normals, i, frame.normal);
    });
    return Status::ok;
}

/// Normals as `clone_normals`, and with them the moved tangents, of unit length and orthogonal to
/// the normals.
///
///   unit_tangents  out, at least #points places. For tangents of four numbers (glTF) a
///                  StridedPoints of 16 bytes' stride: the fourth, the sign of the texture's
///                  handedness, is not touched, and no pose changes it
///   degenerate     where the normal is that at rest, so is the tangent
template <AnyBinding B, PointRangeIn<3> Pose, MutablePointRangeIn<3> Out, MutablePointRangeIn<3> TangentsOut,
          class Parallel = SerialFor>
    requires(B::dimension == 3)
Status clone_tangent_frames(const std::array<B, 2>& tangents, const Pose& pose, Out&& normals,
                            TangentsOut&& unit_tangents, const Parallel& parallel_for = {})
noexcept {
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
