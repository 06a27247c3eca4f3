// Cages with faces that are not planar: fans, for mean value, harmonic and Green coordinates.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/gradients.hpp"
#include "../support/green.hpp"
#include "../support/larger.hpp"
#include "../support/polyhedra.hpp"
#include "../support/uniform_harmonic.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <nlohmann/json.hpp>

#include <fstream>

namespace fans_tests {

using namespace cageform_tests;
using cageform::GreenCoordinates;
using cageform::HarmonicOptions;
using cageform::MeanValueCoordinates;
using cageform::PolyhedralMesh;
using cageform::PolyhedralOptions;
using cageform::TriangleMesh;

namespace {

template <class T>
using MeanValue = MeanValueCoordinates<T, 3, PolyhedralMesh<T>>;
template <class T>
using Green = GreenCoordinates<T, 3, PolyhedralMesh<T>>;
template <class T>
using Harmonic = cageform::HarmonicCoordinates<T, 3, PolyhedralMesh<T>>;
template <class T>
using UniformHarmonic = cageform_tests::UniformHarmonic<T, 3, PolyhedralMesh<T>>;

static_assert(cageform::GradientCoordinates<Green<float>>);

PolyhedralOptions fans(std::uint32_t divisions = 1) {
    return {.faces = PolyhedralOptions::Faces::fan, .divisions = divisions};
}
constexpr PolyhedralOptions where_needed{.non_planar = PolyhedralOptions::NonPlanar::fan};

double number(const nlohmann::json& x) {
    return x.is_string() ? std::stod(x.get<std::string>()) : x.get<double>();
}
std::vector<double> numbers(const nlohmann::json& list) {
    std::vector<double> result;
    for (const auto& x : list) result.push_back(number(x));
    return result;
}
Vec<double, 3> place(const nlohmann::json& list) {
    return {number(list[0]), number(list[1]), number(list[2])};
}
std::vector<Vec<double, 3>> places(const nlohmann::json& list) {
    std::vector<Vec<double, 3>> result;
    for (const auto& p : list) result.push_back(place(p));
    return result;
}
nlohmann::json read(const std::string& name) {
    std::ifstream file(std::string(CAGEFORM_TEST_DATA) + "/quads/" + name + ".json");
    return nlohmann::json::parse(file);
}
PolyhedronData cage_of(const nlohmann::json& json) {
    return {places(json["cage"]["vertices"]), json["cage"]["faces"].get<Loops>()};
}

/// A prism over a polygon of 3 to 8 corners (`corners` unless 0) that is star-shaped about its mean, with
/// vertices moved by up to an eighth. Loops begin at random corners.
PolyhedronData random_warped(std::uint64_t seed, std::size_t corners = 0) {
    Random random(seed);
    const std::size_t n = corners != 0 ? corners : 3 + random.below(6);
    std::vector<Vec<double, 2>> base;
    for (std::size_t k = 0; k < n; ++k) {
        const double angle = 2 * std::numbers::pi * double(k) / double(n), radius = random.uniform(0.8, 1);
        base.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    auto data = prism_over(base, random.uniform(0.8, 1.5));
    for (auto& v : data.vertices) {
        for (std::size_t k = 0; k < 3; ++k) v[k] += random.uniform(-0.125, 0.125);
    }
    for (auto& face : data.faces)
        std::rotate(face.begin(), face.begin() + std::ptrdiff_t(random.below(face.size())), face.end());
    return data;
}

template <class T>
Vec<T, 3> random_point(const PolyhedralMesh<T>& mesh, Random& random, double beyond = 0) {
    const auto bounds = bounds_of(mesh.vertices());
    Vec<T, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
        p[k] = T(double(bounds.lower[k]) +
                 random.uniform(-beyond, 1 + beyond) * (double(bounds.upper[k]) - double(bounds.lower[k])));
    return p;
}

/// Points inside, around and far away; on and next to faces, edges, vertices and means of faces.
template <class T>
std::vector<Vec<T, 3>> points_about(const PolyhedralMesh<T>& mesh, std::uint64_t seed) {
    Random random(seed + 5);
    const auto& surface = mesh.triangles();
    std::vector<Vec<T, 3>> points(surface.vertices().begin(), surface.vertices().end());
    for (std::size_t n = 0; n < 40; ++n) points.push_back(random_point(mesh, random, 0.5));
    for (std::size_t n = 0; n < 5; ++n) points.push_back(random_point(mesh, random, 100));
    for (const auto& face : surface.faces()) {
        const auto a = surface[face[0]], b = surface[face[1]], m = surface[face[2]];
        points.push_back(T(0.25) * a + T(0.75) * b);
        points.push_back(T(0.5) * a + (T(0.25) * b + T(0.25) * m));
        auto beside = points.back();
        for (std::size_t k = 0; k < 3; ++k) beside[k] += T(random.uniform(-1e-5, 1e-5));
        points.push_back(beside);
    }
    return points;
}

/// Weights of vertices and vectors from weights of the fan mesh's points and vectors.
template <class T>
std::vector<T> folded(const PolyhedralMesh<T>& mesh, const std::vector<T>& row) {
    std::vector<T> result(row.begin(), row.begin() + std::ptrdiff_t(mesh.size()));
    for (std::size_t n = 0; n < mesh.fan_points().size(); ++n) {
        mesh.fan_points().for_each_corner(
            n, [&](std::uint32_t v, double weight) { result[v] += T(weight) * row[mesh.size() + n]; });
    }
    result.insert(result.end(), row.begin() + std::ptrdiff_t(mesh.triangles().size()), row.end());
    return result;
}

} // namespace

TEST_CASE("fans: reference values", "[coordinates][fans][oracle]") {
    const std::string name =
        GENERATE("quads_cube_planar", "quads_cube_twisted", "quads_cube_warped", "quads_prism5");
    CAPTURE(name);
    const auto json = read(name);
    const auto data = cage_of(json);
    const PolyhedralMesh<double> mesh(data.vertices, data.faces, fans());
    const auto& surface = mesh.triangles();
    REQUIRE(check(mesh).status == Status::ok);

    const auto means = json["means_of_faces"].get<Loops>();
    REQUIRE(mesh.fan_points().size() == means.size());
    for (std::size_t n = 0; n < means.size(); ++n) {
        const auto corners = mesh.fan_points().corners(n);
        CHECK(std::is_permutation(corners.begin(), corners.end(), means[n].begin(), means[n].end()));
    }
    const auto triangles = json["fan_triangles"].get<std::vector<std::array<std::uint32_t, 3>>>();
    CHECK(std::equal(surface.faces().begin(), surface.faces().end(), triangles.begin(), triangles.end()));

    const MeanValue<double> mean_value(mesh);
    const Green<double> green(mesh);
    const auto pose = places(json["pose"]);
    const auto vectors = places(json["vector_handles"]), posed = places(json["posed_vector_handles"]);
    REQUIRE(green.handles().size() == data.vertices.size() + vectors.size());
    const auto points = places(json["points"]);
    const auto by_mean_value = cageform::bind(mean_value, points), by_green = cageform::bind(green, points);
    REQUIRE(by_mean_value.status() == Status::ok);
    REQUIRE(by_green.status() == Status::ok);
    const auto handles = posed_handles(by_green.value, pose);
    for (std::size_t n = 0; n < vectors.size(); ++n) {
        CHECK(distance(green.handles()[data.vertices.size() + n], vectors[n]) <= 1e-15);
        CHECK(distance(handles[data.vertices.size() + n], posed[n]) <= 1e-15);
    }
    std::vector<Vec<double, 3>> moved(points.size()), turned(points.size());
    REQUIRE(clone(by_mean_value.value, pose, moved) == Status::ok);
    REQUIRE(clone(by_green.value, handles, turned) == Status::ok);
    const auto found = evaluate_all(mean_value, points), of_green = evaluate_all(green, points);
    REQUIRE(json["rows"].size() == points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        const auto& row = json["rows"][i];
        CHECK(found.states[i] == PointState::inside);
        CHECK(difference(found.rows[i], numbers(row["mean_value_fan"])) <= 1e-13);
        auto expected = numbers(row["green_fan_points"]);
        const auto of_vectors = numbers(row["green_fan_vectors"]);
        expected.insert(expected.end(), of_vectors.begin(), of_vectors.end());
        CHECK(difference(of_green.rows[i], expected) <= 1e-13);
        CHECK(distance(moved[i], place(row["posed_mean_value"])) <= 1e-13);
        CHECK(distance(turned[i], place(row["posed_green"])) <= 1e-13);
    }
    for (const auto& on_face : json["on_face"]) {
        std::vector<double> expected(data.vertices.size()), row(data.vertices.size());
        for (const auto& [vertex, weight] : on_face["weights"].items())
            expected[std::stoul(vertex)] = number(weight);
        CHECK(weights_at(mean_value, place(on_face["point"]), std::span(row)) == PointState::on_boundary);
        CHECK(difference(row, expected) <= 1e-13);
    }

    const auto report = check(mesh);
    REQUIRE(report.fan_distances.size() == report.faults.size());
    for (std::size_t n = 0; n < report.faults.size(); ++n) {
        const auto& [kind, face, none] = report.faults[n];
        CHECK(kind == cageform::CageFaultKind::face_fanned);
        if (data.faces[face].size() != 4) continue;
        const double expected = number(json["fan_gap_to_bilinear_bound"][face]);
        CHECK(std::fabs(report.fan_distances[n] - expected) <= 1e-15);
    }
}

TEST_CASE("divided faces converge to the mean value integral over bilinear patches",
          "[coordinates][fans][oracle]") {
    const std::string name = GENERATE("quads_cube_planar", "quads_cube_twisted", "quads_cube_warped");
    CAPTURE(name);
    const auto json = read(name);
    const auto data = cage_of(json);
    double before = 1;
    for (const std::uint32_t divisions : {1u, 2u, 4u, 8u}) {
        const MeanValue<double> mean_value(
            PolyhedralMesh<double>(data.vertices, data.faces, fans(divisions)));
        REQUIRE(mean_value.cage_report().status == Status::ok);
        double worst = 0;
        for (const auto& row : json["rows"]) {
            std::vector<double> found(data.vertices.size());
            (void)weights_at(mean_value, place(row["point"]), std::span(found));
            worst = larger(worst, difference(found, numbers(row["mean_value_bilinear"])));
        }
        CAPTURE(divisions, worst);
        CHECK(worst <= before / 4); // measured: from 0.025 by 18 to 40, by 37 to 48, by 16
        before = worst;
        if (divisions == 4) CHECK(worst <= 1e-4); // measured: 3e-5
    }
}

TEMPLATE_TEST_CASE("weights on fans are those on their triangles, folded, bit for bit", "[coordinates][fans]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(range<std::uint64_t>(0, effort(20u, 3u)));
    CAPTURE(seed);
    const auto data = random_warped(seed, 4); // 1/4 of a weight is exact, with or without fused products
    const std::uint32_t divisions = seed % 4 == 3 ? 2 : 1;
    const PolyhedralMesh<T> mesh(data.vertices, data.faces, fans(divisions));
    const TriangleMesh<T> triangles(mesh.triangles().vertices(), mesh.triangles().faces());
    const auto points = points_about(mesh, seed);
    const auto compare = [&](const auto& coordinates, const auto& direct) {
        const auto found = evaluate_all(coordinates, points), whole = evaluate_all(direct, points);
        REQUIRE(found.status() == Status::ok);
        REQUIRE(whole.status() == Status::ok);
        CHECK(found.states == whole.states);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i, points[i][0], points[i][1], points[i][2], int(found.states[i]));
            // On divided faces, where three points share corners, the order of sums differs.
            const bool exact = divisions == 1 || found.states[i] != PointState::on_boundary;
            const auto expected = folded(mesh, whole.rows[i]);
            if (exact)
                CHECK(found.rows[i] == expected);
            else
                CHECK(difference(found.rows[i], expected) <= 4 * cageform::epsilon<T>);
        }
    };
    compare(MeanValue<T>(mesh), MeanValueCoordinates<T, 3>(triangles));
    if (divisions == 1) compare(Green<T>(mesh), GreenCoordinates<T, 3>(triangles));
}

