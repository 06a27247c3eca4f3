#include "cli/mesh_control.hpp"

#include "cli/auto_cage.hpp"
#include "cli/mesh_cage.hpp"
#include "files/bind_report.hpp"
#include "files/obj_file.hpp"
#include "io/messages.hpp"

#include <algorithm>
#include <utility>

namespace cageform_support {

namespace {

/// Poses the vertices by pins, if there are any. Vertices of --hold do not move.
///
///   still   vertices that no pose moves
void pin_pose(MeshControl& to, const MeshControlChoice& given, std::span<const Point3> places,
              const std::vector<std::size_t>& still) {
    if (!given.pins.is_given()) return;
    auto pins = value_or_fail(given.pins.pins<3>(places));
    const std::span<const Point3> rest(to.cage.vertices);
    const auto parts = cage_parts(to.cage);
    auto held = given.pins.held_handles(rest.first(to.saved), still, &parts);
    const std::string kind = to.cage.lattice ? "lattice" : given.choice.name;
    auto pinned = value_or_fail(
        PinnedCage<double, 3>::make(to.coordinates, {to.cage.name, kind, to.describe_faults},
                                    {std::move(pins), std::move(held)}, given.pins, given.outside));
    auto pose = pinned.rest();
    std::copy(to.pose.vertices.begin(), to.pose.vertices.end(), pose.begin());
    if (const auto started = pinned.start(pose); !started)
        throw Failure(to.pose.name + ": " + to_string(started.error()));
    value_or_fail(pinned.settle(pinned.targets(), pinned.turns(), pose));
    to.on_pins = pinned.report();
    warn(pinned.warning());
    std::copy(pose.begin(), pose.begin() + std::ptrdiff_t(to.pose.vertices.size()), to.pose.vertices.begin());
    if (to.coordinates.handles().vector_count() > 0) to.handles = std::move(pose);
}

MeshControl read_sites(const MeshControlChoice& given, std::span<const Point3> places) {
    if (given.pose.empty() && !given.pins.is_given()) throw Failure("--pose is required for points");
    if (given.pins.is_given() && !given.of_sites.weights.empty())
        throw Failure("--weights: pins do not support points with weights");
    const std::string& path = given.pose.empty() ? given.cage : given.pose;
    auto posed =
        load_posed_sites<3>(given.cage, path, given.of_sites, [&]() -> Expected<std::vector<Point3>> {
            return std::vector<Point3>(places.begin(), places.end());
        });
    auto& [sites, pose, weights] = posed;
    MeshControl control{make_coordinates<double>(given.choice, sites), {}, {}, std::move(weights), {}};
    control.cage.name = given.cage;
    control.cage.vertices = sites.points;
    control.pose.name = path;
    control.pose.vertices = std::move(pose.points);
    constexpr std::size_t corners = 8; // of the box that --surround adds
    control.saved = sites.points.size() - (given.of_sites.surround > 0 ? corners : 0);
    std::vector<std::size_t> still;
    for (std::size_t i = control.saved; i < sites.points.size(); ++i) still.push_back(i);
    control.describe_faults = [known = std::move(sites)](const cageform::BindReport& report) {
        return describe_site_faults(known, report);
    };
    pin_pose(control, given, places, still);
    return control;
}

/// The pose from a file or operations; if neither is given, the rest pose if there are pins, else
/// first_pose() for generated cages.
///
///   held   vertices that no pose moves
MeshFile read_pose(const MeshControlChoice& given, const MeshFile& cage,
                   const std::vector<std::size_t>& held) {
    const bool operated = !given.operations.operations.empty();
    if (!given.pose.empty() && operated)
        throw Failure("give --pose or operations such as --turn, but not both");
    const auto put_back = [&](MeshFile pose) {
        for (const std::size_t i : held) pose.vertices[i] = cage.vertices[i];
        return pose;
    };
    if (!given.pose.empty()) {
        return put_back(value_or_fail(load_mesh_pose(given.pose, cage)));
    }
    if (!operated && given.pins.is_given()) return cage;
    if (!operated && !CageChoice::of(given.cage).is_auto)
        throw Failure("--pose is required, or operations such as --turn, or --pin");
    MeshFile pose = cage;
    if (operated) {
        const auto parts = cage_parts(cage);
        pose.vertices = given.operations.posed(cage.vertices, cage.lattice, nullptr, &parts);
    } else {
        pose.vertices = first_pose(cage.vertices);
    }
    return put_back(std::move(pose));
}

} // namespace

MeshControl read_mesh_control(const MeshControlChoice& given, const MeshFile& figure,
                              std::span<const Point3> places) {
    if (given.choice.takes_sites()) return read_sites(given, places);
    auto cage = load_or_make_cage(given.cage, figure);
    const auto still = given.operations.still(cage.lattice);
    auto pose = read_pose(given, cage, still);
    auto coordinates = make_coordinates<double>(given.choice, cage);
    const std::string name = cage.name;
    MeshControl control{
        std::move(coordinates),
        std::move(cage),
        std::move(pose),
        {},
        [name](const cageform::BindReport& report) { return describe_mesh_faults(name, report); }};
    control.saved = control.cage.lattice ? control.cage.lattice->points() : control.cage.vertices.size();
    pin_pose(control, given, places, still);
    return control;
}

std::string MeshControl::saved_pose() const {
    if (!coordinates.takes_sites) return to_text(cage, pose.vertices);
    std::string text;
    for (std::size_t i = 0; i < saved; ++i) {
        text += 'v';
        for (const double x : pose.vertices[i].v) text += ' ' + detail::digits_of(x);
        text += '\n';
    }
    return text;
}

void MeshControlChoice::add_options(CommandLine& line) {
    add_cage(line, cage, CageFiles::mesh_or_sites);
    line.add("--pose", pose,
             "the pose: the same mesh or points with vertices moved; or give operations such as --turn; with "
             "--cage auto and none of these, half the figure bends");
    operations.add_options(line);
    pins.add_options(line);
    line.add("--save-pose", save_pose, "also write the posed vertices to an OBJ file that --pose reads")
        .ends_with({".obj"});
    outside.with_sites = choice.with_sites = choice.with_normals = true;
    choice.in_space = true;
}

std::string MeshControlChoice::fault() const {
    for (const std::string& why : {of_sites.fault(choice), outside.fault(), pins.fault(has_pose())}) {
        if (!why.empty()) return why;
    }
    return {};
}

std::string MeshControlChoice::save_fault(const MeshControl& control) const {
    if (save_pose.empty() || control.handles.empty()) return {};
    return "--save-pose " + save_pose + ": with " + choice.name +
           " pins move faces as well as vertices, but a saved pose has only vertices; use mean-value or "
           "harmonic";
}

} // namespace cageform_support
