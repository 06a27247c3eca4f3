#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/larger.hpp"
#include "../support/polyhedra.hpp"

#include <algorithm>

namespace polyhedral_mesh_tests {

using namespace cageform_tests;
using cageform::CageFaultKind;
using cageform::PointState;
using cageform::PolyhedralMesh;
using cageform::PolyhedralOptions;
using cageform::Status;

namespace {

/// The faults that are not warnings.
template <class T>
std::vector<cageform::CageFault> faults_of(const PolyhedralMesh<T>& mesh) {
    auto faults = check(mesh).faults;
    std::erase_if(faults, [](const auto& fault) { return cageform::status_of(fault.kind) == Status::ok; });
    return faults;
}

} // namespace

TEST_CASE("PolygonTriangulation makes triangles with an area", "[cage][polyhedral]") {
    const auto seed = GENERATE(range<std::uint64_t>(0, 300));
    CAPTURE(seed);
    Random random(seed);
    auto base = random_star<double>(seed);
    double area = 0, size = 0;
    for (std::size_t k = 0; k < base.size(); ++k)
        area += 0.5 * cross(base[k] - base[0], base[(k + 1) % base.size()] - base[0]);
    if (area < 0) std::reverse(base.begin(), base.end());
    std::vector<Vec<double, 2>> polygon; // with up to three extra vertices exactly on an edge
    for (std::size_t k = 0; k < base.size(); ++k) {
        const auto& next = base[(k + 1) % base.size()];
        polygon.push_back(base[k]);
        for (std::size_t n = random.below(4), of = n + 1; n > 0; --n)
            polygon.push_back(next + (double(n) / double(of)) * (base[k] - next));
        size = cageform_tests::larger(size, cageform::detail::length(next - base[k]));
    }
    const cageform::detail::PolygonTriangulation triangulation(polygon);
    REQUIRE(triangulation.triangles().size() == polygon.size() - 2);
    double sum = 0;
    for (const auto& [a, b, c] : triangulation.triangles()) {
        const double own = 0.5 * cross(polygon[b] - polygon[a], polygon[c] - polygon[a]);
        CHECK(own > 1e-6 * size * size / double(polygon.size()) / double(polygon.size()));
        sum += own;
    }
    CHECK(sum == Approx(std::fabs(area)).epsilon(1e-12));
}

TEMPLATE_TEST_CASE("prisms over stars are valid with any vertices on their edges", "[cage][polyhedral]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(range<std::uint64_t>(0, 60));
    CAPTURE(seed);
    const auto data = random_prism(seed);
    const auto mesh = data.template cage<TestType>();
    const auto report = check(mesh);
    REQUIRE(report.status == Status::ok);
    REQUIRE(mesh.face_count() == data.faces.size());
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        CHECK(
            std::equal(mesh.face(f).begin(), mesh.face(f).end(), data.faces[f].begin(), data.faces[f].end()));
        const auto [first, last] = mesh.triangles_of(f);
        CHECK(last - first == data.faces[f].size() - 2);
        for (std::size_t t = first; t < last; ++t) CHECK(mesh.face_of(t) == f);
    }
    // The inside is above the floor and below the ceiling.
    Random random(seed);
    const auto bounds = bounds_of(mesh.vertices());
    std::vector<Vec<double, 2>> base;
    for (std::size_t k = 0; k < mesh.size() / 2; ++k)
        base.push_back({double(mesh[k][0]), double(mesh[k][1])});
    const cageform::Polygon<double> floor(base);
    for (int n = 0; n < 50; ++n) {
        Vec<TestType, 3> p;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto extent = double(bounds.upper[k] - bounds.lower[k]);
            p[k] = TestType(random.uniform(double(bounds.lower[k]) - 0.1 * extent,
                                           double(bounds.upper[k]) + 0.1 * extent));
        }
        const bool between = p[2] > 0 && p[2] < bounds.upper[2];
        const bool inside = between && locate(floor, {double(p[0]), double(p[1])}, 0.0) == PointState::inside;
        CHECK(locate(mesh, p, TestType(0)) == (inside ? PointState::inside : PointState::outside));
    }
}

