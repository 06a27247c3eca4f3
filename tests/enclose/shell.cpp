// Internal steps of 3D cages: touching faces, quadrics, clear tests, lattices.

#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/meshes.hpp"

#include <cageform/enclose/space/reduce_shell.hpp>
#include <cageform/enclose/space/relax_shell.hpp>
#include <cageform/enclose/space/space_distance.hpp>
#include <cageform/enclose/space/surface_nets.hpp>

namespace shell_tests {

using namespace cageform;
using namespace cageform_tests;
using Point = Vec<double, 3>;

namespace {

Point random_place(Random& random) {
    return {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
}

/// A sphere of 66 vertices with radii between 0.9 and 1.4.
detail::Shell random_shell(Random& random) {
    const auto sphere = cageform_tests::sphere(2);
    detail::Shell shell;
    for (const auto& p : sphere.vertices)
        shell.points.push_back((random.uniform(0.9, 1.4) / detail::length(p)) * p);
    for (const auto& face : sphere.faces)
        shell.faces.push_back({std::uint32_t(face[0]), std::uint32_t(face[1]), std::uint32_t(face[2])});
    shell.on_rim.assign(shell.points.size(), false);
    shell.link();
    return shell;
}

std::vector<std::uint32_t> all_faces(const detail::Shell& shell) {
    std::vector<std::uint32_t> all;
    for (std::uint32_t f = 0; f < shell.faces.size(); ++f) {
        if (shell.is_face(f)) all.push_back(f);
    }
    return all;
}

/// The half of a shell with x >= 0, open along a rim.
detail::Shell half_of(detail::Shell shell) {
    shell.half = true;
    for (std::uint32_t f = 0; f < shell.faces.size(); ++f) {
        const auto corner = shell.corners(shell.faces[f]);
        if (corner[0][0] + corner[1][0] + corner[2][0] < 0) shell.remove_face(f);
    }
    return shell;
}

/// The distance from a ball about the origin on a lattice.
detail::DistanceLattice<3> ball_lattice() {
    detail::DistanceLattice<3> lattice({-2, -2, -2}, 0.1, {41, 41, 41}, 4);
    for (std::size_t node = 0; node < lattice.size(); ++node)
        lattice[node] = float(detail::length(lattice.position(node)) - 0.5);
    return lattice;
}

} // namespace

TEST_CASE("moving a vertex changes the energy of its star and of the shell equally", "[enclose][property]") {
    Random random(4);
    for (const bool half : {false, true}) {
        detail::Shell shell = half ? half_of(random_shell(random)) : random_shell(random);
        const detail::ShellEnergy energy(shell.six_volumes(), shell.points.size(), 12, 1);
        detail::StarEnergy star_energy(energy);
        const auto all = all_faces(shell);
        for (int n = 0; n < 100; ++n) {
            CAPTURE(half, n);
            const auto v = std::uint32_t(random.below(shell.points.size()));
            if (shell.star[v].empty()) continue;
            const double before = energy.of(shell, all), here = energy.of(shell, shell.star[v]);
            star_energy.select(shell, v);
            const double at_first = star_energy.at(shell.points[v]);
            shell.points[v] = shell.points[v] + 0.3 * random_place(random);
            const double change = energy.of(shell, all) - before;
            CHECK(std::fabs(change - (energy.of(shell, shell.star[v]) - here)) <= 1e-11);
            CHECK(std::fabs(change - (star_energy.at(shell.points[v]) - at_first)) <= 1e-11);
        }
    }
}

TEST_CASE("relaxed shells are tighter and clear of the figure", "[enclose][property]") {
    const auto lattice = ball_lattice();
    const detail::ShellObstacles obstacles{&lattice, 0.1};
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        detail::Shell shell = random_shell(random);
        const double six = shell.six_volumes();
        const auto all = all_faces(shell);
        const detail::ShellEnergy energy(six, shell.points.size(), 12, 1);
        const double before = energy.of(shell, all);
        REQUIRE(detail::ShellRelaxation(shell, obstacles, energy).relax(24, {}));
        CHECK(energy.of(shell, all) < 0.5 * before);
        CHECK(shell.six_volumes() < 0.5 * six);
        CHECK(shell.six_volumes() > 6 * std::numbers::pi / 6); // of the ball
        std::size_t edges = 0;
        for (std::uint32_t v = 0; v < shell.points.size(); ++v) edges += shell.neighbours(v).size();
        CHECK(edges == 3 * shell.faces.size());
        const detail::ClearTest clear(lattice, 0.5);
        for (const auto& face : shell.faces) CHECK(clear.is_clear(shell.corners(face)));
    }
}

TEST_CASE("the quick test of two faces agrees with the full one", "[enclose][property]") {
    Random random(1);
    std::array<std::array<std::size_t, 2>, 3> verdicts{};
    for (int n = 0; n < 6000; ++n) {
        // Two faces with no, one or two common vertices; some are as close as the gap.
        const std::size_t shared = random.below(3);
        std::vector<Point> points;
        for (int k = 0; k < 6; ++k) points.push_back(random_place(random));
        const double gap = 1e-3;
        if (random.below(2) == 0) { // parallel faces
            const Point &a = points[0], &b = points[1], &c = points[2];
            const Point normal = (1 / detail::length(cross(b - a, c - a))) * cross(b - a, c - a);
            for (std::size_t k = 3; k < 6; ++k)
                points[k] = a + random.uniform(-2, 2) * (b - a) + random.uniform(-2, 2) * (c - a) +
                            (gap * random.uniform(0, 3)) * normal;
        }
        std::array<std::uint32_t, 3> first{0, 1, 2}, second{3, 4, 5};
        for (std::size_t k = 0; k < shared; ++k) second[k] = first[(k + 1) % 3];
        std::rotate(second.begin(), second.begin() + std::ptrdiff_t(random.below(3)), second.end());
        const Facet<3> a(first, std::span<const Point>(points)), b(second, std::span<const Point>(points));
        CAPTURE(n, shared);
        const bool touch = detail::facets_touch(a, b, gap);
        const Point normal = detail::area_normal(a.corner);
        const bool found = detail::faces_touch(a, normal, gap * detail::length(normal), b, gap);
        // Near a common vertex, faces may be closer than the gap.
        CHECK((found == touch || (shared > 0 && !found && !detail::facets_touch(a, b, 0))));
        ++verdicts[shared][touch ? 1 : 0];
    }
    for (const auto& counts : verdicts) CHECK((counts[0] > 50 && counts[1] > 50));
}

TEST_CASE("a quadric is the sum of squared distances from planes, with the right minimum",
          "[enclose][property]") {
    Random random(2);
    for (int n = 0; n < 200; ++n) {
        CAPTURE(n);
        struct Plane {
            Point normal, at;
            double weight;
        };
        std::vector<Plane> planes;
        detail::Quadric quadric;
        for (std::size_t k = 3 + random.below(4); k > 0; --k) {
            planes.push_back({random_place(random), random_place(random), random.uniform(0.5, 2)});
            detail::Quadric one;
            one.add_plane(planes.back().normal, planes.back().at, planes.back().weight);
            quadric += one;
        }
        const auto expected = [&](const Point& p) {
            double sum = 0;
            for (const auto& plane : planes) {
                const double off = dot(plane.normal, p - plane.at);
                sum += plane.weight * off * off;
            }
            return sum;
        };
        for (int k = 0; k < 5; ++k) {
            const Point p = 3.0 * random_place(random);
            CHECK(quadric.at(p) == Approx(expected(p)).epsilon(1e-12).margin(1e-12));
        }
        Point least{};
        if (!quadric.least(least)) continue;
        for (int k = 0; k < 20; ++k)
            CHECK(expected(least) <= expected(least + 0.01 * random_place(random)) + 1e-9);
    }
    detail::Quadric flat;
    flat.add_plane({0, 0, 2}, {5, 6, 7}, 1);
    flat.add_plane({0, 1, 0}, {5, 6, 7}, 1);
    Point none{};
    CHECK_FALSE(flat.least(none));
    CHECK(flat.at({1, 8, 9}) == Approx(4 * 4 + 4));
}

TEST_CASE("step directions: both ways along three axes, to the middle, and inwards", "[enclose][property]") {
    Random random(3);
    for (int n = 0; n < 200; ++n) {
        const auto coordinate = [&] { return random.below(4) == 0 ? 0.0 : random.uniform(-1, 1); };
        Point normal{coordinate(), coordinate(), coordinate()};
        if (detail::length(normal) == 0) normal[2] = 1;
        normal = (1 / detail::length(normal)) * normal;
        const Point to_middle{coordinate(), coordinate(), coordinate()};
        CAPTURE(n);
        const auto u = detail::step_directions(normal, to_middle);
        CHECK(u[0] == normal);
        for (std::size_t i = 0; i < 7; ++i) CHECK(detail::length(u[i]) == Approx(1));
        for (std::size_t i = 0; i < 6; i += 2) {
            CHECK(detail::length(u[i] + u[i + 1]) <= 1e-15);
            CHECK(std::fabs(dot(u[i], u[(i + 2) % 6])) <= 1e-15);
        }
        const double away = detail::length(to_middle);
        if (away > 0) CHECK(dot(u[6], to_middle) == Approx(away));
        Point across{}; // the slanted directions surround the normal
        for (std::size_t i = 7; i < 10; ++i) {
            CHECK(detail::length(u[i]) <= 1.04);
            CHECK(dot(u[i], normal) == Approx(-0.7));
            const Point part = u[i] + 0.7 * normal;
            CHECK(detail::length(part) >= 0.69);
            across = across + part;
        }
        CHECK(detail::length(across) == Approx(0.4));
    }
}

TEST_CASE("a half has no interior edge between two rim vertices", "[enclose][property]") {
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        detail::DistanceLattice<3> lattice({-1.95, -2, -2}, 0.1, {40, 41, 41}, 4);
        std::vector<std::uint8_t> outside(lattice.size());
        const std::array<Point, 3> middles{random_place(random), random_place(random), random_place(random)};
        for (std::size_t node = 0; node < lattice.size(); ++node) {
            Point p = lattice.position(node);
            p[0] = std::fabs(p[0]);
            for (const Point& middle : middles)
                lattice[node] = (std::min)(lattice[node], float(detail::length(p - middle) - 0.4));
            outside[node] = lattice[node] > 0 ? 1 : 0;
        }
        detail::make_well_composed(lattice, outside);
        auto shell = detail::SurfaceNets(lattice, outside, true).shell();
        const double six = shell.six_volumes();
        const detail::ShellObstacles obstacles{&lattice, 0.2};
        REQUIRE(detail::ShellReduction(shell, obstacles).reduce_to(8, {}));
        const detail::ShellEnergy energy(six, 8, 6, 1);
        REQUIRE(detail::ShellRelaxation(shell, obstacles, energy).relax(6, {}));
        for (const auto f : all_faces(shell)) {
            const auto& face = shell.faces[f];
            for (std::size_t k = 0; k < 3; ++k) {
                const auto v = face[k], w = face[(k + 1) % 3];
                const bool is_inside = shell.face_across(f, v, w) != detail::Shell::none;
                CHECK((!is_inside || !shell.on_rim[v] || !shell.on_rim[w]));
            }
        }
    }
}

