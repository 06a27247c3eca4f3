// Green coordinates of curved cages: reference values, the laws of Cauchy's integral, named faults.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/green.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/coordinates/curved_green.hpp>
#include <cageform/coordinates/green.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <complex>
#include <fstream>

namespace curved_green_tests {

using namespace cageform;
using namespace cageform_tests;

namespace {

using Complex = std::complex<double>;
using Json = nlohmann::json;

static_assert(GradientCoordinates<CurvedGreenCoordinates<float>>);
static_assert(GradientCoordinates<CurvedGreenCoordinates<double>>);

double number(const Json& x) {
    return x.is_string() ? std::stod(x.get<std::string>()) : x.get<double>();
}
template <class T = double>
Vec<T, 2> vec(const Json& x) {
    return {T(number(x[0])), T(number(x[1]))};
}
Json read(const std::string& name) {
    std::ifstream file(std::string(CAGEFORM_TEST_DATA) + "/curved/" + name);
    return Json::parse(file);
}
template <class T>
CurvedGreenCoordinates<T> coordinates_of(const Json& json, CurvedGreenOptions<T> options = {}) {
    std::vector<typename CurvedPolygon<T>::Loop> loops;
    for (const auto& loop : json["loops"]) {
        auto& edges = loops.emplace_back();
        for (const auto& edge : loop) {
            auto& points = edges.emplace_back();
            for (const auto& p : edge) points.push_back(vec<T>(p));
        }
    }
    for (const auto& loop : json["posed_degrees"]) {
        for (const auto& m : loop) options.posed_degrees.push_back(m.get<std::size_t>());
    }
    return CurvedGreenCoordinates<T>(CurvedPolygon<T>(std::move(loops)), options);
}

/// The largest error and its seed. NaN counts as the largest error.
struct Worst {
    static constexpr std::uint64_t none = ~std::uint64_t{0};
    double value = 0;
    std::uint64_t seed = none;

