// Laws of the parts of 3D cages.

#include "../catch.hpp"

#include <cageform/enclose/find_parts.hpp>
#include <cageform/enclose/parts_of_faces.hpp>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>

namespace find_parts_tests {

using namespace cageform;

using LatticePoint = std::array<int, 3>;

struct Cage {
    std::vector<Vec<double, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces;

    CageParts parts() const {
        const auto found = find_parts(TriangleMesh<double>(vertices, faces));
        REQUIRE(found.report.status == Status::ok);
        return found.value;
    }
};

/// Boxes on a lattice, each from its lowest cube to its highest.
using Boxes = std::vector<std::array<LatticePoint, 2>>;

/// The boundary of the union of boxes. Diagonals of squares join corners with an even sum of coordinates, so that
/// the mesh of the boxes reflected in x, y or z = 0 is the reflected mesh.
Cage border_of(const Boxes& boxes) {
    std::set<LatticePoint> cubes;
    for (const auto& [low, high] : boxes) {
        for (int x = low[0]; x <= high[0]; ++x) {
            for (int y = low[1]; y <= high[1]; ++y) {
                for (int z = low[2]; z <= high[2]; ++z) cubes.insert({x, y, z});
            }
        }
    }
    Cage cage;
    std::map<LatticePoint, std::uint32_t> numbers;
    const auto number = [&](const LatticePoint& at) {
        const auto [found, is_new] = numbers.insert({at, std::uint32_t(cage.vertices.size())});
        if (is_new) cage.vertices.push_back({double(at[0]), double(at[1]), double(at[2])});
        return found->second;
    };
    for (const LatticePoint& cube : cubes) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (int side = 0; side < 2; ++side) {
                LatticePoint beside = cube;
                beside[axis] += side == 0 ? -1 : 1;
                if (cubes.contains(beside)) continue;
                std::array<LatticePoint, 4> square;
                for (std::size_t k = 0; k < 4; ++k) {
                    square[k] = cube;
                    square[k][axis] += side;
                    square[k][(axis + 1) % 3] += k == 1 || k == 2 ? 1 : 0;
                    square[k][(axis + 2) % 3] += k == 2 || k == 3 ? 1 : 0;
                }
                if (side == 0) std::reverse(square.begin(), square.end());
                if ((square[0][0] + square[0][1] + square[0][2]) % 2 != 0)
                    std::rotate(square.begin(), square.begin() + 1, square.end());
                std::array<std::uint32_t, 4> v;
                std::transform(square.begin(), square.end(), v.begin(), number);
                cage.faces.insert(cage.faces.end(), {{v[0], v[1], v[2]}, {v[0], v[2], v[3]}});
            }
        }
    }
    return cage;
}

/// A head, two arms, two legs and a trunk; symmetric about x = 0.
const Boxes character{{{{-3, 0, -2}, {2, 9, 1}}},   {{{-1, 10, -1}, {0, 10, 0}}},
                      {{{-2, 11, -2}, {1, 14, 1}}}, {{{-11, 8, -1}, {-4, 9, 0}}},
                      {{{3, 8, -1}, {10, 9, 0}}},   {{{-3, -9, -1}, {-2, -1, 0}}},
                      {{{1, -9, -1}, {2, -1, 0}}}};
/// Without the right arm, and with one leg shorter.
const Boxes lopsided{character[0], character[1], character[2],
                     character[3], character[5], {{{1, -8, -1}, {2, -1, 0}}}};

/// A cube with the first of six arms.
Boxes star(std::size_t arms) {
    Boxes boxes{{{{-3, -3, -3}, {2, 2, 2}}}};
    for (std::size_t n = 0; n < arms; ++n) {
        std::array<LatticePoint, 2> arm{{{-1, -1, -1}, {0, 0, 0}}};
        arm[0][n % 3] = n < 3 ? 3 : -13;
        arm[1][n % 3] = n < 3 ? 12 : -4;
        boxes.push_back(arm);
    }
    return boxes;
}

