// Normals, tangents and Jacobians of clones: differences of the deformed surface, affine poses, degenerate
// normals.
#include "../catch.hpp"
#include "../support/allocation_count.hpp"
#include "../support/bindings.hpp"
#include "../support/effort.hpp"
#include "../support/figures.hpp"
#include "../support/larger.hpp"
#include "../support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/clone/normals.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>
#include <cageform/parallel/threads.hpp>

namespace normals_tests {

using namespace cageform_tests;
using cageform::bind_jacobians;
using cageform::bind_vectors;
using cageform::Binding;
using cageform::epsilon;
using cageform::Polygon;

namespace {

template <class T>
using Mean2 = cageform::MeanValueCoordinates<T, 2>;
template <class T>
using Mean3 = cageform::MeanValueCoordinates<T, 3>;

/// A random smooth closed figure within the unit ball: a sphere with waves.
struct Waves {
    std::array<double, 4> size, phase;

    explicit Waves(std::uint64_t seed) {
        Random random(seed);
        for (double& s : size) s = random.uniform(-0.12, 0.12);
        for (double& p : phase) p = random.uniform(0, 6);
    }
    Vec<double, 3> operator()(double u, double v) const {
        const double r = 0.6 * (1 + size[0] * std::sin(3 * u + phase[0]) * std::sin(v) +
                                size[1] * std::cos(2 * v + phase[1]) +
                                size[2] * std::sin(2 * u + phase[2]) * std::sin(v) * std::sin(v) +
                                size[3] * std::cos(4 * v + phase[3]));
        return {r * std::cos(u) * std::sin(v), r * std::sin(u) * std::sin(v), r * std::cos(v)};
    }
};

/// A point of the figure, and points one step along u and v on either side.
struct Patch {
    Vec<double, 3> middle;
    std::array<std::array<Vec<double, 3>, 2>, 2> beside; ///< [u, v][behind, ahead]
    Vec<double, 3> normal;
};
std::vector<Patch> patches(const Waves& figure, int count, double step, std::uint64_t seed) {
    Random random(seed);
    std::vector<Patch> result;
    for (int n = 0; n < count; ++n) {
        const double u = random.uniform(0, 6.28), v = random.uniform(0.3, 2.84);
        Patch patch{
            figure(u, v),
            {{{figure(u - step, v), figure(u + step, v)}, {figure(u, v - step), figure(u, v + step)}}},
            {}};
        const double fine = 1e-6;
        const auto along = figure(u + fine, v) - figure(u - fine, v);
        const auto across = figure(u, v + fine) - figure(u, v - fine);
        patch.normal = cross(across, along);
        patch.normal = (1 / std::sqrt(dot(patch.normal, patch.normal))) * patch.normal;
        result.push_back(patch);
    }
    return result;
}

/// In degrees.
template <std::size_t D>
double angle_between(const Vec<double, D>& a, const Vec<double, D>& b) {
    const auto d = (1 / std::sqrt(dot(a, a))) * a - (1 / std::sqrt(dot(b, b))) * b;
    return 2 * std::asin(std::min(1.0, std::sqrt(dot(d, d)) / 2)) * 180 / std::numbers::pi;
}

template <class T>
struct BoundTangents {
    Points3<T> normals;
    std::array<Binding<T, 3>, 2> tangents;
};
/// Random normals at points inside a mesh.
template <class T, class C>
BoundTangents<T> random_tangents(const C& coordinates, const Points3<T>& points, std::uint64_t seed) {
    Random random(seed);
    BoundTangents<T> result;
    for (std::size_t i = 0; i < points.size(); ++i) {
        Vec<double, 3> n{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        result.normals.push_back(vec_cast<T>((1 / std::sqrt(dot(n, n))) * n));
    }
    result.tangents = bind_vectors(coordinates, points, cageform::tangents_of(result.normals)).value;
    return result;
}
/// The largest angle between normals of clones and normals from differences of clones.
template <class C>
double worst_angle(C& coordinates, double step, double reach, std::uint64_t seed) {
    using T = typename C::scalar;
    const auto places = patches(Waves(seed), 150, step, seed);
    Points3<T> middles, normals;
    Points3<double> around;
    for (const Patch& patch : places) {
        middles.push_back(vec_cast<T>(patch.middle));
        normals.push_back(vec_cast<T>(patch.normal));
        for (const auto& way : patch.beside) around.insert(around.end(), way.begin(), way.end());
    }
    const auto tangents = bind_vectors(coordinates, middles, cageform::tangents_of(normals));
    REQUIRE(tangents.report.status == Status::ok);
    REQUIRE(tangents.report.outside.empty());
    const auto beside = cageform::bind(coordinates, around).value;
    double worst = 0;
    for (int n = 0; n < 3; ++n) {
        const auto pose = shaken(coordinates.handles(), reach, seed + 10 * std::uint64_t(n));
        Points3<double> moved(middles.size());
        REQUIRE(cageform::clone_normals(tangents.value, pose, moved) == Status::ok);
        Points3<double> ends;
        for (const auto& p : cloned(beside, pose)) ends.push_back(vec_cast<double>(p));
        for (std::size_t i = 0; i < places.size(); ++i) {
            const auto along = ends[4 * i + 1] - ends[4 * i], across = ends[4 * i + 3] - ends[4 * i + 2];
            const double degrees = angle_between(moved[i], cross(across, along));
            worst = cageform_tests::larger(worst, degrees); // keeps NaN
        }
    }
    return worst;
}

} // namespace

TEST_CASE("normals are those of the deformed surface, mean value", "[clone][normals][meanvalue]") {
    const auto seed = std::uint64_t(GENERATE(seeds(6)));
    CAPTURE(seed);
    auto cage = sphere(2);
    Random random(seed + 30);
    for (auto& v : cage.vertices) v = random.uniform(1.0, 1.3) * v;
    Mean3<double> coordinates(cage.mesh<double>());
    CHECK(worst_angle(coordinates, 1e-4, 0.3, seed) <= 1e-4);
    // Differences of float points are too inaccurate for a stricter bound.
    Mean3<float> of_floats(cage.mesh<float>());
    CHECK(worst_angle(of_floats, 1e-2, 0.3, seed) <= 0.1);
}

TEST_CASE("normals are those of the deformed surface, harmonic", "[clone][normals][harmonic]") {
    const auto seed = std::uint64_t(GENERATE(seeds(1)));
    CAPTURE(seed);
    auto cage = sphere(1);
    Random random(seed + 30);
    for (auto& v : cage.vertices) v = random.uniform(1.2, 1.5) * v;
    cageform::HarmonicCoordinates<double, 3> coordinates(cage.mesh<double>(), {.resolution = effort(96, 48)},
                                                         cageform::UniformGrid{});
    REQUIRE(coordinates.solve().status == Status::ok);
    // Values are interpolated, so differences are meaningful over a cell and more.
    CHECK(worst_angle(coordinates, 0.05, 0.15, seed) <= effort(0.1, 0.4)); // of order h²
}

TEMPLATE_TEST_CASE("affine poses move normals by the cofactor matrix", "[clone][normals][affine]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = std::uint64_t(GENERATE(seeds(10)));
    CAPTURE(seed);
    const auto mesh = random_mesh(seed).mesh<T>();
    const Mean3<T> coordinates(mesh);
    const auto bound = random_tangents<T>(coordinates, points_in(mesh, 100, seed), seed);
    Random random(seed + 2);
    for (int n = 0; n < 5; ++n) {
        auto map = random_affine<3>(random, size_of(mesh.vertices()));
        const auto& a = map.rows;
        const Vec<Vec<double, 3>, 3> cofactors{cross(a[1], a[2]), cross(a[2], a[0]), cross(a[0], a[1])};
        const double determinant = dot(a[0], cofactors[0]);
        if (std::fabs(determinant) < 0.2) continue; // rounding grows like its reciprocal
        const auto pose = map(mesh.vertices());
        Points3<T> moved(bound.normals.size()), unit(moved.size());
        REQUIRE(clone_tangent_frames(bound.tangents, pose, moved, unit) == Status::ok);
        Points3<T> alone(moved.size());
        REQUIRE(clone_normals(bound.tangents, pose, alone) == Status::ok);
        CHECK(alone == moved);
        map.shift = {};
        for (std::size_t i = 0; i < moved.size(); ++i) {
            CAPTURE(n, i, determinant);
            const auto normal = vec_cast<double>(bound.normals[i]);
            const Vec<double, 3> expected{dot(cofactors[0], normal), dot(cofactors[1], normal),
                                          dot(cofactors[2], normal)};
            const double allowed = 3e4 * double(epsilon<T>) / std::fabs(determinant);
            CHECK(angle_between(vec_cast<double>(moved[i]), expected) <= 60 * allowed);
            const auto along = map(vec_cast<double>(bound.tangents[0].rest_point(i)));
            CHECK(angle_between(vec_cast<double>(unit[i]), along) <= 60 * allowed);
            CHECK(std::fabs(double(dot(moved[i], moved[i])) - 1) <= 4 * double(epsilon<T>));
            CHECK(std::fabs(double(dot(unit[i], unit[i])) - 1) <= 4 * double(epsilon<T>));
            CHECK(std::fabs(double(dot(unit[i], moved[i]))) <=
                  100 * double(epsilon<T>) / std::fabs(determinant));
        }
    }
}

TEMPLATE_TEST_CASE("at rest normals are as given", "[clone][normals][rest]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto mesh = random_mesh(6).mesh<T>();
    const Mean3<T> coordinates(mesh);
    const auto points = points_in(mesh, 70, 3);
    const auto bound = random_tangents<T>(coordinates, points, 3);
    const std::vector<Vec<T, 3>> pose(mesh.vertices().begin(), mesh.vertices().end());
    Points3<T> normals(points.size());
    REQUIRE(clone_normals(std::array{bound.tangents[0].view(), bound.tangents[1].view()}, pose, normals) ==
            Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i)
        CHECK(distance(normals[i], bound.normals[i]) <= 8 * double(epsilon<T>));
    const auto jacobians = bind_jacobians(coordinates, points);
    std::vector<T> matrices(9 * points.size());
    REQUIRE(clone_jacobians(jacobians.value, pose,
                            cageform::StridedMatrices<T, 3>(matrices.data(), points.size())) == Status::ok);
    for (std::size_t n = 0; n < matrices.size(); ++n) CHECK(matrices[n] == (n % 9 % 4 == 0 ? T(1) : T(0)));
}

TEST_CASE("normals in the plane are those of deformed curves", "[clone][normals][plane]") {
    const auto seed = std::uint64_t(GENERATE(seeds(6)));
    CAPTURE(seed);
    const Polygon<double> cage(random_star<double>(seed));
    const Mean2<double> coordinates(cage);
    const double size = bounds_of(cage.vertices()).diagonal();
    Random random(seed);
    Points2<double> points, normals, ends;
    for (int n = 0; n < 100; ++n) {
        const double angle = random.uniform(0, 6.3);
        points.push_back(random_inside(cage, random, 0.01));
        normals.push_back({std::cos(angle), std::sin(angle)});
        const Vec<double, 2> step{1e-5 * size * std::sin(angle), -1e-5 * size * std::cos(angle)};
        ends.insert(ends.end(), {points.back() - step, points.back() + step});
    }
    const auto tangents = bind_vectors(coordinates, points, cageform::tangents_of(normals)).value;
    const auto pose = shaken(coordinates.handles(), 0.1 * size, seed);
    const auto moved = cloned(cageform::bind(coordinates, ends).value, pose);
    Points2<double> found(points.size());
    REQUIRE(clone_normals(tangents, pose, found) == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto along = moved[2 * i + 1] - moved[2 * i];
        CHECK(angle_between(found[i], Vec<double, 2>{-along[1], along[0]}) <= 0.01);
    }
    REQUIRE(clone_normals(tangents, Points2<double>(cage.size()), found) == Status::ok); // one position
    for (std::size_t i = 0; i < points.size(); ++i) CHECK(distance(found[i], normals[i]) <= 1e-15);
}

TEMPLATE_TEST_CASE("a degenerate normal is that at rest", "[clone][normals][degenerate]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto mesh = random_mesh(6).mesh<T>();
    const Mean3<T> coordinates(mesh);
    auto points = points_in(mesh, 40, 5);
    points[7][1] = std::numeric_limits<T>::infinity(); // a point kept in place
    auto bound = random_tangents<T>(coordinates, points, 5);
    bound.normals[3] = {}; // a point without a normal at rest
    const auto frames = cageform::tangents_of(bound.normals);
    const auto tangents = bind_vectors(coordinates, points, frames).value;
    Points3<T> normals(points.size()), unit(points.size());
    const auto check_rest = [&](const Points3<T>& pose) {
        REQUIRE(clone_tangent_frames(tangents, pose, normals, unit) == Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i);
            CHECK(distance(normals[i], bound.normals[i]) <= 8 * double(epsilon<T>));
            CHECK(distance(unit[i], frames[0][i]) <= 8 * double(epsilon<T>));
        }
    };
    check_rest(Points3<T>(mesh.size())); // all handles coincide
    Points3<T> onto_line;
    for (const auto& v : mesh.vertices()) onto_line.push_back({v[0], 0, 0});
    check_rest(onto_line);
    Points3<T> pose;
    for (const auto& v : mesh.vertices()) pose.push_back(T(1e-30) * v);
    check_rest(pose);
    // Very large tangents are not degenerate.
    pose.clear();
    for (const auto& v : mesh.vertices()) pose.push_back(T(1e25) * Vec<T, 3>{v[0], v[2], v[1]});
    REQUIRE(clone_normals(tangents, pose, normals) == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i == 3 || i == 7) continue;
        const auto n = vec_cast<double>(bound.normals[i]);
        CHECK(angle_between(vec_cast<double>(normals[i]), Vec<double, 3>{-n[0], -n[2], -n[1]}) <= 0.1);
    }
}