TEST_CASE("a faulty polyhedral mesh is refused with the face and the vertex", "[cage][polyhedral][status]") {
    auto data = l_prism();
    const auto only_fault = [&](CageFaultKind kind) {
        const auto faults = faults_of(data.cage<double>());
        REQUIRE(!faults.empty());
        CHECK(faults[0].kind == kind);
        CHECK(check(data.cage<double>()).status == cageform::status_of(kind));
        return faults[0];
    };
    SECTION("a corner off the plane") {
        data.vertices[3][2] = 1e-9;
        const auto fault = only_fault(CageFaultKind::face_not_planar);
        CHECK(fault.a == 0);
        CHECK(fault.b == 3);
        // The sides stay flat: the direction in which the corner moves is parallel to them.
        CHECK(faults_of(data.cage<double>()).size() == 1);
        CHECK(check(PolyhedralMesh<double>(data.vertices, data.faces, {.off_plane = 1e-9})).status ==
              Status::ok);
        CHECK(check(PolyhedralMesh<float>(data.vertices, data.faces)).status ==
              Status::ok); // one rounding of float
    }
    SECTION("64 roundings are not a fault") {
        data.vertices[3][2] = 32 * 0x1p-52;
        CHECK(check(data.cage<double>()).status == Status::ok);
    }
    SECTION("a loop that crosses itself") {
        std::swap(data.faces[1][1], data.faces[1][2]);
        CHECK(only_fault(CageFaultKind::face_crosses_itself).a == 1);
    }
    SECTION("a vertex twice in a loop") {
        data.faces[1].insert(data.faces[1].begin() + 3, data.faces[1][0]);
        CHECK(only_fault(CageFaultKind::face_crosses_itself).a == 1);
    }
    SECTION("a loop on a line") {
        data.faces.push_back({0, 1, 0, 1});
        CHECK(only_fault(CageFaultKind::face_without_area).a == data.faces.size() - 1);
    }
    SECTION("two corners") {
        data.faces[4].resize(2);
        const auto fault = only_fault(CageFaultKind::too_few_vertices);
        CHECK(fault.a == 4);
        CHECK(fault.b == 2);
    }
    SECTION("no corners") {
        data.faces[4].clear();
        CHECK(only_fault(CageFaultKind::too_few_vertices).a == 4);
    }
    SECTION("an index out of range") {
        data.faces[4][1] = 12;
        CHECK(only_fault(CageFaultKind::face_without_vertex).a == 4);
    }
    SECTION("a coordinate that is NaN") {
        data.vertices[7][1] = std::numeric_limits<double>::quiet_NaN();
        CHECK(only_fault(CageFaultKind::vertex_not_finite).a == 7);
    }
    SECTION("a face with reversed orientation") {
        std::reverse(data.faces[1].begin(), data.faces[1].end());
        const auto fault = only_fault(CageFaultKind::face_flipped);
        CHECK((fault.a == 1 || fault.b == 1));
        CHECK(std::max(fault.a, fault.b) < data.faces.size()); // face indices, not triangle indices
    }
    SECTION("faces that pass through each other") {
        auto other = data;
        for (auto& v : other.vertices) v = v + Vec<double, 3>{0.25, 0.25, 0.25};
        for (auto& face : other.faces) {
            for (auto& i : face) i += 12;
        }
        data.vertices.insert(data.vertices.end(), other.vertices.begin(), other.vertices.end());
        data.faces.insert(data.faces.end(), other.faces.begin(), other.faces.end());
        const auto fault = only_fault(CageFaultKind::faces_cross);
        CHECK(fault.a < 8);
        CHECK((fault.b >= 8 && fault.b < 16));
    }
    SECTION("half of the faces are missing") {
        data.faces.resize(4);
        (void)only_fault(CageFaultKind::open_edge);
    }
    SECTION("no faces") {
        data = {};
        (void)only_fault(CageFaultKind::too_few_vertices);
    }
    SECTION("coordinates whose products overflow") {
        for (auto& v : data.vertices) v = 1e300 * v;
        CHECK(check(data.cage<double>()).status != Status::ok); // as for a TriangleMesh
        CHECK(check(data.cage<double>().triangles()).status != Status::ok);
    }
}

