// Laws of pair_faces and of its matching.

#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/effort.hpp"
#include "../support/larger.hpp"
#include "../support/meshes.hpp"

#include <cageform/enclose/make_cage_3d.hpp>
#include <cageform/enclose/space/matching.hpp>

#include <map>
#include <set>

namespace pair_faces_tests {

using namespace cageform;
using namespace cageform_tests;
using Point = Vec<double, 3>;
using Three = std::array<std::uint32_t, 3>;
using Made = Result<TriangleMesh<double>, MakeCageReport>;
using Paired = Result<PolyhedralMesh<double>, MakeCageReport>;

namespace {

/// The maximum weight by brute force over all sets of vertices.
std::int64_t best_sum(std::size_t vertices, const std::vector<detail::WeightedEdge>& edges) {
    std::vector<std::int64_t> best(std::size_t{1} << vertices, 0);
    for (std::size_t set = 0; set < best.size(); ++set) {
        for (const auto& [a, b, weight] : edges) {
            const std::size_t both = std::size_t{1} << a | std::size_t{1} << b;
            if ((set & both) == both) best[set] = larger(best[set], best[set ^ both] + weight);
        }
    }
    return best.back();
}

Point at(const MeshData& data, int v) {
    return data.vertices[std::size_t(v)];
}

/// The minimum distance of sampled points of a figure from a cage; negative if a point is outside.
double sampled_clearance(const TriangleMesh<double>& cage, const MeshData& figure) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : figure.faces) {
        for (const Point& p : {at(figure, a), (1.0 / 3) * (at(figure, a) + at(figure, b) + at(figure, c))}) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const auto& face : cage.faces())
                nearest =
                    std::min(nearest, detail::distance_to_facet(p, Facet<3>(face, cage.vertices()).corner));
            least = std::min(least, detail::is_enclosed(winding_number(cage, p)) ? nearest : -nearest);
        }
    }
    return least;
}

/// A rough ball as a cage with a report like that of make_cage; the figure is the shrunk ball.
struct RoughBall {
    MeshData figure;
    Made made;

    explicit RoughBall(std::uint64_t seed, bool is_mirrored = false)
        : figure(sphere(2)) {
        Random random(seed);
        MeshData cage = figure;
        std::map<std::array<double, 3>, double> radius; // equal for mirror images
        for (std::size_t v = 0; v < cage.vertices.size(); ++v) {
            const Point p = cage.vertices[v];
            const auto found = radius.insert(
                {{is_mirrored ? std::fabs(p[0]) : p[0], p[1], p[2]}, random.uniform(0.85, 1.15)});
            cage.vertices[v] = found.first->second * p;
            figure.vertices[v] = 0.85 * cage.vertices[v];
        }
        made.value = cage.mesh<double>();
        made.report.margin = made.report.clearance = sampled_clearance(made.value, figure);
    }
    Paired pair(const MakeCageOptions& options = {}) const {
        return pair_faces(made, figure.vertices, figure.faces, options);
    }
};

Three from_least(Three face) {
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    return face;
}

/// The two triangles of a quad, split at a corner.
std::array<Three, 2> cut(std::span<const std::uint32_t> quad, std::size_t corner) {
    const auto v = [&](std::size_t k) { return quad[(corner + k) % 4]; };
    return {{{v(0), v(1), v(2)}, {v(0), v(2), v(3)}}};
}

std::set<std::set<std::uint32_t>> faces_of(const PolyhedralMesh<double>& mesh) {
    std::set<std::set<std::uint32_t>> faces;
    for (std::size_t f = 0; f < mesh.face_count(); ++f)
        faces.insert({mesh.face(f).begin(), mesh.face(f).end()});
    return faces;
}

