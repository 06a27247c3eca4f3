// Interpolates linearly between scattered points.
#pragma once

#include <cageform/binding/detail/symmetric_matrix.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The shares s of some points q in the value at the origin: Σs = 1, and Σsq = 0 if the points allow it.
///
/// They come from moving least squares with weights that are singular at the points, φ = (R − |q|)²
/// / |q|²: the linear function that fits given values best, evaluated at the origin. With the
/// weighted mean m, the principal axes v of the points and their extents σ,
///
///     s_j = φ_j / Σφ · (1 − Σ_v (m·v / σ) ((q_j − m)·v / σ)).
///
/// m·v / σ is limited to ±12. Up to half a spacing from the points it is smaller. Farther away, and
/// off a sheet of points, which says little about slopes across it, such terms would be noise times a
/// distance. Lancaster, Salkauskas, Math. Comp. 37 (1981), 141: interpolating moving least squares.
template <std::size_t D>
class LinearShares {
public:
    /// `radius`: no point is farther than this. `rounding`: an extent up to this counts as zero.
    void compute(std::span<const Vec<double, D>> places, double radius, double rounding) {
        shares_.resize(places.size());
        double sum = 0;
        Vec<double, D> mean{};
        for (std::size_t j = 0; j < places.size(); ++j) {
            // A point closer than this has all the share in double precision. Points on the rim
            // keep a small share, because there may be no others.
            const double distance = (std::max)(std::sqrt(dot(places[j], places[j])) / radius, 1e-8);
            const double open = 1.05 - (std::min)(distance, 1.0);
            shares_[j] = open * open / (distance * distance);
            sum += shares_[j];
            mean = mean + shares_[j] * places[j];
        }
        mean = (1 / sum) * mean;
        SquareMatrix<D> square{};
        for (std::size_t j = 0; j < places.size(); ++j) {
            const auto d = places[j] - mean;
            shares_[j] /= sum;
            add_outer_product(square, shares_[j] * d, d);
        }
        // Extents are roots of squares, so only half of the digits are left.
        const PrincipalAxes<D> axes = principal_axes(square);
        const double least = (std::max)(rounding, 1e-6 * std::sqrt((std::max)(axes.largest(), 0.0)));
        Vec<double, D> slope{};
        for (std::size_t n = 0; n < D; ++n) {
            const double extent = std::sqrt((std::max)(axes.values[n], 0.0));
            if (!(extent > least)) continue;
            const auto& axis = axes.vectors[n];
            slope = slope - std::clamp(dot(mean, axis) / extent, -12.0, 12.0) / extent * axis;
        }
        sum = 0;
        for (std::size_t j = 0; j < places.size(); ++j) {
            shares_[j] *= 1 + dot(slope, places[j] - mean);
            sum += shares_[j];
        }
        for (double& share : shares_) share /= sum; // large slopes round Σs away from 1
    }
    double operator[](std::size_t place) const noexcept { return shares_[place]; }

private:
    std::vector<double> shares_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
