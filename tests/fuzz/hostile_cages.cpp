// Makes cages of every kind that no one should, and takes each through check, bind and clone: nothing may
// crash, and what is bound is finite. A program of its own, for sanitizers:
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -Iinclude
//             -isystem /usr/include/eigen3 -Itests tests/fuzz/hostile_cages.cpp -o hostile_cages
//     ./hostile_cages FIRST_SEED COUNT [fans|curves]     (only faces that are not planar, only curves)
#include "support/cages.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/curved_green.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/three_point.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

namespace {

using namespace cageform;
using cageform_tests::Random;

#define REQUIRE(condition)                                                                                   \
    if (!(condition)) {                                                                                      \
        std::fprintf(stderr, "seed %llu, line %d: %s\n", seed, __LINE__, #condition);                        \
        std::abort();                                                                                        \
    }

/// Spoils a coordinate of a cage in [-1, 1]^D: some kinds change all numbers, some only a few.
template <class T>
T spoilt(Random& random, double x, std::size_t kind) {
    switch (kind) {
    case 1: return T(std::round(2 * x) / 2); // duplicates, collinear, crossing
    case 2: return T(x * 1e300 * 1e8);       // infinite in float, near the end in double
    case 3: return T(x * 1e-300 * 1e-20);    // subnormal or zero
    case 4: return T(1e6 + x);
    case 5: return random.below(8) == 0 ? std::numeric_limits<T>::quiet_NaN() : T(x);
    case 6: return random.below(8) == 0 ? std::numeric_limits<T>::infinity() : T(x);
    case 7:
        return T(x * std::pow(10.0, random.uniform(sizeof(T) == 4 ? -44 : -320, sizeof(T) == 4 ? 38 : 308)));
    case 8: return T(x * double(std::numeric_limits<T>::max()));
    default: return T(x);
    }
}

template <class T, std::size_t D>
std::vector<Vec<T, D>> hostile_points(Random& random, std::size_t count, bool convex) {
    const std::size_t kind = random.below(16), thin = random.below(3);
    const double width = std::pow(10.0, random.uniform(-17, 0));
    std::vector<Vec<T, D>> points(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * double(i) / double(count);
        for (std::size_t k = 0; k < D; ++k) {
            double x = random.uniform(-1, 1);
            if (convex && k < 2) x = k == 0 ? std::cos(angle) : std::sin(angle);
            if (thin == 1 && k + 1 == D) x *= width;
            if (thin == 2 && k > 0) x *= width;
            points[i][k] = spoilt<T>(random, x, kind);
        }
        if (i > 0 && random.below(12) == 0 && kind % 2 == 1) points[i] = points[random.below(i)];
    }
    return points;
}

/// From poses of the vertices: at rest the handles as they are, and numbers in any pose that is taken.
template <class T, std::size_t D>
void pose_faces(const Binding<T, D>& binding, Random& random, unsigned long long seed) {
    std::vector<Vec<T, D>> rest, vertices, handles(binding.handle_count());
    for (std::size_t h = 0; h < handles.size(); ++h) {
        rest.push_back(binding.rest_handle(h));
        if (binding.handle_view().is_point(h)) vertices.push_back(rest[h]);
    }
    const Status at_rest = pose_handles(binding, vertices, handles).status;
    REQUIRE(at_rest == Status::pose_not_finite || (at_rest == Status::ok && handles == rest));
    vertices = hostile_points<T, D>(random, vertices.size(), false);
    if (pose_handles(binding, vertices, handles).status != Status::ok) return;
    for (const auto& handle : handles) REQUIRE(is_finite(handle));
}

/// Binds places in and about the cage, and moves them.
template <class C>
Status take(const C& coordinates, Random& random, unsigned long long seed) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    auto points = hostile_points<T, D>(random, 5, false);
    for (std::size_t i = 0; i < 4 && !coordinates.handles().empty(); ++i) {
        const auto a = coordinates.handles()[random.below(coordinates.handles().size())];
        const auto b = coordinates.handles()[random.below(coordinates.handles().size())];
        points.push_back(T(0.5) * a + T(0.5) * b);
        points.push_back(a);
    }
    const BindOptions options{.outside = OutsidePoints(random.below(3)),
                              .linear_precision = LinearPrecision(random.below(2))};
    const auto [binding, report] = bind(coordinates, points, options);
    // A solver may refuse a sound cage: its grid is too coarse for it, or too large a number.
    REQUIRE(report.status == coordinates.cage_report().status ||
            (!C::closed_form && report.status != Status::ok));
    if (report.status != Status::ok) {
        REQUIRE(binding.point_count() == 0);
        return report.status;
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t h = 0; h < binding.handle_count(); ++h) REQUIRE(is_finite(binding.weight(i, h)));
    }
    std::vector<Vec<T, D>> pose, out(points.size());
    for (std::size_t h = 0; h < binding.handle_count(); ++h) pose.push_back(binding.rest_handle(h));
    REQUIRE(clone(binding, pose, out) == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (is_finite(points[i])) REQUIRE(out[i] == points[i]);
    }
    pose_faces(binding, random, seed);
    pose[0] = pose[pose.size() - 1]; // beyond 1e36 the way there may be no number
    const Status moved = clone(binding, pose, out);
    REQUIRE(moved == Status::ok || moved == Status::pose_not_finite);
    return Status::ok;
}

