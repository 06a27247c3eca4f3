// Forward-mode automatic differentiation.
#pragma once

#include <cageform/core/detail/number.hpp>
#include <cageform/core/detail/simd_exp.hpp>
#include <cageform/core/detail/simd_log.hpp>
#include <cageform/core/vec.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A value that depends on `D` variables, and its gradient. `U` is a scalar or a register. To
/// differentiate a formula that is templated on its number type, call it with this type.
template <class U, std::size_t D>
struct Dual {
    U value{};
    Vec<U, D> gradient{};

    constexpr Dual() noexcept = default;
    constexpr Dual(U x) noexcept // NOLINT(google-explicit-constructor): constants in formulas
        : value(x) {}
    constexpr Dual(U x, const Vec<U, D>& slope) noexcept
        : value(x)
        , gradient(slope) {}

    friend constexpr Dual operator+(const Dual& a, const Dual& b) noexcept {
        return {a.value + b.value, slope([&](std::size_t k) { return a.gradient[k] + b.gradient[k]; })};
    }
    friend constexpr Dual operator-(const Dual& a, const Dual& b) noexcept {
        return {a.value - b.value, slope([&](std::size_t k) { return a.gradient[k] - b.gradient[k]; })};
    }
    friend constexpr Dual operator-(const Dual& a) noexcept { return U(-1) * a; }
    friend constexpr Dual operator*(const Dual& a, const Dual& b) noexcept {
        return {a.value * b.value,
                slope([&](std::size_t k) { return a.value * b.gradient[k] + b.value * a.gradient[k]; })};
    }
    friend constexpr Dual operator*(const U& a, const Dual& b) noexcept {
        return {a * b.value, slope([&](std::size_t k) { return a * b.gradient[k]; })};
    }
    friend constexpr Dual operator/(const Dual& a, const Dual& b) noexcept {
        const U inverse = U(1) / b.value, quotient = a.value * inverse;
        return {quotient,
                slope([&](std::size_t k) { return inverse * (a.gradient[k] - quotient * b.gradient[k]); })};
    }
    friend constexpr Dual operator/(const U& a, const Dual& b) noexcept {
        const U inverse = U(1) / b.value, quotient = a * inverse, factor = -(quotient * inverse);
        return {quotient, slope([&](std::size_t k) { return factor * b.gradient[k]; })};
    }
    Dual& operator+=(const Dual& b) noexcept { return *this = *this + b; }

    friend constexpr auto operator<(const Dual& a, const Dual& b) noexcept { return a.value < b.value; }

    template <class Mask>
    friend constexpr Dual select(const Mask& first, const Dual& a, const Dual& b) noexcept {
        return {detail::select(first, a.value, b.value),
                slope([&](std::size_t k) { return detail::select(first, a.gradient[k], b.gradient[k]); })};
    }
    friend Dual abs(const Dual& a) noexcept { return select(a.value < U(0), -a, a); }
    /// Not differentiable at zero.
    friend Dual sqrt(const Dual& a) noexcept {
        const U root = detail::sqrt(a.value);
        return {root, (U(0.5) / root) * a.gradient};
    }
    friend Dual atan(const Dual& a) noexcept {
        return {std::atan(a.value), (1 / (1 + a.value * a.value)) * a.gradient};
    }
    friend Dual exp(const Dual& a) noexcept {
        const U power = detail::exp(a.value);
        return {power, power * a.gradient};
    }
    friend Dual log(const Dual& a) noexcept { return {detail::log(a.value), (U(1) / a.value) * a.gradient}; }
    /// For y ≥ 0; not differentiable at (0, 0).
    friend Dual angle(const Dual& y, const Dual& x) noexcept {
        const U inverse = U(1) / (x.value * x.value + y.value * y.value);
        return {detail::angle(y.value, x.value), slope([&](std::size_t k) {
                    return inverse * (x.value * y.gradient[k] - y.value * x.gradient[k]);
                })};
    }

private:
    /// Returns one derivative per variable. Without a loop, so that registers are not spilled.
    template <class F>
    static constexpr Vec<U, D> slope(const F& f) noexcept {
        if constexpr (D == 2)
            return {f(0), f(1)};
        else
            return {f(0), f(1), f(2)};
    }
};

/// Describes the number type N of a formula: the type of its value and the number of its derivatives.
/// Component 0 is the value; the derivatives follow.
template <class N>
struct NumberTraits {
    using Value = N;
    static constexpr std::size_t derivatives = 0;
    // NOLINTNEXTLINE(bugprone-return-const-ref-from-parameter): callers use it only while `n` exists
    static const Value& component(const N& n, std::size_t) noexcept { return n; }
    static Value& component(N& n, std::size_t) noexcept { return n; }
};
template <class U, std::size_t D>
struct NumberTraits<Dual<U, D>> {
    using Value = U;
    static constexpr std::size_t derivatives = D;
    static const U& component(const Dual<U, D>& n, std::size_t k) noexcept {
        return k == 0 ? n.value : n.gradient[k - 1];
    }
    static U& component(Dual<U, D>& n, std::size_t k) noexcept {
        return k == 0 ? n.value : n.gradient[k - 1];
    }
};

template <class N>
using ValueOf = typename NumberTraits<N>::Value;
template <class N>
inline constexpr bool has_gradient = NumberTraits<N>::derivatives > 0;

template <class N>
const ValueOf<N>& value_of(const N& n) noexcept {
    return NumberTraits<N>::component(n, 0);
}

/// Returns the second argument if N carries a gradient, else the first.
template <class N, class A, class B>
constexpr const auto& for_number([[maybe_unused]] const A& of_values,
                                 [[maybe_unused]] const B& of_gradients) noexcept {
    if constexpr (has_gradient<N>)
        return of_gradients;
    else
        return of_values;
}

/// Makes a number from a value and its gradient. Discards the gradient if N has none.
template <class N, std::size_t D>
N with_gradient(const ValueOf<N>& value, [[maybe_unused]] const Vec<ValueOf<N>, D>& gradient) noexcept {
    if constexpr (has_gradient<N>)
        return {value, gradient};
    else
        return value;
}

/// Calls set(row, value) for the weight of handle `i`; or, if N has a gradient, for each derivative of
/// the weight times `scale`.
template <class N, class S, class Set>
void for_each_component(const N& weight, std::size_t i, [[maybe_unused]] std::size_t handles,
                        [[maybe_unused]] S scale, const Set& set) {
    if constexpr (has_gradient<N>) {
        for (std::size_t k = 0; k < NumberTraits<N>::derivatives; ++k)
            set(k * handles + i, ValueOf<N>(scale) * weight.gradient[k]);
    } else {
        set(i, weight);
    }
}

/// Writes the weights of all handles, or their derivatives, to one lane of `rows`, each times `inverse`, and
/// derivatives times `scale`. Returns whether all are finite.
template <class N, class S, class Row>
bool store_weights(std::span<const N> weights, const N& inverse, S scale, Row* rows,
                   std::size_t lane) noexcept {
    bool finite = true;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        for_each_component(weights[i] * inverse, i, weights.size(), scale, [&](std::size_t row, S x) {
            auto& to = rows[row][lane];
            to = static_cast<std::remove_reference_t<decltype(to)>>(x);
            finite = finite && is_finite(to);
        });
    }
    return finite;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
