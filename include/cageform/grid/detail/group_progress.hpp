// Progress of groups of functions that are solved on several threads.
#pragma once

#include <cageform/grid/evaluation.hpp>

#include <atomic>
#include <thread>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Made on the calling thread, which alone asks the caller's progress; every thread is told to stop when that says so.
class GroupProgress {
public:
    GroupProgress(const Progress& progress, std::size_t groups)
        : progress_(progress)
        , groups_(groups) {}

    bool cancelled() const noexcept { return cancelled_; }

    /// `part` of the group at hand is done; false when to stop.
    bool keep_going(double part) {
        if (std::this_thread::get_id() == caller_ && progress_ && !cancelled_) {
            told_ = std::max(told_, (double(done_) + part) / double(groups_));
            if (!progress_(told_)) cancelled_ = true;
        }
        return !cancelled_;
    }
    void end_group() {
        ++done_;
        (void)keep_going(0);
    }

private:
    const Progress& progress_;
    std::size_t groups_;
    std::thread::id caller_ = std::this_thread::get_id();
    std::atomic<std::size_t> done_{0};
    std::atomic<bool> cancelled_{false};
    double told_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
