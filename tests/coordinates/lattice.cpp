// Lattices of splines: reference values, the laws of free-form deformation, named faults.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/gradients.hpp"
#include "../support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/lattice.hpp>
#include <cageform/coordinates/lattice/refine.hpp>

#include <nlohmann/json.hpp>

#include <fstream>
#include <random>

namespace lattice_tests {

using namespace cageform_tests;
using cageform::LatticeAxis;
using cageform::LatticeCoordinates;
using cageform::PointState;
using cageform::Status;
using cageform::Transform;
using cageform::Vec;

namespace {

static_assert(cageform::CageCoordinates<LatticeCoordinates<float, 2>>);
static_assert(cageform::CageCoordinates<LatticeCoordinates<double, 3>>);

std::vector<double> numbers(const nlohmann::json& list) {
    std::vector<double> result;
    for (const auto& x : list)
        result.push_back(x.is_string() ? std::stod(x.get<std::string>()) : x.get<double>());
    return result;
}
template <std::size_t D>
Vec<double, D> vec_of(const nlohmann::json& list) {
    const auto all = numbers(list);
    Vec<double, D> v{};
    for (std::size_t k = 0; k < D; ++k) v[k] = all[k];
    return v;
}
template <class T, std::size_t D>
LatticeCoordinates<T, D> lattice_of(const nlohmann::json& json) {
    std::array<LatticeAxis, D> axes;
    Transform<T, D> box{};
    for (std::size_t k = 0; k < D; ++k) {
        axes[k] = {json["axes"][k]["points"], json["axes"][k]["degree"], {}};
        box.columns[k] = vec_cast<T>(vec_of<D>(json["frame_columns"][k]));
    }
    box.translation = vec_cast<T>(vec_of<D>(json["origin"]));
    return LatticeCoordinates<T, D>(axes, box, T(json["falloff"].get<double>()));
}

/// A random lattice with any number of points, degrees, knots and axes.
template <class T, std::size_t D>
struct RandomLattice {
    std::mt19937_64 random;
    std::array<LatticeAxis, D> axes;
    Transform<T, D> box{};
    T falloff = 0;

