#include "cli/wrap_choice.hpp"

#include "cli/auto_cage.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/progress_bar.hpp"
#include "cli/skeleton_choice.hpp"
#include "files/obj_file.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"
#include "io/messages.hpp"

#include <cageform/fit/wrap.hpp>
#include <cageform/parallel/threads.hpp>

#include <algorithm>

namespace cageform_support {

namespace {

using cageform::Status;

/// Throws the failure of a search, with its culprit.
[[noreturn]] void fail_search(const WrapFigures& figures, const WrapMap& map) {
    const auto& report = map.report;
    const std::string why = cageform::to_string(report.status);
    if (map.coordinates && map.coordinates->cage_report().status == report.status) {
        cageform::BindReport faults;
        faults.status = report.status;
        faults.cage = map.coordinates->cage_report();
        throw Failure(describe_mesh_faults(map.cage.name, faults));
    }
    if (report.status == Status::too_many_handles)
        throw Failure(figures.source.name + ": is far larger than " + figures.target.name +
                      (map.keeps_place ? ": leave out --no-align" : ", or a landmark is far away"));
    if (report.status == Status::value_not_finite && report.culprit < figures.landmarks.names.size())
        throw Failure(figures.landmarks.name(report.culprit) + ": too far from the figures");
    const MeshFile& file = report.of_target ? figures.target : figures.source;
    const WeldedMesh& mesh = report.of_target ? figures.target_surface : figures.source_surface;
    const bool is_vertex = report.status == Status::figure_not_finite && report.culprit < mesh.first.size();
    throw Failure(file.name + ": " +
                  (is_vertex ? "v " + std::to_string(mesh.first[report.culprit] + 1) + ": " : "") + why);
}

/// Warns of points that the coordinates of a cage do not move.
void warn_of_outside(const WrapMap& map, const WrapFigures& figures) {
    const auto& coordinates = *map.coordinates;
    if (coordinates.has_extension()) return;
    std::vector<Point3> all = figures.source_surface.places;
    all.insert(all.end(), figures.follow.begin(), figures.follow.end());
    const auto outside = coordinates.bind(all).report.outside;
    if (outside.empty()) return;
    warn(map.cage.name + ": " + std::to_string(outside.size()) + " of " + std::to_string(all.size()) +
         " vertices of the source and its followers lie outside, first " +
         name_points(std::span(&all[outside[0]], 1), {0}) +
         "; the coordinates are not defined there, and these vertices do not follow: enlarge the cage, or "
         "use --coordinates mean-value");
}

} // namespace

std::string parse_file_pair(std::string_view word, std::string& in, std::string& out) {
    const std::size_t colon = word.find(':');
    if (colon == word.npos || colon == 0 || colon + 1 == word.size() ||
        word.find(':', colon + 1) != word.npos)
        return detail::quoted(word) + " is not IN:OUT, such as dress.obj:dress_on_target.obj";
    in = word.substr(0, colon);
    out = word.substr(colon + 1);
    return {};
}

void LandmarkChoice::add_options(CommandLine& line) {
    line.add_text(
            "--landmark", [this](const std::string& word) { given.emplace_back(word, false); },
            "a point of the source and its place on the target, SOURCE:TARGET. Each is x,y,z or the number "
            "of a vertex, from 0: 881:0,4.37,0.3. May be given several times")
        .in_order();
    line.add_text(
            "--landmarks", [this](const std::string& path) { given.emplace_back(path, true); },
            "a CSV file of landmarks, one per line: VERTEX,x,y,z or x,y,z,x,y,z or VERTEX,VERTEX; or two "
            "files of points, SOURCE.csv:TARGET.csv")
        .in_order();
}

Expected<Landmarks> LandmarkChoice::read(const LandmarkVertices& vertices) const {
    Landmarks landmarks;
    for (const auto& [word, is_file] : given) {
        std::string why, of_source, of_target;
        if (!is_file) {
            why = parse_landmark(word, vertices, landmarks);
        } else if (parse_file_pair(word, of_source, of_target).empty()) {
            const auto from = load_point_table(of_source), to = load_point_table(of_target);
            if (!from) return from.error();
            if (!to) return to.error();
            why = add_landmarks(*from, *to, landmarks);
        } else {
            const auto text = read_text(word);
            if (!text) return text.error();
            why = parse_landmarks(*text, word, vertices, landmarks);
        }
        if (!why.empty()) return FileError{why};
    }
    return landmarks;
}

void WrapMap::move(std::span<const Point3> points, std::span<Point3> moved, std::span<Jacobian3> jacobians,
                   const std::string& name) const {
    const cageform::Running running{.parallel = cageform::ThreadedFor{}};
    const Status status = coordinates ? cageform::move(wrap, *coordinates, points, moved, jacobians, running)
                                      : cageform::move(wrap, points, moved, jacobians, running);
    if (status != Status::ok) throw Failure(name + ": " + cageform::to_string(status));
    const auto is_endless = [](const Point3& p) { return !cageform::is_finite(p); };
    if (std::any_of(moved.begin(), moved.end(), is_endless))
        throw Failure(name + ": a point is not finite on the target");
}

std::string WrapMap::saved_pose() const {
    std::vector<Point3> vertices = cage.vertices;
    std::copy_n(wrap.pose.begin(), std::min(vertices.size(), wrap.pose.size()), vertices.begin());
    return to_text(cage, vertices);
}

void WrapChoice::add_options(CommandLine& line) {
    const auto share_fault = [](const std::string& word) {
        constexpr double most = 0.1;
        double share = 0;
        const std::string why = parse_share(word, share);
        if (!why.empty() || (share <= most && word.ends_with('%'))) return why;
        return detail::quoted(word) + " is not a percentage of the height up to 10%, such as 0.05%";
    };
    line.add_text(
            "--push-out", [this](const std::string& word) { (void)parse_share(word, push_out.emplace()); },
            "move vertices of followers that are inside the target out to its surface plus this share of its "
            "height, such as 0.05%")
        .check(share_fault);
    landmarks.add_options(line);
    line.add("--cage", cage,
             std::string("wrap by a pose of this cage: a closed mesh about the source, faces "
                         "counter-clockwise seen from outside") +
                 auto_cage_help + "; by default a lattice is used, which fits more closely");
    line.add("--save-pose", save_pose,
             "also write the pose of the cage to an OBJ file that other programs read with --pose")
        .ends_with({".obj"});
    line.add_text(
            "--lattice",
            [this](const std::string& word) {
                names_finest = true;
                (void)detail::parse_whole(word, finest);
            },
            "the cells of the finest lattice along the target's height: 6, 12 or 24; with --cage, "
            "the lattice follows the cage, and 0 uses none")
        .one_of({"0", "6", "12", "24"})
        .show_default("24; with --cage 0");
    line.add_flag("--stiff", is_stiff, "bend less: for scans whose noise is correlated");
    line.add_flag("--refine-contacts", refines_contacts,
                  "halve the cells of the finest lattice where the source is not on the target, as at thighs "
                  "that touch; may take twice the time");
    line.add_flag("--no-align", keeps_place,
                  "the source already lies on the target: do not scale and shift it first");
    line.add_flag("--other-pose", other_pose,
                  "source and target have different poses: first fit the landmarks, then the surfaces");
    add_share(line, "--residual", residual,
              "stop when 95 % of the source is nearer to the target than this share of its height, such as "
              "0.1%; 0: do not stop early")
        .show_default("0");
    coordinates.in_space = coordinates.with_normals = true;
    coordinates.add_options(line);
}

std::string WrapChoice::fault() const {
    if (cage.empty() && coordinates.is_named) return "--coordinates is for --cage: give a cage too";
    if (cage.empty() && !save_pose.empty()) return "--save-pose is for --cage: give a cage too";
    if (cage.empty() && names_finest && finest == 0) return "--lattice 0 is for --cage: give a cage too";
    if (!cage.empty() && refines_contacts) return "--refine-contacts is for a lattice: leave out --cage";
    if (other_pose && landmarks.given.empty())
        return "--other-pose needs landmarks: give --landmark or --landmarks";
    if (!save_pose.empty() && coordinates.takes_normals())
        return "--save-pose: with " + coordinates.name +
               " the pose has more than vertices; use mean-value or harmonic";
    return {};
}

WrapMap WrapChoice::solve(const WrapFigures& figures) const {
    const cageform::SurfaceMesh source(figures.source_surface.places, figures.source_surface.triangles),
        target(figures.target_surface.places, figures.target_surface.triangles);
    cageform::WrapOptions options;
    options.landmarks = figures.landmarks.marks;
    options.follow = figures.follow;
    options.align = !keeps_place;
    options.other_pose = other_pose;
    options.refine_contacts = refines_contacts;
    options.finest = unsigned(cage.empty() || names_finest ? finest : 0);
    options.least_stiffness = is_stiff ? 1e-5 : options.least_stiffness;
    options.residual = residual;

    WrapMap map;
    map.keeps_place = keeps_place;
    if (!cage.empty()) {
        map.cage = load_or_make_cage(cage, figures.enclosed);
        map.coordinates = make_coordinates<double>(coordinates, map.cage);
        print_notes(map.cage.name, map.coordinates->cage_report(), map.coordinates->note);
        if (!map.coordinates->has_gradients())
            throw Failure("--coordinates " + coordinates.name + " have no gradients, which a wrap needs");
        warn_of_outside(map, figures);
    }
    ProgressBar bar("wrapping");
    const cageform::Running running{.parallel = cageform::ThreadedFor{}, .progress = bar.callback()};
    auto found = map.coordinates ? cageform::wrap(*map.coordinates, source, target, options, running)
                                 : cageform::wrap(source, target, options, running);
    map.wrap = std::move(found.value);
    map.report = std::move(found.report);
    const Status status = map.report.status;
    if (status != Status::ok && status != Status::fit_not_reached) fail_search(figures, map);
    return map;
}

} // namespace cageform_support
