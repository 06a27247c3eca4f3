// The facets and bones of a cage in units of a tree: the cells that they intersect, and their intersections
// with rays and axis lines.
#pragma once

#include <cageform/cage/detail/box_tree.hpp>
#include <cageform/core/detail/disjoint_sets.hpp>
#include <cageform/grid/lattice/bones.hpp>
#include <cageform/grid/lattice/placed_facet.hpp>
#include <cageform/grid/tree/cell_tree.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace detail {

/// Whether a facet intersects a box given by its middle and half side, by the separating axis test
/// (Gottschalk, Lin, Manocha 1996; for triangles Akenine-Möller 2001).
inline bool passes(const PlacedFacet<2>& edge, const Vec<double, 2>& middle, double half) noexcept {
    const auto a = edge.corner[0] - middle, b = edge.corner[1] - middle, along = b - a;
    for (std::size_t k = 0; k < 2; ++k) {
        if ((std::min)(a[k], b[k]) > half || (std::max)(a[k], b[k]) < -half) return false;
    }
    return std::fabs(cross(a, along)) <= half * (std::fabs(along[0]) + std::fabs(along[1]));
}
inline bool passes(const PlacedFacet<3>& face, const Vec<double, 3>& middle, double half) noexcept {
    std::array<Vec<double, 3>, 3> c;
    for (std::size_t n = 0; n < 3; ++n) c[n] = face.corner[n] - middle;
    for (std::size_t k = 0; k < 3; ++k) {
        if ((std::min)({c[0][k], c[1][k], c[2][k]}) > half || (std::max)({c[0][k], c[1][k], c[2][k]}) < -half)
            return false;
    }
    const auto n = cross(c[1] - c[0], c[2] - c[0]);
    if (std::fabs(dot(n, c[0])) > half * (std::fabs(n[0]) + std::fabs(n[1]) + std::fabs(n[2]))) return false;
    for (std::size_t e = 0; e < 3; ++e) {
        const auto along = c[(e + 1) % 3] - c[e];
        // The axis perpendicular to the edge and a coordinate axis.
        for (const auto& [u, v] : other_axes) {
            const double side = along[u] * c[e][v] - along[v] * c[e][u];
            const auto& opposite = c[(e + 2) % 3];
            const double other = along[u] * opposite[v] - along[v] * opposite[u];
            const double reach = half * (std::fabs(along[u]) + std::fabs(along[v]));
            if ((std::min)(side, other) > reach || (std::max)(side, other) < -reach) return false;
        }
    }
    return true;
}

/// Returns the position where an axis line crosses a facet, if it does. The line is given in multiples of
/// 2^-fraction units. Integer arithmetic decides, so every line crosses a closed boundary an even number of
/// times.
inline std::optional<double> crossing(const PlacedFacet<2>& edge, std::size_t axis,
                                      const std::array<std::int64_t, 2>& line, int fraction) noexcept {
    const std::size_t across = 1 - axis;
    const double at = std::ldexp(double(line[across]), -fraction);
    const double from = edge.corner[0][across], to = edge.corner[1][across];
    if (!(at >= (std::min)(from, to) && at < (std::max)(from, to))) return std::nullopt;
    const double s = (at - from) / (to - from);
    return edge.coordinate({1 - s, s}, axis);
}
inline std::optional<double> crossing(const PlacedFacet<3>& face, std::size_t axis,
                                      const std::array<std::int64_t, 3>& line, int fraction) noexcept {
    const auto [u, v] = other_axes[axis];
    const FaceAcross across(face, axis, fraction);
    if (across.is_edge_on() || !across.crosses({line[u], line[v]})) return std::nullopt;
    const auto w = weights_at(face, axis, std::ldexp(double(line[u]), -fraction),
                              std::ldexp(double(line[v]), -fraction));
    if (!w) return std::nullopt;
    return face.coordinate(onto_facet(*w), axis);
}

} // namespace detail
namespace grid {

/// The boundary of a cage in units of the tree. Its elements are the facets of the boundary and of interior
/// cells (walls), then the bones. The inside of a bone is not in the domain. The vertices of facets are
/// rounded to 2⁻³⁰ of the tree's cube, so that integer arithmetic can decide what is inside.
template <std::size_t D>
class TreeBoundary {
public:
    using Facet = PlacedFacet<D>;
    using Index = std::array<std::int32_t, D>;

