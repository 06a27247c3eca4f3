// Projects a row of positive numbers to weights that reproduce a point.
#pragma once

#include <cageform/core/affine/entropy_solver.hpp>
#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/status.hpp>

#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Finds the weights nearest to a positive prior with Σ w = 1 and Σ w H = p: those that minimise
/// Σ w ln(w/q) (Kullback, Leibler). Unlike the least change, they are never negative. For a row that already
/// has both properties, the weights are the row itself, up to rounding.
///
///   prior    q, not negative; at least one is positive. Handles with q = 0 have weight 0
///   handles  H, #prior points
///   p        must lie inside the hull of the handles with q > 0
///   weights  out, #prior; may be `prior`. Unchanged unless the status is ok
///   cost     some 5 to 10 passes of O(#prior), more next to the boundary of the hull; in double
///   fails    weights_do_not_match; weights_not_positive (a prior); value_not_finite (a handle or p);
///            point_not_surrounded; out_of_memory
template <Scalar T, std::size_t D>
Status project(std::span<const T> prior, std::span<const Vec<T, D>> handles, const Vec<T, D>& p,
               std::span<T> weights) noexcept {
    const std::size_t count = prior.size();
    if (handles.size() != count || weights.size() != count) return Status::weights_do_not_match;
    double largest = 0, size = 0;
    for (std::size_t k = 0; k < count; ++k) {
        if (!(prior[k] >= 0) || !is_finite(prior[k])) return Status::weights_not_positive;
        if (prior[k] == 0) continue;
        const auto u = vec_cast<double>(handles[k]) - vec_cast<double>(p);
        if (!is_finite(u)) return Status::value_not_finite;
        largest = (std::max)(largest, double(prior[k]));
        for (const double x : u.v) size = (std::max)(size, std::fabs(x));
    }
    if (!(largest > 0)) return Status::weights_not_positive;
    if (!is_finite(p) || !is_finite(size)) return Status::value_not_finite;
    return detail::guard_memory([&] {
        std::vector<double> q, rows;
        std::vector<Vec<double, D>> places;
        std::vector<std::size_t> numbers;
        const double scale = size > 0 ? 1 / size : 1;
        for (std::size_t k = 0; k < count; ++k) {
            if (prior[k] == 0) continue;
            q.push_back(double(prior[k]) / largest);
            places.push_back(scale * (vec_cast<double>(handles[k]) - vec_cast<double>(p)));
            numbers.push_back(k);
        }
        rows.resize(q.size());
        const auto u = [&](std::size_t k) { return places[k]; };
        detail::EntropySolver<double, D, decltype(u)> solver(q, u, rows);
        Vec<double, D> off{};
        if (solver.solve(0, false) == 0) return Status::point_not_surrounded;
        for (std::size_t k = 0; k < q.size(); ++k) off = off + (rows[k] / solver.sum()) * places[k];
        constexpr double missed = 1e-10; // of the extent of the handles about p; rounding is far below
        if (!(dot(off, off) < missed * missed)) return Status::point_not_surrounded;
        std::fill(weights.begin(), weights.end(), T(0));
        for (std::size_t k = 0; k < q.size(); ++k) weights[numbers[k]] = T(rows[k] / solver.sum());
        return Status::ok;
    });
}

} // namespace cageform::inline CAGEFORM_ABI