template <class T>
Status in_plane(Random& random, unsigned long long seed) {
    const std::size_t count = random.below(14);
    const auto vertices = hostile_points<T, 2>(random, count, random.below(2) == 0);
    if (random.below(6) == 0) return take(BarycentricCoordinates<T, 2>(vertices), random, seed);
    std::vector<std::size_t> loops;
    if (random.below(3) == 0) {
        for (std::size_t left = count; left > 0;) {
            loops.push_back(1 + random.below(left));
            left -= loops.back();
        }
        if (random.below(4) == 0) loops.push_back(random.bits() >> random.below(64));
    }
    const Polygon<T> cage(vertices, loops);
    switch (random.below(4)) {
    case 0: return take(GreenCoordinates<T, 2>(cage), random, seed);
    case 1: return take(WachspressCoordinates<T>(cage), random, seed);
    case 2: return take(DiscreteHarmonicCoordinates<T>(cage), random, seed);
    default: break;
    }
    return take(MeanValueCoordinates<T, 2>(cage), random, seed);
}

/// Faces of any number of corners as fans, most of them warped.
template <class T>
Status with_fans(std::vector<Vec<T, 3>> vertices, const std::vector<std::vector<std::int64_t>>& faces,
                 Random& random, unsigned long long seed) {
    double size = 1;
    if (random.below(4) != 0) { // a prism over a regular polygon, of any size
        size = std::pow(10.0, random.below(2) == 0 ? 0 : random.uniform(-1, 1) * (sizeof(T) == 4 ? 30 : 140));
        const std::size_t n = vertices.size() / 2;
        for (std::size_t i = 0; i < 2 * n; ++i) {
            const double angle = 2 * std::numbers::pi * double(i) / double(n);
            const Vec<double, 3> p{std::cos(angle), std::sin(angle), i < n ? 0.0 : 1.0};
            vertices[i] = vec_cast<T>(size * p);
        }
    }
    const double warp = random.below(4) == 0 ? 0 : size * std::pow(10.0, random.uniform(-17, 0));
    for (auto& v : vertices) {
        for (std::size_t k = 0; k < 3; ++k) v[k] += T(warp * random.uniform(-1, 1));
    }
    const bool all = random.below(2) == 0;
    PolyhedralOptions options{
        .off_plane = random.below(8) == 0 ? random.uniform(-1, 1) : 0,
        .non_planar = all ? PolyhedralOptions::NonPlanar::refuse : PolyhedralOptions::NonPlanar::fan,
        .faces = all ? PolyhedralOptions::Faces::fan : PolyhedralOptions::Faces::planar};
    if (random.below(4) == 0) options.divisions = 2 + std::uint32_t(random.below(3));
    if (random.below(50) == 0) options.divisions = std::uint32_t(random.bits());
    if (random.below(50) == 0) options.divisions = 0;
    const PolyhedralMesh<T> mesh(vertices, faces, options);
    const auto report = check(mesh);
    for (const auto& fault : report.faults) {
        const bool of_faces =
            fault.kind == CageFaultKind::faces_cross || fault.kind == CageFaultKind::face_flipped;
        // A face from face_count() on closes a gap.
        if (of_faces) REQUIRE(fault.a <= mesh.face_count() && fault.b <= mesh.face_count());
        if (fault.kind == CageFaultKind::open_edge || fault.kind == CageFaultKind::gap_closed ||
            fault.kind == CageFaultKind::edge_not_manifold || fault.kind == CageFaultKind::duplicate_vertices)
            REQUIRE(fault.a < mesh.size() && fault.b < mesh.size());
        if (fault.kind == CageFaultKind::vertex_not_manifold || fault.kind == CageFaultKind::vertex_unused ||
            fault.kind == CageFaultKind::vertex_not_finite)
            REQUIRE(fault.a < mesh.size());
    }
    if (random.below(16) == 0) {
        HarmonicOptions grid;
        grid.resolution = 8 + random.below(24);
        return take(HarmonicCoordinates(mesh, grid, cageform::UniformGrid{}), random, seed);
    }
    if (random.below(2) == 0) return take(GreenCoordinates(mesh), random, seed);
    return take(MeanValueCoordinates(mesh), random, seed);
}

