// Computes a pose of all handles from a pose of the cage's vertices or of bones. Needed before a clone if
// some handles are vectors.
//
//     pose_handles(binding, cage_pose, handles);      // the vectors of faces follow their corners
//     clone(binding, handles, out);
#pragma once

#include <cageform/core/detail/face_handles.hpp>
#include <cageform/core/status.hpp>
#include <cageform/core/view.hpp>
#include <cageform/figure/binding.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// Result of `pose_handles`.
struct PoseReport {
    static constexpr std::size_t none = ~std::size_t{0};
    Status status = Status::ok;
    /// Faces with zero area in the pose: their direction is unknown, their vector zero. Faces with zero area
    /// at rest, such as legs of curved cages, do not count.
    std::size_t collapsed_faces = 0;
    std::size_t first_collapsed = none; ///< the handle of the first collapsed face
};

/// A dense or packed binding, or its view.
template <class B>
concept HasHandles = requires(const B& binding) {
    typename B::scalar;
    { binding.handle_view() } -> std::same_as<HandleView<typename B::scalar, B::dimension>>;
};

/// Computes a pose of all handles from a pose of the cage's vertices.
///
///   pose     one point for each point handle, in the order of the handles
///   out      at least #handles points, readable. `pose` may be the first points of `out`
///   returns  pose_size_differs, pose_not_finite, output_too_small, handles_not_faces (vectors without a
///            face): `out` is then untouched; or ok, and the faces without area
///   cost     O(#handles), no allocation: 80 operations and two roots a face in 3D, two operations in 2D.
///            Means of loops are recomputed for each of their triangles
///
/// The pose at rest reproduces the handles at rest bitwise, so `clone` returns the bound points. A similarity
/// also transforms every vector, to rounding. A mirrored pose is not a similarity here, because its normals
/// are inverted.
template <HasHandles B, PointRange Pose, class Out>
    requires(B::dimension == 2 || B::dimension == 3) && MutablePointRange<std::remove_reference_t<Out>>
PoseReport pose_handles(const B& binding, const Pose& pose, Out&& out) noexcept {
    using T = typename B::scalar;
    const HandleView<T, B::dimension> handles = binding.handle_view();
    const std::size_t vectors = handles.vector_count();
    PoseReport report;
    const auto refuse = [&report](Status status) {
        report.status = status;
        return report;
    };
    if (std::size(pose) != handles.count - vectors) return refuse(Status::pose_size_differs);
    if (std::size(out) < handles.count) return refuse(Status::output_too_small);
    if (vectors > 0 && handles.faces == nullptr) return refuse(Status::handles_not_faces);
    for (std::size_t n = 0; n < std::size(pose); ++n) {
        if (!detail::can_be_posed<T, Out>(to_vec<T>(pose[n]))) return refuse(Status::pose_not_finite);
    }
    // Backwards, because `out` may be `pose`, and point n belongs to handle n or a later handle.
    for (std::size_t i = handles.count, n = std::size(pose); i-- > 0;) {
        if (handles.is_point(i)) store_point(out, i, to_vec<range_scalar_t<Out>>(pose[--n]));
    }
    for (std::size_t i = 0, face = 0; face < vectors; ++i) {
        if (handles.is_point(i)) continue;
        const auto vector = detail::posed_vector(handles, i, handles.faces[face++], out);
        store_point(out, i, vector);
        if (vector != Vec<T, B::dimension>{} || handles.rest[i] == Vec<T, B::dimension>{}) continue;
        if (report.collapsed_faces++ == 0) report.first_collapsed = i;
    }
    return report;
}

/// Computes a pose of the handles of bones from the bones' transforms. A bone has D + 1 consecutive handles:
/// a point, its origin o, and D vectors, its axes. With the weights ω and ω (p − o)_k a clone is linear blend
/// skinning, Σ ω (A p + b).
///
///   bones    as many as point handles
///   out      at least #handles points; may not overlap `bones`
///   returns  handles_not_bones (handles in another order), pose_size_differs, pose_not_finite,
///            output_too_small (`out` is then untouched), or ok
///   cost     O(#handles), no allocation
template <HasHandles B, class Out>
    requires MutablePointRange<std::remove_reference_t<Out>>
Status pose_bones(const B& binding, std::span<const Transform<typename B::scalar, B::dimension>> bones,
                  Out&& out) noexcept {
    using T = typename B::scalar;
    constexpr std::size_t D = B::dimension;
    const HandleView<T, D> handles = binding.handle_view();
    for (std::size_t i = 0; i < handles.count; ++i) {
        if (handles.is_point(i) != (i % (D + 1) == 0)) return Status::handles_not_bones;
    }
    if (handles.count % (D + 1) != 0) return Status::handles_not_bones;
    if (bones.size() != handles.count / (D + 1)) return Status::pose_size_differs;
    if (std::size(out) < handles.count) return Status::output_too_small;
    const auto posed = [&](std::size_t i) {
        const Transform<T, D>& bone = bones[i / (D + 1)];
        const auto mapped = bone.map_vector(handles.rest[i]);
        return handles.is_point(i) ? mapped + bone.translation : mapped;
    };
    for (std::size_t i = 0; i < handles.count; ++i) {
        if (!is_finite(posed(i))) return Status::pose_not_finite;
    }
    for (std::size_t i = 0; i < handles.count; ++i) store_point(out, i, posed(i));
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI
