// Threads without a group of their own help to solve the groups of others.
//
// The number of threads of a caller's parallel_for is unknown, and so is whether they run at the same time.
// Work must therefore never wait for a thread that has not started. The owner of a group offers pieces of a
// pass to threads that are idle at that moment. The owner itself processes the pieces that no other thread
// has begun.
#pragma once

#include <cageform/core/detail/flush_denormals.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#if defined(__STDCPP_THREADS__)
#include <thread>
#endif

namespace cageform::inline CAGEFORM_ABI::detail {

/// Waits briefly. Spins first, because most waits are short, and yields the processor later.
class Waiting {
public:
    void reset() noexcept { spins_ = 0; }
    void wait() noexcept {
        constexpr unsigned short_spins = 2000;
        if (spins_ < short_spins) {
            ++spins_;
#if defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
            __builtin_ia32_pause();
#elif defined(__GNUC__) && defined(__aarch64__)
            __asm__ volatile("yield");
#endif
            return;
        }
#if defined(__STDCPP_THREADS__)
        std::this_thread::yield();
#endif
    }

private:
    unsigned spins_ = 0;
};

/// The threads of one solve.
class HelpingThreads {
    /// The pieces of one pass, begun in order.
    struct Job {
        void (*call)(const void* body, std::size_t chunk, std::size_t chunks) noexcept;
        const void* body;
        std::size_t chunks;
        std::atomic<std::size_t> next{0};
    };
    /// A slot for an owner's job.
    struct Offer {
        std::atomic<bool> in_use{false}; ///< whether an owner has this slot
        std::atomic<bool> open{false};   ///< whether pieces may be left
        std::atomic<Job*> job{nullptr};
        std::atomic<unsigned> inside{0}; ///< number of threads that may access the job

        bool work() noexcept {
            if (!open.load(std::memory_order_relaxed)) return false;
            ++inside;
            Job* const offered = job.load();
            const bool any = offered != nullptr && work_on(*offered);
            --inside;
            return any;
        }
        bool work_on(Job& offered) noexcept {
            bool any = false;
            for (;;) {
                const std::size_t chunk = offered.next++;
                if (chunk + 1 >= offered.chunks) open.store(false, std::memory_order_relaxed);
                if (chunk >= offered.chunks) return any;
                offered.call(offered.body, chunk, offered.chunks);
                any = true;
            }
        }
    };

public:
    /// Distributes the work of a group to threads. A default-constructed Share uses only the calling thread.
    class Share {
    public:
        Share() noexcept = default;

        /// Calls body(chunk, chunks) for every piece, begun in order, on this thread and on idle ones. There
        /// is one piece per thread, at most `most`. body must not throw and may wait for earlier pieces.
        template <class Body>
        void split(std::size_t most, const Body& body) const noexcept {
            const std::size_t others = threads_ != nullptr && most > 1 ? threads_->reserve(most - 1) : 0;
            if (others == 0) return body(std::size_t{0}, std::size_t{1});
            Job job{[](const void* b, std::size_t chunk, std::size_t chunks) noexcept {
                        (*static_cast<const Body*>(b))(chunk, chunks);
                    },
                    &body, others + 1};
            offer_->job.store(&job);
            offer_->open.store(true);
            (void)offer_->work_on(job);
            offer_->job.store(nullptr);
            for (Waiting waiting; offer_->inside.load() != 0;) waiting.wait();
            threads_->idle_ += int(others);
        }
        /// Calls body(begin, end) for ranges that cover [0, count) exactly once, each of about `grain` or
        /// more.
        template <class Body>
        void for_ranges(std::size_t count, std::size_t grain, const Body& body) const noexcept {
            split(std::clamp<std::size_t>(count / grain, 1, 16), [&](std::size_t chunk, std::size_t chunks) {
                body(count * chunk / chunks, count * (chunk + 1) / chunks);
            });
        }

    private:
        friend HelpingThreads;
        HelpingThreads* threads_ = nullptr;
        Offer* offer_ = nullptr;
    };

    /// Marks its thread as solving groups, so that other threads may help.
    class Owner {
    public:
        explicit Owner(HelpingThreads& threads) noexcept
            : threads_(threads) {
            ++threads.owners_;
            for (Offer& offer : threads.offers_) {
                if (offer.in_use.exchange(true)) continue;
                share_.threads_ = &threads;
                share_.offer_ = &offer;
                return;
            }
        }
        Owner(const Owner&) = delete;
        Owner& operator=(const Owner&) = delete;
        ~Owner() {
            if (share_.offer_ != nullptr) share_.offer_->in_use = false;
            --threads_.owners_;
        }
        const Share& share() const noexcept { return share_; }

    private:
        HelpingThreads& threads_;
        Share share_;
    };

    /// Helps until no thread owns a group.
    void help() noexcept {
        const FlushDenormals flush;
        ++helping_;
        ++idle_;
        for (Waiting waiting; owners_.load() != 0;) {
            bool worked = false;
            for (Offer& offer : offers_) worked = offer.work() || worked;
            if (worked) waiting.reset();
            waiting.wait();
        }
        --idle_;
        --helping_;
    }

private:
    /// Reserves idle threads: an owner's fair share, at most `wanted`. The caller must release them.
    std::size_t reserve(std::size_t wanted) noexcept {
        const int owners = (std::max)(owners_.load(), 1), fair = (helping_.load() + owners - 1) / owners;
        const int most = (std::min)(fair, int(wanted));
        for (int idle = idle_.load(); idle > 0 && most > 0;) {
            const int reserved = (std::min)(idle, most);
            if (idle_.compare_exchange_weak(idle, idle - reserved)) return std::size_t(reserved);
        }
        return 0;
    }

    std::array<Offer, 16> offers_; ///< more owners than this get no help
    std::atomic<int> owners_{0}, helping_{0}, idle_{0};
};

using WorkShare = HelpingThreads::Share;

/// Returns solver.helpers(), or 0 without such a function.
template <class S>
std::size_t helpers_of(const S& solver) noexcept {
    if constexpr (requires { solver.helpers(); }) return solver.helpers();
    return 0;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
