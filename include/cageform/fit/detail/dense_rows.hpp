// Weights of points for all handles of a cage, and their derivatives.
#pragma once

#include <cageform/core/status.hpp>
#include <cageform/core/vec.hpp>

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Rows of one weight per handle.
struct DenseRows {
    std::size_t handles = 0;
    std::vector<double> weights; ///< #rows · #handles

    std::size_t size() const noexcept { return handles == 0 ? 0 : weights.size() / handles; }
    template <class F>
    void for_each(std::size_t row, const F& f) const {
        const double* const w = weights.data() + row * handles;
        for (std::size_t i = 0; i < handles; ++i) f(i, w[i]);
    }
    Vec<double, 3> product(std::size_t row, const std::vector<Vec<double, 3>>& p) const noexcept {
        Vec<double, 3> sum{};
        for_each(row, [&](std::size_t i, double w) { sum = sum + w * p[i]; });
        return sum;
    }
    void add(std::size_t row, const Vec<double, 3>& value, std::vector<Vec<double, 3>>& sums) const noexcept {
        for_each(row, [&](std::size_t i, double w) { sums[i] = sums[i] + w * value; });
    }
};

/// Fills one row of weights per point, or three rows of derivatives. Points without weights get zeros.
using EvaluateCage =
    std::function<Status(std::span<const Vec<double, 3>> points, bool derivatives, DenseRows& rows)>;

} // namespace cageform::inline CAGEFORM_ABI::detail