TEMPLATE_TEST_CASE("weights on fans reproduce points and affine poses, wherever a face's list begins",
                   "[coordinates][fans]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(range<std::uint64_t>(0, effort(20u, 3u)));
    CAPTURE(seed);
    const auto data = random_warped(seed);
    auto rotated = data;
    for (auto& face : rotated.faces) std::rotate(face.begin(), face.begin() + 1, face.end());
    const double rounding = 200 * double(cageform::epsilon<T>);
    const auto compare = [&]<class C>(const PolyhedralOptions& options, const C*) {
        const C one(PolyhedralMesh<T>(data.vertices, data.faces, options));
        const C other(PolyhedralMesh<T>(rotated.vertices, rotated.faces, options));
        const auto &surface = one.cage().triangles(), &same = other.cage().triangles();
        CHECK(std::equal(surface.vertices().begin(), surface.vertices().end(), same.vertices().begin(),
                         same.vertices().end()));
        std::vector<Vec<T, 3>> points;
        Random random(seed);
        while (points.size() < 50) points.push_back(random_point(one.cage(), random, 0.3));
        const auto found = evaluate_all(one, points), again = evaluate_all(other, points);
        REQUIRE(found.status() == Status::ok);
        REQUIRE(again.status() == Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i, points[i][0], points[i][1], points[i][2]);
            CHECK(missed(one, found.rows[i], points[i]) <= rounding);
            const std::vector<T> a(found.rows[i].begin(),
                                   found.rows[i].begin() + std::ptrdiff_t(one.cage().size()));
            const std::vector<T> b(again.rows[i].begin(),
                                   again.rows[i].begin() + std::ptrdiff_t(one.cage().size()));
            CHECK(difference(a, b) <= 10 * rounding * absolute_sum(a));
        }
    };
    const MeanValue<T>* const mean_value = nullptr;
    const Green<T>* const green = nullptr;
    compare(fans(), mean_value);
    compare(fans(3), mean_value);
    compare(where_needed, mean_value);
    compare(fans(), green);
}

