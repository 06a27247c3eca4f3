// Sums of thousands of weights.
#pragma once

#include <cageform/config.hpp>

#include <algorithm>
#include <array>
#include <cstddef>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Adds to each number of `start` those that add(i, sum) adds for i = 0 … count − 1. Thousands of
/// small numbers, added one by one to a large one, may all be rounded the same way; so they are
/// added up in runs, and the runs with compensation (Kahan, Further remarks on reducing truncation
/// errors, Comm. ACM 8, 1965): the error is that of a run, however many there are.
template <class N, std::size_t K, class Add>
std::array<N, K> compensated_sum(const std::array<N, K>& start, std::size_t count, const Add& add) noexcept {
    constexpr std::size_t run = 64;
    std::array<N, K> sum = start, excess; // what the sum is too large by
    if (count <= run) {
        for (std::size_t i = 0; i < count; ++i) add(i, sum);
        return sum;
    }
    for (std::size_t k = 0; k < K; ++k) excess[k] = sum[k] - sum[k];
    for (std::size_t begin = 0; begin < count; begin += run) {
        std::array<N, K> part;
        for (std::size_t k = 0; k < K; ++k) part[k] = -excess[k];
        for (std::size_t i = begin; i < std::min(begin + run, count); ++i) add(i, part);
        for (std::size_t k = 0; k < K; ++k) {
            const N next = sum[k] + part[k];
            excess[k] = (next - sum[k]) - part[k];
            sum[k] = next;
        }
    }
    for (std::size_t k = 0; k < K; ++k) sum[k] = sum[k] - excess[k];
    return sum;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
