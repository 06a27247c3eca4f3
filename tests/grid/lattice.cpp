#include "averaging/lattice.hpp"
#include "../catch.hpp"
#include "../support/cages.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace lattice_tests {

using cageform::Bounds;
using cageform::bounds_of;
using cageform::CellBox;
using cageform::epsilon;
using cageform::Lattice;
using cageform::Vec;
using cageform_sources::averaging::lattice_about;
using cageform_sources::averaging::papers_margin;
using cageform_tests::Random;
using cageform_tests::random_star;

namespace {

template <std::size_t D>
void check_numbering(const CellBox<D>& box) {
    std::size_t expected_size = 1;
    for (std::size_t k = 0; k < D; ++k) {
        CHECK(box.stride(k) == expected_size);
        expected_size *= box.cells[k];
    }
    REQUIRE(box.size() == expected_size);
    std::set<typename CellBox<D>::Index> seen;
    for (std::size_t n = 0; n < box.size(); ++n) {
        const auto index = box.index(n);
        CHECK(box.number(index) == n);
        seen.insert(index);
        for (std::size_t k = 0; k < D; ++k) {
            CHECK(index[k] < box.cells[k]);
            if (index[k] + 1 == box.cells[k]) continue;
            auto next = index;
            ++next[k];
            CHECK(box.number(next) == n + box.stride(k));
        }
    }
    CHECK(seen.size() == box.size());
}

/// Checks lattice_about for any bounds.
template <class T, std::size_t D>
void check_about(const Bounds<T, D>& bounds, std::size_t resolution) {
    const auto lattice = lattice_about(bounds, resolution);
    const auto extent = bounds.upper - bounds.lower;
    const T longest = *std::max_element(extent.v, extent.v + D);
    const T rounding = 8 * epsilon<T> * std::fmax(bounds.magnitude(), longest);
    CHECK(std::fabs(lattice.spacing * T(resolution - 2 * papers_margin) - longest) <= rounding);
    bool reached = false;
    for (std::size_t k = 0; k < D; ++k) {
        CAPTURE(k);
        reached = reached || lattice.cells[k] == resolution;
        CHECK(lattice.cells[k] <= resolution);
        // At least the margin, except for a thousandth of a cell that is rounded off; less than one cell
        // more.
        const T margin = T(papers_margin) * lattice.spacing;
        const T below = bounds.lower[k] - lattice.origin[k];
        const T above = lattice.origin[k] + T(lattice.cells[k]) * lattice.spacing - bounds.upper[k];
        CHECK(below >= margin - T(1e-3) * lattice.spacing - rounding);
        CHECK(above >= margin - T(1e-3) * lattice.spacing - rounding);
        CHECK(below <= margin + T(0.5) * lattice.spacing + rounding);
        CHECK(std::fabs(above - below) <= 2 * rounding); // the cage is in the middle
    }
    CHECK(reached);
}

} // namespace

TEST_CASE("cells are numbered with the first axis fastest", "[grid][lattice]") {
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto side = [&] { return 1 + random.below(7); };
    check_numbering<1>({{side()}});
    check_numbering<2>({{side(), side()}});
    check_numbering<3>({{side(), side(), side()}});
}

TEMPLATE_TEST_CASE("the centre of a cell is half a cell from its corner", "[grid][lattice]",
                   CAGEFORM_SCALARS) {
    Lattice<TestType, 3> lattice;
    lattice.cells = {4, 5, 6};
    lattice.origin = {-1, 2, 10};
    lattice.spacing = TestType(0.5);
    CHECK(lattice.centre({0, 0, 0}) == Vec<TestType, 3>{-0.75, 2.25, 10.25});
    CHECK(lattice.centre({3, 1, 5}) == Vec<TestType, 3>{0.75, 2.75, 12.75});
    CHECK(lattice.in_cells({-1, 2, 10}) == Vec<TestType, 3>{0, 0, 0});
    for (std::size_t n = 0; n < lattice.size(); ++n) {
        const auto index = lattice.index(n);
        const auto x = lattice.in_cells(lattice.centre(index));
        for (std::size_t k = 0; k < 3; ++k) CHECK(x[k] == TestType(index[k]) + TestType(0.5));
    }
}

TEMPLATE_TEST_CASE("a lattice around a cage has the margin", "[grid][lattice][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    const auto points = random_star<T>(std::uint64_t(seed));
    const auto bounds = bounds_of(std::span<const Vec<T, 2>>(points));
    Random random{std::uint64_t(seed)};
    for (const std::size_t resolution : {std::size_t(5), std::size_t(8), 16 + random.below(500)}) {
        CAPTURE(resolution);
        check_about(bounds, resolution);
        const Bounds<T, 3> box{{0, -1, T(random.uniform(-9, 0))},
                               {T(random.uniform(1, 9)), T(-0.5), T(random.uniform(0.1, 9))}};
        check_about(box, resolution);
    }
}

TEMPLATE_TEST_CASE("short sides of a cage have as many cells as needed", "[grid][lattice]",
                   CAGEFORM_SCALARS) {
    const Bounds<TestType, 2> wide{{0, 0}, {12, 3}};
    CHECK(lattice_about(wide, 16).cells == CellBox<2>::Index{16, 7}); // 12 and 3 cells, and 2 · 2 more
    CHECK(lattice_about(wide, 16).origin == Vec<TestType, 2>{-2, -2});
    const Bounds<TestType, 2> wider{{0, 0}, {12, TestType(3.01)}};
    CHECK(lattice_about(wider, 16).cells == CellBox<2>::Index{16, 8});
    const Bounds<TestType, 2> flat{{0, 0}, {12, TestType(1e-2)}};
    CHECK(lattice_about(flat, 16).cells == CellBox<2>::Index{16, 5});
}

TEMPLATE_TEST_CASE("a rounding error adds no cell", "[grid][lattice]", CAGEFORM_SCALARS) {
    for (std::size_t n = 1; n <= 12; ++n) {
        for (const TestType size : {TestType(0.1), TestType(0.3), TestType(7)}) {
            CAPTURE(n, size);
            const Bounds<TestType, 2> bounds{{0, 0}, {12 * size, TestType(n) * size}};
            CHECK(lattice_about(bounds, 16).cells == CellBox<2>::Index{16, n + 4});
        }
    }
}

} // namespace lattice_tests
