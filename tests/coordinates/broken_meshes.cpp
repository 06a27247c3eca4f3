// Meshes with random faults: check names the fault, or bind keeps the laws.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/meshes.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>

namespace broken_meshes_tests {

using namespace cageform_tests;
using cageform::Status;
using cageform::TriangleMesh;

namespace {

/// Adds one to three faults, or valid changes that look like faults.
void damage(MeshData& data, Random& random) {
    for (std::size_t n = 0; n <= random.below(3) && !data.faces.empty(); ++n) {
        const std::size_t f = random.below(data.faces.size()), g = random.below(data.faces.size());
        const std::size_t v = random.below(data.vertices.size()), w = random.below(data.vertices.size());
        constexpr double inf = std::numeric_limits<double>::infinity();
        switch (random.below(10)) {
        case 0:
        case 1:
        case 2: data.faces.erase(data.faces.begin() + std::ptrdiff_t(f)); break;
        case 3: std::swap(data.faces[f][0], data.faces[f][1]); break;
        case 4: std::swap(data.faces[f][random.below(3)], data.faces[g][random.below(3)]); break;
        case 5: data.faces.push_back(data.faces[f]); break;
        case 6: data.faces[f][random.below(3)] = int(random.below(data.vertices.size() + 2)) - 1; break;
        case 7: data.vertices[v][random.below(3)] = random.below(2) == 0 ? inf : inf - inf; break;
        case 8: data.vertices[v] = data.vertices[w]; break;
        default: std::swap(data.vertices[v], data.vertices[w]); break;
        }
    }
}

template <class C>
void check_bind(const C& coordinates, const Points3<double>& points, bool exact) {
    const auto [binding, report] = cageform::bind(coordinates, points);
    if (report.status != Status::ok) {
        const bool named = report.status == report.cage.status || report.status == Status::grid_too_coarse;
        CHECK(named);
        if (report.cage.status != Status::ok) CHECK_FALSE(report.cage.faults.empty());
        return;
    }
    const auto bounds = cageform::bounds_of(coordinates.handles());
    const double size = double(bounds.diagonal()) + double(bounds.magnitude());
    CHECK(report.partition_error.value <= 1e-11);
    CHECK(report.reproduction_error.value <= 1e-11 * size);
    // Before linear precision is restored, weights of closed forms are exact, and those of solvers are within
    // the tolerance.
    CHECK(report.residual_restored.value <=
          (exact ? 1e-7 : 1e-5 * double(coordinates.handles().size())) * size);
    if (!exact) CHECK(report.least_weight.value >= -1e-4);
}

} // namespace

TEST_CASE("10,000 broken meshes give a status or a binding that keeps the laws",
          "[coordinates][mesh][status][property]") {
    Random random(2026);
    const int count = effort(10000, 1000);
    int bound = 0, closed = 0;
    for (int n = 0; n < count; ++n) {
        CAPTURE(n);
        auto data = random_mesh(random.below(40));
        const auto points = points_about(data, 9, std::uint64_t(n));
        damage(data, random);
        const auto mesh = data.mesh<double>();
        const auto report = check(mesh);
        CHECK((report.status == Status::ok || !report.faults.empty()));
        if (report.status == Status::ok) {
            ++bound;
            closed += report.faults.empty() ? 0 : 1;
        }
        check_bind(cageform::MeanValueCoordinates<double, 3>(mesh), points, true);
        if (n % 20 == 0)
            check_bind(
                cageform::HarmonicCoordinates<double, 3>(mesh, {.resolution = 12}, cageform::UniformGrid{}),
                points, false);
    }
    CHECK(bound >= count / 10);
    CHECK(closed >= count / 20); // bound with a warning
}

} // namespace broken_meshes_tests
