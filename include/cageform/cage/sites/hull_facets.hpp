// The facets of the convex hull of sites, with nearly coplanar facets merged.
#pragma once

#include <cageform/cage/detail/box_tree.hpp>
#include <cageform/cage/sites/delaunay.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A plane of the hull (a line in 2D) and the sites within the tolerance of it. Lengths are in extents.
template <std::size_t D>
struct HullFacet {
    Vec<double, D> normal; ///< outward unit normal
    double offset;         ///< normal·x on the plane
    std::vector<std::uint32_t> vertex;

    double distance(const Vec<double, D>& p) const noexcept { return dot(normal, p) - offset; }
};

/// A facet of the exact hull, and the index of its merged facet in `HullFacets::facets`.
template <std::size_t D>
struct HullPiece {
    Corners<D> corner;
    std::uint32_t facet;
};

/// Merges the facets of a hull. Rounding makes the exact hull of a rotated lattice uneven: it has slivers of
/// arbitrary direction, and some sites lie just below the surface. Facets are therefore processed in
/// descending order of size. Each facet collects sites within the tolerance of its plane. Such a site must be
/// connected to the facet through facets of simplices in that plane. The remaining facets are flatter than
/// the tolerance and join a neighbouring facet.
template <std::size_t D>
class HullFacets {
public:
    /// `at` are the vertices of the triangulation in extents.
    HullFacets(const Delaunay<D>& sites, std::span<const Vec<double, D>> at, double tolerance)
        : sites_(sites)
        , at_(at)
        , tolerance_(tolerance)
        , seen_(sites.simplices().size(), 0)
        , in_facet_(sites.size(), 0)
        , facet_of_(sites.simplices().size(), none) {
        struct Entry {
            double measure;
            std::uint32_t ghost;
        };
        std::vector<Entry> order;
        for (std::uint32_t s = 0; s < sites.simplices().size(); ++s) {
            if (sites.simplices()[s].is_ghost()) order.push_back({length(outward(s)), s});
        }
        std::sort(order.begin(), order.end(), [](const Entry& a, const Entry& b) {
            return a.measure > b.measure || (a.measure == b.measure && a.ghost < b.ghost);
        });
        for (const Entry& entry : order) {
            if (facet_of_[entry.ghost] == none && entry.measure > tolerance * longest_edge(entry.ghost))
                collect(entry.ghost);
        }
        find_pieces();
    }

    std::vector<HullFacet<D>> facets;
    std::vector<HullPiece<D>> pieces;

private:
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    const auto& simplex(std::uint32_t s) const noexcept { return sites_.simplices()[s]; }

    /// Returns an outward normal; its length is the length of the edge, or twice the area of the triangle.
    Vec<double, D> outward(std::uint32_t ghost) const noexcept {
        const auto& v = simplex(ghost).vertex;
        const auto e = at_[v[1]] - at_[v[0]];
        if constexpr (D == 2) {
            return {-e[1], e[0]}; // a ghost with its third vertex on the left is positively oriented
        } else {
            return cross(e, at_[v[2]] - at_[v[0]]);
        }
    }
    double longest_edge(std::uint32_t ghost) const noexcept {
        if constexpr (D == 2) return 1; // in 2D the measure and the tolerance are both lengths
        double longest = 0;
        const auto& v = simplex(ghost).vertex;
        for (std::size_t k = 0; k < D; ++k)
            longest = std::fmax(longest, length(at_[v[k]] - at_[v[(k + 1) % D]]));
        return longest;
    }