TEMPLATE_TEST_CASE("on a fan weights are linear on each triangle", "[coordinates][fans]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(range<std::uint64_t>(0, effort(12u, 2u)));
    CAPTURE(seed);
    const auto data = random_warped(seed);
    const PolyhedralMesh<T> mesh(data.vertices, data.faces, fans());
    const MeanValue<T> mean_value(mesh);
    HarmonicOptions options;
    options.resolution = 16;
    const UniformHarmonic<T> harmonic(mesh, options);
    const double rounding = 64 * double(cageform::epsilon<T>);
    Random random(seed);
    std::vector<Vec<T, 3>> points;
    std::vector<std::vector<double>> expected;
    const auto add = [&](const std::vector<double>& weights) {
        Vec<double, 3> p{};
        for (std::size_t v = 0; v < weights.size(); ++v) p = p + weights[v] * vec_cast<double>(mesh[v]);
        points.push_back(vec_cast<T>(p));
        expected.push_back(weights);
    };
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        const auto n = loop.size();
        for (int repeat = 0; n > 3 && repeat < 3; ++repeat) {
            const std::size_t k = random.below(n);
            auto shares = random_shares(3, random);
            if (repeat == 1) shares = {0, 0, 1}; // the mean
            if (repeat == 2) shares = {0.25, 0.75, 0};
            std::vector<double> weights(mesh.size(), 0.0);
            weights[loop[k]] += shares[0];
            weights[loop[(k + 1) % n]] += shares[1];
            for (const auto v : loop) weights[v] += shares[2] / double(n);
            add(weights);
        }
    }
    for (std::size_t v = 0; v < mesh.size(); ++v) {
        std::vector<double> weights(mesh.size(), 0.0);
        weights[v] = 1;
        add(weights);
    }
    const auto compare = [&](const auto& coordinates) {
        const auto found = evaluate_all(coordinates, points);
        REQUIRE(found.status() == Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i);
            // Rounding may move a point off the face, so it may count as inside, with nearby weights.
            CHECK(difference(found.rows[i], expected[i]) <= 100 * rounding);
        }
    };
    compare(mean_value);
    compare(harmonic);
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::vector<T> row(mesh.size());
        const auto nearest = mean_value.nearest_boundary(points[i], row);
        CHECK(distance(nearest, points[i]) <= rounding);
        CHECK(difference(row, expected[i]) <= rounding);
    }
}

