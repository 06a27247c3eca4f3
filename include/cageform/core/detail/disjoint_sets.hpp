// Disjoint sets (union-find).
#pragma once

#include <cageform/config.hpp>

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A partition of the numbers 0, …, n − 1, at first into singletons: a union-find forest with path
/// halving. O(log n) amortised per operation.
class DisjointSets {
public:
    explicit DisjointSets(std::size_t count)
        : parent_(count) {
        std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
    }

    /// Returns the smallest member of a number's set.
    std::uint32_t find(std::uint32_t n) noexcept {
        while (parent_[n] != n) n = parent_[n] = parent_[parent_[n]];
        return n;
    }
    /// Joins the sets of two numbers. Returns false if they were already in the same set.
    bool join(std::uint32_t a, std::uint32_t b) noexcept {
        a = find(a);
        b = find(b);
        parent_[a < b ? b : a] = a < b ? a : b;
        return a != b;
    }

private:
    std::vector<std::uint32_t> parent_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
