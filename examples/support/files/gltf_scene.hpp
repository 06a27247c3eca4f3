#pragma once

// The scene of a glTF 2.0 document: nodes, vertices in world space, skins, morph targets and animations.
//
// Section numbers refer to the glTF 2.0 specification.

#include "files/gltf_document.hpp"

#include <cageform/core/types/handles.hpp>

#include <map>

namespace cageform_support {

using Affine3 = cageform::Transform<double, 3>;

inline constexpr Affine3 identity_map{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {0, 0, 0}};

inline Point3 mapped(const Affine3& a, const Point3& p) {
    return a.map_vector(p) + a.translation;
}
/// The map x ↦ a(b(x)).
Affine3 product(const Affine3& a, const Affine3& b);
/// The inverse; nothing if the map is singular.
std::optional<Affine3> inverse(const Affine3& a);
/// The transpose of the linear part times a vector.
inline Point3 transposed_map(const Affine3& a, const Point3& v) {
    return {dot(a.columns[0], v), dot(a.columns[1], v), dot(a.columns[2], v)};
}
double determinant(const Affine3& a);

/// The transform of a node (5.25): a matrix, or translation, rotation (x, y, z, w) and scale.
struct GltfTransform {
    Point3 translation{};
    std::array<double, 4> rotation{0, 0, 0, 1};
    Point3 scale{1, 1, 1};
    std::optional<Affine3> matrix;

    Affine3 map() const;
};

struct GltfNode {
    std::string name; // for messages: `node 3 "arm"`
    GltfIndex parent = gltf_none, mesh = gltf_none, skin = gltf_none;
    std::vector<GltfIndex> children;
    GltfTransform rest;
    bool is_in_scene = false;
};

struct GltfSkin {
    std::vector<GltfIndex> joints; // nodes
    std::vector<Affine3> inverse_binds;
};

/// A run: vertices of primitives of one node's mesh. These primitives have the same accessors of positions,
/// normals, tangents and morph targets. The vertices are consecutive in MeshFile::vertices.
struct GltfVertices {
    GltfIndex node = 0, mesh = 0;
    std::vector<std::size_t> primitives;                             // of the mesh
    GltfIndex position = 0, normal = gltf_none, tangent = gltf_none; // accessors
    std::vector<std::array<GltfIndex, 3>> targets;  // POSITION, NORMAL, TANGENT of each morph target
    std::size_t first = 0;                          // in MeshFile::vertices
    std::vector<Point3> places;                     // #vertices: POSITION
    std::vector<std::vector<Point3>> target_places; // #targets, #vertices; empty without POSITION
    std::vector<double> weights;                    // #targets: at rest
    std::size_t influences = 0;                     // per vertex; 0: no skin
    std::vector<std::uint32_t> joints;              // #vertices · influences
    std::vector<double> joint_weights;              // likewise

    std::size_t count() const { return places.size(); }
};

/// A pose of the nodes, and the weights of their morph targets.
struct GltfPose {
    std::vector<GltfTransform> nodes;         // #nodes
    std::vector<std::vector<double>> weights; // #runs
};

/// A document and its default scene.
class GltfScene final : public MeshDocument {
public:
    GltfDocument document;
    std::vector<GltfNode> nodes;
    std::vector<GltfSkin> skins;
    std::vector<GltfVertices> runs; // in the order of MeshFile::vertices
    std::vector<GltfIndex> joints;  // nodes of all skins in use, each once; guides begin with their origins

    explicit GltfScene(GltfDocument read)
        : document(std::move(read)) {}
    GltfScene(const GltfScene& other) = default;

    std::vector<std::string> extensions() const override { return {".glb", ".gltf"}; }
    Expected<MovedFile> moved(const MeshFile& mesh, const MovedVertices& moved,
                              const std::filesystem::path& path) const override;

    std::shared_ptr<const MeshDocument> with_faces_reversed() const override;

    GltfPose rest_pose() const;
    /// The world transforms of all nodes.
    std::vector<Affine3> worlds(const GltfPose& pose) const;
    /// The maps from POSITION, with morph targets added, to world space: one per vertex for skinned vertices,
    /// else one for all.
    std::vector<Affine3> maps(const GltfVertices& run, std::span<const Affine3> worlds) const;
    /// POSITION with morph targets added.
    static Point3 morphed(const GltfVertices& run, std::span<const double> weights, std::size_t vertex);
    /// World positions of all vertices.
    std::vector<Point3> positions(const GltfPose& pose) const;
};

/// Reads the default scene of a document.
///
///   name      of the file, prefix of messages
///   returns   the vertices of all primitives of the default scene in world space. A mesh that several nodes
///             use has vertices for each node. Its document is a GltfScene
///   fails     if the document is broken, or has no vertices in the scene
Expected<MeshFile> read_scene(GltfDocument document, const std::string& name);

/// The mesh without its skins: its document has the positions, normals and tangents at rest. Fails as
/// GltfScene::moved().
///
///   mesh   its document is a GltfScene
Expected<MeshFile> without_skins(const MeshFile& mesh);

/// As read_scene(), from the contents of a .gltf or .glb file.
Expected<MeshFile> parse_gltf(std::string bytes, const std::string& path);

} // namespace cageform_support
