// Harmonic coordinates in triangle meshes: the laws to the solver's tolerance, the oracle, and robust
// intersections.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/larger.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"
#include "../support/uniform_harmonic.hpp"
#include "../support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>
#include <cageform/grid/lattice/simplex_boundary.hpp>
#include <cageform/parallel/threads.hpp>

namespace harmonic_mesh_tests {

using namespace cageform_tests;
using cageform::epsilon;
using cageform::HarmonicCoordinates;
using cageform::HarmonicOptions;
using cageform::grid::SimplexBoundary;

namespace {

/// Random points inside.
template <class T>
Points3<T> points_in(const cageform::TriangleMesh<T>& mesh, const MeshData& data, std::uint64_t seed) {
    Points3<T> points;
    const auto tolerance = cageform::coincidence_tolerance(cageform::bounds_of(mesh.vertices()));
    for (const auto& p : points_about(data, 400, seed)) {
        if (locate(mesh, vec_cast<T>(p), tolerance) == PointState::inside) points.push_back(vec_cast<T>(p));
    }
    for (std::size_t f = 0; f < mesh.faces().size(); f += 5) { // on faces, edges and vertices
        const auto &a = mesh[mesh.faces()[f][0]], &b = mesh[mesh.faces()[f][1]],
                   &c = mesh[mesh.faces()[f][2]];
        points.push_back(f % 15 == 0 ? a : f % 15 == 5 ? T(0.5) * (a + b) : T(0.25) * (a + b) + T(0.5) * c);
    }
    return points;
}

} // namespace

TEMPLATE_TEST_CASE("weights in a mesh sum to 1, reproduce the point and stay in [0, 1] at every resolution",
                   "[coordinates][harmonic][mesh][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(8, 4)));
    const std::size_t resolution = GENERATE(std::size_t{14}, effort<std::size_t>(29, 10));
    CAPTURE(seed, resolution);
    const auto data = random_mesh(std::uint64_t(seed));
    const auto mesh = data.mesh<T>();
    const auto points = points_in(mesh, data, std::uint64_t(seed));
    const HarmonicCoordinates<T, 3> coordinates(mesh, {.resolution = resolution}, cageform::UniformGrid{});
    const auto weights = evaluate_all(coordinates, points);
    if (weights.status() == Status::grid_too_coarse) { // a thin part
        CHECK(weights.evaluation.solver.unseen_handle < mesh.size());
        CHECK(weights.evaluation.solver.sufficient_resolution > resolution);
        return;
    }
    REQUIRE(weights.status() == Status::ok);
    CHECK(weights.evaluation.solver.multigrid.convergence_factor <= 0.2);
    const auto bounds = cageform::bounds_of(mesh.vertices());
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        CHECK(weights.states[i] != PointState::outside);
        double size = 0, total = 0; // the effect of functions with errors up to the tolerance
        for (std::size_t k = 0; k < mesh.size(); ++k) {
            total += 1e-6 + double(epsilon<T>);
            size = cageform_tests::larger(size, distance(mesh[k], points[i]));
        }
        CHECK(std::fabs(double(sum_of(weights.rows[i])) - 1) <= total);
        CHECK(distance(combine(weights.rows[i], mesh.vertices()), points[i]) <=
              total * size + 64 * double(epsilon<T>) * double(bounds.magnitude()));
        for (const T w : weights.rows[i]) CHECK((w >= T(0) && w <= T(1)));
    }
    if (resolution > 14) return;
    cageform::Running threaded;
    threaded.parallel = cageform::ThreadedFor{2};
    CHECK((evaluate_all(coordinates, points, threaded).rows == weights.rows));
}

