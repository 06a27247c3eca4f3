// Packed functions replace a solve with bitwise equal weights. All other files are refused.
#include "catch.hpp"
#include "support/aligned.hpp"
#include "support/effort.hpp"
#include "support/meshes.hpp"
#include "support/polyhedra.hpp"
#include "support/weights.hpp"

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/coordinates/harmonic/solution_blob.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>

#include <limits>

namespace harmonic_solution_tests {

using namespace cageform_tests;
using cageform::HarmonicCoordinates;
using cageform::HarmonicOptions;
using cageform::Polygon;
using cageform::PolyhedralMesh;
using cageform::TriangleMesh;
using cageform::detail::SolutionGroup;
using cageform::detail::SolutionHeader;

namespace {

template <class C>
using Adaptive = HarmonicCoordinates<typename C::scalar, C::dimension, C>;

constexpr HarmonicOptions coarse{.accuracy = 0.02};

template <class Coordinates>
std::vector<std::byte> saved(Coordinates& coordinates) {
    auto [bytes, report] = coordinates.save_solution();
    REQUIRE(report.status == Status::ok);
    REQUIRE(bytes.size() % 64 == 0);
    return std::move(bytes);
}

SolutionHeader header_of(std::span<const std::byte> bytes) {
    SolutionHeader header;
    std::memcpy(&header, bytes.data(), sizeof(header));
    return header;
}

/// Checks that coordinates that loaded a solution have equal weights, gradients and report.
template <class C, class Points>
void check_round_trip(const C& cage, const Points& points) {
    constexpr HarmonicOptions options{.accuracy = effort(0.02, 0.1)};
    Adaptive<C> solved(cage, options);
    REQUIRE(solved.solve().status == Status::ok);
    const auto bytes = saved(solved);
    Adaptive<C> again(cage, options);
    CHECK(saved(again) == bytes); // after another solve
    Aligned memory(bytes);
    Adaptive<C> reader(cage, options);
    const auto loaded = reader.load_solution(memory.bytes());
    REQUIRE(loaded.status == Status::ok);
    CHECK(saved(reader) == bytes); // without a solve
    const auto expected = evaluate_all(solved, points), found = evaluate_all(reader, points);
    REQUIRE(found.status() == Status::ok);
    CHECK(found.states == expected.states);
    CHECK(found.rows == expected.rows);
    const auto& a = expected.evaluation.solver;
    for (const auto& b : {loaded.solver, found.evaluation.solver}) {
        CHECK(b.cells == a.cells);
        CHECK(b.solves == a.solves);
        CHECK(b.bytes == a.bytes);
        CHECK(b.multigrid.cycles == a.multigrid.cycles);
        CHECK(b.multigrid.error_estimate == a.multigrid.error_estimate);
        CHECK(b.multigrid.convergence_factor == a.multigrid.convergence_factor);
        CHECK(b.tree.grid_errors == a.tree.grid_errors);
        CHECK(b.tree.finest_size == a.tree.finest_size);
        CHECK(b.tree.finest_position == a.tree.finest_position);
        CHECK(b.tree.finest_reason == a.tree.finest_reason);
    }
    const Adaptive<C> copy = reader; // shares the functions
    CHECK(evaluate_all(copy, points).rows == expected.rows);
}

const Points2<double> l_shape{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};

} // namespace

TEST_CASE("functions loaded from a file give bitwise the weights of the solve",
          "[coordinates][harmonic][solution]") {
    for (std::uint64_t seed = 1; seed <= effort(2U, 1U); ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const Polygon<double> star(random_star<double>(seed));
        Points2<double> inside;
        for (int n = 0; n < 50; ++n) inside.push_back(random_inside(star, random));
        inside.push_back({100, 100});
        if constexpr (effort(true, false)) check_round_trip(star, inside);
        const Polygon<float> single(random_star<float>(seed));
        check_round_trip(single, inside);
        const auto mesh = random_mesh(seed + 2); // the first two are large
        const auto about = points_about(mesh, 50, seed);
        if (effort(true, false) && check(mesh.mesh<double>()).status == Status::ok)
            check_round_trip(mesh.mesh<double>(), about);
        if (check(mesh.mesh<float>()).status == Status::ok) check_round_trip(mesh.mesh<float>(), about);
    }
    const auto prism = l_prism().cage<float>(); // planar faces with harmonic functions
    check_round_trip(prism, Points3<float>{{0.5F, 0.5F, 0.5F}, {1.5F, 0.25F, 0.9F}, {0.1F, 1.9F, 0.2F}});
}

TEST_CASE("AnyCoordinates save and load solutions if the type has solutions",
          "[coordinates][harmonic][solution][status]") {
    const Points2<double> points{{0.5, 0.5}, {1.5, 0.5}};
    const cageform::AnyCoordinates<double, 2> any = Adaptive<Polygon<double>>(l_shape, coarse);
    const auto [bytes, report] = any.save_solution();
    REQUIRE(report.status == Status::ok);
    Aligned memory(bytes);
    const cageform::AnyCoordinates<double, 2> reader = Adaptive<Polygon<double>>(l_shape, coarse);
    REQUIRE(reader.load_solution(memory.bytes()).status == Status::ok);
    const auto expected = any.bind(points), found = reader.bind(points);
    REQUIRE(expected);
    REQUIRE(found);
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t h = 0; h < l_shape.size(); ++h)
            CHECK(found.value.view().weights(i, h) == expected.value.view().weights(i, h));
    }

    const cageform::AnyCoordinates<double, 2> none,
        closed = cageform::MeanValueCoordinates<double, 2>(l_shape),
        uniform =
            cageform::HarmonicCoordinates<double, 2>(l_shape, {.resolution = 16}, cageform::UniformGrid{});
    CHECK(none.save_solution().status() == Status::coordinates_empty);
    CHECK(none.load_solution(memory.bytes()).status == Status::coordinates_empty);
    for (const auto& other : {closed, uniform}) {
        CHECK(other.save_solution().status() == Status::solver_not_supported);
        CHECK(other.load_solution(memory.bytes()).status == Status::solver_not_supported);
        CHECK(other.bind(points).status() == Status::ok);
    }
    Adaptive<Polygon<double>> cancelled(l_shape, coarse);
    CHECK(cancelled.save_solution({cageform::SerialFor{}, [](double) { return false; }}).status() ==
          Status::cancelled);
}

