// Mean value coordinates in 3D: the oracle, the laws on random meshes, and critical points of the formulas.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/larger.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"
#include "../support/thin_cages.hpp"
#include "../support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/mean_value.hpp>

namespace mean_value_3d_tests {

using namespace cageform_tests;
using cageform::epsilon;

namespace {

template <class T>
using Mean = cageform::MeanValueCoordinates<T, 3>;

template <class T>
Points3<T> converted(const Points3<double>& points) {
    Points3<T> result;
    for (const auto& p : points) result.push_back(vec_cast<T>(p));
    return result;
}

} // namespace

TEMPLATE_TEST_CASE("mean value weights in space are those of the oracle",
                   "[coordinates][meanvalue][space][oracle]", CAGEFORM_SCALARS) {
    using T = TestType;
    for (const char* name : {"cube", "l_prism", "octahedron", "tetrahedron"}) {
        const auto json = read_json(std::string("meanvalue3d_") + name);
        MeshData data;
        for (const auto& v : json["cage"]["vertices"]) data.vertices.push_back({v[0], v[1], v[2]});
        for (const auto& f : json["cage"]["faces"]) data.faces.push_back({f[0], f[1], f[2]});
        Points3<double> points;
        for (const auto& p : json["points"]) points.push_back({p[0], p[1], p[2]});
        REQUIRE(points.size() >= 12);
        const auto weights = evaluate_all(Mean<T>(data.mesh<T>()), converted<T>(points));
        REQUIRE(weights.status() == Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const std::string tag = json["point_tags"][i];
            CAPTURE(name, i, tag);
            if (tag.starts_with("inside")) CHECK(weights.states[i] == PointState::inside);
            if (tag.starts_with("outside")) CHECK(weights.states[i] == PointState::outside);
            if (tag.starts_with("on_")) CHECK(weights.states[i] == PointState::on_boundary);
            for (std::size_t k = 0; k < data.vertices.size(); ++k) {
                CHECK(std::fabs(double(weights.rows[i][k]) - json["coordinates"][i][k].get<double>()) <=
                      (sizeof(T) == 8 ? 1e-12 : 5e-5));
            }
        }
    }
}

TEMPLATE_TEST_CASE("mean value weights in space sum to 1 and reproduce the point",
                   "[coordinates][meanvalue][space][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(20, 5)));
    CAPTURE(seed);
    const auto data = random_mesh(std::uint64_t(seed));
    const auto mesh = data.mesh<T>();
    const auto points = converted<T>(points_about(data, 300, std::uint64_t(seed)));
    const auto weights = evaluate_all(Mean<T>(mesh), points);
    REQUIRE(weights.status() == Status::ok);
    const auto bounds = cageform::bounds_of(mesh.vertices());
    const double size = double(bounds.diagonal());
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        const auto state = locate(mesh, points[i], cageform::coincidence_tolerance(bounds));
        CHECK(weights.states[i] == state);
        double largest = 1;
        for (const T w : weights.rows[i]) largest = cageform_tests::larger(largest, std::fabs(double(w)));
        // Rounding of the coordinates, and of the remainder of each face's sum next to its plane.
        const double tolerance = largest * (sizeof(T) == 8 ? 2e-12 : 1e-3);
        CHECK(std::fabs(double(sum_of(weights.rows[i])) - 1) <= tolerance);
        CHECK(distance(combine(weights.rows[i], mesh.vertices()), points[i]) <=
              tolerance * size + 16 * double(epsilon<T>) * double(bounds.magnitude()) * largest);
    }
}

TEST_CASE("mean value weights are continuous up to planes, faces, edges and vertices",
          "[coordinates][meanvalue][space][limits]") {
    const int seed = GENERATE(seeds(effort(10, 2)));
    CAPTURE(seed);
    const auto data = random_mesh(std::uint64_t(seed));
    const auto mesh = data.mesh<double>();
    const Mean<double> coordinates(mesh);
    const auto bounds = cageform::bounds_of(mesh.vertices());
    const double size = bounds.diagonal();
    Random random(std::uint64_t(seed) + 5);
    for (int n = 0; n < 40; ++n) {
        const auto& face = mesh.faces()[random.below(mesh.faces().size())];
        const auto a = mesh[face[0]], b = mesh[face[1]], c = mesh[face[2]];
        auto normal = cross(b - a, c - a);
        normal = (1 / std::sqrt(dot(normal, normal))) * normal;
        // On a face, an edge and a vertex; and in the plane of the face beside it.
        const double u = n % 4 == 3 ? random.uniform(-1, 2) : random.uniform(0, 1);
        const double v = n % 4 == 3 ? random.uniform(-1, 2) : n % 4 == 0 ? random.uniform(0, 1 - u) : 0.0;
        const auto foot = n % 4 == 2 ? a : a + u * (b - a) + v * (c - a);
        const auto at = [&](double height) { return Vec<double, 3>(foot + height * size * normal); };
        for (const double height : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13}) {
            const Points3<double> points{at(height), at(-height)};
            const auto weights = evaluate_all(coordinates, points);
            for (std::size_t i = 0; i < 2; ++i) {
                CAPTURE(n, height, i);
                double largest = 1;
                for (const double w : weights.rows[i])
                    largest = cageform_tests::larger(largest, std::fabs(w));
                CHECK(distance(combine(weights.rows[i], mesh.vertices()), points[i]) <=
                      1e-11 * size * largest + 16 * epsilon<double> * bounds.magnitude() * largest);
            }
        }
    }
}