TEST_CASE("a triangle is clear if all its points are", "[enclose][property]") {
    const auto lattice = ball_lattice();
    const detail::ClearTest clear(lattice, 0.5);
    Random random(7);
    int free = 0, met = 0;
    for (int n = 0; n < 2000; ++n) {
        CAPTURE(n);
        const detail::Corners<3> corner{1.5 * random_place(random), 1.5 * random_place(random),
                                        1.5 * random_place(random)};
        const double distance = detail::distance_to_facet(Point{}, corner);
        const bool is_clear = clear.is_clear(corner);
        // Where f = 0, samples are at most 0.8 spacings from every point of a triangle.
        if (distance > 0.51) CHECK(is_clear);
        if (distance < 0.38) CHECK_FALSE(is_clear);
        free += is_clear ? 1 : 0;
        met += is_clear ? 0 : 1;
    }
    CHECK(free > 100);
    CHECK(met > 100);
}

TEST_CASE("batched and single tests of triangles agree", "[enclose][property]") {
    const auto lattice = ball_lattice();
    const detail::ClearTest alone(lattice, 0.5);
    detail::ClearTest together(lattice, 0.5);
    int refused = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        // A fan around a moving vertex. Corners are clear.
        std::vector<Point> ring;
        for (int k = 0; k < 6; ++k)
            ring.push_back({1.2 * std::cos(k), 1.2 * std::sin(k), random.uniform(-0.5, 0.8)});
        together.reset();
        for (int n = 0; n < 30; ++n) {
            const Point p = 0.4 * random_place(random) + Point{0, 0, 0.8};
            if (!alone.is_clear(p)) continue;
            const auto triangle = [&](std::size_t k) {
                return detail::Corners<3>{p, ring[k], ring[(k + 1) % ring.size()]};
            };
            bool all = true;
            for (std::size_t k = 0; k < ring.size(); ++k) all = all && alone.is_clear(triangle(k));
            const bool found = together.are_clear(ring.size(), triangle);
            // The batch samples one more point, which may reject a close triangle.
            double nearest = std::numeric_limits<double>::infinity();
            for (std::size_t k = 0; k < ring.size(); ++k)
                nearest = std::min(nearest, detail::distance_to_facet(Point{}, triangle(k)));
            CHECK((found == all || (all && nearest < 0.5)));
            refused += found ? 0 : 1;
        }
    }
    CHECK((refused > 100 && refused < 1000));
}

