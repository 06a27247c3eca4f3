// Laws of all types in coordinates/types.hpp; new types are tested without changes.
#include <cageform/binding/make_coordinates.hpp>

#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/clone/clone.hpp>

#include <set>

namespace make_coordinates_tests {

using namespace cageform;
using cageform_tests::Random;

namespace {

constexpr std::uint64_t seed = 63;

/// Binds random points inside the cage by all types; counts the supported cages per type.
template <class Cage>
void check_cage(const Cage& cage, double low, double high, std::vector<int>& taken) {
    using T = typename Cage::scalar;
    constexpr std::size_t D = Cage::dimension;
    Random random(seed);
    std::vector<Vec<T, D>> points(30), out(30);
    for (auto& p : points) {
        for (std::size_t k = 0; k < D; ++k) p[k] = T(random.uniform(low, high));
    }
    CoordinateOptions<T> options;
    options.harmonic.accuracy = 1e-2;
    for (std::size_t n = 0; n < coordinate_facts.size(); ++n) {
        const CoordinateFacts& facts = coordinate_facts[n];
        CAPTURE(seed, facts.name, D, sizeof(T));
        const AnyCoordinates<T, D> made = make_coordinates(CoordinateType(n), cage, options);
        const Status status = made.cage_report().status;
        if ((facts.cages & detail::kinds_of<Cage>) == 0) {
            CHECK(status == Status::coordinates_empty);
            continue;
        }
        if (status != Status::ok) {
            const std::set known{Status::not_a_simplex, Status::interior_cells_not_supported};
            CHECK(known.contains(status));
            continue;
        }
        ++taken[n];
        CHECK(made.has_extension() == facts.has_extension);
        CHECK((made.handles().vector_count() > 0) == facts.with_normals);
        const auto [binding, report] = bind(made, points);
        REQUIRE(report.status == Status::ok);
        REQUIRE(report.outside.empty());
        const HandleView<T, D> handles = made.handles();
        std::vector<Vec<T, D>> pose(handles.rest, handles.rest + handles.count);
        REQUIRE(clone(binding, pose, out) == Status::ok);
        CHECK(out == points);
        for (std::size_t i = 0; i < pose.size(); ++i) {
            for (std::size_t k = 0; handles.is_point(i) && k < D; ++k) pose[i][k] += T(0.25);
        }
        REQUIRE(clone(binding, pose, out) == Status::ok);
        double error = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (std::size_t k = 0; k < D; ++k)
                error = std::max(error, std::fabs(double(out[i][k] - points[i][k]) - 0.25));
        }
        CHECK(error <= 100 * double(epsilon<T>));
    }
}

template <class T>
void check_cages() {
    using Faces = std::vector<std::vector<std::uint32_t>>;
    std::vector<int> taken(coordinate_facts.size());
    const std::vector<Vec<T, 2>> square{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    const std::vector<Vec<T, 2>> triangle{{-2, -1}, {2, -1}, {0, 3}};
    check_cage(Polygon<T>(square), -0.9, 0.9, taken);
    check_cage(Polygon<T>(triangle), -0.5, 0.5, taken);
    check_cage(PointSet<T, 2>(square), -0.9, 0.9, taken);
    check_cage(CurvedPolygon<T>(Polygon<T>(square)), -0.9, 0.9, taken);
    auto with_point = square;
    with_point.push_back({T(0.1), T(0.2)});
    InteriorCells<2> cells;
    cells.bones.push_back({4, 4, 0.1});
    check_cage(CellComplex<T, 2>(Polygon<T>(square), with_point, cells), -0.9, 0.9, taken);
    Transform<T, 2> box;
    box.translation = {-1, -1};
    box.columns = {{{2, 0}, {0, 2}}};
    check_cage(LatticeCoordinates<T, 2>({{{4, 3}, {3, 2}}}, box), -0.9, 0.9, taken);

    std::vector<Vec<T, 3>> cube;
    for (int n = 0; n < 8; ++n) cube.push_back({T(n & 1 ? 1 : -1), T(n & 2 ? 1 : -1), T(n & 4 ? 1 : -1)});
    const Faces quads{{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {1, 3, 7, 5}, {3, 2, 6, 7}, {2, 0, 4, 6}};
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (const auto& q : quads) triangles.insert(triangles.end(), {{q[0], q[1], q[2]}, {q[0], q[2], q[3]}});
    check_cage(TriangleMesh<T>(cube, triangles), -0.9, 0.9, taken);
    check_cage(PolyhedralMesh<T>(cube, quads), -0.9, 0.9, taken);
    check_cage(PointSet<T, 3>(cube), -0.9, 0.9, taken);
    const std::vector<Vec<T, 3>> corners{{-1, -1, -1}, {3, -1, -1}, {-1, 3, -1}, {-1, -1, 3}};
    const std::vector<std::array<std::uint32_t, 3>> sides{{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
    check_cage(TriangleMesh<T>(corners, sides), -0.9, 0.3, taken);
    for (std::size_t n = 0; n < taken.size(); ++n) {
        CAPTURE(coordinate_facts[n].name);
        CHECK(taken[n] > 0);
    }
}

} // namespace

TEST_CASE("every coordinate type supports the listed cages and reproduces rest and translations", "[bind]") {
    check_cages<float>();
    check_cages<double>();
}

} // namespace make_coordinates_tests