TEST_CASE("mean value binds in space move with affine poses", "[coordinates][meanvalue][space][binding]") {
    const auto data = random_mesh(5);
    const auto [binding, report] =
        cageform::bind(Mean<double>(data.mesh<double>()), points_about(data, 200, 5));
    CHECK(report.status == Status::ok);
    CHECK(report.weight_change.value <= 1e-11);
}

TEMPLATE_TEST_CASE("restoring never makes linear precision worse in space",
                   "[coordinates][meanvalue][space][binding]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto corners =
        thin_simplex<T, 3>(random, std::pow(10.0, random.uniform(sizeof(T) == 4 ? -5 : -13, -1)));
    const Mean<T> coordinates(corners, Faces{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
    if (coordinates.cage_report().status != Status::ok) return; // too thin
    Points3<T> points;
    for (int i = 0; i < 40; ++i)
        points.push_back({T(random.uniform(-2, 2)), T(random.uniform(-2, 2)), T(random.uniform(-2, 2))});
    using cageform::LinearPrecision;
    const auto left = cageform::bind(coordinates, points, {.linear_precision = LinearPrecision::leave});
    const auto restored = cageform::bind(coordinates, points);
    REQUIRE(restored.report.status == Status::ok);
    check_restored(left, restored, coordinates.handles());
}

TEMPLATE_TEST_CASE("points outside thin cages in space are outside", "[coordinates][meanvalue][space][thin]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(40));
    Random random{std::uint64_t(seed)};
    const double width = std::pow(10.0, random.uniform(sizeof(T) == 4 ? -6.5 : -9, -1));
    CAPTURE(seed, width);
    const Faces box{{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    for (const double depth : {1.0, width}) { // a plate and a rod
        Points3<T> corners;
        for (int i = 0; i < 8; ++i)
            corners.push_back({T(i & 1), T(depth * (i >> 1 & 1)), T(width * (i >> 2 & 1))});
        check_thin_states(Mean<T>(corners, box), random);
    }
    check_thin_states(
        Mean<T>(thin_simplex<T, 3>(random, width), Faces{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}),
        random);
}

TEST_CASE("float weights of a thousand vertices in space sum to 1", "[coordinates][meanvalue][space]") {
    Random random(1);
    auto data = sphere(4);
    for (auto& v : data.vertices) v = random.uniform(0.9, 1.1) * v;
    Points3<float> points;
    for (int i = 0; i < 200; ++i)
        points.push_back({float(random.uniform(-1.5, 1.5)), float(random.uniform(-1.5, 1.5)),
                          float(random.uniform(-1.5, 1.5))});
    for (const auto& row : evaluate_all(Mean<float>(data.mesh<float>()), points).rows)
        CHECK(std::fabs(double(sum_of(row) - 1)) <= 6 * double(epsilon<float>) * absolute_sum(row));
}

TEST_CASE("invalid meshes are refused by mean value coordinates", "[coordinates][meanvalue][space][status]") {
    auto data = sphere(1);
    data.faces.resize(data.faces.size() / 2);
    CHECK(evaluate_all(Mean<double>(data.mesh<double>()), Points3<double>{{0, 0, 0}}).status() ==
          Status::cage_not_closed);
}

TEST_CASE("mean value weights in space do not depend on the orientation of shells",
          "[coordinates][meanvalue][space]") {
    const auto outer = sphere(2), inner = sphere(1);
    const auto hollow = [&](bool outer_turned, bool inner_turned) {
        MeshData data = outer;
        const auto turn = [](Faces faces) {
            for (auto& face : faces) std::swap(face[0], face[1]);
            return faces;
        };
        if (outer_turned) data.faces = turn(data.faces);
        const int first = int(data.vertices.size());
        for (const auto& v : inner.vertices) data.vertices.push_back(0.4 * v);
        for (const auto& [a, b, c] : inner_turned ? turn(inner.faces) : inner.faces)
            data.faces.push_back({first + a, first + b, first + c});
        return data;
    };
    const auto points = points_about(outer, 100, 3);
    const auto expected = evaluate_all(Mean<double>(hollow(false, true).mesh<double>()), points);
    for (const auto& [a, b] : {std::pair(false, false), std::pair(true, false), std::pair(true, true)}) {
        const auto weights = evaluate_all(Mean<double>(hollow(a, b).mesh<double>()), points);
        CHECK(weights.states == expected.states);
        for (std::size_t i = 0; i < points.size(); ++i)
            CHECK(difference(weights.rows[i], expected.rows[i]) <= 1e-12);
    }
}

TEST_CASE("mean value coordinates in space are made from vertices and faces too",
          "[coordinates][meanvalue][space]") {
    const auto data = random_mesh(3);
    const auto points = points_about(data, 50, 3);
    const Mean<double> coordinates(data.vertices, data.faces);
    REQUIRE(coordinates.cage().size() == data.vertices.size());
    const auto weights = evaluate_all(coordinates, points);
    const auto expected = evaluate_all(Mean<double>(data.mesh<double>()), points);
    CHECK(weights.status() == Status::ok);
    CHECK(weights.rows == expected.rows);
    CHECK(weights.states == expected.states);
}

} // namespace mean_value_3d_tests