/// The partition of the vertices, independent of part numbers.
std::set<std::set<std::uint32_t>> classes_of(const CageParts& parts,
                                             const std::vector<std::uint32_t>& names) {
    std::map<int, std::set<std::uint32_t>> classes;
    for (std::size_t v = 0; v < names.size(); ++v) classes[parts.of_vertex[v]].insert(names[v]);
    std::set<std::set<std::uint32_t>> all;
    for (const auto& [number, vertices] : classes) all.insert(vertices);
    return all;
}

/// True if the faces of a part are connected by edges.
bool is_connected(const Cage& cage, const CageParts& parts, int number) {
    std::map<std::array<std::uint32_t, 2>, std::vector<std::size_t>> at;
    std::vector<std::size_t> stack;
    std::size_t left = 0;
    std::vector<bool> seen(cage.faces.size());
    for (std::size_t f = 0; f < cage.faces.size(); ++f) {
        if (parts.of_face[f] != number) continue;
        if (left++ == 0) stack.push_back(f);
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [a, b] = std::minmax(cage.faces[f][k], cage.faces[f][(k + 1) % 3]);
            at[{a, b}].push_back(f);
        }
    }
    if (!stack.empty()) seen[stack.back()] = true;
    while (!stack.empty()) {
        const std::size_t f = stack.back();
        stack.pop_back();
        --left;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [a, b] = std::minmax(cage.faces[f][k], cage.faces[f][(k + 1) % 3]);
            for (const std::size_t g : at[{a, b}]) {
                if (!seen[g]) stack.push_back(g);
                seen[g] = true;
            }
        }
    }
    return left == 0;
}

TEST_CASE("vertices belong to one part each, parts are connected and form a tree") {
    for (const Boxes& boxes : {character, lopsided, star(4), star(1)}) {
        const Cage cage = border_of(boxes);
        const CageParts parts = cage.parts();
        REQUIRE(parts.of_face.size() == cage.faces.size());
        REQUIRE(parts.of_vertex.size() == cage.vertices.size());
        std::size_t count = 0;
        for (const CagePart& part : parts.parts) {
            CHECK(!part.vertices.empty());
            CHECK(is_connected(cage, parts, part.number));
            for (const auto v : part.vertices) CHECK(parts.of_vertex[v] == part.number);
            count += part.vertices.size();
            CHECK((part.number == 1) == (part.parent == 0));
            CHECK((part.number == 1) == part.joint.empty());
            if (part.number != 1) CHECK(parts.find(part.parent) != nullptr);
            const auto moved = parts.moved_with(part.number);
            CHECK(std::includes(moved.begin(), moved.end(), part.vertices.begin(), part.vertices.end()));
            for (const auto v : part.joint) {
                CHECK(!std::binary_search(moved.begin(), moved.end(), v));
                CHECK(std::any_of(cage.faces.begin(), cage.faces.end(), [&](const auto& face) {
                    return std::find(face.begin(), face.end(), v) != face.end() &&
                           parts.of_face[std::size_t(&face - cage.faces.data())] == part.number;
                }));
            }
        }
        CHECK(count == cage.vertices.size());
        CHECK(parts.find(99) == nullptr);
    }
}

TEST_CASE("a ball, a cube and a plate are one part") {
    Boxes ball;
    for (int x = -5; x < 5; ++x) {
        for (int y = -5; y < 5; ++y) {
            const double room = 26 - (x + 0.5) * (x + 0.5) - (y + 0.5) * (y + 0.5);
            if (room <= 0.25) continue;
            const int high = int(std::sqrt(room) - 0.5);
            ball.push_back({{{x, y, -1 - high}, {x, y, high}}});
        }
    }
    CHECK(border_of(ball).parts().parts.size() == 1);
    CHECK(border_of({{{{0, 0, 0}, {5, 5, 5}}}}).parts().parts.size() == 1);
    CHECK(border_of({{{{0, 0, 0}, {9, 9, 1}}}}).parts().parts.size() == 1);
    const auto parts = border_of({{{{0, 0, 0}, {0, 0, 0}}}}).parts();
    CHECK(parts.parts.size() == 1);
    CHECK(parts.parts[0].vertices.size() == 8);
}

