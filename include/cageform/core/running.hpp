// Threads, progress and cancellation of long computations, which take a Running as their last
// argument, and the helpers that implement them.
#pragma once

#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/detail/parallel.hpp>
#include <cageform/core/status.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <functional>
// Uses POSIX's clock where available: <chrono> costs every file a quarter of a second to compile.
// On Windows, mingw-w64 has that clock in a separate library, which not every program links.
#if defined(CLOCK_MONOTONIC) && !defined(_WIN32)
#define CAGEFORM_DETAIL_POSIX_CLOCK
#else
#include <chrono>
#endif

namespace cageform::inline CAGEFORM_ABI {

/// The type of body(begin, end); see core/detail/parallel.hpp.
using RangeBody = std::function<void(std::size_t, std::size_t)>;
/// The type of parallel_for(count, grain, body); see core/detail/parallel.hpp.
using ParallelFor = std::function<void(std::size_t, std::size_t, const RangeBody&)>;
/// Called on the calling thread with the fraction done, in [0, 1] and never decreasing; returning
/// false cancels. A computation that ends with Status::ok has reported 1.
using Progress = std::function<bool(double)>;

/// How a computation runs. Its result does not depend on this, unless the progress callback
/// cancels.
struct Running {
    ParallelFor parallel = SerialFor{};
    Progress progress{};

    /// Returns a Running for a subtask: its progress from 0 to 1 is reported as `from` … `to`.
    /// Keeps a pointer to this object, which must outlive it.
    Running part(double from, double to) const {
        if (!progress) return {parallel, {}};
        return {parallel, [this, from, to](double done) { return progress(std::lerp(from, to, done)); }};
    }
    /// Reports progress; returns false if the computation should stop.
    bool keep_going(double done) const { return !progress || progress(done); }
    /// Returns the final status of a computation. If it is ok, reports progress 1, which may still
    /// cancel.
    Status end(Status status) const {
        return status == Status::ok && !keep_going(1) ? Status::cancelled : status;
    }
};

namespace detail {

/// Calls the caller's parallel_for, or the serial loop if none was given.
template <class Body>
void in_parallel(const Running& running, std::size_t count, std::size_t grain, const Body& body) {
    if (running.parallel) {
        running.parallel(count, grain, body);
    } else {
        SerialFor{}(count, grain, body);
    }
}

/// Runs body(first, last) over `blocks` (or pieces) in parallel. With a progress callback it takes
/// at most about fifty steps and reports after each. Returns Status::cancelled if the callback
/// cancels.
template <class Body>
Status for_each_block(std::size_t blocks, const Running& running, const Body& body) {
    constexpr std::size_t grain = 16;
    const std::size_t step = running.progress ? std::max<std::size_t>(blocks / 50, 16 * grain) : blocks;
    if (blocks == 0) return running.end(Status::ok);
    for (std::size_t begin = 0; begin < blocks; begin += step) {
        const std::size_t count = (std::min)(step, blocks - begin);
        in_parallel(running, count, grain, [&](std::size_t b, std::size_t e) { body(begin + b, begin + e); });
        if (!running.keep_going(double(begin + count) / double(blocks))) return Status::cancelled;
    }
    return Status::ok;
}

/// Returns wall time in seconds, from a monotonic clock whose origin stays fixed while the program
/// runs.
inline double seconds_now() noexcept {
#if defined(CAGEFORM_DETAIL_POSIX_CLOCK)
    ::timespec now{};
    (void)::clock_gettime(CLOCK_MONOTONIC, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
#else
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
#endif
}

/// Runs `f`, which returns a Status, under the memory guard and a stopwatch; stores both results in
/// `report`.
template <class Report, class F>
void run_into(Report& report, const F& f) {
    const double start = seconds_now();
    report.status = guard_memory(f);
    report.seconds = seconds_now() - start;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
