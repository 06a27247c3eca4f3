// Deforms a surface, a cloud of points or a tetrahedral mesh by a cage and a pose of the cage.
//
//     deform_mesh man.obj --cage auto -o first_look.obj --picture first_look.png
//     deform_mesh man.obj --cage man_cage.obj --pose man_pose.obj --coordinates harmonic -o posed.obj
//     deform_mesh man.obj --cage man_cage.obj --pin 12 --pin 5021:+0.2,+0.4,0 -o pulled.obj
//     deform_mesh part.mesh --cage part_cage.obj --bend all:xy,0,4,90 --no-folds -o bent.mesh --report
//
// sibson and sibson-c1 use the vertices of the cage files as control points.
//
// Normals are transformed by the inverse transpose of the deformation's Jacobian. The rest of the file does
// not change: groups, nodes, materials, images, texture coordinates, comments, cells.

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
    bool drops_skins = false;
    bool is_strict = false;
    cageform::FoldOptions folds;
    ViewChoice view;
};

/// Draws sites as octahedra.
MeshFile dots(const std::vector<Point3>& sites, double radius) {
    MeshFile file;
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
    std::vector<Point3> guides;       // of the figure
    std::vector<Colour> paint;        // of --weight
    MeshFolds folds;                  // around the vertices
    cageform::BindReport report;
    std::string warning;
};

constexpr std::size_t most_bytes = std::size_t{256} << 20; // of weights per batch

/// Binds and clones a figure, in batches if the weights exceed 256 MB.
class Deformer {
public:
    Deformer(const Arguments& given, const MeshFile& figure, const MeshControl& control)
        : given_(given)
        , control_(control)
        , rest_(figure.vertices)
        , guides_(figure.guides)
        , options_(given.control.outside.bind_options(control.coordinates))
        , finds_folds_(figure.tetrahedra.empty() && (given.report || given.no_folds))
        , takes_jacobians_(finds_folds_ || !figure.normals.empty() || !figure.guides.empty())
        , handles_(control.handles) {
        result_.vertices.resize(rest_.size());
        if (takes_jacobians_ && !control.weights.empty())
            leave_out_jacobians("no gradients are computed for points with weights");
        else if (takes_jacobians_ && !control.coordinates.has_gradients())
            leave_out_jacobians(cageform::to_string(cageform::Status::gradients_not_supported));
        if (takes_jacobians_) result_.jacobians.resize(rest_.size());
    }

    /// Stops if the status of the report is not ok.
    Deformed run() {
        auto& report = result_.report;
        report.cage = control_.coordinates.cage_report();
        const std::size_t bindings = takes_jacobians_ ? 4 : 1;
        const std::size_t handles = control_.coordinates.handles().count;
        const std::size_t fits = most_bytes / (bindings * sizeof(double) * (handles + 1));
        const std::size_t together = rest_.size() <= fits ? rest_.size() : fits / 4 + 1;
        ProgressBar bar("binding");
        const cageform::Running running{.progress = bar.callback()};
        const bool in_batches = together < rest_.size() || takes_jacobians_;
        if (in_batches) {
            const auto evaluation = control_.coordinates.solve(running.subtask(0, 0.5));
            report.status = evaluation.status;
            report.solver = evaluation.solver;
        }
        const cageform::Running binding = running.subtask(in_batches ? 0.5 : 0, 1);
        const double all = double(std::max<std::size_t>(rest_.size(), 1));
        std::size_t first = 0;
        while (report.status == cageform::Status::ok) {
            const std::size_t end = first + std::min(together, rest_.size() - first);
            deform(first, end, binding.subtask(double(first) / all, double(end) / all));
            first = end;
            if (first >= rest_.size()) break;
        }
        if (report.status == cageform::Status::ok) deform_guides(together);
        return std::move(result_);
    }

private:
    cageform::Status clone_points(const cageform::Binding<double, 3>& bound, std::span<Point3> moved) const {
        const std::span weights(control_.weights);
        return weights.empty() ? cageform::clone(bound, handles_, moved)
                               : cageform::clone_rational(bound, handles_, weights, moved);
    }

    /// Moves the figure's guides, in batches. Guides outside the cage follow as the coordinates define.
    void deform_guides(std::size_t together) {
        result_.guides.resize(guides_.size());
        for (std::size_t first = 0; first < guides_.size(); first += together) {
            const auto batch = guides_.subspan(first, std::min(together, guides_.size() - first));
            const auto bound = control_.coordinates.bind(batch, options_, cageform::Running{});
            const auto moved = std::span(result_.guides).subspan(first, batch.size());
            if (bound && clone_points(bound.value, moved) == cageform::Status::ok) continue;
            result_.guides.clear();
            return;
        }
    }

    void leave_out_jacobians(const std::string& why) {
        takes_jacobians_ = false;
        result_.folds.unknown = why;
        result_.jacobians.clear();
    }