    void add(double error, std::uint64_t of) {
        if (error <= value || std::isnan(value)) return;
        value = error;
        seed = of;
    }
    /// Returns and prints the seed if the error exceeds a limit.
    std::uint64_t seed_above(double limit) const {
        if (value <= limit) return none;
        WARN("error " << value << " with seed " << seed);
        return seed;
    }
};

template <class T>
using Loops = std::vector<typename CurvedPolygon<T>::Loop>;

/// Nested star-shaped loops of lines, quadratics and cubics, of either direction. Some tangents vanish, and
/// some lines are stored as cubics. Moved, turned and scaled (10^-3 … 10^3). A cubic may intersect itself.
template <class T>
Loops<T> random_curves(std::uint64_t seed, double tangents_vanish = 0.2) {
    Random random(seed);
    const std::size_t count = 3 + random.below(6), rings = 1 + random.below(2);
    const double scale = std::pow(10.0, random.uniform(-3, 3)), turn = random.uniform(0, 6.3);
    const Vec<double, 2> centre{random.uniform(-2, 2) * scale, random.uniform(-2, 2) * scale};
    std::vector<double> angles;
    for (std::size_t i = 0; i < count; ++i)
        angles.push_back(turn +
                         2 * std::numbers::pi * (double(i) + random.uniform(-0.2, 0.2)) / double(count));
    angles.push_back(angles[0] + 2 * std::numbers::pi);
    const auto at = [&](double angle, double radius) {
        return Vec<double, 2>{radius * std::cos(angle), radius * std::sin(angle)};
    };
    std::vector<Vec<double, 2>> corners;
    for (std::size_t i = 0; i < count; ++i) corners.push_back(at(angles[i], random.uniform(0.4, 1)));
    corners.push_back(corners[0]);
    std::vector<std::vector<Vec<double, 2>>> outline;
    for (std::size_t i = 0; i < count; ++i) {
        const auto a = corners[i], b = corners[i + 1];
        const auto within = [&](double share) {
            return at(angles[i] + share * (angles[i + 1] - angles[i]), random.uniform(0.3, 1.2));
        };
        switch (random.below(5)) {
        case 0: outline.push_back({a, b}); break;
        case 1: outline.push_back({a, within(random.uniform(0.2, 0.8)), b}); break;
        case 2: outline.push_back({a, a + (1 / 3.0) * (b - a), b - (1 / 3.0) * (b - a), b}); break;
        default:
            outline.push_back({a, within(random.uniform(0.1, 0.5)), within(random.uniform(0.5, 0.9)), b});
            if (random.uniform(0, 1) < tangents_vanish) outline.back()[1] = a;
            if (random.uniform(0, 1) < tangents_vanish) outline.back()[2] = b;
            break;
        }
    }
    Loops<T> loops;
    double factor = 1;
    for (std::size_t ring = 0; ring < rings; ++ring) {
        auto& loop = loops.emplace_back();
        for (const auto& edge : outline) {
            auto& points = loop.emplace_back();
            for (const auto& p : edge) points.push_back(vec_cast<T>(centre + (scale * factor) * p));
        }
        factor *= random.uniform(0.2, 0.3);
        if (random.below(2) == 0) continue;
        std::reverse(loop.begin(), loop.end());
        for (auto& edge : loop) std::reverse(edge.begin(), edge.end());
    }
    return loops;
}
/// The point of a curve at t.
template <class T>
Vec<T, 2> on_curve(const std::vector<Vec<T, 2>>& edge, double t) {
    std::vector<Vec<long double, 2>> c;
    for (const auto& p : edge) c.push_back(vec_cast<long double>(p));
    for (; c.size() > 1; c.pop_back()) {
        for (std::size_t i = 0; i + 1 < c.size(); ++i)
            c[i] = c[i] + static_cast<long double>(t) * (c[i + 1] - c[i]);
    }
    return vec_cast<T>(c[0]);
}
/// Points at several distances from edges, ends and roots of e', and random points around the cage.
template <class T>
std::vector<Vec<T, 2>> points_about(const Loops<T>& loops, std::size_t count, std::uint64_t seed) {
    Random random(seed + 99);
    std::vector<Vec<T, 2>> all;
    for (const auto& loop : loops) {
        for (const auto& edge : loop) all.insert(all.end(), edge.begin(), edge.end());
    }
    const auto bounds = bounds_of(std::span<const Vec<T, 2>>(all));
    const double diagonal = double(bounds.diagonal());
    std::vector<Vec<T, 2>> points;
    while (points.size() < count) {
        const auto& loop = loops[random.below(loops.size())];
        const auto& edge = loop[random.below(loop.size())];
        const std::size_t kind = random.below(4);
        double t = kind == 0 ? double(random.below(2)) : random.uniform(0, 1);
        auto p = vec_cast<double>(on_curve(edge, t));
        if (kind == 3) { // a double root of e(s) = z
            detail::PlaneCurve curve{edge.size() - 1, {}};
            for (std::size_t i = 0; i < edge.size(); ++i) curve.control[i] = vec_cast<double>(edge[i]);
            const auto turning = detail::turning_points(curve.powers());
            if (turning.count > 0) {
                const auto root = turning.s[random.below(turning.count)];
                detail::Polynomial e{curve.degree, {}};
                for (std::size_t i = 0; i <= curve.degree; ++i) e.c[i] = detail::to_number(curve.powers()[i]);
                const auto at = e.at(root);
                if (std::hypot(at.re - p[0], at.im - p[1]) < 10 * diagonal) p = {at.re, at.im};
            }
        }
        const double away = diagonal * std::pow(10.0, random.uniform(-16, kind == 2 ? 0.5 : -1)),
                     angle = random.uniform(0, 6.3);
        points.push_back({T(p[0] + away * std::cos(angle)), T(p[1] + away * std::sin(angle))});
    }
    return points;
}

/// The largest difference of weights. Weights of a loop's legs may differ by a common constant.
template <class T>
double difference_of_rows(const CurvedGreenCoordinates<T>& green, const std::vector<T>& row,
                          const Json& points, const Json& legs) {
    const std::size_t count = points.size();
    double worst = row.size() == 2 * count ? 0 : 1e9;
    for (std::size_t i = 0; i < count; ++i)
        worst = larger(worst, std::fabs(double(row[i]) - number(points[i])));
    std::size_t first = 0;
    for (const auto& loop : green.cage().loops()) {
        std::size_t last = first;
        for (std::size_t e = 0; e < loop.size(); ++e) last += 3; // posed edges of all files have degree 3
        double mean = 0;
        for (std::size_t i = first; i < last; ++i)
            mean += (double(row[count + i]) - number(legs[i])) / double(last - first);
        for (std::size_t i = first; i < last; ++i)
            worst = larger(worst, std::fabs(double(row[count + i]) - mean - number(legs[i])));
        first = last;
    }
    return first == count ? worst : 1e9;
}

template <class T>
void compare_with_reference(const std::string& name) {
    const double tolerance = std::is_same_v<T, float> ? 1e-5 : 1e-13;
    const Json json = read(name);
    const auto green = coordinates_of<T>(json);
    REQUIRE(green.cage_report().status == Status::ok);
    const std::size_t count = json["handles"].size();
    REQUIRE(green.handles().size() == 2 * count);
    for (std::size_t i = 0; i < count; ++i) {
        CHECK(distance(green.handles()[i], vec(json["handles"][i])) <= tolerance);
        const auto leg = json["legs"][i];
        CHECK(green.handle_faces()[i] ==
              HandleFace<2>{leg[0].get<std::uint32_t>(), leg[1].get<std::uint32_t>()});
    }
    std::vector<Vec<T, 2>> points, pose;
    std::vector<Vec<double, 2>> posed(2 * count);
    for (const auto& row : json["rows"]) points.push_back(vec<T>(row["point"]));
    for (std::size_t i = 0; i < count; ++i) posed[i] = vec(json["pose"][i]);
    for (std::size_t i = 0; i < count; ++i)
        posed[count + i] = cageform::detail::edge_handle(posed[green.handle_faces()[i][0]],
                                                         posed[green.handle_faces()[i][1]]);
    const auto found = evaluate_all(green, points);
    const auto slopes = gradients_of<T, 2>(green, points);
    REQUIRE(found.status() == Status::ok);
    std::size_t derivatives = 0;
    for (std::size_t n = 0; n < points.size(); ++n) {
        const auto& row = json["rows"][n];
        const std::string state = row["state"];
        // In float, points next to the boundary are on it or beyond it.
        if (std::is_same_v<T, float> && n >= 4 && n < 8) continue;
        CAPTURE(name, n, points[n][0], points[n][1], state);
        CHECK(to_string(found.states[n]) == state);
        CHECK(difference_of_rows(green, found.rows[n], row["points_a"], row["legs_b"]) <= tolerance);
        const auto at = combine(found.rows[n], posed);
        CHECK(distance(at, vec(row["posed"])) <= 4 * tolerance);
        if (row.contains("legs_b_diagonal")) {
            for (std::size_t i = 0; i < count; ++i)
                CHECK(std::fabs(double(found.rows[n][count + i]) - number(row["legs_b_diagonal"][i])) <=
                      tolerance);
        }
        if (!row.contains("derivative")) continue;
        ++derivatives;
        double largest = 0, worst = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Complex expected(number(row["derivative"][i][0]), number(row["derivative"][i][1]));
            const auto& gradient = slopes.rows[n][i];
            largest = std::max(largest, std::abs(expected));
            worst = larger(worst, std::abs(Complex(double(gradient[0]), -double(gradient[1])) - expected));
        }
        CHECK(worst <= tolerance * largest);
        const auto j = jacobian(slopes.rows[n], [&] {
            std::vector<Vec<T, 2>> all;
            for (const auto& p : posed) all.push_back(vec_cast<T>(p));
            return all;
        }());
        const auto f = vec(row["posed_derivative"]);
        CHECK(std::fabs(double(j[0][0]) - f[0]) <= 8 * tolerance * largest);
        CHECK(std::fabs(double(j[1][0]) - f[1]) <= 8 * tolerance * largest);
        CHECK(std::fabs(double(j[0][0] - j[1][1])) <= 8 * tolerance * largest);
        CHECK(std::fabs(double(j[0][1] + j[1][0])) <= 8 * tolerance * largest);
    }
    CHECK(derivatives >= 4);
}

} // namespace

TEST_CASE("Weights of curved cages are those of the oracle", "[coordinates][curved_green][oracle]") {
    for (const char* name : {"curved_l_straight.json", "curved_mixed.json", "curved_blob.json",
                             "curved_leaf.json", "curved_hole.json"}) {
        compare_with_reference<double>(name);
        compare_with_reference<float>(name);
    }
}

TEST_CASE("Weights of curved cages in a disk are those of the oracle",
          "[coordinates][curved_green][oracle]") {
    const Json json = read("disk.json");
    for (const auto& test : json["cases"]) {
        CurvedGreenOptions<double> options;
        options.disk = CurvedGreenDisk<double>{vec(test["centre"]), number(test["radius"])};
        const auto green = coordinates_of<double>(read(test["cage"]), options);
        REQUIRE(green.cage_report().status == Status::ok);
        std::vector<Vec<double, 2>> points, posed;
        for (const auto& row : test["rows"]) points.push_back(vec(row["point"]));
        for (const auto& p : test["pose"]) posed.push_back(vec(p));
        for (const auto& [from, to] : green.handle_faces())
            posed.push_back(cageform::detail::edge_handle(posed[from], posed[to]));
        const auto found = evaluate_all(green, points);
        REQUIRE(found.status() == Status::ok);
        for (std::size_t n = 0; n < points.size(); ++n) {
            CAPTURE(test["cage"].get<std::string>(), n);
            const auto& row = test["rows"][n];
            for (std::size_t i = 0; i < row["weights"].size(); ++i)
                CHECK(std::fabs(found.rows[n][i] - number(row["weights"][i][0])) <= 1e-13);
            CHECK(distance(combine(found.rows[n], posed), vec(row["posed"])) <= 1e-13);
        }
    }
}

