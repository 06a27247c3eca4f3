// Solves functions by multigrid, sixteen at a time, until the error of each is below the tolerance.
#pragma once

#include <cageform/grid/multigrid/multigrid.hpp>
#include <cageform/grid/solve_groups.hpp>

#include <functional>

namespace cageform::inline CAGEFORM_ABI::grid {

struct CycleGoal {
    std::size_t functions;
    double tolerance; ///< maximum error of each function, by its estimate
    std::size_t max_cycles;
};

/// Solves a block whose source is set.
///
///   goal     applies to the first goal.functions functions of the block; others are ignored
///   between  between() is called before every cycle and after the last one. It may change the source, and
///            returns the resulting change of the solution. Cycles end when this change, too, is within the
///            tolerance
///   fails    not_converged, cancelled
template <std::size_t D>
Status run_cycles(const Multigrid<D>& multigrid, typename Multigrid<D>::Block& block, const CycleGoal& goal,
                  GroupWork& work, const std::function<double()>& between) {
    const auto largest = [&](const typename Multigrid<D>::Values& values) {
        return *std::max_element(values.begin(), values.begin() + std::ptrdiff_t(goal.functions));
    };
    SolverReport& report = work.report;
    report.solves = goal.functions;
    auto error = multigrid.start(block, work.share);
    double before = 0;
    for (;;) {
        report.multigrid.error_estimate = largest(error.estimate);
        report.multigrid.error_bound = largest(error.bound);
        if (report.multigrid.cycles > 1 && before > goal.tolerance)
            report.multigrid.convergence_factor =
                (std::max)(report.multigrid.convergence_factor, report.multigrid.error_estimate / before);
        const double change = between();
        // The gain is unknown before the first cycle.
        if (report.multigrid.cycles > 0 && block.is_refined() &&
            (std::max)(report.multigrid.error_estimate, change) <= goal.tolerance)
            return Status::ok;
        if (report.multigrid.cycles == goal.max_cycles) {
            report.unconverged = goal.functions;
            return Status::not_converged;
        }
        if (!work.keep_going(double(report.multigrid.cycles) / double(report.multigrid.cycles + 4)))
            return Status::cancelled;
        before = report.multigrid.error_estimate + change;
        error = multigrid.cycle(block, work.share);
        ++report.multigrid.cycles;
    }
}

/// A solver of functions given by their right-hand sides, for solve_groups.
///
///   goal  for all functions
///   fill  fill(first, count, source) adds the right-hand sides of functions first … first + count − 1 to
///         the block's source, which is zero
template <std::size_t D, class Fill>
struct MultigridGroups {
    using Block = typename Multigrid<D>::Block;
    static constexpr std::size_t width = Multigrid<D>::width;

    const Multigrid<D>& multigrid;
    CycleGoal goal;
    Fill fill;

    std::size_t groups() const noexcept { return (goal.functions + width - 1) / width; }
    Block make_block() const { return multigrid.make_block(); }
    std::size_t helpers() const noexcept { return multigrid.helpers(); }

    Status solve(std::size_t group, Block& block, GroupWork& work) const {
        const std::size_t first = group * width, count = (std::min)(width, goal.functions - first);
        for (auto& row : block.source) row.fill(0.0);
        fill(first, count, block.source);
        const CycleGoal here{count, goal.tolerance, goal.max_cycles};
        return run_cycles(multigrid, block, here, work, [] { return 0.0; });
    }
};
template <std::size_t D, class Fill>
MultigridGroups(const Multigrid<D>&, CycleGoal, Fill) -> MultigridGroups<D, Fill>;

} // namespace cageform::inline CAGEFORM_ABI::grid