/// The prism's faces as polygons, or any loops.
template <class T>
Status with_polygons(const std::vector<Vec<T, 3>>& vertices, Random& random, unsigned long long seed,
                     bool fans) {
    const auto n = std::int64_t(vertices.size() / 2);
    std::vector<std::vector<std::int64_t>> faces(2);
    for (std::int64_t i = 0; i < n; ++i) {
        faces[0].push_back(n - 1 - i);
        faces[1].push_back(n + i);
        faces.push_back({i, (i + 1) % n, n + (i + 1) % n, n + i});
    }
    auto& face = faces[random.below(faces.size())];
    const std::size_t harm = random.below(10), corner = random.below(face.size());
    if (harm == 0) face[corner] = std::int64_t(random.bits());
    if (harm == 1) face[corner] = std::int64_t(random.below(vertices.size()));
    if (harm == 2) std::swap(face[0], face[corner]);
    if (harm == 3) face.resize(random.below(face.size()));
    if (harm == 4) faces.push_back(face);
    if (harm == 5) face.insert(face.begin() + std::ptrdiff_t(corner), face[0]);
    if (harm == 6) faces.resize(random.below(faces.size()));
    if (harm == 7) {
        for (auto& i : face) i = std::int64_t(random.below(vertices.size()));
    }
    if (fans) return with_fans(vertices, faces, random, seed);
    const cageform::PolyhedralOptions off_plane{
        .off_plane = random.below(3) == 0 ? double(T(random.uniform(0, 1))) : 0};
    if (random.below(4) == 0) {
        HarmonicOptions options;
        options.resolution = 8 + random.below(24);
        return take(HarmonicCoordinates(PolyhedralMesh<T>(vertices, faces, off_plane), options,
                                        cageform::UniformGrid{}),
                    random, seed);
    }
    return take(MeanValueCoordinates<T, 3, PolyhedralMesh<T>>(vertices, faces, off_plane), random, seed);
}

