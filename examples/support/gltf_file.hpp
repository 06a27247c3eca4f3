#pragma once

// glTF 2.0: a mesh that came from an OBJ file, its skin or its morph targets, and how it moves.
//
// A file is a JSON object and a buffer of bytes; both end in one file, .gltf (the bytes as text in the JSON) or .glb
// (the bytes as they are). References are to the sections of the glTF 2.0 specification.

#include "base64.hpp"
#include "clip_file.hpp"
#include "csv.hpp"
#include "obj_file.hpp"

#include <cageform/animate/import/gltf.hpp>
#include <cageform/binding/skin_weights.hpp>

#include <nlohmann/json.hpp>

#include <bit>
#include <cstring>
#include <map>

namespace cageform_examples {

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

    /// Appends to an array of the JSON's root; returns the index.
    std::size_t append(const char* array, GltfJson object) {
        json[array].push_back(std::move(object));
        return json[array].size() - 1;
    }

    /// The file's contents. Letters of names that are no UTF-8 are replaced.
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

/// A mesh as glTF has it: a vertex for every position, normal and texture coordinate that meet at a corner. The vertices
/// of the OBJ file come first, all of them in its order; behind them those that are there once more, because their faces
/// differ in normal or texture coordinate.
struct GltfMesh {
    struct Corner {
        std::uint32_t vertex, normal, texture; // of the OBJ file; ObjCorner::none where there is none
        friend auto operator<=>(const Corner&, const Corner&) = default;
    };
    std::vector<Corner> corners;                       // #vertices
    std::vector<std::array<std::uint32_t, 1>> indices; // three a triangle, among the corners
    std::vector<std::array<float, 2>> texture; // #vertices, v downwards; empty where the file has none
};

/// Splits the vertices of a file as glTF needs it. Fails where the file has no faces, or a texture coordinate is no
/// numbers or is not there.
inline SvgResult<GltfMesh> gltf_mesh(const ObjFile& file) {
    if (file.triangles.empty()) return SvgError{file.name + ": holds no faces"};
    // Texture coordinates, which ObjFile leaves alone.
    std::vector<std::array<float, 2>> texture;
    std::vector<std::vector<std::uint32_t>> of_face;
    std::vector<std::string_view> words;
    std::size_t line = 1, total = 0;
    const auto refuse = [&](const std::string& why) { return SvgError{file.name + ": " + why, line}; };
    for (detail::ObjScanner scanner(file.text); scanner.next(words, line);) total += words[0] == "vt" ? 1 : 0;
    for (detail::ObjScanner scanner(file.text); scanner.next(words, line);) {
        if (words[0] == "vt") {
            std::array<double, 2> st{};
            for (std::size_t k = 0; k < 2 && k + 1 < words.size(); ++k) {
                const std::string why = detail::parse_number(words[k + 1], st[k]);
                if (!why.empty()) return refuse(why);
                if (!std::isfinite(float(st[k]))) return refuse("a texture coordinate is not finite");
            }
            texture.push_back({float(st[0]), 1 - float(st[1])}); // 3.7.2.1: v counts from the top
        } else if (words[0] == "f") {
            auto& corners = of_face.emplace_back();
            for (const std::string_view word : std::span(words).subspan(1)) {
                std::uint32_t& index = corners.emplace_back(ObjCorner::none);
                const std::size_t first = word.find('/'), second = word.find('/', first + 1);
                if (first == std::string_view::npos || first + 1 == std::min(second, word.size())) continue;
                const std::string why = detail::parse_index(word.substr(first + 1, second - first - 1),
                                                            texture.size(), total, "texture", index);
                if (!why.empty()) return refuse(why);
            }
        }
    }

    GltfMesh mesh;
    for (std::uint32_t v = 0; v < file.vertices.size(); ++v)
        mesh.corners.push_back({v, ObjCorner::none, ObjCorner::none});
    std::map<GltfMesh::Corner, std::uint32_t> known;
    std::vector<bool> met(file.vertices.size()); // whether a corner has taken the vertex's own place
    for (std::size_t t = 0; t < file.triangles.size(); ++t) {
        const ObjFace& face = file.faces[file.triangle_faces[t]];
        for (const std::uint32_t vertex : file.triangles[t]) {
            const auto at = std::find_if(face.corners.begin(), face.corners.end(),
                                         [&](const ObjCorner& corner) { return corner.vertex == vertex; });
            const std::uint32_t st = of_face[file.triangle_faces[t]][std::size_t(at - face.corners.begin())];
            const GltfMesh::Corner corner{vertex, at->normal, st};
            const auto next = std::uint32_t(met[vertex] ? mesh.corners.size() : vertex);
            const auto [place, added] = known.insert({corner, next});
            if (added && met[vertex]) mesh.corners.push_back(corner);
            if (added && !met[vertex]) mesh.corners[vertex] = corner;
            met[vertex] = true;
            mesh.indices.push_back({place->second});
        }
    }
    if (!texture.empty()) {
        for (const auto& corner : mesh.corners)
            mesh.texture.push_back(corner.texture == ObjCorner::none ? std::array<float, 2>{}
                                                                     : texture[corner.texture]);
    }
    return mesh;
}

/// The mesh's positions where the file's vertices are at `places`.
inline std::vector<std::array<float, 3>> gltf_positions(const GltfMesh& mesh,
                                                        std::span<const Point3> places) {
    std::vector<std::array<float, 3>> positions;
    for (const auto& corner : mesh.corners) {
        const Point3& p = places[corner.vertex];
        positions.push_back({float(p[0]), float(p[1]), float(p[2])});
    }
    return positions;
}

/// Its normals then, of unit length: the file's turned with their faces; where there are none, the mean of the faces about
/// the vertex, weighted by area.
inline std::vector<std::array<float, 3>> gltf_normals(const GltfMesh& mesh, const ObjFile& file,
                                                      std::span<const Point3> places) {
    const std::vector<Point3> turned = deformed_normals(file, places);
    std::vector<Point3> smooth(file.vertices.size());
    for (const ObjFace& face : file.faces) {
        const Point3 area = detail::area_vector(face, places);
        for (const ObjCorner& corner : face.corners) smooth[corner.vertex] = smooth[corner.vertex] + area;
    }
    std::vector<std::array<float, 3>> normals;
    for (const auto& corner : mesh.corners) {
        Point3 n = corner.normal == ObjCorner::none ? smooth[corner.vertex] : turned[corner.normal];
        if (const double length = std::hypot(n[0], n[1], n[2]); length > 0 && std::isfinite(length))
            n = (1 / length) * n;
        else
            n = {0, 0, 1}; // any will do where the faces have no area
        normals.push_back({float(n[0]), float(n[1]), float(n[2])});
    }
    return normals;
}

/// Some numbers through the keys of a clip as a sampler of an animation, CUBICSPLINE. Nothing is lost but what single
/// precision rounds.
///
///   values   of every key, `components` numbers
///   returns  as to_gltf_cubicspline()
inline cageform::GltfTrack gltf_track(const PoseClip& clip, std::span<const double> values,
                                      std::size_t components) {
    const std::size_t keys = clip.keys.size();
    std::vector<cageform::BezierCurve> curves(keys * components);
    std::vector<double> own(keys);
    for (std::size_t c = 0; c < components; ++c) {
        for (std::size_t k = 0; k < keys; ++k) own[k] = values[k * components + c];
        const auto curve = curve_through(clip, own);
        for (std::size_t k = 0; k < keys; ++k) {
            const auto& p = curve.pieces()[k];
            const double end = k + 1 < keys ? clip.keys[k + 1].time : clip.length, h = end - p.begin;
            const double last = own[(k + 1) % keys];
            curves[k * components + c].points = {{{p.begin, p.c0},
                                                  {p.begin + h / 3, p.c0 + p.c1 * h / 3},
                                                  {end - h / 3, p.c0 + h / 3 * (2 * p.c1 + p.c2 * h)},
                                                  {end, last}}};
        }
    }
    return cageform::to_gltf_cubicspline(curves, components);
}

/// Appends the attributes of a skin, four joints a set: JOINTS_0, WEIGHTS_0, JOINTS_1, … Points without weights are given to
/// the joint `still`.
///
///   Index    std::uint8_t or std::uint16_t
///   weights  #points · influences, of a point's skin: float, or normalised integers
template <class Index, class Weight>
void add_skin_attributes(GltfDocument& document, GltfJson& attributes, const GltfMesh& mesh,
                         const cageform::SkinWeights& skin, std::span<const Weight> weights,
                         std::size_t still) {
    constexpr bool integer = !std::is_same_v<Weight, float>;
    constexpr Weight one = integer ? std::numeric_limits<Weight>::max() : Weight(1);
    const std::size_t most = skin.influences, sets = (most + 3) / 4;
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

} // namespace cageform_examples
