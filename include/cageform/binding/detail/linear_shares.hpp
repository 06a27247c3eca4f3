// Interpolation between scattered places.
#pragma once

#include <cageform/binding/detail/symmetric_matrix.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Shares s of some places q in the value at the origin: Σs = 1, Σsq = 0 where the places allow.
///
/// Moving least squares with weights that are singular at the places, φ = (R − |q|)² / |q|²: the
/// linear function nearest to given values, at the origin. About the weighted mean m and with the
/// principal axes v of the places, σ their extents,
///
///     s_j = φ_j / Σφ · (1 − Σ_v (m·v / σ) ((q_j − m)·v / σ)).
///
/// m·v / σ is held in ±12. Half a spacing off the places it is less; farther, and off a sheet of
/// places, which say little about slopes across it, these would be noise times a distance.
/// Lancaster, Salkauskas, Math. Comp. 37 (1981), 141: interpolating moving least squares.
template <std::size_t D>
class LinearShares {
public:
    /// `radius`: no place is farther. `rounding`: an extent of no more is none.
    void compute(std::span<const Vec<double, D>> places, double radius, double rounding) {
        shares_.resize(places.size());
        double sum = 0;
        Vec<double, D> mean{};
        for (std::size_t j = 0; j < places.size(); ++j) {
            // Nearer than this a place has all the share in double precision. What lies on the rim
            // has a little, for there may be no others.
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
        // Of the squares only half the digits are left in extents.
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
