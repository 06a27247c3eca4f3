// The rotations nearest to matrices, for a register of matrices or a single matrix.
#pragma once

#include <cageform/core/detail/simd_instructions.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A linear map; at[row][column].
template <class X, std::size_t D>
struct LinearMap {
    X at[D][D];
};

using DoubleLanes = Simd<double>;

inline DoubleLanes sum_of_squares(const DoubleLanes* x, std::size_t count) noexcept {
    DoubleLanes sum = x[0] * x[0];
    for (std::size_t n = 1; n < count; ++n) sum = multiply_add(x[n], x[n], sum);
    return sum;
}

/// Replaces `turn`, a rotation minus the identity, by R − 1 for the rotation R nearest to J, which maximises
/// tr(Rᵀ J). Lanes where J determines no rotation (a reflection or zero) keep `turn`. A symmetric J without
/// negative eigenvalues gives exact zeros.
inline void nearest_rotation(const LinearMap<DoubleLanes, 2>& j, LinearMap<DoubleLanes, 2>& turn) noexcept {
    const DoubleLanes along = j.at[0][0] + j.at[1][1], across = j.at[1][0] - j.at[0][1];
    const DoubleLanes square = multiply_add(along, along, across * across);
    const auto is_open = square <= DoubleLanes(1e-24) * sum_of_squares(&j.at[0][0], 4);
    const DoubleLanes size = select<double>(is_open, DoubleLanes(1), sqrt(square));
    // cos − 1, without cancellation for angles below 90 degrees.
    const DoubleLanes is_ahead = (max)(along, DoubleLanes(0)) + size;
    const DoubleLanes cosine = select<double>(along < DoubleLanes(0), along / size - DoubleLanes(1),
                                              DoubleLanes(0) - across / size * (across / is_ahead));
    const DoubleLanes sine = across / size;
    turn.at[0][0] = select<double>(is_open, turn.at[0][0], cosine);
    turn.at[1][1] = turn.at[0][0];
    turn.at[1][0] = select<double>(is_open, turn.at[1][0], sine);
    turn.at[0][1] = select<double>(is_open, turn.at[0][1], DoubleLanes(0) - sine);
}

/// The eigenvector of the largest eigenvalue of a symmetric 4 × 4 matrix of trace 0: the unit quaternion of
/// Horn (Closed-form solution of absolute orientation using unit quaternions, J. Opt. Soc. Am. A 4 (1987)).
class RotationQuaternion {
public:
    /// j  a matrix whose squares sum to 1
    explicit RotationQuaternion(const LinearMap<DoubleLanes, 3>& j) noexcept {
        const auto& a = j.at;
        n_[0][0] = a[0][0] + a[1][1] + a[2][2];
        n_[0][1] = a[2][1] - a[1][2];
        n_[0][2] = a[0][2] - a[2][0];
        n_[0][3] = a[1][0] - a[0][1];
        n_[1][1] = a[0][0] - a[1][1] - a[2][2];
        n_[1][2] = a[0][1] + a[1][0];
        n_[1][3] = a[0][2] + a[2][0];
        n_[2][2] = a[1][1] - a[0][0] - a[2][2];
        n_[2][3] = a[1][2] + a[2][1];
        n_[3][3] = a[2][2] - a[0][0] - a[1][1];
        for (std::size_t r = 1; r < 4; ++r) {
            for (std::size_t c = 0; c < r; ++c) n_[r][c] = n_[c][r];
        }
        find_value(a);
        find_vector();
        // One step with the Rayleigh quotient makes eigenvalue and eigenvector exact to rounding.
        value_ = DoubleLanes(0);
        for (std::size_t r = 0; r < 4; ++r) {
            DoubleLanes row = n_[r][0] * q[0];
            for (std::size_t c = 1; c < 4; ++c) row = multiply_add(n_[r][c], q[c], row);
            value_ = multiply_add(row, q[r], value_);
        }
        find_vector();
    }

    DoubleLanes q[4];      ///< w, x, y, z
    DoubleLanes certainty; ///< 0 for a double eigenvalue

private:
    /// Computes the eigenvalue by Newton's method from an upper bound.
    void find_value(const DoubleLanes (&a)[3][3]) noexcept {
        const DoubleLanes determinant = a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
                                        a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
                                        a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
        value_ = DoubleLanes(0);
        DoubleLanes cofactors[4][4];
        set_cofactors(cofactors);
        DoubleLanes constant = n_[0][0] * cofactors[0][0];
        for (std::size_t c = 1; c < 4; ++c) constant = multiply_add(n_[0][c], cofactors[0][c], constant);
        const DoubleLanes linear = DoubleLanes(-8) * determinant;
        value_ = DoubleLanes(1.7320508075688774);
        for (int step = 0; step < 24; ++step) {
            const DoubleLanes square = value_ * value_;
            const DoubleLanes f =
                multiply_add(square - DoubleLanes(2), square, multiply_add(linear, value_, constant));
            const DoubleLanes slope =
                multiply_add(DoubleLanes(4) * (square - DoubleLanes(1)), value_, linear);
            const DoubleLanes change = select<double>(slope <= DoubleLanes(0), DoubleLanes(0), f / slope);
            value_ -= change;
            Lanes<double> changes;
            abs(change).store(changes);
            double largest = 0;
            for (const double x : changes.v) largest = x > largest ? x : largest;
            if (!(largest > 1e-9)) return;
        }
    }

