// Harmonic functions on meshes: tests/data/oracle/surface.json, properties on random meshes, errors.
#include "../catch.hpp"
#include "../support/larger.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"

#include <cageform/fields/surface.hpp>

#include <limits>

namespace surface_tests {

using cageform::CageFaultKind;
using cageform::cotangent_weights;
using cageform::MeshWeights;
using cageform::Status;
using cageform_tests::MeshData;
using cageform_tests::Random;
using Json = nlohmann::json;
using Point = cageform::Vec<double, 3>;
using Marks = std::vector<std::uint8_t>;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

MeshData mesh_of(const Json& json) {
    MeshData mesh;
    for (const auto& v : json.at("vertices"))
        mesh.vertices.push_back({v[0].get<double>(), v[1].get<double>(), v[2].get<double>()});
    for (const auto& f : json.at("faces"))
        mesh.faces.push_back({f[0].get<int>(), f[1].get<int>(), f[2].get<int>()});
    return mesh;
}

/// The fields of a case and its marks; unknown values are NaN.
template <class T>
std::pair<std::vector<T>, Marks> given_of(const Json& json, std::size_t size) {
    const Json given = json.at("given");
    const std::size_t fields = given.begin().value().size();
    std::vector<T> values(fields * size, T(nan));
    Marks marks(size);
    for (auto at = given.begin(); at != given.end(); ++at) {
        const std::size_t i = std::stoul(at.key());
        marks[i] = 1;
        for (std::size_t k = 0; k < fields; ++k) {
            const auto text = at.value()[k].get<std::string>();
            const auto slash = text.find('/');
            values[k * size + i] = T(std::stod(text)) /
                                   (slash == std::string::npos ? T(1) : T(std::stod(text.substr(slash + 1))));
        }
    }
    return {values, marks};
}

/// A grid of cells with random inner vertices and random diagonals.
MeshData random_sheet(Random& random, int cells, double jitter) {
    MeshData mesh;
    const int n = cells + 1;
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            const bool inner = x > 0 && y > 0 && x < cells && y < cells;
            const double reach = inner ? jitter : 0;
            mesh.vertices.push_back(
                {x + random.uniform(-reach, reach), y + random.uniform(-reach, reach), 0});
        }
    }
    for (int y = 0; y < cells; ++y) {
        for (int x = 0; x < cells; ++x) {
            const int a = y * n + x, b = a + 1, c = b + n, d = a + n;
            // A diagonal that keeps the orientation of both triangles.
            const auto area = [&](int i, int j, int k) {
                const auto u = mesh.vertices[std::size_t(j)] - mesh.vertices[std::size_t(i)],
                           v = mesh.vertices[std::size_t(k)] - mesh.vertices[std::size_t(i)];
                return u[0] * v[1] - u[1] * v[0];
            };
            const bool first = area(a, b, c) > 0.01 && area(a, c, d) > 0.01;
            const bool second = area(a, b, d) > 0.01 && area(b, c, d) > 0.01;
            if (first && (!second || random.below(2) == 0)) {
                mesh.faces.insert(mesh.faces.end(), {{a, b, c}, {a, c, d}});
            } else {
                mesh.faces.insert(mesh.faces.end(), {{a, b, d}, {b, c, d}});
            }
        }
    }
    return mesh;
}

/// A closed mesh of slivers: a sphere or torus, randomly moved and stretched.
MeshData random_closed_mesh(Random& random) {
    MeshData mesh = random.below(2) == 0 ? cageform_tests::sphere(3) : cageform_tests::torus(14, 9);
    const double stretch = std::pow(10.0, random.uniform(0, 1.5));
    for (auto& v : mesh.vertices) {
        for (std::size_t k = 0; k < 3; ++k) v[k] += random.uniform(-0.03, 0.03);
        v[2] *= stretch;
    }
    return mesh;
}

/// Two fields: 1 and 0, 0 and 1, at a few vertices.
std::pair<std::vector<double>, Marks> random_fields(Random& random, std::size_t size) {
    std::vector<double> values(2 * size, nan);
    Marks marks(size);
    for (std::size_t n = 0; n < 6; ++n) {
        const std::size_t i = (n * size) / 6 + random.below(size / 6);
        marks[i] = 1;
        values[i] = double(n % 2);
        values[size + i] = 1 - double(n % 2);
    }
    return {values, marks};
}

std::vector<double> solve(const MeshData& mesh, std::vector<double> values, const Marks& marks,
                          MeshWeights kind = MeshWeights::intrinsic_delaunay) {
    const auto weights = cotangent_weights(mesh.vertices, mesh.faces, kind);
    REQUIRE(weights.report.status == Status::ok);
    REQUIRE(cageform::solve_surface(weights.value, marks, std::span(values)).status == Status::ok);
    return values;
}

