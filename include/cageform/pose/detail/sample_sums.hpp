// The sums of PoseSamples over samples and spokes.
#pragma once

#include <cageform/core/detail/in_parallel.hpp>
#include <cageform/pose/types/pose_samples.hpp>

#include <Eigen/Core>

#include <cmath>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Adds up K, G and M. Gradients are those of lengths that are shares of the cage's size.
template <Scalar T, std::size_t D>
class SampleSums {
public:
    using Matrix = Eigen::MatrixXd;

    SampleSums(std::size_t handles, std::size_t clusters)
        : stiffness_(Matrix::Zero(Eigen::Index(handles), Eigen::Index(handles)))
        , gradients_(Matrix::Zero(Eigen::Index(handles), Eigen::Index(clusters * D)))
        , moments_(clusters, Eigen::Matrix<double, int(D), int(D)>::Zero()) {}

    /// Adds the products of columns, #handles × any number, to K. Threads take columns of K.
    void add_products(const Matrix& columns, const Running& running) {
        constexpr Eigen::Index panel = 64;
        const Eigen::Index handles = stiffness_.rows();
        in_parallel(
            running, std::size_t((handles + panel - 1) / panel), 1, [&](std::size_t begin, std::size_t end) {
                for (auto n = Eigen::Index(begin); n < Eigen::Index(end); ++n) {
                    const Eigen::Index first = n * panel, width = (std::min)(panel, handles - first);
                    stiffness_.block(first, first, handles - first, width).noalias() +=
                        columns.bottomRows(handles - first) * columns.middleRows(first, width).transpose();
                }
            });
    }
    /// Adds a sample of weight 1 to its cluster.
    void add_sample(const Eigen::Ref<const Matrix>& gradient, std::size_t cluster) {
        gradients_.middleCols(Eigen::Index(cluster * D), Eigen::Index(D)) += gradient;
        moments_[cluster].diagonal().array() += 1;
    }
    /// Divides by the number of samples.
    void finish_samples(std::size_t count) {
        stiffness_ /= double(count);
        gradients_ /= double(count);
        for (auto& moment : moments_) moment /= double(count);
        felt_ = stiffness_.diagonal();
    }
    /// Adds a spoke: `gradient` times the handles at rest is `direction`.
    void add_spoke(const Eigen::VectorXd& gradient, const Vec<double, D>& direction, std::size_t cluster,
                   double weight) {
        stiffness_.template selfadjointView<Eigen::Lower>().rankUpdate(gradient, weight);
        for (std::size_t k = 0; k < D; ++k) {
            gradients_.col(Eigen::Index(cluster * D + k)) += weight * direction[k] * gradient;
            for (std::size_t m = 0; m < D; ++m)
                moments_[cluster](Eigen::Index(k), Eigen::Index(m)) += weight * (direction[k] * direction[m]);
        }
    }

    void write(PoseSamples<T, D>& to) const {
        const auto handles = std::size_t(stiffness_.rows());
        to.cluster_count = moments_.size();
        const std::size_t blocks = block_count<T>(to.cluster_count);
        to.gradients.resize(blocks * handles * D);
        to.moments.resize(blocks * D * D);
        for (std::size_t c = 0; c < blocks * lane_count<T>; ++c) {
            const std::size_t block = c / lane_count<T>, lane = c % lane_count<T>;
            const bool is_there = c < to.cluster_count;
            for (std::size_t n = 0; n < handles * D; ++n)
                to.gradients[block * handles * D + n][lane] =
                    is_there ? T(gradients_(Eigen::Index(n / D), Eigen::Index(c * D + n % D))) : T(0);
            for (std::size_t n = 0; n < D * D; ++n)
                to.moments[block * D * D + n][lane] =
                    is_there ? T(moments_[c](Eigen::Index(n / D), Eigen::Index(n % D))) : T(n % (D + 1) == 0);
        }
        const double mean = felt_.mean();
        for (std::size_t i = 0; i < handles; ++i) {
            for (std::size_t j = 0; j <= i; ++j)
                to.stiffness.push_back(stiffness_(Eigen::Index(i), Eigen::Index(j)));
            if (!(felt_(Eigen::Index(i)) > 1e-6 * mean)) to.unfelt.push_back(std::uint32_t(i));
        }
    }

private:
    Matrix stiffness_; ///< its lower half
    Matrix gradients_; ///< D columns for each cluster
    std::vector<Eigen::Matrix<double, int(D), int(D)>> moments_;
    Eigen::VectorXd felt_; ///< the diagonal without spokes
};

} // namespace cageform::inline CAGEFORM_ABI::detail
