// A mutex, also for standard libraries without std::mutex.
#pragma once

#include <cageform/config.hpp>

#include <atomic>
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

} // namespace cageform::inline CAGEFORM_ABI::detail