double difference(std::span<const double> a, std::span<const double> b) {
    REQUIRE(a.size() == b.size());
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = cageform_tests::larger(largest, std::fabs(a[i] - b[i]));
    return largest;
}

} // namespace

TEMPLATE_TEST_CASE("solve_surface: reference values", "[surface][oracle]", CAGEFORM_SCALARS) {
    std::size_t cases = 0;
    const auto file = cageform_tests::read_json("surface");
    for (const auto& json : file.at("cases")) {
        if (!json.contains("vertices")) continue; // bone heat
        CAPTURE(json.at("name").get<std::string>());
        const MeshData mesh = mesh_of(json);
        for (const auto kind : {MeshWeights::own, MeshWeights::intrinsic_delaunay}) {
            const bool flipped =
                kind == MeshWeights::intrinsic_delaunay && json.contains("solution_intrinsic_delaunay");
            const Json expected =
                json.at(flipped ? "solution_intrinsic_delaunay_numbers" : "solution_numbers");
            auto [values, marks] = given_of<TestType>(json, mesh.vertices.size());
            const auto weights = cotangent_weights(mesh.mesh<TestType>().vertices(), mesh.faces, kind);
            REQUIRE(weights.report.status == Status::ok);
            REQUIRE(cageform::solve_surface(weights.value, marks, std::span(values)).status == Status::ok);
            const double tolerance = std::is_same_v<TestType, float> ? 2e-6 : 1e-12;
            for (std::size_t i = 0; i < values.size(); ++i) {
                CAPTURE(i);
                const std::size_t n = mesh.vertices.size();
                CHECK(double(values[i]) ==
                      Approx(expected[i % n][i / n].get<double>()).epsilon(0).margin(tolerance));
            }
            ++cases;
        }
    }
    CHECK(cases == 12);
}

TEST_CASE("cotangent_weights: exact for a pair of obtuse triangles", "[surface][oracle]") {
    const auto file = cageform_tests::read_json("surface");
    for (const auto& json : file.at("cases")) {
        if (json.at("name") != "obtuse_pair") continue;
        const MeshData mesh = mesh_of(json);
        const auto own = cotangent_weights(mesh.vertices, mesh.faces, MeshWeights::own);
        const Json expected = json.at("edge_weights");
        REQUIRE(own.value.links.size() == expected.size());
        for (const auto& link : own.value.links) {
            const auto [low, high] = std::minmax(link.a, link.b);
            const auto text =
                expected.at(std::to_string(low) + " " + std::to_string(high)).get<std::string>();
            const double value = std::stod(text) / std::stod(text.substr(text.find('/') + 1));
            CHECK(link.conductance == Approx(value).epsilon(1e-14));
        }
        CHECK(own.report.negative_weights == 5);
        CHECK(own.report.flips == 0);
        const auto flipped = cotangent_weights(mesh.vertices, mesh.faces);
        CHECK(flipped.report.flips > 0);
        return;
    }
    FAIL("the case is missing");
}

TEST_CASE("solve_surface: linear functions on flat sheets", "[surface][property]") {
    const auto seed = GENERATE(range(0, 12));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const MeshData mesh = random_sheet(random, 9, 0.45);
    const Point turn{random.uniform(-1, 1), random.uniform(-1, 1), 0};
    std::vector<double> values(mesh.vertices.size()), expected(mesh.vertices.size());
    Marks marks(mesh.vertices.size());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        const auto& v = mesh.vertices[i];
        expected[i] = 3 + dot(turn, v);
        marks[i] = v[0] == 0 || v[0] == 9 || v[1] == 0 || v[1] == 9 ? 1 : 0;
        values[i] = marks[i] != 0 ? expected[i] : nan;
    }
    CHECK(difference(solve(mesh, values, marks), expected) < 1e-12);
    CHECK(difference(solve(mesh, values, marks, MeshWeights::own), expected) < 1e-12);
}

TEST_CASE("solve_surface: values within the range of the data and sums of one on closed meshes",
          "[surface][property]") {
    const auto seed = GENERATE(range(0, 12));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const MeshData mesh = random_closed_mesh(random);
    const std::size_t size = mesh.vertices.size();
    const auto weights = cotangent_weights(mesh.vertices, mesh.faces);
    REQUIRE(weights.report.status == Status::ok);
    CHECK(weights.report.negative_weights == 0);
    CHECK(weights.report.flips > 0);
    for (const auto& link : weights.value.links) REQUIRE(link.conductance > 0);
    const auto [given, marks] = random_fields(random, size);
    const auto solved = solve(mesh, given, marks);
    for (std::size_t i = 0; i < size; ++i) {
        REQUIRE(solved[i] >= -1e-13);
        REQUIRE(solved[i] <= 1 + 1e-13);
        REQUIRE(solved[i] + solved[size + i] == Approx(1).epsilon(1e-12));
    }
}

