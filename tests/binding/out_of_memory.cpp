// Every failing allocation gives a status: no exception, no partial result.
#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/cages.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/binding/skin_weights.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/blended.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/sibson.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>

namespace out_of_memory_tests {

using namespace cageform_tests;
using cageform::bind;
using cageform::BindOptions;
using cageform::Status;

namespace {

/// Runs call() with its first, second, … allocation failing, until all succeed. After a failure
/// the status is out_of_memory, or ok if the standard library needs no memory.
template <class Call>
void fail_in_turn(const char* name, const Call& call) {
    CAPTURE(name);
    std::size_t reported = 0;
    for (std::size_t failing = 1;; ++failing) {
        Status status = Status::cancelled;
        bool thrown = false;
        allocations = 0;
        failing_allocation = failing;
        try {
            status = call();
        } catch (...) {
            thrown = true;
        }
        failing_allocation = 0;
        const bool all_made = allocations < failing;
        if (thrown || (status != Status::out_of_memory && status != Status::ok)) {
            CAPTURE(failing);
            FAIL("allocation that fails: " << (thrown ? "an exception" : to_string(status)));
        }
        reported += status == Status::out_of_memory;
        if (all_made) {
            CHECK(status == Status::ok);
            break;
        }
    }
    CHECK(reported > 0);
}

} // namespace

TEST_CASE("every failing allocation gives a status in each call", "[binding][status][memory]") {
    // A collinear vertex, so that the report of the cage is not empty.
    const Points2<double> square{{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}};
    const Points2<double> points{{0.5, 0.5}, {1.5, 0.7}, {1, 0}, {3, 1}, {0.5, 1.5}};
    const cageform::MeanValueCoordinates<double, 2> mean_value(square);
    cageform::HarmonicCoordinates<double, 2> harmonic(square, {.resolution = 8}, cageform::UniformGrid{});
    for (const auto outside : {cageform::OutsidePoints::extend, cageform::OutsidePoints::nearest_boundary}) {
        const BindOptions options{.outside = outside};
        fail_in_turn("bind", [&] { return bind(mean_value, points, options).report.status; });
        fail_in_turn("bind harmonic", [&] { return bind(harmonic, points, options).report.status; });
        fail_in_turn("bind_vectors",
                     [&] { return bind_vectors(mean_value, points, points, options).report.status; });
        fail_in_turn("bind_jacobians",
                     [&] { return bind_jacobians(harmonic, points, options).report.status; });
        const BindOptions fading{.outside = outside, .falloff = 2};
        fail_in_turn("bind what fades", [&] { return bind(mean_value, points, fading).report.status; });
        fail_in_turn("bind_vectors that fade",
                     [&] { return bind_vectors(mean_value, points, points, fading).report.status; });
    }
    fail_in_turn("solve", [&] {
        cageform::HarmonicCoordinates<double, 2> fresh = harmonic;
        return fresh.solve().status;
    });
    REQUIRE(harmonic.solve().status == Status::ok);
    fail_in_turn("bind what is solved", [&] { return bind(harmonic, points).report.status; });
    fail_in_turn("weights_at", [&] {
        std::array<double, 5> row{};
        return weights_at(mean_value, points[0], row) == cageform::PointState::inside ? Status::ok
                                                                                      : Status::out_of_memory;
    });

    const auto binding = bind(mean_value, points).value;
    fail_in_turn("pack", [&] {
        const cageform::PackOptions options{.format = cageform::WeightFormat::int16, .largest = 4};
        return pack(binding, options).report.status;
    });
    fail_in_turn("skin_weights", [&] { return skin_weights(binding).report.status; });
    const auto skin = skin_weights(binding).value;
    fail_in_turn("skin_to_binding", [&] { return skin_to_binding(binding, skin).status(); });
}

TEST_CASE("every failing allocation gives a status in 3D", "[binding][status][memory]") {
    using Point = Vec<float, 3>;
    const std::vector<Point> vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5, 5, 5}}; // one unused
    const std::vector<std::array<std::uint32_t, 3>> faces{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    const std::vector<Point> points{{0.2f, 0.2f, 0.2f}, {0.1f, 0.3f, 0.2f}};
    const cageform::MeanValueCoordinates<float, 3> mean_value(vertices, faces);
    const cageform::HarmonicCoordinates<float, 3> harmonic(
        cageform::TriangleMesh<float>(std::vector<Point>(vertices.begin(), vertices.end() - 1), faces),
        {.resolution = 8}, cageform::UniformGrid{});
    fail_in_turn("bind", [&] { return bind(mean_value, points).report.status; });
    fail_in_turn("bind harmonic", [&] { return bind(harmonic, points).report.status; });
}

