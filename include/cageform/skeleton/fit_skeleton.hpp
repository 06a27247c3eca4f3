// Fits a skeleton to any sequence of meshes: bones that turn, and a few weights a vertex.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/core/view.hpp>
#include <cageform/skeleton/detail/make_keys.hpp>
#include <cageform/skeleton/detail/read_motion.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Finds bones, where they go in each frame, and the weights of a skin, such that the figure is near its
/// frames. They minimise Σ |x_i^t − Σ_j w_ij M_j^t v_i|² over the maps M_j^t of the bones and the weights
/// w_ij ≥ 0, of which a vertex has at most K and whose sum is 1 (Le and Deng, Smooth skinning decomposition
/// with rigid bones, ACM TOG 31(6), 2012). Joints and a hierarchy are made of the bones' motion.
///
///   rest     v, the vertices at rest, where no bone has moved. All units are those of the figure
///   frames   `frames[t]` is a range of as many vertices: spans, StridedPoints, … The rest need not be one
///   faces    triangles over the vertices. Weights are smooth along their edges, and the report measures
///            by how much they are turned; there may be none
///   returns  the skeleton and its report. Vertices that are together in all frames get one skin, so seams
///            stay closed. The result has the same bits for any number of threads
///   bones    more than a sixth of the vertices, or 1,024, are as many. With SkeletonOptions::bones 0 short
///            fits grow until every vertex is within the distance. The last then loses bones as long as it
///            stays so; it has other bits than the fit by its number. If no number is enough, the status is
///            ok and `beyond` counts the vertices that are farther away
///   minimum  a local one: idle bones move to where the error is largest, and come back if that is no better
///   cost     O(#vertices · (#bones · #frames + some thousand)) and O(#frames · #bones²) a round, all in
///            double: 1,114 vertices in 33 frames take 0.3 s for 12 bones; by distance some three times as
///            long. Memory: 24 bytes · #vertices · #frames
///   fails    influences_not_supported; bones_not_supported (neither bones nor a distance); value_not_finite
///            (the distance, or a negative one); motion_empty; frames_do_not_match; frame_not_finite (also
///            above 1e100, or 1e30 sizes away; the report has frame and vertex, at rest frame #frames);
///            face_without_vertex; cancelled; out_of_memory
template <PointRangeIn<3> R, detail::FramesIn<3> Frames, FaceRange F>
Result<FittedSkeleton<range_scalar_t<R>>, SkeletonReport>
fit_skeleton(const R& rest, const Frames& frames, const F& faces, const SkeletonOptions& options = {},
             const Running& running = {}) {
    Result<FittedSkeleton<range_scalar_t<R>>, SkeletonReport> result;
    SkeletonReport timed;
    detail::run_into(timed, [&] {
        detail::Motion motion;
        const Status status = detail::read_motion(rest, frames, faces, options, motion, result.report);
        return status == Status::ok ? detail::fit_motion(motion, options, running, result) : status;
    });
    result.report.status = timed.status;
    result.report.seconds = timed.seconds;
    if (timed.status != Status::ok) result.value = {};
    return result;
}

/// Makes keys of a skeleton's motion, as few as keep the figure near to what the maps make of it.
///
///   skeleton      as `fit_skeleton` returns it. With `parents` set to no_parent, bones are free of each
///                 other
///   rest          #vertices, as it was fitted
///   times         #frames, in seconds, ascending
///   options       the distance is from where a vertex is by the maps to where it is by the keys, in every
///                 frame: measured at the skin, not at the bones, and for all bones together
///   returns       keys at some of the frames, with the values there. A channel that may stand still has one.
///                 Rotations without tangents keep the distance by slerp and by nlerp. Neighbouring rotation
///                 keys differ by at most 90°. Between neighbouring frames there are keys where slerp and
///                 nlerp differ by more than the distance (or 1e-4). Half turns about one axis all go one way
///   cost          some O(#vertices · #influences · #frames · log #frames); 1,114 vertices in 33 frames take
///                 0.1 s for 20 bones. Memory: 12 bytes · #vertices · #frames
///   fails         value_not_finite (the distance, or a negative one; a map; the rest; an ancestor that is
///                 flat);
///                 input_malformed (a skeleton whose sizes or indices do not match); frames_do_not_match (as
///                 many times or vertices); keys_not_ascending; cancelled; out_of_memory
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
        return detail::make_keys(skeleton, places, times, options, running, result);
    });
    result.report.status = timed.status;
    result.report.seconds = timed.seconds;
    if (timed.status != Status::ok) result.value = {};
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
