// Rigid motions, and the motion that fits pairs of positions best.
#pragma once

#include <cageform/pose/detail/nearest_rotation.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The motion x ↦ Q x + b. Storing Q − 1 makes the identity exact.
template <std::size_t D>
struct RigidFrame {
    LinearMap<double, D> turn{}; ///< Q − 1
    Vec<double, D> shift{};      ///< b

    /// `change` returns (Q − 1) v, `change_back` (Q − 1)ᵀ v.
    Vec<double, D> change(const Vec<double, D>& v) const noexcept {
        Vec<double, D> to{};
        for (std::size_t r = 0; r < D; ++r) {
            for (std::size_t c = 0; c < D; ++c) to[r] += turn.at[r][c] * v[c];
        }
        return to;
    }
    Vec<double, D> change_back(const Vec<double, D>& v) const noexcept {
        Vec<double, D> to{};
        for (std::size_t r = 0; r < D; ++r) {
            for (std::size_t c = 0; c < D; ++c) to[c] += turn.at[r][c] * v[r];
        }
        return to;
    }
    Vec<double, D> rotate(const Vec<double, D>& v) const noexcept { return v + change(v); }
    Vec<double, D> rotate_back(const Vec<double, D>& v) const noexcept { return v + change_back(v); }
};

/// Sums up pairs of a place y and a target t for the rigid motion that minimises Σ m |Q y + b − t|². Vectors
/// affect only the rotation.
template <std::size_t D>
class RigidFit {
public:
    void add_centre(const Vec<double, D>& place, const Vec<double, D>& target, double weight) noexcept {
        place_ = place_ + weight * place;
        target_ = target_ + weight * target;
        weight_ += weight;
    }
    /// Call after all centres are added.
    void add_point(const Vec<double, D>& place, const Vec<double, D>& target, double weight) noexcept {
        add_vector(place - (1 / weight_) * place_, target - (1 / weight_) * target_, weight);
    }
    void add_vector(const Vec<double, D>& place, const Vec<double, D>& target, double weight) noexcept {
        for (std::size_t r = 0; r < D; ++r) {
            for (std::size_t c = 0; c < D; ++c) sums_.at[r][c] += weight * target[r] * place[c];
        }
        scale_ += weight;
    }
    /// Sets the motion. A rotation that the pairs do not determine is unchanged.
    void set(RigidFrame<D>& frame) const noexcept {
        double squares = 0;
        for (const auto& row : sums_.at) {
            for (const double x : row) squares += x * x;
        }
        if (squares > 1e-24 * scale_ * scale_) rotate(frame, squares);
        if (weight_ > 0) frame.shift = (1 / weight_) * target_ - frame.rotate((1 / weight_) * place_);
    }

private:
    void rotate(RigidFrame<2>& frame, double /*squares*/) const noexcept {
        nearest_rotation(sums_, frame.turn);
    }
    void rotate(RigidFrame<3>& frame, double squares) const noexcept {
        double minors = 0; // sum of the squared 2 × 2 minors, zero for rank 1
        const auto& a = sums_.at;
        std::size_t longest = 0;
        double length[3];
        for (std::size_t r = 0; r < 3; ++r) {
            length[r] = a[r][0] * a[r][0] + a[r][1] * a[r][1] + a[r][2] * a[r][2];
            longest = length[r] > length[longest] ? r : longest;
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t s = (r + 1) % 3, d = (c + 1) % 3;
                const double minor = a[r][c] * a[s][d] - a[r][d] * a[s][c];
                minors += minor * minor;
            }
        }
        if (minors > 1e-16 * squares * squares)
            nearest_rotation(sums_, frame.turn);
        else
            rotate_axis(frame, unit({a[longest][0], a[longest][1], a[longest][2]}));
    }
    /// Applies the smallest rotation that maps a line of places to the line of their targets.
    void rotate_axis(RigidFrame<3>& frame, const Vec<double, 3>& axis) const noexcept {
        Vec<double, 3> to{};
        for (std::size_t r = 0; r < 3; ++r)
            to[r] = dot(Vec<double, 3>{sums_.at[r][0], sums_.at[r][1], sums_.at[r][2]}, axis);
        to = unit(to);
        const Vec<double, 3> from = unit(frame.rotate(axis));
        // The product of two half turns: about the first line, then about the bisector of both lines.
        Vec<double, 3> middle = from + to;
        if (dot(middle, middle) < 1e-24) middle = across(from);
        middle = unit(middle);
        LinearMap<double, 3> turned{};
        for (std::size_t c = 0; c < 3; ++c) {
            Vec<double, 3> column{frame.turn.at[0][c], frame.turn.at[1][c], frame.turn.at[2][c]};
            column[c] += 1;
            column = 2 * dot(from, column) * from - column;
            column = 2 * dot(middle, column) * middle - column;
            for (std::size_t r = 0; r < 3; ++r) turned.at[r][c] = column[r];
        }
        nearest_rotation(turned, frame.turn); // keeps rounding errors from accumulating over frames
    }
    static Vec<double, 3> unit(const Vec<double, 3>& v) noexcept { return (1 / std::sqrt(dot(v, v))) * v; }
    static Vec<double, 3> across(const Vec<double, 3>& v) noexcept {
        const bool is_along_x = std::fabs(v[0]) > 0.6;
        return cross(v, is_along_x ? Vec<double, 3>{0, 1, 0} : Vec<double, 3>{1, 0, 0});
    }

    LinearMap<double, D> sums_{};
    Vec<double, D> place_{}, target_{};
    double weight_ = 0, scale_ = 0;
};

/// Returns R − 1 for a counterclockwise rotation by an angle, in radians.
inline LinearMap<double, 2> rotation_of(const Vec<double, 1>& angle) noexcept {
    const double half = std::sin(angle[0] / 2), sine = std::sin(angle[0]), cosine = -2 * half * half;
    return {{{cosine, -sine}, {sine, cosine}}};
}
/// Returns R − 1 for a rotation about the axis `turn` by its length, in radians.
inline LinearMap<double, 3> rotation_of(const Vec<double, 3>& turn) noexcept {
    const double angle = std::sqrt(dot(turn, turn));
    LinearMap<double, 3> to{};
    if (!(angle > 0)) return to;
    const Vec<double, 3> axis = (1 / angle) * turn;
    const double half = std::sin(angle / 2), sine = std::sin(angle), less = 2 * half * half;
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) to.at[r][c] += less * (axis[r] * axis[c] - (r == c ? 1 : 0));
        const std::size_t s = (r + 1) % 3, t = (r + 2) % 3;
        to.at[t][s] += sine * axis[r];
        to.at[s][t] -= sine * axis[r];
    }
    return to;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