TEST_CASE("a solution of another cage, grid or accuracy is refused with its own status",
          "[coordinates][harmonic][solution][status]") {
    Adaptive<Polygon<double>> solved(l_shape, coarse);
    Aligned memory(saved(solved));
    const auto status_for = [&](auto coordinates) {
        const Status status = coordinates.load_solution(memory.bytes()).status;
        if (coordinates.cage_report().status == Status::ok) {
            const Points2<double> points{{0.5, 0.5}}; // solves if no solution is loaded
            if constexpr (decltype(coordinates)::dimension == 2)
                CHECK(evaluate_all(coordinates, points).status() == Status::ok);
        }
        return status;
    };
    CHECK(status_for(solved) == Status::ok);
    auto moved = l_shape;
    moved[3] = {1, 1.0009765625};
    CHECK(status_for(Adaptive<Polygon<double>>(moved, coarse)) == Status::blob_of_another_cage);
    auto turned = l_shape;
    std::rotate(turned.begin(), turned.begin() + 1, turned.end());
    CHECK(status_for(Adaptive<Polygon<double>>(turned, coarse)) == Status::blob_of_another_cage);
    for (const double accuracy : {0.01, 0.0199, 0.05})
        CHECK(status_for(Adaptive<Polygon<double>>(l_shape, {.accuracy = accuracy})) ==
              Status::blob_of_another_grid);
    const auto box = divided_box({1, 1, 1}, 1).mesh<double>();
    CHECK(status_for(Adaptive<TriangleMesh<double>>(box, coarse)) == Status::blob_kind_differs);

    // The triangles of two cages are equal, but the functions on their faces differ.
    const auto prism = l_prism();
    Adaptive<PolyhedralMesh<double>> of_polygons(prism.cage<double>(), coarse);
    Aligned planar(saved(of_polygons));
    const auto triangles = prism.cage<double>().triangles();
    Adaptive<TriangleMesh<double>> of_triangles(TriangleMesh<double>(triangles.vertices(), triangles.faces()),
                                                coarse);
    CHECK(of_triangles.load_solution(planar.bytes()).status == Status::blob_of_another_grid);
}

