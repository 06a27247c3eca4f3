// Binds an OBJ figure to a cage, a closed mesh around it, and packs what a game needs of it into one file
// (support/figure_file.hpp): points and normals as blobs, triangles, and a motion of the cage.
//
//     bind_mesh character.obj --cage character_cage.obj --clip character_clip.csv --largest 16 --format int16
//               -o character.figure
//
// The engine's client (engine/ogre_client.cpp) maps that file and plays it.

#include "atomic_file.hpp"
#include "clip_file.hpp"
#include "figure_file.hpp"
#include "guard.hpp"
#include "mesh_cage.hpp"

#include <cageform/binding/bind_vectors.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/cageform.hpp>

#include <CLI/CLI.hpp>

#include <iostream>

namespace {

using namespace cageform_examples;
using cageform::Status;
using cageform::WeightFormat;

struct Arguments {
    std::string figure, cage, clip, out;
    std::string coordinates = "mean-value";
    WeightFormat format = WeightFormat::scalar;
    std::size_t largest = 0;
    bool report = false;
    cageform::HarmonicOptions harmonic{.resolution = 64};
};

int fail(const std::string& message) {
    std::cerr << "bind_mesh: " << message << '\n';
    return 1;
}

/// The mean of the normals of the faces around every vertex, by area.
std::vector<Point3> normals_of(const ObjFile& figure) {
    const auto& p = figure.vertices;
    std::vector<Point3> normals(p.size());
    for (const auto& [a, b, c] : figure.triangles) {
        for (const auto i : {a, b, c}) normals[i] = normals[i] + cross(p[b] - p[a], p[c] - p[a]);
    }
    return normals;
}

/// The curves of x, y and z of every vertex.
std::vector<cageform::PiecewiseCubic<float>> curves_of(const PoseClip& clip) {
    std::vector<cageform::PiecewiseCubic<float>> curves;
    std::vector<double> values(clip.keys.size());
    for (std::size_t n = 0; n < 3 * clip.keys[0].places.size(); ++n) {
        for (std::size_t k = 0; k < values.size(); ++k) values[k] = clip.keys[k].places[n / 3][n % 3];
        std::vector<cageform::CubicPiece<float>> pieces;
        const auto curve = curve_through(clip, values);
        for (const auto& [begin, c0, c1, c2, c3] : curve.pieces())
            pieces.push_back({float(begin), float(c0), float(c1), float(c2), float(c3)});
        curves.emplace_back(std::move(pieces), float(clip.length));
    }
    return curves;
}

template <class Coordinates>
int bind_figure(const Arguments& given, const Coordinates& coordinates, const ObjFile& figure,
                const ObjFile& cage) {
    warn_of_closed_gaps("bind_mesh", cage.name, coordinates.cage_report());
    std::vector<cageform::PiecewiseCubic<float>> curves;
    if (!given.clip.empty()) {
        const auto clip = load_pose_clip(given.clip, cage.vertices.size());
        if (!clip) return fail(to_string(clip.error()));
        curves = curves_of(*clip);
    }
    cageform::BindOptions bind_options;
    bind_options.outside = cageform::OutsidePoints::keep_in_place;
    const auto bound = cageform::bind(coordinates, figure.vertices, bind_options);
    if (bound.report.status != Status::ok) return fail(describe_mesh_faults(cage.name, bound.report));
    if (!bound.report.outside.empty() || !bound.report.unreached.empty()) {
        return fail(std::to_string(bound.report.outside.size()) + " vertices of " + figure.name +
                    " lie outside the cage " + cage.name + ", " +
                    std::to_string(bound.report.unreached.size()) + " have no weights");
    }
    const auto tangents = cageform::tangents_of(normals_of(figure));
    const auto turned = cageform::bind_vectors(coordinates, figure.vertices, tangents, bind_options);
    if (turned.report.status != Status::ok) return fail(describe_mesh_faults(cage.name, turned.report));

    AtomicFile out(given.out);
    const auto write = [&out](std::span<const std::byte> bytes) {
        out.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    };
    cageform::PackOptions options;
    options.format = given.format;
    options.largest = given.largest;
    cageform::PackedBinding<float, 3> points; // whose order vectors take over
    for (const auto* binding : {&bound.binding, &turned.bindings[0], &turned.bindings[1]}) {
        auto [packed, report] = cageform::pack(*binding, options);
        if (report.status != Status::ok) return fail(cageform::to_string(report.status));
        write(packed.bytes());
        if (given.report) {
            std::cout << (binding == &bound.binding ? "points: " : "tangents: ") << report.bytes << " of "
                      << report.dense_bytes << " bytes, " << report.weights_per_point
                      << " weights a point; sum of changes of a point's weights at most "
                      << report.error.value << ", mean " << report.mean_error << '\n';
        }
        if (binding == &bound.binding) points = std::move(packed);
        if (points.view().order != nullptr) options.order = {points.view().order, figure.vertices.size()};
    }
    write(figure_tail(figure.triangles, curves));
    if (const auto error = out.commit()) return fail(*error);
    return 0;
}

int run_program(int argc, char** argv) {
    CLI::App app("Binds an OBJ figure to a cage and packs what a game needs of it into one file.");
    Arguments given;
    std::string format = "float";
    app.add_option("figure", given.figure, "the OBJ file to bind")->required();
    app.add_option("--cage", given.cage,
                   "its cage: an OBJ file of a closed mesh, faces counter-clockwise seen from outside")
        ->required();
    app.add_option("--clip", given.clip, "a motion of the cage: poses as make_character writes them");
    app.add_option("-o,--out", given.out, "the file to write")->required();
    app.add_option("--coordinates", given.coordinates, "mean-value or harmonic")
        ->check(CLI::IsMember({"mean-value", "harmonic"}))
        ->capture_default_str();
    app.add_option("--resolution", given.harmonic.resolution,
                   "grid cells along the cage's longest side, for harmonic")
        ->capture_default_str();
    app.add_option("--largest", given.largest,
                   "weights of its place that a vertex keeps at least, 4 or more; 0: all")
        ->capture_default_str();
    app.add_option("--format", format, "of weights: float, half, int16 or int8")
        ->check(CLI::IsMember({"float", "half", "int16", "int8"}))
        ->capture_default_str();
    app.add_flag("--report", given.report, "print sizes and errors");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 1;
    }
    given.format = format == "half"    ? WeightFormat::half
                   : format == "int16" ? WeightFormat::int16
                   : format == "int8"  ? WeightFormat::int8
                                       : WeightFormat::scalar;

    const auto figure = load_obj(given.figure);
    if (!figure) return fail(to_string(figure.error()));
    const auto cage = load_mesh_cage(given.cage);
    if (!cage) return fail(to_string(cage.error()));
    const cageform::TriangleMesh<float> mesh(cage->vertices, cage->triangles);
    if (given.coordinates == "harmonic") {
        return bind_figure(given, cageform::HarmonicCoordinates<float, 3>(mesh, given.harmonic), *figure,
                           *cage);
    }
    return bind_figure(given, cageform::MeanValueCoordinates<float, 3>(mesh), *figure, *cage);
}

} // namespace

int main(int argc, char** argv) {
    return guarded("bind_mesh", [&] { return run_program(argc, argv); });
}
