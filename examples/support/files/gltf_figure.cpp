#include "files/gltf_figure.hpp"

#include "files/moved_normals.hpp"
#include "io/csv.hpp"

#include <cmath>
#include <set>

namespace cageform_support {

using Use = GltfDocument::Use;

namespace {

/// Makes the surfaces of the default scene.
class SurfaceMaker {
public:
    SurfaceMaker(const MeshFile& figure, const GltfScene& scene)
        : figure_(figure)
        , scene_(scene)
        , gltf_{scene.document, {}, {}, {}, {}} {}

    GltfFigure make(GltfMotion motion) {
        if (motion == GltfMotion::drop) gltf_.document.json.erase("animations");
        separate_meshes();
        const auto worlds = scene_.worlds(scene_.rest_pose());
        for (const GltfVertices& run : scene_.runs) {
            GltfSurface surface;
            surface.node = run.node;
            surface.mesh = gltf_.document.json["nodes"][run.node]["mesh"].get<GltfIndex>();
            surface.primitives = run.primitives;
            for (std::size_t i = 0; i < run.count(); ++i) {
                const auto vertex = std::uint32_t(run.first + i);
                surface.corners.push_back({vertex, run.normal == gltf_none ? MeshCorner::none : vertex});
            }
            surface.maps = scene_.maps(run, worlds);
            read_texture(run, surface);
            if (motion == GltfMotion::drop) drop_targets(run, surface);
            gltf_.surfaces.push_back(std::move(surface));
        }
        return std::move(gltf_);
    }

private:
    /// Copies meshes that several nodes use.
    void separate_meshes() {
        std::set<GltfIndex> used;
        for (const bool is_in_scene : {false, true}) {
            for (GltfIndex n = 0; n < scene_.nodes.size(); ++n) {
                const GltfNode& node = scene_.nodes[n];
                if (node.mesh == gltf_none || node.is_in_scene != is_in_scene) continue;
                if (used.insert(node.mesh).second || !is_in_scene) continue;
                gltf_.document.json["nodes"][n]["mesh"] =
                    gltf_.document.append("meshes", scene_.document.object("meshes", node.mesh, node.name));
            }
        }
    }

    /// Reads what tangents of deformed surfaces need.
    void read_texture(const GltfVertices& run, GltfSurface& surface) const {
        const GltfJson& attributes =
            scene_.document.json["meshes"][run.mesh]["primitives"][run.primitives[0]]["attributes"];
        if (run.tangent == gltf_none || run.normal == gltf_none || !attributes.contains("TEXCOORD_0")) return;
        const auto read = scene_.document.numbers(attributes["TEXCOORD_0"].get<GltfIndex>(), {"VEC2"},
                                                  scene_.nodes[run.node].name + ", TEXCOORD_0");
        if (read.count() != run.count()) return;
        for (std::size_t i = 0; i < run.count(); ++i)
            surface.texture.push_back({float(read.numbers[2 * i]), float(read.numbers[2 * i + 1])});
        for (const auto& [a, b, c] : figure_.triangles) {
            if (a < run.first || a - run.first >= run.count()) continue;
            const auto first = std::uint32_t(run.first);
            surface.triangles.push_back({a - first, b - first, c - first});
        }
    }

    /// Removes morph targets; the vertices stay where they are at rest.
    void drop_targets(const GltfVertices& run, const GltfSurface& surface) {
        if (run.targets.empty()) return;
        GltfJson& mesh = gltf_.document.json["meshes"][surface.mesh];
        for (GltfJson* holder : {&mesh, &gltf_.document.json["nodes"][run.node]}) holder->erase("weights");
        if (mesh.contains("extras") && mesh["extras"].is_object()) mesh["extras"].erase("targetNames");
        std::vector<std::array<float, 3>> places;
        for (std::size_t i = 0; i < run.count(); ++i) {
            const Point3 p = GltfScene::morphed(run, run.weights, i);
            places.push_back({float(p[0]), float(p[1]), float(p[2])});
        }
        const bool is_moved =
            std::any_of(run.weights.begin(), run.weights.end(), [](double weight) { return weight != 0; });
        const GltfIndex position = is_moved ? gltf_.document.add(places, Use::vertices, true) : run.position;
        for (const std::size_t p : run.primitives) {
            GltfJson& primitive = gltf_.document.json["meshes"][surface.mesh]["primitives"][p];
            primitive.erase("targets");
            primitive["attributes"]["POSITION"] = position;
        }
    }