TEMPLATE_TEST_CASE("Weights of curved cages have row sums next to edges, ends and double roots too",
                   "[coordinates][curved_green][property]", float, double) {
    using T = TestType;
    std::size_t cages = 0, outside = 0, inside = 0, on_boundary = 0;
    Worst worst_sum, worst_place;
    for (std::uint64_t seed = 0; seed < effort(3000u, 100u); ++seed) {
        const auto loops = random_curves<T>(seed);
        CurvedGreenOptions<T> options;
        options.posed_degree = 3 + seed % 3;
        const CurvedGreenCoordinates<T> green(CurvedPolygon<T>(loops), options);
        if (green.cage_report().status != Status::ok) continue;
        ++cages;
        const auto points = points_about<T>(loops, 40, seed);
        const auto found = evaluate_all(green, points);
        REQUIRE(found.status() == Status::ok);
        const double size = size_of(std::vector(green.handles().begin(), green.handles().end()));
        for (std::size_t n = 0; n < points.size(); ++n) {
            outside += found.states[n] == PointState::outside;
            inside += found.states[n] == PointState::inside;
            on_boundary += found.states[n] == PointState::on_boundary;
            long double sum = -1;
            for (std::size_t i = 0; i < green.handles().size() / 2; ++i)
                sum += static_cast<long double>(found.rows[n][i]);
            // Beside an end without a tangent, the continuation has large weights.
            const double weights = std::max(1.0, absolute_sum(found.rows[n]));
            worst_sum.add(double(std::fabs(sum)) / weights, seed);
            worst_place.add(distance(combine(found.rows[n], green.handles()), points[n]) / size / weights,
                            seed);
        }
    }
    const double tolerance =
        std::is_same_v<T, float> ? 1e-6 : 1e-14; // in float the tolerance at a vertex is 1e-6 of the size
    CHECK(worst_sum.seed_above(tolerance) == Worst::none);
    CHECK(worst_place.seed_above(tolerance) == Worst::none);
    CHECK(cages == effort(3000u, 100u));
    for (const std::size_t count : {inside, outside, on_boundary}) CHECK(count >= cages);
}

namespace {

/// Control points moved by up to a fifth of the cage, plus an affine map.
template <class T>
std::vector<Vec<double, 2>> random_pose(const CurvedGreenCoordinates<T>& green, std::uint64_t seed) {
    Random random(seed + 7);
    const std::size_t count = green.handles().size() / 2;
    const double size = double(bounds_of(green.handles().first(count)).diagonal());
    std::vector<Vec<double, 2>> pose;
    for (const auto& p : green.handles().first(count))
        pose.push_back(vec_cast<double>(p) +
                       Vec<double, 2>{random.uniform(-0.2, 0.2) * size, random.uniform(-0.2, 0.2) * size});
    return pose;
}
/// All handles for a pose of the control points.
template <class T>
std::vector<Vec<double, 2>> with_legs(const CurvedGreenCoordinates<T>& green,
                                      std::vector<Vec<double, 2>> pose) {
    for (const auto& [from, to] : green.handle_faces())
        pose.push_back(cageform::detail::edge_handle(pose[from], pose[to]));
    return pose;
}
/// Moves points without a binding.
template <class T>
std::vector<Vec<double, 2>> moved(const CurvedGreenCoordinates<T>& green,
                                  const std::vector<Vec<T, 2>>& points,
                                  const std::vector<Vec<double, 2>>& pose) {
    const auto handles = with_legs(green, pose);
    std::vector<Vec<double, 2>> result;
    for (const auto& row : evaluate_all(green, points).rows)
        result.push_back(vec_cast<double>(combine(row, handles)));
    return result;
}
/// The largest distance between two lists, relative to the cage, and to `weights` if larger than 1.
template <class T>
double apart(const CurvedGreenCoordinates<T>& green, const std::vector<Vec<double, 2>>& a,
             const std::vector<Vec<double, 2>>& b, const Weights<T>& weights) {
    const double size = size_of(std::vector(green.handles().begin(), green.handles().end()));
    double worst = a.size() == b.size() ? 0 : 1e9;
    for (std::size_t n = 0; n < a.size() && n < b.size(); ++n)
        worst = larger(worst, distance(a[n], b[n]) / size / std::max(1.0, absolute_sum(weights.rows[n])));
    return worst;
}

/// The control points of all edges around the loops, elevated to the posed degrees, shared ends once.
template <class T>
std::vector<Vec<double, 2>> joined(const std::vector<std::vector<Vec<double, 2>>>& edges) {
    std::vector<Vec<double, 2>> all;
    for (const auto& edge : edges) all.insert(all.end(), edge.begin(), edge.end() - 1);
    return all;
}
/// The control points of each edge in a pose, for given edge counts of loops and degrees.
std::vector<std::vector<Vec<double, 2>>> edges_of(const std::vector<Vec<double, 2>>& pose,
                                                  const std::vector<std::size_t>& loop_sizes,
                                                  const std::vector<std::size_t>& degrees) {
    std::vector<std::vector<Vec<double, 2>>> edges;
    std::size_t first = 0, e = 0;
    for (const std::size_t size : loop_sizes) {
        const std::size_t begin = first;
        for (std::size_t k = 0; k < size; ++k, ++e) {
            auto& edge = edges.emplace_back();
            for (std::size_t i = 0; i <= degrees[e]; ++i)
                edge.push_back(pose[first + i - (k + 1 == size && i == degrees[e] ? first + i - begin : 0)]);
            first += degrees[e];
        }
    }
    return edges;
}

/// Elevates the degree by one.
std::vector<Vec<double, 2>> raised(const std::vector<Vec<double, 2>>& c) {
    std::vector<Vec<double, 2>> r{c[0]};
    const auto n = double(c.size());
    for (std::size_t i = 1; i < c.size(); ++i)
        r.push_back((double(i) / n) * c[i - 1] + (1 - double(i) / n) * c[i]);
    r.push_back(c.back());
    return r;
}
/// The parts of the curve on [0, t] and on [t, 1].
template <class T>
std::array<std::vector<Vec<T, 2>>, 2> split(std::vector<Vec<T, 2>> c, T t) {
    std::vector<Vec<T, 2>> low, high;
    while (!c.empty()) {
        low.push_back(c.front());
        high.insert(high.begin(), c.back());
        for (std::size_t i = 0; i + 1 < c.size(); ++i)
            c[i] = c[i] + t * (c[i + 1] - c[i]); // keeps coincident points
        c.pop_back();
    }
    return {low, high};
}

/// Whether two edges are equally near. Rounding then decides which edge is used, outside and on the boundary.
bool is_on_seam(const Loops<double>& loops, const Vec<double, 2>& p) {
    double nearest = 1e300, second = 1e300;
    for (const auto& loop : loops) {
        for (const auto& edge : loop) {
            detail::PlaneCurve curve{edge.size() - 1, {}};
            std::copy(edge.begin(), edge.end(), curve.control.begin());
            const double off = detail::nearest_place(curve, p, 1e300).distance;
            second = std::min(second, std::max(nearest, off));
            nearest = std::min(nearest, off);
        }
    }
    return second - nearest <= 1e-9 * (second + std::fabs(p[0]) + std::fabs(p[1]));
}

/// A cage with the posed degrees of its edges.
struct PosedCage {
    Loops<double> loops;
    CurvedGreenOptions<double> options;
    std::vector<std::size_t> sizes; ///< number of edges per loop

