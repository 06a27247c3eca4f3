// Laws of the rings around limbs of 3D cages.

#include "../catch.hpp"

#include <cageform/enclose/make_cage_3d.hpp>

#include <algorithm>
#include <map>
#include <random>
#include <set>

namespace ring_tests {

using namespace cageform;

using Point = Vec<double, 3>;

struct Figure {
    std::vector<Point> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces;

    /// Adds a box around a segment with the half width `radius`.
    void add_bar(const Point& from, const Point& to, double radius) {
        const Point along = (1 / detail::length(to - from)) * (to - from);
        Point u = cross(along, std::fabs(along[0]) < 0.7 ? Point{1, 0, 0} : Point{0, 1, 0});
        u = (radius / detail::length(u)) * u;
        const Point w = cross(along, u);
        const auto first = std::uint32_t(vertices.size());
        for (const Point& end : {from, to}) {
            for (const Point& side : {u + w, u - w, Point{} - u - w, w - u}) vertices.push_back(end + side);
        }
        for (std::uint32_t k = 0; k < 4; ++k) {
            const std::uint32_t a = first + k, b = first + (k + 1) % 4;
            faces.insert(faces.end(), {{a, b, b + 4}, {a, b + 4, a + 4}});
        }
        for (const std::uint32_t k : {0U, 4U})
            faces.insert(faces.end(), {{first + k, first + k + 1, first + k + 2},
                                       {first + k, first + k + 2, first + k + 3}});
    }
};

using Made = Result<TriangleMesh<double>, MakeCageReport>;
using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// The edges between the faces of a part or its descendants and other faces.
std::set<Edge> border_of(const Made& made, int number) {
    const CageParts& parts = made.report.parts;
    std::map<Edge, int> sides;
    for (std::size_t f = 0; f < made.value.faces().size(); ++f) {
        bool hangs = false;
        for (auto part = parts.find(parts.of_face[f]); part != nullptr; part = parts.find(part->parent))
            hangs = hangs || part->number == number;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto v = made.value.faces()[f][k], w = made.value.faces()[f][(k + 1) % 3];
            sides[std::minmax(v, w)] += hangs ? 1 : 0;
        }
    }
    std::set<Edge> border;
    for (const auto& [edge, count] : sides) {
        if (count == 1) border.insert(edge);
    }
    return border;
}

/// Checks that each part except the first of a shell ends at a planar closed loop. Returns the number of loops.
std::size_t check_rings(const Made& made) {
    REQUIRE(made.report.status == Status::ok);
    const CageParts& parts = made.report.parts;
    REQUIRE(parts.of_face.size() == made.value.faces().size());
    REQUIRE(parts.of_vertex.size() == made.value.size());
    std::size_t count = 0;
    for (const CagePart& part : parts.parts) {
        REQUIRE(!part.vertices.empty());
        if (part.parent == 0) continue;
        ++count;
        const auto border = border_of(made, part.number);
        REQUIRE(border.size() >= 4);
        REQUIRE(border.size() == part.joint.size());
        std::map<std::uint32_t, std::vector<std::uint32_t>> next;
        for (const auto& [v, w] : border) {
            next[v].push_back(w);
            next[w].push_back(v);
        }
        std::vector<std::uint32_t> loop{next.begin()->first};
        for (std::uint32_t before = loop[0]; loop.size() <= border.size();) {
            const auto& both = next.at(loop.back());
            REQUIRE(both.size() == 2);
            const auto on = both[0] == before ? both[1] : both[0];
            before = loop.back();
            if (on == loop[0]) break;
            loop.push_back(on);
        }
        REQUIRE(loop.size() == border.size()); // a single loop
        std::sort(loop.begin(), loop.end());
        REQUIRE(loop == part.joint);
        Point middle{}, normal{};
        for (const auto v : part.joint)
            middle = middle + (1.0 / double(loop.size())) * made.value.vertices()[v];
        double size = 0;
        for (const auto v : part.joint) {
            for (const auto w : part.joint) {
                const Point n = cross(made.value.vertices()[v] - middle, made.value.vertices()[w] - middle);
                if (dot(n, n) > dot(normal, normal)) normal = n;
            }
            size = std::max(size, detail::length(made.value.vertices()[v] - middle));
        }
        for (const auto v : part.joint) {
            const double off = dot(normal, made.value.vertices()[v] - middle) / detail::length(normal);
            REQUIRE(std::fabs(off) < 1e-9 * size); // rounding of the coordinates
        }
    }
    return count;
}

