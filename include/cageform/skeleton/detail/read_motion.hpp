// Reads and validates the frames of fit_skeleton.
#pragma once

#include <cageform/core/view.hpp>
#include <cageform/skeleton/detail/fit_motion.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A sequence of point ranges, one per frame.
template <class Frames, std::size_t D>
concept FramesIn = PointRangeIn<std::remove_cvref_t<decltype(std::declval<const Frames&>()[0])>, D>;

inline Status check(const SkeletonOptions& options) noexcept {
    if (options.influences < 1 || options.influences > 8) return Status::influences_not_supported;
    if (!(options.max_distance >= 0) || !std::isfinite(options.max_distance)) return Status::value_not_finite;
    return options.bones == 0 && options.max_distance == 0 ? Status::bones_not_supported : Status::ok;
}

template <class R, class Frames, class F>
Status read_motion(const R& rest, const Frames& frames, const F& faces, Motion& motion,
                   SkeletonReport& report) {
    const std::size_t vertices = std::size(rest), count = std::size(frames);
    if (vertices == 0 || count < 2) return Status::motion_empty;
    for (std::size_t t = 0; t < count; ++t) {
        report.frame = t;
        if (std::size(frames[t]) != vertices) return Status::frames_do_not_match;
    }
    motion.allocate(vertices, count);
    const auto is_finite = [](const Vec<double, 3>& p) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (!(std::fabs(p[k]) <= 1e100)) return false;
        }
        return true;
    };
    for (std::size_t t = 0; t <= count; ++t) {
        report.frame = t;
        for (std::size_t i = 0; i < vertices; ++i) {
            const auto p = t == count ? to_vec<double>(rest[i]) : to_vec<double>(frames[t][i]);
            report.vertex = i;
            if (!is_finite(p)) return Status::frame_not_finite;
            if (t == count) motion.rest[i] = p;
            for (std::size_t k = 0; k < 3 && t < count; ++k) motion.path(i)[k * motion.lanes + t] = p[k];
        }
    }
    report.frame = report.vertex = 0;
    motion.faces.reserve(std::size(faces));
    for (std::size_t f = 0; f < std::size(faces); ++f) {
        std::array<std::uint32_t, 3> face;
        for (std::size_t k = 0; k < 3; ++k) {
            if (!(faces[f][k] >= 0) || std::size_t(faces[f][k]) >= vertices)
                return Status::face_without_vertex;
            face[k] = std::uint32_t(faces[f][k]);
        }
        motion.faces.push_back(face);
    }
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
