// Finds the pose of a lattice that fits a posed figure best.
//
//     lattice_fit man.obj man_posed.obj --cage lattice:6x6x6 -o pose.obj --picture fit.png
//     deform_mesh man.obj --cage lattice:6x6x6 --pose pose.obj -o by_lattice.obj
//     lattice_fit icon.svg icon_edited.svg --cage lattice:4x4 -o pose.svg
//
// The posed figure is the same file with moved vertices. The pose is a least-squares fit (fit_lattice), which
// deform_mesh, deform_svg and other programs read. The program prints the largest error and its position.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/pose_choice.hpp"
#include "files/bind_report.hpp"
#include "files/obj_file.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"
#include "pictures/mesh_picture.hpp"
#include "pictures/view_choice.hpp"
#include "svg/document.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/fit_lattice.hpp>
#include <cageform/clone/clone.hpp>

#include <chrono>
#include <iostream>
#include <limits>

namespace {

using namespace cageform_support;

struct Arguments {
    std::string rest, posed, cage, out, picture;
    double smoothness = cageform::LatticeFitOptions{}.smoothness;
    PoseChoice choice; // --freeze
    ViewChoice view;
    bool is_strict = false;
};

/// A figure's vertices at rest and posed, and their names.
template <std::size_t D>
struct Figures {
    std::string rest_name, posed_name;
    std::vector<cageform::Vec<double, D>> rest, posed;
};

template <std::size_t D>
struct Fitted {
    std::vector<cageform::Vec<double, D>> pose, moved; // handles of the lattice; vertices of the figure
};

/// Fits the pose of the lattice, and prints the errors.
template <std::size_t D>
Fitted<D> fitted(const Arguments& given, const Figures<D>& figures,
                 const std::optional<LatticeBox<D>>& lattice) {
    const auto& [rest_name, posed_name, rest, posed] = figures;
    if (!lattice)
        throw Failure("--cage " + detail::quoted(given.cage) +
                      " is no lattice: write one such as lattice:" + (D == 2 ? "4x4" : "4x4x4"));
    if (rest.size() != posed.size())
        throw Failure(posed_name + " has " + std::to_string(posed.size()) + " vertices, " + rest_name +
                      " has " + std::to_string(rest.size()) + ": both need the same vertices");
    const auto held = given.choice.still(lattice);
    const std::vector<std::uint32_t> frozen(held.begin(), held.end());

    const auto start = std::chrono::steady_clock::now();
    const auto coordinates = lattice->template coordinates<double>();
    const auto bound = cageform::bind(coordinates, rest);
    if (!bound) throw Failure(describe_faults(rest_name, bound.report));
    std::vector<cageform::Vec<double, D>> displacements;
    for (std::size_t i = 0; i < rest.size(); ++i) displacements.push_back(posed[i] - rest[i]);
    auto fit = cageform::fit_lattice(coordinates, bound.value, displacements,
                                     {.smoothness = given.smoothness, .frozen = frozen});
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    const auto& report = fit.report;
    if (!fit) throw Failure(posed_name + ": " + cageform::to_string(report.status));
    Fitted<D> result{std::move(fit.value), rest};
    const auto status = cageform::clone(bound.value, result.pose, result.moved);
    if (status != cageform::Status::ok) throw Failure(cageform::to_string(status));
    const auto number = [](double x) { return detail::short_number(x); };
    std::cout << printable(rest_name) << ": by " << describe(*lattice)
              << "\nlargest distance: " << number(report.largest) << ", of " << (D == 2 ? "point " : "v ")
              << report.farthest + (D == 2 ? 0 : 1) << " at (";
    for (std::size_t k = 0; k < D; ++k) std::cout << (k == 0 ? "" : ", ") << number(rest[report.farthest][k]);
    std::cout << "); rms: " << number(report.rms)
              << "\npoints of the lattice that move no vertex: " << report.idle.size()
              << "\nseconds to bind and fit: " << number(time.count()) << '\n';
    if (report.unreached > 0)
        warn(rest_name + ": " + std::to_string(report.unreached) +
             (report.unreached == 1 ? " vertex is" : " vertices are") + " too far from the lattice to move");
    return result;
}

int fit_in_plane(const Arguments& given) {
    if (lowercase_extension(given.out) == ".obj")
        return fail("-o " + given.out + ": the figure lies in the plane: write .svg or .csv");
    if (!given.picture.empty())
        return fail("--picture is for figures in space; pose_cage draws a pose in the plane");
    const auto rest = value_or_fail(load_svg(given.rest));
    const auto posed = value_or_fail(load_svg(given.posed));
    Figures<2> figures{given.rest, given.posed, {}, {}};
    for (const auto& [document, points] : {std::pair{&rest, &figures.rest}, {&posed, &figures.posed}}) {
        const auto found = value_or_fail(figure_vertices(*document));
        for (const Point2& p : found) points->push_back({p.x, p.y});
    }
    const auto cage = load_or_make_cage(given.cage, rest);
    const auto fit = fitted(given, figures, cage.lattice);
    const CageFile pose = moved_cage(cage, fit.pose);
    const auto view = view_box(rest);
    const Expected<std::string> text =
        lowercase_extension(given.out) == ".csv" ? to_csv(pose) : to_svg(pose, view);
    if (!text) return fail(given.out + ": " + to_string(text.error()));
    OutputFiles outputs;
    outputs.add(given.out).write(*text);
    return commit(outputs);
}

int fit_in_space(const Arguments& given) {
    if (lowercase_extension(given.out) != ".obj")
        return fail("-o " + given.out + ": the figure lies in space: write .obj");
    fail_if(fault_of_outputs({given.out, given.picture}));
    auto rest = load_mesh_figure(given.rest, given.is_strict);
    const auto posed = value_or_fail(load_mesh(given.posed, strays_of(given.is_strict)));
    if (posed.vertices.size() == rest.vertices.size()) {
        fail_if(leave_out_also(rest, posed.left_out, given.posed + ": ", given.is_strict));
    }
    const auto cage = load_or_make_cage(given.cage, rest);
    Figures<3> figures{given.rest, given.posed, rest.vertices, posed.vertices};
    for (const std::size_t vertex : rest.left_out) // fit_lattice skips non-finite points
        figures.rest[vertex] = Point3{std::numeric_limits<double>::quiet_NaN(), 0, 0};
    const auto fit = fitted(given, figures, cage.lattice);
    OutputFiles outputs;
    outputs.add(given.out).write(to_text(cage, fit.pose));
    if (!given.picture.empty()) {
        const std::array<MeshScene, 3> scenes{
            {{{rest.vertices, rest.triangles}, cage_view(cage, cage.vertices)},
             {{posed.vertices, rest.triangles}, {}},
             {{fit.moved, rest.triangles}, cage_view(cage, fit.pose)}}};
        draw_meshes(scenes, 1500, 620, given.view.sight).write_png(outputs.add(given.picture));
    }
    return commit(outputs);
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Finds the pose of a lattice that fits a posed figure best.");
    line.set_examples({"man.obj man_posed.obj --cage lattice:6x6x6 -o pose.obj --picture fit.png",
                       "icon.svg icon_edited.svg --cage lattice:4x4 -o pose.svg"});
    Arguments given;
    line.add("rest", given.rest, "the figure at rest: a mesh or an SVG file").required();
    line.add("posed", given.posed, "the same file with moved vertices").required();
    line.add("--cage", given.cage, "the lattice: lattice:4x4 or lattice:4x4x4, or a .lattice.json file")
        .required();
    line.add("--smoothness", given.smoothness,
             "the weight of second differences of the pose: higher is smoother, lower fits more closely")
        .range(0.0, 1e12)
        .show_default();
    line.add("--freeze", given.choice.freeze,
             "the number of layers of points at the faces of the box to keep at rest")
        .show_default();
    line.add("-o,--output", given.out, "the pose to write: in space .obj, in the plane .svg or .csv")
        .required()
        .ends_with({".obj", ".svg", ".csv"});
    line.add("--picture", given.picture,
             "also draw the figure at rest, posed, and by the lattice's pose, to a PNG file (in space)")
        .ends_with({".png"});
    given.view.add_options(line);
    add_strict(line, given.is_strict);
    line.set_footer(mesh_formats + std::string("\n") + lattice_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    return is_mesh_path(given.rest) ? fit_in_space(given) : fit_in_plane(given);
}