    void deform(std::size_t first, std::size_t end, const cageform::Running& running) {
        const auto batch = rest_.subspan(first, end - first);
        const auto& [coordinates, weights] = std::tie(control_.coordinates, control_.weights);
        const auto bound = coordinates.bind(batch, options_, running.subtask(0, takes_jacobians_ ? 0.25 : 1));
        if (first == 0) result_.report.solver = bound.report.solver;
        add_batch(result_.report, bound.report, first);
        result_.report.status = bound.report.status;
        if (bound.report.status != cageform::Status::ok) return;
        const auto& pose = control_.pose;
        if (handles_.empty())
            handles_ = value_or_fail(pose_of_handles(bound.value, pose.vertices, pose.name, result_.warning));
        const auto moved = std::span(result_.vertices).subspan(first, batch.size());
        if (const auto status = clone_points(bound.value, moved); status != cageform::Status::ok)
            throw Failure((weights.empty() ? pose.name : given_.control.of_sites.weights) + ": " +
                          cageform::to_string(status));
        if (takes_jacobians_) clone_jacobians(first, batch, running.subtask(0.25, 1));
        for (std::size_t i = 0; given_.paints && i < batch.size(); ++i)
            result_.paint.push_back(heat(bound.value.weight(i, given_.weight)));
    }

    void clone_jacobians(std::size_t first, std::span<const Point3> batch, const cageform::Running& running) {
        const auto axes = control_.coordinates.bind_jacobians(batch, options_, running);
        const cageform::StridedMatrices<double, 3> jacobians(result_.jacobians[first][0].v, batch.size());
        const cageform::Status cloned =
            axes ? cageform::clone_jacobians(axes.value, handles_, jacobians) : axes.report.status;
        if (cloned != cageform::Status::ok) return leave_out_jacobians(cageform::to_string(cloned));
        const auto at_rest = control_.coordinates.handles();
        if (finds_folds_)
            result_.folds.add(axes.value, std::span(at_rest.rest, at_rest.count), handles_, first,
                              given_.folds);
    }

    const Arguments& given_;
    const MeshControl& control_;
    std::span<const Point3> rest_, guides_;
    cageform::BindOptions options_;
    bool finds_folds_, takes_jacobians_;
    std::vector<Point3> handles_; // in the pose; empty until the first batch is bound
    Deformed result_;
};

/// If the pose folds the figure, moves both back towards rest, to the largest step without folds.
void stop_at_folds(const MeshFile& figure, MeshControl& control, std::vector<Point3>& moved,
                   std::vector<Jacobian3>& jacobians, std::vector<Point3>& guides, const MeshFolds& folds) {
    if (const std::string why = folds.fault(); !why.empty())
        throw Failure(figure.name + ": --no-folds: " + why);
    if (folds.report.count == 0) return;
    const double step = folds.step.step;
    note(figure.name + ": the pose stops at " + detail::short_number(step) + " of its way from rest, where " +
         (folds.of_cells ? "" : "the figure at ") + folds.name_of(folds.step.culprit) + " would fold");
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = on_the_way(figure.vertices[i], moved[i], step);
    for (std::size_t i = 0; i < guides.size(); ++i) guides[i] = on_the_way(figure.guides[i], guides[i], step);
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
}

/// ", with a negative determinant at 6 of 6 vertices"; empty without Jacobians.
std::string share_of_mirrored(const std::vector<Jacobian3>& jacobians) {
    const auto mirrors = [](const Jacobian3& j) { return dot(j[0], cross(j[1], j[2])) < 0; };
    const auto count = std::count_if(jacobians.begin(), jacobians.end(), mirrors);
    return jacobians.empty() ? std::string()
                             : ", with a negative determinant at " + std::to_string(count) + " of " +
                                   std::to_string(jacobians.size()) + " vertices";
}

/// Draws the figure at rest and posed, in its cage.
Picture draw_pose(const Arguments& given, const MeshFile& figure, const MeshControl& control,
                  const Deformed& posed) {
    MeshFile rest_dots, moved_dots;
    const MeshFile *drawn = &control.cage, *drawn_pose = &control.pose;
    if (control.coordinates.takes_sites) {
        const std::span<const Point3> sites(control.cage.vertices);
        const double radius = cageform::bounds_of(sites).diagonal() / 150;
        rest_dots = dots(control.cage.vertices, radius);
        moved_dots = dots(control.pose.vertices, radius);
        drawn = &rest_dots;
        drawn_pose = &moved_dots;
    }
    const std::array<MeshScene, 2> scenes{
        {{{figure.vertices, figure.triangles, posed.paint}, cage_view(*drawn, drawn->vertices)},
         {{posed.vertices, figure.triangles, posed.paint}, cage_view(*drawn, drawn_pose->vertices)}}};
    return draw_meshes(scenes, 1600, 1000, given.view.sight);
}

void print_report(const Arguments& given, const MeshFile& figure, const MeshControl& control,
                  const Deformed& posed) {
    std::cout << "figure: " << figure.vertices.size() << " vertices, " << figure.normals.size()
              << " normals, " << (figure.tetrahedra.empty() ? figure.faces.size() : figure.tetrahedra.size())
              << (figure.tetrahedra.empty() ? " faces\n" : " tetrahedra\n");
    if (control.coordinates.takes_sites)
        std::cout << "control points: " << control.cage.vertices.size() << '\n';
    else
        std::cout << "cage: " << control.cage.vertices.size() << " vertices, "
                  << control.cage.triangles.size() << " triangles\n";
    std::cout << describe(posed.report) << control.on_pins
              << describe(posed.folds, given.no_folds && posed.folds.report.count > 0);
}

