// Sibson's natural neighbour weights of a point in the convex hull of sites.
//
// Evaluation of a point p:
//
//   1. `Delaunay::find_cavity` walks from simplex to simplex towards p and finds the *cavity*: the Delaunay
//      simplices whose circumscribed ball contains p. Their vertices are the natural neighbours of p. A
//      *ghost*, a simplex beyond a facet of the hull, is in the cavity only if p lies beyond that facet or in
//      its plane.
//   2. Next to the hull, `find_near_hull` decides whether p lies outside, on a facet or inside. On a facet,
//      only the facet's sites have weights.
//   3. Inside, `NewCell` (new_cell.hpp) measures the overlap of the Voronoi cell of p with the cell of each
//      neighbour (cell_overlap.hpp).
//   4. `add_cell` divides the overlaps by their sum, and `restore` removes the rounding errors of Σu = 1 and
//      Σ u (P − p) = 0.
//
// Coordinates have three units: `LatticePoint` holds integers of the lattice, *extents* are lattice
// coordinates times 2^-60, and *units* are those of the user. An extent is the smallest power of two above
// the longest side of the sites' bounds (site_lattice.hpp).
#pragma once

#include <cageform/cage/sites/hull_facets.hpp>
#include <cageform/coordinates/sibson/new_cell.hpp>
#include <cageform/core/status.hpp>

#include <memory>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A natural neighbour of a point, and its weight.
template <std::size_t D>
struct Neighbour {
    std::uint32_t site;
    double weight;
    Vec<double, D> gradient; ///< of the weight by the point, per unit of length
    Vec<double, D> away;     ///< site − point
};

/// Solves m x = y in place for a positive definite matrix: y becomes x. Reads only the upper triangle of m.
/// Returns false if m is singular to rounding.
template <std::size_t N>
bool solve_symmetric(Square<double, N> m, std::array<double, N>& y) noexcept {
    std::array<double, N> first, inverse;
    for (std::size_t k = 0; k < N; ++k) first[k] = m[k][k];
    for (std::size_t k = 0; k < N; ++k) {
        if (!(m[k][k] > 1e-13 * first[k])) return false;
        inverse[k] = 1 / m[k][k];
        for (std::size_t i = k + 1; i < N; ++i) {
            const double f = m[k][i] * inverse[k];
            for (std::size_t j = i; j < N; ++j) m[i][j] -= f * m[k][j];
            y[i] -= f * y[k];
        }
    }
    for (std::size_t k = N; k-- > 0;) {
        for (std::size_t j = k + 1; j < N; ++j) y[k] -= m[k][j] * y[j];
        y[k] *= inverse[k];
    }
    return true;
}

/// Finds the natural neighbours of points among fixed sites.
template <std::size_t D>
class NaturalNeighbours {
    struct Nothing {
        struct Scratch {};
    };
    using Flat = std::conditional_t<D == 3, NaturalNeighbours<2>, Nothing>;

public:
    /// Scratch memory of an evaluation, one per thread, with the results of `find`.
    struct Scratch {
        std::vector<Neighbour<D>> found; ///< the order depends on the triangulation alone
        bool gradients = true;           ///< input: whether `find` computes gradients
        bool at_site = false;
        Vec<double, D> missed{}; ///< for a point on a facet: Σ weight · away, in extents
        typename Delaunay<D>::Search search;
        NewCell<D> cell;
        std::unique_ptr<typename Flat::Scratch> flat;
    };