TEST_CASE("the local frame of a triangle gives its distance", "[enclose][property]") {
    Random random(6);
    for (int n = 0; n < 3000; ++n) {
        CAPTURE(n);
        detail::Corners<3> corner{random_place(random), random_place(random), random_place(random)};
        if (n % 5 == 1) corner[2] = 0.3 * corner[0] + 0.7 * corner[1]; // a segment
        if (n % 5 == 2) corner[2] = corner[0];
        if (n % 20 == 3) corner[1] = corner[2] = corner[0];
        if (n % 5 == 4) { // a needle
            const auto k = std::size_t(n % 3);
            corner[k] = corner[(k + 1) % 3] + 1e-3 * random_place(random);
        }
        const Point p = random_place(random);
        const double expected = detail::distance_to_facet(p, corner);
        const detail::TriangleFrame frame(corner);
        CHECK(std::fabs(std::sqrt(double(frame.distance2(vec_cast<float>(p), 100))) - expected) <= 1e-6);
        const double limit = random.uniform(0, 2);
        const double limited = double(frame.distance2(vec_cast<float>(p), float(limit * limit)));
        if (expected < limit - 1e-6) CHECK(std::fabs(std::sqrt(limited) - expected) <= 1e-6);
        if (expected > limit + 1e-6) CHECK(limited > limit * limit);
    }
}

