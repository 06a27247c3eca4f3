// Solves the functions of a cage with any solver and keeps them, or samples and discards them group
// by group.
#pragma once

#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/harmonic/cage_solver.hpp>
#include <cageform/core/detail/in_parallel.hpp>

#include <memory>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A solver made for a problem, with its functions once they have been solved and kept.
template <CageSolver S>
struct Solution {
    using Solver = S;

    std::shared_ptr<const typename S::Problem> problem;
    std::optional<S> solver;
    std::vector<typename S::Functions> functions; ///< by group; empty until `solve`
    SolverReport report;                          ///< of the solve whose functions are kept

    Status make(std::shared_ptr<const typename S::Problem> given, SolverReport& into) {
        problem = std::move(given);
        const Status status = S::make(*problem, into, solver);
        if (status != Status::ok) return status;
        // NOLINTNEXTLINE(bugprone-unchecked-optional-access): made where the status is ok
        const auto [hierarchy, block] = solver->memory();
        into.bytes = hierarchy + block;
        return Status::ok;
    }

    /// Solves all functions and keeps them.
    Status solve(SolverReport& into, const Running& running) { return solve_by(*solver, into, running); }

    /// Solves all functions, starting from the functions that a solution for another cage has kept.
    Status solve_from(const Solution& before, std::span<const std::size_t> old_handles, SolverReport& into,
                      const Running& running) {
        if constexpr (WarmSolver<S>) {
            if (!solver->takes_guess()) return solve(into, running);
            const typename S::Guess guess(*solver, *before.solver, before.functions, old_handles);
            return solve_by(FromGuess{*solver, guess}, into, running);
        }
        return solve(into, running);
    }

private:
    /// Adapts a solver with a guess to the GroupSolver concept.
    template <class Guess>
    struct FromGuess {
        using Block = typename S::Block;
        const S& solver;
        const Guess& guess;

        std::size_t groups() const { return solver.groups(); }
        Block make_block() const { return solver.make_block(); }
        std::size_t helpers() const noexcept requires requires(const S& s) { s.helpers(); }
        { return solver.helpers(); }
        Status solve(std::size_t group, Block& block, grid::GroupWork& work) const {
            return solver.solve(group, block, work, &guess);
        }
    };
    template <class Guess>
    FromGuess(const S&, const Guess&) -> FromGuess<Guess>;

    template <class Groups>
    Status solve_by(const Groups& groups, SolverReport& into, const Running& running) {
        // NOLINTNEXTLINE(bugprone-unchecked-optional-access): solved once it is made
        const double kept = 0.5 * double(solver->memory().block) * double(solver->groups());
        if (double(into.bytes) + kept > double(memory_limit(problem->options))) {
            into.bytes += std::size_t(kept);
            return Status::out_of_memory;
        }
        functions.resize(solver->groups());
        const Status status = grid::solve_groups(
            groups, into,
            [&](std::size_t group, const auto& block) { functions[group] = solver->keep(block); }, running);
        report = into;
        return status;
    }
};

/// Computes the weights of a batch of points, from kept functions if there are any. Otherwise it
/// solves the functions group by group and frees each group after sampling it.
template <CageSolver S>
Status sample_solution(const Solution<S>& solution, const Batch<typename S::Problem::scalar>& batch,
                       SolverReport& report, const Running& running) {
    constexpr std::size_t lanes = lane_count<typename S::Problem::scalar>;
    constexpr std::size_t together = 1024 / lanes; // blocks of points in one Samples
    // NOLINTNEXTLINE(bugprone-unchecked-optional-access): a solution is used once it is made
    const S& solver = *solution.solver;
    const std::size_t blocks = batch.points.blocks(), pieces = (blocks + together - 1) / together;
    if (!solution.functions.empty()) {
        return for_each_block(blocks, running, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; b += together) {
                auto samples = solver.samples(batch, b * lanes, (std::min)(b + together, end) * lanes);
                for (std::size_t group = 0; group < solution.functions.size(); ++group)
                    solver.sample(samples, group, solution.functions[group], batch.rows);
                solver.finish(samples, batch.rows);
            }
        });
    }
    if (blocks == 0) return Status::ok;
    std::vector<typename S::Samples> samples(pieces);
    in_parallel(running, pieces, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n)
            samples[n] =
                solver.samples(batch, n * together * lanes, (std::min)((n + 1) * together, blocks) * lanes);
    });
    const auto sample_group = [&](std::size_t group, const auto& block) {
        for (auto& piece : samples) solver.sample(piece, group, block, batch.rows);
    };
    const Status status = grid::solve_groups(solver, report, sample_group, running);
    if (status != Status::ok) return status;
    for (auto& piece : samples) solver.finish(piece, batch.rows);
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
