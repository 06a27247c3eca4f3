// The facets of the convex hull of sites, those in one plane taken together.
#pragma once

#include <cageform/cage/delaunay.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A plane of the hull (in the plane a line) and the sites within tolerance of it. In extents.
template <std::size_t D>
struct HullFacet {
    Vec<double, D> normal; ///< outwards, of length 1
    double offset;         ///< normal·x on the plane
    std::vector<std::uint32_t> vertex;

    double distance(const Vec<double, D>& p) const noexcept { return dot(normal, p) - offset; }
};

/// Finds the facets of a hull. A rotated lattice is flat to rounding only: its exact hull has facets
/// turned by anything, or hides sites beneath. So facets are taken from the largest down, each with
/// all sites within tolerance of its plane that it is connected with by facets of simplices in that
/// plane. What is left over is flatter than the tolerance.
template <std::size_t D>
class HullFacets {
public:
    /// `at`: the vertices in extents.
    HullFacets(const Delaunay<D>& sites, std::span<const Vec<double, D>> at, double tolerance)
        : sites_(sites)
        , at_(at)
        , tolerance_(tolerance)
        , seen_(sites.simplices().size(), 0)
        , in_facet_(sites.size(), 0)
        , taken_(sites.simplices().size(), false) {
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
            if (!taken_[entry.ghost] && entry.measure > tolerance * longest_edge(entry.ghost))
                collect(entry.ghost);
        }
    }

    std::vector<HullFacet<D>> facets;

private:
    const auto& simplex(std::uint32_t s) const noexcept { return sites_.simplices()[s]; }

    /// A normal as long as the facet, or twice its area.
    Vec<double, D> outward(std::uint32_t ghost) const noexcept {
        const auto& v = simplex(ghost).vertex;
        const auto e = at_[v[1]] - at_[v[0]];
        if constexpr (D == 2) {
            return {-e[1], e[0]}; // a ghost with a third vertex on the left is positively oriented
        } else {
            return cross(e, at_[v[2]] - at_[v[0]]);
        }
    }
    double longest_edge(std::uint32_t ghost) const noexcept {
        if constexpr (D == 2) return 1; // a length is compared with a length
        double longest = 0;
        const auto& v = simplex(ghost).vertex;
        for (std::size_t k = 0; k < D; ++k)
            longest = std::fmax(longest, length(at_[v[k]] - at_[v[(k + 1) % D]]));
        return longest;
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
            if (simplex(s).is_ghost()) taken_[s] = true;
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
    /// Whether all sites of the facet without vertex `k` lie in the plane.
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
    std::vector<bool> taken_;
    std::uint32_t stamp_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