TEST_CASE("mixed cells are found next to uniform rows of eight", "[enclose][property]") {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const detail::DistanceLattice<3> lattice(
            {0, 0, 0}, 1, {1 + random.below(30), 1 + random.below(6), 1 + random.below(6)}, 1);
        std::vector<std::uint8_t> outside(lattice.size(), seed % 2 == 0 ? 0 : 1);
        for (std::size_t n = random.below(4); n > 0; --n) outside[random.below(outside.size())] ^= 1;
        std::vector<std::size_t> visited;
        detail::for_each_mixed(lattice, outside, [&](std::size_t node, const auto& numbers) {
            CHECK(numbers == lattice.numbers(node));
            visited.push_back(node);
        });
        CHECK(std::is_sorted(visited.begin(), visited.end()));
        for (std::size_t node = 0; node < lattice.size(); ++node) {
            const auto n = lattice.numbers(node);
            bool is_mixed = false;
            for (std::size_t bits = 1; bits < 8; ++bits) {
                std::size_t other = node;
                bool exists = true;
                for (std::size_t k = 0; k < 3; ++k) {
                    if ((bits >> k & 1) == 0) continue;
                    exists = exists && n[k] + 1 < lattice.count()[k];
                    other += lattice.stride()[k];
                }
                is_mixed = is_mixed || (exists && outside[other] != outside[node]);
            }
            if (is_mixed) CHECK(std::binary_search(visited.begin(), visited.end(), node));
        }
    }
}

