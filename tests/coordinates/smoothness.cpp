// Smoothness of weights: the column "smoothness" of the table in coordinates/README.md, for every type.
#include "catch.hpp"
#include "support/bindings.hpp"
#include "support/figures.hpp"
#include "support/polyhedra.hpp"

#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/blended.hpp>
#include <cageform/coordinates/curved_green.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/lattice.hpp>
#include <cageform/coordinates/maximum_entropy.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/sibson.hpp>
#include <cageform/coordinates/three_point.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>

#include <functional>

namespace smoothness_tests {

using namespace cageform_tests;
using cageform::Polygon;

namespace {

/// The largest fourth difference along a line is of order h^k in the step h, where k is the order of the
/// first discontinuous derivative, at most four. Slopes of maximum entropy weights change like the root of
/// the distance from the line of an edge, or from the plane of a face.
constexpr double jumps = 0, continuous = 1, like_root = 1.5, once = 2, twice = 3, always = 4;

template <std::size_t D>
using Points = std::vector<Vec<double, D>>;

/// The weights along a line, from t = 0 to 1.
template <std::size_t D>
struct Line {
    std::function<Weights<double>(const Points<D>&)> weigh;
    Vec<double, D> from, to;

    Weights<double> weights(double first, double step, std::size_t count) const {
        Points<D> points;
        for (std::size_t k = 0; k < count; ++k)
            points.push_back(from + (first + double(k) * step) * (to - from));
        return weigh(points);
    }
};
template <class C>
Line<C::dimension> line_of(const C& coordinates, const Vec<double, C::dimension>& from,
                           const Vec<double, C::dimension>& to) {
    return {[coordinates](const Points<C::dimension>& points) { return evaluate_all(coordinates, points); },
            from, to};
}
/// A line with a given midpoint.
template <class C>
Line<C::dimension> through(const C& coordinates, const Vec<double, C::dimension>& middle, double reach,
                           std::uint64_t seed) {
    const auto along = random_points<double, C::dimension>(1, reach, seed)[0];
    return line_of(coordinates, middle - along, middle + along);
}
/// A line between two random points, inside the cage unless `anywhere`.
template <class C>
Line<C::dimension> line(const C& coordinates, std::uint64_t seed, bool anywhere = false) {
    const auto corners = corners_of(coordinates);
    const auto bounds = cageform::bounds_of(std::span<const Vec<double, C::dimension>>(corners));
    Random random(1000 * seed); // independent of the random numbers of other seeds
    for (;;) {
        std::array<Vec<double, C::dimension>, 2> ends{};
        for (auto& end : ends) {
            for (std::size_t k = 0; k < C::dimension; ++k)
                end[k] = random.uniform(bounds.lower[k], bounds.upper[k]);
        }
        const auto found = line_of(coordinates, ends[0], ends[1]);
        const auto is_out = [](PointState state) { return state == PointState::outside; };
        const auto states = found.weights(0, 1.0 / 500, 501).states;
        if (anywhere || std::none_of(states.begin(), states.end(), is_out)) return found;
    }
}

struct Measured {
    double power = always, jump = 0;
    bool has_zero = false; ///< whether a weight next to the worst point is exactly zero
};

/// Finds the point of a line with the largest fourth difference, by steps that shrink by a factor of eight.
/// Returns the order of that difference in the step.
template <std::size_t D>
Measured measure(const Line<D>& line) {
    constexpr std::size_t order = 4, phases = 4; // phases: points per step
    constexpr double least = 1e-13, enough = 1e-9;
    double first = 0, step = 1.0 / 500, before = 0;
    std::size_t count = 500 * phases + 1;
    for (int level = 0;; ++level) {
        const auto weights = line.weights(first, step / phases, count);
        REQUIRE(weights.status() == Status::ok);
        Measured found;
        double largest = 0, worst = first, scale = 1;
        for (std::size_t i = 0; i < weights.rows[0].size(); ++i) {
            std::vector<double> w;
            for (const auto& row : weights.rows) w.push_back(row[i]);
            for (std::size_t k = 0; k < count; ++k) {
                scale = larger(scale, std::fabs(w[k]));
                found.has_zero = found.has_zero || w[k] == 0;
                if (k + phases < count) found.jump = larger(found.jump, std::fabs(w[k + phases] - w[k]));
                if (k + order * phases >= count) continue;
                const double difference = w[k] - 4 * w[k + phases] + 6 * w[k + 2 * phases] -
                                          4 * w[k + 3 * phases] + w[k + 4 * phases];
                if (std::fabs(difference) <= largest) continue;
                largest = std::fabs(difference);
                worst = first + (double(k) / phases + 0.5 * order) * step;
            }
        }
        if (level > 0) found.power = std::log(before / std::max(largest, least * scale)) / std::log(8.0);
        if (largest <= enough * scale || level == 8) return found;
        before = largest;
        first = std::max(0.0, worst - (order + 1) * step);
        step /= 8;
        count = 16 * (order + 1) * phases + 1;
        first = std::min(first, 1 - step * double(16 * (order + 1)));
    }
}

template <std::size_t D>
struct Kind {
    const char* name;
    double smoothness;
    std::function<Line<D>(std::uint64_t)> line;
    double jump = 0;   ///< largest allowed jump of discontinuous weights
    bool cuts = false; ///< whether negative weights become 0, with a kink
};

/// Checks that weights are as smooth as documented on all lines, and no smoother on some line.
template <std::size_t D>
void check_kind(const Kind<D>& kind) {
    CAPTURE(kind.name);
    double least = always;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        const auto [power, jump, has_zero] = measure(kind.line(seed));
        CAPTURE(seed, power, jump, has_zero);
        const bool is_cut = kind.cuts && has_zero;
        CHECK(power >= (is_cut ? continuous : kind.smoothness) - 0.4);
        if (power < 0.4) CHECK(jump <= kind.jump); // else the jump is the slope times the step
        if (!is_cut) least = std::min(least, power);
    }
    CHECK(least <= kind.smoothness + 0.4);
}

/// A lattice in a rotated box, with a falloff. `shear` is a component of one axis of the box; 0 if axes are
/// orthogonal.
cageform::LatticeCoordinates<double, 3> random_lattice(std::size_t degree, std::uint64_t seed,
                                                       double shear = 0) {
    Random random(seed);
    const double turn = random.uniform(0, 6.3), x = std::cos(turn), y = std::sin(turn);
    std::array<cageform::LatticeAxis, 3> axes;
    axes.fill({degree + 3, degree, {}});
    return cageform::LatticeCoordinates<double, 3>(
        axes, cageform::Transform<double, 3>{{{{x, y, shear}, {-y, x, 0}, {0, 0, 1}}}, {}}, 0.3);
}
/// Random sites. The first site lies in the hull of the others.
template <std::size_t D>
cageform::SibsonCoordinates<double, D> random_sites(int degree, std::uint64_t seed) {
    auto sites = random_points<double, D>(20, 1, seed);
    sites[0] = 0.1 * sites[0];
    return cageform::SibsonCoordinates<double, D>(cageform::PointSet<double, D>(sites), {.degree = degree});
}
Polygon<double> star(std::uint64_t seed) {
    return Polygon<double>(random_star<double>(seed));
}
Polygon<double> convex(std::uint64_t seed) {
    Random random(seed);
    Points<2> vertices;
    for (int k = 0; k < 7; ++k) {
        const double angle = 2 * std::numbers::pi * (k + random.uniform(-0.3, 0.3)) / 7;
        vertices.push_back({2 * std::cos(angle), std::sin(angle)});
    }
    return Polygon<double>(vertices);
}
cageform::TriangleMesh<double> mesh(std::uint64_t seed) {
    return random_mesh(seed).mesh<double>();
}
cageform::PolyhedralMesh<double> prism(std::uint64_t seed) {
    return random_prism(seed).cage<double>();
}
/// Harmonic coordinates with solved functions.
template <class C>
C solved(C coordinates) {
    REQUIRE(coordinates.solve().status == Status::ok);
    return coordinates;
}

} // namespace

