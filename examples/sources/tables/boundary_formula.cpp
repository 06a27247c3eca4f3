// Prints the boundary values of a harmonic function of a cage as formulas, edge by edge. The function is 1 at
// its vertex, linear along the adjacent edges, and 0 on all others. Inside it solves Laplace's equation.
//
//     boundary_formula --cage square.csv --vertex 0 --at 1,0

#include "cli/coordinates.hpp"
#include "files/bind_report.hpp"
#include "files/cage_file.hpp"
#include "io/messages.hpp"
#include "pictures/field_plot.hpp"

#include <cmath>
#include <iostream>

namespace {

using namespace cageform_support;

std::string number(double x) {
    return text_of("%.12g", x == 0 ? 0.0 : x);
}

/// "3 + 2 t", without zero terms.
std::string linear(double constant, double slope, const std::string& variable) {
    if (slope == 0) return number(constant);
    const std::string size = std::fabs(slope) == 1 ? "" : number(std::fabs(slope)) + " ";
    if (constant == 0) return (slope < 0 ? "-" : "") + size + variable;
    return number(constant) + (slope < 0 ? " - " : " + ") + size + variable;
}

/// "(x - 3)/4": the fraction of the path between two coordinates; "1 - x/4" towards 0.
std::string share(const std::string& variable, double from, double to) {
    const double length = to - from;
    if (to == 0) {
        const std::string size = std::fabs(length) == 1 ? "" : "/" + number(std::fabs(length));
        return (length < 0 ? "1 - " : "1 + ") + variable + size;
    }
    std::string above = from == 0  ? variable
                        : from < 0 ? variable + " + " + number(-from)
                                   : variable + " - " + number(from);
    if (length < 0) above = number(from) + " - " + variable;
    if (length < 0 && from == 0) above = "-" + variable;
    if (std::fabs(length) == 1) return above;
    return (above.find(' ') == std::string::npos ? above : "(" + above + ")") + "/" +
           number(std::fabs(length));
}

struct Edge {
    std::size_t from, to;
};

/// The formula on an edge that begins or ends at the vertex, in t from 0 to 1 and in x or y.
std::string formula(const CageFile& cage, const Edge& edge, std::size_t vertex) {
    const Point2 &a = cage.vertices[edge.from], &b = cage.vertices[edge.to];
    const bool falls = edge.from == vertex; // from 1 to 0
    const bool along_x = std::fabs(b.x - a.x) >= std::fabs(b.y - a.y);
    const std::string variable = along_x ? "x" : "y";
    const double from = along_x ? a.x : a.y, to = along_x ? b.x : b.y;
    // The share of the way from the end at which the function is 0.
    const std::string part = falls ? share(variable, to, from) : share(variable, from, to);
    const std::string place = along_x && a.y == b.y    ? "(x, " + number(a.y) + ")"
                              : !along_x && a.x == b.x ? "(" + number(a.x) + ", y)"
                                                       : "(x, y)";
    return "  x = " + linear(a.x, b.x - a.x, "t") + ", y = " + linear(a.y, b.y - a.y, "t") +
           ", 0 <= t <= 1:  h_" + std::to_string(vertex) + " = " + (falls ? "1 - t" : "t") + "\n  h_" +
           std::to_string(vertex) + place + " = " + part + ", " + number(std::fmin(from, to)) +
           " <= " + variable + " <= " + number(std::fmax(from, to)) + "\n";
}

/// The position on an edge that is nearest to a point.
struct Nearest {
    Edge edge{};
    double t = 0, distance = HUGE_VAL;
};
Nearest nearest_place(const CageFile& cage, const Point2& p) {
    Nearest best;
    cage.for_each_edge([&](std::size_t i, std::size_t j) {
        const Point2 &a = cage.vertices[i], &b = cage.vertices[j];
        const double ex = b.x - a.x, ey = b.y - a.y, length2 = ex * ex + ey * ey;
        const double along = length2 > 0 ? ((p.x - a.x) * ex + (p.y - a.y) * ey) / length2 : 0;
        const double t = std::fmin(std::fmax(along, 0), 1);
        const double distance = std::hypot(p.x - a.x - t * ex, p.y - a.y - t * ey);
        if (distance < best.distance) best = {{i, j}, t, distance};
    });
    return best;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Prints the values of a cage's harmonic function on its boundary, as formulas.");
    line.set_examples(
        {"--cage square.csv --vertex 0 --at 1,0", "--cage cat_cage.svg --vertex 0 --at 212.5,750"});
    std::string cage_path, place;
    std::size_t vertex = 0;
    line.add("--cage", cage_path, "an SVG or CSV file").required();
    line.add("--vertex", vertex, "the vertex whose function is printed, counted from 0").required();
    line.add("--at", place, "x,y: also print its value at this point of the boundary");
    line.set_footer(cage_formats);
    if (const auto code = line.parse(argc, argv)) return *code;

    const auto cage = load_cage(cage_path).value();
    CoordinatesChoice choice;
    choice.name = "harmonic";
    const auto checked = make_coordinates<double>(choice, cage).cage_report();
    if (checked.status != cageform::Status::ok) return fail(describe_faults(cage.name, checked));
    if (vertex >= cage.vertices.size()) {
        return fail("there is no vertex " + std::to_string(vertex) + ": " + cage_path + " has " +
                    std::to_string(cage.vertices.size()));
    }
    std::array<double, 2> at{};
    if (!place.empty()) {
        if (const std::string why = detail::parse_point(place, at); !why.empty()) return fail("--at: " + why);
    }
    std::string text = "h_" + std::to_string(vertex) + " is 1 at (" + number(cage.vertices[vertex].x) + ", " +
                       number(cage.vertices[vertex].y) + ")\n";
    cage.for_each_edge([&](std::size_t i, std::size_t j) {
        if (i == j || (i != vertex && j != vertex)) return; // a point, or an edge elsewhere
        const Edge edge{i, j};
        text += "on the edge from vertex " + std::to_string(i) + " to vertex " + std::to_string(j) + ":\n" +
                formula(cage, edge, vertex);
    });
    text += "on all other edges it is 0\n";
    if (!place.empty()) {
        const Point2 p{at[0], at[1]};
        const auto [edge, t, distance] = nearest_place(cage, p);
        PlaneBox box;
        for (const Point2& v : cage.vertices) box.add(v);
        if (!(distance <= 1e-9 * box.extent())) {
            return fail("--at: (" + number(p.x) + ", " + number(p.y) + ") is not on the boundary, which is " +
                        number(distance) + " away");
        }
        const double value = (edge.from == vertex ? 1 - t : 0) + (edge.to == vertex ? t : 0);
        text += "h_" + std::to_string(vertex) + "(" + number(p.x) + ", " + number(p.y) +
                ") = " + number(value) + ", on the edge from vertex " + std::to_string(edge.from) +
                " to vertex " + std::to_string(edge.to) + " at t = " + number(t) + "\n";
    }
    std::cout << text;
    return 0;
}
