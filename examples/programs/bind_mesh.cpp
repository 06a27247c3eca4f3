// Binds a figure to a cage and packs the data for a game into one file: points, normals, triangles, a
// motion of the cage. Formats: cageform/figure/figure.hpp, support/files/figure_parts.hpp.
//
//     bind_mesh character.obj --cage character_cage.obj --clip character_clip.csv --max-distance 0.001
//               -o character.figure
//
// --max-distance is the largest error of a vertex in all poses of the motion, relative to the figure's size.
// The file is the smallest within this bound. Without a motion the bound holds for all poses within a tenth
// of the cage's size of an affine motion. Green coordinates need a motion, because rotations of their faces
// have no bound.
//
// --pose-samples also packs the data of a PoseSolver: the game can then pose the figure by pins.
//
// integrations/ogre/ogre_client.cpp maps and plays such a file.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/motion_choice.hpp"
#include "cli/progress_bar.hpp"
#include "cli/weight_choice.hpp"
#include "files/bind_report.hpp"
#include "files/clip_file.hpp"
#include "files/figure_parts.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/binding/pose_samples.hpp>

#include <filesystem>
#include <iomanip>
#include <iostream>
#include <sstream>

namespace {

using namespace cageform_support;
using cageform::Status;

struct Arguments {
    std::string figure, cage, labels, out;
    MotionChoice moves;
    WeightChoice weights; // distance relative to the figure's size
    bool pose_samples = false, no_file_normals = false, is_strict = false;
    bool report = false;
    OutsideChoice outside;
    CoordinatesChoice choice;