TEST_CASE("points on divided faces have bilinear weights", "[coordinates][fans]") {
    const auto seed = GENERATE(range<std::uint64_t>(0, effort(10u, 2u)));
    CAPTURE(seed);
    const auto data = random_warped(seed);
    const std::uint32_t k = 2 + std::uint32_t(seed % 3);
    const PolyhedralMesh<double> mesh(data.vertices, data.faces, fans(k));
    REQUIRE(check(mesh).status == Status::ok);
    const MeanValue<double> mean_value(mesh);
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        if (loop.size() != 4) continue;
        const auto [first, last] = mesh.triangles_of(f);
        CHECK(last - first == 4 * k * k);
        for (std::uint32_t j = 0; j <= k; ++j) {
            for (std::uint32_t i = 0; i <= k; ++i) {
                const double u = double(i) / k, v = double(j) / k;
                std::vector<double> expected(mesh.size(), 0.0), row(mesh.size());
                expected[loop[0]] = (1 - u) * (1 - v);
                expected[loop[1]] = u * (1 - v);
                expected[loop[2]] = u * v;
                expected[loop[3]] = (1 - u) * v;
                Vec<double, 3> p{};
                for (const auto c : loop) p = p + expected[c] * mesh[c];
                CHECK(weights_at(mean_value, p, std::span(row)) == PointState::on_boundary);
                CHECK(difference(row, expected) <= 1e-14);
            }
        }
    }
}

