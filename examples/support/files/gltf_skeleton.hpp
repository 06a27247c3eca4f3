#pragma once

// glTF 2.0: meshes with a skin, a skeleton that turns, its animation, and the file's end.

#include "files/gltf_file.hpp"
#include "io/atomic_file.hpp"

#include <cageform/skeleton/fit_skeleton.hpp>

namespace cageform_support {

/// Appends meshes with the attributes of a skin.
///
///   weights   float, unorm8 or unorm16
///   joints    their number
///   still     the joint of vertices without weights
void add_skinned_meshes(GltfDocument& document, std::span<const GltfMesh> meshes, const ObjFile& figure,
                        const cageform::SkinWeights& skin, const std::string& weights, std::size_t joints,
                        std::size_t still);

/// "JOINTS_0 to JOINTS_3: many players read JOINTS_0 alone, four joints a vertex; "; for a note on a skin of
/// more than one set.
std::string describe_sets(std::size_t sets);

/// Gives a node a translation, unless this is zero.
void set_origin(GltfJson& node, const Point3& origin);

/// Appends a node for each mesh, the first of the document. Returns their numbers.
///
///   has_skin   the mesh follows the skin; else the node has the translation `origin`
std::vector<std::size_t> add_mesh_nodes(GltfDocument& document, std::span<const GltfMesh> meshes,
                                        bool has_skin, const Point3& origin = {});

/// A place as the buffers have it.
std::array<double, 3> rounded(const Point3& p);

/// The inverse matrix of a joint that is only moved to its place.
std::array<float, 16> inverse_bind(const std::array<double, 3>& place);

/// Appends a sampler and a channel that moves something of a node.
void add_channel(GltfJson& animation, std::size_t node, const char* path, std::size_t input,
                 const char* interpolation, std::size_t output);

namespace detail {

/// Appends keys of a bone's channel, or gives the node their only value. `inputs` has the times that there
/// are.
template <class V>
void add_keys(GltfDocument& document, GltfJson& animation, std::size_t node, const char* path,
              const typename cageform::SkeletonKeys<double>::Channel<V>& keys,
              std::map<std::vector<double>, std::size_t>& inputs) {
    constexpr std::size_t size = sizeof(V) / sizeof(double);
    const auto single = [](const V& value) {
        std::array<float, size> result{};
        for (std::size_t k = 0; k < size; ++k) result[k] = float(value[k]);
        return result;
    };
    if (keys.times.size() == 1) {
        document.json["nodes"][node][path] = single(keys.values[0]);
        return;
    }
    const auto [input, is_new] = inputs.insert({keys.times, 0});
    if (is_new) {
        std::vector<std::array<float, 1>> times;
        for (const double time : keys.times) times.push_back({float(time)});
        input->second = document.add(times, GltfDocument::Use::other, true);
    }
    const bool cubic = !keys.in_tangents.empty();
    std::vector<std::array<float, size>> values;
    for (std::size_t k = 0; k < keys.times.size(); ++k) { // 3.11: in-tangent, value, out-tangent
        if (cubic) values.push_back(single(keys.in_tangents[k]));
        values.push_back(single(keys.values[k]));
        if (cubic) values.push_back(single(keys.out_tangents[k]));
    }
    add_channel(animation, node, path, input->second, cubic ? "CUBICSPLINE" : "LINEAR",
                document.add(values, GltfDocument::Use::other));
}

} // namespace detail

/// Appends the nodes of the meshes and of a skeleton, the skin and its animation. The file's meshes have been
/// added with the skeleton's skin.
///
///   name     of the node above all bones
///   origin   its translation, from which the skeleton's places are counted
void add_skeleton(GltfDocument& document, std::span<const GltfMesh> meshes,
                  const cageform::FittedSkeleton<double>& skeleton,
                  const cageform::SkeletonKeys<double>& keys, const std::string& name, const Point3& origin);

/// "out.glb: 1 object, 2 materials, 512 vertices, 1024 triangles, 20 bones, 40000 bytes".
///
///   moved   such as "20 bones"
///   bytes   of the file
std::string describe_gltf(const std::string& path, std::span<const GltfMesh> meshes, const ObjParts& parts,
                          const ObjFile& figure, const std::string& moved, std::size_t bytes);

/// The bytes of a file, by its name .gltf or .glb; fails where they are more than the format allows.
Expected<std::string> gltf_bytes(const GltfDocument& document, const std::string& path);

} // namespace cageform_support
