// The Delaunay triangulation of sites, in 2D and 3D.
#pragma once

#include <cageform/cage/sites/insertion_order.hpp>
#include <cageform/cage/sites/site_lattice.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A Delaunay triangulation, with a *ghost* simplex beyond every facet of the convex hull.
///
/// Inserts site by site (Bowyer 1981, Watson 1981) with exact predicates. Sites are rounded to a lattice of
/// step 2^-60 extents (site_lattice.hpp). Determinants of uncertain sign in double are evaluated in
/// integers. Points on a sphere count as outside, so no simplex is flat. The numbering of vertices and
/// simplices depends only on the positions of the sites.
///
///   cost    O(n log n) for usual sites, O(n²) at worst in 3D
///   memory  6 triangles or about 7 tetrahedra of 64 bytes per site
template <std::size_t D>
class Delaunay {
    static_assert(D == 2 || D == 3);

public:
    static constexpr std::uint32_t none = ~std::uint32_t{0};
    /// The vertex at infinity, which is the last vertex of every ghost.
    static constexpr std::uint32_t infinite = none;

    /// Vertices are ascending, except that the first two may be swapped for positive orientation
    /// (`detail::orientation`). A ghost has the orientation of a simplex whose last vertex is a point beyond
    /// the ghost's facet. Neighbour k is across the facet opposite to vertex k.
    struct Simplex {
        std::array<std::uint32_t, D + 1> vertex;
        std::array<std::uint32_t, D + 1> neighbour;

        bool is_ghost() const noexcept { return vertex[D] == infinite; }
        std::size_t index_of(std::uint32_t v) const noexcept { return index(vertex, v); }
        std::size_t index_of_neighbour(std::uint32_t s) const noexcept { return index(neighbour, s); }

    private:
        static std::size_t index(const std::array<std::uint32_t, D + 1>& all, std::uint32_t x) noexcept {
            std::size_t k = 0;
            while (k < D && all[k] != x) ++k;
            return k;
        }
    };

    /// The working memory of a search, one per thread.
    class Search {
        friend class Delaunay;

    public:
        /// Returns the *cavity*: the simplices whose open balls contain the point, in ascending order.
        std::span<const std::uint32_t> cavity() const noexcept { return cavity_; }
        bool holds(std::uint32_t simplex) const noexcept { return stamps_[simplex] == stamp_; }

    private:
        void begin(std::size_t simplices) {
            cavity_.clear();
            if (stamps_.size() < simplices) stamps_.resize(simplices, 0);
            stamp_ += 2; // odd: visited, even: in the cavity
            if (stamp_ != 0) return;
            std::fill(stamps_.begin(), stamps_.end(), 0u);
            stamp_ = 2;
        }

        std::vector<std::uint32_t> cavity_, stamps_;
        std::uint32_t stamp_ = 0;
        std::uint32_t last_ = 0; ///< start of the next walk
    };

    Delaunay() = default;

    /// Triangulates points on a lattice and skips duplicates. The result is empty if all points lie in one
    /// plane (in 2D, on one line).
    explicit Delaunay(std::vector<detail::LatticePoint<D>> points)
        : site_(points.size())
        , point_(std::move(points)) {
        sort_sites();
        Search search;
        if (!begin()) return;
        for (std::uint32_t i = D + 1; i < point_.size(); ++i) insert(i, search);
        finish();
        find_centres();
        make_start_grid();
    }

    bool empty() const noexcept { return simplices_.empty(); }
    std::size_t size() const noexcept { return point_.size(); }
    std::span<const Simplex> simplices() const noexcept { return simplices_; }
    /// Returns the caller's index of a vertex.
    std::uint32_t site(std::uint32_t vertex) const noexcept { return site_[vertex]; }
    const detail::LatticePoint<D>& point(std::uint32_t vertex) const noexcept { return point_[vertex]; }
    /// Returns the circumcentre of a simplex that is not a ghost, relative to its first vertex.
    const detail::Centre<D>& centre(std::uint32_t simplex) const noexcept { return centres_[simplex]; }

    std::array<detail::LatticePoint<D>, D + 1> corners(const Simplex& simplex) const noexcept {
        std::array<detail::LatticePoint<D>, D + 1> a;
        for (std::size_t k = 0; k <= D; ++k) a[k] = point_[simplex.vertex[k]];
        return a;
    }

    /// Returns a simplex that contains `p`, or a ghost if p lies beyond the ghost's facet.
    std::uint32_t locate(const detail::LatticePoint<D>& p, Search& search) const noexcept {
        return walk(p, search, [](std::uint32_t) { return false; });
    }