    explicit RandomLattice(int seed)
        : random(std::uint64_t(seed)) {
        for (std::size_t k = 0; k < D; ++k) {
            auto& axis = axes[k];
            axis.degree = 1 + random() % 3;
            axis.points = axis.degree + 1 + random() % 4;
            if (random() % 4 == 0) axis = {2 + random() % 6, 63, {}}; // Bernstein
            const std::size_t degree = std::min(axis.degree, axis.points - 1);
            if (random() % 3 == 0) {
                axis.knots.assign(degree + 1, 0.0);
                for (std::size_t n = degree + 1; n < axis.points; ++n)
                    axis.knots.push_back(uniform(0.05, 0.95));
                std::sort(axis.knots.begin(), axis.knots.end());
                axis.knots.insert(axis.knots.end(), degree + 1, 1.0);
            }
            for (std::size_t a = 0; a < D; ++a)
                box.columns[k][a] = T(uniform(-0.4, 0.4) + (a == k ? 2.0 : 0.0));
            box.translation[k] = T(uniform(-3, 3));
        }
        if (seed % 2 == 0) falloff = T(uniform(0.2, 2));
    }
    double uniform(double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; }
    LatticeCoordinates<T, D> lattice() const { return LatticeCoordinates<T, D>(axes, box, falloff); }
    /// The point o + A u.
    Vec<T, D> place(double low, double high) {
        Vec<T, D> u;
        for (std::size_t k = 0; k < D; ++k) u[k] = T(uniform(low, high));
        return box.translation + box.map_vector(u);
    }
};

template <class T, std::size_t D>
void compare_with_reference(const std::string& name) {
    CAPTURE(name);
    std::ifstream file(std::string(CAGEFORM_TEST_DATA) + "/lattice/" + name + ".json");
    const auto json = nlohmann::json::parse(file);
    const auto lattice = lattice_of<T, D>(json);
    REQUIRE(lattice.cage_report().status == Status::ok);
    std::vector<Vec<double, D>> handles;
    for (const char* list : {"handles", "still_handles"}) {
        for (const auto& handle : json[list]) handles.push_back(vec_of<D>(handle));
    }
    REQUIRE(handles.size() == lattice.handles().size());
    CHECK(lattice.frame_handles() == json["still_handles"].size());
    const double rounding = std::is_same_v<T, float> ? 1e-6 : 1e-15;
    for (std::size_t i = 0; i < handles.size(); ++i) {
        for (std::size_t k = 0; k < D; ++k)
            CHECK(std::fabs(double(lattice.handles()[i][k]) - handles[i][k]) <= 4 * rounding);
    }
    std::vector<Vec<T, D>> points;
    for (const auto& row : json["rows"]) points.push_back(vec_cast<T>(vec_of<D>(row["point"])));
    const auto found = evaluate_all(lattice, points);
    REQUIRE(found.status() == Status::ok);
    for (std::size_t n = 0; n < points.size(); ++n) {
        const auto& row = json["rows"][n];
        CAPTURE(n);
        const bool is_faded = row.contains("falloff_weights");
        const auto expected = numbers(row[is_faded ? "falloff_weights" : "weights"]);
        double largest = 1;
        for (const double w : expected) largest = std::max(largest, std::fabs(w));
        for (std::size_t i = 0; i < expected.size(); ++i)
            CHECK(std::fabs(double(found.rows[n][i]) - expected[i]) <= 8 * rounding * largest);
        const auto state = row["state"].get<std::string>();
        CHECK(found.states[n] == (state == "inside"    ? PointState::inside
                                  : state == "outside" ? PointState::outside
                                                       : PointState::on_boundary));
        if (row.contains("nearest_weights")) {
            std::vector<T> at_nearest(handles.size());
            const auto nearest = lattice.nearest_boundary(points[n], at_nearest);
            const auto place = vec_of<D>(row["nearest"]);
            for (std::size_t k = 0; k < D; ++k)
                CHECK(std::fabs(double(nearest[k]) - place[k]) <= 32 * rounding);
            const auto weights = numbers(row["nearest_weights"]);
            for (std::size_t i = 0; i < weights.size(); ++i)
                CHECK(std::fabs(double(at_nearest[i]) - weights[i]) <= 32 * rounding);
        }
        if (!row.contains("gradients") || is_faded) continue;
        const auto gradients = gradients_of<T, D>(lattice, {points[n]}).rows[0];
        for (std::size_t axis = 0; axis < D; ++axis) {
            const auto known = numbers(row["gradients"][axis]);
            for (std::size_t i = 0; i < known.size(); ++i) {
                double size = 1;
                for (const double x : known) size = std::max(size, std::fabs(x));
                CHECK(std::fabs(double(gradients[i][axis]) - known[i]) <= 16 * rounding * size);
            }
        }
    }
}

} // namespace

TEST_CASE("lattices have the weights, slopes and places of the reference", "[coordinates][lattice][oracle]") {
    for (const char* name : {"lattice_bernstein_2d", "lattice_cubic_2d_turned"}) {
        compare_with_reference<double, 2>(name);
        compare_with_reference<float, 2>(name);
    }
    for (const char* name : {"lattice_box_3d", "lattice_quadratic_3d"}) {
        compare_with_reference<double, 3>(name);
        compare_with_reference<float, 3>(name);
    }
}

TEMPLATE_TEST_CASE("weights of a lattice do not depend on its size, bitwise",
                   "[coordinates][lattice][property]", float, double) {
    using T = TestType;
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    constexpr int most = sizeof(T) == 8 ? 900 : 60; // keeps small slopes normal numbers
    for (const int exponent : {-most, -most / 2, most / 2, most}) {
        CAPTURE(exponent);
        const auto scaled = [&](auto x) {
            for (auto& number : x.v) number = std::ldexp(number, exponent);
            return x;
        };
        RandomLattice<T, 3> given(seed);
        const auto lattice = given.lattice();
        std::vector<Vec<T, 3>> points, large;
        for (int n = 0; n < 20; ++n) points.push_back(given.place(-1, 2));
        for (const auto& p : points) large.push_back(scaled(p));
        for (auto& column : given.box.columns) column = scaled(column);
        given.box.translation = scaled(given.box.translation);
        given.falloff = std::ldexp(given.falloff, exponent);
        const auto other = given.lattice();
        REQUIRE(other.cage_report().status == Status::ok);
        const auto found = evaluate_all(lattice, points), same = evaluate_all(other, large);
        CHECK(found.states == same.states);
        CHECK(found.rows == same.rows);
        auto gradients = gradients_of<T, 3>(lattice, points).rows;
        for (auto& row : gradients) {
            for (auto& slope : row) {
                for (auto& x : slope.v) x = std::ldexp(x, -exponent);
            }
        }
        CHECK(gradients == gradients_of<T, 3>(other, large).rows);
        std::vector<T> row(lattice.handles().size()), of_large(row.size());
        for (std::size_t n = 0; n < points.size(); ++n) {
            CHECK(scaled(lattice.nearest_boundary(points[n], row)) ==
                  other.nearest_boundary(large[n], of_large));
            CHECK(row == of_large);
        }
    }
}

TEMPLATE_TEST_CASE("points too far from a lattice are unreached", "[coordinates][lattice]", float, double) {
    using T = TestType;
    const Transform<T, 3> box{{Vec<T, 3>{1, 0, 0}, Vec<T, 3>{0, 1, 0}, Vec<T, 3>{0, 0, 1}}, {0, 0, 0}};
    const LatticeCoordinates<T, 3> lattice({LatticeAxis{}, LatticeAxis{}, LatticeAxis{}}, box);
    constexpr T farthest = sizeof(T) == 8 ? T(1e15) : T(1e6);
    const T beyond = std::nextafter(farthest, 2 * farthest);
    CHECK(beyond - farthest <= T(0.125));
    const auto found = evaluate_all(
        lattice,
        std::vector<Vec<T, 3>>{{farthest, -farthest, farthest}, {0, beyond, 0}, {T(0.5), 0, -beyond}});
    CHECK(found.states == std::vector{PointState::outside, PointState::unreached, PointState::unreached});
    for (const T weight : found.rows[0]) CHECK(std::isfinite(weight));
}

TEMPLATE_TEST_CASE("weights of a lattice are a mean of its handles, at the point, anywhere",
                   "[coordinates][lattice][property]", float, double) {
    using T = TestType;
    const int seed = GENERATE(seeds(40));
    CAPTURE(seed);
    const auto check = [&]<std::size_t D>(RandomLattice<T, D> any) {
        const auto lattice = any.lattice();
        REQUIRE(lattice.cage_report().status == Status::ok);
        std::vector<Vec<T, D>> points;
        for (int n = 0; n < 20; ++n) points.push_back(any.place(0, 1));
        for (int n = 0; n < 20; ++n) points.push_back(any.place(-0.7, 1.7));
        const auto found = evaluate_all(lattice, points);
        REQUIRE(found.status() == Status::ok);
        for (std::size_t n = 0; n < points.size(); ++n) {
            double sum = 0, size = 1;
            Vec<double, D> mean{};
            for (std::size_t i = 0; i < lattice.handles().size(); ++i) {
                const auto w = double(found.rows[n][i]);
                if (found.states[n] != PointState::outside) CHECK(w >= 0);
                sum += w;
                size += std::fabs(w);
                mean = mean + w * vec_cast<double>(lattice.handles()[i]);
            }
            const double rounding = 32 * double(cageform::epsilon<T>) * size;
            CHECK(std::fabs(sum - 1) <= rounding);
            for (std::size_t k = 0; k < D; ++k)
                CHECK(std::fabs(mean[k] - double(points[n][k])) <= 8 * rounding);
        }
    };
    check(RandomLattice<T, 2>(seed));
    check(RandomLattice<T, 3>(seed));
}

TEST_CASE("gradients of a lattice are those of its weights, faded or not",
          "[coordinates][lattice][property]") {
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    const auto check = [&]<std::size_t D>(RandomLattice<double, D> any) {
        const auto lattice = any.lattice();
        for (int n = 0; n < 10; ++n) {
            const auto p = any.place(-0.4, 1.4);
            const auto gradients = gradients_of<double, D>(lattice, {p}).rows[0];
            Vec<double, D> sum{};
            for (std::size_t axis = 0; axis < D; ++axis) {
                constexpr double step = 1e-6;
                auto above = p, below = p;
                above[axis] += step;
                below[axis] -= step;
                const auto rows = evaluate_all(lattice, std::vector{below, above}).rows;
                for (std::size_t i = 0; i < lattice.handles().size(); ++i) {
                    const double difference = (rows[1][i] - rows[0][i]) / (2 * step);
                    // A knot of degree 1 within the step has two slopes: half their difference is allowed.
                    bool is_smooth = true;
                    for (const auto& a : any.axes) is_smooth = is_smooth && a.degree > 1;
                    if (is_smooth)
                        CHECK(std::fabs(gradients[i][axis] - difference) <=
                              1e-5 * (1 + std::fabs(difference)));
                    sum[axis] += gradients[i][axis];
                }
            }
            for (std::size_t k = 0; k < D; ++k) CHECK(std::fabs(sum[k]) <= 1e-11);
        }
    };
    check(RandomLattice<double, 2>(seed));
    check(RandomLattice<double, 3>(seed));
}

TEST_CASE("displacements are smooth across faces of the box and in the falloff",
          "[coordinates][lattice][property]") {
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    RandomLattice<double, 3> any(2 * seed);
    for (auto& axis : any.axes) axis = {axis.points + 3, 3, {}};
    const auto lattice = any.lattice();
    std::vector<Vec<double, 3>> pose(lattice.handles().begin(), lattice.handles().end());
    for (std::size_t i = 0; i + lattice.frame_handles() < pose.size(); ++i) {
        for (double& x : pose[i].v) x += any.uniform(-0.3, 0.3);
    }
    const auto moved = [&](const Vec<double, 3>& p) {
        const auto row = evaluate_all(lattice, std::vector{p}).rows[0];
        Vec<double, 3> q{};
        for (std::size_t i = 0; i < row.size(); ++i) q = q + row[i] * pose[i];
        return q;
    };
    const auto values_agree = [&](const Vec<double, 3>& at, const Vec<double, 3>& way) {
        constexpr double h = 1e-6;
        const auto a = moved(at - (2 * h) * way), b = moved(at - h * way), c = moved(at + h * way),
                   d = moved(at + (2 * h) * way);
        for (std::size_t k = 0; k < 3; ++k) {
            CHECK(std::fabs(c[k] - b[k]) <= 1e-4);
            CHECK(std::fabs((d[k] - c[k]) - (b[k] - a[k])) / h <= 1e-3);
        }
    };
    Vec<double, 3> u{any.uniform(0.1, 0.9), any.uniform(0.1, 0.9), 1};
    const auto face = any.box.translation + any.box.map_vector(u);
    values_agree(face, any.box.columns[2]);
    // At the end of the falloff the figure is at rest.
    const auto& across = any.box.columns[2];
    const double length = std::sqrt(dot(across, across));
    const auto end = face + (any.falloff / length) * across;
    values_agree(end, across);
    const auto beyond = moved(end + 0.1 * across);
    for (std::size_t k = 0; k < 3; ++k) CHECK(std::fabs(beyond[k] - (end + 0.1 * across)[k]) <= 1e-12);
}

TEST_CASE("frozen layers keep outside points in place, smoothly", "[coordinates][lattice]") {
    const LatticeCoordinates<double, 2> lattice({LatticeAxis{7, 3, {}}, LatticeAxis{7, 3, {}}},
                                                {{Vec<double, 2>{1, 0}, Vec<double, 2>{0, 1}}, {0, 0}});
    const auto frozen = lattice.frozen_handles(2);
    CHECK(frozen.size() == 49 - 9);
    std::vector<Vec<double, 2>> pose(lattice.handles().begin(), lattice.handles().end());
    std::mt19937_64 random(5);
    for (std::uint32_t i = 0; i < pose.size(); ++i) {
        if (!std::binary_search(frozen.begin(), frozen.end(), i))
            pose[i] = pose[i] + Vec<double, 2>{double(random() % 100) / 500, double(random() % 100) / 500};
    }
    // Displacements are of order two: a tenth of the distance from the face gives a hundredth.
    const auto displacement = [&](double distance) {
        const auto row = evaluate_all(lattice, std::vector{Vec<double, 2>{distance, 0.4}}).rows[0];
        Vec<double, 2> q{-distance, -0.4};
        for (std::size_t i = 0; i < row.size(); ++i) q = q + row[i] * pose[i];
        return std::sqrt(dot(q, q));
    };
    CHECK(displacement(1e-3) > 0);
    CHECK(displacement(1e-4) <= 0.0101 * displacement(1e-3));
}

TEST_CASE("a lattice of two points a side is trilinear, a figure is bound, posed and stays affine",
          "[coordinates][lattice][binding]") {
    const Transform<float, 3> box{{Vec<float, 3>{2, 0, 0}, Vec<float, 3>{0, 2, 0}, Vec<float, 3>{0, 0, 2}},
                                  {-1, -1, -1}};
    const LatticeCoordinates<float, 3> two({LatticeAxis{2}, LatticeAxis{2}, LatticeAxis{2}}, box);
    CHECK(two.handles().size() == 8);
    const auto corner = evaluate_all(two, std::vector{Vec<float, 3>{1, 1, 1}, Vec<float, 3>{0.5f, 0, -0.5f}});
    CHECK(corner.rows[0] == std::vector<float>{0, 0, 0, 0, 0, 0, 0, 1});
    CHECK(corner.states[0] == PointState::on_boundary);
    for (std::size_t i = 0; i < 8; ++i) {
        const float x = i % 2 != 0 ? 0.75f : 0.25f, z = i / 4 != 0 ? 0.25f : 0.75f;
        CHECK(corner.rows[1][i] == x * 0.5f * z);
    }
    const LatticeCoordinates<float, 3> lattice({LatticeAxis{5}, LatticeAxis{4, 2, {}}, LatticeAxis{6, 9, {}}},
                                               box);
    std::vector<Vec<float, 3>> figure;
    std::mt19937_64 random(3);
    for (int n = 0; n < 500; ++n) {
        Vec<float, 3> p;
        for (float& x : p.v) x = float(double(random() % 3000) / 1000 - 1.5);
        figure.push_back(p);
    }
    const auto bound = cageform::bind(lattice, figure);
    REQUIRE(bound);
    std::vector<Vec<float, 3>> pose, out(figure.size());
    const auto affine = [](const Vec<float, 3>& p) {
        return Vec<float, 3>{2 * p[0] + p[1] - 1, 0.5f * p[1] - p[2], p[0] + p[2] + 3};
    };
    for (const auto& h : lattice.handles()) pose.push_back(affine(h));
    REQUIRE(cageform::clone(bound.value.view(), pose, out) == Status::ok);
    for (std::size_t n = 0; n < figure.size(); ++n) {
        for (std::size_t k = 0; k < 3; ++k) CHECK(std::fabs(out[n][k] - affine(figure[n])[k]) <= 2e-5f);
    }
}

TEST_CASE("refined axes have the control points of the reference", "[coordinates][lattice][oracle]") {
    std::ifstream file(std::string(CAGEFORM_TEST_DATA) + "/lattice/refinement.json");
    const auto json = nlohmann::json::parse(file);
    for (const auto& table : json["tables"]) {
        CAPTURE(table["how"], table["degree"], table["points"]);
        const LatticeAxis axis{table["points"], table["degree"], numbers(table["knots"])};
        const auto how = table["how"].get<std::string>();
        const auto knots = numbers(table["new_knots"]);
        const auto differ = std::mismatch(axis.knots.begin(), axis.knots.end(), knots.begin());
        const double inserted = *differ.second;
        const auto refined = how == "degree"  ? cageform::raise_degree(axis)
                             : how == "halve" ? cageform::halve_spans(axis)
                                              : cageform::insert_knot(axis, inserted);
        REQUIRE(refined);
        CHECK(refined.value.axis.points == table["new_points"]);
        CHECK(refined.value.axis.degree == table["new_degree"]);
        REQUIRE(knots.size() == refined.value.axis.knots.size());
        for (std::size_t n = 0; n < knots.size(); ++n)
            CHECK(std::fabs(refined.value.axis.knots[n] - knots[n]) <= 1e-15);
        for (std::size_t r = 0; r < refined.value.axis.points; ++r) {
            const auto row = numbers(table["matrix"][r]);
            for (std::size_t i = 0; i < row.size(); ++i)
                CHECK(std::fabs(refined.value.row(r)[i] - row[i]) <= 1e-15);
        }
    }
}

TEST_CASE("a refined lattice deforms as before", "[coordinates][lattice][property]") {
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    RandomLattice<double, 3> any(seed);
    const auto coarse = any.lattice();
    std::vector<Vec<double, 3>> pose(coarse.handles().begin(), coarse.handles().end());
    for (std::size_t i = 0; i + coarse.frame_handles() < pose.size(); ++i) {
        for (double& x : pose[i].v) x += any.uniform(-0.5, 0.5);
    }
    const std::size_t axis = any.random() % 3;
    const auto& old = any.axes[axis];
    const bool is_bernstein = old.points <= old.degree + 1 && old.knots.empty();
    const auto refined = is_bernstein       ? cageform::raise_degree(old)
                         : any.random() % 2 ? cageform::halve_spans(old)
                                            : cageform::insert_knot(old, any.uniform(0.1, 0.9));
    REQUIRE(refined);
    const std::array<std::size_t, 3> counts{coarse.points(0), coarse.points(1), coarse.points(2)};
    any.axes[axis] = refined.value.axis;
    const auto fine = any.lattice();
    REQUIRE(fine.cage_report().status == Status::ok);
    const auto rest = cageform::refined_points(coarse.handles(), counts, axis, refined.value);
    const auto posed =
        cageform::refined_points(std::span<const Vec<double, 3>>(pose), counts, axis, refined.value);
    REQUIRE(rest.size() == fine.handles().size());
    for (std::size_t i = 0; i < rest.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) CHECK(std::fabs(rest[i][k] - fine.handles()[i][k]) <= 1e-14);
    }
    std::vector<Vec<double, 3>> points;
    for (int n = 0; n < 20; ++n) points.push_back(any.place(n < 10 ? 0 : -0.5, n < 10 ? 1 : 1.5));
    const auto before = evaluate_all(coarse, points).rows, after = evaluate_all(fine, points).rows;
    for (std::size_t n = 0; n < points.size(); ++n) {
        Vec<double, 3> p{}, q{};
        double size = 1;
        for (std::size_t i = 0; i < pose.size(); ++i) p = p + before[n][i] * pose[i];
        for (std::size_t i = 0; i < posed.size(); ++i) {
            q = q + after[n][i] * posed[i];
            size += std::fabs(after[n][i]);
        }
        for (std::size_t k = 0; k < 3; ++k) CHECK(std::fabs(p[k] - q[k]) <= 1e-14 * size * 4);
    }
}

