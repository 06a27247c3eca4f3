// Deforms an OBJ figure or a tetrahedral mesh by a cage and a pose of the cage.
//
//     deform_mesh man.obj --cage auto -o first_look.obj --picture first_look.png
//     deform_mesh man.obj --cage man_cage.obj --pose man_pose.obj --coordinates harmonic -o posed.obj
//     deform_mesh man.obj --cage man_cage.obj --pin 12 --pin 5021:+0.2,+0.4,0 -o pulled.obj
//     deform_mesh part.mesh --cage part_cage.obj --bend all:xy,0,4,90 --no-folds -o bent.mesh --report
//
// sibson and sibson-c1 use the vertices of the cage files as control points.
//
// Normals are transformed by the inverse transpose of the deformation's Jacobian. The rest of the file does
// not change: groups, materials, texture coordinates, comments, cells.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/mesh_control.hpp"
#include "cli/mesh_folds.hpp"
#include "cli/progress_bar.hpp"
#include "files/bind_report.hpp"
#include "files/medit_file.hpp"
#include "files/obj_parts.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"
#include "pictures/mesh_picture.hpp"
#include "pictures/view_choice.hpp"

#include <cageform/clone/clone.hpp>
#include <cageform/clone/clone_rational.hpp>
#include <cageform/clone/jacobians.hpp>

#include <algorithm>
#include <iostream>

