// Makes glTF documents of figures with faces of any number of corners, such as OBJ files.

#include "files/gltf_figure.hpp"
#include "files/obj_file.hpp"
#include "files/obj_parts.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"
#include "svg/css_colour.hpp"

namespace cageform_support {

namespace {

/// The texture coordinates of an OBJ file, which MeshFile does not parse.
struct ObjTexture {
    std::vector<std::array<float, 2>> coordinates;   // v downwards
    std::vector<std::vector<std::uint32_t>> of_face; // #faces · #corners, or MeshCorner::none

    std::uint32_t of_corner(std::size_t face, std::size_t corner) const {
        return coordinates.empty() ? MeshCorner::none : of_face[face][corner];
    }
};

/// Fails on an invalid number or index.
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

/// The faces of a material.
struct Part {
    std::uint32_t material = 0;         // of the ObjParts
    std::vector<std::uint32_t> indices; // of elements, three per triangle
};

/// The vertices and faces of an object.
class SplitMesh {
public:
    std::vector<MeshCorner> corners;    // #elements
    std::vector<std::uint32_t> texture; // #elements: index of the ObjTexture, or MeshCorner::none
    std::vector<Part> parts;            // in the order of their first faces

    ///   triangles   of the object
    ///   takes_all   whether the mesh has all vertices of the file, or only those of its faces
    SplitMesh(const MeshFile& file, const ObjParts& of_file, const ObjTexture& coordinates,
              std::span<const std::size_t> triangles, bool takes_all) {
        std::vector<std::uint32_t> place(file.vertices.size(), takes_all ? 0 : MeshCorner::none);
        for (const std::size_t t : triangles) {
            for (const std::uint32_t vertex : file.triangles[t]) place[vertex] = 0;
        }
        for (std::uint32_t v = 0; v < file.vertices.size(); ++v) {
            if (place[v] == MeshCorner::none) continue;
            place[v] = std::uint32_t(corners.size());
            add({v, MeshCorner::none}, MeshCorner::none);
        }
        std::vector<bool> met(corners.size()); // whether a corner uses the vertex's own index
        std::map<std::array<std::uint32_t, 3>, std::uint32_t> known;
        std::map<std::uint32_t, std::size_t> part_of;
        for (const std::size_t t : triangles) {
            const std::size_t f = file.triangle_faces[t];
            const MeshFace& face = file.faces[f];
            const auto [part, is_first] = part_of.insert({of_file.face_materials[f], parts.size()});
            if (is_first) parts.push_back({of_file.face_materials[f], {}});
            for (const std::uint32_t vertex : file.triangles[t]) {
                const auto at =
                    std::find_if(face.corners.begin(), face.corners.end(),
                                 [&](const MeshCorner& corner) { return corner.vertex == vertex; });
                const std::uint32_t st = coordinates.of_corner(f, std::size_t(at - face.corners.begin()));
                const std::uint32_t own = place[vertex];
                const auto next = std::uint32_t(met[own] ? corners.size() : own);
                const auto [index, is_new] = known.insert({{vertex, at->normal, st}, next});
                if (is_new && met[own]) add(*at, st);
                if (is_new && !met[own]) {
                    corners[own] = *at;
                    texture[own] = st;
                }
                met[own] = true;
                parts[part->second].indices.push_back(index->second);
            }
        }
    }

private:
    void add(const MeshCorner& corner, std::uint32_t st) {
        corners.push_back(corner);
        texture.push_back(st);
    }
};

/// The attributes of a surface at rest.
///
///   figure    positions relative to the origin of the surface
///   texture   #elements, or empty
GltfJson add_attributes(GltfDocument& document, const GltfSurface& surface, const MeshFile& figure,
                        const std::vector<std::array<float, 2>>& texture) {
    using Use = GltfDocument::Use;
    GltfJson attributes;
    std::vector<std::array<float, 3>> positions;
    for (const MeshCorner& corner : surface.corners) {
        const Point3 p = figure.vertices[corner.vertex] - surface.maps[0].translation;
        positions.push_back({float(p[0]), float(p[1]), float(p[2])});
    }
    attributes["POSITION"] = document.add(positions, Use::vertices, true);
    const auto normals = gltf_normals(surface, figure, {figure.vertices});
    attributes["NORMAL"] = document.add(normals, Use::vertices);
    if (const auto tangents = gltf_tangents(surface, figure.vertices, normals); !tangents.empty())
        attributes["TANGENT"] = document.add(tangents, Use::vertices);
    if (!texture.empty()) attributes["TEXCOORD_0"] = document.add(texture, Use::vertices);
    if (figure.colours.empty()) return attributes;
    std::vector<std::array<float, 3>> colours; // 3.7.2.1: linear
    for (const MeshCorner& corner : surface.corners) {
        auto& colour = colours.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const double displayed = figure.colours[corner.vertex][k];
            colour[k] = displayed > 0 ? float(to_linear(std::min(displayed, 1.0))) : 0.0f;
        }
    }
    attributes["COLOR_0"] = document.add(colours, Use::vertices);
    return attributes;
}

/// One primitive per material; the primitives share attributes.
GltfJson add_primitives(GltfDocument& document, const SplitMesh& mesh, const GltfJson& attributes) {
    GltfJson primitives = GltfJson::array();
    for (const Part& part : mesh.parts) {
        primitives.push_back({{"attributes", attributes},
                              {"indices", add_indices(document, part.indices, mesh.corners.size())},
                              {"material", part.material}});
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

/// Appends the materials and embeds their images. alphaMode is BLEND if the opacity is below 1. It is also
/// BLEND if `map_d` names the colour image and this image has alpha. Returns warnings on images that are not
/// written.
///
///   textured   whether the meshes have texture coordinates
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

void add_object(GltfFigure& gltf, const MeshFile& figure, const ObjParts& parts, const ObjTexture& texture,
                const std::string& name, const SplitMesh& mesh, const Point3& origin) {
    GltfSurface surface;
    surface.corners = mesh.corners;
    surface.maps = {identity_map};
    surface.maps[0].translation = origin;
    std::vector<std::array<float, 2>> coordinates;
    for (const std::uint32_t st : mesh.texture) {
        if (texture.coordinates.empty()) break;
        coordinates.push_back(st == MeshCorner::none ? std::array<float, 2>{} : texture.coordinates[st]);
    }
    const bool takes_tangents =
        !coordinates.empty() && std::any_of(mesh.parts.begin(), mesh.parts.end(), [&](const Part& part) {
            return !parts.materials[part.material].normal_texture.empty();
        });
    for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
        surface.primitives.push_back(p);
        const auto& indices = mesh.parts[p].indices;
        for (std::size_t n = 0; takes_tangents && n < indices.size(); n += 3)
            surface.triangles.push_back({indices[n], indices[n + 1], indices[n + 2]});
    }
    if (takes_tangents) surface.texture = coordinates;
    GltfDocument& document = gltf.document;
    const GltfJson attributes = add_attributes(document, surface, figure, coordinates);
    surface.mesh = document.append(
        "meshes", {{"name", name}, {"primitives", add_primitives(document, mesh, attributes)}});
    GltfJson node = {{"name", name}, {"mesh", surface.mesh}};
    if (origin != Point3{}) node["translation"] = {origin[0], origin[1], origin[2]};
    surface.node = add_root(document, std::move(node));
    gltf.surfaces.push_back(std::move(surface));
}

} // namespace

Expected<GltfFigure> figure_of_faces(const MeshFile& figure, const std::string& generator) {
    if (figure.faces.empty())
        return FileError{figure.name + (figure.triangles.empty()
                                            ? ": holds no faces"
                                            : ": is a Medit mesh, which is not written as glTF")};
    const auto texture = read_texture(figure);
    if (!texture) return texture.error();
    const ObjParts parts = read_parts(figure);
    GltfFigure gltf{GltfDocument(generator), {}, parts.warnings, {}, describe_unused(parts)};
    gltf.document.json["scene"] = 0;
    gltf.document.append("scenes", {{"nodes", GltfJson::array()}});
    const auto warnings = add_materials(gltf.document, parts, !texture->coordinates.empty());
    gltf.warnings.insert(gltf.warnings.end(), warnings.begin(), warnings.end());
    std::vector<std::vector<std::size_t>> of_object(parts.objects.size()); // triangles
    for (std::size_t t = 0; t < figure.triangles.size(); ++t)
        of_object[parts.face_objects[figure.triangle_faces[t]]].push_back(t);
    const Point3 origin = far_origin(figure);
    for (std::size_t o = 0; o < of_object.size(); ++o) {
        const SplitMesh mesh(figure, parts, *texture, of_object[o], of_object.size() == 1);
        add_object(gltf, figure, parts, *texture, parts.objects[o], mesh, origin);
    }
    return gltf;
}

} // namespace cageform_support