TEMPLATE_TEST_CASE("Jacobians move vectors", "[clone][jacobians]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto mesh = random_mesh(2).mesh<T>();
    const Mean3<T> coordinates(mesh);
    const auto points = points_in(mesh, 75, 8);
    const auto columns = bind_jacobians(coordinates, points).value;
    const double size = double(bounds_of(mesh.vertices()).diagonal());
    const auto pose = shaken(mesh.vertices(), 0.2 * size, 8);
    // Columns padded to four floats, with other data between matrices.
    constexpr std::size_t stride = 14;
    std::vector<float> buffer(stride * points.size(), -7);
    REQUIRE(clone_jacobians(columns, pose,
                            cageform::StridedMatrices<float, 3>(buffer.data(), points.size(),
                                                                stride * sizeof(float), 4 * sizeof(float)),
                            cageform::ThreadedFor{2}) == Status::ok);
    Points3<T> vectors(points.size(), {T(0.6), T(-0.3), T(0.7)});
    const auto moved = cloned(bind_vectors(coordinates, points, vectors).value, pose);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const float* const j = buffer.data() + stride * i;
        Vec<double, 3> product{};
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                product[axis] += double(j[4 * k + axis]) * double(vectors[i][k]);
            CHECK((k == 2 || j[4 * k + 3] == -7));
        }
        CHECK(distance(product, moved[i]) <= 1e-4);
        CHECK((j[11] == -7 && j[12] == -7 && j[13] == -7));
    }
}

