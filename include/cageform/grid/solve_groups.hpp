// Drives all solvers: solves functions in groups, on the caller's threads, with progress,
// cancellation and a report.
#pragma once

#include <cageform/core/detail/in_parallel.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/core/types/solver_report.hpp>
#include <cageform/grid/multigrid/helping_threads.hpp>

#include <atomic>
#include <concepts>
#include <mutex>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

#if defined(__STDCPP_THREADS__) && (!defined(__GLIBCXX__) || defined(_GLIBCXX_HAS_GTHREADS))
using Mutex = std::mutex;
#else
/// A spin lock for standard libraries without std::mutex: WebAssembly without threads, and
/// mingw-w64 with the win32 thread model, where a job system may still have threads. The guarded
/// code takes well below a microsecond.
class Mutex {
public:
    void lock() noexcept {
        while (taken_.test_and_set(std::memory_order_acquire)) {}
    }
    void unlock() noexcept { taken_.clear(std::memory_order_release); }

private:
    std::atomic_flag taken_;
};
#endif

/// Returns an address that differs for every thread.
inline const void* this_thread() noexcept {
    static thread_local char place;
    return &place;
}

/// The progress of groups that are solved on several threads. Construct it on the calling thread;
/// only that thread calls the caller's progress function.
class GroupProgress {
public:
    GroupProgress(const Progress& progress, std::size_t groups)
        : progress_(progress)
        , groups_(groups) {}

    bool stopped() const noexcept { return stopped_; }
    void stop() noexcept { stopped_ = true; } ///< stops every thread

    /// Reports that the fraction `part` of the current group is done. Returns false to stop.
    bool keep_going(double part) {
        if (this_thread() == caller_ && progress_ && !stopped_) {
            told_ = (std::max)(told_, (double(done_) + part) / double(groups_));
            if (!progress_(told_)) stopped_ = true;
        }
        return !stopped_;
    }
    bool end_group() {
        ++done_;
        return keep_going(0);
    }

private:
    const Progress& progress_;
    std::size_t groups_;
    const void* caller_ = this_thread();
    std::atomic<std::size_t> done_{0};
    std::atomic<bool> stopped_{false};
    double told_ = 0;
};

/// Stops the other threads if this one leaves by an exception.
struct StopUnlessDone {
    explicit StopUnlessDone(GroupProgress& all) noexcept
        : progress(all) {}
    StopUnlessDone(const StopUnlessDone&) = delete;
    StopUnlessDone& operator=(const StopUnlessDone&) = delete;
    ~StopUnlessDone() {
        if (!done) progress.stop();
    }
    GroupProgress& progress;
    bool done = false;
};

/// Returns solver.helpers(), or 0 if the solver has no such function.
template <class S>
std::size_t helpers_of(const S& solver) noexcept {
    if constexpr (requires { solver.helpers(); }) return solver.helpers();
    return 0;
}

} // namespace detail
namespace grid {

/// Passed to a solver with each group of functions.
struct GroupWork {
    detail::GroupProgress& progress;
    detail::WorkShare share{}; ///< divides the work within the group among threads
    SolverReport report{};     ///< out: the work done for this group

    /// Reports that the fraction `part` of the group, in [0, 1], is done. Returns false to stop.
    bool keep_going(double part) const { return progress.keep_going(part); }
};

/// A solver that solve_groups can drive. It solves functions in groups that are independent of each
/// other.
///
///   Block                      the memory that a group is solved in; made once a thread and reused
///   make_block()               makes such memory
///   groups()                   the number of groups
///   solve(group, block, work)  solves the functions of a group. Calls work.keep_going() now and
///                              then. Returns ok, not_converged, or cancelled if keep_going says so
///   helpers()                  optional: how many additional threads are useful for one group
template <class S>
concept GroupSolver = requires(const S& solver, typename S::Block& block, std::size_t group,
                               GroupWork& work) {
    { solver.groups() } -> std::convertible_to<std::size_t>;
    { solver.make_block() } -> std::same_as<typename S::Block>;
    { solver.solve(group, block, work) } -> std::same_as<Status>;
};

/// Solves all groups and passes each to take(group, block), on the thread that solved it.
///
///   report   out: the work done for each group is added
///   running  its progress is called on the calling thread, which must take part in the work. Its
///            parallel_for distributes the groups; threads left over help within groups. No result
///            depends on the threads
///   fails    cancelled, or the failure of the first group that fails, which ends the solve
template <GroupSolver S, class Take>
Status solve_groups(const S& solver, SolverReport& report, const Take& take, const Running& running = {}) {
    using Block = typename S::Block;
    const double start = detail::seconds_now();
    detail::GroupProgress progress(running.progress, solver.groups());
    Status status = Status::ok;
    std::vector<Block> spare; // at most as many as threads that run at the same time
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

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
