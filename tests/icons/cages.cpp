// Cages around icons that nobody here drew: for cages.sh.
//
//     cages < LIST    the files' names; prints a table of a row for each number of vertices and way of making
//
// made: make_cage returned a cage, verified against the icon. exact: it has the requested number of
// vertices. bound: harmonic coordinates at their default accuracy accept it, and all ends of segments
// are inside. Area over the tightest, least angles in degrees, and milliseconds have median, 95th
// percentile and worst.

#include "svg/drawn_figure.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/enclose/make_cage.hpp>

#include <algorithm>
#include <cstdio>
#include <iostream>

namespace {

using namespace cageform_support;
using Segments = std::vector<cageform::DrawnSegment<double>>;

struct Icon {
    std::string name;
    DrawnFigure figure;
};

bool is_bound(const cageform::Polygon<double>& cage, const Segments& segments) {
    std::vector<cageform::Vec<double, 2>> points;
    for (const auto& s : segments) points.insert(points.end(), {s.a, s.b});
    const auto [binding, report] = cageform::bind(cageform::HarmonicCoordinates<double, 2>(cage), points);
    return report.status == cageform::Status::ok && report.outside.empty() && report.unreached.empty();
}

/// Median, 95th percentile and the last, in the order told.
void print(std::vector<double> values, const char* format, bool falling = false) {
    std::sort(values.begin(), values.end());
    if (falling) std::reverse(values.begin(), values.end());
    const std::size_t n = values.size();
    for (const std::size_t k : {n / 2, n * 95 / 100, n - 1}) std::printf(format, n > 0 ? values[k] : 0.0);
}

void measure(const std::vector<Icon>& icons, const char* way, const cageform::MakeCageOptions& options) {
    std::size_t made = 0, exact = 0, bound = 0;
    std::vector<double> area, angle, milliseconds;
    for (const Icon& icon : icons) {
        const auto [cage, report] =
            cageform::make_cage(cageform::Drawing(icon.figure.segments, icon.figure.areas), options);
        milliseconds.push_back(1000 * report.seconds);
        if (report.status != cageform::Status::ok || report.clearance < 0.9 * report.margin) {
            std::printf("    %s: %s, clearance %.3f of the margin\n", icon.name.c_str(),
                        to_string(report.status), report.clearance / report.margin);
            continue;
        }
        ++made;
        exact += report.vertices == options.vertices ? 1 : 0;
        area.push_back(report.area / report.tightest_area);
        angle.push_back(report.least_angle);
        if (is_bound(cage, icon.figure.segments)) {
            ++bound;
        } else {
            std::printf("    %s: not bound\n", icon.name.c_str());
        }
    }
    std::printf("%-10s %3zu | %4zu %4zu %4zu of %zu |", way, options.vertices, made, exact, bound,
                icons.size());
    print(area, " %.3f");
    std::printf(" |");
    print(angle, " %3.0f", true);
    std::printf(" |");
    print(milliseconds, " %4.0f");
    std::printf("\n");
    std::fflush(stdout);
}

} // namespace

int main() {
    std::vector<Icon> icons;
    std::string name;
    std::size_t unread = 0;
    while (std::getline(std::cin, name)) {
        const auto document = load_svg(name);
        auto figure = document ? drawn_figure(*document) : Expected<DrawnFigure>(document.error());
        if (figure) {
            icons.push_back({name, std::move(*figure)});
        } else {
            ++unread;
            std::printf("    %s\n", to_string(figure.error()).c_str());
        }
    }
    std::printf("%zu icons, %zu files without one\n", icons.size(), unread);
    std::printf("way   vertices | made exact bound    | area over the tightest | least angle | ms\n");
    cageform::MakeCageOptions options;
    for (const std::size_t vertices : {16, 24, 40}) {
        options.vertices = vertices;
        measure(icons, "", options);
    }
    options.vertices = 24;
    auto changed = options;
    changed.mirror = cageform::MirrorPlane{0, {}};
    measure(icons, "mirrored", changed);
    changed = options;
    changed.one_cage = false;
    measure(icons, "parts", changed);
    changed = options;
    changed.holes = true;
    measure(icons, "holes", changed);
    for (const double margin : {0.01, 0.05}) {
        changed = options;
        changed.margin = margin;
        measure(icons, margin < 0.02 ? "margin 1%" : "margin 5%", changed);
    }
}
