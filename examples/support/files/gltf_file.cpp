#include "files/gltf_file.hpp"

#include "files/moved_normals.hpp"
#include "files/obj_file.hpp"
#include "svg/css_colour.hpp"

namespace cageform_support {

Expected<ObjTexture> read_texture(const MeshFile& file) {
    ObjTexture texture;
    std::vector<std::string_view> words;
    std::size_t line = 1, total = 0;
    const auto refuse = [&](const std::string& why) { return FileError{file.name + ": " + why, line}; };
    for (detail::ObjScanner scanner(file.text); scanner.next(words, line);) total += words[0] == "vt" ? 1 : 0;
    for (detail::ObjScanner scanner(file.text); scanner.next(words, line);) {
        if (words[0] == "vt") {
            std::array<double, 2> st{};
            for (std::size_t k = 0; k < 2 && k + 1 < words.size(); ++k) {
                const std::string why = detail::parse_number(words[k + 1], st[k]);
                if (!why.empty()) return refuse(why);
                if (!std::isfinite(float(st[k]))) return refuse("a texture coordinate is not finite");
            }
            texture.coordinates.push_back({float(st[0]), 1 - float(st[1])}); // 3.7.2.1: v is 0 at the top
        } else if (words[0] == "f") {
            auto& corners = texture.of_face.emplace_back();
            for (const std::string_view word : std::span(words).subspan(1)) {
                std::uint32_t& index = corners.emplace_back(MeshCorner::none);
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

Expected<std::vector<GltfMesh>> gltf_meshes(const MeshFile& file, const ObjParts& parts) {
    if (file.triangles.empty()) return FileError{file.name + ": holds no faces"};
    const auto texture = read_texture(file);
    if (!texture) return texture.error();
    std::vector<GltfMesh> meshes;
    std::vector<std::vector<std::size_t>> of_object(parts.objects.size()); // triangles
    for (std::size_t t = 0; t < file.triangles.size(); ++t)
        of_object[parts.face_objects[file.triangle_faces[t]]].push_back(t);
    std::vector<std::uint32_t> place(file.vertices.size()); // index in the mesh
    for (std::size_t o = 0; o < of_object.size(); ++o) {
        GltfMesh mesh{parts.objects[o], {}, {}, {}, false};
        std::fill(place.begin(), place.end(), of_object.size() == 1 ? 0 : MeshCorner::none);
        for (const std::size_t t : of_object[o]) {
            for (const std::uint32_t vertex : file.triangles[t]) place[vertex] = 0;
        }
        for (std::uint32_t v = 0; v < file.vertices.size(); ++v) {
            if (place[v] == MeshCorner::none) continue;
            place[v] = std::uint32_t(mesh.corners.size());
            mesh.corners.push_back({v, MeshCorner::none, MeshCorner::none});
        }
        std::map<GltfMesh::Corner, std::uint32_t> known;
        std::vector<bool> met(mesh.corners.size()); // whether a corner uses the vertex's own index
        std::map<std::uint32_t, std::size_t> part_of;
        for (const std::size_t t : of_object[o]) {
            const std::size_t f = file.triangle_faces[t];
            const MeshFace& face = file.faces[f];
            const auto [part, is_first] = part_of.insert({parts.face_materials[f], mesh.parts.size()});
            if (is_first) mesh.parts.push_back({parts.face_materials[f], {}});
            for (const std::uint32_t vertex : file.triangles[t]) {
                const auto at =
                    std::find_if(face.corners.begin(), face.corners.end(),
                                 [&](const MeshCorner& corner) { return corner.vertex == vertex; });
                const std::uint32_t st = texture->coordinates.empty()
                                             ? MeshCorner::none
                                             : texture->of_face[f][std::size_t(at - face.corners.begin())];
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
                mesh.texture.push_back(corner.texture == MeshCorner::none
                                           ? std::array<float, 2>{}
                                           : texture->coordinates[corner.texture]);
        }
        mesh.takes_tangents =
            !mesh.texture.empty() && std::any_of(mesh.parts.begin(), mesh.parts.end(), [&](const auto& part) {
                return !parts.materials[part.material].normal_texture.empty();
            });
        meshes.push_back(std::move(mesh));
    }
    return meshes;
}

void make_sums_exact(cageform::SkinWeights& skin) {
    constexpr double one = 1 << 24; // multiples of its inverse up to 1 are floats
    for (std::size_t first = 0; first < skin.weights.size(); first += skin.influences) {
        const auto weights = std::span(skin.weights).subspan(first, skin.influences);
        double sum = 0; // exact, like all numbers here
        for (float& weight : weights) {
            weight = float(std::round(one * double(weight)) / one);
            sum += double(weight);
        }
        float& largest = *std::max_element(weights.begin(), weights.end());
        if (largest > 0) largest = float(double(largest) + 1 - sum);
    }
}

cageform::SkinWeights first_set(const cageform::SkinWeights& skin) {
    cageform::SkinWeights first = skin;
    for (std::size_t begin = 0; begin < first.weights.size(); begin += first.influences) {
        const auto own = std::span(first.weights).subspan(begin, first.influences);
        float sum = 0;
        for (std::size_t k = 0; k < own.size(); ++k) sum += k < 4 ? own[k] : 0;
        for (std::size_t k = 0; k < own.size(); ++k) own[k] = k < 4 && sum > 0 ? own[k] / sum : 0;
    }
    return first;
}

double single_precision_error(std::span<const Point3> places) {
    constexpr double roundings = 4;
    return roundings * double(std::numeric_limits<float>::epsilon()) *
           cageform::bounds_of(places).magnitude();
}

std::vector<std::array<float, 3>> gltf_positions(const GltfMesh& mesh, std::span<const Point3> places) {
    std::vector<std::array<float, 3>> positions;
    for (const auto& corner : mesh.corners) {
        const Point3& p = places[corner.vertex];
        positions.push_back({float(p[0]), float(p[1]), float(p[2])});
    }
    return positions;
}

std::vector<std::array<float, 3>> gltf_normals(const GltfMesh& mesh, const MeshFile& file,
                                               const MovedVertices& moved) {
    const MovedNormals turned(file, moved);
    std::vector<Point3> smooth(file.vertices.size());
    for (const MeshFace& face : file.faces) {
        const Point3 area = detail::area_vector(face, moved.places);
        for (const MeshCorner& corner : face.corners) smooth[corner.vertex] = smooth[corner.vertex] + area;
    }
    std::vector<std::array<float, 3>> normals;
    for (const auto& corner : mesh.corners) {
        Point3 n = corner.normal == MeshCorner::none ? smooth[corner.vertex]
                                                     : turned.of_corner(corner.vertex, corner.normal);
        if (const double length = std::hypot(n[0], n[1], n[2]); length > 0 && std::isfinite(length))
            n = (1 / length) * n;
        else
            n = {0, 0, 1}; // arbitrary, since the faces have no area
        normals.push_back({float(n[0]), float(n[1]), float(n[2])});
    }
    return normals;
}

std::vector<std::array<float, 4>> gltf_tangents(const GltfMesh& mesh, std::span<const Point3> places,
                                                std::span<const std::array<float, 3>> normals) {
    std::vector<std::array<float, 4>> tangents;
    if (!mesh.takes_tangents) return tangents;
    std::vector<Point3> along_u(mesh.corners.size()), along_v(along_u); // sums over triangles
    for (const GltfMesh::Part& part : mesh.parts) {
        for (std::size_t n = 0; n < part.indices.size(); n += 3) {
            const std::array corners{part.indices[n][0], part.indices[n + 1][0], part.indices[n + 2][0]};
            std::array<Point3, 2> edges;
            std::array<std::array<double, 2>, 2> steps; // of u and v
            for (std::size_t k = 0; k < 2; ++k) {
                edges[k] =
                    places[mesh.corners[corners[k + 1]].vertex] - places[mesh.corners[corners[0]].vertex];
                for (std::size_t axis = 0; axis < 2; ++axis)
                    steps[k][axis] =
                        double(mesh.texture[corners[k + 1]][axis]) - double(mesh.texture[corners[0]][axis]);
            }
            const double side = std::copysign(1, steps[0][0] * steps[1][1] - steps[1][0] * steps[0][1]);
            for (const std::uint32_t corner : corners) {
                along_u[corner] = along_u[corner] + side * (steps[1][1] * edges[0] - steps[0][1] * edges[1]);
                along_v[corner] = along_v[corner] + side * (steps[0][0] * edges[1] - steps[1][0] * edges[0]);
            }
        }
    }
    for (std::size_t i = 0; i < along_u.size(); ++i) {
        const auto unit = [](const Point3& v) { return (1 / std::sqrt(dot(v, v))) * v; };
        const Point3 n =
            cageform::vec_cast<double>(cageform::Vec<float, 3>{normals[i][0], normals[i][1], normals[i][2]});
        Point3 tangent = along_u[i] - dot(along_u[i], n) * n;
        if (!(dot(tangent, tangent) > 0)) // arbitrary, since u has no direction
            tangent = std::fabs(n[0]) < 0.6 ? Point3{1, 0, 0} - n[0] * n : Point3{0, 1, 0} - n[1] * n;
        tangent = unit(tangent);
        const float side = dot(cross(n, tangent), along_v[i]) > 0 ? -1.0f : 1.0f; // v is downwards
        tangents.push_back({float(tangent[0]), float(tangent[1]), float(tangent[2]), side});
    }
    return tangents;
}

GltfJson gltf_attributes(GltfDocument& document, const GltfMesh& mesh, const MeshFile& file) {
    using Use = GltfDocument::Use;
    GltfJson attributes;
    attributes["POSITION"] = document.add(gltf_positions(mesh, file.vertices), Use::vertices, true);
    const auto normals = gltf_normals(mesh, file, {file.vertices});
    attributes["NORMAL"] = document.add(normals, Use::vertices);
    if (const auto tangents = gltf_tangents(mesh, file.vertices, normals); !tangents.empty())
        attributes["TANGENT"] = document.add(tangents, Use::vertices);
    if (!mesh.texture.empty()) attributes["TEXCOORD_0"] = document.add(mesh.texture, Use::vertices);
    if (file.colours.empty()) return attributes;
    std::vector<std::array<float, 3>> colours; // 3.7.2.1: linear
    for (const auto& corner : mesh.corners) {
        auto& colour = colours.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const double displayed = file.colours[corner.vertex][k];
            colour[k] = displayed > 0 ? float(to_linear(std::min(displayed, 1.0))) : 0.0f;
        }
    }
    attributes["COLOR_0"] = document.add(colours, Use::vertices);
    return attributes;
}

GltfJson gltf_primitives(GltfDocument& document, const GltfMesh& mesh, const GltfJson& attributes,
                         const GltfJson& targets) {
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

/// Whether a PNG file has alpha, in its pixels or for some colours (chunk tRNS; PNG 3rd edition, sections
/// 11.2.1 and 11.3.1).
bool png_has_alpha(std::string_view bytes) {
    constexpr std::size_t colour_type = 25;
    if (bytes.size() <= colour_type) return false;
    const std::string_view header = bytes.substr(0, bytes.find("IDAT"));
    return bytes[colour_type] == 4 || bytes[colour_type] == 6 || header.find("tRNS") != header.npos;
}

namespace {

struct Texture {
    std::optional<std::size_t> index;
    bool has_alpha = false;
};

/// Embeds images, each once.
struct TextureWriter {
    GltfDocument& document;
    bool textured; // whether the meshes have texture coordinates
    std::vector<std::string> warnings = {};
    std::map<std::string, Texture> known = {}; // by path of the image

    Texture add(const ObjMaterial& material, const std::string& picture) {
        if (picture.empty()) return {};
        if (!textured) {
            warnings.push_back("the figure has no texture coordinates for the texture " +
                               detail::quoted(std::filesystem::path(picture).filename().string()) +
                               " of the material " + detail::quoted(material.name));
            return {};
        }
        const auto [place, is_new] = known.insert({picture, Texture{}});
        if (!is_new) return place->second;
        const auto bytes = read_file(picture);
        const bool is_png = bytes && bytes->starts_with("\x89PNG\r\n\x1a\n");
        const bool is_jpeg = bytes && bytes->starts_with("\xff\xd8\xff");
        if (!is_png && !is_jpeg) {
            warnings.push_back(!bytes ? bytes.error().message
                                      : picture +
                                            ": is neither PNG nor JPEG, the formats of glTF: the material " +
                                            detail::quoted(material.name) + " is written without it");
            return {};
        }
        const std::size_t image =
            document.append("images", {{"name", std::filesystem::path(picture).stem().string()},
                                       {"mimeType", is_png ? "image/png" : "image/jpeg"},
                                       {"bufferView", document.add_bytes(*bytes)}});
        place->second = {document.append("textures", {{"source", image}}), is_png && png_has_alpha(*bytes)};
        return place->second;
    }
};

} // namespace

std::vector<std::string> add_materials(GltfDocument& document, const ObjParts& parts, bool textured) {
    TextureWriter textures{document, textured};
    bool is_bright = false;
    for (const ObjMaterial& material : parts.materials) {
        const auto& c = material.colour;
        GltfJson pbr = {{"baseColorFactor", {c[0], c[1], c[2], material.opacity}},
                        {"metallicFactor", material.metallic},
                        {"roughnessFactor", material.roughness}};
        const Texture of_colour = textures.add(material, material.texture);
        const bool see_through = of_colour.has_alpha && !material.opaque_texture;
        if (of_colour.index) pbr["baseColorTexture"] = {{"index", *of_colour.index}};
        if (of_colour.index && !material.opaque_texture && !see_through)
            textures.warnings.push_back(material.texture +
                                        ": has no alpha for the statement \"map_d\" of the material " +
                                        detail::quoted(material.name));
        GltfJson written = {{"name", material.name}, {"pbrMetallicRoughness", std::move(pbr)}};
        if (const auto normals = textures.add(material, material.normal_texture); normals.index)
            written["normalTexture"] = {{"index", *normals.index}};
        const Texture of_emission = textures.add(material, material.emission_texture);
        if (of_emission.index) written["emissiveTexture"] = {{"index", *of_emission.index}};
        constexpr std::array<double, 3> black{}, white{1, 1, 1};
        // The image is multiplied by Ke, which some programs omit or set to black.
        const auto& e = of_emission.index && material.emission == black ? white : material.emission;
        if (const double most = std::max({e[0], e[1], e[2]}); most > 0) {
            const double scale = std::max(most, 1.0); // 3.9.3: factors are at most 1
            written["emissiveFactor"] = {e[0] / scale, e[1] / scale, e[2] / scale};
            if (scale > 1) {
                written["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", scale}};
                is_bright = true;
            }
        }
        if (material.opacity < 1 || see_through) written["alphaMode"] = "BLEND";
        written["doubleSided"] = true; // as OBJ files are drawn
        document.append("materials", std::move(written));
    }
    if (is_bright) document.json["extensionsUsed"].push_back("KHR_materials_emissive_strength");
    return textures.warnings;
}

cageform::Result<cageform::GltfTrack, cageform::ExchangeReport>
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

} // namespace cageform_support
