// Falloff in figures, packed bindings and compositions; invalid falloffs.
#include "../catch.hpp"
#include "../support/bindings.hpp"
#include "../support/figures.hpp"
#include "../support/packed.hpp"
#include "../support/uniform_harmonic.hpp"

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/binding/compose.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/binding/rebind_cage.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/blended.hpp>
#include <cageform/coordinates/lattice.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <cstring>

namespace falloff_kept_tests {

using namespace cageform_tests;
using cageform::BindOptions;
using cageform::epsilon;
using cageform::OutsidePoints;
using cageform::Polygon;
using cageform::WeightFormat;

namespace {

template <class T, std::size_t D>
using Mean = cageform::MeanValueCoordinates<T, D>;

template <class T, std::size_t D>
bool same_weights(const cageform::Binding<T, D>& a, const cageform::Binding<T, D>& b) {
    const auto x = a.view().weights, y = b.view().weights;
    return x.rows == y.rows && x.points == y.points &&
           std::memcmp(x.data, y.data, x.blocks() * x.rows * sizeof(cageform::Lanes<T>)) == 0;
}

/// Points in and around a cage.
template <class T>
Points2<T> points_in_and_out(const Polygon<T>& cage, std::size_t count, std::uint64_t seed) {
    Random random(seed);
    const auto bounds = cageform::bounds_of(cage.vertices());
    Points2<T> points(count);
    for (auto& p : points) {
        for (std::size_t k = 0; k < 2; ++k) {
            const double width = double(bounds.upper[k] - bounds.lower[k]);
            p[k] = T(double(bounds.lower[k]) + random.uniform(-0.8, 1.8) * width);
        }
    }
    return points;
}

/// A solver that must not run: its `solve` fails the test.
struct Unsolvable : cageform_tests::UniformHarmonic<double, 2> {
    using cageform_tests::UniformHarmonic<double, 2>::UniformHarmonic;
    cageform::Evaluation solve(const cageform::Running& = {}) {
        FAIL_CHECK("nothing is solved for a bind that is refused");
        return {};
    }
};

} // namespace

TEMPLATE_TEST_CASE("packed bindings preserve the falloff", "[binding][pack][falloff]", float, double) {
    using T = TestType;
    const auto seed = std::uint64_t(GENERATE(seeds(3)));
    CAPTURE(seed);
    const Polygon<T> cage(random_star<T>(seed));
    const double size = double(cageform::bounds_of(cage.vertices()).diagonal());
    const auto points = points_in_and_out(cage, 203, seed);
    const auto bound = cageform::bind(Mean<T, 2>(cage), points, {.falloff = 0.2 * size});
    REQUIRE(bound.report.status == Status::ok);
    REQUIRE(bound.report.faded.size() > 10);
    REQUIRE(bound.report.outside.size() > bound.report.faded.size() + 10);
    const auto pose = shaken(cage.vertices(), 0.1 * size, seed);
    const auto expected = cloned(bound.value, pose);
    for (const auto format :
         {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8}) {
        for (const double tolerance : {0.0, 0.02 * size}) {
            CAPTURE(int(format), tolerance);
            cageform::PackOptions options{.format = format, .tolerance = tolerance};
            if (tolerance == 0) options.threshold = 1e-3;
            const auto [packed, report] = cageform::pack(bound.value, options);
            if (report.status == Status::format_too_coarse) continue;
            REQUIRE(report.status == Status::ok);
            std::vector<Vec<T, 2>> moved(points.size());
            REQUIRE(cageform::clone(packed.view(), pose, moved) == Status::ok);
            const auto weights = effective_weights(packed.view());
            for (std::size_t i = 0; i < points.size(); ++i) {
                CAPTURE(i);
                // The sums are those of the binding, less than 1 outside.
                double sum = 0, own = 0, sizes = 1;
                for (std::size_t h = 0; h < cage.size(); ++h) {
                    sum += weights[i][h];
                    own += double(bound.value.weight(i, h));
                    sizes += std::fabs(double(bound.value.weight(i, h)));
                }
                CHECK(std::fabs(sum - own) <= 256 * double(epsilon<T>) * sizes);
                CHECK(distance(moved[i], expected[i]) <=
                      double(report.errors[i]) * 0.15 * size + 256 * double(epsilon<T>) * size * sizes);
            }
            for (const std::size_t i : bound.report.outside) {
                const auto& list = bound.report.faded;
                if (!std::binary_search(list.begin(), list.end(), i)) CHECK(moved[i] == points[i]);
            }
        }
    }
}

TEST_CASE("figures, packed points and AnyCoordinates have the same falloff", "[binding][falloff]") {
    const auto seed = std::uint64_t(GENERATE(seeds(3)));
    CAPTURE(seed);
    const auto data = random_mesh(seed);
    const Mean<double, 3> coordinates(data.mesh<double>());
    const auto points = points_about(data, 100, seed);
    const auto normals = random_points<double, 3>(points.size(), 1, seed);
    const double size = double(cageform::bounds_of(coordinates.handles()).diagonal());
    for (const auto outside : {OutsidePoints::extend, OutsidePoints::nearest_boundary}) {
        const BindOptions options{.outside = outside, .falloff = 0.1 * size};
        const cageform::FigurePoints given{points, normals};
        const auto figure = cageform::bind(coordinates, given, options);
        REQUIRE(figure.report.status == Status::ok);
        CHECK(figure.report.points.faded.size() > 5);
        CHECK(figure.report.vectors.faded == figure.report.points.faded);
        CHECK(same_weights(figure.value.points, cageform::bind(coordinates, points, options).value));
        const auto tangents = cageform::tangents_of(normals);
        for (std::size_t k = 0; k < 2; ++k)
            CHECK(same_weights(figure.value.tangents[k],
                               cageform::bind_vectors(coordinates, points, tangents[k], options).value));
        const cageform::AnyCoordinates<double, 3> any(coordinates);
        const auto by_any = cageform::bind(any, given, options);
        REQUIRE(by_any.report.status == Status::ok);
        CHECK(same_weights(by_any.value.points, figure.value.points));
        CHECK(same_weights(by_any.value.tangents[1], figure.value.tangents[1]));
        CHECK(by_any.report.points.faded == figure.report.points.faded);
        const auto again = cageform::rebind_cage(figure.value, coordinates, {}, options);
        REQUIRE(again.report.status == Status::ok);
        CHECK(same_weights(again.value.points, figure.value.points));
        CHECK(same_weights(again.value.tangents[0], figure.value.tangents[0]));
    }
}

TEST_CASE("the falloff of sites applies to a composed figure", "[binding][falloff]") {
    const Polygon<double> cage(random_star<double>(1));
    const double size = cageform::bounds_of(cage.vertices()).diagonal();
    const auto corners = points_in_and_out(cage, 4, 3);
    const Points2<double> box{
        {-3 * size, -3 * size}, {3 * size, -3 * size}, {3 * size, 3 * size}, {-3 * size, 3 * size}};
    Points2<double> sites(4);
    for (std::size_t k = 0; k < 4; ++k) sites[k] = cage[0] + 0.1 * box[k];
    const auto fine = cageform::bind(Mean<double, 2>(Polygon<double>(sites)), corners);
    const auto coarse = cageform::bind(Mean<double, 2>(cage), sites, {.falloff = 0.5 * size});
    REQUIRE(fine.report.status == Status::ok);
    REQUIRE(coarse.report.status == Status::ok);
    REQUIRE(!coarse.report.faded.empty());
    const auto whole = cageform::compose(fine.value, coarse.value);
    REQUIRE(whole.report.status == Status::ok);
    const auto pose = shaken(cage.vertices(), 0.1 * size, 4);
    const auto expected = cloned(fine.value, cloned(coarse.value, pose)), found = cloned(whole.value, pose);
    for (std::size_t i = 0; i < corners.size(); ++i) CHECK(distance(found[i], expected[i]) <= 1e-12 * size);
}

TEST_CASE("the falloff of two cages depends on the nearer one", "[binding][falloff]") {
    const Polygon<double> left(Points2<double>{{0, 0}, {2, 0}, {2, 2}, {0, 2}}),
        right(Points2<double>{{5, 0}, {7, 0}, {7, 2}, {5, 2}});
    const cageform::BlendedCoordinates<Mean<double, 2>> coordinates(
        {Mean<double, 2>(left), Mean<double, 2>(right)});
    const Points2<double> points{{2.5, 1}, {4.5, 1}, {3.5, 1}, {1, 1}};
    const auto [binding, report] =
        cageform::bind(coordinates, points, {.outside = OutsidePoints::nearest_boundary, .falloff = 1});
    REQUIRE(report.status == Status::ok);
    CHECK(report.outside == std::vector<std::size_t>{0, 1, 2});
    CHECK(report.faded == std::vector<std::size_t>{0, 1});
    Points2<double> pose(coordinates.handles().begin(), coordinates.handles().end());
    for (std::size_t i = 0; i < 4; ++i) pose[i] = pose[i] + Vec<double, 2>{0, 1};
    const auto moved = cloned(binding, pose);
    CHECK(distance(moved[0], Vec<double, 2>{2.5, 1.5}) <= 1e-15); // f(1/2) = 1/2
    CHECK(moved[1] == points[1]);
    CHECK(moved[2] == points[2]);
    CHECK(distance(moved[3], Vec<double, 2>{1, 2}) <= 1e-15);
}

TEST_CASE("an unsupported falloff is rejected before solving", "[binding][falloff][status]") {
    const Polygon<double> cage(Points2<double>{{0, 0}, {2, 0}, {2, 2}, {0, 2}});
    const Points2<double> points{{1, 1}, {3, 1}}, normals{{1, 0}, {0, 1}};
    const Mean<double, 2> closed(cage);
    const Unsolvable solver(cage, {.resolution = 32});
    const auto refused = [&](const auto& coordinates, const BindOptions& options) {
        const auto bound = cageform::bind(coordinates, points, options);
        CHECK(bound.report.status == Status::falloff_not_supported);
        CHECK(bound.value.point_count() == 0);
        const auto vectors = cageform::bind_vectors(coordinates, points, normals, options);
        CHECK(vectors.report.status == Status::falloff_not_supported);
        CHECK(vectors.value.point_count() == 0);
        CHECK(cageform::bind_jacobians(coordinates, points, options).report.status ==
              Status::falloff_not_supported);
        const auto figure = cageform::bind(coordinates, cageform::FigurePoints{points, normals}, options);
        CHECK(figure.report.status == Status::falloff_not_supported);
        CHECK(figure.report.points.status == Status::falloff_not_supported);
        CHECK(
            cageform::bind(cageform::AnyCoordinates<double, 2>(coordinates), points, options).report.status ==
            Status::falloff_not_supported);
        Points2<double> many(100, points[0]);
        for (const std::size_t batch : {std::size_t{1}, std::size_t{1} << 24}) {
            const auto packed = cageform::pack(coordinates, many, {.bind = options, .batch = batch});
            CHECK(packed.report.status == Status::falloff_not_supported);
            CHECK(packed.report.bound.status == Status::falloff_not_supported);
        }
    };
    for (const double falloff : {-1.0, std::nan(""), HUGE_VAL, -HUGE_VAL}) {
        CAPTURE(falloff);
        for (const auto outside :
             {OutsidePoints::extend, OutsidePoints::keep_in_place, OutsidePoints::nearest_boundary}) {
            refused(closed, {.outside = outside, .falloff = falloff});
            refused(solver, {.outside = outside, .falloff = falloff});
        }
    }
    refused(closed, {.outside = OutsidePoints::keep_in_place, .falloff = 1});
    refused(solver, {.outside = OutsidePoints::keep_in_place, .falloff = 1});
    refused(solver, {.outside = OutsidePoints::extend, .falloff = 1});
    // Errors of the cage come first; without a falloff everything is valid.
    const Polygon<double> crossing(Points2<double>{{0, 0}, {1, 1}, {1, 0}, {0, 1}});
    CHECK(cageform::bind(Mean<double, 2>(crossing), points, {.falloff = -1}).report.status ==
          Status::cage_self_crossing);
    for (const double none : {0.0, -0.0}) {
        const auto kept =
            cageform::bind(closed, points, {.outside = OutsidePoints::keep_in_place, .falloff = none});
        CHECK(kept.report.status == Status::ok);
        CHECK(kept.report.faded.empty());
    }
}

TEMPLATE_TEST_CASE("any positive falloff gives finite weights", "[binding][falloff]", float, double) {
    using T = TestType;
    const Polygon<T> cage(Points2<T>{{0, 0}, {2, 0}, {2, 2}, {0, 2}});
    const T most = std::numeric_limits<T>::max(), nan = std::numeric_limits<T>::quiet_NaN();
    const Points2<T> points{{3, 1}, {T(2) + 8 * epsilon<T>, 1}, {most, most}, {-most, 0}, {nan, 0}, {1, 1}};
    const double least = std::numeric_limits<double>::denorm_min();
    for (const double falloff : {least, 1e-300, 1e-8, 1e8, 1e300, std::numeric_limits<double>::max()}) {
        for (const auto outside : {OutsidePoints::extend, OutsidePoints::nearest_boundary}) {
            CAPTURE(falloff, int(outside));
            const BindOptions options{.outside = outside, .falloff = falloff};
            const auto bound = cageform::bind(Mean<T, 2>(cage), points, options);
            const auto axes = cageform::bind_jacobians(Mean<T, 2>(cage), points, options);
            REQUIRE(bound.report.status == Status::ok);
            REQUIRE(axes.report.status == Status::ok);
            CHECK(bound.report.not_finite == std::vector<std::size_t>{4});
            for (std::size_t i = 0; i < points.size(); ++i) {
                CAPTURE(i);
                for (std::size_t h = 0; h < 4; ++h) {
                    CHECK(std::isfinite(bound.value.weight(i, h)));
                    for (const auto& axis : axes.value) CHECK(std::isfinite(axis.weight(i, h)));
                }
            }
        }
    }
}

} // namespace falloff_kept_tests
