// Makes a sample figure: a puppet in T-pose, a cage of 112 vertices, a pose and a dance of the cage.
//
//     make_character out -o character.glb
//
// writes out/character.obj, out/character_cage.obj, out/character_pose.obj, out/character_clip.csv, a
// periodic dance of the cage (support/files/clip_file.hpp), and out/character.bones.csv, a skeleton that
// bends an arm (skin_mesh). character.glb is the same puppet as a game character: glTF 2.0 with joints,
// materials, textures, morph targets and two animations (character/character_gltf.hpp). Either output is
// optional. The puppet is a smooth union of rounded bodies, meshed by surface nets
// (support/pictures/surface_nets.hpp). The ground is y = 0, y is up, and the puppet faces along z.
//
//     make_character out --girth 1.5 --child 0.4 --followers
//
// writes the files of a puppet with another body in the same T-pose (character/puppet.hpp). --followers also
// writes out/character_tights.obj, out/character_skirt.obj and out/character.landmarks.csv: what follows a
// body that is laid on another.

#include "character/character_gltf.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "files/clip_file.hpp"
#include "files/gltf_skeleton.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"
#include "pictures/plot.hpp"

#include <cageform/cage/triangle_mesh.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

namespace {

using Point = cageform::Vec<double, 3>;

using Mesh = cageform_support::ImplicitMesh;
using cageform_programs::puppet;
using cageform_programs::PuppetShape;
using cageform_programs::ramp;
using cageform_support::fail;
using cageform_support::length;

// ---- the cage: a sheet of cells around the outline, with a front and a back ----

/// A point of the sheet on the puppet's left; the right side is mirrored.
struct SheetPoint {
    int column; // outwards from the middle, from 1
    int row;    // upwards from the ground
    double x, y, front, back;
};
constexpr std::array<SheetPoint, 28> sheet{{
    {1, 0, 0.088, -0.03, 0.255, -0.135}, {2, 0, 0.3, -0.03, 0.255, -0.135},  // sole
    {1, 1, 0.09, 0.155, 0.245, -0.13},   {2, 1, 0.295, 0.155, 0.245, -0.13}, // ankle
    {1, 2, 0.078, 0.38, 0.115, -0.12},   {2, 2, 0.282, 0.38, 0.115, -0.12},  // under the knee
    {1, 3, 0.066, 0.54, 0.12, -0.12},    {2, 3, 0.285, 0.54, 0.12, -0.12},   // above the knee
    {1, 4, 0.035, 0.71, 0.15, -0.155},   {2, 4, 0.285, 0.71, 0.13, -0.14},   // crotch
    {1, 5, 0.09, 1, 0.225, -0.17},       {2, 5, 0.265, 1, 0.165, -0.14},     // waist
    {1, 6, 0.1, 1.215, 0.2, -0.16},      {2, 6, 0.265, 1.215, 0.14, -0.125}, // armpit
    {1, 7, 0.11, 1.45, 0.14, -0.14},     {2, 7, 0.27, 1.435, 0.11, -0.11},   // shoulder
    {3, 6, 0.385, 1.225, 0.1, -0.1},     {3, 7, 0.385, 1.425, 0.1, -0.1},    // upper arm
    {4, 6, 0.49, 1.235, 0.095, -0.095},  {4, 7, 0.49, 1.415, 0.095, -0.095}, // inside of the elbow
    {5, 6, 0.6, 1.24, 0.09, -0.09},      {5, 7, 0.6, 1.41, 0.09, -0.09},     // outside of the elbow
    {6, 6, 0.79, 1.25, 0.14, -0.095},    {6, 7, 0.79, 1.4, 0.14, -0.095},    // wrist
    {7, 6, 1.025, 1.255, 0.15, -0.095},  {7, 7, 1.025, 1.395, 0.15, -0.095}, // finger tips
    {1, 8, 0.235, 1.5, 0.235, -0.195},   {1, 9, 0.225, 1.935, 0.22, -0.195}, // chin, crown
}};

struct Cage {
    Mesh mesh;
    std::vector<SheetPoint> origin; // of every vertex; x and column are negative on the right
    PuppetShape shape;
};

Cage make_cage(const PuppetShape& shape) {
    Cage cage{{}, {}, shape};
    std::map<std::pair<int, int>, std::uint32_t>
        front; // by column and row; the back vertex has the next index
    for (const int side : {1, -1}) {
        for (SheetPoint p : sheet) {
            p.column *= side;
            p.x *= side;
            front[{p.column, p.row}] = std::uint32_t(cage.mesh.vertices.size());
            for (const double z : {p.front, p.back})
                cage.mesh.vertices.push_back(shaped({p.x, p.y, z}, shape));
            cage.origin.insert(cage.origin.end(), 2, p);
        }
    }
    // Two triangles; diagonals are chosen so that both sides of the figure mirror each other.
    const auto add = [&](std::array<std::uint32_t, 4> quad, bool other) {
        const std::size_t first = other ? 1 : 0;
        for (const std::size_t k : {first + 1, first + 2})
            cage.mesh.faces.push_back({quad[first], quad[k % 4], quad[(k + 1) % 4]});
    };
    std::set<std::pair<std::uint32_t, std::uint32_t>> ways; // directed edges of cells, counter-clockwise
    for (const auto& [at, corner] : front) {
        const auto [column, row] = at;
        const int next = column == -1 ? 1 : column + 1;
        const auto right = front.find({next, row}), upper = front.find({column, row + 1}),
                   across = front.find({next, row + 1});
        if (right == front.end() || upper == front.end() || across == front.end()) continue;
        if (column == -1 && row < 4) continue; // between the legs
        const std::array<std::uint32_t, 4> cell{corner, right->second, across->second, upper->second};
        add(cell, column > 0);
        add({cell[3] + 1, cell[2] + 1, cell[1] + 1, cell[0] + 1}, column > 0);
        for (std::size_t k = 0; k < 4; ++k) ways.insert({cell[k], cell[(k + 1) % 4]});
    }
    for (const auto& [from, to] : ways) {
        if (!ways.contains({to, from})) add({to, from, from + 1, to + 1}, cage.origin[from].x > 0);
    }
    return cage;
}

// ---- the pose: a joint turns everything beyond it ----

Point rotated(const Point& p, const Point& centre, std::size_t axis, double degrees) {
    const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    Point q = p;
    q[u] = centre[u] + c * (p[u] - centre[u]) - s * (p[v] - centre[v]);
    q[v] = centre[v] + s * (p[u] - centre[u]) + c * (p[v] - centre[v]);
    return q;
}

/// Rotations of joints in degrees; of pairs, the left one first.
struct Joints {
    struct Arm {
        double shoulder, elbow; // up, about z
        double forward;         // of the forearm, about y
    };
    struct Leg {
        double hip, knee; // about x: negative is forward, positive back
        double aside;     // of the hip, about z: positive to the figure's left
    };
    std::array<Arm, 2> arms;
    std::array<Leg, 2> legs;
    std::array<double, 2> head;  // about y, about z
    std::array<double, 3> chest; // about y, x, z
    Point shift{};               // of the whole figure
};

/// A pose that waves and steps.
constexpr Joints waving{
    {{{30, 66, 0}, {50, -10, 45}}}, {{{5, 6, 4}, {-66, 80, 0}}}, {24, 9}, {14, 5, -7}, {}};

/// The posed position of a cage vertex. Near a joint a vertex rotates by a fraction of the angle, so the cage
/// bends smoothly. Outer joints are applied first, then inner joints.
Point posed(const Point& rest, const SheetPoint& origin, const Joints& joints, const PuppetShape& shape) {
    constexpr std::size_t x = 0, y = 1, z = 2; // axes
    const double out = std::fabs(origin.x), side = origin.x < 0 ? -1 : 1;
    const std::size_t of_side = origin.x > 0 ? 0 : 1;
    Point p = rest;
    // Short and thick limbs turn less, so that no parts of the cage meet.
    const double share = (1 - 0.15 * shape.child) * (1 - 0.6 * std::max(shape.girth - 1, 0.0));
    const auto turn_about = [&](const Point& joint, std::size_t axis, double degrees) {
        p = rotated(p, shaped(joint, shape), axis, share * degrees);
    };
    if (origin.row == 6 || origin.row == 7) {
        const double forearm = ramp(0.44, 0.66, out), arm = ramp(0.2, 0.42, out);
        const Point elbow{side * 0.545, 1.325, 0}, shoulder{side * 0.23, 1.325, 0};
        const auto& turn = joints.arms[of_side];
        turn_about(elbow, y, turn.forward * forearm);
        turn_about(elbow, z, turn.elbow * forearm);
        turn_about(shoulder, z, turn.shoulder * arm);
    }
    if (origin.row <= 4) {
        const double shin = ramp(0.6, 0.32, origin.y), thigh = ramp(0.88, 0.56, origin.y);
        const Point knee{side * 0.178, 0.46, 0}, hip{side * 0.15, 0.83, 0};
        const auto& turn = joints.legs[of_side];
        turn_about(knee, x, turn.knee * shin);
        turn_about(hip, x, turn.hip * thigh);
        turn_about(hip, z, turn.aside * thigh);
    }
    const double head = ramp(1.43, 1.54, origin.y), chest = ramp(0.82, 1.4, origin.y);
    turn_about({0, 1.5, 0}, y, joints.head[0] * head);
    turn_about({0, 1.5, 0}, z, joints.head[1] * head);
    turn_about({0, 0.9, 0}, y, joints.chest[0] * chest);
    turn_about({0, 0.9, 0}, x, joints.chest[1] * chest);
    turn_about({0, 0.9, 0}, z, joints.chest[2] * chest);
    return p + joints.shift;
}

constexpr double dance_length = 2.4; // seconds

/// A pose of the dance: alternating steps; one hand waves above, the other swings below, then they change
/// roles. `part` is the time in [0, 1]; the poses at 0 and 1 are equal.
Joints dancing(double part) {
    const double angle = 2 * std::numbers::pi * part;
    const double sway = std::cos(angle); // 1: on the left foot
    const auto lift = [&](double of) { return ramp(0.1, 1, of) * (1 - 0.15 * std::cos(2 * angle)); };
    Joints joints{};
    for (const std::size_t i : {0u, 1u}) {
        const double side = i == 0 ? 1 : -1;
        const double up = 0.5 + 0.5 * std::sin(angle) * side; // of the hand
        const double wave = std::sin(3 * angle) * up * up;
        joints.arms[i].shoulder = side * (-48 + 74 * up);
        joints.arms[i].elbow = side * (54 * up + 18 * wave);
        joints.arms[i].forward = -side * 42 * (1 - up);
        const double raised = lift(-side * sway), bent = lift(side * sway);
        joints.legs[i].hip = -58 * raised - 7 * bent;
        joints.legs[i].knee = 74 * raised + 14 * bent;
        joints.legs[i].aside = -5 * sway;
    }
    joints.head = {-16 * std::sin(angle), 8 * sway};
    joints.chest = {13 * std::sin(angle), 4 - 2 * std::cos(2 * angle), -7 * sway};
    joints.shift = {0.06 * sway, -0.012 * (1 - std::cos(2 * angle)), 0};
    return joints;
}

// ---- the bones ----

/// The bones in the format of skin_mesh. The left arm is bent.
std::string bones_text(const PuppetShape& shape) {
    std::string text = "# The puppet's bones\n"
                       "name,parent,head x,y,z,tail x,y,z,turn about x,y,z (degrees)\n";
    const auto bones = cageform_programs::puppet_bones(shape);
    for (const auto& bone : bones) {
        text += bone.name + ',' + (bone.parent == bone.none ? std::string() : bones[bone.parent].name);
        for (const Point& p : {bone.head, bone.tail, bone.turn}) {
            for (const double x : {p[0], p[1], p[2]}) text += ',' + cageform_support::text_of("%g", x);
        }
        text += '\n';
    }
    return text;
}

/// The landmarks: a name and a place in each row.
std::string landmarks_text(const PuppetShape& shape) {
    std::string text = "# Places on the puppet's skin, and its joints\nname,x,y,z\n";
    for (const auto& [name, p] : cageform_programs::puppet_landmarks(shape))
        text += name + cageform_support::formatted(",%.6f,%.6f,%.6f\n", p[0], p[1], p[2]);
    return text;
}

// ---- the files ----

/// The mesh as OBJ text; a vertex and its normal have the same index.
std::string obj_text(const char* heading, const Mesh& mesh, const std::vector<Point>& normals) {
    std::string text = std::string("# ") + heading + "\n";
    using cageform_support::formatted;
    for (const Point& p : mesh.vertices) text += formatted("v %.6f %.6f %.6f\n", p[0], p[1], p[2]);
    for (const Point& n : normals) text += formatted("vn %.5f %.5f %.5f\n", n[0], n[1], n[2]);
    for (const auto& [a, b, c] : mesh.faces) {
        if (normals.empty())
            text += formatted("f %u %u %u\n", a + 1, b + 1, c + 1);
        else
            text += formatted("f %u//%u %u//%u %u//%u\n", a + 1, a + 1, b + 1, b + 1, c + 1, c + 1);
    }
    return text;
}

/// Checks a mesh as a cage.
void check(const Mesh& mesh, const char* what) {
    const auto report = cageform::check(cageform::TriangleMesh<double>(mesh.vertices, mesh.faces));
    if (report.status != cageform::Status::ok)
        throw cageform_support::Failure(std::string(what) + ": " + cageform::to_string(report.status));
}

Mesh posed_cage(const Cage& cage, const Joints& joints) {
    Mesh pose = cage.mesh;
    for (std::size_t i = 0; i < pose.vertices.size(); ++i)
        pose.vertices[i] = posed(pose.vertices[i], cage.origin[i], joints, cage.shape);
    return pose;
}

constexpr std::size_t keys = 24; // of the dance

cageform_support::PoseClip dance_of(const Cage& cage) {
    cageform_support::PoseClip dance{"the dance", dance_length, {}};
    for (std::size_t k = 0; k < keys; ++k) {
        const double part = double(k) / keys;
        auto& key = dance.keys.emplace_back();
        key.time = part * dance_length;
        key.places = posed_cage(cage, dancing(part)).vertices;
    }
    return dance;
}

/// Checks the cage of a dance at the keys and halfway between.
void check(const Cage& cage, const cageform_support::PoseClip& dance) {
    const auto motion = cageform_support::make_clip<double>(dance);
    auto cursor = motion.make_cursor();
    for (std::size_t k = 0; k < 2 * keys; ++k) {
        Mesh now = cage.mesh;
        motion.sample(double(k) / double(2 * keys) * dance_length, cursor, now.vertices);
        check(now, "the dance");
    }
}

/// Fails if a vertex of the figure lies outside the cage.
void check_inside(const Mesh& figure, const Cage& cage) {
    cageform_support::MeshFile shell;
    shell.vertices = cage.mesh.vertices;
    shell.triangles = cage.mesh.faces;
    const auto coordinates = cageform_support::make_coordinates<double>({}, shell);
    const auto outside = coordinates.bind(figure.vertices).report.outside;
    if (outside.empty()) return;
    const Point& p = figure.vertices[outside.front()];
    throw cageform_support::Failure(
        std::to_string(outside.size()) + " vertices of the figure lie outside the cage, first (" +
        std::to_string(p[0]) + ", " + std::to_string(p[1]) + ", " + std::to_string(p[2]) + ")");
}

/// The files of a run, and what is printed about them.
struct Written {
    cageform_support::OutputFiles files;
    std::string summary;
};

/// Writes the files of the folder.
void write_folder(const std::filesystem::path& folder, const Mesh& figure, const PuppetShape& shape,
                  bool has_followers, Written& written) {
    const Cage cage = make_cage(shape);
    const Mesh pose = posed_cage(cage, waving);
    const auto dance = dance_of(cage);
    check(cage.mesh, "the cage");
    check(pose, "the pose");
    check(cage, dance);
    check_inside(figure, cage);
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
        throw cageform_support::Failure("cannot make the folder " + folder.string() + ": " + error.message());
    std::vector<Point> normals;
    for (const Point& p : figure.vertices) {
        const Point g =
            cageform_support::slope([&](const Point& at) { return puppet(unshaped(at, shape)); }, p);
        normals.push_back((1 / length(g)) * g);
    }
    const auto write = [&](const char* name, const std::string& text, const std::string& holds) {
        const auto path = folder / name;
        written.files.add(path).write(text);
        written.summary += cageform_support::printable(path.string()) + ": " + holds + '\n';
    };
    const auto write_mesh = [&](const char* name, const char* heading, const Mesh& mesh,
                                const std::vector<Point>& vertex_normals) {
        write(name, obj_text(heading, mesh, vertex_normals),
              std::to_string(mesh.vertices.size()) + " vertices, " + std::to_string(mesh.faces.size()) +
                  " faces");
    };
    write_mesh("character.obj", "A puppet, made by make_character", figure, normals);
    write_mesh("character_cage.obj", "The puppet's cage", cage.mesh, {});
    write_mesh("character_pose.obj", "A pose of the puppet's cage", pose, {});
    write("character_clip.csv", cageform_support::pose_clip_text(dance, "A dance of the puppet's cage"),
          std::to_string(keys) + " poses of the cage in 2.4 s");
    write("character.bones.csv", bones_text(shape), "18 bones, and a pose of them");
    if (!has_followers) return;
    write_mesh("character_tights.obj", "The puppet's tights", cageform_programs::puppet_tights(shape), {});
    write_mesh("character_skirt.obj", "The puppet's skirt", cageform_programs::puppet_skirt(shape), {});
    write("character.landmarks.csv", landmarks_text(shape), "places on the skin, and joints");
}

/// Writes the character as glTF.
void write_gltf(const std::string& path, const Mesh& figure, Written& written) {
    const auto document = cageform_programs::character_gltf(figure);
    const std::size_t bytes = cageform_support::value_or_fail(save_gltf(document, path, written.files));
    written.summary += cageform_support::printable(path) + ": ";
    for (const char* array : {"nodes", "meshes", "materials", "animations"})
        written.summary += std::to_string(document.json.at(array).size()) + ' ' + array + ", ";
    written.summary += std::to_string(bytes) + " bytes\n";
}

} // namespace

