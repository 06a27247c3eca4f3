// Makes sets of control points from a figure: points of the figure as handles, and fixed points around the
// figure.
#pragma once

#include <cageform/cage/detail/primitives.hpp>
#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/result.hpp>
#include <cageform/core/view.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// The result of `sites_with_figure_points`.
template <Scalar T, std::size_t D>
struct ConstraintPoints {
    std::vector<Vec<T, D>> sites;       ///< the given sites, then the added ones
    std::vector<std::uint32_t> handles; ///< #indices: the site at each figure point
};

/// Adds points of a figure to a set of control points. These figure points can then be moved directly,
/// because a figure point at a site follows the site exactly.
///
///   sites    any PointRange
///   figure   any PointRange of the same dimension, converted to the scalar of the sites
///   indices  indices of the figure points to add. If a point is closer to an earlier site than the
///            coincidence_tolerance of all sites and chosen points, it adds no site. The earlier site is then
///            its handle
///   cost     O(#indices · #sites)
///   fails    index_out_of_range, vertex_not_finite, out_of_memory
template <PointRange S, PointRangeIn<range_dimension<S>> F>
Result<ConstraintPoints<range_scalar_t<S>, range_dimension<S>>>
sites_with_figure_points(const S& sites, const F& figure, std::span<const std::size_t> indices) {
    using T = range_scalar_t<S>;
    using Site = Vec<T, range_dimension<S>>;
    Result<ConstraintPoints<T, range_dimension<S>>> result;
    const auto run = [&] {
        for (std::size_t i = 0; i < std::size(sites); ++i) result.value.sites.push_back(to_vec<T>(sites[i]));
        std::vector<Site> chosen;
        for (const std::size_t index : indices) {
            if (index >= std::size(figure)) return Status::index_out_of_range;
            chosen.push_back(to_vec<T>(figure[index]));
        }
        std::vector<Site> all = result.value.sites;
        all.insert(all.end(), chosen.begin(), chosen.end());
        for (const Site& p : all) {
            if (!is_finite(p)) return Status::vertex_not_finite;
        }
        const double tolerance = coincidence_tolerance(bounds_of(std::span<const Site>(all)));
        for (const Site& p : chosen) {
            const auto at_it = [&](const Site& site) {
                const auto d = vec_cast<double>(site) - vec_cast<double>(p);
                return std::sqrt(dot(d, d)) <= tolerance;
            };
            const auto found = std::find_if(result.value.sites.begin(), result.value.sites.end(), at_it);
            result.value.handles.push_back(static_cast<std::uint32_t>(found - result.value.sites.begin()));
            if (found == result.value.sites.end()) result.value.sites.push_back(p);
        }
        return Status::ok;
    };
    result.report = detail::guard_memory(run);
    if (!result) result.value = {};
    return result;
}

/// Selects the points that `surround` makes on the box.
enum class SurroundSites : std::uint8_t {
    corners, ///< the 2^D corners
    lattice, ///< 3^D − 1 points: corners, and the midpoints of edges and, in space, of faces
};

struct SurroundOptions {
    /// Distance from the points to the sides of the box, in diagonals of the points' bounds; > 0.
    double margin = 0.25;
    SurroundSites sites = SurroundSites::corners;
};

/// Makes sites on a box around points, as fixed control points. With these sites a deformation fades to zero
/// towards the box, and all points lie inside the box.
///
///   points  any PointRange: the figure and the sites together. Points in one plane or on one line get the
///           margin in all directions
///   fails   too_few_vertices without points, vertex_not_finite, cage_has_no_area or
///           cage_has_no_volume if all points coincide, radius_not_positive for the margin,
///           value_not_finite if a corner exceeds the scalar's range, out_of_memory
template <PointRange R>
Result<std::vector<Vec<range_scalar_t<R>, range_dimension<R>>>>
surround(const R& points, const SurroundOptions& options = {}) {
    using T = range_scalar_t<R>;
    constexpr std::size_t D = range_dimension<R>;
    Result<std::vector<Vec<T, D>>> result;
    result.report = detail::guard_memory([&] {
        if (!is_finite(options.margin) || !(options.margin > 0)) return Status::radius_not_positive;
        std::vector<Vec<double, D>> positions;
        for (std::size_t i = 0; i < std::size(points); ++i) {
            positions.push_back(to_vec<double>(points[i]));
            if (!is_finite(positions.back())) return Status::vertex_not_finite;
        }
        if (positions.empty()) return Status::too_few_vertices;
        const auto bounds = bounds_of(std::span<const Vec<double, D>>(positions));
        if (!(bounds.diagonal() > coincidence_tolerance(bounds)))
            return D == 2 ? Status::cage_has_no_area : Status::cage_has_no_volume;
        const auto box = bounds.widened(options.margin * bounds.diagonal());
        const std::size_t steps = options.sites == SurroundSites::corners ? 2 : 3;
        std::size_t count = 1;
        for (std::size_t k = 0; k < D; ++k) count *= steps;
        for (std::size_t i = 0; i < count; ++i) {
            if (2 * i + 1 == count) continue; // skip the centre of the lattice
            Vec<double, D> site{};
            for (std::size_t k = 0, rest = i; k < D; ++k, rest /= steps) {
                const double share = double(rest % steps) / double(steps - 1);
                site[k] = (1 - share) * box.lower[k] + share * box.upper[k];
            }
            result.value.push_back(vec_cast<T>(site));
            if (!is_finite(result.value.back())) return Status::value_not_finite;
        }
        return Status::ok;
    });
    if (!result) result.value.clear();
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
