// Deforms any OBJ figure by a cage, a closed mesh around it, and a pose of the cage.
//
//     deform_mesh man.obj --cage man_cage.obj --pose man_pose.obj --coordinates harmonic -o posed.obj
//
// Vertices move with the cage and normals turn with the faces. Everything else in the file stays: groups,
// materials, texture coordinates, comments.

#include "atomic_file.hpp"
#include "guard.hpp"
#include "mesh_cage.hpp"
#include "mesh_picture.hpp"
#include "progress_bar.hpp"

#include <CLI/CLI.hpp>

#include <iostream>

namespace {

using namespace cageform_examples;

int fail(const std::string& message) {
    std::cerr << "deform_mesh: " << message << '\n';
    return 1;
}

struct Arguments {
    std::string figure, cage, pose, out, picture;
    std::string coordinates = "mean-value", outside = "refuse";
    bool report = false;
    cageform::HarmonicOptions harmonic{.resolution = 64};
};

/// Binds the figure, moves it and writes what was asked for.
template <class Coordinates>
int deform_figure(const Arguments& given, const Coordinates& coordinates, const ObjFile& figure,
                  const ObjFile& cage, const ObjFile& pose) {
    warn_of_closed_gaps("deform_mesh", cage.name, coordinates.cage_report());
    cageform::BindOptions options;
    options.outside = given.outside == "nearest"  ? cageform::OutsidePoints::nearest_boundary
                      : given.outside == "extend" ? cageform::OutsidePoints::extend
                                                  : cageform::OutsidePoints::keep_in_place;
    cageform::BindResult<double, 3> bound;
    {
        ProgressBar bar("binding");
        bound = cageform::bind(coordinates, figure.vertices, options, {.progress = bar.callback()});
    }
    const auto& report = bound.report;
    if (report.status != cageform::Status::ok) return fail(describe_mesh_faults(cage.name, report));
    const std::string points = std::to_string(report.outside.size()) + " of " +
                               std::to_string(report.points) + " vertices of " + figure.name;
    if (given.outside == "refuse" && !report.outside.empty()) {
        return fail(points + " lie outside the cage " + cage.name + ", first " +
                    name_points(figure.vertices, report.outside) + "; --outside says what to do with them");
    }
    if (given.outside == "extend" && !Coordinates::has_extension && !report.outside.empty()) {
        return fail(given.coordinates + " coordinates are not defined outside the cage, where " + points +
                    " lie, first " + name_points(figure.vertices, report.outside));
    }
    if (!report.unreached.empty()) {
        return fail(figure.name + ": no weights can be had for " +
                    name_points(figure.vertices, report.unreached) +
                    (Coordinates::closed_form ? ": too far from the cage"
                                              : ": the grid is too coarse, raise --resolution"));
    }
    std::vector<Point3> moved(figure.vertices.size());
    const auto status = cageform::clone(bound.binding, pose.vertices, moved);
    if (status != cageform::Status::ok) return fail(pose.name + ": " + cageform::to_string(status));
    for (const Point3& p : moved) {
        if (!cageform::is_finite(p)) return fail(figure.name + ": a vertex has moved beyond all numbers");
    }

    AtomicFile out(given.out);
    out.write(to_text(figure, moved));
    if (out.error()) return fail(*out.error());
    if (!given.picture.empty()) {
        const std::array<MeshScene, 2> scenes{
            {{{figure.vertices, figure.triangles}, {cage.vertices, cage.triangles}},
             {{moved, figure.triangles}, {pose.vertices, cage.triangles}}}};
        if (const auto error = draw_meshes(scenes, 1600, 1000).write_png(given.picture)) return fail(*error);
    }
    if (const auto error = out.commit()) return fail(*error);
    if (given.report) {
        std::cout << "figure: " << figure.vertices.size() << " vertices, " << figure.normals.size()
                  << " normals, " << figure.faces.size() << " faces\ncage: " << cage.vertices.size()
                  << " vertices, " << cage.triangles.size() << " triangles\n"
                  << describe(report);
    }
    return 0;
}

int run_program(int argc, char** argv) {
    CLI::App app("Deforms an OBJ figure by a cage, a closed mesh around it, and a pose of the cage.");
    Arguments given;
    app.add_option("figure", given.figure, "the OBJ file to deform")->required();
    app.add_option("--cage", given.cage,
                   "its cage: an OBJ file of a closed mesh, faces counter-clockwise seen from outside")
        ->required();
    app.add_option("--pose", given.pose, "the same mesh with its vertices moved")->required();
    app.add_option("-o,--output", given.out, "the OBJ file to write")->required();
    app.add_option("--coordinates", given.coordinates, "mean-value or harmonic")
        ->check(CLI::IsMember({"mean-value", "harmonic"}))
        ->capture_default_str();
    app.add_option("--resolution", given.harmonic.resolution, "harmonic: grid cells along the longest side")
        ->capture_default_str();
    app.add_option("--tolerance", given.harmonic.multigrid.tolerance,
                   "harmonic: where the solver ends, an error of the functions")
        ->capture_default_str();
    app.add_option("--outside", given.outside,
                   "vertices outside the cage: refuse, keep (in place), nearest (follow the nearest boundary "
                   "point) or extend (where the coordinates are defined outside)")
        ->check(CLI::IsMember({"refuse", "keep", "nearest", "extend"}))
        ->capture_default_str();
    app.add_option("--picture", given.picture, "also draw it at rest and posed, in its cage, to a PNG file");
    app.add_flag("--report", given.report, "print the bind report");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 1;
    }

    const auto figure = load_obj(given.figure);
    if (!figure) return fail(to_string(figure.error()));
    const auto cage = load_mesh_cage(given.cage);
    if (!cage) return fail(to_string(cage.error()));
    const auto pose = load_obj(given.pose);
    if (!pose) return fail(to_string(pose.error()));
    const std::string why = pose_difference(*cage, *pose);
    if (!why.empty()) return fail(why);

    const cageform::TriangleMesh<double> mesh(cage->vertices, cage->triangles);
    if (given.coordinates == "harmonic") {
        return deform_figure(given, cageform::HarmonicCoordinates<double, 3>(mesh, given.harmonic), *figure,
                             *cage, *pose);
    }
    return deform_figure(given, cageform::MeanValueCoordinates<double, 3>(mesh), *figure, *cage, *pose);
}

} // namespace

int main(int argc, char** argv) {
    return guarded("deform_mesh", [&] { return run_program(argc, argv); });
}
