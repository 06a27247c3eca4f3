// Approximates a Bézier curve between two keys by polynomials in time that are optimal in a Sobolev
// norm under conditions.
//
// Izdebski, Interpolacja trajektorii w animacji (Trajectory interpolation in animation), PhD thesis,
// Warsaw University of Technology (2019), ch. 4; misprints corrected, integrals exact. Independent
// pieces are solved by normal_equations.hpp, coupled ones by coupled_pieces.hpp. Bind time.
#pragma once

#include <cageform/animate/fit/bezier_fit.hpp>
#include <cageform/animate/fit/coupled_pieces.hpp>
#include <cageform/animate/fit/fit_errors.hpp>
#include <cageform/animate/fit/fit_options.hpp>
#include <cageform/animate/fit/least_maximum.hpp>
#include <cageform/animate/fit/normal_equations.hpp>
#include <cageform/parallel/running.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Fits pieces to one curve, repeatedly in a knot search. Uses the normalised units of fit_problem.hpp.
class SobolevFitter {
public:
    using Piece = detail::FitPiece;

    SobolevFitter(const BezierCurve& curve, const FitOptions& options)
        : curve_(curve)
        , problem_(curve, options)
        , status_(check_all()) {}

    Status status() const noexcept { return status_; }
    const BezierCurve& curve() const noexcept { return curve_; }

    /// Whether each piece is determined by its own interval.
    bool decoupled() const noexcept { return detail::decoupled(problem_.options.conditions); }

    /// Returns the best piece between two parameters, with the prescribed derivatives of the curve at its
    /// ends. It is not `solved` if there are more conditions than coefficients, or a slope is unbounded.
    Piece fit_piece(double begin, double end) const {
        Piece piece = problem_.interval(begin, end);
        if (!(piece.length() > 0)) return piece;
        const std::size_t d = problem_.options.degree;
        const std::size_t left = problem_.prescribed(begin == 0), right = problem_.prescribed(end == 1);
        if (left + right > d + 1) return piece;
        piece.polynomial.degree = d;
        if (!prescribe(piece, left, false) || !prescribe(piece, right, true)) return piece;
        if (const std::size_t count = d + 1 - left - right; count > 0) {
            detail::solve_normal_equations(problem_, piece, left, count);
            if (problem_.options.norm == FitNorm::sup)
                detail::LeastMaximum(problem_, piece, left, count).improve(piece);
        }
        piece.solved = true;
        return piece;
    }

    /// The objective of the knot search: the weighted squared errors of a piece, in normalised units.
    /// If the curve's slope is unbounded, an infinite term is omitted; it is the same for all knots.
    double cost(const Piece& piece) const {
        const FitOptions& options = problem_.options;
        if (!problem_.vertical || options.slope_weight == 0) {
            const auto error = detail::residual(problem_, piece);
            double sum = options.value_weight * detail::l2_square(problem_, piece, error);
            if (options.slope_weight > 0)
                sum += options.slope_weight * detail::slope_square(problem_, piece, error);
            return sum;
        }
        const auto gram = detail::gram_matrix(problem_, piece.length());
        const auto load = detail::load(problem_, piece);
        double sum = 0;
        for (std::size_t i = 0; i <= options.degree; ++i) {
            double row = 0;
            for (std::size_t j = 0; j <= options.degree; ++j) row += gram[i][j] * piece.polynomial.c[j];
            sum += piece.polynomial.c[i] * (row - 2 * load[i]);
        }
        return sum;
    }

    /// The largest |C − f| on a piece, exact up to rounding: the residual is a polynomial in the
    /// curve's parameter.
    double largest_error(const Piece& piece) const {
        return problem_.unit * detail::largest_error(problem_, piece);
    }
    /// A lower bound of largest_error from a few samples, rarely by more than 5 %, and much faster.
    double sampled_error(const Piece& piece) const noexcept {
        return problem_.unit * detail::sampled_error(problem_, piece);
    }

    /// Fits all pieces between parameters that ascend from 0 to 1.
    Result<BezierFit, FitReport> fit(std::span<const double> parameters, const Running& running = {}) const {
        if (status_ != Status::ok) return {{}, {status_}};
        std::vector<Piece> pieces;
        const Status status = solve(parameters, pieces, running);
        if (status != Status::ok) return {{}, {status}};
        return gather(pieces);
    }

    /// The sum of the costs of the pieces between parameters; infinite if there is no fit.
    double cost(std::span<const double> parameters) const {
        std::vector<Piece> pieces;
        if (solve(parameters, pieces, {}) != Status::ok) return std::numeric_limits<double>::infinity();
        double sum = 0;
        for (const Piece& piece : pieces) sum += cost(piece);
        return sum;
    }

    /// The cost in the units of the curve.
    double objective(std::span<const double> parameters) const { return in_units(cost(parameters)); }
    double in_units(double cost) const noexcept { return cost * problem_.unit * problem_.unit; }