    /// Sets the cofactors of the symmetric matrix N − value.
    void set_cofactors(DoubleLanes (&to)[4][4]) const noexcept {
        DoubleLanes m[4][4];
        for (std::size_t r = 0; r < 4; ++r) {
            for (std::size_t c = 0; c < 4; ++c) m[r][c] = r == c ? n_[r][c] - value_ : n_[r][c];
        }
        const auto minor = [&m](std::size_t r, std::size_t s, std::size_t c, std::size_t d) {
            return m[r][c] * m[s][d] - m[r][d] * m[s][c];
        };
        const DoubleLanes low[6] = {minor(2, 3, 0, 1), minor(2, 3, 0, 2), minor(2, 3, 0, 3),
                                    minor(2, 3, 1, 2), minor(2, 3, 1, 3), minor(2, 3, 2, 3)};
        const DoubleLanes high[6] = {minor(0, 1, 0, 1), minor(0, 1, 0, 2), minor(0, 1, 0, 3),
                                     minor(0, 1, 1, 2), minor(0, 1, 1, 3), minor(0, 1, 2, 3)};
        to[0][0] = m[1][1] * low[5] - m[1][2] * low[4] + m[1][3] * low[3];
        to[0][1] = DoubleLanes(0) - (m[1][0] * low[5] - m[1][2] * low[2] + m[1][3] * low[1]);
        to[0][2] = m[1][0] * low[4] - m[1][1] * low[2] + m[1][3] * low[0];
        to[0][3] = DoubleLanes(0) - (m[1][0] * low[3] - m[1][1] * low[1] + m[1][2] * low[0]);
        to[1][1] = m[0][0] * low[5] - m[0][2] * low[2] + m[0][3] * low[1];
        to[1][2] = DoubleLanes(0) - (m[0][0] * low[4] - m[0][1] * low[2] + m[0][3] * low[0]);
        to[1][3] = m[0][0] * low[3] - m[0][1] * low[1] + m[0][2] * low[0];
        to[2][2] = m[3][0] * high[4] - m[3][1] * high[2] + m[3][3] * high[0];
        to[2][3] = DoubleLanes(0) - (m[2][0] * high[4] - m[2][1] * high[2] + m[2][3] * high[0]);
        to[3][3] = m[2][0] * high[3] - m[2][1] * high[1] + m[2][2] * high[0];
        for (std::size_t r = 1; r < 4; ++r) {
            for (std::size_t c = 0; c < r; ++c) to[r][c] = to[c][r];
        }
    }

    /// Sets q to the normalised row of the adjugate with the largest diagonal entry.
    void find_vector() noexcept {
        DoubleLanes cofactors[4][4];
        set_cofactors(cofactors);
        DoubleLanes largest = abs(cofactors[0][0]);
        for (std::size_t c = 0; c < 4; ++c) q[c] = cofactors[0][c];
        for (std::size_t r = 1; r < 4; ++r) {
            const DoubleLanes size = abs(cofactors[r][r]);
            const auto is_larger = largest < size;
            for (std::size_t c = 0; c < 4; ++c) q[c] = select<double>(is_larger, cofactors[r][c], q[c]);
            largest = select<double>(is_larger, size, largest);
        }
        certainty = largest;
        const DoubleLanes length = sqrt(sum_of_squares(q, 4));
        const DoubleLanes over = select<double>(length <= DoubleLanes(0), DoubleLanes(1), length);
        for (DoubleLanes& x : q) x = x / over;
    }

    DoubleLanes n_[4][4], value_;
};

inline void nearest_rotation(const LinearMap<DoubleLanes, 3>& j, LinearMap<DoubleLanes, 3>& turn) noexcept {
    const DoubleLanes size = sqrt(sum_of_squares(&j.at[0][0], 9));
    const auto is_zero = size <= DoubleLanes(1e-100);
    const DoubleLanes over = select<double>(is_zero, DoubleLanes(1), size);
    LinearMap<DoubleLanes, 3> unit;
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) unit.at[r][c] = j.at[r][c] / over;
    }
    const RotationQuaternion found(unit);
    const auto is_open = is_zero | (found.certainty <= DoubleLanes(1e-12));
    const auto& [w, x, y, z] = found.q;
    const auto set = [&](std::size_t r, std::size_t c, const DoubleLanes& half) {
        turn.at[r][c] = select<double>(is_open, turn.at[r][c], half + half);
    };
    const DoubleLanes none(0);
    set(0, 0, none - multiply_add(y, y, z * z));
    set(1, 1, none - multiply_add(x, x, z * z));
    set(2, 2, none - multiply_add(x, x, y * y));
    set(0, 1, x * y - w * z);
    set(1, 0, x * y + w * z);
    set(0, 2, x * z + w * y);
    set(2, 0, x * z - w * y);
    set(1, 2, y * z - w * x);
    set(2, 1, y * z + w * x);
}

/// The same for a single matrix.
template <std::size_t D>
void nearest_rotation(const LinearMap<double, D>& j, LinearMap<double, D>& turn) noexcept {
    LinearMap<DoubleLanes, D> many, turns;
    for (std::size_t r = 0; r < D; ++r) {
        for (std::size_t c = 0; c < D; ++c) {
            many.at[r][c] = DoubleLanes(j.at[r][c]);
            turns.at[r][c] = DoubleLanes(turn.at[r][c]);
        }
    }
    nearest_rotation(many, turns);
    for (std::size_t r = 0; r < D; ++r) {
        for (std::size_t c = 0; c < D; ++c) {
            Lanes<double> lanes;
            turns.at[r][c].store(lanes);
            turn.at[r][c] = lanes[0];
        }
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail
