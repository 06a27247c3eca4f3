#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/core/view.hpp>

#include <deque>
#include <span>
#include <string>
#include <vector>

namespace view_tests {

using cageform::MutablePointRange;
using cageform::PointRange;
using cageform::range_dimension;
using cageform::range_scalar_t;
using cageform::store_point;
using cageform::StridedPoints;
using cageform::Vec;
using cageform_tests::Random;

namespace {

struct Vertex {
    float position[3];
    float normal[3];
    float texture[2];
};

template <class T, std::size_t D>
void check_against_index_arithmetic(Random& random) {
    // Strides without overlap: axes within points, or points within axes, with gaps.
    const std::size_t size = 1 + random.below(9);
    const bool points_outside = random.below(2) == 0;
    const std::size_t inner = 1 + random.below(3);
    const std::size_t outer = inner * (points_outside ? D : size) + random.below(3);
    const std::size_t first = random.below(4);
    const std::size_t point_step = points_outside ? outer : inner;
    const std::size_t axis_step = points_outside ? inner : outer;
    std::vector<T> buffer(first + point_step * (size - 1) + axis_step * (D - 1) + 1);
    for (T& x : buffer) x = T(random.uniform(-1, 1));

    const auto bytes = [](std::size_t step) { return std::ptrdiff_t(step * sizeof(T)); };
    const StridedPoints<const T, D> reads(buffer.data() + first, size, bytes(point_step), bytes(axis_step));
    const StridedPoints<T, D> writes(buffer.data() + first, size, bytes(point_step), bytes(axis_step));
    REQUIRE(reads.size() == size);
    for (std::size_t i = 0; i < size; ++i) {
        for (std::size_t k = 0; k < D; ++k) {
            CHECK(reads[i][k] == buffer[first + i * point_step + k * axis_step]);
        }
    }
    auto expected = buffer;
    for (std::size_t i = 0; i < size; ++i) {
        Vec<T, D> p{};
        for (std::size_t k = 0; k < D; ++k) {
            p[k] = expected[first + i * point_step + k * axis_step] = T(random.uniform(2, 3));
        }
        writes.store(i, p);
        CHECK(reads[i] == p); // both views share memory
    }
    CHECK(buffer == expected);
}

} // namespace

TEMPLATE_TEST_CASE("strided points read and write the computed addresses", "[core][view][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(100));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    check_against_index_arithmetic<TestType, 1>(random);
    check_against_index_arithmetic<TestType, 2>(random);
    check_against_index_arithmetic<TestType, 3>(random);
}

TEST_CASE("strided points over an interleaved vertex buffer", "[core][view]") {
    std::vector<Vertex> mesh(5);
    for (std::size_t i = 0; i < mesh.size(); ++i) {
        const float x = float(i);
        mesh[i] = {{x, 10 + x, 20 + x}, {30 + x, 40 + x, 50 + x}, {60 + x, 70 + x}};
    }
    const StridedPoints<float, 3> positions(mesh[0].position, mesh.size(), sizeof(Vertex));
    const StridedPoints<const float, 2> texture(mesh[0].texture, mesh.size(), sizeof(Vertex));
    for (std::size_t i = 0; i < mesh.size(); ++i) {
        const float x = float(i);
        CHECK(positions[i] == Vec<float, 3>{x, 10 + x, 20 + x});
        CHECK(texture[i] == Vec<float, 2>{60 + x, 70 + x});
        positions.store(i, {-1, -2, -3});
    }
    for (std::size_t i = 0; i < mesh.size(); ++i) {
        const float x = float(i);
        CHECK((mesh[i].position[0] == -1 && mesh[i].position[1] == -2 && mesh[i].position[2] == -3));
        CHECK((mesh[i].normal[0] == 30 + x && mesh[i].normal[1] == 40 + x && mesh[i].normal[2] == 50 + x));
        CHECK((mesh[i].texture[0] == 60 + x && mesh[i].texture[1] == 70 + x));
    }
}

TEMPLATE_TEST_CASE("strided points over separate arrays, and backwards", "[core][view]", CAGEFORM_SCALARS) {
    constexpr std::ptrdiff_t step = sizeof(TestType);
    std::vector<TestType> xs_then_ys{1, 2, 3, 10, 20, 30};
    const StridedPoints<TestType, 2> points(xs_then_ys.data(), 3, step, 3 * step);
    CHECK(points[0] == Vec<TestType, 2>{1, 10});
    CHECK(points[2] == Vec<TestType, 2>{3, 30});
    points.store(1, {7, 8});
    CHECK(xs_then_ys == std::vector<TestType>{1, 7, 3, 10, 8, 30});

    const StridedPoints<const TestType, 2> backwards(xs_then_ys.data() + 2, 3, -step, 3 * step);
    CHECK(backwards[0] == Vec<TestType, 2>{3, 30});
    CHECK(backwards[2] == Vec<TestType, 2>{1, 10});

    const StridedPoints<const TestType, 2> packed(xs_then_ys.data(), 3); // the default: x y x y …
    CHECK(packed[1] == Vec<TestType, 2>{3, 10});
}

TEST_CASE("ranges of points", "[core][view]") {
    STATIC_REQUIRE(PointRange<std::vector<Vec<double, 2>>>);
    STATIC_REQUIRE(PointRange<const std::vector<Vec<double, 2>>&>);
    STATIC_REQUIRE(PointRange<std::deque<std::array<float, 3>>>);
    STATIC_REQUIRE(PointRange<std::span<const Vec<float, 3>>>);
    STATIC_REQUIRE(PointRange<std::array<std::array<double, 2>, 4>>);
    STATIC_REQUIRE(PointRange<double[4][2]>);
    STATIC_REQUIRE(PointRange<const float[4][3]>);
    STATIC_REQUIRE(PointRange<StridedPoints<float, 2>>);
    STATIC_REQUIRE(PointRange<StridedPoints<const float, 2>>);

    STATIC_REQUIRE(!PointRange<int>);
    STATIC_REQUIRE(!PointRange<double[4]>);
    STATIC_REQUIRE(!PointRange<Vec<double, 2>*>); // no size
    STATIC_REQUIRE(!PointRange<Vec<double, 2>>);
    STATIC_REQUIRE(!PointRange<std::vector<double>>);
    STATIC_REQUIRE(!PointRange<std::vector<std::string>>);
}

TEST_CASE("ranges of points that can be written", "[core][view]") {
    STATIC_REQUIRE(MutablePointRange<std::vector<Vec<double, 2>>>);
    STATIC_REQUIRE(MutablePointRange<std::span<Vec<double, 2>>>);
    STATIC_REQUIRE(MutablePointRange<const std::span<Vec<double, 2>>>); // a const view has mutable points
    STATIC_REQUIRE(MutablePointRange<std::array<std::array<float, 3>, 4>>);
    STATIC_REQUIRE(MutablePointRange<double[4][2]>);
    STATIC_REQUIRE(MutablePointRange<StridedPoints<double, 3>>);
    STATIC_REQUIRE(MutablePointRange<const StridedPoints<double, 3>>);

    STATIC_REQUIRE(!MutablePointRange<const std::vector<Vec<double, 2>>>);
    STATIC_REQUIRE(!MutablePointRange<std::span<const Vec<double, 2>>>);
    STATIC_REQUIRE(!MutablePointRange<const double[4][2]>);
    STATIC_REQUIRE(!MutablePointRange<StridedPoints<const double, 3>>);
    STATIC_REQUIRE(!MutablePointRange<std::vector<double>>);
}

TEST_CASE("dimension and scalar of a range are those of its points", "[core][view]") {
    STATIC_REQUIRE(range_dimension<std::vector<Vec<double, 2>>> == 2);
    STATIC_REQUIRE(range_dimension<const float[4][3]> == 3);
    STATIC_REQUIRE(range_dimension<StridedPoints<const float, 3>> == 3);
    STATIC_REQUIRE(std::is_same_v<range_scalar_t<std::vector<std::array<float, 3>>>, float>);
    STATIC_REQUIRE(std::is_same_v<range_scalar_t<std::span<const Vec<double, 2>>>, double>);
    STATIC_REQUIRE(std::is_same_v<range_scalar_t<StridedPoints<const float, 3>>, float>);
}

TEMPLATE_TEST_CASE("store_point writes one point with the range's rounding", "[core][view]",
                   CAGEFORM_SCALARS) {
    const Vec<double, 2> p{1.0 / 3, -2.0 / 3};
    const auto check = [&](auto& range) {
        store_point(range, 1, p);
        for (std::size_t k = 0; k < 2; ++k) {
            CHECK(range[0][k] == TestType(k));
            CHECK(range[1][k] == TestType(p[k]));
            CHECK(range[2][k] == TestType(4 + k));
        }
    };
    SECTION("vector of vec") {
        std::vector<Vec<TestType, 2>> range{{0, 1}, {2, 3}, {4, 5}};
        check(range);
    }
    SECTION("array of array") {
        std::array<std::array<TestType, 2>, 3> range{{{0, 1}, {2, 3}, {4, 5}}};
        check(range);
    }
    SECTION("C array") {
        TestType range[3][2] = {{0, 1}, {2, 3}, {4, 5}};
        check(range);
    }
    SECTION("span") {
        Vec<TestType, 2> memory[] = {{0, 1}, {2, 3}, {4, 5}};
        const std::span<Vec<TestType, 2>> range(memory);
        check(range);
    }
    SECTION("strided view") {
        TestType memory[] = {0, 1, 2, 3, 4, 5};
        const StridedPoints<TestType, 2> range(memory, 3);
        check(range);
    }
}

} // namespace view_tests
