// A second reader of what export_gltf, fit_skeleton and make_hand write: loads files by tinygltf, plays them
// by the words of the specification and compares with the library's own clone at many times, or with poses
// given as OBJ files.
//
//     gltf_playback FIGURE.obj CAGE.obj CLIP.csv FILE…
//     gltf_playback --at FIGURE.obj FILE SECONDS POSE.obj…
//     gltf_playback --near SHARE FIGURE.obj FILE SECONDS POSE.obj…
//
// --near: a file with a skeleton, whose vertices may be so far off, as a share of the figure's size.
// Files are bound by mean value coordinates; those with a skin of floats have as many influences as their
// sets take.

#include "../support/larger.hpp"
#include "cli/mesh_cage.hpp"
#include "files/clip_file.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/smooth_skin_weights.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <tiny_gltf.h>

#include <cstring>
#include <iostream>
#include <map>
#include <stdexcept>

namespace {

using namespace cageform_support;
using Matrix = std::array<double, 16>; // by columns

/// An accessor's numbers, integers as they are or normalised (3.6.2.2), element by element.
std::vector<double> numbers(const tinygltf::Model& model, int index) {
    const auto& accessor = model.accessors.at(std::size_t(index));
    const auto& view = model.bufferViews.at(std::size_t(accessor.bufferView));
    const auto& bytes = model.buffers.at(std::size_t(view.buffer)).data;
    const auto components = std::size_t(tinygltf::GetNumComponentsInType(std::uint32_t(accessor.type)));
    const auto size = std::size_t(tinygltf::GetComponentSizeInBytes(std::uint32_t(accessor.componentType)));
    const auto stride = std::size_t(accessor.ByteStride(view));
    std::vector<double> result;
    for (std::size_t i = 0; i < accessor.count; ++i) {
        for (std::size_t k = 0; k < components; ++k) {
            const unsigned char* at =
                &bytes.at(view.byteOffset + accessor.byteOffset + i * stride + k * size);
            std::uint32_t bits = 0;
            std::memcpy(&bits, at, size);
            const double one = size == 1 ? 255.0 : 65535.0;
            result.push_back(accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT
                                 ? double(std::bit_cast<float>(bits))
                                 : double(bits) / (accessor.normalized ? one : 1));
        }
    }
    return result;
}

/// A sampler of LINEAR or CUBICSPLINE interpolation at a time within it (appendix C).
///
///   turns   whether the values are rotations
std::vector<double> sampled(const tinygltf::Model& model, const tinygltf::AnimationSampler& sampler,
                            double time, bool turns) {
    const bool linear = sampler.interpolation == "LINEAR";
    if (!linear && sampler.interpolation != "CUBICSPLINE")
        throw std::runtime_error("a sampler is neither LINEAR nor CUBICSPLINE");
    const auto times = numbers(model, sampler.input), values = numbers(model, sampler.output);
    const std::size_t components = values.size() / ((linear ? 1 : 3) * times.size());
    std::size_t k = 0;
    while (k + 2 < times.size() && times[k + 1] <= time) ++k;
    const double length = times[k + 1] - times[k], t = (time - times[k]) / length;
    const double t2 = t * t, t3 = t2 * t;
    std::vector<double> result(components);
    if (linear) {
        double share_a = 1 - t, share_b = t;
        if (turns) { // slerp, by the shorter way
            double along = 0;
            for (std::size_t c = 0; c < 4; ++c) along += values[4 * k + c] * values[4 * k + 4 + c];
            const double angle = std::acos(std::min(std::fabs(along), 1.0));
            if (std::sin(angle) > 1e-9) {
                share_a = std::sin((1 - t) * angle) / std::sin(angle);
                share_b = std::sin(t * angle) / std::sin(angle);
            }
            if (along < 0) share_b = -share_b;
        }
        for (std::size_t c = 0; c < components; ++c)
            result[c] = share_a * values[k * components + c] + share_b * values[(k + 1) * components + c];
        return result;
    }
    for (std::size_t c = 0; c < components; ++c) {
        const auto at = [&](std::size_t key, std::size_t part) { // in-tangent, value, out-tangent
            return values[(3 * key + part) * components + c];
        };
        result[c] = (2 * t3 - 3 * t2 + 1) * at(k, 1) + length * (t3 - 2 * t2 + t) * at(k, 2) +
                    (-2 * t3 + 3 * t2) * at(k + 1, 1) + length * (t3 - t2) * at(k + 1, 0);
    }
    double square = 0;
    for (const double x : result) square += x * x;
    for (double& x : result) x /= turns ? std::sqrt(square) : 1;
    return result;
}

Matrix product(const Matrix& a, const Matrix& b) {
    Matrix c{};
    for (std::size_t column = 0; column < 4; ++column) {
        for (std::size_t row = 0; row < 4; ++row) {
            for (std::size_t k = 0; k < 4; ++k) c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
        }
    }
    return c;
}

/// A file loaded: its mesh, and what each of its vertices was in the OBJ file.
struct File {
    tinygltf::Model model;
    Point3 place; // of the node above the mesh or above all joints, from which positions are counted
    std::vector<Point3> rest;
    std::vector<std::size_t> origin;
};

File load(const std::string& path, const MeshFile& figure) {
    File file;
    tinygltf::TinyGLTF loader;
    std::string error, warning;
    const bool loaded = path.ends_with(".glb")
                            ? loader.LoadBinaryFromFile(&file.model, &error, &warning, path)
                            : loader.LoadASCIIFromFile(&file.model, &error, &warning, path);
    if (!loaded || !error.empty() || !warning.empty()) throw std::runtime_error(error + warning);
    if (file.model.meshes.size() != 1 || file.model.meshes[0].primitives.size() != 1)
        throw std::runtime_error("one mesh of one primitive is expected");
    for (const int node : file.model.scenes.at(0).nodes) {
        const tinygltf::Node& root = file.model.nodes.at(std::size_t(node));
        const bool is_place = root.mesh >= 0 ? root.skin < 0 : file.model.skins.at(0).skeleton == node;
        for (std::size_t k = 0; is_place && k < root.translation.size(); ++k)
            file.place[k] = root.translation[k];
    }
    std::map<std::array<float, 3>, std::size_t> places;
    const auto single = [&](const Point3& p) {
        const Point3 from = p - file.place;
        return std::array{float(from[0]), float(from[1]), float(from[2])};
    };
    for (std::size_t i = 0; i < figure.vertices.size(); ++i) places[single(figure.vertices[i])] = i;
    const auto& primitive = file.model.meshes[0].primitives[0];
    const auto positions = numbers(file.model, primitive.attributes.at("POSITION"));
    for (std::size_t i = 0; i < positions.size(); i += 3) {
        file.rest.push_back(Point3{positions[i], positions[i + 1], positions[i + 2]} + file.place);
        file.origin.push_back(places.at(single(file.rest.back())));
    }
    for (std::size_t i = 0; i < figure.vertices.size(); ++i) {
        if (single(file.rest.at(i)) != single(figure.vertices[i]))
            throw std::runtime_error("the vertices are in another order");
    }
    const auto indices = numbers(file.model, primitive.indices);
    if (indices.size() != 3 * figure.triangles.size()) throw std::runtime_error("triangles are missing");
    for (std::size_t n = 0; n < indices.size(); ++n) {
        const auto corner = file.origin.at(std::size_t(indices[n]));
        if (figure.vertices[corner] != figure.vertices[figure.triangles[n / 3][n % 3]])
            throw std::runtime_error("a triangle has other corners");
    }
    return file;
}

/// A skin's joints and weights of every vertex, all sets side by side.
struct Influences {
    std::size_t count = 0; // of a vertex
    std::vector<double> joints, weights;
};
Influences influences(const File& file) {
    const auto& attributes = file.model.meshes[0].primitives[0].attributes;
    Influences all;
    std::vector<std::vector<double>> joints, weights;
    for (;; all.count += 4) {
        const std::string set = std::to_string(all.count / 4);
        const auto joint = attributes.find("JOINTS_" + set), weight = attributes.find("WEIGHTS_" + set);
        if (joint == attributes.end() || weight == attributes.end()) break;
        joints.push_back(numbers(file.model, joint->second));
        weights.push_back(numbers(file.model, weight->second));
    }
    for (std::size_t i = 0; i < file.rest.size(); ++i) {
        for (std::size_t k = 0; k < all.count; ++k) {
            all.joints.push_back(joints[k / 4].at(4 * i + k % 4));
            all.weights.push_back(weights[k / 4].at(4 * i + k % 4));
        }
    }
    return all;
}

/// The vertices at a time: morph targets first, then the skin (3.7.2.2, 3.7.3).
std::vector<Point3> played(const File& file, const Influences& skin, double time) {
    const auto& model = file.model;
    std::vector<Point3> moved = file.rest;
    for (Point3& p : moved) p = p - file.place;
    std::vector<tinygltf::Node> nodes = model.nodes; // as they are then
    std::vector<double> shares = model.meshes[0].weights;
    const auto& animation = model.animations.at(0);
    for (const auto& channel : animation.channels) {
        auto value = sampled(model, animation.samplers.at(std::size_t(channel.sampler)), time,
                             channel.target_path == "rotation");
        tinygltf::Node& node = nodes.at(std::size_t(channel.target_node));
        if (channel.target_path == "translation")
            node.translation = std::move(value);
        else if (channel.target_path == "rotation")
            node.rotation = std::move(value);
        else if (channel.target_path == "scale")
            node.scale = std::move(value);
        else if (channel.target_path == "weights")
            shares = std::move(value);
        else
            throw std::runtime_error("a channel moves something else");
    }
    const auto& targets = model.meshes[0].primitives[0].targets;
    for (std::size_t t = 0; t < targets.size(); ++t) {
        const auto shift = numbers(model, targets[t].at("POSITION"));
        for (std::size_t i = 0; i < moved.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) moved[i][k] += shares.at(t) * shift[3 * i + k];
        }
    }
    if (skin.count == 0) {
        for (Point3& p : moved) p = p + file.place;
        return moved;
    }

