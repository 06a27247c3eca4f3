// The Voronoi cell of a place among sites: what it takes from each, to working precision.
#pragma once

#include <cageform/coordinates/detail/stolen.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Measures, facets and moments of the cell of a place (coordinates/detail/stolen.hpp). In double
/// where a bound of the rounding allows, else with circumcentres from integers and sums of 120 bits:
/// next to flat facets of the hull, where the cell is long and thin.
template <std::size_t D>
class NewCell {
public:
    /// What rounding may be of the weights in double at the most. Errors measured are below a
    /// fortieth of the bound, and below 1e-14.
    static constexpr double enough = 0x1p-36;

    Cavity<D> cavity;
    std::vector<double> measure, facet;
    std::vector<Vec<double, D>> moment;
    double total = 0;   ///< Σ measure
    bool exact = false; ///< whether double was not enough

    /// The search has found the cavity of `p`, which holds no ghosts. False where the cell has no
    /// measure. Moments are left empty unless asked for; smooth measures are always exact.
    bool fill(const Delaunay<D>& sites, const Place<D>& p, std::span<const std::uint32_t> found,
              StolenParts parts) {
        cavity.fill(sites, p, found);
        exact = parts == StolenParts::smooth;
        if (!exact) {
            fill_double(sites);
            fast_.sum(cavity, parts);
            take(fast_);
            exact = !(total > 0 && fast_.bound < enough * total);
        }
        if (exact) fill_exact(sites, parts);
        return total > 0;
    }
    /// A vertex of the cavity seen from the place, in steps.
    Vec<double, D> seen(const Delaunay<D>& sites, std::size_t n) const noexcept {
        return to_double<D>(difference<D>(sites.place(cavity.vertices[n]), cavity.place));
    }

private:
    template <class N>
    void take(const Stolen<N, D>& sums) {
        const std::size_t count = cavity.vertices.size();
        measure.resize(count);
        facet.resize(count);
        moment.resize(sums.moment.size());
        total = 0;
        for (std::size_t n = 0; n < count; ++n) {
            measure[n] = double(sums.measure[n]);
            facet[n] = double(sums.facet[n]);
            if (measure[n] < 0) measure[n] = 0; // rounding
            total += measure[n];
        }
        for (std::size_t n = 0; n < moment.size(); ++n) {
            for (std::size_t k = 0; k < D; ++k) moment[n][k] = double(sums.moment[n][k]);
        }
    }

    std::array<Place<D>, D + 1> rim_corners(const Delaunay<D>& sites, std::size_t n) const noexcept {
        const auto& rim = cavity.rim[n];
        const auto& simplex = cavity.simplices[rim.simplex];
        std::array<Place<D>, D + 1> a;
        a[0] = cavity.place;
        for (std::uint32_t k = 0, next = 1; k <= D; ++k) {
            if (k != rim.index) a[next++] = sites.place(cavity.vertices[simplex.vertex[k]]);
        }
        return a;
    }

    void fill_double(const Delaunay<D>& sites) {
        fast_.clear();
        for (std::size_t n = 0; n < cavity.vertices.size(); ++n)
            fast_.site.push_back(numbers(seen(sites, n)));
        for (std::size_t n = 0; n < cavity.numbers.size(); ++n) {
            const Centre<D>& c = sites.centre(cavity.numbers[n]);
            const auto& first = fast_.site[cavity.simplices[n].vertex[0]];
            Vec<double, D> at = c.at;
            double largest = 0;
            for (std::size_t k = 0; k < D; ++k) {
                largest = std::max(largest, std::fabs(first[k]) + std::fabs(at[k]));
                at[k] += first[k];
            }
            note_centre(at, c.error + 0x1p-52 * largest);
        }
        for (std::size_t n = 0; n < cavity.rim.size(); ++n) {
            const auto& rim = cavity.rim[n];
            Square<double, D> edges;
            for (std::uint32_t k = 0, next = 0; k <= D; ++k) {
                if (k != rim.index) edges[next++] = fast_.site[cavity.simplices[rim.simplex].vertex[k]];
            }
            Centre<D> c{};
            if (!find_centre<D>(edges, c)) c = exact_centre<D>(rim_corners(sites, n));
            note_centre(c.at, c.error);
        }
    }
    void note_centre(const Vec<double, D>& at, double error) {
        double size = 0;
        for (std::size_t k = 0; k < D; ++k) size += std::fabs(at[k]);
        fast_.centre.push_back(numbers(at));
        fast_.size.push_back(size);
        fast_.error.push_back(error);
    }
    static Numbers<double, D> numbers(const Vec<double, D>& v) noexcept {
        Numbers<double, D> a;
        for (std::size_t k = 0; k < D; ++k) a[k] = v[k];
        return a;
    }

    void fill_exact(const Delaunay<D>& sites, StolenParts parts) {
        wide_.clear();
        for (const std::uint32_t v : cavity.vertices)
            wide_.site.push_back(wide_vector(difference<D>(sites.place(v), cavity.place)));
        for (std::size_t n = 0; n < cavity.numbers.size(); ++n) {
            const auto corners = sites.corners(sites.simplices()[cavity.numbers[n]]);
            auto c = wide_centre(corners);
            const auto first = wide_vector(difference<D>(corners[0], cavity.place));
            for (std::size_t k = 0; k < D; ++k) c[k] = c[k] + first[k];
            wide_.centre.push_back(c);
        }
        for (std::size_t n = 0; n < cavity.rim.size(); ++n)
            wide_.centre.push_back(wide_centre(rim_corners(sites, n)));
        wide_.sum(cavity, parts);
        take(wide_);
    }
    static Numbers<WideFloat, D> wide_vector(const Place<D>& a) noexcept {
        Numbers<WideFloat, D> r;
        for (std::size_t k = 0; k < D; ++k) r[k] = WideFloat(a[k]);
        return r;
    }
    static Numbers<WideFloat, D> wide_centre(const std::array<Place<D>, D + 1>& a) noexcept {
        const auto q = centre_quotient<WideInt, D>(edge_rows<WideInt, D>(a));
        const WideFloat scale = inverse(WideFloat(q.determinant) + WideFloat(q.determinant));
        Numbers<WideFloat, D> c;
        for (std::size_t k = 0; k < D; ++k) c[k] = WideFloat(q.numerator[k]) * scale;
        return c;
    }

    Stolen<double, D> fast_;
    Stolen<WideFloat, D> wide_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