    /// Assembles the result from solved pieces.
    Result<BezierFit, FitReport> gather(std::span<const Piece> pieces) const {
        const FitOptions& options = problem_.options;
        const double length = problem_.function.length(), begin = curve_.begin(), unit = problem_.unit;
        Result<BezierFit, FitReport> result;
        auto& [fitted, report] = result;
        fitted.degree = options.degree;
        fitted.free_coefficients =
            (options.degree + 1) * pieces.size() - detail::condition_count(options.conditions, pieces.size());
        fitted.parameters = {0};
        fitted.knots = {begin};
        double l2 = 0, slope = 0;
        for (const Piece& piece : pieces) {
            const auto error = detail::residual(problem_, piece);
            fitted.parameters.push_back(piece.end);
            fitted.knots.push_back(piece.end == 1 ? curve_.end() : begin + length * piece.x_end);
            for (std::size_t k = 0; k <= options.degree; ++k) {
                fitted.bernstein.push_back(curve_.points[0][1] + unit * piece.polynomial.c[k]);
                if (!is_finite(fitted.bernstein.back())) report.status = Status::value_not_finite;
            }
            l2 += detail::l2_square(problem_, piece, error);
            slope += detail::slope_square(problem_, piece, error);
            const auto largest = detail::largest_absolute(error);
            if (unit * largest.value <= report.sup_error && &piece != pieces.data()) continue;
            report.sup_error = unit * largest.value;
            report.sup_at = begin + length * problem_.function.time()(piece.begin +
                                                                      largest.at * (piece.end - piece.begin));
        }
        report.l2_error = unit * (std::sqrt(l2) * std::sqrt(length));
        report.slope_error = unit * (std::sqrt(slope) / std::sqrt(length));
        return result;
    }

private:
    Status check_all() const noexcept {
        const FitOptions& options = problem_.options; // with weights in normalised units
        if (const Status status = check(curve_).status; status != Status::ok) return status;
        constexpr double room = 128; // headroom for the sums of differences in derivatives
        for (const auto& p : curve_.points) {
            if (!is_finite(room * (p[1] - curve_.points[0][1]))) return Status::value_not_finite;
        }
        if (options.degree < 3 || options.degree > 5) return Status::degree_not_supported;
        using enum FitCondition;
        const bool coupled = contains(options.conditions, knot_c0 | knot_c1 | knot_c2) ||
                             !contains(options.conditions, end_value) ||
                             !contains(options.conditions, knot_value);
        if (options.norm == FitNorm::sup && coupled) return Status::norm_not_supported;
        if (!(options.value_weight > 0) || !(options.slope_weight >= 0) || !is_finite(options.value_weight) ||
            !is_finite(options.slope_weight))
            return Status::weights_not_positive;
        return Status::ok;
    }

    /// Sets the first or the last `count` coefficients of a piece from the curve; returns false if
    /// a derivative is unbounded.
    bool prescribe(Piece& piece, std::size_t count, bool at_end) const noexcept {
        std::array<double, 3> c{};
        if (!problem_.derivatives(at_end ? piece.end : piece.begin, count, c)) return false;
        const std::size_t degree = problem_.options.degree;
        const auto b = [&](std::size_t k) -> double& { return piece.polynomial.c[at_end ? degree - k : k]; };
        const double d = double(degree), step = at_end ? -piece.length() : piece.length();
        b(0) = c[0];
        if (count > 1) b(1) = b(0) + c[1] * step / d;
        if (count > 2) b(2) = 2 * b(1) - b(0) + c[2] * step * step / (d * (d - 1));
        return true;
    }

    /// Makes and solves the pieces between parameters.
    Status solve(std::span<const double> parameters, std::vector<Piece>& pieces,
                 const Running& running) const {
        bool ascending = parameters.size() >= 2 && parameters.front() == 0 && parameters.back() == 1;
        for (std::size_t i = 0; i + 1 < parameters.size() && ascending; ++i) {
            pieces.push_back(problem_.interval(parameters[i], parameters[i + 1]));
            ascending = parameters[i + 1] > parameters[i] && pieces.back().length() > 0;
        }
        if (!ascending) return Status::knots_not_ascending;
        if (!decoupled()) return detail::CoupledPieces(problem_, pieces).solve();
        for (Piece& piece : pieces) {
            if (!running.keep_going(piece.begin)) return Status::cancelled;
            std::array<double, 3> c{};
            for (const double t : {piece.begin, piece.end}) {
                if (!problem_.derivatives(t, problem_.prescribed(t == 0 || t == 1), c))
                    return Status::slope_unbounded;
            }
            piece = fit_piece(piece.begin, piece.end);
            if (!piece.solved) return Status::too_many_conditions;
        }
        return Status::ok;
    }

    BezierCurve curve_;
    detail::FitProblem problem_;
    Status status_;
};

/// Fits the optimal pieces between given parameters of the curve, ascending from 0 to 1, with exact
/// integrals. Solves a small linear system per piece, or one for all coupled pieces.
inline Result<BezierFit, FitReport> fit_pieces(const BezierCurve& curve, std::span<const double> parameters,
                                               const FitOptions& options = {}, const Running& running = {}) {
    auto result = SobolevFitter(curve, options).fit(parameters, running);
    result.report.status = running.end(result.report.status);
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
