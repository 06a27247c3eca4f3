#pragma once

// glTF 2.0: meshes that came from an OBJ file, their materials, their skin or morph targets, and how they
// move.
//
// A file is a JSON object and a buffer of bytes; both end in one file, .gltf (the bytes as text in the
// JSON) or .glb (the bytes as they are). References are to the sections of the glTF 2.0 specification.

#include "files/clip_file.hpp"
#include "files/obj_parts.hpp"
#include "io/base64.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"

#include <cageform/binding/skin_weights.hpp>
#include <cageform/exchange/gltf.hpp>

#include <nlohmann/json.hpp>

#include <bit>
#include <cstring>
#include <map>

namespace cageform_support {

using GltfJson = nlohmann::ordered_json;

/// The JSON and the bytes of a file in the making.
class GltfDocument {
public:
    enum class Use { vertices = 34962, indices = 34963, other = 0 }; // 5.11.5

    GltfJson json = {{"asset", {{"version", "2.0"}, {"generator", "cageform export_gltf"}}}};

    /// Appends an accessor of N numbers an element, in a view of its own; returns its index.
    ///
    ///   bounds  whether to tell the least and the largest of each component, as positions and times have to
    template <class T, std::size_t N>
    std::size_t add(std::span<const std::array<T, N>> values, Use use, bool bounds = false,
                    bool normalised = false) {
        static_assert(std::endian::native == std::endian::little, "glTF is little-endian");
        bytes_.resize((bytes_.size() + 3) / 4 * 4); // 3.6.2.4
        GltfJson view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", values.size_bytes()}};
        if (use == Use::vertices) view["byteStride"] = sizeof(std::array<T, N>);
        if (use != Use::other) view["target"] = int(use);
        bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
        json["bufferViews"].push_back(std::move(view));

        GltfJson accessor = {{"bufferView", json["bufferViews"].size() - 1},
                             {"componentType", component_type<T>()},
                             {"count", values.size()},
                             {"type", N == 1   ? "SCALAR"
                                      : N == 2 ? "VEC2"
                                      : N == 3 ? "VEC3"
                                      : N == 4 ? "VEC4"
                                               : "MAT4"}};
        if (normalised) accessor["normalized"] = true;
        for (std::size_t k = 0; bounds && k < N; ++k) {
            T low = values[0][k], high = low;
            for (const auto& value : values) {
                low = std::min(low, value[k]);
                high = std::max(high, value[k]);
            }
            accessor["min"].push_back(low);
            accessor["max"].push_back(high);
        }
        return append("accessors", std::move(accessor));
    }
    template <class T, std::size_t N>
    std::size_t add(const std::vector<std::array<T, N>>& values, Use use, bool bounds = false,
                    bool normalised = false) {
        return add(std::span<const std::array<T, N>>(values), use, bounds, normalised);
    }

    /// Appends bytes as they are, such as a picture, in a view of their own; returns its index.
    std::size_t add_bytes(std::string_view contents) {
        bytes_.resize((bytes_.size() + 3) / 4 * 4);
        GltfJson view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", contents.size()}};
        bytes_.append(contents);
        return append("bufferViews", std::move(view));
    }

    /// Appends to an array of the JSON's root; returns the index.
    std::size_t append(const char* array, GltfJson object) {
        json[array].push_back(std::move(object));
        return json[array].size() - 1;
    }

