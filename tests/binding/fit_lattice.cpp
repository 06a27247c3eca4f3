// fit_lattice: reference values, round trips and invalid input.
#include "../catch.hpp"
#include "../support/effort.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/fit_lattice.hpp>
#include <cageform/clone/clone.hpp>

#include <nlohmann/json.hpp>

#include <fstream>
#include <random>

namespace fit_lattice_tests {

using namespace cageform_tests;
using cageform::LatticeAxis;
using cageform::LatticeCoordinates;
using cageform::LatticeFitOptions;
using cageform::Status;
using cageform::Transform;
using cageform::Vec;

namespace {

double number(const nlohmann::json& x) {
    return x.is_string() ? std::stod(x.get<std::string>()) : x.get<double>();
}
Vec<double, 2> pair(const nlohmann::json& list) {
    return {number(list[0]), number(list[1])};
}

/// A figure of random points in a random lattice, bound.
template <class T, std::size_t D>
struct RandomFigure {
    std::mt19937_64 random;
    LatticeCoordinates<T, D> lattice;
    std::vector<Vec<T, D>> points;
    cageform::Binding<T, D> binding;

    RandomFigure(int seed, std::size_t count, T falloff = 0)
        : random(std::uint64_t(seed))
        , lattice(axes(), box(), falloff) {
        for (std::size_t n = 0; n < count; ++n) {
            Vec<T, D> u;
            for (T& x : u.v) x = T(uniform(0, 1));
            points.push_back(lattice.box().translation + lattice.box().map_vector(u));
        }
        bind();
    }
    void bind() {
        auto bound = cageform::bind(lattice, points);
        REQUIRE(bound);
        binding = std::move(bound.value);
    }
    double uniform(double low, double high) { return low + (high - low) * double(random() >> 11) * 0x1p-53; }
    std::array<LatticeAxis, D> axes() {
        std::array<LatticeAxis, D> axes;
        for (auto& axis : axes) {
            axis.degree = 1 + random() % 3;
            axis.points = axis.degree + 1 + random() % 2;
        }
        return axes;
    }
    Transform<T, D> box() {
        Transform<T, D> box;
        for (std::size_t k = 0; k < D; ++k) {
            for (std::size_t a = 0; a < D; ++a)
                box.columns[k][a] = T(uniform(-0.4, 0.4) + (a == k ? 2.0 : 0.0));
            box.translation[k] = T(uniform(-3, 3));
        }
        return box;
    }
    std::vector<Vec<T, D>> random_pose() {
        std::vector<Vec<T, D>> pose(lattice.handles().begin(), lattice.handles().end());
        for (std::size_t i = 0; i + lattice.frame_handles() < pose.size(); ++i) {
            for (T& x : pose[i].v) x += T(uniform(-0.3, 0.3));
        }
        return pose;
    }
    std::vector<Vec<T, D>> moved(const std::vector<Vec<T, D>>& pose) const {
        std::vector<Vec<T, D>> out(points.size());
        REQUIRE(cageform::clone(binding, pose, out) == Status::ok);
        return out;
    }
    std::vector<Vec<T, D>> displacements(const std::vector<Vec<T, D>>& pose) const {
        auto list = moved(pose);
        for (std::size_t j = 0; j < list.size(); ++j) list[j] = list[j] - points[j];
        return list;
    }
};

template <class T, std::size_t D>
double farthest_apart(const std::vector<Vec<T, D>>& a, const std::vector<Vec<T, D>>& b) {
    double farthest = a.size() == b.size() ? 0 : HUGE_VAL;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        for (std::size_t k = 0; k < D; ++k)
            farthest = std::max(farthest, std::fabs(double(a[i][k]) - double(b[i][k])));
    }
    return farthest;
}

} // namespace

