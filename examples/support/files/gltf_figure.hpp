#pragma once

// Figures as glTF 2.0 documents, to which skins, skeletons and morph targets are added.
//
// The document of a .glb or .gltf file is kept; figures of other formats get a new one. Section numbers refer
// to the glTF 2.0 specification.

#include "files/gltf_scene.hpp"

namespace cageform_support {

/// Primitives of a node's mesh that share their vertices. No other node uses the mesh. An element is a vertex
/// of these primitives; several elements can belong to one vertex of the figure.
struct GltfSurface {
    GltfIndex node = 0, mesh = 0;
    std::vector<std::size_t> primitives; // of the mesh
    std::vector<MeshCorner> corners;     // #elements: vertex and normal of the figure
    std::vector<Affine3> maps; // from POSITION with morph targets added to world space: one, or #elements
    std::vector<std::array<std::uint32_t, 3>> triangles; // elements; empty without tangents
    std::vector<std::array<float, 2>> texture;           // #elements, v downwards; empty without tangents

    const Affine3& map(std::size_t element) const { return maps[maps.size() == 1 ? 0 : element]; }
};

/// A document with a figure at rest.
struct GltfFigure {
    GltfDocument document;
    std::vector<GltfSurface> surfaces;
    std::vector<std::string> warnings; // on materials of OBJ files
    std::vector<std::string> notes;    // on parts of the document that are replaced
    std::string unused;                // describe_unused() of an OBJ file
};

/// What a document keeps of its motion.
enum class GltfMotion : std::uint8_t {
    keep,         ///< skins, morph targets and animations
    without_skin, ///< morph targets and animations; vertices of skinned meshes are at rest
    drop          ///< nothing: all vertices are at rest
};

/// The document of a figure.
///
///   figure      as read from its file
///   generator   of new documents
///   returns     positions are relative to far_origin() in new documents
///   fails       if the figure has no faces, or its texture coordinates or document are invalid
Expected<GltfFigure> gltf_figure(const MeshFile& figure, const std::string& generator, GltfMotion motion);

/// gltf_figure() of a figure without a glTF document. Each object is a mesh, and each of its materials a
/// primitive. A vertex is a distinct combination of position, normal and texture coordinate at a corner.
/// Vertices are in the order of the file, followed by duplicates. The only mesh of a file has all vertices of
/// the file; one of several meshes has only those of its faces.
Expected<GltfFigure> figure_of_faces(const MeshFile& figure, const std::string& generator);

/// Unit normals of a surface after a deformation, in the space of POSITION. Without normals of the figure,
/// they are area-weighted means of the normals of adjacent faces.
std::vector<std::array<float, 3>> gltf_normals(const GltfSurface& surface, const MeshFile& figure,
                                               const MovedVertices& moved);

/// Tangents along u, perpendicular to the normals; the fourth number is the handedness (3.7.2.1). Empty for
/// surfaces without tangents.
///
///   places   #vertices of the figure
std::vector<std::array<float, 4>> gltf_tangents(const GltfSurface& surface, std::span<const Point3> places,
                                                std::span<const std::array<float, 3>> normals);

/// Appends a root node to the default scene; returns its index.
GltfIndex add_root(GltfDocument& document, GltfJson node);

/// Appends a sampler and a channel for a property of a node.
void add_channel(GltfJson& animation, GltfIndex node, const char* path, GltfIndex input,
                 const char* interpolation, GltfIndex output);

/// Appends an accessor of indices, in 16 bits if possible.
///
///   elements   number of vertices
GltfIndex add_indices(GltfDocument& document, std::span<const std::uint32_t> indices, std::size_t elements);

/// Appends an accessor with one number per element, such as the times of an animation.
GltfIndex add_scalars(GltfDocument& document, std::span<const double> values, bool has_bounds);

/// A pose of a figure.
struct GltfPoseTarget {
    std::string name;
    std::vector<Point3> places;         // #vertices of the figure
    std::vector<Jacobian3> jacobians{}; // #vertices, or empty if unknown
};

/// A node with morph targets.
struct GltfMorphs {
    GltfIndex node = 0;
    std::vector<double> weights; // of its previous targets at rest
};

/// Appends a morph target for each pose, with normals and tangents if the surfaces have them. Returns the
/// nodes; their previous targets keep their weights at rest and in animations. Fails if the transform of
/// a surface to world space is singular.
Expected<std::vector<GltfMorphs>> add_targets(GltfFigure& gltf, const MeshFile& figure,
                                              std::span<const GltfPoseTarget> poses);

/// "out.glb: 1 object, 2 materials, 512 vertices, 1024 triangles, 20 bones, 40000 bytes".
///
///   moved   such as "20 bones"
///   bytes   of the file
std::string describe_gltf(const std::string& path, const GltfFigure& gltf, const MeshFile& figure,
                          const std::string& moved, std::size_t bytes);

} // namespace cageform_support