TEST_CASE("faults of fans refer to faces and vertices of the mesh", "[cage][polyhedral][fans][status]") {
    const std::uint32_t divisions = GENERATE(1u, 2u, effort(5u, 4u));
    CAPTURE(divisions);
    PolyhedronData data = prism_over({{0, 0}, {2, 0}, {2, 2}, {0, 2}}, 2);
    PolyhedralOptions options{.faces = PolyhedralOptions::Faces::fan, .divisions = divisions};
    const auto mesh = [&] { return PolyhedralMesh<double>(data.vertices, data.faces, options); };
    REQUIRE(check(mesh()).status == Status::ok);
    CHECK(check(mesh()).faults.empty()); // planar fans give no warning
    const auto first_fault = [&](CageFaultKind kind) {
        const auto report = check(mesh());
        const auto faults = faults_of(mesh());
        REQUIRE(!faults.empty());
        CAPTURE(to_string(faults[0].kind), faults[0].a, faults[0].b);
        CHECK(faults[0].kind == kind);
        CHECK(report.status == cageform::status_of(kind));
        return faults[0];
    };
    SECTION("a warped face, and one that is not planar in any direction") {
        data.vertices[6][2] += 0.5;
        const auto report = check(mesh());
        REQUIRE(report.status == Status::ok);
        REQUIRE(report.faults.size() == 1);
        CHECK(report.faults[0].kind == CageFaultKind::face_fanned);
        CHECK(report.faults[0].a == 1);
        REQUIRE(report.fan_distances.size() == 1);
        CHECK(report.fan_distances[0] == 0.5 / 16 / divisions / divisions);
        options = {};
        CHECK(first_fault(CageFaultKind::face_not_planar).a == 1);
    }
    SECTION("a corner beyond the diagonal of the others") {
        data.vertices[6] = {0.25, 0.25, 2};
        const auto fault = first_fault(CageFaultKind::face_fan_folds);
        CHECK(fault.a == 1);
        CHECK((fault.b >= 4 && fault.b < 8));
    }
    SECTION("a bow tie whose triangles have different sizes") {
        data.faces[1] = {4, 6, 5, 7};
        data.vertices[5] = {4, -1, 2};
        CHECK(first_fault(CageFaultKind::face_fan_folds).a == 1);
    }
    SECTION("a bow tie") {
        data.faces[1] = {4, 6, 5, 7};
        CHECK(first_fault(CageFaultKind::face_without_area).a == 1);
    }
    SECTION("a star that goes around its mean twice") {
        data.faces.push_back({});
        for (std::uint32_t k = 0; k < 5; ++k) {
            const double angle = 4 * std::numbers::pi * k / 5;
            data.vertices.push_back({5 + std::cos(angle), std::sin(angle), 0.1 * (k % 2)});
            data.faces.back().push_back(8 + k);
        }
        CHECK(first_fault(CageFaultKind::face_fan_folds).a == 6);
    }
    SECTION("a repeated vertex") {
        data.faces[1] = {4, 5, 6, 4, 7};
        const auto fault = first_fault(CageFaultKind::face_crosses_itself);
        CHECK(fault.a == 1);
        CHECK(fault.b == 4);
    }
    SECTION("all corners on a line") {
        data.faces.push_back({0, 1, 9, 8});
        data.vertices.push_back({4, 0, 0});
        data.vertices.push_back({3, 0, 0});
        CHECK(first_fault(CageFaultKind::face_without_area).a == 6);
    }
    SECTION("a mean on an edge") {
        data.faces.push_back({8, 9, 10, 11});
        // The mean is (5.5, 1/4, 0); the corners are moved so that it is between the first two.
        for (const auto& v : {Vec<double, 3>{5, 0, 0}, {6, 0, 0}, {5.75, 1, 0}, {5.5, -1, 0}})
            data.vertices.push_back(v);
        CHECK(first_fault(CageFaultKind::face_without_area).a == 6);
    }
    SECTION("fans that cross") {
        // The middle of the floor is at 1/2, above the edge of the ceiling from vertex 4 to 6.
        data.vertices[1][2] = data.vertices[3][2] = 1;
        for (std::size_t k = 0; k < 4; ++k) data.vertices[4 + k][2] = data.vertices[k][2] + 0.2;
        data.faces[1] = {4, 5, 6};
        data.faces.push_back({4, 6, 7});
        const auto fault = first_fault(CageFaultKind::faces_cross);
        CHECK(fault.a == 0);
        CHECK((fault.b == 1 || fault.b == 6));
    }
    SECTION("means that coincide") {
        auto upper = prism_over({{0.5, 0.5}, {1.5, 0.5}, {1.5, 1.5}, {0.5, 1.5}}, 1);
        for (auto& v : upper.vertices) data.vertices.push_back(v + Vec<double, 3>{0, 0, 2});
        for (auto& face : upper.faces) {
            for (auto& i : face) i += 8;
            data.faces.push_back(face);
        }
        const auto fault = first_fault(CageFaultKind::faces_cross);
        CHECK(std::min(fault.a, fault.b) == 1);
        CHECK(std::max(fault.a, fault.b) == 6);
    }
    SECTION("an open edge") {
        data.faces.resize(3);
        const auto fault = first_fault(CageFaultKind::open_edge);
        CHECK(fault.a < 8);
        CHECK(fault.b < 8);
        CHECK(fault.a != fault.b);
    }
    SECTION("a small gap") {
        data.faces.pop_back();
        const auto report = check(mesh());
        for (const auto& fault : report.faults) {
            CHECK((fault.kind == CageFaultKind::gap_closed || fault.kind == CageFaultKind::open_edge));
            CHECK(fault.a < 8);
            CHECK(fault.b < 8);
        }
        if (divisions == 1) {
            CHECK(report.status == Status::ok);
            CHECK(report.faults.size() == 4);
        }
    }
    SECTION("three faces at an edge") {
        data.faces.push_back({0, 1, 9, 8});
        data.vertices.push_back({0, -2, 1});
        data.vertices.push_back({2, -2, 1});
        for (const auto& fault : faults_of(mesh())) {
            CHECK(fault.a < 10);
            CHECK(fault.b < 10);
        }
        CHECK(check(mesh()).status == Status::cage_not_manifold);
    }
    SECTION("a mean that is NaN") {
        for (auto& v : data.vertices) v = 8e307 * v;
        const auto fault = faults_of(mesh()).front();
        CHECK(fault.a < 8);
    }
}

