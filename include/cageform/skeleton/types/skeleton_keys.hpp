// Keys of a skeleton's motion.
#pragma once

#include <cageform/clip/curves/rigid_motion.hpp>
#include <cageform/skeleton/types/fitted_skeleton.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Keys of each bone's node, as in glTF. The local transform of a node is
///
///     x ↦ rotation(scale · axes(x)) + translation
///
/// It maps the node's own axes, with the origin at the bone's joint, to those of its parent.
template <class T>
struct SkeletonKeys {
    using Map = typename FittedSkeleton<T>::Map;

    /// Interpolation of rotations without tangents: slerp as glTF requires, or nlerp as in many players.
    enum class Turn : std::uint8_t { slerp, nlerp };

    /// Without tangents, values are interpolated linearly and rotations by slerp along the shorter arc
    /// (LINEAR). With tangents, values are cubic splines; those of rotations are normalised (CUBICSPLINE).
    template <class V>
    struct Channel {
        std::vector<T> times;                     ///< in seconds, ascending; a single key holds at all times
        std::vector<V> values;                    ///< #times; dot products of neighbouring rotations are >= 0
        std::vector<V> in_tangents, out_tangents; ///< #times, per second; or none
    };
    struct Bone {
        Channel<Vec<T, 3>> translation;
        Channel<Quaternion<T>> rotation;
        Channel<Vec<T, 3>> scale; ///< (1, 1, 1) for rigid bones
        /// Rotation to the axes of the scale; the identity unless bones are stretched. In glTF, this rotation
        /// needs a second node, a child of the bone's node. The second node is then the joint of the skin and
        /// the parent of the child bones.
        Channel<Quaternion<T>> axes;
    };
    std::vector<Bone> bones;

    /// Returns the local transform of a bone at a time, clamped to the first and last key.
    Map local(std::size_t bone, T time, Turn way = Turn::slerp) const noexcept {
        const Bone& of = bones[bone];
        return composed(at(of.translation, time, way), at(of.rotation, time, way), at(of.scale, time, way),
                        at(of.axes, time, way));
    }
    /// Returns the map of each bone from the rest pose to the pose at a time; #bones. FittedSkeleton::map is
    /// the same for a frame.
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

    /// Returns the local transform of the four channel values.
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
        std::size_t low = 0, high = times.size() - 1; // the time is between these two keys
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

/// Options of fit_skeleton_keys.
struct SkeletonKeyOptions {
    /// Maximum distance between two positions of a vertex: by the keys, and by the maps of the fitted
    /// skeleton. Relative to the figure's diagonal in the rest pose. 0: a key in each frame, except in
    /// constant channels.
    double max_distance = 0;
    /// Uses tangents in channels where tangents need fewer numbers. glTF players support tangents; Blender
    /// 3.4 replaces them by its own tangents.
    bool tangents = false;
};

struct SkeletonKeysReport {
    Status status = Status::ok;
    std::size_t keys = 0;    ///< number of keys in all channels
    std::size_t numbers = 0; ///< stored: times, values and tangents
    /// Largest distance that occurs, measured as SkeletonKeyOptions::max_distance.
    double max_distance = 0;
    std::size_t frame = 0, vertex = 0; ///< where max_distance is reached
    double seconds = 0;
};

} // namespace cageform::inline CAGEFORM_ABI
