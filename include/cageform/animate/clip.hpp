// A cage that moves: the pose of all its vertices at a time, without allocating. Run time, as piecewise_cubic.hpp.
#pragma once

#include <cageform/animate/piecewise_cubic.hpp>

#include <array>

namespace cageform::inline CAGEFORM_ABI {

/// A rotation in space: x, y, z, w with w = cos of half the angle; of unit length.
template <Scalar T>
using Quaternion = std::array<T, 4>;

/// From one rotation to another along the shorter way at constant speed; `part` in [0, 1] (Shoemake 1985).
template <Scalar T>
Quaternion<T> slerp(const Quaternion<T>& a, Quaternion<T> b, T part) noexcept {
    T cosine = 0;
    for (std::size_t k = 0; k < 4; ++k) cosine += a[k] * b[k];
    if (cosine < 0) {
        for (T& x : b) x = -x;
        cosine = -cosine;
    }
    T of_a = 1 - part, of_b = part;
    if (cosine <
        T(0.9995)) { // nearer than that a straight line, made of unit length again below, does as well
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

/// A turn of a cage as a whole, on top of what its vertices do: interpolating the places of vertices between two turned poses
/// would shrink the cage on the way. In the plane `angle` (radians, counter-clockwise with y up); in space `rotations`
/// at keys, between which `phase` tells where one is: 2.25 is a quarter of the way from key 2 to key 3, eased as its track
/// is. Then `translation`. Tracks without pieces do nothing.
template <Scalar T, std::size_t D>
struct RigidMotion {
    Vec<T, D> pivot{};                    ///< the point about which the cage turns
    Track<T> angle;                       ///< in the plane
    std::vector<Quaternion<T>> rotations; ///< in space
    Track<T> phase;                       ///< in space
    std::array<Track<T>, D> translation{};
};

/// The motion of a cage: a track for every coordinate of every vertex, and perhaps a rigid motion on top. Made once;
/// `sample` is noexcept and allocates nothing.
template <Scalar T, std::size_t D>
class CageClip {
    static_assert(D == 2 || D == 3);

public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    CageClip() = default;

    /// `curves`: #vertices · D, the coordinates of a vertex side by side, each with pieces. The clip lasts from the first
    /// begin of a curve to the last end; beyond it goes on as said, as a whole.
    CageClip(std::span<const PiecewiseCubic<T>> curves, Extrapolation before = Extrapolation::constant,
             Extrapolation after = Extrapolation::constant)
        : bank_(curves)
        , before_(before)
        , after_(after) {
        CAGEFORM_ASSERT(curves.size() % D == 0, "D curves a vertex");
        if (curves.empty()) return;
        begin_ = curves[0].begin();
        end_ = curves[0].end();
        for (const auto& curve : curves) {
            begin_ = curve.begin() < begin_ ? curve.begin() : begin_;
            end_ = curve.end() > end_ ? curve.end() : end_;
        }
        // What a turn of the clip adds, and the slopes at its ends.
        Cursor cursor = make_cursor();
        first_.resize(curves.size());
        last_.resize(curves.size());
        first_slope_.resize(curves.size());
        last_slope_.resize(curves.size());
        bank_.sample(end_, cursor.bank_, last_);
        bank_.sample(begin_, cursor.bank_, first_, first_slope_);
        for (std::size_t k = 0; k < curves.size(); ++k) {
            const auto& last = curves[k].pieces().back();
            last_slope_[k] = curves[k].end() == end_ ? last.derivative(end_) : T(0);
        }
    }

    void set_rigid_motion(RigidMotion<T, D> motion) {
        motion_ = std::move(motion);
        moves_ = true;
    }

    std::size_t vertex_count() const noexcept { return bank_.size() / D; }
    T begin() const noexcept { return begin_; }
    T end() const noexcept { return end_; }
    std::size_t bytes() const noexcept { return bank_.bytes(); }

    /// Where a player of the clip is; one for every place that plays it.
    class Cursor {
    public:
        Cursor() = default;

    private:
        friend class CageClip;
        typename CurveBank<T>::Cursor bank_;
        std::vector<T> values_;
    };
    Cursor make_cursor() const {
        Cursor cursor;
        cursor.bank_ = bank_.make_cursor();
        cursor.values_.resize(bank_.size());
        return cursor;
    }

    /// The cage's vertices at a time, into `pose` (#vertices): what `clone` takes.
    void sample(T time, Cursor& cursor, std::span<Vec<T, D>> pose) const noexcept {
        CAGEFORM_ASSERT(pose.size() >= vertex_count(), "a place for every vertex");
        const auto folded = fold_time(time, begin_, end_, before_, after_);
        bank_.sample(folded.time, cursor.bank_, cursor.values_);
        for (std::size_t i = 0; i < vertex_count(); ++i) {
            for (std::size_t k = 0; k < D; ++k) {
                const std::size_t n = i * D + k;
                const T slope = folded.beyond < 0 ? first_slope_[n] : last_slope_[n];
                const T turned = detail::multiply_add(folded.turns, last_[n] - first_[n], cursor.values_[n]);
                pose[i][k] = detail::multiply_add(folded.beyond, slope, turned);
            }
        }
        if (moves_) move(time, pose.first(vertex_count()));
    }

private:
    void move(T time, std::span<Vec<T, D>> pose) const noexcept {
        Vec<Vec<T, D>, D> rows{};
        for (std::size_t k = 0; k < D; ++k) rows[k][k] = T(1);
        if constexpr (D == 2) {
            if (!motion_.angle.curve.empty()) {
                const T angle = motion_.angle(time), c = std::cos(angle), s = std::sin(angle);
                rows = {{{{c, -s}}, {{s, c}}}};
            }
        } else if (!motion_.rotations.empty()) {
            const std::size_t last = motion_.rotations.size() - 1;
            const T phase = motion_.phase.curve.empty() ? T(0) : motion_.phase(time);
            const T inside = phase > T(0) ? (phase < T(last) ? phase : T(last)) : T(0);
            const std::size_t from =
                std::size_t(inside) < last ? std::size_t(inside) : (last > 0 ? last - 1 : 0);
            const std::size_t to = from < last ? from + 1 : last;
            const auto [x, y, z, w] = slerp(motion_.rotations[from], motion_.rotations[to], inside - T(from));
            rows = {{{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)}},
                     {{2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)}},
                     {{2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}}};
        }
        auto to = motion_.pivot;
        for (std::size_t k = 0; k < D; ++k) {
            if (!motion_.translation[k].curve.empty()) to[k] += motion_.translation[k](time);
        }
        for (auto& p : pose) {
            const auto from = p - motion_.pivot;
            for (std::size_t k = 0; k < D; ++k) p[k] = to[k] + dot(rows[k], from);
        }
    }

    CurveBank<T> bank_;
    T begin_ = 0, end_ = 0;
    Extrapolation before_ = Extrapolation::constant, after_ = Extrapolation::constant;
    std::vector<T> first_, last_, first_slope_, last_slope_; ///< of every curve at the clip's ends
    RigidMotion<T, D> motion_;
    bool moves_ = false;
};

} // namespace cageform::inline CAGEFORM_ABI