TEST_CASE("faces are divided 1 to 64 times", "[cage][polyhedral][fans][status]") {
    const PolyhedronData data = prism_over({{0, 0}, {2, 0}, {2, 2}, {0, 2}}, 2);
    PolyhedralOptions options{.faces = PolyhedralOptions::Faces::fan, .divisions = effort(64U, 16U)};
    const auto mesh = [&] { return PolyhedralMesh<double>(data.vertices, data.faces, options); };
    CHECK(check(mesh()).status == Status::ok);
    for (const std::uint32_t k : {0u, 65u, ~0u}) {
        options.divisions = k;
        const auto faults = faults_of(mesh());
        REQUIRE(!faults.empty());
        CHECK(faults[0].kind == CageFaultKind::face_divisions);
        CHECK(faults[0].a == k);
        CHECK(check(mesh()).status == cageform::status_of(CageFaultKind::face_divisions));
    }
}

TEST_CASE("divided faces beside others form a closed mesh", "[cage][polyhedral][fans]") {
    // A house: a pentagon in front and behind, quads, and a roof with two triangles on one side.
    PolyhedronData data = prism_over({{0, 0}, {2, 0}, {2, 1}, {1, 2}, {0, 1}}, 3);
    const auto roof = data.faces.back();
    data.faces.pop_back();
    data.faces.push_back({roof[0], roof[1], roof[2]});
    data.faces.push_back({roof[0], roof[2], roof[3]});
    const std::uint32_t k = GENERATE(1u, 2u, 3u, 7u);
    CAPTURE(k);
    const PolyhedralMesh<double> mesh(
        data.vertices, data.faces, PolyhedralOptions{.faces = PolyhedralOptions::Faces::fan, .divisions = k});
    REQUIRE(check(mesh).status == Status::ok);
    CHECK(mesh.vertices().size() == 10);
    CHECK(mesh.size() == 10);
    for (std::size_t n = 0; n < mesh.fan_points().size(); ++n) {
        Vec<double, 3> p{};
        double sum = 0;
        mesh.fan_points().for_each_corner(n, [&](std::uint32_t v, double weight) {
            CHECK(weight > 0);
            sum += weight;
            p = p + weight * mesh[v];
        });
        CHECK(sum == Approx(1).epsilon(1e-15));
        CHECK(cageform::detail::length(p - mesh.triangles()[mesh.size() + n]) <= 1e-14);
    }
    // The faces are planar, so the volume is that of the prism.
    double volume = 0;
    for (const auto& [a, b, c] : mesh.triangles().faces()) {
        const auto& at = mesh.triangles().vertices();
        volume += dot(at[a], cross(at[b], at[c])) / 6;
    }
    CHECK(volume == Approx(9).epsilon(1e-13));
    for (std::size_t t = 0; t < mesh.triangles().faces().size(); ++t) {
        const auto [first, last] = mesh.triangles_of(mesh.face_of(t));
        CHECK((t >= first && t < last));
    }
}

TEST_CASE("a small gap is closed by triangles and reported", "[cage][polyhedral]") {
    auto data = prism_over({{0, 0}, {4, 0}, {4, 4}, {0, 4}, {-1, 2}}, 4);
    const std::vector<std::uint32_t> gone = data.faces.back();
    data.faces.pop_back();
    const auto mesh = data.cage<double>();
    const auto report = check(mesh);
    CHECK(report.status == Status::ok);
    CHECK(std::count_if(report.faults.begin(), report.faults.end(),
                        [](const auto& fault) { return fault.kind == CageFaultKind::gap_closed; }) == 4);
    CHECK(mesh.triangles().faces().size() > mesh.triangles().given_faces());
    CHECK(mesh.face_of(mesh.triangles().given_faces()) == mesh.face_count());
}

} // namespace polyhedral_mesh_tests
