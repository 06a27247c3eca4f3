#include "files/gltf_scene.hpp"

#include "files/gltf_animation.hpp"
#include "io/csv.hpp"
#include "svg/css_colour.hpp"

#include <cmath>
#include <set>
#include <tuple>
#include <utility>

namespace cageform_support {

Affine3 product(const Affine3& a, const Affine3& b) {
    Affine3 both;
    for (std::size_t k = 0; k < 3; ++k) both.columns[k] = a.map_vector(b.columns[k]);
    both.translation = mapped(a, b.translation);
    return both;
}

double determinant(const Affine3& a) {
    return dot(a.columns[0], cross(a.columns[1], a.columns[2]));
}

std::optional<Affine3> inverse(const Affine3& a) {
    const auto& [x, y, z] = a.columns;
    const double volume = determinant(a);
    const double most = std::sqrt(dot(x, x) * dot(y, y) * dot(z, z));
    if (!(std::fabs(volume) > 1e-14 * most) || !std::isfinite(1 / volume)) return std::nullopt;
    const Point3 rows[3] = {(1 / volume) * cross(y, z), (1 / volume) * cross(z, x),
                            (1 / volume) * cross(x, y)};
    Affine3 result;
    for (std::size_t k = 0; k < 3; ++k) result.columns[k] = {rows[0][k], rows[1][k], rows[2][k]};
    result.translation = -1.0 * result.map_vector(a.translation);
    return result;
}

Affine3 GltfTransform::map() const {
    if (matrix) return *matrix;
    const auto [x, y, z, w] = rotation;
    return {{scale[0] * Point3{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
             scale[1] * Point3{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
             scale[2] * Point3{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}},
            translation};
}

namespace {

std::string describe(const char* kind, std::size_t index, const GltfJson& object) {
    const auto name = object.find("name");
    std::string text = std::string(kind) + ' ' + std::to_string(index);
    if (name != object.end() && name->is_string()) text += ' ' + detail::quoted(name->get<std::string>());
    return text;
}

/// An index property; gltf_none if it is absent.
GltfIndex index_of(const GltfJson& object, const char* key, const std::string& user) {
    const auto found = object.find(key);
    if (found == object.end()) return gltf_none;
    const auto index = gltf_index(*found);
    if (!index) throw GltfFault(user + ": \"" + key + "\" is not an index");
    return *index;
}

std::vector<GltfIndex> indices_of(const GltfJson& object, const char* key, const std::string& user) {
    std::vector<GltfIndex> indices;
    if (!object.contains(key)) return indices;
    if (!object[key].is_array()) throw GltfFault(user + ": \"" + key + "\" is not a list");
    for (const GltfJson& value : object[key]) {
        const auto index = gltf_index(value);
        if (!index) throw GltfFault(user + ": \"" + key + "\" is not a list of indices");
        indices.push_back(*index);
    }
    return indices;
}

/// N finite numbers; false if the property is absent.
template <class Numbers>
bool read_numbers(const GltfJson& object, const char* key, Numbers& numbers, const std::string& user) {
    const auto found = object.find(key);
    if (found == object.end()) return false;
    if (!found->is_array() || found->size() != std::size(numbers))
        throw GltfFault(user + ": \"" + key + "\" is not a list of " + std::to_string(std::size(numbers)) +
                        " numbers");
    for (std::size_t k = 0; k < std::size(numbers); ++k) {
        if (!(*found)[k].is_number() || !std::isfinite((*found)[k].get<double>()))
            throw GltfFault(user + ": \"" + key + "\" holds a value that is not a number");
        numbers[k] = (*found)[k].get<double>();
    }
    return true;
}

/// An affine map from 16 numbers, column by column. The last row must be 0, 0, 0, 1.
Affine3 affine_of(std::span<const double> m, const std::string& user) {
    for (std::size_t k = 0; k < 4; ++k) {
        if (!(std::fabs(m[4 * k + 3] - (k == 3 ? 1 : 0)) < 1e-6))
            throw GltfFault(user + ": a matrix is not affine: its last row is not 0, 0, 0, 1");
    }
    Affine3 a;
    for (std::size_t k = 0; k < 3; ++k) a.columns[k] = {m[4 * k], m[4 * k + 1], m[4 * k + 2]};
    a.translation = {m[12], m[13], m[14]};
    return a;
}

/// The corners of a primitive's triangles, three per triangle (3.7.2.1).
std::vector<std::uint32_t> corners_of(const GltfDocument& document, const GltfJson& primitive,
                                      std::size_t vertices, const std::string& name) {
    const GltfIndex accessor = index_of(primitive, "indices", name);
    std::vector<std::uint32_t> list;
    if (accessor != gltf_none) {
        list = document.indices(accessor, name + ", indices");
    } else {
        list.resize(vertices);
        for (std::size_t i = 0; i < list.size(); ++i) list[i] = std::uint32_t(i);
    }
    for (const std::uint32_t index : list) {
        if (index >= vertices)
            throw GltfFault(name + ": refers to vertex " + std::to_string(index) + " of " +
                            std::to_string(vertices));
    }
    const GltfIndex given = index_of(primitive, "mode", name), mode = given == gltf_none ? 4 : given;
    if (mode > 6) throw GltfFault(name + ": there is no mode " + std::to_string(mode));
    if (mode == 4) list.resize(list.size() / 3 * 3);
    if (mode == 4) return list;
    std::vector<std::uint32_t> corners; // none for points and lines
    for (std::size_t i = 2; mode > 4 && i < list.size(); ++i) {
        const bool is_fan = mode == 6, is_odd = i % 2 == 1;
        corners.push_back(is_fan ? list[0] : list[is_odd ? i - 1 : i - 2]);
        corners.push_back(is_fan ? list[i - 1] : list[is_odd ? i - 2 : i - 1]);
        corners.push_back(list[i]);
    }
    return corners;
}

class SceneReader {
public:
    SceneReader(GltfScene& scene, MeshFile& mesh)
        : scene_(scene)
        , document_(scene.document)
        , mesh_(mesh) {}

    void read() {
        read_nodes();
        read_skins();
        mark_scene();
        for (GltfIndex n = 0; n < scene_.nodes.size(); ++n) {
            if (scene_.nodes[n].is_in_scene && scene_.nodes[n].mesh != gltf_none) read_mesh(n);
        }
        if (mesh_.vertices.empty()) throw GltfFault("the scene holds no vertices");
        finish();
    }

private:
    void read_nodes() {
        const GltfJson& list = document_.array("nodes");
        scene_.nodes.resize(list.size());
        for (GltfIndex n = 0; n < list.size(); ++n) {
            const GltfJson& json = document_.object("nodes", n, "the document");
            GltfNode& node = scene_.nodes[n];
            node.name = describe("node", n, json);
            node.mesh = index_of(json, "mesh", node.name);
            node.skin = index_of(json, "skin", node.name);
            node.children = indices_of(json, "children", node.name);
            if (json.contains("extensions") && json["extensions"].contains("EXT_mesh_gpu_instancing"))
                throw GltfFault(node.name + ": the extension \"EXT_mesh_gpu_instancing\" draws copies of its "
                                            "mesh, which is not supported");
            std::array<double, 16> matrix{};
            if (read_numbers(json, "matrix", matrix, node.name))
                node.rest.matrix = affine_of(matrix, node.name);
            read_numbers(json, "translation", node.rest.translation.v, node.name);
            read_numbers(json, "rotation", node.rest.rotation, node.name);
            if (node.rest.rotation == std::array<double, 4>{})
                throw GltfFault(node.name + ": \"rotation\" is zero");
            read_numbers(json, "scale", node.rest.scale.v, node.name);
        }
        for (GltfIndex n = 0; n < list.size(); ++n) {
            for (const GltfIndex child : scene_.nodes[n].children) {
                (void)document_.object("nodes", child, scene_.nodes[n].name);
                if (scene_.nodes[child].parent != gltf_none)
                    throw GltfFault(scene_.nodes[child].name + " has two parents");
                scene_.nodes[child].parent = n;
            }
        }
        refuse_cycles();
    }

    void refuse_cycles() const {
        std::vector<GltfIndex> seen(scene_.nodes.size(),
                                    gltf_none); // the start of the walk that met the node
        for (GltfIndex n = 0; n < scene_.nodes.size(); ++n) {
            GltfIndex at = n;
            for (; at != gltf_none && seen[at] == gltf_none; at = scene_.nodes[at].parent) seen[at] = n;
            if (at != gltf_none && seen[at] == n)
                throw GltfFault(scene_.nodes[at].name + " is its own ancestor");
        }
    }

    void read_skins() {
        const GltfJson& list = document_.array("skins");
        for (GltfIndex s = 0; s < list.size(); ++s) {
            const GltfJson& json = document_.object("skins", s, "the document");
            const std::string name = describe("skin", s, json);
            GltfSkin& skin = scene_.skins.emplace_back();
            skin.joints = indices_of(json, "joints", name);
            if (skin.joints.empty()) throw GltfFault(name + ": has no joints");
            for (const GltfIndex joint : skin.joints) (void)document_.object("nodes", joint, name);
            skin.inverse_binds.assign(skin.joints.size(), identity_map);
            const GltfIndex matrices = index_of(json, "inverseBindMatrices", name);
            if (matrices == gltf_none) continue;
            const GltfNumbers read = document_.numbers(matrices, {"MAT4"}, name);
            if (read.count() < skin.joints.size())
                throw GltfFault(name + ": has " + std::to_string(skin.joints.size()) + " joints, and " +
                                std::to_string(read.count()) + " inverse bind matrices");
            for (std::size_t j = 0; j < skin.joints.size(); ++j)
                skin.inverse_binds[j] = affine_of(std::span(read.numbers).subspan(16 * j, 16), name);
        }
    }

    void mark_scene() {
        const GltfJson& scenes = document_.array("scenes");
        std::vector<GltfIndex> open;
        if (scenes.empty()) {
            for (GltfIndex n = 0; n < scene_.nodes.size(); ++n) {
                if (scene_.nodes[n].parent == gltf_none) open.push_back(n);
            }
        } else {
            const GltfIndex own = index_of(document_.json, "scene", "the document");
            const GltfIndex index = own == gltf_none ? 0 : own;
            open = indices_of(document_.object("scenes", index, "the document"), "nodes",
                              "scene " + std::to_string(index));
        }
        while (!open.empty()) {
            const GltfIndex n = open.back();
            open.pop_back();
            (void)document_.object("nodes", n, "the scene");
            if (std::exchange(scene_.nodes[n].is_in_scene, true))
                throw GltfFault(scene_.nodes[n].name + " is in the scene twice");
            open.insert(open.end(), scene_.nodes[n].children.begin(), scene_.nodes[n].children.end());
        }
    }

    void read_mesh(GltfIndex n) {
        const GltfNode& node = scene_.nodes[n];
        const GltfJson& json = document_.object("meshes", node.mesh, node.name);
        if (node.skin != gltf_none) (void)document_.object("skins", node.skin, node.name);
        const std::string name = describe("mesh", node.mesh, json);
        if (!json.contains("primitives") || !json["primitives"].is_array())
            throw GltfFault(name + ": has no list of primitives");
        runs_of_node_.clear();
        for (std::size_t p = 0; p < json["primitives"].size(); ++p)
            read_primitive(n, json, p, name + ", primitive " + std::to_string(p));
    }

    void read_primitive(GltfIndex n, const GltfJson& mesh, std::size_t p, const std::string& name) {
        const GltfJson& primitive = mesh["primitives"][p];
        if (!primitive.is_object() || !primitive.contains("attributes") ||
            !primitive["attributes"].is_object())
            throw GltfFault(name + ": has no attributes");
        const GltfJson& attributes = primitive["attributes"];
        if (!attributes.contains("POSITION")) return; // 3.7.2.1: nothing is drawn
        GltfVertices run;
        run.node = n;
        run.mesh = scene_.nodes[n].mesh;
        run.position = index_of(attributes, "POSITION", name);
        run.normal = index_of(attributes, "NORMAL", name);
        run.tangent = index_of(attributes, "TANGENT", name);
        if (primitive.contains("targets")) {
            if (!primitive["targets"].is_array()) throw GltfFault(name + ": \"targets\" is not a list");
            for (const GltfJson& target : primitive["targets"]) {
                if (!target.is_object()) throw GltfFault(name + ": a target is not an object");
                run.targets.push_back({index_of(target, "POSITION", name), index_of(target, "NORMAL", name),
                                       index_of(target, "TANGENT", name)});
            }
        }
        const auto [known, is_new] =
            runs_of_node_.insert({{run.position, run.normal, run.tangent, run.targets}, scene_.runs.size()});
        if (is_new) {
            read_vertices(run, mesh, attributes, name);
            scene_.runs.push_back(std::move(run));
        }
        scene_.runs[known->second].primitives.push_back(p);
        add_faces(known->second, primitive, name);
    }

    /// The first three numbers of each element.
    ///
    ///   count   the expected number of elements; gltf_none: any
    std::vector<Point3> read_points(GltfIndex accessor, std::size_t count, const std::string& user,
                                    std::string_view type = "VEC3") const {
        const GltfNumbers read = document_.numbers(accessor, {type}, user);
        const bool is_quantised = read.component_type >= 5120 && read.component_type <= 5123;
        if (read.component_type != 5126 && !(is_quantised && document_.uses("KHR_mesh_quantization")))
            throw GltfFault(user + ": accessor " + std::to_string(accessor) + " does not hold floats");
        if (count != gltf_none && read.count() != count)
            throw GltfFault(user + " has " + std::to_string(read.count()) + " elements, POSITION has " +
                            std::to_string(count));
        std::vector<Point3> points(read.count());
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) points[i][k] = read.numbers[read.components * i + k];
            if (!cageform::is_finite(points[i]))
                throw GltfFault(user + ": element " + std::to_string(i) + " is not finite");
        }
        return points;
    }

    void read_vertices(GltfVertices& run, const GltfJson& mesh, const GltfJson& attributes,
                       const std::string& name) {
        run.first = mesh_.vertices.size();
        run.places = read_points(run.position, gltf_none, name + ", POSITION");
        const std::size_t count = run.places.size();
        const std::size_t most =
            std::min<std::size_t>(std::max(std::size_t{1} << 20, 4 * document_.file_size()),
                                  0xfffffffe); // since many nodes can use one mesh
        if (count > most - run.first)
            throw GltfFault("its nodes have more than " + std::to_string(most) + " vertices together");
        if (run.tangent != gltf_none) (void)read_points(run.tangent, count, name + ", TANGENT", "VEC4");
        read_targets(run, mesh, name);
        read_joints(run, attributes, name);
        mesh_.vertices.resize(run.first + count);
        std::vector<Point3> normals;
        if (run.normal != gltf_none) normals = read_points(run.normal, count, name + ", NORMAL");
        set_colours(run, attributes, name);
        mesh_.normals.resize(mesh_.vertices.size()); // in world space: finish()
        std::copy(normals.begin(), normals.end(), mesh_.normals.begin() + std::ptrdiff_t(run.first));
    }

    void read_targets(GltfVertices& run, const GltfJson& mesh, const std::string& name) {
        const std::string user = name + ", target ";
        const std::size_t count = run.count();
        for (std::size_t t = 0; t < run.targets.size(); ++t) {
            auto& places = run.target_places.emplace_back();
            const auto& [position, normal, tangent] = run.targets[t];
            if (position != gltf_none) places = read_points(position, count, user + std::to_string(t));
            for (const GltfIndex other : {normal, tangent}) {
                if (other != gltf_none) (void)read_points(other, count, user + std::to_string(t));
            }
        }
        run.weights.assign(run.targets.size(), 0.0);
        if (run.targets.empty()) return;
        for (const GltfJson* holder : {&mesh, &document_.json["nodes"][run.node]}) // 3.7.2.2
            read_numbers(*holder, "weights", run.weights, name);
    }

    void read_joints(GltfVertices& run, const GltfJson& attributes, const std::string& name) {
        const GltfIndex skin_index = scene_.nodes[run.node].skin;
        if (skin_index == gltf_none || !attributes.contains("JOINTS_0")) return;
        const GltfSkin& skin = scene_.skins[skin_index];
        const std::size_t count = run.count();
        std::vector<std::vector<double>> joints, weights;
        for (std::size_t set = 0; attributes.contains("JOINTS_" + std::to_string(set)); ++set) {
            const std::string number = std::to_string(set);
            for (auto [key, list] :
                 {std::pair("JOINTS_" + number, &joints), {"WEIGHTS_" + number, &weights}}) {
                const GltfIndex accessor = index_of(attributes, key.c_str(), name);
                if (accessor == gltf_none) throw GltfFault(name + ": " + key + " is missing");
                GltfNumbers read = document_.numbers(accessor, {"VEC4"}, name + ", " + key);
                if (list == &joints && read.component_type != 5121 && read.component_type != 5123)
                    throw GltfFault(name + ": " + key + " does not hold integers of 8 or 16 bits");
                list->push_back(std::move(read.numbers));
                if (list->back().size() != 4 * count)
                    throw GltfFault(name + ": " + key + " and POSITION have different counts");
            }
        }
        run.influences = 4 * joints.size();
        for (std::size_t i = 0; i < count; ++i) {
            double sum = 0;
            for (std::size_t k = 0; k < run.influences; ++k) {
                const double joint = joints[k / 4][4 * i + k % 4], weight = weights[k / 4][4 * i + k % 4];
                const bool is_used = weight != 0;
                if (is_used && !(joint < double(skin.joints.size())))
                    throw GltfFault(name + ": vertex " + std::to_string(i) + " follows joint " +
                                    detail::short_number(joint) + " of a skin with " +
                                    std::to_string(skin.joints.size()));
                run.joints.push_back(is_used ? std::uint32_t(joint) : 0);
                run.joint_weights.push_back(weight);
                sum += weight;
            }
            if (!(std::isfinite(sum) && sum > 0))
                throw GltfFault(name + ": the weights of vertex " + std::to_string(i) +
                                " have no positive sum");
            for (std::size_t k = 0; k < run.influences; ++k)
                run.joint_weights[i * run.influences + k] /= sum; // the sum is 1 up to rounding
        }
    }

    void set_colours(const GltfVertices& run, const GltfJson& attributes, const std::string& name) {
        const GltfIndex accessor = index_of(attributes, "COLOR_0", name);
        if (accessor == gltf_none) return;
        const GltfNumbers read = document_.numbers(accessor, {"VEC3", "VEC4"}, name + ", COLOR_0");
        mesh_.colours.resize(mesh_.vertices.size(), Point3{1, 1, 1});
        for (std::size_t i = 0; i < std::min(read.count(), run.count()); ++i) {
            for (std::size_t k = 0; k < 3; ++k)
                mesh_.colours[run.first + i][k] = to_displayed(read.numbers[read.components * i + k]);
        }
    }

    void add_faces(std::size_t r, const GltfJson& primitive, const std::string& name) {
        const GltfVertices& run = scene_.runs[r];
        const auto corners = corners_of(document_, primitive, run.count(), name);
        for (std::size_t n = 0; n < corners.size(); n += 3) {
            if (corners[n] == corners[n + 1] || corners[n + 1] == corners[n + 2] ||
                corners[n] == corners[n + 2])
                continue; // degenerate triangles connect strips
            MeshFace face;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto vertex = std::uint32_t(run.first + corners[n + k]);
                face.corners.push_back({vertex, run.normal == gltf_none ? MeshCorner::none : vertex});
            }
            mesh_.faces.push_back(std::move(face));
            run_of_face_.push_back(r);
        }
    }

    /// Sets positions and normals in world space, the orientation of faces, and guides.
    void finish() {
        const auto worlds = scene_.worlds(scene_.rest_pose());
        std::vector<bool> is_mirrored, is_joint(scene_.nodes.size());
        for (const GltfVertices& run : scene_.runs) {
            const auto maps = scene_.maps(run, worlds);
            for (std::size_t i = 0; i < run.count(); ++i) {
                const Affine3& map = maps[maps.size() == 1 ? 0 : i];
                mesh_.vertices[run.first + i] = mapped(map, GltfScene::morphed(run, run.weights, i));
                if (!cageform::is_finite(mesh_.vertices[run.first + i]))
                    throw GltfFault(scene_.nodes[run.node].name + ": vertex " + std::to_string(i) +
                                    " is not finite in world space");
                set_normal(run, map, mesh_.normals[run.first + i]);
            }
            is_mirrored.push_back(!maps.empty() && determinant(maps[0]) < 0);
            if (run.influences == 0) continue;
            for (const GltfIndex joint : scene_.skins[scene_.nodes[run.node].skin].joints) {
                if (!is_joint[joint]) scene_.joints.push_back(joint);
                is_joint[joint] = true;
            }
        }
        if (!mesh_.colours.empty()) mesh_.colours.resize(mesh_.vertices.size(), Point3{1, 1, 1});
        for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
            auto& corners = mesh_.faces[f].corners;
            if (is_mirrored[run_of_face_[f]]) std::swap(corners[1], corners[2]); // 3.7.4
        }
        if (std::none_of(scene_.runs.begin(), scene_.runs.end(),
                         [](const GltfVertices& run) { return run.normal != gltf_none; }))
            mesh_.normals.clear();
        for (const GltfIndex joint : scene_.joints) mesh_.guides.push_back(worlds[joint].translation);
        for (const GltfVertices& run : scene_.runs) add_target_ends(run, worlds);
    }

