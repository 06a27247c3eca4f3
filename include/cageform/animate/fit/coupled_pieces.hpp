// Fits pieces that are coupled by conditions, as one linear system.
#pragma once

#include <cageform/animate/fit/normal_equations.hpp>
#include <cageform/core/status.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The Lagrange system [G Aᵀ; A 0] of Izdebski 2019, (4.59), see sobolev_fit.hpp. G contains the normal
/// equations of all pieces, A has a row per condition. Unknowns are the Bernstein coefficients and the
/// Lagrange multipliers, ordered by time: the multipliers of a knot stand between its two pieces. The
/// system is therefore banded.
class CoupledPieces {
public:
    CoupledPieces(const FitProblem& problem, std::span<FitPiece> pieces)
        : problem_(problem)
        , pieces_(pieces)
        , coefficients_(problem.options.degree + 1) {}

    /// Solves for all pieces: ok, slope_unbounded or too_many_conditions.
    Status solve() {
        const std::size_t unknowns = coefficients_ * pieces_.size();
        if (condition_count(problem_.options.conditions, pieces_.size()) > unknowns)
            return Status::too_many_conditions;
        if (!make_conditions()) return Status::slope_unbounded;
        if (!independent()) return Status::too_many_conditions;
        std::size_t most = 0; // the largest number of conditions at a knot
        for (std::size_t knot = 0; knot <= pieces_.size(); ++knot)
            most = (std::max)(most, first_[knot + 1] - first_[knot]);
        BandedMatrix system(unknowns + conditions_.size(), most + coefficients_ - 1);
        std::vector<double> solution(unknowns + conditions_.size());
        fill_normal_equations(system, solution);
        fill_conditions(system, solution);
        system.solve(solution);
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            pieces_[i].polynomial.degree = problem_.options.degree;
            for (std::size_t k = 0; k < coefficients_; ++k)
                pieces_[i].polynomial.c[k] = solution[first_unknown_of(i) + k];
        }
        return Status::ok;
    }