TEST_CASE("fitted lattices have the handles and residuals of the reference", "[binding][lattice][oracle]") {
    std::ifstream file(std::string(CAGEFORM_TEST_DATA) + "/lattice/fit.json");
    const auto json = nlohmann::json::parse(file);
    REQUIRE(json["cases"].size() == 3);
    for (const auto& each : json["cases"]) {
        CAPTURE(each["smoothness"], each["axes"]);
        std::array<LatticeAxis, 2> axes;
        Transform<double, 2> box{};
        for (std::size_t k = 0; k < 2; ++k) {
            axes[k] = {each["axes"][k]["points"], each["axes"][k]["degree"], {}};
            box.columns[k] = pair(each["frame_columns"][k]);
        }
        box.translation = pair(each["origin"]);
        const LatticeCoordinates<double, 2> lattice(axes, box);
        std::vector<Vec<double, 2>> points, displacements;
        for (const auto& p : each["points"]) points.push_back(pair(p));
        for (const auto& d : each["displacements"]) displacements.push_back(pair(d));
        const auto weights = each["point_weights"].get<std::vector<double>>();
        const auto frozen = each["frozen"].get<std::vector<std::uint32_t>>();
        CHECK(frozen == lattice.frozen_handles(each["frozen_layers"].get<std::size_t>()));
        const auto bound = cageform::bind(lattice, points);
        REQUIRE(bound);
        const auto fit = cageform::fit_lattice(
            lattice, bound.value, displacements,
            {.smoothness = number(each["smoothness"]), .point_weights = weights, .frozen = frozen});
        REQUIRE(fit);
        for (std::size_t i = 0; i < fit.value.size(); ++i) {
            const auto known = pair(each["handle_displacements"][i]);
            for (std::size_t k = 0; k < 2; ++k)
                CHECK(std::fabs(fit.value[i][k] - lattice.handles()[i][k] - known[k]) <= 1e-10);
        }
        CHECK(std::fabs(fit.report.rms - number(each["rms_residual"])) <= 1e-12);
        CHECK(std::fabs(fit.report.largest - number(each["largest_residual"])) <= 1e-12);
        CHECK(fit.report.idle.empty());
        CHECK(fit.report.pivot_ratio > 0);
        CHECK(fit.report.pivot_ratio <= 1);
    }
}

TEMPLATE_TEST_CASE("fitting the displacements of a pose returns the pose", "[binding][lattice][property]",
                   float, double) {
    using T = TestType;
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    const auto check = [&](auto figure) {
        const auto pose = figure.random_pose();
        const auto fit = cageform::fit_lattice(figure.lattice, figure.binding, figure.displacements(pose),
                                               {.smoothness = 0});
        REQUIRE(fit);
        // In float the displacements are rounded relative to the size of the points.
        const double rounding = std::is_same_v<T, float> ? 1e-6 : 1e-14;
        CHECK(farthest_apart(fit.value, pose) <= rounding / fit.report.pivot_ratio);
        if constexpr (std::is_same_v<T, double>) CHECK(farthest_apart(fit.value, pose) <= 1e-10);
        CHECK(fit.report.rms <= 100 * rounding);
        CHECK(fit.report.largest <= 100 * rounding);
    };
    check(RandomFigure<T, 2>(seed, 300));
    check(RandomFigure<T, 3>(seed, 1000, T(0.5)));
}

TEST_CASE("affine displacements are reproduced for every smoothness, also from few points",
          "[binding][lattice][property]") {
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    RandomFigure<double, 3> figure(seed, 12);
    Vec<Vec<double, 3>, 4> affine;
    for (auto& column : affine.v) {
        for (double& x : column.v) x = figure.uniform(-1, 1);
    }
    const auto displacement = [&](const Vec<double, 3>& p) {
        return affine[3] + p[0] * affine[0] + p[1] * affine[1] + p[2] * affine[2];
    };
    std::vector<Vec<double, 3>> displacements, pose;
    for (const auto& p : figure.points) displacements.push_back(displacement(p));
    for (const auto& h : figure.lattice.handles()) pose.push_back(h + displacement(h));
    for (const double smoothness : {1e-6, 1e-2, 1.0, 100.0}) {
        CAPTURE(smoothness);
        const auto fit =
            cageform::fit_lattice(figure.lattice, figure.binding, displacements, {.smoothness = smoothness});
        REQUIRE(fit);
        // The condition of the matrix grows with the smoothness.
        CHECK(farthest_apart(fit.value, pose) <= 1e-9 * std::max(1.0, smoothness));
    }
}

