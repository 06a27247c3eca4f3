// Pieces that conditions tie together: one linear system for all.
#pragma once

#include <cageform/animate/fit/normal_equations.hpp>
#include <cageform/core/status.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The Lagrange system [G Aᵀ; A 0] of the source's (4.59): the normal equations G of all pieces,
/// and a row of A for each condition. Unknowns are the pieces' Bernstein coefficients and the
/// multipliers, from key to key: the conditions of a knot stand between its pieces, so that the
/// system is banded.
class TiedPieces {
public:
    TiedPieces(const FitProblem& problem, std::span<FitPiece> pieces)
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
        std::size_t most = 0; // conditions of a knot
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
                pieces_[i].polynomial.c[k] = solution[place_of(i) + k];
        }
        return Status::ok;
    }

private:
    /// A row of A, of length 1: a sum over the coefficients of the pieces before and after a knot.
    struct Condition {
        std::size_t knot;
        Coefficients before{}, after{};
        double right = 0;
    };

    /// Of a piece's coefficients among the unknowns.
    std::size_t place_of(std::size_t piece) const noexcept {
        return piece * coefficients_ + first_[piece + 1];
    }

    /// The conditions of all knots, the keys' included; false where the curve lacks a derivative.
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
                if (before) bounded = take_from_curve(knot, order, true) && bounded;
                if (after) bounded = take_from_curve(knot, order, false) && bounded;
            }
        }
        first_.push_back(conditions_.size());
        for (Condition& row : conditions_) normalise(row);
        return bounded;
    }

    /// A condition: the derivative of the piece before or after a knot is the curve's.
    bool take_from_curve(std::size_t knot, std::size_t order, bool before) {
        const double t = before ? pieces_[knot - 1].end : pieces_[knot].begin;
        std::array<double, 3> c{};
        const bool bounded = problem_.derivatives(t, order + 1, c);
        Condition& row = conditions_.emplace_back(Condition{knot});
        add_derivative(row, order, before, 1);
        const double d = double(problem_.options.degree);
        row.right = c[order] / (order == 0 ? 1 : order == 1 ? d : d * (d - 1));
        return bounded;
    }

    /// Adds `sign` times a derivative of the piece before or after the row's knot, over its size on
    /// the unit interval, so that all rows are of one magnitude.
    void add_derivative(Condition& row, std::size_t order, bool before, double sign) const {
        static constexpr std::array<std::array<double, 3>, 3> differences{
            {{1, 0, 0}, {-1, 1, 0}, {1, -2, 1}}};
        const FitPiece& piece = pieces_[before ? row.knot - 1 : row.knot];
        const double scale = std::pow(piece.length(), -double(order));
        for (std::size_t k = 0; k <= order; ++k) {
            // From the end the same differences backwards, with the sign of the order.
            double& entry = before ? row.before[problem_.options.degree - k] : row.after[k];
            const double turned = before && order == 1 ? -1 : 1;
            entry += sign * turned * differences[order][k] * scale;
        }
    }

    static void normalise(Condition& row) noexcept {
        double square = 0;
        for (const auto* part : {&row.before, &row.after}) {
            for (const double x : *part) square += x * x;
        }
        const double length = std::sqrt(square);
        for (auto* part : {&row.before, &row.after}) {
            for (double& x : *part) x /= length;
        }
        row.right /= length;
    }

    /// Whether no condition follows from those before it: what is left of each, orthogonal to them,
    /// is 1e-10 at least. Only conditions of one knot and the next have a piece in common.
    bool independent() const {
        std::vector<std::vector<double>> kept; // orthonormal, of this knot and the one before
        std::size_t of_knot_before = 0;        // of them
        for (std::size_t knot = 0; knot <= pieces_.size(); ++knot) {
            for (std::size_t r = first_[knot]; r < first_[knot + 1]; ++r) {
                std::vector<double> left((knot + 1) * coefficients_, 0.0);
                for (std::size_t k = 0; k < coefficients_; ++k) {
                    if (knot > 0) left[(knot - 1) * coefficients_ + k] = conditions_[r].before[k];
                    left[knot * coefficients_ + k] = conditions_[r].after[k];
                }
                for (int twice = 0; twice < 2; ++twice) { // once leaves rounding
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
    /// Of vectors that are 0 beyond their end.
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
                right[place_of(i) + p] = of_curve[p];
                for (std::size_t q = 0; q < coefficients_; ++q)
                    system(place_of(i) + p, place_of(i) + q) = gram[p][q];
            }
        }
    }

    void fill_conditions(BandedMatrix& system, std::span<double> right) const {
        for (std::size_t r = 0; r < conditions_.size(); ++r) {
            const Condition& row = conditions_[r];
            const std::size_t place = row.knot * coefficients_ + r;
            right[place] = row.right;
            const auto couple = [&](std::size_t piece, const Coefficients& part) {
                for (std::size_t k = 0; k < coefficients_; ++k)
                    system(place, place_of(piece) + k) = system(place_of(piece) + k, place) = part[k];
            };
            if (row.knot > 0) couple(row.knot - 1, row.before);
            if (row.knot < pieces_.size()) couple(row.knot, row.after);
        }
    }

    const FitProblem& problem_;
    std::span<FitPiece> pieces_;
    std::size_t coefficients_; ///< of a piece
    std::vector<Condition> conditions_;
    std::vector<std::size_t> first_; ///< #knots + 1, of each knot's conditions among all
};

} // namespace cageform::inline CAGEFORM_ABI::detail
