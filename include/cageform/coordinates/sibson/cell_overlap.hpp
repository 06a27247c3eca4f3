// Measures the overlap of the Voronoi cell of a new point with the Voronoi cells of the sites.
#pragma once

#include <cageform/cage/sites/delaunay.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Grows scratch memory to at least `size` elements.
template <class T>
void grow_to(std::vector<T>& scratch, std::size_t size) {
    if (scratch.size() < size) scratch.resize(size);
}

/// The cavity of a new point p: the Delaunay simplices whose circumscribed ball contains p. Its vertices,
/// simplices and boundary facets (the *rim*) are numbered from 0.
template <std::size_t D>
struct Cavity {
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    struct Simplex {
        std::array<std::uint32_t, D + 1> vertex; ///< indices into `vertices`
        /// The cavity simplex across the facet without vertex k, or none.
        std::array<std::uint32_t, D + 1> inner;
        std::array<std::uint32_t, D + 1> rim; ///< the rim facet without vertex k, or none
    };
    struct RimFacet {
        std::uint32_t simplex;
        std::uint32_t index; ///< the simplex's vertex that is not on the facet
    };

    // Valid until the next fill.
    /// Vertex numbers of the triangulation, in order of first use by a simplex.
    std::span<const std::uint32_t> vertices;
    /// Simplex numbers of the triangulation, as passed to `fill`.
    std::span<const std::uint32_t> numbers;
    std::span<const Simplex> simplices;
    std::span<const RimFacet> rim;

    /// Numbers a cavity, given by ascending simplex numbers without ghosts. Refers to `cavity`.
    void fill(const Delaunay<D>& sites, std::span<const std::uint32_t> cavity) {
        if (of_vertex_.size() < sites.size()) of_vertex_.resize(sites.size(), none);
        if (of_simplex_.size() < sites.simplices().size()) of_simplex_.resize(sites.simplices().size(), none);
        grow_to(vertices_, (D + 1) * cavity.size());
        grow_to(simplices_, cavity.size());
        grow_to(rim_, (D + 1) * cavity.size());
        std::uint32_t vertex_count = 0, rim_count = 0;
        for (std::uint32_t n = 0; n < cavity.size(); ++n) of_simplex_[cavity[n]] = n;
        for (std::uint32_t n = 0; n < cavity.size(); ++n) {
            const auto& from = sites.simplices()[cavity[n]];
            Simplex& to = simplices_[n];
            for (std::uint32_t k = 0; k <= D; ++k) {
                std::uint32_t& number = of_vertex_[from.vertex[k]];
                if (number == none) {
                    number = vertex_count;
                    vertices_[vertex_count++] = from.vertex[k];
                }
                to.vertex[k] = number;
                to.inner[k] = of_simplex_[from.neighbour[k]];
                to.rim[k] = none;
                if (to.inner[k] != none) continue;
                to.rim[k] = rim_count;
                rim_[rim_count++] = {n, k};
            }
        }
        vertices = {vertices_.data(), vertex_count};
        numbers = cavity;
        simplices = {simplices_.data(), cavity.size()};
        rim = {rim_.data(), rim_count};
        for (const std::uint32_t v : vertices) of_vertex_[v] = none;
        for (const std::uint32_t s : numbers) of_simplex_[s] = none;
    }

    /// Returns the other rim facet at a ridge, which is `facet` without its vertex `y`. Rotates around the
    /// ridge through the simplices of the cavity.
    std::uint32_t across(const RimFacet& facet, std::uint32_t y) const noexcept {
        std::uint32_t s = facet.simplex, last = facet.index;
        while (simplices[s].inner[y] != none) {
            const std::uint32_t next = simplices[s].inner[y], ahead = simplices[s].vertex[last];
            const auto& to = simplices[next];
            std::uint32_t back = 0;
            while (to.inner[back] != s) ++back;
            y = std::uint32_t(std::find(to.vertex.begin(), to.vertex.end(), ahead) - to.vertex.begin());
            last = back;
            s = next;
        }
        return simplices[s].rim[y];
    }

private:
    std::vector<std::uint32_t> vertices_;
    std::vector<Simplex> simplices_;
    std::vector<RimFacet> rim_;
    /// Numbers in the cavity by vertex and simplex of the triangulation; none outside `fill`.
    std::vector<std::uint32_t> of_vertex_, of_simplex_;
};

/// A vector with components of any number type.
template <class N, std::size_t D>
using Numbers = std::array<N, D>;

