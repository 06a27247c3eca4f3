// Triangle meshes as cages: point location, nearest points, and faults.
#include "../catch.hpp"
#include "../support/meshes.hpp"

#include <random>

namespace triangle_mesh_tests {

using namespace cageform_tests;
using cageform::CageFaultKind;
using cageform::PointState;
using cageform::Status;
using cageform::TriangleMesh;

namespace {

bool has(const cageform::CageReport& report, CageFaultKind kind, std::size_t a, std::size_t b = 0) {
    return std::any_of(report.faults.begin(), report.faults.end(),
                       [&](const auto& fault) { return fault.kind == kind && fault.a == a && fault.b == b; });
}
cageform::CageReport report_of(const Points3<double>& vertices, const Faces& faces) {
    return check(TriangleMesh<double>(vertices, faces));
}

} // namespace

TEST_CASE("valid meshes have no faults", "[cage][mesh]") {
    const int seed = GENERATE(seeds(24));
    CAPTURE(seed);
    const auto report = check(random_mesh(std::uint64_t(seed)).mesh<double>());
    CHECK(report.status == Status::ok);
    CHECK(report.faults.empty());
}

TEST_CASE("a mesh takes any points and any triples of integers, and deduces its scalar", "[cage][mesh]") {
    const float points[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const std::vector<std::array<std::uint16_t, 3>> small{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    const std::int64_t large[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    STATIC_REQUIRE(std::is_same_v<decltype(TriangleMesh(points, small)), TriangleMesh<float>>);
    STATIC_REQUIRE(cageform::FaceRange<Faces>);
    STATIC_REQUIRE(!cageform::FaceRange<Points3<double>>);
    STATIC_REQUIRE(!cageform::FaceRange<std::vector<int>>);
    const TriangleMesh<double> mesh(points, large);
    CHECK(check(mesh).status == Status::ok);
    CHECK(std::ranges::equal(mesh.faces(), TriangleMesh(points, small).faces()));
    const std::int64_t beyond[1][3] = {{0, (std::int64_t{1} << 32) + 1, 2}}; // not vertex 1
    CHECK(TriangleMesh<double>(points, beyond).faces()[0][1] == cageform::no_vertex);
}

TEST_CASE("locate and nearest_boundary_value agree with the sphere of the mesh", "[cage][mesh]") {
    const auto data = sphere(3);
    const auto mesh = data.mesh<double>();
    for (const auto& p : points_about(data, 500, 7)) {
        const double r = std::sqrt(dot(p, p));
        Vec<double, 3> place;
        const auto value = nearest_boundary_value(mesh, p, place);
        Vec<double, 3> sum{};
        for (std::size_t n = 0; n < value.weight.size(); ++n)
            sum = sum + value.weight[n] * mesh[value.handle[n]];
        CHECK(std::sqrt(dot(sum - place, sum - place)) <= 1e-15);
        CHECK(std::fabs(std::sqrt(dot(place - p, place - p)) - std::fabs(1 - r)) <= 0.02);
        if (r < 0.98) CHECK(locate(mesh, p, 1e-14) == PointState::inside);
        if (r > 1) CHECK(locate(mesh, p, 1e-14) == PointState::outside);
        if (r < 0.98 || r > 1) CHECK(std::fabs(winding_number(mesh, p) - (r < 1 ? 1 : 0)) <= 1e-12);
        CHECK(locate(mesh, place, 1e-14) == PointState::on_boundary);
    }
    // A cavity in either orientation.
    for (const bool turned : {false, true}) {
        auto shells = sphere(1);
        const auto inner = sphere(1);
        const int first = int(shells.vertices.size());
        for (const auto& v : inner.vertices) shells.vertices.push_back(0.5 * v);
        for (const auto& [a, b, c] : inner.faces) {
            if (turned) {
                shells.faces.push_back({first + a, first + c, first + b});
            } else {
                shells.faces.push_back({first + a, first + b, first + c});
            }
        }
        const auto hollow = shells.mesh<double>();
        const auto report = check(hollow);
        CHECK(report.status == Status::ok);
        CHECK(report.faults.size() == (turned ? 0 : 1));
        if (!turned) CHECK(has(report, CageFaultKind::shell_orientation_reversed, inner.faces.size()));
        CHECK(locate(hollow, Vec<double, 3>{0, 0, 0.1}, 1e-14) == PointState::outside);
        CHECK(locate(hollow, Vec<double, 3>{0, 0, 0.6}, 1e-14) == PointState::inside);
        CHECK(locate(hollow, Vec<double, 3>{0, 0, 1.6}, 1e-14) == PointState::outside);
    }
}

TEMPLATE_TEST_CASE("the face hierarchy agrees with a loop over all faces", "[cage][mesh][property]",
                   CAGEFORM_SCALARS) {
    const int seed = GENERATE(seeds(24));
    CAPTURE(seed);
    const auto data = random_mesh(std::uint64_t(seed));
    const auto mesh = data.template mesh<TestType>();
    const auto tolerance = coincidence_tolerance(bounds_of(mesh.vertices()));
    for (const auto& p : points_about(data, 200, unsigned(seed))) {
        const auto q = cageform::vec_cast<TestType>(p);
        double least = std::numeric_limits<double>::infinity();
        for (const auto& face : mesh.faces())
            least = (std::min)(
                least, cageform::detail::distance_to_facet(cageform::vec_cast<double>(q),
                                                           cageform::Facet<3>(face, mesh.vertices()).corner));
        Vec<TestType, 3> place;
        const auto value = nearest_boundary_value(mesh, q, place);
        auto off = -1.0 * cageform::vec_cast<double>(place);
        for (std::size_t k = 0; k < 3; ++k)
            off = off + value.weight[k] * cageform::vec_cast<double>(mesh[value.handle[k]]);
        CHECK(std::sqrt(dot(off, off)) <= double(tolerance));
        const auto way = cageform::vec_cast<double>(place) - cageform::vec_cast<double>(q);
        CHECK(std::fabs(std::sqrt(dot(way, way)) - least) <= double(tolerance));
        const bool is_enclosed = cageform::detail::is_enclosed(winding_number(mesh, q));
        if (least > 2 * double(tolerance))
            CHECK(locate(mesh, q, tolerance) == (is_enclosed ? PointState::inside : PointState::outside));
    }
    const auto nowhere = TriangleMesh<TestType>();
    CHECK(locate(nowhere, Vec<TestType, 3>{}, tolerance) == PointState::outside);
}

TEST_CASE("check reports every fault of a mesh", "[cage][mesh][status]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto good = sphere(1);
    auto data = good;
    CHECK(report_of({}, {}).status == Status::too_few_vertices);
    CHECK(report_of(good.vertices, {}).status == Status::cage_has_no_volume);
    data.vertices[3][1] = nan;
    CHECK(has(report_of(data.vertices, data.faces), CageFaultKind::vertex_not_finite, 3));

    for (const int missing : {-1, int(good.vertices.size())}) {
        data = good;
        data.faces[5][1] = missing;
        const auto report = report_of(data.vertices, data.faces);
        CHECK(report.status == Status::face_without_vertex);
        CHECK(has(report, CageFaultKind::face_without_vertex, 5));
    }
    data = good;
    data.vertices[7] = data.vertices[2];
    CHECK(has(report_of(data.vertices, data.faces), CageFaultKind::duplicate_vertices, 2, 7));

    data = good;
    data.faces.resize(data.faces.size() / 2); // half of the sphere: not a small gap
    auto report = report_of(data.vertices, data.faces);
    CHECK(report.status == Status::cage_not_closed);
    CHECK(std::count_if(report.faults.begin(), report.faults.end(),
                        [](const auto& fault) { return fault.kind == CageFaultKind::open_edge; }) == 8);
    data = good;
    std::swap(data.faces[6][0], data.faces[6][1]);
    report = report_of(data.vertices, data.faces);
    CHECK(report.status == Status::cage_faces_flipped);
    CHECK(report.faults.size() == 3);
    for (const auto& fault : report.faults) CHECK((fault.a == 6 || fault.b == 6));

    data = good;
    data.faces[6] = {data.faces[6][0], data.faces[6][0], data.faces[6][1]};
    CHECK(has(report_of(data.vertices, data.faces), CageFaultKind::face_without_area, 6));

    // Two tetrahedra with a common edge or vertex.
    const Faces tetrahedron{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    Faces two = tetrahedron;
    for (const auto& [a, b, c] : Faces{{0, 4, 1}, {0, 1, 5}, {1, 4, 5}, {0, 5, 4}}) two.push_back({a, b, c});
    const Points3<double> edge_points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}};
    CHECK(has(report_of(edge_points, two), CageFaultKind::edge_not_manifold, 0, 1));
    Faces at_vertex = tetrahedron;
    for (const auto& [a, b, c] : Faces{{0, 5, 4}, {0, 4, 6}, {4, 5, 6}, {0, 6, 5}})
        at_vertex.push_back({a, b, c});
    const Points3<double> vertex_points{{0, 0, 0},  {1, 0, 0},  {0, 1, 0}, {0, 0, 1},
                                        {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    report = report_of(vertex_points, at_vertex);
    CHECK(report.status == Status::cage_not_manifold);
    CHECK(has(report, CageFaultKind::vertex_not_manifold, 0));

    data = good;
    data.vertices[0] = {-3, 0.1, 0.2}; // moved through the other side
    report = report_of(data.vertices, data.faces);
    CHECK(report.status == Status::cage_faces_cross);
    data = good;
    data.vertices.push_back({0, 0, 0});
    report = report_of(data.vertices, data.faces);
    CHECK(report.status == Status::ok);
    CHECK(has(report, CageFaultKind::vertex_unused, data.vertices.size() - 1));
}

TEST_CASE("crossing faces around a vertex of many faces are found like all pairs", "[cage][mesh][status]") {
    std::mt19937 random(20261122);
    std::size_t sound = 0, crossing = 0;
    for (int round = 0; round < 60; ++round) {
        // Two cones over one rim with some vertices swapped.
        const auto rim = std::uint32_t(33 + random() % 60);
        const double mess = round % 3 == 0 ? 0 : 4.0 / rim;
        std::uniform_real_distribution<double> share(-1, 1);
        Points3<double> vertices{{0, 0, -1}, {0.2 * share(random), 0.2 * share(random), 1}};
        Faces faces;
        for (std::uint32_t i = 0; i < rim; ++i) {
            const double angle = 2 * std::numbers::pi / rim * i + mess * share(random);
            const double radius = 2 + share(random);
            vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.3 * share(random)});
            const int a = int(2 + i), b = int(2 + (i + 1) % rim);
            faces.push_back({0, b, a});
            faces.push_back({1, a, b});
        }
        std::vector<std::array<std::size_t, 2>> expected, found;
        for (std::size_t f = 0; f < faces.size(); ++f) {
            for (std::size_t g = f + 1; g < faces.size(); ++g) {
                const auto passes = [&](const auto& face, const auto& through) {
                    cageform::detail::Corners<3> corner;
                    for (std::size_t k = 0; k < 3; ++k) {
                        const auto& p = vertices[std::size_t(through[k])];
                        corner[k] = {p[0], p[1], p[2]};
                    }
                    const auto has = [&](int i) {
                        return std::find(through.begin(), through.end(), i) != through.end();
                    };
                    for (std::size_t k = 0; k < 3; ++k) {
                        const int i = face[k], j = face[(k + 1) % 3];
                        const auto &s = vertices[std::size_t(i)], &t = vertices[std::size_t(j)];
                        if (!has(i) && !has(j) &&
                            cageform::detail::pierces({s[0], s[1], s[2]}, {t[0], t[1], t[2]}, corner))
                            return true;
                    }
                    return false;
                };
                if (passes(faces[f], faces[g]) || passes(faces[g], faces[f])) expected.push_back({f, g});
            }
        }
        const auto report = report_of(vertices, faces);
        for (const auto& fault : report.faults) {
            if (fault.kind == CageFaultKind::faces_cross) found.push_back({fault.a, fault.b});
        }
        std::sort(found.begin(), found.end());
        INFO("round " << round);
        CHECK(found == expected);
        ++(expected.empty() ? sound : crossing);
    }
    CHECK(sound >= 20);
    CHECK(crossing >= 20);
}

TEST_CASE("small gaps are closed, with warnings for their edges", "[cage][mesh][status]") {
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    auto data = sphere(3);
    for (auto& v : data.vertices) v = random.uniform(0.8, 1.1) * v;
    const auto whole = data.mesh<double>();
    std::vector<std::pair<std::size_t, std::size_t>> dropped;
    for (int n = 0; n < 4; ++n) { // adjacent or not
        const std::size_t f = random.below(data.faces.size());
        for (std::size_t k = 0; k < 3; ++k) {
            const std::pair ends = std::minmax(data.faces[f][k], data.faces[f][(k + 1) % 3]);
            const auto a = std::size_t(ends.first), b = std::size_t(ends.second);
            const auto again = std::find(dropped.begin(), dropped.end(), std::pair(a, b));
            if (again == dropped.end()) {
                dropped.push_back({a, b});
            } else {
                dropped.erase(again);
            }
        }
        data.faces.erase(data.faces.begin() + std::ptrdiff_t(f));
    }
    const auto mesh = data.mesh<double>();
    const auto report = check(mesh);
    REQUIRE(report.status == Status::ok);
    CHECK(report.faults.size() == dropped.size());
    for (const auto& [a, b] : dropped) CHECK(has(report, CageFaultKind::gap_closed, a, b));
    CHECK(mesh.given_faces() == data.faces.size());
    CHECK(mesh.faces().size() == whole.faces().size());
    for (const auto& p : points_about(data, 200, 5)) {
        Vec<double, 3> place;
        (void)nearest_boundary_value(whole, p, place);
        if (dot(place - p, place - p) < 0.02)
            continue; // a gap of two faces may be closed along its other diagonal
        CHECK(locate(mesh, p, 1e-12) == locate(whole, p, 1e-12));
        CHECK(std::fabs(winding_number(mesh, p) - winding_number(whole, p)) <= 1e-9);
    }
}

TEST_CASE("a gap that cannot be closed is an open edge", "[cage][mesh][status]") {
    // A vertex in the middle of an edge that is missing in the face on the other side: the gap is flat.
    const Points3<double> vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0, 0}};
    const auto report = report_of(vertices, {{0, 2, 1}, {0, 4, 3}, {4, 1, 3}, {1, 2, 3}, {0, 3, 2}});
    CHECK(report.status == Status::cage_not_closed);
}

TEST_CASE("gaps that touch at a vertex are closed, isolated faces and flat cages are refused",
          "[cage][mesh][status]") {
    for (int n = 0; n < 20; ++n) {
        CAPTURE(n);
        auto data = sphere(2);
        Random random{std::uint64_t(n)};
        for (std::size_t i = data.vertices.size(); i-- > 1;) { // any numbering
            const std::size_t j = random.below(i + 1);
            std::swap(data.vertices[i], data.vertices[j]);
            for (auto& face : data.faces) {
                for (int& v : face) v = v == int(i) ? int(j) : v == int(j) ? int(i) : v;
            }
        }
        const int tip = data.faces[0][0]; // two faces around a vertex that are not neighbours
        std::vector<std::size_t> about;
        for (std::size_t f = 0; f < data.faces.size(); ++f) {
            if (std::find(data.faces[f].begin(), data.faces[f].end(), tip) != data.faces[f].end())
                about.push_back(f);
        }
        const auto neighbours = [&](std::size_t f, std::size_t g) {
            int common = 0;
            for (const int v : data.faces[f])
                common += std::count(data.faces[g].begin(), data.faces[g].end(), v) > 0;
            return common > 1;
        };
        std::size_t other = 1;
        while (neighbours(about[0], about[other])) ++other;
        data.faces.erase(data.faces.begin() + std::ptrdiff_t(about[other]));
        data.faces.erase(data.faces.begin() + std::ptrdiff_t(about[0]));
        CHECK(check(data.mesh<double>()).status == Status::ok);
    }
    auto stray = sphere(1);
    const int first = int(stray.vertices.size());
    for (const auto& v : Points3<double>{{0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}}) stray.vertices.push_back(v);
    stray.faces.push_back({first, first + 1, first + 2});
    CHECK(check(stray.mesh<double>()).status == Status::cage_not_closed);
    const auto flat = report_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 0}},
                                {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}});
    CHECK(flat.status == Status::cage_has_no_volume);
}

} // namespace triangle_mesh_tests