    explicit PosedCage(std::uint64_t seed, double tangents_vanish = 0.2)
        : loops(random_curves<double>(seed, tangents_vanish)) {
        Random random(seed + 5);
        for (const auto& loop : loops) {
            sizes.push_back(loop.size());
            for (const auto& edge : loop)
                options.posed_degrees.push_back(edge.size() - 1 + random.below(7 - edge.size()));
        }
    }
    CurvedGreenCoordinates<double> green() const {
        return CurvedGreenCoordinates<double>(CurvedPolygon<double>(loops), options);
    }
};

} // namespace

TEST_CASE("Raising the posed degree, splitting edges and reversing loops of curved cages have no effect",
          "[coordinates][curved_green][property]") {
    Worst raising, splitting, reversing;
    for (std::uint64_t seed = 0; seed < effort(400u, 20u); ++seed) {
        const PosedCage cage(seed);
        const auto green = cage.green();
        REQUIRE(green.cage_report().status == Status::ok);
        std::vector<Vec<double, 2>> points;
        for (const auto& p : points_about<double>(cage.loops, 40, seed)) {
            std::vector<double> row(green.handles().size());
            if (weights_at(green, p, row) == PointState::inside || !is_on_seam(cage.loops, p))
                points.push_back(p);
        }
        for (const auto& edge : cage.loops[0]) points.push_back(edge[0]); // vertices have their own limits
        const auto pose = random_pose(green, seed);
        const auto at = moved(green, points, pose);
        const auto weights = evaluate_all(green, points);
        const auto posed = edges_of(pose, cage.sizes, cage.options.posed_degrees);
        CAPTURE(seed);
        {
            PosedCage raised_cage = cage;
            auto edges = posed;
            for (std::size_t e = 0; e < edges.size(); ++e) {
                if (raised_cage.options.posed_degrees[e] == 5) continue;
                ++raised_cage.options.posed_degrees[e];
                edges[e] = raised(edges[e]);
            }
            const auto same = moved(raised_cage.green(), points, joined<double>(edges));
            raising.add(apart(green, at, same, weights), seed);
        }
        {
            PosedCage halves = cage;
            halves.options.posed_degrees.clear();
            std::vector<std::vector<Vec<double, 2>>> edges;
            const double t = 0.25 + 0.5 * double(seed % 7) / 7;
            std::size_t e = 0;
            for (auto& loop : halves.loops) {
                std::vector<std::vector<Vec<double, 2>>> all;
                for (const auto& edge : loop) {
                    for (const auto& half : split(edge, t)) all.push_back(half);
                    for (const auto& half : split(posed[e], t)) edges.push_back(half);
                    halves.options.posed_degrees.insert(halves.options.posed_degrees.end(), 2,
                                                        cage.options.posed_degrees[e]);
                    ++e;
                }
                loop = all;
            }
            const auto finer = halves.green();
            REQUIRE(finer.cage_report().status == Status::ok);
            // Nothing changes on the boundary either, nor where the nearest point is a new end. Points within
            // the tolerance of only one of the cages are left out.
            auto same = moved(finer, points, joined<double>(edges));
            const auto states = evaluate_all(finer, points).states;
            for (std::size_t n = 0; n < points.size(); ++n) {
                if (states[n] != weights.states[n]) same[n] = at[n];
            }
            splitting.add(apart(green, at, same, weights), seed);
        }
        {
            PosedCage back = cage;
            back.options.posed_degrees.clear();
            std::vector<std::vector<Vec<double, 2>>> edges;
            std::size_t first = 0;
            for (auto& loop : back.loops) {
                for (std::size_t k = loop.size(); k-- > 0;) {
                    back.options.posed_degrees.push_back(cage.options.posed_degrees[first + k]);
                    edges.emplace_back(posed[first + k].rbegin(), posed[first + k].rend());
                }
                first += loop.size();
                std::reverse(loop.begin(), loop.end());
                for (auto& edge : loop) std::reverse(edge.begin(), edge.end());
            }
            const auto same = moved(back.green(), points, joined<double>(edges));
            reversing.add(apart(green, at, same, weights), seed);
        }
    }
    CHECK(raising.seed_above(1e-13) == Worst::none);
    CHECK(splitting.seed_above(1e-13) == Worst::none);
    CHECK(reversing.seed_above(1e-13) == Worst::none);
}

TEST_CASE("Straight cages of posed degree 1 have the weights of GreenCoordinates",
          "[coordinates][curved_green][property]") {
    Worst worst, cubic;
    for (std::uint64_t seed = 0; seed < effort(200u, 20u); ++seed) {
        const auto polygon = random_rings<double>(seed);
        const GreenCoordinates<double, 2> green(polygon);
        CurvedGreenOptions<double> options;
        options.posed_degree = 1;
        const CurvedGreenCoordinates<double> curved(CurvedPolygon<double>(polygon), options);
        REQUIRE(curved.cage_report().status == green.cage_report().status);
        if (green.cage_report().status != Status::ok) continue;
        REQUIRE(std::ranges::equal(curved.handles(), green.handles()));
        REQUIRE(std::ranges::equal(curved.handle_faces(), green.handle_faces()));
        REQUIRE(std::ranges::equal(curved.handle_kinds(), green.handle_kinds()));
        const auto points = points_about<double>(
            std::vector(curved.cage().loops().begin(), curved.cage().loops().end()), 40, seed);
        const auto a = evaluate_all(green, points), b = evaluate_all(curved, points);
        for (std::size_t n = 0; n < points.size(); ++n) {
            if (a.states[n] != b.states[n] || a.states[n] == PointState::on_boundary) continue;
            const double off = difference(a.rows[n], b.rows[n]) / std::max(1.0, absolute_sum(a.rows[n]));
            worst.add(off, seed);
        }
        // Lines, and lines stored as cubics.
        auto loops = std::vector(curved.cage().loops().begin(), curved.cage().loops().end());
        const CurvedGreenCoordinates<double> lines{CurvedPolygon<double>(loops)};
        for (auto& loop : loops) {
            for (auto& edge : loop) edge = raised(raised(edge));
        }
        const CurvedGreenCoordinates<double> cubics{CurvedPolygon<double>(loops)};
        const auto c = evaluate_all(lines, points), d = evaluate_all(cubics, points);
        for (std::size_t n = 0; n < points.size(); ++n) {
            if (c.states[n] != d.states[n]) continue;
            cubic.add(difference(c.rows[n], d.rows[n]) / std::max(1.0, absolute_sum(c.rows[n])), seed);
        }
    }
    CHECK(worst.seed_above(1e-14) == Worst::none);
    CHECK(cubic.seed_above(1e-13) == Worst::none);
}

