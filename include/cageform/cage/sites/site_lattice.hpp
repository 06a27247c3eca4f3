// Points with integer coordinates, and the exact predicates of a Delaunay triangulation.
#pragma once

#include <cageform/cage/detail/primitives.hpp>
#include <cageform/cage/sites/wide_int.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A point on a lattice of step 2^-60 extents. An *extent* is the unit of length: the smallest power of two
/// above the longest side of the sites' bounds. Differences need 61 bits and a sign.
template <std::size_t D>
using LatticePoint = std::array<std::int64_t, D>;

/// Converts a point to double, with a relative rounding error below 2^-53.
template <std::size_t D>
Vec<double, D> to_double(const LatticePoint<D>& a) noexcept {
    Vec<double, D> r{};
    for (std::size_t k = 0; k < D; ++k) r[k] = double(a[k]);
    return r;
}
template <std::size_t D>
LatticePoint<D> difference(LatticePoint<D> a, const LatticePoint<D>& b) noexcept {
    for (std::size_t k = 0; k < D; ++k) a[k] -= b[k];
    return a;
}

/// Converts between points of the caller and lattice points. The rounding error of a double within the
/// bounds is below 2^-60 extents, for any distance from the origin.
template <std::size_t D>
class SiteLattice {
public:
    SiteLattice() = default;
    explicit SiteLattice(const Bounds<double, D>& bounds) noexcept
        : lower_(bounds.lower) {
        int largest = (std::numeric_limits<int>::min)();
        for (std::size_t k = 0; k < D; ++k) {
            int exponent = 0;
            // Halved so that no difference overflows.
            std::frexp(bounds.upper[k] / 2 - bounds.lower[k] / 2, &exponent);
            if (bounds.upper[k] > bounds.lower[k]) largest = (std::max)(largest, exponent + 1);
        }
        exponent_ = 60 - largest;
        for (std::size_t k = 0; k < D; ++k) origin_[k] = fixed(lower_[k]);
    }

    /// Returns the lattice point of `p`, whose distance from the bounds must be at most their length.
    LatticePoint<D> position(const Vec<double, D>& p) const noexcept {
        LatticePoint<D> result;
        for (std::size_t k = 0; k < D; ++k) result[k] = std::int64_t(fixed(p[k]) - origin_[k]);
        return result;
    }
    /// Converts a length to extents; the longest side of the bounds is at least 1/2 and less than 1.
    double extents(double length) const noexcept { return std::ldexp(length, exponent_ - 60); }
    double units(double extents) const noexcept { return std::ldexp(extents, 60 - exponent_); }
    /// Returns a point relative to the lower bounds, in extents. Coordinates beyond 2^400 extents are
    /// clamped.
    Vec<double, D> to_extents(const Vec<double, D>& p) const noexcept {
        Vec<double, D> r{};
        for (std::size_t k = 0; k < D; ++k) {
            int exponent = 0;
            std::frexp(p[k], &exponent);
            r[k] = exponent + exponent_ > 460 ? std::copysign(0x1p400, p[k])
                                              : extents(p[k]) - extents(lower_[k]);
        }
        return r;
    }
    Vec<double, D> to_extents(const LatticePoint<D>& p) const noexcept { return 0x1p-60 * to_double<D>(p); }
    /// Converts a point in extents back to the units of the caller.
    Vec<double, D> from_extents(const Vec<double, D>& q) const noexcept {
        Vec<double, D> r{};
        for (std::size_t k = 0; k < D; ++k) r[k] = lower_[k] + units(q[k]);
        return r;
    }

private:
    /// Returns the lowest 64 bits of x 2^exponent, rounded. Differences within the bounds fit into 64 bits.
    std::uint64_t fixed(double x) const noexcept {
        const auto bits = std::bit_cast<std::uint64_t>(x);
        const auto raw = int((bits >> 52) & 0x7ff);
        const std::uint64_t fraction = bits & 0xfffffffffffffu;
        const std::uint64_t mantissa = raw == 0 ? fraction : fraction | (std::uint64_t(1) << 52);
        const int shift = (std::max)(raw, 1) - 1075 + exponent_;
        std::uint64_t value = 0;
        if (shift >= 0) {
            value = shift < 64 ? mantissa << shift : 0;
        } else if (shift > -64) {
            value = ((mantissa >> (-shift - 1)) + 1) >> 1;
        }
        return (bits >> 63) != 0 ? ~value + 1 : value;
    }

    Vec<double, D> lower_{};
    std::array<std::uint64_t, D> origin_{};
    int exponent_ = 0;
};

// ---- determinants -------------------------------------------------------------------------------

template <class X, std::size_t N>
using Square = std::array<std::array<X, N>, N>;

