#pragma once

// glTF 2.0: skinned meshes, skeletons and their animation.

#include "files/gltf_file.hpp"

#include <cageform/skeleton/fit_skeleton.hpp>

namespace cageform_support {

/// Appends meshes with the attributes of a skin.
///
///   weights   float, unorm8 or unorm16
///   joints    number of joints
///   still     joint of vertices without weights
void add_skinned_meshes(GltfDocument& document, std::span<const GltfMesh> meshes, const MeshFile& figure,
                        const cageform::SkinWeights& skin, const std::string& weights, std::size_t joints,
                        std::size_t still);

/// "JOINTS_0 to JOINTS_3: many players read only JOINTS_0, four joints per vertex; ": a note on skins with
/// several sets.
std::string describe_sets(std::size_t sets);

/// Sets the translation of a node, unless it is zero.
void set_origin(GltfJson& node, const Point3& origin);

/// Appends a node for each mesh, before all other nodes. Returns their indices.
///
///   has_skin   the mesh follows the skin; else the node gets the translation `origin`
std::vector<std::size_t> add_mesh_nodes(GltfDocument& document, std::span<const GltfMesh> meshes,
                                        bool has_skin, const Point3& origin = {});

/// A point rounded to single precision.
std::array<double, 3> rounded(const Point3& p);

/// The inverse bind matrix of a joint without rotation.
std::array<float, 16> inverse_bind(const std::array<double, 3>& place);

/// Appends a sampler and a channel for a property of a node.
void add_channel(GltfJson& animation, std::size_t node, const char* path, std::size_t input,
                 const char* interpolation, std::size_t output);

/// Appends the nodes of the meshes and of a skeleton, the skin and its animation. The meshes must have been
/// added with the skeleton's skin.
///
///   name     of the parent node of all bones
///   origin   its translation: origin of the skeleton's positions
void add_skeleton(GltfDocument& document, std::span<const GltfMesh> meshes,
                  const cageform::FittedSkeleton<double>& skeleton,
                  const cageform::SkeletonKeys<double>& keys, const std::string& name, const Point3& origin);

/// "out.glb: 1 object, 2 materials, 512 vertices, 1024 triangles, 20 bones, 40000 bytes".
///
///   moved   such as "20 bones"
///   bytes   of the file
std::string describe_gltf(const std::string& path, std::span<const GltfMesh> meshes, const ObjParts& parts,
                          const MeshFile& figure, const std::string& moved, std::size_t bytes);

} // namespace cageform_support
