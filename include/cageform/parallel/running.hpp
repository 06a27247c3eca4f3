// Threads, progress and cancellation of long computations, which take a Running as their last
// argument.
#pragma once

#include <cageform/core/status.hpp>
#include <cageform/core/types/parallel_for.hpp>

#include <cmath>
#include <cstddef>
#include <functional>

namespace cageform::inline CAGEFORM_ABI {

/// The type of body(begin, end); see core/types/parallel_for.hpp.
using RangeBody = std::function<void(std::size_t, std::size_t)>;
/// The type of parallel_for(count, grain, body); see core/types/parallel_for.hpp.
using ParallelFor = std::function<void(std::size_t, std::size_t, const RangeBody&)>;
/// Called on the calling thread with the fraction done, in [0, 1] and never decreasing; returning
/// false cancels. It must not throw. A computation that ends with Status::ok has reported 1.
using Progress = std::function<bool(double)>;

/// How a computation runs. Its result does not depend on this, unless the progress callback
/// cancels.
struct Running {
    ParallelFor parallel = SerialFor{};
    Progress progress{};

    /// Returns a Running for a subtask: its progress from 0 to 1 is reported as `from` … `to`.
    /// Keeps a pointer to this object, which must outlive it.
    Running subtask(double from, double to) const {
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

} // namespace cageform::inline CAGEFORM_ABI