TEST_CASE("no other pose fits better, and frozen handles do not move", "[binding][lattice][property]") {
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    RandomFigure<double, 2> figure(seed, 200);
    std::vector<Vec<double, 2>> displacements;
    std::vector<double> weights;
    for (std::size_t j = 0; j < figure.points.size(); ++j) {
        displacements.push_back({figure.uniform(-1, 1), figure.uniform(-1, 1)});
        weights.push_back(figure.random() % 5 == 0 ? 0 : figure.uniform(0.1, 3) * 1e300);
    }
    const auto error = [&](const std::vector<Vec<double, 2>>& pose) {
        const auto out = figure.moved(pose);
        double sum = 0, total = 0;
        for (std::size_t j = 0; j < out.size(); ++j) {
            const auto missing = displacements[j] - (out[j] - figure.points[j]);
            sum += weights[j] / 1e300 * dot(missing, missing);
            total += weights[j] / 1e300;
        }
        return std::sqrt(sum / total);
    };
    std::vector<std::uint32_t> frozen;
    for (std::uint32_t i = 0; i < figure.lattice.handles().size(); ++i) {
        if (figure.random() % 3 == 0) frozen.push_back(i);
    }
    const LatticeFitOptions options{.smoothness = 0, .point_weights = weights, .frozen = frozen};
    const auto fit = cageform::fit_lattice(figure.lattice, figure.binding, displacements, options);
    REQUIRE(fit);
    CHECK(std::fabs(fit.report.rms - error(fit.value)) <= 1e-12);
    for (const auto i : frozen) CHECK(fit.value[i] == figure.lattice.handles()[i]);
    for (int trial = 0; trial < 10; ++trial) {
        auto other = fit.value;
        for (std::uint32_t i = 0; i < other.size(); ++i) {
            if (std::find(frozen.begin(), frozen.end(), i) == frozen.end())
                other[i] =
                    other[i] + Vec<double, 2>{figure.uniform(-0.01, 0.01), figure.uniform(-0.01, 0.01)};
        }
        CHECK(error(other) >= fit.report.rms * (1 - 1e-12));
    }
    double before = fit.report.rms;
    for (const double smoothness : {1e-6, 1e-3, 1.0}) { // a smoother pose does not fit better
        auto smoother = options;
        smoother.smoothness = smoothness;
        const auto next = cageform::fit_lattice(figure.lattice, figure.binding, displacements, smoother);
        REQUIRE(next);
        CHECK(next.report.rms >= before * (1 - 1e-12));
        before = next.report.rms;
    }
}

TEST_CASE("sparse and dense matrices give the same fit", "[binding][lattice]") {
    std::mt19937_64 random(7);
    const auto uniform = [&] { return double(random() >> 11) * 0x1p-52 - 1; };
    cageform::detail::LeastSquares dense(60, 3), sparse(60, 3, 10);
    for (int n = 0; n < 400; ++n) {
        std::vector<cageform::detail::LeastSquares::Term> row;
        const auto first = std::uint32_t(random() % 51);
        for (std::uint32_t i = 0; i < 10; i += 1 + std::uint32_t(random() % 3))
            row.push_back({first + i, uniform()});
        const std::array<double, 3> right{uniform(), uniform(), uniform()};
        const double weight = std::fabs(uniform());
        dense.add(row, right, weight);
        sparse.add(row, right, weight);
    }
    const auto a = dense.solve(), b = sparse.solve();
    REQUIRE(a.status == Status::ok);
    REQUIRE(b.status == Status::ok);
    REQUIRE(a.values.size() == 180);
    for (std::size_t i = 0; i < 180; ++i) CHECK(std::fabs(a.values[i] - b.values[i]) <= 1e-11);
}

