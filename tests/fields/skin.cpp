// Bone weights: the reference of tests/data/oracle/surface.json, properties on random meshes, visibility,
// errors.
#include "../catch.hpp"
#include "../support/larger.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"

#include <cageform/binding/bind_bones.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/fields/skin.hpp>

#include <limits>

namespace surface_skin_tests {

using cageform::bone_heat;
using cageform::BoneSegment;
using cageform::BoneVisibility;
using cageform::harmonic_skin;
using cageform::Status;
using cageform::SurfaceSkinOptions;
using cageform_tests::MeshData;
using cageform_tests::Random;
using Point = cageform::Vec<double, 3>;

namespace {

constexpr SurfaceSkinOptions blind{.visibility = BoneVisibility::ignored};

/// A torus and bones along parts of its core; for every other seed one more in its hole, near the wall.
struct Ring {
    MeshData mesh = cageform_tests::torus(24, 12);
    std::vector<BoneSegment> bones;

    explicit Ring(std::uint64_t seed) {
        Random random(seed);
        for (auto& v : mesh.vertices) {
            for (std::size_t k = 0; k < 3; ++k) v[k] += random.uniform(-0.01, 0.01);
        }
        const std::size_t count = 2 + random.below(4);
        for (std::size_t b = 0; b < count; ++b) {
            const auto at = [&](double part) {
                const double angle = 2 * std::numbers::pi * (double(b) + part) / double(count);
                return Point{std::cos(angle), std::sin(angle), random.uniform(-0.1, 0.1)};
            };
            bones.push_back({at(0.2), at(0.5)});
        }
        if (seed % 2 == 1) bones.push_back({{0.45, 0, -0.2}, {0.45, 0, 0.2}});
    }
};

double largest_difference(std::span<const double> a, std::span<const double> b) {
    REQUIRE(a.size() == b.size());
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = cageform_tests::larger(largest, std::fabs(a[i] - b[i]));
    return largest;
}

} // namespace

TEMPLATE_TEST_CASE("bone_heat: reference values", "[surface][skin][oracle]", CAGEFORM_SCALARS) {
    MeshData mesh;
    std::size_t checked = 0;
    const auto file = cageform_tests::read_json("surface");
    for (const auto& json : file.at("cases")) {
        if (json.at("name") == "sphere_162") {
            for (const auto& v : json.at("vertices"))
                mesh.vertices.push_back({v[0].get<double>(), v[1].get<double>(), v[2].get<double>()});
            for (const auto& f : json.at("faces"))
                mesh.faces.push_back({f[0].get<int>(), f[1].get<int>(), f[2].get<int>()});
        }
        if (json.at("name") != "bone_heat_sphere_162") continue;
        std::vector<BoneSegment> bones;
        for (const auto& bone : json.at("bones")) {
            const auto end = [&](std::size_t n) {
                return Point{bone[n][0].get<double>(), bone[n][1].get<double>(), bone[n][2].get<double>()};
            };
            bones.push_back({end(0), end(1)});
        }
        const auto points = mesh.mesh<TestType>();
        for (const auto& options : {blind, SurfaceSkinOptions{}}) { // in a ball everything is visible
            const auto skin = bone_heat(points.vertices(), mesh.faces, bones, options);
            REQUIRE(skin.report.status == Status::ok);
            CHECK(skin.report.hidden == 0);
            const auto expected = json.at("solution_numbers").get<std::vector<std::vector<double>>>();
            REQUIRE(skin.value.size() == 3 * expected.size());
            const double tolerance = std::is_same_v<TestType, float> ? 2e-6 : 1e-12;
            for (std::size_t n = 0; n < skin.value.size(); ++n) {
                CAPTURE(n);
                CHECK(double(skin.value[n]) == Approx(expected[n / 3][n % 3]).epsilon(0).margin(tolerance));
                ++checked;
            }
        }
    }
    CHECK(checked == 2 * 3 * 162);
}

TEST_CASE("bone weights: properties", "[surface][skin][property]") {
    const auto seed = GENERATE(range(0, 8));
    CAPTURE(seed);
    const Ring ring{std::uint64_t(seed)};
    const std::size_t bones = ring.bones.size();
    const auto all = std::span<const BoneSegment>(ring.bones);
    const auto heat = bone_heat(ring.mesh.vertices, ring.mesh.faces, all);
    const auto harmonic = harmonic_skin(ring.mesh.vertices, ring.mesh.faces, all);
    for (const auto* skin : {&heat, &harmonic}) {
        REQUIRE(skin->report.status == Status::ok);
        REQUIRE(skin->value.size() == bones * ring.mesh.vertices.size());
        CHECK(skin->report.mesh.negative_weights == 0);
        for (std::size_t i = 0; i < ring.mesh.vertices.size(); ++i) {
            double sum = 0;
            for (std::size_t b = 0; b < bones; ++b) {
                sum += skin->value[i * bones + b];
                REQUIRE(skin->value[i * bones + b] >= -1e-13);
            }
            REQUIRE(sum == Approx(1).epsilon(1e-12));
        }
    }
    // The bone in the hole is not visible from any vertex nearest to it.
    const bool has_outer = seed % 2 == 1;
    CHECK((heat.report.hidden > 0 || !has_outer));
    CHECK(heat.report.idle_bones == (has_outer ? std::vector{bones - 1} : std::vector<std::size_t>{}));

    // Other units; another order of the bones and of the vertices.
    MeshData other = ring.mesh;
    auto turned = ring.bones;
    for (auto& v : other.vertices) v = 0x1p-500 * v;
    for (auto& bone : turned) bone = {0x1p-500 * bone.tail, 0x1p-500 * bone.head};
    CHECK(largest_difference(bone_heat(other.vertices, other.faces, turned).value, heat.value) < 1e-12);
    CHECK(largest_difference(harmonic_skin(other.vertices, other.faces, turned).value, harmonic.value) <
          1e-12);
    other = ring.mesh;
    turned = ring.bones;
    std::reverse(turned.begin(), turned.end());
    std::reverse(other.vertices.begin(), other.vertices.end());
    for (auto& face : other.faces) {
        for (auto& i : face) i = int(other.vertices.size()) - 1 - i;
    }
    for (const bool is_heat : {false, true}) {
        auto skin = is_heat ? bone_heat(other.vertices, other.faces, turned)
                            : harmonic_skin(other.vertices, other.faces, turned);
        std::reverse(skin.value.begin(), skin.value.end());
        CHECK(largest_difference(skin.value, (is_heat ? heat : harmonic).value) < 1e-10);
    }
}

TEST_CASE("bone weights: equal far from the origin", "[surface][skin][property]") {
    const auto seed = GENERATE(seeds(6));
    CAPTURE(seed);
    const Ring near_origin(static_cast<std::uint64_t>(seed));
    Ring far_away = near_origin;
    const Point shift{500000.25, -4600000.5, 3e6}; // rounds positions to 1e-9
    for (auto& v : far_away.mesh.vertices) {
        for (std::size_t k = 0; k < 3; ++k) v[k] += shift[k];
    }
    for (BoneSegment& bone : far_away.bones) bone = {bone.head + shift, bone.tail + shift};
    const auto weights = [&](const Ring& ring, const auto& skin) {
        const auto made = skin(ring.mesh.mesh<double>().vertices(), ring.mesh.faces, ring.bones, blind);
        REQUIRE(made.report.status == Status::ok);
        return made.value;
    };
    const auto heat = [](const auto&... all) { return bone_heat(all...); };
    const auto harmonic = [](const auto&... all) { return harmonic_skin(all...); };
    CHECK(largest_difference(weights(near_origin, heat), weights(far_away, heat)) <= 1e-6);
    CHECK(largest_difference(weights(near_origin, harmonic), weights(far_away, harmonic)) <= 1e-6);
}

TEST_CASE("bone weights: symmetric for a symmetric mesh and symmetric bones", "[surface][skin][property]") {
    // The octahedron's sphere is symmetric; bone 1 is the mirror image of bone 0, and bone 2 of itself.
    MeshData mesh = cageform_tests::sphere(3);
    for (auto& v : mesh.vertices) v = {2 * v[0], v[1], 0.4 * v[2] * (1 + v[1])};
    const std::vector<BoneSegment> bones{
        {{0.4, 0, 0}, {1.5, 0.2, 0}}, {{-0.4, 0, 0}, {-1.5, 0.2, 0}}, {{0, 0.1, 0}, {0, 0.8, 0}}};
    std::map<std::array<double, 3>, std::size_t> at;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        const auto& v = mesh.vertices[i];
        at[{v[0] + 0.0, v[1] + 0.0, v[2] + 0.0}] = i;
    }
    const auto heat = bone_heat(mesh.vertices, mesh.faces, bones);
    const auto harmonic = harmonic_skin(mesh.vertices, mesh.faces, bones);
    for (const auto* skin : {&heat, &harmonic}) {
        REQUIRE(skin->report.status == Status::ok);
        for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
            const auto& v = mesh.vertices[i];
            const std::size_t j = at.at({-v[0] + 0.0, v[1] + 0.0, v[2] + 0.0});
            REQUIRE(skin->value[3 * i] == Approx(skin->value[3 * j + 1]).epsilon(0).margin(1e-12));
            REQUIRE(skin->value[3 * i + 2] == Approx(skin->value[3 * j + 2]).epsilon(0).margin(1e-12));
        }
    }
}

