#include "character/character_gltf.hpp"

#include "character/images.hpp"
#include "character/motions.hpp"
#include "files/gltf_skeleton.hpp"
#include "io/messages.hpp"

#include <cageform/fields/skin.hpp>

namespace cageform_programs {

namespace {

using namespace cageform_support;
using Use = GltfDocument::Use;
template <std::size_t N>
using Floats = std::vector<std::array<float, N>>;

// ---- model space: centimetres, z up ----

constexpr double scale = 0.01;
constexpr Point3 between_feet{0, 0, 0.06};
const Rotation upright = about(0, -90); // from model space to the world

Point3 in_model(const Point3& direction) {
    return rotated(inverse(upright), direction);
}
Point3 place_in_model(const Point3& place) {
    return (1 / scale) * in_model(place - between_feet);
}
Rotation in_model(const Rotation& turn) {
    return product(inverse(upright), product(turn, upright));
}

std::array<float, 3> floats(const Point3& p) {
    return {float(p[0]), float(p[1]), float(p[2])};
}
std::array<float, 4> floats(const Rotation& q) {
    return {float(q[0]), float(q[1]), float(q[2]), float(q[3])};
}
/// Numbers of a node, without rounding errors about 0.
template <class V>
GltfJson numbers(const V& values) {
    GltfJson list;
    for (std::size_t k = 0; k < sizeof(V) / sizeof(double); ++k)
        list.push_back(std::fabs(values[k]) < 1e-12 ? 0.0 : values[k]);
    return list;
}

/// The bones with their rest rotations in model space: y is along the bone.
struct Rig {
    std::vector<PuppetBone> bones = puppet_bones();
    std::vector<Rotation> turns;
    std::size_t first = 0; ///< node of the first joint