TEST_CASE("weights in the plane are as smooth as documented", "[coordinates][property]") {
    using Mean = cageform::MeanValueCoordinates<double, 2>;
    using cageform::HarmonicCoordinates;
    cageform::CellComplex<double, 2> with_wall(convex(1)), with_disc(convex(1));
    with_wall.add_chain(Points<2>{{-1, -0.2}, {0, 0.1}, {0.8, 0}});
    with_disc.add_point(Vec<double, 2>{0.3, 0.1}, 0.2);
    const auto walled = solved(HarmonicCoordinates(with_wall)),
               about_disc = solved(HarmonicCoordinates(with_disc));
    const std::vector<Kind<2>> kinds{
        {"barycentric", always,
         [](auto seed) {
             return line(cageform::BarycentricCoordinates<double, 2>(random_simplex<double, 2>(seed)), seed,
                         true);
         }},
        {"mean value", always, [](auto seed) { return line(Mean(random_rings<double>(seed)), seed, true); }},
        {"mean value at a vertex", continuous,
         [](auto seed) {
             const auto cage = star(seed);
             return through(Mean(cage), cage[0], 0.1 * distance(cage[0], cage[1]), seed);
         }},
        {"Wachspress", always,
         [](auto seed) { return line(cageform::WachspressCoordinates<double>(convex(seed)), seed); }},
        {"Green", always,
         [](auto seed) { return line(cageform::GreenCoordinates<double, 2>(star(seed)), seed); }},
        {"curved Green", always,
         [](auto seed) {
             return line(
                 cageform::CurvedGreenCoordinates<double>(cageform::CurvedPolygon<double>(star(seed))), seed);
         }},
        {"harmonic", twice, [](auto seed) { return line(solved(HarmonicCoordinates(star(seed))), seed); }, 0,
         true},
        {"local harmonic", twice,
         [](auto seed) { return line(solved(HarmonicCoordinates(star(seed), {.locality = 20})), seed); }, 0,
         true},
        {"maximum entropy", like_root,
         [](auto seed) { return line(cageform::MaximumEntropyCoordinates(star(seed)), seed); }},
        {"MEC-2", always,
         [](auto seed) {
             return line(cageform::MaximumEntropyCoordinates(star(seed), cageform::EntropyPrior::mec2), seed);
         }},
        {"harmonic across a wall", jumps, [walled](auto seed) { return line(walled, seed); },
         1e-6}, // rounding
        {"harmonic about a disc", jumps, [about_disc](auto seed) { return line(about_disc, seed); }, 1e-3},
        {"harmonic on a uniform grid", jumps,
         [](auto seed) {
             return line(solved(HarmonicCoordinates(star(seed), {.resolution = 64}, cageform::UniformGrid{})),
                         seed);
         },
         1e-2},
        {"Sibson", once, [](auto seed) { return line(random_sites<2>(1, seed), seed); }},
        {"Sibson at a site", continuous,
         [](auto seed) {
             const auto sites = random_sites<2>(1, seed);
             return through(sites, sites.handles()[0], 0.1, seed);
         }},
        {"Sibson, degree 3, at a site", once,
         [](auto seed) {
             const auto sites = random_sites<2>(3, seed);
             return through(sites, sites.handles()[0], 0.1, seed);
         }},
        {"blended", once,
         [](auto seed) {
             std::vector<Mean> parts;
             parts.emplace_back(Points<2>{{0, 0}, {2, 0}, {2, 1}, {0, 1}});
             parts.emplace_back(Points<2>{{1, 0.2}, {3, 0.2}, {3, 0.8}, {1, 0.8}});
             return line(cageform::BlendedCoordinates<Mean>(std::move(parts)), seed);
         }},
    };
    for (const auto& kind : kinds) check_kind(kind);
}