    const MeshFile& figure_;
    const GltfScene& scene_;
    GltfFigure gltf_;
};

Expected<GltfFigure> figure_of_scene(const MeshFile& figure, GltfMotion motion) {
    const auto& scene = static_cast<const GltfScene&>(*figure.document);
    if (motion == GltfMotion::keep || scene.joints.empty()) return SurfaceMaker(figure, scene).make(motion);
    const auto baked = without_skins(figure);
    if (!baked) return baked.error();
    auto gltf = SurfaceMaker(*baked, static_cast<const GltfScene&>(*baked->document)).make(motion);
    gltf.notes.push_back(figure.name +
                         ": its skin is replaced, so its animations of joints no longer move its "
                         "vertices");
    return gltf;
}

} // namespace

Expected<GltfFigure> gltf_figure(const MeshFile& figure, const std::string& generator, GltfMotion motion) {
    if (dynamic_cast<const GltfScene*>(figure.document.get()) == nullptr)
        return figure_of_faces(figure, generator);
    if (figure.triangles.empty()) return FileError{figure.name + ": holds no faces"};
    try {
        return figure_of_scene(figure, motion);
    } catch (const GltfFault& fault) {
        return FileError{figure.name + ": " + fault.what()};
    } catch (const GltfJson::exception& fault) {
        return json_error(figure.name, fault);
    }
}

std::vector<std::array<float, 3>> gltf_normals(const GltfSurface& surface, const MeshFile& figure,
                                               const MovedVertices& moved) {
    const MovedNormals turned(figure, moved);
    std::vector<Point3> smooth(figure.vertices.size());
    for (const MeshFace& face : figure.faces) {
        const Point3 area = detail::area_vector(face, moved.places);
        for (const MeshCorner& corner : face.corners) smooth[corner.vertex] = smooth[corner.vertex] + area;
    }
    std::vector<std::array<float, 3>> normals;
    for (std::size_t i = 0; i < surface.corners.size(); ++i) {
        const MeshCorner& corner = surface.corners[i];
        Point3 n = corner.normal == MeshCorner::none ? smooth[corner.vertex]
                                                     : turned.of_corner(corner.vertex, corner.normal);
        n = transposed_map(surface.map(i), n);
        if (const double length = std::hypot(n[0], n[1], n[2]); length > 0 && std::isfinite(length))
            n = (1 / length) * n;
        else
            n = {0, 0, 1}; // arbitrary, since the faces have no area
        normals.push_back({float(n[0]), float(n[1]), float(n[2])});
    }
    return normals;
}

std::vector<std::array<float, 4>> gltf_tangents(const GltfSurface& surface, std::span<const Point3> places,
                                                std::span<const std::array<float, 3>> normals) {
    std::vector<std::array<float, 4>> tangents;
    if (surface.texture.empty()) return tangents;
    std::vector<Point3> along_u(surface.corners.size()), along_v(along_u); // sums over triangles
    for (const auto& corners : surface.triangles) {
        std::array<Point3, 2> edges;
        std::array<std::array<double, 2>, 2> steps; // of u and v
        for (std::size_t k = 0; k < 2; ++k) {
            edges[k] =
                places[surface.corners[corners[k + 1]].vertex] - places[surface.corners[corners[0]].vertex];
            for (std::size_t axis = 0; axis < 2; ++axis)
                steps[k][axis] =
                    double(surface.texture[corners[k + 1]][axis]) - double(surface.texture[corners[0]][axis]);
        }
        const double side = std::copysign(1, steps[0][0] * steps[1][1] - steps[1][0] * steps[0][1]);
        for (const std::uint32_t corner : corners) {
            along_u[corner] = along_u[corner] + side * (steps[1][1] * edges[0] - steps[0][1] * edges[1]);
            along_v[corner] = along_v[corner] + side * (steps[0][0] * edges[1] - steps[1][0] * edges[0]);
        }
    }
    for (std::size_t i = 0; i < along_u.size(); ++i) {
        const auto unit = [](const Point3& v) { return (1 / std::sqrt(dot(v, v))) * v; };
        const auto back = inverse(surface.map(i)).value_or(identity_map);
        const Point3 u = back.map_vector(along_u[i]), v = back.map_vector(along_v[i]);
        const Point3 n =
            cageform::vec_cast<double>(cageform::Vec<float, 3>{normals[i][0], normals[i][1], normals[i][2]});
        Point3 tangent = u - dot(u, n) * n;
        if (!(dot(tangent, tangent) > 0)) // arbitrary, since u has no direction
            tangent = std::fabs(n[0]) < 0.6 ? Point3{1, 0, 0} - n[0] * n : Point3{0, 1, 0} - n[1] * n;
        tangent = unit(tangent);
        const float side = dot(cross(n, tangent), v) > 0 ? -1.0f : 1.0f; // v is downwards
        tangents.push_back({float(tangent[0]), float(tangent[1]), float(tangent[2]), side});
    }
    return tangents;
}

GltfIndex add_root(GltfDocument& document, GltfJson node) {
    const GltfIndex index = document.append("nodes", std::move(node));
    if (!document.array("scenes").empty())
        document.json["scenes"][document.json.value("scene", GltfIndex{0})]["nodes"].push_back(index);
    return index;
}

void add_channel(GltfJson& animation, GltfIndex node, const char* path, GltfIndex input,
                 const char* interpolation, GltfIndex output) {
    animation["samplers"].push_back({{"input", input}, {"interpolation", interpolation}, {"output", output}});
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", node}, {"path", path}}}});
}

GltfIndex add_indices(GltfDocument& document, std::span<const std::uint32_t> indices, std::size_t elements) {
    const auto add = [&]<class Index>(Index) {
        std::vector<std::array<Index, 1>> list;
        for (const std::uint32_t index : indices) list.push_back({static_cast<Index>(index)});
        return document.add(list, Use::indices);
    };
    return elements < 65535 ? add(std::uint16_t{}) : add(std::uint32_t{}); // 3.7.2.1: not the largest
}

GltfIndex add_scalars(GltfDocument& document, std::span<const double> values, bool has_bounds) {
    std::vector<std::array<float, 1>> numbers;
    for (const double value : values) numbers.push_back({float(value)});
    return document.add(numbers, Use::other, has_bounds);
}

namespace {

/// The tangents of a surface without their handedness.
std::vector<std::array<float, 3>> directions(const GltfSurface& surface, std::span<const Point3> places,
                                             std::span<const std::array<float, 3>> normals) {
    std::vector<std::array<float, 3>> result;
    for (const auto& [x, y, z, side] : gltf_tangents(surface, places, normals)) result.push_back({x, y, z});
    return result;
}

std::vector<std::array<float, 3>> difference(std::vector<std::array<float, 3>> a,
                                             const std::vector<std::array<float, 3>>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) a[i][k] -= b[i][k];
    }
    return a;
}

