// The driver of all solvers: solves functions in groups on the caller's threads, with progress,
// cancellation and a report.
#pragma once

#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/grid/detail/group_progress.hpp>
#include <cageform/grid/multigrid/helping_threads.hpp>
#include <cageform/grid/types/solver_report.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <atomic>
#include <concepts>
#include <mutex>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::grid {

/// The context of a solve of one group.
struct GroupWork {
    detail::GroupProgress& progress;
    detail::WorkShare share{}; ///< distributes work within the group to threads
    SolverReport report{};     ///< out: the work done for this group

    /// Reports the completed fraction of the group, in [0, 1]. Returns false to stop.
    bool keep_going(double done) const { return progress.keep_going(done); }
};

/// A solver of independent groups of functions.
///
///   Block                      the memory of one group's solve; made once per thread and reused
///   make_block()               makes a Block
///   groups()                   the number of groups
///   solve(group, block, work)  solves the functions of a group and calls work.keep_going() regularly.
///                              Returns ok, not_converged, or cancelled if keep_going returned false
///   helpers()                  optional: how many additional threads are useful for one group
template <class S>
concept GroupSolver =
    requires(const S& solver, typename S::Block& block, std::size_t group, GroupWork& work) {
        { solver.groups() } -> std::convertible_to<std::size_t>;
        { solver.make_block() } -> std::same_as<typename S::Block>;
        { solver.solve(group, block, work) } -> std::same_as<Status>;
    };

/// Solves all groups and passes each to take(group, block) on the thread that solved it.
///
///   report   out: adds the work of each group
///   running  its progress function is called on the calling thread, which must take part in the work. Its
///            parallel_for distributes the groups; idle threads help within groups. Results do not depend on
///            the number of threads
///   fails    cancelled, or the status of the first group that fails, which ends the solve
template <GroupSolver S, class Take>
Status solve_groups(const S& solver, SolverReport& report, const Take& take, const Running& running = {}) {
    using Block = typename S::Block;
    const double start = detail::seconds_now();
    detail::GroupProgress progress(running.progress, solver.groups());
    Status status = Status::ok;
    std::vector<Block> spare; // at most one per concurrent thread
    detail::Mutex access;     // guards `status`, `spare` and the report
    const auto borrow_block = [&]() -> Block {
        {
            const std::lock_guard lock(access);
            if (!spare.empty()) {
                Block block = std::move(spare.back());
                spare.pop_back();
                return block;
            }
        }
        return solver.make_block();
    };
    detail::HelpingThreads threads;
    std::atomic<std::size_t> next{0};
    const auto solve_group = [&](std::size_t group, Block& block, const detail::WorkShare& share) {
        GroupWork work{progress, share};
        Status outcome = solver.solve(group, block, work);
        if (outcome == Status::ok) {
            take(group, block);
            if (!progress.end_group()) outcome = Status::cancelled;
        }
        const std::lock_guard lock(access);
        report.add(work.report);
        if (outcome == Status::ok) return;
        if (status == Status::ok) status = outcome;
        progress.stop();
    };
    detail::in_parallel(running, solver.groups() * (1 + detail::helpers_of(solver)), 1,
                        [&](std::size_t, std::size_t) {
                            {
                                const detail::HelpingThreads::Owner owner(threads);
                                std::size_t group = progress.stopped() ? solver.groups() : next++;
                                if (group < solver.groups()) {
                                    detail::StopUnlessDone stop(progress); // in case a solve throws
                                    Block block = borrow_block();
                                    for (; group < solver.groups() && !progress.stopped(); group = next++)
                                        solve_group(group, block, owner.share());
                                    stop.done = true;
                                    const std::lock_guard lock(access);
                                    spare.push_back(std::move(block));
                                }
                            }
                            threads.help();
                        });
    report.seconds += detail::seconds_now() - start;
    return running.end(status);
}

} // namespace cageform::inline CAGEFORM_ABI::grid
