// The largest allowed cell size at each point.
//
// The size depends on the thickness of the domain and on the altitudes of its facets. It also depends on the
// vertices and edges where functions are singular (grid/tree/features.hpp). grid/tree/refinement.hpp splits
// cells accordingly.
#pragma once

#include <cageform/grid/tree/bone_sizes.hpp>
#include <cageform/grid/types/solver_report.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <map>
#include <numbers>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

struct RefinementOptions {
    double across = 6; ///< cells across the thickness of the domain
    /// 3D: acceptable error of the functions, or 0. Between two facets, far from their edges, functions are
    /// nearly linear. If `small_error` is not 0, `across` applies only near edges at which the kinks of
    /// functions would cause larger errors than that.
    double small_error = 0;
    double per_facet = 1; ///< cells along the smallest altitude of a facet; in 2D along an edge
    /// 3D: largest cell at a facet, in square roots of its area.
    double of_root_area = std::numeric_limits<double>::infinity();
    /// 2D: extra halvings at a vertex where functions decrease linearly with the distance. At a vertex of
    /// interior angle ω they decrease like the power π/ω of the distance, and the number is divided by π/ω.
    double corner_levels = 0.67;
    double corner_gradation = 1; ///< minimum ratio of distance to cell size near such a vertex
    double edge_levels = 1;      ///< 3D: extra halvings at reflex edges and boundaries of walls
    /// 3D: extra halvings at the ends of such edges. The number is divided by λ if functions decrease like
    /// the power λ < 1 of the distance from the end, and is then at most 10.
    double reflex_levels = 1;
    /// 3D: largest cell at a vertex of more than three facets, as a fraction of the cage's size.
    double at_vertex = 1.0 / 16;
    double per_radius = 12; ///< see BoneSizes
    /// Largest cell, as a fraction of the cage's size. This size is the distance between two far vertices in
    /// 3D, and the longest side of the box around the cage in 2D.
    double largest = 1.0 / 16;
};

} // namespace grid

namespace detail {

/// Returns the first corner of a facet's longest edge, and the length of that edge.
template <std::size_t D>
std::pair<std::size_t, double> longest_edge(const Corners<D>& corner) noexcept {
    std::pair<std::size_t, double> longest{0, 0};
    for (std::size_t k = 0; k < D; ++k) {
        const double l = length(corner[(k + 1) % D] - corner[k]);
        if (l > longest.second) longest = {k, l};
    }
    return longest;
}
/// Returns the length of an edge, or the area of a triangle.
inline double measure(const Corners<2>& corner) noexcept {
    return length(corner[1] - corner[0]);
}
inline double measure(const Corners<3>& corner) noexcept {
    return 0.5 * length(cross(corner[1] - corner[0], corner[2] - corner[0]));
}

/// The cell sizes that facets allow, in units.
template <std::size_t D>
class CellSizes {
public:
    using Boundary = grid::TreeBoundary<D>;
    using Cell = typename grid::CellTree<D>::Cell;
    using Point = Vec<double, D>;

    /// An upper bound of a cell's size, and its reason.
    struct SizeLimit {
        double size;
        SizeReason reason;
    };
    /// A point on a facet where the domain is thin.
    struct ThinPoint {
        Point position, inwards;
        double size, thickness;
    };

    CellSizes(const Boundary& boundary, const grid::RefinementOptions& options)
        : boundary_(boundary)
        , options_(options)
        , cage_size_(size_of_cage(boundary))
        , largest_((std::max)(options.largest * cage_size_, 1.0))
        , faced_(2 * boundary.size()) {
        for (std::uint32_t n = 0; n < boundary.size(); ++n) {
            faced_[std::size_t{2} * n] = faced_[std::size_t{2} * n + 1] = n;
            altitudes_.push_back(altitude(boundary[n].corner));
            root_areas_.push_back(std::sqrt(measure(boundary[n].corner)));
        }
        if constexpr (D == 3) find_slopes();
    }
    const Boundary& boundary() const noexcept { return boundary_; }
    const grid::RefinementOptions& options() const noexcept { return options_; }
    double cage_size() const noexcept { return cage_size_; }
    double largest() const noexcept { return largest_; }

