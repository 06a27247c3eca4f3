// Finds the fewest polynomial pieces that approximate a curve within a tolerance.
#pragma once

#include <cageform/animate/fit/knots.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

class FewestPieces {
public:
    using Fit = Result<BezierFit, FitReport>;

    FewestPieces(const BezierCurve& curve, double tolerance, const FitOptions& options)
        : fitter_(curve, options)
        , options_(options)
        , tolerance_(tolerance) {}

    /// Finds the fewest pieces. With independent pieces, a result with tolerance_not_met is empty.
    Fit find(const Running& running) const {
        if (fitter_.status() != Status::ok) return refused(fitter_.status());
        if (!(tolerance_ > 0)) return refused(Status::tolerance_not_positive);
        return fitter_.decoupled() ? longest_pieces(running) : add_pieces(running);
    }
    /// Whether conditions couple the pieces; the search is then slower.
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

    /// For coupled pieces: increments the number of pieces until they meet the tolerance.
    Fit add_pieces(const Running& running) const {
        Fit result;
        for (std::size_t pieces = 1; pieces <= options_.max_pieces; ++pieces) {
            if (!running.keep_going(double(pieces - 1) / double(options_.max_pieces)))
                return refused(Status::cancelled);
            for (const int rounds : {0, 20}) { // optimises the knots only if the error is near the tolerance
                result = at_optimal_knots(pieces, rounds, {});
                if (!result) break;
                if (result.report.sup_error <= tolerance_) return result;
                if (result.report.sup_error > 2 * tolerance_) break;
            }
            // More pieces add coefficients; repeated conditions stay unsolvable.
            if (result.status() == Status::too_many_conditions && pieces < 8) continue;
            if (!result) return result;
        }
        if (result) result.report.status = Status::tolerance_not_met;
        return result;
    }

    /// For independent pieces: makes each piece as long as possible.
    Fit longest_pieces(const Running& running) const {
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
    /// Returns the longest piece from parameter `begin` that meets the tolerance; the first trial ends
    /// at `end`.
    LongestPiece longest_piece(double begin, double end) const {
        FitPiece good;
        double low = begin, high = 2; // bounds of the longest piece's end
        const auto narrow = [&] { return high - low <= 1e-3 * (end - begin); };
        for (int round = 0; round < 40; ++round) {
            const FitPiece piece = fitter_.fit_piece(begin, end);
            if (!piece.solved && end - begin < 1e-12) return {failure_reason(), {}};
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
        // The samples may have missed the maximum error. Rounding errors do not shrink with the length.
        for (int round = 0; good.solved && fitter_.largest_error(good) > tolerance_; ++round) {
            if (round == 100) return {Status::tolerance_not_met, {}};
            good = fitter_.fit_piece(begin, begin + 0.95 * (good.end - begin));
        }
        // If there is no piece, the tolerance is below the resolution of double.
        return {good.solved ? Status::ok : Status::tolerance_not_met, good};
    }

    /// Returns the factor for the next length: the error is of order degree + 1 in the length.
    double length_factor(double error) const noexcept {
        const double order = double(options_.degree + 1);
        return std::clamp(std::pow(0.985 * tolerance_ / (std::max)(error, 1e-300), 1 / order), 0.1, 8.0);
    }

    /// Returns the reason why even the shortest piece fails.
    Status failure_reason() const {
        const Status status = fitter_.fit(std::array<double, 2>{0, 1}).status();
        return status == Status::ok ? Status::too_many_conditions : status;
    }

    SobolevFitter fitter_;
    FitOptions options_;
    double tolerance_;
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
