// Divides samples into clusters of similar size.
#pragma once

#include <cageform/core/vec.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <cmath>
#include <limits>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Clusters by farthest points, then by ten steps of Lloyd's method (Least squares quantization in PCM,
/// IEEE Trans. Inf. Theory 28 (1982)). Positions are rounded to integers, so that rounding errors
/// decide no tie: clusters do not depend on the position or size of a figure.
///
///   cost  O(#samples #clusters) per step
template <Scalar T, std::size_t D>
class SampleClusters {
public:
    /// `centre` and `size` are those of the cage.
    SampleClusters(const std::vector<Vec<T, D>>& points, const Vec<double, D>& centre, double size,
                   std::size_t count, const Running& running)
        : running_(running)
        , cluster_of(points.size(), 0)
        , nearest_(points.size(), std::numeric_limits<double>::infinity()) {
        for (const auto& point : points) {
            auto p = (0x1p16 / size) * (vec_cast<double>(point) - centre);
            for (double& x : p.v) x = std::nearbyint(x);
            points_.push_back(p);
        }
        if (count >= points.size()) {
            for (std::size_t s = 0; s < points.size(); ++s) {
                cluster_of[s] = std::uint32_t(s);
                centres.push_back(std::uint32_t(s));
            }
            return;
        }
        choose_farthest_points(count);
        for (int step = 0; step < 10; ++step) {
            update_means();
            assign();
        }
        update_means();
        drop_empty();
        choose_centres();
    }

private:
    std::vector<Vec<double, D>> points_; ///< #samples: whole numbers
    const Running& running_;

public:
    std::vector<std::uint32_t> cluster_of; ///< #samples
    std::vector<std::uint32_t> centres;    ///< #clusters: the sample nearest to each mean

private:
    static double distance(const Vec<double, D>& a, const Vec<double, D>& b) noexcept {
        return dot(a - b, a - b);
    }

    /// The first centre is the first sample; each further one is the sample farthest from all centres so far.
    void choose_farthest_points(std::size_t count) {
        std::size_t farthest = 0;
        for (std::size_t c = 0; c < count; ++c) {
            means_.push_back(points_[farthest]);
            in_parallel(running_, points_.size(), 4096, [&](std::size_t begin, std::size_t end) {
                for (std::size_t s = begin; s < end; ++s) update_nearest(s, c);
            });
            farthest = 0;
            for (std::size_t s = 0; s < points_.size(); ++s) {
                if (nearest_[s] > nearest_[farthest]) farthest = s;
            }
        }
    }
    void update_nearest(std::size_t s, std::size_t cluster) noexcept {
        const double to = distance(points_[s], means_[cluster]);
        if (!(to < nearest_[s])) return;
        nearest_[s] = to;
        cluster_of[s] = std::uint32_t(cluster);
    }
    void assign() {
        in_parallel(running_, points_.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t s = begin; s < end; ++s) {
                nearest_[s] = std::numeric_limits<double>::infinity();
                for (std::size_t c = 0; c < means_.size(); ++c) update_nearest(s, c);
            }
        });
    }
    /// Moves the means to those of their samples.
    void update_means() {
        std::vector<Vec<double, D>> sums(means_.size(), Vec<double, D>{});
        counts_.assign(means_.size(), 0);
        for (std::size_t s = 0; s < points_.size(); ++s) {
            sums[cluster_of[s]] = sums[cluster_of[s]] + points_[s];
            ++counts_[cluster_of[s]];
        }
        for (std::size_t c = 0; c < means_.size(); ++c) {
            if (counts_[c] > 0) means_[c] = (1 / double(counts_[c])) * sums[c];
        }
    }
    void drop_empty() {
        std::vector<std::uint32_t> number(means_.size(), 0);
        std::size_t kept = 0;
        for (std::size_t c = 0; c < means_.size(); ++c) {
            if (counts_[c] == 0) continue;
            number[c] = std::uint32_t(kept);
            means_[kept++] = means_[c];
        }
        means_.resize(kept);
        for (auto& cluster : cluster_of) cluster = number[cluster];
    }
    void choose_centres() {
        constexpr std::uint32_t none = ~std::uint32_t{0};
        centres.assign(means_.size(), none);
        for (std::size_t s = 0; s < points_.size(); ++s) {
            std::uint32_t& centre = centres[cluster_of[s]];
            const Vec<double, D>& place = means_[cluster_of[s]];
            if (centre == none || distance(points_[s], place) < distance(points_[centre], place))
                centre = std::uint32_t(s);
        }
    }

    std::vector<double> nearest_;       ///< #samples: the squared distance to the cluster's mean
    std::vector<Vec<double, D>> means_; ///< #clusters
    std::vector<std::size_t> counts_;   ///< #clusters: number of samples
};

} // namespace cageform::inline CAGEFORM_ABI::detail
