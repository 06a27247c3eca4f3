// Threads that have no group left to solve help those that have one.
//
// Nobody knows how many threads a caller's parallel_for has, nor whether they run together. So no
// part of the work waits for a thread that has yet to come: who owns a group offers parts of a pass
// to threads that are free at that moment, and takes itself what none has begun.
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

/// Waits a moment: at first without leaving the processor, for most waits are short.
class Waiting {
public:
    void reset() noexcept { turns_ = 0; }
    void wait() noexcept {
        constexpr unsigned short_turns = 2000;
        if (turns_ < short_turns) {
            ++turns_;
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
    unsigned turns_ = 0;
};

/// The threads of one solve.
class HelpingThreads {
    /// Parts of one pass, begun in order.
    struct Job {
        void (*call)(const void* body, std::size_t part, std::size_t parts) noexcept;
        const void* body;
        std::size_t parts;
        std::atomic<std::size_t> next{0};
    };
    /// Where an owner offers a job.
    struct Offer {
        std::atomic<bool> taken{false}; ///< by an owner
        std::atomic<bool> open{false};  ///< parts are left, or were a moment ago
        std::atomic<Job*> job{nullptr};
        std::atomic<unsigned> inside{0}; ///< threads that may look at the job

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
                const std::size_t part = offered.next++;
                if (part + 1 >= offered.parts) open.store(false, std::memory_order_relaxed);
                if (part >= offered.parts) return any;
                offered.call(offered.body, part, offered.parts);
                any = true;
            }
        }
    };

public:
    /// What the owner of a group shares its work by; one made without threads shares with none.
    class Share {
    public:
        Share() noexcept = default;

        /// body(part, parts) for every part, begun in order, on this thread and those that are free;
        /// as many as these, `most` at most. It must not throw, and may wait for parts before it.
        template <class Body>
        void split(std::size_t most, const Body& body) const noexcept {
            const std::size_t others = threads_ != nullptr && most > 1 ? threads_->reserve(most - 1) : 0;
            if (others == 0) return body(std::size_t{0}, std::size_t{1});
            Job job{[](const void* b, std::size_t part, std::size_t parts) noexcept {
                        (*static_cast<const Body*>(b))(part, parts);
                    },
                    &body, others + 1};
            offer_->job.store(&job);
            offer_->open.store(true);
            (void)offer_->work_on(job);
            offer_->job.store(nullptr);
            for (Waiting waiting; offer_->inside.load() != 0;) waiting.wait();
            threads_->idle_ += int(others);
        }
        /// body(begin, end) for ranges that cover [0, count) once; few of them where that is small.
        template <class Body>
        void for_ranges(std::size_t count, std::size_t grain, const Body& body) const noexcept {
            split(std::clamp<std::size_t>(count / grain, 1, 16), [&](std::size_t part, std::size_t parts) {
                body(count * part / parts, count * (part + 1) / parts);
            });
        }

    private:
        friend HelpingThreads;
        HelpingThreads* threads_ = nullptr;
        Offer* offer_ = nullptr;
    };

    /// While it lives its thread solves groups, and may be helped.
    class Owner {
    public:
        explicit Owner(HelpingThreads& threads) noexcept
            : threads_(threads) {
            ++threads.owners_;
            for (Offer& offer : threads.offers_) {
                if (offer.taken.exchange(true)) continue;
                share_.threads_ = &threads;
                share_.offer_ = &offer;
                return;
            }
        }
        Owner(const Owner&) = delete;
        Owner& operator=(const Owner&) = delete;
        ~Owner() {
            if (share_.offer_ != nullptr) share_.offer_->taken = false;
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
    /// Of the idle threads an owner's fair part, `wanted` at most; who has them gives them back.
    std::size_t reserve(std::size_t wanted) noexcept {
        const int owners = (std::max)(owners_.load(), 1), fair = (helping_.load() + owners - 1) / owners;
        const int most = (std::min)(fair, int(wanted));
        for (int idle = idle_.load(); idle > 0 && most > 0;) {
            const int taken = (std::min)(idle, most);
            if (idle_.compare_exchange_weak(idle, idle - taken)) return std::size_t(taken);
        }
        return 0;
    }

    std::array<Offer, 16> offers_; ///< owners beyond these are not helped
    std::atomic<int> owners_{0}, helping_{0}, idle_{0};
};

using WorkShare = HelpingThreads::Share;

} // namespace cageform::inline CAGEFORM_ABI::detail