TEST_CASE("bone_heat: for little heat, the mean over the vertices", "[surface][skin][property]") {
    // Then the weights are equal at all vertices: Σ M H p / Σ M H. They must not vanish at 1e-18.
    const MeshData mesh = cageform_tests::sphere(3);
    const auto areas = cageform::cotangent_weights(mesh.vertices, mesh.faces).value.areas;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        std::vector<BoneSegment> bones(3);
        for (auto& bone : bones) {
            for (auto* end : {&bone.head, &bone.tail}) {
                for (double& x : end->v) x = random.uniform(-0.5, 0.5);
            }
        }
        std::array<double, 3> shares{};
        for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
            std::array<double, 3> distance{};
            for (std::size_t b = 0; b < 3; ++b)
                distance[b] =
                    cageform::detail::distance_to_segment(mesh.vertices[i], bones[b].head, bones[b].tail);
            const auto nearest = std::min_element(distance.begin(), distance.end());
            shares[std::size_t(nearest - distance.begin())] += areas[i] / (*nearest * *nearest);
        }
        const double all = shares[0] + shares[1] + shares[2];
        SurfaceSkinOptions options = blind;
        for (const double heat : {1e-10, 1e-18, 1e-320}) {
            options.heat = heat;
            const auto skin = bone_heat(mesh.vertices, mesh.faces, bones, options);
            REQUIRE(skin.report.status == Status::ok);
            const double margin = std::max(100 * heat, 1e-12);
            for (std::size_t n = 0; n < skin.value.size(); ++n)
                REQUIRE(skin.value[n] == Approx(shares[n % 3] / all).epsilon(0).margin(margin));
        }
        options.heat = 1e308; // compared with the influence of neighbours
        const auto skin = bone_heat(mesh.vertices, mesh.faces, bones, options);
        REQUIRE(skin.report.status == Status::ok);
        for (const double w : skin.value) REQUIRE((w == 1 || w < 1e-100));
    }
}

