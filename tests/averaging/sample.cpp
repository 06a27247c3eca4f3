#include "averaging/sample.hpp"
#include "../catch.hpp"
#include "../support/cages.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace sample_tests {

using cageform::epsilon;
using cageform::Lattice;
using cageform::Vec;
using cageform_sources::averaging::CellTag;
using cageform_sources::averaging::Interpolation;
using cageform_sources::averaging::sample_stencil;
using cageform_sources::averaging::SampleStencil;
using cageform_tests::Random;

namespace {

template <class T, std::size_t D>
Lattice<T, D> random_lattice(Random& random) {
    Lattice<T, D> lattice;
    lattice.spacing = T(std::pow(10.0, random.uniform(-2, 2)));
    for (std::size_t k = 0; k < D; ++k) {
        lattice.cells[k] = 2 + random.below(6);
        lattice.origin[k] = T(random.uniform(-5, 5)) * lattice.spacing;
    }
    return lattice;
}

/// The rounding of a position on the lattice, in cells: of p, of the origin, and of their difference.
template <class T>
T rounding_in_cells() {
    return 32 * epsilon<T>; // positions are up to 5 + 8 cells from zero
}

template <class T, std::size_t D>
Vec<T, D> at_cells(const Lattice<T, D>& lattice, const Vec<double, D>& cells) {
    Vec<T, D> p{};
    for (std::size_t k = 0; k < D; ++k)
        p[k] = T(double(lattice.origin[k]) + cells[k] * double(lattice.spacing));
    return p;
}

template <class T, std::size_t D>
void check_stencil(const SampleStencil<T, D>& stencil, std::span<const CellTag> tags) {
    REQUIRE(stencil.count <= (std::size_t(1) << D));
    std::set<std::size_t> cells;
    T sum = 0;
    for (std::size_t i = 0; i < stencil.count; ++i) {
        REQUIRE(stencil.cells[i] < tags.size());
        CHECK(cells.insert(stencil.cells[i]).second);
        CHECK(stencil.shares[i] > 0);
        CHECK((tags[stencil.cells[i]] == CellTag::interior || tags[stencil.cells[i]] == CellTag::boundary));
        sum += stencil.shares[i];
    }
    if (stencil.count > 0) CHECK(std::fabs(sum - 1) <= T(1 << D) * epsilon<T>);
}

template <class T, std::size_t D>
void check_linear_field(Random& random) {
    const auto lattice = random_lattice<T, D>(random);
    std::vector<CellTag> tags(lattice.size());
    for (auto& tag : tags) tag = random.below(2) == 0 ? CellTag::interior : CellTag::boundary;
    // A function of the position in cells, of slopes up to 1.
    Vec<double, D> slope{};
    for (std::size_t k = 0; k < D; ++k) slope[k] = random.uniform(-1, 1);
    const auto value = [&](const Vec<double, D>& cells) { return 1 + dot(slope, cells); };
    std::vector<T> field(lattice.size());
    for (std::size_t c = 0; c < field.size(); ++c) {
        const auto index = lattice.index(c);
        Vec<double, D> cells{};
        for (std::size_t k = 0; k < D; ++k) cells[k] = double(index[k]) + 0.5;
        field[c] = T(value(cells));
    }
    for (int n = 0; n < 20; ++n) {
        Vec<double, D> cells{};
        for (std::size_t k = 0; k < D; ++k) cells[k] = random.uniform(0.5, double(lattice.cells[k]) - 0.5);
        const auto p = at_cells(lattice, cells);
        const auto stencil =
            sample_stencil(lattice, std::span<const CellTag>(tags), p, Interpolation::multilinear);
        check_stencil(stencil, std::span<const CellTag>(tags));
        REQUIRE(stencil.count > 0);
        // Each slope carries the rounding of the position, and the sum of 2^D shares its own of values < 25.
        const double rounding =
            double(rounding_in_cells<T>()) * double(D) + 25 * (2 << D) * double(epsilon<T>);
        CHECK(std::fabs(double(stencil.sample(field)) - value(cells)) <= rounding);
    }
}

/// Multilinear interpolation by its definition: of all cells, the product of the hats 1 − |x − centre|.
template <class T, std::size_t D>
void check_against_hats(Random& random) {
    const auto lattice = random_lattice<T, D>(random);
    const std::vector<CellTag> kinds{CellTag::interior, CellTag::boundary, CellTag::exterior,
                                     CellTag::untyped};
    std::vector<CellTag> tags(lattice.size());
    std::vector<T> field(lattice.size());
    for (std::size_t c = 0; c < tags.size(); ++c) {
        tags[c] = kinds[random.below(4)];
        field[c] = tags[c] == CellTag::interior || tags[c] == CellTag::boundary
                       ? T(random.uniform(-1, 1))
                       : std::numeric_limits<T>::quiet_NaN();
    }
    std::size_t empty = 0;
    for (int n = 0; n < 30; ++n) {
        Vec<double, D> cells{};
        for (std::size_t k = 0; k < D; ++k) cells[k] = random.uniform(0, double(lattice.cells[k]));
        const auto p = at_cells(lattice, cells);
        const auto stencil =
            sample_stencil(lattice, std::span<const CellTag>(tags), p, Interpolation::multilinear);
        check_stencil(stencil, std::span<const CellTag>(tags));
        double total = 0;
        double sum = 0;
        for (std::size_t c = 0; c < tags.size(); ++c) {
            const auto index = lattice.index(c);
            double share = 1;
            for (std::size_t k = 0; k < D; ++k) {
                // Beyond the outermost centres the values continue as they are.
                const double x = std::clamp(cells[k], 0.5, double(lattice.cells[k]) - 0.5);
                share *= std::fmax(0.0, 1 - std::fabs(x - double(index[k]) - 0.5));
            }
            if (tags[c] != CellTag::interior && tags[c] != CellTag::boundary) continue;
            total += share;
            if (share > 0) sum += share * double(field[c]);
        }
        if (total == 0) {
            CHECK(stencil.count == 0);
            ++empty;
        } else if (total > 0.01) { // otherwise the rounding of the position is magnified by 1/total
            const double rounding = 2 * double(D) * double(rounding_in_cells<T>()) / total;
            CHECK(std::fabs(double(stencil.sample(field)) - sum / total) <= rounding * (2 << D));
        }
    }
    CHECK(empty < 30);
}

template <class T, std::size_t D>
void check_nearest(Random& random) {
    const auto lattice = random_lattice<T, D>(random);
    std::vector<CellTag> tags(lattice.size());
    for (auto& tag : tags) tag = random.below(3) == 0 ? CellTag::exterior : CellTag::interior;
    for (std::size_t c = 0; c < tags.size(); ++c) {
        const auto index = lattice.index(c);
        Vec<double, D> cells{};
        for (std::size_t k = 0; k < D; ++k) cells[k] = double(index[k]) + random.uniform(0.01, 0.99);
        const auto stencil = sample_stencil(lattice, std::span<const CellTag>(tags), at_cells(lattice, cells),
                                            Interpolation::nearest_cell);
        CAPTURE(c);
        if (tags[c] == CellTag::exterior) {
            CHECK(stencil.count == 0);
        } else {
            REQUIRE(stencil.count == 1);
            CHECK(stencil.cells[0] == c);
            CHECK(stencil.shares[0] == 1);
        }
    }
}

template <class T, std::size_t D>
void check_centres(Random& random) {
    const auto lattice = random_lattice<T, D>(random);
    const std::vector<CellTag> tags(lattice.size(), CellTag::interior);
    std::vector<T> field(lattice.size());
    for (T& x : field) x = T(random.uniform(-1, 1));
    for (std::size_t c = 0; c < tags.size(); ++c) {
        const auto centre = lattice.centre(lattice.index(c));
        for (const auto interpolation : {Interpolation::nearest_cell, Interpolation::multilinear}) {
            const auto stencil =
                sample_stencil(lattice, std::span<const CellTag>(tags), centre, interpolation);
            check_stencil(stencil, std::span<const CellTag>(tags));
            // Off the centre by a rounding of the position, times differences of values up to 2.
            CHECK(std::fabs(stencil.sample(field) - field[c]) <= 2 * T(D) * rounding_in_cells<T>());
        }
    }
}

} // namespace