TEST_CASE("harmonic weights on fans are those on their triangles, folded", "[coordinates][fans][harmonic]") {
    const auto seed = GENERATE(range<std::uint64_t>(0, effort(4u, 1u)));
    CAPTURE(seed);
    const auto data = random_warped(seed);
    const auto divisions = std::uint32_t(1 + seed % 2);
    const PolyhedralMesh<double> mesh(data.vertices, data.faces, fans(divisions));
    const TriangleMesh<double> triangles(mesh.triangles().vertices(), mesh.triangles().faces());
    std::vector<Vec<double, 3>> points;
    Random random(seed);
    while (points.size() < 100) points.push_back(random_point(mesh, random));
    const auto compare = [&](const auto& coordinates, const auto& direct, double tolerance) {
        const auto found = evaluate_all(coordinates, points), whole = evaluate_all(direct, points);
        REQUIRE(found.status() == Status::ok);
        REQUIRE(whole.status() == Status::ok);
        CHECK(found.states == whole.states);
        std::size_t inside = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (found.states[i] != PointState::inside) continue;
            ++inside;
            CAPTURE(i);
            CHECK(difference(found.rows[i], folded(mesh, whole.rows[i])) <= tolerance);
            CHECK(*std::min_element(found.rows[i].begin(), found.rows[i].end()) >= -tolerance);
            CHECK(std::fabs(double(sum_of(found.rows[i])) - 1) <= tolerance);
            CHECK(distance(combine(found.rows[i], mesh.vertices()), points[i]) <= 4 * tolerance);
        }
        CHECK(inside > 30);
    };
    HarmonicOptions options;
    options.resolution = divisions == 1 ? 24 : 48; // every point of the fans needs a node nearby
    options.multigrid.tolerance = 1e-9;
    compare(UniformHarmonic<double>(mesh, options),
            cageform::HarmonicCoordinates<double, 3>(triangles, options, cageform::UniformGrid{}), 1e-7);
    const HarmonicOptions adaptive{.accuracy = effort(2e-3, 1e-2)};
    // Both have discretisation errors. Triangles have a near field; fans do not, and their errors next to
    // small triangles exceed the accuracy (options.hpp).
    compare(Harmonic<double>(mesh, adaptive), cageform::HarmonicCoordinates<double, 3>(triangles, adaptive),
            3 * adaptive.accuracy);
}

