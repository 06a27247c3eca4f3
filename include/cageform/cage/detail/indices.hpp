// Sequences of indices, and sorted sets.
#pragma once

#include <cageform/config.hpp>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns 0, …, count − 1.
template <class Index>
std::vector<Index> first_indices(std::size_t count) {
    std::vector<Index> indices(count);
    std::iota(indices.begin(), indices.end(), Index{0});
    return indices;
}

/// Sorts elements and removes duplicates.
template <class T>
void sort_unique(std::vector<T>& elements) {
    std::sort(elements.begin(), elements.end());
    elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
}

} // namespace cageform::inline CAGEFORM_ABI::detail
