// Gradients at sites, estimated from values there.
#pragma once

#include <cageform/coordinates/sibson/natural_neighbours.hpp>
#include <cageform/core/affine/orthonormal_rows.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// How gradients at sites follow from the values there: least squares over the Voronoi neighbours j
/// of a site i, weighted by μ = |F| / |d| with F the facet between both cells and d = P_j − P_i.
/// Exact for linear functions. Cells of sites on the hull are unbounded: they are cut by their
/// mirror image in the site.
enum class SiteGradients : std::uint8_t {
    facets,   ///< exact for a + b·x + γ|x|² too at inner sites: the most accurate on even sites
    gentle,   ///< μ = |F| |d|: weights are less negative, and less accurate
    mirrored, ///< all cells are cut by their mirror image: for rings of sites, one close to another
};

namespace detail {

/// The gradient at every site as a linear map of values: g_i = Σ G_il z_l, Σ_l G_il = 0.
template <std::size_t D>
class SiteGradientRows {
public:
    struct Term {
        std::uint32_t site;
        Vec<double, D> vector; ///< per unit of length
    };

    SiteGradientRows() = default;
    /// `on_hull`: of every site, by the user's numbers.
    SiteGradientRows(const NaturalNeighbours<D>& sites, SiteGradients rule, const std::vector<bool>& on_hull)
        : sites_(&sites.sites())
        , rule_(rule)
        , unit_(sites.step())
        , tolerance_(sites.tolerance()) {
        const std::size_t count = sites_->size();
        list_neighbours();
        rows_.resize(count);
        for (std::uint32_t v = 0; v < count; ++v) {
            fill(v, on_hull[sites_->site(v)] || rule == SiteGradients::mirrored);
        }
        sites_ = nullptr;
        neighbours_ = {};
    }

    std::span<const Term> row(std::size_t site) const noexcept { return rows_[site]; }

private:
    /// Delaunay neighbours, of every vertex in ascending order.
    void list_neighbours() {
        neighbours_.resize(sites_->size());
        for (const auto& simplex : sites_->simplices()) {
            for (std::size_t i = 0; !simplex.is_ghost() && i <= D; ++i) {
                for (std::size_t k = 0; k <= D; ++k) {
                    if (i != k) neighbours_[simplex.vertex[i]].push_back(simplex.vertex[k]);
                }
            }
        }
        for (auto& list : neighbours_) {
            std::sort(list.begin(), list.end());
            list.erase(std::unique(list.begin(), list.end()), list.end());
        }
    }

    void fill(std::uint32_t v, bool mirrored) {
        const auto& around = neighbours_[v];
        if (around.empty()) return;
        std::vector<Place<D>> places;
        for (const std::uint32_t n : around)
            places.push_back(difference<D>(sites_->place(n), sites_->place(v)));
        if (mirrored) add_mirrored(places);
        // The cell of v is that of a new place at v among its neighbours.
        const Delaunay<D> local(std::move(places));
        if (local.empty()) return;
        (void)local.find_cavity({}, search_);
        for (const std::uint32_t s : search_.cavity()) {
            if (local.simplices()[s].is_ghost()) return mirrored ? void() : fill(v, true);
        }
        if (!cell_.fill(local, {}, search_.cavity(), StolenParts::facets)) return;
        fit(v, local);
    }

    /// The mirror images of neighbours but for those at another neighbour's place: on lattices and
    /// rings, where rounding would decide which of the two has the facet.
    void add_mirrored(std::vector<Place<D>>& places) const {
        const std::size_t count = places.size();
        for (std::size_t n = 0; n < count; ++n) {
            const Place<D> mirrored = difference<D>({}, places[n]);
            const auto coincides = [&](const Place<D>& other) {
                return length(to_double<D>(difference<D>(other, mirrored))) * unit_ <= 4 * tolerance_;
            };
            if (std::none_of(places.begin(), places.begin() + std::ptrdiff_t(count), coincides))
                places.push_back(mirrored);
        }
    }

    void fit(std::uint32_t v, const Delaunay<D>& local) {
        const auto& around = neighbours_[v];
        double size = 0; // the nearest neighbour's distance
        for (std::size_t n = 0; n < cell_.cavity.vertices.size(); ++n) {
            const double distance = length(cell_.seen(n));
            if (size == 0 || distance < size) size = distance;
        }
        auto& row = rows_[sites_->site(v)];
        Buffer<Vec<double, D>> scaled; // d times the square root of its weight in the sum of squares
        std::vector<double> root;
        for (std::size_t n = 0; n < cell_.cavity.vertices.size(); ++n) {
            const std::uint32_t number = local.site(cell_.cavity.vertices[n]);
            const auto d = (1 / size) * cell_.seen(n);
            const double d2 = dot(d, d);
            // The facet's area is `facet` / |d| times a constant; both μ are divided by |d|².
            const double weight =
                std::fmax(cell_.facet(n), 0.0) / (rule_ == SiteGradients::gentle ? d2 : d2 * d2);
            if (number >= around.size() || !(weight > 0)) continue;
            root.push_back(std::sqrt(weight));
            scaled.push_back(root.back() * d);
            row.push_back({sites_->site(around[number]), {}});
        }
        // With A = QR the pseudoinverse is R⁻¹Qᵀ: the condition is not squared, as it is in AᵀA.
        const OrthonormalRows<D> rows(std::move(scaled));
        for (std::size_t k = 0; k < D; ++k) {
            if (rows.triangle()[k][k] == 0) return row.clear();
        }
        Vec<double, D> sum{};
        for (std::size_t n = 0; n < row.size(); ++n) {
            row[n].vector = (root[n] / (size * unit_)) * coefficients(rows.triangle(), rows[n]);
            sum = sum + row[n].vector;
        }
        row.push_back({sites_->site(v), -1.0 * sum});
    }

    const Delaunay<D>* sites_ = nullptr;
    SiteGradients rule_ = SiteGradients::facets;
    double unit_ = 1; ///< a step of the lattice
    double tolerance_ = 0;
    std::vector<std::vector<std::uint32_t>> neighbours_;
    std::vector<std::vector<Term>> rows_; ///< by the user's numbers
    typename Delaunay<D>::Search search_;
    NewCell<D> cell_;
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