TEST_CASE("Jacobians in the plane are those of an affine map", "[clone][jacobians][plane]") {
    using T = double;
    const Polygon<T> cage(random_star<T>(4));
    const Points2<T> flat{cage[0], T(0.25) * (cage[0] + cage[1] + cage[2] + cage[3])};
    const auto in_plane = bind_jacobians(Mean2<T>(cage), flat).value;
    Random random(3);
    const auto map = random_affine<2>(random, 1);
    std::vector<T> matrices(8);
    const cageform::StridedMatrices<T, 2> view(matrices.data(), 2);
    REQUIRE(clone_jacobians(in_plane, map(cage.vertices()), view) == Status::ok);
    for (std::size_t n = 0; n < 8; ++n)
        CHECK(std::fabs(double(matrices[n]) - map.rows[n % 2][n % 4 / 2]) <= 1e4 * double(epsilon<T>));
    matrices.assign(8, T(3));
    const auto untouched = matrices;
    CHECK(clone_jacobians(in_plane, flat, view) == Status::pose_size_differs);
    CHECK(clone_jacobians(in_plane, cage.vertices(), cageform::StridedMatrices<T, 2>(matrices.data(), 1)) ==
          Status::output_too_small);
    CHECK(matrices == untouched);
}

TEST_CASE("normals and tangents leave other data of a buffer, and refused outputs, unchanged",
          "[clone][normals][status]") {
    const auto mesh = random_mesh(2).mesh<float>();
    const auto points = points_in(mesh, 37, 9);
    const auto bound = random_tangents<float>(Mean3<float>(mesh), points, 9);
    const auto pose = shaken(mesh.vertices(), 0.1 * double(bounds_of(mesh.vertices()).diagonal()), 9);
    std::vector<std::array<float, 4>> tangents(37, {0, 0, 0, -1}); // as in glTF
    const cageform::StridedPoints<float, 3> xyz(tangents[0].data(), 37, sizeof(tangents[0]));
    Points3<float> normals(37), plain(37);
    REQUIRE(clone_tangent_frames(bound.tangents, pose, normals, xyz) == Status::ok);
    REQUIRE(clone_tangent_frames(bound.tangents, pose, normals, plain, cageform::ThreadedFor{3}) ==
            Status::ok);
    for (std::size_t i = 0; i < 37; ++i) {
        CHECK(xyz[i] == plain[i]);
        CHECK(tangents[i][3] == -1);
    }

    const auto before = normals;
    auto bad = pose;
    bad[1][2] = std::numeric_limits<float>::quiet_NaN();
    CHECK(clone_normals(bound.tangents, bad, normals) == Status::pose_not_finite);
    bad.pop_back();
    CHECK(clone_normals(bound.tangents, bad, normals) == Status::pose_size_differs);
    Points3<float> few(36);
    CHECK(clone_normals(bound.tangents, pose, few) == Status::output_too_small);
    CHECK(clone_tangent_frames(bound.tangents, pose, normals, few) == Status::output_too_small);
    CHECK(clone_tangent_frames(bound.tangents, pose, few, normals) == Status::output_too_small);
    CHECK(normals == before);
    CHECK(few == Points3<float>(36));
}

