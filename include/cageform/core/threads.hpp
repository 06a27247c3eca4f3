// A parallel_for on std::jthread for programs without a job system of their own. It needs a standard
// library with threads: of the two of mingw-w64, the one whose thread model is posix.
#pragma once

#include <cageform/core/parallel.hpp>

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Starts its threads anew for each loop (some 20 µs each): meant for binding and for large
/// figures. It allocates, so a clone with it does too. Where the system refuses a thread the loop
/// runs on those it has; an exception of the body ends the loop and is thrown again on the calling
/// thread.
struct ThreadedFor {
    unsigned threads = 0; ///< 0: as many as the machine has

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
            } catch (const std::exception&) { // too few threads or too little memory for more
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
