#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/core/point.hpp>

#include <string>
#include <vector>

namespace my {

/// A vector of an engine: only named components.
struct Position {
    float x, y, z;
};
/// Read only: a table index.
struct FixedPosition {
    double x, y;
};
struct NoTraits {
    double x, y;
};
struct NoScalar {};
struct NoGet {};
struct NoDimension {};
struct NullDimension {};
struct OtherScalar {};

} // namespace my

template <>
struct cageform::PointTraits<my::Position> {
    using scalar = float;
    static constexpr std::size_t dimension = 3;
    static constexpr float get(const my::Position& p, std::size_t axis) noexcept {
        return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
    }
    static constexpr void set(my::Position& p, std::size_t axis, float x) noexcept {
        (axis == 0 ? p.x : axis == 1 ? p.y : p.z) = x;
    }
};
template <>
struct cageform::PointTraits<my::FixedPosition> {
    using scalar = double;
    static constexpr std::size_t dimension = 2;
    static constexpr double get(const my::FixedPosition& p, std::size_t axis) noexcept {
        return axis == 0 ? p.x : p.y;
    }
};

// Each of these lacks one thing.
template <>
struct cageform::PointTraits<my::NoScalar> {
    static constexpr std::size_t dimension = 2;
    static double get(const my::NoScalar&, std::size_t) { return 0; }
};
template <>
struct cageform::PointTraits<my::NoGet> {
    using scalar = double;
    static constexpr std::size_t dimension = 2;
};
template <>
struct cageform::PointTraits<my::NoDimension> {
    using scalar = double;
    static double get(const my::NoDimension&, std::size_t) { return 0; }
};
template <>
struct cageform::PointTraits<my::NullDimension> {
    using scalar = double;
    static constexpr std::size_t dimension = 0;
    static double get(const my::NullDimension&, std::size_t) { return 0; }
};
template <>
struct cageform::PointTraits<my::OtherScalar> {
    using scalar = float;
    static constexpr std::size_t dimension = 2;
    static double get(const my::OtherScalar&, std::size_t) { return 0; }
};

namespace point_tests {

using cageform::MutablePoint;
using cageform::Point;
using cageform::PointTraits;
using cageform::to_vec;
using cageform::Vec;

TEST_CASE("a type with a complete trait is a point", "[core][point]") {
    STATIC_REQUIRE(Point<Vec<double, 2>>);
    STATIC_REQUIRE(Point<Vec<float, 7>>);
    STATIC_REQUIRE(Point<std::array<float, 3>>);
    STATIC_REQUIRE(Point<double[2]>);
    STATIC_REQUIRE(Point<my::Position>);
    STATIC_REQUIRE(Point<my::FixedPosition>);

    STATIC_REQUIRE(!Point<my::NoTraits>);
    STATIC_REQUIRE(!Point<my::NoScalar>);
    STATIC_REQUIRE(!Point<my::NoGet>);
    STATIC_REQUIRE(!Point<my::NoDimension>);
    STATIC_REQUIRE(!Point<my::NullDimension>);
    STATIC_REQUIRE(!Point<my::OtherScalar>);
    STATIC_REQUIRE(!Point<double>);
    STATIC_REQUIRE(!Point<double*>);
    STATIC_REQUIRE(!Point<void>);
    STATIC_REQUIRE(!Point<std::string>);
    STATIC_REQUIRE(!Point<std::vector<double>>);
    STATIC_REQUIRE(!Point<std::array<float, 0>>);
}

TEST_CASE("points whose trait has `set` are mutable", "[core][point]") {
    STATIC_REQUIRE(MutablePoint<Vec<float, 2>>);
    STATIC_REQUIRE(MutablePoint<std::array<double, 3>>);
    STATIC_REQUIRE(MutablePoint<float[3]>);
    STATIC_REQUIRE(MutablePoint<my::Position>);
    STATIC_REQUIRE(!MutablePoint<my::FixedPosition>);
    STATIC_REQUIRE(!MutablePoint<my::NoGet>);
    STATIC_REQUIRE(!MutablePoint<my::NoTraits>);
}

TEST_CASE("to_vec reads every component in order", "[core][point]") {
    STATIC_REQUIRE(to_vec<double>(my::Position{1, 2, 3}) == Vec<double, 3>{1, 2, 3});
    STATIC_REQUIRE(to_vec<float>(my::FixedPosition{4, 5}) == Vec<float, 2>{4, 5});
    STATIC_REQUIRE(to_vec<float>(std::array<float, 3>{7, 8, 9}) == Vec<float, 3>{7, 8, 9});
    STATIC_REQUIRE(to_vec<double>(Vec<double, 2>{1, 2}) == Vec<double, 2>{1, 2});
    const float raw[] = {1, 2, 3};
    CHECK(to_vec<double>(raw) == Vec<double, 3>{1, 2, 3});
}

TEST_CASE("to_vec converts to the requested scalar", "[core][point]") {
    const std::array<double, 2> p{1.0 / 3, 1e-9};
    CHECK(to_vec<float>(p) == Vec<float, 2>{float(1.0 / 3), float(1e-9)});
    CHECK(to_vec<double>(std::array<float, 2>{0.1f, 0.2f}) == Vec<double, 2>{double(0.1f), double(0.2f)});
}

TEMPLATE_TEST_CASE("get returns the value of set, and other components are unchanged", "[core][point]",
                   my::Position, (Vec<float, 3>), (std::array<float, 3>)) {
    using Traits = PointTraits<TestType>;
    STATIC_REQUIRE(Traits::dimension == 3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        TestType p{1, 2, 3};
        Traits::set(p, axis, 10);
        for (std::size_t other = 0; other < 3; ++other) {
            CAPTURE(axis, other);
            CHECK(Traits::get(p, other) == (other == axis ? 10.f : float(other + 1)));
        }
    }
}

} // namespace point_tests
