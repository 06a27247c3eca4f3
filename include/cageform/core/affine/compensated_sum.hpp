// Sums of thousands of weights.
#pragma once

#include <cageform/core/affine/dual.hpp>

#include <algorithm>
#include <array>
#include <cstddef>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The sums of what add(i, sums) adds to each of K numbers for i = 0 … count − 1. Thousands of small
/// numbers, added one by one to a large one, may all be rounded the same way; so they are added up
/// in runs, and the runs with compensation (Kahan, Further remarks on reducing truncation errors,
/// Comm. ACM 8, 1965): the error is that of a run, however many there are.
template <class N, std::size_t K, class Add>
std::array<N, K> compensated_sums(std::size_t count, const Add& add) noexcept {
    constexpr std::size_t run = 64;
    std::array<N, K> sums, excess; // what the sums are too large by
    for (std::size_t k = 0; k < K; ++k) sums[k] = excess[k] = N(ValueOf<N>(0));
    for (std::size_t begin = 0; begin < count; begin += run) {
        std::array<N, K> part;
        for (std::size_t k = 0; k < K; ++k) part[k] = -excess[k];
        for (std::size_t i = begin; i < (std::min)(begin + run, count); ++i) add(i, part);
        for (std::size_t k = 0; k < K; ++k) {
            const N next = sums[k] + part[k];
            excess[k] = (next - sums[k]) - part[k];
            sums[k] = next;
        }
    }
    for (std::size_t k = 0; k < K; ++k) sums[k] = sums[k] - excess[k];
    return sums;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
