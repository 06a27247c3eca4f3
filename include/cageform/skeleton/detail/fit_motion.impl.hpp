// Fits a skeleton to a Motion, by number of bones or by distance.
#pragma once

#include <cageform/core/result.hpp>
#include <cageform/skeleton/detail/joint_tree.hpp>
#include <cageform/skeleton/detail/skeleton_search.hpp>
#include <cageform/skeleton/types/fitted_skeleton.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Converts a fit to the public type: bones in tree order, single-precision weights, the figure's units.
template <class T>
FittedSkeleton<T> skeleton_of(const Motion& motion, const BoneFit& fit) {
    const JointTree tree(motion, fit);
    FittedSkeleton<T> result;
    result.bones = fit.bones();
    result.frames = motion.frames;
    std::vector<std::uint32_t> number(result.bones);
    for (std::uint32_t n = 0; n < result.bones; ++n) number[tree.order[n]] = n;
    for (const std::uint32_t j : tree.order) {
        const std::uint32_t parent = tree.parents[j];
        result.parents.push_back(parent == JointTree::none ? FittedSkeleton<T>::no_parent : number[parent]);
        result.joints.push_back(vec_cast<T>(motion.size * tree.places[j] + motion.centre));
    }
    for (std::size_t t = 0; t < motion.frames; ++t) {
        for (const std::uint32_t j : tree.order) {
            typename FittedSkeleton<T>::Map map;
            for (std::size_t r = 0; r < 3; ++r) {
                double shift = motion.size * fit.map(j, r, 3)[t] + motion.centres[t][r];
                for (std::size_t c = 0; c < 3; ++c) {
                    const double x = fit.map(j, r, c)[t];
                    map.axes[c][r] = T(x);
                    shift -= x * motion.centre[c];
                }
                map.shift[r] = T(shift);
            }
            result.maps.push_back(map);
        }
    }
    const VertexWeights& of = fit.weights();
    const std::size_t width = result.skin.influences = of.width;
    result.skin.joints.assign(motion.welded.size() * width, 0);
    result.skin.weights.assign(motion.welded.size() * width, 0);
    for (std::size_t i = 0; i < motion.welded.size(); ++i) {
        std::uint16_t* const joints = result.skin.joints.data() + i * width;
        float* const weights = result.skin.weights.data() + i * width;
        const std::size_t first = motion.welded[i] * width;
        double left = 1;
        for (std::size_t k = width; k-- > 0;) {
            const double w = k == 0 ? left : of.weights[first + k];
            if (!(w > 0)) continue;
            joints[k] = std::uint16_t(number[of.joints[first + k]]);
            weights[k] = float(w);
            left -= double(weights[k]);
        }
        // Rounding can make the first weight smaller than others.
        for (std::size_t k = 1; k < width && weights[k - 1] < weights[k]; ++k) {
            std::swap(weights[k - 1], weights[k]);
            std::swap(joints[k - 1], joints[k]);
        }
    }
    return result;
}

/// Errors of a skeleton in one frame, in the units of Motion.
struct FrameErrors {
    double sum = 0;                    ///< sum of squared errors over all input vertices
    double largest = -1;               ///< largest squared error
    std::size_t vertex = 0;            ///< input vertex with the largest error
    std::vector<float> turns;          ///< rotation error of each face with an area, in degrees
    std::vector<std::uint32_t> beyond; ///< vertices beyond the maximum distance
};

/// The input vertices that a vertex of Motion was welded from.
struct WeldedFrom {
    std::uint32_t count = 0, first = 0;
};

/// Measures a skeleton in frame t.
///
///   from   per vertex of `motion`
///   most   maximum distance; 0: no limit
template <class T>
FrameErrors frame_errors(const Motion& motion, const FittedSkeleton<T>& skeleton, std::size_t t,
                         std::span<const WeldedFrom> from, double most) {
    FrameErrors frame;
    std::vector<Vec<double, 3>> right(motion.vertices), played(motion.vertices);
    for (std::uint32_t i = 0; i < motion.vertices; ++i) {
        for (std::size_t k = 0; k < 3; ++k) right[i][k] = motion.path(i)[k * motion.lanes + t];
        const auto rest = vec_cast<T>(motion.size * motion.rest[i] + motion.centre);
        const auto place = vec_cast<double>(skeleton.place(t, from[i].first, rest));
        for (std::size_t k = 0; k < 3; ++k) played[i][k] = (place[k] - motion.centres[t][k]) / motion.size;
        const auto d = played[i] - right[i];
        const double square = dot(d, d);
        frame.sum += from[i].count * square;
        if (most > 0 && square > most * most) frame.beyond.push_back(i);
        if (square <= frame.largest) continue;
        frame.largest = square;
        frame.vertex = from[i].first;
    }
    for (const auto& face : motion.faces) {
        const auto a = cross(right[face[1]] - right[face[0]], right[face[2]] - right[face[0]]);
        const auto b = cross(played[face[1]] - played[face[0]], played[face[2]] - played[face[0]]);
        const auto across = cross(a, b);
        if (!(dot(a, a) > 0) || !(dot(b, b) > 0)) continue;
        constexpr double degrees = 180 / 3.14159265358979323846;
        frame.turns.push_back(float(degrees * std::atan2(std::sqrt(dot(across, across)), dot(a, b))));
    }
    return frame;
}