/// Returns the determinant by cofactor expansion along the last column. `permanent` sums the absolute
/// values of its terms.
template <class X>
X determinant(const Square<X, 2>& m) noexcept {
    return m[0][0] * m[1][1] - m[0][1] * m[1][0];
}
template <class X, std::size_t N>
X determinant(const Square<X, N>& m) noexcept {
    X sum(0);
    for (std::size_t i = 0; i < N; ++i) {
        Square<X, N - 1> minor;
        for (std::size_t r = 0; r + 1 < N; ++r)
            std::copy_n(m[r < i ? r : r + 1].begin(), N - 1, minor[r].begin());
        const X term = determinant(minor) * m[i][N - 1];
        sum = (i + N) % 2 == 1 ? sum + term : sum - term;
    }
    return sum;
}
inline double permanent(const Square<double, 2>& m) noexcept {
    return std::fabs(m[0][0] * m[1][1]) + std::fabs(m[0][1] * m[1][0]);
}
template <std::size_t N>
double permanent(const Square<double, N>& m) noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < N; ++i) {
        Square<double, N - 1> minor;
        for (std::size_t r = 0; r + 1 < N; ++r)
            std::copy_n(m[r < i ? r : r + 1].begin(), N - 1, minor[r].begin());
        sum += permanent(minor) * std::fabs(m[i][N - 1]);
    }
    return sum;
}

/// Bounds the rounding error of a determinant in double, relative to the sum of its terms' absolute values.
/// There are 24 terms of at most five rounded factors and three sums of squares. In any order of summation,
/// as with -ffast-math, the error is far below 2^6 roundings of 2^-53.
inline constexpr double determinant_error = 0x1p-47;

/// Returns the sign of the determinant if it is certain in double, else 2.
template <std::size_t N>
int certain_sign(const Square<double, N>& m) noexcept {
    const double value = determinant(m);
    const double error = determinant_error * permanent(m);
    if (value > error) return 1;
    if (value < -error) return -1;
    return 2;
}

template <class X, std::size_t D>
Square<X, D> edge_rows(const std::array<LatticePoint<D>, D + 1>& a) noexcept {
    Square<X, D> rows;
    for (std::size_t i = 0; i < D; ++i) {
        for (std::size_t k = 0; k < D; ++k) rows[i][k] = X(a[i + 1][k] - a[0][k]);
    }
    return rows;
}
/// Returns the rows (a_i − q, |a_i − q|²).
template <class X, std::size_t D>
Square<X, D + 1> lifted_rows(const std::array<LatticePoint<D>, D + 1>& a, const LatticePoint<D>& q) noexcept {
    Square<X, D + 1> rows;
    for (std::size_t i = 0; i <= D; ++i) {
        rows[i][D] = X(0);
        for (std::size_t k = 0; k < D; ++k) {
            rows[i][k] = X(a[i][k] - q[k]);
            rows[i][D] = rows[i][D] + rows[i][k] * rows[i][k];
        }
    }
    return rows;
}

/// Returns the sign of det(a_1 − a_0, …), in 2D positive for counter-clockwise triangles. Exact.
template <std::size_t D>
int orientation(const std::array<LatticePoint<D>, D + 1>& a) noexcept {
    const int sign = certain_sign<D>(edge_rows<double, D>(a));
    return sign != 2 ? sign : determinant(edge_rows<WideInt, D>(a)).sign();
}

/// The corners of a simplex relative to a point, to test the point against several facets.
template <std::size_t D>
class RelativeCorners {
public:
    RelativeCorners(const std::array<LatticePoint<D>, D + 1>& corners, const LatticePoint<D>& p) noexcept
        : corners_(corners)
        , point_(p) {
        for (std::size_t i = 0; i <= D; ++i) {
            for (std::size_t k = 0; k < D; ++k) relative_[i][k] = double(corners[i][k] - p[k]);
        }
    }
    /// Returns the orientation of the simplex with corner k replaced by the point. Exact.
    int side(std::size_t k) const noexcept {
        Square<double, D> rows;
        for (std::size_t n = 0; n < D; ++n) rows[n] = relative_[n < k ? n : n + 1];
        const int sign = certain_sign<D>(rows);
        if (sign != 2) return k % 2 == 0 ? sign : -sign;
        auto a = corners_;
        a[k] = point_;
        return determinant(edge_rows<WideInt, D>(a)).sign();
    }

private:
    std::array<LatticePoint<D>, D + 1> corners_;
    LatticePoint<D> point_;
    std::array<std::array<double, D>, D + 1> relative_;
};

/// Returns a positive number if `q` lies strictly inside the circumscribed ball of a positively
/// oriented simplex, zero if on its sphere. Exact.
template <std::size_t D>
int in_sphere(const std::array<LatticePoint<D>, D + 1>& a, const LatticePoint<D>& q) noexcept {
    int sign = certain_sign<D + 1>(lifted_rows<double, D>(a, q));
    if (sign == 2) sign = determinant(lifted_rows<WideInt, D>(a, q)).sign();
    return D == 2 ? sign : -sign;
}

// ---- circumcentres ------------------------------------------------------------------------------

/// A circumcentre relative to the first corner: numerator / (2 determinant).
template <class X, std::size_t D>
struct CentreQuotient {
    std::array<X, D> numerator;
    X determinant;
};