TEST_CASE("normals of a frame allocate nothing", "[clone][normals][frame]") {
    const auto mesh = random_mesh(2).mesh<float>();
    const auto points = points_in(mesh, 500, 9);
    const Mean3<float> coordinates(mesh);
    const auto bound = random_tangents<float>(coordinates, points, 9);
    const auto columns = bind_jacobians(coordinates, points).value;
    const auto pose = shaken(mesh.vertices(), 0.01, 9);
    Points3<float> normals(500), tangents(500);
    std::vector<float> matrices(4500);
    const cageform::StridedMatrices<float, 3> view(matrices.data(), 500);
    STATIC_REQUIRE(noexcept(clone_normals(bound.tangents, pose, normals)));
    STATIC_REQUIRE(noexcept(clone_jacobians(columns, pose, view)));
    const std::size_t before = allocations;
    const Status of_normals = clone_normals(bound.tangents, pose, normals);
    const Status of_frames = clone_tangent_frames(bound.tangents, pose, normals, tangents);
    const Status of_jacobians = clone_jacobians(columns, pose, view);
    CHECK(allocations == before);
    CHECK(of_normals == Status::ok);
    CHECK(of_frames == Status::ok);
    CHECK(of_jacobians == Status::ok);
}

TEST_CASE("packed vectors move as the vectors do", "[clone][normals][packed]") {
    const auto mesh = random_mesh(2).mesh<float>();
    const auto points = points_in(mesh, 300, 9);
    const auto bound = random_tangents<float>(Mean3<float>(mesh), points, 9);
    const auto pose = shaken(mesh.vertices(), 0.1 * double(bounds_of(mesh.vertices()).diagonal()), 9);
    Points3<float> expected(300), normals(300);
    REQUIRE(clone_normals(bound.tangents, pose, expected) == Status::ok);
    const std::array<cageform::PackedBindingView<float, 3>, 2> packed{bound.tangents[0].view(),
                                                                      bound.tangents[1].view()};
    REQUIRE(clone_normals(packed, pose, normals) == Status::ok);
    for (std::size_t i = 0; i < 300; ++i) CHECK(distance(normals[i], expected[i]) <= 1e-5);
}

