// Compensated summation of thousands of weights.
#pragma once

#include <cageform/core/affine/dual.hpp>

#include <array>
#include <cstddef>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns K sums: calls add(i, sums) for i = 0 … count − 1, which adds the terms of i. Sums runs of 64
/// terms, then adds the runs with compensation. The error is that of one run, whatever the count.
/// (Kahan, Further remarks on reducing truncation errors, Comm. ACM 8, 1965.)
template <class N, std::size_t K, class Add>
std::array<N, K> compensated_sums(std::size_t count, const Add& add) noexcept {
    constexpr std::size_t run = 64;
    std::array<N, K> sums, excess; // excess: by how much the sums are too large
    for (std::size_t k = 0; k < K; ++k) sums[k] = excess[k] = N(ValueOf<N>(0));
    for (std::size_t begin = 0; begin < count; begin += run) {
        std::array<N, K> partial;
        for (std::size_t k = 0; k < K; ++k) partial[k] = -excess[k];
        const std::size_t end = count - begin < run ? count : begin + run;
        for (std::size_t i = begin; i < end; ++i) add(i, partial);
        for (std::size_t k = 0; k < K; ++k) {
            const N next = sums[k] + partial[k];
            excess[k] = (next - sums[k]) - partial[k];
            sums[k] = next;
        }
    }
    for (std::size_t k = 0; k < K; ++k) sums[k] = sums[k] - excess[k];
    return sums;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
