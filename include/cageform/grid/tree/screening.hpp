// Functions of the screened Laplace equation Δu = κ²u, which decay over a length of 1/κ.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/core/vec.hpp>

#include <cstddef>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the factor that turns a harmonic polynomial, homogeneous of a degree n, into a solution of the
/// screened equation: Γ(ν + 1) (2/x)^ν I_ν(x) with ν = n + D/2 − 1 and x = κr, a power series in x².
///
///   square  (κr)², at most a few units
template <std::size_t D>
double screened_factor(unsigned degree, double square) noexcept {
    constexpr double least = 1e-17;
    double sum = 1, term = 1;
    for (double m = 1, order = degree + 0.5 * double(D); term > least * sum; ++m, ++order) {
        term *= 0.25 * square / (m * order);
        sum += term;
    }
    return sum;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