TEST_CASE("bone weights: binding, posing and cloning give linear blend skinning",
          "[surface][skin][property]") {
    const auto seed = GENERATE(range(0, 4));
    CAPTURE(seed);
    const Ring ring{std::uint64_t(seed)};
    const auto& points = ring.mesh.vertices;
    const auto& faces = ring.mesh.faces;
    Random random{std::uint64_t(seed)};
    using Move = cageform::Transform<double, 3>;
    const auto any = [&] {
        return Point{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)};
    };
    std::vector<Move> rest, own, common;
    const Move same{{any(), any(), any()}, any()};
    for (const auto& bone : ring.bones) {
        rest.push_back({{Point{1, 0, 0}, Point{0, 1, 0}, Point{0, 0, 1}}, bone.head});
        own.push_back({{any(), any(), any()}, any()});
        common.push_back(same);
    }
    for (const bool is_heat : {false, true}) {
        const auto weights =
            (is_heat ? bone_heat(points, faces, ring.bones) : harmonic_skin(points, faces, ring.bones)).value;
        const auto bound =
            cageform::bind_bones(points, std::span<const Move>(rest), std::span<const double>(weights));
        REQUIRE(bound.report.status == Status::ok);
        for (const auto& moves : {own, common}) {
            std::vector<Point> pose(4 * rest.size()), out(points.size());
            REQUIRE(cageform::pose_bones(bound.value, std::span<const Move>(moves), pose) == Status::ok);
            REQUIRE(clone(bound.value, pose, out) == Status::ok);
            for (std::size_t i = 0; i < points.size(); ++i) {
                Point expected{};
                for (std::size_t b = 0; b < rest.size(); ++b) {
                    const auto moved = moves[b].map_vector(points[i]) + moves[b].translation;
                    expected = expected + weights[i * rest.size() + b] * moved;
                }
                if (moves[0].translation == same.translation)
                    expected = same.map_vector(points[i]) + same.translation;
                for (std::size_t k = 0; k < 3; ++k)
                    REQUIRE(out[i][k] == Approx(expected[k]).epsilon(0).margin(1e-12));
            }
        }
    }
}

