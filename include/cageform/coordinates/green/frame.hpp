// What the formulas of Green coordinates in the plane and in space are given, and what they return.
#pragma once

#include <cageform/coordinates/mean_value/frame.hpp>
#include <cageform/core/detail/buffer.hpp>
#include <cageform/core/detail/simd_angle.hpp>
#include <cageform/core/detail/simd_log.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A cage in the numbers that the formula takes.
template <class S, std::size_t D>
struct GreenFrame;

/// Memory for the formula.
template <class S, std::size_t D>
struct GreenRows;

/// How much of the full angle the cage is seen under, 1 inside and 0 outside, the facets that the
/// point lies on left out; and one in the lanes of points that lie on a facet, zero in the others.
template <class S>
struct GreenSum {
    Simd<S> winding, touched;
};

/// What arguments of logarithms are kept above. The logarithm of a length goes with a length, so
/// its limit is zero.
template <class S>
inline constexpr S least_square = (std::numeric_limits<S>::min)() * S(1e6);

template <class S>
void add(const Simd<S>& x, Lanes<S>& row) noexcept {
    (Simd<S>::load(row) + x).store(row);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
