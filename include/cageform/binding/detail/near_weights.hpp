// Finds weights close to given ones that reproduce a point.
#pragma once

#include <cageform/binding/detail/symmetric_matrix.hpp>
#include <cageform/core/affine/affine_rows.hpp>

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

struct HandleWeight {
    std::uint32_t handle = 0;
    double weight = 0;
    friend bool operator==(const HandleWeight&, const HandleWeight&) = default;
};

/// Orders weights descending, equal ones by handle.
constexpr bool is_heavier(const HandleWeight& a, const HandleWeight& b) noexcept {
    return a.weight != b.weight ? a.weight > b.weight : a.handle < b.handle;
}

/// Finds the weights of one point that reproduce it with the least relative change of given weights m:
/// w = m · max(0, 1 + a·y), where a are the affine rows of the handles and y has D + 1 numbers such that Σ w
/// a = (1, 0). Uses Newton's method as ConvexWeights does. Where m is 0, so is w, and w is continuous in m.
template <std::size_t D>
class NearWeights {
public:
    /// The tolerance relative to the size: the resolution of weights in single precision.
    static constexpr double reproduced = 1e-7;

    template <Scalar T>
    void load(std::span<const HandleWeight> row, const HandleView<T, D>& handles,
              const AffineFrame<double, D>& frame) {
        given_.clear();
        for (const HandleWeight& entry : row) {
            if (entry.weight > 0) given_.push_back(entry);
        }
        std::sort(given_.begin(), given_.end(), is_heavier);
        columns_.resize(given_.size());
        for (std::size_t k = 0; k < given_.size(); ++k) {
            const auto affine = frame.row(handles, given_[k].handle);
            for (std::size_t r = 0; r <= D; ++r) columns_[k][long(r)] = affine[r];
        }
    }

    /// Drops the weights below the threshold if the others reproduce the point. Returns false if no
    /// weights reproduce it; the given weights are then kept.
    bool reproduce(double threshold) {
        const bool is_exact = solve(given_.size());
        const auto least = std::find_if(found_.begin(), found_.end(),
                                        [&](const HandleWeight& entry) { return entry.weight < threshold; });
        const auto kept = (std::max)(std::size_t(least - found_.begin()), std::size_t{1});
        if (kept < given_.size()) {
            const std::vector<HandleWeight> all = found_;
            if (!solve(kept) && is_exact) found_ = all;
        }
        double sum = 0;
        for (const HandleWeight& entry : found_) sum += entry.weight;
        for (HandleWeight& entry : found_) entry.weight /= sum;
        std::sort(found_.begin(), found_.end(), is_heavier);
        support_.clear();
        for (const HandleWeight& entry : found_) support_.push_back(entry.handle);
        return is_exact;
    }

    std::span<const std::size_t> support() const noexcept { return support_; } ///< by descending weight
    double weight(std::size_t handle) const noexcept {
        for (const HandleWeight& entry : found_) {
            if (entry.handle == handle) return entry.weight;
        }
        return 0;
    }

private:
    static constexpr int N = int(D) + 1;
    using Row = Eigen::Matrix<double, N, 1>;
    using Square = Eigen::Matrix<double, N, N>;

    /// Solves for the first `count` given weights, in `found_`. If these cannot reproduce the point,
    /// returns false and the given weights.
    bool solve(std::size_t count) {
        found_.assign(given_.begin(), given_.begin() + std::ptrdiff_t(count));
        constexpr double penalty = 1e-12; // keeps the equations solvable for coplanar handles
        Row y = Row::Zero();
        double value = objective(count, y);
        for (int step = 0; step < 60; ++step) {
            Square matrix = penalty * Square::Identity();
            Row gradient = Row::Zero();
            gradient[0] = -1;
            for (std::size_t k = 0; k < count; ++k) {
                const double factor = 1 + columns_[k].dot(y);
                if (!(factor > 0)) continue;
                gradient += given_[k].weight * factor * columns_[k];
                matrix += given_[k].weight * columns_[k] * columns_[k].transpose();
            }
            if (gradient.template lpNorm<Eigen::Infinity>() < 1e-14) break;
            const Row direction = -SmallMatrix<std::size_t(N)>(matrix).llt().solve(gradient);
            const double fall = gradient.dot(direction);
            if (!(fall < 0)) break;
            double length = 1, there = objective(count, y + direction);
            while (!(there <= value + 1e-4 * length * fall) && length > 1e-10) {
                length *= 0.5;
                there = objective(count, y + length * direction);
            }
            if (!(there < value)) break;
            y += length * direction;
            value = there;
        }
        Row missed = Row::Zero();
        missed[0] = -1;
        for (std::size_t k = 0; k < count; ++k) {
            found_[k].weight *= (std::max)(0.0, 1 + columns_[k].dot(y));
            missed += found_[k].weight * columns_[k];
        }
        if (missed.template lpNorm<Eigen::Infinity>() <= reproduced) return true;
        found_.assign(given_.begin(), given_.begin() + std::ptrdiff_t(count));
        return false;
    }
    double objective(std::size_t count, const Row& y) const {
        double value = -y[0];
        for (std::size_t k = 0; k < count; ++k) {
            const double factor = (std::max)(0.0, 1 + columns_[k].dot(y));
            value += 0.5 * given_[k].weight * factor * factor;
        }
        return value;
    }

    std::vector<HandleWeight> given_, found_;
    std::vector<Row> columns_;
    std::vector<std::size_t> support_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