TEST_CASE("solve_surface: invariances", "[surface][property]") {
    const auto seed = GENERATE(range(0, 8));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const MeshData mesh = random_closed_mesh(random);
    const std::size_t size = mesh.vertices.size();
    const auto [given, marks] = random_fields(random, size);
    const auto solved = solve(mesh, given, marks);

    MeshData other = mesh; // the orientation, order and first corners of faces
    for (auto& face : other.faces) {
        if (random.below(2) == 0) std::swap(face[0], face[1]);
        std::rotate(face.begin(), face.begin() + std::ptrdiff_t(random.below(3)), face.end());
    }
    for (std::size_t f = other.faces.size(); f > 1; --f)
        std::swap(other.faces[f - 1], other.faces[random.below(f)]);
    CHECK(difference(solve(other, given, marks), solved) < 1e-10);

    other = mesh; // units far beyond the overflow of squares
    const double scale = std::ldexp(1.0, random.below(2) == 0 ? 900 : -900);
    for (auto& v : other.vertices) v = scale * v;
    CHECK(difference(solve(other, given, marks), solved) == 0);

    other = mesh; // the numbering of vertices
    for (auto& face : other.faces) {
        for (auto& i : face) i = int(size) - 1 - i;
    }
    std::reverse(other.vertices.begin(), other.vertices.end());
    std::vector<double> turned(given.rbegin(), given.rend()); // and of fields
    auto back = solve(other, turned, Marks(marks.rbegin(), marks.rend()));
    std::reverse(back.begin(), back.end());
    CHECK(difference(back, solved) < 1e-10);
}

TEST_CASE("solve_surface: a Möbius strip", "[surface]") {
    // Two rows around: each function of the angle is a function on a ring of 20 with equal weights.
    MeshData mesh;
    constexpr int around = 20;
    for (int n = 0; n < around; ++n) {
        for (const double side : {-1.0, 0.0, 1.0}) {
            const double t = 2 * std::numbers::pi * n / around, r = 3 + side * std::cos(t / 2);
            mesh.vertices.push_back({r * std::cos(t), r * std::sin(t), side * std::sin(t / 2)});
        }
    }
    for (int n = 0; n < around; ++n) {
        for (int row = 0; row < 2; ++row) {
            const bool last = n + 1 == around;
            const int a = 3 * n + row, b = a + 1, c = last ? 2 - row : a + 3, d = last ? 1 - row : a + 4;
            mesh.faces.insert(mesh.faces.end(), {{a, b, c}, {b, d, c}});
        }
    }
    std::vector<double> values(mesh.vertices.size(), nan);
    Marks marks(values.size());
    for (const auto& [i, value] : {std::pair(1, 0.0), std::pair(31, 1.0)}) {
        marks[std::size_t(i)] = 1;
        values[std::size_t(i)] = value;
    }
    const auto weights = cotangent_weights(mesh.vertices, mesh.faces);
    REQUIRE(weights.report.status == Status::ok);
    REQUIRE(cageform::solve_surface(weights.value, marks, std::span(values)).status == Status::ok);
    for (const double value : values) CHECK((value >= 0 && value <= 1));
}

TEST_CASE("solve_surface: exact on the two sides of a flat triangle", "[surface][property]") {
    // Flipping the side opposite to the obtuse corner c leaves faces that are glued to themselves. The
    // angles opposite to the other sides are twice π/2 − β and twice π/2 − α.
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const double part = random.uniform(0.1, 0.9), height = random.uniform(0.01, 0.2);
        const std::vector<Point> corners{{0, 0, 0}, {1, 0, 0}, {part, height, 0}};
        const double at_a = height / part, at_b = height / (1 - part); // tan α, tan β
        for (const std::array<int, 3> back :
             {std::array{0, 2, 1}, std::array{0, 1, 2}, std::array{2, 0, 1}}) {
            const auto weights = cotangent_weights(corners, cageform_tests::Faces{{0, 1, 2}, back});
            CHECK(weights.report.flips == 1);
            CHECK(weights.report.negative_weights == 0);
            std::vector<double> values{0, 1, nan};
            REQUIRE(cageform::solve_surface(weights.value, Marks{1, 1, 0}, std::span(values)).status ==
                    Status::ok);
            CHECK(values[2] == Approx(at_b / (at_a + at_b)).epsilon(1e-12));
        }
    }
}

