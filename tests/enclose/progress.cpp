// Progress of make_cage.
#include "../support/progress.hpp"
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/meshes.hpp"

#include <cageform/enclose/make_cage.hpp>
#include <cageform/enclose/make_cage_3d.hpp>

namespace enclose_progress_tests {

using namespace cageform_tests;

TEST_CASE("progress never falls and ends with 1: made cages", "[enclose][progress]") {
    const std::vector<cageform::DrawnSegment<double>> drawn{{{0, 0}, {1, 0}, 0.1}, {{1, 0}, {1, 1}, 0.1}};
    check_progress("make_cage, plane", [&](const Running& r) { return cageform::make_cage(drawn, {}, r); });
    const auto ball = sphere(1);
    check_progress("make_cage, space", [&](const Running& r) {
        return cageform::make_cage(ball.vertices, ball.faces, {.vertices = 24, .margin = effort(0.0, 0.1)},
                                   r);
    });
}

} // namespace enclose_progress_tests
