// What the Voronoi cell of a new place takes from the cells of the sites.
#pragma once

#include <cageform/cage/delaunay.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

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

    Place<D> place{};
    std::vector<std::uint32_t> vertices; ///< of the triangulation, ascending
    std::vector<std::uint32_t> numbers;  ///< of the triangulation's simplices
    std::vector<Simplex> simplices;
    std::vector<RimFacet> rim;

    void fill(const Delaunay<D>& sites, const Place<D>& p, std::span<const std::uint32_t> cavity) {
        place = p;
        numbers.assign(cavity.begin(), cavity.end());
        vertices.clear();
        for (const std::uint32_t s : numbers) {
            const auto& vertex = sites.simplices()[s].vertex;
            vertices.insert(vertices.end(), vertex.begin(), vertex.end());
        }
        std::sort(vertices.begin(), vertices.end());
        vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
        simplices.resize(numbers.size());
        rim.clear();
        for (std::uint32_t n = 0; n < numbers.size(); ++n) {
            const auto& from = sites.simplices()[numbers[n]];
            for (std::uint32_t k = 0; k <= D; ++k) {
                simplices[n].vertex[k] = find(vertices, from.vertex[k]);
                simplices[n].inner[k] = find(numbers, from.neighbour[k]);
                simplices[n].rim[k] = none;
                if (simplices[n].inner[k] != none) continue;
                simplices[n].rim[k] = std::uint32_t(rim.size());
                rim.push_back({n, k});
            }
        }
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
    static std::uint32_t find(const std::vector<std::uint32_t>& sorted, std::uint32_t x) noexcept {
        const auto at = std::lower_bound(sorted.begin(), sorted.end(), x);
        return at != sorted.end() && *at == x ? std::uint32_t(at - sorted.begin()) : none;
    }
};

/// A vector of numbers of any kind.
template <class N, std::size_t D>
using Numbers = std::array<N, D>;

template <class N>
N cross_of(const Numbers<N, 2>& a, const Numbers<N, 2>& b) noexcept {
    return a[0] * b[1] - a[1] * b[0];
}
template <class N>
N triple(const Numbers<N, 3>& m, const Numbers<N, 3>& a, const Numbers<N, 3>& b) noexcept {
    return m[0] * (a[1] * b[2] - a[2] * b[1]) + m[1] * (a[2] * b[0] - a[0] * b[2]) +
           m[2] * (a[0] * b[1] - a[1] * b[0]);
}

/// The measures of the stolen parts, with p as origin, summed over the edges of Voronoi facets
/// (specification, section 5): sums of determinants of circumcentres in which no loop needs an
/// order. N is double or WideFloat.
template <class N, std::size_t D>
struct Stolen {
    using Vector = Numbers<N, D>;

    // In: seen from p, in steps of the lattice.
    std::vector<Vector> site;        ///< of the cavity's vertices
    std::vector<Vector> centre;      ///< of its simplices
    std::vector<Vector> rim_centre;  ///< of p and the facets of its rim
    std::vector<double> size, error; ///< Σ|x| of all centres, and bounds of their errors; double only
    // Out, for every vertex.
    std::vector<N> measure; ///< D! times the stolen area or volume
    std::vector<N> facet;   ///< (D − 1)! |P|/2 times the length or area of the facet of p's cell towards it
    std::vector<Vector> moment; ///< |P|²/2 times the gradient of `measure` in p
    double bound = 0;           ///< of the rounding of all measures together; double only

    /// `smooth`: the measures are those of the C² coordinates of Hiyoshi & Sugihara, in the plane:
    /// ∫ (|y − P|² − |y − p|²) dy over the stolen part, times 6. Without facets and moments.
    void sum(const Cavity<D>& cavity, bool smooth) {
        const std::size_t count = cavity.vertices.size();
        measure.assign(count, N(0));
        facet.assign(count, N(0));
        moment.assign(count, Vector{});
        bound = 0;
        if constexpr (D == 2) heights(cavity, smooth);
        for (std::size_t n = 0; n < cavity.simplices.size(); ++n) {
            const auto& simplex = cavity.simplices[n];
            for (std::uint32_t k = 0; k <= D; ++k) {
                if (simplex.inner[k] == Cavity<D>::none) {
                    dual_edge(simplex, k, n, centre.size() + simplex.rim[k]);
                } else if (n < simplex.inner[k]) {
                    dual_edge(simplex, k, n, simplex.inner[k]);
                }
            }
        }
        for (std::size_t n = 0; n < cavity.rim.size(); ++n) close(cavity, n, smooth);
    }

private:
    std::vector<N> height_; ///< |y − P|² − |y − p|² at circumcentres, for the sites P of each; smooth only

    const Vector& at(std::size_t c) const noexcept {
        return c < centre.size() ? centre[c] : rim_centre[c - centre.size()];
    }
    static constexpr bool measures_error = std::is_same_v<N, double>;

    void heights(const Cavity<D>& cavity, bool smooth) {
        height_.clear();
        if (!smooth) return;
        for (std::size_t n = 0; n < cavity.simplices.size(); ++n) {
            const Vector& r = site[cavity.simplices[n].vertex[0]];
            const Vector& c = centre[n];
            height_.push_back(r[0] * r[0] + r[1] * r[1] - N(2) * (c[0] * r[0] + c[1] * r[1]));
        }
        height_.resize(centre.size() + rim_centre.size(), N(0));
    }