    /// Whether the output stores the normals of the file.
    bool keeps_normals(const MeshFile& figure_file) const {
        return !figure_file.normals.empty() && !no_file_normals;
    }
};

/// Area-weighted vertex normals, of unit length or zero.
std::vector<Point3> normals_of(const MeshFile& figure) {
    const auto& p = figure.vertices;
    std::vector<Point3> normals(p.size());
    for (const auto& [a, b, c] : figure.triangles) {
        for (const auto i : {a, b, c}) normals[i] = normals[i] + cross(p[b] - p[a], p[c] - p[a]);
    }
    for (Point3& n : normals) {
        if (const double length = std::hypot(n[0], n[1], n[2]); length > 0) n = (1 / length) * n;
    }
    return normals;
}

/// The motion, packed exactly and periodic. Fails if it exceeds single precision.
cageform::PackedClip<float, 3> packed_clip(const PoseClip& clip) {
    std::vector<cageform::PiecewiseCubic<float>> curves;
    std::vector<double> values(clip.keys.size());
    for (std::size_t n = 0; n < 3 * clip.keys[0].places.size(); ++n) {
        for (std::size_t k = 0; k < values.size(); ++k) values[k] = clip.keys[k].places[n / 3][n % 3];
        std::vector<cageform::CubicPiece<float>> pieces;
        const auto curve = curve_through(clip, values);
        for (const auto& [begin, c0, c1, c2, c3] : curve.pieces()) {
            pieces.push_back({float(begin), float(c0), float(c1), float(c2), float(c3)});
            for (const double number : {c0, c1, c2, c3}) {
                if (std::isfinite(float(number))) continue;
                throw Failure(clip.name + ": v " + std::to_string(n / 3 + 1) + " moves too fast after " +
                              std::to_string(begin) + " s: single precision cannot represent its curve");
            }
        }
        curves.emplace_back(std::move(pieces), float(clip.length));
    }
    constexpr auto cycle = cageform::Extrapolation::cycle;
    return cageform::PackedClip<float, 3>(cageform::CageClip<float, 3>(curves, cycle, cycle).view());
}

constexpr double of_vectors =
    10; ///< tolerance of unit vectors, relative to that of points (FigurePackOptions::tangent_tolerance)

/// Describes the error of a packing, and warns if it is large.
std::string describe_loss(const MeshFile& figure, const cageform::PackReport& report,
                          const SampledPoses& poses, bool is_vector, bool has_faces) {
    PackingLoss loss;
    loss.largest = report.distance.value;
    loss.mean = report.mean_distance;
    loss.vertex = report.distance.point;
    loss.size = is_vector ? 1 : report.size;
    if (is_vector) loss.size_of = "the length of vectors that carry normals";
    loss.poses = report.poses;
    loss.reach = report.reach;
    loss.has_vectors = has_faces;
    if (report.distance_pose < poses.times.size()) loss.time = poses.times[report.distance_pose];
    const std::string text = describe(loss);
    if (loss.share() > PackingLoss::worth_a_warning * (is_vector ? of_vectors : 1))
        warn(figure.name + ": the packed figure is off by " + text + "; --max-distance bounds this" +
             (report.poses == 0 && has_faces ? " over a motion" : ""));
    return text;
}

/// Samples the inside of the cage for pins and packs the samples. Prints their size if `tells`.
cageform::PackedPoseSamples packed_samples(const ChosenCoordinates<float, 3>& coordinates,
                                           const std::string& cage, bool tells) {
    ProgressBar bar("sampling");
    const auto [samples, report] = pose_samples(coordinates, {}, {.progress = bar.callback()});
    if (report.status != Status::ok)
        throw Failure(cage + ": --pose-samples: " + cageform::to_string(report.status));
    auto packed = cageform::pack(samples);
    if (!packed) throw Failure(cage + ": --pose-samples: " + cageform::to_string(packed.status()));
    if (tells) {
        std::cout << "samples for pins: " << packed.value.bytes().size() << " bytes, of " << report.samples
                  << " points in " << report.rotations << " clusters, " << report.seconds << " s\n";
    }
    return std::move(packed.value);
}

/// Binds and packs the normals of the mesh, with the tolerance of tangents.
cageform::PackedBinding<float, 3> packed_normals(const ChosenCoordinates<float, 3>& coordinates,
                                                 const std::vector<Point3>& places, const MeshFile& figure,
                                                 const Arguments& given, cageform::PackOptions options) {
    const std::vector<Point3> normals = normals_of(figure);
    ProgressBar bar("binding normals");
    const auto bound =
        cageform::bind_vectors(coordinates, places, std::array{std::span<const Point3>(normals)},
                               given.outside.bind_options(coordinates), {.progress = bar.callback()});
    if (!bound) throw Failure(figure.name + ": normals: " + cageform::to_string(bound.report.status));
    options.tolerance = std::min(1.0, of_vectors * given.weights.distance);
    auto packed = cageform::pack(bound.value[0], options);
    if (!packed) throw Failure(figure.name + ": normals: " + cageform::to_string(packed.report.status));
    return std::move(packed.value);
}

/// A motion of the cage: its clip, the packed clip, and the poses that --max-distance tests.
struct Motion {
    PoseClip clip;
    cageform::PackedClip<float, 3> packed;
    SampledPoses poses;
};

Motion motion_of(const Arguments& given, const MeshFile& cage) {
    Motion motion{given.moves.motion(cage), {}, {}};
    if (motion.clip.keys.empty()) return motion;
    for (PoseKey& key : motion.clip.keys) key.places = relative_to(given.outside.origin, key.places);
    motion.packed = packed_clip(motion.clip);
    motion.poses = sample_poses(motion.clip);
    return motion;
}

/// Binds points and normals, and prints warnings. `labels` are those of the cage's vertices, or empty.
cageform::FigureBinding<float, 3> bound_figure(const Arguments& given, const MeshFile& figure,
                                               const MeshFile& cage,
                                               const ChosenCoordinates<float, 3>& coordinates,
                                               const std::vector<Point3>& places,
                                               const std::vector<std::string>& labels) {
    const std::vector<Point3> normals = normals_of(figure);
    cageform::Result<cageform::FigureBinding<float, 3>, cageform::FigureBindReport> bound;
    {
        ProgressBar bar("binding");
        const cageform::Running running{.progress = bar.callback()};
        const bool binds_twice = given.keeps_normals(figure);
        if (binds_twice) (void)coordinates.solve(running.subtask(0, 0.5)); // once for both binds
        bound =
            coordinates.bind(cageform::FigurePoints{places, normals}, given.outside.bind_options(coordinates),
                             running.subtask(binds_twice ? 0.5 : 0, 1));
    }
    const cageform::BindReport& of_points = bound.report.points;
    if (!bound) {
        const bool fault_of_points = of_points.status != Status::ok;
        throw Failure(describe_mesh_faults(cage.name, fault_of_points ? of_points : bound.report.vectors));
    }
    warn_of_coarse_grid(cage.name, of_points.solver);
    given.outside.check(coordinates, of_points, figure.vertices, figure.name, cage.name);
    if (const auto& still = bound.report.vectors.unreached; !still.empty()) {
        warn(figure.name + ": no pose turns the normals of " + std::to_string(still.size()) +
             " vertices, first " + name_points(figure.vertices, still));
    }
    if (!labels.empty()) {
        auto of_handles = labels; // faces have none
        of_handles.resize(bound.value.points.handle_count());
        const Status status = bound.value.set_labels(of_handles);
        if (status != Status::ok) throw Failure(given.labels + ": " + cageform::to_string(status));
    }
    return std::move(bound.value);
}

/// Prints the report of a packed figure, and returns its error; empty if there is none.
std::string judge_packing(const Arguments& given, const MeshFile& figure,
                          const cageform::FigurePackReport& report, const SampledPoses& poses) {
    const std::pair<const char*, const cageform::PackReport&> reports[] = {
        {"points", report.points}, {"tangents", report.vectors[0]}, {"bitangents", report.vectors[1]}};
    for (const auto& [name, part] : reports) {
        const bool is_vector = &part != &report.points;
        if (part.status == Status::format_too_coarse) {
            std::ostringstream least;
            least << std::setprecision(3) << part.distance.value / (is_vector ? of_vectors : size_of(figure));
            return figure.name + ": " + cageform::to_string(part.status) + ", " + least.str() +
                   " is the smallest possible: raise --max-distance or choose another --format";
        }
        if (part.status != Status::ok) return cageform::to_string(part.status);
        const std::string loss = describe_loss(figure, part, poses, is_vector, given.choice.takes_normals());
        if (!given.report) continue;
        std::cout << name << ": " << part.bytes << " of " << part.dense_bytes << " bytes, "
                  << name_of(part.format) << ", " << part.weights_per_point << " weights per point\n  off by "
                  << loss << "\n  sum of changes of a point's weights at most " << part.error.value
                  << ", mean " << part.mean_error << '\n';
    }
    return report.status == Status::ok ? "" : cageform::to_string(report.status);
}

/// Binds, packs and writes. `labels` are those of the cage's vertices, or empty.
int bind_figure(const Arguments& given, const MeshFile& figure, const MeshFile& cage_of_file,
                const std::vector<std::string>& labels) {
    fail_if(fault_of_outputs({given.out}));
    const Point3& origin = given.outside.origin;
    const std::vector<Point3> places = relative_to(origin, joined_places(figure));
    MeshFile cage = cage_of_file;
    cage.vertices = relative_to(origin, cage.vertices);
    if (cage.lattice) cage.lattice->frame.translation = cage.lattice->frame.translation - origin;
    const auto coordinates = make_coordinates<float>(given.choice, cage);
    print_notes(cage.name, coordinates.cage_report(), coordinates.note);
    const Motion motion = motion_of(given, cage_of_file);
    const auto bound = bound_figure(given, figure, cage, coordinates, places, labels);
    if (const std::string pose = first_mirror(figure, bound.points, motion.clip); !pose.empty())
        warn(pose + ": the pose mirrors " + figure.name + "; clone_figure --flip-faces reverses its faces");
    cageform::FigurePackOptions options;
    options.weights.format = given.weights.format;
    options.weights.largest = given.weights.largest;
    const auto posed = poses_of_handles(bound.points, motion.clip, motion.poses);
    options.weights.poses = posed;
    options.weights.tolerance = given.weights.distance * size_of(figure);
    const std::string clip_name = std::filesystem::path(motion.clip.name).stem().string();
    const cageform::FigureClipData clips[] = {{clip_name, motion.packed.bytes()}};
    if (!motion.packed.bytes().empty()) options.clips = clips;
    cageform::PackedPoseSamples samples;
    if (given.pose_samples) samples = packed_samples(coordinates, cage.name, given.report);
    cageform::PackedBinding<float, 3> across;
    if (given.keeps_normals(figure))
        across = packed_normals(coordinates, places, figure, given, options.weights);
    std::span<const std::byte> place;
    if (origin != Point3{}) {
        place = std::as_bytes(std::span(origin.v));
        note(given.out + ": the figure, its cage and its clip are stored relative to " +
             detail::short_number(origin[0]) + ", " + detail::short_number(origin[1]) + ", " +
             detail::short_number(origin[2]) + ", for single precision; clone_figure adds this origin");
    }
    const cageform::FigurePartData parts[] = {{"TRIS", std::as_bytes(std::span(figure.triangles))},
                                              {"PINS", samples.bytes()},
                                              {"NRM1", across.bytes()},
                                              {"ORIG", place}};
    options.parts = parts;
    cageform::Result<cageform::PackedFigure<float, 3>, cageform::FigurePackReport> made;
    {
        ProgressBar bar("packing");
        made = cageform::pack(bound, options, {.progress = bar.callback()});
    }
    const auto& [packed, report] = made;
    fail_if(judge_packing(given, figure, report, motion.poses));
    const std::string others = describe_others(figure, {"v", "vn", "f"});
    if (given.report && !others.empty()) std::cout << "not stored: " << others << '\n';
    if (given.report && !labels.empty()) {
        std::cout << "labels: of "
                  << labels.size() - std::size_t(std::count(labels.begin(), labels.end(), "")) << " of "
                  << labels.size() << " vertices of the cage\n";
    }
    AtomicFile out(given.out);
    out.write({reinterpret_cast<const char*>(packed.bytes().data()), packed.bytes().size()});
    fail_if(out.commit());
    return 0;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Binds a figure to a cage and packs the data that a game needs into one file.");
    line.set_examples({"character.obj --cage auto:112 -o character.figure",
                       "character.obj --cage character_cage.obj --clip character_clip.csv --max-distance "
                       "0.001 -o character.figure"});
    Arguments given;
    line.add("figure", given.figure, "the mesh to bind").required();
    add_cage(line, given.cage, CageFiles::mesh);
    given.moves.add_options(line);
    line.add("--labels", given.labels,
             "a text file with names of the cage's vertices, which the output stores");
    line.add("-o,--output", given.out, "the file to write").required().ends_with({".figure"});
    given.choice.with_normals = given.choice.in_space = true;
    given.choice.add_options(line);
    given.outside.add_options(line);
    given.weights.add_options(line, "the figure's size", " unit normals may change by ten times as much;",
                              "float; with --max-distance, the smallest that suffices");
    line.add_flag("--pose-samples", given.pose_samples,
                  "also pack samples of the cage's inside, for poses by pins in a game");
    line.add_flag(
        "--no-file-normals", given.no_file_normals,
        "do not store the normals of the mesh: fewer bytes; clone_figure then computes normals from "
        "the faces");
    add_strict(line, given.is_strict);
    line.add_flag("--report", given.report, "print sizes and errors");
    line.set_footer(mesh_formats + std::string("\n") + lattice_format + "\n" + pose_clip_format + "\n" +
                    pose_operations_format + "\n" + labels_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    given.moves.order_poses();
    fail_if(given.outside.fault());
    if (given.choice.name == "barycentric")
        return fail("--coordinates barycentric: normals need mean-value, harmonic or green");
    fail_if(given.weights.fault(given.choice, given.moves.is_given()));

    const auto figure = load_mesh_figure(given.figure, given.is_strict);
    if (figure.faces.empty())
        return fail(figure.name + ": has no faces, so no normals; bind_tiles binds points without faces");
    const auto cage = load_or_make_cage(given.cage, figure);
    for (const auto* file : {&figure, &cage}) {
        fail_if(single_precision_fault(*file));
    }
    std::vector<std::string> labels;
    if (!given.labels.empty()) {
        labels = value_or_fail(read_labels(given.labels, cage.vertices.size()));
    }
    given.outside.origin = far_origin(figure);
    return bind_figure(given, figure, cage, labels);
}
