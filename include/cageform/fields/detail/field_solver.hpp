// Solves for the values of many fields at the nodes of a lattice.
#pragma once

#include <cageform/grid/multigrid/groups.hpp>

#include <cmath>
#include <limits>
#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The range of a field's given values. It is mapped to [−1, 1] for the solve.
class FieldRange {
public:
    void add(double value) noexcept {
        low_ = std::fmin(low_, value);
        high_ = std::fmax(high_, value);
    }
    double middle() const noexcept { return 0.5 * low_ + 0.5 * high_; }
    double half() const noexcept { return 0.5 * high_ - 0.5 * low_; }

private:
    double low_ = (std::numeric_limits<double>::max)(), high_ = -low_;
};

/// Fields on a lattice with their data.
template <std::size_t D, class Given>
struct FieldProblem {
    const grid::NodeRuns<D>& nodes;
    std::span<const grid::CutLink> cuts; ///< the links that end at data; a link of weight 0 ends at no data
    std::span<const FieldRange> ranges;  ///< #fields
    const Given& given;                  ///< given(cut, field) returns the data at the end of a cut link
};
template <std::size_t D, class Given>
FieldProblem(const grid::NodeRuns<D>&, std::span<const grid::CutLink>, std::span<const FieldRange>,
             const Given&) -> FieldProblem<D, Given>;

/// Solves for the nodes of all fields.
///
///   options  tolerance, relative to a field's range, and max_cycles
///   solved   out: #fields · #nodes, field after field
template <std::size_t D, Scalar T, class Given, class Options>
Status solve_fields(const FieldProblem<D, Given>& problem, const Options& options, std::span<T> solved,
                    SolverReport& report, const Running& running) {
    const auto& nodes = problem.nodes;
    const auto cuts = problem.cuts;
    const auto ranges = problem.ranges;
    const grid::Multigrid<D> multigrid(nodes, cuts, {}, running);
    report.bytes = multigrid.bytes() + multigrid.block_bytes();
    const auto slots = multigrid.source_slots();
    const auto fill = [&](std::size_t first, std::size_t count, auto& source) {
        for (std::size_t k = 0; k < count; ++k) {
            const double middle = ranges[first + k].middle(), half = ranges[first + k].half();
            for (std::size_t c = 0; c < cuts.size() && half > 0; ++c) {
                if (cuts[c].weight > 0)
                    source[slots[cuts[c].node]][k] +=
                        cuts[c].weight * ((problem.given(c, first + k) - middle) / half);
            }
        }
    };
    const auto take = [&](std::size_t group, const auto& block) {
        const std::size_t first = group * multigrid.width;
        for (std::uint32_t node = 0; node < nodes.count(); ++node) {
            const auto values = block.value(node);
            for (std::size_t k = 0; k < (std::min)(multigrid.width, ranges.size() - first); ++k)
                solved[(first + k) * nodes.count() + node] =
                    static_cast<T>(ranges[first + k].middle() + ranges[first + k].half() * values[k]);
        }
    };
    // Errors refer to values in [−1, 1], whose range is 2.
    const grid::CycleGoal goal{ranges.size(), 2 * options.tolerance, options.max_cycles};
    const Status status =
        grid::solve_groups(grid::MultigridGroups{multigrid, goal, fill}, report, take, running);
    report.multigrid.error_estimate *= 0.5;
    report.multigrid.error_bound *= 0.5;
    return status;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
