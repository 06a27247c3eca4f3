// Determinants and singular values of small matrices, and the first root of a determinant along a line.
#pragma once

#include <cageform/core/vec.hpp>

#include <array>
#include <cmath>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A square matrix in column-major order.
template <std::size_t D>
using Columns = std::array<Vec<double, D>, D>;

inline double determinant(const Columns<2>& m) noexcept {
    return cross(m[0], m[1]);
}
inline double determinant(const Columns<3>& m) noexcept {
    return dot(m[0], cross(m[1], m[2]));
}

/// Returns the columns of det(m) m⁻ᵀ.
inline Columns<2> cofactors(const Columns<2>& m) noexcept {
    return {{{m[1][1], -m[1][0]}, {-m[0][1], m[0][0]}}};
}
inline Columns<3> cofactors(const Columns<3>& m) noexcept {
    return {cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])};
}

inline double largest_singular_value(const Columns<2>& m) noexcept {
    return (std::hypot(m[0][0] + m[1][1], m[0][1] - m[1][0]) +
            std::hypot(m[0][0] - m[1][1], m[0][1] + m[1][0])) /
           2;
}
/// From the largest eigenvalue of MᵀM in trigonometric form (Smith 1961).
inline double largest_singular_value(const Columns<3>& m) noexcept {
    double size = 0;
    for (const auto& column : m) {
        for (const double x : column.v) size = std::fabs(x) > size ? std::fabs(x) : size;
    }
    if (!(size > 0)) return 0;
    Columns<3> scaled = m, g{}; // so that squares neither underflow nor overflow
    for (auto& column : scaled) column = (1 / size) * column;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) g[i][j] = dot(scaled[i], scaled[j]);
    }
    const double mean = (g[0][0] + g[1][1] + g[2][2]) / 3;
    double squares = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        g[i][i] -= mean;
        squares += dot(g[i], g[i]);
    }
    const double p = std::sqrt(squares / 6);
    if (!(p > 0)) return size * std::sqrt(mean);
    for (auto& column : g) column = (1 / p) * column;
    const double r = determinant(g) / 2, cosine = r < -1 ? -1 : r > 1 ? 1 : r;
    return size * std::sqrt(mean + 2 * p * std::cos(std::acos(cosine) / 3));
}

struct SingularValues {
    double largest, least;
};
/// The least singular value is computed from the determinant, without cancellation.
inline SingularValues singular_values(const Columns<2>& m) noexcept {
    const double largest = largest_singular_value(m);
    return {largest, largest > 0 ? std::fabs(determinant(m)) / largest : 0};
}
inline SingularValues singular_values(const Columns<3>& m) noexcept {
    const double of_faces = largest_singular_value(cofactors(m)); // the product of the largest two
    return {largest_singular_value(m), of_faces > 0 ? std::fabs(determinant(m)) / of_faces : 0};
}

/// Stands for no root in (0, 1].
inline constexpr double no_root = 2;

/// Returns the least root of a + b t + c t² in (0, 1], for a > 0, or `no_root`.
inline double first_root(double a, double b, double c) noexcept {
    const double discriminant = b * b - 4 * a * c;
    if (discriminant < 0) return no_root;
    // Both terms have the same sign and do not cancel. The roots are q / c and a / q.
    const double q = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
    double least = no_root;
    const auto take = [&](double numerator, double denominator) {
        if (denominator == 0) return;
        const double root = numerator / denominator;
        if (root > 0 && root <= 1 && root < least) least = root;
    };
    take(q, c);
    take(a, q);
    return least;
}

/// det(A + t B) − threshold, a polynomial of degree D in t.
template <std::size_t D>
class DeterminantAlong {
public:
    /// `factor` scales the determinants.
    DeterminantAlong(const Columns<D>& a, const Columns<D>& b, double factor, double threshold) noexcept {
        const auto from_a = cofactors(a), from_b = cofactors(b);
        c_[0] = factor * determinant(a) - threshold;
        c_[D] = factor * determinant(b);
        double first = 0, second = 0;
        for (std::size_t k = 0; k < D; ++k) {
            first += dot(from_a[k], b[k]);
            second += dot(from_b[k], a[k]);
        }
        c_[1] = factor * first;
        if constexpr (D == 3) c_[2] = factor * second;
    }

    double operator()(double t) const noexcept {
        double value = c_[D];
        for (std::size_t k = D; k-- > 0;) value = value * t + c_[k];
        return value;
    }

    bool is_finite() const noexcept {
        for (const double c : c_) {
            if (!cageform::is_finite(c)) return false;
        }
        return true;
    }

    /// Returns the first t in [0, 1] where the value is not above 0, or `no_root`.
    double first_fold() const noexcept {
        if (!(c_[0] > 0)) return 0;
        if constexpr (D == 2) {
            return first_root(c_[0], c_[1], c_[2]);
        } else {
            // The value is monotone between its extrema.
            const double a = c_[1], b = 2 * c_[2], c = 3 * c_[3], discriminant = b * b - 4 * a * c;
            double places[] = {1, 1, 1};
            if (discriminant > 0) {
                const double q = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
                if (c != 0) places[0] = inside(q / c);
                if (q != 0) places[1] = inside(a / q);
                if (places[1] < places[0]) std::swap(places[0], places[1]);
            }
            double from = 0;
            for (const double to : places) {
                if (!((*this)(to) > 0)) return between(from, to);
                from = to;
            }
            return no_root;
        }
    }

private:
    /// Returns t if it is between 0 and 1, else 1.
    static double inside(double t) noexcept { return t > 0 && t < 1 ? t : 1; }

    /// Bisects between `above`, where the value is positive, and `below`, where it is not. Returns the last t
    /// with a positive value.
    double between(double above, double below) const noexcept {
        for (int n = 0; n < 200; ++n) {
            const double middle = above + (below - above) / 2;
            if (!(middle > above) || !(middle < below)) break;
            ((*this)(middle) > 0 ? above : below) = middle;
        }
        return above;
    }

    double c_[D + 1];
};

} // namespace cageform::inline CAGEFORM_ABI::detail
