// A parallel_for based on std::jthread, for programs without a job system. Needs a standard library
// with threads; for mingw-w64, the variant with the posix thread model.
#pragma once

#include <cageform/core/types/parallel_for.hpp>

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Starts new threads for each loop (about 20 µs each), so it suits binding and large figures.
/// Allocates memory, and so does a clone that uses it. If the system refuses a thread, the loop runs on
/// fewer threads. An exception of the body ends the loop and is rethrown on the calling thread.
struct ThreadedFor {
    unsigned threads = 0; ///< 0: one per hardware thread

    template <class Body>
    void operator()(std::size_t count, std::size_t grain, Body&& body) const {
        const std::size_t wanted = threads != 0 ? threads : std::thread::hardware_concurrency();
        if (grain == 0) grain = 1;
        const std::size_t pieces = (count + grain - 1) / grain;
        const std::size_t workers = pieces < wanted ? pieces : wanted;
        if (workers <= 1) return SerialFor{}(count, grain, body);

        std::atomic<std::size_t> next{0};
        const auto work = [&] {
            for (;;) {
                const std::size_t piece = next.fetch_add(1, std::memory_order_relaxed);
                if (piece >= pieces) return;
                const std::size_t begin = piece * grain;
                body(begin, begin + grain < count ? begin + grain : count);
            }
        };
#if defined(__cpp_exceptions)
        std::exception_ptr failure;
        std::mutex failure_access;
        const auto guarded = [&] {
            try {
                work();
            } catch (...) {
                next.store(pieces, std::memory_order_relaxed);
                const std::lock_guard lock(failure_access);
                if (!failure) failure = std::current_exception();
            }
        };
        {
            std::vector<std::jthread> pool;
            try {
                for (std::size_t i = 1; i < workers; ++i) pool.emplace_back(guarded);
            } catch (const std::exception&) { // the system is out of threads or memory
            }
            guarded();
        }
        if (failure) std::rethrow_exception(failure);
#else
        std::vector<std::jthread> pool;
        for (std::size_t i = 1; i < workers; ++i) pool.emplace_back(work);
        work();
#endif
    }
};

} // namespace cageform::inline CAGEFORM_ABI
