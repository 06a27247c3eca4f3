// Chooses the knots of a fit: uniform, optimal on a grid, or optimal.
#pragma once

#include <cageform/animate/fit/line_minimum.hpp>
#include <cageform/animate/fit/sobolev_fit.hpp>
#include <cageform/parallel/running.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Returns parameters of a checked curve that divide its interval into equal times.
inline std::vector<double> uniform_in_time(const BezierCurve& curve, std::size_t pieces) {
    const BezierFunction function(curve);
    std::vector<double> parameters;
    for (std::size_t i = 0; i <= pieces; ++i)
        parameters.push_back(function.parameter_at_fraction(double(i) / double(pieces)));
    return parameters;
}
/// Returns equal steps of the parameter (equal arcs in Izdebski 2019).
inline std::vector<double> uniform_in_parameter(std::size_t pieces) {
    std::vector<double> parameters;
    for (std::size_t i = 0; i <= pieces; ++i) parameters.push_back(double(i) / double(pieces));
    return parameters;
}

struct KnotOptions {
    FitOptions fit{};
    std::size_t max_trials = 1000000; ///< for more, search_knots fails with too_many_trials
    std::size_t steps = 40;           ///< of the grid of optimal_knots; at least two per piece are used
    /// Rounds of optimal_knots. Each moves every knot once. At most 20 for more than 64 pieces.
    int rounds = 100;
};

/// The knots that a search found.
struct BestKnots {
    std::vector<double> parameters;   ///< #pieces + 1, from 0 to 1
    std::vector<std::size_t> indices; ///< their indices among the candidates, for a grid
};

/// The result of a knot search.
struct KnotReport {
    /// As for a fit; too_many_trials; knots_not_ascending for 0 pieces or too few candidates; cancelled.
    Status status = Status::ok;
    double objective = std::numeric_limits<double>::infinity(); ///< weighted squared errors
    std::size_t trials = 0;                                     ///< number of fits
};

