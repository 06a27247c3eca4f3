// A skeleton with skinning weights and motion.
#pragma once

#include <cageform/binding/types/skin_weights.hpp>
#include <cageform/core/vec.hpp>

#include <array>

namespace cageform::inline CAGEFORM_ABI {

/// Skinning weights, and the map of each bone in each frame. The position of vertex v in frame t is
///
///     Σ_k weight_k · map(t, joint_k)(v)
///
/// In the rest pose all maps are the identity. Parents precede children.
template <class T>
struct FittedSkeleton {
    static constexpr std::uint32_t no_parent = 0xffffffff;

    /// x ↦ Σ_c axes[c] x_c + shift.
    struct Map {
        std::array<Vec<T, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
        Vec<T, 3> shift{};

        Vec<T, 3> operator()(const Vec<T, 3>& x) const noexcept {
            return x[0] * axes[0] + (x[1] * axes[1] + (x[2] * axes[2] + shift));
        }
        /// Returns the linear part applied to a direction.
        Vec<T, 3> turned(const Vec<T, 3>& x) const noexcept {
            return x[0] * axes[0] + (x[1] * axes[1] + x[2] * axes[2]);
        }
        /// Returns the composition x ↦ this(inner(x)).
        Map after(const Map& inner) const noexcept {
            Map result;
            for (std::size_t c = 0; c < 3; ++c) result.axes[c] = turned(inner.axes[c]);
            result.shift = (*this)(inner.shift);
            return result;
        }
        /// Returns the inverse; the axes must be linearly independent.
        Map inverse() const noexcept {
            const std::array<Vec<T, 3>, 3> rows{cross(axes[1], axes[2]), cross(axes[2], axes[0]),
                                                cross(axes[0], axes[1])};
            const T share = 1 / dot(axes[0], rows[0]);
            Map result;
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t r = 0; r < 3; ++r) result.axes[c][r] = share * rows[r][c];
            }
            result.shift = T(-1) * result.turned(shift);
            return result;
        }
        friend bool operator==(const Map&, const Map&) = default;
    };

    std::size_t bones = 0;
    std::size_t frames = 0;
    SkinWeights skin;                   ///< `joints` are indices of bones
    std::vector<Map> maps;              ///< #frames · #bones, frame by frame
    std::vector<std::uint32_t> parents; ///< #bones; no_parent for the root, bone 0
    std::vector<Vec<T, 3>> joints;      ///< #bones: pivot of each bone in the rest pose

    const Map& map(std::size_t frame, std::size_t bone) const noexcept { return maps[frame * bones + bone]; }

    /// Returns the position of a vertex in a frame, given its position in the rest pose.
    Vec<T, 3> place(std::size_t frame, std::size_t vertex, const Vec<T, 3>& rest) const noexcept {
        Vec<T, 3> sum{};
        for (std::size_t k = vertex * skin.influences; k < (vertex + 1) * skin.influences; ++k) {
            if (skin.weights[k] > 0) sum = sum + T(skin.weights[k]) * map(frame, skin.joints[k])(rest);
        }
        return sum;
    }
    /// Returns the local transform of a bone's node in a frame. It maps the node's own axes, with the origin
    /// at the joint, to the axes of its parent (of the world for a root). map(frame, bone) is a translation
    /// by minus the joint, followed by the local transforms from the bone to the root.
    Map local(std::size_t frame, std::size_t bone) const noexcept {
        const Map own = node(frame, bone);
        return parents[bone] == no_parent ? own : node(frame, parents[bone]).inverse().after(own);
    }

private:
    Map node(std::size_t frame, std::size_t bone) const noexcept {
        Map result = map(frame, bone);
        result.shift = result(joints[bone]);
        return result;
    }
};

} // namespace cageform::inline CAGEFORM_ABI