/// A trunk with bars in random, well separated directions.
Figure random_star(std::mt19937& random, std::size_t arms) {
    std::uniform_real_distribution<double> within(-1, 1);
    Figure figure;
    figure.add_bar({0, 0, -0.5}, {0, 0, 0.5}, 0.4);
    std::vector<Point> directions;
    while (directions.size() < arms) {
        Point d{within(random), within(random), within(random)};
        const double size = detail::length(d);
        if (size > 1 || size < 0.1) continue;
        d = (1 / size) * d;
        if (std::any_of(directions.begin(), directions.end(), [&](const Point& e) { return dot(d, e) > 0; }))
            continue;
        directions.push_back(d);
        figure.add_bar({}, (2.5 + within(random) / 2) * d, 0.15);
    }
    return figure;
}

TEST_CASE("every limb of a star has a planar closed loop, and the cage is valid") {
    const auto seed = std::random_device{}();
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::size_t arms = 0, rings = 0;
    for (int round = 0; round < 3; ++round) {
        const std::size_t count = 2 + random() % 3;
        const Figure figure = random_star(random, count);
        MakeCageOptions options{.vertices = 80 + random() % 60};
        const auto plain = make_cage(figure.vertices, figure.faces, options);
        REQUIRE(plain.report.parts.parts.empty());
        options.rings = true;
        const auto made = make_cage(figure.vertices, figure.faces, options);
        CAPTURE(round, count, options.vertices);
        arms += count;
        rings += check_rings(made);
        REQUIRE(made.report.vertices == options.vertices);
        REQUIRE(made.report.clearance >= 0.9 * made.report.margin);
        REQUIRE(made.report.area < 1.3 * plain.report.area);
        const auto again = make_cage(figure.vertices, figure.faces, options);
        REQUIRE(std::equal(made.value.vertices().begin(), made.value.vertices().end(),
                           again.value.vertices().begin(), again.value.vertices().end()));
        const auto paired = pair_faces(made, figure.vertices, figure.faces, options);
        REQUIRE(paired.report.status == Status::ok);
        std::set<Edge> edges; // of quads and triangles
        for (std::size_t f = 0; f < paired.value.face_count(); ++f) {
            const auto face = paired.value.face(f);
            for (std::size_t k = 0; k < face.size(); ++k)
                edges.insert(std::minmax(face[k], face[(k + 1) % face.size()]));
        }
        for (const CagePart& part : made.report.parts.parts) {
            if (part.parent == 0) continue;
            for (const Edge& edge : border_of(made, part.number)) REQUIRE(edges.contains(edge));
        }
    }
    REQUIRE(4 * rings >= 3 * arms); // find_parts may merge two close arms
}

