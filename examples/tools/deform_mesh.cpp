// Deforms any OBJ figure by a cage, a closed mesh around it, and a pose of the cage.
//
//     deform_mesh man.obj --cage auto -o first_look.obj --picture first_look.png
//     deform_mesh man.obj --cage man_cage.obj --pose man_pose.obj --coordinates harmonic -o posed.obj
//
// Coordinates of points without a cage, sibson and sibson-c1, take the vertices of both files for points.
//
// Vertices move with the cage and normals turn with the faces. Everything else in the file stays: groups,
// materials, texture coordinates, comments.

#include "cli/auto_cage.hpp"
#include "cli/bind_report.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/guard.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/pose_choice.hpp"
#include "cli/progress_bar.hpp"
#include "cli/view_choice.hpp"
#include "files/atomic_file.hpp"
#include "files/obj_parts.hpp"
#include "pictures/mesh_picture.hpp"

#include <cageform/clone/clone.hpp>
#include <cageform/clone/clone_rational.hpp>

#include <functional>
#include <iostream>

namespace {

using namespace cageform_examples;

struct Arguments {
    std::string figure, cage, pose, out, picture;
    OutsideChoice outside;
    std::size_t weight = 0; // whose is painted
    bool paints = false;
    bool report = false;
    CoordinatesChoice choice;
    SiteChoice of_sites;
    PoseChoice operations;
    ViewChoice view;
};

/// The control of the figure: coordinates, and the pose of their handles.
struct Control {
    ChosenCoordinates<double, 3> coordinates;
    ObjFile cage, pose;          // of sites with points alone
    std::vector<double> weights; // of sites, or none
    std::function<std::string(const cageform::BindReport&)> describe_faults;
};

/// Sites as a picture shows them: an octahedron each.
ObjFile dots(const std::vector<Point3>& sites, double radius) {
    ObjFile file;
    for (const Point3& site : sites) {
        const auto first = std::uint32_t(file.vertices.size()); // then 2k and 2k + 1 along axis k
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

SvgResult<Control> read_sites(const Arguments& given, const ObjFile& figure) {
    auto posed = load_posed_sites<3>(given.cage, given.pose, given.of_sites,
                                     [&]() -> SvgResult<std::vector<Point3>> { return figure.vertices; });
    if (!posed) return posed.error();
    auto& [sites, pose, weights] = *posed;
    Control control{make_coordinates<double>(given.choice, sites), {}, {}, std::move(weights), {}};
    control.cage.name = given.cage;
    control.cage.vertices = sites.points;
    control.pose.name = given.pose;
    control.pose.vertices = std::move(pose.points);
    control.describe_faults = [known = std::move(sites)](const cageform::BindReport& report) {
        return describe_site_faults(known, report);
    };
    return control;
}

/// The pose by a file, or by operations; of a cage that is made, where neither is given, one for a first
/// look.
SvgResult<ObjFile> read_pose(const Arguments& given, const ObjFile& cage) {
    const bool operated = !given.operations.operations.empty();
    if (!given.pose.empty() && operated)
        return SvgError{"give --pose or operations such as --turn, but not both"};
    const auto held = given.operations.still(cage.lattice);
    if (!held) return held.error();
    const auto put_back = [&](ObjFile pose) {
        for (const std::size_t i : *held) pose.vertices[i] = cage.vertices[i];
        return pose;
    };
    if (!given.pose.empty()) {
        auto pose = load_obj(given.pose);
        if (!pose) return pose;
        const std::string why = pose_difference(cage, *pose);
        if (!why.empty()) return SvgError{why};
        return put_back(std::move(*pose));
    }
    if (!operated && !CageWord::of(given.cage).is_auto)
        return SvgError{"--pose is required, or operations such as --turn"};
    ObjFile pose = cage;
    if (operated) {
        auto moved = given.operations.posed(cage.vertices, cage.lattice);
        if (!moved) return moved.error();
        pose.vertices = std::move(*moved);
    } else {
        pose.vertices = first_pose(cage.vertices);
    }
    return put_back(std::move(pose));
}

SvgResult<Control> read_control(const Arguments& given, const ObjFile& figure) {
    if (given.choice.takes_sites() && given.pose.empty()) return SvgError{"--pose is required for points"};
    if (given.choice.takes_sites()) return read_sites(given, figure);
    auto cage = load_or_make_cage(given.cage, figure);
    if (!cage) return cage.error();
    auto pose = read_pose(given, *cage);
    if (!pose) return pose.error();
    auto coordinates = make_coordinates<double>(given.choice, *cage);
    const std::string name = cage->name;
    return Control{std::move(coordinates),
                   std::move(*cage),
                   std::move(*pose),
                   {},
                   [name](const cageform::BindReport& report) { return describe_mesh_faults(name, report); }};
}

struct Deformed {
    std::vector<Point3> vertices;
    std::vector<Colour> paint; // of --weight
    cageform::BindReport report;
    std::string fault, warning;
};

/// Binds the figure and moves it; where the weights of all vertices would take more than 256 MB, a batch of
/// them after the other. Until `fault` is not empty, or the report's status not ok.
Deformed deformed(const Arguments& given, const ObjFile& figure, const Control& control) {
    constexpr std::size_t most_bytes = std::size_t{256} << 20;
    const auto& [coordinates, cage, pose, weights, describe_faults] = control;
    const std::span<const Point3> rest(figure.vertices);
    const std::size_t fits = most_bytes / (sizeof(double) * (coordinates.handles().count + 1));
    const std::size_t together = rest.size() <= fits ? rest.size() : fits / 4 + 1;
    const auto options = given.outside.bind_options(coordinates);
    Deformed result;
    result.vertices.resize(rest.size());
    auto& report = result.report;
    report.cage = coordinates.cage_report();
    ProgressBar bar("binding");
    const cageform::Running running{.progress = bar.callback()};
    const bool in_batches = together < rest.size();
    if (in_batches) {
        const auto evaluation = coordinates.solve(running.subtask(0, 0.5));
        report.status = evaluation.status;
        report.solver = evaluation.solver;
    }
    const cageform::Running binding = running.subtask(in_batches ? 0.5 : 0, 1);
    const auto done = [&](std::size_t i) {
        return double(i) / double(std::max<std::size_t>(rest.size(), 1));
    };
    std::optional<std::vector<Point3>> handles;
    std::size_t first = 0;
    while (report.status == cageform::Status::ok) {
        const auto batch = rest.subspan(first, std::min(together, rest.size() - first));
        const auto bound =
            coordinates.bind(batch, options, binding.subtask(done(first), done(first + batch.size())));
        if (first == 0) report.solver = bound.report.solver;
        add_batch(report, bound.report, first);
        report.status = bound.report.status;
        if (report.status != cageform::Status::ok) break;
        if (!handles) {
            auto posed = pose_of_handles(bound.value, pose.vertices, pose.name, result.warning);
            if (!posed) {
                result.fault = to_string(posed.error());
                return result;
            }
            handles = std::move(*posed);
        }
        const auto moved = std::span(result.vertices).subspan(first, batch.size());
        const auto status = weights.empty()
                                ? cageform::clone(bound.value, *handles, moved)
                                : cageform::clone_rational(bound.value, *handles, std::span(weights), moved);
        if (status != cageform::Status::ok) {
            result.fault =
                (weights.empty() ? pose.name : given.of_sites.weights) + ": " + cageform::to_string(status);
            return result;
        }
        for (std::size_t i = 0; given.paints && i < batch.size(); ++i)
            result.paint.push_back(heat(bound.value.weight(i, given.weight)));
        first += batch.size();
        if (first >= rest.size()) break;
    }
    return result;
}

/// Binds the figure, moves it and writes the requested files.
int deform_figure(const Arguments& given, const ObjFile& figure, const Control& control) {
    const auto& [coordinates, cage, pose, weights, describe_faults] = control;
    if (const auto why = fault_of_outputs({given.out, given.picture})) return fail(*why);
    warn_of_closed_gaps(cage.name, coordinates.cage_report());
    if (!coordinates.note.empty()) note(coordinates.note);
    const auto [moved, paint, report, fault, warning] = deformed(given, figure, control);
    if (!fault.empty()) return fail(fault);
    if (report.status != cageform::Status::ok) return fail(describe_faults(report));
    warn_of_coarse_grid(cage.name, report.solver);
    const auto outside = given.outside.judge(coordinates, report, figure.vertices, figure.name, cage.name);
    if (!outside.fault.empty()) return fail(outside.fault);
    if (!outside.warning.empty()) warn(outside.warning);
    if (!warning.empty()) warn(warning);
    for (const Point3& p : moved) {
        if (!cageform::is_finite(p)) return fail(figure.name + ": a vertex has left the range of numbers");
    }

    OutputFiles outputs;
    outputs.add(given.out).write(to_text(figure, moved));
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
            {{{figure.vertices, figure.triangles, paint}, {drawn->vertices, drawn->triangles}},
             {{moved, figure.triangles, paint}, {drawn_pose->vertices, drawn->triangles}}}};
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
             " (and their textures), which have to be in the same folder");
    }
    if (given.report) {
        std::cout << "figure: " << figure.vertices.size() << " vertices, " << figure.normals.size()
                  << " normals, " << figure.faces.size() << " faces\n";
        if (coordinates.takes_sites)
            std::cout << "control points: " << cage.vertices.size() << '\n';
        else
            std::cout << "cage: " << cage.vertices.size() << " vertices, " << cage.triangles.size()
                      << " triangles\n";
        std::cout << describe(report);
    }
    return 0;
}

