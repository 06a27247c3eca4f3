// The progress of binding functions.
#include "../support/progress.hpp"
#include "../catch.hpp"
#include "../support/bindings.hpp"
#include "../support/effort.hpp"
#include "../support/figures.hpp"

#include <cageform/binding/bind_bones.hpp>
#include <cageform/binding/compose.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/binding/rebind_cage.hpp>
#include <cageform/binding/skin_weights.hpp>
#include <cageform/binding/smooth_skin_weights.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/blended.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/sibson.hpp>
#include <cageform/coordinates/three_point.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>

namespace binding_progress_tests {

using namespace cageform_tests;

namespace {

template <class C, class Points>
void check_bind(const char* what, const C& coordinates, const Points& points) {
    CAPTURE(what);
    check_progress("bind", [&](const Running& r) { return cageform::bind(coordinates, points, {}, r); });
    check_progress("bind no points",
                   [&](const Running& r) { return cageform::bind(coordinates, Points{}, {}, r); });
}

/// All functions with points in a cage.
template <class C, class Points>
void check_binds(const char* what, const C& coordinates, const Points& points) {
    check_bind(what, coordinates, points);
    CAPTURE(what);
    check_progress("pack, streamed",
                   [&](const Running& r) { return cageform::pack(coordinates, points, {}, r); });
    if constexpr (cageform::GradientCoordinates<C>) {
        check_progress("bind_jacobians",
                       [&](const Running& r) { return bind_jacobians(coordinates, points, {}, r); });
        check_progress("bind, a figure", [&](const Running& r) {
            return cageform::bind(coordinates, cageform::FigurePoints{points, points}, {}, r);
        });
    }
    if constexpr (requires(C solved) { solved.solve(); }) {
        check_progress("solve", [&](const Running& r) {
            C fresh = coordinates;
            return fresh.solve(r);
        });
    }
}

} // namespace

TEST_CASE("progress never decreases and ends with 1: coordinates and bindings", "[core][running][progress]") {
    Random random(1);
    const auto star = random_star<double>(3);
    const cageform::Polygon<double> polygon(star);
    std::vector<Vec<double, 2>> points;
    for (int i = 0; i < effort(700, 150); ++i) points.push_back(random_inside(polygon, random, 0));
    const cageform::MeanValueCoordinates<double, 2> plane(polygon);
    check_binds("mean value, plane", plane, points);
    check_bind("Green", cageform::GreenCoordinates<double, 2>(polygon), points);
    check_bind("Sibson", cageform::SibsonCoordinates<double, 2>(star), points);
    check_bind("blended", cageform::BlendedCoordinates(std::vector{plane, plane}), points);
    const std::vector<Vec<double, 2>> triangle{{-20, -20}, {30, -20}, {-5, 40}};
    const cageform::BarycentricCoordinates<double, 2> simple(triangle);
    check_bind("barycentric", simple, points);
    check_bind("Wachspress", cageform::WachspressCoordinates<double>(cageform::Polygon<double>(triangle)),
               points);
    using Harmonic = cageform::HarmonicCoordinates<double, 2>;
    check_binds(
        "harmonic, uniform",
        cageform::HarmonicCoordinates<double, 2>(polygon, {.resolution = 32}, cageform::UniformGrid{}),
        points);
    check_bind("harmonic, adaptive", Harmonic(polygon, {.accuracy = 0.05}), points);

    const auto fine = cageform::bind(plane, points).value, coarse = cageform::bind(simple, star).value;
    check_progress("pack", [&](const Running& r) { return pack(fine, {.largest = 4}, r); });
    check_progress("pack to a distance", [&](const Running& r) { return pack(fine, {.tolerance = 0.1}, r); });
    check_progress("compose", [&](const Running& r) { return compose(fine, coarse, r); });
    check_progress("skin_weights", [&](const Running& r) { return skin_weights(fine, {}, r); });
    const std::vector<std::array<int, 3>> triangles{{0, 1, 2}, {1, 2, 3}};
    check_progress("smooth_skin_weights",
                   [&](const Running& r) { return smooth_skin_weights(fine, triangles, {}, r); });
    const std::vector<double> shares(2 * points.size(), 0.5);
    check_progress("skin_weights of shares", [&](const Running& r) {
        return cageform::skin_weights(std::span<const double>(shares), 2, {}, r);
    });
    const cageform::Transform<double, 2> bone{{{{1, 0}, {0, 1}}}, {0, 0}};
    const std::vector<cageform::Transform<double, 2>> bones{bone, bone};
    check_progress("bind_bones", [&](const Running& r) {
        return bind_bones(points, std::span<const cageform::Transform<double, 2>>(bones),
                          std::span<const double>(shares), {}, r);
    });
}

TEST_CASE("progress never decreases and ends with 1: 3D", "[core][running][progress]") {
    const auto data = sphere(1);
    const auto mesh = data.mesh<double>();
    const auto points = points_in(mesh, 100, 4);
    const cageform::MeanValueCoordinates<double, 3> closed_form(mesh);
    check_bind("mean value, space", closed_form, points);
    check_binds("harmonic, uniform",
                cageform::HarmonicCoordinates<double, 3>(mesh, {.resolution = 16}, cageform::UniformGrid{}),
                points);
    const auto figure = cageform::bind(closed_form, cageform::FigurePoints{points, points}).value;
    check_progress("pack, a figure", [&](const Running& r) { return cageform::pack(figure, {}, r); });
    check_progress("rebind_cage",
                   [&](const Running& r) { return rebind_cage(figure, closed_form, {}, {}, r); });
}

} // namespace binding_progress_tests