namespace detail {

using KnotSearch = Result<BestKnots, KnotReport>;

/// Finds the knots of minimum cost among candidates for independent pieces, by dynamic programming:
/// least(n, k) = min_j least(n − 1, j) + cost(j, k).
inline KnotSearch cheapest_path(const SobolevFitter& fitter, std::span<const double> candidates,
                                std::size_t pieces, const Running& running) {
    const std::size_t last = candidates.size() - 1;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    KnotSearch search;
    const auto cancelled = [&](double done) {
        if (running.keep_going(done)) return false;
        search.report.status = Status::cancelled;
        return true;
    };
    std::vector<double> cost((last + 1) * (last + 1), infinity); // from j to k, in row k
    for (std::size_t j = 0; j < last; ++j) {
        if (cancelled(0.8 * double(j) / double(last))) return search;
        for (std::size_t k = j + 1; k <= last; ++k) {
            const auto piece = fitter.fit_piece(candidates[j], candidates[k]);
            ++search.report.trials;
            if (piece.solved) cost[k * (last + 1) + j] = fitter.cost(piece);
        }
    }
    std::vector<std::vector<double>> least(pieces + 1, std::vector<double>(last + 1, infinity));
    std::vector<std::vector<std::size_t>> from(pieces + 1, std::vector<std::size_t>(last + 1));
    least[0][0] = 0;
    for (std::size_t n = 1; n <= pieces; ++n) {
        if (cancelled(0.8 + 0.2 * double(n) / double(pieces))) return search;
        for (std::size_t k = n; k <= last; ++k) {
            for (std::size_t j = n - 1; j < k; ++j) {
                const double sum = least[n - 1][j] + cost[k * (last + 1) + j];
                if (sum >= least[n][k]) continue;
                least[n][k] = sum;
                from[n][k] = j;
            }
        }
    }
    search.report.objective = least[pieces][last];
    if (!(search.report.objective < infinity)) {
        search.report.status = fitter.fit(uniform_in_parameter(pieces)).status();
        if (search) search.report.status = Status::too_many_conditions;
        return search;
    }
    search.value.indices.resize(pieces + 1, last);
    for (std::size_t n = pieces; n > 0; --n) search.value.indices[n - 1] = from[n][search.value.indices[n]];
    for (const std::size_t i : search.value.indices) search.value.parameters.push_back(candidates[i]);
    return search;
}

/// Advances to the next choice of ascending indices from 0 to `last`, in lexicographic order; returns
/// false after the last choice.
inline bool next_choice(std::vector<std::size_t>& indices) noexcept {
    const std::size_t pieces = indices.size() - 1, last = indices[pieces];
    std::size_t i = pieces - 1;
    while (i > 0 && indices[i] + (pieces - i) == last) --i;
    if (i == 0) return false;
    ++indices[i];
    for (std::size_t k = i + 1; k < pieces; ++k) indices[k] = indices[k - 1] + 1;
    return true;
}

/// Finds the knots of minimum cost among candidates by brute force, as in Izdebski 2019.
inline KnotSearch try_all(const SobolevFitter& fitter, std::span<const double> candidates, std::size_t pieces,
                          std::size_t max_trials, const Running& running) {
    KnotSearch search;
    std::vector<std::size_t> indices(pieces + 1);
    for (std::size_t i = 0; i < pieces; ++i) indices[i] = i;
    indices[pieces] = candidates.size() - 1;
    std::vector<double> parameters(pieces + 1);
    do {
        if (search.report.trials++ == max_trials) {
            search.report.status = Status::too_many_trials;
            return search;
        }
        // The first inner knot measures the progress.
        const double done = pieces > 1 ? double(indices[1] - 1) / double(indices[pieces]) : 0;
        if (search.report.trials % 1000 == 0 && !running.keep_going(done)) {
            search.report.status = Status::cancelled;
            return search;
        }
        for (std::size_t i = 0; i <= pieces; ++i) parameters[i] = candidates[indices[i]];
        const double objective = fitter.cost(parameters);
        if (objective < search.report.objective) {
            search.report.objective = objective;
            search.value.parameters = parameters;
            search.value.indices = indices;
        }
    } while (next_choice(indices));
    if (search.value.parameters.empty()) search.report.status = Status::too_many_conditions;
    return search;
}

/// Returns options with independent pieces and almost the same optimal knots: f = C at knots instead of
/// continuity. Returns the given options if there are none, or if slopes have little weight, since the
/// optimal knots then differ.
inline FitOptions with_independent_pieces(FitOptions options) noexcept {
    using enum FitCondition;
    if (options.conditions == (end_value | knot_c0) && options.slope_weight >= 1e-3 * options.value_weight)
        options.conditions = end_value | knot_value;
    return options;
}

/// Resamples knots with the same density to another number of pieces.
inline std::vector<double> resampled_knots(std::span<const double> knots, std::size_t pieces) {
    if (knots.empty()) return {};
    std::vector<double> result;
    const double ratio = double(knots.size() - 1) / double(pieces);
    for (std::size_t i = 0; i < pieces; ++i) {
        const double position = double(i) * ratio;
        const auto k = std::size_t(position);
        result.push_back(std::lerp(knots[k], knots[k + 1], position - double(k)));
    }
    result.push_back(1);
    return result;
}

/// Moves every inner knot once to its position of minimum cost; returns the largest move.
inline double optimise_each_knot(const SobolevFitter& fitter, KnotSearch& search) {
    auto& t = search.value.parameters;
    double moved = 0;
    for (std::size_t i = 1; i + 1 < t.size(); ++i) {
        const auto objective = [&](double x) {
            ++search.report.trials;
            if (!fitter.decoupled()) {
                auto others = t;
                others[i] = x;
                return fitter.cost(others);
            }
            const auto left = fitter.fit_piece(t[i - 1], x), right = fitter.fit_piece(x, t[i + 1]);
            if (!left.solved || !right.solved) return std::numeric_limits<double>::infinity();
            return fitter.cost(left) + fitter.cost(right);
        };
        const double margin = 1e-6 * (t[i + 1] - t[i - 1]);
        const double best = line_minimum(t[i - 1] + margin, t[i], t[i + 1] - margin, 1e-9, objective);
        moved = (std::max)(moved, std::fabs(best - t[i]));
        t[i] = best;
    }
    return moved;
}

} // namespace detail