TEST_CASE("Gradients of curved cages: sums, the Cauchy-Riemann equations in every pose, and differences",
          "[coordinates][curved_green][gradient][property]") {
    Worst sums, cauchy_riemann, differences, in_disk;
    std::size_t inside = 0, outside = 0;
    for (std::uint64_t seed = 0; seed < effort(400u, 20u); ++seed) {
        PosedCage cage(seed);
        const auto green = cage.green();
        REQUIRE(green.cage_report().status == Status::ok);
        const double size = double(bounds_of(green.handles().first(green.handles().size() / 2)).diagonal());
        cage.options.disk = CurvedGreenDisk<double>{green.handles()[0], 1.5 * size};
        const auto disk = cage.green();
        REQUIRE(disk.cage_report().status == Status::ok);
        const auto handles = with_legs(green, random_pose(green, seed));
        std::vector<Vec<double, 2>> ones(handles.size());
        for (std::size_t h = 0; h < handles.size() / 2; ++h) ones[h] = {1, 0};
        const auto points = points_about<double>(cage.loops, 24, seed);
        const auto slopes = gradients_of<double, 2>(green, points);
        REQUIRE(slopes.evaluation.status == Status::ok);
        for (std::size_t n = 0; n < points.size(); ++n) {
            const auto& p = points[n];
            CAPTURE(seed, n, p[0], p[1], to_string(slopes.states[n]));
            double largest = 1;
            for (const auto& g : slopes.rows[n]) largest += (std::fabs(g[0]) + std::fabs(g[1])) * size;
            const auto sum = jacobian(slopes.rows[n], ones);
            sums.add(double(std::fabs(sum[0][0]) + std::fabs(sum[0][1])) * size / largest, seed);
            if (slopes.states[n] != PointState::outside) {
                const auto j = jacobian(slopes.rows[n], handles);
                cauchy_riemann.add(
                    double(std::fabs(j[0][0] - j[1][1]) + std::fabs(j[0][1] + j[1][0])) / largest, seed);
            }
            // Differences need free space around the point, without cage or seams.
            double room = 1e300;
            for (const auto& loop : cage.loops) {
                for (const auto& edge : loop) {
                    detail::PlaneCurve curve{edge.size() - 1, {}};
                    std::copy(edge.begin(), edge.end(), curve.control.begin());
                    room = std::min(room, detail::nearest_place(curve, p, 1e300).distance);
                }
            }
            if (room < 0.01 * size || room > size) continue;
            if (slopes.states[n] == PointState::outside && is_on_seam(cage.loops, p)) continue;
            (slopes.states[n] == PointState::outside ? outside : inside) += 1;
            const double step = 1e-6 * size;
            const std::vector<Vec<double, 2>> around{
                {p[0] + step, p[1]}, {p[0] - step, p[1]}, {p[0], p[1] + step}, {p[0], p[1] - step}};
            for (const bool of_disk : {false, true}) {
                const auto& coordinates = of_disk ? disk : green;
                const auto rows = evaluate_all(coordinates, around).rows;
                const auto gradients = gradients_of<double, 2>(coordinates, {p}).rows[0];
                double worst = 0;
                for (std::size_t h = 0; h < gradients.size(); ++h) {
                    for (std::size_t k = 0; k < 2; ++k)
                        worst = larger(worst, std::fabs((rows[2 * k][h] - rows[2 * k + 1][h]) / (2 * step) -
                                                        gradients[h][k]) *
                                                  size);
                }
                auto& most = of_disk ? in_disk : differences;
                most.add(worst * room / size / largest, seed);
            }
        }
    }
    CHECK(sums.seed_above(1e-14) == Worst::none);
    CHECK(cauchy_riemann.seed_above(1e-14) == Worst::none);
    CHECK(differences.seed_above(1e-6) == Worst::none);
    CHECK(in_disk.seed_above(1e-6) == Worst::none);
    CHECK(inside >= effort(400u, 20u));
    CHECK(outside >= effort(400u, 20u));
}

TEST_CASE("Weights of curved cages are continuous across edges, with their slopes",
          "[coordinates][curved_green][outside]") {
    Worst values, slopes;
    std::size_t checked = 0;
    for (std::uint64_t seed = 0; seed < effort(300u, 20u); ++seed) {
        const PosedCage cage(seed, 0);
        const auto green = cage.green();
        REQUIRE(green.cage_report().status == Status::ok);
        Random random(seed);
        const auto& loop = cage.loops[random.below(cage.loops.size())];
        const auto& edge = loop[random.below(loop.size())];
        const double t = random.uniform(0.1, 0.9);
        const auto at = on_curve(edge, t);
        const auto along = on_curve(edge, t + 1e-6) - on_curve(edge, t - 1e-6);
        const double size = size_of(std::vector(green.handles().begin(), green.handles().end()));
        const auto step = (0x1p-40 * size / detail::length(along)) * Vec<double, 2>{along[1], -along[0]};
        const auto rows = evaluate_all(green, std::vector{at - step, at, at + step});
        CAPTURE(seed, t);
        CHECK(rows.states[1] == PointState::on_boundary);
        CHECK((rows.states[0] == PointState::inside) == (rows.states[2] == PointState::outside));
        const double speed = 5e5 * detail::length(along) / size; // |e'|
        for (const std::size_t side : {std::size_t{0}, std::size_t{2}})
            values.add(difference(rows.rows[1], rows.rows[side]) * speed, seed);
        const auto gradients = gradients_of<double, 2>(green, {at - step, at, at + step}).rows;
        for (std::size_t h = 0; h < gradients[0].size(); ++h) {
            for (const std::size_t side : {std::size_t{0}, std::size_t{2}})
                slopes.add(distance(gradients[1][h], gradients[side][h]) * size * speed * speed, seed);
        }
        ++checked;
    }
    CHECK(values.seed_above(1e-11) == Worst::none); // slopes times 2^-40
    CHECK(slopes.seed_above(1e-9) == Worst::none);
    CHECK(checked == effort(300u, 20u));
}