    /// Returns the size that RefinementOptions::largest refers to. In 3D it is the distance between two
    /// vertices far from each other. This distance is nearly the largest, and does not depend on rotation.
    static double size_of_cage(const Boundary& boundary) noexcept {
        if constexpr (D == 2) return std::ldexp(1.0, int(boundary.depth()));
        auto from = boundary[0].corner[0], to = from;
        for (int step = 0; step < 3; ++step) {
            for (std::size_t n = 0; n < boundary.size(); ++n) {
                for (const auto& corner : boundary[n].corner) {
                    if (length(corner - from) > length(to - from)) to = corner;
                }
            }
            if (step < 2) std::swap(from, to);
        }
        return length(to - from);
    }

    // ---- facets -----------------------------------------------------------------------------------

    /// Returns the size that facets allow for a cell that they intersect. Rays across the domain are
    /// limited to the length that matters for this size.
    ///
    ///   thin  out: adds points where the thickness of the domain requires cells of this size
    SizeLimit of_facets(std::span<const std::uint32_t> facets, const Cell& cell, const Point& middle,
                        std::vector<ThinPoint>& thin) {
        const double most = options_.across * (std::min)(2.0 * cell.size, largest_);
        SizeLimit least{largest_, SizeReason::largest};
        for (const std::uint32_t n : facets) {
            if (n >= boundary_.size()) break; // a bone
            if (by_facet(n) < least.size) least = {by_facet(n), SizeReason::facet};
            const auto& facet = boundary_[n];
            const auto position = facet.position(nearest_on_facet(middle, facet.corner));
            for (const bool front : {true, false}) {
                if (!front && facet.separates) continue;
                const double t = thickness(n, front, position, most);
                if (!(t < most)) continue;
                const double size = (std::max)(size_between(n, position, t), 1.0);
                if (size < least.size) least = {size, SizeReason::thickness};
                if (size >= cell.size) thin.push_back({position, inwards(n, front), size, t});
            }
        }
        return least;
    }

    /// Returns the size that a facet allows near a point on its boundary. In 3D the size is at most the
    /// thickness of the outside behind the facet. The reason is that axis lines of larger cells can miss a
    /// narrow dent. This rule divides the size by at most eight.
    double size_near(std::uint32_t n, const Point& position) {
        const auto within = 0.95 * position + (0.05 / D) * sum(boundary_[n].corner);
        const double size = size_of(n, true, within);
        if (!boundary_[n].separates) return (std::min)(size, size_of(n, false, within));
        return D == 2 ? size : std::clamp(thickness(n, false, within), size / 8, size);
    }

    /// A part of the boundary, for RefinementPlanner.
    struct Patch {
        double area;                           ///< in 2D the length
        double altitude, root_area, thickness; ///< altitude and square root of the area of its facet
        std::array<double, D> slopes;          ///< see slopes_
        std::array<double, D> lengths;         ///< lengths of the facet's edges, divided by its area

        /// Divides the patch into parts by the allowed cell size, at most `most`. Calls f(size, area) for
        /// each part.
        template <class F>
        void for_each_part(const grid::RefinementOptions& options, double most, const F& f) const {
            const double across = thickness / options.across;
            if (!(options.small_error > 0) || !(across < most)) return f((std::min)(across, most), area);
            double rest = area;
            for (std::size_t k = 0; k < D; ++k) {
                const auto kink = kink_at(thickness, slopes[k], options);
                const double size = (std::min)(kink.size, most), width = kink.reach + 4 * size;
                const double part = (std::min)(rest, area * width * lengths[k]);
                f(size, part);
                rest -= part;
            }
            f((std::min)(most, most_of_thickness * thickness), rest);
        }
    };
    /// Divides the facets, and both sides of walls, into patches. Casts one ray per patch.
    std::vector<Patch> patches(const Running& running) const {
        constexpr double most = 2000; // patches in addition to one per facet
        double area = 0;
        for (std::uint32_t n = 0; n < boundary_.size(); ++n) area += measure(boundary_[n].corner);
        const auto parts = in_runs<std::vector<Patch>>(running, boundary_.size(), 64, [&] {
            return [this, area, sizes = *this](std::size_t begin, std::size_t end,
                                               std::vector<Patch>& patches) mutable {
                for (std::size_t n = begin; n < end; ++n) {
                    for (const bool front : {true, false}) {
                        if (front || !boundary_[n].separates)
                            sizes.add_patches({std::uint32_t(n), front, boundary_[n].corner}, area / most,
                                              patches);
                    }
                }
            };
        });
        std::vector<Patch> patches;
        for (const auto& part : parts) patches.insert(patches.end(), part.begin(), part.end());
        return patches;
    }

private:
    /// In units; facets closer than this count as coplanar.
    static constexpr double touching = 0.01;
    /// Smallest cosine between the normals of two facets for a thickness between them.
    static constexpr double facing = 0.7;

