// Inputs and outputs of the formulas of Green coordinates.
#pragma once

#include <cageform/coordinates/mean_value/frame.hpp>
#include <cageform/core/detail/simd_angle.hpp>
#include <cageform/core/detail/simd_log.hpp>
#include <cageform/core/types/buffer.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The tables of a cage.
template <class S, std::size_t D>
struct GreenFrame;

/// Working memory of the formula.
template <class S, std::size_t D>
struct GreenRows;

/// `winding` is the fraction of the full angle that the cage subtends at the point: 1 inside, 0 outside,
/// without facets that contain the point. `touched` is 1 for points on a facet, else 0.
template <class S>
struct GreenSum {
    Simd<S> winding, touched;
};

/// The lower limit of arguments of logarithms. Each logarithm of a length is multiplied by the length, so the
/// product tends to zero.
template <class S>
inline constexpr S least_square = (std::numeric_limits<S>::min)() * S(1e6);

template <class S>
void add(const Simd<S>& x, Lanes<S>& row) noexcept {
    (Simd<S>::load(row) + x).store(row);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
