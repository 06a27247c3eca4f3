#include "files/gltf_skeleton.hpp"

#include <cmath>
#include <set>

namespace cageform_support {

using Use = GltfDocument::Use;

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

std::size_t joint_sets(const cageform::SkinWeights& skin) {
    std::size_t most = 1;
    for (std::size_t n = 0; n < skin.weights.size(); ++n) {
        if (skin.weights[n] != 0) most = std::max(most, n % skin.influences + 1);
    }
    return (most + 3) / 4;
}

std::string describe_sets(std::size_t sets) {
    return "JOINTS_0 to JOINTS_" + std::to_string(sets - 1) +
           ": many players read only JOINTS_0, four joints per vertex; ";
}

GltfJoints add_joints(GltfDocument& document, const std::string& root_name, const Point3& origin,
                      std::span<const GltfJoint> joints) {
    GltfJson root = {{"name", root_name}};
    if (origin != Point3{}) root["translation"] = {origin[0], origin[1], origin[2]};
    GltfJoints added{add_root(document, std::move(root)), origin, {}, {}, {}};
    for (const GltfJoint& joint : joints) {
        const bool has_parent = joint.parent != GltfJoint::no_parent;
        const Point3 place = rounded_to_single(joint.place);
        const Point3 from = rounded_to_single(has_parent ? place - added.places[joint.parent] : place);
        added.places.push_back(place);
        added.nodes.push_back(
            document.append("nodes", {{"name", joint.name}, {"translation", {from[0], from[1], from[2]}}}));
        document.json["nodes"][has_parent ? added.axes[joint.parent] : added.root]["children"].push_back(
            added.nodes.back());
        added.axes.push_back(added.nodes.back());
        if (!joint.has_axes) continue;
        added.axes.back() = document.append("nodes", {{"name", joint.name + ", axes"}});
        document.json["nodes"][added.nodes.back()]["children"].push_back(added.axes.back());
    }
    return added;
}

namespace {

/// Adds skins with the same joints to surfaces.
class SkinAdder {
public:
    SkinAdder(GltfFigure& gltf, const GltfJoints& joints)
        : gltf_(gltf)
        , document_(gltf.document)
        , joints_(joints)
        , is_free_(document_.array("nodes").size(), true) {
        for (const GltfJson& node : document_.array("nodes")) {
            for (const GltfJson& child : node.value("children", GltfJson::array()))
                is_free_[child.get<GltfIndex>()] = false;
        }
        for (const GltfJson& animation : document_.array("animations")) {
            for (const GltfJson& channel : animation.value("channels", GltfJson::array())) {
                const GltfJson target = channel.value("target", GltfJson::object());
                const GltfIndex node = target.value("node", gltf_none);
                if (node < is_free_.size() && target.value("path", "") != "weights") is_free_[node] = false;
            }
        }
        for (GltfIndex n = 0; n < is_free_.size(); ++n) {
            for (const char* key : {"children", "camera", "extensions"})
                is_free_[n] = is_free_[n] && !document_.json["nodes"][n].contains(key);
        }
    }