TEST_CASE("invalid lattices are refused with their own status", "[coordinates][lattice][faults]") {
    const Transform<double, 2> box{{Vec<double, 2>{1, 0}, Vec<double, 2>{0, 1}}, {0, 0}};
    const auto report = [&](const LatticeAxis& axis, const Transform<double, 2>& in, double falloff = 0) {
        return LatticeCoordinates<double, 2>({LatticeAxis{}, axis}, in, falloff).cage_report();
    };
    const auto first = [&](const auto& of) { return of.faults.at(0); };
    for (const LatticeAxis& axis : {LatticeAxis{0}, LatticeAxis{1}, LatticeAxis{4, 0, {}},
                                    LatticeAxis{6, 4, {}}, LatticeAxis{65, 64, {}}}) {
        CHECK(report(axis, box).status == Status::lattice_degree_not_supported);
        CHECK(first(report(axis, box)).a == 1);
    }
    for (const auto& knots : std::vector<std::vector<double>>{{0, 0, 0.5, 1},
                                                              {0, 0, 0.6, 0.4, 1, 1},
                                                              {0, 0, 0.5, 0.5, 1, 1},
                                                              {0, 0.1, 0.4, 0.6, 1, 1},
                                                              {0, 0, 0.4, 0.6, 1, 2},
                                                              {0, 0, 0, 0.6, 1, 1},
                                                              {0, 0, 1e-60, 0.6, 1, 1},
                                                              {0, 0, std::nan(""), 0.6, 1, 1}}) {
        CAPTURE(knots);
        CHECK(report({4, 1, knots}, box).status == Status::lattice_knots_not_supported);
    }
    CHECK(report({4, 1, {0, 0, 0.4, 0.6, 1, 1}}, box).status == Status::ok);
    CHECK(report({5, 2, {0, 0, 0, 0.5, 0.5, 1, 1, 1}}, box).status == Status::ok);
    CHECK(report({}, {{Vec<double, 2>{1, 0}, Vec<double, 2>{2, 0}}, {0, 0}}).status == Status::frame_flat);
    CHECK(report({}, {{Vec<double, 2>{1, 0}, Vec<double, 2>{0, 0}}, {0, 0}}).status == Status::frame_flat);
    const auto infinite = report({}, {{Vec<double, 2>{1, 0}, Vec<double, 2>{0, HUGE_VAL}}, {0, 0}});
    CHECK(infinite.status == Status::vertex_not_finite);
    CHECK(first(infinite).a == 1);
    // The far corner overflows.
    const auto large = report({}, {{Vec<double, 2>{1e308, 0}, Vec<double, 2>{0, 1e308}}, {1e308, 0}});
    CHECK(large.status == Status::vertex_not_finite);
    CHECK(first(large).a == 2);
    // The reciprocal of the side overflows.
    const double least = 4e-324;
    CHECK(report({}, {{Vec<double, 2>{least, 0}, Vec<double, 2>{0, least}}, {0, 0}}).status ==
          Status::frame_flat);
    for (const double falloff : {-1.0, std::nan(""), HUGE_VAL})
        CHECK(report({}, box, falloff).status == Status::falloff_negative);
    const LatticeCoordinates<double, 3> huge(
        {LatticeAxis{1000}, LatticeAxis{1000}, LatticeAxis{1000}},
        {{Vec<double, 3>{1, 0, 0}, Vec<double, 3>{0, 1, 0}, Vec<double, 3>{0, 0, 1}}, {0, 0, 0}});
    CHECK(huge.cage_report().status == Status::too_many_handles);

    const LatticeCoordinates<double, 2> lattice({LatticeAxis{}, LatticeAxis{}}, box);
    const auto found =
        evaluate_all(lattice, std::vector<Vec<double, 2>>{{std::nan(""), 0}, {1e16, 0}, {0.5, 0.5}});
    CHECK(found.states == std::vector{PointState::not_finite, PointState::unreached, PointState::inside});
}

