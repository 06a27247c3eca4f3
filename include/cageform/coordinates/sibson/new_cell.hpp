// The overlaps of a new point's Voronoi cell with the cells of the sites, to working precision.
#pragma once

#include <cageform/coordinates/sibson/cell_overlap.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The overlaps, facets and moments of a new point's cell (see CellOverlap). A facet lies between the cells
/// of the point and of a site. Its moment, the integral of the position relative to the point, gives the
/// gradient of the overlap. Sums are computed in double if their rounding bound allows it. Otherwise
/// circumcentres come from integers and sums have 120 bits. Long thin cells next to flat facets of the hull
/// need this precision.
template <std::size_t D>
class NewCell {
public:
    /// The largest accepted rounding error of the weights in double. It is compared with the root of the sum
    /// of squared bounds, because the errors of hundreds of terms do not all add up. Measured errors over the
    /// sets of tests/fuzz/hostile_sites.cpp are then below 1e-13.
    static constexpr double enough = D == 2 ? 0x1p-39 : 0x1p-35;

    Cavity<D> cavity;
    double total = 0;   ///< Σ measure
    bool exact = false; ///< whether double was not accurate enough

    /// Computes the cell of `p` from its cavity `found`, without ghosts. Returns false if the cell has no
    /// measure. Smooth measures are always exact.
    bool fill(const Delaunay<D>& sites, const LatticePoint<D>& p, std::span<const std::uint32_t> found,
              OverlapSums sums) {
        point_ = p;
        cavity.fill(sites, found);
        fast_.make_room(cavity);
        for (std::size_t n = 0; n < cavity.vertices.size(); ++n) {
            auto& site = fast_.site[n];
            site.size = 0;
            for (std::size_t k = 0; k < D; ++k) {
                site.at[k] = double(sites.point(cavity.vertices[n])[k] - p[k]);
                site.size += std::fabs(site.at[k]);
            }
        }
        exact = sums == OverlapSums::smooth;
        if (!exact) {
            fill_double(sites);
            fast_.sum(cavity, sums);
            add_up();
            exact = !(total > 0 && std::sqrt(fast_.squares) < enough * total);
        }
        if (exact) {
            fill_exact(sites, sums);
            add_up();
        }
        return total > 0;
    }
    // Results for vertex n of the cavity, as far as `sums` requested them.
    double measure(std::size_t n) const noexcept { return fast_.measure[n]; }
    double facet(std::size_t n) const noexcept { return fast_.facet[n]; }
    Vec<double, D> moment(std::size_t n) const noexcept { return vector(fast_.moment[n]); }
    /// Returns site − p, in lattice steps.
    Vec<double, D> seen(std::size_t n) const noexcept { return vector(fast_.site[n].at); }

private:
    static Vec<double, D> vector(const Numbers<double, D>& a) noexcept {
        Vec<double, D> v;
        for (std::size_t k = 0; k < D; ++k) v[k] = a[k];
        return v;
    }
    void add_up() noexcept {
        total = 0;
        for (std::size_t n = 0; n < cavity.vertices.size(); ++n) {
            double& measure = fast_.measure[n];
            if (measure < 0) measure = 0; // rounding
            total += measure;
        }
    }

    std::array<LatticePoint<D>, D + 1> rim_corners(const Delaunay<D>& sites, std::size_t n) const noexcept {
        const auto& rim = cavity.rim[n];
        const auto& simplex = cavity.simplices[rim.simplex];
        std::array<LatticePoint<D>, D + 1> a;
        a[0] = point_;
        for (std::uint32_t k = 0, next = 1; k <= D; ++k) {
            if (k != rim.index) a[next++] = sites.point(cavity.vertices[simplex.vertex[k]]);
        }
        return a;
    }

    void fill_double(const Delaunay<D>& sites) {
        const std::size_t inner = cavity.numbers.size();
        for (std::size_t n = 0; n < inner; ++n) {
            const Centre<D>& c = sites.centre(cavity.numbers[n]);
            const auto& first = fast_.site[cavity.simplices[n].vertex[0]].at;
            Vec<double, D> at = c.at;
            double largest = 0;
            for (std::size_t k = 0; k < D; ++k) {
                largest = (std::max)(largest, std::fabs(first[k]) + std::fabs(at[k]));
                at[k] += first[k];
            }
            set_centre(n, at, c.error + 0x1p-52 * largest);
        }
        for (std::size_t n = 0; n < cavity.rim.size(); ++n) {
            const auto& rim = cavity.rim[n];
            Square<double, D> edges;
            for (std::uint32_t k = 0, next = 0; k <= D; ++k) {
                if (k != rim.index) edges[next++] = fast_.site[cavity.simplices[rim.simplex].vertex[k]].at;
            }
            Centre<D> c;
            if (!find_centre<D>(edges, c)) c = exact_centre<D>(rim_corners(sites, n));
            set_centre(inner + n, c.at, c.error);
        }
    }
    void set_centre(std::size_t n, const Vec<double, D>& at, double error) noexcept {
        auto& centre = fast_.centre[n];
        centre.size = 0;
        for (std::size_t k = 0; k < D; ++k) {
            centre.at[k] = at[k];
            centre.size += std::fabs(at[k]);
        }
        centre.error = error;
    }

    void fill_exact(const Delaunay<D>& sites, OverlapSums sums) {
        wide_.make_room(cavity);
        for (std::size_t n = 0; n < cavity.vertices.size(); ++n)
            wide_.site[n].at = wide_vector(difference<D>(sites.point(cavity.vertices[n]), point_));
        const std::size_t inner = cavity.numbers.size();
        for (std::size_t n = 0; n < inner; ++n) {
            const auto corners = sites.corners(sites.simplices()[cavity.numbers[n]]);
            auto& c = wide_.centre[n].at = wide_centre(corners);
            const auto first = wide_vector(difference<D>(corners[0], point_));
            for (std::size_t k = 0; k < D; ++k) c[k] = c[k] + first[k];
        }
        for (std::size_t n = 0; n < cavity.rim.size(); ++n)
            wide_.centre[inner + n].at = wide_centre(rim_corners(sites, n));
        wide_.sum(cavity, sums);
        for (std::size_t n = 0; n < cavity.vertices.size(); ++n) {
            fast_.measure[n] = double(wide_.measure[n]);
            fast_.facet[n] = double(wide_.facet[n]);
            for (std::size_t k = 0; k < D; ++k) fast_.moment[n][k] = double(wide_.moment[n][k]);
        }
    }
    static Numbers<WideFloat, D> wide_vector(const LatticePoint<D>& a) noexcept {
        Numbers<WideFloat, D> r;
        for (std::size_t k = 0; k < D; ++k) r[k] = WideFloat(a[k]);
        return r;
    }
    static Numbers<WideFloat, D> wide_centre(const std::array<LatticePoint<D>, D + 1>& a) noexcept {
        const auto q = centre_quotient<WideInt, D>(edge_rows<WideInt, D>(a));
        const WideFloat scale = inverse(WideFloat(q.determinant) + WideFloat(q.determinant));
        Numbers<WideFloat, D> c;
        for (std::size_t k = 0; k < D; ++k) c[k] = WideFloat(q.numerator[k]) * scale;
        return c;
    }

    LatticePoint<D> point_{};
    CellOverlap<double, D> fast_; ///< the results, also of the exact path
    CellOverlap<WideFloat, D> wide_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