    template <class Weight>
    void add(const cageform::SkinWeights& skin, std::span<const Weight> weights, std::size_t still) {
        for (GltfSurface& surface : gltf_.surfaces) {
            const GltfJson attributes =
                joints_.nodes.size() <= 256
                    ? skin_attributes<std::uint8_t>(document_, surface, skin, weights, still)
                    : skin_attributes<std::uint16_t>(document_, surface, skin, weights, still);
            for (const std::size_t p : surface.primitives) {
                GltfJson& own = document_.json["meshes"][surface.mesh]["primitives"][p]["attributes"];
                GltfJson others = GltfJson::object(); // than those of a previous skin
                for (const auto& [key, accessor] : own.items()) {
                    if (!key.starts_with("JOINTS_") && !key.starts_with("WEIGHTS_")) others[key] = accessor;
                }
                others.update(attributes);
                own = std::move(others);
                if (determinant(surface.map(0)) < 0) turn_faces(surface, p);
            }
            surface.node = free_node(surface.node);
            document_.json["nodes"][surface.node]["skin"] = skin_of(surface.map(0));
        }
    }

private:
    /// Reverses the faces of a primitive, since the transform of its node does not mirror it any more.
    void turn_faces(const GltfSurface& surface, std::size_t p) {
        GltfJson& primitive = document_.json["meshes"][surface.mesh]["primitives"][p];
        std::vector<std::uint32_t> list(surface.corners.size());
        for (std::size_t i = 0; i < list.size(); ++i) list[i] = std::uint32_t(i);
        if (primitive.contains("indices"))
            list = document_.indices(primitive["indices"].get<GltfIndex>(), "a primitive");
        const auto mode = primitive.value("mode", 4);
        if (mode < 4 || list.empty()) return; // points and lines
        if (mode == 5) list.insert(list.begin(), list.front());
        if (mode == 6) std::reverse(list.begin() + 1, list.end());
        for (std::size_t n = 0; mode == 4 && n + 2 < list.size(); n += 3) std::swap(list[n + 1], list[n + 2]);
        primitive["indices"] = add_indices(document_, list, surface.corners.size());
    }

    /// The node itself, without its transform, or a new root node with its mesh.
    GltfIndex free_node(GltfIndex n) {
        const auto known = moved_.find(n);
        if (known != moved_.end()) return known->second;
        GltfIndex& index = moved_[n] = n;
        if (is_free_[n]) {
            for (const char* key : {"translation", "rotation", "scale", "matrix"})
                document_.json["nodes"][n].erase(key);
            return n;
        }
        GltfJson old = document_.json["nodes"][n], fresh = GltfJson::object();
        if (old.contains("name")) fresh["name"] = old["name"];
        for (const char* key : {"mesh", "weights"}) {
            if (old.contains(key)) fresh[key] = old[key];
            old.erase(key);
        }
        document_.json["nodes"][n] = std::move(old);
        index = add_root(document_, std::move(fresh));
        if (!document_.array("animations").empty()) retarget_weights(n, index);
        return index;
    }

    void retarget_weights(GltfIndex from, GltfIndex to) {
        for (GltfJson& animation : document_.json["animations"]) {
            for (GltfJson& channel : animation["channels"]) {
                GltfJson& target = channel["target"];
                if (target.value("node", gltf_none) == from && target.value("path", "") == "weights")
                    target["node"] = to;
            }
        }
    }

    /// The skin of surfaces with this map.
    GltfIndex skin_of(const Affine3& map) {
        for (const auto& [known, skin] : skins_) {
            if (known.columns == map.columns && known.translation == map.translation) return skin;
        }
        std::vector<std::array<float, 16>> matrices;
        for (const Point3& place : joints_.places) {
            auto& matrix = matrices.emplace_back();
            const Point3 shift = map.translation - joints_.origin - place;
            for (std::size_t k = 0; k < 3; ++k) {
                for (std::size_t row = 0; row < 3; ++row) matrix[4 * k + row] = float(map.columns[k][row]);
                matrix[12 + k] = float(shift[k]);
            }
            matrix[15] = 1;
        }
        const GltfIndex skin =
            document_.append("skins", {{"inverseBindMatrices", document_.add(matrices, Use::other)},
                                       {"skeleton", joints_.root},
                                       {"joints", joints_.axes}});
        skins_.push_back({map, skin});
        return skin;
    }

    GltfFigure& gltf_;
    GltfDocument& document_;
    const GltfJoints& joints_;
    std::vector<bool> is_free_;            // #nodes: whether nothing but the mesh depends on the transform
    std::map<GltfIndex, GltfIndex> moved_; // nodes that have the meshes now
    std::vector<std::pair<Affine3, GltfIndex>> skins_;
};

} // namespace

void add_skin(GltfFigure& gltf, const GltfJoints& joints, const cageform::SkinWeights& skin,
              const std::string& weights, std::size_t still) {
    SkinAdder adder(gltf, joints);
    const auto add = [&]<class Weight>(const std::vector<Weight>& list) {
        adder.add(skin, std::span<const Weight>(list), still);
    };
    if (weights == "unorm8")
        add(cageform::to_normalised<std::uint8_t>(skin));
    else if (weights == "unorm16")
        add(cageform::to_normalised<std::uint16_t>(skin));
    else
        add(skin.weights);
}

namespace {

struct BoneAnimation {
    GltfDocument& document;
    GltfJson json;
    std::map<std::vector<double>, GltfIndex> inputs = {}; ///< accessors of times