TEST_CASE("a lattice of more than a thousand handles can be fitted", "[binding][lattice]") {
    const std::size_t side = effort<std::size_t>(36, 33);
    const LatticeCoordinates<float, 2> lattice({LatticeAxis{side, 2, {}}, LatticeAxis{side, 3, {}}},
                                               {{Vec<float, 2>{1, 0}, Vec<float, 2>{0, 1}}, {0, 0}});
    REQUIRE(lattice.handles().size() > 1000);
    std::vector<Vec<float, 2>> points, displacements;
    std::mt19937_64 random(11);
    for (int n = 0; n < 3000; ++n) {
        const Vec<float, 2> p{float(random() % 4096) / 4096, float(random() % 4096) / 4096};
        points.push_back(p);
        displacements.push_back({0.1f * std::sin(6 * p[1]), 0.05f * std::cos(5 * p[0])});
    }
    const auto bound = cageform::bind(lattice, points);
    REQUIRE(bound);
    const auto fit = cageform::fit_lattice(lattice, bound.value, displacements, {.smoothness = 1e-9});
    REQUIRE(fit);
    CHECK(fit.report.largest <= 1e-3);
    CHECK(fit.report.rms > 0);
    std::vector<Vec<float, 2>> out(points.size());
    REQUIRE(cageform::clone(bound.value, fit.value, out) == Status::ok);
    for (std::size_t j = 0; j < points.size(); ++j) {
        const auto missing = displacements[j] - (out[j] - points[j]);
        CHECK(std::sqrt(double(dot(missing, missing))) <= fit.report.largest + 1e-6);
    }
}

TEST_CASE("handles without points are listed and determined by smoothness", "[binding][lattice]") {
    const Transform<double, 2> box{{Vec<double, 2>{1, 0}, Vec<double, 2>{0, 1}}, {0, 0}};
    const LatticeCoordinates<double, 2> lattice({LatticeAxis{5, 1, {}}, LatticeAxis{2, 1, {}}}, box);
    const std::vector<Vec<double, 2>> points{{0.1, 0.2}, {0.2, 0.9}, {0.05, 0.6}, {0.15, 0.4}, {0.24, 0.1}};
    const std::vector<Vec<double, 2>> same(points.size(), Vec<double, 2>{0.5, -1});
    const auto bound = cageform::bind(lattice, points);
    REQUIRE(bound);
    const auto fit = cageform::fit_lattice(lattice, bound.value, same);
    REQUIRE(fit);
    CHECK(fit.report.idle == std::vector<std::uint32_t>{2, 3, 4, 7, 8, 9});
    for (std::size_t i = 0; i < 10; ++i) {
        const auto shift = fit.value[i] - lattice.handles()[i];
        CHECK(std::fabs(shift[0] - 0.5) <= 1e-9);
        CHECK(std::fabs(shift[1] + 1) <= 1e-9);
    }
    const auto refused = cageform::fit_lattice(lattice, bound.value, same, {.smoothness = 0});
    CHECK(refused.status() == Status::fit_not_determined);
    CHECK(refused.value.empty());
    // Determined if these are frozen; trivial if all are.
    const auto freed =
        cageform::fit_lattice(lattice, bound.value, same, {.smoothness = 0, .frozen = fit.report.idle});
    REQUIRE(freed);
    CHECK(freed.report.largest <= 1e-12);
    std::vector<std::uint32_t> all(10);
    for (std::uint32_t i = 0; i < 10; ++i) all[i] = i;
    const auto none = cageform::fit_lattice(lattice, bound.value, same, {.frozen = all});
    REQUIRE(none);
    CHECK(std::equal(none.value.begin(), none.value.end(), lattice.handles().begin()));
    CHECK(std::fabs(none.report.rms - std::sqrt(1.25)) <= 1e-12);
    // One point leaves the affine motions that fix it undetermined.
    const auto one = cageform::bind(lattice, std::vector<Vec<double, 2>>{{0.1, 0.2}});
    REQUIRE(one);
    CHECK(cageform::fit_lattice(lattice, one.value, std::vector<Vec<double, 2>>{{1, 1}}).status() ==
          Status::fit_not_determined);
}

