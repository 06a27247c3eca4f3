// Surfaces over a domain in the plane: exactly the domain is drawn, in the requested view.
#include "pictures/field_plot.hpp"

#include "catch.hpp"
#include "support/cages.hpp"
#include "support/oracle.hpp"

#include <numbers>

namespace field_plot_tests {

using namespace cageform_tests;
using namespace cageform_support;

double cross2(const Point2& a, const Point2& b, const Point2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// A star around the origin with radii from 0.4 to 1; some of its vertices are on lines of the lattice.
std::vector<Point2> random_star(Random& random, double scale) {
    std::vector<Point2> loop;
    const std::size_t count = 5 + random.below(12);
    for (std::size_t k = 0; k < count; ++k) {
        const double angle = 2 * std::numbers::pi * (double(k) + random.uniform(0, 0.8)) / double(count);
        const double radius = scale * random.uniform(0.4, 1);
        Point2 p{radius * std::cos(angle), radius * std::sin(angle)};
        if (random.below(4) == 0) p.y = std::round(8 * p.y) / 8;
        loop.push_back(p);
    }
    return loop;
}

double area(const std::vector<Point2>& loop) {
    double sum = 0;
    for (std::size_t k = 0; k < loop.size(); ++k)
        sum += cross2({0, 0}, loop[k], loop[(k + 1) % loop.size()]) / 2;
    return std::fabs(sum);
}

double length(const std::vector<Point2>& loop) {
    double sum = 0;
    for (std::size_t k = 0; k < loop.size(); ++k) {
        const Point2 &a = loop[k], &b = loop[(k + 1) % loop.size()];
        sum += std::hypot(b.x - a.x, b.y - a.y);
    }
    return sum;
}

TEST_CASE("a domain cut along a lattice keeps its area and its boundary",
          "[examples][field_plot][property]") {
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 5);
    std::vector<std::vector<Point2>> loops{random_star(random, 1)};
    if (random.below(2) == 0) loops.push_back(random_star(random, 0.35)); // a hole
    PlaneBox box;
    for (const Point2& p : loops[0]) box.add(p);
    const PlaneMesh mesh = cut_by_lattice(loops, box, 4 + random.below(40));
    double covered = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        covered += std::fabs(cross2(mesh.places[a], mesh.places[b], mesh.places[c])) / 2;
    const double wanted = area(loops[0]) - (loops.size() == 2 ? area(loops[1]) : 0);
    CHECK(covered == Approx(wanted).epsilon(0).margin(1e-12));

    // Every edge of only one triangle is on a loop: neighbouring triangles share whole edges, without gaps.
    // The ends of an edge may differ by rounding where a column meets a loop.
    const std::vector<double> values(mesh.places.size(), 0.0);
    double rim = 0;
    for (const PlaneLine& line : rim_of(mesh, values)) {
        const Point2 &a = line.points[0], &b = line.points[1];
        const Point2 middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
        double nearest = 1;
        for (const auto& loop : loops) {
            for (std::size_t k = 0; k < loop.size(); ++k) {
                const Point2 &c = loop[k], &d = loop[(k + 1) % loop.size()];
                const double side = std::hypot(d.x - c.x, d.y - c.y);
                const double along =
                    ((middle.x - c.x) * (d.x - c.x) + (middle.y - c.y) * (d.y - c.y)) / (side * side);
                if (along > -1e-9 && along < 1 + 1e-9)
                    nearest = std::min(nearest, std::fabs(cross2(c, d, middle)) / side);
            }
        }
        CAPTURE(a.x, a.y, b.x, b.y);
        CHECK(nearest < 1e-12);
        rim += std::hypot(b.x - a.x, b.y - a.y);
    }
    CHECK(rim ==
          Approx(length(loops[0]) + (loops.size() == 2 ? length(loops[1]) : 0)).epsilon(0).margin(1e-9));
}

TEST_CASE("a part of a domain is its intersection with the box", "[examples][field_plot]") {
    const std::vector<std::vector<Point2>> loops{{{0, 0}, {4, 0}, {4, 3}, {0, 3}}};
    double covered = 0;
    const PlaneMesh mesh = cut_by_lattice(loops, {{3, 1}, {6, 2}}, 7);
    for (const auto& [a, b, c] : mesh.triangles)
        covered += std::fabs(cross2(mesh.places[a], mesh.places[b], mesh.places[c])) / 2;
    CHECK(covered == Approx(1).epsilon(0).margin(1e-12));
    const auto part = clip_segment({0, 0}, {4, 2}, {{1, 0}, {3, 1}});
    REQUIRE(part.has_value());
    CHECK((*part)[0] == Approx(0.25));
    CHECK((*part)[1] == Approx(0.5));
    CHECK(!clip_segment({0, 0}, {4, 0}, {{1, 1}, {3, 2}}).has_value());
    CHECK(!clip_segment({0, 0}, {1, 0}, {{2, -1}, {3, 2}}).has_value());
}

TEST_CASE("the text of a box is read or refused", "[examples][field_plot]") {
    const auto box = parse_box("-1, 2.5,3,4e1");
    REQUIRE(box.has_value());
    CHECK(box->low.x == -1);
    CHECK(box->high.y == 42.5);
    for (const char* text :
         {"", "1,2,3", "1,2,3,4,5", "1,2,0,4", "1,2,3,-4", "1,2,x,4", "1,2,nan,4", "1,2,inf,4"}) {
        CAPTURE(text);
        CHECK(!parse_box(text).has_value());
        CHECK(!box_fault(text).empty());
    }
}

TEST_CASE("projected points are those of the reference", "[examples][field_plot][oracle]") {
    const auto reference = read_json("fields");
    std::size_t count = 0;
    for (const auto& view : reference["plot"]) {
        const double degree = 180 / std::numbers::pi;
        const auto from = view_from(degree * double(view["turn"]), degree * double(view["rise"]));
        for (const auto& pair : view["points"]) {
            Point3 p, seen;
            for (std::size_t k = 0; k < 3; ++k) {
                p[k] = double(pair[0][k]);
                seen[k] = double(pair[1][k]);
            }
            CHECK(dot(from.right, p) == Approx(seen[0]).epsilon(0).margin(1e-15));
            CHECK(dot(from.up, p) == Approx(seen[1]).epsilon(0).margin(1e-15));
            CHECK(dot(from.towards, p) == Approx(seen[2]).epsilon(0).margin(1e-15));
            ++count;
        }
    }
    CHECK(count == 10);
}

/// A surface over a star, with linear values.
FieldSurface plane_over_star(std::size_t cells, double slope) {
    Random random(7);
    const std::vector<std::vector<Point2>> loops{random_star(random, 1)};
    PlaneBox box;
    for (const Point2& p : loops[0]) box.add(p);
    FieldSurface surface{cut_by_lattice(loops, box, cells), {}, {}, true};
    for (const Point2& p : surface.mesh.places) surface.values.push_back(0.5 + slope * (p.x - 0.5 * p.y));
    return surface;
}

bool is_like(const Colour& a, const Colour& b, float difference) {
    return std::fabs(a.r - b.r) <= difference && std::fabs(a.g - b.g) <= difference &&
           std::fabs(a.b - b.b) <= difference;
}

TEST_CASE("the picture of a plane does not depend on its subdivision", "[examples][field_plot]") {
    FieldStyle style;
    style.size = 150;
    SurfaceView view;
    view.turns = {35};
    const Picture coarse = draw_surface(plane_over_star(3, 0.4), view, style);
    const Picture fine = draw_surface(plane_over_star(40, 0.4), view, style);
    REQUIRE(coarse.width() == fine.width());
    std::size_t unlike = 0, coloured = 0;
    for (std::size_t y = 0; y < fine.height(); ++y) {
        for (std::size_t x = 0; x < fine.width(); ++x) {
            coloured += is_like(fine.at(x, y), {1, 1, 1}, 0.01f) ? 0 : 1;
            // Colour is not a linear function of the value, so coarse triangles interpolate it differently.
            unlike += is_like(coarse.at(x, y), fine.at(x, y), 0.12f) ? 0 : 1;
        }
    }
    CHECK(coloured > 2000);
    CHECK(unlike <= 4); // samples on an edge
}

TEST_CASE("whole turns of the view change no byte", "[examples][field_plot]") {
    FieldStyle style;
    style.size = 80;
    style.set_range(0, 1);
    SurfaceView view;
    view.turns = {35, 395, -325, 755};
    const Picture picture = draw_surface(plane_over_star(12, 0.3), view, style);
    const auto same_as = [&](std::size_t view_number) {
        for (std::size_t y = 0; y < style.size; ++y) {
            for (std::size_t x = 0; x < style.size; ++x) {
                if (!is_like(picture.at(x, y), picture.at(view_number * style.size + x, y), 0)) return false;
            }
        }
        return true;
    };
    for (std::size_t n = 1; n < 4; ++n) CHECK(same_as(n));
}

TEST_CASE("lines are visible in front of a surface and hidden behind it", "[examples][field_plot]") {
    // A wall in the plane y = 0, seen along y.
    const std::vector<Point3> wall{{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
    const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}, {0, 2, 3}};
    const std::vector<Colour> grey(4, Colour{0.5f, 0.5f, 0.5f});
    const auto green_pixels = [&](double depth) {
        SpacePlot plot{{wall, triangles, grey}, {}, {}};
        plot.lines.push_back({{{-0.8, depth, 0.3}, {0.8, depth, 0.3}}, 2, {0, 1, 0}});
        const Picture picture = draw_plot(plot, view_from(0, 0), 100, 100);
        std::size_t count = 0;
        for (std::size_t y = 0; y < 100; ++y) {
            for (std::size_t x = 0; x < 100; ++x) count += is_like(picture.at(x, y), {0, 1, 0}, 0.3f) ? 1 : 0;
        }
        return count;
    };
    CHECK(green_pixels(0.5) == 0);
    CHECK(green_pixels(0) >= 100); // on the wall
    CHECK(green_pixels(-0.5) >= 100);
}

TEST_CASE("an empty field and a constant field are drawn", "[examples][field_plot]") {
    FieldStyle style;
    style.size = 40;
    style.set_range(0, 1);
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    CHECK(draw_surface({mesh_of_grid(3, 2), std::vector<double>(6, nothing), {}}, {}, style).height() == 40);
    CHECK(draw_surface({mesh_of_grid(3, 2), std::vector<double>(6, 2.0), {}}, {}, style).height() == 40);
    CHECK(draw_surface({mesh_of_grid(1, 1), {1.0}, {}}, {}, style).height() == 40);
}

} // namespace field_plot_tests
