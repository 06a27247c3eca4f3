// The vertices and edges that need smaller cells than their facets, because functions are singular there or
// data has kinks.
#pragma once

#include <cageform/grid/tree/cell_sizes.hpp>

#include <numbers>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A segment or a point with small cells around it.
template <std::size_t D>
struct Feature {
    Vec<double, D> begin, end;
    double size;      ///< of the cells at the feature, in units
    double gradation; ///< minimum ratio of distance to cell size near the feature
    SizeReason reason;

    /// Returns the size that the feature allows for a cell with a given middle.
    double size_at(const Vec<double, D>& middle) const noexcept {
        const auto along = end - begin;
        const double all = dot(along, along);
        const double fraction = all > 0 ? std::clamp(dot(middle - begin, along) / all, 0.0, 1.0) : 0;
        return (std::max)(size, length(middle - (begin + fraction * along)) / gradation);
    }
};

struct FacetCorner {
    std::uint32_t vertex, facet, corner;
};
template <std::size_t D>
std::vector<FacetCorner> corners_of(const grid::TreeBoundary<D>& boundary) {
    std::vector<FacetCorner> corners;
    for (std::uint32_t n = 0; n < boundary.size(); ++n) {
        for (std::uint32_t k = 0; k < D; ++k) corners.push_back({boundary[n].vertex[k], n, k});
    }
    return corners;
}
/// For every vertex, calls f with the parts of facets that have this `vertex`, in ascending order of facets.
template <class Part, class F>
void for_each_vertex(std::vector<Part> parts, const F& f) {
    std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
        return a.vertex != b.vertex ? a.vertex < b.vertex : a.facet < b.facet;
    });
    for (auto begin = parts.begin(), end = begin; begin != parts.end(); begin = end) {
        while (end != parts.end() && end->vertex == begin->vertex) ++end;
        f(std::span<const Part>(begin, end));
    }
}

template <std::size_t D>
class Features;

/// The features in 2D: vertices where functions decrease like a power below two of the distance.
template <>
class Features<2> {
public:
    /// `sizes` must outlive it.
    explicit Features(CellSizes<2>& sizes)
        : sizes_(sizes)
        , boundary_(sizes.boundary()) {}

    std::vector<Feature<2>> find() {
        std::vector<Feature<2>> features;
        for_each_vertex(corners_of(boundary_), [&](std::span<const End> about) {
            const double levels = std::round(sizes_.options().corner_levels / exponent(about));
            if (levels > 0) add(about, levels, features);
        });
        return features;
    }
    /// Returns the sum over all vertices of 1/α, the factors of corner_levels.
    double inverse_exponents() const {
        double sum = 0;
        for_each_vertex(corners_of(boundary_),
                        [&](std::span<const End> about) { sum += 1 / exponent(about); });
        return sum;
    }

private:
    using End = FacetCorner; ///< the end of an edge

    /// Returns the exponent α such that the steepest functions at a vertex decrease like distance^α: π over
    /// the interior angle. Returns infinity if the vertex needs no smaller cells.
    double exponent(std::span<const End> about) const noexcept {
        constexpr double pi = std::numbers::pi, obtuse = 0.55 * pi;
        double angle = about.size() == 1 ? 2 * pi : pi;
        if (about.size() == 2) {
            const auto &a = boundary_[about[0].facet], &b = boundary_[about[1].facet];
            const auto u = across(about[0]), v = across(about[1]);
            const double size = length(u) * length(v);
            if (!(size > 0)) return std::numeric_limits<double>::infinity();
            angle = std::acos(std::clamp(dot(u, v) / size, -1.0, 1.0));
            const bool convex = dot(boundary_.normal(about[0].facet), v) < 0;
            if (!a.separates && !b.separates) {
                angle = (std::max)(angle, 2 * pi - angle);
            } else if (a.separates && b.separates && !convex) {
                angle = 2 * pi - angle;
            } else if (a.separates != b.separates) {
                angle = pi;
            }
        }
        return angle > obtuse ? pi / angle : std::numeric_limits<double>::infinity();
    }
    /// Returns the vector from a vertex along its edge to the other end.
    Vec<double, 2> across(const End& end) const noexcept {
        const auto& corner = boundary_[end.facet].corner;
        return corner[1 - end.corner] - corner[end.corner];
    }
    /// Adds a vertex with the cell size of its edges, halved `levels` times.
    void add(std::span<const End> about, double levels, std::vector<Feature<2>>& features) {
        const auto position = boundary_[about[0].facet].corner[about[0].corner];
        double size = sizes_.largest();
        for (const End& end : about) size = (std::min)(size, sizes_.size_near(end.facet, position));
        features.push_back({position, position, (std::max)(std::ldexp(size, -int(levels)), 1.0),
                            sizes_.options().corner_gradation, SizeReason::singular_vertex});
    }