TEST_CASE(
    "A large disk moves nothing, and a disk through a cage of many vertices gives its harmonic extension",
    "[coordinates][curved_green][disk]") {
    Worst worst;
    for (std::uint64_t seed = 0; seed < effort(100u, 10u); ++seed) {
        PosedCage cage(seed);
        const auto plane = cage.green();
        const auto points = points_about<double>(cage.loops, 24, seed);
        const double size = size_of(std::vector(plane.handles().begin(), plane.handles().end()));
        cage.options.disk = CurvedGreenDisk<double>{plane.handles()[1], 1e8 * size};
        const auto disk = cage.green();
        REQUIRE(disk.cage_report().status == Status::ok);
        const auto pose = random_pose(plane, seed);
        worst.add(
            apart(plane, moved(plane, points, pose), moved(disk, points, pose), evaluate_all(plane, points)),
            seed);
    }
    CHECK(worst.seed_above(1e-14) == Worst::none);

    std::vector<Vec<double, 2>> circle;
    for (std::size_t i = 0; i < 256; ++i) {
        const double angle = 2 * std::numbers::pi * double(i) / 256;
        circle.push_back({1 + std::cos(angle), 2 + std::sin(angle)});
    }
    CurvedGreenOptions<double> options;
    options.posed_degree = 1;
    options.disk = CurvedGreenDisk<double>{{1, 2}, 1};
    const CurvedGreenCoordinates<double> disk(CurvedPolygon<double>(Polygon<double>(circle)), options);
    REQUIRE(disk.cage_report().status == Status::ok);
    // The harmonic function with the boundary values (cos 3φ, sin 2φ).
    std::vector<Vec<double, 2>> pose, expected, points;
    for (std::size_t i = 0; i < 256; ++i) {
        const double angle = 2 * std::numbers::pi * double(i) / 256;
        pose.push_back({std::cos(3 * angle), std::sin(2 * angle)});
    }
    Random random(3);
    for (int n = 0; n < 40; ++n) {
        const double radius = random.uniform(0, 0.9), angle = random.uniform(0, 6.3);
        points.push_back({1 + radius * std::cos(angle), 2 + radius * std::sin(angle)});
        expected.push_back(
            {std::pow(radius, 3) * std::cos(3 * angle), radius * radius * std::sin(2 * angle)});
    }
    const auto found = moved(disk, points, pose);
    for (std::size_t n = 0; n < points.size(); ++n) CHECK(distance(found[n], expected[n]) <= 1e-3);
    for (const auto& p : circle) { // on vertices, and outside the disk
        std::vector<double> row(disk.handles().size());
        CHECK(weights_at(disk, p, row) == PointState::on_boundary);
        CHECK(std::fabs(double(sum_of(std::span(row).first(256))) - 1) <= 1e-13);
        const auto beyond = p + 0.1 * (p - Vec<double, 2>{1, 2});
        CHECK(weights_at(disk, beyond, row) == PointState::outside);
        CHECK(distance(combine(row, disk.handles()), beyond) <= 1e-13);
    }
}

TEST_CASE("Gradients on vertices of curved cages are those of a point nearby, also on a disk's circle",
          "[coordinates][curved_green][disk]") {
    const int seed = GENERATE(seeds(10));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const Vec<double, 2> centre{random.uniform(-2, 2), random.uniform(-2, 2)};
    const double radius = random.uniform(0.5, 3);
    std::vector<Vec<double, 2>> cage;
    for (std::size_t i = 0; i < 7; ++i) {
        const double angle = 2 * std::numbers::pi * (double(i) + random.uniform(-0.3, 0.3)) / 7;
        cage.push_back(centre + radius * Vec<double, 2>{std::cos(angle), std::sin(angle)});
    }
    const auto middle = [](const Vec<double, 2>& a, const Vec<double, 2>& at, const Vec<double, 2>& b) {
        const auto to_a = (1 / distance(a, at)) * (a - at), to_b = (1 / distance(b, at)) * (b - at);
        const auto between = to_a + to_b;
        return (1 / std::hypot(between[0], between[1])) * between;
    };
    const auto box = cageform::bounds_of(std::span<const Vec<double, 2>>(cage));
    std::vector<Vec<double, 2>> inside;
    for (std::size_t i = 0; i < 7; ++i)
        inside.push_back(cage[i] +
                         1e-6 * box.diagonal() * middle(cage[(i + 6) % 7], cage[i], cage[(i + 1) % 7]));
    for (const double share : {0.0, 1.0, 1.5}) { // relative to the circle through all vertices; 0: no disk
        CAPTURE(share);
        CurvedGreenOptions<double> options;
        if (share > 0) options.disk = CurvedGreenDisk<double>{centre, share * radius};
        const CurvedGreenCoordinates<double> green(CurvedPolygon<double>(Polygon<double>(cage)), options);
        REQUIRE(green.cage_report().status == Status::ok);
        const auto found = gradients_of<double, 2>(green, cage),
                   expected = gradients_of<double, 2>(green, inside);
        for (std::size_t i = 0; i < 7; ++i) {
            CHECK(found.states[i] == PointState::on_boundary);
            double largest = 0, worst = 0;
            for (std::size_t h = 0; h < found.rows[i].size(); ++h) {
                for (std::size_t k = 0; k < 2; ++k) {
                    largest = std::max(largest, std::fabs(expected.rows[i][h][k]));
                    worst = larger(worst, std::fabs(found.rows[i][h][k] - expected.rows[i][h][k]));
                }
            }
            CHECK(worst <= 1e-8 * largest);
        }
    }
}

TEMPLATE_TEST_CASE("Weights of curved cages do not depend on the unit of length",
                   "[coordinates][curved_green]", float, double) {
    using T = TestType;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const auto loops = random_curves<T>(seed);
        const auto points = points_about<T>(loops, 20, seed);
        const auto rows = evaluate_all(CurvedGreenCoordinates<T>(CurvedPolygon<T>(loops)), points);
        REQUIRE(rows.status() == Status::ok);
        for (const int exponent : {-30, -1, 30}) {
            auto scaled = loops;
            auto places = points;
            for (auto& loop : scaled) {
                for (auto& edge : loop) {
                    for (auto& p : edge) p = std::ldexp(T(1), exponent) * p;
                }
            }
            for (auto& p : places) p = std::ldexp(T(1), exponent) * p;
            const auto same = evaluate_all(CurvedGreenCoordinates<T>(CurvedPolygon<T>(scaled)), places);
            CAPTURE(seed, exponent);
            CHECK(same.states == rows.states);
            CHECK(same.rows == rows.rows);
        }
    }
}

