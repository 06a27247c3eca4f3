// Interpolation between scattered places.
#pragma once

#include <cageform/core/vec.hpp>

#include <Eigen/Eigenvalues>

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
        Column mean = Column::Zero();
        for (std::size_t j = 0; j < places.size(); ++j) {
            // Nearer than this a place has all the share in double precision. What lies on the rim
            // has a little, for there may be no others.
            const double distance = std::max(std::sqrt(dot(places[j], places[j])) / radius, 1e-8);
            const double open = 1.05 - std::min(distance, 1.0);
            shares_[j] = open * open / (distance * distance);
            sum += shares_[j];
            mean += shares_[j] * column(places[j]);
        }
        mean /= sum;
        Matrix square = Matrix::Zero();
        for (std::size_t j = 0; j < places.size(); ++j) {
            const Column d = column(places[j]) - mean;
            shares_[j] /= sum;
            square += shares_[j] * d * d.transpose();
        }
        // Of the squares only half the digits are left in extents.
        const Eigen::SelfAdjointEigenSolver<Matrix> axes(square);
        const double least =
            std::max(rounding, 1e-6 * std::sqrt(std::max(axes.eigenvalues()[Eigen::Index(D) - 1], 0.0)));
        Column slope = Column::Zero();
        for (Eigen::Index n = 0; n < Eigen::Index(D); ++n) {
            const double extent = std::sqrt(std::max(axes.eigenvalues()[n], 0.0));
            if (!(extent > least)) continue;
            const Column axis = axes.eigenvectors().col(n);
            slope -= std::clamp(mean.dot(axis) / extent, -12.0, 12.0) / extent * axis;
        }
        sum = 0;
        for (std::size_t j = 0; j < places.size(); ++j) {
            shares_[j] *= 1 + slope.dot(column(places[j]) - mean);
            sum += shares_[j];
        }
        for (double& share : shares_) share /= sum; // large slopes round Σs away from 1
    }
    double operator[](std::size_t place) const noexcept { return shares_[place]; }

private:
    using Column = Eigen::Matrix<double, int(D), 1>;
    using Matrix = Eigen::Matrix<double, int(D), int(D)>;

    static Column column(const Vec<double, D>& p) {
        Column c;
        for (std::size_t k = 0; k < D; ++k) c[Eigen::Index(k)] = p[k];
        return c;
    }

    std::vector<double> shares_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