    /// Whether the vertices at the places i, j (, y) of a simplex, then its vertex k, are an even
    /// permutation of the simplex.
    static bool is_even(std::array<std::uint32_t, D + 1> order) noexcept {
        bool even = true;
        for (std::size_t a = 0; a <= D; ++a) {
            for (std::size_t b = a + 1; b <= D; ++b) even ^= order[b] < order[a];
        }
        return even;
    }

    /// The edge from centre `a` of a simplex across its facet without vertex `k` to centre `b`.
    void dual_edge(const typename Cavity<D>::Simplex& simplex, std::uint32_t k, std::size_t a,
                   std::size_t b) {
        if constexpr (D == 2) {
            std::uint32_t i = (k + 1) % 3, j = (k + 2) % 3; // (i, j, k) is even
            add_edge(simplex.vertex[i], simplex.vertex[j], b, a);
        } else {
            for (std::uint32_t y = 0; y < 4; ++y) {
                if (y == k) continue;
                std::uint32_t i = 0;
                while (i == k || i == y) ++i;
                const std::uint32_t j = 6 - i - k - y;
                const bool even = is_even({i, j, y, k});
                add_edge(simplex.vertex[i], simplex.vertex[j], even ? b : a, even ? a : b);
            }
        }
    }
    /// An edge of the Voronoi facet of i and j, counter-clockwise seen from j.
    void add_edge(std::uint32_t i, std::uint32_t j, std::size_t a, std::size_t b) {
        if constexpr (D == 2) {
            const N t = cross_of(at(a), at(b));
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
            Vector m;
            for (std::size_t k = 0; k < D; ++k) m[k] = half() * (site[i][k] + site[j][k]);
            const N t = triple(m, at(a), at(b));
            measure[i] = measure[i] + t;
            measure[j] = measure[j] - t;
            note_error(size_of(m), a, b);
        }
    }
    /// At each ridge of a facet of the rim, from the centre at which the path about it leaves the
    /// cavity to that at which it enters.
    void close(const Cavity<D>& cavity, std::size_t n, bool smooth) {
        const auto& rim = cavity.rim[n];
        const auto& simplex = cavity.simplices[rim.simplex];
        for (std::uint32_t y = 0; y <= D; ++y) {
            if (y == rim.index) continue;
            if constexpr (D == 2) {
                const std::uint32_t i = 3 - y - rim.index;
                if (!is_even({i, y, rim.index})) continue;
                const std::size_t enter = centre.size() + n, leave = centre.size() + cavity.across(rim, y);
                const std::uint32_t v = simplex.vertex[i];
                const N t = cross_of(at(leave), at(enter));
                measure[v] = measure[v] + (smooth ? t * square(v) : t);
                add_facet(v, t, enter, leave);
                note_error(1, leave, enter);
            } else {
                std::uint32_t i = 0;
                while (i == rim.index || i == y) ++i;
                std::uint32_t j = 6 - i - y - rim.index;
                if (simplex.vertex[j] < simplex.vertex[i]) std::swap(i, j);
                if (!is_even({i, j, y, rim.index})) continue;
                const std::size_t enter = centre.size() + n, leave = centre.size() + cavity.across(rim, y);
                add_edge(simplex.vertex[i], simplex.vertex[j], leave, enter);
                close_facet(simplex.vertex[i], enter, leave);
                close_facet(simplex.vertex[j], leave, enter);
            }
        }
    }
    /// An edge of the facet of p's cell towards i.
    void close_facet(std::uint32_t i, std::size_t a, std::size_t b) requires(D == 3) {
        Vector m;
        for (std::size_t k = 0; k < D; ++k) m[k] = half() * site[i][k];
        const N t = triple(m, at(a), at(b));
        measure[i] = measure[i] + t;
        Vector& sum = moment[i];
        facet[i] = facet[i] + t;
        for (std::size_t k = 0; k < D; ++k) sum[k] = sum[k] + t * (m[k] + at(a)[k] + at(b)[k]);
        note_error(size_of(m), a, b);
    }
    void add_facet(std::uint32_t i, const N& t, std::size_t a, std::size_t b) requires(D == 2) {
        facet[i] = facet[i] + t;
        for (std::size_t k = 0; k < D; ++k) moment[i][k] = moment[i][k] + t * (at(a)[k] + at(b)[k]);
    }

    static N half() noexcept {
        if constexpr (measures_error)
            return 0.5;
        else
            return inverse(N(2));
    }
    N square(std::uint32_t i) const noexcept {
        N sum(0);
        for (const N& x : site[i]) sum = sum + x * x;
        return sum;
    }
    static double size_of(const Vector& m) noexcept {
        if constexpr (measures_error) {
            double sum = 0;
            for (const double x : m) sum += std::fabs(x);
            return sum;
        } else {
            return 0;
        }
    }
    void note_error(double length, std::size_t a, std::size_t b) noexcept {
        if constexpr (measures_error)
            bound += length * (size[a] * error[b] + size[b] * error[a] + 0x1p-52 * size[a] * size[b]);
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