private:
    /// A row of A, normalised: a linear combination of the coefficients of the pieces before and
    /// after a knot.
    struct Condition {
        std::size_t knot;
        Coefficients before{}, after{};
        double right = 0;
    };

    /// The index of a piece's first coefficient among the unknowns.
    std::size_t first_unknown_of(std::size_t piece) const noexcept {
        return piece * coefficients_ + first_[piece + 1];
    }

    /// Collects the conditions at all knots and keys; returns false if a derivative of the curve is
    /// unbounded.
    bool make_conditions() {
        bool bounded = true;
        for (std::size_t knot = 0; knot <= pieces_.size(); ++knot) {
            first_.push_back(conditions_.size());
            const bool before = knot > 0, after = knot < pieces_.size();
            for (std::size_t order = 0; order < 3; ++order) {
                if (before && after && problem_.has(neighbours_agree[order])) {
                    Condition& row = conditions_.emplace_back(Condition{knot});
                    add_derivative(row, order, true, 1);
                    add_derivative(row, order, false, -1);
                }
                if (!problem_.has(before && after ? at_knots[order] : at_keys[order])) continue;
                if (before) bounded = match_curve(knot, order, true) && bounded;
                if (after) bounded = match_curve(knot, order, false) && bounded;
            }
        }
        first_.push_back(conditions_.size());
        for (Condition& row : conditions_) normalise(row);
        return bounded;
    }

    /// Adds the condition that a derivative of the piece before or after a knot equals the curve's.
    bool match_curve(std::size_t knot, std::size_t order, bool before) {
        const double t = before ? pieces_[knot - 1].end : pieces_[knot].begin;
        std::array<double, 3> c{};
        const bool bounded = problem_.derivatives(t, order + 1, c);
        Condition& row = conditions_.emplace_back(Condition{knot});
        add_derivative(row, order, before, 1);
        const double d = double(problem_.options.degree);
        row.right = c[order] / (order == 0 ? 1 : order == 1 ? d : d * (d - 1));
        return bounded;
    }

    /// Adds `sign` times a derivative of the piece before or after the row's knot. Omits the factors
    /// that depend only on the degree, so that all rows have similar size.
    void add_derivative(Condition& row, std::size_t order, bool before, double sign) const {
        static constexpr std::array<std::array<double, 3>, 3> differences{
            {{1, 0, 0}, {-1, 1, 0}, {1, -2, 1}}};
        const FitPiece& piece = pieces_[before ? row.knot - 1 : row.knot];
        const double scale = std::pow(piece.length(), -double(order));
        for (std::size_t k = 0; k <= order; ++k) {
            // At the end of a piece, differences are mirrored; odd orders change sign.
            double& entry = before ? row.before[problem_.options.degree - k] : row.after[k];
            const double mirrored = before && order == 1 ? -1 : 1;
            entry += sign * mirrored * differences[order][k] * scale;
        }
    }

    static void normalise(Condition& row) noexcept {
        double square = 0;
        for (const auto* side : {&row.before, &row.after}) {
            for (const double x : *side) square += x * x;
        }
        const double length = std::sqrt(square);
        for (auto* side : {&row.before, &row.after}) {
            for (double& x : *side) x /= length;
        }
        row.right /= length;
    }

    /// Whether the conditions are linearly independent, by Gram-Schmidt: the rest of each after
    /// projection must be larger than 1e-10. Only conditions at adjacent knots share a piece.
    bool independent() const {
        std::vector<std::vector<double>> kept; // orthonormal, of this knot and the previous one
        std::size_t of_knot_before = 0;        // the number of those of the previous knot
        for (std::size_t knot = 0; knot <= pieces_.size(); ++knot) {
            for (std::size_t r = first_[knot]; r < first_[knot + 1]; ++r) {
                std::vector<double> left((knot + 1) * coefficients_, 0.0);
                for (std::size_t k = 0; k < coefficients_; ++k) {
                    if (knot > 0) left[(knot - 1) * coefficients_ + k] = conditions_[r].before[k];
                    left[knot * coefficients_ + k] = conditions_[r].after[k];
                }
                for (int twice = 0; twice < 2; ++twice) { // the second pass removes rounding errors
                    for (const auto& unit : kept) subtract_projection(left, unit);
                }
                const double length = std::sqrt(dot_product(left, left));
                if (!(length > 1e-10)) return false;
                for (double& x : left) x /= length;
                kept.push_back(std::move(left));
            }
            kept.erase(kept.begin(), kept.begin() + long(of_knot_before));
            of_knot_before = kept.size();
        }
        return true;
    }
    /// The dot product; the shorter vector is padded with zeros.
    static double dot_product(std::span<const double> a, std::span<const double> b) noexcept {
        double sum = 0;
        for (std::size_t i = 0; i < (std::min)(a.size(), b.size()); ++i) sum += a[i] * b[i];
        return sum;
    }
    static void subtract_projection(std::span<double> from, std::span<const double> unit) noexcept {
        const double along = dot_product(from, unit);
        for (std::size_t i = 0; i < (std::min)(from.size(), unit.size()); ++i) from[i] -= along * unit[i];
    }

    void fill_normal_equations(BandedMatrix& system, std::span<double> right) const {
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            const FitMatrix gram = gram_matrix(problem_, pieces_[i].length());
            const Coefficients of_curve = load(problem_, pieces_[i]);
            for (std::size_t p = 0; p < coefficients_; ++p) {
                right[first_unknown_of(i) + p] = of_curve[p];
                for (std::size_t q = 0; q < coefficients_; ++q)
                    system(first_unknown_of(i) + p, first_unknown_of(i) + q) = gram[p][q];
            }
        }
    }

    void fill_conditions(BandedMatrix& system, std::span<double> right) const {
        for (std::size_t r = 0; r < conditions_.size(); ++r) {
            const Condition& row = conditions_[r];
            const std::size_t index = row.knot * coefficients_ + r;
            right[index] = row.right;
            const auto couple = [&](std::size_t piece, const Coefficients& side) {
                for (std::size_t k = 0; k < coefficients_; ++k)
                    system(index, first_unknown_of(piece) + k) = system(first_unknown_of(piece) + k, index) =
                        side[k];
            };
            if (row.knot > 0) couple(row.knot - 1, row.before);
            if (row.knot < pieces_.size()) couple(row.knot, row.after);
        }
    }

    const FitProblem& problem_;
    std::span<FitPiece> pieces_;
    std::size_t coefficients_; ///< per piece
    std::vector<Condition> conditions_;
    std::vector<std::size_t> first_; ///< #knots + 1: the index of each knot's first condition
};

} // namespace cageform::inline CAGEFORM_ABI::detail