TEMPLATE_TEST_CASE("A binding to a curved cage is bitwise exact at rest, follows similarities, and packs",
                   "[coordinates][curved_green][bind]", float, double) {
    using T = TestType;
    for (std::uint64_t seed = 0; seed < effort(40u, 5u); ++seed) {
        CAPTURE(seed);
        const auto loops = random_curves<T>(seed, 0);
        const CurvedGreenCoordinates<T> green{CurvedPolygon<T>(loops)};
        auto points = points_about<T>(loops, 40, seed);
        points[3][1] = std::numeric_limits<T>::quiet_NaN();
        const auto bound = bind(green, points, {.outside = OutsidePoints::extend});
        REQUIRE(bound.report.status == Status::ok);
        CHECK(bound.report.not_finite == std::vector<std::size_t>{3});
        CHECK(bound.report.unreached.empty());
        points[3] = points[4];
        const std::size_t count = green.handles().size() / 2;
        const std::vector<Vec<T, 2>> control(green.handles().begin(),
                                             green.handles().begin() + std::ptrdiff_t(count));
        std::vector<Vec<T, 2>> out(points.size());
        REQUIRE(clone(bound.value, posed_handles(bound.value, control), out) == Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) CHECK((i == 3 || out[i] == points[i]));
        CHECK(clone(bound.value, control, out) == Status::pose_size_differs); // without legs

        Random random(seed + 50);
        AffineMap<2> turn;
        const double a = random.uniform(-2, 2), b = random.uniform(-2, 2);
        turn.rows[0] = {a, -b};
        turn.rows[1] = {b, a};
        turn.shift = {size_of(control), 0.5};
        const auto pose = turn(std::span<const Vec<T, 2>>(control));
        const auto packed = pack(bound.value);
        REQUIRE(packed.status() == Status::ok);
        for (const bool is_packed : {false, true}) {
            const auto handles = posed_handles(bound.value, pose);
            REQUIRE((is_packed ? clone(packed.value, handles, out) : clone(bound.value, handles, out)) ==
                    Status::ok);
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (i == 3) continue;
                double weight = 0;
                for (std::size_t h = 0; h < 2 * count; ++h)
                    weight += std::fabs(double(bound.value.weight(i, h)));
                const double size =
                    weight * (size_of(control) + size_of(pose)) + distance(points[i], control[0]);
                CHECK(distance(out[i], turn(vec_cast<long double>(points[i]))) <=
                      24 * double(epsilon<T>) * size);
            }
        }
    }
}

TEST_CASE("The nearest boundary place of a curved cage has the weights of the limit",
          "[coordinates][curved_green]") {
    for (std::uint64_t seed = 0; seed < effort(60u, 6u); ++seed) {
        const auto loops = random_curves<double>(seed);
        const CurvedGreenCoordinates<double> green{CurvedPolygon<double>(loops)};
        const double size = size_of(std::vector(green.handles().begin(), green.handles().end()));
        for (const auto& p : points_about<double>(loops, 10, seed)) {
            std::vector<double> row(green.handles().size());
            const auto q = green.nearest_boundary(p, row);
            double least = 1e300; // no sample of the curves is nearer
            for (const auto& loop : loops) {
                for (const auto& edge : loop) {
                    for (int k = 0; k <= 50; ++k)
                        least = std::min(least, distance(p, on_curve(edge, k / 50.0)));
                }
            }
            CAPTURE(seed, p[0], p[1]);
            CHECK(distance(p, q) <= least + 1e-14 * size);
            CHECK(distance(combine(row, green.handles()), q) <=
                  1e-13 * size * std::max(1.0, absolute_sum(row)));
            CHECK(std::fabs(double(sum_of(std::span(row).first(row.size() / 2))) - 1) <=
                  1e-13 * std::max(1.0, absolute_sum(row)));
        }
    }
}

namespace {

CageReport report_of(std::vector<CurvedPolygon<double>::Loop> loops,
                     const CurvedGreenOptions<double>& options = {}) {
    return CurvedGreenCoordinates<double>(CurvedPolygon<double>(std::move(loops)), options).cage_report();
}

void check_first_fault(const CageReport& found, Status status, CageFaultKind kind, std::size_t a,
                       std::size_t b) {
    CHECK(found.status == status);
    REQUIRE(!found.faults.empty());
    CHECK(found.faults[0].kind == kind);
    CHECK(found.faults[0].a == a);
    CHECK(found.faults[0].b == b);
}

const CurvedPolygon<double>::Loop two_parabolas{{{0, 0}, {1, -1}, {2, 0}}, {{2, 0}, {1, 1}, {0, 0}}};

} // namespace

TEST_CASE("Faults of curved cages are named", "[coordinates][curved_green][check]") {
    using Cage = CurvedPolygon<double>;
    using Kind = CageFaultKind;
    const Cage::Loop& leaf = two_parabolas;
    const double infinite = std::numeric_limits<double>::infinity(),
                 nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(report_of({leaf}).status == Status::ok);
    CHECK(report_of({leaf}).faults.empty());
    check_first_fault(report_of({}), Status::too_few_vertices, Kind::too_few_vertices, 0, 0);
    check_first_fault(report_of({leaf, {}}), Status::too_few_vertices, Kind::too_few_vertices, 1, 0);
    check_first_fault(report_of({{leaf[0], {}}}), Status::curve_degree_not_supported, Kind::curve_degree, 1,
                      0);
    check_first_fault(report_of({{leaf[0], {{2, 0}}}}), Status::curve_degree_not_supported,
                      Kind::curve_degree, 1, 0);
    check_first_fault(report_of({{leaf[0], {{2, 0}, {2, 1}, {1, 1}, {0, 1}, {0, 0}}}}),
                      Status::curve_degree_not_supported, Kind::curve_degree, 1, 4);
    check_first_fault(report_of({{leaf[0], {{2, 0}, {1, nan}, {0, 0}}}}), Status::vertex_not_finite,
                      Kind::vertex_not_finite, 1, 1);
    check_first_fault(report_of({{{{0, 0}, {1, -1}, {infinite, 0}}, leaf[1]}}), Status::vertex_not_finite,
                      Kind::vertex_not_finite, 0, 2);
    check_first_fault(report_of({{{{0, 0}, {1e308, -1e308}, {2, 0}}, {{2, 0}, {-1e308, 1e308}, {0, 0}}}}),
                      Status::vertex_not_finite, Kind::vertex_not_finite, 0, 1);
    check_first_fault(report_of({{leaf[0], {{2, 0}, {1, 1}, {0, 1e-9}}}}), Status::loop_not_closed,
                      Kind::loop_not_closed, 0, 1);
    check_first_fault(report_of({{leaf[0], {{2, 0}, {2, 0}}, leaf[1]}}), Status::duplicate_vertices,
                      Kind::duplicate_vertices, 1, 1);
    check_first_fault(report_of({{{{0, 0}, {2, 1}}, {{2, 1}, {4, 2}, {0, 0}}}}), Status::cage_has_no_area,
                      Kind::no_area, 0, 0);
    // A curve there and back, a loop, a line that reverses, two crossing edges, a vertex visited twice.
    check_first_fault(report_of({{leaf[0], {{2, 0}, {1, -1}, {0, 0}}}}), Status::cage_self_crossing,
                      Kind::edges_cross, 0, 1);
    check_first_fault(report_of({{{{0, 0}, {4, 3}, {-2, 3}, {2, 0}}, {{2, 0}, {0, 0}}}}),
                      Status::cage_self_crossing, Kind::edges_cross, 0, 0);
    check_first_fault(report_of({{{{0, 0}, {4, 0}, {-2, 0}, {2, 0}}, {{2, 0}, {1, 3}, {0, 0}}}}),
                      Status::cage_self_crossing, Kind::edges_cross, 0, 0);
    check_first_fault(report_of({leaf, {{{1, 0}, {3, 0}}, {{3, 0}, {2, 3}}, {{2, 3}, {1, 0}}}}),
                      Status::cage_self_crossing, Kind::edges_cross, 0, 2);
    check_first_fault(report_of({{{{0, 0}, {2, 0}},
                                  {{2, 0}, {0, 2}},
                                  {{0, 2}, {0, 0}},
                                  {{0, 0}, {-2, 0}},
                                  {{-2, 0}, {0, -2}},
                                  {{0, -2}, {0, 0}}}}),
                      Status::cage_self_crossing, Kind::edges_cross, 0, 3);
    // Curves that touch between their ends, and curves at a distance of 1e-9.
    const auto lens = [](double gap) {
        return Cage::Loop{{{-1, 2 + gap}, {0, gap}, {1, 2 + gap}}, {{1, 2 + gap}, {0, 4}, {-1, 2 + gap}}};
    };
    const Cage::Loop below{{{-1, 0}, {0, 2}, {1, 0}}, {{1, 0}, {0, -2}, {-1, 0}}};
    check_first_fault(report_of({below, lens(0)}), Status::cage_self_crossing, Kind::edges_cross, 0, 2);
    CHECK(report_of({below, lens(1e-9)}).status == Status::ok);
    // A teardrop of one edge.
    CHECK(report_of({{{{0, 0}, {3, -1}, {3, 2}, {0, 0}}}}).status == Status::ok);
    const Cage crossed(Polygon<double>(std::vector<Vec<double, 2>>{{0, 0}, {1, 1}, {1, 0}, {0, 1}}));
    CHECK(check(crossed).status == Status::cage_self_crossing);
    const Cage unmatched(
        Polygon<double>(std::vector<Vec<double, 2>>{{0, 0}, {1, 1}, {1, 0}}, std::vector<std::size_t>{4}));
    CHECK(check(unmatched).status == Status::loops_do_not_match);
}