TEST_CASE("poses of fans: bits at rest, similarities, and the cage of triangles",
          "[coordinates][fans][green]") {
    const auto seed = GENERATE(range<std::uint64_t>(0, effort(20u, 3u)));
    CAPTURE(seed);
    const auto data = random_warped(seed);
    const PolyhedralMesh<double> mesh(data.vertices, data.faces, seed % 2 == 0 ? fans() : where_needed);
    const Green<double> green(mesh);
    Random random(seed);
    std::vector<Vec<double, 3>> points;
    while (points.size() < 60) points.push_back(random_point(mesh, random, 0.2));
    const auto bound = cageform::bind(green, points);
    REQUIRE(bound.status() == Status::ok);
    const auto packed = cageform::pack(bound.value);
    REQUIRE(packed.report.status == Status::ok);
    const auto opened = cageform::open_blob<double, 3>(packed.value.bytes());
    REQUIRE(opened.status() == Status::ok);
    const std::vector<Vec<double, 3>> rest(green.handles().begin(), green.handles().end());
    CHECK(posed_handles(bound.value, data.vertices) == rest);

    // If one vertex moves, vectors of other faces are bitwise unchanged.
    auto pose = data.vertices;
    const std::size_t moved = random.below(pose.size());
    pose[moved][random.below(3)] += 0.05;
    const auto handles = posed_handles(bound.value, pose);
    std::vector<Vec<double, 3>> of_blob(handles.size());
    REQUIRE(cageform::pose_handles(opened.value, pose, of_blob).status == Status::ok);
    CHECK(of_blob == handles);
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        const bool moves = std::find(loop.begin(), loop.end(), moved) != loop.end();
        const auto [first, last] = mesh.triangles_of(f);
        std::size_t same = 0;
        for (std::size_t t = first; t < last; ++t)
            same += handles[mesh.size() + t] == rest[mesh.size() + t] ? 1 : 0;
        if (!moves) CHECK(same == last - first);
        if (moves && mesh.is_fan(f)) CHECK(same == 0); // all triangles of a fan share its mean
    }

    // The clone equals that of the triangle mesh whose means are posed as means of posed corners.
    const TriangleMesh<double> triangles(mesh.triangles().vertices(), mesh.triangles().faces());
    const auto direct = cageform::bind(GreenCoordinates<double, 3>(triangles), points);
    REQUIRE(direct.status() == Status::ok);
    auto longer = pose;
    for (std::size_t n = 0; n < mesh.fan_points().size(); ++n) {
        Vec<double, 3> mean{};
        mesh.fan_points().for_each_corner(
            n, [&](std::uint32_t v, double weight) { mean = mean + weight * pose[v]; });
        longer.push_back(mean);
    }
    std::vector<Vec<double, 3>> one(points.size()), other(points.size());
    REQUIRE(clone(bound.value, handles, one) == Status::ok);
    REQUIRE(clone(direct.value, posed_handles(direct.value, longer), other) == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) CHECK(distance(one[i], other[i]) <= 1e-13);

    for (std::size_t v = 0; v < pose.size(); ++v) {
        const auto& p = data.vertices[v]; // axes permuted, scaled, moved
        pose[v] = {1.5 * p[1] + 3, 1.5 * p[2] - 1, 1.5 * p[0] + 0.25};
    }
    REQUIRE(clone(bound.value, posed_handles(bound.value, pose), one) == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec<double, 3> expected{1.5 * points[i][1] + 3, 1.5 * points[i][2] - 1,
                                      1.5 * points[i][0] + 0.25};
        CHECK(distance(one[i], expected) <= 1e-13);
    }
}

TEST_CASE("gradients on fans are those of the weights", "[coordinates][fans][gradients]") {
    const auto seed = GENERATE(range<std::uint64_t>(0, effort(8u, 2u)));
    CAPTURE(seed);
    const auto data = random_warped(seed);
    Random random(seed);
    const auto compare = [&](const auto& coordinates) {
        std::vector<Vec<double, 3>> points;
        while (points.size() < 20) {
            const auto p = random_point(coordinates.cage(), random);
            Vec<double, 3> nearest;
            (void)nearest_boundary_value(coordinates.cage(), p, nearest);
            if (distance(p, nearest) > 0.05) points.push_back(p);
        }
        const auto found = gradients_of<double, 3>(coordinates, points);
        REQUIRE(found.evaluation.status == Status::ok);
        const double step = 1e-5;
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i);
            for (std::size_t k = 0; k < 3; ++k) {
                auto above = points[i], below = points[i];
                above[k] += step;
                below[k] -= step;
                const auto pair = evaluate_all(coordinates, std::vector{above, below});
                std::vector<double> slope, expected;
                for (std::size_t h = 0; h < coordinates.handles().size(); ++h) {
                    slope.push_back(found.rows[i][h][k]);
                    expected.push_back((pair.rows[0][h] - pair.rows[1][h]) / (2 * step));
                }
                CHECK(difference(slope, expected) <= 1e-6); // measured: 3e-8, the error of differences
            }
        }
    };
    compare(MeanValue<double>(PolyhedralMesh<double>(data.vertices, data.faces, fans())));
    compare(MeanValue<double>(PolyhedralMesh<double>(data.vertices, data.faces, fans(2))));
    compare(Green<double>(PolyhedralMesh<double>(data.vertices, data.faces, fans())));
}

