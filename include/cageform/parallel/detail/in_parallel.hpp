// Parallel loops with progress and cancellation.
#pragma once

#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/parallel/running.hpp>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns an address that is unique to the calling thread.
inline const void* this_thread() noexcept {
    static thread_local char position;
    return &position;
}

/// Calls `running.parallel`, or a serial loop if it is empty.
template <class Body>
void in_parallel(const Running& running, std::size_t count, std::size_t grain, const Body& body) {
    if (running.parallel) {
        running.parallel(count, grain, body);
    } else {
        SerialFor{}(count, grain, body);
    }
}

/// Reports progress in functions that return no Status. Throws Cancelled if the callback cancels;
/// without exceptions it does nothing.
inline void report_progress([[maybe_unused]] const Running& running, [[maybe_unused]] double done) {
#if defined(__cpp_exceptions)
    if (!running.keep_going(done)) throw Cancelled{};
#endif
}

/// Divides [0, count) into runs whose lengths do not depend on the number of threads. Returns the result of
/// each run, in order.
///
///  least    the length of a run; it is larger if there would be more than 256 runs
///  work_of  work_of() returns a function object: work(begin, end, part) writes the result of a run
///           to `part`. Each call of the loop's body makes one object for all of its runs
///  fails    throws Cancelled if the progress callback cancels. The calling thread calls the callback after
///           each of its own runs. Without exceptions, cancellation is ignored
template <class Part, class WorkOf>
std::vector<Part> in_runs(const Running& running, std::size_t count, std::size_t least,
                          const WorkOf& work_of) {
    const std::size_t run = (std::max)(least, (count + 255) / 256);
    std::vector<Part> parts((count + run - 1) / run);
    std::atomic<std::size_t> done{0};
    std::atomic<bool> stopped{false};
    const void* const caller = this_thread();
#if defined(__cpp_exceptions)
    constexpr bool throws = true;
#else
    constexpr bool throws = false;
#endif
    in_parallel(running, parts.size(), 1, [&](std::size_t first, std::size_t last) {
        auto work = work_of();
        for (std::size_t n = first; n < last && !stopped; ++n) {
            work(n * run, (std::min)((n + 1) * run, count), parts[n]);
            const double share = double(++done) / double(parts.size());
            if (this_thread() == caller && throws && !running.keep_going(share)) stopped = true;
        }
    });
#if defined(__cpp_exceptions)
    if (stopped || !running.keep_going(1)) throw Cancelled{};
#endif
    return parts;
}

/// Runs body(first, last) over `blocks` in parallel. With a progress callback, it runs in steps of about a
/// quarter of a second and reports after each. Returns Status::cancelled if the callback cancels.
template <class Body>
Status for_each_block(std::size_t blocks, const Running& running, const Body& body) {
    constexpr std::size_t grain = 16;
    constexpr double long_step = 0.25; // seconds
    std::size_t step = running.progress ? 4 * grain : blocks;
    if (blocks == 0) return running.end(Status::ok);
    for (std::size_t begin = 0, count = 0; begin < blocks; begin += count) {
        const double start = seconds_now();
        count = (std::min)(step, blocks - begin);
        const std::size_t piece = std::clamp<std::size_t>(count / grain, 1, grain); // work for many threads
        in_parallel(running, count, piece, [&](std::size_t b, std::size_t e) { body(begin + b, begin + e); });
        if (!running.keep_going(double(begin + count) / double(blocks))) return Status::cancelled;
        const double taken = seconds_now() - start;
        if (taken > long_step)
            step = (std::max)(grain, step / 2);
        else if (taken < 0.5 * long_step)
            step = 2 * step;
    }
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
