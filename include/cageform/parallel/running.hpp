// Threads, progress and cancellation of long computations. Such functions take a Running as their last
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
/// Called on the calling thread with the completed fraction, in [0, 1] and never decreasing. Return
/// false to cancel. Must not throw. A computation that returns Status::ok has reported 1.
using Progress = std::function<bool(double)>;

/// Options of a long computation. They do not affect its result, unless the progress callback cancels.
struct Running {
    ParallelFor parallel = SerialFor{};
    Progress progress{};

    /// Returns a Running for a subtask whose progress 0 … 1 is reported as `from` … `to`. The result
    /// refers to this object, which must outlive it.
    Running subtask(double from, double to) const {
        if (!progress) return {parallel, {}};
        return {parallel, [this, from, to](double done) { return progress(std::lerp(from, to, done)); }};
    }
    /// Reports progress; returns false if the computation must stop.
    bool keep_going(double done) const { return !progress || progress(done); }
    /// Returns the final status of a computation. For Status::ok, it first reports progress 1, which
    /// may still cancel.
    Status end(Status status) const {
        return status == Status::ok && !keep_going(1) ? Status::cancelled : status;
    }
};

} // namespace cageform::inline CAGEFORM_ABI
