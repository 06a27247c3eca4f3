// Progress, termination and locking of groups that are solved on several threads.
#pragma once

#include <cageform/parallel/detail/in_parallel.hpp>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <mutex>

namespace cageform::inline CAGEFORM_ABI::detail {

#if defined(__STDCPP_THREADS__) && (!defined(__GLIBCXX__) || defined(_GLIBCXX_HAS_GTHREADS))
using Mutex = std::mutex;
#else
/// A spin lock for standard libraries without std::mutex: WebAssembly without threads, and mingw-w64 with
/// the win32 thread model, where a job system may still have threads. The guarded code takes well below a
/// microsecond.
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

/// Progress of groups that are solved on several threads. Construct it on the calling thread; only that
/// thread calls the caller's progress function.
class GroupProgress {
public:
    GroupProgress(const Progress& progress, std::size_t groups)
        : progress_(progress)
        , groups_(groups) {}

    bool stopped() const noexcept { return stopped_; }
    void stop() noexcept { stopped_ = true; } ///< stops every thread

    /// Reports the completed fraction of the current group. Returns false to stop.
    bool keep_going(double element) {
        if (this_thread() == caller_ && progress_ && !stopped_) {
            reported_ = (std::max)(reported_, (double(done_) + element) / double(groups_));
            if (!progress_(reported_)) stopped_ = true;
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
    double reported_ = 0;
};

/// Stops the other threads if this thread leaves by an exception.
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

} // namespace cageform::inline CAGEFORM_ABI::detail