    /// Appends the keys of a channel of a bone; a single key becomes the node's property.
    template <class V>
    void add(GltfIndex node, const char* path, const cageform::SkeletonKeys<double>::Channel<V>& keys) {
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
        if (is_new) input->second = add_scalars(document, keys.times, true);
        const bool cubic = !keys.in_tangents.empty();
        std::vector<std::array<float, size>> values;
        for (std::size_t k = 0; k < keys.times.size(); ++k) { // 3.11: in-tangent, value, out-tangent
            if (cubic) values.push_back(single(keys.in_tangents[k]));
            values.push_back(single(keys.values[k]));
            if (cubic) values.push_back(single(keys.out_tangents[k]));
        }
        add_channel(json, node, path, input->second, cubic ? "CUBICSPLINE" : "LINEAR",
                    document.add(values, Use::other));
    }
};

} // namespace

void add_skeleton(GltfFigure& gltf, const cageform::FittedSkeleton<double>& skeleton,
                  const cageform::SkeletonKeys<double>& keys, const std::string& weights,
                  const std::string& name, const Point3& origin) {
    std::vector<GltfJoint> joints;
    for (std::size_t b = 0; b < skeleton.bones; ++b) {
        const bool is_root = skeleton.parents[b] == cageform::FittedSkeleton<double>::no_parent;
        const auto& axes = keys.bones[b].axes; // of the bone's scale
        joints.push_back(
            {"bone " + std::to_string(b), skeleton.joints[b],
             is_root ? GltfJoint::no_parent : skeleton.parents[b],
             axes.times.size() > 1 || axes.values[0] != cageform::Quaternion<double>{0, 0, 0, 1}});
    }
    const GltfJoints added = add_joints(gltf.document, name, origin, joints);
    add_skin(gltf, added, skeleton.skin, weights, 0);
    BoneAnimation animation{gltf.document, {{"name", name}}};
    for (std::size_t b = 0; b < skeleton.bones; ++b) {
        const auto& bone = keys.bones[b];
        animation.add(added.nodes[b], "translation", bone.translation);
        animation.add(added.nodes[b], "rotation", bone.rotation);
        if (bone.scale.times.size() > 1 || bone.scale.values[0] != Point3{1, 1, 1})
            animation.add(added.nodes[b], "scale", bone.scale);
        if (joints[b].has_axes) animation.add(added.axes[b], "rotation", bone.axes);
    }
    if (animation.json.contains("channels")) gltf.document.append("animations", std::move(animation.json));
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

cageform::Status add_clip(GltfDocument& document, const PoseClip& clip, const std::string& name,
                          std::span<const GltfTrackOfNode> tracks) {
    GltfJson animation = {{"name", name}};
    GltfIndex input = gltf_none;
    for (const GltfTrackOfNode& track : tracks) {
        const auto [curves, made] = gltf_track(clip, track.values, track.components);
        if (made.status != cageform::Status::ok) return made.status;
        const std::vector<double> times(curves.times.begin(), curves.times.end()),
            values(curves.values.begin(), curves.values.end());
        if (input == gltf_none) input = add_scalars(document, times, true);
        GltfIndex output = gltf_none;
        if (std::string_view(track.path) == "translation") {
            std::vector<std::array<float, 3>> places;
            for (std::size_t i = 0; i < values.size(); i += 3)
                places.push_back({curves.values[i], curves.values[i + 1], curves.values[i + 2]});
            output = document.add(places, Use::other);
        } else {
            output = add_scalars(document, values, false);
        }
        add_channel(animation, track.node, track.path, input, "CUBICSPLINE", output);
    }
    document.append("animations", std::move(animation));
    return cageform::Status::ok;
}

} // namespace cageform_support
