// The keys of a skeleton's motion, as engines play them.
#pragma once

#include <cageform/clip/curves/rigid_motion.hpp>
#include <cageform/skeleton/types/fitted_skeleton.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Keys of every bone's node, as glTF has them. A node's local transform is
///
///     x ↦ rotation(scale · axes(x)) + translation
///
/// It goes from the node's own axes, whose origin is the bone's joint, to those of its parent.
template <class T>
struct SkeletonKeys {
    using Map = typename FittedSkeleton<T>::Map;

    /// How players turn between keys without tangents: at constant speed (slerp), as glTF asks, or by
    /// components, normalised (nlerp), as many do.
    enum class Turn { slerp, nlerp };

    /// Without tangents, values go straight between keys, and rotations turn at constant speed along the
    /// shorter arc (LINEAR). With tangents they are cubics; those of rotations are then normalised
    /// (CUBICSPLINE).
    template <class V>
    struct Channel {
        std::vector<T> times;                     ///< in seconds, ascending; a single key holds at all times
        std::vector<V> values;                    ///< #times; neighbouring rotations have one sign
        std::vector<V> in_tangents, out_tangents; ///< #times, per second; or none
    };
    struct Bone {
        Channel<Vec<T, 3>> translation;
        Channel<Quaternion<T>> rotation;
        Channel<Vec<T, 3>> scale; ///< (1, 1, 1) of rigid bones
        /// Turns to the axes that are scaled; the identity unless bones are stretched. glTF needs a second
        /// node for it, a child that carries the joint and the children.
        Channel<Quaternion<T>> axes;
    };
    std::vector<Bone> bones;

    /// Returns a bone's local transform at a time; before the first key and after the last, theirs.
    Map local(std::size_t bone, T time, Turn way = Turn::slerp) const noexcept {
        const Bone& of = bones[bone];
        return composed(at(of.translation, time, way), at(of.rotation, time, way), at(of.scale, time, way),
                        at(of.axes, time, way));
    }
    /// Returns where each bone takes a vertex from its place at rest at a time, as FittedSkeleton::map does
    /// in a frame; #bones.
    std::vector<Map> maps(const FittedSkeleton<T>& skeleton, T time, Turn way = Turn::slerp) const {
        std::vector<Map> nodes(bones.size());
        for (std::size_t b = 0; b < bones.size(); ++b) {
            nodes[b] = local(b, time, way);
            if (skeleton.parents[b] != FittedSkeleton<T>::no_parent)
                nodes[b] = nodes[skeleton.parents[b]].after(nodes[b]);
        }
        for (std::size_t b = 0; b < bones.size(); ++b) nodes[b].shift = nodes[b](T(-1) * skeleton.joints[b]);
        return nodes;
    }

    /// Returns the local transform that the values of the four channels make.
    static Map composed(const Vec<T, 3>& translation, const Quaternion<T>& rotation, const Vec<T, 3>& scale,
                        const Quaternion<T>& axes) noexcept {
        const Map outer = turn(rotation), inner = turn(axes);
        Map result;
        for (std::size_t c = 0; c < 3; ++c) {
            Vec<T, 3> axis = inner.axes[c];
            for (std::size_t k = 0; k < 3; ++k) axis[k] *= scale[k];
            result.axes[c] = outer(axis);
        }
        result.shift = translation;
        return result;
    }

private:
    static Map turn(const Quaternion<T>& q) noexcept {
        const auto [x, y, z, w] = q;
        Map map;
        map.axes = {{{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                     {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                     {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}}};
        return map;
    }
    template <class V>
    static V at(const Channel<V>& channel, T time, Turn way) noexcept {
        const std::vector<T>& times = channel.times;
        if (!(time > times.front())) return channel.values.front();
        if (!(time < times.back())) return channel.values.back();
        std::size_t low = 0, high = times.size() - 1; // the time is between theirs
        while (high - low > 1) {
            const std::size_t middle = (low + high) / 2;
            (times[middle] <= time ? low : high) = middle;
        }
        constexpr bool turns = std::is_same_v<V, Quaternion<T>>;
        const T length = times[high] - times[low], t = (time - times[low]) / length, s = 1 - t;
        const V &a = channel.values[low], &b = channel.values[high];
        const bool is_linear = channel.out_tangents.empty();
        if constexpr (turns) {
            if (is_linear && way == Turn::slerp) return slerp(a, b, t);
        }
        V result{};
        T square = 0;
        for (std::size_t k = 0; k < (turns ? 4 : 3); ++k) {
            result[k] = is_linear
                            ? a[k] + t * (b[k] - a[k])
                            : s * s * (1 + 2 * t) * a[k] + t * t * (3 - 2 * t) * b[k] +
                                  length * s * t *
                                      (s * channel.out_tangents[low][k] - t * channel.in_tangents[high][k]);
            square += result[k] * result[k];
        }
        for (std::size_t k = 0; turns && k < 4; ++k) result[k] /= std::sqrt(square);
        return result;
    }
};

/// Controls how keys are made; see skeleton/fit_skeleton.hpp.
struct SkeletonKeyOptions {
    /// How far the keys may bring a vertex from where the maps bring it, a share of the figure's diagonal at
    /// rest. 0: a key in each frame, where more than one is needed.
    double max_distance = 0;
    /// Whether a channel may have tangents where it then stores fewer numbers. Players of glTF read them;
    /// Blender 3.4 does not: it makes tangents of its own.
    bool tangents = false;
};

struct SkeletonKeysReport {
    Status status = Status::ok;
    std::size_t keys = 0;    ///< of all channels
    std::size_t numbers = 0; ///< that they store: times, values and tangents
    /// The largest distance between the figure by maps and by keys, a share of its diagonal at rest.
    double max_distance = 0;
    std::size_t frame = 0, vertex = 0; ///< where it is
    double seconds = 0;
};

} // namespace cageform::inline CAGEFORM_ABI