    /// The cage must pass `check`.
    ///
    ///   tolerance  an element this close to a cell counts as intersecting it; in units of the cage
    ///   scale      the side of the cube, in multiples of the cage's longest side; at least 1
    template <class Cage>
    TreeBoundary(const Cage& cage, unsigned depth, double tolerance = 0, double scale = 1)
        : depth_(depth)
        , fraction_(30 - int(depth))
        , scale_(scale) {
        const auto bounds = bounds_of(cage.vertices());
        const auto lower = vec_cast<double>(bounds.lower), extent = vec_cast<double>(bounds.upper) - lower;
        double longest = 0;
        for (std::size_t k = 0; k < D; ++k) longest = std::fmax(longest, scale * extent[k]);
        unit_ = std::ldexp(longest, -int(depth));
        slack_ = rounding + std::ldexp(1.0, -fraction_) + tolerance / unit_;
        for (std::size_t k = 0; k < D; ++k) origin_[k] = lower[k] - 0.5 * (longest - extent[k]);
        std::vector<Vec<double, D>> placed, rounded;
        for (const auto& vertex : cage.vertices()) {
            auto p = in_units(vec_cast<double>(vertex));
            placed.push_back(p);
            for (std::size_t k = 0; k < D; ++k)
                p[k] = std::ldexp(std::round(std::ldexp(p[k], fraction_)), -fraction_);
            rounded.push_back(p);
        }
        const auto add = [&](const auto& facet, bool separates) {
            facets_.push_back({facet, std::span<const Vec<double, D>>(rounded), separates});
            exact_.push_back({facet, std::span<const Vec<double, D>>(placed), separates});
        };
        for_each_facet(boundary_of(cage), [&](const auto& facet) { add(facet, true); });
        for (const auto& facet : interior_cells(cage).facets) add(facet, false);
        boxes_ = detail::BoxTree<D>(facets_.size(), [&](std::uint32_t n) { return facets_[n].bounds(); });
        bones_ = GridBones<D>(interior_cells(cage).bones, std::span<const Vec<double, D>>(placed),
                              Lattice<double, D>{{}, origin_, unit_});
        for (const Facet& facet : facets_) {
            const auto normal = detail::normal_of(facet);
            const double size = detail::length(normal);
            normals_.push_back(size > 0 ? (1 / size) * normal : Vec<double, D>{});
        }
        orient_normals_outward(rounded.size());
    }

    unsigned depth() const noexcept { return depth_; }
    double unit() const noexcept { return unit_; }   ///< in units of the cage
    double scale() const noexcept { return scale_; } ///< side of the cube / longest side of the cage
    int fraction() const noexcept { return fraction_; }
    Vec<double, D> in_units(const Vec<double, D>& p) const noexcept { return (1 / unit_) * (p - origin_); }
    Vec<double, D> in_cage(const Vec<double, D>& p) const noexcept { return origin_ + unit_ * p; }

    std::size_t elements() const noexcept { return facets_.size() + bones_.size(); }
    /// Whether an element is a facet that separates inside from outside, not a wall.
    bool separates(std::size_t element) const noexcept {
        return element < size() && facets_[element].separates;
    }
    const GridBones<D>& bones() const noexcept { return bones_; }
    std::size_t size() const noexcept { return facets_.size(); } ///< number of facets
    const Facet& operator[](std::size_t facet) const noexcept { return facets_[facet]; }
    /// Returns a facet with unrounded vertices.
    const Facet& exact(std::size_t facet) const noexcept { return exact_[facet]; }
    /// Returns the unit normal, outward except at walls; zero if the facet has no area.
    const Vec<double, D>& normal(std::size_t facet) const noexcept { return normals_[facet]; }
    /// Calls visit(facet) for all facets, exact or rounded, that the segment from `from` to from + length ·
    /// direction may meet. visit returns the new length.
    template <class Visit>
    void for_each_on_ray(const Vec<double, D>& from, const Vec<double, D>& direction, double length,
                         const Visit& visit) const {
        boxes_.for_each_on_ray(from, direction, length, rounding + std::ldexp(1.0, -fraction_), visit);
    }

    /// Calls visit(facet) for all facets whose boxes are within a distance from a point.
    template <class Visit>
    void for_each_within(const Vec<double, D>& p, double distance, const Visit& visit) const {
        boxes_.for_each_near(p, distance * distance, [&](std::uint32_t facet) {
            visit(facet);
            return distance * distance;
        });
    }

