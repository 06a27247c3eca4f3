// Makes cages in space about random soups of triangles, and proves each in exact integers: it is closed, no
// two of its faces meet but at what they share, no face meets the figure, and every corner of the figure is
// inside. A refusal is named and counted. A program of its own:
//
//     g++ -std=c++20 -O2 -Iinclude -isystem /usr/include/eigen3 -Itests tests/fuzz/hostile_figures.cpp
//         -lgmpxx -lgmp -o hostile_figures
//     ./hostile_figures FIRST_SEED COUNT
//
// Numbers are scaled by one power of two, so that all of them are integers: nothing is rounded.
#include "support/cages.hpp"

#include <cageform/enclose/make_cage_3d.hpp>

#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>

namespace {

using namespace cageform;
using cageform_tests::Random;
using Point = Vec<double, 3>;
using Triangle = std::array<std::uint32_t, 3>;
using Exact = std::array<mpz_class, 3>;

struct Figure {
    std::vector<Point> vertices;
    std::vector<Triangle> faces;
};

/// Triangles anywhere, at any scale; some in strips, flat, without area, or twice there.
Figure random_soup(Random& random) {
    Figure figure;
    const double size = std::pow(10.0, random.uniform(-4, 4));
    const double flat = random.below(6) == 0 ? double(random.below(2)) * 1e-6 : 1;
    const double shift = random.below(4) == 0 ? 100 * size : size;
    const Point middle{shift * random.uniform(-1, 1), shift * random.uniform(-1, 1),
                       shift * random.uniform(-1, 1)};
    const std::size_t count = 1 + random.below(random.below(4) == 0 ? 60 : 12);
    const double edge = random.below(3) == 0 ? random.uniform(0.05, 0.3) : 1; // else as large as the figure
    for (std::size_t n = 0; n < count; ++n) {
        const auto first = std::uint32_t(figure.vertices.size());
        const Point place{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
        for (int k = 0; k < 3; ++k) {
            const Point p{place[0] + edge * random.uniform(-1, 1), place[1] + edge * random.uniform(-1, 1),
                          flat * (place[2] + edge * random.uniform(-1, 1))};
            figure.vertices.push_back(middle + size * p);
        }
        const std::uint32_t chained = n > 0 && random.below(3) == 0 ? first - 1 : first;
        figure.faces.push_back({chained, first + 1, first + 2});
        if (random.below(40) == 0) figure.faces.back()[2] = first + 1; // without area
        if (random.below(40) == 0) figure.faces.push_back(figure.faces.back());
    }
    return figure;
}

/// The power of two that makes integers of all numbers.
int scale_of(const std::vector<Point>& a, const std::vector<Point>& b) {
    int least = 0;
    for (const auto* points : {&a, &b}) {
        for (const Point& p : *points) {
            for (std::size_t k = 0; k < 3; ++k) {
                int exponent = 0;
                if (std::frexp(p[k], &exponent) != 0) least = std::min(least, exponent - 53);
            }
        }
    }
    return -least;
}
std::vector<Exact> exact_points(const std::vector<Point>& points, int scale) {
    std::vector<Exact> result(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            int exponent = 0;
            const double mantissa = std::ldexp(std::frexp(points[i][k], &exponent), 53); // an integer
            mpz_mul_2exp(result[i][k].get_mpz_t(), mpz_class(mantissa).get_mpz_t(),
                         mp_bitcnt_t(mantissa == 0 ? 0 : exponent - 53 + scale));
        }
    }
    return result;
}

Exact operator-(const Exact& a, const Exact& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
/// The sign of the volume of the tetrahedron a, b, c, d.
int side(const Exact& a, const Exact& b, const Exact& c, const Exact& d) {
    const Exact u = b - a, v = c - a, w = d - a;
    const mpz_class volume = u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) +
                             u[2] * (v[0] * w[1] - v[1] * w[0]);
    return sgn(volume);
}
/// The sign of the area of a, b, c without their coordinate `axis`.
int side(const Exact& a, const Exact& b, const Exact& c, std::size_t axis) {
    const std::size_t x = axis == 0 ? 1 : 0, y = axis == 2 ? 1 : 2;
    const mpz_class area = (b[x] - a[x]) * (c[y] - a[y]) - (b[y] - a[y]) * (c[x] - a[x]);
    return sgn(area);
}

struct Facet {
    std::array<const Exact*, 3> corner;
    Point lower, upper; ///< of its box, in doubles: exact, since a box only compares
    const Exact& operator[](std::size_t k) const { return *corner[k % 3]; }
    bool has_area() const {
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (side(*corner[0], *corner[1], *corner[2], axis) != 0) return true;
        return false;
    }
};
std::vector<Facet> facets_of(const std::vector<Triangle>& faces, const std::vector<Point>& places,
                             const std::vector<Exact>& exact) {
    std::vector<Facet> result;
    for (const Triangle& face : faces) {
        Facet facet{{&exact[face[0]], &exact[face[1]], &exact[face[2]]}, places[face[0]], places[face[0]]};
        for (const std::uint32_t i : face) {
            for (std::size_t k = 0; k < 3; ++k) {
                facet.lower[k] = std::min(facet.lower[k], places[i][k]);
                facet.upper[k] = std::max(facet.upper[k], places[i][k]);
            }
        }
        result.push_back(facet);
    }
    return result;
}
bool boxes_meet(const Facet& a, const Facet& b) {
    for (std::size_t k = 0; k < 3; ++k)
        if (a.upper[k] < b.lower[k] || b.upper[k] < a.lower[k]) return false;
    return true;
}

/// Whether the segment p–q meets a triangle that has an area, touching included.
bool meets(const Exact& p, const Exact& q, const Facet& t) {
    const int at_p = side(t[0], t[1], t[2], p), at_q = side(t[0], t[1], t[2], q);
    if (at_p * at_q > 0) return false;
    if (at_p != 0 || at_q != 0) {
        const int a = side(p, q, t[0], t[1]), b = side(p, q, t[1], t[2]), c = side(p, q, t[2], t[0]);
        return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
    }
    // In one plane: it meets an edge, or lies inside.
    std::size_t axis = 0;
    while (side(t[0], t[1], t[2], axis) == 0) ++axis;
    int inside = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Exact &a = t[k], &b = t[k + 1];
        const int a_side = side(p, q, a, axis), b_side = side(p, q, b, axis);
        const int p_side = side(a, b, p, axis), q_side = side(a, b, q, axis);
        if (a_side == 0 && b_side == 0) { // on one line: their ranges along it meet
            for (std::size_t x = 0; x < 3; ++x) {
                const auto [p_least, p_most] = std::minmax(p[x], q[x]);
                const auto [a_least, a_most] = std::minmax(a[x], b[x]);
                if (p_most < a_least || a_most < p_least) break;
                if (x == 2) return true;
            }
        } else if (a_side * b_side <= 0 && p_side * q_side <= 0) {
            return true;
        }
        inside += p_side * side(t[0], t[1], t[2], axis) > 0;
    }
    return inside == 3;
}
/// Whether an edge of one meets the other. A triangle without area is its edges.
bool meet(const Facet& a, const Facet& b) {
    if (!boxes_meet(a, b)) return false;
    for (std::size_t k = 0; k < 3; ++k) {
        if (b.has_area() && meets(a[k], a[k + 1], b)) return true;
        if (a.has_area() && meets(b[k], b[k + 1], a)) return true;
    }
    return false;
}

