// Rotates and translates a cage as a whole. For run time.
#pragma once

#include <cageform/clip/curves/track.hpp>

#include <array>
#include <cmath>

namespace cageform::inline CAGEFORM_ABI {

/// A rotation in 3D: a unit quaternion x, y, z, w, where w is the cosine of half the angle.
template <Scalar T>
using Quaternion = std::array<T, 4>;

/// Interpolates between rotations along the shorter arc at constant speed (Shoemake, Animating rotation
/// with quaternion curves, 1985); `fraction` in [0, 1].
template <Scalar T>
Quaternion<T> slerp(const Quaternion<T>& a, Quaternion<T> b, T fraction) noexcept {
    T cosine = 0;
    for (std::size_t k = 0; k < 4; ++k) cosine += a[k] * b[k];
    if (cosine < 0) {
        for (T& x : b) x = -x;
        cosine = -cosine;
    }
    T of_a = 1 - fraction, of_b = fraction;
    // Nearly equal rotations are interpolated linearly and normalised below, since the sine is near 0.
    constexpr T nearly_equal = T(0.9995);
    if (cosine < nearly_equal) {
        const T angle = std::acos(cosine), sine = std::sin(angle);
        of_a = std::sin(of_a * angle) / sine;
        of_b = std::sin(of_b * angle) / sine;
    }
    Quaternion<T> q{};
    T square = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        q[k] = of_a * a[k] + of_b * b[k];
        square += q[k] * q[k];
    }
    for (T& x : q) x /= std::sqrt(square);
    return q;
}

/// A non-owning view of a `RigidMotion` or of the motion of a packed clip.
template <Scalar T, std::size_t D>
struct RigidMotionView {
    Vec<T, D> pivot{};
    TrackView<T> angle_or_phase; ///< 2D: the angle; 3D: the position in `rotations`
    std::span<const Quaternion<T>> rotations;
    std::array<TrackView<T>, D> translation{};

    /// Moves the points of a pose.
    void apply(T time, std::span<Vec<T, D>> pose) const noexcept {
        const auto rows = rotation(time);
        auto to = pivot;
        for (std::size_t k = 0; k < D; ++k) {
            if (!translation[k].curve.empty()) to[k] += translation[k](time);
        }
        for (auto& p : pose) {
            const auto from = p - pivot;
            for (std::size_t k = 0; k < D; ++k) p[k] = to[k] + dot(rows[k], from);
        }
    }

private:
    /// Returns the rows of the rotation matrix.
    Vec<Vec<T, D>, D> rotation(T time) const noexcept {
        if constexpr (D == 2) {
            if (!angle_or_phase.curve.empty()) {
                const T a = angle_or_phase(time), c = std::cos(a), s = std::sin(a);
                return {{{{c, -s}}, {{s, c}}}};
            }
        } else if (!rotations.empty()) {
            const std::size_t last = rotations.size() - 1;
            const T phase = angle_or_phase.curve.empty() ? T(0) : angle_or_phase(time);
            const T inside = phase > T(0) ? (phase < T(last) ? phase : T(last)) : T(0);
            const std::size_t before = std::size_t(inside);
            const std::size_t from = before < last ? before : (last > 0 ? last - 1 : 0);
            const std::size_t to = from < last ? from + 1 : last;
            const auto [x, y, z, w] = slerp(rotations[from], rotations[to], inside - T(from));
            return {{{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)}},
                     {{2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)}},
                     {{2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}}};
        }
        Vec<Vec<T, D>, D> unit{};
        for (std::size_t k = 0; k < D; ++k) unit[k][k] = T(1);
        return unit;
    }
};

/// Rotates and translates a cage as a whole, after its vertices have been sampled. (Interpolating vertices
/// between two rotated poses would shrink the cage in between.) Tracks without pieces have no effect.
template <Scalar T, std::size_t D>
struct RigidMotion {
    Vec<T, D> pivot{};                    ///< the centre of rotation
    Track<T> angle;                       ///< 2D: radians, counter-clockwise with y up
    std::vector<Quaternion<T>> rotations; ///< 3D: one per key
    /// 3D: the fractional key index; 2.25 is a quarter of the arc from key 2 to key 3.
    Track<T> phase;
    std::array<Track<T>, D> translation{}; ///< after the rotation

    RigidMotionView<T, D> view() const noexcept {
        RigidMotionView<T, D> view{pivot, (D == 2 ? angle : phase).view(), rotations, {}};
        for (std::size_t k = 0; k < D; ++k) view.translation[k] = translation[k].view();
        return view;
    }
    /// Moves the points of a pose.
    void apply(T time, std::span<Vec<T, D>> pose) const noexcept { view().apply(time, pose); }
};

} // namespace cageform::inline CAGEFORM_ABI
