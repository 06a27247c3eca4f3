#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/core/types/parallel_for.hpp>
#include <cageform/parallel/threads.hpp>

#include <algorithm>
#include <chrono>
#include <limits>
#include <mutex>
#include <new>
#include <set>
#include <utility>
#include <vector>

namespace parallel_tests {

using cageform::SerialFor;
using cageform::ThreadedFor;
using cageform_tests::Random;

namespace {

using Range = std::pair<std::size_t, std::size_t>;

/// The ranges of a loop, in order, and the number of threads that ran them.
template <class Loop>
std::pair<std::vector<Range>, std::size_t> ranges_of(const Loop& loop, std::size_t count, std::size_t grain) {
    std::mutex mutex;
    std::vector<Range> ranges;
    std::set<std::thread::id> threads;
    loop(count, grain, [&](std::size_t begin, std::size_t end) {
        const std::lock_guard guard(mutex);
        ranges.emplace_back(begin, end);
        threads.insert(std::this_thread::get_id());
    });
    std::sort(ranges.begin(), ranges.end());
    return {ranges, threads.size()};
}

/// Whether the sorted ranges are not empty and partition the indices.
void check_cover(const std::vector<Range>& ranges, std::size_t count) {
    std::size_t next = 0;
    for (const auto& [begin, end] : ranges) {
        CHECK(begin == next);
        CHECK(end > begin);
        next = end;
    }
    CHECK(next == count);
}

/// Neither copied nor moved.
struct Counter {
    std::atomic<std::size_t> total{0};
    void operator()(std::size_t begin, std::size_t end) { total += end - begin; }
};

} // namespace

TEST_CASE("the serial loop makes one call", "[core][parallel]") {
    CHECK(ranges_of(SerialFor{}, 0, 1).first.empty());
    for (const std::size_t count : {1u, 2u, 1000u}) {
        for (const std::size_t grain : {0u, 1u, 7u, 5000u}) {
            CHECK(ranges_of(SerialFor{}, count, grain).first == std::vector<Range>{{0, count}});
        }
    }
}

TEST_CASE("the threaded loop covers every index once", "[core][parallel]") {
    for (const std::size_t count : {0u, 1u, 2u, 3u, 16u, 17u, 100u, 1001u}) {
        for (const std::size_t grain : {0u, 1u, 2u, 7u, 16u, 100u, 5000u}) {
            for (const unsigned threads : {0u, 1u, 2u, 3u, 8u}) {
                CAPTURE(count, grain, threads);
                const auto [ranges, used] = ranges_of(ThreadedFor{threads}, count, grain);
                check_cover(ranges, count);
                if (threads != 0) CHECK(used <= threads);
                if (ranges.size() > 1) {
                    // A piece has `grain` indices, the last one possibly fewer.
                    for (const auto& [begin, end] : ranges)
                        CHECK((end - begin == std::max<std::size_t>(grain, 1) || end == count));
                }
            }
        }
    }
}

TEST_CASE("the threaded loop covers every index of random loops once", "[core][parallel][property]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const std::size_t count = random.below(20000);
    const std::size_t grain = 1 + random.below(500);
    const unsigned threads = unsigned(1 + random.below(6));
    CAPTURE(count, grain, threads);
    std::vector<int> visits(count, 0);
    ThreadedFor{threads}(count, grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    CHECK(std::count(visits.begin(), visits.end(), 1) == std::ptrdiff_t(count));
}

TEST_CASE("the threaded loop uses at most the given threads", "[core][parallel]") {
    for (const unsigned threads : {1u, 2u, 3u}) {
        std::mutex mutex;
        std::set<std::thread::id> used;
        ThreadedFor{threads}(32, 1, [&](std::size_t, std::size_t) {
            {
                const std::lock_guard guard(mutex);
                used.insert(std::this_thread::get_id());
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1)); // leaves work for other threads
        });
        CHECK(used.size() <= threads);
    }
}

TEST_CASE("a grain larger than the count gives one piece", "[core][parallel]") {
    constexpr std::size_t most = std::numeric_limits<std::size_t>::max();
    for (const std::size_t grain : {most, most - 1, most / 2}) {
        CAPTURE(grain);
        CHECK(ranges_of(ThreadedFor{4}, 10, grain).first == std::vector<Range>{{0, 10}});
    }
}

TEST_CASE("a loop does not copy its body", "[core][parallel]") {
    Counter counter;
    SerialFor{}(100, 1, counter);
    ThreadedFor{3}(1000, 10, counter);
    CHECK(counter.total == 1100);
    ThreadedFor{3}(1000, 10, Counter{}); // a temporary
}

TEST_CASE("an exception in a threaded loop reaches the caller", "[core][parallel]") {
    const ThreadedFor loop{3};
    for (const std::size_t culprit : {0u, 57u, 99u}) {
        CAPTURE(culprit);
        CHECK_THROWS_AS(loop(100, 1,
                             [&](std::size_t begin, std::size_t) {
                                 if (begin == culprit) throw std::bad_alloc();
                             }),
                        std::bad_alloc);
    }
}

} // namespace parallel_tests
