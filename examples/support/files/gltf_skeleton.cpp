#include "files/gltf_skeleton.hpp"

namespace cageform_support {

void add_skinned_meshes(GltfDocument& document, std::span<const GltfMesh> meshes, const MeshFile& figure,
                        const cageform::SkinWeights& skin, const std::string& weights, std::size_t joints,
                        std::size_t still) {
    const auto add = [&]<class Weight>(const std::vector<Weight>& list) {
        for (const GltfMesh& mesh : meshes) {
            GltfJson attributes = gltf_attributes(document, mesh, figure);
            const std::span<const Weight> all(list);
            attributes.update(joints <= 256
                                  ? skin_attributes<std::uint8_t>(document, mesh, skin, all, still)
                                  : skin_attributes<std::uint16_t>(document, mesh, skin, all, still));
            document.append(
                "meshes", {{"name", mesh.name}, {"primitives", gltf_primitives(document, mesh, attributes)}});
        }
    };
    if (weights == "unorm8")
        add(cageform::to_normalised<std::uint8_t>(skin));
    else if (weights == "unorm16")
        add(cageform::to_normalised<std::uint16_t>(skin));
    else
        add(skin.weights);
}

std::string describe_sets(std::size_t sets) {
    return "JOINTS_0 to JOINTS_" + std::to_string(sets - 1) +
           ": many players read only JOINTS_0, four joints per vertex; ";
}

void set_origin(GltfJson& node, const Point3& origin) {
    if (origin != Point3{}) node["translation"] = {origin[0], origin[1], origin[2]};
}

std::vector<std::size_t> add_mesh_nodes(GltfDocument& document, std::span<const GltfMesh> meshes,
                                        bool has_skin, const Point3& origin) {
    std::vector<std::size_t> nodes;
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        GltfJson node = {{"name", meshes[m].name}, {"mesh", m}};
        if (has_skin)
            node["skin"] = 0;
        else
            set_origin(node, origin);
        nodes.push_back(document.append("nodes", std::move(node)));
    }
    return nodes;
}

std::array<double, 3> rounded(const Point3& p) {
    return {double(float(p[0])), double(float(p[1])), double(float(p[2]))};
}

std::array<float, 16> inverse_bind(const std::array<double, 3>& place) {
    return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -float(place[0]), -float(place[1]), -float(place[2]), 1};
}

void add_channel(GltfJson& animation, std::size_t node, const char* path, std::size_t input,
                 const char* interpolation, std::size_t output) {
    animation["samplers"].push_back({{"input", input}, {"interpolation", interpolation}, {"output", output}});
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", node}, {"path", path}}}});
}

namespace {

struct BoneAnimation {
    GltfDocument& document;
    GltfJson json;
    std::map<std::vector<double>, std::size_t> inputs = {}; ///< accessors of times

    /// Appends the keys of a channel of a bone; a single key becomes the node's property.
    template <class V>
    void add(std::size_t node, const char* path, const cageform::SkeletonKeys<double>::Channel<V>& keys) {
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
        add_channel(json, node, path, input->second, cubic ? "CUBICSPLINE" : "LINEAR",
                    document.add(values, GltfDocument::Use::other));
    }
};

} // namespace

void add_skeleton(GltfDocument& document, std::span<const GltfMesh> meshes,
                  const cageform::FittedSkeleton<double>& skeleton,
                  const cageform::SkeletonKeys<double>& keys, const std::string& name, const Point3& origin) {
    constexpr auto no_parent = cageform::FittedSkeleton<double>::no_parent;
    std::vector<std::size_t> roots = add_mesh_nodes(document, meshes, true);
    GltfJson top = {{"name", name}};
    set_origin(top, origin);
    roots.push_back(document.append("nodes", std::move(top)));
    std::vector<std::size_t> nodes, joints; // #bones; a joint differs if the bone's scale has its own axes
    std::vector<std::array<float, 16>> inverse;
    for (std::size_t b = 0; b < skeleton.bones; ++b) {
        const auto place = rounded(skeleton.joints[b]);
        const std::uint32_t parent = skeleton.parents[b];
        Point3 from = skeleton.joints[b];
        if (parent != no_parent) {
            const auto [x, y, z] = rounded(skeleton.joints[parent]);
            from = Point3{place[0], place[1], place[2]} - Point3{x, y, z};
        }
        const std::string own = "bone " + std::to_string(b);
        nodes.push_back(document.append("nodes", {{"name", own}, {"translation", rounded(from)}}));
        joints.push_back(nodes.back());
        document.json["nodes"][parent == no_parent ? roots.back() : joints[parent]]["children"].push_back(
            nodes.back());
        const auto& axes = keys.bones[b].axes;
        if (axes.times.size() > 1 || axes.values[0] != cageform::Quaternion<double>{0, 0, 0, 1}) {
            joints.back() = document.append("nodes", {{"name", own + ", axes"}});
            document.json["nodes"][nodes.back()]["children"].push_back(joints.back());
        }
        inverse.push_back(inverse_bind(place));
    }
    BoneAnimation animation{document, {{"name", name}}};
    for (std::size_t b = 0; b < skeleton.bones; ++b) {
        const auto& bone = keys.bones[b];
        animation.add(nodes[b], "translation", bone.translation);
        animation.add(nodes[b], "rotation", bone.rotation);
        if (bone.scale.times.size() > 1 || bone.scale.values[0] != Point3{1, 1, 1})
            animation.add(nodes[b], "scale", bone.scale);
        if (joints[b] != nodes[b]) animation.add(joints[b], "rotation", bone.axes);
    }
    document.append("skins", {{"inverseBindMatrices", document.add(inverse, GltfDocument::Use::other)},
                              {"skeleton", roots.back()},
                              {"joints", joints}});
    document.append("scenes", {{"nodes", roots}});
    if (animation.json.contains("channels")) document.append("animations", std::move(animation.json));
}

std::string describe_gltf(const std::string& path, std::span<const GltfMesh> meshes, const ObjParts& parts,
                          const MeshFile& figure, const std::string& moved, std::size_t bytes) {
    const auto count = [](std::size_t n, const char* thing) { return detail::counted(n, thing) + ", "; };
    std::size_t vertices = 0;
    for (const GltfMesh& mesh : meshes) vertices += mesh.corners.size();
    return path + ": " + count(meshes.size(), "object") + count(parts.materials.size(), "material") +
           std::to_string(vertices) + " vertices, " + std::to_string(figure.triangles.size()) +
           " triangles, " + moved + ", " + std::to_string(bytes) + " bytes";
}

} // namespace cageform_support
