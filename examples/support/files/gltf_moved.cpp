// Writes a glTF document with moved vertices.

#include "files/gltf_scene.hpp"
#include "files/moved_normals.hpp"
#include "io/csv.hpp"

#include <cmath>
#include <set>

namespace cageform_support {

namespace {

/// The moved attributes of the vertices of a run, in the space of its node or skin.
struct MovedRun {
    std::vector<std::array<float, 3>> places, normals; // attributes without an accessor are empty
    std::vector<std::array<float, 4>> tangents;
    // #targets: displacements of POSITION, NORMAL and TANGENT
    std::vector<std::array<std::vector<std::array<float, 3>>, 3>> targets;
    bool operator==(const MovedRun&) const = default;
};

double norm(const Point3& v) {
    return std::sqrt(dot(v, v));
}

Point3 unit(const Point3& v) {
    const double length = norm(v);
    return length > 0 && std::isfinite(length) ? (1 / length) * v : v;
}

std::array<float, 3> single(const Point3& p) {
    return {float(p[0]), float(p[1]), float(p[2])};
}

Point3 mapped_vector(const Jacobian3& jacobian, const Point3& v) {
    return v[0] * jacobian[0] + v[1] * jacobian[1] + v[2] * jacobian[2];
}

/// J⁻ᵀ v, up to a positive factor.
Point3 cofactors_times(const Jacobian3& jacobian, const Point3& v) {
    const auto& [a, b, c] = jacobian;
    const Point3 across = cross(b, c);
    const double side = std::copysign(1, dot(a, across));
    return side * (v[0] * across + v[1] * cross(c, a) + v[2] * cross(a, b));
}

class SceneMover {
public:
    SceneMover(const GltfScene& scene, const MeshFile& mesh, const MovedVertices& moved)
        : scene_(scene)
        , mesh_(mesh)
        , moved_(moved)
        , document_(scene.document)
        , worlds_(scene.worlds(scene.rest_pose()))
        , normals_(mesh, moved)
        , shifts_(scene.nodes.size())
        , rounding_(16 * std::numeric_limits<double>::epsilon() *
                    cageform::bounds_of(std::span<const Point3>(mesh.vertices)).magnitude()) {}

    Expected<MovedFile> write(const std::filesystem::path& path) {
        auto files = moved_document().files(path);
        if (!files) return files.error();
        return MovedFile{std::move(*files), notes()};
    }

    /// Moves the vertices; returns the output.
    const GltfDocument& moved_document() {
        count_uses();
        if (moved_.drops_skins) drop_skins();
        if (!moved_.drops_skins && !moved_.guides.empty()) move_joints();
        std::vector<MovedRun> runs;
        next_end_ = scene_.joints.size();
        for (const GltfVertices& run : scene_.runs) runs.push_back(moved_run(run));
        store(runs);
        return document_;
    }

private:
    // ---- joints ----

    void drop_skins() {
        for (const GltfVertices& run : scene_.runs) {
            if (run.influences == 0) continue;
            document_.json["nodes"][run.node].erase("skin");
            for (const std::size_t p : run.primitives) {
                GltfJson& attributes = document_.json["meshes"][run.mesh]["primitives"][p]["attributes"];
                for (std::size_t set = 0; set < run.influences / 4; ++set) {
                    attributes.erase("JOINTS_" + std::to_string(set));
                    attributes.erase("WEIGHTS_" + std::to_string(set));
                }
            }
        }
        const GltfJson& nodes = document_.array("nodes");
        const auto has_skin = [](const GltfJson& node) { return node.contains("skin"); };
        if (std::none_of(nodes.begin(), nodes.end(), has_skin)) document_.json.erase("skins");
    }