TEST_CASE("weights in space are as smooth as documented", "[coordinates][property]") {
    using Mean = cageform::MeanValueCoordinates<double, 3>;
    using cageform::HarmonicCoordinates;
    const auto prismatic = solved(HarmonicCoordinates(prism(6), {.accuracy = 1e-2}));
    const auto uniform = solved(HarmonicCoordinates(mesh(1), {.resolution = 32}, cageform::UniformGrid{}));
    const std::vector<Kind<3>> kinds{
        {"mean value", always, [](auto seed) { return line(Mean(mesh(seed)), seed, true); }},
        {"mean value at an edge", continuous,
         [](auto seed) {
             const auto cage = mesh(seed);
             const auto& face = cage.faces()[0];
             const auto a = cage.vertices()[face[0]], b = cage.vertices()[face[1]];
             return through(Mean(cage), 0.5 * (a + b), 0.1 * distance(a, b), seed);
         }},
        {"Green", always,
         [](auto seed) { return line(cageform::GreenCoordinates<double, 3>(mesh(seed)), seed); }},
        {"harmonic", twice,
         [](auto seed) { return line(solved(HarmonicCoordinates(mesh(seed), {.accuracy = 1e-2})), seed); }, 0,
         true},
        {"local harmonic", twice,
         [](auto seed) {
             return line(solved(HarmonicCoordinates(mesh(seed), {.accuracy = 1e-2, .locality = 20})), seed);
         },
         0, true},
        {"maximum entropy", like_root,
         [](auto seed) { return line(cageform::MaximumEntropyCoordinates(mesh(seed)), seed); }},
        {"harmonic, faces of any shape", jumps, [prismatic](auto seed) { return line(prismatic, seed); },
         0.1},
        {"harmonic on a uniform grid", jumps, [uniform](auto seed) { return line(uniform, seed); }, 0.1},
        {"Sibson", twice, [](auto seed) { return line(random_sites<3>(1, seed), seed); }},
        {"Sibson, degree 3", twice, [](auto seed) { return line(random_sites<3>(3, seed), seed); }},
        {"lattice, degree 1", continuous,
         [](auto seed) { return line(random_lattice(1, seed), seed, true); }},
        {"lattice, degree 2", once, [](auto seed) { return line(random_lattice(2, seed), seed, true); }},
        {"lattice, degree 3", once, [](auto seed) { return line(random_lattice(3, seed), seed, true); }},
        {"lattice, degree 3, sheared and faded", continuous,
         [](auto seed) { return line(random_lattice(3, seed, 0.4), seed, true); }},
        {"lattice, degree 3, in the box", twice,
         [](auto seed) {
             const auto lattice = random_lattice(3, seed);
             return through(lattice, 0.5 * (lattice.handles()[0] + lattice.handles()[215]), 0.3, seed);
         }},
    };
    for (const auto& kind : kinds) check_kind(kind);
}

} // namespace smoothness_tests
