// The result of fitting a Bézier curve: polynomials in time and their errors.
#pragma once

#include <cageform/animate/curves/bezier.hpp>
#include <cageform/clip/curves/piecewise_cubic.hpp>
#include <cageform/core/detail/bernstein.hpp>
#include <cageform/core/result.hpp>

#include <algorithm>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The errors of a fit f of a curve C.
struct FitReport {
    /// ok; as check(curve), value_not_finite also where values differ by more than 1e306 from the
    /// first key's, or a coefficient overflows; and
    ///   degree_not_supported      not 3, 4 or 5
    ///   weights_not_positive      value_weight is not positive or slope_weight negative
    ///   norm_not_supported        the sup norm with conditions that couple pieces
    ///   knots_not_ascending       knots do not ascend from 0 to 1, or two coincide after rounding
    ///   slope_unbounded           a condition prescribes an unbounded derivative
    ///   too_many_conditions       more conditions than coefficients, or repeated ones
    ///   tolerance_not_positive    from `fit`
    ///   tolerance_not_met         from `fit`, with the largest number of pieces
    ///   cancelled                 from `fit`
    Status status = Status::ok;
    double l2_error = 0;    ///< (∫ (C − f)² dx)^½, in the units of the curve
    double slope_error = 0; ///< (∫ (C' − f')² dx)^½; infinite at a vertical tangent
    double sup_error = 0;   ///< max |C − f|, exact to rounding
    double sup_at = 0;      ///< a time at which it is attained

    double w12_error() const noexcept { return std::hypot(l2_error, slope_error); }
};

/// Consecutive polynomials in time; together they are the function f.
struct BezierFit {
    std::size_t degree = 3;
    std::vector<double> knots;      ///< #pieces + 1 times
    std::vector<double> parameters; ///< the curve's parameters at the knots, from 0 to 1
    /// #pieces · (degree + 1) Bernstein coefficients; each piece is a polynomial on [0, 1].
    std::vector<double> bernstein;
    std::size_t free_coefficients = 0; ///< coefficients minus conditions

    std::size_t pieces() const noexcept { return knots.empty() ? 0 : knots.size() - 1; }
    std::span<const double> coefficients(std::size_t piece) const noexcept {
        return std::span(bernstein).subspan(piece * (degree + 1), degree + 1);
    }
    double operator()(double x) const noexcept {
        std::size_t i = 0;
        while (i + 2 < knots.size() && x >= knots[i + 1]) ++i;
        return in_piece(i, (x - knots[i]) / (knots[i + 1] - knots[i]));
    }
    /// Returns the value of a piece at u in [0, 1], from its first knot to its second.
    double in_piece(std::size_t piece, double u) const noexcept {
        detail::Bernstein p{degree, {}};
        std::ranges::copy(coefficients(piece), p.c.begin());
        return p(u);
    }
};

/// Converts a piece of degree 3 to its run-time form. Its ends are rounded to T, so that it meets the
/// next piece. T must resolve its length; its coefficients may overflow T.
template <Scalar T>
CubicPiece<T> cubic_piece(const BezierFit& fitted, std::size_t piece) noexcept {
    const auto b = fitted.coefficients(piece);
    const T begin = static_cast<T>(fitted.knots[piece]);
    const double h = double(static_cast<T>(fitted.knots[piece + 1])) - double(begin);
    const double c1 = 3 * (b[1] - b[0]), c2 = 3 * (b[2] - 2 * b[1] + b[0]),
                 c3 = b[3] - 3 * b[2] + 3 * b[1] - b[0];
    return {begin, static_cast<T>(b[0]), static_cast<T>(c1 / h), static_cast<T>(c2 / (h * h)),
            static_cast<T>(c3 / (h * h * h))};
}

} // namespace cageform::inline CAGEFORM_ABI