    /// Moves the origins of joints with the cage. Rotations and scales stay, so that animations play. Inverse
    /// bind matrices follow, so that the skin at rest stays.
    void move_joints() {
        std::vector<bool> is_joint(scene_.nodes.size());
        for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
            is_joint[scene_.joints[j]] = true;
            if (!is_same_place(mesh_.guides[j], moved_.guides[j]))
                shifts_[scene_.joints[j]] = moved_.guides[j] - mesh_.guides[j];
        }
        compare_shifts();
        std::vector<GltfIndex> open;
        for (GltfIndex n = 0; n < scene_.nodes.size(); ++n) {
            if (scene_.nodes[n].parent == gltf_none) open.push_back(n);
        }
        while (!open.empty()) { // parents come first
            const GltfIndex n = open.back();
            open.pop_back();
            const GltfNode& node = scene_.nodes[n];
            open.insert(open.end(), node.children.begin(), node.children.end());
            const Point3 of_parent = node.parent == gltf_none ? Point3{} : shifts_[node.parent];
            if (!is_joint[n]) shifts_[n] = of_parent;
            if (shifts_[n] == of_parent) continue;
            const auto to_parent = node.parent == gltf_none ? identity_map : inverse(worlds_[node.parent]);
            if (to_parent)
                move_node(n, to_parent->map_vector(shifts_[n] - of_parent));
            else
                shifts_[n] = of_parent; // the parent's transform is singular
        }
        for (GltfIndex s = 0; s < scene_.skins.size(); ++s) move_binds(s);
        move_keys();
    }