    /// Returns the file's contents. Bytes of names that are not UTF-8 are replaced.
    std::string text(bool binary) const {
        GltfJson whole = json;
        std::string bytes = bytes_;
        bytes.resize((bytes.size() + 3) / 4 * 4);
        whole["buffers"].push_back({{"byteLength", bytes.size()}});
        const auto dumped = [&](int indent) {
            return whole.dump(indent, ' ', false, GltfJson::error_handler_t::replace);
        };
        if (!binary) {
            whole["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(bytes);
            return dumped(1) + '\n';
        }
        std::string head = dumped(-1); // 4.4
        head.resize((head.size() + 3) / 4 * 4, ' ');
        const auto number = [](std::size_t n) {
            const auto word = static_cast<std::uint32_t>(n);
            return std::string(
                {char(word & 255), char(word >> 8 & 255), char(word >> 16 & 255), char(word >> 24)});
        };
        return "glTF" + number(2) + number(12 + 8 + head.size() + 8 + bytes.size()) + number(head.size()) +
               "JSON" + head + number(bytes.size()) + std::string("BIN\0", 4) + bytes;
    }
    std::size_t bytes() const { return bytes_.size(); }

private:
    template <class T>
    static int component_type() {
        if constexpr (std::is_same_v<T, float>) {
            return 5126;
        } else {
            static_assert(std::is_unsigned_v<T>);
            return sizeof(T) == 1 ? 5121 : sizeof(T) == 2 ? 5123 : 5125;
        }
    }

    std::string bytes_;
};

/// A mesh as glTF has it: a vertex for every position, normal and texture coordinate that meet at a corner,
/// in the order of the OBJ file; then the duplicates, whose faces differ in normal or texture coordinate.
/// Where it is the only mesh of a file it has all vertices of that, else those that its faces have.
struct GltfMesh {
    struct Corner {
        std::uint32_t vertex, normal, texture; // of the OBJ file; ObjCorner::none where there is none
        friend auto operator<=>(const Corner&, const Corner&) = default;
    };
    /// The faces of a material.
    struct Part {
        std::uint32_t material = 0;                        // of the ObjParts
        std::vector<std::array<std::uint32_t, 1>> indices; // three a triangle, among the corners
    };
    std::string name;
    std::vector<Corner> corners;               // #vertices
    std::vector<Part> parts;                   // in the order of their first faces
    std::vector<std::array<float, 2>> texture; // #vertices, v downwards; empty where the file has none
    bool takes_tangents = false;               // whether a material of it has a picture of normals
};

/// The texture coordinates of a file, which ObjFile leaves alone.
struct ObjTexture {
    std::vector<std::array<float, 2>> coordinates; // v downwards
    std::vector<std::vector<std::uint32_t>>
        of_face; // #faces, of every corner; ObjCorner::none where there is none
};

/// Fails where one is no numbers or is not there.
Expected<ObjTexture> read_texture(const ObjFile& file);

/// The meshes of a file, one an object: splits vertices as glTF needs it. Fails where the file has no
/// faces, or as read_texture() does.
Expected<std::vector<GltfMesh>> gltf_meshes(const ObjFile& file, const ObjParts& parts);

/// The mesh's positions where the file's vertices are at `places`.
std::vector<std::array<float, 3>> gltf_positions(const GltfMesh& mesh, std::span<const Point3> places);

/// The mesh's normals after a deformation of the file's vertices, of unit length: those of the file; where
/// there are none, the mean of the faces about the vertex, weighted by area.
std::vector<std::array<float, 3>> gltf_normals(const GltfMesh& mesh, const ObjFile& file,
                                               const MovedVertices& moved);

/// The tangents of a mesh that takes them, along its pictures' u, across its normals; the fourth number is
/// the side of v (glTF 2.0, 3.7.2.1). None of other meshes.
std::vector<std::array<float, 4>> gltf_tangents(const GltfMesh& mesh, std::span<const Point3> places,
                                                std::span<const std::array<float, 3>> normals);

/// The attributes of a mesh at rest.
GltfJson gltf_attributes(GltfDocument& document, const GltfMesh& mesh, const ObjFile& file);

/// The primitives of a mesh, one a material, which share its attributes and its targets.
///
///   targets   null where there are none
GltfJson gltf_primitives(GltfDocument& document, const GltfMesh& mesh, const GltfJson& attributes,
                         const GltfJson& targets = {});

/// Appends the materials, with the pictures of their textures, which the file then holds. If `map_d` names
/// the picture of the colour and the picture has alpha, the material gets alphaMode BLEND. Returns warnings
/// of pictures that are left out.
///
///   textured   whether the meshes have texture coordinates
std::vector<std::string> add_materials(GltfDocument& document, const ObjParts& parts, bool textured);

/// Some numbers through the keys of a clip as a sampler of an animation, CUBICSPLINE. Nothing is lost but
/// what single precision rounds.
///
///   values   of every key, `components` numbers
///   returns  as to_gltf_cubicspline()
cageform::Result<cageform::GltfTrack, cageform::ExchangeReport>
gltf_track(const PoseClip& clip, std::span<const double> values, std::size_t components);

/// Rounds weights to multiples of 2^-24, so that the weights of each point sum to exactly 1. An error of the
/// sum would move the point by that share of its distance from the origin.
void make_sums_exact(cageform::SkinWeights& skin);

/// The largest error of a player that computes in single precision: a few roundings of the largest
/// coordinate.
double rounding_of_players(std::span<const Point3> places);

/// How many sets of four joints a skin fills: the last that has a weight.
inline std::size_t joint_sets(const cageform::SkinWeights& skin) {
    std::size_t most = 1;
    for (std::size_t n = 0; n < skin.weights.size(); ++n) {
        if (skin.weights[n] != 0) most = std::max(most, n % skin.influences + 1);
    }
    return (most + 3) / 4;
}

/// The places of the vertices, for weights. Files split vertices where normals or texture coordinates
/// differ, and some round the copies apart. A vertex near an earlier place gets that place. Near means within
/// 1e-6 of the figure's size, and within 1 % of the 5th percentile of edge lengths.
std::vector<Point3> joined_places(const ObjFile& figure);

/// Some players read only the first set, four joints a vertex, and normalise its weights. Returns the skin
/// that they show.
cageform::SkinWeights first_set(const cageform::SkinWeights& skin);

/// Appends the attributes of a skin, four joints a set: JOINTS_0, WEIGHTS_0, JOINTS_1, … Points without
/// weights are given to the joint `still`. Sets without a weight are left out.
///
///   Index    std::uint8_t or std::uint16_t
///   weights  #points · influences, of a point's skin: float, or normalised integers
template <class Index, class Weight>
void add_skin_attributes(GltfDocument& document, GltfJson& attributes, const GltfMesh& mesh,
                         const cageform::SkinWeights& skin, std::span<const Weight> weights,
                         std::size_t still) {
    constexpr bool integer = !std::is_same_v<Weight, float>;
    constexpr Weight one = integer ? std::numeric_limits<Weight>::max() : Weight(1);
    const std::size_t most = skin.influences, sets = joint_sets(skin);
    for (std::size_t set = 0; set < sets; ++set) {
        std::vector<std::array<Index, 4>> joints;
        std::vector<std::array<Weight, 4>> shares;
        for (const auto& corner : mesh.corners) {
            auto& joint = joints.emplace_back();
            auto& share = shares.emplace_back();
            const std::size_t first = corner.vertex * most;
            for (std::size_t k = 0; k < 4 && 4 * set + k < most; ++k) {
                share[k] = weights[first + 4 * set + k];
                // 3.7.3.3: unused ones are of joint 0. Rounding may have made more so.
                joint[k] = share[k] == 0 ? Index(0) : static_cast<Index>(skin.joints[first + 4 * set + k]);
            }
            if (set == 0 && weights[first] == 0) {
                joint[0] = static_cast<Index>(still);
                share[0] = one;
            }
        }
        const std::string number = std::to_string(set);
        attributes["JOINTS_" + number] = document.add(joints, GltfDocument::Use::vertices);
        attributes["WEIGHTS_" + number] = document.add(shares, GltfDocument::Use::vertices, false, integer);
    }
}

} // namespace cageform_support
