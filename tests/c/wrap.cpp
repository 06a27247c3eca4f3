// Wraps by the C interface: equality with C++, and refused arguments.
#include "../catch.hpp"
#include "../support/allocation_count.hpp"
#include "support.hpp"

#include <cageform/coordinates/mean_value.hpp>
#include <cageform/fit/wrap.hpp>

#include <cstring>
#include <string>

namespace c_interface_tests {

namespace {

/// Two ellipsoids, the target with a bump; points of the source's clothes; a cage of the source.
struct Figures {
    MeshData source = sphere(3), target = sphere(3), box = divided_box({1, 1, 2}, 1.2);
    std::vector<std::uint32_t> indices, box_indices;
    std::vector<Vec<double, 3>> clothes;
    std::vector<cageform_landmark> landmarks;

    /// Slender figures have few samples; `width` is relative to their height.
    explicit Figures(Random random, double width = 0.12) {
        const double bump = random.uniform(0.1, 0.2);
        for (auto& v : source.vertices) v = {width * v[0], width * v[1], v[2]};
        for (auto& v : target.vertices)
            v = {3 + 1.2 * width * v[0] * (1 + bump * v[2]), 0.9 * width * v[1],
                 1.1 * v[2] + bump * v[0] * v[2]};
        for (const auto& v : source.vertices) {
            if (random.below(3) == 0) clothes.push_back(1.04 * v);
        }
        for (const auto& face : source.faces) indices.insert(indices.end(), face.begin(), face.end());
        for (const auto& face : box.faces) box_indices.insert(box_indices.end(), face.begin(), face.end());
        for (const std::size_t i : {std::size_t(4), std::size_t(5)}) {
            const auto &from = source.vertices[i], &to = target.vertices[i];
            landmarks.push_back({{from[0], from[1], from[2]}, {to[0], to[1], to[2]}, i == 4 ? 0.0 : 2.0});
        }
    }
    cageform_drawing source_drawing() const { return drawing_of(source.vertices, indices); }
    cageform_drawing target_drawing() const { return drawing_of(target.vertices, indices); }
    cageform_wrap_options options() const {
        auto its = sized<cageform_wrap_options>();
        its.landmarks = landmarks.data();
        its.landmark_count = landmarks.size();
        its.follow = points_of(clothes);
        its.finest = 12;
        return its;
    }
    template <class T>
    void make_coordinates(std::uint32_t type, Owned<cageform_coordinates>& made) const {
        auto cage = sized<cageform_cage>();
        cage.kind = CAGEFORM_MESH;
        cage.vertices = points_of(box.vertices);
        cage.indices = box_indices.data();
        cage.index_count = box_indices.size();
        auto options = sized<cageform_coordinates_options>();
        options.type = type;
        options.scalar = std::is_same_v<T, double> ? CAGEFORM_DOUBLE : CAGEFORM_FLOAT;
        REQUIRE(cageform_coordinates_create(&cage, &options, &made.object, nullptr) == CAGEFORM_OK);
    }
};

template <class T>
bool same_points(const cageform_points& view, const std::vector<Vec<T, 3>>& points) {
    return view.count == points.size() && view.bytes == points.size() * sizeof(Vec<T, 3>) &&
           (points.empty() || std::memcmp(view.data, points.data(), view.bytes) == 0);
}

/// Compares a wrap with that of C++.
///
///   move   moves points by the map of C++
template <class T, class Move>
void check_bits(const Figures& its, const cageform_coordinates* coordinates,
                const cageform::Result<cageform::Wrap<T>, cageform::WrapReport>& expected, const Move& move) {
    REQUIRE(expected.status() == cageform::Status::ok);
    const auto source = its.source_drawing(), target = its.target_drawing();
    const auto options = its.options();
    auto running = sized<cageform_running>();
    running.threads = 2;
    auto report = sized<cageform_report>();
    Owned<cageform_wrap> wrap;
    REQUIRE(cageform_fit_wrap(coordinates, &source, &target, &options, &running, &wrap.object, &report) ==
            CAGEFORM_OK);
    const auto& wanted = expected.report;
    CHECK(report.to_target_upper == wanted.to_target.upper);
    CHECK(report.to_source_largest == wanted.to_source.largest);
    CHECK(report.miss == wanted.miss);
    CHECK(report.culprit == wanted.missed);
    CHECK(report.height == wanted.height);
    CHECK(report.least_stretch == wanted.least_stretch);
    CHECK(report.samples == wanted.samples);
    CHECK(report.ended == std::uint32_t(wanted.ended));

    auto info = sized<cageform_wrap_info>();
    REQUIRE(cageform_wrap_describe(wrap.object, &info) == CAGEFORM_OK);
    const auto& map = expected.value;
    for (std::size_t k = 0; k < 3; ++k) {
        CHECK(info.first[9 + k] == double(map.first.translation[k]));
        for (std::size_t n = 0; n < 3; ++n) CHECK(info.first[3 * k + n] == double(map.first.columns[k][n]));
    }
    CHECK(same_points(info.pose, map.pose));
    CHECK(same_points(info.lattice_pose, map.lattice_pose));

    std::vector<Vec<T, 3>> points, moved;
    for (const auto& p : its.clothes) points.push_back({T(p[0]), T(p[1]), T(p[2])});
    moved = points;
    std::vector<std::array<Vec<T, 3>, 3>> matrices(points.size());
    REQUIRE(move(map, points, moved, matrices) == cageform::Status::ok);
    auto out = points;
    std::vector<Vec<double, 9>> jacobians(points.size());
    const auto to_jacobians = output_of(jacobians);
    REQUIRE(cageform_wrap_move(wrap.object, points_of(out), output_of(out), &to_jacobians, &running) ==
            CAGEFORM_OK);
    CHECK(out == moved);
    bool same = true;
    for (std::size_t n = 0; n < points.size(); ++n) {
        for (std::size_t k = 0; k < 9; ++k)
            same = same && jacobians[n][k] == double(matrices[n][k / 3][k % 3]);
    }
    CHECK(same);
}

template <class T>
void check_bits_with_cage(const Figures& its, const cageform::SurfaceMesh& source,
                          const cageform::SurfaceMesh& target, const cageform::WrapOptions& options) {
    const cageform::MeanValueCoordinates coordinates(its.box.template mesh<T>());
    Owned<cageform_coordinates> given;
    its.make_coordinates<T>(CAGEFORM_MEAN_VALUE, given);
    check_bits<T>(its, given.object, cageform::wrap(coordinates, source, target, options),
                  [&](const auto& map, const auto& points, auto& out, auto& jacobians) {
                      return cageform::move(map, coordinates, points, out, jacobians);
                  });
}

} // namespace

TEST_CASE("wraps equal those of C++ bit for bit", "[c]") {
    const std::uint64_t seed = 20261201;
    CAPTURE(seed);
    const Figures its{Random(seed)};
    const cageform::SurfaceMesh source(its.source.vertices, its.source.faces),
        target(its.target.vertices, its.target.faces);
    std::vector<cageform::Landmark> landmarks;
    for (const auto& [from, to, weight] : its.landmarks)
        landmarks.push_back({{from[0], from[1], from[2]}, {to[0], to[1], to[2]}, weight == 0 ? 1 : weight});
    cageform::WrapOptions options;
    options.landmarks = landmarks;
    options.follow = its.clothes;
    options.finest = 12;
    check_bits<double>(its, nullptr, cageform::wrap(source, target, options),
                       [](const auto& map, const auto& points, auto& out, auto& jacobians) {
                           return cageform::move(map, points, out, jacobians);
                       });
    check_bits_with_cage<float>(its, source, target, options);
    check_bits_with_cage<double>(its, source, target, options);
}

TEST_CASE("a bad fit is given with its status", "[c]") {
    const Figures its(Random(20261202), 0.3);
    auto inside_out = its.indices;
    for (std::size_t f = 0; f < inside_out.size(); f += 3) std::swap(inside_out[f], inside_out[f + 1]);
    const auto source = its.source_drawing(), target = drawing_of(its.target.vertices, inside_out);
    auto options = sized<cageform_wrap_options>();
    options.finest = 6;
    options.least_stiffness = 1e-2;
    auto report = sized<cageform_report>();
    Owned<cageform_wrap> wrap;
    CHECK(cageform_fit_wrap(nullptr, &source, &target, &options, nullptr, &wrap.object, &report) ==
          CAGEFORM_FIT_NOT_REACHED);
    CHECK(report.unmatched_source > 0.5);
    auto moved = its.clothes;
    CHECK(cageform_wrap_move(wrap.object, points_of(its.clothes), output_of(moved), nullptr, nullptr) ==
          CAGEFORM_OK);
    CHECK(moved != its.clothes);
}

TEST_CASE("wraps refuse wrong arguments", "[c]") {
    Figures its{Random(20261203)};
    const auto source = its.source_drawing(), target = its.target_drawing();
    const auto options = its.options();
    Owned<cageform_wrap> wrap;
    const auto refused = [&](const cageform_drawing& from, const cageform_drawing& to,
                             const cageform_wrap_options& choice, cageform_status wanted,
                             const char* culprit = "", const cageform_coordinates* coordinates = nullptr) {
        auto report = sized<cageform_report>();
        const auto status =
            cageform_fit_wrap(coordinates, &from, &to, &choice, nullptr, &wrap.object, &report);
        CAPTURE(report.message);
        CHECK(std::string(cageform_status_name(status)) == cageform_status_name(wanted));
        CHECK(std::string(report.message).find(culprit) != std::string::npos);
        CHECK(wrap.object == nullptr);
        return report;
    };
    CHECK(cageform_fit_wrap(nullptr, nullptr, &target, nullptr, nullptr, &wrap.object, nullptr) ==
          CAGEFORM_ARGUMENT_NULL);
    CHECK(cageform_fit_wrap(nullptr, &source, nullptr, nullptr, nullptr, &wrap.object, nullptr) ==
          CAGEFORM_ARGUMENT_NULL);
    CHECK(cageform_fit_wrap(nullptr, &source, &target, nullptr, nullptr, nullptr, nullptr) ==
          CAGEFORM_ARGUMENT_NULL);
    auto drawing = source;
    drawing.size = 0;
    refused(source, drawing, options, CAGEFORM_SIZE_NOT_SET);
    drawing = source;
    drawing.index_count -= 1;
    refused(drawing, target, options, CAGEFORM_COUNTS_DO_NOT_MATCH);
    drawing = source;
    drawing.points.dimension = 2;
    refused(source, drawing, options, CAGEFORM_DIMENSION_DIFFERS);
    refused(sized<cageform_drawing>(), target, options, CAGEFORM_FIGURE_EMPTY);
    CHECK(refused(source, sized<cageform_drawing>(), options, CAGEFORM_FIGURE_EMPTY).of_target == 1);

    auto vertices = its.target.vertices;
    vertices[5][1] = NAN;
    auto report = refused(source, drawing_of(vertices, its.indices), options, CAGEFORM_FIGURE_NOT_FINITE,
                          "(target vertex 5)");
    CHECK(report.culprit == 5);
    CHECK(report.of_target == 1);
    auto indices = its.indices;
    indices[3 * 7 + 1] = std::uint32_t(vertices.size());
    report = refused(drawing_of(its.source.vertices, indices), target, options, CAGEFORM_INDEX_OUT_OF_RANGE,
                     "(source face 7)");
    CHECK(report.of_target == 0);

    auto choice = options;
    choice.size = 3;
    refused(source, target, choice, CAGEFORM_SIZE_NOT_SET);
    choice = options;
    choice.landmarks = nullptr;
    refused(source, target, choice, CAGEFORM_ARGUMENT_NULL);
    for (const double wrong : {-0.1, 1.0, double(NAN)}) {
        choice = options;
        choice.floor = wrong;
        refused(source, target, choice, CAGEFORM_VALUE_NOT_FINITE);
    }
    choice = options;
    choice.finest = UINT32_MAX;
    refused(source, target, choice, CAGEFORM_VALUE_NOT_FINITE);
    its.clothes[2][0] = INFINITY;
    refused(source, target, options, CAGEFORM_VALUE_NOT_FINITE, "(follower 2)");
    its.landmarks[1].weight = -1;
    refused(source, target, options, CAGEFORM_WEIGHTS_NOT_POSITIVE, "(landmark 1)");
    its.landmarks[1].target[2] = NAN;
    refused(source, target, options, CAGEFORM_VALUE_NOT_FINITE, "(landmark 1)");
}

TEST_CASE("wraps refuse wrong objects, and moves write all or nothing", "[c]") {
    const Figures its{Random(20261204)};
    const auto source = its.source_drawing(), target = its.target_drawing();
    auto options = sized<cageform_wrap_options>();
    options.finest = 6; // the cage alone
    Owned<cageform_wrap> wrap, none;
    Owned<cageform_coordinates> coordinates, plane;
    its.make_coordinates<float>(CAGEFORM_MEAN_VALUE, coordinates);
    const std::vector<Vec<double, 2>> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    auto polygon = sized<cageform_cage>();
    polygon.vertices = points_of(square);
    REQUIRE(cageform_coordinates_create(&polygon, nullptr, &plane.object, nullptr) == CAGEFORM_OK);
    const auto fit = [&](const void* with, Owned<cageform_wrap>& made) {
        return cageform_fit_wrap(static_cast<const cageform_coordinates*>(with), &source, &target, &options,
                                 nullptr, &made.object, nullptr);
    };
    REQUIRE(fit(coordinates.object, wrap) == CAGEFORM_OK);
    CHECK(fit(plane.object, none) == CAGEFORM_DIMENSION_DIFFERS);
    CHECK(fit(wrap.object, none) == CAGEFORM_OBJECT_OF_ANOTHER_KIND);
    CHECK(none.object == nullptr);

    auto info = sized<cageform_wrap_info>();
    REQUIRE(cageform_wrap_describe(wrap.object, &info) == CAGEFORM_OK);
    CHECK(info.lattice == nullptr);
    CHECK(info.pose.count == its.box.vertices.size());
    const auto points = its.clothes;
    auto out = points;
    std::vector<Vec<float, 9>> few(points.size() - 1);
    const auto to_few = output_of(few);
    CHECK(cageform_wrap_move(wrap.object, points_of(points), output_of(out), &to_few, nullptr) ==
          CAGEFORM_OUTPUT_TOO_SMALL);
    std::size_t failures = 0;
    for (;; ++failures) {
        failing_allocation = allocations + 1 + failures;
        const cageform_status status =
            cageform_wrap_move(wrap.object, points_of(points), output_of(out), nullptr, nullptr);
        failing_allocation = 0;
        if (status == CAGEFORM_OK) break;
        REQUIRE(status == CAGEFORM_OUT_OF_MEMORY);
        REQUIRE(out == points);
    }
    CHECK(failures > 3);
    CHECK(out != points);
}

} // namespace c_interface_tests