    static void set_normal(const GltfVertices& run, const Affine3& map, Point3& normal) {
        if (run.normal == gltf_none) return;
        const auto back = inverse(map);
        const Point3 n = back ? transposed_map(*back, normal) : normal;
        const double length = std::hypot(n[0], n[1], n[2]);
        if (length > 0 && std::isfinite(length)) normal = (1 / length) * n;
    }

    /// Appends to the guides, for each vertex and each morph target that moves it, the position at rest plus
    /// the displacement of the target.
    void add_target_ends(const GltfVertices& run, std::span<const Affine3> worlds) {
        const auto maps = run.targets.empty() ? std::vector<Affine3>() : scene_.maps(run, worlds);
        for (std::size_t i = 0; i < run.count() && !maps.empty(); ++i) {
            for (const auto& places : run.target_places) {
                if (places.empty() || places[i] == Point3{}) continue;
                mesh_.guides.push_back(mesh_.vertices[run.first + i] +
                                       maps[maps.size() == 1 ? 0 : i].map_vector(places[i]));
            }
        }
    }

    GltfScene& scene_;
    const GltfDocument& document_;
    MeshFile& mesh_;
    std::vector<std::size_t> run_of_face_;
    using Attributes = std::tuple<GltfIndex, GltfIndex, GltfIndex, std::vector<std::array<GltfIndex, 3>>>;
    std::map<Attributes, std::size_t> runs_of_node_; // of the current node
};

} // namespace