TEMPLATE_TEST_CASE("cages of triangles and planar faces have no fans", "[coordinates][fans]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(range<std::uint64_t>(0, effort(6u, 2u)));
    CAPTURE(seed);
    const auto compare = [&](const auto& one, const auto& other) {
        const auto points = points_about(one.cage(), seed);
        const auto a = evaluate_all(one, points), b = evaluate_all(other, points);
        REQUIRE(a.status() == Status::ok);
        CHECK(a.rows == b.rows);
        CHECK(a.states == b.states);
    };
    // Triangles are never fans, whatever the option.
    const auto warped = random_warped(seed);
    const PolyhedralMesh<T> some(warped.vertices, warped.faces, fans());
    const TriangleMesh<T> triangles(some.triangles().vertices(), some.triangles().faces());
    const PolyhedralMesh<T> plain(triangles.vertices(), triangles.faces());
    const PolyhedralMesh<T> asked(triangles.vertices(), triangles.faces(), fans(4));
    CHECK(asked.triangles().size() == triangles.size());
    compare(MeanValue<T>(asked), MeanValue<T>(plain));
    compare(MeanValue<T>(asked), MeanValueCoordinates<T, 3>(triangles));
    compare(Green<T>(plain), GreenCoordinates<T, 3>(triangles));
    // Planar faces are not fans if fans are made only where needed.
    const auto data = random_prism(seed);
    compare(MeanValue<T>(data.vertices, data.faces, where_needed), MeanValue<T>(data.vertices, data.faces));
    // Green coordinates use the triangles of planar faces.
    const Green<T> green(data.vertices, data.faces);
    compare(green, GreenCoordinates<T, 3>(green.cage().triangles()));
    const auto points = points_about(green.cage(), seed);
    const auto found = evaluate_all(green, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        CHECK(missed(green, found.rows[i], points[i]) <= (sizeof(T) == 4 ? 1e-5 : 1e-13));
    }
}

TEST_CASE("fans make a refused cage valid, and its planar faces keep their coordinates",
          "[coordinates][fans]") {
    auto data = prism_over({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}, 2);
    data.vertices[4][2] += 0.25; // twisting the ceiling leaves the sides planar
    data.vertices[6][2] += 0.25;
    CHECK(MeanValue<double>(data.cage<double>()).cage_report().status == Status::face_not_planar);
    const MeanValue<double> mean_value(PolyhedralMesh<double>(data.vertices, data.faces, where_needed));
    const auto& report = mean_value.cage_report();
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.faults.size() == 1);
    CHECK(report.faults[0].kind == cageform::CageFaultKind::face_fanned);
    CHECK(report.faults[0].a == 1);
    CHECK(report.fan_distances == std::vector<double>{0.5 / 16});
    CHECK_FALSE(mean_value.cage().is_fan(2));
    // In the plane of side 2, x from −1 to 1, by mean value coordinates of its polygon.
    const std::vector<Vec<double, 2>> side{{-1, 0}, {1, 0}, {1, 2}, {-1, 2.25}};
    const MeanValueCoordinates<double, 2> plane(side);
    std::vector<double> row(8), flat(4), expected(8, 0.0);
    REQUIRE(weights_at(mean_value, Vec<double, 3>{0.25, -1, 0.75}, std::span(row)) ==
            PointState::on_boundary);
    REQUIRE(weights_at(plane, Vec<double, 2>{0.25, 0.75}, std::span(flat)) == PointState::inside);
    const std::size_t corners[] = {0, 1, 5, 4};
    for (std::size_t k = 0; k < 4; ++k) expected[corners[k]] = flat[k];
    CHECK(difference(row, expected) <= 1e-15);
    // The mean of the ceiling.
    REQUIRE(weights_at(mean_value, Vec<double, 3>{0, 0, 2.125}, std::span(row)) == PointState::on_boundary);
    CHECK(difference(row, std::vector<double>{0, 0, 0, 0, 0.25, 0.25, 0.25, 0.25}) <= 1e-15);
}

TEST_CASE("Green coordinates refuse divided faces", "[coordinates][fans][green][status]") {
    const auto data = random_warped(1);
    const Green<double> green(PolyhedralMesh<double>(data.vertices, data.faces, fans(2)));
    CHECK(green.cage_report().status == Status::divisions_not_supported);
    CHECK(green.cage_report().faults.back().a == 2);
    CHECK(cageform::bind(green, data.vertices).status() == Status::divisions_not_supported);
    // Coordinates so large that vectors overflow: the fault names a vertex of the face.
    auto large = data;
    for (auto& v : large.vertices) v = 3e154 * v;
    const Green<double> overflown(PolyhedralMesh<double>(large.vertices, large.faces, fans()));
    if (overflown.cage_report().status != Status::ok)
        CHECK(overflown.cage_report().faults.back().a < data.vertices.size());
}

} // namespace fans_tests
