// Scalar versions of the register functions, so that one template can use scalars or registers.
#pragma once

#include <cageform/core/detail/simd_angle.hpp>
#include <cageform/core/detail/simd_instructions.hpp>

#include <cmath>
#include <concepts>

namespace cageform::inline CAGEFORM_ABI::detail {

template <std::floating_point X>
X select(bool first, X a, X b) noexcept {
    return first ? a : b;
}
template <std::floating_point X>
X abs(X a) noexcept {
    return std::fabs(a);
}
template <std::floating_point X>
X(max)(X a, X b) noexcept {
    return a < b ? b : a;
}
template <std::floating_point X>
X(min)(X a, X b) noexcept {
    return a < b ? a : b;
}
template <std::floating_point X>
X sqrt(X a) noexcept {
    return std::sqrt(a);
}
/// Returns the angle of (x, y) in [0, π], for y ≥ 0.
template <std::floating_point X>
X angle(X y, X x) noexcept {
    return std::atan2(y, x);
}

inline bool both(bool a, bool b) noexcept {
    return a && b;
}
template <class Mask>
Mask both(const Mask& a, const Mask& b) noexcept {
    return a & b;
}

/// The scalar type of a scalar or of a register.
template <class X>
struct ScalarOfNumber {
    using type = X;
};
template <Scalar T>
struct ScalarOfNumber<Simd<T>> {
    using type = T;
};
template <class X>
using ScalarOf = typename ScalarOfNumber<X>::type;

} // namespace cageform::inline CAGEFORM_ABI::detail