std::shared_ptr<const MeshDocument> GltfScene::with_faces_reversed() const {
    auto scene = std::make_shared<GltfScene>(*this);
    std::set<std::pair<GltfIndex, std::size_t>> done;
    for (const GltfVertices& run : runs) {
        for (const std::size_t p : run.primitives) {
            if (!done.insert({run.mesh, p}).second) continue;
            GltfJson& primitive = scene->document.json["meshes"][run.mesh]["primitives"][p];
            auto corners = corners_of(document, primitive, run.count(), "a primitive");
            if (corners.empty()) continue;
            std::vector<std::array<std::uint32_t, 1>> indices;
            for (std::size_t n = 0; n < corners.size(); ++n) // the first corner stays the first
                indices.push_back({corners[n % 3 == 0 ? n : n % 3 == 1 ? n + 1 : n - 1]});
            primitive["indices"] = scene->document.add(indices, GltfDocument::Use::indices);
            primitive.erase("mode"); // strips and fans become triangles
        }
    }
    return scene;
}

GltfPose GltfScene::rest_pose() const {
    GltfPose pose;
    for (const GltfNode& node : nodes) pose.nodes.push_back(node.rest);
    for (const GltfVertices& run : runs) pose.weights.push_back(run.weights);
    return pose;
}

std::vector<Affine3> GltfScene::worlds(const GltfPose& pose) const {
    std::vector<Affine3> worlds(nodes.size());
    std::vector<GltfIndex> open;
    for (GltfIndex n = 0; n < nodes.size(); ++n) {
        if (nodes[n].parent == gltf_none) open.push_back(n);
    }
    while (!open.empty()) { // parents come first
        const GltfIndex n = open.back();
        open.pop_back();
        const Affine3 own = pose.nodes[n].map();
        worlds[n] = nodes[n].parent == gltf_none ? own : product(worlds[nodes[n].parent], own);
        open.insert(open.end(), nodes[n].children.begin(), nodes[n].children.end());
    }
    return worlds;
}