TEST_CASE("a star of k arms has k + 1 parts") {
    for (std::size_t arms = 1; arms <= 6; ++arms) {
        CAPTURE(arms);
        const CageParts parts = border_of(star(arms)).parts();
        CHECK(parts.parts.size() == arms + 1);
        for (const CagePart& part : parts.parts) CHECK(part.parent == (part.number == 1 ? 0 : 1));
    }
}

TEST_CASE("a character has a trunk, a head, and two pairs of limbs numbered n and -n") {
    const Cage cage = border_of(character);
    const CageParts parts = cage.parts();
    std::vector<int> numbers;
    for (const CagePart& part : parts.parts) {
        numbers.push_back(part.number);
        CHECK(part.parent == (part.number == 1 ? 0 : 1));
    }
    REQUIRE(numbers.size() == 6);
    std::map<LatticePoint, int> of; // by position
    for (std::size_t v = 0; v < cage.vertices.size(); ++v) {
        const auto& p = cage.vertices[v];
        of[{int(p[0]), int(p[1]), int(p[2])}] = parts.of_vertex[v];
    }
    std::size_t pairs = 0;
    for (const auto& [at, number] : of) {
        const int image = of.at({-at[0], at[1], at[2]});
        if (parts.find(-number) == nullptr) {
            CHECK(image == number);
            continue;
        }
        ++pairs;
        CHECK(image == -number);
        CHECK((at[0] > 0) == (number > 0));
    }
    CHECK(pairs > 0);
    const std::set<int> tips{of.at({0, 15, 0}), of.at({11, 9, 0}), of.at({-11, 9, 0}), of.at({2, -9, 0}),
                             of.at({-2, -9, 0})};
    CHECK(tips.size() == 5);
    CHECK(!tips.contains(1));
    CHECK(of.at({0, 5, 2}) == 1);
}

TEST_CASE("the hierarchy of a symmetric cage is symmetric") {
    const unsigned seed = std::random_device{}();
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto any = [&](int most) { return std::uniform_int_distribution(1, most)(random); };
    for (int n = 0; n < 300; ++n) {
        // Squares in a plane: a trunk and a head with 2·wide columns, arms at both sides, adjacent legs.
        const int wide = any(4), head = any(7), trunk = any(7), arm = any(trunk), leg = any(7),
                  reach = any(5);
        CAPTURE(wide, head, trunk, arm, leg, reach);
        std::vector<std::array<std::uint32_t, 4>> faces;
        std::vector<int> labels;
        constexpr int columns = 21, rows = 23,
                      low = 14; // of vertices; the middle column is on the mirror line
        const auto vertex = [&](int x, int y) {
            return std::uint32_t((y + low) * columns + x + columns / 2);
        };
        for (int y = -low; y < rows - low - 1; ++y) {
            for (int x = -columns / 2; x < columns / 2; ++x) {
                const int side = x >= 0 ? 1 : -1, out = x >= 0 ? x : -x - 1;
                const int label = out < wide ? (y >= head || y < -trunk - leg ? 0
                                                : y >= 0                      ? 3
                                                : y >= -trunk                 ? 1
                                                                              : 4 * side)
                                  : out < wide + reach && y < head && y >= -arm ? 2 * side
                                                                                : 0;
                if (label == 0) continue;
                faces.push_back({vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)});
                labels.push_back(label);
            }
        }
        const auto parts = cageform::parts_of_faces(faces, columns * rows, labels);
        const auto image_of = [&](int number) { return parts.find(-number) == nullptr ? number : -number; };
        for (const CagePart& part : parts.parts) {
            CAPTURE(part.number);
            CHECK(parts.find(image_of(part.number))->parent == image_of(part.parent));
        }
        for (int y = -low; y < rows - low; ++y) {
            for (int x = 1; x <= columns / 2; ++x) {
                CAPTURE(x, y);
                CHECK(parts.of_vertex[vertex(-x, y)] == image_of(parts.of_vertex[vertex(x, y)]));
            }
        }
    }
}

