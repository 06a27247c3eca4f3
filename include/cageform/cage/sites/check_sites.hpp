// Checks whether sites are valid control points: no two too close to each other, and not all in a plane.
#pragma once

#include <cageform/cage/detail/primitives.hpp>
#include <cageform/cage/types/report.hpp>
#include <cageform/core/view.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T, std::size_t D>
class PointSet; // in cage/point_set.hpp

namespace detail {

/// Finds sites closer to each other than `tolerance`. Sorts the sites along one axis after the other, and
/// splits the sorted sites at gaps wider than the tolerance. Stops when no axis splits a range any more. O(n
/// log n) unless very many sites almost coincide.
template <std::size_t D>
class CloseSites {
public:
    CloseSites(std::span<const Vec<double, D>> sites, double tolerance)
        : sites_(sites)
        , tolerance_(tolerance)
        , order_(sites.size()) {
        std::iota(order_.begin(), order_.end(), std::size_t{0});
    }
    /// Calls f(i, j), i < j, at most once for each site j, with the first coincident site i.
    template <class F>
    void for_each(const F& f) {
        std::vector<Run> runs{{0, order_.size(), 0, 0}};
        while (!runs.empty()) {
            const Run run = runs.back();
            runs.pop_back();
            if (run.end - run.begin < 2) continue;
            if (run.undivided == D) {
                list(run, f);
                continue;
            }
            divide(run, runs);
        }
    }

private:
    struct Run {
        std::size_t begin, end; ///< in order_
        std::size_t axis;       ///< the next axis to sort along
        std::size_t undivided;  ///< number of successive axes without a gap
    };

    void divide(const Run& run, std::vector<Run>& runs) {
        const auto at = [&](std::size_t n) { return sites_[order_[n]][run.axis]; };
        std::sort(order_.begin() + std::ptrdiff_t(run.begin), order_.begin() + std::ptrdiff_t(run.end),
                  [&](std::size_t a, std::size_t b) { return sites_[a][run.axis] < sites_[b][run.axis]; });
        std::size_t begin = run.begin;
        const std::size_t next = (run.axis + 1) % D;
        for (std::size_t n = run.begin + 1; n <= run.end; ++n) {
            if (n < run.end && !(at(n) - at(n - 1) > tolerance_)) continue;
            const bool whole = begin == run.begin && n == run.end;
            runs.push_back({begin, n, next, whole ? run.undivided + 1 : 1});
            begin = n;
        }
    }
    template <class F>
    void list(const Run& run, const F& f) {
        const auto first = order_.begin() + std::ptrdiff_t(run.begin);
        std::sort(first, order_.begin() + std::ptrdiff_t(run.end));
        for (std::size_t n = 1; n < run.end - run.begin; ++n) {
            for (std::size_t m = 0; m < n; ++m) {
                const std::size_t i = first[std::ptrdiff_t(m)], j = first[std::ptrdiff_t(n)];
                if (length(sites_[j] - sites_[i]) > tolerance_) continue;
                f(i, j);
                break;
            }
        }
    }

    std::span<const Vec<double, D>> sites_;
    double tolerance_;
    std::vector<std::size_t> order_;
};

/// Whether all sites lie within `tolerance` of a line (in 2D) or of a plane (in 3D). Each axis points to
/// the site farthest from the span of the previous axes.
template <std::size_t D>
bool is_flat_set(std::span<const Vec<double, D>> sites, double tolerance) noexcept {
    std::array<Vec<double, D>, D> axis{}; // orthonormal
    for (std::size_t found = 0; found < D; ++found) {
        Vec<double, D> farthest{};
        for (const auto& site : sites) {
            auto away = site - sites[0];
            for (std::size_t k = 0; k < found; ++k) away = away - dot(away, axis[k]) * axis[k];
            if (dot(away, away) > dot(farthest, farthest)) farthest = away;
        }
        const double distance = length(farthest);
        if (!(distance > tolerance)) return true;
        axis[found] = (1 / distance) * farthest;
    }
    return false;
}

template <Scalar T, std::size_t D>
void check_point_set(const PointSet<T, D>& set, CageReport& report) {
    if (set.size() < D + 1) return report.add(CageFaultKind::too_few_vertices, 0, set.size());
    for (std::size_t i = 0; i < set.size(); ++i) {
        if (!is_finite(set[i])) report.add(CageFaultKind::vertex_not_finite, i);
    }
    if (report.status != Status::ok) return;

    // Scaled by the largest coordinate against overflow and underflow.
    std::vector<Vec<double, D>> sites;
    for (const auto& site : set.sites()) sites.push_back(vec_cast<double>(site));
    int exponent = 0;
    std::frexp(bounds_of(std::span<const Vec<double, D>>(sites)).magnitude(), &exponent);
    for (auto& site : sites) {
        for (std::size_t k = 0; k < D; ++k) site[k] = std::ldexp(site[k], -exponent);
    }
    const auto bounds = bounds_of(std::span<const Vec<double, D>>(sites));
    const double tolerance = 8 * double(epsilon<T>) * std::fmax(bounds.diagonal(), bounds.magnitude());
    CloseSites<D>(sites, tolerance).for_each([&](std::size_t i, std::size_t j) {
        report.add(CageFaultKind::duplicate_vertices, i, j);
    });
    if (report.status == Status::ok && is_flat_set<D>(sites, tolerance))
        report.add(CageFaultKind::sites_in_a_plane);
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
