// What the Voronoi cell of a new place takes from the cells of the sites.
#pragma once

#include <cageform/cage/sites/delaunay.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Scratch memory of at least `size` elements, which is never given back.
template <class T>
void grow_to(std::vector<T>& scratch, std::size_t size) {
    if (scratch.size() < size) scratch.resize(size);
}

/// The cavity of a place in numbers from 0 on: its sites, simplices, and the facets of its rim.
template <std::size_t D>
struct Cavity {
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    struct Simplex {
        std::array<std::uint32_t, D + 1> vertex; ///< of `vertices`
        std::array<std::uint32_t, D + 1> inner;  ///< the neighbour in the cavity, or none
        std::array<std::uint32_t, D + 1> rim;    ///< the facet of the rim without vertex k, or none
    };
    struct RimFacet {
        std::uint32_t simplex;
        std::uint32_t index; ///< of the vertex that it is without
    };

    // Until the next fill.
    std::span<const std::uint32_t> vertices; ///< of the triangulation, as they come in its simplices
    std::span<const std::uint32_t> numbers;  ///< of the triangulation's simplices: those given
    std::span<const Simplex> simplices;
    std::span<const RimFacet> rim;

    /// `cavity`: without ghosts, ascending; it is kept.
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

    /// The other facet of the rim at the ridge of `facet` without its vertex `y`: found by turning
    /// about the ridge through the cavity.
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
    std::vector<std::uint32_t> of_vertex_, of_simplex_; ///< numbers here; none but within `fill`
};

/// A vector of numbers of any kind.
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

/// What is summed over stolen parts.
enum class StolenParts : std::uint8_t {
    measures,
    facets,  ///< measures and facets
    moments, ///< measures, facets and moments
    smooth,  ///< smooth measures
};

/// The measures of the stolen parts, with p as origin, summed over the edges of Voronoi facets
/// (specification, section 5): sums of determinants of circumcentres in which no loop needs an
/// order. N is double or WideFloat.
template <class N, std::size_t D>
struct Stolen {
    using Vector = Numbers<N, D>;

    /// Seen from p, in steps of the lattice. Sizes and errors are of use in double only.
    struct Site {
        Vector at;
        double size; ///< Σ|x|
    };
    struct Centre {
        Vector at;
        double size, error; ///< Σ|x|, and a bound of the error of every x
    };

    // In. All vectors are as long as they ever had to be.
    std::vector<Site> site;     ///< of the cavity's vertices
    std::vector<Centre> centre; ///< of its simplices, then of p and the facets of its rim
    // Out, for every vertex; what is not asked for is left as it is.
    std::vector<N> measure; ///< D! times the stolen area or volume
    std::vector<N> facet;   ///< (D − 1)! |P|/2 times the length or area of the facet of p's cell towards it
    std::vector<Vector> moment; ///< |P|²/2 times the gradient of `measure` in p
    double squares = 0;         ///< of bounds of the rounding of every term, summed; double only

    void make_room(const Cavity<D>& cavity) {
        grow_to(site, cavity.vertices.size());
        grow_to(centre, cavity.simplices.size() + cavity.rim.size());
        grow_to(measure, cavity.vertices.size());
        grow_to(facet, cavity.vertices.size());
        grow_to(moment, cavity.vertices.size());
    }
    /// Smooth measures are those of the C² coordinates of Hiyoshi & Sugihara, in the plane:
    /// ∫ (|y − P|² − |y − p|²) dy over the stolen part, times 6. They have no facets and moments.
    void sum(const Cavity<D>& cavity, StolenParts parts) {
        parts_ = parts;
        const std::size_t count = cavity.vertices.size();
        std::fill_n(measure.begin(), count, N(0));
        if (parts != StolenParts::measures) std::fill_n(facet.begin(), count, N(0));
        if (parts == StolenParts::moments) std::fill_n(moment.begin(), count, Vector{});
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

    /// The other vertices of a simplex than k, in an order that makes an even permutation of it with
    /// k as the last.
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
        if (parts_ != StolenParts::smooth) return;
        for (std::size_t n = 0; n < cavity.simplices.size(); ++n) {
            const Vector& r = site[cavity.simplices[n].vertex[0]].at;
            const Vector& c = centre[n].at;
            height_.push_back(r[0] * r[0] + r[1] * r[1] - N(2) * (c[0] * r[0] + c[1] * r[1]));
        }
        height_.resize(cavity.simplices.size() + cavity.rim.size(), N(0));
    }

