#include "../catch.hpp"

#include <cageform/adapt/glm.hpp>
#include <cageform/cage/polygon.hpp>

#include <glm/mat2x2.hpp>
#include <glm/vec4.hpp>

#include <span>
#include <vector>

namespace glm_tests {

using cageform::MutablePoint;
using cageform::MutablePointRange;
using cageform::Point;
using cageform::PointRange;
using cageform::PointTraits;
using cageform::Vec;

TEST_CASE("GLM vectors are points in every qualifier", "[adapt][glm]") {
    STATIC_REQUIRE(MutablePoint<glm::vec2>);
    STATIC_REQUIRE(MutablePoint<glm::vec3>);
    STATIC_REQUIRE(MutablePoint<glm::dvec2>);
    STATIC_REQUIRE(MutablePoint<glm::dvec3>);
    STATIC_REQUIRE(MutablePoint<glm::vec4>);
    STATIC_REQUIRE(MutablePoint<glm::vec<2, float, glm::lowp>>);
    STATIC_REQUIRE(MutablePoint<glm::vec<3, double, glm::mediump>>);
    STATIC_REQUIRE(PointTraits<glm::vec2>::dimension == 2);
    STATIC_REQUIRE(PointTraits<glm::dvec3>::dimension == 3);
    STATIC_REQUIRE(std::is_same_v<PointTraits<glm::vec2>::scalar, float>);
    STATIC_REQUIRE(std::is_same_v<PointTraits<glm::dvec2>::scalar, double>);
    STATIC_REQUIRE(!Point<glm::mat2>);
}

TEMPLATE_TEST_CASE("GLM vectors are read and written by axis", "[adapt][glm]", glm::vec3, glm::dvec3) {
    using Traits = PointTraits<TestType>;
    TestType p(1, 2, 3);
    CHECK((Traits::get(p, 0) == 1 && Traits::get(p, 1) == 2 && Traits::get(p, 2) == 3));
    CHECK(cageform::to_vec<double>(p) == Vec<double, 3>{1, 2, 3});
    Traits::set(p, 1, 7);
    CHECK(p == TestType(1, 7, 3));
}

TEST_CASE("ranges of GLM vectors are ranges of points", "[adapt][glm]") {
    STATIC_REQUIRE(MutablePointRange<std::vector<glm::vec2>>);
    STATIC_REQUIRE(MutablePointRange<std::span<glm::dvec3>>);
    STATIC_REQUIRE(PointRange<std::span<const glm::vec3>>);
    STATIC_REQUIRE(!MutablePointRange<std::span<const glm::vec3>>);

    std::vector<glm::vec2> points{{0, 0}, {4, 0}, {0, 3}};
    const cageform::Polygon cage(points);
    STATIC_REQUIRE(std::is_same_v<decltype(cage), const cageform::Polygon<float>>);
    CHECK(cage[1] == Vec<float, 2>{4, 0});
    CHECK(cage[2] == Vec<float, 2>{0, 3});

    cageform::store_point(points, 1, Vec<double, 2>{1.0 / 3, 5});
    CHECK(points == std::vector<glm::vec2>{{0, 0}, {float(1.0 / 3), 5}, {0, 3}});
}

} // namespace glm_tests