template <class N>
N cross_of(const Numbers<N, 2>& a, const Numbers<N, 2>& b) noexcept {
    return a[0] * b[1] - a[1] * b[0];
}
template <class N>
Numbers<N, 3> cross_of(const Numbers<N, 3>& a, const Numbers<N, 3>& b) noexcept {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The quantities that are summed over the overlap of two Voronoi cells.
enum class OverlapSums : std::uint8_t {
    measures,
    facets,  ///< measures and facets
    moments, ///< measures, facets and moments
    smooth,  ///< the measures of the C² coordinates
};

/// Measures V_p ∩ V_i for every neighbour i of a new point p.
///
/// The corners of V_p ∩ V_i are circumcentres: of the cavity's simplices, and of p with each rim facet. The
/// measure is a sum of determinants over the edges, with p as origin (the shoelace formula in 2D, cones over
/// the faces in 3D). Each edge joins the circumcentres of two simplices with a common facet: a pass over the
/// facets of the cavity visits all edges, in any order. N is double or WideFloat.
template <class N, std::size_t D>
struct CellOverlap {
    using Vector = Numbers<N, D>;

    /// Positions are relative to p, in lattice steps. Sizes and errors are used only for double.
    struct Site {
        Vector at;
        double size; ///< Σ|x|
    };
    struct Centre {
        Vector at;
        double size, error; ///< Σ|x|, and an error bound for each component
    };

    // Input. The vectors may be longer than the cavity needs.
    std::vector<Site> site; ///< the cavity's vertices
    /// Circumcentres: of the cavity's simplices, then of p with each rim facet.
    std::vector<Centre> centre;
    // Output, one per vertex. Quantities that were not requested keep old values.
    std::vector<N> measure; ///< D! times the area or volume of V_p ∩ V_i
    /// (D − 1)! |P|/2 times the length or area of the facet between p's cell and the site's cell.
    std::vector<N> facet;
    /// |P|²/2 times the gradient of `measure` by p: a multiple of the facet's first moment about p, ∫ y dy.
    std::vector<Vector> moment;
    double squares = 0; ///< sum of the squared rounding bounds of all terms; double only

    void make_room(const Cavity<D>& cavity) {
        grow_to(site, cavity.vertices.size());
        grow_to(centre, cavity.simplices.size() + cavity.rim.size());
        grow_to(measure, cavity.vertices.size());
        grow_to(facet, cavity.vertices.size());
        grow_to(moment, cavity.vertices.size());
    }
    /// Computes the sums. Smooth measures, without facets and moments, are those of the C² coordinates of
    /// Hiyoshi & Sugihara (2D only): 6 ∫ (|y − P|² − |y − p|²) dy over V_p ∩ V_i.
    void sum(const Cavity<D>& cavity, OverlapSums sums) {
        sums_ = sums;
        const std::size_t count = cavity.vertices.size();
        std::fill_n(measure.begin(), count, N(0));
        if (sums != OverlapSums::measures) std::fill_n(facet.begin(), count, N(0));
        if (sums == OverlapSums::moments) std::fill_n(moment.begin(), count, Vector{});
        squares = 0;
        if constexpr (D == 2) find_heights(cavity);
        for (std::size_t n = 0; n < cavity.simplices.size(); ++n) {
            const auto& simplex = cavity.simplices[n];
            for (std::uint32_t k = 0; k <= D; ++k) {
                if (simplex.inner[k] == Cavity<D>::none) {
                    dual_edge(simplex, k, n, cavity.simplices.size() + simplex.rim[k]);
                } else if (n < simplex.inner[k]) {
                    dual_edge(simplex, k, n, simplex.inner[k]);
                }
            }
        }
        for (std::size_t n = 0; n < cavity.rim.size(); ++n) close(cavity, n);
    }

private:
    static constexpr bool measures_error = std::is_same_v<N, double>;

    /// Returns the vertices of a simplex except k, in an order that makes them and k an even permutation.
    static constexpr auto others(std::uint32_t k) noexcept {
        if constexpr (D == 2) {
            constexpr std::uint32_t all[3][2] = {{1, 2}, {2, 0}, {0, 1}};
            return std::to_array(all[k]);
        } else {
            constexpr std::uint32_t all[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
            return std::to_array(all[k]);
        }
    }

    void find_heights(const Cavity<D>& cavity) {
        height_.clear();
        if (sums_ != OverlapSums::smooth) return;
        for (std::size_t n = 0; n < cavity.simplices.size(); ++n) {
            const Vector& r = site[cavity.simplices[n].vertex[0]].at;
            const Vector& c = centre[n].at;
            height_.push_back(r[0] * r[0] + r[1] * r[1] - N(2) * (c[0] * r[0] + c[1] * r[1]));
        }
        height_.resize(cavity.simplices.size() + cavity.rim.size(), N(0));
    }

    /// Adds the dual edge from circumcentre `a` of a simplex, across its facet without vertex `k`, to
    /// circumcentre `b`. The edge lies in the bisector plane of any two vertices i, j of that facet. In 3D
    /// its term is det((P_i + P_j)/2, a, b), because the midpoint lies in that plane; the signs for cells i
    /// and j are opposite.
    void dual_edge(const typename Cavity<D>::Simplex& simplex, std::uint32_t k, std::size_t a,
                   std::size_t b) {
        const auto order = others(k);
        const std::uint32_t i = simplex.vertex[order[0]], j = simplex.vertex[order[1]];
        if constexpr (D == 2) {
            const N t = cross_of(centre[b].at, centre[a].at);
            if (height_.empty()) {
                measure[i] = measure[i] + t;
                measure[j] = measure[j] - t;
            } else {
                const N h = height_[a] + height_[b];
                measure[i] = measure[i] + t * (square(i) + h);
                measure[j] = measure[j] - t * (square(j) + h);
            }
            add_error(1, a, b);
        } else {
            const std::uint32_t l = simplex.vertex[order[2]];
            const Vector normal = cross_of(centre[b].at, centre[a].at);
            const N x = half_of(i, normal), y = half_of(j, normal), z = half_of(l, normal);
            measure[i] = measure[i] + (y - z);
            measure[j] = measure[j] + (z - x);
            measure[l] = measure[l] + (x - y);
            add_error(site[i].size + site[j].size + site[l].size, a, b);
        }
    }
    /// Closes the boundary of V_p ∩ V_i at rim facet `n`: at each ridge of the facet, adds the edge between
    /// the circumcentres of p with the two rim facets of the ridge. These edges bound p's cell.
    void close(const Cavity<D>& cavity, std::size_t n) {
        const auto& rim = cavity.rim[n];
        const auto& vertex = cavity.simplices[rim.simplex].vertex;
        const std::size_t first = cavity.simplices.size();
        const auto order = others(rim.index);
        if constexpr (D == 2) {
            const std::uint32_t v = vertex[order[0]];
            const std::size_t leave = first + cavity.across(rim, order[1]);
            const N t = cross_of(centre[leave].at, centre[first + n].at);
            measure[v] = measure[v] + (sums_ == OverlapSums::smooth ? t * square(v) : t);
            add_facet(v, t, first + n, leave);
            add_error(1, leave, first + n);
        } else {
            for (std::size_t r = 0; r < 3; ++r) {
                const std::uint32_t i = vertex[order[r]], j = vertex[order[(r + 1) % 3]];
                if (i < j) close(i, j, first + n, first + cavity.across(rim, order[(r + 2) % 3]));
            }
        }
    }
    /// Adds the edge from b to a of the facet between i and j, and the reversed edge to the facets between
    /// p's cell and the cells of i and j.
    void close(std::uint32_t i, std::uint32_t j, std::size_t a, std::size_t b)
        requires(D == 3)
    {
        const Vector normal = cross_of(centre[a].at, centre[b].at);
        const N x = half_of(i, normal), y = half_of(j, normal);
        measure[i] = measure[i] - y;
        measure[j] = measure[j] + x;
        add_facet(i, x, a, b);
        add_facet(j, N(0) - y, a, b);
        add_error(site[i].size + site[j].size, a, b);
    }
    /// Adds the edge from a to b to the facet between p's cell and the cell of i.
    void add_facet(std::uint32_t i, const N& t, std::size_t a, std::size_t b) {
        if (sums_ == OverlapSums::measures) return;
        facet[i] = facet[i] + t;
        if (sums_ != OverlapSums::moments) return;
        for (std::size_t k = 0; k < D; ++k) {
            N sum = centre[a].at[k] + centre[b].at[k];
            if constexpr (D == 3) sum = sum + half() * site[i].at[k];
            moment[i][k] = moment[i][k] + t * sum;
        }
    }

    static N half() noexcept {
        if constexpr (measures_error) {
            return 0.5;
        } else {
            return inverse(N(2));
        }
    }
    N half_of(std::uint32_t i, const Vector& normal) const noexcept {
        N sum(0);
        for (std::size_t k = 0; k < D; ++k) sum = sum + site[i].at[k] * normal[k];
        return half() * sum;
    }
    N square(std::uint32_t i) const noexcept {
        N sum(0);
        for (const N& x : site[i].at) sum = sum + x * x;
        return sum;
    }
    void add_error(double length, std::size_t a, std::size_t b) noexcept {
        if constexpr (measures_error) {
            const Centre &x = centre[a], &y = centre[b];
            const double bound = length * (x.size * (y.error + 0x1p-52 * y.size) + y.size * x.error);
            squares += bound * bound;
        }
    }

    OverlapSums sums_ = OverlapSums::moments;
    /// |y − P|² − |y − p|² at each circumcentre y, equal for all vertices P of its simplex; smooth only.
    std::vector<N> height_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
