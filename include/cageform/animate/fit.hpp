// Fits as few polynomial pieces to a Bézier curve as meet a tolerance.
//
// The order of reading: fit/fit_options.hpp (what is minimised), fit/sobolev_fit.hpp (the best pieces for
// given knots), fit/knots.hpp (the best knots for a number of pieces), fit/fewest_pieces.hpp (the number of
// pieces).
#pragma once

#include <cageform/animate/fit/fewest_pieces.hpp>
#include <cageform/animate/fit/tolerances.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Fits the fewest pieces whose largest error, measured exactly, is not above a tolerance.
///
/// With conditions that leave pieces independent (the default), each piece is as long as possible.
/// Otherwise pieces are added one by one until they suffice, at the best knots for their number.
///
///   tolerance   the bound for |C − f|, in the units of the curve's values
///   returns     the pieces. If options.max_pieces do not suffice, the status is tolerance_not_met and
///               the value is the best fit of that many pieces
///   cost        some microseconds per independent piece; otherwise milliseconds, and seconds for many pieces
inline Result<BezierFit, FitReport> fit(const BezierCurve& curve, double tolerance,
                                        const FitOptions& options = {}, const Running& running = {}) {
    const detail::FewestPieces search(curve, tolerance, options);
    auto result = search.find(running);
    const bool nothing = result.status() == Status::tolerance_not_met && result.value.knots.empty();
    if (nothing) result = search.nearest(running.subtask(1, 1));
    result.report.status = running.end(result.report.status);
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