TEST_CASE("a flood equals a walk along lattice lines", "[enclose][property]") {
    const auto check_one = [](Random& random, const auto& lattice) {
        std::vector<std::uint8_t> open(lattice.size());
        for (auto& o : open) o = random.below(5) < 3 ? 1 : 0;
        // Reached: open boundary nodes, and open neighbours of reached nodes, until nothing changes.
        std::vector<std::uint8_t> expected(lattice.size(), 0);
        for (bool changed = true; changed;) {
            changed = false;
            for (std::size_t node = 0; node < lattice.size(); ++node) {
                if (open[node] == 0 || expected[node] != 0) continue;
                const auto n = lattice.numbers(node);
                bool reached = false;
                for (std::size_t k = 0; k < n.size(); ++k)
                    reached = reached || n[k] == 0 || n[k] + 1 == lattice.count()[k];
                lattice.for_each_neighbour(
                    node, [&](std::size_t other) { reached = reached || expected[other] != 0; });
                expected[node] = reached ? 1 : 0;
                changed = changed || reached;
            }
        }
        CHECK(lattice.flood([&](std::size_t node) { return open[node] != 0; }) == expected);
    };
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        check_one(random,
                  detail::DistanceLattice<2>({0, 0}, 1, {1 + random.below(20), 1 + random.below(20)}, 1));
        check_one(random,
                  detail::DistanceLattice<3>(
                      {0, 0, 0}, 1, {1 + random.below(9), 1 + random.below(9), 1 + random.below(9)}, 1));
    }
}

TEST_CASE("3D lattice distances are exact next to faces and never too small", "[enclose][property]") {
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        std::vector<detail::Corners<3>> faces;
        for (int f = 0; f < 12; ++f) {
            const Point middle = random_place(random);
            const double size = f % 3 == 0 ? 1 : 0.05; // larger and smaller than a cell
            detail::Corners<3> corner{middle, middle + size * random_place(random),
                                      middle + size * random_place(random)};
            if (f % 4 == 1) corner[2] = 0.3 * corner[0] + 0.7 * corner[1]; // a segment
            if (f == 11) corner = {middle, middle, middle};
            faces.push_back(corner);
        }
        detail::DistanceLattice<3> lattice({-2.5, -2.5, -2.5}, 0.25, {21, 21, 21}, 3);
        detail::SpaceDistance(lattice, faces).fill(0.5, 3);
        for (std::size_t node = 0; node < lattice.size(); ++node) {
            double least = std::numeric_limits<double>::infinity();
            for (const auto& corner : faces)
                least = (std::min)(least, detail::distance_to_facet(lattice.position(node), corner));
            const double found = double(lattice[node]) + 0.5;
            // Odd nodes farther than two margins take the mean of their neighbours.
            const double slack = least < 1 ? 1e-6 : 2 * lattice.spacing();
            if (!(found >= (std::min)(least, 3.5) - slack)) FAIL_CHECK("too small at node " << node);
            if (least < 0.25 && !(found <= least + 1e-6)) FAIL_CHECK("not exact at node " << node);
        }
    }
}

} // namespace shell_tests
