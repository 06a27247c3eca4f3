// Fits the fewest polynomial pieces to a Bézier curve that meet a tolerance.
//
// Order of reading: fit/fit_options.hpp (the objective), fit/sobolev_fit.hpp (the best pieces for given
// knots), fit/knots.hpp (the best knots for a number of pieces), fit/fewest_pieces.hpp (the number of
// pieces).
#pragma once

#include <cageform/animate/fit/fewest_pieces.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Fits the fewest pieces whose maximum error, measured exactly, is at most a tolerance.
///
/// If the conditions leave pieces independent (the default), each piece is as long as possible.
/// Otherwise the number of pieces grows by one, with optimal knots, until the tolerance is met.
///
///   tolerance   the bound for |C − f|, in the units of the curve's values
///   returns     the pieces. If options.max_pieces is too small, the status is tolerance_not_met and the
///               value is the best fit with that number of pieces
///   cost        microseconds per independent piece; for coupled pieces milliseconds to seconds
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