/// The number of times that the faces wind about a point, counted along a ray that meets no edge.
int winding(const std::vector<Facet>& cage, const Exact& p, Random& random, const mpz_class& reach) {
    for (;;) {
        Exact far_off;
        for (std::size_t k = 0; k < 3; ++k)
            far_off[k] = p[k] + reach * (long(random.below(2001)) - 1000) + long(random.below(1000));
        if (far_off[0] == p[0] && far_off[1] == p[1] && far_off[2] == p[2]) continue;
        int count = 0;
        bool clear = true;
        for (const Facet& face : cage) {
            const int at_p = side(face[0], face[1], face[2], p),
                      at_end = side(face[0], face[1], face[2], far_off);
            const int a = side(p, far_off, face[0], face[1]), b = side(p, far_off, face[1], face[2]),
                      c = side(p, far_off, face[2], face[0]);
            if (at_p * at_end > 0 || (std::min({a, b, c}) < 0 && std::max({a, b, c}) > 0)) continue;
            if (at_p * at_end == 0 || a == 0 || b == 0 || c == 0) {
                clear = false;
                break;
            }
            count += at_end > 0 ? 1 : -1;
        }
        if (clear) return count;
    }
}

/// Names a fault of a cage; empty if it is proved.
std::string fault_of(const TriangleMesh<double>& cage, const Figure& figure, Random& random) {
    std::vector<Triangle> faces;
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (const auto& face : cage.faces()) {
        faces.push_back({face[0], face[1], face[2]});
        for (std::size_t k = 0; k < 3; ++k)
            if (!edges.insert({face[k], face[(k + 1) % 3]}).second) return "an edge is used twice";
    }
    for (const auto& [a, b] : edges)
        if (!edges.contains({b, a})) return "the mesh is open";
    const std::vector<Point> places(cage.vertices().begin(), cage.vertices().end());
    const int scale = scale_of(places, figure.vertices);
    const auto own = exact_points(places, scale), others = exact_points(figure.vertices, scale);
    const auto cage_facets = facets_of(faces, places, own),
               drawn = facets_of(figure.faces, figure.vertices, others);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if (!cage_facets[f].has_area()) return "a face has no area";
        for (const Facet& facet : drawn)
            if (meet(cage_facets[f], facet)) return "a face meets the figure";
        for (std::size_t g = f + 1; g < faces.size(); ++g) {
            std::vector<std::size_t> shared; // corners of f
            for (std::size_t k = 0; k < 3; ++k)
                if (std::ranges::find(faces[g], faces[f][k]) != faces[g].end()) shared.push_back(k);
            if (shared.size() == 3) return "a face is there twice";
            if (shared.empty()) {
                if (meet(cage_facets[f], cage_facets[g])) return "two faces meet";
            } else if (shared.size() == 1) {
                std::size_t k = 0;
                while (faces[g][k] != faces[f][shared[0]]) ++k;
                const Facet &a = cage_facets[f], &b = cage_facets[g];
                if (meets(a[shared[0] + 1], a[shared[0] + 2], b) || meets(b[k + 1], b[k + 2], a))
                    return "two faces meet beyond the vertex that they share";
            } else {
                const std::size_t alone = 3 - shared[0] - shared[1];
                const Facet &a = cage_facets[f], &b = cage_facets[g];
                std::size_t k = 0;
                while (std::ranges::find(faces[f], faces[g][k]) != faces[f].end()) ++k;
                if (side(a[0], a[1], a[2], b[k]) != 0) continue;
                std::size_t axis = 0;
                while (side(a[0], a[1], a[2], axis) == 0) ++axis;
                const Exact &from = a[shared[0]], &to = a[shared[1]];
                if (side(from, to, a[alone], axis) == side(from, to, b[k], axis))
                    return "two faces are folded together";
            }
        }
    }
    mpz_class reach = 1;
    for (const auto* points : {&own, &others})
        for (const Exact& p : *points)
            for (const mpz_class& x : p) reach = std::max<mpz_class>(reach, abs(x));
    for (const Triangle& face : figure.faces)
        for (const std::uint32_t i : face)
            if (winding(cage_facets, others[i], random, reach) != 1)
                return "a corner of the figure is outside";
    return {};
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: hostile_figures FIRST_SEED COUNT\n");
        return 2;
    }
    const unsigned long long first = std::strtoull(argv[1], nullptr, 10),
                             end = first + std::strtoull(argv[2], nullptr, 10);
    std::map<std::string, std::size_t> outcomes;
    std::size_t faults = 0;
    for (unsigned long long seed = first; seed < end; ++seed) {
        Random random(seed);
        const Figure figure = random_soup(random);
        MakeCageOptions options;
        options.vertices = 4 + random.below(120);
        options.margin = random.below(8) == 0 ? random.uniform(0.02, 0.05) : random.uniform(0.05, 0.15);
        options.one_cage = random.below(4) != 0;
        options.fill_tunnels = random.below(4) == 0;
        if (random.below(4) == 0) options.mirror = MirrorPlane{random.below(3)};
        const auto made = make_cage(figure.vertices, figure.faces, options);
        std::string outcome = to_string(made.report.status);
        if (made) {
            if (const std::string fault = fault_of(made.value, figure, random); !fault.empty()) {
                std::printf("seed %llu: %s\n", seed, fault.c_str());
                outcome = fault;
                ++faults;
            } else {
                outcome =
                    made.report.clearance >= 0.9 * made.report.margin ? "proved" : "proved, but too near";
            }
        } else {
            std::printf("seed %llu: %s\n", seed, outcome.c_str());
        }
        ++outcomes[outcome];
        std::fflush(stdout);
    }
    for (const auto& [outcome, count] : outcomes) std::printf("%6zu %s\n", count, outcome.c_str());
    return faults == 0 ? 0 : 1;
}
