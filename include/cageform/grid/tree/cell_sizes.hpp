// Chooses the largest allowed cell size at each point, in space.
//
// The size depends on the thickness of the domain, on the altitudes of its facets, and on the edges
// and vertices where functions are singular. grid/tree/refinement.hpp splits cells accordingly.
#pragma once

#include <cageform/core/detail/in_parallel.hpp>
#include <cageform/core/types/solver_report.hpp>
#include <cageform/grid/tree/bone_sizes.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

struct RefinementOptions {
    double across = 6;    ///< cells across the thickness of the domain
    double per_facet = 1; ///< cells along the least altitude of a facet
    /// The largest cell at a facet, in roots of its area.
    double of_root_area = std::numeric_limits<double>::infinity();
    double edge_levels = 1;   ///< extra halvings at reflex edges and rims of walls
    double reflex_levels = 1; ///< extra halvings at the ends of such edges
    /// Largest cell at a vertex of more than three facets, as a fraction of the cage's size.
    double at_vertex = 1.0 / 16;
    double per_radius = 12; ///< see BoneSizes
    /// Largest cell anywhere, as a fraction of the same: the distance between two far vertices.
    double largest = 1.0 / 16;
};

} // namespace grid

namespace detail {

/// Computes the allowed cell sizes, in units.
class CellSizes {
public:
    using Boundary = grid::TreeBoundary<3>;
    using Cell = grid::CellTree<3>::Cell;
    using Point = Vec<double, 3>;

    /// An upper limit of a cell's size, and its reason.
    struct Demand {
        double size;
        SizeReason reason;
    };
    /// A singular segment or point, about which cells are small.
    struct Feature {
        Point begin, end;
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
            altitudes_.push_back(altitude(boundary[n]));
            root_areas_.push_back(std::sqrt(0.5 * length(normal_of(boundary[n]))));
        }
    }
    double largest() const noexcept { return largest_; }

