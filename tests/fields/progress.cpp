// The progress reported by the functions of this room.
#include "../support/progress.hpp"
#include "../catch.hpp"
#include "../support/meshes.hpp"

#include <cageform/fields/dirichlet.hpp>
#include <cageform/fields/graph.hpp>
#include <cageform/fields/skin.hpp>
#include <cageform/fields/strokes.hpp>
#include <cageform/fields/surface.hpp>

namespace fields_progress_tests {

using namespace cageform_tests;

TEST_CASE("progress is monotone and ends with 1: grids and graphs", "[fields][progress]") {
    const std::vector<cageform::GraphLink> links{{0, 1, 1.0}, {1, 2, 1.0}};
    const std::vector<std::uint8_t> ends{1, 0, 1}, all{1, 1, 1};
    for (const auto& given : {ends, all}) {
        check_progress("solve_graph", [&](const Running& r) {
            std::vector<double> values{1, 0, 2};
            return cageform::solve_graph(cageform::Graph{3, links}, given, std::span(values), {}, r);
        });
    }
    const cageform::CellBox<2> cells{{8, 8}};
    std::vector<std::uint8_t> given(64, 0);
    for (std::size_t i = 0; i < 64; ++i) given[i] = i % 8 == 0 || i % 8 == 7 || i < 8 || i >= 56;
    check_progress("solve_dirichlet", [&](const Running& r) {
        std::vector<double> values(64, 0);
        values[0] = 1;
        return cageform::solve_dirichlet(cells, given, values, {}, r);
    });
    check_progress("strokes", [](const Running& r) {
        cageform::Diffusion<double> field({{-1, -1}, {1, 1}}, 24, 1);
        CHECK(field.add({{{0.1, 0.2}, {0.5, 0.5}}, {3.0, 1.0}, {}}) == Status::ok);
        return field.solve({}, r);
    });
    const auto ring = torus(24, 12);
    const std::vector<cageform::BoneSegment> bones{{{1, 0, 0}, {0.5, 0.8, 0}}, {{-1, 0, 0}, {-0.5, -0.8, 0}}};
    check_progress("harmonic_skin", [&](const Running& r) {
        return cageform::harmonic_skin(ring.vertices, ring.faces, bones, {}, r);
    });
    check_progress("bone_heat", [&](const Running& r) {
        return cageform::bone_heat(ring.vertices, ring.faces, bones, {}, r);
    });
    const auto weights = cageform::cotangent_weights(ring.vertices, ring.faces).value;
    check_progress("solve_surface", [&](const Running& r) {
        std::vector<std::uint8_t> marks(ring.vertices.size(), 0);
        std::vector<double> values(ring.vertices.size(), 0);
        marks[0] = marks[1] = 1;
        values[0] = 1;
        return cageform::solve_surface(weights, std::span<const std::uint8_t>(marks), std::span(values), r);
    });
}

} // namespace fields_progress_tests
