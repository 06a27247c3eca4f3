// Unknown nodes as runs, against a test of every position.
#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/grid/lattice/node_runs.hpp>

#include <set>

namespace node_runs_tests {

using cageform::grid::NodeRuns;
using cageform_tests::Random;

namespace {

template <std::size_t D>
void check_runs(int seed) {
    CAPTURE(seed, D);
    Random random{std::uint64_t(seed)};
    typename NodeRuns<D>::Index size{};
    for (auto& s : size) s = std::int32_t(1 + random.below(D == 1 ? 60 : 9));
    NodeRuns<D> nodes(size);
    std::set<typename NodeRuns<D>::Index> expected;
    for (std::size_t r = 0; r < nodes.rows(); ++r) {
        auto index = nodes.row_index(r);
        CHECK(nodes.row(index) == r);
        for (std::int32_t x = 0; x < size[0];) {
            const auto end = std::min<std::int32_t>(size[0], x + std::int32_t(random.below(5)));
            nodes.add_run(x, end); // may be empty, may be adjacent to the run before
            for (index[0] = x; index[0] < end; ++index[0]) expected.insert(index);
            x = end + std::int32_t(random.below(3)) + (end == x ? 1 : 0);
        }
        nodes.end_row();
    }
    REQUIRE(nodes.count() == expected.size());
    std::uint32_t next = 0;
    nodes.for_each([&](const auto& index, std::uint32_t node) {
        CHECK(node == next++);
        CHECK(expected.count(index) == 1);
        CHECK(nodes.find(index) == node);
    });
    CHECK(next == nodes.count());

    std::set<std::pair<std::uint32_t, std::size_t>> ends;
    nodes.for_each_end([&](const auto& index, std::uint32_t node, std::size_t direction) {
        CHECK(nodes.find(index) == node);
        CHECK(ends.insert({node, direction}).second);
    });
    std::size_t missing = 0;
    for (const auto& index : expected) {
        for (std::size_t direction = 0; direction < 2 * D; ++direction) {
            auto there = index;
            there[direction / 2] += (direction & 1) != 0 ? 1 : -1;
            const bool is_end = expected.count(there) == 0;
            missing += is_end ? 1 : 0;
            CHECK((nodes.find(there) == NodeRuns<D>::none) == is_end);
            CHECK(ends.count({nodes.find(index), direction}) == (is_end ? 1 : 0));
        }
    }
    CHECK(ends.size() == missing);
}

} // namespace

TEST_CASE("NodeRuns finds its nodes and the ends of runs", "[grid][node_runs][property]") {
    const int seed = GENERATE(seeds(60));
    check_runs<1>(seed);
    check_runs<2>(seed);
    check_runs<3>(seed);
}

} // namespace node_runs_tests
