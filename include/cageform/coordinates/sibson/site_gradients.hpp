// Estimates gradients at sites from values at the sites.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/coordinates/sibson/natural_neighbours.hpp>
#include <cageform/core/affine/orthonormal_rows.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// How the gradient g at site i is estimated: by least squares over its Voronoi neighbours j,
///
///     Σ_j μ ((g·d − Δz) / |d|)² → min,   μ = |F| / |d|
///
/// where F is the facet between the two cells, d = P_j − P_i, and Δz the difference of the values. The weight
/// of (g·d − Δz)² is thus |F| / |d|³. The estimate is exact for linear functions. The unbounded cell of a
/// site on the hull is cut by adding the mirror images of its neighbours in the site.
enum class SiteGradients : std::uint8_t {
    /// Also exact for a + b·x + γ|x|² at inner sites: the most accurate for evenly spread sites.
    facets,
    /// μ = |F| |d|, so (g·d − Δz)² has the weight |F| / |d|. Negative weights are smaller, accuracy is lower.
    gentle,
    /// Cuts all cells by mirrored neighbours: for closely spaced rings of sites.
    mirrored,
};

namespace detail {

/// The gradient at every site as a linear map of the values: g_i = Σ G_il z_l, with Σ_l G_il = 0.
template <std::size_t D>
class SiteGradientRows {
public:
    struct Term {
        std::uint32_t site;
        Vec<double, D> vector; ///< per unit of length
    };

    SiteGradientRows() = default;
    /// `on_hull` has an entry per site, in the user's order.
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
    /// Lists the Delaunay neighbours of every vertex in ascending order.
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
            sort_unique(list);
        }
    }

    void fill(std::uint32_t v, bool mirrored) {
        const auto& around = neighbours_[v];
        if (around.empty()) return;
        std::vector<LatticePoint<D>> positions;
        for (const std::uint32_t n : around)
            positions.push_back(difference<D>(sites_->point(n), sites_->point(v)));
        if (mirrored) add_mirrored(positions);
        // The cell of v equals the cell of a new point at v among the neighbours of v.
        const Delaunay<D> local(std::move(positions));
        if (local.empty()) return;
        (void)local.find_cavity({}, search_);
        for (const std::uint32_t s : search_.cavity()) {
            if (local.simplices()[s].is_ghost()) return mirrored ? void() : fill(v, true);
        }
        if (!cell_.fill(local, {}, search_.cavity(), OverlapSums::facets)) return;
        fit(v, local);
    }

    /// Adds the mirror images of the neighbours that do not coincide with a neighbour. Otherwise rounding
    /// would decide which of the two gets the facet, on lattices and rings.
    void add_mirrored(std::vector<LatticePoint<D>>& positions) const {
        const std::size_t count = positions.size();
        for (std::size_t n = 0; n < count; ++n) {
            const LatticePoint<D> mirrored = difference<D>({}, positions[n]);
            const auto coincides = [&](const LatticePoint<D>& other) {
                return length(to_double<D>(difference<D>(other, mirrored))) * unit_ <= 4 * tolerance_;
            };
            if (std::none_of(positions.begin(), positions.begin() + std::ptrdiff_t(count), coincides))
                positions.push_back(mirrored);
        }
    }

    void fit(std::uint32_t v, const Delaunay<D>& local) {
        const auto& around = neighbours_[v];
        double size = 0; // distance of the nearest neighbour
        for (std::size_t n = 0; n < cell_.cavity.vertices.size(); ++n) {
            const double distance = length(cell_.seen(n));
            if (size == 0 || distance < size) size = distance;
        }
        auto& row = rows_[sites_->site(v)];
        Buffer<Vec<double, D>> scaled; // d times the square root of its weight
        std::vector<double> root;
        for (std::size_t n = 0; n < cell_.cavity.vertices.size(); ++n) {
            const std::uint32_t number = local.site(cell_.cavity.vertices[n]);
            const auto d = (1 / size) * cell_.seen(n);
            const double d2 = dot(d, d);
            // The area is `facet` / |d| times a constant. The weight μ / |d|² belongs to residuals g·d − Δz.
            const double weight =
                std::fmax(cell_.facet(n), 0.0) / (rule_ == SiteGradients::gentle ? d2 : d2 * d2);
            if (number >= around.size() || !(weight > 0)) continue;
            root.push_back(std::sqrt(weight));
            scaled.push_back(root.back() * d);
            row.push_back({sites_->site(around[number]), {}});
        }
        // With A = QR the pseudoinverse is R⁻¹Qᵀ, which does not square the condition number as AᵀA does.
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
    double unit_ = 1; ///< a lattice step, in the units of the sites
    double tolerance_ = 0;
    std::vector<std::vector<std::uint32_t>> neighbours_;
    std::vector<std::vector<Term>> rows_; ///< in the user's order
    typename Delaunay<D>::Search search_;
    NewCell<D> cell_;
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