TEST_CASE("harmonic_skin: a bone moves nothing beyond its neighbouring bones", "[surface][skin]") {
    const MeshData mesh = cageform_tests::torus(60, 9); // five bones around, each with its own third
    std::vector<BoneSegment> bones;
    const auto at = [](double turn) {
        return Point{std::cos(2 * std::numbers::pi * turn), std::sin(2 * std::numbers::pi * turn), 0};
    };
    for (int b = 0; b < 5; ++b) bones.push_back({at(b / 5.0), at((b + 1) / 5.0)});
    const auto skin = harmonic_skin(mesh.vertices, mesh.faces, bones);
    REQUIRE(skin.report.status == Status::ok);
    std::size_t shared = 0;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        const double turn = double(i / 9) / 60 * 5; // the adjacent bone, and the position
        for (std::size_t b = 0; b < 5; ++b) {
            CAPTURE(i, b);
            const double away = std::fabs(std::remainder(turn - (double(b) + 0.5), 5.0));
            const double w = skin.value[5 * i + b];
            if (away > 0.9) REQUIRE(w == 0);
            if (away < 0.1) REQUIRE(w == 1);
            if (away > 0.4 && away < 0.6) ++shared;
            if (away > 0.4 && away < 0.6) REQUIRE((w > 0.2 && w < 0.8));
        }
    }
    CHECK(shared > 50);
}

