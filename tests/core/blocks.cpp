#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/core/types/blocks.hpp>
#include <cageform/core/types/buffer.hpp>

#include <type_traits>
#include <vector>

namespace blocks_tests {

using cageform::block_count;
using cageform::block_point;
using cageform::BlockView;
using cageform::lane_count;
using cageform::Lanes;
using cageform::Vec;
using cageform_tests::Random;

TEMPLATE_TEST_CASE("a row of a block is one cache line", "[core][blocks]", CAGEFORM_SCALARS) {
    STATIC_REQUIRE(lane_count<TestType> * sizeof(TestType) == 64);
    STATIC_REQUIRE(sizeof(Lanes<TestType>) == 64);
    STATIC_REQUIRE(alignof(Lanes<TestType>) == 64);
    STATIC_REQUIRE(std::is_trivially_copyable_v<Lanes<TestType>>);
    STATIC_REQUIRE(std::is_nothrow_default_constructible_v<Lanes<TestType>>);
    const std::vector<Lanes<TestType>> rows(3);
    CHECK(reinterpret_cast<std::uintptr_t>(rows.data()) % 64 == 0);
}

TEMPLATE_TEST_CASE("blocks hold all points, and the last one is not empty", "[core][blocks]",
                   CAGEFORM_SCALARS) {
    constexpr std::size_t lanes = lane_count<TestType>;
    STATIC_REQUIRE(block_count<TestType>(0) == 0);
    for (std::size_t points = 1; points < 5 * lanes; ++points) {
        CAPTURE(points);
        const std::size_t blocks = block_count<TestType>(points);
        CHECK(blocks * lanes >= points);
        CHECK((blocks - 1) * lanes < points);
    }
}

TEMPLATE_TEST_CASE("the rows of a block are contiguous in a block view", "[core][blocks][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(30));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    constexpr std::size_t lanes = lane_count<TestType>;
    const std::size_t points = random.below(4 * lanes + 1);
    const std::size_t rows = 1 + random.below(5);
    std::vector<Lanes<TestType>> memory(block_count<TestType>(points) * rows);
    for (auto& row : memory) {
        for (std::size_t lane = 0; lane < lanes; ++lane) row[lane] = TestType(-1);
    }
    const BlockView<TestType> view{memory.data(), rows, points};
    REQUIRE(view.blocks() == block_count<TestType>(points));
    REQUIRE(view.lanes == lanes);
    for (std::size_t i = 0; i < points; ++i) {
        for (std::size_t row = 0; row < rows; ++row) view(i, row) = TestType(i * rows + row);
    }
    // The reference: walks the memory in order.
    std::size_t untouched = 0;
    for (std::size_t block = 0; block < view.blocks(); ++block) {
        for (std::size_t row = 0; row < rows; ++row) {
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const std::size_t i = block * lanes + lane;
                const TestType x = memory[block * rows + row][lane];
                CHECK(x == (i < points ? TestType(i * rows + row) : TestType(-1)));
                CHECK(view.block(block)[row][lane] == x);
                untouched += x == TestType(-1);
            }
        }
    }
    CHECK(untouched == (view.blocks() * lanes - points) * rows);

    const BlockView<const TestType> reads = view;
    for (std::size_t i = 0; i < points; ++i) CHECK(&reads(i, rows - 1) == &view(i, rows - 1));
    CHECK((reads.rows == rows && reads.points == points && reads.blocks() == view.blocks()));
}

TEMPLATE_TEST_CASE("block_point gathers the axes", "[core][blocks]", CAGEFORM_SCALARS) {
    constexpr std::size_t points = lane_count<TestType> + 3;
    std::vector<Lanes<TestType>> memory(block_count<TestType>(points) * 3);
    const BlockView<TestType> view{memory.data(), 3, points};
    for (std::size_t i = 0; i < points; ++i) {
        for (std::size_t k = 0; k < 3; ++k) view(i, k) = TestType(10 * i + k);
    }
    for (std::size_t i = 0; i < points; ++i) {
        const TestType x = TestType(10 * i);
        CHECK(block_point<3>(view, i) == Vec<TestType, 3>{x, x + 1, x + 2});
        CHECK(block_point<2>(BlockView<const TestType>(view), i) == Vec<TestType, 2>{x, x + 1});
    }
}