int run_program(int argc, char** argv) {
    cageform_support::CommandLine line("Makes a puppet, a cage around it and a pose of the cage, as OBJ "
                                       "files, a dance of the cage, and bones. Also makes the puppet as glTF "
                                       "with a skeleton, materials and animations.");
    line.set_examples({"out", ".", "out --girth 1.5 --child 0.4 --followers", "-o character.glb"});
    std::string folder, out;
    PuppetShape shape;
    bool has_followers = false;
    line.add("folder", folder,
             "where character.obj, character_cage.obj, character_pose.obj, character_clip.csv and "
             "character.bones.csv are written");
    const auto output =
        line.add("-o,--output", out,
                 "write the puppet as a character of a game: .glb or .gltf with named joints, a skin, "
                 "materials, textures, morph targets, and the animations walk and greeting; with girth 1 and "
                 "child 0")
            .ends_with({".glb", ".gltf"});
    line.add("--girth", shape.girth, "how thick the trunk and the limbs are: 1 is the usual puppet")
        .range(PuppetShape::least_girth, PuppetShape::most_girth)
        .show_default()
        .excludes(output);
    line.add("--child", shape.child, "proportions from those of an adult (0) to those of a child (1)")
        .range(0.0, 1.0)
        .show_default()
        .excludes(output);
    line.add_flag("--followers", has_followers,
                  "also write what follows a body that is laid on another: character_tights.obj, "
                  "character_skirt.obj and character.landmarks.csv");
    if (const auto code = line.parse(argc, argv)) return *code;
    if (folder.empty() && out.empty()) return fail("give a folder, or a file by -o");
    if (folder.empty() && has_followers) return fail("--followers: give a folder");

    const Mesh figure = cageform_programs::puppet_mesh(shape);
    check(figure, "the figure");
    Written written;
    if (!folder.empty()) write_folder(folder, figure, shape, has_followers, written);
    if (!out.empty()) write_gltf(out, figure, written);
    cageform_support::fail_if(written.files.commit());
    std::cout << written.summary;
    return 0;
}