    Rig() {
        for (const PuppetBone& bone : bones)
            turns.push_back(between({0, 1, 0}, in_model(bone.tail - bone.head)));
    }
    Rotation turn_of_parent(std::size_t b) const {
        return bones[b].parent == PuppetBone::none ? no_rotation : turns[bones[b].parent];
    }
    /// The rotation of a node for a rotation of the bone relative to its parent, with axes of the world.
    Rotation local(std::size_t b, const Rotation& turn) const {
        return product(inverse(turn_of_parent(b)), product(in_model(turn), turns[b]));
    }
    /// The translation of a node with the parent `b`.
    Point3 translation(std::size_t b, const Point3& place) const {
        const Point3 way = (1 / scale) * in_model(place - bones[b].head);
        return rotated(inverse(turns[b]), way);
    }
};

// ---- materials ----

enum Material : std::uint32_t { face_skin, skin, shirt, brass, denim, leather, eye, wool };

void add_materials(GltfDocument& document) {
    const auto add = [&](const char* name, const Point3& colour, double metallic, double roughness) {
        const std::size_t index =
            document.append("materials", {{"name", name},
                                          {"pbrMetallicRoughness",
                                           {{"baseColorFactor", {colour[0], colour[1], colour[2], 1.0}},
                                            {"metallicFactor", metallic},
                                            {"roughnessFactor", roughness}}}});
        return &document.json["materials"][index];
    };
    document.append("samplers",
                    {{"magFilter", 9729}, {"minFilter", 9987}, {"wrapS", 10497}, {"wrapT", 10497}});
    for (const auto& [name, png] : {std::pair{"cloth", cloth_image()}, std::pair{"face", face_image()},
                                    std::pair{"knit", knit_image()}}) {
        const std::size_t image = document.append(
            "images", {{"name", name}, {"mimeType", "image/png"}, {"bufferView", document.add_bytes(png)}});
        document.append("textures", {{"name", name}, {"sampler", 0}, {"source", image}});
    }
    (*add("face", {1, 1, 1}, 0, 0.6))["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 1}};
    add("skin", {0.8, 0.5, 0.36}, 0, 0.6);
    GltfJson& shirt_cloth = *add("shirt", {1, 1, 1}, 0, 0.85);
    shirt_cloth["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    shirt_cloth["doubleSided"] = true;
    add("brass", {0.85, 0.62, 0.22}, 0.8, 0.35);
    (*add("denim", {0.06, 0.10, 0.22}, 0, 0.9))["doubleSided"] = true;
    GltfJson& shoes = *add("leather", {0.20, 0.07, 0.03}, 0, 0.4);
    shoes["extras"] = {{"sound", "wood"}};
    add("eye", {1, 1, 1}, 0, 0.15);
    GltfJson& knit = *add("wool", {0.72, 0.30, 0.05}, 0, 0.95);
    knit["normalTexture"] = {{"index", 2}, {"scale", 0.8}};
    knit["emissiveFactor"] = {0.02, 0.008, 0.0};
}

// ---- meshes ----

GltfJson morph_accessors(GltfDocument& document, const MorphTarget& target) {
    Floats<3> shifts, turns;
    for (const Point3& p : target.shifts) shifts.push_back(floats((1 / scale) * in_model(p)));
    for (const Point3& p : target.turns) turns.push_back(floats(in_model(p)));
    return {{"POSITION", document.add(shifts, Use::vertices, true)},
            {"NORMAL", document.add(turns, Use::vertices)}};
}

GltfSurface surface_of(const PuppetPart& part, bool takes_tangents) {
    GltfSurface surface;
    surface.maps = {identity_map};
    for (std::uint32_t i = 0; i < part.places.size(); ++i) surface.corners.push_back({i, MeshCorner::none});
    if (!takes_tangents) return surface;
    surface.triangles.assign(part.faces.begin(), part.faces.end());
    surface.texture = part.texture;
    return surface;
}

/// A primitive of a part. Its skin has the four largest weights of each vertex.
///
///   places    #vertices, in the coordinates of the mesh
///   normals   #vertices, likewise
GltfJson primitive_of(GltfDocument& document, const PuppetPart& part, Material material,
                      const std::vector<Point3>& places, const Floats<3>& normals,
                      std::span<const MorphTarget> targets = {}) {
    const GltfSurface surface = surface_of(part, material == wool);
    Floats<3> positions;
    for (const Point3& p : places) positions.push_back(floats(p));
    GltfJson attributes = {{"POSITION", document.add(positions, Use::vertices, true)},
                           {"NORMAL", document.add(normals, Use::vertices)},
                           {"TEXCOORD_0", document.add(part.texture, Use::vertices)}};
    if (const auto tangents = gltf_tangents(surface, places, normals); !tangents.empty())
        attributes["TANGENT"] = document.add(tangents, Use::vertices);
    if (!part.colours.empty()) attributes["COLOR_0"] = document.add(part.colours, Use::vertices, false, true);
    if (!part.weights.empty()) {
        auto [weights, report] =
            cageform::skin_weights(part.weights, part.weights.size() / places.size(), {.influences = 4});
        if (report.status != cageform::Status::ok) throw Failure(cageform::to_string(report.status));
        make_sums_exact(weights);
        attributes.update(
            skin_attributes<std::uint8_t, float>(document, surface, weights, weights.weights, 0));
    }
    std::vector<std::uint32_t> corners;
    for (const auto& face : part.faces) corners.insert(corners.end(), face.begin(), face.end());
    GltfJson primitive = {{"attributes", attributes},
                          {"indices", add_indices(document, corners, places.size())},
                          {"material", material}};
    for (const MorphTarget& target : targets)
        primitive["targets"].push_back(morph_accessors(document, target));
    return primitive;
}

struct NamedTarget {
    const char* name;
    Point3 (*shift)(const Point3&);
};

/// Appends a mesh of parts that follow the bones, with its node; returns the node.
std::size_t add_skinned(GltfDocument& document, const char* name,
                        std::initializer_list<std::pair<const PuppetPart*, Material>> parts,
                        std::initializer_list<NamedTarget> shifts = {}) {
    GltfJson mesh = {{"name", name}};
    for (const auto& [part, material] : parts) {
        std::vector<Point3> places;
        Floats<3> normals;
        for (const Point3& p : part->places) places.push_back(place_in_model(p));
        for (const Point3& n : part->normals) normals.push_back(floats(in_model(n)));
        std::vector<MorphTarget> targets;
        for (const NamedTarget& target : shifts) targets.push_back(morph_target(*part, target.shift));
        mesh["primitives"].push_back(primitive_of(document, *part, material, places, normals, targets));
    }
    for (const NamedTarget& target : shifts) {
        mesh["weights"].push_back(0);
        mesh["extras"]["targetNames"].push_back(target.name);
    }
    const std::size_t index = document.append("meshes", std::move(mesh));
    return document.append("nodes", {{"name", name}, {"mesh", index}, {"skin", 0}});
}

/// Appends a mesh without bones, in centimetres; returns the mesh.
///
///   unit   of the part, in metres
std::size_t add_rigid(GltfDocument& document, const char* name, const PuppetPart& part, Material material,
                      double unit) {
    std::vector<Point3> places;
    Floats<3> normals;
    for (const Point3& p : part.places) places.push_back((unit / scale) * p);
    for (const Point3& n : part.normals) normals.push_back(floats(n));
    GltfJson mesh = {{"name", name}};
    mesh["primitives"].push_back(primitive_of(document, part, material, places, normals));
    return document.append("meshes", std::move(mesh));
}

// ---- nodes ----

/// Appends the joints below the node `top`, and the skin.
void add_joints(GltfDocument& document, Rig& rig, std::size_t top) {
    rig.first = document.json["nodes"].size();
    GltfJson joints;
    Floats<16> inverse_binds;
    for (std::size_t b = 0; b < rig.bones.size(); ++b) {
        const PuppetBone& bone = rig.bones[b];
        const bool is_root = bone.parent == PuppetBone::none;
        const Point3 translation =
            is_root ? place_in_model(bone.head) : rig.translation(bone.parent, bone.head);
        const std::size_t node = document.append("nodes", {{"name", bone.name},
                                                           {"translation", numbers(translation)},
                                                           {"rotation", numbers(rig.local(b, no_rotation))}});
        document.json["nodes"][is_root ? top : rig.first + bone.parent]["children"].push_back(node);
        joints.push_back(node);
        const Rotation back = inverse(rig.turns[b]);
        std::array<float, 16> matrix{};
        for (std::size_t column = 0; column < 4; ++column) {
            Point3 p{};
            if (column < 3)
                p[column] = 1;
            else
                p = -1.0 * place_in_model(bone.head);
            p = rotated(back, p);
            for (std::size_t row = 0; row < 3; ++row) matrix[4 * column + row] = float(p[row]);
        }
        matrix[15] = 1;
        inverse_binds.push_back(matrix);
    }
    document.append("skins", {{"name", "puppet"},
                              {"inverseBindMatrices", document.add(inverse_binds, Use::other)},
                              {"skeleton", top},
                              {"joints", joints}});
}

/// Appends a node below a joint.
///
///   turn   from the mesh to the world
void attach(GltfDocument& document, const Rig& rig, std::size_t bone, const Point3& place,
            const Rotation& turn, GltfJson node) {
    node["translation"] = numbers(rig.translation(bone, place));
    node["rotation"] = numbers(product(inverse(rig.turns[bone]), product(inverse(upright), turn)));
    const std::size_t index = document.append("nodes", std::move(node));
    document.json["nodes"][rig.first + bone]["children"].push_back(index);
}

void add_eyes_and_cap(GltfDocument& document, const Rig& rig) {
    const std::size_t ball = add_rigid(document, "eye", eye_part(), eye, 0.034);
    for (const double side : {1.0, -1.0}) {
        const Rotation gaze = between({0, 1, 0}, {0.12 * side, 0.02, 1});
        attach(document, rig, bone::head, {0.068 * side, 1.757, 0.143}, gaze,
               {{"name", side > 0 ? "left eye" : "right eye"}, {"mesh", ball}});
    }
    const std::size_t cap = add_rigid(document, "cap", cap_part(), wool, 1);
    attach(document, rig, bone::head, {0, 1.71, 0.004}, about(0, -7),
           {{"name", "cap"}, {"mesh", cap}, {"scale", {1.0, 1.0, 0.97}}, {"extras", {{"slot", "hat"}}}});
}

/// Appends a camera and a light to the scene's roots.
void add_camera_and_light(GltfDocument& document, GltfJson& roots) {
    const Point3 eye_place{1.3, 1.5, 4.2}, way = Point3{0, 0.95, 0} - eye_place;
    const double yaw = std::atan2(-way[0], -way[2]), pitch = std::atan2(way[1], std::hypot(way[0], way[2]));
    constexpr double degrees = 180 / std::numbers::pi;
    document.append(
        "cameras", {{"name", "portrait"},
                    {"type", "perspective"},
                    {"perspective", {{"yfov", 0.5}, {"aspectRatio", 1.0}, {"znear", 0.1}, {"zfar", 100.0}}}});
    roots.push_back(document.append(
        "nodes", {{"name", "camera"},
                  {"camera", 0},
                  {"translation", numbers(eye_place)},
                  {"rotation", numbers(product(about(1, degrees * yaw), about(0, degrees * pitch)))}}));
    document.json["extensionsUsed"].push_back("KHR_lights_punctual");
    document.json["extensions"]["KHR_lights_punctual"]["lights"].push_back(
        {{"name", "sun"}, {"type", "directional"}, {"color", {1.0, 0.96, 0.9}}, {"intensity", 3.0}});
    roots.push_back(document.append("nodes", {{"name", "sun"},
                                              {"rotation", numbers(product(about(1, 35), about(0, -50)))},
                                              {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}));
}

// ---- animations ----

/// Times and poses of an animation.
struct Motion {
    const char* name;
    double length;
    std::size_t steps;
    bool is_cubic; // CUBICSPLINE with the motion's own slopes
    PuppetPose (*pose)(const std::vector<PuppetBone>&, double);
};

/// Appends one animation. Only nodes that move have channels.
class MotionWriter {
public:
    MotionWriter(GltfDocument& document, const Rig& rig, const Motion& motion)
        : document_(document)
        , rig_(rig)
        , motion_(motion)
        , animation_({{"name", motion.name}}) {
        Floats<1> times;
        for (std::size_t k = 0; k <= motion.steps; ++k)
            times.push_back({float(motion.length * double(k) / double(motion.steps))});
        input_ = document.add(times, Use::other, true);
    }

    void add(std::size_t face, std::size_t shirt_node) {
        for (std::size_t b = 0; b < rig_.bones.size(); ++b) add_rotation(b);
        add_channel_of<3>(
            rig_.first, "translation", floats(place_in_model(rig_.bones[0].head)),
            [&](const PuppetPose& pose) { return floats(place_in_model(rig_.bones[0].head + pose.shift)); });
        add_channel_of<2>(face, "weights", {}, [](const PuppetPose& pose) {
            return std::array{float(pose.smile), float(pose.surprise)};
        });
        add_channel_of<1>(shirt_node, "weights", {},
                          [](const PuppetPose& pose) { return std::array{float(pose.breath)}; });
        document_.append("animations", std::move(animation_));
    }

private:
    PuppetPose pose_at(double key) const {
        const double part = key / double(motion_.steps);
        return motion_.pose(rig_.bones, part - std::floor(part));
    }

    void add_rotation(std::size_t b) {
        const Rotation rest = rig_.local(b, no_rotation);
        Rotation last = rest;
        add_channel_of<4>(rig_.first + b, "rotation", floats(rest), [&](const PuppetPose& pose) {
            Rotation q = rig_.local(b, pose.turns[b]);
            double cosine = 0;
            for (std::size_t k = 0; k < 4; ++k) cosine += q[k] * last[k];
            for (double& number : q) number *= cosine < 0 ? -1 : 1; // neighbouring keys have the same sign
            last = q;
            return floats(q);
        });
    }

    /// Adds a channel if a value differs from the node's own.
    template <std::size_t N, class Value>
    void add_channel_of(std::size_t node, const char* path, const std::array<float, N>& own, Value value) {
        Floats<N> values, keys;
        const double step = motion_.is_cubic ? 0.02 : 1; // of the slopes, in keys
        const double seconds = motion_.length / double(motion_.steps);
        for (std::size_t k = 0; k <= motion_.steps; ++k) {
            const auto now = value(pose_at(double(k)));
            values.push_back(now);
            if (motion_.is_cubic) {
                const auto before = value(pose_at(double(k) - step)),
                           after = value(pose_at(double(k) + step));
                std::array<float, N> slope;
                for (std::size_t n = 0; n < N; ++n)
                    slope[n] = float(double(after[n] - before[n]) / (2 * step * seconds));
                keys.insert(keys.end(), {slope, now, slope});
            } else {
                keys.push_back(now);
            }
        }
        if (std::all_of(values.begin(), values.end(), [&](const auto& v) { return v == own; })) return;
        std::vector<std::array<float, 1>> list;
        const char* interpolation = motion_.is_cubic ? "CUBICSPLINE" : "LINEAR";
        std::size_t output = 0;
        if (std::string_view(path) == "weights") { // 3.11: numbers of targets are a flat list
            for (const auto& key : keys) {
                for (const float number : key) list.push_back({number});
            }
            output = document_.add(list, Use::other);
        } else {
            output = document_.add(keys, Use::other);
        }
        add_channel(animation_, node, path, input_, interpolation, output);
    }

    GltfDocument& document_;
    const Rig& rig_;
    const Motion& motion_;
    GltfJson animation_;
    std::size_t input_ = 0;
};

std::vector<double> weights_of(const ImplicitMesh& mesh, const Rig& rig) {
    std::vector<cageform::BoneSegment> segments;
    for (const PuppetBone& bone : rig.bones) segments.push_back({bone.head, bone.tail});
    // With more heat, fewer bones move each vertex. The skin keeps four of them.
    auto made = cageform::bone_heat(mesh.vertices, mesh.faces, segments, {.heat = 10});
    if (made.report.status != cageform::Status::ok) throw Failure(cageform::to_string(made.report.status));
    return std::move(made.value);
}

} // namespace

GltfDocument character_gltf(const ImplicitMesh& mesh) {
    Rig rig;
    const PuppetParts parts = puppet_parts(mesh, weights_of(mesh, rig));
    GltfDocument document("cageform make_character");
    document.json["asset"]["copyright"] = "2026 the cageform authors, MIT License";
    document.json["scene"] = 0;
    add_materials(document);
    const std::size_t top = document.append(
        "nodes", {{"name", "character"},
                  {"translation", numbers(between_feet)},
                  {"rotation", numbers(upright)},
                  {"scale", {scale, scale, scale}},
                  {"extras", {{"walk speed (m/s)", walk_speed}, {"tags", {"puppet", "biped"}}}}});
    add_joints(document, rig, top);
    add_eyes_and_cap(document, rig);
    GltfJson roots = {top};
    // Nodes with a skin are roots: the transforms of their parents have no effect (3.7.3.3).
    const std::size_t face =
        add_skinned(document, "face", {{&parts.face, face_skin}}, {{"smile", smile}, {"surprise", surprise}});
    const std::size_t hands = add_skinned(document, "hands", {{&parts.hands, skin}});
    const std::size_t shirt_node = add_skinned(
        document, "shirt", {{&parts.shirt, shirt}, {&parts.buttons, brass}}, {{"breath", breath}});
    const std::size_t legs =
        add_skinned(document, "trousers and shoes", {{&parts.trousers, denim}, {&parts.shoes, leather}});
    for (const std::size_t node : {face, hands, shirt_node, legs}) roots.push_back(node);
    add_camera_and_light(document, roots);
    document.append("scenes", {{"name", "stage"}, {"nodes", roots}});
    for (const Motion& motion : {Motion{"walk", walk_length, 30, false, walk_pose},
                                 Motion{"greeting", greeting_length, 30, true, greeting_pose}})
        MotionWriter(document, rig, motion).add(face, shirt_node);
    return document;
}

} // namespace cageform_programs