TEST_CASE("rings of a mirrored cage are symmetric, also those across the mirror plane") {
    const auto seed = std::random_device{}();
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> within(-0.3, 0.3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        Figure figure; // a trunk with a head, a tail, and two mirrored arms
        const auto turned = [&](Point p) {
            std::rotate(p.v, p.v + (3 - axis) % 3, p.v + 3);
            return p;
        };
        figure.add_bar(turned({0, -1, 0}), turned({0, 1, 0}), 0.45);
        figure.add_bar(turned({0, 0.9, 0}), turned({0, 2.8, 0.3}), 0.15);
        const double up = within(random), aside = within(random);
        for (const double side : {-1.0, 1.0})
            figure.add_bar(turned({0.2 * side, 0.5, 0}), turned({2.5 * side, 0.5 + up, aside}), 0.15);
        MakeCageOptions options{.vertices = 90, .mirror = MirrorPlane{axis, 0.0}};
        options.rings = true;
        const auto made = make_cage(figure.vertices, figure.faces, options);
        CAPTURE(axis);
        REQUIRE(check_rings(made) >= 3);
        const CageParts& parts = made.report.parts;
        std::map<std::array<double, 3>, std::uint32_t> at;
        const auto key = [](const Point& p) { return std::array{p[0] + 0.0, p[1] + 0.0, p[2] + 0.0}; };
        for (std::uint32_t v = 0; v < made.value.size(); ++v) at[key(made.value.vertices()[v])] = v;
        std::size_t pairs = 0;
        for (std::uint32_t v = 0; v < made.value.size(); ++v) {
            Point p = made.value.vertices()[v];
            p[axis] = -p[axis];
            const auto image = at.find(key(p));
            REQUIRE(image != at.end());
            const int number = parts.of_vertex[v], other = parts.of_vertex[image->second];
            REQUIRE(other == (parts.find(-number) != nullptr ? -number : number));
            pairs += number != other ? 1 : 0;
            if (number != other) REQUIRE((number > 0) == (p[axis] < 0));
        }
        REQUIRE(pairs > 0);
    }
}

TEST_CASE("without limbs there are no rings, and few vertices allow few rings") {
    Figure ball;
    ball.add_bar({0, 0, -1}, {0, 0, 1}, 1);
    MakeCageOptions options{.vertices = 60};
    options.rings = true;
    for (const CageShape shape : {CageShape::figure, CageShape::hull, CageShape::box}) {
        options.shape = shape;
        options.vertices = shape == CageShape::box ? 0 : 60;
        const auto made = make_cage(ball.vertices, ball.faces, options);
        REQUIRE(check_rings(made) == 0);
        REQUIRE(made.report.parts.parts.size() == 1);
        auto plain = options;
        plain.rings = false;
        const auto same = make_cage(ball.vertices, ball.faces, plain);
        REQUIRE(std::equal(made.value.vertices().begin(), made.value.vertices().end(),
                           same.value.vertices().begin(), same.value.vertices().end()));
    }
    std::mt19937 random(7);
    const Figure star = random_star(random, 4);
    options = {.vertices = 20};
    options.rings = true;
    REQUIRE(check_rings(make_cage(star.vertices, star.faces, options)) <= 2);
}

TEST_CASE("rings work with looseness and with several shells") {
    std::mt19937 random(11);
    Figure figure = random_star(random, 3);
    MakeCageOptions options;
    options.rings = true;
    options.looseness = 0.4;
    const auto fewest = make_cage(figure.vertices, figure.faces, options);
    REQUIRE(check_rings(fewest) > 0);
    const auto& attempts = fewest.report.attempts;
    REQUIRE(std::is_sorted(attempts.begin(), attempts.end(),
                           [](const auto& a, const auto& b) { return a.vertices < b.vertices; }));
    const auto of = std::find_if(attempts.begin(), attempts.end(), [&](const auto& attempt) {
        return attempt.vertices == fewest.report.vertices;
    });
    REQUIRE(of != attempts.end());
    const double excess = fewest.report.area / fewest.report.tightest_area - 1;
    REQUIRE(std::fabs(of->excess - excess) < 1e-9); // equal up to the order of summation
    REQUIRE(excess <= options.looseness);
    const auto own = figure.vertices.size();
    for (std::size_t v = 0; v < own; ++v) figure.vertices.push_back(figure.vertices[v] + Point{9, 0, 0});
    for (std::size_t f = 0, count = figure.faces.size(); f < count; ++f) {
        auto face = figure.faces[f];
        for (auto& v : face) v += std::uint32_t(own);
        figure.faces.push_back(face);
    }
    options = {.vertices = 160, .one_cage = false};
    options.rings = true;
    const auto two = make_cage(figure.vertices, figure.faces, options);
    REQUIRE(check_rings(two) > 0);
    REQUIRE(two.report.components == 2);
}

} // namespace ring_tests
