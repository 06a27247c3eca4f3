// On which side of a line a point lies, and whether segments meet: decided exactly.
#pragma once

#include <cageform/core/vec.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The sign of a sum of products x·y, without rounding: products and sums are split into a rounded
/// part and its error (Shewchuk, Adaptive precision floating-point arithmetic and fast robust
/// geometric predicates, Discrete Comput. Geom. 18 (1997), sec. 2: Two-Sum, Two-Product,
/// Grow-Expansion). For factors at most 1 and not below 1e-120, or zero.
template <std::size_t N>
int sign_of_products(const std::array<std::array<double, 2>, N>& factors) noexcept {
    std::array<double, 2 * N> parts{}; // without overlap, ascending; their exact sum is the result
    std::size_t count = 0;
    const auto add = [&](double x) {
        for (std::size_t i = 0; i < count; ++i) {
            const double sum = parts[i] + x, virtual_x = sum - parts[i];
            parts[i] = (parts[i] - (sum - virtual_x)) + (x - virtual_x);
            x = sum;
        }
        parts[count++] = x;
    };
    for (const auto& [x, y] : factors) {
        const double product = x * y;
        add(std::fma(x, y, -product));
        add(product);
    }
    while (count > 0 && parts[count - 1] == 0) --count;
    return count == 0 ? 0 : parts[count - 1] > 0 ? 1 : -1;
}

/// 1 where `c` lies to the left of the line from `a` to `b`, −1 to the right, 0 on it. Exact for
/// finite points whose coordinates, other than zero, differ by less than a factor of 1e120.
inline int orientation(const Vec<double, 2>& a, const Vec<double, 2>& b, const Vec<double, 2>& c) noexcept {
    const double left = (b[0] - a[0]) * (c[1] - a[1]), right = (b[1] - a[1]) * (c[0] - a[0]);
    // Shewchuk, sec. 4.3: what rounding may be. Products below 1e-290 lose more.
    const double bound = 4 * epsilon<double> * (std::fabs(left) + std::fabs(right));
    if (bound > 1e-290 && std::fabs(left - right) > bound && is_finite(bound)) return left > right ? 1 : -1;
    double largest = 0;
    for (const auto* p : {&a, &b, &c}) largest = std::max({largest, std::fabs((*p)[0]), std::fabs((*p)[1])});
    int exponent = 0;
    std::frexp(largest, &exponent);
    const auto scaled = [&](double x) { return std::ldexp(x, -exponent); };
    const double ax = scaled(a[0]), ay = scaled(a[1]), bx = scaled(b[0]), by = scaled(b[1]),
                 cx = scaled(c[0]), cy = scaled(c[1]);
    return sign_of_products<6>({{{ax, by}, {-ay, bx}, {bx, cy}, {-by, cx}, {cx, ay}, {-cy, ax}}});
}

/// Whether the segments ab and cd have a place in common, ends included. Exact as `orientation` is.
inline bool segments_touch(const Vec<double, 2>& a, const Vec<double, 2>& b, const Vec<double, 2>& c,
                           const Vec<double, 2>& d) noexcept {
    for (std::size_t k = 0; k < 2; ++k) {
        if (std::max(a[k], b[k]) < std::min(c[k], d[k]) || std::max(c[k], d[k]) < std::min(a[k], b[k]))
            return false;
    }
    return orientation(a, b, c) * orientation(a, b, d) <= 0 &&
           orientation(c, d, a) * orientation(c, d, b) <= 0;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