    static double altitude(const Corners<D>& corner) noexcept {
        const double longest = longest_edge(corner).second;
        if constexpr (D == 2) { // an edge that rounding has collapsed gives no limit
            return longest > 0 ? longest : std::numeric_limits<double>::infinity();
        } else {
            return longest > 0 ? 2 * measure(corner) / longest : 0;
        }
    }
    /// The cells that resolve a kink of functions at an edge of a thin part of the domain.
    struct Kink {
        double size, reach; ///< the cell size, and the distance from the edge within which it applies
    };
    /// Between two parallel planes a harmonic function deviates from a linear one by A exp(−π d / thickness).
    /// Here d is the distance from the edge, and A is the deviation at the edge.
    ///
    ///   slope  the largest slope of hat functions at the edge, on the facets
    static Kink kink_at(double thickness, double slope, const grid::RefinementOptions& options) noexcept {
        // Error of a function with a kink / (cell size · slope).
        constexpr double error_of_cell = 0.2;
        const double amplitude = (std::min)(1.0, thickness * slope) / options.small_error;
        return {(std::max)(thickness / options.across, options.small_error / (error_of_cell * slope)),
                amplitude > 1 ? thickness / std::numbers::pi * std::log(amplitude) : 0};
    }
    /// The largest ratio of cell size to thickness in a thin part of the domain. Larger cells lose precision
    /// in the positions on the boundary.
    static constexpr double most_of_thickness = 64;
    /// Returns the cell size that facet `n` allows at a position where the domain is thin.
    double size_between([[maybe_unused]] std::uint32_t n, [[maybe_unused]] const Point& position,
                        double thickness) const noexcept {
        if constexpr (D == 3) {
            if (options_.small_error > 0) {
                const auto& corner = boundary_[n].corner;
                double size = (std::min)(largest_, most_of_thickness * thickness);
                for (std::size_t k = 0; k < 3; ++k) {
                    const auto kink = kink_at(thickness, slopes_[n][k], options_);
                    const double apart =
                        distance_to_segment(position, corner[(k + 1) % 3], corner[(k + 2) % 3]) - kink.reach;
                    size = (std::min)(size, (std::max)(kink.size, 0.5 * apart));
                }
                return size;
            }
        }
        return thickness / options_.across;
    }
    void find_slopes() {
        // Keys are the vertices of an edge; NOLINTNEXTLINE(misc-const-correctness): filled below
        std::map<std::array<std::uint32_t, 2>, double> largest;
        const auto for_each_edge = [&](const auto& f) {
            for (std::uint32_t n = 0; n < boundary_.size(); ++n) {
                for (std::size_t k = 0; k < 3; ++k) {
                    const auto [a, b] =
                        std::minmax(boundary_[n].vertex[(k + 1) % 3], boundary_[n].vertex[(k + 2) % 3]);
                    f(n, k, largest[{a, b}]);
                }
            }
        };
        for_each_edge([&](std::uint32_t n, std::size_t k, double& slope) {
            const auto& corner = boundary_[n].corner;
            slope =
                (std::max)(slope, length(corner[(k + 2) % 3] - corner[(k + 1) % 3]) / (2 * measure(corner)));
        });
        slopes_.resize(boundary_.size());
        for_each_edge([&](std::uint32_t n, std::size_t k, double slope) { slopes_[n][k] = slope; });
    }
    static Point sum(const Corners<D>& corner) noexcept {
        auto sum = corner[0];
        for (std::size_t k = 1; k < D; ++k) sum = sum + corner[k];
        return sum;
    }
    Point inwards(std::uint32_t n, bool front) const noexcept {
        return (front ? -1.0 : 1.0) * boundary_.normal(n);
    }
    /// Returns the distance across the domain from a point on a facet to the opposite facet (Shapira, Shamir,
    /// Cohen-Or, Visual Computer 24 (2008)). If `front` is false and the facet is not a wall, the distance is
    /// across the outside. Returns infinity if the first facet on the ray does not face this one. Returns
    /// infinity too if that facet has a common vertex with this one, because a wedge has no thickness. A
    /// distance of `most` or more also counts as infinity.
    double thickness(std::uint32_t from_facet, bool front, const Point& from,
                     double most = std::numeric_limits<double>::infinity()) {
        constexpr double none = std::numeric_limits<double>::infinity();
        const auto direction = inwards(from_facet, front);
        if (!(dot(direction, direction) > 0)) return none;
        double nearest = (std::min)(most, std::ldexp(2.0, int(boundary_.depth())));
        std::uint32_t met = from_facet;
        const bool is_outside = !front && boundary_[from_facet].separates;
        // The cosine between the ray and the facet's normal, positive if the facet faces the ray.
        const auto faces = [&](std::uint32_t n) {
            const double along = dot(direction, boundary_.normal(n));
            return boundary_[n].separates ? (is_outside ? -along : along) : std::fabs(along);
        };
        const auto meet = [&](std::uint32_t n) {
            const PlacedFacet<D>& facet = boundary_[n];
            if (n == from_facet || !(faces(n) > 1e-9)) return nearest;
            const double along = dot(direction, boundary_.normal(n));
            const double t = dot(boundary_.normal(n), facet.corner[0] - from) / along;
            // Of two facets at the same distance, the one with the lower index counts.
            const bool is_first = t < nearest || (t == nearest && met != from_facet && n < met);
            if (!(t > touching && is_first)) return nearest;
            for (const double w : weights_in_plane(facet, from + t * direction)) {
                if (w < -1e-9) return nearest;
            }
            nearest = t;
            met = n;
            return nearest;
        };
        std::uint32_t& faced = faced_[std::size_t{2} * from_facet + (front ? 0 : 1)];
        (void)meet(faced); // likely the result, which limits the search
        boundary_.for_each_on_ray(from, direction, nearest, meet);
        if (met == from_facet) return none;
        faced = met;
        bool counts = faces(met) > facing;
        for (const std::uint32_t v : boundary_[met].vertex) counts = counts && !boundary_[from_facet].has(v);
        return counts ? nearest : none;
    }