/// Adds the differences between the poses of a surface and its state at rest. Returns their accessors.
GltfJson add_differences(GltfDocument& document, const GltfSurface& surface, const MeshFile& figure,
                         std::span<const GltfPoseTarget> poses) {
    const GltfJson attributes =
        document.json["meshes"][surface.mesh]["primitives"][surface.primitives[0]]["attributes"];
    std::vector<Affine3> back;
    for (const Affine3& map : surface.maps) {
        const auto to_surface = inverse(map);
        if (!to_surface)
            throw GltfFault("node " + std::to_string(surface.node) + ": its transform at rest is singular");
        back.push_back(*to_surface);
    }
    const auto normals = gltf_normals(surface, figure, {figure.vertices});
    const auto tangents = directions(surface, figure.vertices, normals);
    GltfJson targets = GltfJson::array();
    for (const GltfPoseTarget& pose : poses) {
        std::vector<std::array<float, 3>> steps;
        for (std::size_t i = 0; i < surface.corners.size(); ++i) {
            const std::uint32_t vertex = surface.corners[i].vertex;
            const Point3 step =
                back[back.size() == 1 ? 0 : i].map_vector(pose.places[vertex] - figure.vertices[vertex]);
            steps.push_back({float(step[0]), float(step[1]), float(step[2])});
        }
        GltfJson target = {{"POSITION", document.add(steps, Use::vertices, true)}};
        const auto moved = gltf_normals(surface, figure, {pose.places, pose.jacobians});
        if (attributes.contains("NORMAL"))
            target["NORMAL"] = document.add(difference(moved, normals), Use::vertices);
        if (!tangents.empty())
            target["TANGENT"] =
                document.add(difference(directions(surface, pose.places, moved), tangents), Use::vertices);
        targets.push_back(std::move(target));
    }
    return targets;
}