TEST_CASE("the hierarchy is nested: fingers at the hand, the arm at the trunk") {
    const Boxes boxes{{{{-8, -10, -6}, {3, 9, 5}}}, {{{4, -1, -1}, {14, 0, 0}}},
                      {{{15, -5, -1}, {21, 4, 0}}}, {{{22, -5, -1}, {29, -4, 0}}},
                      {{{22, -1, -1}, {29, 0, 0}}}, {{{22, 3, -1}, {29, 4, 0}}}};
    const Cage cage = border_of(boxes);
    const CageParts parts = cage.parts();
    const auto part_at = [&](const Vec<double, 3>& at) {
        const auto found = std::find(cage.vertices.begin(), cage.vertices.end(), at);
        return parts.of_vertex[std::size_t(found - cage.vertices.begin())];
    };
    const int hand = part_at({22, 2, 1}), finger = part_at({30, 1, 1});
    CHECK(hand != finger);
    CHECK(hand != 1);
    CHECK(parts.find(finger)->parent == hand);
    const auto moved = parts.moved_with(hand);
    for (std::uint32_t v = 0; v < cage.vertices.size(); ++v)
        CHECK((cage.vertices[v][0] < 23 || std::binary_search(moved.begin(), moved.end(), v)));
}

TEST_CASE("parts do not depend on scale, position, vertex order or rotations by 90 degrees") {
    const unsigned seed = std::random_device{}();
    CAPTURE(seed);
    std::mt19937 random(seed);
    for (const Boxes& boxes : {lopsided, character, star(3)}) {
        const Cage cage = border_of(boxes);
        std::vector<std::uint32_t> original(cage.vertices.size());
        std::iota(original.begin(), original.end(), 0u);
        const CageParts parts = cage.parts();

        Cage twice = cage; // powers of two are exact
        for (auto& p : twice.vertices) p = 2.0 * p;
        CHECK(twice.parts().of_face == parts.of_face);
        CHECK(cage.parts().of_vertex == parts.of_vertex);

        Cage turned = cage;
        for (auto& p : turned.vertices) p = {p[1], -p[0], p[2]};
        CHECK(classes_of(turned.parts(), original) == classes_of(parts, original));
        for (auto& p : turned.vertices) p = {p[2], p[0], p[1]};
        CHECK(classes_of(turned.parts(), original) == classes_of(parts, original));

        Cage shuffled = cage;
        std::vector<std::uint32_t> names = original; // of the permuted vertices
        std::shuffle(names.begin(), names.end(), random);
        std::vector<std::uint32_t> place(names.size());
        for (std::uint32_t v = 0; v < names.size(); ++v) {
            place[names[v]] = v;
            shuffled.vertices[v] = cage.vertices[names[v]];
        }
        for (auto& face : shuffled.faces) {
            for (auto& v : face) v = place[v];
        }
        std::shuffle(shuffled.faces.begin(), shuffled.faces.end(), random);
        CHECK(classes_of(shuffled.parts(), names) == classes_of(parts, original));
    }
}

TEST_CASE("each shell has its own parts, and invalid cages have none") {
    Boxes two = lopsided;
    two.push_back({{{20, 0, 0}, {22, 2, 2}}});
    const CageParts parts = border_of(two).parts();
    CHECK(parts.parts.size() == border_of(lopsided).parts().parts.size() + 1);
    CHECK(std::count_if(parts.parts.begin(), parts.parts.end(),
                        [](const CagePart& part) { return part.parent == 0; }) == 2);

    CHECK(!find_parts(TriangleMesh<double>()));
    Cage spoilt = border_of(star(1));
    spoilt.vertices[3][1] = std::numeric_limits<double>::quiet_NaN();
    const auto found = find_parts(TriangleMesh<double>(spoilt.vertices, spoilt.faces));
    CHECK(!found);
    CHECK(found.value.parts.empty());
}

} // namespace find_parts_tests