    /// Whether an element intersects a cell or comes within the tolerance of it. Conservative for bones.
    bool passes(std::size_t element, const typename CellTree<D>::Cell& cell) const noexcept {
        const double half = 0.5 * cell.size;
        const auto middle = cell.middle();
        if (element < size()) return detail::passes(facets_[element], middle, half + slack_);
        return bones_[element - size()].distance(middle) <= half * std::sqrt(double(D)) + slack_;
    }
    /// Returns the intersection of a ray from inside with an element: a wall, a bone, or a facet where the
    /// ray leaves the domain.
    ///
    ///   rounded  whether facets are rounded or exact
    std::optional<Hit<D>> hit(std::size_t element, const AxisRay<D>& ray,
                              bool rounded = true) const noexcept {
        if (element >= size()) return bones_.hit(element - size(), ray);
        const auto& facet = rounded ? facets_[element] : exact_[element];
        const double along = ray.up ? normals_[element][ray.axis] : -normals_[element][ray.axis];
        if (facet.separates && !(along > 0)) return std::nullopt;
        return detail::hit(facet, ray);
    }
    /// Returns the nearest intersection of a ray with some elements.
    std::optional<Hit<D>> first_hit(std::span<const std::uint32_t> elements, AxisRay<D> ray) const noexcept {
        std::optional<Hit<D>> first;
        for (const std::uint32_t element : elements) {
            const auto found = hit(element, ray);
            if (!found || (first && !(ray.distance(found->position) < ray.length))) continue;
            first = found;
            ray.length = ray.distance(found->position);
        }
        return first;
    }

    /// Returns the distance along a ray from inside to the exact boundary, at most the ray's length.
    double free_distance(AxisRay<D> ray) const noexcept {
        Vec<double, D> direction{};
        direction[ray.axis] = ray.up ? 1 : -1;
        for_each_on_ray(ray.from, direction, ray.length, [&](std::uint32_t facet) {
            if (const auto found = hit(facet, ray, false))
                ray.length = std::fmin(ray.length, ray.distance(found->position));
            return ray.length;
        });
        for (std::size_t element = size(); element < elements(); ++element) {
            if (const auto found = hit(element, ray))
                ray.length = std::fmin(ray.length, ray.distance(found->position));
        }
        return std::fmax(ray.length, 0.0);
    }

    struct Meeting {
        double fraction; ///< the fraction of the segment before it, in [0, 1]
        BoundaryValue<D> value;
    };
    /// Follows the segment from `from`, which is inside, to `from + along`. Returns the first point where the
    /// segment meets a wall or leaves the domain. Considers only the given facets, rounded.
    std::optional<Meeting> first_met(const Vec<double, D>& from, const Vec<double, D>& along,
                                     std::span<const std::uint32_t> facets) const noexcept {
        Met met;
        for (const std::uint32_t n : facets) meet(facets_[n], normals_[n], from, along, met);
        return meeting_of(met, from, along);
    }
    /// As the overload above, but considers all facets, with exact vertices.
    std::optional<Meeting> first_met(const Vec<double, D>& from, const Vec<double, D>& along) const noexcept {
        Met met;
        for_each_on_ray(from, along, 1, [&](std::uint32_t n) {
            const auto normal = detail::normal_of(exact_[n]);
            meet(exact_[n], dot(normal, normals_[n]) < 0 ? -1.0 * normal : normal, from, along, met);
            return met.fraction;
        });
        return meeting_of(met, from, along);
    }

