// A parallel_for on std::jthread for programs without a job system of their own.
#pragma once

#include <cageform/core/parallel.hpp>

#include <atomic>
#include <thread>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Starts its threads anew for each loop (some 20 µs each): meant for binding and for large figures.
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
        std::vector<std::jthread> pool;
        pool.reserve(workers - 1);
        for (std::size_t i = 1; i < workers; ++i) pool.emplace_back(work);
        work();
    }
};

} // namespace cageform::inline CAGEFORM_ABI
