// The sums of PoseSamples over samples and spokes.
#pragma once

#include <cageform/binding/pose_samples/column_products.hpp>
#include <cageform/pose/types/pose_samples.hpp>

#include <array>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Sums K, G and M. Gradients are in units of the cage's size; matrices are stored by columns, with one
/// number per handle.
template <Scalar T, std::size_t D>
class SampleSums {
public:
    SampleSums(std::size_t handles, std::size_t clusters)
        : handles_(handles)
        , stiffness_(handles * handles)
        , gradients_(handles * clusters * D)
        , moments_(clusters) {}

    /// Adds the products of columns to K.
    void add_products(std::span<const double> columns, const Running& running) {
        add_column_products(std::span<double>(stiffness_), columns, handles_, running);
    }
    /// Adds a sample of weight 1 (D columns) to its cluster.
    void add_sample(std::span<const double> gradient, std::size_t cluster) {
        double* const sum = gradients_.data() + cluster * D * handles_;
        for (std::size_t n = 0; n < D * handles_; ++n) sum[n] += gradient[n];
        for (std::size_t k = 0; k < D; ++k) moments_[cluster][k * D + k] += 1;
    }
    /// Divides by the number of samples.
    void finish_samples(std::size_t count) {
        for (double& x : stiffness_) x /= double(count);
        for (double& x : gradients_) x /= double(count);
        for (auto& moment : moments_) {
            for (double& x : moment) x /= double(count);
        }
        for (std::size_t i = 0; i < handles_; ++i) diagonal_.push_back(stiffness_[i * handles_ + i]);
    }
    /// Adds a spoke: `gradient` times the handles at rest is `direction`.
    void add_spoke(std::span<const double> gradient, const Vec<double, D>& direction, std::size_t cluster,
                   double weight) {
        for (std::size_t j = 0; j < handles_; ++j) {
            if (gradient[j] == 0) continue;
            for (std::size_t i = j; i < handles_; ++i)
                stiffness_[j * handles_ + i] += weight * gradient[j] * gradient[i];
        }
        for (std::size_t k = 0; k < D; ++k) {
            double* const column = gradients_.data() + (cluster * D + k) * handles_;
            for (std::size_t i = 0; i < handles_; ++i) column[i] += weight * direction[k] * gradient[i];
            for (std::size_t m = 0; m < D; ++m)
                moments_[cluster][k * D + m] += weight * (direction[k] * direction[m]);
        }
    }

    void write(PoseSamples<T, D>& to) const {
        to.cluster_count = moments_.size();
        const std::size_t blocks = block_count<T>(to.cluster_count);
        to.gradients.resize(blocks * handles_ * D);
        to.moments.resize(blocks * D * D);
        for (std::size_t c = 0; c < blocks * lane_count<T>; ++c) {
            const std::size_t block = c / lane_count<T>, lane = c % lane_count<T>;
            const bool exists = c < to.cluster_count;
            for (std::size_t n = 0; n < handles_ * D; ++n)
                to.gradients[block * handles_ * D + n][lane] =
                    exists ? T(gradients_[(c * D + n % D) * handles_ + n / D]) : T(0);
            for (std::size_t n = 0; n < D * D; ++n)
                to.moments[block * D * D + n][lane] = exists ? T(moments_[c][n]) : T(n % (D + 1) == 0);
        }
        double mean = 0;
        for (const double entry : diagonal_) mean += entry / double(handles_);
        for (std::size_t i = 0; i < handles_; ++i) {
            for (std::size_t j = 0; j <= i; ++j) to.stiffness.push_back(stiffness_[j * handles_ + i]);
            if (!(diagonal_[i] > 1e-6 * mean)) to.weak_handles.push_back(std::uint32_t(i));
        }
    }

private:
    std::size_t handles_;
    std::vector<double> stiffness_;                  ///< its lower half
    std::vector<double> gradients_;                  ///< D columns for each cluster
    std::vector<std::array<double, D * D>> moments_; ///< row after row
    std::vector<double> diagonal_;                   ///< the diagonal without spokes
};

} // namespace cageform::inline CAGEFORM_ABI::detail