TEMPLATE_TEST_CASE("sampling reproduces linear fields", "[grid][sample][property]", CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(30));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    check_linear_field<TestType, 1>(random);
    check_linear_field<TestType, 2>(random);
    check_linear_field<TestType, 3>(random);
}

TEMPLATE_TEST_CASE("sampling is the sum of hats, scaled where cells are left out", "[grid][sample][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(30));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    check_against_hats<TestType, 2>(random);
    check_against_hats<TestType, 3>(random);
}

TEMPLATE_TEST_CASE("nearest_cell takes the cell that holds the point", "[grid][sample][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    check_nearest<TestType, 1>(random);
    check_nearest<TestType, 2>(random);
    check_nearest<TestType, 3>(random);
}

TEMPLATE_TEST_CASE("at its centre a cell has its own value", "[grid][sample][property]", CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    check_centres<TestType, 2>(random);
    check_centres<TestType, 3>(random);
}

TEMPLATE_TEST_CASE("there is nothing to sample outside the lattice", "[grid][sample]", CAGEFORM_SCALARS) {
    using limits = std::numeric_limits<TestType>;
    Lattice<TestType, 2> lattice;
    lattice.cells = {4, 3};
    const std::vector<CellTag> tags(lattice.size(), CellTag::interior);
    const auto count = [&](TestType x, TestType y, Interpolation interpolation) {
        return sample_stencil(lattice, std::span<const CellTag>(tags), Vec<TestType, 2>{x, y}, interpolation)
            .count;
    };
    for (const auto interpolation : {Interpolation::nearest_cell, Interpolation::multilinear}) {
        for (const TestType far : {TestType(0.01), TestType(1e9), limits::max()}) {
            CHECK(count(-far, 1, interpolation) == 0);
            CHECK(count(4 + far, 1, interpolation) == 0);
            CHECK(count(1, -far, interpolation) == 0);
            CHECK(count(1, 3 + far, interpolation) == 0);
        }
        // Its border belongs to it.
        for (const TestType x : {TestType(0), TestType(4)}) {
            for (const TestType y : {TestType(0), TestType(3)}) CHECK(count(x, y, interpolation) == 1);
        }
        // Not finite is not promised to work, but it is no cell either.
        CHECK(count(limits::quiet_NaN(), 1, interpolation) == 0);
        CHECK(count(1, limits::infinity(), interpolation) == 0);
    }
}

TEMPLATE_TEST_CASE("a lattice one cell wide is sampled along the other axis", "[grid][sample]",
                   CAGEFORM_SCALARS) {
    Lattice<TestType, 2> lattice;
    lattice.cells = {3, 1};
    const std::vector<CellTag> tags(3, CellTag::interior);
    const std::vector<TestType> field{0, 2, 4};
    for (const TestType y : {TestType(0), TestType(0.5), TestType(1)}) {
        const auto stencil = sample_stencil(lattice, std::span<const CellTag>(tags), Vec<TestType, 2>{1, y},
                                            Interpolation::multilinear);
        CHECK(stencil.sample(field) == 1);
    }
}

} // namespace sample_tests
