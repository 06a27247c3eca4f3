// Divides samples into clusters of about one size.
#pragma once

#include <cageform/core/vec.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <cmath>
#include <limits>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Clusters by farthest points, then by ten steps of Lloyd's method (Least squares quantization in PCM, IEEE
/// Trans. Inf. Theory 28 (1982)). Positions are rounded, so that roundings decide no tie: clusters depend
/// neither on the place of a figure nor on its size.
///
///   cost  O(#samples #clusters) a step
template <Scalar T, std::size_t D>
class SampleClusters {
public:
    /// centre, size  of the cage
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
        spread(count);
        for (int step = 0; step < 10; ++step) {
            move();
            assign();
        }
        move();
        drop_empty();
        take_samples();
    }

private:
    std::vector<Vec<double, D>> points_; ///< #samples: whole numbers
    const Running& running_;

public:
    std::vector<std::uint32_t> cluster_of; ///< #samples
    std::vector<std::uint32_t> centres;    ///< #clusters: the sample nearest to the mean of each

private:
    static double distance(const Vec<double, D>& a, const Vec<double, D>& b) noexcept {
        return dot(a - b, a - b);
    }

    /// Starts from the first sample; each further centre is the sample farthest from those before.
    void spread(std::size_t count) {
        std::size_t farthest = 0;
        for (std::size_t c = 0; c < count; ++c) {
            places_.push_back(points_[farthest]);
            in_parallel(running_, points_.size(), 4096, [&](std::size_t begin, std::size_t end) {
                for (std::size_t s = begin; s < end; ++s) look_at(s, c);
            });
            farthest = 0;
            for (std::size_t s = 0; s < points_.size(); ++s) {
                if (nearest_[s] > nearest_[farthest]) farthest = s;
            }
        }
    }
    void look_at(std::size_t s, std::size_t cluster) noexcept {
        const double to = distance(points_[s], places_[cluster]);
        if (!(to < nearest_[s])) return;
        nearest_[s] = to;
        cluster_of[s] = std::uint32_t(cluster);
    }
    void assign() {
        in_parallel(running_, points_.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t s = begin; s < end; ++s) {
                nearest_[s] = std::numeric_limits<double>::infinity();
                for (std::size_t c = 0; c < places_.size(); ++c) look_at(s, c);
            }
        });
    }
    /// Moves the places to the means of their samples.
    void move() {
        std::vector<Vec<double, D>> sums(places_.size(), Vec<double, D>{});
        counts_.assign(places_.size(), 0);
        for (std::size_t s = 0; s < points_.size(); ++s) {
            sums[cluster_of[s]] = sums[cluster_of[s]] + points_[s];
            ++counts_[cluster_of[s]];
        }
        for (std::size_t c = 0; c < places_.size(); ++c) {
            if (counts_[c] > 0) places_[c] = (1 / double(counts_[c])) * sums[c];
        }
    }
    void drop_empty() {
        std::vector<std::uint32_t> number(places_.size(), 0);
        std::size_t kept = 0;
        for (std::size_t c = 0; c < places_.size(); ++c) {
            if (counts_[c] == 0) continue;
            number[c] = std::uint32_t(kept);
            places_[kept++] = places_[c];
        }
        places_.resize(kept);
        for (auto& cluster : cluster_of) cluster = number[cluster];
    }
    void take_samples() {
        constexpr std::uint32_t none = ~std::uint32_t{0};
        centres.assign(places_.size(), none);
        for (std::size_t s = 0; s < points_.size(); ++s) {
            std::uint32_t& centre = centres[cluster_of[s]];
            const Vec<double, D>& place = places_[cluster_of[s]];
            if (centre == none || distance(points_[s], place) < distance(points_[centre], place))
                centre = std::uint32_t(s);
        }
    }

    std::vector<double> nearest_; ///< #samples: the square of the distance to the place of their cluster
    std::vector<Vec<double, D>> places_; ///< #clusters
    std::vector<std::size_t> counts_;    ///< #clusters: their samples
};

} // namespace cageform::inline CAGEFORM_ABI::detail
