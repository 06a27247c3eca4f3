// Binding straight into a packed binding: the bytes and reports of `bind` and `pack`.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/larger.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/parallel/threads.hpp>

namespace bind_packed_tests {

using namespace cageform_tests;
using cageform::Extreme;
using cageform::pack;
using cageform::PackOptions;
using cageform::Status;
using cageform::StreamedPackOptions;
using cageform::WeightFormat;

namespace {

bool same(const Extreme& a, const Extreme& b) {
    return a.point == b.point && a.value == b.value;
}

/// A batch contains the weights of a few blocks.
template <class C, class Points>
void check_same(const C& coordinates, const Points& points, StreamedPackOptions options, std::size_t blocks) {
    using T = typename C::scalar;
    options.batch = blocks * sizeof(cageform::Lanes<T>) * (coordinates.handles().size() + C::dimension);
    auto kept = coordinates;
    if constexpr (requires { kept.solve(); }) REQUIRE(kept.solve().status == Status::ok);
    const auto bound = cageform::bind(kept, points, options.bind);
    REQUIRE(bound.report.status == Status::ok);
    auto pack = options.pack;
    if (!pack.format) pack.format = WeightFormat::scalar;
    const auto packed = cageform::pack(bound.value, pack);
    REQUIRE(packed.report.status == Status::ok);
    for (const unsigned threads : {1u, 3u}) {
        cageform::Running running;
        if (threads > 1) running.parallel = cageform::ThreadedFor{threads};
        const auto at_once = cageform::pack(coordinates, points, options, running);
        REQUIRE(at_once.report.bound.status == Status::ok);
        REQUIRE(at_once.report.packed.status == Status::ok);
        const auto expected = packed.value.bytes(), found = at_once.value.bytes();
        REQUIRE(found.size() == expected.size());
        CHECK(std::equal(found.begin(), found.end(), expected.begin()));
        const auto &a = at_once.report.bound, &b = bound.report;
        CHECK(a.points == b.points);
        CHECK(a.on_boundary == b.on_boundary);
        CHECK(a.outside == b.outside);
        CHECK(a.faded == b.faded);
        CHECK(a.not_finite == b.not_finite);
        CHECK(a.unreached == b.unreached);
        CHECK(a.not_restored == b.not_restored);
        CHECK(a.partition_error.value == b.partition_error.value);
        CHECK(a.reproduction_error.value == b.reproduction_error.value);
        CHECK(a.weight_change.value == b.weight_change.value);
        CHECK(a.least_weight.value == b.least_weight.value);
        CHECK(a.amplification.value == b.amplification.value);
        CHECK(a.solver.cells == b.solver.cells);
        const auto &p = at_once.report.packed, &q = packed.report;
        CHECK(p.errors == q.errors);
        CHECK(p.distances == q.distances);
        CHECK(same(p.error, q.error));
        CHECK(p.distance.value == q.distance.value);
        CHECK(p.distance_pose == q.distance_pose);
        CHECK(std::fabs(p.mean_distance - q.mean_distance) <= 1e-12 * q.size);
        CHECK(p.size == q.size);
        CHECK(p.rows == q.rows);
        CHECK(p.rows_added == q.rows_added);
        CHECK(p.weights_per_point == q.weights_per_point);
        CHECK(p.bytes == q.bytes);
        CHECK(p.dense_bytes == q.dense_bytes);
        CHECK(p.points == q.points);
        CHECK(p.handles == q.handles);
        CHECK(p.format == q.format);
    }
}

} // namespace

TEMPLATE_TEST_CASE("pack of coordinates and points equals bind followed by pack", "[binding][pack][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    for (std::uint64_t seed = 0; seed < effort(3u, 1u); ++seed) {
        CAPTURE(seed);
        Random random(seed + 40);
        const cageform::Polygon<T> star(random_star<T>(seed));
        Points2<T> points;
        for (int n = 0; n < 211; ++n) points.push_back(random_inside(star, random, 1e-4));
        for (int n = 0; n < 90; ++n) points.push_back(points[std::size_t(random.uniform(0, 30))]); // seams
        points.push_back(star[0]);
        points.push_back(T(30) * star[1]);
        points.push_back({std::numeric_limits<T>::quiet_NaN(), T(0)});
        const cageform::MeanValueCoordinates<T, 2> mean_value(star);
        const double size = double(bounds_of(star.vertices()).diagonal());
        std::vector<double> poses;
        for (const auto& vertex : star.vertices()) {
            for (std::size_t k = 0; k < 2; ++k)
                poses.push_back(double(vertex[k]) + random.uniform(0, 0.1 * size));
        }
        std::vector<std::uint32_t> order(points.size());
        for (std::uint32_t n = 0; n < order.size(); ++n) order[n] = std::uint32_t(order.size()) - 1 - n;
        for (const std::size_t blocks : {1u, 3u}) {
            check_same(mean_value, points, {.pack = {.threshold = 1e-3}}, blocks);
            check_same(mean_value, points, {.bind = {.falloff = 40 * size}, .pack = {.threshold = 1e-3}},
                       blocks);
            check_same(mean_value, points, {.pack = {.format = WeightFormat::half}}, blocks);
            check_same(mean_value, points, {.pack = {.largest = 5, .order = order}}, blocks);
            check_same(mean_value, points,
                       {.bind = {.outside = cageform::OutsidePoints::keep_in_place},
                        .pack = {.format = WeightFormat::int16, .tolerance = 0.01 * size, .poses = poses}},
                       blocks);
        }
        check_same(cageform::HarmonicCoordinates<T, 2>(star), points, {.pack = {.threshold = 1e-4}}, 2);
    }
    const auto data = random_mesh(4);
    Points3<T> in_space;
    for (const auto& p : points_about(data, effort(300, 60), 2)) in_space.push_back(vec_cast<T>(p));
    const cageform::HarmonicCoordinates<T, 3> harmonic(data.template mesh<T>(),
                                                       {.accuracy = effort(0.02, 0.1)});
    // Several batches, so that functions are kept as by `solve`.
    check_same(harmonic, in_space, {.pack = {.format = WeightFormat::half, .threshold = 1e-3}}, 2);
}

