// Loops that run in parallel, with progress and cancellation, as a Running says.
#pragma once

#include <cageform/core/running.hpp>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Calls the caller's parallel_for, or the serial loop if none was given.
template <class Body>
void in_parallel(const Running& running, std::size_t count, std::size_t grain, const Body& body) {
    if (running.parallel) {
        running.parallel(count, grain, body);
    } else {
        SerialFor{}(count, grain, body);
    }
}

/// Divides [0, count) into runs, whose lengths do not depend on the threads, and returns what was made for
/// each run, in order.
///
///   least    the shortest run, but for the last; runs are longer if there would be more than 64
///   work_of  work_of(): a work; work(begin, end, part) fills the part of a run. The loop makes
///            one work for all runs that it calls together
template <class Part, class WorkOf>
std::vector<Part> in_runs(const Running& running, std::size_t count, std::size_t least,
                          const WorkOf& work_of) {
    const std::size_t run = (std::max)(least, (count + 63) / 64);
    std::vector<Part> parts((count + run - 1) / run);
    in_parallel(running, parts.size(), 1, [&](std::size_t first, std::size_t last) {
        auto work = work_of();
        for (std::size_t n = first; n < last; ++n) work(n * run, (std::min)((n + 1) * run, count), parts[n]);
    });
    return parts;
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

} // namespace cageform::inline CAGEFORM_ABI::detail
