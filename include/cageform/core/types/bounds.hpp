// Axis-aligned bounds, and the tolerances derived from them.
#pragma once

#include <cageform/core/vec.hpp>

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// The axis-aligned bounds of points; empty (lower above upper) for no points.
template <Scalar T, std::size_t D>
struct Bounds {
    Vec<T, D> lower;
    Vec<T, D> upper;

    /// Computed in double, so that no float overflows or underflows.
    T diagonal() const noexcept {
        const auto d = vec_cast<double>(upper - lower);
        return static_cast<T>(std::sqrt(dot(d, d)));
    }
    /// Returns the largest absolute coordinate; the rounding of coordinates is relative to it.
    T magnitude() const noexcept {
        T m = 0;
        for (std::size_t k = 0; k < D; ++k)
            m = std::fmax(m, std::fmax(std::fabs(lower[k]), std::fabs(upper[k])));
        return m;
    }
    Bounds widened(T margin) const noexcept {
        Bounds b = *this;
        for (std::size_t k = 0; k < D; ++k) {
            b.lower[k] -= margin;
            b.upper[k] += margin;
        }
        return b;
    }
    /// Extends the bounds so that they cover `b`.
    void include(const Bounds& b) noexcept {
        for (std::size_t k = 0; k < D; ++k) {
            if (b.lower[k] < lower[k]) lower[k] = b.lower[k];
            if (upper[k] < b.upper[k]) upper[k] = b.upper[k];
        }
    }
    bool covers(const Bounds& b) const noexcept {
        for (std::size_t k = 0; k < D; ++k) {
            if (b.lower[k] < lower[k] || upper[k] < b.upper[k]) return false;
        }
        return true;
    }
    bool overlaps(const Bounds& b) const noexcept {
        for (std::size_t k = 0; k < D; ++k) {
            if (b.upper[k] < lower[k] || upper[k] < b.lower[k]) return false;
        }
        return true;
    }
};

template <Scalar T, std::size_t D>
Bounds<T, D> bounds_of(std::span<const Vec<T, D>> points) noexcept {
    Bounds<T, D> b;
    for (std::size_t k = 0; k < D; ++k) {
        b.lower[k] = (std::numeric_limits<T>::max)();
        b.upper[k] = std::numeric_limits<T>::lowest();
        for (const auto& p : points) {
            b.lower[k] = std::fmin(b.lower[k], p[k]);
            b.upper[k] = std::fmax(b.upper[k], p[k]);
        }
    }
    return b;
}

/// Returns the distance below which two points of a cage coincide, in the cage's units: 8 epsilon times
/// the larger of the diagonal and the largest absolute coordinate. A point this close to a vertex or an
/// edge lies on it.
template <Scalar T, std::size_t D>
T coincidence_tolerance(const Bounds<T, D>& bounds) noexcept {
    return 8 * epsilon<T> * std::fmax(bounds.diagonal(), bounds.magnitude());
}

/// Returns a power of two that scales the diagonal to at most 1; scaling by it is exact.
template <Scalar T, std::size_t D>
T unit_scale(const Bounds<T, D>& bounds) noexcept {
    int exponent = 0;
    std::frexp(bounds.diagonal(), &exponent);
    return std::ldexp(T(1), -exponent);
}

} // namespace cageform::inline CAGEFORM_ABI
