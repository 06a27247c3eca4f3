// compose: two bindings as one.
#include "catch.hpp"
#include "support/bindings.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/compose.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/parallel/threads.hpp>

#include <cmath>
#include <cstring>

namespace compose_tests {

using namespace cageform_tests;
using cageform::Binding;
using cageform::compose;
using cageform::epsilon;

namespace {

/// A figure bound to the vertices of a star, which are bound to a surrounding triangle.
template <class T>
struct TwoLevels {
    std::vector<Vec<T, 2>> triangle{{-20, -20}, {30, -20}, {-5, 40}}, star;
    Binding<T, 2> fine, coarse;

    explicit TwoLevels(std::uint64_t seed) {
        Random random(seed);
        star = random_star<T>(seed);
        const cageform::Polygon<T> cage(star);
        std::vector<Vec<T, 2>> figure;
        for (int i = 0; i < 100; ++i) figure.push_back(random_inside(cage, random, 0));
        fine = cageform::bind(cageform::MeanValueCoordinates<T, 2>(cage), figure).value;
        coarse = cageform::bind(cageform::BarycentricCoordinates<T, 2>(triangle), star).value;
        REQUIRE(fine.point_count() == 100);
        REQUIRE(coarse.point_count() == star.size());
    }
};

} // namespace

TEMPLATE_TEST_CASE("a composed binding equals two consecutive clones", "[binding][compose]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = std::uint64_t(GENERATE(range(0, 10)));
    CAPTURE(seed);
    const TwoLevels<T> levels(seed);
    const auto [composed, report] = compose(levels.fine, levels.coarse);
    REQUIRE(report.status == Status::ok);
    CHECK(report.still.empty());
    REQUIRE(composed.point_count() == 100);
    REQUIRE(composed.handle_count() == 3);
    const auto pose = random_points<T, 2>(3, 30, seed + 1);
    const auto once = cloned(composed, pose), twice = cloned(levels.fine, cloned(levels.coarse, pose));
    const auto at_rest = cloned(composed, levels.triangle);
    for (std::size_t i = 0; i < 100; ++i) {
        double error = 0; // rounding of sums of products of weights
        for (std::size_t h = 0; h < levels.star.size(); ++h) {
            for (std::size_t k = 0; k < 3; ++k)
                error += 20 * double(epsilon<T>) *
                         std::fabs(double(levels.fine.weight(i, h)) * double(levels.coarse.weight(h, k)));
        }
        CAPTURE(i, error);
        CHECK(distance(once[i], twice[i]) <= 80 * error); // the extent of the pose and the triangle
        const auto p = levels.fine.rest_point(i);
        CHECK(std::memcmp(&p, &at_rest[i], sizeof(p)) == 0);
        double sum = 0;
        Vec<double, 2> place{};
        for (std::size_t h = 0; h < 3; ++h) {
            sum += double(composed.weight(i, h));
            place = place + double(composed.weight(i, h)) * cageform::vec_cast<double>(levels.triangle[h]);
        }
        CHECK(std::fabs(sum - 1) <= error);
        CHECK(distance(place, p) <= 80 * error);
    }
    const auto threaded = compose(levels.fine, levels.coarse, {.parallel = cageform::ThreadedFor{3}}).value;
    for (std::size_t i = 0; i < 100; ++i) {
        for (std::size_t h = 0; h < 3; ++h) CHECK(threaded.weight(i, h) == composed.weight(i, h));
    }
}

TEMPLATE_TEST_CASE("sites bound to themselves compose to the fine binding", "[binding][compose]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const TwoLevels<T> levels(3);
    const auto itself =
        cageform::bind(cageform::MeanValueCoordinates<T, 2>(cageform::Polygon<T>(levels.star)), levels.star)
            .value;
    const auto [composed, report] = compose(levels.fine, itself);
    REQUIRE(report.status == Status::ok);
    for (std::size_t i = 0; i < 100; ++i) {
        for (std::size_t h = 0; h < levels.star.size(); ++h)
            CHECK(composed.weight(i, h) == levels.fine.weight(i, h));
    }
}

TEST_CASE("a site without coarse weights does not move and is reported", "[binding][compose]") {
    TwoLevels<double> levels(5);
    levels.triangle = {{100, 100}, {101, 100}, {100, 101}}; // elsewhere
    const auto coarse = cageform::bind(cageform::BarycentricCoordinates<double, 2>(levels.triangle),
                                       levels.star, {.outside = cageform::OutsidePoints::keep_in_place})
                            .value;
    const auto [composed, report] = compose(levels.fine, coarse);
    REQUIRE(report.status == Status::ok);
    CHECK(report.still.size() == levels.star.size());
    const auto moved = cloned(composed, random_points<double, 2>(3, 9, 1));
    for (std::size_t i = 0; i < 100; ++i) CHECK(moved[i] == levels.fine.rest_point(i));
}

TEST_CASE("compose rejects bindings that do not match", "[binding][compose][status]") {
    const TwoLevels<double> levels(6), others(7);
    const auto status = [](const auto& fine, const auto& coarse) {
        const auto result = compose(fine, coarse);
        CHECK(result.value.point_count() == 0);
        return result.status();
    };
    CHECK(status(levels.fine, levels.fine) == Status::bindings_differ);
    CHECK(status(levels.fine, others.coarse) == Status::bindings_differ);
    auto star = levels.star;
    star[2][1] = std::nextafter(star[2][1], 1e9);
    const auto beside =
        cageform::bind(cageform::BarycentricCoordinates<double, 2>(levels.triangle), star).value;
    CHECK(status(levels.fine, beside) == Status::bindings_differ);
    auto [rows, rest] = Binding<double, 2>(levels.fine).release();
    const auto handles = binding_handles(levels.fine);
    std::vector kinds(handles.size(), cageform::HandleKind::point);
    kinds[1] = cageform::HandleKind::vector;
    const Binding<double, 2> of_vectors(std::move(rows), std::move(rest),
                                        {handles.data(), handles.size(), kinds.data(), nullptr}, 100);
    CHECK(status(of_vectors, levels.coarse) == Status::handles_not_points);
    const cageform::Running stop{.parallel = cageform::SerialFor{}, .progress = [](double) { return false; }};
    CHECK(compose(levels.fine, levels.coarse, stop).status() == Status::cancelled);
}

} // namespace compose_tests