namespace {

using namespace cageform_support;

struct Arguments {
    std::string figure, out, picture;
    MeshControlChoice control;
    std::size_t weight = 0; // the vertex of --weight
    bool paints = false;
    bool report = false;
    bool no_folds = false;
    bool flips_faces = false;
    bool is_strict = false;
    cageform::FoldOptions folds;
    ViewChoice view;
};

/// Draws sites as octahedra.
ObjFile dots(const std::vector<Point3>& sites, double radius) {
    ObjFile file;
    for (const Point3& site : sites) {
        const auto first = std::uint32_t(file.vertices.size()); // + 2k and 2k + 1: the corners on axis k
        for (std::size_t n = 0; n < 6; ++n) {
            file.vertices.push_back(site);
            file.vertices.back()[n / 2] += n % 2 == 0 ? radius : -radius;
        }
        for (std::uint32_t corner = 0; corner < 8; ++corner) {
            file.triangles.push_back(
                {first + corner % 2, first + 2 + corner / 2 % 2, first + 4 + corner / 4});
        }
    }
    return file;
}

struct Deformed {
    std::vector<Point3> vertices;
    std::vector<Jacobian3> jacobians; // at the vertices; empty if unknown or not needed
    std::vector<Colour> paint;        // of --weight
    MeshFolds folds;                  // around the vertices
    cageform::BindReport report;
    std::string fault, warning;
};

constexpr std::size_t most_bytes = std::size_t{256} << 20; // of weights per batch

/// Binds and clones the figure, in batches if the weights exceed 256 MB. Stops if `fault` is not empty or the
/// status of the report is not ok.
Deformed deformed(const Arguments& given, const ObjFile& figure, const MeshControl& control) {
    const auto& coordinates = control.coordinates;
    const auto& [pose, weights] = std::tie(control.pose, control.weights);
    const std::span<const Point3> rest(figure.vertices);
    const auto at_rest = coordinates.handles();
    const auto options = given.control.outside.bind_options(coordinates);
    Deformed result;
    result.vertices.resize(rest.size());
    auto& report = result.report;
    report.cage = coordinates.cage_report();
    const bool finds_folds = figure.tetrahedra.empty() && (given.report || given.no_folds);
    bool takes_jacobians = finds_folds || !figure.normals.empty();
    if (takes_jacobians && (!weights.empty() || !coordinates.has_gradients())) {
        takes_jacobians = false;
        result.folds.unknown = weights.empty()
                                   ? cageform::to_string(cageform::Status::gradients_not_supported)
                                   : "no gradients are computed for points with weights";
    }
    if (takes_jacobians) result.jacobians.resize(rest.size());
    const std::size_t bindings = takes_jacobians ? 4 : 1;
    const std::size_t fits = most_bytes / (bindings * sizeof(double) * (at_rest.count + 1));
    const std::size_t together = rest.size() <= fits ? rest.size() : fits / 4 + 1;
    ProgressBar bar("binding");
    const cageform::Running running{.progress = bar.callback()};
    const bool in_batches = together < rest.size() || takes_jacobians;
    if (in_batches) {
        const auto evaluation = coordinates.solve(running.subtask(0, 0.5));
        report.status = evaluation.status;
        report.solver = evaluation.solver;
    }
    const cageform::Running binding = running.subtask(in_batches ? 0.5 : 0, 1);
    const auto done = [&](std::size_t i) {
        return double(i) / double(std::max<std::size_t>(rest.size(), 1));
    };
    std::vector<Point3> handles = control.handles;
    std::size_t first = 0;
    while (report.status == cageform::Status::ok) {
        const auto batch = rest.subspan(first, std::min(together, rest.size() - first));
        const double begin = done(first), end = done(first + batch.size());
        const double middle = takes_jacobians ? 0.75 * begin + 0.25 * end : end;
        const auto bound = coordinates.bind(batch, options, binding.subtask(begin, middle));
        if (first == 0) report.solver = bound.report.solver;
        add_batch(report, bound.report, first);
        report.status = bound.report.status;
        if (report.status != cageform::Status::ok) break;
        if (handles.empty()) {
            auto posed = pose_of_handles(bound.value, pose.vertices, pose.name, result.warning);
            if (!posed) {
                result.fault = to_string(posed.error());
                return result;
            }
            handles = std::move(*posed);
        }
        const auto moved = std::span(result.vertices).subspan(first, batch.size());
        const auto status = weights.empty()
                                ? cageform::clone(bound.value, handles, moved)
                                : cageform::clone_rational(bound.value, handles, std::span(weights), moved);
        if (status != cageform::Status::ok) {
            result.fault = (weights.empty() ? pose.name : given.control.of_sites.weights) + ": " +
                           cageform::to_string(status);
            return result;
        }
        if (takes_jacobians) {
            const auto axes = coordinates.bind_jacobians(batch, options, binding.subtask(middle, end));
            const cageform::StridedMatrices<double, 3> jacobians(result.jacobians[first][0].v, batch.size());
            const cageform::Status cloned =
                axes ? cageform::clone_jacobians(axes.value, handles, jacobians) : axes.report.status;
            takes_jacobians = cloned == cageform::Status::ok;
            if (!takes_jacobians) {
                result.folds.unknown = cageform::to_string(cloned);
                result.jacobians.clear();
            } else if (finds_folds) {
                result.folds.add(axes.value, std::span(at_rest.rest, at_rest.count), handles, first,
                                 given.folds);
            }
        }
        for (std::size_t i = 0; given.paints && i < batch.size(); ++i)
            result.paint.push_back(heat(bound.value.weight(i, given.weight)));
        first += batch.size();
        if (first >= rest.size()) break;
    }
    return result;
}

/// If the pose folds the figure, moves both back towards rest, to the largest step without folds. Returns an
/// error message, or empty.
std::string stop_at_folds(const ObjFile& figure, MeshControl& control, std::vector<Point3>& moved,
                          std::vector<Jacobian3>& jacobians, const MeshFolds& folds) {
    if (const std::string why = folds.fault(); !why.empty()) return figure.name + ": --no-folds: " + why;
    if (folds.report.count == 0) return {};
    const double step = folds.step.step;
    note(figure.name + ": the pose stops at " + detail::short_number(step) + " of its way from rest, where " +
         (folds.of_cells ? "" : "the figure at ") + folds.name_of(folds.step.culprit) + " would fold");
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = on_the_way(figure.vertices[i], moved[i], step);
    for (Jacobian3& jacobian : jacobians) {
        for (std::size_t k = 0; k < 3; ++k) {
            Point3 axis{};
            axis[k] = 1;
            jacobian[k] = on_the_way(axis, jacobian[k], step);
        }
    }
    auto& pose = control.pose.vertices;
    for (std::size_t i = 0; i < pose.size(); ++i)
        pose[i] = on_the_way(control.cage.vertices[i], pose[i], step);
    return {};
}

/// ", with a negative determinant at 6 of 6 vertices"; empty without Jacobians.
std::string share_of_mirrored(const std::vector<Jacobian3>& jacobians) {
    const auto mirrors = [](const Jacobian3& j) { return dot(j[0], cross(j[1], j[2])) < 0; };
    const auto count = std::count_if(jacobians.begin(), jacobians.end(), mirrors);
    return jacobians.empty() ? std::string()
                             : ", with a negative determinant at " + std::to_string(count) + " of " +
                                   std::to_string(jacobians.size()) + " vertices";
}

/// Binds, clones and writes the requested files.
int deform_figure(const Arguments& given, const ObjFile& figure, MeshControl control) {
    const auto& [coordinates, cage, pose] = std::tie(control.coordinates, control.cage, control.pose);
    if (const auto why = fault_of_outputs({given.out, given.control.save_pose, given.picture}))
        return fail(*why);
    warn_of_closed_gaps(cage.name, coordinates.cage_report());
    if (!coordinates.note.empty()) note(coordinates.note);
    auto [moved, jacobians, paint, folds, report, fault, warning] = deformed(given, figure, control);
    if (!fault.empty()) return fail(fault);
    if (report.status != cageform::Status::ok) return fail(control.describe_faults(report));
    warn_of_coarse_grid(cage.name, report.solver);
    const auto outside =
        given.control.outside.judge(coordinates, report, figure.vertices, figure.name, cage.name);
    if (!outside.fault.empty()) return fail(outside.fault);
    if (!outside.warning.empty()) warn(outside.warning);
    if (!warning.empty()) warn(warning);
    for (const Point3& p : moved) {
        if (!cageform::is_finite(p)) return fail(figure.name + ": a vertex is not finite in the pose");
    }
    if (!figure.tetrahedra.empty() && (given.report || given.no_folds))
        folds = folds_of_cells(figure, moved, given.folds);
    if (given.no_folds) {
        const std::string why = stop_at_folds(figure, control, moved, jacobians, folds);
        if (!why.empty()) return fail(why);
    }

    if (const std::string why =
            describe_winding(control.pose.name, figure.name + share_of_mirrored(jacobians),
                             side_of(figure.vertices, moved), given.flips_faces);
        !why.empty())
        warn(why);
    if (jacobians.empty() && !figure.normals.empty() && !folds.unknown.empty())
        note(figure.name + ": its normals are computed from the faces: " + folds.unknown);
    OutputFiles outputs;
    outputs.add(given.out).write(to_text(figure, {moved, jacobians}));
    if (!given.control.save_pose.empty()) outputs.add(given.control.save_pose).write(control.saved_pose());
    if (!given.picture.empty()) {
        ObjFile rest_dots, moved_dots;
        const ObjFile *drawn = &cage, *drawn_pose = &pose;
        if (coordinates.takes_sites) {
            const double radius =
                cageform::bounds_of(std::span<const Point3>(cage.vertices)).diagonal() / 150;
            rest_dots = dots(cage.vertices, radius);
            moved_dots = dots(pose.vertices, radius);
            drawn = &rest_dots;
            drawn_pose = &moved_dots;
        }
        const std::array<MeshScene, 2> scenes{
            {{{figure.vertices, figure.triangles, paint}, cage_view(*drawn, drawn->vertices)},
             {{moved, figure.triangles, paint}, cage_view(*drawn, drawn_pose->vertices)}}};
        draw_meshes(scenes, 1600, 1000, given.view.sight).write_png(outputs.add(given.picture));
    }
    if (const auto error = outputs.commit()) return fail(*error);
    const auto folder_of = [](const std::string& path) {
        return std::filesystem::absolute(path).lexically_normal().parent_path();
    };
    if (const auto materials = material_files(figure);
        !materials.empty() && folder_of(given.out) != folder_of(given.figure)) {
        note(given.out + " names its materials as " + given.figure +
             " does: " + detail::quoted(materials[0]) + (materials.size() > 1 ? " and more" : "") +
             " (and their textures), which must be in the same folder");
    }
    if (given.report) {
        std::cout << "figure: " << figure.vertices.size() << " vertices, " << figure.normals.size()
                  << " normals, "
                  << (figure.tetrahedra.empty() ? figure.faces.size() : figure.tetrahedra.size())
                  << (figure.tetrahedra.empty() ? " faces\n" : " tetrahedra\n");
        if (coordinates.takes_sites)
            std::cout << "control points: " << cage.vertices.size() << '\n';
        else
            std::cout << "cage: " << cage.vertices.size() << " vertices, " << cage.triangles.size()
                      << " triangles\n";
        std::cout << describe(report) << control.on_pins;
        std::cout << describe(folds, given.no_folds && folds.report.count > 0);
    }
    return 0;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Deforms an OBJ figure or a tetrahedral mesh by a cage, a closed mesh around it, and a pose of "
        "the cage.");
    line.set_examples({"model.obj --cage auto:60 -o look.obj --picture look.png",
                       "model.obj --cage cage.obj --pose pose.obj --coordinates harmonic -o posed.obj",
                       "model.obj --cage cage.obj --pin 12 --pin 5021:+0.2,+0.4,0 -o pulled.obj",
                       "part.mesh --cage box --twist all:x,0,4,90 --no-folds -o twisted.mesh --report"});
    Arguments given;
    line.add("figure", given.figure, "the OBJ or .mesh file to deform").required();
    given.control.add_options(line);
    line.add_flag(
        "--no-folds", given.no_folds,
        "stop the pose on its straight path from rest, before the first tetrahedron folds; for a surface, "
        "before space folds at the first vertex");
    line.add("--fold-threshold", given.folds.threshold,
             "the largest ratio of volumes, posed to rest, that counts as folded")
        .range(-1e6, 0.999)
        .show_default()
        .rarely_needed();
    add_strict(line, given.is_strict);
    add_flip_faces(line, given.flips_faces);
    line.add("-o,--output", given.out, "the file to write: .obj or .mesh, like the figure")
        .required()
        .ends_with({".obj", ".mesh"});
    given.control.outside.add_options(line);
    given.control.of_sites.add_options(line);
    line.add("--picture", given.picture, "also draw it at rest and posed, in its cage, to a PNG file")
        .ends_with({".png"});
    given.view.add_options(line);
    const CommandOption weight =
        line.add("--weight", given.weight, "paint the weight of this vertex, from 0, in the picture");
    line.add_flag("--report", given.report, "print the bind report, the errors of pins, and folds");
    given.control.choice.add_options(line);
    line.set_footer(obj_format + std::string("\n") + medit_format + "\n" + lattice_format + "\n" +
                    pose_operations_format + "\n" + pins_format + "\n" + site_formats + "\n" +
                    site_weights_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    if (const std::string why = given.control.fault(); !why.empty()) return fail(why);
    const std::string ending = ending_of(given.figure) == ".mesh" ? ".mesh" : ".obj";
    if (ending_of(given.out) != ending)
        return fail("-o " + given.out + ": the figure " + given.figure + " is written as " + ending);

    auto figure = load_mesh_figure(given.figure, given.is_strict, MeshFormats::obj_or_medit).value();
    if (given.flips_faces && ending == ".mesh")
        return fail("--flip-faces: " + figure.name + ": only OBJ files are supported");
    auto control = read_mesh_control(given.control, figure, figure.vertices).value();
    if (const std::string why = given.control.save_fault(control); !why.empty()) return fail(why);
    given.paints = weight.is_given();
    if (given.paints && given.picture.empty()) return fail("--weight needs --picture");
    if (given.paints && given.weight >= control.cage.vertices.size()) {
        return fail("there is no vertex " + std::to_string(given.weight) + ": " + given.control.cage +
                    " has " + std::to_string(control.cage.vertices.size()));
    }
    if (given.flips_faces) figure = with_faces_turned_over(std::move(figure));
    return deform_figure(given, figure, std::move(control));
}