TEST_CASE("bone weights: a mesh in 2D", "[surface][skin]") {
    // A bar, which is an open mesh: as the same bar in 3D.
    std::vector<cageform::Vec<float, 2>> flat;
    MeshData mesh;
    for (int n = 0; n < 45; ++n) {
        const int x = n / 5, y = n % 5;
        flat.push_back({float(x) + 0.25F * float(y % 2), float(y)});
        mesh.vertices.push_back({x + 0.25 * (y % 2), double(y), 0});
        if (x < 8 && y < 4) mesh.faces.insert(mesh.faces.end(), {{n, n + 5, n + 1}, {n + 1, n + 5, n + 6}});
    }
    const std::vector<BoneSegment> bones{{{0, 2, 0}, {4, 2, 0}}, {{4, 2, 0}, {8, 2, 0}}};
    const auto same = [&](const auto& of_flat, const auto& of_space) {
        REQUIRE(of_flat.report.status == Status::ok);
        REQUIRE(of_flat.value.size() == of_space.value.size());
        for (std::size_t n = 0; n < of_flat.value.size(); ++n)
            REQUIRE(of_flat.value[n] == float(of_space.value[n]));
    };
    same(harmonic_skin(flat, mesh.faces, bones), harmonic_skin(mesh.vertices, mesh.faces, bones));
    same(bone_heat(flat, mesh.faces, bones, blind), bone_heat(mesh.vertices, mesh.faces, bones, blind));
    CHECK(bone_heat(flat, mesh.faces, bones).report.status == Status::cage_not_closed);
    const auto weights = cageform::cotangent_weights(flat, mesh.faces);
    CHECK(weights.report.rim_edges == 2 * (8 + 4));
    CHECK(weights.value.links.size() > 80);
    flat[7][1] = std::numeric_limits<float>::infinity();
    const auto bad = cageform::cotangent_weights(flat, mesh.faces);
    REQUIRE(bad.report.mesh.faults.size() == 1);
    CHECK(bad.report.mesh.faults[0].a == 7);
}

