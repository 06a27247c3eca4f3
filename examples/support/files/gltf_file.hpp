#pragma once

// glTF 2.0: meshes that came from an OBJ file, their materials, their skin or morph targets, and how they
// move.
//
// A file is a JSON object and a buffer of bytes; both end in one file, .gltf (the bytes as text in the
// JSON) or .glb (the bytes as they are). References are to the sections of the glTF 2.0 specification.

#include "files/base64.hpp"
#include "files/clip_file.hpp"
#include "files/csv.hpp"
#include "files/input_file.hpp"
#include "files/obj_parts.hpp"

#include <cageform/binding/skin_weights.hpp>
#include <cageform/exchange/gltf.hpp>

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
};

/// The texture coordinates of a file, which ObjFile leaves alone.
struct ObjTexture {
    std::vector<std::array<float, 2>> coordinates; // v downwards
    std::vector<std::vector<std::uint32_t>>
        of_face; // #faces, of every corner; ObjCorner::none where there is none
};

/// Fails where one is no numbers or is not there.
inline SvgResult<ObjTexture> read_texture(const ObjFile& file) {
    ObjTexture texture;
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
            texture.coordinates.push_back({float(st[0]), 1 - float(st[1])}); // 3.7.2.1: v counts from the top
        } else if (words[0] == "f") {
            auto& corners = texture.of_face.emplace_back();
            for (const std::string_view word : std::span(words).subspan(1)) {
                std::uint32_t& index = corners.emplace_back(ObjCorner::none);
                const std::size_t first = word.find('/'), second = word.find('/', first + 1);
                if (first == std::string_view::npos || first + 1 == std::min(second, word.size())) continue;
                const std::string why =
                    detail::parse_index(word.substr(first + 1, second - first - 1),
                                        texture.coordinates.size(), total, "texture", index);
                if (!why.empty()) return refuse(why);
            }
        }
    }
    return texture;
}

