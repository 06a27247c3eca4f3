// Stretches and folds of small matrices: determinants and singular values.
#pragma once

#include <cageform/pose/detail/nearest_rotation.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

inline double determinant(const LinearMap<double, 2>& m) noexcept {
    return m.at[0][0] * m.at[1][1] - m.at[0][1] * m.at[1][0];
}
inline double determinant(const LinearMap<double, 3>& m) noexcept {
    const auto& a = m.at;
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
           a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
}

/// Returns the inverse of a regular matrix.
inline LinearMap<double, 2> inverse(const LinearMap<double, 2>& m) noexcept {
    const double over = 1 / determinant(m);
    return {{{over * m.at[1][1], -over * m.at[0][1]}, {-over * m.at[1][0], over * m.at[0][0]}}};
}
inline LinearMap<double, 3> inverse(const LinearMap<double, 3>& m) noexcept {
    const double over = 1 / determinant(m);
    LinearMap<double, 3> to;
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            to.at[c][r] = over * (m.at[r1][c1] * m.at[r2][c2] - m.at[r1][c2] * m.at[r2][c1]);
        }
    }
    return to;
}

/// Returns the squares of the least and the largest singular value.
inline Vec<double, 2> squared_stretches(const LinearMap<double, 2>& m) noexcept {
    const auto& a = m.at;
    const double x = a[0][0] + a[1][1], y = a[1][0] - a[0][1], z = a[0][0] - a[1][1], w = a[0][1] + a[1][0];
    const double p = std::sqrt(x * x + y * y), q = std::sqrt(z * z + w * w);
    return {(p - q) * (p - q) / 4, (p + q) * (p + q) / 4};
}
/// As above, from the eigenvalues of MᵀM in trigonometric form (Smith, Eigenvalues of a symmetric 3 × 3
/// matrix, Comm. ACM 4 (1961)). The least one is computed from the determinant, without cancellation.
inline Vec<double, 2> squared_stretches(const LinearMap<double, 3>& m) noexcept {
    double s[3][3];
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c)
            s[r][c] = m.at[0][r] * m.at[0][c] + m.at[1][r] * m.at[1][c] + m.at[2][r] * m.at[2][c];
    }
    const double mean = (s[0][0] + s[1][1] + s[2][2]) / 3;
    LinearMap<double, 3> b;
    double spread = 0;
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) {
            b.at[r][c] = s[r][c] - (r == c ? mean : 0);
            spread += b.at[r][c] * b.at[r][c];
        }
    }
    const double p = std::sqrt(spread / 6);
    if (!(p > 1e-14 * mean)) return {mean, mean};
    const double ratio = determinant(b) / (2 * p * p * p);
    const double angle = std::acos(ratio < -1 ? -1 : ratio > 1 ? 1 : ratio) / 3;
    const double largest = mean + 2 * p * std::cos(angle);
    const double least = mean + 2 * p * std::cos(angle + 2.0943951023931953);
    const double middle = 3 * mean - largest - least, volume = determinant(m);
    return {middle > 0 ? volume * volume / (middle * largest) : 0, largest};
}

/// The extreme stretches of several deformations.
struct Stretches {
    std::size_t folded = 0;
    double least = 1, largest = 1; ///< squares of singular values

    /// Adds the deformation 1 + d M⁻¹.
    template <std::size_t D>
    void add(const LinearMap<double, D>& d, const LinearMap<double, D>& moments) noexcept {
        const LinearMap<double, D> over = inverse(moments);
        LinearMap<double, D> f;
        for (std::size_t r = 0; r < D; ++r) {
            for (std::size_t c = 0; c < D; ++c) {
                f.at[r][c] = r == c ? 1 : 0;
                for (std::size_t k = 0; k < D; ++k) f.at[r][c] += d.at[r][k] * over.at[k][c];
            }
        }
        const Vec<double, 2> squares = squared_stretches(f);
        folded += determinant(f) > 0 ? 0 : 1;
        least = squares[0] < least ? squares[0] : least;
        largest = squares[1] > largest ? squares[1] : largest;
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