TEST_CASE("solve_surface: flat pillows with random orientation of faces", "[surface][property]") {
    std::size_t flips = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const int count = 5 + int(random.below(8));
        std::vector<double> angles;
        for (int n = 0; n < count; ++n)
            angles.push_back(2 * std::numbers::pi * (n + random.uniform(-0.4, 0.4)) / count);
        MeshData mesh;
        for (const double t : angles)
            mesh.vertices.push_back({std::cos(t), 0.3 * std::sin(t) * (1 + 0.2 * std::cos(t)), 0});
        for (int n = 1; n + 1 < count; ++n) { // fans around two corners: no edge occurs twice
            mesh.faces.push_back({0, n, n + 1});
            mesh.faces.push_back({1, (n + 2) % count, n + 1});
        }
        Marks marks(mesh.vertices.size());
        std::vector<double> start(mesh.vertices.size(), nan);
        for (std::size_t i = 0; i < marks.size(); i += 2) {
            marks[i] = 1;
            start[i] = random.uniform(0, 1);
        }
        const auto solved = [&] {
            const auto weights = cotangent_weights(mesh.vertices, mesh.faces);
            CHECK(weights.report.negative_weights == 0);
            flips += weights.report.flips;
            auto values = start;
            REQUIRE(cageform::solve_surface(weights.value, marks, std::span(values)).status == Status::ok);
            return values;
        };
        const auto expected = solved();
        for (const double value : expected) CHECK((value >= -1e-12 && value <= 1 + 1e-12));
        for (int n = 0; n < 4; ++n) {
            for (auto& face : mesh.faces) {
                if (random.below(2) == 0) std::swap(face[1], face[2]);
            }
            const auto values = solved();
            for (std::size_t i = 0; i < values.size(); ++i)
                CHECK(std::fabs(values[i] - expected[i]) <= 1e-10);
        }
    }
    CHECK(flips > 1000);
}

TEST_CASE("solve_surface: nearly coincident vertices, needles", "[surface][property]") {
    // Conductances differ by 1e12 and more. Subtraction gave values of −8, and flips gave NaN.
    std::size_t flips = 0, negative = 0;
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        MeshData mesh = seed % 2 == 0 ? cageform_tests::sphere(2) : cageform_tests::torus(6, 5);
        for (int n = 0; n < 4; ++n) {
            const auto any = [&] { return random.below(mesh.vertices.size()); };
            const auto &from = mesh.vertices[any()], to = mesh.vertices[any()];
            mesh.vertices[any()] = to + std::pow(10, random.uniform(-11, -6)) * (from - to);
        }
        const double thin = std::pow(10, random.uniform(-11, 0));
        for (auto& v : mesh.vertices) {
            if (seed % 3 > 0) v[2] *= thin;
            if (seed % 3 == 1) v[1] *= thin;
        }
        const auto weights = cotangent_weights(mesh.vertices, mesh.faces);
        if (weights.report.status == Status::face_without_area) continue;
        REQUIRE(weights.report.status == Status::ok);
        flips += weights.report.flips;
        for (const auto& link : weights.value.links) REQUIRE(std::isfinite(link.conductance));
        if (weights.report.negative_weights > 0) {
            ++negative;
            continue;
        }
        auto [values, marks] = random_fields(random, mesh.vertices.size());
        REQUIRE(cageform::solve_surface(weights.value, marks, std::span(values)).status == Status::ok);
        for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
            REQUIRE(values[i] >= 0);
            REQUIRE(values[i] <= 1 + 1e-14);
            REQUIRE(values[i] + values[mesh.vertices.size() + i] == Approx(1).epsilon(1e-14));
        }
    }
    CHECK(flips > 3000);
    CHECK(negative < 30);
}

