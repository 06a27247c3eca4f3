#pragma once

// Writes glTF 2.0: meshes from OBJ files, materials, skins, morph targets and animations.
//
// JSON and a binary buffer are written to one file: .gltf (buffer as base64 in the JSON) or .glb (binary).
// Section numbers refer to the glTF 2.0 specification.

#include "files/clip_file.hpp"
#include "files/gltf_document.hpp"
#include "files/obj_parts.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"

#include <cageform/binding/skin_weights.hpp>
#include <cageform/exchange/gltf.hpp>

namespace cageform_support {

/// A mesh with one vertex per distinct combination of position, normal and texture coordinate at a corner.
/// Vertices are in the order of the OBJ file, followed by duplicates. The only mesh of a file has all
/// vertices of the file; one of several meshes has only those of its faces.
struct GltfMesh {
    struct Corner {
        std::uint32_t vertex, normal, texture; // indices of the OBJ file, or MeshCorner::none
        friend auto operator<=>(const Corner&, const Corner&) = default;
    };
    /// The faces of a material.
    struct Part {
        std::uint32_t material = 0;                        // of the ObjParts
        std::vector<std::array<std::uint32_t, 1>> indices; // into `corners`, three per triangle
    };
    std::string name;
    std::vector<Corner> corners;               // #vertices
    std::vector<Part> parts;                   // in the order of their first faces
    std::vector<std::array<float, 2>> texture; // #vertices, v downwards; empty if the file has none
    bool takes_tangents = false;               // whether a material has a normal map
};

/// The texture coordinates of an OBJ file, which MeshFile does not parse.
struct ObjTexture {
    std::vector<std::array<float, 2>> coordinates;   // v downwards
    std::vector<std::vector<std::uint32_t>> of_face; // #faces · #corners, or MeshCorner::none
};

/// Fails on an invalid number or index.
Expected<ObjTexture> read_texture(const MeshFile& file);

/// One mesh per object of a file; splits vertices as glTF requires. Fails if the file has no faces, or as
/// read_texture().
Expected<std::vector<GltfMesh>> gltf_meshes(const MeshFile& file, const ObjParts& parts);

/// The positions of the mesh for the file's vertices at `places`.
std::vector<std::array<float, 3>> gltf_positions(const GltfMesh& mesh, std::span<const Point3> places);

/// Unit normals of the mesh after a deformation: those of the file; if it has none, area-weighted means of
/// adjacent faces.
std::vector<std::array<float, 3>> gltf_normals(const GltfMesh& mesh, const MeshFile& file,
                                               const MovedVertices& moved);

/// Tangents along u, perpendicular to the normals; the fourth number is the handedness (3.7.2.1). Empty for
/// meshes without normal maps.
std::vector<std::array<float, 4>> gltf_tangents(const GltfMesh& mesh, std::span<const Point3> places,
                                                std::span<const std::array<float, 3>> normals);

/// The attributes of a mesh at rest.
GltfJson gltf_attributes(GltfDocument& document, const GltfMesh& mesh, const MeshFile& file);

/// One primitive per material; the primitives share attributes and targets.
///
///   targets   null if there are none
GltfJson gltf_primitives(GltfDocument& document, const GltfMesh& mesh, const GltfJson& attributes,
                         const GltfJson& targets = {});

/// Appends the materials and embeds their images. alphaMode is BLEND if the opacity is below 1, or `map_d`
/// names the colour image and that image has alpha. Returns warnings on images that are not written.
///
///   textured   whether the meshes have texture coordinates
std::vector<std::string> add_materials(GltfDocument& document, const ObjParts& parts, bool textured);

/// Converts curve_through() of several numbers to a CUBICSPLINE sampler, exactly up to single precision.
///
///   values    #keys · components: the numbers at the keys
///   returns   as to_gltf_cubicspline()
cageform::Result<cageform::GltfTrack, cageform::ExchangeReport>
gltf_track(const PoseClip& clip, std::span<const double> values, std::size_t components);

/// Rounds weights to multiples of 2^-24, such that the weights of each point sum to exactly 1. An error of
/// the sum would move a point by that fraction of its distance from the origin.
void make_sums_exact(cageform::SkinWeights& skin);

/// Estimated rounding error of players that compute in single precision: four roundings of the largest
/// coordinate, in its units.
double single_precision_error(std::span<const Point3> places);

/// Number of sets of four joints with a nonzero weight.
inline std::size_t joint_sets(const cageform::SkinWeights& skin) {
    std::size_t most = 1;
    for (std::size_t n = 0; n < skin.weights.size(); ++n) {
        if (skin.weights[n] != 0) most = std::max(most, n % skin.influences + 1);
    }
    return (most + 3) / 4;
}

/// The skin as shown by players that read only the first set (four joints per vertex) and normalise its
/// weights.
cageform::SkinWeights first_set(const cageform::SkinWeights& skin);

/// Returns JOINTS_0, WEIGHTS_0, JOINTS_1, … with four joints per set. Points without weights get the joint
/// `still`. Sets without weights are omitted.
///
///   Index     std::uint8_t or std::uint16_t
///   weights   #points · influences: float, or normalised integers
template <class Index, class Weight>
GltfJson skin_attributes(GltfDocument& document, const GltfMesh& mesh, const cageform::SkinWeights& skin,
                         std::span<const Weight> weights, std::size_t still) {
    GltfJson attributes = GltfJson::object();
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
                // 3.7.3.3: unused entries have joint 0, also after rounding.
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
    return attributes;
}

} // namespace cageform_support
