// Where the pieces of a fit meet: uniform, searched on a grid, or optimal.
#pragma once

#include <cageform/animate/sobolev_fit.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Parameters of a sound curve where its interval is divided into equal times.
inline std::vector<double> uniform_in_time(const BezierCurve& curve, std::size_t pieces) {
    const BezierFunction function(curve);
    std::vector<double> parameters;
    for (std::size_t i = 0; i <= pieces; ++i)
        parameters.push_back(function.parameter_at_part(double(i) / double(pieces)));
    return parameters;
}
/// Equal steps of the parameter: what the source calls equal arcs (its figures show that).
inline std::vector<double> uniform_in_parameter(std::size_t pieces) {
    std::vector<double> parameters;
    for (std::size_t i = 0; i <= pieces; ++i) parameters.push_back(double(i) / double(pieces));
    return parameters;
}

/// Knots and what they cost.
struct KnotSearch {
    Status status =
        Status::ok; ///< as of a fit; too_many_trials; knots_not_ascending for fewer candidates than pieces
    std::vector<double> parameters;   ///< #pieces + 1, from 0 to 1
    std::vector<std::size_t> indices; ///< of them among the candidates, where they are from a grid
    double objective = std::numeric_limits<double>::infinity(); ///< weighted squares of the errors
    std::size_t trials = 0;
};

namespace detail {

/// Minimises f on (low, high) around `at`: golden sections, and parabolas where they do (Brent 1973, ch. 5).
template <class F>
double line_minimum(double low, double at, double high, double tolerance, const F& f) {
    constexpr double golden = 0.3819660112501051;
    double best = at, second = at, third = at, f_best = f(at), f_second = f_best, f_third = f_best;
    double step = 0, before = 0;
    for (int round = 0; round < 60; ++round) {
        const double middle = 0.5 * (low + high);
        if (std::fabs(best - middle) <= 2 * tolerance - 0.5 * (high - low)) break;
        bool parabola = false;
        if (std::fabs(before) > tolerance) {
            const double r = (best - second) * (f_best - f_third), q0 = (best - third) * (f_best - f_second);
            double p = (best - third) * q0 - (best - second) * r, q = 2 * (q0 - r);
            if (q > 0) p = -p;
            q = std::fabs(q);
            if (std::fabs(p) < std::fabs(0.5 * q * before) && p > q * (low - best) && p < q * (high - best)) {
                before = step;
                step = p / q;
                parabola = true;
            }
        }
        if (!parabola) {
            before = best < middle ? high - best : low - best;
            step = golden * before;
        }
        const double next = best + (std::fabs(step) >= tolerance ? step : std::copysign(tolerance, step));
        const double f_next = f(next);
        if (f_next <= f_best) {
            (next < best ? high : low) = best;
            third = second;
            f_third = f_second;
            second = best;
            f_second = f_best;
            best = next;
            f_best = f_next;
        } else {
            (next < best ? low : high) = next;
            if (f_next <= f_second || second == best) {
                third = second;
                f_third = f_second;
                second = next;
                f_second = f_next;
            } else if (f_next <= f_third || third == best || third == second) {
                third = next;
                f_third = f_next;
            }
        }
    }
    return best;
}

/// The knots of least cost among candidates when pieces are determined by their own interval, by dynamic programming:
/// least(n, k) = min_j least(n − 1, j) + cost(j, k).
inline KnotSearch cheapest_path(const SobolevFitter& fitter, std::span<const double> candidates,
                                std::size_t pieces) {
    const std::size_t last = candidates.size() - 1;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    KnotSearch search;
    std::vector<double> cost((last + 1) * (last + 1), infinity);
    for (std::size_t j = 0; j < last; ++j) {
        for (std::size_t k = j + 1; k <= last; ++k) {
            const auto piece = fitter.fit_piece(candidates[j], candidates[k]);
            ++search.trials;
            if (piece.solved) cost[j * (last + 1) + k] = fitter.cost(piece);
        }
    }
    std::vector<std::vector<double>> least(pieces + 1, std::vector<double>(last + 1, infinity));
    std::vector<std::vector<std::size_t>> from(pieces + 1, std::vector<std::size_t>(last + 1));
    least[0][0] = 0;
    for (std::size_t n = 1; n <= pieces; ++n) {
        for (std::size_t k = n; k <= last; ++k) {
            for (std::size_t j = n - 1; j < k; ++j) {
                const double sum = least[n - 1][j] + cost[j * (last + 1) + k];
                if (sum >= least[n][k]) continue;
                least[n][k] = sum;
                from[n][k] = j;
            }
        }
    }
    search.objective = least[pieces][last];
    if (!(search.objective < infinity)) {
        search.status = fitter.fit(uniform_in_parameter(pieces)).status;
        if (search.status == Status::ok) search.status = Status::too_many_conditions;
        return search;
    }
    std::size_t k = last;
    for (std::size_t n = pieces; n > 0; --n) {
        search.indices.push_back(k);
        k = from[n][k];
    }
    search.indices.push_back(0);
    std::reverse(search.indices.begin(), search.indices.end());
    for (const std::size_t i : search.indices) search.parameters.push_back(candidates[i]);
    return search;
}

/// Options whose pieces are determined apart and have practically the same best knots: values taken at knots in the stead of
/// neighbours that agree. The same options where there are none, and where slopes hardly count, which makes a difference.
inline FitOptions apart(FitOptions options) noexcept {
    using enum FitCondition;
    if (options.conditions == (end_value | knot_c0) && options.slope_weight >= 1e-3 * options.value_weight)
        options.conditions = end_value | knot_value;
    return options;
}

} // namespace detail