/// A prism of an n-gon, or any faces.
template <class T>
Status in_space(Random& random, unsigned long long seed, bool only_fans) {
    const std::size_t n = 3 + random.below(4);
    std::vector<std::array<std::int64_t, 3>> faces;
    auto vertices = hostile_points<T, 3>(random, 2 * n, false);
    if (random.below(2) == 0) {
        const auto ring = hostile_points<T, 3>(random, n, true);
        const T height = spoilt<T>(random, random.uniform(0.5, 1), random.below(9));
        for (std::size_t i = 0; i < n; ++i) {
            vertices[i] = vertices[n + i] = ring[i];
            vertices[i][2] = 0;
            vertices[n + i][2] = height;
        }
    }
    const std::size_t kind = random.below(6);
    if (only_fans || kind < 2) return with_polygons(vertices, random, seed, only_fans || kind == 0);
    const auto m = std::int64_t(n);
    for (std::int64_t i = 0; i < m; ++i) {
        const std::int64_t j = (i + 1) % m;
        faces.insert(faces.end(), {{i, j, m + j}, {i, m + j, m + i}});
        if (i > 0 && i + 1 < m) faces.insert(faces.end(), {{0, i + 1, i}, {m, m + i, m + i + 1}});
    }
    const std::size_t harm = random.below(8);
    auto& face = faces[random.below(faces.size())];
    if (harm == 0) face[random.below(3)] = std::int64_t(random.bits());
    if (harm == 1) face[random.below(3)] = std::int64_t(random.below(2 * n));
    if (harm == 2) faces.resize(random.below(faces.size()));
    if (harm == 3) faces.push_back(face);
    if (harm == 4) std::swap(face[0], face[1]);
    if (random.below(2) == 0) return take(GreenCoordinates<T, 3>(vertices, faces), random, seed);
    return take(MeanValueCoordinates<T, 3>(vertices, faces), random, seed);
}

/// Loops of curves whose control points lie along a ring, or anywhere. Some are open, or no curves.
template <class T>
Status with_curves(Random& random, unsigned long long seed) {
    std::vector<typename CurvedPolygon<T>::Loop> loops(random.below(16) == 0 ? random.below(4) : 1);
    for (auto& loop : loops) {
        const std::size_t edges = (random.below(16) == 0 ? 0 : 1) + random.below(6), count = 4 * edges;
        const auto points = hostile_points<T, 2>(random, count, random.below(4) != 0);
        for (std::size_t e = 0; e < edges; ++e) {
            const std::size_t degree = random.below(20) == 0 ? random.below(6) : 1 + random.below(3);
            auto& edge = loop.emplace_back();
            edge.push_back(points[4 * e]);
            for (std::size_t i = 1; i < degree; ++i) edge.push_back(points[4 * e + i % 4]);
            if (degree > 0) edge.push_back(points[(4 * e + 4) % count]);
            if (degree > 2 && random.below(5) == 0) edge[1] = edge[0];
            if (degree > 2 && random.below(5) == 0) edge[degree - 1] = edge[degree];
            if (random.below(30) == 0) edge.back() = points[random.below(count)];
        }
    }
    CurvedGreenOptions<T> options;
    if (random.below(3) == 0) options.posed_degree = random.below(7);
    if (random.below(8) == 0) {
        for (std::size_t e = random.below(8); e-- > 0;) options.posed_degrees.push_back(random.below(7));
    }
    if (random.below(4) == 0)
        options.disk = {{T(random.uniform(-1, 1)), T(random.uniform(-1, 1))},
                        spoilt<T>(random, 3, random.below(9))};
    return take(CurvedGreenCoordinates<T>(CurvedPolygon<T>(loops), options), random, seed);
}

} // namespace

int main(int count, char** arguments) {
    const unsigned long long first = count > 1 ? std::strtoull(arguments[1], nullptr, 10) : 0;
    const unsigned long long cages = count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 10000;
    const std::string only = count > 3 ? arguments[3] : "";
    std::map<std::string, std::size_t> outcomes;
    for (unsigned long long seed = first; seed < first + cages; ++seed) {
        Random random(seed);
        const bool in_float = seed % 2 == 0;
        const auto kind = only.empty() ? seed / 2 % 3 : only == "fans" ? 1 : 2;
        const Status status =
            kind == 0   ? (in_float ? in_plane<float>(random, seed) : in_plane<double>(random, seed))
            : kind == 2 ? (in_float ? with_curves<float>(random, seed) : with_curves<double>(random, seed))
            : in_float  ? in_space<float>(random, seed, only == "fans")
                        : in_space<double>(random, seed, only == "fans");
        ++outcomes[to_string(status)];
    }
    for (const auto& [text, times] : outcomes) std::printf("%9zu  %s\n", times, text.c_str());
}