TEST_CASE("cotangent_weights: errors have a status", "[surface][errors]") {
    const MeshData good = cageform_tests::sphere(1);
    const auto refused = [](const MeshData& mesh, Status status, CageFaultKind kind, std::size_t a) {
        const auto weights = cotangent_weights(mesh.vertices, mesh.faces);
        CHECK(weights.report.status == status);
        CHECK(weights.value.links.empty());
        CHECK(weights.value.vertices == 0);
        REQUIRE(!weights.report.mesh.faults.empty());
        CHECK(weights.report.mesh.faults[0].kind == kind);
        CHECK(weights.report.mesh.faults[0].a == a);
        std::vector<double> values(mesh.vertices.size(), 1.0);
        CHECK(cageform::solve_surface(weights.value, Marks(values.size(), 0), std::span(values)).status ==
              Status::input_malformed);
    };
    MeshData bad = good;
    bad.faces[7][1] = -1;
    refused(bad, Status::face_without_vertex, CageFaultKind::face_without_vertex, 7);
    bad.faces[7][1] = int(good.vertices.size());
    refused(bad, Status::face_without_vertex, CageFaultKind::face_without_vertex, 7);
    bad.faces[7][1] = bad.faces[7][2];
    refused(bad, Status::face_without_area, CageFaultKind::face_without_area, 7);
    bad = good;
    bad.vertices[5][2] = nan;
    refused(bad, Status::vertex_not_finite, CageFaultKind::vertex_not_finite, 5);
    bad = good;
    bad.vertices.push_back({0, 0, 3});
    bad.faces.push_back({good.faces[0][0], good.faces[0][1], int(good.vertices.size())});
    refused(bad, Status::cage_not_manifold, CageFaultKind::edge_not_manifold,
            std::size_t(std::min(good.faces[0][0], good.faces[0][1])));
    bad = {{{0, 0, 0}, {1, 0, 0}, {0.5, 1e-13, 0}}, {{0, 1, 2}}};
    refused(bad, Status::face_without_area, CageFaultKind::face_without_area, 0);
    bad.vertices[2][1] = 1e-11;
    CHECK(cotangent_weights(bad.vertices, bad.faces).report.status == Status::ok);
    CHECK(cotangent_weights(bad.vertices, cageform_tests::Faces{}).report.status == Status::ok);
}

TEST_CASE("solve_surface: errors have a status and nothing is written", "[surface][errors]") {
    MeshData mesh = cageform_tests::sphere(1);
    const std::size_t size = mesh.vertices.size();
    for (const Point& v : {Point{5, 0, 0}, Point{6, 0, 0}, Point{5, 1, 0}, Point{9, 9, 9}})
        mesh.vertices.push_back(v); // a separate triangle, and a vertex without a face
    mesh.faces.push_back({int(size), int(size) + 1, int(size) + 2});
    const auto weights = cotangent_weights(mesh.vertices, mesh.faces);
    REQUIRE(weights.report.status == Status::ok);
    REQUIRE(weights.report.mesh.faults.size() == 1);
    CHECK(weights.report.mesh.faults[0].kind == CageFaultKind::vertex_unused);
    CHECK(weights.report.mesh.faults[0].a == size + 3);

    std::vector<double> values(mesh.vertices.size(), 7);
    Marks marks(values.size());
    marks[0] = 1;
    auto evaluation = cageform::solve_surface(weights.value, marks, std::span(values));
    CHECK(evaluation.status == Status::cells_unreached);
    CHECK(evaluation.solver.culprit == size);
    CHECK(std::count(values.begin(), values.end(), 7.0) == std::ptrdiff_t(values.size()));

    marks[size + 1] = marks[size + 3] = 1;
    values[size + 3] = nan; // of the vertex without a face: ignored
    values[size + 1] = nan;
    evaluation = cageform::solve_surface(weights.value, marks, std::span(values));
    CHECK(evaluation.status == Status::value_not_finite);
    CHECK(evaluation.solver.culprit == size + 1);

    values[size + 1] = 2;
    REQUIRE(cageform::solve_surface(weights.value, marks, std::span(values)).status == Status::ok);
    CHECK(values[1] == Approx(7));
    CHECK(values[size] == Approx(2));
    CHECK(std::isnan(values[size + 3]));

    cageform::Running stop;
    stop.progress = [](double) { return false; };
    CHECK(cageform::solve_surface(weights.value, marks, std::span(values), stop).status == Status::cancelled);
}

TEST_CASE("cotangent_weights: boundary edges opposite to an obtuse angle are counted", "[surface]") {
    const MeshData mesh{{{0, 0, 0}, {4, 0, 0}, {2, 0.5, 0}, {2, 3, 0}}, {{0, 1, 2}, {0, 2, 3}, {1, 3, 2}}};
    const auto weights = cotangent_weights(mesh.vertices, mesh.faces);
    REQUIRE(weights.report.status == Status::ok);
    CHECK(weights.report.negative_weights == 3); // the whole boundary
    double negative = 0;
    for (const auto& link : weights.value.links) negative = std::min(negative, link.conductance);
    CHECK(negative == Approx(-15.0 / 16).epsilon(1e-14)); // ½ cot, of (−2, −½)·(2, −½) over 2
    double areas = 0;
    for (const double area : weights.value.areas) areas += area * weights.value.unit * weights.value.unit;
    CHECK(areas == Approx(6).epsilon(1e-14));
}

} // namespace surface_tests
