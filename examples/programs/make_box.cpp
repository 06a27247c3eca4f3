// Makes a tetrahedral mesh of a box, and a cage around it.
//
//     make_box -o box.mesh --size 4,1,1 --cells 40,10,10 --cage box_cage.obj
//     deform_mesh box.mesh --cage box_cage.obj --bend all:xy,0,4,150 --no-folds -o bent.mesh --report
//
// The box consists of cubes; each cube is split into six tetrahedra around a diagonal.

#include "cli/command_line.hpp"
#include "files/medit_file.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <cageform/cage/box_mesh.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

namespace {

using namespace cageform_support;

using Counts = std::array<std::size_t, 3>;
constexpr double most_cells = 16777216;

/// "4,1,1": three positive lengths; an empty reason is success.
std::string parse_size(const std::string& word, Point3& size) {
    std::array<double, 3> numbers{};
    if (const auto why = detail::parse_point(word, numbers); !why.empty()) return why;
    for (const double x : numbers) {
        if (!(x > 0 && std::isfinite(x))) return "a length is not a positive number";
    }
    size = {numbers[0], numbers[1], numbers[2]};
    return {};
}

/// "40,10,10": how many cubes or rectangles along each axis; an empty reason is success.
std::string parse_counts(const std::string& word, Counts& counts) {
    std::array<double, 3> numbers{};
    if (const auto why = detail::parse_point(word, numbers); !why.empty()) return why;
    for (const double x : numbers) {
        if (!(x >= 1 && x == std::floor(x))) return "a number along an axis is not a whole number from 1";
    }
    if (!(numbers[0] * numbers[1] * numbers[2] <= most_cells)) return "more than 16,777,216 together";
    for (std::size_t k = 0; k < 3; ++k) counts[k] = std::size_t(numbers[k]);
    return {};
}

struct TetrahedralBox {
    std::vector<Point3> vertices;
    std::vector<std::array<std::uint32_t, 4>> cells;

    TetrahedralBox(const Point3& size, const Counts& cubes) {
        const Counts points{cubes[0] + 1, cubes[1] + 1, cubes[2] + 1};
        const std::array<std::uint32_t, 3> step{1, std::uint32_t(points[0]),
                                                std::uint32_t(points[0] * points[1])};
        Counts at{};
        for (at[2] = 0; at[2] < points[2]; ++at[2]) {
            for (at[1] = 0; at[1] < points[1]; ++at[1]) {
                for (at[0] = 0; at[0] < points[0]; ++at[0]) {
                    Point3 p;
                    for (std::size_t k = 0; k < 3; ++k) p[k] = size[k] * double(at[k]) / double(cubes[k]);
                    const auto first = std::uint32_t(vertices.size());
                    vertices.push_back(p);
                    if (at[0] < cubes[0] && at[1] < cubes[1] && at[2] < cubes[2]) fill_cube(first, step);
                }
            }
        }
    }

private:
    /// Each path along three edges from the first corner of a cube to the last is a tetrahedron.
    void fill_cube(std::uint32_t first, const std::array<std::uint32_t, 3>& step) {
        std::array<std::size_t, 3> axes{0, 1, 2};
        do {
            const std::uint32_t second = first + step[axes[0]], third = second + step[axes[1]],
                                last = third + step[axes[2]];
            const bool is_cyclic = (axes[1] + 3 - axes[0]) % 3 == 1; // else it would be inverted
            cells.push_back({first, is_cyclic ? second : third, is_cyclic ? third : second, last});
        } while (std::next_permutation(axes.begin(), axes.end()));
    }
};

/// The sides of the box, enlarged by a margin, as rectangles.
std::string cage_text(const Point3& size, const Counts& divisions) {
    const double margin = 0.05 * *std::min_element(size.v, size.v + 3);
    const Point3 more{margin, margin, margin};
    const auto cage = cageform::box_mesh<double>(-1.0 * more, size + more, divisions);
    std::string text = "# A cage around a box of tetrahedra, made by make_box\n";
    for (const auto& p : cage.vertices()) {
        text += 'v';
        for (const double x : p.v) detail::append_digits(text += ' ', x);
        text += '\n';
    }
    for (std::size_t f = 0; f < cage.face_count(); ++f) {
        text += 'f';
        for (const auto v : cage.face(f)) text += ' ' + std::to_string(v + 1);
        text += '\n';
    }
    return text;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Makes a box of tetrahedra, with a corner at the origin, and a cage around it.");
    line.set_examples({"-o box.mesh", "-o box.mesh --size 4,1,1 --cells 40,10,10 --cage box_cage.obj"});
    std::string out, cage;
    Point3 size{4, 1, 1};
    Counts cells{16, 4, 4}, divisions{4, 1, 1};
    line.add("-o,--output", out, "the .mesh file to write").required().ends_with({".mesh"});
    line.add_parsed("--size", size, parse_size, "its lengths: X,Y,Z").show_default("4,1,1");
    line.add_parsed("--cells", cells, parse_counts,
                    "the number of cubes along each axis, six tetrahedra each")
        .show_default("16,4,4");
    line.add("--cage", cage, "also write a cage around it, a box, to an OBJ file").ends_with({".obj"});
    line.add_parsed("--divisions", divisions, parse_counts,
                    "the number of the cage's rectangles along each axis")
        .show_default("4,1,1");
    line.set_footer(medit_format);
    if (const auto code = line.parse(argc, argv)) return *code;

    fail_if(fault_of_outputs({out, cage}));
    const TetrahedralBox box(size, cells);
    OutputFiles outputs;
    outputs.add(out).write(medit_text(box.vertices, box.cells));
    if (!cage.empty()) outputs.add(cage).write(cage_text(size, divisions));
    fail_if(outputs.commit());
    std::cout << printable(out) << ": " << box.vertices.size() << " vertices, " << box.cells.size()
              << " tetrahedra\n";
    return 0;
}