TEST_CASE("invalid input of a fit is rejected with its status, points that are not finite are ignored",
          "[binding][lattice][faults]") {
    RandomFigure<double, 2> figure(3, 50);
    const auto displacements = figure.displacements(figure.random_pose());
    const auto fit = [&](const std::vector<Vec<double, 2>>& targets, const LatticeFitOptions& options = {}) {
        return cageform::fit_lattice(figure.lattice, figure.binding, targets, options).status();
    };
    CHECK(fit(displacements) == Status::ok);
    auto wrong = displacements;
    wrong.pop_back();
    CHECK(fit(wrong) == Status::targets_do_not_match);
    wrong = displacements;
    wrong[7][1] = std::nan("");
    CHECK(fit(wrong) == Status::value_not_finite);
    wrong[7][1] = HUGE_VAL;
    CHECK(fit(wrong) == Status::value_not_finite);
    const auto by_weights = [&](double first, std::size_t count, double rest = 1) {
        std::vector<double> weights(count, rest);
        weights[0] = first;
        return fit(displacements, {.point_weights = weights});
    };
    CHECK(by_weights(1, 49) == Status::targets_do_not_match);
    CHECK(by_weights(std::nan(""), 50) == Status::value_not_finite);
    CHECK(by_weights(-1, 50) == Status::weights_not_positive);
    CHECK(by_weights(0, 50, 0) == Status::weights_not_positive);
    CHECK(by_weights(0, 50) == Status::ok);
    for (const double smoothness : {-1.0, std::nan(""), HUGE_VAL})
        CHECK(fit(displacements, {.smoothness = smoothness}) == Status::value_not_finite);
    const std::vector<std::uint32_t> frozen{100};
    CHECK(fit(displacements, {.frozen = frozen}) == Status::index_out_of_range);
    const LatticeCoordinates<double, 2> other({LatticeAxis{9}, LatticeAxis{9}}, figure.lattice.box());
    CHECK(cageform::fit_lattice(other, figure.binding, displacements).status() ==
          Status::targets_do_not_match);
    const LatticeCoordinates<double, 2> unsound({LatticeAxis{1}, LatticeAxis{9}}, figure.lattice.box());
    CHECK(cageform::fit_lattice(unsound, figure.binding, displacements).status() ==
          Status::lattice_degree_not_supported);
    CHECK(fit(std::vector<Vec<double, 2>>(50, Vec<double, 2>{1e308, -1e308})) != Status::out_of_memory);

    auto with_bad = figure;
    auto targets = displacements;
    with_bad.points.push_back({std::nan(""), 0});
    targets.push_back({std::nan(""), std::nan("")});
    with_bad.bind();
    const auto skipped = cageform::fit_lattice(with_bad.lattice, with_bad.binding, targets);
    REQUIRE(skipped);
    const auto without = cageform::fit_lattice(figure.lattice, figure.binding, displacements);
    CHECK(skipped.value == without.value);
    CHECK(skipped.report.farthest == without.report.farthest);
    CHECK(skipped.report.unreached == 0);
}

TEST_CASE("points without weights have no residual and are counted", "[binding][lattice]") {
    RandomFigure<double, 2> figure(4, 50);
    auto targets = figure.displacements(figure.random_pose());
    const auto without = cageform::fit_lattice(figure.lattice, figure.binding, targets);
    REQUIRE(without);
    CHECK(without.report.unreached == 0);
    for (const Vec<double, 2>& p : {Vec<double, 2>{1e17, 0}, Vec<double, 2>{40, 40}}) {
        figure.points.push_back(p); // unreached; outside and kept in place
        targets.push_back({7, 8});
    }
    const auto bound =
        cageform::bind(figure.lattice, figure.points, {.outside = cageform::OutsidePoints::keep_in_place});
    REQUIRE(bound);
    CHECK(bound.report.unreached == std::vector<std::size_t>{50});
    CHECK(bound.report.outside == std::vector<std::size_t>{51});
    const auto fit = cageform::fit_lattice(figure.lattice, bound.value, targets);
    REQUIRE(fit);
    CHECK(fit.report.unreached == 2);
    CHECK(fit.value == without.value);
    CHECK(fit.report.rms == without.report.rms);
    CHECK(fit.report.largest == without.report.largest);
    // A figure of only such points.
    const std::vector<Vec<double, 2>> lost{{1e17, 0}}, target{{1, 1}};
    const auto none = cageform::bind(figure.lattice, lost);
    REQUIRE(none);
    const auto refused = cageform::fit_lattice(figure.lattice, none.value, target);
    CHECK(refused.status() == Status::fit_not_determined);
    CHECK(refused.report.unreached == 1);
}

} // namespace fit_lattice_tests