    /// The edge from centre `a` of a simplex across its facet without vertex `k` to centre `b`: one
    /// of the Voronoi facets of every two vertices of that facet, as a determinant of the middle of
    /// both, a and b.
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
            note_error(1, a, b);
        } else {
            const std::uint32_t l = simplex.vertex[order[2]];
            const Vector normal = cross_of(centre[b].at, centre[a].at);
            const N x = half_of(i, normal), y = half_of(j, normal), z = half_of(l, normal);
            measure[i] = measure[i] + (y - z);
            measure[j] = measure[j] + (z - x);
            measure[l] = measure[l] + (x - y);
            note_error(site[i].size + site[j].size + site[l].size, a, b);
        }
    }
    /// At each ridge of a facet of the rim, from the centre at which the path about it leaves the
    /// cavity to that at which it enters.
    void close(const Cavity<D>& cavity, std::size_t n) {
        const auto& rim = cavity.rim[n];
        const auto& vertex = cavity.simplices[rim.simplex].vertex;
        const std::size_t first = cavity.simplices.size();
        const auto order = others(rim.index);
        if constexpr (D == 2) {
            const std::uint32_t v = vertex[order[0]];
            const std::size_t leave = first + cavity.across(rim, order[1]);
            const N t = cross_of(centre[leave].at, centre[first + n].at);
            measure[v] = measure[v] + (parts_ == StolenParts::smooth ? t * square(v) : t);
            add_facet(v, t, first + n, leave);
            note_error(1, leave, first + n);
        } else {
            for (std::size_t r = 0; r < 3; ++r) {
                const std::uint32_t i = vertex[order[r]], j = vertex[order[(r + 1) % 3]];
                if (i < j) close(i, j, first + n, first + cavity.across(rim, order[(r + 2) % 3]));
            }
        }
    }
    /// The edge from b to a of the facet between i and j, and back those of p's facets towards both.
    void close(std::uint32_t i, std::uint32_t j, std::size_t a, std::size_t b) requires(D == 3) {
        const Vector normal = cross_of(centre[a].at, centre[b].at);
        const N x = half_of(i, normal), y = half_of(j, normal);
        measure[i] = measure[i] - y;
        measure[j] = measure[j] + x;
        add_facet(i, x, a, b);
        add_facet(j, N(0) - y, a, b);
        note_error(site[i].size + site[j].size, a, b);
    }
    /// An edge a b of the facet of p's cell towards i.
    void add_facet(std::uint32_t i, const N& t, std::size_t a, std::size_t b) {
        if (parts_ == StolenParts::measures) return;
        facet[i] = facet[i] + t;
        if (parts_ != StolenParts::moments) return;
        for (std::size_t k = 0; k < D; ++k) {
            N sum = centre[a].at[k] + centre[b].at[k];
            if constexpr (D == 3) sum = sum + half() * site[i].at[k];
            moment[i][k] = moment[i][k] + t * sum;
        }
    }

    static N half() noexcept {
        if constexpr (measures_error)
            return 0.5;
        else
            return inverse(N(2));
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
    void note_error(double length, std::size_t a, std::size_t b) noexcept {
        if constexpr (measures_error) {
            const Centre &x = centre[a], &y = centre[b];
            const double bound = length * (x.size * (y.error + 0x1p-52 * y.size) + y.size * x.error);
            squares += bound * bound;
        }
    }

    StolenParts parts_ = StolenParts::moments;
    std::vector<N> height_; ///< |y − P|² − |y − p|² at circumcentres, for the sites P of each; smooth only
};

} // namespace cageform::inline CAGEFORM_ABI::detail