TEMPLATE_TEST_CASE(
    "in meshes of 20 to 500 vertices weights reproduce the point, are 1 at their vertex and barycentric "
    "on faces",
    "[coordinates][harmonic][meanvalue][mesh][property]", (cageform_tests::UniformHarmonic<float, 3>),
    (cageform::MeanValueCoordinates<double, 3>)) {
    using C = TestType;
    using T = typename C::scalar;
    const int seed = GENERATE(seeds(effort(10, 3)));
    CAPTURE(seed);
    const auto data = random_large_mesh(std::uint64_t(seed));
    const auto mesh = data.mesh<T>();
    Random random{std::uint64_t(seed)};
    Points3<T> points(mesh.vertices().begin(), mesh.vertices().end());
    std::vector<std::array<double, 3>> shares;
    for (const auto& face : mesh.faces()) { // every third point lies on an edge
        const auto w = random_shares(shares.size() % 3 == 0 ? 2 : 3, random);
        shares.push_back({w[0], w[1], w.size() > 2 ? w[2] : 0});
        Vec<double, 3> p{};
        for (std::size_t k = 0; k < 3; ++k) p = p + shares.back()[k] * vec_cast<double>(mesh[face[k]]);
        points.push_back(vec_cast<T>(p));
    }
    const std::size_t on = points.size();
    for (const auto& p : points_about(data, 300, std::uint64_t(seed))) {
        const auto tolerance = cageform::coincidence_tolerance(cageform::bounds_of(mesh.vertices()));
        if (locate(mesh, vec_cast<T>(p), tolerance) == PointState::inside) points.push_back(vec_cast<T>(p));
    }
    const C coordinates = [&] {
        if constexpr (C::closed_form) {
            return C(mesh);
        } else {
            return C(mesh, {.resolution = effort(32u, 16u)});
        }
    }();
    const auto weights = evaluate_all(coordinates, points);
    if (weights.status() == Status::grid_too_coarse) {
        CHECK(weights.evaluation.solver.unseen_handle < mesh.size());
        return;
    }
    REQUIRE(weights.status() == Status::ok);
    const auto bounds = cageform::bounds_of(mesh.vertices());
    const double size = double(bounds.diagonal()) + double(bounds.magnitude());
    // Rounding of coordinates may move a point off its face.
    const double rounding = double(bounds.magnitude()) / double(bounds.diagonal()) + 1;
    const double solved = C::closed_form ? 0 : 1e-6;
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        const auto& row = weights.rows[i];
        const double much = absolute_sum(row) + 1;
        CHECK(std::fabs(double(sum_of(row)) - 1) <=
              much * (256 * double(epsilon<T>) + double(mesh.size()) * solved));
        CHECK(distance(combine(row, mesh.vertices()), points[i]) <=
              much * size * (4096 * double(epsilon<T>) + double(mesh.size()) * solved));
        if constexpr (!C::closed_form) {
            for (const T w : row) CHECK((w >= T(0) && w <= T(1)));
        }
        if (i >= on) continue;
        CHECK(weights.states[i] == PointState::on_boundary);
        std::vector<double> expected(mesh.size());
        if (i < mesh.size()) {
            expected[i] = 1;
        } else {
            for (std::size_t k = 0; k < 3; ++k)
                expected[mesh.faces()[i - mesh.size()][k]] += shares[i - mesh.size()][k];
        }
        CHECK(difference(row, expected) <= 2e3 * double(epsilon<T>) * rounding);
    }
}

TEST_CASE("vertices and faces make the coordinates that their mesh makes", "[coordinates][harmonic][mesh]") {
    const auto data = random_mesh(3);
    const auto mesh = data.mesh<float>();
    const std::vector<cageform::Vec<float, 3>> vertices(mesh.vertices().begin(), mesh.vertices().end());
    const HarmonicCoordinates coordinates(vertices, data.faces, {.resolution = 20}, cageform::UniformGrid{});
    STATIC_REQUIRE(std::is_same_v<decltype(coordinates), const cageform::HarmonicCoordinates<float, 3>>);
    CHECK(coordinates.options().resolution == 20);
    CHECK(
        evaluate_all(coordinates, vertices).rows ==
        evaluate_all(HarmonicCoordinates(mesh, {.resolution = 20}, cageform::UniformGrid{}), vertices).rows);
}