TEST_CASE("bindings that do not match are refused, and outputs are unchanged",
          "[clone][normals][packed][status]") {
    const auto binding = [](std::size_t points, std::size_t handles, std::size_t largest) {
        return cageform::pack(random_binding<float, 3>(points, handles, points + handles),
                              {.largest = largest})
            .value;
    };
    const auto first = binding(70, 12, 4);
    std::vector<std::uint32_t> order(first.view().order, first.view().order + 70);
    auto view = first.view();
    const auto pose = random_points<float, 3>(12, 1, 3);
    Points3<float> normals(70), tangents(70);
    std::vector<float> matrices(9 * 70);
    const auto untouched = normals;
    const auto refused = [&](const cageform::PackedBindingView<float, 3>& second) {
        CHECK(clone_normals(std::array{view, second}, pose, normals) == Status::bindings_differ);
        CHECK(clone_tangent_frames(std::array{view, second}, pose, normals, tangents) ==
              Status::bindings_differ);
        CHECK(normals == untouched);
        CHECK(tangents == untouched);
    };
    const cageform::StridedMatrices<float, 3> jacobians(matrices.data(), 70);
    const auto fewer = binding(69, 12, 4), another_cage = binding(70, 11, 4), in_order = binding(70, 12, 0);
    for (const auto* other : {&fewer, &another_cage, &in_order}) refused(other->view());
    CHECK(clone_jacobians(std::array{view, fewer.view(), view}, pose, jacobians) == Status::bindings_differ);
    CHECK(clone_jacobians(std::array{view, another_cage.view(), view}, pose, jacobians) ==
          Status::pose_size_differs);
    CHECK(matrices == std::vector<float>(9 * 70));
    // Equal orders in different memory match.
    auto second = view;
    second.order = order.data();
    CHECK(clone_normals(std::array{view, second}, pose, normals) == Status::ok);
    std::swap(order[3], order[60]);
    normals = untouched;
    refused(second);
}

} // namespace normals_tests