    NaturalNeighbours() = default;
    /// Triangulates the sites.
    ///
    ///   tolerance  distance below which points coincide, in the units of the sites
    ///   smooth     2D only: uses the C² coordinates of Hiyoshi & Sugihara, which are the limits of Sibson's
    ///              3D weights on a flat facet of the hull
    NaturalNeighbours(std::span<const Vec<double, D>> sites, double tolerance, bool smooth = false)
        : smooth_(smooth)
        , lattice_(bounds_of(sites))
        , unit_(lattice_.units(1))
        , bounds_(bounds_of(sites).widened(tolerance))
        , tolerance_(lattice_.extents(tolerance)) {
        std::vector<LatticePoint<D>> positions;
        positions.reserve(sites.size());
        for (const auto& site : sites) positions.push_back(lattice_.position(site));
        sites_ = Delaunay<D>(std::move(positions));
        if (sites_.empty()) return;
        at_.reserve(sites_.size());
        for (std::uint32_t v = 0; v < sites_.size(); ++v) at_.push_back(lattice_.to_extents(sites_.point(v)));
        HullFacets<D> hull(sites_, at_, tolerance_);
        facets_ = std::move(hull.facets);
        if (facets_.empty()) return;
        hull_ = HullTree<D>(std::move(hull.pieces));
        for (auto& facet : facets_) prepare(facet);
        const auto vertices = hull_vertices();
        near_hull_.reserve(sites_.simplices().size());
        for (const auto& simplex : sites_.simplices()) {
            const auto on_hull = [&](std::uint32_t v) { return v == Delaunay<D>::infinite || vertices[v]; };
            near_hull_.push_back(std::any_of(simplex.vertex.begin(), simplex.vertex.end(), on_hull) ? 1 : 0);
        }
    }

    /// Returns whether all sites lie in a plane (2D: on a line) within the tolerance.
    bool empty() const noexcept { return facets_.empty(); }
    const Delaunay<D>& sites() const noexcept { return sites_; }
    /// Returns the distance below which points coincide, in the units of the sites.
    double tolerance() const noexcept { return lattice_.units(tolerance_); }
    /// Returns the lattice step in the units of the sites.
    double step() const noexcept { return lattice_.units(0x1p-60); }
    /// Returns for every site, in the user's order, whether it lies on the hull within the tolerance.
    std::vector<bool> on_hull() const {
        const auto vertices = hull_vertices();
        std::vector<bool> result(sites_.size(), false);
        for (std::uint32_t v = 0; v < sites_.size(); ++v) result[sites_.site(v)] = vertices[v];
        return result;
    }

    /// Finds the neighbours of a finite point; none if it lies outside the hull. Gradients are set only
    /// inside the hull. At a site they are zero.
    PointState find(const Vec<double, D>& p, Scratch& scratch) const {
        scratch.found.clear();
        scratch.at_site = false;
        for (std::size_t k = 0; k < D; ++k) {
            // Tested first, because a hull as thin as the tolerance has facets without a usable plane.
            if (p[k] < bounds_.lower[k] || p[k] > bounds_.upper[k]) return PointState::outside;
        }
        const auto position = lattice_.position(p);
        const std::uint32_t at = sites_.find_cavity(position, scratch.search);
        const auto cavity = scratch.search.cavity();
        const auto is_near = [&](std::uint32_t s) { return near_hull_[s] != 0; };
        if (near_hull_[at] != 0 || std::any_of(cavity.begin(), cavity.end(), is_near)) {
            const PointState state = find_near_hull(lattice_.to_extents(position), scratch);
            if (state != PointState::inside) return state;
        }
        if (find_inside(position, at, scratch)) return PointState::inside;
        (void)find_on_hull(p, scratch);
        return PointState::on_boundary;
    }

    /// Returns the point of the hull's surface nearest to a finite point, and finds that point's neighbours.
    Vec<double, D> find_on_hull(const Vec<double, D>& p, Scratch& scratch) const {
        typename HullTree<D>::Nearest nearest{0, {}, (std::numeric_limits<double>::max)()};
        hull_.find(lattice_.to_extents(p), nearest);
        scratch.found.clear();
        scratch.missed = {};
        find_on_facet(nearest.facet, nearest.position, scratch);
        return lattice_.from_extents(nearest.position + scratch.missed);
    }