    struct Nearest {
        double distance; ///< negative within a bone
        BoundaryValue<D> value;
        Vec<double, D> position; ///< only for facets
    };
    /// Returns the nearest point of some elements, with rounded or exact facets.
    Nearest nearest(std::span<const std::uint32_t> elements, const Vec<double, D>& p,
                    bool rounded = true) const noexcept {
        Nearest best{std::numeric_limits<double>::infinity(), {}, {}};
        for (const std::uint32_t n : elements) {
            if (n >= size()) {
                // Bones overlap at joints, so the search covers all bones.
                const auto bone = bones_.nearest(p, best.distance);
                if (bone) best = {bone->distance, bone->value, {}};
                continue;
            }
            const Facet& facet = rounded ? facets_[n] : exact_[n];
            const auto weights = nearest_on_facet(p, facet.corner);
            const auto position = facet.position(weights);
            const double distance = detail::length(position - p);
            if (distance < best.distance) best = {distance, value_on_facet(facet.vertex, weights), position};
        }
        return best;
    }

private:
    struct Met {
        double fraction = 1;
        const Facet* facet = nullptr; ///< null: none yet
    };
    /// Replaces the facet met so far if the segment meets this one earlier.
    static void meet(const Facet& facet, const Vec<double, D>& outward, const Vec<double, D>& from,
                     const Vec<double, D>& along, Met& met) noexcept {
        constexpr double margin = 1e-9; // for rounding, in barycentric coordinates
        const double leaves = dot(along, outward);
        if (facet.separates ? !(leaves > 0) : leaves == 0) return;
        const double fraction = dot(facet.corner[0] - from, outward) / leaves;
        if (fraction < 0 || !(fraction < met.fraction || (met.facet == nullptr && fraction <= met.fraction)))
            return;
        const auto w = detail::weights_in_plane(facet, from + fraction * along);
        if (*std::min_element(w.begin(), w.end()) < -margin) return;
        met = {fraction, &facet};
    }
    static std::optional<Meeting> meeting_of(const Met& met, const Vec<double, D>& from,
                                             const Vec<double, D>& along) noexcept {
        if (met.facet == nullptr) return std::nullopt;
        const auto w = detail::weights_in_plane(*met.facet, from + met.fraction * along);
        return Meeting{met.fraction, value_on_facet(met.facet->vertex, detail::onto_facet(w))};
    }

    /// Makes the normals of each shell point outward, by a vote of its facets weighted by area. Facets of a
    /// shell are oriented consistently.
    void orient_normals_outward(std::size_t vertices) {
        detail::DisjointSets shells(vertices);
        for (const Facet& facet : facets_) {
            if (!facet.separates) continue;
            for (const std::uint32_t v : facet.vertex) shells.join(facet.vertex[0], v);
        }
        std::vector<double> votes(vertices); // NOLINT(misc-const-correctness): modified below
        for (std::size_t n = 0; n < facets_.size(); ++n)
            votes[shells.find(facets_[n].vertex[0])] += vote(facets_[n], normals_[n]);
        for (std::size_t n = 0; n < facets_.size(); ++n) {
            if (facets_[n].separates && votes[shells.find(facets_[n].vertex[0])] < 0)
                normals_[n] = -1.0 * normals_[n];
        }
    }
    /// Returns the area of a facet, negated if its normal points inside. Counts the crossings above the
    /// facet's centroid, along the main axis of its normal. If their number is even, the upper side is
    /// outside. Returns 0 if other facets are at the same position.
    double vote(const Facet& facet, const Vec<double, D>& normal) const {
        std::size_t axis = 0;
        for (std::size_t k = 1; k < D; ++k) {
            if (std::fabs(normal[k]) > std::fabs(normal[axis])) axis = k;
        }
        if (normal[axis] == 0 || !facet.separates) return 0;
        Vec<double, D> middle{}, up{};
        for (const auto& corner : facet.corner) middle = middle + (1 / double(D)) * corner;
        std::array<std::int64_t, D> line{};
        for (std::size_t k = 0; k < D; ++k) line[k] = std::llround(std::ldexp(middle[k], fraction_));
        const auto from = detail::crossing(facet, axis, line, fraction_);
        if (!from) return 0; // a sliver between two integer lines
        middle[axis] = *from;
        up[axis] = 1;
        bool inside_above = false, apart = true;
        const double all = std::ldexp(2.0, int(depth_));
        for_each_on_ray(middle, up, all, [&](std::uint32_t n) {
            if (&facets_[n] == &facet || !facets_[n].separates) return all;
            const auto at = detail::crossing(facets_[n], axis, line, fraction_);
            if (at && std::fabs(*at - *from) <= rounding) apart = false;
            if (at && *at > *from) inside_above = !inside_above;
            return all;
        });
        if (!apart) return 0;
        return detail::length(detail::normal_of(facet)) * (inside_above == (normal[axis] > 0) ? -1.0 : 1.0);
    }

    static constexpr double rounding = 1e-6; ///< above the rounding of positions

    unsigned depth_;
    int fraction_; ///< fractional bits of a coordinate
    double scale_;
    double unit_ = 1, slack_ = rounding;
    Vec<double, D> origin_{};
    Buffer<Facet> facets_, exact_;
    Buffer<Vec<double, D>> normals_;
    GridBones<D> bones_{{}, {}, {}};
    detail::BoxTree<D> boxes_; ///< of the rounded facets
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