/// Extends the animations of a node's weights: each key of `targets` weights gets `added` zeros at its end.
void pad_keys(GltfDocument& document, GltfIndex node, std::size_t targets, std::size_t added) {
    for (GltfIndex a = 0; a < document.array("animations").size(); ++a) {
        GltfJson animation = document.json["animations"][a];
        for (GltfJson& channel : animation.at("channels")) {
            const GltfJson target = channel.value("target", GltfJson::object());
            if (target.value("node", gltf_none) != node || target.value("path", "") != "weights") continue;
            GltfJson sampler = animation.at("samplers").at(channel.at("sampler").get<GltfIndex>());
            const auto keys = document.numbers(sampler.at("output").get<GltfIndex>(), {"SCALAR"},
                                               "animation " + std::to_string(a));
            std::vector<double> padded;
            for (std::size_t n = 0; n < keys.numbers.size(); ++n) {
                padded.push_back(keys.numbers[n]);
                if ((n + 1) % targets == 0) padded.resize(padded.size() + added);
            }
            sampler["output"] = add_scalars(document, padded, false);
            animation["samplers"].push_back(std::move(sampler)); // others may use the old one
            channel["sampler"] = animation["samplers"].size() - 1;
        }
        document.json["animations"][a] = std::move(animation);
    }
}

/// Appends the names of new targets, unless the previous ones have none.
void add_names(GltfJson& mesh, std::size_t targets, std::span<const GltfPoseTarget> poses) {
    if (!mesh.contains("extras")) mesh["extras"] = GltfJson::object();
    if (!mesh["extras"].is_object()) return;
    GltfJson& names = mesh["extras"]["targetNames"];
    if (names.is_null()) names = GltfJson::array();
    for (std::size_t t = names.size(); t < targets; ++t) names.push_back("target " + std::to_string(t));
    for (const GltfPoseTarget& pose : poses) names.push_back(pose.name);
}

/// Extends the weights of a node and its mesh. Returns the previous weights at rest.
std::vector<double> add_weights(GltfDocument& document, GltfIndex node_index, GltfIndex mesh_index,
                                std::size_t targets, std::span<const GltfPoseTarget> poses) {
    GltfJson &mesh = document.json["meshes"][mesh_index], &node = document.json["nodes"][node_index];
    GltfJson weights = mesh.value("weights", GltfJson(std::vector<double>(targets)));
    const auto extend = [&](GltfJson& list) {
        for (std::size_t t = 0; t < poses.size(); ++t) list.push_back(0.0);
    };
    const auto before = node.value("weights", weights).get<std::vector<double>>();
    extend(weights);
    mesh["weights"] = std::move(weights);
    if (node.contains("weights")) extend(node["weights"]);
    add_names(mesh, targets, poses);
    if (targets > 0) pad_keys(document, node_index, targets, poses.size());
    return before;
}

} // namespace

Expected<std::vector<GltfMorphs>> add_targets(GltfFigure& gltf, const MeshFile& figure,
                                              std::span<const GltfPoseTarget> poses) {
    GltfDocument& document = gltf.document;
    std::vector<GltfMorphs> nodes;
    try {
        for (const GltfSurface& surface : gltf.surfaces) {
            const GltfJson added = add_differences(document, surface, figure, poses);
            std::size_t before = 0;
            for (const std::size_t p : surface.primitives) {
                GltfJson& targets = document.json["meshes"][surface.mesh]["primitives"][p]["targets"];
                before = targets.size();
                for (const GltfJson& target : added) targets.push_back(target);
            }
            const bool is_known = std::any_of(nodes.begin(), nodes.end(), [&](const GltfMorphs& node) {
                return node.node == surface.node;
            });
            if (!is_known)
                nodes.push_back(
                    {surface.node, add_weights(document, surface.node, surface.mesh, before, poses)});
        }
    } catch (const GltfFault& fault) {
        return FileError{figure.name + ": " + fault.what()};
    } catch (const GltfJson::exception& fault) {
        return json_error(figure.name, fault);
    }
    return nodes;
}

std::string describe_gltf(const std::string& path, const GltfFigure& gltf, const MeshFile& figure,
                          const std::string& moved, std::size_t bytes) {
    const auto count = [](std::size_t n, const char* thing) { return detail::counted(n, thing) + ", "; };
    std::size_t vertices = 0;
    std::set<GltfIndex> nodes;
    for (const GltfSurface& surface : gltf.surfaces) {
        vertices += surface.corners.size();
        nodes.insert(surface.node);
    }
    return path + ": " + count(nodes.size(), "object") +
           count(gltf.document.array("materials").size(), "material") + std::to_string(vertices) +
           " vertices, " + std::to_string(figure.triangles.size()) + " triangles, " + moved + ", " +
           std::to_string(bytes) + " bytes";
}

} // namespace cageform_support