    /// Moves `p`, a point of the hull, by a fraction of the way to the centroid of the first simplex. The
    /// result lies inside the hull.
    Vec<double, D> moved_inside(const Vec<double, D>& p, double fraction) const noexcept {
        std::uint32_t s = 0;
        while (sites_.simplices()[s].is_ghost()) ++s;
        Vec<double, D> middle{};
        for (const std::uint32_t v : sites_.simplices()[s].vertex) middle = middle + (1.0 / (D + 1)) * at_[v];
        return p + fraction * (lattice_.from_extents(middle) - p);
    }

private:
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    /// A flat facet with more sites than a simplex has, and its triangulation.
    struct FlatFacet {
        std::array<Vec<double, D>, 2> axis;
        Flat neighbours;
    };

    // ---- inside ---------------------------------------------------------------------------------

    /// Computes the weights of a point inside the hull from its cavity in `scratch`. `at` is the simplex
    /// where the search for the cavity began. Returns false if the point's cell has no measure.
    bool find_inside(const LatticePoint<D>& position, std::uint32_t at, Scratch& scratch) const {
        if (scratch.search.cavity().empty())
            return find_site(position, sites_.simplices()[at].vertex, scratch);
        const auto sums = smooth_             ? OverlapSums::smooth
                          : scratch.gradients ? OverlapSums::moments
                                              : OverlapSums::measures;
        const bool sound = scratch.cell.fill(sites_, position, scratch.search.cavity(), sums);
        if (find_site(position, scratch.cell.cavity.vertices, scratch)) return true;
        if (sound) add_cell(scratch.cell, sums == OverlapSums::moments, scratch.found);
        return sound;
    }
    /// Returns whether the point coincides with one of these vertices, which then gets all the weight.
    template <class Vertices>
    bool find_site(const LatticePoint<D>& position, const Vertices& vertices, Scratch& scratch) const {
        for (const std::uint32_t v : vertices) {
            const auto away = 0x1p-60 * to_double<D>(difference<D>(sites_.point(v), position));
            if (dot(away, away) > tolerance_ * tolerance_) continue;
            add_site(v, away, scratch);
            return true;
        }
        return false;
    }
    void add_site(std::uint32_t v, const Vec<double, D>& away, Scratch& scratch) const {
        scratch.at_site = true;
        scratch.found.push_back({sites_.site(v), 1, {}, unit_ * away});
    }
    void add_cell(const NewCell<D>& cell, bool gradients, std::vector<Neighbour<D>>& found) const {
        const std::size_t count = cell.cavity.vertices.size();
        found.resize(count);
        Vec<double, D> sum{};
        const double share = 1 / cell.total;
        std::size_t used = 0;
        for (std::size_t n = 0; n < count; ++n) {
            const auto away = cell.seen(n);
            Vec<double, D> slope{};
            if (gradients) {
                slope = (2 / dot(away, away)) * cell.moment(n);
                sum = sum + slope;
            }
            if (cell.measure(n) > 0)
                found[used++] = {sites_.site(cell.cavity.vertices[n]), cell.measure(n) * share, slope,
                                 0x1p-60 * away};
        }
        found.resize(used);
        restore(found);
        for (auto& n : found) n.away = unit_ * n.away;
        if (!gradients) return;
        const double per_step = 1 / lattice_.units(0x1p-60);
        for (auto& n : found) n.gradient = (per_step / cell.total) * (n.gradient - n.weight * sum);
    }