/// The best of all choices of inner knots among candidates, which ascend from 0 to 1 (the source's brute force). Where pieces
/// are determined apart the best is found without trying all; so with `end_value | knot_c0`, by the knots of
/// `end_value | knot_value`.
///
///   max_trials  choices that are tried before it gives up with too_many_trials
inline KnotSearch search_knots(const BezierCurve& curve, std::span<const double> candidates,
                               std::size_t pieces, const FitOptions& options = {},
                               std::size_t max_trials = 1000000) {
    const SobolevFitter fitter(curve, detail::apart(options));
    KnotSearch search;
    search.status = fitter.status();
    if (search.status != Status::ok) return search;
    if (pieces == 0 || candidates.size() < pieces + 1) {
        search.status = Status::knots_not_ascending;
        return search;
    }
    if (fitter.decoupled()) return detail::cheapest_path(fitter, candidates, pieces);
    const std::size_t last = candidates.size() - 1;
    std::vector<std::size_t> indices(pieces + 1);
    for (std::size_t i = 0; i < pieces; ++i) indices[i] = i;
    indices[pieces] = last;
    std::vector<double> parameters(pieces + 1);
    for (;;) {
        if (search.trials++ == max_trials) {
            search.status = Status::too_many_trials;
            return search;
        }
        for (std::size_t i = 0; i <= pieces; ++i) parameters[i] = candidates[indices[i]];
        const double objective = fitter.objective(parameters);
        if (objective < search.objective) {
            search.objective = objective;
            search.parameters = parameters;
            search.indices = indices;
        }
        std::size_t i = pieces - 1; // the next choice, the last knot fastest
        while (i > 0 && indices[i] + (pieces - i) == last) --i;
        if (i == 0) break;
        ++indices[i];
        for (std::size_t k = i + 1; k < pieces; ++k) indices[k] = indices[k - 1] + 1;
    }
    if (search.parameters.empty()) search.status = Status::too_many_conditions;
    return search;
}

/// The source's heuristic for two pieces (Algorithm 4): the best of `steps` equal steps of time, then of as many between its
/// neighbours, and so on, until the weighted error is accepted or `rounds` are done.
inline KnotSearch refine_knot(const BezierCurve& curve, std::size_t steps, const FitOptions& options = {},
                              double accepted_error = 0, std::size_t rounds = 8) {
    const SobolevFitter fitter(curve, options);
    KnotSearch search;
    search.status = fitter.status();
    if (search.status != Status::ok) return search;
    double low = 0, high = 1;
    for (std::size_t round = 0;
         round < rounds && std::sqrt(std::fmax(search.objective, 0.0)) > accepted_error; ++round) {
        double best = 0.5 * (low + high), least = std::numeric_limits<double>::infinity();
        for (std::size_t i = 1; i < steps; ++i) {
            const double part = low + (high - low) * double(i) / double(steps);
            const std::array<double, 3> parameters{0, fitter.function().parameter_at_part(part), 1};
            const double objective = fitter.objective(parameters);
            ++search.trials;
            if (objective >= least) continue;
            least = objective;
            best = part;
            search.parameters.assign(parameters.begin(), parameters.end());
        }
        search.objective = least;
        const double step = (high - low) / double(steps);
        low = best - step;
        high = best + step;
    }
    if (search.parameters.empty()) search.status = Status::too_many_conditions;
    return search;
}

/// The best knots: those on a grid of `steps` equal steps of the parameter, then polished continuously, one knot after the other,
/// until none moves or `rounds` are done. O(steps² + pieces · rounds) fits of a piece, of all pieces where they are tied.
inline KnotSearch optimal_knots(const BezierCurve& curve, std::size_t pieces, const FitOptions& options = {},
                                std::size_t steps = 40, int rounds = 100) {
    const SobolevFitter fitter(curve, detail::apart(options));
    // The grid is searched with pieces apart whatever the conditions, or there would be too many choices.
    FitOptions on_grid = options;
    using enum FitCondition;
    if (!fitter.decoupled()) on_grid.conditions = end_value | knot_value;
    KnotSearch search =
        search_knots(curve, uniform_in_parameter(std::max(steps, 2 * pieces)), pieces, on_grid);
    if (search.status != Status::ok) return search;
    auto& t = search.parameters;
    search.indices.clear();
    for (int round = 0; round < rounds; ++round) {
        double moved = 0;
        for (std::size_t i = 1; i < pieces; ++i) {
            const auto objective = [&](double x) {
                ++search.trials;
                if (!fitter.decoupled()) {
                    auto others = t;
                    others[i] = x;
                    return fitter.objective(others);
                }
                const auto left = fitter.fit_piece(t[i - 1], x), right = fitter.fit_piece(x, t[i + 1]);
                if (!left.solved || !right.solved) return std::numeric_limits<double>::infinity();
                return fitter.cost(left) + fitter.cost(right);
            };
            const double margin = 1e-6 * (t[i + 1] - t[i - 1]);
            const double best =
                detail::line_minimum(t[i - 1] + margin, t[i], t[i + 1] - margin, 1e-9, objective);
            moved = std::max(moved, std::fabs(best - t[i]));
            t[i] = best;
        }
        if (moved < 1e-8) break;
    }
    search.objective = SobolevFitter(curve, options).objective(t);
    return search;
}

} // namespace cageform::inline CAGEFORM_ABI