TEST_CASE("block views convert to const, not from const", "[core][blocks]") {
    STATIC_REQUIRE(std::is_convertible_v<BlockView<float>, BlockView<const float>>);
    STATIC_REQUIRE(!std::is_convertible_v<BlockView<const float>, BlockView<float>>);
    STATIC_REQUIRE(!std::is_convertible_v<BlockView<float>, BlockView<const double>>);
    const BlockView<float> empty;
    CHECK((empty.data == nullptr && empty.points == 0 && empty.blocks() == 0));
}

TEST_CASE("a buffer equals a vector after the same operations", "[core][buffer][property]") {
    struct Element { // its size is no power of two
        int value[3];
    };
    using Vector = std::vector<Element>;
    const auto make = [](int n) { return Element{{n, 2 * n, -n}}; };
    const auto same = [](const Element& a, const Element& b) {
        return std::equal(std::begin(a.value), std::end(a.value), std::begin(b.value));
    };
    const std::uint64_t seed = GENERATE(1U, 2U, 3U, 4U, 5U);
    CAPTURE(seed);
    Random random(seed);
    cageform::Buffer<Element> buffer;
    Vector expected;
    for (int step = 0; step < 400; ++step) {
        const std::size_t count = random.below(20);
        switch (random.below(9)) {
        case 0:
            buffer.resize(count);
            expected.resize(count);
            break;
        case 1: buffer.reserve(count); break;
        case 2:
            buffer.shrink_to_fit();
            CHECK(buffer.capacity() == buffer.size());
            break;
        case 3: {
            const Vector more(count, make(step));
            buffer.append(more.data(), more.data() + count);
            expected.insert(expected.end(), more.begin(), more.end());
            break;
        }
        case 4:
            buffer.erase_from(buffer.begin() + std::ptrdiff_t(buffer.size() / 2));
            expected.resize(expected.size() / 2);
            break;
        case 5: { // a copy and a move
            cageform::Buffer<Element> copy = buffer;
            buffer.clear();
            CHECK(copy.size() == expected.size());
            buffer = std::move(copy);
            break;
        }
        case 6: {
            cageform::Buffer<Element> other(count, make(-1));
            other = buffer;
            buffer = cageform::Buffer<Element>(std::move(other));
            CHECK(other.size() <= count + expected.size()); // NOLINT(bugprone-use-after-move): valid still
            break;
        }
        case 7: // its own element, during a reallocation
            if (buffer.empty()) break;
            buffer.shrink_to_fit();
            expected.push_back(expected.front());
            CHECK(same(buffer.push_back(buffer.front()), expected.back()));
            break;
        default: buffer.push_back(make(step)); expected.push_back(make(step));
        }
        REQUIRE(buffer.size() == expected.size());
        CHECK(buffer.empty() == expected.empty());
        CHECK(buffer.capacity() >= buffer.size());
        CHECK(std::equal(buffer.begin(), buffer.end(), expected.begin(), same));
    }
}

TEST_CASE("large buffers, with huge pages if available, hold the written values", "[core][buffer]") {
    constexpr std::size_t huge_page = (std::size_t{1} << 21) / sizeof(int);
    for (const std::size_t size : {2 * huge_page - 1, 2 * huge_page, 3 * huge_page + 12345}) {
        CAPTURE(size);
        cageform::Buffer<int> buffer(size);
        for (std::size_t i = 0; i < size; ++i) buffer[i] = int(i);
        buffer.reserve(2 * size); // moves
        bool same = true;
        for (std::size_t i = 0; i < size; ++i) same = same && buffer[i] == int(i);
        CHECK(same);
    }
}

TEST_CASE("a buffer aligns its elements and rejects impossible sizes", "[core][buffer]") {
    cageform::Buffer<Lanes<float>> rows(3);
    CHECK(reinterpret_cast<std::uintptr_t>(rows.data()) % alignof(Lanes<float>) == 0);
#if !defined(CAGEFORM_SANITIZED) // sanitizers abort such an allocation
    constexpr std::size_t most = ~std::size_t{0};
    CHECK_THROWS_AS(rows.reserve(most / 2), std::bad_alloc);
    CHECK_THROWS_AS(rows.resize(most), std::bad_alloc);
#endif
    CHECK(rows.size() == 3);
}

} // namespace blocks_tests