TEST_CASE("few points are packed without keeping functions", "[binding][pack]") {
    const cageform::Polygon<double> star(random_star<double>(2));
    Random random(4);
    Points2<double> points;
    for (int n = 0; n < 20; ++n) points.push_back(random_inside(star, random, 1e-3));
    const cageform::HarmonicCoordinates<double, 2> coordinates(star);
    const auto packed = cageform::pack(coordinates, points, {.pack = {.threshold = 1e-3}});
    REQUIRE(packed.report.packed.status == Status::ok);
    const auto expected = cageform::pack(cageform::bind(coordinates, points).value,
                                         PackOptions{.format = WeightFormat::scalar, .threshold = 1e-3});
    CHECK(std::equal(packed.value.bytes().begin(), packed.value.bytes().end(), expected.value.bytes().begin(),
                     expected.value.bytes().end()));
    // The estimate has no functions and bounds the size of the result.
    const auto memory = pack_memory(coordinates, points.size());
    CHECK(memory.solver > 0);
    CHECK(memory.functions == 0);
    CHECK(memory.batch > 0);
    const auto dense = cageform::pack(coordinates, points);
    CHECK(dense.value.bytes().size() <= memory.packed + 2000); // the header and padding
    CHECK(pack_memory(coordinates, points.size(), {.batch = 1}).functions > 0);
}

TEST_CASE("errors of bind and pack have the index of the point among all", "[binding][pack][status]") {
    const cageform::Polygon<double> star(random_star<double>(2));
    Random random(4);
    Points2<double> points;
    for (int n = 0; n < 100; ++n) points.push_back(random_inside(star, random, 1e-3));
    const cageform::MeanValueCoordinates<double, 2> coordinates(star);
    const std::size_t batch = 1; // one block per batch
    const auto refused = [&](const PackOptions& pack) {
        const auto result = cageform::pack(coordinates, points, {.pack = pack, .batch = batch});
        CHECK(result.value.bytes().empty());
        return result.report.packed.status;
    };
    CHECK(refused({.largest = 2}) == Status::too_few_weights);
    const std::vector<std::uint32_t> twice(points.size(), 1);
    CHECK(refused({.largest = 4, .order = twice}) == Status::order_not_a_permutation);
    const auto coarse = cageform::pack(
        coordinates, points, {.pack = {.format = WeightFormat::int8, .tolerance = 1e-12}, .batch = batch});
    CHECK(coarse.report.packed.status == Status::format_too_coarse);
    CHECK(coarse.report.packed.culprit < points.size());
    CHECK(coarse.value.bytes().empty());
    const cageform::MeanValueCoordinates<double, 2> bad(
        cageform::Polygon<double>(Points2<double>{{0, 0}, {1, 0}}));
    CHECK(cageform::pack(bad, points, {.batch = batch}).report.bound.status == Status::too_few_vertices);
    // Cancellation at any time gives no result.
    const cageform::HarmonicCoordinates<double, 2> harmonic(star);
    double before = 0;
    for (const double at : {0.0, 0.2, 0.45, 0.6, 0.8, 0.99}) {
        cageform::Running running;
        running.progress = [&, last = 0.0](double done) mutable {
            CHECK(done >= last);
            last = done;
            before = larger(before, done);
            return done < at;
        };
        const auto result =
            cageform::pack(harmonic, points, {.pack = {.threshold = 1e-3}, .batch = batch}, running);
        CAPTURE(at);
        CHECK((result.report.bound.status == Status::cancelled ||
               result.report.packed.status == Status::cancelled));
        CHECK(result.value.bytes().empty());
    }
    CHECK(before <= 1);
}

} // namespace bind_packed_tests