    /// Assigns the remaining ghosts to the facets of their neighbours.
    void find_pieces() {
        std::vector<std::uint32_t> ghosts;
        for (std::uint32_t s = 0; s < facet_of_.size(); ++s) {
            if (facet_of_[s] != none) ghosts.push_back(s);
        }
        for (std::size_t n = 0; n < ghosts.size(); ++n) {
            const std::uint32_t s = ghosts[n];
            pieces.push_back({{}, facet_of_[s]});
            for (std::size_t k = 0; k < D; ++k) {
                pieces.back().corner[k] = at_[simplex(s).vertex[k]];
                const std::uint32_t next = simplex(s).neighbour[k];
                if (facet_of_[next] != none) continue;
                facet_of_[next] = facet_of_[s];
                ghosts.push_back(next);
            }
        }
    }
    void collect(std::uint32_t ghost) {
        const auto n = outward(ghost);
        HullFacet<D> facet{(1 / length(n)) * n, 0, {}};
        facet.offset = dot(facet.normal, at_[simplex(ghost).vertex[0]]);
        ++stamp_;
        for (std::size_t k = 0; k < D; ++k) add(facet, simplex(ghost).vertex[k]);
        std::vector<std::uint32_t> waiting{ghost};
        seen_[ghost] = stamp_;
        while (!waiting.empty()) {
            const std::uint32_t s = waiting.back();
            waiting.pop_back();
            std::size_t inside = 0;
            for (const std::uint32_t v : simplex(s).vertex) {
                if (v == Delaunay<D>::infinite) continue;
                if (in_facet_[v] != stamp_ && std::fabs(facet.distance(at_[v])) <= tolerance_) add(facet, v);
                if (in_facet_[v] == stamp_) ++inside;
            }
            if (inside < D) continue;
            if (simplex(s).is_ghost() && facet_of_[s] == none) facet_of_[s] = std::uint32_t(facets.size());
            for (std::size_t k = 0; k <= D; ++k) {
                const std::uint32_t next = simplex(s).neighbour[k];
                if (seen_[next] == stamp_ || !connects(s, k)) continue;
                seen_[next] = stamp_;
                waiting.push_back(next);
            }
        }
        std::sort(facet.vertex.begin(), facet.vertex.end());
        facets.push_back(std::move(facet));
    }
    void add(HullFacet<D>& facet, std::uint32_t v) {
        in_facet_[v] = stamp_;
        facet.vertex.push_back(v);
    }
    /// Whether the facet of simplex `s` opposite to vertex `k` lies in the plane.
    bool connects(std::uint32_t s, std::size_t k) const noexcept {
        for (std::size_t i = 0; i <= D; ++i) {
            const std::uint32_t v = simplex(s).vertex[i];
            if (i != k && v != Delaunay<D>::infinite && in_facet_[v] != stamp_) return false;
        }
        return true;
    }

    const Delaunay<D>& sites_;
    std::span<const Vec<double, D>> at_;
    double tolerance_;
    std::vector<std::uint32_t> seen_, in_facet_;
    std::vector<std::uint32_t> facet_of_; ///< per ghost
    std::uint32_t stamp_ = 0;
};

/// Finds the nearest point of a hull. O(n log n) to build, usually O(log n) per query.
template <std::size_t D>
class HullTree {
public:
    struct Nearest {
        std::uint32_t facet;
        Vec<double, D> position;
        double distance2; ///< squared distance to the query point
    };

    HullTree() = default;
    explicit HullTree(std::vector<HullPiece<D>> pieces)
        : pieces_(std::move(pieces))
        , boxes_(pieces_.size(), [this](std::uint32_t n) {
            return bounds_of(std::span<const Vec<double, D>>(pieces_[n].corner));
        }) {}

    /// Replaces `best` if a point of the hull is nearer to `q`.
    void find(const Vec<double, D>& q, Nearest& best) const {
        boxes_.for_each_near(q, best.distance2, [&](std::uint32_t n) {
            const auto& [corner, facet] = pieces_[n];
            const auto x = point_on_facet(nearest_on_facet(q, corner), corner);
            const double distance2 = dot(x - q, x - q);
            if (distance2 < best.distance2) best = {facet, x, distance2};
            return best.distance2;
        });
    }

private:
    std::vector<HullPiece<D>> pieces_;
    BoxTree<D> boxes_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