std::vector<Affine3> GltfScene::maps(const GltfVertices& run, std::span<const Affine3> worlds) const {
    if (run.influences == 0) return {worlds[run.node]};
    const GltfSkin& skin = skins[nodes[run.node].skin];
    std::vector<Affine3> of_joint, maps;
    for (std::size_t j = 0; j < skin.joints.size(); ++j)
        of_joint.push_back(product(worlds[skin.joints[j]], skin.inverse_binds[j]));
    maps.reserve(run.count());
    for (std::size_t i = 0; i < run.count(); ++i) {
        Affine3& map = maps.emplace_back();
        for (std::size_t k = i * run.influences; k < (i + 1) * run.influences; ++k) {
            const double weight = run.joint_weights[k];
            if (weight == 0) continue;
            const Affine3& joint = of_joint[run.joints[k]];
            for (std::size_t axis = 0; axis < 3; ++axis)
                map.columns[axis] = map.columns[axis] + weight * joint.columns[axis];
            map.translation = map.translation + weight * joint.translation;
        }
    }
    return maps;
}

Point3 GltfScene::morphed(const GltfVertices& run, std::span<const double> weights, std::size_t vertex) {
    Point3 place = run.places[vertex];
    for (std::size_t t = 0; t < weights.size(); ++t) {
        if (weights[t] != 0 && !run.target_places[t].empty())
            place = place + weights[t] * run.target_places[t][vertex];
    }
    return place;
}