    /// Returns the distance between two vertices far from each other. It is nearly the largest, and
    /// independent of how the cage is rotated.
    static double size_of_cage(const Boundary& boundary) noexcept {
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

    /// Returns the size that facets allow for a cell that they pass. Rays across the domain are
    /// only as long as matters to cells of that size.
    ///
    ///   thin  out: points are added where the domain is thin enough to require cells of this size
    Demand of_facets(std::span<const std::uint32_t> facets, const Cell& cell, const Point& middle,
                     std::vector<ThinPoint>& thin) {
        const double most = options_.across * (std::min)(2.0 * cell.size, largest_);
        Demand least{largest_, SizeReason::largest};
        for (const std::uint32_t n : facets) {
            if (n >= boundary_.size()) break; // a bone
            if (by_facet(n) < least.size) least = {by_facet(n), SizeReason::facet};
            const auto& facet = boundary_[n];
            const auto position = facet.position(nearest_on_facet(middle, facet.corner));
            for (const bool front : {true, false}) {
                if (!front && facet.separates) continue;
                const double t = thickness(n, front, position, most),
                             size = (std::max)(t / options_.across, 1.0);
                if (size < least.size) least = {size, SizeReason::thickness};
                if (t < most && size >= cell.size) thin.push_back({position, inwards(n, front), size, t});
            }
        }
        return least;
    }

    /// A piece of the boundary, for RefinementPlanner.
    struct Patch {
        double area, altitude, root_area, thickness; ///< altitude and root of the area of its facet
    };
    /// Divides the facets, and both sides of walls, into patches. Cost: a ray for each patch.
    std::vector<Patch> patches(const Running& running) const {
        constexpr double most = 2000; // patches beyond one for each facet
        double area = 0;
        for (std::uint32_t n = 0; n < boundary_.size(); ++n) area += 0.5 * length(normal_of(boundary_[n]));
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

    // ---- what is singular ---------------------------------------------------------------------------

    /// Returns the features: reflex edges, cut in pieces, their ends, and other vertices of more
    /// than three facets.
    std::vector<Feature> features() {
        std::vector<Feature> features;
        const auto reflex = reflex_edges();
        for (const auto& about : reflex) add_edge(about, features);
        add_vertices(reflex, features);
        return features;
    }
    /// Returns the size that a feature allows for a cell with a given middle. It grows with the
    /// distance from the feature.
    static double size_at(const Feature& feature, const Point& middle) noexcept {
        const auto along = feature.end - feature.begin;
        const double all = dot(along, along);
        const double fraction = all > 0 ? std::clamp(dot(middle - feature.begin, along) / all, 0.0, 1.0) : 0;
        const double distance = length(middle - (feature.begin + fraction * along));
        return (std::max)(feature.size, distance / (all > 0 ? edge_gradation : vertex_gradation));
    }

private:
    /// In units; bodies nearer than this are taken as sharing a plane.
    static constexpr double touching = 0.01;
    /// Least cosine between two facets' normals for a thickness to be measured between them.
    static constexpr double facing = 0.7;
    static constexpr std::size_t pieces = 8; ///< pieces of a singular edge, each with its own size
    /// A cell near a feature is no larger than its distance from the feature divided by this.
    static constexpr double edge_gradation = 1.5, vertex_gradation = 2;

    static double altitude(const PlacedFacet<3>& facet) noexcept {
        const double longest = longest_edge(facet.corner).second;
        return longest > 0 ? length(normal_of(facet)) / longest : 0;
    }
    /// Returns the corner where the longest edge begins, and its length.
    static std::pair<std::size_t, double> longest_edge(const Corners<3>& corner) noexcept {
        std::pair<std::size_t, double> longest{0, 0};
        for (std::size_t k = 0; k < 3; ++k) {
            const double l = length(corner[(k + 1) % 3] - corner[k]);
            if (l > longest.second) longest = {k, l};
        }
        return longest;
    }
    Point inwards(std::uint32_t n, bool front) const noexcept {
        return (front ? -1.0 : 1.0) * boundary_.normal(n);
    }
    /// Returns the distance across the domain from a point on a facet to the facet that faces it
    /// (Shapira, Shamir, Cohen-Or, Visual Computer 24 (2008)). Returns infinity if the first facet
    /// met does not face it, shares a vertex with it (a wedge has no thickness), or is `most` or
    /// farther away.
    double thickness(std::uint32_t from_facet, bool front, const Point& from,
                     double most = std::numeric_limits<double>::infinity()) {
        constexpr double none = std::numeric_limits<double>::infinity();
        const auto direction = inwards(from_facet, front);
        if (!(dot(direction, direction) > 0)) return none;
        double nearest = (std::min)(most, std::ldexp(2.0, int(boundary_.depth())));
        std::uint32_t met = from_facet;
        const auto meet = [&](std::uint32_t n) {
            const PlacedFacet<3>& facet = boundary_[n];
            const double along = dot(direction, boundary_.normal(n));
            if (n == from_facet || !((facet.separates ? along : std::fabs(along)) > 1e-9)) return nearest;
            const double t = dot(boundary_.normal(n), facet.corner[0] - from) / along;
            // If two facets are at the same distance, the first counts, whichever was met before.
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
        (void)meet(faced); // it is likely met again, and then limits the search
        boundary_.for_each_on_ray(from, direction, nearest, meet);
        if (met == from_facet) return none;
        faced = met;
        const double along = dot(direction, boundary_.normal(met));
        bool counts = (boundary_[met].separates ? along : std::fabs(along)) > facing;
        for (const std::uint32_t v : boundary_[met].vertex) counts = counts && !boundary_[from_facet].has(v);
        return counts ? nearest : none;
    }

    struct Piece {
        std::uint32_t facet;
        bool front;
        Corners<3> corner;
    };
    void add_patches(const Piece& piece, double largest_area, std::vector<Patch>& patches) {
        const auto& c = piece.corner;
        const double area = 0.5 * length(cross(c[1] - c[0], c[2] - c[0]));
        if (area > largest_area) {
            const std::size_t first = longest_edge(c).first, second = (first + 1) % 3;
            for (const std::size_t moved : {first, second}) {
                auto half = piece;
                half.corner[moved] = 0.5 * (c[first] + c[second]);
                add_patches(half, largest_area, patches);
            }
            return;
        }
        const auto middle = (1.0 / 3) * (c[0] + c[1] + c[2]);
        patches.push_back({area, altitudes_[piece.facet], root_areas_[piece.facet],
                           thickness(piece.facet, piece.front, middle)});
    }
    double by_facet(std::uint32_t n) const noexcept {
        return (std::min)(altitudes_[n] / options_.per_facet, options_.of_root_area * root_areas_[n]);
    }
    double size_of(std::uint32_t n, bool front, const Point& position) {
        return (std::max)(
            1.0, (std::min)({largest_, by_facet(n), thickness(n, front, position) / options_.across}));
    }
    /// Returns the size that a facet allows near a point on its rim.
    double size_near(std::uint32_t n, const Point& position) {
        const auto& c = boundary_[n].corner;
        const auto within = 0.95 * position + (0.05 / 3) * (c[0] + c[1] + c[2]);
        const double size = size_of(n, true, within);
        return boundary_[n].separates ? size : (std::min)(size, size_of(n, false, within));
    }

    struct Ridge { ///< an edge of a facet
        std::array<std::uint32_t, 2> vertex;
        std::uint32_t facet;
        std::uint32_t apex; ///< the facet's corner opposite the edge
    };
    /// Returns, for each reflex edge or rim of a wall, the facets that meet there.
    std::vector<std::vector<Ridge>> reflex_edges() const {
        std::vector<Ridge> ridges;
        for (std::uint32_t n = 0; n < boundary_.size(); ++n) {
            for (std::uint32_t apex = 0; apex < 3; ++apex) {
                const std::uint32_t a = boundary_[n].vertex[(apex + 1) % 3];
                const std::uint32_t b = boundary_[n].vertex[(apex + 2) % 3];
                ridges.push_back({{(std::min)(a, b), (std::max)(a, b)}, n, apex});
            }
        }
        std::sort(ridges.begin(), ridges.end(), [](const Ridge& a, const Ridge& b) {
            return a.vertex != b.vertex ? a.vertex < b.vertex : a.facet < b.facet;
        });
        std::vector<std::vector<Ridge>> reflex;
        for (auto begin = ridges.begin(), end = begin; begin != ridges.end(); begin = end) {
            while (end != ridges.end() && end->vertex == begin->vertex) ++end;
            if (is_reflex({begin, end})) reflex.emplace_back(begin, end);
        }
        return reflex;
    }
    /// Tells whether functions are singular at an edge: the domain has an angle of more than 180
    /// degrees there, or a wall ends or bends there.
    bool is_reflex(std::span<const Ridge> about) const noexcept {
        constexpr double flat = -0.988; // the cosine of 171 degrees
        if (about.size() != 2) return about.size() == 1;
        const bool separates = boundary_[about[0].facet].separates;
        const auto u = across(about[0]), v = across(about[1]);
        const double size = length(u) * length(v);
        if (!(size > 0) || separates != boundary_[about[1].facet].separates || dot(u, v) < flat * size)
            return false;
        return !separates || dot(boundary_.normal(about[0].facet), v) > 0;
    }
    /// Returns the vector from an edge to the opposite corner, at a right angle to the edge.
    Point across(const Ridge& ridge) const noexcept {
        const auto& corner = boundary_[ridge.facet].corner;
        const auto& a = corner[(ridge.apex + 1) % 3];
        const auto along = corner[(ridge.apex + 2) % 3] - a, to_apex = corner[ridge.apex] - a;
        const double all = dot(along, along);
        return all > 0 ? to_apex - (dot(to_apex, along) / all) * along : to_apex;
    }
    void add_edge(std::span<const Ridge> about, std::vector<Feature>& features) {
        const auto& corner = boundary_[about[0].facet].corner;
        const auto a = corner[(about[0].apex + 1) % 3], b = corner[(about[0].apex + 2) % 3];
        for (std::size_t n = 0; n < pieces; ++n) {
            const auto at = [&](double fraction) {
                return a + ((double(n) + fraction) / double(pieces)) * (b - a);
            };
            double size = largest_;
            for (const Ridge& ridge : about) size = (std::min)(size, size_near(ridge.facet, at(0.5)));
            size = (std::max)(size * std::exp2(-options_.edge_levels), 1.0);
            features.push_back({at(0), at(1), size, SizeReason::singular_edge});
        }
    }
    /// Adds the vertices that need smaller cells than their facets do: the ends of reflex edges,
    /// vertices of more than three facets, and vertices of walls.
    void add_vertices(std::span<const std::vector<Ridge>> reflex, std::vector<Feature>& features) {
        std::vector<std::uint32_t> ends;
        for (const auto& about : reflex)
            ends.insert(ends.end(), about[0].vertex.begin(), about[0].vertex.end());
        std::sort(ends.begin(), ends.end());
        std::vector<std::pair<std::uint32_t, std::uint32_t>> corners; // a vertex, 3 · facet + corner
        for (std::uint32_t n = 0; n < boundary_.size(); ++n) {
            for (std::uint32_t k = 0; k < 3; ++k) corners.push_back({boundary_[n].vertex[k], 3 * n + k});
        }
        std::sort(corners.begin(), corners.end());
        for (auto begin = corners.begin(), end = begin; begin != corners.end(); begin = end) {
            while (end != corners.end() && end->first == begin->first) ++end;
            const std::uint32_t facet = begin->second / 3;
            // Functions are nearly linear at such a vertex.
            if (end - begin <= 3 && boundary_[facet].separates) continue;
            const auto position = boundary_[facet].corner[begin->second % 3];
            double size = largest_;
            for (auto at = begin; at != end; ++at)
                size = (std::min)(size, size_near(at->second / 3, position));
            const bool is_end = std::binary_search(ends.begin(), ends.end(), begin->first);
            const double here =
                (std::max)(1.0, (std::min)(is_end ? size * std::exp2(-options_.reflex_levels) : size,
                                           options_.at_vertex * cage_size_));
            if (here < size) features.push_back({position, position, here, SizeReason::singular_vertex});
        }
    }

    const Boundary& boundary_;
    grid::RefinementOptions options_;
    double cage_size_, largest_;
    std::vector<std::uint32_t> faced_; ///< by facet and side: the facet that the last ray from it met
    std::vector<double> altitudes_;    ///< by facet
    std::vector<double> root_areas_;   ///< by facet: the root of its area
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