/// Binds, clones and writes the requested files.
int deform_figure(const Arguments& given, const MeshFile& figure, MeshControl control) {
    const auto& [coordinates, cage] = std::tie(control.coordinates, control.cage);
    fail_if(fault_of_outputs({given.out, given.control.save_pose, given.picture}));
    print_notes(cage.name, coordinates.cage_report(), coordinates.note);
    Deformed posed = Deformer(given, figure, control).run();
    auto& [moved, jacobians, guides, paint, folds, report, warning] = posed;
    if (report.status != cageform::Status::ok) return fail(control.describe_faults(report));
    warn_of_coarse_grid(cage.name, report.solver);
    given.control.outside.check(coordinates, report, figure.vertices, figure.name, cage.name);
    warn(warning);
    for (const Point3& p : moved) {
        if (!cageform::is_finite(p)) return fail(figure.name + ": a vertex is not finite in the pose");
    }
    if (!figure.tetrahedra.empty() && (given.report || given.no_folds))
        folds = folds_of_cells(figure, moved, given.folds);
    if (given.no_folds) stop_at_folds(figure, control, moved, jacobians, guides, folds);

    warn(describe_winding(control.pose.name, figure.name + share_of_mirrored(jacobians),
                          side_of(figure.vertices, moved), given.flips_faces));
    if (jacobians.empty() && !figure.normals.empty() && !folds.unknown.empty())
        note(figure.name + ": its normals are computed from the faces: " + folds.unknown);
    OutputFiles outputs;
    const auto notes =
        value_or_fail(save_mesh(figure, {moved, jacobians, guides, given.drops_skins}, given.out, outputs));
    if (!given.control.save_pose.empty()) outputs.add(given.control.save_pose).write(control.saved_pose());
    if (!given.picture.empty())
        draw_pose(given, figure, control, posed).write_png(outputs.add(given.picture));
    fail_if(outputs.commit());
    for (const std::string& text : notes) note(text);
    note(describe_materials(figure, given.out));
    if (given.report) print_report(given, figure, control, posed);
    return 0;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Deforms a surface, a cloud of points or a tetrahedral mesh by a cage, a closed mesh around it, "
        "and a pose of the cage.");
    line.set_examples({"model.obj --cage auto:60 -o look.obj --picture look.png",
                       "model.obj --cage cage.obj --pose pose.obj --coordinates harmonic -o posed.obj",
                       "model.obj --cage cage.obj --pin 12 --pin 5021:+0.2,+0.4,0 -o pulled.obj",
                       "part.mesh --cage box --twist all:x,0,4,90 --no-folds -o twisted.mesh --report"});
    Arguments given;
    line.add("figure", given.figure, "the file to deform: glTF, OBJ, PLY, STL or Medit").required();
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
    line.add("-o,--output", given.out,
             "the file to write, in the format of the figure: .obj, .mesh, .glb, .gltf, .ply or .stl")
        .required()
        .ends_with(mesh_extensions);
    line.add_flag(
        "--drop-skin", given.drops_skins,
        "glTF: write skinned meshes in the pose of the cage, without their skins. By default skins are "
        "kept, and their joints move with the cage");
    given.control.outside.add_options(line);
    given.control.of_sites.add_options(line);
    line.add("--picture", given.picture, "also draw it at rest and posed, in its cage, to a PNG file")
        .ends_with({".png"});
    given.view.add_options(line);
    const CommandOption weight =
        line.add("--weight", given.weight, "paint the weight of this vertex, from 0, in the picture");
    line.add_flag("--report", given.report, "print the bind report, the errors of pins, and folds");
    given.control.choice.add_options(line);
    line.set_footer(mesh_formats + std::string("\n") + medit_format + "\n" + lattice_format + "\n" +
                    pose_operations_format + "\n" + pins_format + "\n" + site_formats + "\n" +
                    site_weights_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    fail_if(given.control.fault());
    auto figure = load_mesh_figure(given.figure, given.is_strict);
    fail_if(fault_of_extension(figure, given.out));
    if (given.flips_faces) fail_if(fault_of_reversing(figure));
    auto control = read_mesh_control(given.control, figure, figure.vertices);
    fail_if(given.control.save_fault(control));
    given.paints = weight.is_given();
    if (given.paints && given.picture.empty()) return fail("--weight needs --picture");
    if (given.paints && given.weight >= control.cage.vertices.size()) {
        return fail("there is no vertex " + std::to_string(given.weight) + ": " + given.control.cage +
                    " has " + std::to_string(control.cage.vertices.size()));
    }
    if (given.flips_faces) figure = with_faces_reversed(std::move(figure));
    return deform_figure(given, figure, std::move(control));
}
