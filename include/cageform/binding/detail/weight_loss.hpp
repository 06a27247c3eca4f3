// Measures how far points move when their weights change.
#pragma once

#include <cageform/binding/types/pack_options.hpp>
#include <cageform/cage/detail/primitives.hpp>
#include <cageform/core/affine/affine_rows.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The distance that a point moves by a change of weights, w' − w: max |Σ (w' − w) d| over the
/// displacements d of given poses, or Σ |w' − w| · reach without poses.
template <std::size_t D>
class WeightLoss {
public:
    struct Distance {
        double value = 0;
        std::size_t pose = Extreme::none;
    };

    /// Returns pose_size_differs, pose_not_finite (with the pose in `culprit`), value_not_finite, or ok.
    template <Scalar T>
    Status load(const HandleView<T, D>& handles, const PackOptions& options, std::size_t& culprit) {
        handles_ = handles.count;
        size_ = handles.point_count() > 0 ? bounds_of_points<double>(handles).diagonal() : 0;
        if (!(size_ > 0)) size_ = 1;
        if (!is_finite(options.reach) || !is_finite(options.tolerance) || options.reach < 0 ||
            options.tolerance < 0)
            return Status::value_not_finite;
        reach_ = options.reach > 0 ? options.reach : 0.1 * size_;
        const std::size_t numbers = handles_ * D;
        if (numbers == 0 ? !options.poses.empty() : options.poses.size() % numbers != 0)
            return Status::pose_size_differs;
        poses_ = numbers == 0 ? 0 : options.poses.size() / numbers;
        displacements_.resize(poses_ * numbers);
        for (std::size_t p = 0; p < poses_; ++p) {
            for (std::size_t h = 0; h < handles_; ++h) {
                for (std::size_t k = 0; k < D; ++k) {
                    // In the scalar of `clone`.
                    const T d =
                        static_cast<T>(options.poses[(p * handles_ + h) * D + k]) - handles.rest[h][k];
                    culprit = p;
                    if (!is_finite(d)) return Status::pose_not_finite;
                    displacements_[(p * D + k) * handles_ + h] = double(d) / size_;
                }
            }
        }
        culprit = Extreme::none;
        return Status::ok;
    }

    std::size_t poses() const { return poses_; }
    double reach() const { return reach_; }
    /// Returns the handles' displacements along an axis in a pose, in units of the cage's size.
    std::span<const double> displacements(std::size_t pose, std::size_t axis) const {
        return {displacements_.data() + (pose * D + axis) * handles_, handles_};
    }

    /// Returns the largest distances of `L` points over all poses, and the poses.
    ///
    ///   change  #handles rows of L numbers
    template <std::size_t L>
    std::array<Distance, L> distances(std::span<const double> change) const {
        std::array<Distance, L> result{};
        if (poses_ == 0) {
            for (std::size_t h = 0; h < handles_; ++h) {
                for (std::size_t lane = 0; lane < L; ++lane)
                    result[lane].value += reach_ * std::fabs(change[h * L + lane]);
            }
            return result;
        }
        for (std::size_t p = 0; p < poses_; ++p) {
            const auto squared = squared_in<L>(p, change);
            for (std::size_t lane = 0; lane < L; ++lane) {
                if (p == 0 || squared[lane] > result[lane].value) result[lane] = {squared[lane], p};
            }
        }
        for (auto& distance : result) distance.value = size_ * std::sqrt(distance.value);
        return result;
    }

    /// Returns the largest distance, or the first one above `limit`. Pose `first_pose` is tested first;
    /// it becomes the pose with the returned distance.
    template <std::size_t L>
    double largest(std::span<const double> change, double limit, std::size_t& first_pose) const {
        double worst = 0;
        if (poses_ == 0) {
            for (const Distance& distance : distances<L>(change)) worst = (std::max)(worst, distance.value);
            return worst;
        }
        for (std::size_t n = 0, first = (std::min)(first_pose, poses_ - 1); n < poses_; ++n) {
            const std::size_t p = (first + n) % poses_;
            const auto squared = squared_in<L>(p, change);
            const double distance = size_ * std::sqrt(*std::max_element(squared.begin(), squared.end()));
            if (distance > worst) {
                worst = distance;
                first_pose = p;
            }
            if (worst > limit) break;
        }
        return worst;
    }

private:
    /// Returns |Σ (w' − w) d|² in a pose, in units of the cage's size.
    template <std::size_t L>
    std::array<double, L> squared_in(std::size_t pose, std::span<const double> change) const {
        std::array<double, L> squared{};
        for (std::size_t k = 0; k < D; ++k) {
            const auto d = displacements(pose, k);
            std::array<double, L> sum{};
            for (std::size_t h = 0; h < handles_; ++h) {
                for (std::size_t lane = 0; lane < L; ++lane) sum[lane] += d[h] * change[h * L + lane];
            }
            for (std::size_t lane = 0; lane < L; ++lane) squared[lane] += sum[lane] * sum[lane];
        }
        return squared;
    }

    std::size_t handles_ = 0, poses_ = 0;
    double size_ = 1, reach_ = 0;
    std::vector<double> displacements_; // [pose][axis][handle], in units of the size
};

} // namespace cageform::inline CAGEFORM_ABI::detail