    /// Restores Σu = 1 and Σ u away = 0 after rounding. Each u_i changes by u_i y·(1, away_i), the smallest
    /// change relative to the weights. If the neighbours are flat to rounding, nothing changes.
    static void restore(std::vector<Neighbour<D>>& found) noexcept {
        for (int round = 0; round < 2; ++round) {
            Square<double, D + 1> m{};
            for (const auto& n : found) {
                m[0][0] += n.weight;
                for (std::size_t i = 0; i < D; ++i) {
                    const double x = n.weight * n.away[i];
                    m[0][i + 1] += x;
                    for (std::size_t k = i; k < D; ++k) m[i + 1][k + 1] += x * n.away[k];
                }
            }
            std::array<double, D + 1> y;
            y[0] = 1 - m[0][0];
            for (std::size_t k = 1; k <= D; ++k) y[k] = -m[0][k];
            if (!solve_symmetric(m, y)) return;
            const auto factor = [&](const Neighbour<D>& n) {
                double sum = y[0];
                for (std::size_t k = 0; k < D; ++k) sum += y[k + 1] * n.away[k];
                return sum;
            };
            double largest = 0;
            for (const auto& n : found) largest = (std::max)(largest, std::fabs(factor(n)));
            // Larger errors have another cause and are kept.
            if (!(largest < 1e-6)) return;
            for (auto& n : found) n.weight += n.weight * factor(n);
            if (largest < 1e-12) return;
        }
    }

    // ---- on the hull ----------------------------------------------------------------------------

    /// Returns for every vertex whether it lies on the hull within the tolerance.
    std::vector<bool> hull_vertices() const {
        std::vector<bool> result(sites_.size(), false);
        for (const auto& simplex : sites_.simplices()) {
            for (std::size_t k = 0; simplex.is_ghost() && k < D; ++k) result[simplex.vertex[k]] = true;
        }
        for (const auto& facet : facets_) {
            for (const std::uint32_t v : facet.vertex) result[v] = true;
        }
        return result;
    }
    /// Decides whether the point `q` (in extents), whose cavity touches the hull, lies outside, on a facet or
    /// inside. On a facet it also finds the neighbours.
    PointState find_near_hull(const Vec<double, D>& q, Scratch& scratch) const {
        const auto cavity = scratch.search.cavity();
        const auto is_ghost = [&](std::uint32_t s) { return sites_.simplices()[s].is_ghost(); };
        const bool beyond = std::any_of(cavity.begin(), cavity.end(), is_ghost);
        // The sites of a facet may be off its plane by one tolerance, and the point by another.
        typename HullTree<D>::Nearest nearest{none, {}, 4 * tolerance_ * tolerance_};
        hull_.find(q, nearest);
        if (nearest.facet == none) return beyond ? PointState::outside : PointState::inside;
        const double distance = facets_[nearest.facet].distance(q);
        if (distance > tolerance_) return PointState::outside;
        if (distance < -tolerance_ && !beyond) return PointState::inside;
        find_on_facet(nearest.facet, q, scratch);
        return PointState::on_boundary;
    }
    /// Sorts the sites of a facet along the line (2D), or triangulates more than three sites (3D).
    void prepare(HullFacet<D>& facet) {
        if constexpr (D == 2) {
            std::sort(facet.vertex.begin(), facet.vertex.end(), [&](std::uint32_t a, std::uint32_t b) {
                return cross(facet.normal, at_[a]) < cross(facet.normal, at_[b]);
            });
        } else {
            flat_.push_back({});
            if (facet.vertex.size() == 3) return;
            auto& [axis, neighbours] = flat_.back();
            const auto along = at_[facet.vertex[1]] - at_[facet.vertex[0]];
            const auto across = cross(facet.normal, along);
            axis[1] = (1 / length(across)) * across;
            axis[0] = cross(axis[1], facet.normal);
            std::vector<Vec<double, 2>> flat;
            flat.reserve(facet.vertex.size());
            for (const std::uint32_t v : facet.vertex) flat.push_back(in_plane(axis, at_[v]));
            neighbours = Flat(flat, tolerance_, true);
        }
    }
    static Vec<double, 2> in_plane(const std::array<Vec<double, D>, 2>& axis,
                                   const Vec<double, D>& q) noexcept {
        return {dot(axis[0], q), dot(axis[1], q)};
    }

