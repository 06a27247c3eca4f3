// Tests whether weights exceed rounding errors.
#pragma once

#include <cageform/core/affine/compensated_sum.hpp>
#include <cageform/core/affine/orthonormal_rows.hpp>
#include <cageform/core/types/buffer.hpp>

#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Far outside thin cages, unnormalised weights are small differences of large numbers. Weights that lost
/// their digits violate Σ w_i (C_i − p) = 0. This class tests that equation. Lengths in each direction are
/// relative to the cage's extent in that direction.
template <class S, std::size_t D>
class MomentTest {
public:
    MomentTest() = default;
    template <class Number>
    explicit MomentTest(const Buffer<Vec<Number, D>>& vertices) {
        Buffer<Vec<double, D + 1>> rows;
        for (const auto& v : vertices) {
            auto& row = rows.push_back(Vec<double, D + 1>{1});
            for (std::size_t k = 0; k < D; ++k) row[k + 1] = double(v[k]);
        }
        const double deviation = std::sqrt(double(rows.size())); // scales the rows of Q to size 1
        const OrthonormalRows<D + 1> basis(std::move(rows));
        for (std::size_t i = 0; i < vertices.size(); ++i) {
            auto& position = positions_.push_back();
            for (std::size_t k = 0; k < D; ++k) position[k] = static_cast<S>(deviation * basis[i][k + 1]);
        }
        for (std::size_t k = 0; k <= D; ++k) {
            for (std::size_t j = 0; j < k; ++j)
                triangle_[k][j] = static_cast<S>(basis.triangle()[k][j] / deviation);
            triangle_[k][k] = static_cast<S>(basis.triangle()[k][k] * deviation);
        }
    }

    /// Returns 1 in lanes whose weights lost more than half of their digits, else 0.
    template <class N, class X = ValueOf<N>>
    X failed(const Vec<X, D>& p, const std::vector<N>& weights, const X& sum) const noexcept {
        const X zero(S(0)), one(S(1));
        const auto moments = compensated_sums<X, D>(weights.size(), [&](std::size_t i, auto& total) {
            for (std::size_t k = 0; k < D; ++k) total[k] += value_of(weights[i]) * X(positions_[i][k]);
        });
        std::array<X, D + 1> row{one};
        for (std::size_t k = 0; k < D; ++k) row[k + 1] = p[k];
        const auto position = in_basis(triangle_, row);
        X missed = zero, square = one; // square: 1 + |p|²
        for (std::size_t k = 0; k < D; ++k) {
            missed = (max)(missed, abs(moments[k] - sum * position[k + 1]));
            square += p[k] * p[k];
        }
        return select(X(std::sqrt(epsilon<S>)) * square * abs(sum) < missed, one, zero);
    }

private:
    Buffer<Vec<S, D>> positions_;
    Vec<Vec<S, D + 1>, D + 1> triangle_{};
};

} // namespace cageform::inline CAGEFORM_ABI::detail