    /// Sets common_shift_ if all joints move by one translation. Else sets skeleton_scale_, the ratio of the
    /// root mean square distances of joints from their centroid.
    void compare_shifts() {
        Point3 middle{}, moved_middle{};
        const double share = 1 / double(scene_.joints.size());
        for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
            middle = middle + share * mesh_.guides[j];
            moved_middle = moved_middle + share * moved_.guides[j];
        }
        double before = 0, after = 0;
        bool is_translation = true;
        for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
            const Point3 from = mesh_.guides[j] - middle, to = moved_.guides[j] - moved_middle;
            before += dot(from, from);
            after += dot(to, to);
            is_translation = is_translation && norm(to - from) <= rounding_;
        }
        if (is_translation)
            common_shift_ = moved_middle - middle;
        else if (before > 0 && after > 0)
            skeleton_scale_ = std::sqrt(after / before);
    }

    void move_node(GltfIndex n, const Point3& step) {
        GltfJson& node = document_.json["nodes"][n];
        if (scene_.nodes[n].rest.matrix) {
            for (std::size_t k = 0; k < 3; ++k)
                node["matrix"][12 + k] = scene_.nodes[n].rest.matrix->translation[k] + step[k];
        } else {
            const Point3 place = scene_.nodes[n].rest.translation + step;
            node["translation"] = {place[0], place[1], place[2]};
        }
        steps_[n] = step;
    }

    /// The step of the node whose translation a channel animates; null if the node does not move.
    const Point3* step_of(const GltfJson& channel) const {
        const GltfJson target = channel.value("target", GltfJson::object());
        const auto step = steps_.find(target.value("node", gltf_none));
        return step != steps_.end() && target.value("path", "") == "translation" ? &step->second : nullptr;
    }

    /// Moves the keys of translations of moved nodes. Channels of all animations may share accessors.
    void move_keys() {
        for (const GltfJson& animation : document_.array("animations")) {
            for (const GltfJson& channel : animation.at("channels")) {
                const auto& sampler = animation.at("samplers").at(channel.at("sampler").get<GltfIndex>());
                if (step_of(channel) == nullptr)
                    kept_accessors_.insert(sampler.at("output").get<GltfIndex>());
            }
        }
        for (GltfIndex a = 0; a < document_.array("animations").size(); ++a) {
            GltfJson& animation = document_.json["animations"][a];
            std::map<GltfIndex, std::size_t> users; // of samplers
            for (const GltfJson& channel : animation["channels"])
                ++users[channel["sampler"].get<GltfIndex>()];
            for (GltfJson& channel : animation["channels"]) {
                if (const Point3* const step = step_of(channel))
                    move_channel(animation, channel, users[channel["sampler"].get<GltfIndex>()] > 1, *step,
                                 "animation " + std::to_string(a));
            }
        }
    }

    void move_channel(GltfJson& animation, GltfJson& channel, bool shares_sampler, const Point3& step,
                      const std::string& name) {
        GltfJson& samplers = animation["samplers"];
        GltfIndex sampler = channel["sampler"].get<GltfIndex>();
        const bool is_cubic = samplers[sampler].value("interpolation", "LINEAR") == "CUBICSPLINE";
        const GltfIndex output = samplers[sampler]["output"].get<GltfIndex>();
        const GltfNumbers keys = scene_.document.numbers(output, {"VEC3"}, name);
        const GltfTransform& node = scene_.nodes[channel["target"]["node"].get<GltfIndex>()].rest;
        const Point3 rest = node.matrix ? node.matrix->translation : node.translation,
                     moved_rest = rest + step;
        std::vector<std::array<float, 3>> values;
        for (std::size_t i = 0; i < keys.count(); ++i) {
            Point3 key{keys.numbers[3 * i], keys.numbers[3 * i + 1], keys.numbers[3 * i + 2]};
            const bool is_value = !is_cubic || i % 3 == 1; // else a tangent
            values.push_back(
                single(is_value ? moved_rest + skeleton_scale_ * (key - rest) : skeleton_scale_ * key));
        }
        const GltfIndex index = stored<3>(output, values, GltfDocument::Use::other);
        if (index != output && shares_sampler) {
            samplers.push_back(samplers[sampler]);
            channel["sampler"] = sampler = samplers.size() - 1;
        }
        samplers[sampler]["output"] = index;
    }

    void move_binds(GltfIndex s) {
        const GltfSkin& skin = scene_.skins[s];
        std::vector<std::array<float, 16>> matrices;
        bool is_moved = false;
        for (std::size_t j = 0; j < skin.joints.size(); ++j) {
            Affine3 bind = skin.inverse_binds[j];
            const Point3 shift = shifts_[skin.joints[j]] - common_shift_;
            if (const auto to_joint = inverse(worlds_[skin.joints[j]]); !to_joint) {
                flat_shifts_.insert({skin.joints[j], shift});
            } else if (shift != Point3{}) {
                bind.translation = bind.translation - to_joint->map_vector(shift);
                is_moved = true;
            }
            auto& matrix = matrices.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) {
                for (std::size_t row = 0; row < 3; ++row) matrix[4 * k + row] = float(bind.columns[k][row]);
                matrix[12 + k] = float(bind.translation[k]);
            }
            matrix[15] = 1;
        }
        if (!is_moved) return;
        GltfJson& json = document_.json["skins"][s];
        if (json.contains("inverseBindMatrices"))
            json["inverseBindMatrices"] =
                stored<16>(json["inverseBindMatrices"].get<GltfIndex>(), matrices, GltfDocument::Use::other);
        else
            json["inverseBindMatrices"] = document_.add(matrices, GltfDocument::Use::other);
    }

    // ---- vertices ----

    MovedRun moved_run(const GltfVertices& run) {
        const bool bakes = moved_.drops_skins && run.influences > 0;
        const auto maps = scene_.maps(run, worlds_);
        MovedRun result;
        result.targets.resize(run.targets.size());
        read_attributes(run);
        for (std::size_t i = 0; i < run.count(); ++i) {
            const Affine3& map = maps[maps.size() == 1 ? 0 : i];
            const auto back = inverse(bakes ? worlds_[run.node] : map);
            if (!back) throw GltfFault(scene_.nodes[run.node].name + ": its transform at rest is singular");
            move_vertex(run, i, map, *back, bakes, result);
        }
        return result;
    }

    void read_attributes(const GltfVertices& run) {
        const auto read = [&](GltfIndex accessor, const char* type) {
            return accessor == gltf_none ? std::vector<double>()
                                         : scene_.document.numbers(accessor, {type}, "a vertex").numbers;
        };
        own_normals_ = read(run.normal, "VEC3");
        own_tangents_ = read(run.tangent, "VEC4");
        own_targets_.clear();
        for (const auto& target : run.targets) {
            own_targets_.push_back({read(target[1], "VEC3"), read(target[2], "VEC3")});
        }
    }

    /// `map` from the file to world space at rest; `back` from world space to the output.
    void move_vertex(const GltfVertices& run, std::size_t i, const Affine3& map, const Affine3& back,
                     bool bakes, MovedRun& result) {
        const std::size_t vertex = run.first + i;
        const bool is_left_out = std::binary_search(mesh_.left_out.begin(), mesh_.left_out.end(), vertex);
        const Point3 rest = mesh_.vertices[vertex], shift = shift_of(run, i);
        const Point3 now =
            is_left_out || is_same_place(rest, moved_.places[vertex]) ? rest : moved_.places[vertex];
        const Point3 morphs = GltfScene::morphed(run, run.weights, i) - run.places[i];
        Point3 place =
            bakes ? mapped(back, now) : run.places[i] + morphs + back.map_vector(now - rest - shift);
        const Jacobian3* jacobian =
            moved_.jacobians.empty() || is_left_out ? nullptr : &moved_.jacobians[vertex];
        for (std::size_t t = 0; t < run.targets.size(); ++t) {
            if (run.target_places[t].empty()) continue;
            const Point3& own = run.target_places[t][i];
            const Point3 step = own == Point3{} ? own : moved_step(map.map_vector(own), jacobian, now);
            const Point3 stored = own == Point3{} ? own : unless_same(own, back.map_vector(step));
            result.targets[t][0].push_back(single(stored));
            place = place - run.weights[t] * stored;
        }
        result.places.push_back(single(place));
        for (const float x : result.places.back()) {
            if (!std::isfinite(x))
                throw GltfFault("v " + std::to_string(vertex + 1) +
                                ": its moved position is not finite in single precision");
        }
        if (run.normal != gltf_none) move_normal(run, i, map, back, jacobian, result);
        if (run.tangent != gltf_none) move_tangent(i, map, back, jacobian, result);
    }

    /// The translation of a vertex in world space by its node or joints.
    Point3 shift_of(const GltfVertices& run, std::size_t i) const {
        if (run.influences == 0) return shifts_[run.node];
        Point3 shift = common_shift_;
        if (flat_shifts_.empty()) return shift;
        const auto& joints = scene_.skins[scene_.nodes[run.node].skin].joints;
        for (std::size_t k = i * run.influences; k < (i + 1) * run.influences; ++k) {
            const auto found = flat_shifts_.find(joints[run.joints[k]]);
            if (found != flat_shifts_.end()) shift = shift + run.joint_weights[k] * found->second;
        }
        return shift;
    }

    /// Whether positions are equal up to rounding, so that a figure at rest keeps its bytes.
    bool is_same_place(const Point3& rest, const Point3& now) const {
        const Point3 step = now - rest;
        return dot(step, step) <= rounding_ * rounding_;
    }

    /// `before` if both are equal up to rounding, else `after`.
    static Point3 unless_same(const Point3& before, const Point3& after) {
        const Point3 change = after - before;
        return dot(change, change) <= 1e-24 * dot(before, before) ? before : after;
    }

    /// The displacement of a morph target in the pose, in world space: the Jacobian times the displacement.
    /// Without a Jacobian, the difference between the moved guide of the target and the moved vertex.
    Point3 moved_step(const Point3& step, const Jacobian3* jacobian, const Point3& now) {
        const std::size_t end = next_end_++;
        const bool has_end = end < moved_.guides.size();
        const Point3 exact = has_end ? moved_.guides[end] - now : step;
        if (jacobian == nullptr) return exact;
        const Point3 linear = mapped_vector(*jacobian, step);
        if (has_end) {
            const Point3 off = linear - exact;
            target_error_ = std::max(target_error_, norm(off));
        }
        return linear;
    }

    void move_normal(const GltfVertices& run, std::size_t i, const Affine3& map, const Affine3& back,
                     const Jacobian3* jacobian, MovedRun& result) {
        const std::size_t vertex = run.first + i;
        const Point3 own{own_normals_[3 * i], own_normals_[3 * i + 1], own_normals_[3 * i + 2]};
        const Point3& rest = mesh_.normals[vertex];
        const bool bakes = moved_.drops_skins && run.influences > 0;
        const Point3 now = normals_.of_corner(std::uint32_t(vertex), std::uint32_t(vertex));
        const auto to_world = inverse(back), from_file = inverse(map);
        if (!to_world || !from_file)
            throw GltfFault(scene_.nodes[run.node].name + ": its transform at rest is singular");
        const Point3 normal = now == rest && !bakes ? own : unit(transposed_map(*to_world, now));
        result.normals.push_back(single(normal));
        const auto carried = [&](const Point3& v) {
            const Point3 world = transposed_map(*from_file, v);
            return transposed_map(*to_world, jacobian == nullptr ? world : cofactors_times(*jacobian, world));
        };
        move_steps(1, i, own, normal, carried, result);
    }

    void move_tangent(std::size_t i, const Affine3& map, const Affine3& back, const Jacobian3* jacobian,
                      MovedRun& result) {
        const Point3 own{own_tangents_[4 * i], own_tangents_[4 * i + 1], own_tangents_[4 * i + 2]};
        double side = own_tangents_[4 * i + 3];
        const auto carried = [&](const Point3& v) {
            const Point3 world = map.map_vector(v);
            return back.map_vector(jacobian == nullptr ? world : mapped_vector(*jacobian, world));
        };
        Point3 tangent = unit(carried(own));
        if (jacobian == nullptr && !result.normals.empty()) { // perpendicular to the moved normal
            const auto& n = result.normals.back();
            const Point3 normal{n[0], n[1], n[2]};
            tangent = unit(tangent - dot(tangent, normal) * normal);
        }
        if (jacobian != nullptr && dot((*jacobian)[0], cross((*jacobian)[1], (*jacobian)[2])) < 0)
            side = -side;
        const Point3 change = tangent - own;
        if (dot(change, change) < 1e-14) tangent = own; // rounded
        result.tangents.push_back({float(tangent[0]), float(tangent[1]), float(tangent[2]), float(side)});
        move_steps(2, i, own, tangent, carried, result);
    }

    /// Moves the displacements of a normal (kind 1) or tangent (kind 2) by morph targets. The linear map and
    /// the factor are those of the vector at rest, so sums for any weights keep their directions.
    template <class Carried>
    void move_steps(std::size_t kind, std::size_t i, const Point3& own, const Point3& now,
                    const Carried& carried, MovedRun& result) {
        const double length = norm(carried(own));
        for (std::size_t t = 0; t < own_targets_.size(); ++t) {
            const auto& steps = own_targets_[t][kind - 1];
            if (steps.empty()) continue;
            const Point3 step{steps[3 * i], steps[3 * i + 1], steps[3 * i + 2]};
            const bool is_kept = step == Point3{} || !(length > 0);
            result.targets[t][kind].push_back(
                single(is_kept ? step : unless_same(step, (norm(now) / length) * carried(step))));
        }
    }

    // ---- accessors ----

    /// Stores the runs. Nodes whose results for a mesh differ get meshes of their own.
    void store(const std::vector<MovedRun>& runs) {
        for (std::size_t r = 0; r < runs.size();) {
            std::size_t end = r;
            while (end < runs.size() && scene_.runs[end].node == scene_.runs[r].node) ++end;
            store_node(runs, r, end);
            r = end;
        }
    }

    struct Variant { // of a mesh
        GltfIndex mesh;
        std::size_t first, end; // runs
    };

    void store_node(const std::vector<MovedRun>& runs, std::size_t first, std::size_t end) {
        const GltfVertices& run = scene_.runs[first];
        auto& variants = variants_[run.mesh];
        for (const Variant& variant : variants) {
            bool is_same = variant.end - variant.first == end - first;
            for (std::size_t r = first; is_same && r < end; ++r)
                is_same = are_near(runs[r], runs[variant.first + r - first]);
            if (!is_same) continue;
            if (variant.mesh != run.mesh) document_.json["nodes"][run.node]["mesh"] = variant.mesh;
            return;
        }
        GltfIndex mesh = run.mesh;
        const bool is_kept = outside_meshes_.contains(mesh); // nodes outside the scene use it
        if (is_kept && std::all_of(runs.begin() + std::ptrdiff_t(first), runs.begin() + std::ptrdiff_t(end),
                                   [&](const MovedRun& moved) {
                                       return is_at_rest(scene_.runs[std::size_t(&moved - runs.data())],
                                                         moved);
                                   }))
            return;
        if (!variants.empty() || is_kept) {
            mesh = document_.append("meshes", scene_.document.json["meshes"][run.mesh]);
            document_.json["nodes"][run.node]["mesh"] = mesh;
        }
        variants.push_back({mesh, first, end});
        for (std::size_t r = first; r < end; ++r) {
            for (const std::size_t p : scene_.runs[r].primitives)
                store_primitive(scene_.runs[r], runs[r], document_.json["meshes"][mesh]["primitives"][p]);
        }
    }

    /// Whether two runs are equal up to rounding.
    static bool are_near(const MovedRun& a, const MovedRun& b) {
        if (a == b) return true;
        const auto near_lists = [](const auto& x, const auto& y) {
            float most = 0;
            for (const auto& v : x) {
                for (const float c : v) most = std::max(most, std::fabs(c));
            }
            for (std::size_t i = 0; i < x.size(); ++i) {
                for (std::size_t k = 0; k < x[i].size(); ++k) {
                    if (!(std::fabs(x[i][k] - y[i][k]) <= 4 * most * std::numeric_limits<float>::epsilon()))
                        return false;
                }
            }
            return true;
        };
        for (std::size_t t = 0; t < a.targets.size(); ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
                if (a.targets[t][k].size() != b.targets[t][k].size() ||
                    !near_lists(a.targets[t][k], b.targets[t][k]))
                    return false;
            }
        }
        return a.places.size() == b.places.size() && near_lists(a.places, b.places) &&
               near_lists(a.normals, b.normals) && near_lists(a.tangents, b.tangents);
    }

    void store_primitive(const GltfVertices& run, const MovedRun& moved, GltfJson& primitive) {
        GltfJson& attributes = primitive["attributes"];
        attributes["POSITION"] = stored<3>(run.position, moved.places);
        if (!moved.normals.empty()) attributes["NORMAL"] = stored<3>(run.normal, moved.normals);
        if (!moved.tangents.empty()) attributes["TANGENT"] = stored<4>(run.tangent, moved.tangents);
        for (std::size_t t = 0; t < run.targets.size(); ++t) {
            constexpr const char* names[] = {"POSITION", "NORMAL", "TANGENT"};
            for (std::size_t k = 0; k < 3; ++k) {
                if (!moved.targets[t][k].empty())
                    primitive["targets"][t][names[k]] = stored<3>(run.targets[t][k], moved.targets[t][k]);
            }
        }
    }

    /// Whether nothing has moved.
    bool is_at_rest(const GltfVertices& run, const MovedRun& moved) const {
        bool is_same = is_unchanged<3>(run.position, moved.places);
        if (!moved.normals.empty()) is_same = is_same && is_unchanged<3>(run.normal, moved.normals);
        if (!moved.tangents.empty()) is_same = is_same && is_unchanged<4>(run.tangent, moved.tangents);
        for (std::size_t t = 0; t < run.targets.size(); ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
                const auto& values = moved.targets[t][k];
                is_same = is_same && (values.empty() || is_unchanged<3>(run.targets[t][k], values));
            }
        }
        return is_same;
    }

    /// Finds the accessors that primitives outside the runs use, and meshes of nodes outside the scene.
    void count_uses() {
        std::set<std::pair<GltfIndex, std::size_t>> moving;
        for (const GltfNode& node : scene_.nodes) {
            if (!node.is_in_scene && node.mesh != gltf_none) outside_meshes_.insert(node.mesh);
        }
        for (const GltfVertices& run : scene_.runs) {
            for (const std::size_t p : run.primitives) moving.insert({run.mesh, p});
        }
        const GltfJson& meshes = scene_.document.array("meshes");
        const auto keep = [&](const GltfJson& attributes) {
            for (const auto& [name, index] : attributes.items()) {
                if (const auto accessor = gltf_index(index)) kept_accessors_.insert(*accessor);
            }
        };
        for (std::size_t m = 0; m < meshes.size(); ++m) {
            const GltfJson primitives = meshes[m].value("primitives", GltfJson::array());
            for (std::size_t p = 0; p < primitives.size(); ++p) {
                const bool is_moved = moving.contains({m, p}) && !outside_meshes_.contains(m);
                if (is_moved || !primitives[p].is_object()) continue;
                keep(primitives[p].value("attributes", GltfJson::object()));
                for (const GltfJson& target : primitives[p].value("targets", GltfJson::array())) keep(target);
            }
        }
    }

    /// Stores the elements that replace those of an accessor; returns the index of their accessor.
    template <std::size_t N>
    GltfIndex stored(GltfIndex accessor, const std::vector<std::array<float, N>>& values,
                     GltfDocument::Use use = GltfDocument::Use::vertices) {
        auto& known = stored_[accessor];
        std::string bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
        for (const auto& [contents, index] : known) {
            if (contents == bytes) return index;
        }
        GltfIndex index = accessor;
        if (known.empty() && !kept_accessors_.contains(accessor)) {
            if (!is_unchanged<N>(accessor, values)) document_.replace<N>(accessor, values, use);
        } else {
            GltfJson copy = document_.json["accessors"][accessor];
            const bool has_bounds = copy.contains("min") || copy.contains("max");
            index = document_.add(values, use, has_bounds);
            for (const char* key : {"name", "extras"}) {
                if (copy.contains(key)) document_.json["accessors"][index][key] = copy[key];
            }
        }
        known.push_back({std::move(bytes), index});
        return index;
    }

    /// Whether the elements are those of the accessor, which may be integers or sparse.
    template <std::size_t N>
    bool is_unchanged(GltfIndex accessor, const std::vector<std::array<float, N>>& values) const {
        const auto numbers =
            scene_.document.numbers(accessor,
                                    {N == 3   ? "VEC3"
                                     : N == 4 ? "VEC4"
                                              : "MAT4"},
                                    "a vertex")
                .numbers;
        for (std::size_t n = 0; n < numbers.size(); ++n) {
            if (float(numbers[n]) != values[n / N][n % N]) return false;
        }
        return true;
    }

    std::vector<std::string> notes() const {
        std::vector<std::string> notes;
        const double size = size_of(mesh_);
        const auto add = [&](const std::string& what, double distance) {
            notes.push_back(mesh_.name + ": " + what + ", the largest distance from the exact result is " +
                            detail::short_number(distance) + ", " +
                            detail::short_number(100 * distance / size) + " % of its size");
        };
        if (target_error_ > 1e-6 * size)
            add("its morph targets are moved by the Jacobian; at full weight", target_error_);
        if (scene_.joints.empty() || moved_.drops_skins) return notes;
        const auto written = read_scene(document_, "the output");
        if (!written) throw GltfFault(written.error().message);
        double distance = 0;
        for (std::size_t i = 0; i < written->vertices.size(); ++i) {
            const Point3 off = written->vertices[i] - moved_.places[i];
            if (!std::binary_search(mesh_.left_out.begin(), mesh_.left_out.end(), i))
                distance = std::max(distance, norm(off));
        }
        add("its skin is kept, and its joints are moved; at rest", distance);
        return notes;
    }

    const GltfScene& scene_;
    const MeshFile& mesh_;
    const MovedVertices& moved_;
    GltfDocument document_; // the output
    std::vector<Affine3> worlds_;
    MovedNormals normals_;
    std::vector<Point3> shifts_; // #nodes: translation in world space
    std::map<GltfIndex, Point3>
        flat_shifts_;           // of joints with singular transforms; their inverse bind matrices stay
    Point3 common_shift_{};     // translation of all joints in world space, if they move in no other way
    double skeleton_scale_ = 1; // of distances between joints
    double rounding_;           // of positions in world space
    std::vector<double> own_normals_, own_tangents_;              // of the current run
    std::vector<std::array<std::vector<double>, 2>> own_targets_; // NORMAL and TANGENT of its targets
    std::size_t next_end_ = 0;                                    // index of the next guide of a morph target
    double target_error_ = 0;
    std::map<GltfIndex, std::vector<Variant>> variants_; // of each mesh
    std::map<GltfIndex, std::vector<std::pair<std::string, GltfIndex>>>
        stored_;                         // new elements of each accessor
    std::set<GltfIndex> kept_accessors_; // accessors that primitives outside the scene or other samplers use
    std::set<GltfIndex> outside_meshes_; // meshes of nodes outside the scene
    std::map<GltfIndex, Point3> steps_;  // of translations of nodes, in the space of their parents
};

} // namespace

Expected<MovedFile> GltfScene::moved(const MeshFile& mesh, const MovedVertices& moved,
                                     const std::filesystem::path& path) const {
    try {
        return SceneMover(*this, mesh, moved).write(path);
    } catch (const GltfFault& fault) {
        return FileError{mesh.name + ": " + fault.what()};
    } catch (const GltfJson::exception& fault) {
        return json_error(mesh.name, fault);
    }
}

Expected<MeshFile> without_skins(const MeshFile& mesh) {
    try {
        const MovedVertices at_rest{.places = mesh.vertices, .drops_skins = true};
        return read_scene(
            SceneMover(static_cast<const GltfScene&>(*mesh.document), mesh, at_rest).moved_document(),
            mesh.name);
    } catch (const GltfFault& fault) {
        return FileError{mesh.name + ": " + fault.what()};
    } catch (const GltfJson::exception& fault) {
        return json_error(mesh.name, fault);
    }
}

} // namespace cageform_support