/// Solves 2 e_i·c = |e_i|² by Cramer's rule.
template <class X, std::size_t D>
CentreQuotient<X, D> centre_quotient(const Square<X, D>& edges) noexcept {
    CentreQuotient<X, D> q;
    q.determinant = determinant(edges);
    for (std::size_t k = 0; k < D; ++k) {
        Square<X, D> m = edges;
        for (std::size_t i = 0; i < D; ++i) {
            X square(0);
            for (std::size_t l = 0; l < D; ++l) square = square + edges[i][l] * edges[i][l];
            m[i][k] = square;
        }
        q.numerator[k] = determinant(m);
    }
    return q;
}

/// A CentreQuotient in double, computed with the edges' cofactors. Also has the sums of the absolute values
/// of all terms.
template <std::size_t D>
struct SizedCentreQuotient : CentreQuotient<double, D> {
    std::array<double, D> numerator_size{};
    double determinant_size = 0;

    explicit SizedCentreQuotient(const Square<double, D>& edges) noexcept
        : CentreQuotient<double, D>{} {
        for (std::size_t i = 0; i < D; ++i) {
            const auto& e = edges[i];
            double square = 0;
            for (const double x : e) square += x * x;
            for (std::size_t k = 0; k < D; ++k) {
                const auto [plus, minus] = cofactor(edges, i, k);
                const double size = std::fabs(plus) + std::fabs(minus);
                this->numerator[k] += square * (plus - minus);
                numerator_size[k] += square * size;
                if (i != 0) continue;
                this->determinant += e[k] * (plus - minus);
                determinant_size += std::fabs(e[k]) * size;
            }
        }
    }

private:
    /// Returns the cofactor of element k of edge i as the two numbers whose difference it is.
    static std::array<double, 2> cofactor(const Square<double, D>& e, std::size_t i, std::size_t k) noexcept {
        if constexpr (D == 2) {
            const double x = e[1 - i][1 - k];
            return i == k ? std::array<double, 2>{x, 0} : std::array<double, 2>{0, x};
        } else {
            const auto &a = e[(i + 1) % 3], &b = e[(i + 2) % 3];
            const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
            return {a[l] * b[m], a[m] * b[l]};
        }
    }
};

/// A circumcentre with an error bound for its components.
template <std::size_t D>
struct Centre {
    Vec<double, D> at;
    double error;
};

/// Evaluates `in_sphere` from the circumcentre c relative to the first corner, as the sign of 2 q·c − |q|²;
/// 0 if uncertain.
template <std::size_t D>
int certain_in_sphere(const LatticePoint<D>& first, const Centre<D>& centre,
                      const LatticePoint<D>& p) noexcept {
    double value = 0, size = 0, reach = 0;
    for (std::size_t k = 0; k < D; ++k) {
        const double q = double(p[k] - first[k]), diameter = 2 * centre.at[k];
        value += q * (diameter - q);
        size += std::fabs(q) * (std::fabs(diameter) + std::fabs(q));
        reach += std::fabs(q);
    }
    const double error = determinant_error * size + 2 * centre.error * reach;
    return value > error ? 1 : value < -error ? -1 : 0;
}

/// Returns the circumcentre relative to the first corner, computed in integers, with a relative error of
/// 2^-50.
template <std::size_t D>
Centre<D> exact_centre(const std::array<LatticePoint<D>, D + 1>& a) noexcept {
    const auto q = centre_quotient<WideInt, D>(edge_rows<WideInt, D>(a));
    const double bottom = 2 * double(WideFloat(q.determinant));
    Centre<D> c{};
    for (std::size_t k = 0; k < D; ++k) {
        c.at[k] = double(WideFloat(q.numerator[k])) / bottom;
        c.error = std::fmax(c.error, 0x1p-50 * std::fabs(c.at[k]));
    }
    return c;
}
/// Computes the circumcentre from edges in double; returns false if its error may exceed 2^-42 of its
/// largest component.
template <std::size_t D>
bool find_centre(const Square<double, D>& edges, Centre<D>& c) noexcept {
    const SizedCentreQuotient<D> q(edges);
    const double size = std::fabs(q.determinant), error = 0x1p-49 * q.determinant_size;
    if (!(error < 0x1p-42 * size)) return false;
    c = {};
    const double scale = 0.5 / q.determinant;
    double largest = 0;
    for (std::size_t k = 0; k < D; ++k) {
        c.at[k] = q.numerator[k] * scale;
        largest = (std::max)(largest, std::fabs(c.at[k]));
        c.error = (std::max)(c.error, q.numerator_size[k]);
    }
    c.error = (0x1p-49 * c.error + 2 * largest * error) * std::fabs(scale);
    return c.error <= 0x1p-42 * largest;
}
template <std::size_t D>
Centre<D> circumcentre(const std::array<LatticePoint<D>, D + 1>& a) noexcept {
    Centre<D> c{};
    return find_centre<D>(edge_rows<double, D>(a), c) ? c : exact_centre<D>(a);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