std::vector<Point3> GltfScene::positions(const GltfPose& pose) const {
    const auto of_nodes = worlds(pose);
    std::vector<Point3> places;
    for (std::size_t r = 0; r < runs.size(); ++r) {
        const auto to_world = maps(runs[r], of_nodes);
        for (std::size_t i = 0; i < runs[r].count(); ++i)
            places.push_back(
                mapped(to_world[to_world.size() == 1 ? 0 : i], morphed(runs[r], pose.weights[r], i)));
    }
    return places;
}

Expected<MeshFile> read_scene(GltfDocument document, const std::string& name) {
    const auto scene = std::make_shared<GltfScene>(std::move(document));
    MeshFile mesh;
    mesh.name = name;
    try {
        SceneReader(*scene, mesh).read();
        for (GltfIndex a = 0; a < scene->document.array("animations").size(); ++a) {
            if (const auto read = GltfAnimation::read(*scene, a, name); !read) return read.error();
        }
    } catch (const GltfFault& fault) {
        return FileError{name + ": " + fault.what()};
    } catch (const GltfJson::exception& fault) {
        return json_error(name, fault);
    }
    if (const std::string why = detail::triangulate(mesh); !why.empty()) return FileError{name + ": " + why};
    mesh.document = scene;
    return mesh;
}

Expected<MeshFile> parse_gltf(std::string bytes, const std::string& path) {
    auto document = GltfDocument::parse(std::move(bytes), path);
    if (!document) return document.error();
    return read_scene(std::move(*document), path);
}

} // namespace cageform_support