    struct Piece {
        std::uint32_t facet;
        bool front;
        Corners<D> corner;
    };
    void add_patches(const Piece& piece, double largest_area, std::vector<Patch>& patches) {
        const auto& c = piece.corner;
        const double area = measure(c);
        if (area > largest_area) {
            const std::size_t first = longest_edge(c).first, second = (first + 1) % D;
            for (const std::size_t moved : {first, second}) {
                auto half = piece;
                half.corner[moved] = 0.5 * (c[first] + c[second]);
                add_patches(half, largest_area, patches);
            }
            return;
        }
        auto& patch = patches.emplace_back();
        patch.area = area;
        patch.altitude = altitudes_[piece.facet];
        patch.root_area = root_areas_[piece.facet];
        patch.thickness = thickness(piece.facet, piece.front, (1.0 / D) * sum(c));
        if constexpr (D == 3) {
            const auto& whole = boundary_[piece.facet].corner;
            patch.slopes = slopes_[piece.facet];
            for (std::size_t k = 0; k < 3; ++k)
                patch.lengths[k] = length(whole[(k + 2) % 3] - whole[(k + 1) % 3]) / measure(whole);
        }
    }
    double by_facet(std::uint32_t n) const noexcept {
        return (std::min)(altitudes_[n] / options_.per_facet, options_.of_root_area * root_areas_[n]);
    }
    double size_of(std::uint32_t n, bool front, const Point& position) {
        return (std::max)(
            1.0, (std::min)({largest_, by_facet(n), thickness(n, front, position) / options_.across}));
    }

    const Boundary& boundary_;
    grid::RefinementOptions options_;
    double cage_size_, largest_;
    std::vector<std::uint32_t> faced_; ///< per facet and side: result of the last ray, to limit the next one
    std::vector<double> altitudes_;    ///< per facet
    std::vector<double> root_areas_;   ///< per facet: square root of its area
    /// 3D: [facet][corner] is the largest slope of a hat function, on a facet at the edge opposite to the
    /// corner.
    std::vector<std::array<double, D>> slopes_;
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
