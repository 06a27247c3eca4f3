// Makes meshes and bones of every kind that no one should, and takes them through cotangent weights,
// harmonic functions, weights of bones, skins and bindings to bones: nothing may crash; what is refused
// is named, and what is made keeps its laws. A program of its own, for sanitizers:
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -Iinclude
//             -isystem /usr/include/eigen3 -Itests tests/fuzz/hostile_surfaces.cpp -o hostile_surfaces
//     ./hostile_surfaces FIRST_SEED COUNT
#include "support/meshes.hpp"

#include <cageform/binding/bind_bones.hpp>
#include <cageform/binding/skin_weights.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/fields/skin.hpp>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

namespace {

using namespace cageform;
using cageform_tests::MeshData;
using cageform_tests::Random;

std::map<std::string, std::size_t> outcomes;
void count(const char* what, Status status) {
    ++outcomes[std::string(what) + ": " + to_string(status)];
}

#define REQUIRE(condition)                                                                                   \
    if (!(condition)) {                                                                                      \
        std::fprintf(stderr, "seed %llu, line %d: %s\n", seed, __LINE__, #condition);                        \
        std::abort();                                                                                        \
    }

/// A number about 1, of the many sizes that numbers have.
template <class T>
double any_size(Random& random) {
    const double most = sizeof(T) == 4 ? 38 : 308, least = sizeof(T) == 4 ? -45 : -323;
    return std::pow(10.0, random.uniform(least, most));
}

/// Spoils a coordinate of a mesh in [-1, 1]³: some kinds change all numbers, some only a few, and half
/// change nothing.
template <class T>
T spoilt(Random& random, double x, std::size_t kind) {
    switch (kind) {
    case 1: return T(std::round(2 * x) / 2); // duplicates, collinear, crossing
    case 2: return T(x * 1e300);             // infinite in float
    case 3: return T(x * 1e-300);            // zero in float
    case 4: return T(1e6 + x);
    case 5: return random.below(40) == 0 ? std::numeric_limits<T>::quiet_NaN() : T(x);
    case 6: return random.below(40) == 0 ? std::numeric_limits<T>::infinity() : T(x);
    case 7: return T(x * any_size<T>(random));
    case 8: return T(x * double(std::numeric_limits<T>::max()));
    case 9: return T(x + 1e-9 * random.uniform(-1, 1));
    default: return T(x);
    }
}

using IndexFaces = std::vector<std::array<std::int64_t, 3>>;

MeshData base_mesh(Random& random) {
    MeshData mesh;
    switch (random.below(8)) {
    case 0: return cageform_tests::sphere(int(random.below(3)));
    case 1: return cageform_tests::torus(3 + int(random.below(6)), 3 + int(random.below(4)));
    case 2: return cageform_tests::divided_box({1 + int(random.below(3)), 2, 1}, 0.5);
    case 3: // triangles at random
        for (std::size_t n = random.below(12); n > 0; --n) mesh.vertices.push_back({});
        for (auto& v : mesh.vertices) {
            for (double& x : v.v) x = random.uniform(-1, 1);
        }
        for (std::size_t n = random.below(16); n > 0 && !mesh.vertices.empty(); --n) {
            const auto any = [&] { return int(random.below(mesh.vertices.size())); };
            mesh.faces.push_back({any(), any(), any()});
        }
        return mesh;
    case 4: { // a sheet, or a pillow of two
        const int across = 2 + int(random.below(4));
        for (int n = 0; n < across * across; ++n)
            mesh.vertices.push_back({2.0 * (n % across) / across - 1, 2.0 * (n / across) / across - 1,
                                     random.uniform(-0.1, 0.1) * double(random.below(2))});
        for (int n = 0; n + across + 1 < across * across; ++n) {
            if (n % across + 1 == across) continue;
            mesh.faces.insert(mesh.faces.end(),
                              {{n, n + 1, n + across}, {n + 1, n + across + 1, n + across}});
        }
        return mesh;
    }
    case 5: { // a fan of needles about an axis, closed
        const int rim = 3 + int(random.below(20));
        mesh.vertices = {{0, 0, 1}, {0, 0, -1}};
        for (int n = 0; n < rim; ++n) {
            const double angle = 2 * std::numbers::pi * n / rim;
            mesh.vertices.push_back({0.5 * std::cos(angle), 0.5 * std::sin(angle), 0});
            const int a = 2 + n, b = 2 + (n + 1) % rim;
            mesh.faces.insert(mesh.faces.end(), {{0, a, b}, {1, b, a}});
        }
        return mesh;
    }
    default: return cageform_tests::sphere(1 + int(random.below(2)));
    }
}

/// Parts, duplicates, holes, edges of three faces, vertices without faces, indices out of range.
IndexFaces harmed(Random& random, MeshData& mesh) {
    IndexFaces faces;
    const auto add = [&](std::size_t first) {
        for (const auto& f : mesh.faces)
            faces.push_back(
                {f[0] + std::int64_t(first), f[1] + std::int64_t(first), f[2] + std::int64_t(first)});
    };
    add(0);
    if (random.below(6) == 0) { // a second part, within the first, at its place or apart
        const auto size = mesh.vertices.size();
        const std::size_t how = random.below(3);
        for (std::size_t i = 0; i < size; ++i) {
            const auto v = mesh.vertices[i];
            mesh.vertices.push_back(how == 0 ? 0.5 * v : how == 1 ? v : v + Vec<double, 3>{3, 0, 0});
        }
        add(size);
    }
    for (std::size_t harms = random.below(2) * random.below(3); harms > 0 && !faces.empty(); --harms) {
        const auto size = mesh.vertices.size();
        auto& face = faces[random.below(faces.size())];
        const auto any = [&] { return std::int64_t(random.below(size)); };
        switch (random.below(9)) {
        case 0: face[random.below(3)] = std::int64_t(random.bits()); break;
        case 1: face[random.below(3)] = any(); break;
        case 2: faces.resize(random.below(faces.size())); break;
        case 3: faces.push_back(std::array<std::int64_t, 3>(face)); break;
        case 4: std::swap(face[0], face[1]); break;
        case 5: mesh.vertices.push_back({random.uniform(-1, 1), 0, 0}); break;
        case 6: mesh.vertices[std::size_t(any())] = mesh.vertices[std::size_t(any())]; break;
        case 7: faces.push_back({face[0], face[1], any()}); break;
        default: face[1] = face[0]; break;
        }
    }
    return faces;
}

/// Flat, thin, or pulled towards a corner.
void squeeze(Random& random, MeshData& mesh) {
    const double width = random.below(4) == 0 ? 0 : std::pow(10.0, random.uniform(-17, 0));
    switch (random.below(6)) {
    case 0:
        for (auto& v : mesh.vertices) v[2] *= width;
        break;
    case 1:
        for (auto& v : mesh.vertices) v[1] *= width, v[2] *= width;
        break;
    case 2: // a vertex on top of another, nearly
        if (mesh.vertices.size() > 1)
            mesh.vertices[0] = mesh.vertices[1] + width * (mesh.vertices[0] - mesh.vertices[1]);
        break;
    default: break;
    }
}

template <class T, std::size_t D>
std::vector<Vec<T, D>> as(Random& random, const MeshData& mesh, std::size_t kind) {
    std::vector<Vec<T, D>> points;
    for (const auto& v : mesh.vertices) {
        points.push_back({});
        for (std::size_t k = 0; k < D; ++k) points.back()[k] = spoilt<T>(random, v[k], kind);
    }
    return points;
}

std::vector<BoneSegment> some_bones(Random& random, const MeshData& mesh, std::size_t mesh_kind) {
    const std::size_t many = random.below(200);
    std::vector<BoneSegment> bones(many == 0 ? 2000 : random.below(7));
    const std::size_t kind = random.below(2) == 0 ? mesh_kind : random.below(16);
    const double reach = random.below(4) == 0 ? 3 : 0.6;
    for (auto& bone : bones) {
        for (auto* end : {&bone.head, &bone.tail}) {
            for (double& x : end->v) x = spoilt<double>(random, random.uniform(-reach, reach), kind);
        }
        switch (random.below(20)) {
        case 0: bone.tail = bone.head; break;
        case 1: bone = bones[random.below(bones.size())]; break;
        case 2: // at a vertex
            if (!mesh.vertices.empty()) bone.head = mesh.vertices[random.below(mesh.vertices.size())];
            break;
        case 3: bone.tail = bone.head + 1e-12 * bone.tail; break;
        case 4: bone.tail = std::pow(10, random.uniform(0, 250)) * bone.tail; break;
        default: break;
        }
    }
    return bones;
}

bool is_mesh_fault(Status status) {
    return status == Status::vertex_not_finite || status == Status::face_without_vertex ||
           status == Status::face_without_area || status == Status::cage_not_manifold;
}
/// A fault of this status that names a vertex or face that there is.
bool names(const CageReport& report, Status status, std::size_t vertices, std::size_t faces) {
    for (const auto& fault : report.faults) {
        if (status_of(fault.kind) != status) continue;
        const bool is_face = status == Status::face_without_vertex || status == Status::face_without_area;
        return fault.a < (is_face ? faces : vertices);
    }
    return false;
}

/// Harmonic functions with values at random vertices, between those.
template <class T>
void try_harmonic(const CotangentWeights& weights, Random& random, unsigned long long seed) {
    const std::size_t size = weights.vertices, fields = random.below(3);
    std::vector<std::uint8_t> given(size);
    std::vector<T> values(fields * size, std::numeric_limits<T>::quiet_NaN());
    const std::size_t every = 1 + random.below(8);
    for (std::size_t i = 0; i < size; ++i) {
        given[i] = random.below(every) == 0 ? 1 : 0;
        for (std::size_t f = 0; f < fields && given[i] != 0; ++f)
            values[f * size + i] =
                random.below(400) == 0 ? std::numeric_limits<T>::infinity() : T(random.below(2));
    }
    auto solved = values;
    const auto evaluation = solve_surface(weights, given, std::span<T>(solved));
    count("solve_surface", evaluation.status);
    const auto is_same = [&](std::size_t i) {
        return solved[i] == values[i] || (std::isnan(solved[i]) && std::isnan(values[i]));
    };
    if (evaluation.status != Status::ok) {
        for (std::size_t i = 0; i < solved.size(); ++i) REQUIRE(is_same(i));
        const bool is_named =
            evaluation.status == Status::cells_unreached || evaluation.status == Status::value_not_finite;
        REQUIRE(is_named || weights.has_negative);
        REQUIRE(!is_named || evaluation.solver.culprit < std::max(size, solved.size()));
        return;
    }
    for (std::size_t i = 0; i < solved.size(); ++i) {
        if (given[i % size] != 0 || weights.unused[i % size] != 0) REQUIRE(is_same(i));
        if (given[i % size] != 0 || weights.unused[i % size] != 0) continue;
        REQUIRE(is_finite(solved[i]));
        if (weights.has_negative) continue;
        REQUIRE(solved[i] >= T(0) && double(solved[i]) <= 1 + 1e-12);
    }
}

template <class T, std::size_t D>
void try_weights(const std::vector<Vec<T, D>>& points, const IndexFaces& faces, Random& random,
                 unsigned long long seed) {
    const auto kind = random.below(4) == 0 ? MeshWeights::own : MeshWeights::intrinsic_delaunay;
    const auto weights = cotangent_weights(points, faces, kind);
    const Status status = weights.report.status;
    count("cotangent_weights", status);
    if (status != Status::ok) {
        REQUIRE(is_mesh_fault(status) && names(weights.report.mesh, status, points.size(), faces.size()));
        REQUIRE(weights.value.vertices == 0 && weights.value.links.empty() && weights.value.areas.empty());
        return;
    }
    REQUIRE(weights.value.vertices == points.size() && weights.value.areas.size() == points.size());
    std::size_t negative = 0;
    for (const auto& link : weights.value.links) {
        REQUIRE(link.a < points.size() && link.b < points.size() && link.a != link.b);
        REQUIRE(is_finite(link.conductance) && link.conductance != 0);
        negative += link.conductance < 0 ? 1 : 0;
    }
    REQUIRE(negative == weights.report.negative_weights);
    for (std::size_t i = 0; i < points.size(); ++i)
        REQUIRE(is_finite(weights.value.areas[i]) && weights.value.areas[i] >= 0 &&
                (weights.value.unused[i] == 0 || weights.value.areas[i] == 0));
    try_harmonic<T>(weights.value, random, seed);
}

/// A skin of weights that are all positive or zero and sum to one.
template <class T>
void try_skin(const std::vector<T>& weights, std::size_t bones, Random& random, unsigned long long seed) {
    const SkinWeightsOptions options{.influences = random.below(6), .threshold = random.uniform(0, 0.2)};
    const auto skin = skin_weights(std::span<const T>(weights), bones, options);
    count("skin_weights", skin.report.status);
    if (skin.report.status != Status::ok) {
        REQUIRE(options.influences == 0 && skin.value.weights.empty());
        return;
    }
    for (std::size_t i = 0; i < skin.value.point_count(); ++i) {
        double sum = 0;
        for (std::size_t k = 0; k < options.influences; ++k) {
            const float w = skin.value.weights[i * options.influences + k];
            REQUIRE(w >= 0 && w <= 1 && skin.value.joints[i * options.influences + k] < bones);
            sum += double(w);
        }
        REQUIRE(sum == 0 || std::fabs(sum - 1) < 1e-7);
    }
}

template <class T, std::size_t D>
void try_bones(const std::vector<Vec<T, D>>& points, const IndexFaces& faces,
               const std::vector<BoneSegment>& bones, Random& random, unsigned long long seed) {
    std::vector<std::uint32_t> groups;
    if (random.below(4) == 0) {
        for (std::size_t i = 0; i < points.size(); ++i)
            groups.push_back(random.below(3) == 0 ? no_bone : std::uint32_t(random.below(bones.size() + 1)));
    }
    SurfaceSkinOptions options{.groups = groups};
    options.visibility = random.below(2) == 0 ? BoneVisibility::inside : BoneVisibility::ignored;
    if (random.below(4) == 0) options.heat = std::pow(10.0, random.uniform(-320, 308));
    if (random.below(40) == 0) options.heat = -random.uniform(0, 1);
    const bool is_heat = random.below(2) == 0;
    const auto skin =
        is_heat ? bone_heat(points, faces, bones, options) : harmonic_skin(points, faces, bones, options);
    const Status status = skin.report.status;
    const bool obtuse = skin.report.mesh.negative_weights > 0;
    count(is_heat ? "bone_heat" : "harmonic_skin", status);
    if (status != Status::ok) {
        REQUIRE(skin.value.empty());
        const bool is_named = is_mesh_fault(status) || status == Status::cage_not_closed
                                  ? names(skin.report.mesh.mesh, status, points.size(), faces.size())
                              : status == Status::value_not_finite ? skin.report.solver.culprit < bones.size()
                              : status == Status::bone_weights_do_not_match ? bones.empty()
                              : status == Status::weights_not_positive      ? is_heat && !(options.heat > 0)
                              : status == Status::not_converged             ? obtuse
                                                                : skin.report.solver.culprit < points.size();
        REQUIRE(is_named);
        return;
    }
    REQUIRE(skin.value.size() == points.size() * bones.size());
    double largest = 1; // negative weights may make others large
    for (const T w : skin.value) largest = std::fmax(largest, std::fabs(double(w)));
    for (std::size_t i = 0; i < points.size(); ++i) {
        double sum = 0;
        for (std::size_t b = 0; b < bones.size(); ++b) {
            const double w = double(skin.value[i * bones.size() + b]);
            REQUIRE(is_finite(w));
            REQUIRE(obtuse || (w >= 0 && w <= 1 + 1e-12));
            sum += w;
        }
        REQUIRE(sum == 0 ||
                std::fabs(sum - 1) <= double(bones.size()) * (sizeof(T) == 4 ? 1e-7 : 1e-12) * largest);
    }
    if (!obtuse) try_skin(skin.value, bones.size(), random, seed);
}

/// Frames of bones, and weights that may be wrong; where all is of the size of one, a clone is a skinning.
template <class T, std::size_t D>
void try_binding(Random& random, unsigned long long seed) {
    const std::size_t kind = random.below(16), bones = random.below(5), points = random.below(9);
    const auto any = [&] {
        Vec<T, D> p;
        for (std::size_t k = 0; k < D; ++k) p[k] = spoilt<T>(random, random.uniform(-1, 1), kind);
        return p;
    };
    const auto frames = [&] {
        std::vector<Transform<T, D>> all(bones);
        for (auto& bone : all) {
            bone.translation = any();
            for (auto& axis : bone.columns) axis = any();
            if (random.below(16) == 0) bone.columns[1] = bone.columns[0];
        }
        return all;
    };
    const auto rest = frames(), moves = frames();
    std::vector<Vec<T, D>> places(points);
    for (auto& p : places) p = any();
    std::vector<double> shares(points * bones + (random.below(40) == 0 ? 1 : 0));
    const bool negative = random.below(4) == 0;
    for (double& w : shares) w = random.below(60) == 0 ? 1e300 : random.uniform(negative ? -0.5 : 0, 1);
    const BindOptions options{.linear_precision = LinearPrecision(random.below(2))};
    const auto bound =
        bind_bones(places, std::span<const Transform<T, D>>(rest), std::span<const double>(shares), options);
    count("bind_bones", bound.report.status);
    if (bound.report.status != Status::ok) {
        REQUIRE(bound.value.point_count() == 0);
        REQUIRE(bound.report.status == Status::bone_weights_do_not_match ||
                !bound.report.cage.faults.empty());
        return;
    }
    for (std::size_t i = 0; i < points; ++i) {
        for (std::size_t h = 0; h < bound.value.handle_count(); ++h)
            REQUIRE(is_finite(bound.value.weight(i, h)));
    }
    std::vector<Vec<T, D>> pose(bones * (D + 1)), out(points);
    const Status posed = pose_bones(bound.value, std::span<const Transform<T, D>>(moves), pose);
    count("pose_bones", posed);
    if (posed != Status::ok) {
        REQUIRE(posed == Status::pose_not_finite);
        return;
    }
    REQUIRE(clone(bound.value, pose, out) == Status::ok);
}

template <class T, std::size_t D>
void try_all(Random& random, unsigned long long seed) {
    auto mesh = base_mesh(random);
    const auto faces = harmed(random, mesh);
    squeeze(random, mesh);
    const std::size_t kind = random.below(20);
    const auto points = as<T, D>(random, mesh, kind);
    try_weights<T>(points, faces, random, seed);
    try_bones<T>(points, faces, some_bones(random, mesh, kind), random, seed);
    try_binding<T, D>(random, seed);
}

} // namespace

int main(int argc, char** argv) {
    const unsigned long long first = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 0;
    const unsigned long long cases = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1000;
    for (unsigned long long seed = first; seed < first + cases; ++seed) {
        Random random(seed);
        switch (random.below(8)) {
        case 0: try_all<float, 2>(random, seed); break;
        case 1: try_all<double, 2>(random, seed); break;
        case 2:
        case 3:
        case 4: try_all<float, 3>(random, seed); break;
        default: try_all<double, 3>(random, seed); break;
        }
    }
    for (const auto& [text, times] : outcomes) std::printf("%9zu  %s\n", times, text.c_str());
}