    /// Finds the neighbours of a point within tolerance of facet `n`, in extents.
    void find_on_facet(std::size_t n, const Vec<double, D>& q, Scratch& scratch) const {
        const HullFacet<D>& facet = facets_[n];
        for (const std::uint32_t v : facet.vertex) {
            if (!(length(at_[v] - q) <= tolerance_)) continue;
            return add_site(v, at_[v] - q, scratch);
        }
        if constexpr (D == 2) {
            const auto position = [&](const Vec<double, 2>& x) { return cross(facet.normal, x); };
            std::size_t next = 1;
            while (next + 1 < facet.vertex.size() && position(at_[facet.vertex[next]]) < position(q)) ++next;
            add_facet_sites(std::array<std::uint32_t, 2>{facet.vertex[next - 1], facet.vertex[next]}, q,
                            scratch);
        } else if (flat_[n].neighbours.empty()) {
            add_facet_sites({facet.vertex[0], facet.vertex[1], facet.vertex[2]}, q, scratch);
        } else {
            if (!scratch.flat) scratch.flat = std::make_unique<typename Flat::Scratch>();
            const auto x = in_plane(flat_[n].axis, q);
            if (flat_[n].neighbours.find(x, *scratch.flat) == PointState::outside)
                flat_[n].neighbours.find_on_hull(x, *scratch.flat);
            for (const auto& flat : scratch.flat->found)
                add(facet.vertex[flat.site], flat.weight, q, scratch);
        }
    }
    void add_facet_sites(const std::array<std::uint32_t, D>& vertex, const Vec<double, D>& q,
                         Scratch& scratch) const {
        Corners<D> corner;
        for (std::size_t k = 0; k < D; ++k) corner[k] = at_[vertex[k]];
        auto weight = nearest_on_facet(q, corner);
        if constexpr (D == 3) refine(q, corner, weight);
        for (std::size_t k = 0; k < D; ++k) add(vertex[k], weight[k], q, scratch);
    }
    /// Corrects the barycentric weights of sliver triangles, in up to four rounds, until the point is
    /// reproduced within the tolerance. Each round loses digits too.
    void refine(const Vec<double, D>& q, const Corners<D>& corner, std::array<double, D>& weight) const {
        const auto& [a, b, c] = corner;
        const auto n = cross(b - a, c - a);
        auto miss = q - point_on_facet(weight, corner);
        for (int round = 0; round < 4 && dot(miss, miss) > tolerance_ * tolerance_; ++round) {
            const double u = dot(cross(c - b, miss), n) / dot(n, n),
                         v = dot(cross(a - c, miss), n) / dot(n, n);
            const std::array<double, D> next{weight[0] + u, weight[1] + v, weight[2] - (u + v)};
            const auto rest = q - point_on_facet(next, corner);
            if (!((std::min)({next[0], next[1], next[2]}) >= 0 && dot(rest, rest) < dot(miss, miss))) return;
            weight = next;
            miss = rest;
        }
    }
    void add(std::uint32_t v, double weight, const Vec<double, D>& q, Scratch& scratch) const {
        if (!(weight > 0)) return;
        const auto away = at_[v] - q;
        scratch.found.push_back({sites_.site(v), weight, {}, unit_ * away});
        scratch.missed = scratch.missed + weight * away;
    }

    bool smooth_ = false; ///< whether weights are the C² coordinates; 2D
    SiteLattice<D> lattice_;
    double unit_ = 1;            ///< one extent in the units of the user
    Bounds<double, D> bounds_{}; ///< of the sites, widened by the tolerance
    double tolerance_ = 0;       ///< in extents
    Delaunay<D> sites_;
    std::vector<Vec<double, D>> at_; ///< positions of the vertices, in extents
    std::vector<HullFacet<D>> facets_;
    std::vector<FlatFacet> flat_; ///< 3D: one per facet, empty for triangles
    HullTree<D> hull_;
    std::vector<std::uint8_t> near_hull_; ///< per simplex: whether it has a vertex on the hull
};

} // namespace cageform::inline CAGEFORM_ABI::detail