int run_program(int argc, char** argv) {
    CommandLine line("Deforms an OBJ figure by a cage, a closed mesh around it, and a pose of the cage.");
    line.set_examples({"model.obj --cage auto:60 -o look.obj --picture look.png",
                       "model.obj --cage cage.obj --pose pose.obj --coordinates harmonic -o posed.obj"});
    Arguments given;
    line.add("figure", given.figure, "the OBJ file to deform").required();
    line.add("--cage", given.cage,
             "its cage: an OBJ file of a closed mesh, faces counter-clockwise seen from outside; for sibson "
             "and sibson-c1 a file of points" +
                 std::string(auto_cage_help))
        .required();
    line.add("--pose", given.pose,
             "the pose: the same mesh or points with vertices moved; or give operations such as --turn; with "
             "--cage auto and none of these, half the figure bends");
    given.operations.add_options(line);
    line.add("-o,--output", given.out, "the OBJ file to write").required().ends_with({".obj"});
    given.outside.with_sites = given.choice.with_sites = given.choice.with_normals = true;
    given.choice.in_space = true;
    given.outside.add_options(line);
    given.of_sites.add_options(line);
    line.add("--picture", given.picture, "also draw it at rest and posed, in its cage, to a PNG file")
        .ends_with({".png"});
    given.view.add_options(line);
    const CommandOption weight =
        line.add("--weight", given.weight, "paint this vertex's weight on the figure in the picture, from 0");
    line.add_flag("--report", given.report, "print the bind report");
    given.choice.add_options(line);
    line.set_footer(obj_format + std::string("\n") + lattice_format + "\n" + pose_operations_format + "\n" +
                    site_formats + "\n" + site_weights_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    for (const std::string& why : {given.of_sites.fault(given.choice), given.outside.fault()}) {
        if (!why.empty()) return fail(why);
    }

    const auto figure = load_obj(given.figure);
    if (!figure) return fail(to_string(figure.error()));
    const auto control = read_control(given, *figure);
    if (!control) return fail(to_string(control.error()));
    given.paints = weight.is_given();
    if (given.paints && given.picture.empty()) return fail("--weight is painted on the --picture: give one");
    if (given.paints && given.weight >= control->cage.vertices.size()) {
        return fail("there is no vertex " + std::to_string(given.weight) + ": " + given.cage + " has " +
                    std::to_string(control->cage.vertices.size()));
    }
    return deform_figure(given, *figure, *control);
}

} // namespace

int main(int argc, char** argv) {
    return guarded("deform_mesh", [&] { return run_program(argc, argv); });
}