    CellSizes<2>& sizes_;
    const grid::TreeBoundary<2>& boundary_;
};

/// The features in 3D: pieces of reflex edges, their ends, and other vertices of more than three facets.
template <>
class Features<3> {
public:
    /// `sizes` must outlive it.
    explicit Features(CellSizes<3>& sizes)
        : sizes_(sizes)
        , boundary_(sizes.boundary()) {}

    std::vector<Feature<3>> find() {
        std::vector<Feature<3>> features;
        const auto reflex = reflex_edges();
        for (const auto& about : reflex) add_edge(about, features);
        add_vertices(reflex, features);
        return features;
    }

private:
    using Point = Vec<double, 3>;
    static constexpr std::size_t pieces = 8; ///< pieces of a singular edge, each with its own size
    static constexpr double edge_gradation = 1.5, vertex_gradation = 2, spike_gradation = 1;

    struct Ridge { // an edge of a facet
        std::array<std::uint32_t, 2> vertex;
        std::uint32_t facet;
        std::uint32_t apex; ///< the facet's corner opposite to the edge
    };
    /// Returns, for each reflex edge or boundary edge of a wall, the facets that meet there.
    std::vector<std::vector<Ridge>> reflex_edges() const {
        std::vector<Ridge> ridges;
        for (std::uint32_t n = 0; n < boundary_.size(); ++n) {
            for (std::uint32_t apex = 0; apex < 3; ++apex) {
                const std::uint32_t a = boundary_[n].vertex[(apex + 1) % 3];
                const std::uint32_t b = boundary_[n].vertex[(apex + 2) % 3];
                ridges.push_back({{(std::min)(a, b), (std::max)(a, b)}, n, apex});
            }
        }
        std::vector<std::vector<Ridge>> reflex;
        for_each_vertex(std::move(ridges), [&](std::span<const Ridge> about) {
            if (is_reflex(about)) reflex.emplace_back(about.begin(), about.end());
        });
        return reflex;
    }
    /// Whether functions are singular at an edge: the interior angle exceeds 180 degrees, or a wall ends or
    /// bends there.
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
    /// Returns the vector from an edge to the opposite corner, perpendicular to the edge.
    Point across(const Ridge& ridge) const noexcept {
        const auto& corner = boundary_[ridge.facet].corner;
        const auto& a = corner[(ridge.apex + 1) % 3];
        const auto along = corner[(ridge.apex + 2) % 3] - a, to_apex = corner[ridge.apex] - a;
        const double all = dot(along, along);
        return all > 0 ? to_apex - (dot(to_apex, along) / all) * along : to_apex;
    }
    void add_edge(std::span<const Ridge> about, std::vector<Feature<3>>& features) {
        const auto& corner = boundary_[about[0].facet].corner;
        const auto a = corner[(about[0].apex + 1) % 3], b = corner[(about[0].apex + 2) % 3];
        for (std::size_t n = 0; n < pieces; ++n) {
            const auto at = [&](double fraction) {
                return a + ((double(n) + fraction) / double(pieces)) * (b - a);
            };
            double size = sizes_.largest();
            for (const Ridge& ridge : about) size = (std::min)(size, sizes_.size_near(ridge.facet, at(0.5)));
            size = (std::max)(size * std::exp2(-sizes_.options().edge_levels), 1.0);
            features.push_back({at(0), at(1), size, edge_gradation, SizeReason::singular_edge});
        }
    }
    /// Adds the vertices that need smaller cells than their facets: the ends of reflex edges, vertices of
    /// more than three facets, and vertices of walls.
    void add_vertices(std::span<const std::vector<Ridge>> reflex, std::vector<Feature<3>>& features) {
        const auto& options = sizes_.options();
        std::vector<std::uint32_t> ends;
        for (const auto& about : reflex)
            ends.insert(ends.end(), about[0].vertex.begin(), about[0].vertex.end());
        std::sort(ends.begin(), ends.end());
        for_each_vertex(corners_of(boundary_), [&](std::span<const FacetCorner> about) {
            const auto& [vertex, facet, corner] = about[0];
            // Functions are nearly linear at a vertex of three facets.
            if (about.size() <= 3 && boundary_[facet].separates) return;
            const auto position = boundary_[facet].corner[corner];
            double size = sizes_.largest();
            for (const auto& at : about) size = (std::min)(size, sizes_.size_near(at.facet, position));
            const bool is_end = std::binary_search(ends.begin(), ends.end(), vertex);
            const double here =
                (std::max)(1.0, (std::min)(is_end ? size * std::exp2(-options.reflex_levels) : size,
                                           options.at_vertex * sizes_.cage_size()));
            if (here < size)
                features.push_back({position, position, here, vertex_gradation, SizeReason::singular_vertex});
            if (is_end) add_spike(about, size, features);
        });
    }
    /// Adds the cells near a vertex where functions decrease like a power λ < 1 of the distance. If the
    /// outside is narrow there, adds cells along the edges too. `size` is the size that the facets allow.
    void add_spike(std::span<const FacetCorner> about, double size, std::vector<Feature<3>>& features) const {
        constexpr double most_levels = 10, narrow = 2.2; // in steradians
        const double angle = angle_outside(about), levels = sizes_.options().reflex_levels;
        // λ is the smallest root of P_λ(cos θ) for a circular cone of half-angle θ with the solid angle
        // `angle` outside. The formula is within 2 % of 1/λ for θ from 90 to 175 degrees.
        const double inverse = 1 + 0.95 * std::log(2 * std::numbers::pi / angle);
        if (!(inverse > 1)) return;
        const auto position = boundary_[about[0].facet].corner[about[0].corner];
        const double least = (std::max)(1.0, size * std::exp2(-(std::min)(levels * inverse, most_levels)));
        features.push_back({position, position, least, spike_gradation, SizeReason::singular_vertex});
        if (angle > narrow) return;
        // If `levels` is 2, a cell at a distance r from the vertex is as large as the radius of the cone
        // there. The smallest size is r / 32. Each further level halves the cells.
        const double slope =
            (std::max)(std::sqrt(angle / std::numbers::pi), 1.0 / 32) * std::exp2(2 - levels);
        for (const auto& at : about) {
            auto edge = boundary_[at.facet].corner[(at.corner + 1) % 3] - position;
            for (double here = 0.5 * slope * length(edge); here > least; here *= 0.5, edge = 0.5 * edge) {
                if (here < size)
                    features.push_back({position + 0.5 * edge, position + edge, here, edge_gradation,
                                        SizeReason::singular_vertex});
            }
        }
    }
    /// Returns the solid angle outside the domain at a vertex, at most 2π. Returns 2π at walls, at faces
    /// without area, and for angles below 1e-6.
    double angle_outside(std::span<const FacetCorner> about) const noexcept {
        constexpr double full = 4 * std::numbers::pi;
        const Point axis{0.2, 0.4, std::sqrt(0.8)}; // arbitrary
        double sum = 0;                             // the angle, up to multiples of `full`
        for (const auto& at : about) {
            if (!boundary_[at.facet].separates) return full / 2;
            const auto& corner = boundary_[at.facet].corner;
            const auto direction = [&](std::size_t k) {
                const auto edge = corner[(at.corner + k) % 3] - corner[at.corner];
                return (1 / length(edge)) * edge;
            };
            const Point u = direction(1), v = direction(2), normal = cross(u, v);
            // van Oosterom, Strackee, IEEE Trans. Biomed. Eng. 30 (1983), eq. 8
            const double angle =
                2 * std::atan2(dot(axis, normal), 1 + dot(u, v) + dot(v, axis) + dot(axis, u));
            sum += dot(normal, boundary_.normal(at.facet)) < 0 ? -angle : angle;
        }
        const double angle = sum - full * std::floor(sum / full);
        return angle > 1e-6 && angle < full / 2 ? angle : full / 2;
    }

    CellSizes<3>& sizes_;
    const grid::TreeBoundary<3>& boundary_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
