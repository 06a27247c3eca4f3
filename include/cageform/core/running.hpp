// What every computation that may take long is told, always as its last argument: threads,
// progress, cancel. And what all of them do with it.
#pragma once

#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/parallel.hpp>
#include <cageform/core/status.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <functional>
// POSIX's clock, where it is: <chrono> costs every file a quarter of a second to compile. On Windows
// mingw-w64 has that clock in a library of its own, which not every program links.
#if defined(CLOCK_MONOTONIC) && !defined(_WIN32)
#define CAGEFORM_DETAIL_POSIX_CLOCK
#else
#include <chrono>
#endif

namespace cageform::inline CAGEFORM_ABI {

/// body(begin, end); see core/parallel.hpp.
using RangeBody = std::function<void(std::size_t, std::size_t)>;
/// parallel_for(count, grain, body); see core/parallel.hpp.
using ParallelFor = std::function<void(std::size_t, std::size_t, const RangeBody&)>;
/// Called on the calling thread with the fraction done, in [0, 1] and never falling; false cancels. What ends
/// with Status::ok has told 1.
using Progress = std::function<bool(double)>;

/// How a computation runs. Its result does not depend on it, unless the progress cancels.
struct Running {
    ParallelFor parallel = SerialFor{};
    Progress progress{};

    /// For a part of the work: its progress from 0 to 1 is that of the whole `from` … `to`. Points
    /// to this, which has to outlive it.
    Running part(double from, double to) const {
        if (!progress) return {parallel, {}};
        return {parallel, [this, from, to](double done) { return progress(std::lerp(from, to, done)); }};
    }
    /// Tells the progress; false when to stop.
    bool keep_going(double done) const { return !progress || progress(done); }
    /// The status of a computation at its end: where it is ok the progress is told 1, and may still cancel.
    Status end(Status status) const {
        return status == Status::ok && !keep_going(1) ? Status::cancelled : status;
    }
};

namespace detail {

/// The caller's parallel_for; one left empty is the serial one.
template <class Body>
void in_parallel(const Running& running, std::size_t count, std::size_t grain, const Body& body) {
    if (running.parallel) {
        running.parallel(count, grain, body);
    } else {
        SerialFor{}(count, grain, body);
    }
}

/// Runs body(first, last) over `blocks` (or pieces) in parallel, in at most fifty steps between
/// which the caller's progress is told. Returns Status::cancelled when it says so.
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

/// Wall time, not processor time, in seconds from an origin that stays while the program runs: of a clock
/// that nobody sets.
inline double seconds_now() noexcept {
#if defined(CAGEFORM_DETAIL_POSIX_CLOCK)
    ::timespec now{};
    (void)::clock_gettime(CLOCK_MONOTONIC, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
#else
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
#endif
}

/// Runs `f`, which returns a Status, under the memory guard and a stopwatch; both go into `report`.
template <class Report, class F>
void run_into(Report& report, const F& f) {
    const double start = seconds_now();
    report.status = guard_memory(f);
    report.seconds = seconds_now() - start;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
