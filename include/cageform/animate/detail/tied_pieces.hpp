// Pieces that conditions tie together: one linear system for all.
#pragma once

#include <cageform/animate/detail/normal_equations.hpp>
#include <cageform/core/status.hpp>

#include <Eigen/LU>
#include <Eigen/QR>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The Lagrange system [G Aᵀ; A 0] of the source's (4.59): the normal equations G of all pieces,
/// and a row of A for each condition. Unknowns are the pieces' Bernstein coefficients and the
/// multipliers.
class TiedPieces {
public:
    TiedPieces(const FitProblem& problem, std::span<FitPiece> pieces)
        : problem_(problem)
        , pieces_(pieces)
        , coefficients_(problem.options.degree + 1)
        , unknowns_(coefficients_ * pieces.size())
        , conditions_(condition_count(problem.options.conditions, pieces.size())) {}

    /// Solves for all pieces: ok, slope_unbounded or too_many_conditions.
    Status solve() {
        if (conditions_ > unknowns_) return Status::too_many_conditions;
        const long size = long(unknowns_ + conditions_);
        system_ = Eigen::MatrixXd::Zero(size, size);
        right_ = Eigen::VectorXd::Zero(size);
        rows_ = Eigen::MatrixXd::Zero(long(conditions_), long(unknowns_));
        fill_normal_equations();
        for (std::size_t order = 0; order < 3; ++order) fill_conditions(order);
        if (!bounded_) return Status::slope_unbounded;
        normalise_conditions();
        if (!independent()) return Status::too_many_conditions;
        system_.bottomLeftCorner(rows_.rows(), rows_.cols()) = rows_;
        system_.topRightCorner(rows_.cols(), rows_.rows()) = rows_.transpose();
        const Eigen::VectorXd solution = system_.partialPivLu().solve(right_);
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            pieces_[i].polynomial.degree = problem_.options.degree;
            for (std::size_t k = 0; k < coefficients_; ++k)
                pieces_[i].polynomial.c[k] = solution(long(i * coefficients_ + k));
            pieces_[i].solved = true;
        }
        return Status::ok;
    }

private:
    void fill_normal_equations() {
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            const GramMatrix gram = gram_matrix(problem_, pieces_[i].length());
            const Coefficients right = load(problem_, pieces_[i]);
            const std::size_t first = i * coefficients_;
            for (std::size_t p = 0; p < coefficients_; ++p) {
                right_(long(first + p)) = right[p];
                for (std::size_t q = 0; q < coefficients_; ++q)
                    system_(long(first + p), long(first + q)) = gram[p][q];
            }
        }
    }

    /// The conditions on derivatives of one order.
    void fill_conditions(std::size_t order) {
        const std::size_t last = pieces_.size() - 1;
        if (problem_.has(at_keys[order])) {
            take_from_curve(order, 0, false);
            take_from_curve(order, last, true);
        }
        for (std::size_t i = 0; i < last; ++i) {
            if (problem_.has(neighbours_agree[order])) {
                add_derivative(order, i, true, 1);
                add_derivative(order, i + 1, false, -1);
                ++row_;
            }
            if (problem_.has(at_knots[order])) {
                take_from_curve(order, i, true);
                take_from_curve(order, i + 1, false);
            }
        }
    }

    /// A row: the derivative of a piece at its begin or end is the curve's.
    void take_from_curve(std::size_t order, std::size_t piece, bool at_end) {
        const FitPiece& p = pieces_[piece];
        std::array<double, 3> c{};
        bounded_ = problem_.derivatives(at_end ? p.end : p.begin, order + 1, c) && bounded_;
        add_derivative(order, piece, at_end, 1);
        const double d = double(problem_.options.degree);
        right_(long(unknowns_ + row_)) = c[order] / (order == 0 ? 1 : order == 1 ? d : d * (d - 1));
        ++row_;
    }

    /// Adds `sign` times a derivative of a piece at its begin or end to the current row.
    /// Derivatives are taken over their size on the unit interval, so that all rows are of one
    /// magnitude.
    void add_derivative(std::size_t order, std::size_t piece, bool at_end, double sign) {
        static constexpr std::array<std::array<double, 3>, 3> differences{
            {{1, 0, 0}, {-1, 1, 0}, {1, -2, 1}}};
        const double scale = std::pow(pieces_[piece].length(), -double(order));
        for (std::size_t k = 0; k <= order; ++k) {
            // From the end the same differences backwards, with the sign of the order.
            const std::size_t j = at_end ? problem_.options.degree - k : k;
            const double turned = at_end && order == 1 ? -1 : 1;
            rows_(long(row_), long(piece * coefficients_ + j)) +=
                sign * turned * differences[order][k] * scale;
        }
    }

    /// Rows of length 1.
    void normalise_conditions() {
        for (long r = 0; r < rows_.rows(); ++r) {
            const double norm = rows_.row(r).norm();
            rows_.row(r) /= norm;
            right_(long(unknowns_) + r) /= norm;
        }
    }

    /// Whether no condition follows from others, to 1e-10 of rows of length 1.
    bool independent() const {
        if (conditions_ == 0) return true;
        Eigen::ColPivHouseholderQR<Eigen::MatrixXd> rank(rows_.transpose());
        rank.setThreshold(1e-10);
        return std::size_t(rank.rank()) == conditions_;
    }

    const FitProblem& problem_;
    std::span<FitPiece> pieces_;
    std::size_t coefficients_, unknowns_, conditions_; ///< of a piece, of all; rows of A
    Eigen::MatrixXd system_, rows_;                    ///< rows_: A
    Eigen::VectorXd right_;
    std::size_t row_ = 0; ///< of the next condition
    bool bounded_ = true; ///< the curve has all derivatives that are asked for
};

} // namespace cageform::inline CAGEFORM_ABI::detail