/// Distance between the lines of the diagonals over the mean edge length.
double warp_of(const PolyhedralMesh<double>& mesh, std::span<const std::uint32_t> quad) {
    const Point normal = cross(mesh[quad[2]] - mesh[quad[0]], mesh[quad[3]] - mesh[quad[1]]);
    double edges = 0;
    for (std::size_t k = 0; k < 4; ++k) edges += detail::length(mesh[quad[(k + 1) % 4]] - mesh[quad[k]]);
    return std::fabs(dot(mesh[quad[1]] - mesh[quad[0]], normal)) / detail::length(normal) / (edges / 4);
}

} // namespace

TEST_CASE("a matching has the maximum weight", "[enclose][property]") {
    for (std::uint64_t seed = 0; seed < effort(3000u, 300u); ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const std::size_t vertices = 2 + random.below(9);
        const auto most = std::int64_t(1) << random.below(40); // with 1, many sums are ties
        std::vector<detail::WeightedEdge> edges;
        for (std::size_t n = random.below(3 * vertices); n > 0; --n) {
            const auto a = std::uint32_t(random.below(vertices)), b = std::uint32_t(random.below(vertices));
            if (a != b) edges.push_back({a, b, 1 + std::int64_t(random.below(std::size_t(most)))});
        }
        const detail::Matching matching(vertices, edges);
        std::int64_t sum = 0;
        for (std::uint32_t v = 0; v < vertices; ++v) {
            const std::uint32_t e = matching.edge_at(v);
            if (e == detail::Matching::none) continue;
            REQUIRE((edges[e].a == v || edges[e].b == v));
            REQUIRE(matching.edge_at(edges[e].a ^ edges[e].b ^ v) == e);
            if (edges[e].a == v) sum += edges[e].weight;
        }
        REQUIRE(sum == best_sum(vertices, edges));
    }
}

TEST_CASE("each triangle is a face of the paired cage or half of a quad", "[enclose][property]") {
    for (std::uint64_t seed = 0; seed < effort(20u, 3u); ++seed) {
        CAPTURE(seed);
        const RoughBall ball(seed);
        const auto paired = ball.pair();
        REQUIRE(to_string(paired.report.status) == std::string("ok"));
        for (const auto& fault : paired.report.cage.faults)
            CHECK(fault.kind == CageFaultKind::face_fanned); // a warning
        CHECK(std::ranges::equal(paired.value.vertices(), ball.made.value.vertices()));
        std::multiset<Three> triangles, left;
        for (const auto& face : ball.made.value.faces()) left.insert(from_least(face));
        std::size_t quads = 0;
        double worst = 0;
        for (std::size_t f = 0; f < paired.value.face_count(); ++f) {
            const auto face = paired.value.face(f);
            if (face.size() == 3) {
                triangles.insert(from_least({face[0], face[1], face[2]}));
                continue;
            }
            REQUIRE(face.size() == 4);
            ++quads;
            worst = larger(worst, warp_of(paired.value, face));
            const auto old = cut(face, 0), other = cut(face, 1);
            const bool is_old = left.contains(from_least(old[0])) && left.contains(from_least(old[1]));
            for (const Three& half : is_old ? old : other) triangles.insert(from_least(half));
        }
        CHECK(triangles == left); // same orientation
        CHECK(paired.report.quads == quads);
        CHECK(paired.report.triangles + 2 * quads == left.size());
        CHECK(quads > left.size() / 4); // at least half of the triangles
        CHECK(std::fabs(paired.report.worst_warp - worst) <= 1e-12);
        CHECK(worst <= 0.4);
    }
}