TEMPLATE_TEST_CASE("the grid locates points as the cage does", "[coordinates][harmonic][mesh][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(6, 3)));
    CAPTURE(seed);
    const auto compare = [](const auto& cage, const auto& points) { // for any weights
        const auto weights = evaluate_all(
            HarmonicCoordinates(cage, {.resolution = effort(40u, 16u), .multigrid = {.tolerance = 1}},
                                cageform::UniformGrid{}),
            points);
        if (weights.status() != Status::ok) return;
        const auto tolerance = cageform::coincidence_tolerance(cageform::bounds_of(cage.vertices()));
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i);
            CHECK(weights.states[i] == locate(cage, points[i], tolerance));
        }
    };
    const auto data = random_mesh(std::uint64_t(seed));
    Points3<T> points;
    for (const auto& p : points_about(data, 2000, 3)) points.push_back(vec_cast<T>(p));
    compare(data.mesh<T>(), points);
    Random random{std::uint64_t(seed)};
    const auto rings = random_rings<T>(std::uint64_t(seed));
    Points2<T> flat;
    const auto bounds = cageform::bounds_of(rings.vertices());
    for (int n = 0; n < 2000; ++n)
        flat.push_back({T(random.uniform(bounds.lower[0], bounds.upper[0])),
                        T(random.uniform(bounds.lower[1], bounds.upper[1]))});
    compare(rings, flat);
    if (seed > 0) return;
    // Walls on lattice planes, exactly and up to rounding.
    const Points3<T> corners{{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {2, 2, 0}, {2, 4, 0}, {0, 4, 0}};
    Points3<T> prism = corners;
    for (auto p : corners) prism.push_back({p[0], p[1], 4});
    const Faces faces{{0, 3, 1},   {1, 3, 2},  {0, 5, 3},  {3, 5, 4},   {6, 7, 9}, {7, 8, 9}, {6, 9, 11},
                      {9, 10, 11}, {0, 1, 7},  {0, 7, 6},  {1, 2, 8},   {1, 8, 7}, {2, 3, 9}, {2, 9, 8},
                      {3, 4, 10},  {3, 10, 9}, {4, 5, 11}, {4, 11, 10}, {5, 0, 6}, {5, 6, 11}};
    points.clear();
    for (int n = 0; n < 6000; ++n) {
        Vec<T, 3> p{T(random.uniform(0, 4)), T(random.uniform(0, 4)), T(random.uniform(0, 4))};
        p[random.below(3)] =
            T(2 * double(random.below(3))) * (1 + T(double(random.below(41)) - 20) * epsilon<T>);
        points.push_back(p);
    }
    compare(cageform::TriangleMesh<T>(prism, faces), points);
}

TEST_CASE("weights in meshes converge to the oracle", "[coordinates][harmonic][mesh][oracle]") {
    // Linear boundary values have a crease at every edge, even between coplanar faces. Next to a crease or a
    // reflex edge the grid is only of order h; the nearest points are within half a cell. A tetrahedron's
    // weights are linear.
    struct Case {
        const char* name;
        double allowed;
    };
    for (const auto& c :
         {Case{"tetrahedron", 2e-6}, Case{"cube_triangulated", 1e-3},
          Case{"box_mixed_diagonals_triangulated", 2e-3}, Case{"l_prism_triangulated", 3e-3}}) {
        const auto json = read_json(std::string("harmonic3d_") + c.name);
        MeshData data;
        for (const auto& v : json["cage"]["vertices"]) data.vertices.push_back({v[0], v[1], v[2]});
        for (const auto& f : json["cage"]["faces"]) data.faces.push_back({f[0], f[1], f[2]});
        Points3<double> points;
        for (const auto& p : json["points"]) points.push_back({p[0], p[1], p[2]});
        CAPTURE(c.name);
        const auto weights =
            evaluate_all(HarmonicCoordinates(data.mesh<double>(), {.resolution = effort(64u, 20u)},
                                             cageform::UniformGrid{}),
                         points);
        REQUIRE(weights.status() == Status::ok);
        double error = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (std::size_t k = 0; k < data.vertices.size(); ++k)
                error =
                    std::max(error, std::fabs(weights.rows[i][k] - json["coordinates"][i][k].get<double>()));
        }
        CHECK(error <= effort(1, 4) * c.allowed);
        CHECK(error <= weights.evaluation.solver.worst_corner().error + 2e-6);
    }
}

