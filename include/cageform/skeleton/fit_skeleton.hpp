// Fits a skeleton (bones, joints, a hierarchy and skinning weights) to a sequence of meshes.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/core/view.hpp>
#include <cageform/skeleton/detail/read_motion.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Fits bones, their motion and skinning weights to a sequence of meshes. Minimises Σ |x_i^t − Σ_j w_ij M_j^t
/// v_i|² over the bone maps M_j^t and the weights w_ij ≥ 0. A vertex has at most K =
/// SkeletonOptions::influences weights, with sum 1 (Le and Deng, Smooth skinning decomposition with rigid
/// bones, ACM TOG 31(6), 2012). Joints and a hierarchy follow from the motion of the bones.
///
///   rest     #vertices points v_i, in the rest pose; defines all units
///   frames   `frames[t]` is a range of #vertices points x_i^t: spans, StridedPoints, … The rest pose need
///            not be a frame
///   faces    triangles, may be empty. Used for smooth weights and for the report's rotation error
///   returns  skeleton and report. Vertices that coincide in all frames share their weights, so seams stay
///            closed. The result has the same bits for any number of threads
///   bones    clamped to a sixth of the vertices and to 1,024. If SkeletonOptions::bones is 0, short fits
///            with more and more bones run until all vertices are within the distance. Then bones are removed
///            while the limit holds; the result may differ bitwise from a fit with that number. If no number
///            of bones suffices, the status is ok and `beyond` counts the vertices over the limit
///   minimum  local; idle bones are moved to the largest errors, and moved back if the error does not fall
///   cost     O(#vertices · (#bones · #frames + some thousand)) and O(#frames · #bones²) per round, in
///            double. 1,114 vertices, 33 frames, 12 bones: 0.3 s. A fit by distance takes about three times
///            as long. Memory: 24 bytes · #vertices · #frames
///   fails    influences_not_supported; bones_not_supported (neither bones nor a distance); value_not_finite
///            (not finite or negative distance); motion_empty; frames_do_not_match; frame_not_finite (also
///            for coordinates above 1e100, or 1e30 sizes away; the report has the frame and the vertex, with
///            #frames for the rest pose); face_without_vertex; cancelled; out_of_memory
template <PointRangeIn<3> R, detail::FramesIn<3> Frames, FaceRange F>
Result<FittedSkeleton<range_scalar_t<R>>, SkeletonReport>
fit_skeleton(const R& rest, const Frames& frames, const F& faces, const SkeletonOptions& options = {},
             const Running& running = {}) {
    Result<FittedSkeleton<range_scalar_t<R>>, SkeletonReport> result;
    SkeletonReport timed;
    detail::run_into(timed, [&] {
        detail::Motion motion;
        Status status = detail::check(options);
        if (status == Status::ok) status = detail::read_motion(rest, frames, faces, motion, result.report);
        return status == Status::ok ? detail::fit_motion(motion, options, running, result) : status;
    });
    result.report.status = timed.status;
    result.report.seconds = timed.seconds;
    if (timed.status != Status::ok) result.value = {};
    return result;
}

/// Reduces the motion of a skeleton to keys. Drops keys while the skinned vertices stay within a distance.
///
///   skeleton  from `fit_skeleton`. Set all `parents` to no_parent for independent bones
///   rest      #vertices, as in the fit
///   times     #frames, in seconds, ascending
///   options   the distance is measured in every frame, between the positions of skinned vertices by maps and
///             by keys, with all bones together
///   returns   keys at some of the frames, with the values of the frames. A constant channel has one key.
///             Rotations without tangents stay within the distance both with slerp and with nlerp.
///             Neighbouring rotation keys differ by at most 90°. Keys are added between neighbouring frames
///             where slerp and nlerp differ by more than the distance (or 1e-4). Half turns about one axis
///             all have the same direction
///   cost      about O(#vertices · #influences · #frames · log #frames). 1,114 vertices, 33 frames, 20 bones:
///             0.1 s. Memory: 12 bytes · #vertices · #frames
///   fails     value_not_finite (not finite or negative distance; a map; the rest pose; a singular ancestor);
///             input_malformed (sizes or indices of the skeleton); frames_do_not_match (#times or #vertices);
///             keys_not_ascending; cancelled; out_of_memory
template <class T, PointRangeIn<3> R>
Result<SkeletonKeys<T>, SkeletonKeysReport>
fit_skeleton_keys(const FittedSkeleton<T>& skeleton, const R& rest,
                  std::type_identity_t<std::span<const T>> times, const SkeletonKeyOptions& options = {},
                  const Running& running = {}) {
    Result<SkeletonKeys<T>, SkeletonKeysReport> result;
    SkeletonKeysReport timed;
    detail::run_into(timed, [&] {
        std::vector<Vec<double, 3>> places;
        for (std::size_t i = 0; i < std::size(rest); ++i) places.push_back(to_vec<double>(rest[i]));
        return detail::make_keys(detail::SkeletonFrames<T>{skeleton, places, times}, options, running,
                                 result);
    });
    result.report.status = timed.status;
    result.report.seconds = timed.seconds;
    if (timed.status != Status::ok) result.value = {};
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