    /// Finds the cavity of `p`. The cavity is empty if p is a site. If p is outside the hull, the cavity is
    /// incomplete and contains a ghost. Returns a simplex of the cavity or, if p is a site, a simplex with
    /// corner p.
    std::uint32_t find_cavity(const detail::LatticePoint<D>& p, Search& search) const {
        const auto holds = [&](std::uint32_t s) { return certainly_inside(s, p) > 0; };
        const std::uint32_t from = walk(p, search, holds);
        find_cavity(p, from, search);
        return from;
    }

private:
    using LatticePoint = detail::LatticePoint<D>;
    using Corners = std::array<LatticePoint, D + 1>;

    void sort_sites() {
        site_ = detail::insertion_order<D>(point_);
        std::vector<LatticePoint> sorted;
        sorted.reserve(point_.size());
        for (const std::uint32_t site : site_) sorted.push_back(point_[site]);
        point_ = std::move(sorted);
    }

    /// Makes the first simplex of the first D + 1 affinely independent sites, and moves these to the front.
    bool begin() {
        std::size_t count = 0;
        for (std::size_t i = 0; i < point_.size() && count <= D; ++i) {
            if (!independent(count, point_[i])) continue;
            std::rotate(point_.begin() + std::ptrdiff_t(count), point_.begin() + std::ptrdiff_t(i),
                        point_.begin() + std::ptrdiff_t(i) + 1);
            std::rotate(site_.begin() + std::ptrdiff_t(count), site_.begin() + std::ptrdiff_t(i),
                        site_.begin() + std::ptrdiff_t(i) + 1);
            ++count;
        }
        if (count <= D) return false;
        Simplex first{};
        for (std::uint32_t k = 0; k <= D; ++k) first.vertex[k] = k;
        if (detail::orientation<D>(corners(first)) < 0) std::swap(first.vertex[0], first.vertex[1]);
        for (std::uint32_t k = 0; k <= D; ++k) first.neighbour[k] = k + 1;
        simplices_.push_back(first);
        for (std::size_t k = 0; k <= D; ++k) {
            // The orientation is reversed beyond facet k, so two vertices are swapped.
            Simplex ghost = first;
            ghost.vertex[k] = infinite;
            ghost.neighbour[k] = 0;
            std::swap(ghost.vertex[(k + 1) % (D + 1)], ghost.vertex[(k + 2) % (D + 1)]);
            std::swap(ghost.neighbour[(k + 1) % (D + 1)], ghost.neighbour[(k + 2) % (D + 1)]);
            simplices_.push_back(ghost);
        }
        return true;
    }
    bool independent(std::size_t count, const LatticePoint& p) const noexcept {
        if (count == 0) return true;
        if (count == D) {
            Corners a;
            std::copy_n(point_.begin(), D, a.begin());
            a[D] = p;
            return detail::orientation<D>(a) != 0;
        }
        if (count == 1) return p != point_[0];
        // In 3D, p is off the line through the first two points if a minor is not zero.
        using detail::WideInt;
        const LatticePoint d = detail::difference<D>(point_[1], point_[0]),
                           e = detail::difference<D>(p, point_[0]);
        for (std::size_t k = 0; k < D; ++k) {
            const std::size_t l = (k + 1) % D;
            if ((WideInt(d[k]) * WideInt(e[l]) - WideInt(d[l]) * WideInt(e[k])).sign() != 0) return true;
        }
        return false;
    }

    // ---- walk and conflict ----------------------------------------------------------------------

    bool is_free(std::uint32_t s) const noexcept { return simplices_[s].neighbour[0] == none; }
    bool has_infinite(std::uint32_t s) const noexcept {
        bool found = false;
        for (const std::uint32_t v : simplices_[s].vertex) found |= v == infinite;
        return found;
    }