TEST_CASE("the report expects the errors at the edges of a narrow gap in space",
          "[coordinates][harmonic][mesh][corners]") {
    // A U-shaped prism with a gap of two cells.
    const std::vector<std::array<double, 2>> outline{{0, 0},      {1, 0},      {1, 1},    {0.54, 1},
                                                     {0.54, 0.4}, {0.46, 0.4}, {0.46, 1}, {0, 1}};
    MeshData data;
    for (const double z : {0.0, 0.6}) {
        for (const auto& [x, y] : outline) data.vertices.push_back({x, y, z});
    }
    for (const auto& [a, b, c] :
         std::vector<std::array<int, 3>>{{0, 5, 6}, {0, 6, 7}, {0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}}) {
        data.faces.push_back({a, c, b});
        data.faces.push_back({a + 8, b + 8, c + 8});
    }
    for (int i = 0; i < 8; ++i) {
        const int j = (i + 1) % 8;
        data.faces.push_back({i, j, j + 8});
        data.faces.push_back({i, j + 8, i + 8});
    }
    const auto mesh = data.mesh<double>();
    Points3<double> points;
    Random random(1);
    while (points.size() < 300) { // around the gap's inner end and its opening
        const Vec<double, 3> p{random.uniform(0.4, 0.6), random.uniform(0.3, 1), random.uniform(0, 0.6)};
        if (locate(mesh, p, 1e-9) == PointState::inside) points.push_back(p);
    }
    const auto fine =
        evaluate_all(HarmonicCoordinates(mesh, {.resolution = 75}, cageform::UniformGrid{}), points);
    const auto weights =
        evaluate_all(HarmonicCoordinates(mesh, {.resolution = 24}, cageform::UniformGrid{}), points);
    REQUIRE(weights.status() == Status::ok);
    double error = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        error = cageform_tests::larger(error, difference(weights.rows[i], fine.rows[i]));
    const auto worst = weights.evaluation.solver.worst_corner();
    CHECK(error > cageform::CornerError::notable);
    CHECK(error <= worst.error);
    CHECK(worst.error <= 20 * error);
    CHECK(worst.handles[0] != worst.handles[1]);
}

TEST_CASE("a 3D grid above the memory limit is refused before the solve",
          "[coordinates][harmonic][mesh][memory]") {
    const auto mesh = random_mesh(3).mesh<double>();
    const Points3<double> points{mesh[0]};
    const auto most =
        evaluate_all(HarmonicCoordinates(mesh, {.resolution = 1024}, cageform::UniformGrid{}), points);
    CHECK(most.status() == Status::out_of_memory);
    CHECK(most.evaluation.solver.bytes > HarmonicOptions{}.memory_limit);
    const HarmonicOptions options{.resolution = most.evaluation.solver.sufficient_resolution};
    CHECK(options.resolution > 64);
    CHECK(options.resolution < 1024);
}

TEST_CASE("every lattice line crosses a closed mesh an even number of times", "[grid][mesh][property]") {
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    // Vertices on lattice points, half-way between, and anywhere: lines through vertices, edges and faces are
    // frequent.
    auto data = random_mesh(std::uint64_t(seed));
    const auto bounds = cageform::bounds_of(std::span<const Vec<double, 3>>(data.vertices));
    Random random{std::uint64_t(seed)};
    const double cells = 6 + double(random.below(20));
    cageform::Lattice<double, 3> lattice;
    lattice.cells.fill(std::size_t(cells) + 3);
    for (auto& v : data.vertices) {
        for (std::size_t k = 0; k < 3; ++k) {
            v[k] = 1 + cells * (v[k] - bounds.lower[k]) / (bounds.upper[k] - bounds.lower[k]);
            if (seed % 3 != 0) v[k] = std::round((seed % 3) * v[k]) / (seed % 3);
        }
    }
    const auto crossings = SimplexBoundary<3>(data.mesh<double>(), lattice).crossings();
    for (const auto& along : crossings) {
        REQUIRE(!along.empty());
        std::size_t odd = 0;
        for (std::size_t begin = 0, end = 0; begin < along.size(); begin = end) {
            while (end < along.size() && along[end].line == along[begin].line) ++end;
            odd += (end - begin) % 2;
        }
        CHECK(odd == 0);
    }
}

TEST_CASE("an unused vertex has no weight", "[coordinates][harmonic][mesh]") {
    auto data = sphere(1);
    data.vertices.push_back({0.1, 0.2, 0.3});
    const auto weights = evaluate_all(
        HarmonicCoordinates(data.mesh<double>(), {.resolution = 16}, cageform::UniformGrid{}), data.vertices);
    REQUIRE(weights.status() == Status::ok);
    for (const auto& row : weights.rows) CHECK(row.back() == 0);
}

} // namespace harmonic_mesh_tests
