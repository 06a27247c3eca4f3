// Makes a hand: its skin, its control points and its poses.
//
//     make_hand out
//
// writes out/hand.obj, out/hand_points.csv (what each control point is, and what moves it) and out/hand_poses.csv
// (22 angles a line, as pose_hand takes them).

#include "bound_hand.hpp"
#include "command_line.hpp"
#include "guard.hpp"

#include <cageform/cage/triangle_mesh.hpp>

#include <cstdio>
#include <iostream>

namespace {

using namespace cageform_examples;

int fail(const std::string& message) {
    std::cerr << "make_hand: " << message << '\n';
    return 1;
}

template <class... Values>
void append(std::string& text, const char* format, Values... values) {
    std::array<char, 200> line;
    text.append(line.data(), std::size_t(std::snprintf(line.data(), line.size(), format, values...)));
}

std::string obj_text(const ImplicitMesh& mesh) {
    std::string text = "# A right hand, made by make_hand\n";
    for (const Point3& p : mesh.vertices) append(text, "v %.6f %.6f %.6f\n", p[0], p[1], p[2]);
    for (const auto& [a, b, c] : mesh.faces) append(text, "f %u %u %u\n", a + 1, b + 1, c + 1);
    return text;
}

std::string points_text(const Hand& hand) {
    std::string text = "x,y,z,kind,joint,other,part,vertex\n"; // joints and vertices from 0; empty: none
    const auto index = [](std::size_t i) { return i == HandJoint::none ? std::string() : std::to_string(i); };
    for (const HandPoint& p : hand.points) {
        append(text, "%.6f,%.6f,%.6f,%s,%s,%s,%g,%s\n", p.place[0], p.place[1], p.place[2], to_string(p.kind),
               index(p.joint).c_str(), index(p.other).c_str(), p.joint == HandJoint::none ? 0.0 : p.part,
               index(p.vertex).c_str());
    }
    return text;
}

std::string poses_text() {
    std::string text = "# ";
    for (std::size_t i = 0; i < hand_angle_count; ++i)
        text += (i == 0 ? "" : ",") + std::string(hand_angle_ranges[i].name);
    text += '\n';
    for (const NamedHandPose& pose : hand_poses()) {
        text += "# " + std::string(pose.name) + '\n';
        for (std::size_t i = 0; i < hand_angle_count; ++i)
            append(text, i == 0 ? "%g" : ",%g", pose.angles[i]);
        text += '\n';
    }
    return text;
}

int run_program(int argc, char** argv) {
    CommandLine line("Makes the skin of a hand, its control points and some poses of its 22 joint angles.");
    std::string folder;
    line.add("folder", folder, "where hand.obj, hand_points.csv and hand_poses.csv are written").required();
    if (const auto code = line.parse(argc, argv)) return *code;

    const Hand hand = make_hand(hand_cell);
    const auto sound = cageform::check(cageform::TriangleMesh<double>(hand.skin.vertices, hand.skin.faces));
    if (sound.status != cageform::Status::ok)
        return fail(std::string("the skin: ") + to_string(sound.status));
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return fail("cannot make the folder " + folder + ": " + error.message());
    OutputFiles outputs;
    const auto path = std::filesystem::path(folder);
    outputs.add(path / "hand.obj").write(obj_text(hand.skin));
    outputs.add(path / "hand_points.csv").write(points_text(hand));
    outputs.add(path / "hand_poses.csv").write(poses_text());
    if (const auto failure = outputs.commit()) return fail(*failure);
    std::cout << (path / "hand.obj").string() << ": " << hand.skin.vertices.size() << " vertices, "
              << hand.skin.faces.size() << " faces\n"
              << (path / "hand_points.csv").string() << ": " << hand.points.size() << " control points\n"
              << (path / "hand_poses.csv").string() << ": " << hand_poses().size() << " poses\n";
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return cageform_examples::guarded("make_hand", [&] { return run_program(argc, argv); });
}
