// Finds the fewest polynomial pieces of a curve that meet a tolerance.
#pragma once

#include <cageform/animate/fit/knots.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The fewest pieces of one curve for a tolerance.
class FewestPieces {
public:
    using Fit = Result<BezierFit, FitReport>;

    FewestPieces(const BezierCurve& curve, double tolerance, const FitOptions& options)
        : fitter_(curve, options)
        , options_(options)
        , tolerance_(tolerance) {}

    /// Finds them. With independent pieces, a result with tolerance_not_met has no pieces.
    Fit find(const Running& running) const {
        if (fitter_.status() != Status::ok) return refused(fitter_.status());
        if (!(tolerance_ > 0)) return refused(Status::tolerance_not_positive);
        return fitter_.decoupled() ? reach_far(running) : add_pieces(running);
    }
    /// Whether pieces depend on each other, which takes longer.
    bool coupled() const noexcept { return fitter_.status() == Status::ok && !fitter_.decoupled(); }
    /// Fits the largest number of pieces allowed: the best result if the tolerance cannot be met.
    Fit nearest(const Running& running) const {
        Fit result = at_optimal_knots(options_.max_pieces, KnotOptions{}.rounds, running);
        if (result) result.report.status = Status::tolerance_not_met;
        return result;
    }

private:
    static Fit refused(Status status) { return {{}, {status}}; }

    Fit at_optimal_knots(std::size_t pieces, int rounds, const Running& running) const {
        KnotOptions options;
        options.fit = options_;
        options.rounds = rounds;
        const auto search = optimal_knots(fitter_.curve(), pieces, options, running);
        return search ? fitter_.fit(search.value.parameters) : refused(search.status());
    }

    /// For coupled pieces: adds one piece after another until they suffice.
    Fit add_pieces(const Running& running) const {
        Fit result;
        for (std::size_t pieces = 1; pieces <= options_.max_pieces; ++pieces) {
            if (!running.keep_going(double(pieces - 1) / double(options_.max_pieces)))
                return refused(Status::cancelled);
            for (const int rounds : {0, 20}) { // polishes knots only if that may help
                result = at_optimal_knots(pieces, rounds, {});
                if (!result) break;
                if (result.report.sup_error <= tolerance_) return result;
                if (result.report.sup_error > 2 * tolerance_) break;
            }
            // More pieces give more freedom, but do not resolve repeated conditions.
            if (result.status() == Status::too_many_conditions && pieces < 8) continue;
            if (!result) return result;
        }
        if (result) result.report.status = Status::tolerance_not_met;
        return result;
    }

    /// For independent pieces: makes each as long as possible.
    Fit reach_far(const Running& running) const {
        std::vector<FitPiece> pieces;
        double begin = 0, step = 1;
        while (begin < 1) {
            if (!running.keep_going(begin)) return refused(Status::cancelled);
            if (pieces.size() == options_.max_pieces) return refused(Status::tolerance_not_met);
            const auto [status, piece] = longest_piece(begin, (std::min)(1.0, begin + step));
            if (status != Status::ok) return refused(status);
            pieces.push_back(piece);
            step = 1.2 * (piece.end - begin);
            begin = piece.end;
        }
        return fitter_.gather(pieces);
    }

    struct LongestPiece {
        Status status;
        FitPiece piece;
    };
    /// The longest piece from parameter `begin` that meets the tolerance; the first trial ends at `end`.
    LongestPiece longest_piece(double begin, double end) const {
        FitPiece good;
        double low = begin, high = 2; // an end that is near enough, and one that is too far
        const auto narrow = [&] { return high - low <= 1e-3 * (end - begin); };
        for (int round = 0; round < 40; ++round) {
            const FitPiece piece = fitter_.fit_piece(begin, end);
            if (!piece.solved && end - begin < 1e-12) return {why_none(), {}};
            double error =
                piece.solved ? fitter_.sampled_error(piece) : std::numeric_limits<double>::infinity();
            // Measures the error exactly only if the search may end here.
            const bool last = end == 1 || error >= 0.9 * tolerance_ || narrow();
            if (last && error <= tolerance_) error = fitter_.largest_error(piece);
            const bool fits = error <= tolerance_;
            (fits ? low : high) = end;
            if (fits) good = piece;
            if (fits && last && (end == 1 || error >= 0.97 * tolerance_ || narrow()))
                return {Status::ok, good};
            const double guess = begin + (end - begin) * length_factor(error), top = (std::min)(high, 1.0);
            end = guess > low && guess < top ? guess : fits && high > 1 ? 1.0 : 0.5 * (low + top);
        }
        // The samples may have missed the largest error. Errors of rounding do not shrink with the length.
        for (int round = 0; good.solved && fitter_.largest_error(good) > tolerance_; ++round) {
            if (round == 100) return {Status::tolerance_not_met, {}};
            good = fitter_.fit_piece(begin, begin + 0.95 * (good.end - begin));
        }
        // No piece: the tolerance is below the resolution of doubles.
        return {good.solved ? Status::ok : Status::tolerance_not_met, good};
    }

    /// The factor by which the length may change: errors are of order degree + 1 in the length.
    double length_factor(double error) const noexcept {
        const double order = double(options_.degree + 1);
        return std::clamp(std::pow(0.985 * tolerance_ / (std::max)(error, 1e-300), 1 / order), 0.1, 8.0);
    }

    /// The reason why there is no piece, however short.
    Status why_none() const {
        const Status status = fitter_.fit(std::array<double, 2>{0, 1}).status();
        return status == Status::ok ? Status::too_many_conditions : status;
    }

    SobolevFitter fitter_;
    FitOptions options_;
    double tolerance_;
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