TEST_CASE("slopes of a lattice are finite where the square of a falloff is not above zero",
          "[coordinates][lattice]") {
    constexpr float size = 1e-25f;
    const LatticeCoordinates<float, 2> lattice(
        {LatticeAxis{}, LatticeAxis{}}, {{Vec<float, 2>{size, 0}, Vec<float, 2>{0, size}}, {0, 0}}, size);
    REQUIRE(lattice.cage_report().status == Status::ok);
    const std::size_t rows = 2 * lattice.handles().size();
    std::vector<cageform::Lanes<float>> place(2), slopes(rows);
    for (auto& x : place) x = {};
    place[0][0] = 1.5f * size;
    place[1][0] = 0.5f * size;
    std::vector<PointState> states(1, PointState::inside);
    (void)lattice.evaluate_gradients({place.data(), 2, 1}, {slopes.data(), rows, 1}, states);
    CHECK(states[0] == PointState::outside);
    for (const auto& slope : slopes) CHECK(std::isfinite(slope[0]));
}

TEST_CASE("a box around a figure has a margin on all sides, also for flat figures",
          "[coordinates][lattice]") {
    const auto box = cageform::box_around(std::vector<Vec<double, 3>>{{0, 1, 5}, {3, 5, 5}}, 0.1);
    REQUIRE(box);
    CHECK(box.value.translation[2] < 5 - 0.5);
    CHECK(box.value.columns[2][2] > 1);
    CHECK(std::fabs(box.value.columns[0][0] - 4) <= 1e-12);
    using Points = std::vector<Vec<float, 2>>;
    CHECK(cageform::box_around(Points{{1, 1}, {1, 1}}).status() == Status::figure_has_no_size);
    CHECK(cageform::box_around(Points{}).status() == Status::figure_empty);
    CHECK(cageform::box_around(Points{{1, std::nanf("")}}).status() == Status::figure_not_finite);
    CHECK(cageform::box_around(Points{{-3e38f, 0}, {3e38f, 1}}).status() == Status::figure_not_finite);
    CHECK(cageform::box_around(Points{{0, 0}, {1, 1}}, std::nan("")).status() == Status::value_not_finite);
    const auto flat = cageform::box_around(Points{{0, 0}, {1, 0}}, 0.0);
    REQUIRE(flat);
    CHECK(LatticeCoordinates<float, 2>({LatticeAxis{}, LatticeAxis{}}, flat.value).cage_report().status ==
          Status::ok);
}

} // namespace lattice_tests