/// Measures a stored skeleton over all vertices and frames.
template <class T>
void measure(const Motion& motion, const FittedSkeleton<T>& skeleton, double most, SkeletonReport& report,
             const Running& running) {
    std::vector<WeldedFrom> from(motion.vertices);
    for (std::size_t i = motion.welded.size(); i-- > 0;) {
        ++from[motion.welded[i]].count;
        from[motion.welded[i]].first = std::uint32_t(i);
    }
    std::vector<FrameErrors> frames(motion.frames);
    in_parallel(running, motion.frames, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) frames[t] = frame_errors(motion, skeleton, t, from, most);
    });
    double sum = 0, largest = -1;
    std::vector<float> turns;
    report.beyond = 0;
    for (std::size_t t = 0; t < frames.size(); ++t) {
        const FrameErrors& frame = frames[t];
        sum += frame.sum;
        turns.insert(turns.end(), frame.turns.begin(), frame.turns.end());
        for (const std::uint32_t i : frame.beyond) report.beyond += std::exchange(from[i].count, 0);
        if (frame.largest <= largest) continue;
        largest = frame.largest;
        report.frame = t;
        report.vertex = frame.vertex;
    }
    report.bones = skeleton.bones;
    report.rms = std::sqrt(sum / (double(motion.welded.size()) * double(motion.frames)));
    report.max_distance = std::sqrt(largest);
    report.turn = 0;
    if (!turns.empty()) {
        const auto at = turns.begin() + std::ptrdiff_t(0.99 * double(turns.size() - 1));
        std::nth_element(turns.begin(), at, turns.end());
        report.turn = double(*at);
    }
    const auto used = std::count_if(skeleton.skin.weights.begin(), skeleton.skin.weights.end(),
                                    [](float w) { return w > 0; });
    report.mean_influences = double(used) / double(motion.welded.size());
}

/// Rejects positions so far away that their products overflow. Reports the farthest such position in the
/// first frame that has one.
inline Status check_reach(const Motion& motion, SkeletonReport& report) noexcept {
    constexpr double reach = 1e30;
    std::size_t first = motion.frames;
    double farthest = reach;
    for (std::size_t i = 0; i < motion.welded.size(); ++i) {
        for (std::size_t n = 0; n < 3 * motion.lanes; ++n) {
            const double off = std::fabs(motion.path(motion.welded[i])[n]);
            if (off <= reach) continue;
            const std::size_t frame = n % motion.lanes;
            if (frame > first || (frame == first && off <= farthest)) continue;
            first = report.frame = frame;
            farthest = off;
            report.vertex = i;
        }
    }
    return first < motion.frames ? Status::frame_not_finite : Status::ok;
}

template <class T>
Status fit_motion(Motion& motion, const SkeletonOptions& options, const Running& running,
                  Result<FittedSkeleton<T>, SkeletonReport>& result) {
    motion.prepare();
    if (const Status status = check_reach(motion, result.report); status != Status::ok) return status;
    const std::size_t most =
        (std::min)((std::max)(motion.vertices / 6, std::size_t{1}), SkeletonOptions::largest_bones);
    const auto take = [&](const BoneFit& fit) {
        result.value = skeleton_of<T>(motion, fit);
        measure(motion, result.value, options.max_distance, result.report, running);
        return result.report.max_distance <= options.max_distance;
    };
    if (options.bones != 0) {
        SkeletonFitter fitter(motion, options, running);
        const Status status = fitter.run((std::min)(options.bones, most));
        if (status != Status::ok) return status;
        take(fitter.fit());
    } else {
        SkeletonSearch search(motion, options, running);
        if (const Status status = search.run(most, take); status != Status::ok) return status;
        take(search.best());
    }
    return running.end(Status::ok);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
