#include "../catch.hpp"
#include "../support/larger.hpp"
#include "../support/polyhedra.hpp"

#include <algorithm>

namespace polyhedral_mesh_tests {

using namespace cageform_tests;
using cageform::CageFaultKind;
using cageform::PointState;
using cageform::PolyhedralMesh;
using cageform::Status;

namespace {

/// The faults that are none of the warnings.
template <class T>
std::vector<cageform::CageFault> faults_of(const PolyhedralMesh<T>& mesh) {
    auto faults = check(mesh).faults;
    std::erase_if(faults, [](const auto& fault) { return cageform::status_of(fault.kind) == Status::ok; });
    return faults;
}

} // namespace

TEST_CASE("a polygon is cut into triangles that have an area", "[cage][polyhedral]") {
    const auto seed = GENERATE(range<std::uint64_t>(0, 300));
    CAPTURE(seed);
    Random random(seed);
    auto base = random_star<double>(seed);
    double area = 0, size = 0;
    for (std::size_t k = 0; k < base.size(); ++k)
        area += 0.5 * cross(base[k] - base[0], base[(k + 1) % base.size()] - base[0]);
    if (area < 0) std::reverse(base.begin(), base.end());
    std::vector<Vec<double, 2>> polygon; // with up to three vertices more on an edge, exactly on its line
    for (std::size_t k = 0; k < base.size(); ++k) {
        const auto& next = base[(k + 1) % base.size()];
        polygon.push_back(base[k]);
        for (std::size_t n = random.below(4), of = n + 1; n > 0; --n)
            polygon.push_back(next + (double(n) / double(of)) * (base[k] - next));
        size = cageform_tests::larger(size, cageform::detail::length(next - base[k]));
    }
    const cageform::detail::PolygonCutter cutter(polygon);
    REQUIRE(cutter.triangles().size() == polygon.size() - 2);
    double sum = 0;
    for (const auto& [a, b, c] : cutter.triangles()) {
        const double own = 0.5 * cross(polygon[b] - polygon[a], polygon[c] - polygon[a]);
        CHECK(own > 1e-6 * size * size / double(polygon.size()) / double(polygon.size()));
        sum += own;
    }
    CHECK(sum == Approx(std::fabs(area)).epsilon(1e-12));
}

TEMPLATE_TEST_CASE("prisms over stars are sound, whatever vertices lie on their edges", "[cage][polyhedral]",
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
    // Inside is what is over the floor and under the ceiling.
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
        // The sides stay flat: they hold the direction in which the corner has moved.
        CHECK(faults_of(data.cage<double>()).size() == 1);
        CHECK(check(PolyhedralMesh<double>(data.vertices, data.faces, 1e-9)).status == Status::ok);
        CHECK(check(PolyhedralMesh<float>(data.vertices, data.faces)).status ==
              Status::ok); // of float a rounding
    }
    SECTION("64 roundings are no fault") {
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
    SECTION("a vertex that there is not") {
        data.faces[4][1] = 12;
        CHECK(only_fault(CageFaultKind::face_without_vertex).a == 4);
    }
    SECTION("a number that is none") {
        data.vertices[7][1] = std::numeric_limits<double>::quiet_NaN();
        CHECK(only_fault(CageFaultKind::vertex_not_finite).a == 7);
    }
    SECTION("a face turned inside out") {
        std::reverse(data.faces[1].begin(), data.faces[1].end());
        const auto fault = only_fault(CageFaultKind::face_flipped);
        CHECK((fault.a == 1 || fault.b == 1));
        CHECK(std::max(fault.a, fault.b) < data.faces.size()); // faces, not triangles
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
    SECTION("nothing") {
        data = {};
        (void)only_fault(CageFaultKind::too_few_vertices);
    }
    SECTION("coordinates beyond all products") {
        for (auto& v : data.vertices) v = 1e300 * v;
        CHECK(check(data.cage<double>()).status != Status::ok); // as of a TriangleMesh
        CHECK(check(data.cage<double>().triangles()).status != Status::ok);
    }
}

TEST_CASE("a small gap is closed by triangles, and said", "[cage][polyhedral]") {
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