TEST_CASE("a truncated solution, or one with a flipped bit, is refused",
          "[coordinates][harmonic][solution][status]") {
    Adaptive<Polygon<double>> coordinates(Points2<double>{{0, 0}, {1, 0}, {0, 1}}, {.accuracy = 0.1});
    const auto bytes = saved(coordinates);
    for (std::size_t size = 0; size < bytes.size();
         size += size < 512 ? 1 : bytes.size() / effort(200U, 20U)) {
        Aligned memory(std::span<const std::byte>(bytes).first(size));
        CAPTURE(size);
        const Status expected = size < 16 ? Status::not_a_solution : Status::blob_truncated;
        CHECK(coordinates.load_solution(memory.bytes()).status == expected);
    }
    Aligned memory(bytes);
    CHECK(coordinates.load_solution(memory.bytes().subspan(8)).status == Status::not_a_solution);
    CHECK(coordinates.load_solution({}).status == Status::not_a_solution);
    std::size_t accepted = 0;
    const std::size_t step = bytes.size() / effort(400U, 40U) | 1U;
    for (std::size_t byte = 0; byte < bytes.size(); byte += byte < effort(256U, 64U) ? 1 : step) {
        const int bit = int(byte % 8);
        memory.data()[byte] ^= std::byte(1 << bit);
        if (coordinates.load_solution(memory.bytes()).status == Status::ok) ++accepted;
        memory.data()[byte] ^= std::byte(1 << bit);
    }
    CHECK(accepted == 0);
    const auto changed = [&]<class X>(std::size_t offset, X x) {
        Aligned copy(bytes);
        copy.set(offset, x);
        return coordinates.load_solution(copy.bytes()).status;
    };
    CHECK(changed(offsetof(SolutionHeader, version), std::uint32_t(2)) == Status::blob_version_differs);
    CHECK(changed(offsetof(SolutionHeader, endian), std::uint32_t(0x04030201)) ==
          Status::blob_version_differs);
    CHECK(changed(0, cageform::detail::byte_swapped(SolutionHeader::magic_number)) ==
          Status::blob_version_differs);
    CHECK(changed(0, std::uint64_t(7)) == Status::not_a_solution);
    CHECK(coordinates.load_solution(memory.bytes()).status == Status::ok);
}

TEST_CASE("every inconsistency in a solution is found, with a valid checksum",
          "[coordinates][harmonic][solution][status]") {
    Adaptive<Polygon<double>> coordinates(l_shape, coarse);
    const auto bytes = saved(coordinates);
    const SolutionHeader header = header_of(bytes);
    const auto refused = [&]<class X>(std::size_t offset, X x) {
        Aligned memory(bytes);
        memory.set(offset, x);
        memory.seal();
        CAPTURE(offset, double(x));
        CHECK(coordinates.load_solution(memory.bytes()).status == Status::blob_malformed);
    };
    const std::uint64_t far = header.bytes, huge = ~std::uint64_t{0};
    for (const std::size_t field :
         {offsetof(SolutionHeader, groups), offsetof(SolutionHeader, grid_errors)}) {
        for (const std::uint64_t offset :
             {std::uint64_t(0), std::uint64_t(64), std::uint64_t(257), far, far + 64, huge - 63, huge})
            refused(field, offset);
    }
    for (const std::uint64_t count : {far, huge, huge / 4 + 1})
        refused(offsetof(SolutionHeader, grid_error_count), count);
    refused(offsetof(SolutionHeader, finest_reason), std::uint64_t(6));
    const auto in_group = [&](std::size_t field) { return std::size_t(header.groups) + field; };
    for (const std::size_t field : {offsetof(SolutionGroup, words), offsetof(SolutionGroup, rows)}) {
        for (const std::uint64_t offset : {std::uint64_t(0), std::uint64_t(300), far + 64, huge - 63})
            refused(in_group(field), offset);
    }
    SolutionGroup group;
    std::memcpy(&group, bytes.data() + header.groups, sizeof(group));
    REQUIRE(group.row_count > 0);
    for (const std::uint64_t count : {std::uint64_t(0), group.row_count - 1, group.row_count + 1, far, huge})
        refused(in_group(offsetof(SolutionGroup, row_count)), count);
    std::uint64_t nodes = 0;
    std::memcpy(&nodes, bytes.data() + group.words, sizeof(nodes));
    refused(std::size_t(group.words), nodes ^ 1U);
    refused(std::size_t(group.words) + 8, std::uint32_t(1)); // rows before the first word
    const std::size_t words = std::size_t(header.nodes + 63) / 64,
                      last = std::size_t(group.words) + 16 * (words - 1);
    std::memcpy(&nodes, bytes.data() + last, sizeof(nodes));
    REQUIRE(header.nodes % 64 != 0);
    refused(last, nodes | std::uint64_t{1} << 63);
    // Weights are never NaN.
    for (const float number :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        refused(std::size_t(group.rows), number);
        refused(std::size_t(group.rows + group.row_count * 64 - 4), number);
    }
    Aligned other(bytes); // a changed finite value is harmless
    other.set(std::size_t(group.rows), 1e30F);
    other.seal();
    REQUIRE(coordinates.load_solution(other.bytes()).status == Status::ok);
    for (const auto& row : evaluate_all(coordinates, Points2<double>{{0.5, 0.5}, {0.01, 0.01}}).rows) {
        for (const double weight : row) CHECK((weight >= 0 && weight <= 1));
    }
}

} // namespace harmonic_solution_tests