/// The meshes of a file, one an object: splits vertices as glTF needs it. Fails where the file has no
/// faces, or as read_texture() does.
inline SvgResult<std::vector<GltfMesh>> gltf_meshes(const ObjFile& file, const ObjParts& parts) {
    if (file.triangles.empty()) return SvgError{file.name + ": holds no faces"};
    const auto texture = read_texture(file);
    if (!texture) return texture.error();
    std::vector<GltfMesh> meshes;
    std::vector<std::vector<std::size_t>> of_object(parts.objects.size()); // triangles
    for (std::size_t t = 0; t < file.triangles.size(); ++t)
        of_object[parts.face_objects[file.triangle_faces[t]]].push_back(t);
    std::vector<std::uint32_t> place(file.vertices.size()); // of a vertex in the mesh
    for (std::size_t o = 0; o < of_object.size(); ++o) {
        GltfMesh mesh{parts.objects[o], {}, {}, {}};
        std::fill(place.begin(), place.end(), of_object.size() == 1 ? 0 : ObjCorner::none);
        for (const std::size_t t : of_object[o]) {
            for (const std::uint32_t vertex : file.triangles[t]) place[vertex] = 0;
        }
        for (std::uint32_t v = 0; v < file.vertices.size(); ++v) {
            if (place[v] == ObjCorner::none) continue;
            place[v] = std::uint32_t(mesh.corners.size());
            mesh.corners.push_back({v, ObjCorner::none, ObjCorner::none});
        }
        std::map<GltfMesh::Corner, std::uint32_t> known;
        std::vector<bool> met(mesh.corners.size()); // whether a corner has taken the vertex's own place
        std::map<std::uint32_t, std::size_t> part_of;
        for (const std::size_t t : of_object[o]) {
            const std::size_t f = file.triangle_faces[t];
            const ObjFace& face = file.faces[f];
            const auto [part, is_first] = part_of.insert({parts.face_materials[f], mesh.parts.size()});
            if (is_first) mesh.parts.push_back({parts.face_materials[f], {}});
            for (const std::uint32_t vertex : file.triangles[t]) {
                const auto at =
                    std::find_if(face.corners.begin(), face.corners.end(),
                                 [&](const ObjCorner& corner) { return corner.vertex == vertex; });
                const std::uint32_t st = texture->of_face[f][std::size_t(at - face.corners.begin())];
                const GltfMesh::Corner corner{vertex, at->normal, st};
                const std::uint32_t own = place[vertex];
                const auto next = std::uint32_t(met[own] ? mesh.corners.size() : own);
                const auto [index, added] = known.insert({corner, next});
                if (added && met[own]) mesh.corners.push_back(corner);
                if (added && !met[own]) mesh.corners[own] = corner;
                met[own] = true;
                mesh.parts[part->second].indices.push_back({index->second});
            }
        }
        if (!texture->coordinates.empty()) {
            for (const auto& corner : mesh.corners)
                mesh.texture.push_back(corner.texture == ObjCorner::none
                                           ? std::array<float, 2>{}
                                           : texture->coordinates[corner.texture]);
        }
        meshes.push_back(std::move(mesh));
    }
    return meshes;
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

/// Its normals then, of unit length: the file's turned with their faces; where there are none, the mean of
/// the faces about the vertex, weighted by area.
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

/// The attributes of a mesh at rest.
inline GltfJson gltf_attributes(GltfDocument& document, const GltfMesh& mesh, const ObjFile& file) {
    using Use = GltfDocument::Use;
    GltfJson attributes;
    attributes["POSITION"] = document.add(gltf_positions(mesh, file.vertices), Use::vertices, true);
    attributes["NORMAL"] = document.add(gltf_normals(mesh, file, file.vertices), Use::vertices);
    if (!mesh.texture.empty()) attributes["TEXCOORD_0"] = document.add(mesh.texture, Use::vertices);
    return attributes;
}

/// The primitives of a mesh, one a material, which share its attributes and its targets.
///
///   targets   null where there are none
inline GltfJson gltf_primitives(GltfDocument& document, const GltfMesh& mesh, const GltfJson& attributes,
                                const GltfJson& targets = {}) {
    GltfJson primitives = GltfJson::array();
    for (const GltfMesh::Part& part : mesh.parts) {
        std::size_t indices = 0;
        if (mesh.corners.size() < 65535) { // 3.7.2.1: the largest index is not a vertex
            std::vector<std::array<std::uint16_t, 1>> narrow;
            for (const auto& index : part.indices) narrow.push_back({std::uint16_t(index[0])});
            indices = document.add(narrow, GltfDocument::Use::indices);
        } else {
            indices = document.add(part.indices, GltfDocument::Use::indices);
        }
        GltfJson primitive = {{"attributes", attributes}, {"indices", indices}, {"material", part.material}};
        if (!targets.is_null()) primitive["targets"] = targets;
        primitives.push_back(std::move(primitive));
    }
    return primitives;
}

/// Appends the materials, with the pictures of their textures, which the file then holds. Returns warnings,
/// of pictures that are left out.
///
///   textured   whether the meshes have texture coordinates
inline std::vector<std::string> add_materials(GltfDocument& document, const ObjParts& parts, bool textured) {
    std::vector<std::string> warnings;
    std::map<std::string, std::optional<std::size_t>> known; // textures, of pictures
    const auto texture_of = [&](const ObjMaterial& material) -> std::optional<std::size_t> {
        const auto [place, is_new] = known.insert({material.texture, std::nullopt});
        if (!is_new) return place->second;
        const auto bytes = read_file(material.texture);
        const bool is_png = bytes && bytes->starts_with("\x89PNG\r\n\x1a\n");
        const bool is_jpeg = bytes && bytes->starts_with("\xff\xd8\xff");
        if (!is_png && !is_jpeg) {
            warnings.push_back(!bytes ? bytes.error().message
                                      : material.texture +
                                            ": is neither PNG nor JPEG, the formats of glTF: the material " +
                                            detail::quoted(material.name) + " is written without it");
            return std::nullopt;
        }
        const std::size_t image =
            document.append("images", {{"name", std::filesystem::path(material.texture).stem().string()},
                                       {"mimeType", is_png ? "image/png" : "image/jpeg"},
                                       {"bufferView", document.add_bytes(*bytes)}});
        place->second = document.append("textures", {{"source", image}});
        return place->second;
    };
    bool is_bright = false;
    for (const ObjMaterial& material : parts.materials) {
        const auto& c = material.colour;
        GltfJson pbr = {{"baseColorFactor", {c[0], c[1], c[2], material.opacity}},
                        {"metallicFactor", material.metallic},
                        {"roughnessFactor", material.roughness}};
        if (!material.texture.empty() && !textured) {
            warnings.push_back("the figure has no texture coordinates for the texture of the material " +
                               detail::quoted(material.name));
        } else if (!material.texture.empty()) {
            if (const auto texture = texture_of(material)) pbr["baseColorTexture"] = {{"index", *texture}};
        }
        GltfJson written = {{"name", material.name}, {"pbrMetallicRoughness", std::move(pbr)}};
        const auto& e = material.emission;
        if (const double most = std::max({e[0], e[1], e[2]}); most > 0) {
            const double scale = std::max(most, 1.0); // 3.9.3: factors end at 1
            written["emissiveFactor"] = {e[0] / scale, e[1] / scale, e[2] / scale};
            if (scale > 1) {
                written["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", scale}};
                is_bright = true;
            }
        }
        if (material.opacity < 1) written["alphaMode"] = "BLEND";
        written["doubleSided"] = true; // as OBJ files are drawn
        document.append("materials", std::move(written));
    }
    if (is_bright) document.json["extensionsUsed"].push_back("KHR_materials_emissive_strength");
    return warnings;
}

/// Some numbers through the keys of a clip as a sampler of an animation, CUBICSPLINE. Nothing is lost but
/// what single precision rounds.
///
///   values   of every key, `components` numbers
///   returns  as to_gltf_cubicspline()
inline cageform::Result<cageform::GltfTrack, cageform::ExchangeReport>
gltf_track(const PoseClip& clip, std::span<const double> values, std::size_t components) {
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

/// Appends the attributes of a skin, four joints a set: JOINTS_0, WEIGHTS_0, JOINTS_1, … Points without
/// weights are given to the joint `still`.
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