    /// Walks towards `p` across facets. Stops at the simplex that contains p, or at the first simplex s for
    /// which found(s) is true.
    template <class Found>
    std::uint32_t walk(const LatticePoint& p, Search& search, const Found& found) const noexcept {
        std::uint32_t at = starts_.empty() ? search.last_ : starts_[cell_of(p)];
        if (at >= simplices_.size()) at = 0;
        if (has_infinite(at)) at = simplices_[at].neighbour[simplices_[at].index_of(infinite)];
        std::uint32_t from = none;
        // A walk may cycle among cospherical simplices. The loop below then searches all simplices.
        for (std::size_t step = 0; step <= 2 * simplices_.size() && !is_free(at); ++step) {
            if (found(at)) return search.last_ = at;
            const std::uint32_t next = step_towards(p, at, from, step);
            if (next == none || has_infinite(next)) return search.last_ = next == none ? at : next;
            from = at;
            at = next;
        }
        for (at = 0; at < simplices_.size(); ++at) {
            if (is_free(at) || has_infinite(at)) continue;
            const std::uint32_t next = step_towards(p, at, none, 0);
            if (next == none || has_infinite(next)) break;
        }
        return search.last_ = (std::min)(at, std::uint32_t(simplices_.size() - 1));
    }
    /// Finds the cavity of p, starting from a simplex that contains p or whose ball contains it.
    void find_cavity(const detail::LatticePoint<D>& p, std::uint32_t from, Search& search) const {
        search.begin(simplices_.size());
        if (!in_conflict(from, p)) return;
        search.stamps_[from] = search.stamp_;
        search.cavity_.push_back(from);
        if (!centres_.empty() && simplices_[from].is_ghost()) return;
        for (std::size_t n = 0; n < search.cavity_.size(); ++n) {
            for (const std::uint32_t next : simplices_[search.cavity_[n]].neighbour) {
                if (search.stamps_[next] >= search.stamp_ - 1) continue;
                const bool inside = in_conflict(next, p);
                search.stamps_[next] = search.stamp_ - (inside ? 0 : 1);
                if (inside) search.cavity_.push_back(next);
                if (inside && !centres_.empty() && simplices_[next].is_ghost()) return;
            }
        }
        std::sort(search.cavity_.begin(), search.cavity_.end());
    }
    /// Returns the neighbour across a facet that strictly separates `p` from the simplex, or none.
    /// `rotation` selects the first facet to test; the simplex that the walk came from is skipped.
    std::uint32_t step_towards(const LatticePoint& p, std::uint32_t at, std::uint32_t from,
                               std::size_t rotation) const noexcept {
        const Simplex& simplex = simplices_[at];
        const detail::RelativeCorners<D> relative(corners(simplex), p);
        for (std::size_t n = 0; n <= D; ++n) {
            const std::size_t k = (n + rotation) % (D + 1);
            if (simplex.neighbour[k] != from && relative.side(k) < 0) return simplex.neighbour[k];
        }
        return none;
    }

    /// Tests in double, with the circumcentre, whether the ball of a simplex strictly contains `p`. The
    /// simplex must not be a ghost. Returns 1 if it does, −1 if it does not, 0 if uncertain.
    int certainly_inside(std::uint32_t s, const LatticePoint& p) const noexcept {
        return detail::certain_in_sphere<D>(point_[simplices_[s].vertex[0]], centres_[s], p);
    }
    /// Whether the ball of a simplex strictly contains `p`. The ball of a ghost is the half-space beyond
    /// its facet, together with the part of the facet's plane inside the adjacent simplex's ball.
    bool in_conflict(std::uint32_t s, const LatticePoint& p) const noexcept {
        const Simplex& simplex = simplices_[s];
        if (!centres_.empty() && !simplex.is_ghost()) {
            if (const int sign = certainly_inside(s, p); sign != 0) return sign > 0;
        }
        const std::size_t k = simplex.index_of(infinite);
        if (simplex.vertex[k] != infinite) return detail::in_sphere<D>(corners(simplex), p) > 0;
        Corners a;
        for (std::size_t n = 0; n <= D; ++n) a[n] = n == k ? p : point_[simplex.vertex[n]];
        const int side = detail::orientation<D>(a);
        if (side != 0) return side > 0;
        return detail::in_sphere<D>(corners(simplices_[simplex.neighbour[k]]), p) > 0;
    }

    // ---- insertion ------------------------------------------------------------------------------

    /// A facet of a new simplex that contains the new site. It is paired with the same facet of another new
    /// simplex.
    struct OpenFacet {
        std::array<std::uint32_t, D - 1> ridge; ///< the other vertices, ascending
        std::uint32_t simplex;
        std::uint32_t index;
    };

    void insert(std::uint32_t v, Search& search) {
        const std::uint32_t from = locate(point_[v], search);
        find_cavity(point_[v], from, search);
        if (search.cavity_.empty()) return; // a duplicate
        open_.clear();
        added_.clear();
        for (const std::uint32_t s : search.cavity_) {
            for (std::size_t k = 0; k <= D; ++k) {
                const std::uint32_t beyond = simplices_[s].neighbour[k];
                if (!search.holds(beyond)) add_simplex(v, s, k);
            }
        }
        for (const std::uint32_t s : search.cavity_) {
            simplices_[s].neighbour[0] = none;
            free_.push_back(s);
        }
        std::sort(open_.begin(), open_.end(),
                  [](const OpenFacet& a, const OpenFacet& b) { return a.ridge < b.ridge; });
        for (std::size_t n = 0; n + 1 < open_.size(); n += 2) {
            simplices_[open_[n].simplex].neighbour[open_[n].index] = open_[n + 1].simplex;
            simplices_[open_[n + 1].simplex].neighbour[open_[n + 1].index] = open_[n].simplex;
        }
        search.last_ = added_.front();
    }
    void add_simplex(std::uint32_t v, std::uint32_t s, std::size_t k) {
        Simplex fresh = simplices_[s];
        const std::uint32_t beyond = fresh.neighbour[k];
        fresh.vertex[k] = v;
        std::uint32_t number = std::uint32_t(simplices_.size());
        if (free_.empty()) {
            simplices_.push_back(fresh);
        } else {
            number = free_.back();
            free_.pop_back();
            simplices_[number] = fresh;
        }
        added_.push_back(number);
        Simplex& outside = simplices_[beyond];
        outside.neighbour[outside.index_of_neighbour(s)] = number;
        for (std::size_t j = 0; j <= D; ++j) {
            if (j == k) continue;
            OpenFacet facet{{}, number, std::uint32_t(j)};
            std::size_t n = 0;
            for (std::size_t i = 0; i <= D; ++i) {
                if (i != j && i != k) facet.ridge[n++] = fresh.vertex[i];
            }
            std::sort(facet.ridge.begin(), facet.ridge.end());
            open_.push_back(facet);
        }
    }