TEST_CASE("A cusp of an edge is a warning", "[coordinates][curved_green][check]") {
    const auto cusp = report_of({{{{0, 0}, {2, 2}, {0, 2}, {2, 0}}, {{2, 0}, {0, 0}}}});
    check_first_fault(cusp, Status::ok, CageFaultKind::edge_has_cusp, 0, 500);
    CHECK(cusp.faults.size() == 2);
    CHECK(cusp.faults[1].kind == CageFaultKind::loop_orientation_reversed);
    // Outside, in front of the cusp, weights are huge or undefined. If the edge is split at the cusp, weights
    // are small.
    const detail::PlaneCurve whole{3, {{{0, 0}, {2, 2}, {0, 2}, {2, 0}}}};
    const auto [low, high] = whole.halves();
    const auto edge_of = [](const detail::PlaneCurve& curve) {
        return std::vector<Vec<double, 2>>(curve.control.begin(), curve.control.end());
    };
    const CurvedGreenCoordinates<double> undivided(
        CurvedPolygon<double>({{edge_of(whole), {{2, 0}, {0, 0}}}}));
    const CurvedGreenCoordinates<double> divided(
        CurvedPolygon<double>({{edge_of(low), edge_of(high), {{2, 0}, {0, 0}}}}));
    std::vector<double> huge(undivided.handles().size()), row(divided.handles().size());
    for (const Vec<double, 2>& p : {Vec<double, 2>{1, 1.6}, Vec<double, 2>{1.001, 1.8}}) {
        const auto state = weights_at(undivided, p, huge);
        double largest = 0, largest_divided = 0;
        for (const double w : huge) largest = larger(largest, std::fabs(w));
        CHECK((state == PointState::unreached || largest > 100));
        CHECK(weights_at(divided, p, row) == PointState::outside);
        for (const double w : row) largest_divided = larger(largest_divided, std::fabs(w));
        CHECK(largest_divided < 10);
        CHECK(distance(combine(row, divided.handles()), p) <= 1e-13);
    }
}

TEST_CASE("Faults of the options of curved cages are named", "[coordinates][curved_green][check]") {
    using Kind = CageFaultKind;
    const auto& leaf = two_parabolas;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CurvedGreenOptions<double> options;
    options.posed_degree = 6;
    check_first_fault(report_of({leaf}, options), Status::curve_degree_not_supported, Kind::curve_degree, 0,
                      6);
    options.posed_degrees = {2, 1};
    check_first_fault(report_of({leaf}, options), Status::curve_degree_not_supported, Kind::curve_degree, 1,
                      1);
    options.posed_degrees = {2, 2, 2};
    check_first_fault(report_of({leaf}, options), Status::curve_degree_not_supported, Kind::curve_degree, 3,
                      0);
    options.posed_degrees = {2, 3};
    CHECK(report_of({leaf}, options).status == Status::ok);
    options.disk = CurvedGreenDisk<double>{{1, 0}, 1};
    CHECK(report_of({leaf}, options).status == Status::ok);
    options.disk = CurvedGreenDisk<double>{{1, 0.1}, 1};
    check_first_fault(report_of({leaf}, options), Status::disk_too_small, Kind::disk_too_small, 0, 0);
    options.disk = CurvedGreenDisk<double>{{1, nan}, 9};
    check_first_fault(report_of({leaf}, options), Status::disk_too_small, Kind::disk_too_small, 0, 0);
}

TEST_CASE("Legs without length at rest do not count as collapsed", "[coordinates][curved_green][pose]") {
    const CurvedGreenCoordinates<double> leaf(
        CurvedPolygon<double>({{{{0, 0}, {0, 0}, {2, -1}, {3, 0}}, {{3, 0}, {2, 2}, {0, 0}, {0, 0}}}}));
    const auto bound = bind(leaf, std::vector<Vec<double, 2>>{{1.5, 0.25}});
    REQUIRE(bound.report.status == Status::ok);
    std::vector<Vec<double, 2>> pose(leaf.handles().begin(), leaf.handles().begin() + 6), handles(12);
    PoseReport report = pose_handles(bound.value, pose, handles);
    CHECK(report.status == Status::ok);
    CHECK(report.collapsed_faces == 0);
    pose[4] = pose[3];
    report = pose_handles(bound.value, pose, handles);
    CHECK(report.collapsed_faces == 1);
    CHECK(report.first_collapsed == 6 + 3);
    pose[1] = {0.5, 0.5}; // the tangent is not zero any more
    report = pose_handles(bound.value, pose, handles);
    CHECK(report.status == Status::ok);
    CHECK(handles[6] == cageform::detail::edge_handle(pose[0], pose[1]));
}

} // namespace curved_green_tests