TEST_CASE("a cage contains its figure and does not cross itself, however its quads are split",
          "[enclose][property]") {
    for (std::uint64_t seed = 0; seed < effort(6u, 1u); ++seed) {
        CAPTURE(seed);
        const RoughBall ball(seed);
        const auto paired = ball.pair();
        REQUIRE(paired);
        CHECK(paired.report.clearance >= 0.25 * ball.made.report.margin);
        Random random(seed);
        for (int trial = 0; trial < 6; ++trial) {
            CAPTURE(trial);
            std::vector<Three> triangles;
            for (std::size_t f = 0; f < paired.value.face_count(); ++f) {
                const auto face = paired.value.face(f);
                if (face.size() == 3) {
                    triangles.push_back({face[0], face[1], face[2]});
                } else {
                    const auto halves = cut(face, trial < 2 ? std::size_t(trial) : random.below(2));
                    triangles.insert(triangles.end(), halves.begin(), halves.end());
                }
            }
            const TriangleMesh<double> mesh(paired.value.vertices(), triangles);
            const auto report = check(mesh);
            CHECK(report.status == Status::ok);
            CHECK(report.faults.empty());
            CHECK(sampled_clearance(mesh, ball.figure) >= paired.report.clearance * (1 - 1e-9));
        }
        CHECK(sampled_clearance(paired.value.triangles(), ball.figure) >=
              paired.report.clearance * (1 - 1e-9));
    }
}

TEST_CASE("faces are symmetric, deterministic and independent of scale", "[enclose][property]") {
    for (std::uint64_t seed = 0; seed < effort(10u, 2u); ++seed) {
        CAPTURE(seed);
        const RoughBall ball(seed, true);
        MakeCageOptions options;
        options.mirror = MirrorPlane{0, {}};
        const auto paired = ball.pair(options);
        REQUIRE(paired);
        CHECK(paired.report.quads > paired.report.triangles / 2);
        const auto vertices = paired.value.vertices();
        std::vector<std::uint32_t> image;
        for (const Point& p : vertices) {
            const auto found = std::find_if(vertices.begin(), vertices.end(), [&](const Point& q) {
                return detail::length(q - Point{-p[0], p[1], p[2]}) <= 1e-12;
            });
            REQUIRE(found != vertices.end());
            image.push_back(std::uint32_t(found - vertices.begin()));
        }
        const auto faces = faces_of(paired.value);
        for (const auto& face : faces) {
            std::set<std::uint32_t> mirrored;
            for (const auto v : face) mirrored.insert(image[v]);
            CHECK(faces.contains(mirrored));
        }
        CHECK(faces == faces_of(ball.pair(options).value));
        RoughBall scaled = ball;
        std::vector<Point> larger_cage;
        for (const Point& p : vertices) larger_cage.push_back(8.0 * p);
        for (Point& p : scaled.figure.vertices) p = 8.0 * p;
        scaled.made.value = TriangleMesh<double>(larger_cage, ball.made.value.faces());
        scaled.made.report.margin *= 8;
        scaled.made.report.clearance *= 8;
        CHECK(faces == faces_of(scaled.pair(options).value));
    }
}

TEST_CASE("split squares are recovered", "[enclose]") {
    const MeshData figure{{{-0.1, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}}, {{0, 1, 2}}};
    Made made;
    made.value = divided_box({3, 2, 4}, 1).mesh<double>();
    made.report.margin = made.report.clearance = 0.8;
    const auto paired = pair_faces(made, figure.vertices, figure.faces);
    REQUIRE(paired);
    CHECK(paired.report.triangles == 0);
    CHECK(paired.report.quads == made.value.faces().size() / 2);
    CHECK(paired.report.worst_warp == 0);
    for (std::size_t f = 0; f < paired.value.face_count(); ++f) {
        const auto face = paired.value.face(f);
        REQUIRE(face.size() == 4);
        for (std::size_t k = 0; k < 4; ++k)
            CHECK(detail::length(paired.value[face[(k + 1) % 4]] - paired.value[face[k]]) == 1);
    }
}

TEST_CASE("invalid input of pair_faces is reported", "[enclose][error]") {
    RoughBall ball(1);
    ball.figure.faces.push_back({0, 1, 999});
    const auto beyond = ball.pair();
    CHECK(beyond.report.status == Status::index_out_of_range);
    CHECK(beyond.report.culprit == ball.figure.faces.size() - 1);
    CHECK(beyond.value.size() == 0);
    ball.made.report.status = Status::cage_not_found;
    CHECK(ball.pair().report.status == Status::cage_not_found);
    CHECK(ball.pair().value.size() == 0);
}

} // namespace pair_faces_tests
