// Validates a skeleton, makes its keys and measures them.
#pragma once

#include <cageform/core/result.hpp>
#include <cageform/skeleton/detail/fit_motion.hpp>
#include <cageform/skeleton/detail/key_fitter.hpp>
#include <cageform/skeleton/detail/motion.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class To, class T>
typename FittedSkeleton<To>::Map map_cast(const typename FittedSkeleton<T>::Map& map) noexcept {
    typename FittedSkeleton<To>::Map result;
    for (std::size_t c = 0; c < 3; ++c) result.axes[c] = vec_cast<To>(map.axes[c]);
    result.shift = vec_cast<To>(map.shift);
    return result;
}

template <class T>
Status check_frames(const SkeletonFrames<T>& given, double max_distance) noexcept {
    const auto& [skeleton, rest, times] = given;
    if (!(max_distance >= 0) || !std::isfinite(max_distance)) return Status::value_not_finite;
    const SkinWeights& skin = skeleton.skin;
    if (skeleton.bones == 0 || skeleton.frames == 0 || skeleton.parents.size() != skeleton.bones ||
        skeleton.joints.size() != skeleton.bones ||
        skeleton.maps.size() != skeleton.bones * skeleton.frames || skin.joints.size() != skin.weights.size())
        return Status::input_malformed;
    for (std::size_t b = 0; b < skeleton.bones; ++b) {
        const std::uint32_t parent = skeleton.parents[b];
        if (parent >= b && parent != FittedSkeleton<T>::no_parent) return Status::input_malformed;
    }
    for (const std::uint16_t joint : skin.joints) {
        if (joint >= skeleton.bones) return Status::input_malformed;
    }
    if (times.size() != skeleton.frames || skin.joints.size() != rest.size() * skin.influences)
        return Status::frames_do_not_match;
    for (std::size_t t = 0; t < times.size(); ++t) {
        if (!is_finite(times[t])) return Status::value_not_finite;
        if (t > 0 && !(times[t - 1] < times[t])) return Status::keys_not_ascending;
    }
    return Status::ok;
}

/// Measures the maximum distance between the positions of a vertex by maps and by keys, relative to `size`.
template <class T>
void measure_keys(const SkeletonFrames<T>& given, double size, const SkeletonKeys<T>& keys,
                  typename SkeletonKeys<T>::Turn way, SkeletonKeysReport& report) {
    const auto& [skeleton, rest, times] = given;
    FittedSkeleton<T> played = skeleton;
    played.frames = 1;
    for (std::size_t t = 0; t < times.size(); ++t) {
        played.maps = keys.maps(skeleton, times[t], way);
        for (std::size_t i = 0; i < rest.size(); ++i) {
            const auto place = vec_cast<T>(rest[i]);
            const auto d = vec_cast<double>(played.place(0, i, place) - skeleton.place(t, i, place));
            const double distance = std::sqrt(dot(d, d)) / size;
            if (distance <= report.max_distance) continue;
            report.max_distance = distance;
            report.frame = t;
            report.vertex = i;
        }
    }
}

/// Converts a channel to scalars of type T and counts its keys.
template <class T, class To, class From>
void store_channel(To& to, const From& from, SkeletonKeysReport& report) {
    using V = std::decay_t<decltype(to.values[0])>;
    constexpr std::size_t size = sizeof(V) / sizeof(T);
    const auto cast = [](const auto& list) {
        std::vector<V> copies(list.size());
        for (std::size_t n = 0; n < list.size(); ++n) {
            for (std::size_t k = 0; k < size; ++k) copies[n][k] = T(list[n][k]);
        }
        return copies;
    };
    to.times.assign(from.times.begin(), from.times.end());
    to.values = cast(from.values);
    to.in_tangents = cast(from.in_tangents);
    to.out_tangents = cast(from.out_tangents);
    report.keys += from.times.size();
    report.numbers += from.times.size() * ((from.in_tangents.empty() ? 1 : 3) * size + 1);
}

template <class T>
Status make_keys(const SkeletonFrames<T>& given, const SkeletonKeyOptions& options, const Running& running,
                 Result<SkeletonKeys<T>, SkeletonKeysReport>& result) {
    if (const Status status = check_frames(given, options.max_distance); status != Status::ok) return status;
    const auto& [fitted, rest, times] = given;
    for (const auto& p : rest) {
        if (!is_finite(p)) return Status::value_not_finite;
    }
    FittedSkeleton<double> skeleton;
    skeleton.bones = fitted.bones;
    skeleton.frames = fitted.frames;
    skeleton.skin = fitted.skin;
    skeleton.parents = fitted.parents;
    for (const auto& map : fitted.maps) skeleton.maps.push_back(map_cast<double, T>(map));
    for (const auto& joint : fitted.joints) skeleton.joints.push_back(vec_cast<double>(joint));
    double size = figure_size(rest);
    if (!(size > 0)) size = 1;
    const std::vector<double> seconds(times.begin(), times.end());
    // Differences of slerp and nlerp accumulate along a chain. The fit is repeated with a smaller distance;
    // the last round keeps every frame.
    constexpr int rounds = 6;
    SkeletonKeyOptions smaller = options;
    for (int round = 0; round < rounds; ++round) {
        result = {};
        KeyFitter fitter(skeleton, rest, seconds, smaller, size);
        const Running of_round = running.subtask(1 - std::ldexp(1, -round), 1 - std::ldexp(0.5, -round));
        if (const Status status = fitter.run(of_round); status != Status::ok) return status;
        for (const SkeletonKeys<double>::Bone& bone : fitter.keys.bones) {
            auto& to = result.value.bones.emplace_back();
            store_channel<T>(to.translation, bone.translation, result.report);
            store_channel<T>(to.rotation, bone.rotation, result.report);
            store_channel<T>(to.scale, bone.scale, result.report);
            store_channel<T>(to.axes, bone.axes, result.report);
        }
        SkeletonKeysReport by_nlerp;
        measure_keys(given, size, result.value, SkeletonKeys<T>::Turn::slerp, result.report);
        measure_keys(given, size, result.value, SkeletonKeys<T>::Turn::nlerp, by_nlerp);
        const double most = (std::max)(options.max_distance, result.report.max_distance); // covers rounding
        if (smaller.max_distance == 0 || by_nlerp.max_distance <= most) break;
        smaller.max_distance *= round + 2 < rounds ? 0.97 * most / by_nlerp.max_distance : 0;
    }
    return running.end(Status::ok);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