    // Every node's matrix in the world.
    std::vector<Matrix> world(model.nodes.size());
    const auto place = [&](const auto& self, int node, const Matrix& parent) -> void {
        Matrix own{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        const tinygltf::Node& of = nodes[std::size_t(node)];
        if (of.rotation.size() == 4) {
            const double x = of.rotation[0], y = of.rotation[1], z = of.rotation[2], w = of.rotation[3];
            own = {1 - 2 * (y * y + z * z),
                   2 * (x * y + w * z),
                   2 * (x * z - w * y),
                   0,
                   2 * (x * y - w * z),
                   1 - 2 * (x * x + z * z),
                   2 * (y * z + w * x),
                   0,
                   2 * (x * z + w * y),
                   2 * (y * z - w * x),
                   1 - 2 * (x * x + y * y),
                   0,
                   0,
                   0,
                   0,
                   1};
        }
        for (std::size_t c = 0; c < of.scale.size(); ++c) {
            for (std::size_t k = 0; k < 3; ++k) own[4 * c + k] *= of.scale[c];
        }
        for (std::size_t k = 0; k < of.translation.size(); ++k) own[12 + k] = of.translation[k];
        world[std::size_t(node)] = product(parent, own);
        for (const int child : model.nodes[std::size_t(node)].children)
            self(self, child, world[std::size_t(node)]);
    };
    for (const int node : model.scenes.at(0).nodes)
        place(place, node, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    const auto& joints = model.skins.at(0).joints;
    const auto inverse = numbers(model, model.skins[0].inverseBindMatrices);
    std::vector<Matrix> matrices;
    for (std::size_t j = 0; j < joints.size(); ++j) {
        Matrix bind{};
        std::copy_n(inverse.begin() + std::ptrdiff_t(16 * j), 16, bind.begin());
        matrices.push_back(product(world[std::size_t(joints[j])], bind));
    }
    for (std::size_t i = 0; i < moved.size(); ++i) {
        const Point3 p = moved[i];
        moved[i] = {};
        for (std::size_t n = i * skin.count; n < (i + 1) * skin.count; ++n) {
            const Matrix& m = matrices.at(std::size_t(skin.joints[n]));
            for (std::size_t k = 0; k < 3; ++k)
                moved[i][k] +=
                    skin.weights[n] * (m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k]);
        }
    }
    return moved;
}

double length(const Point3& p) {
    return std::hypot(p[0], p[1], p[2]);
}

template <class Result>
auto unwrapped(Result result) {
    if (!result) throw std::runtime_error(to_string(result.error()));
    return std::move(*result);
}

/// How far a file is from the clone at most, over the clip.
int compare(const std::string& path, const MeshFile& figure, const MeshFile& cage, const PoseClip& clip) {
    const File file = load(path, figure);
    const Influences skin = influences(file);
    cageform::Binding<double, 3> binding =
        cageform::bind(cageform::MeanValueCoordinates<double, 3>(
                           cageform::TriangleMesh<double>(cage.vertices, cage.triangles)),
                       figure.vertices)
            .value;
    double size = 0;
    for (const Point3& c : cage.vertices) size = cageform_tests::larger(size, length(c - cage.vertices[0]));
    // Normalised integers are off by one at most for each of the weights; where the joints of a vertex go
    // apart counts.
    bool integers = false;
    if (skin.count > 0) {
        const int weights = file.model.meshes[0].primitives[0].attributes.at("WEIGHTS_0");
        integers = file.model.accessors[std::size_t(weights)].normalized;
        static std::map<std::size_t, cageform::Result<cageform::SkinWeights, cageform::SkinWeightsReport>>
            skins; // of the figure, by influences
        auto& made = skins[skin.count];
        if (made.value.influences == 0)
            made = cageform::smooth_skin_weights(binding, figure.triangles, {.influences = skin.count});
        auto skinned = made ? cageform::skin_to_binding(binding, made.value)
                            : cageform::Result<cageform::Binding<double, 3>>{{}, made.status()};
        if (!skinned) throw std::runtime_error("no skin");
        binding = std::move(skinned.value);
    }
    const double allowed = (integers ? double(skin.count) / 255 : 1e-5) * size;
    const auto motion = make_clip<double>(clip);
    auto cursor = motion.make_cursor();
    std::vector<Point3> pose(motion.vertex_count()), cloned(figure.vertices.size());
    double worst = 0, most_moved = 0;
    for (int n = 0; n <= 7; ++n) {
        const double time = double(n) / 7 * clip.length;
        motion.sample(time, cursor, pose);
        if (clone(binding, pose, cloned) != cageform::Status::ok) throw std::runtime_error("no clone");
        const auto moved = played(file, skin, time);
        for (std::size_t i = 0; i < moved.size(); ++i) {
            worst = cageform_tests::larger(worst, length(moved[i] - cloned[file.origin[i]]));
            most_moved = cageform_tests::larger(most_moved, length(moved[i] - file.rest[i]));
        }
    }
    const bool ok = worst <= allowed && most_moved > 0.01 * size;
    std::cout << path << ": " << (ok ? "" : "FAILED: ") << file.rest.size() << " vertices, " << skin.count
              << " influences, " << file.model.meshes[0].weights.size() << " targets; moves by " << most_moved
              << ", differs from the clone by " << worst << " of allowed " << allowed << '\n';
    return ok ? 0 : 1;
}

/// How far a file is from poses at their times.
int compare_poses(int argc, char** argv) {
    const MeshFile figure = unwrapped(load_mesh(argv[2]));
    const File file = load(argv[3], figure);
    double size = 0, worst = 0, least_moved = 1e30;
    for (const Point3& p : figure.vertices)
        size = cageform_tests::larger(size, length(p - figure.vertices[0]));
    for (int n = 4; n + 1 < argc; n += 2) {
        const auto moved = played(file, {}, std::stod(argv[n]));
        const MeshFile pose = unwrapped(load_mesh(argv[n + 1]));
        if (pose.vertices.size() != figure.vertices.size())
            throw std::runtime_error("a pose of another figure");
        double most_moved = 0;
        for (std::size_t i = 0; i < moved.size(); ++i) {
            worst = cageform_tests::larger(worst, length(moved[i] - pose.vertices[file.origin[i]]));
            most_moved = cageform_tests::larger(most_moved, length(moved[i] - file.rest[i]));
        }
        least_moved = std::min(least_moved, most_moved);
    }
    const auto end = numbers(file.model, file.model.animations.at(0).samplers.at(0).input).back();
    for (const double time : {0.0, end}) {
        const auto moved = played(file, {}, time);
        for (std::size_t i = 0; i < moved.size(); ++i)
            worst = cageform_tests::larger(worst, length(moved[i] - file.rest[i]));
    }
    const bool ok = worst <= 2e-6 * size && least_moved > 0.1 * size; // six decimals, and floats
    std::cout << argv[3] << ": " << (ok ? "" : "FAILED: ") << end << " s, "
              << file.model.meshes[0].weights.size() << " targets; every pose moves it by " << least_moved
              << " at least, differs from the poses, and at both ends from rest, by " << worst << " of "
              << size << '\n';
    return ok ? 0 : 1;
}

/// Whether a file with a skeleton is near to poses at their times.
int compare_near(int argc, char** argv) {
    const double allowed = std::stod(argv[2]);
    const MeshFile figure = unwrapped(load_mesh(argv[3]));
    const File file = load(argv[4], figure);
    const Influences skin = influences(file);
    const double size = cageform::bounds_of(std::span<const Point3>(figure.vertices)).diagonal();
    double worst = 0, most_moved = 0;
    for (int n = 5; n + 1 < argc; n += 2) {
        const auto moved = played(file, skin, std::stod(argv[n]));
        const MeshFile pose = unwrapped(load_mesh(argv[n + 1]));
        if (pose.vertices.size() != figure.vertices.size())
            throw std::runtime_error("a pose of another figure");
        for (std::size_t i = 0; i < moved.size(); ++i) {
            worst = cageform_tests::larger(worst, length(moved[i] - pose.vertices[file.origin[i]]));
            most_moved = cageform_tests::larger(most_moved, length(moved[i] - file.rest[i]));
        }
    }
    const bool ok = worst <= allowed * size && most_moved > 0.05 * size;
    std::cout << argv[4] << ": " << (ok ? "" : "FAILED: ") << skin.count << " influences; moves by "
              << most_moved << ", differs from the poses by " << worst << " of allowed " << allowed * size
              << '\n';
    return ok ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    try {
        if (argc > 5 && argc % 2 == 0 && std::string_view(argv[1]) == "--at")
            return compare_poses(argc, argv);
        if (argc > 6 && argc % 2 == 1 && std::string_view(argv[1]) == "--near")
            return compare_near(argc, argv);
        if (argc < 5) throw std::runtime_error("usage: gltf_playback FIGURE.obj CAGE.obj CLIP.csv FILE…");
        const MeshFile figure = unwrapped(load_mesh(argv[1]));
        const MeshFile cage = unwrapped(load_mesh_cage(argv[2]));
        const PoseClip clip = unwrapped(load_pose_clip(argv[3], cage.vertices.size()));
        int failed = 0;
        for (int n = 4; n < argc; ++n) failed += compare(argv[n], figure, cage, clip);
        return failed == 0 ? 0 : 1;
    } catch (const std::exception& error) {
        std::cerr << "gltf_playback: " << error.what() << '\n';
        return 1;
    }
}