TEST_CASE("cages and coordinates without memory are empty and have a status", "[cage][status][memory]") {
    const Points2<double> square{{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}}, triangle{{0, 0}, {1, 0}, {0, 1}};
    const std::vector<std::size_t> sizes{5};
    using cageform::Polygon;
    fail_in_turn("polygon", [&] { return check(Polygon<double>(square)).status; });
    fail_in_turn("loops", [&] { return check(Polygon<double>(square, sizes)).status; });
    fail_in_turn("barycentric",
                 [&] { return cageform::BarycentricCoordinates<double, 2>(triangle).cage_report().status; });
    fail_in_turn("mean value",
                 [&] { return cageform::MeanValueCoordinates<double, 2>(square).cage_report().status; });
    fail_in_turn("harmonic", [&] {
        const cageform::HarmonicCoordinates<double, 2> coordinates(square, {.resolution = 8},
                                                                   cageform::UniformGrid{});
        CHECK((coordinates.handles().size() == 5 || coordinates.cage_report().status != Status::ok));
        return coordinates.cage_report().status;
    });
    const Points2<double> chain{{1, 1}, {1.5, 1}};
    fail_in_turn("cell complex", [&] {
        cageform::CellComplex<double, 2> made{Polygon<double>(square)};
        (void)made.add_point(Vec<double, 2>{0.5, 0.5}, 0.1);
        (void)made.add_chain(chain);
        return check(made).status;
    });
    const cageform::CellComplex<double, 2> outline{Polygon<double>(square)};
    fail_in_turn("mean value of a complex",
                 [&] { return cageform::MeanValueCoordinates<double, 2>(outline).cage_report().status; });

    using Point = Vec<float, 3>;
    const std::vector<Point> vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5, 5, 5}};
    const std::vector<std::array<std::uint32_t, 3>> faces{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    fail_in_turn("mesh", [&] { return check(cageform::TriangleMesh<float>(vertices, faces)).status; });
    fail_in_turn("mean value in space", [&] {
        return cageform::MeanValueCoordinates<float, 3>(vertices, faces).cage_report().status;
    });
    fail_in_turn("faces in space", [&] {
        cageform::CellComplex<float, 3> made{cageform::TriangleMesh<float>(vertices, faces)};
        (void)made.add_faces(std::span(vertices).first(3), std::span(faces).first(0));
        return check(made).status;
    });
    const std::vector<Point> sites{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {0.4f, 0.5f, 0.3f}};
    for (const bool tips : {false, true}) {
        fail_in_turn("natural neighbours", [&] {
            return cageform::SibsonCoordinates<float, 3>(sites, {.degree = 3, .frames = tips})
                .cage_report()
                .status;
        });
    }
    const cageform::SibsonCoordinates<float, 3> sibson(sites);
    fail_in_turn("bind to sites", [&] { return bind(sibson, std::span(sites).last(1)).report.status; });
    std::vector<std::vector<cageform::MeanValueCoordinates<double, 2>>> parts(
        100, {cageform::MeanValueCoordinates<double, 2>(square),
              cageform::MeanValueCoordinates<double, 2>(triangle)});
    fail_in_turn("blended", [&] {
        REQUIRE(!parts.empty());
        const cageform::BlendedCoordinates<cageform::MeanValueCoordinates<double, 2>> blended(
            std::move(parts.back()));
        parts.pop_back();
        return blended.cage_report().status;
    });
}

TEMPLATE_TEST_CASE("moved-from coordinates give a status or stay valid", "[binding][status]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const Points2<T> square{{0, 0}, {2, 0}, {2, 2}, {0, 2}}, points{{T(0.5), T(0.5)}};
    cageform::MeanValueCoordinates<T, 2> mean_value(square);
    const auto taken = std::move(mean_value);
    CHECK(bind(taken, points).report.status == Status::ok);
    // NOLINTBEGIN(bugprone-use-after-move): what is tested
    CHECK(bind(mean_value, points).report.status == Status::coordinates_empty);
    CHECK(bind_vectors(mean_value, points, points).report.status == Status::coordinates_empty);
    cageform::HarmonicCoordinates<T, 2> harmonic(square, {.resolution = 8}, cageform::UniformGrid{});
    const auto shared = std::move(harmonic);
    CHECK(bind(shared, points).report.status == Status::ok);
    CHECK(bind(harmonic, points).report.status == Status::ok);
    // NOLINTEND(bugprone-use-after-move)
}

} // namespace out_of_memory_tests
