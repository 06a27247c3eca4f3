// The functions of the C interface that fit skeletons.
#pragma once

#include <cageform/c/detail/make_cage.impl.hpp>
#include <cageform/skeleton/detail/transform_path.hpp>
#include <cageform/skeleton/fit_skeleton.hpp>

struct cageform_skeleton : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::skeleton;

    cageform::FittedSkeleton<double> fitted;
    cageform::BoneKind bones = cageform::BoneKind::rigid;
    std::vector<double> joints, maps;
};

namespace cageform::inline CAGEFORM_ABI::detail::c {

/// A view of contiguous frames.
template <class Points>
struct FramesInARow {
    Points points;
    std::size_t vertices, count;

    std::size_t size() const noexcept { return count; }
    Points operator[](std::size_t t) const noexcept { return points.subview(t * vertices, vertices); }
};

/// Reports the first face with an invalid vertex index.
inline void name_face(cageform_report& report, const std::vector<std::array<std::uint32_t, 3>>& faces,
                      std::size_t vertices) noexcept {
    const auto is_bad = [&](const auto& face) {
        return *std::max_element(face.begin(), face.end()) >= vertices;
    };
    const auto face = std::find_if(faces.begin(), faces.end(), is_bad);
    report.faults = 1;
    report.fault = fault_of({CageFaultKind::face_without_vertex, std::size_t(face - faces.begin())});
}

inline cageform_status fit_skeleton_of(const cageform_points& rest, const cageform_points& frames,
                                       const std::vector<std::array<std::uint32_t, 3>>& faces,
                                       const SkeletonOptions& options, const Running& running,
                                       cageform_skeleton& object, cageform_report& report) {
    std::vector<Vec<double, 3>> places;
    cageform_status status = copy_points(rest, places);
    const auto fit = [&](const auto& points) {
        if (status != CAGEFORM_OK) return status;
        const std::size_t count = places.empty() ? 0 : points.size() / places.size();
        if (!places.empty() && points.size() % places.size() != 0)
            return code_of(Status::frames_do_not_match);
        auto [fitted, its] = fit_skeleton(
            places, FramesInARow<std::remove_cvref_t<decltype(points)>>{points, places.size(), count}, faces,
            options, running);
        fill(report, its, count);
        if (its.status == Status::face_without_vertex) name_face(report, faces, places.size());
        if (its.status != Status::ok) return code_of(its.status);
        for (const auto& joint : fitted.joints)
            object.joints.insert(object.joints.end(), joint.v, joint.v + 3);
        for (const auto& map : fitted.maps) {
            for (const auto& axis : map.axes) object.maps.insert(object.maps.end(), axis.v, axis.v + 3);
            object.maps.insert(object.maps.end(), map.shift.v, map.shift.v + 3);
        }
        object.fitted = std::move(fitted);
        object.bones = options.kind;
        return cageform_status(CAGEFORM_OK);
    };
    return frames.scalar == CAGEFORM_DOUBLE ? fit(view_of<double, 3>(frames, status))
                                            : fit(view_of<float, 3>(frames, status));
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c

extern "C" {

cageform_status cageform_fit_skeleton(cageform_points rest, cageform_points frames, const uint32_t* indices,
                                      size_t index_count, const cageform_skeleton_options* options,
                                      const cageform_running* running, cageform_skeleton** skeleton,
                                      cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "vertex", [&](cageform_report& its) {
        if (skeleton == nullptr || (indices == nullptr && index_count > 0))
            return cageform_status(CAGEFORM_ARGUMENT_NULL);
        cageform_skeleton_options own;
        if (const cageform_status status = c::read_struct(options, own); status != CAGEFORM_OK) return status;
        if (own.kind > CAGEFORM_STRETCHED) return cageform_status(CAGEFORM_CHOICE_UNKNOWN);
        if (index_count % 3 != 0) return cageform_status(CAGEFORM_COUNTS_DO_NOT_MATCH);
        const auto faces = c::triangles_of(indices, index_count);
        cageform::SkeletonOptions choice;
        choice.bones = own.bones;
        if (own.influences > 0) choice.influences = own.influences;
        choice.max_distance = own.max_distance;
        choice.kind = static_cast<cageform::BoneKind>(own.kind);
        return c::with_running(running, [&](const cageform::Running& how) {
            return c::make_filled(skeleton, [&](cageform_skeleton& object) {
                return c::fit_skeleton_of(rest, frames, faces, choice, how, object, its);
            });
        });
    });
}

cageform_status cageform_skeleton_describe(const cageform_skeleton* skeleton, cageform_skeleton_info* info) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(skeleton); code != CAGEFORM_OK) return code;
    const auto& fitted = skeleton->fitted;
    cageform_skeleton_info its{};
    its.bones = fitted.bones;
    its.frames = fitted.frames;
    its.vertices = fitted.skin.point_count();
    its.influences = fitted.skin.influences;
    its.parents = fitted.parents.data();
    its.joints = skeleton->joints.data();
    its.vertex_bones = fitted.skin.joints.data();
    its.weights = fitted.skin.weights.data();
    its.maps = skeleton->maps.data();
    return c::write_struct(its, info);
}

cageform_status cageform_skeleton_transforms(const cageform_skeleton* skeleton, cageform_output translations,
                                             cageform_output rotations, const cageform_output* scales,
                                             const cageform_output* axes) {
    namespace c = cageform::detail::c;
    using cageform::detail::NodeTransform;
    cageform_status status = c::check_object(skeleton);
    if (status != CAGEFORM_OK) return status;
    if ((scales == nullptr && skeleton->bones != cageform::BoneKind::rigid) ||
        (axes == nullptr && skeleton->bones == cageform::BoneKind::stretched))
        return CAGEFORM_ARGUMENT_NULL;
    const auto& fitted = skeleton->fitted;
    const std::size_t count = fitted.bones * fitted.frames;
    c::AnyOutput<3> to_translations, to_scales;
    c::AnyOutput<4> to_rotations, to_axes;
    status = to_translations.set(&translations, count);
    if (status == CAGEFORM_OK) status = to_rotations.set(&rotations, count);
    if (status == CAGEFORM_OK) status = to_scales.set(scales, count);
    if (status == CAGEFORM_OK) status = to_axes.set(axes, count);
    if (status != CAGEFORM_OK) return status;
    return c::guarded([&] {
        std::vector<NodeTransform> nodes(count);
        for (std::size_t bone = 0; bone < fitted.bones; ++bone) {
            cageform::detail::TransformPath path;
            for (std::size_t t = 0; t < fitted.frames; ++t) {
                const auto local = fitted.local(t, bone);
                for (const auto& v : {local.axes[0], local.axes[1], local.axes[2], local.shift}) {
                    if (!cageform::is_finite(v)) return c::code_of(cageform::Status::value_not_finite);
                }
                nodes[t * fitted.bones + bone] = path.next(local);
            }
        }
        for (std::size_t n = 0; n < count; ++n) {
            const double* const values = nodes[n].values.data();
            to_translations.store(n, values);
            to_rotations.store(n, values + NodeTransform::rotation);
            to_scales.store(n, values + NodeTransform::scale);
            to_axes.store(n, values + NodeTransform::axes);
        }
        return cageform_status(CAGEFORM_OK);
    });
}

} // extern "C"