    // ---- final order ----------------------------------------------------------------------------

    /// Sorts the vertices within each simplex, then the simplices.
    void finish() {
        std::vector<std::uint32_t> order;
        for (std::uint32_t s = 0; s < simplices_.size(); ++s) {
            if (is_free(s)) continue;
            sort_vertices(simplices_[s]);
            order.push_back(s);
        }
        const auto less = [&](std::uint32_t a, std::uint32_t b) {
            auto x = simplices_[a].vertex, y = simplices_[b].vertex;
            if (x[1] < x[0]) std::swap(x[0], x[1]);
            if (y[1] < y[0]) std::swap(y[0], y[1]);
            return x < y;
        };
        std::sort(order.begin(), order.end(), less);
        std::vector<std::uint32_t> number(simplices_.size(), none);
        for (std::uint32_t n = 0; n < order.size(); ++n) number[order[n]] = n;
        std::vector<Simplex> sorted;
        sorted.reserve(order.size());
        for (const std::uint32_t s : order) {
            sorted.push_back(simplices_[s]);
            for (std::uint32_t& next : sorted.back().neighbour) next = number[next];
        }
        simplices_ = std::move(sorted);
        free_ = {};
        added_ = {};
        open_ = {};
    }
    void find_centres() {
        centres_.reserve(simplices_.size());
        for (const Simplex& simplex : simplices_) {
            centres_.push_back(simplex.is_ghost() ? detail::Centre<D>{}
                                                  : detail::circumcentre<D>(corners(simplex)));
        }
    }
    /// Makes a grid with fewer cells than sites; each cell stores a start for walks.
    void make_start_grid() {
        if (size() < 64) return;
        int bits = 0;
        while ((std::size_t{1} << (D * std::size_t(bits + 1))) <= size()) ++bits;
        const int shift = 60 - bits;
        std::vector<std::uint32_t> starts(std::size_t{1} << (D * std::size_t(bits)));
        Search search;
        for (std::size_t cell = 0; cell < starts.size(); ++cell) {
            LatticePoint middle;
            for (std::size_t k = 0; k < D; ++k) {
                const std::size_t n = (cell >> (k * std::size_t(bits))) & ((std::size_t{1} << bits) - 1);
                middle[k] = (std::int64_t(2 * n + 1) << shift) / 2;
            }
            starts[cell] = locate(middle, search);
        }
        starts_ = std::move(starts);
        grid_bits_ = bits;
    }
    std::size_t cell_of(const LatticePoint& p) const noexcept {
        const std::int64_t last = (std::int64_t{1} << grid_bits_) - 1;
        std::size_t cell = 0;
        for (std::size_t k = D; k-- > 0;) {
            const std::int64_t n = std::clamp(p[k] >> (60 - grid_bits_), std::int64_t{0}, last);
            cell = (cell << grid_bits_) | std::size_t(n);
        }
        return cell;
    }
    static void sort_vertices(Simplex& simplex) noexcept {
        bool odd = false;
        const auto exchange = [&](std::size_t a, std::size_t b) {
            std::swap(simplex.vertex[a], simplex.vertex[b]);
            std::swap(simplex.neighbour[a], simplex.neighbour[b]);
            odd = !odd;
        };
        for (std::size_t i = 1; i <= D; ++i) {
            for (std::size_t k = i; k > 0 && simplex.vertex[k] < simplex.vertex[k - 1]; --k)
                exchange(k, k - 1);
        }
        if (odd) exchange(0, 1);
    }

    std::vector<std::uint32_t> site_; ///< the caller's index of each vertex
    std::vector<LatticePoint> point_;
    std::vector<Simplex> simplices_;
    std::vector<detail::Centre<D>> centres_;
    std::vector<std::uint32_t> starts_; ///< start of walks, per grid cell
    int grid_bits_ = 0;                 ///< log2 of the number of cells along an axis
    std::vector<std::uint32_t> free_, added_;
    std::vector<OpenFacet> open_;
};

} // namespace cageform::inline CAGEFORM_ABI
