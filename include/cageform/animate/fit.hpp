// As few pieces as meet a tolerance, and what tolerance cannot be seen.
#pragma once

#include <cageform/animate/knots.hpp>

#include <numbers>

namespace cageform::inline CAGEFORM_ABI {

/// The fewest pieces whose largest error, measured exactly, is not above a tolerance.
///
/// With pieces that are determined apart (as by default) each reaches as far as it can; otherwise there is one piece
/// more until it suffices, at the best knots for their number.
///
///   tolerance   of |C − f|, in the units of the curve's values
///   max_pieces  tolerance_not_met where they do not suffice; the result is then the best of that many
///   cost        some microseconds a piece where they are determined apart; where not, milliseconds, and seconds for many
inline BezierFit fit(const BezierCurve& curve, double tolerance, const FitOptions& options = {},
                     std::size_t max_pieces = 64) {
    const SobolevFitter fitter(curve, options);
    BezierFit result;
    result.status = fitter.status();
    if (result.status == Status::ok && !(tolerance > 0)) result.status = Status::tolerance_not_positive;
    if (result.status != Status::ok) return result;
    if (!fitter.decoupled()) {
        for (std::size_t pieces = 1; pieces <= max_pieces; ++pieces) {
            // Polished only where that may help.
            for (const int rounds : {0, 20}) {
                const auto search = optimal_knots(curve, pieces, options, 40, rounds);
                result.status = search.status;
                if (search.status == Status::ok) result = fitter.fit(search.parameters);
                if (result.status != Status::ok) break;
                if (result.sup_error <= tolerance) return result;
                if (result.sup_error > 2 * tolerance) break;
            }
            // More pieces give more freedom, but not to conditions that repeat each other.
            if (result.status == Status::too_many_conditions && pieces < 8) continue;
            if (result.status != Status::ok) return result;
        }
        if (result.status == Status::ok) result.status = Status::tolerance_not_met;
        return result;
    }
    std::vector<SobolevFitter::Piece> pieces;
    double begin = 0, step = 1;
    while (begin < 1) {
        if (pieces.size() == max_pieces) {
            const auto search = optimal_knots(curve, max_pieces, options);
            result = search.status == Status::ok ? fitter.fit(search.parameters) : BezierFit{};
            result.status = search.status == Status::ok ? Status::tolerance_not_met : search.status;
            return result;
        }
        // The farthest end that is good enough, between one that is and one that is not. Errors go like the fourth power of
        // the length, for higher degrees like one more each.
        SobolevFitter::Piece good;
        bool verified = false;
        double low = begin, high = 2, end = std::min(1.0, begin + step);
        for (int round = 0; round < 40; ++round) {
            const auto piece = fitter.fit_piece(begin, end);
            if (!piece.solved && end - begin < 1e-12) {
                // Too many conditions for a piece, or a slope that there is not.
                result.status = fitter.fit(std::array<double, 2>{0, 1}).status;
                if (result.status == Status::ok) result.status = Status::too_many_conditions;
                return result;
            }
            double error =
                piece.solved ? fitter.sampled_error(piece) : std::numeric_limits<double>::infinity();
            // Exactly only where it may be the end of the search.
            const bool last = end == 1 || error >= 0.9 * tolerance || high - low <= 1e-3 * (end - begin);
            if (last && error <= tolerance) error = fitter.largest_error(piece);
            const bool fits = error <= tolerance;
            (fits ? low : high) = end;
            if (fits) good = piece;
            if (fits && last &&
                (end == 1 || error >= 0.97 * tolerance || high - low <= 1e-3 * (end - begin))) {
                verified = true;
                break;
            }
            const double factor =
                std::pow(0.985 * tolerance / std::max(error, 1e-300), 1 / double(options.degree + 1));
            const double guess = begin + (end - begin) * std::clamp(factor, 0.1, 8.0);
            const double top = std::min(high, 1.0);
            end = guess > low && guess < top ? guess : fits && high > 1 ? 1.0 : 0.5 * (low + top);
        }
        // What the places of sampled_error do not show.
        while (good.solved && !verified) {
            verified = fitter.largest_error(good) <= tolerance;
            if (!verified) good = fitter.fit_piece(begin, begin + 0.95 * (good.end - begin));
        }
        if (!good.solved) {
            result.status = Status::tolerance_not_met; // below what doubles resolve
            return result;
        }
        pieces.push_back(good);
        step = 1.2 * (good.end - begin);
        begin = good.end;
    }
    return fitter.gather(std::move(result), pieces);
}

/// @name Tolerances
/// Errors that cannot be seen (the source, sec. 5.2). In the units of the values animated, angles of arguments in radians.
/// @{

/// One step of a colour channel of `bits` bits, of a range of 1.
inline double colour_tolerance(unsigned bits) noexcept {
    return std::ldexp(1.0, -int(bits));
}
/// One pixel under an orthographic camera that sees `width` units on `pixels` pixels.
inline double orthographic_tolerance(double width, double pixels) noexcept {
    return width / pixels;
}
/// One pixel at distance `depth` under a perspective camera whose field of view is `angle` across `pixels` pixels.
inline double perspective_tolerance(double angle, double depth, double pixels) noexcept {
    return 2 * std::tan(0.5 * angle) * depth / pixels;
}
/// An angle that moves no point farther than `distance` from where it should be, all points being within `radius` of the pivot.
inline double rotation_tolerance(double distance, double radius) noexcept {
    return distance / radius;
}
/// What an eye can tell apart at a distance: an arc minute.
inline double eye_tolerance(double distance) noexcept {
    return 2 * std::tan(std::numbers::pi / 180 / 120) * distance;
}
/// The pitch of a screen's pixels, in millimetres, from its size in pixels and its diagonal in inches.
inline double pixel_pitch(double width, double height, double diagonal) noexcept {
    return 25.4 * diagonal / std::hypot(width, height);
}
/// The default: a pixel of a path that crosses a screen of 1920.
inline constexpr double screen_tolerance = 1.0 / 1920;
/// @}

} // namespace cageform::inline CAGEFORM_ABI
