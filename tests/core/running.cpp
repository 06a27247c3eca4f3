// Tests the progress of all long functions, except those that bind (binding/progress.cpp).
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/keys.hpp"
#include "../support/meshes.hpp"
#include "../support/progress.hpp"

#include <cageform/animate/compile.hpp>
#include <cageform/animate/fit/knots.hpp>
#include <cageform/enclose/make_cage.hpp>
#include <cageform/enclose/make_cage_3d.hpp>
#include <cageform/fields/dirichlet.hpp>
#include <cageform/fields/graph.hpp>
#include <cageform/fields/skin.hpp>
#include <cageform/fields/strokes.hpp>
#include <cageform/fields/surface.hpp>

namespace running_tests {

using namespace cageform_tests;

TEST_CASE("progress never falls and ends with 1: grids and graphs", "[core][running][progress]") {
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

TEST_CASE("progress never falls and ends with 1: curves", "[core][running][progress]") {
    const cageform::BezierCurve curve{{{{0, 0}, {0.1, 2}, {0.9, -1}, {1, 1}}}};
    using enum cageform::FitCondition;
    for (const auto conditions : {cageform::FitOptions{}.conditions, end_value | knot_c0}) {
        cageform::FitOptions options;
        options.conditions = conditions;
        check_progress("fit", [&](const Running& r) { return fit(curve, 1e-2, options, r); });
        cageform::KnotOptions knots;
        knots.fit = options;
        check_progress("optimal_knots", [&](const Running& r) { return optimal_knots(curve, 4, knots, r); });
        const std::vector<double> candidates{0, 0.2, 0.4, 0.6, 0.8, 1};
        check_progress("search_knots",
                       [&](const Running& r) { return search_knots(curve, candidates, 3, knots, r); });
        cageform::TrackOptions track;
        track.fit = options;
        for (const std::size_t count : {1u, 5u}) {
            std::vector<cageform::Key> keys;
            for (std::size_t i = 0; i < count; ++i) keys.push_back(key(double(i), double(i * i % 3)));
            check_progress("compile, a track", [&](const Running& r) {
                return cageform::compile<float>(std::span<const cageform::Key>(keys), track, r);
            });
            const std::vector<std::vector<cageform::Key>> curves(3, keys);
            check_progress("compile, a clip",
                           [&](const Running& r) { return cageform::compile<float, 3>(curves, track, r); });
        }
    }
    check_progress("compile, a clip of no curves", [&](const Running& r) {
        return cageform::compile<float, 3>(std::span<const std::vector<cageform::Key>>{}, {}, r);
    });
}

TEST_CASE("progress never falls and ends with 1: made cages", "[core][running][progress]") {
    const std::vector<cageform::DrawnSegment<double>> drawn{{{0, 0}, {1, 0}, 0.1}, {{1, 0}, {1, 1}, 0.1}};
    check_progress("make_cage, plane", [&](const Running& r) { return cageform::make_cage(drawn, {}, r); });
    const auto ball = sphere(1);
    check_progress("make_cage, space", [&](const Running& r) {
        return cageform::make_cage(ball.vertices, ball.faces, {.vertices = 24, .margin = effort(0.0, 0.1)},
                                   r);
    });
}

} // namespace running_tests