TEST_CASE("FaceTree agrees with a loop over all faces and the winding number", "[surface][skin][property]") {
    const auto seed = GENERATE(range(0, 10));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    // On lattices rays meet vertices, edges and faces.
    MeshData mesh =
        seed % 2 == 0 ? cageform_tests::divided_box({4, 3, 5}, 1.0) : cageform_tests::torus(13, 7);
    const MeshData inner = cageform_tests::divided_box({2, 1, 1}, 1.0);
    if (seed % 2 == 0) { // a cavity in either orientation
        const int first = int(mesh.vertices.size());
        for (const auto& v : inner.vertices) mesh.vertices.push_back(v + Point{0, 0.5, 0.5});
        for (const auto& f : inner.faces) mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    }
    const auto shape = mesh.mesh<double>();
    const cageform::detail::FaceTree tree(shape.vertices(), shape.faces());
    std::size_t inside = 0, free = 0, checked = 0;
    for (int n = 0; n < 400; ++n) {
        Point p{random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
        if (seed % 2 == 0) p = {0.5 * std::round(2 * p[0]), 0.5 * std::round(2 * p[1]), p[2]};
        if (seed % 2 == 1) p = {0.5 * p[0], 0.5 * p[1], 0.15 * p[2]};
        if (cageform::locate(shape, p, 1e-9) == cageform::PointState::on_boundary) continue;
        const bool is_inside = cageform::locate(shape, p, 1e-9) == cageform::PointState::inside;
        CAPTURE(p[0], p[1], p[2]);
        REQUIRE(tree.encloses(p) == is_inside);
        inside += is_inside ? 1 : 0;
        const auto vertex = std::uint32_t(random.below(mesh.vertices.size()));
        bool meets = false;
        for (const auto& face : shape.faces()) {
            const cageform::Facet<3> facet(face, shape.vertices());
            meets =
                meets || (!facet.has(vertex) && cageform::detail::pierces(shape[vertex], p, facet.corner));
        }
        REQUIRE(tree.is_free(vertex, p) == !meets);
        free += meets ? 0 : 1;
        ++checked;
    }
    CHECK(checked > 200);
    CHECK(inside > 10);
    CHECK(free > 10);
}

TEST_CASE("FaceTree: no segment passes between faces", "[surface][skin][property]") {
    // Outwards through a point on an edge that rounding moves to either side of both faces.
    MeshData mesh = cageform_tests::sphere(2);
    Random random(5);
    for (auto& v : mesh.vertices) v = {v[0] + 0.1 * v[1], v[1] - 0.3 * v[2], v[2] / 3};
    const auto shape = mesh.mesh<double>();
    const cageform::detail::FaceTree tree(shape.vertices(), shape.faces());
    std::size_t checked = 0;
    for (int n = 0; n < 20000; ++n) {
        const auto vertex = std::uint32_t(random.below(mesh.vertices.size()));
        const auto& face = shape.faces()[random.below(mesh.faces.size())];
        const auto &p = shape[vertex], &a = shape[face[0]], &b = shape[face[1]];
        const double part = random.below(8) == 0 ? 0 : random.uniform(0, 1); // vertices too
        const Point q = p + random.uniform(1.5, 3) * (a + part * (b - a) - p);
        if (dot(a - p, a - p) < 1 || dot(b - p, b - p) < 1) continue; // not along the surface
        CAPTURE(vertex, q[0], q[1], q[2]);
        REQUIRE(!tree.is_free(vertex, q));
        ++checked;
    }
    CHECK(checked > 5000);
}

TEST_CASE("FaceTree: segments to a face, along a face, and with reversed faces", "[surface][skin]") {
    MeshData mesh = cageform_tests::divided_box({2, 2, 2}, 1.0); // 3³ points without the centre
    const auto vertex_at = [&](const Point& p) {
        const auto at = std::find(mesh.vertices.begin(), mesh.vertices.end(), p);
        REQUIRE(at != mesh.vertices.end());
        return std::uint32_t(at - mesh.vertices.begin());
    };
    const auto top = vertex_at({0, 0, 1}), edge = vertex_at({0, -1, 1}), corner = vertex_at({-1, -1, 1});
    for (const bool turned : {false, true}) {
        for (auto& face : mesh.faces) {
            if (turned) std::swap(face[0], face[1]);
        }
        const auto shape = mesh.mesh<double>();
        const cageform::detail::FaceTree tree(shape.vertices(), shape.faces());
        for (const double x : {0.0, 0.125, 0.5, 1.0}) {
            for (const double y : {-1.0, 0.0, 0.25, 0.375}) {
                CAPTURE(turned, x, y);
                CHECK(tree.is_free(top, {x, y, -1}));     // ends on a face, an edge, at a vertex
                CHECK(!tree.is_free(top, {x, y, -1.25})); // and behind
                CHECK(tree.is_free(top, {x, y, 0.5}));
                CHECK(tree.is_free(top, {x, y, 1.5}));
                CHECK(tree.is_free(corner, {x, y, 0.25}) == (y > -1)); // not along the side
                CHECK(!tree.is_free(corner, {x, y, 1}));               // along faces of the vertex and others
                CHECK(tree.encloses({0.5 * x, 0.5 * y, 0.25}));
            }
        }
        CHECK(!tree.is_free(edge, {0, 0.5, 1}));
        CHECK(!tree.is_free(edge, {0, 2, 1}));
        CHECK(tree.is_free(edge, {0, -2, 1})); // away from them in their plane
        CHECK(tree.is_free(corner, {-1, -2, 1}));
    }
}

TEST_CASE("harmonic_skin: given groups", "[surface][skin]") {
    const MeshData mesh = cageform_tests::sphere(2);
    const std::vector<BoneSegment> bones(2);
    std::vector<std::uint32_t> groups(mesh.vertices.size(), cageform::no_bone);
    for (std::size_t i = 0; i < groups.size(); ++i) {
        if (mesh.vertices[i][2] > 0.7) groups[i] = 0;
        if (mesh.vertices[i][2] < -0.7) groups[i] = 1;
    }
    const auto skin = harmonic_skin(mesh.vertices, mesh.faces, bones, {.groups = groups});
    REQUIRE(skin.report.status == Status::ok);
    for (std::size_t i = 0; i < groups.size(); ++i) {
        if (groups[i] != cageform::no_bone) REQUIRE(skin.value[2 * i + groups[i]] == 1);
        if (mesh.vertices[i][2] == 0) REQUIRE(skin.value[2 * i] == Approx(0.5).epsilon(1e-12));
    }
    groups[7] = 2;
    const auto bad = harmonic_skin(mesh.vertices, mesh.faces, bones, {.groups = groups});
    CHECK(bad.report.status == Status::index_out_of_range);
    CHECK(bad.report.solver.culprit == 7);
    CHECK(bad.value.empty());
    groups.pop_back();
    CHECK(harmonic_skin(mesh.vertices, mesh.faces, bones, {.groups = groups}).report.status ==
          Status::labels_do_not_match);
}

TEST_CASE("bone weights: errors have a status", "[surface][skin][errors]") {
    const MeshData mesh = cageform_tests::sphere(2);
    const std::vector<BoneSegment> good{{{-0.5, 0, 0}, {-0.1, 0, 0}}, {{0.1, 0, 0}, {0.5, 0, 0}}};
    using Bones = std::vector<BoneSegment>;
    const auto status = [&](const MeshData& of, const Bones& bones, const SurfaceSkinOptions& options = {}) {
        const auto skin = bone_heat(of.vertices, of.faces, bones, options);
        CHECK((skin.report.status == Status::ok) == !skin.value.empty());
        return skin.report.status;
    };
    CHECK(status(mesh, good) == Status::ok);
    CHECK(status(mesh, {}) == Status::bone_weights_do_not_match);
    Bones bones = good;
    bones[1].tail[2] = std::numeric_limits<double>::infinity();
    CHECK(status(mesh, bones) == Status::value_not_finite);
    CHECK(bone_heat(mesh.vertices, mesh.faces, bones).report.solver.culprit == 1);
    bones[1].tail[2] = -1e101; // squares of distances would overflow
    CHECK(status(mesh, bones, blind) == Status::value_not_finite);
    bones[1].tail[2] = 1e99;
    CHECK(status(mesh, bones, blind) == Status::ok);
    CHECK(status(mesh, {{{1e99, 0, 0}, {2e99, 0, 0}}}, blind) == Status::ok);
    CHECK(status(mesh, good, {.heat = 0}) == Status::weights_not_positive);
    CHECK(status(mesh, good, {.heat = std::numeric_limits<double>::quiet_NaN()}) ==
          Status::weights_not_positive);
    // Outside and not visible: the segments to it do not stay inside.
    CHECK(status(mesh, {{{3, 0, 0}, {4, 0, 0}}}) == Status::cells_unreached);
    CHECK(status(mesh, {{{3, 0, 0}, {4, 0, 0}}}, blind) == Status::ok);
    MeshData open = mesh;
    open.faces.pop_back();
    CHECK(status(open, good) == Status::cage_not_closed);
    const auto refused = bone_heat(open.vertices, open.faces, good);
    REQUIRE(refused.report.mesh.mesh.faults.size() == 3);
    CHECK(refused.report.mesh.mesh.faults[0].kind == cageform::CageFaultKind::open_edge);
    CHECK(status(open, good, blind) == Status::ok);
    open.vertices[3][0] = std::numeric_limits<double>::quiet_NaN();
    CHECK(status(open, good, blind) == Status::vertex_not_finite);
    // A bone through a vertex, and one that is a point.
    bones = {{mesh.vertices[0], mesh.vertices[0]}, good[0]};
    const auto skin = bone_heat(mesh.vertices, mesh.faces, bones);
    REQUIRE(skin.report.status == Status::ok);
    CHECK(skin.value[0] == Approx(1).epsilon(1e-6));

    cageform::Running stop;
    stop.progress = [](double) { return false; };
    CHECK(bone_heat(mesh.vertices, mesh.faces, good, {}, stop).report.status == Status::cancelled);
    const Ring ring(0);
    CHECK(harmonic_skin(ring.mesh.vertices, ring.mesh.faces, ring.bones, {}, stop).report.status ==
          Status::cancelled);
}

} // namespace surface_skin_tests