/// Finds the optimal inner knots among candidates, which ascend from 0 to 1. For `end_value | knot_c0`,
/// unless slope_weight < 1e-3 value_weight, uses the knots of `end_value | knot_value`, whose pieces are
/// independent.
///
///   cost  O(#candidates²) fits of one piece if pieces are independent; else a fit per choice of knots
inline Result<BestKnots, KnotReport> search_knots(const BezierCurve& curve,
                                                  std::span<const double> candidates, std::size_t pieces,
                                                  const KnotOptions& options = {},
                                                  const Running& running = {}) {
    const SobolevFitter fitter(curve, detail::with_independent_pieces(options.fit));
    detail::KnotSearch search;
    search.report.status = fitter.status();
    if (!search) return search;
    if (pieces == 0 || candidates.size() < pieces + 1) {
        search.report.status = Status::knots_not_ascending;
        return search;
    }
    search = fitter.decoupled() ? detail::cheapest_path(fitter, candidates, pieces, running)
                                : detail::try_all(fitter, candidates, pieces, options.max_trials, running);
    search.report.objective = fitter.in_units(search.report.objective);
    search.report.status = running.end(search.report.status);
    return search;
}

/// Finds optimal knots: the optimum on a grid of equal parameter steps, then each knot is optimised in
/// turn until none moves. With more than 64 pieces, it starts from the subdivided knots of half as many
/// pieces. With more than 24 coupled pieces, it returns the knots of `end_value | knot_value`, whose
/// cost is a few per cent higher.
///
///   cost  O(steps² + pieces · rounds) fits of one piece, or of all pieces if they are coupled:
///         milliseconds for 8 pieces, seconds for 1000
inline Result<BestKnots, KnotReport> optimal_knots(const BezierCurve& curve, std::size_t pieces,
                                                   const KnotOptions& options = {},
                                                   const Running& running = {}) {
    constexpr std::size_t most_on_grid = 64, most_coupled = 24;
    const bool many = pieces > most_on_grid;
    FitOptions local = detail::with_independent_pieces(options.fit);
    // On the grid, conditions are replaced by independent ones, as dynamic programming needs.
    KnotOptions on_grid = options;
    using enum FitCondition;
    if (!detail::decoupled(local.conditions)) {
        on_grid.fit.conditions = end_value | knot_value;
        if (pieces > most_coupled) local.conditions = end_value | knot_value;
    }
    detail::KnotSearch search;
    if (many) {
        search = optimal_knots(curve, (pieces + 1) / 2, on_grid, running.subtask(0, 0.5));
        search.value.parameters = detail::resampled_knots(search.value.parameters, pieces);
    } else {
        const auto candidates = uniform_in_parameter((std::max)(options.steps, 2 * pieces));
        search = search_knots(curve, candidates, pieces, on_grid, running.subtask(0, 0.5));
    }
    if (!search) return search;
    search.value.indices.clear();
    const SobolevFitter fitter(curve, local);
    const int rounds = many ? (std::min)(options.rounds, 20) : options.rounds;
    for (int round = 0; round < rounds; ++round) {
        if (!running.keep_going(0.5 + 0.5 * round / rounds)) {
            search.report.status = Status::cancelled;
            return search;
        }
        if (detail::optimise_each_knot(fitter, search) < 1e-8) break;
    }
    search.report.objective = SobolevFitter(curve, options.fit).objective(search.value.parameters);
    search.report.status = running.end(Status::ok);
    return search;
}

} // namespace cageform::inline CAGEFORM_ABI
