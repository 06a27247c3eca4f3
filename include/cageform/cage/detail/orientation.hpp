// Exact predicates: orientation with respect to a line or plane, and intersection of segments.
#pragma once

#include <cageform/core/vec.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A sum of products without rounding. Splits products and sums into a rounded part and its error
/// (Shewchuk, Adaptive precision floating-point arithmetic and fast robust geometric predicates, Discrete
/// Comput. Geom. 18 (1997), sec. 2: Two-Sum, Two-Product, Grow-Expansion). Factors must be at most 1 and
/// either zero or at least 1e-120; in products of three factors, at least 1e-90.
template <std::size_t terms>
class ExactSum {
public:
    void add_product(double x, double y) noexcept {
        const double product = x * y;
        add(std::fma(x, y, -product));
        add(product);
    }
    void add_product(double x, double y, double z) noexcept {
        const double product = x * y;
        add_product(std::fma(x, y, -product), z);
        add_product(product, z);
    }
    int sign() const noexcept { return count_ == 0 ? 0 : components_[count_ - 1] > 0 ? 1 : -1; }

private:
    void add(double x) noexcept {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const double component = components_[i], sum = component + x, virtual_x = sum - component;
            const double error = (component - (sum - virtual_x)) + (x - virtual_x);
            if (error != 0) components_[kept++] = error;
            x = sum;
        }
        if (x != 0) components_[kept++] = x;
        count_ = kept;
    }

    std::array<double, terms> components_{}; ///< non-overlapping, ascending, non-zero; they sum to the result
    std::size_t count_ = 0;
};

/// Returns a power of two that scales the largest absolute coordinate to at most 1.
template <std::size_t D>
double unit_scale(std::initializer_list<const Vec<double, D>*> points) noexcept {
    double largest = 0;
    for (const auto* p : points) {
        for (std::size_t k = 0; k < D; ++k) largest = (std::max)(largest, std::fabs((*p)[k]));
    }
    int exponent = 0;
    std::frexp(largest, &exponent);
    return std::ldexp(1.0, -(std::max)(exponent, -1022));
}

/// Returns 1 if `c` is to the left of the line from `a` to `b`, −1 if to the right, 0 if on it. Exact for
/// finite points whose non-zero coordinates differ by less than a factor of 1e120.
inline int orientation(const Vec<double, 2>& a, const Vec<double, 2>& b, const Vec<double, 2>& c) noexcept {
    const double left = (b[0] - a[0]) * (c[1] - a[1]), right = (b[1] - a[1]) * (c[0] - a[0]);
    // The error bound of Shewchuk, sec. 4.3. Products below 1e-290 may have larger errors.
    const double bound = 4 * epsilon<double> * (std::fabs(left) + std::fabs(right));
    if (bound > 1e-290 && std::fabs(left - right) > bound && is_finite(bound)) return left > right ? 1 : -1;
    const double scale = unit_scale<2>({&a, &b, &c});
    const auto p = scale * a, q = scale * b, r = scale * c;
    ExactSum<12> sum;
    sum.add_product(p[0], q[1]);
    sum.add_product(-p[1], q[0]);
    sum.add_product(q[0], r[1]);
    sum.add_product(-q[1], r[0]);
    sum.add_product(r[0], p[1]);
    sum.add_product(-r[1], p[0]);
    return sum.sign();
}

/// Returns on which side of the plane through `a`, `b` and `c` the point `d` lies. The result is 1 on the
/// side from which `a`, `b` and `c` are counter-clockwise, −1 on the other side, and 0 in the plane. Exact
/// for finite points whose non-zero coordinates differ by less than a factor of 1e90.
inline int orientation(const Vec<double, 3>& a, const Vec<double, 3>& b, const Vec<double, 3>& c,
                       const Vec<double, 3>& d) noexcept {
    const auto u = b - a, v = c - a, w = d - a;
    double volume = 0, size = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
        const double left = v[l] * w[m], right = v[m] * w[l];
        volume += u[k] * (left - right);
        size += std::fabs(u[k]) * (std::fabs(left) + std::fabs(right));
    }
    const double bound = 4 * epsilon<double> * size; // as above
    if (bound > 1e-290 && std::fabs(volume) > bound && is_finite(bound)) return volume > 0 ? 1 : -1;
    const double scale = unit_scale<3>({&a, &b, &c, &d});
    const std::array<Vec<double, 3>, 4> p{scale * a, scale * b, scale * c, scale * d};
    ExactSum<96> sum; // of four determinants of three points each
    for (std::size_t n = 0; n < 4; ++n) {
        const auto &x = p[n == 0 ? 1 : 0], &y = p[n <= 1 ? 2 : 1], &z = p[n <= 2 ? 3 : 2];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
            const double sign = n % 2 == 0 ? 1 : -1;
            sum.add_product(sign * x[k], y[l], z[m]);
            sum.add_product(-sign * x[k], y[m], z[l]);
        }
    }
    return sum.sign();
}

/// Whether the segments ab and cd have a common point, ends included. Exact like `orientation`.
inline bool segments_touch(const Vec<double, 2>& a, const Vec<double, 2>& b, const Vec<double, 2>& c,
                           const Vec<double, 2>& d) noexcept {
    for (std::size_t k = 0; k < 2; ++k) {
        if ((std::max)(a[k], b[k]) < (std::min)(c[k], d[k]) ||
            (std::max)(c[k], d[k]) < (std::min)(a[k], b[k]))
            return false;
    }
    return orientation(a, b, c) * orientation(a, b, d) <= 0 &&
           orientation(c, d, a) * orientation(c, d, b) <= 0;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
