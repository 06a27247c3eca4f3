// bind: bindings of every coordinate type, and the correctness of reports.
#include "averaging/pyramid_solver.hpp"
#include "catch.hpp"
#include "support/effort.hpp"
#include "support/larger.hpp"
#include "support/thin_cages.hpp"
#include "support/weights.hpp"

#include <cageform/adapt/eigen.hpp>
#include <cageform/adapt/glm.hpp>
#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/project.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>
#include <cageform/parallel/threads.hpp>

#include <array>
#include <functional>
#include <numeric>

namespace bind_tests {

using namespace cageform_tests;
using cageform::Binding;
using cageform::BindOptions;
using cageform::BindReport;
using cageform::epsilon;
using cageform::LinearPrecision;
using cageform::OutsidePoints;
using cageform::Polygon;
using cageform::UniformGrid;
using cageform_sources::averaging::AveragingSolver;

namespace {

template <class T>
using Bary = cageform::BarycentricCoordinates<T, 2>;
template <class T>
using Mean = cageform::MeanValueCoordinates<T, 2>;
/// Harmonic coordinates on a coarse grid by default, by a solver that leaves a residual to
/// restore.
template <class T>
struct Harmonic : cageform::HarmonicCoordinates<T, 2> {
    template <class Cage>
    explicit Harmonic(const Cage& cage, const cageform::HarmonicOptions& options = {.resolution = 32},
                      const typename Harmonic::Solver& solver = AveragingSolver{})
        : Harmonic::HarmonicCoordinates(cage, options, solver) {}
};

using Indices = std::vector<std::size_t>;

template <class T>
const Points2<T> square{{0, 0}, {4, 0}, {4, 4}, {0, 4}};

template <class T>
constexpr T not_a_number = std::numeric_limits<T>::quiet_NaN();
template <class T>
constexpr T infinity = std::numeric_limits<T>::infinity();

/// Points of each state at known indices.
template <class T>
Points2<T> mixed_points() {
    return {{1, 1},                          // 0
            {5, 1},                          // 1 outside
            {not_a_number<T>, 1},            // 2 not finite
            {4, 2},                          // 3 on the boundary
            {-1, -2},                        // 4 outside
            {2, 3},                          // 5
            {0, 0},                          // 6 on the boundary
            {1, infinity<T>},                // 7 not finite
            {3, T(0.5)},                     // 8
            {-infinity<T>, not_a_number<T>}, // 9 not finite
            {2, 4},                          // 10 on the boundary
            {2, T(4.5)}};                    // 11 outside
}
const Indices mixed_outside{1, 4, 11}, mixed_not_finite{2, 7, 9}, mixed_on_boundary{3, 6, 10};

template <class T>
Points2<T> points_about(const Polygon<T>& cage, int inside, int anywhere, std::uint64_t seed) {
    Random random(seed);
    Points2<T> points;
    for (int i = 0; i < inside; ++i) points.push_back(random_inside(cage, random, 0));
    const auto bounds = cageform::bounds_of(cage.vertices());
    for (int i = 0; i < anywhere; ++i) {
        Vec<T, 2> p{};
        for (std::size_t k = 0; k < 2; ++k) {
            const double reach = double(bounds.diagonal());
            p[k] = T(random.uniform(double(bounds.lower[k]) - reach, double(bounds.upper[k]) + reach));
        }
        points.push_back(p);
    }
    return points;
}

template <class T, std::size_t D>
std::vector<T> row_of(const Binding<T, D>& binding, std::size_t point) {
    std::vector<T> row;
    for (std::size_t h = 0; h < binding.handle_count(); ++h) row.push_back(binding.weight(point, h));
    return row;
}

template <class T, std::size_t D>
bool same_bits(const Binding<T, D>& a, const Binding<T, D>& b) {
    if (a.point_count() != b.point_count() || a.handle_count() != b.handle_count()) return false;
    for (std::size_t i = 0; i < a.point_count(); ++i) {
        if (row_of(a, i) != row_of(b, i)) return false;
        for (std::size_t k = 0; k < D; ++k) {
            const T x = a.rest_point(i)[k], y = b.rest_point(i)[k];
            if (x != y && cageform::is_finite(x)) return false;
        }
    }
    return true;
}

bool same_figures(const BindReport& a, const BindReport& b) {
    const auto same = [](const cageform::Extreme& x, const cageform::Extreme& y) {
        return x.value == y.value && x.point == y.point;
    };
    return same(a.partition_error, b.partition_error) && same(a.reproduction_error, b.reproduction_error) &&
           same(a.weight_change, b.weight_change) && same(a.residual_restored, b.residual_restored) &&
           same(a.least_weight, b.least_weight) && same(a.amplification, b.amplification) &&
           a.outside == b.outside && a.on_boundary == b.on_boundary && a.not_finite == b.not_finite &&
           a.unreached == b.unreached;
}

template <class T, std::size_t D>
std::vector<Vec<T, D>> handles_of(const Binding<T, D>& binding) {
    std::vector<Vec<T, D>> handles;
    for (std::size_t h = 0; h < binding.handle_count(); ++h) handles.push_back(binding.rest_handle(h));
    return handles;
}

/// A pose that is far from affine.
template <class T, std::size_t D>
std::vector<Vec<T, D>> random_pose(const Binding<T, D>& binding, std::uint64_t seed) {
    Random random(seed);
    auto pose = handles_of(binding);
    for (auto& h : pose) {
        for (std::size_t k = 0; k < D; ++k) h[k] = T(random.uniform(-5, 5));
    }
    return pose;
}

template <class T, std::size_t D>
std::vector<Vec<T, D>> cloned(const Binding<T, D>& binding, const std::vector<Vec<T, D>>& pose) {
    std::vector<Vec<T, D>> out(binding.point_count());
    REQUIRE(cageform::clone(binding, pose, out) == Status::ok);
    return out;
}

/// A user's coordinate type, areas in a triangle, written without the library's implementation.
class AreaCoordinates {
public:
    using scalar = double;
    static constexpr std::size_t dimension = 2;
    static constexpr bool has_extension = false;
    static constexpr bool closed_form = true;

    explicit AreaCoordinates(std::array<Vec<double, 2>, 3> corners)
        : corners_(corners) {}

    std::span<const Vec<double, 2>> handles() const { return corners_; }
    const cageform::CageReport& cage_report() const { return report_; }
    cageform::Evaluation evaluate(cageform::BlockView<const double> points,
                                  cageform::BlockView<double> weights, std::span<PointState> states,
                                  const cageform::Running&) const {
        for (std::size_t i = 0; i < states.size(); ++i) {
            if (states[i] == PointState::not_finite) continue;
            const auto p = cageform::block_point<2>(points, i);
            const auto [a, b, c] = corners_;
            const double whole = cross(b - a, c - a);
            weights(i, 0) = cross(b - p, c - p) / whole;
            weights(i, 1) = cross(c - p, a - p) / whole;
            weights(i, 2) = cross(a - p, b - p) / whole;
            const double least = std::min({weights(i, 0), weights(i, 1), weights(i, 2)});
            states[i] = least < 0 ? PointState::outside : PointState::inside;
            if (p[0] == 0.125) states[i] = PointState::unreached; // as after a solver
        }
        return {};
    }
    Vec<double, 2> nearest_boundary(const Vec<double, 2>&, std::span<double> row) const {
        std::fill(row.begin(), row.end(), 0.0);
        row[0] = 1;
        return corners_[0];
    }

private:
    std::array<Vec<double, 2>, 3> corners_;
    cageform::CageReport report_;
};

/// Degraded mean value coordinates: weights below a threshold are dropped, and
/// the first weight is perturbed.
template <class T>
class Thinned : public Mean<T> {
public:
    using Mean<T>::Mean;
    T threshold = T(0.05);
    T offset = 0;

    cageform::Evaluation evaluate(cageform::BlockView<const T> points, cageform::BlockView<T> weights,
                                  std::span<PointState> states, const cageform::Running& options) const {
        const auto evaluation = Mean<T>::evaluate(points, weights, states, options);
        for (std::size_t i = 0; i < states.size(); ++i) {
            for (std::size_t h = 0; h < weights.rows; ++h) {
                if (std::fabs(weights(i, h)) < threshold) weights(i, h) = T(0);
            }
            weights(i, 0) += offset;
        }
        return evaluation;
    }
};

/// The minimum-norm x with rows · x = sums, by Gram-Schmidt.
std::vector<double> least_solution(std::array<std::vector<double>, 3> rows, Vec<double, 3> sums) {
    std::vector<double> x(rows[0].size(), 0.0);
    const auto add = [](std::vector<double>& to, double factor, const std::vector<double>& row) {
        for (std::size_t i = 0; i < to.size(); ++i) to[i] += factor * row[i];
    };
    const auto product = [](const std::vector<double>& a, const std::vector<double>& b) {
        return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
    };
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t s = 0; s < r; ++s) {
            const double along = product(rows[r], rows[s]);
            add(rows[r], -along, rows[s]);
            sums[r] -= along * sums[s];
        }
        const double length = std::sqrt(product(rows[r], rows[r]));
        add(rows[r], 1 / length - 1, std::vector<double>(rows[r]));
        sums[r] /= length;
        add(x, sums[r], rows[r]);
    }
    return x;
}

static_assert(cageform::CageCoordinates<AreaCoordinates> && cageform::CageCoordinates<Thinned<float>>);

} // namespace

TEMPLATE_TEST_CASE("bind returns the status of the cage and an empty binding", "[binding][status]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto status_of = [](const auto& coordinates) {
        const auto result = cageform::bind(coordinates, Points2<T>{{1, 1}});
        CHECK(result.value.point_count() == 0);
        CHECK(result.report.cage.status == result.report.status);
        CHECK(!result.report.cage.faults.empty());
        CHECK(result.report.points == 1);
        return result.report.status;
    };
    CHECK(status_of(Mean<T>(Points2<T>{{0, 0}, {1, 0}})) == Status::too_few_vertices);
    CHECK(status_of(Mean<T>(Points2<T>{{0, 0}, {1, not_a_number<T>}, {0, 1}})) == Status::vertex_not_finite);
    CHECK(status_of(Mean<T>(Points2<T>{{0, 0}, {0, 0}, {1, 0}, {0, 1}})) == Status::duplicate_vertices);
    CHECK(status_of(Mean<T>(Points2<T>{{0, 0}, {1, 1}, {1, 0}, {0, 1}})) == Status::cage_self_crossing);
    CHECK(status_of(Mean<T>(Points2<T>{{0, 0}, {1, 1}, {3, 3}})) == Status::cage_has_no_area);
    const std::array<std::size_t, 1> three{3};
    CHECK(status_of(Mean<T>(Polygon<T>(square<T>, three))) == Status::loops_do_not_match);
    CHECK(status_of(Harmonic<T>(Points2<T>{{0, 0}, {1, 1}, {3, 3}})) == Status::cage_has_no_area);
    CHECK(status_of(Bary<T>(square<T>)) == Status::not_a_simplex);
    CHECK(status_of(Bary<T>(Points2<T>{{0, 0}, {1, 1}, {3, 3}})) == Status::degenerate_simplex);
}

TEMPLATE_TEST_CASE("bind returns the status of the solver and an empty binding", "[binding][status]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto status_of = [](const cageform::HarmonicOptions& options, const auto& solver) {
        const auto result = cageform::bind(Harmonic<T>(square<T>, options, solver), Points2<T>{{1, 1}});
        CHECK(result.value.point_count() == 0);
        CHECK(result.report.cage.status == Status::ok);
        return result.report.status;
    };
    CHECK(status_of({.resolution = 4}, UniformGrid{}) == Status::resolution_not_supported);
    CHECK(status_of({.resolution = 32, .multigrid = {.tolerance = 0}}, UniformGrid{}) ==
          Status::tolerance_not_positive);
    CHECK(status_of({.resolution = 32, .multigrid = {.tolerance = 1e-300, .max_cycles = 1}}, UniformGrid{}) ==
          Status::not_converged);

    const auto result =
        cageform::bind(Harmonic<T>(square<T>, {.resolution = 32}, UniformGrid{}), Points2<T>{{1, 1}});
    REQUIRE(result.report.status == Status::ok);
    CHECK(result.report.solver.solves == 4);
    CHECK(result.report.solver.cells > 0);
    CHECK(result.report.seconds >= result.report.solver.seconds);
}

#if !defined(CAGEFORM_SANITIZED) // sanitizers abort such an allocation
TEST_CASE("more points than fit into memory give a status", "[binding][status]") {
    struct Endless {
        static std::size_t size() { return std::size_t{1} << 60; }
        Vec<double, 2> operator[](std::size_t) const { return {1, 1}; }
    };
    const auto result = cageform::bind(Mean<double>(square<double>), Endless{});
    CHECK(result.report.status == Status::out_of_memory);
    CHECK(result.report.points == std::size_t{1} << 60);
    CHECK(result.value.point_count() == 0);
}
#endif

TEMPLATE_TEST_CASE("the report lists every unusual point", "[binding][report]", Mean<float>, Mean<double>,
                   Harmonic<float>, Harmonic<double>) {
    using T = typename TestType::scalar;
    const auto result = cageform::bind(TestType(square<T>), mixed_points<T>());
    REQUIRE(result.report.status == Status::ok);
    CHECK(result.report.points == 12);
    CHECK(result.value.point_count() == 12);
    CHECK(result.report.outside == mixed_outside);
    CHECK(result.report.not_finite == mixed_not_finite);
    CHECK(result.report.on_boundary == mixed_on_boundary);
    CHECK(result.report.unreached.empty());
}

TEMPLATE_TEST_CASE("points that are not finite are not moved", "[binding][report]", Mean<float>,
                   Harmonic<double>) {
    using T = typename TestType::scalar;
    const auto points = mixed_points<T>();
    const auto policy =
        GENERATE(OutsidePoints::extend, OutsidePoints::keep_in_place, OutsidePoints::nearest_boundary);
    const auto [binding, report] = cageform::bind(TestType(square<T>), points, {.outside = policy});
    REQUIRE(report.status == Status::ok);
    const auto moved = cloned(binding, random_pose(binding, 1));
    for (const std::size_t i : mixed_not_finite) {
        CHECK(row_of(binding, i) == std::vector<T>(4, T(0)));
        for (std::size_t k = 0; k < 2; ++k) {
            if (std::isnan(points[i][k])) {
                CHECK(std::isnan(moved[i][k]));
            } else {
                CHECK(moved[i][k] == points[i][k]);
            }
        }
    }
}

TEMPLATE_TEST_CASE("points kept in place do not move in any pose", "[binding][outside]", Mean<float>,
                   Harmonic<double>) {
    using T = typename TestType::scalar;
    const auto points = mixed_points<T>();
    const auto [binding, report] =
        cageform::bind(TestType(square<T>), points, {.outside = OutsidePoints::keep_in_place});
    REQUIRE(report.status == Status::ok);
    CHECK(report.outside == mixed_outside);
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        const auto moved = cloned(binding, random_pose(binding, seed));
        for (const std::size_t i : mixed_outside) CHECK(moved[i] == points[i]);
        CHECK(moved[0] != points[0]);
        CHECK(moved[3] != points[3]);
    }
}

TEMPLATE_TEST_CASE("points outside can follow the nearest boundary point", "[binding][outside]", Mean<float>,
                   Harmonic<double>) {
    using T = typename TestType::scalar;
    const auto seed = GENERATE(seeds(10));
    CAPTURE(seed);
    const Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    const TestType coordinates(cage);
    Points2<T> outside, nearest;
    for (const auto& p : points_about(cage, 0, 60, std::uint64_t(seed) + 100)) {
        if (cageform::locate(cage, p, T(0)) != PointState::outside) continue;
        outside.push_back(p);
        nearest.push_back(cageform::nearest_on_boundary(cage, p).position);
    }
    REQUIRE(outside.size() > 20);
    const auto [binding, report] =
        cageform::bind(coordinates, outside, {.outside = OutsidePoints::nearest_boundary});
    const auto on_boundary = cageform::bind(coordinates, nearest);
    REQUIRE(report.status == Status::ok);
    REQUIRE(on_boundary.report.status == Status::ok);
    CHECK(report.outside.size() == outside.size());
    CHECK(on_boundary.report.on_boundary.size() == outside.size());
    const double scale = size_of(cage.vertices());
    auto pose = random_pose(binding, std::uint64_t(seed));
    for (auto& c : pose) c = T(scale) * c;
    const auto moved = cloned(binding, pose);
    const auto followed = cloned(on_boundary.value, pose);
    for (std::size_t i = 0; i < outside.size(); ++i) {
        CAPTURE(i);
        const auto offset = cageform::vec_cast<double>(outside[i]) - cageform::vec_cast<double>(nearest[i]);
        // The weights are those of an edge, so their rounding, relative to the edge's length, only
        // matters along the edge.
        CHECK(distance(moved[i], cageform::vec_cast<double>(followed[i]) + offset) <=
              64 * double(epsilon<T>) * (size_of(pose) + size_of(outside)));
    }
    CHECK(report.reproduction_error.value <= 8 * double(epsilon<T>) * scale); // of the boundary points
    CHECK(report.least_weight.value >= -8 * double(epsilon<T>));
}

TEMPLATE_TEST_CASE("points outside use the extension of the type", "[binding][outside]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto points = mixed_points<T>();
    const Mean<T> mean(square<T>);
    const auto extended = cageform::bind(mean, points, {.outside = OutsidePoints::extend});
    REQUIRE(extended.report.status == Status::ok);
    CHECK(extended.report.outside == mixed_outside);
    for (const std::size_t i : mixed_outside) {
        std::array<T, 4> row{};
        CHECK(cageform::weights_at(mean, points[i], row) == PointState::outside);
        CHECK(difference(row_of(extended.value, i), row) <= 16 * double(epsilon<T>)); // restored to rounding
        CHECK(absolute_sum(row) > 1);
    }
    // Harmonic coordinates have no values there.
    const auto kept = cageform::bind(Harmonic<T>(square<T>), points, {.outside = OutsidePoints::extend});
    REQUIRE(kept.report.status == Status::ok);
    CHECK(kept.report.outside == mixed_outside);
    const auto moved = cloned(kept.value, random_pose(kept.value, 3));
    for (const std::size_t i : mixed_outside) CHECK(moved[i] == points[i]);
}

TEMPLATE_TEST_CASE("the numbers of the report are those of the binding", "[binding][report]", Mean<float>,
                   Harmonic<double>, Thinned<double>) {
    using T = typename TestType::scalar;
    const auto seed = GENERATE(seeds(10));
    const auto mode = GENERATE(LinearPrecision::restore, LinearPrecision::leave);
    CAPTURE(seed, int(mode));
    const Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    const auto points = points_about(cage, 300, 10, std::uint64_t(seed) + 200);
    const auto [binding, report] = cageform::bind(
        TestType(cage), points, {.outside = OutsidePoints::keep_in_place, .linear_precision = mode});
    REQUIRE(report.status == Status::ok);
    REQUIRE(!report.outside.empty());
    const double eps = double(epsilon<T>), size = size_of(cage.vertices());
    std::vector<double> partition, reproduction, least, sizes;
    double scale = 1;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto row = row_of(binding, i);
        const bool bound = std::find(report.outside.begin(), report.outside.end(), i) == report.outside.end();
        partition.push_back(bound ? std::fabs(double(sum_of(row) - 1)) : 0);
        reproduction.push_back(bound ? distance(combine(row, cage.vertices()), points[i]) : 0);
        least.push_back(bound ? double(*std::min_element(row.begin(), row.end())) : 1);
        sizes.push_back(bound ? double(absolute_sum(row)) : 0);
        scale = cageform_tests::larger(scale, absolute_sum(row));
    }
    // The report is computed in the scalar: one rounding per handle.
    const double rounding = 8 * eps * scale;
    const auto most = [](const std::vector<double>& v) { return *std::max_element(v.begin(), v.end()); };
    CHECK(std::fabs(report.partition_error.value - most(partition)) <= rounding);
    CHECK(std::fabs(partition[report.partition_error.point] - most(partition)) <= 2 * rounding);
    CHECK(std::fabs(report.reproduction_error.value - most(reproduction)) <= rounding * size);
    CHECK(std::fabs(reproduction[report.reproduction_error.point] - most(reproduction)) <=
          2 * rounding * size);
    CHECK(std::fabs(report.amplification.value - most(sizes)) <= rounding);
    CHECK(report.least_weight.value == *std::min_element(least.begin(), least.end()));
    CHECK(report.least_weight.value == least[report.least_weight.point]);
    if (mode == LinearPrecision::leave) {
        CHECK(report.weight_change.value == 0);
        CHECK(report.residual_restored.value == 0);
    }
    if (mode == LinearPrecision::restore) {
        CHECK(report.partition_error.value <= rounding);
        CHECK(report.reproduction_error.value <= rounding * size);
    } else if constexpr (!std::is_same_v<TestType, Mean<T>>) {
        // There is an error to restore: half a cell of the grid, dropped weights.
        CHECK(report.reproduction_error.value >=
              1e-3 * double(cageform::bounds_of(cage.vertices()).diagonal()));
    }
}

TEMPLATE_TEST_CASE("the numbers of the report are correct for tiny and huge cages",
                   "[binding][report][scale]", CAGEFORM_SCALARS) {
    // The squared error underflows in the smallest units.
    using T = TestType;
    const double unit = sizeof(T) == 4 ? GENERATE(1e-19, 1e-15, 1e15) : GENERATE(1e-150, 1e150);
    CAPTURE(unit);
    const auto error_at = [](T scale) {
        Points2<T> cage{{3, 4}, {7, 5}, {8, 9}, {5, 7}, {2, 8}}, points{{4, 5}, {6, 6}, {T(3.5), 6}};
        for (auto& c : cage) c = scale * c;
        for (auto& p : points) p = scale * p;
        Thinned<T> coordinates(cage);
        coordinates.threshold = 0;
        coordinates.offset = sizeof(T) == 4 ? T(1e-5) : T(1e-13);
        const auto result = cageform::bind(coordinates, points, {.linear_precision = LinearPrecision::leave});
        REQUIRE(result.report.status == Status::ok);
        return result.report.reproduction_error.value / double(scale) / double(coordinates.offset);
    };
    CHECK(error_at(1) == Approx(5).epsilon(0.1)); // the perturbation times the first vertex, up to rounding
    CHECK(error_at(T(unit)) == Approx(5).epsilon(0.1));
}

TEMPLATE_TEST_CASE("restoring linear precision makes the minimum change of weights",
                   "[binding][linear_precision]", Thinned<float>, Thinned<double>, Harmonic<double>) {
    using T = typename TestType::scalar;
    const auto seed = GENERATE(seeds(10));
    CAPTURE(seed);
    const Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    const auto points = points_about(cage, 40, 0, std::uint64_t(seed) + 300);
    const TestType coordinates(cage);
    const auto left = cageform::bind(coordinates, points, {.linear_precision = LinearPrecision::leave});
    const auto restored = cageform::bind(coordinates, points);
    REQUIRE(left.report.status == Status::ok);
    REQUIRE(restored.report.status == Status::ok);

    // The reference: the minimum-norm solution of the three equations.
    // Lengths are relative to the centre and size of the cage, as documented.
    const auto bounds = cageform::bounds_of(cage.vertices());
    const auto middle = cageform::vec_cast<double>(T(0.5) * (bounds.lower + bounds.upper));
    const double size = double(bounds.diagonal());
    const auto in_cage = [&](const Vec<T, 2>& p) {
        return (1 / size) * (cageform::vec_cast<double>(p) - middle);
    };
    double largest = 0;
    for (std::size_t n = 0; n < points.size(); ++n) {
        const auto before = row_of(left.value, n), after = row_of(restored.value, n);
        const auto p = in_cage(points[n]);
        std::array<std::vector<double>, 3> rows;
        Vec<double, 3> missing{1, p[0], p[1]};
        for (std::size_t i = 0; i < cage.size(); ++i) {
            const auto c = in_cage(cage[i]);
            const Vec<double, 3> column{1, c[0], c[1]};
            for (std::size_t r = 0; r < 3; ++r) rows[r].push_back(column[r]);
            missing = missing - double(before[i]) * column;
        }
        auto expected = least_solution(rows, missing);
        for (std::size_t i = 0; i < cage.size(); ++i) expected[i] += double(before[i]);
        for (std::size_t i = 0; i < cage.size(); ++i)
            largest = cageform_tests::larger(largest, std::fabs(double(after[i]) - double(before[i])));
        CAPTURE(n, text(before), text(after));
        const auto least = [](const auto& row) { return double(*std::min_element(row.begin(), row.end())); };
        // Weights that would turn negative are projected if that is possible: tests/binding/projected.cpp.
        std::vector<T> projected(cage.size());
        if (least(before) >= 0 && least(expected) < 0 &&
            cageform::project<T, 2>(before, cage.vertices(), points[n], projected) == Status::ok) {
            CHECK(least(after) >= 0);
            continue;
        }
        CHECK(difference(after, expected) <= 64 * double(epsilon<T>) * size_of(cage.vertices()) / size);
    }
    CHECK(restored.report.weight_change.value == Approx(largest).epsilon(1e-3));
    CHECK(restored.report.residual_restored.value ==
          Approx(left.report.reproduction_error.value).epsilon(1e-3));
    CHECK(largest > 0);
}

TEMPLATE_TEST_CASE("restoring never increases the residual", "[binding][linear_precision]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const double width = std::pow(10.0, random.uniform(sizeof(T) == 4 ? -5.5 : -14, -1));
    const auto corners = thin_simplex<T, 2>(random, width);
    const Mean<T> coordinates(corners);
    if (coordinates.cage_report().status != Status::ok) return; // too thin
    const auto points = points_about(coordinates.cage(), 0, 50, std::uint64_t(seed));
    const auto left = cageform::bind(coordinates, points, {.linear_precision = LinearPrecision::leave});
    const auto restored = cageform::bind(coordinates, points);
    REQUIRE(restored.report.status == Status::ok);
    check_restored(left, restored, coordinates.handles());
}

TEST_CASE("residuals that cannot be restored are reported", "[binding][linear_precision]") {
    const Mean<double> thin(Points2<double>{{0.75, 5}, {2, 4e-9}, {1, 4}});
    const auto points = points_about(thin.cage(), 0, 100, 1);
    const auto left = cageform::bind(thin, points, {.linear_precision = LinearPrecision::leave});
    const auto restored = cageform::bind(thin, points);
    CHECK(restored.report.not_restored.size() > 50);
    CHECK(restored.report.partition_error.value <= 2 * left.report.partition_error.value);
    CHECK(restored.report.reproduction_error.value <= 1.01 * left.report.reproduction_error.value);
    const Mean<double> wide(square<double>);
    CHECK(cageform::bind(wide, mixed_points<double>()).report.not_restored.empty());
}

TEST_CASE("restoring does not change exact weights", "[binding][linear_precision]") {
    // On an edge the other weights are zero and stay zero.
    const Mean<double> coordinates(square<double>);
    const Points2<double> points{{1, 0}, {4, 3}, {0.3, 4}, {0, 0.7}, {4, 4}};
    const auto [binding, report] = cageform::bind(coordinates, points);
    REQUIRE(report.status == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto row = row_of(binding, i);
        CHECK(std::count(row.begin(), row.end(), 0.0) == (i == 4 ? 3 : 2));
    }
    CHECK(report.weight_change.value == 0);
    CHECK(report.residual_restored.value == 0);
}

TEMPLATE_TEST_CASE("any number of points can be bound", "[binding][blocks]", Mean<float>, Harmonic<double>) {
    using T = typename TestType::scalar;
    const std::size_t count = GENERATE(0u, 1u, 2u, 7u, 8u, 9u, 15u, 16u, 17u, 31u, 33u, 1000u);
    CAPTURE(count);
    const Polygon<T> cage(random_star<T>(4));
    auto points = points_about(cage, 1000, 0, 400);
    const TestType coordinates(cage);
    const auto all = cageform::bind(coordinates, points);
    points.resize(count);
    points.shrink_to_fit();
    const auto [binding, report] = cageform::bind(coordinates, points);
    REQUIRE(report.status == Status::ok);
    CHECK(report.points == count);
    REQUIRE(binding.point_count() == count);
    CHECK(binding.handle_count() == cage.size());
    CHECK(handles_of(binding) == random_star<T>(4));
    std::size_t same = 0;
    for (std::size_t i = 0; i < count; ++i)
        same += binding.rest_point(i) == points[i] && row_of(binding, i) == row_of(all.value, i);
    CHECK(same == count);
    CHECK((count == 0 ? report.partition_error.point == cageform::Extreme::none
                      : report.partition_error.point < count));
    std::vector<Vec<T, 2>> out(count);
    CHECK(cageform::clone(binding, handles_of(binding), out) == Status::ok);
    CHECK(out == points);
}

TEMPLATE_TEST_CASE("bind reuses the memory of a recycled binding", "[binding][recycled]", Mean<float>,
                   Harmonic<double>) {
    using T = typename TestType::scalar;
    const TestType large(random_star<T>(5)), small(random_star<T>(7));
    REQUIRE(large.handles().size() != small.handles().size());
    const auto many = points_about(large.cage(), 200, 0, 401);
    auto few = points_about(small.cage(), 53, 5, 402);
    few.push_back({not_a_number<T>, 0});
    const auto expected = cageform::bind(small, few);
    REQUIRE(expected.report.status == Status::ok);
    auto old = cageform::bind(large, many).value;
    const auto* const memory = old.view().weights.data;
    const auto shrunk = cageform::bind(small, few, {}, std::move(old));
    REQUIRE(shrunk.report.status == Status::ok);
    CHECK(same_bits(shrunk.value, expected.value));
    CHECK(same_figures(shrunk.report, expected.report));
    if (large.handles().size() * 200 > small.handles().size() * 64)
        CHECK(shrunk.value.view().weights.data == memory);
    auto again = cageform::bind(small, few).value;
    CHECK(same_bits(cageform::bind(large, many, {}, std::move(again)).value,
                    cageform::bind(large, many).value));
}

TEST_CASE("a thousand copies of a point get the same weights", "[binding][blocks]") {
    const Points2<float> points(1000, Vec<float, 2>{1, 2});
    const auto [binding, report] = cageform::bind(Mean<float>(square<float>), points);
    REQUIRE(report.status == Status::ok);
    for (std::size_t i = 1; i < 1000; ++i) REQUIRE(row_of(binding, i) == row_of(binding, 0));
    CHECK(report.least_weight.point == 0); // the first of equal ones
}

TEMPLATE_TEST_CASE("progress rises to 1 and can cancel", "[binding][progress]", Mean<double>,
                   Harmonic<double>) {
    const Polygon<double> cage(random_star<double>(6));
    auto points = points_about(cage, 1000, 0, 500);
    for (std::size_t i = 0; i < effort(150000U, 75000U); ++i)
        points.push_back(points[i]); // enough for several steps
    const TestType coordinates(cage);
    std::vector<double> told;
    const auto whole = cageform::bind(coordinates, points, {}, {.progress = [&](double done) {
                                          told.push_back(done);
                                          return true;
                                      }});
    REQUIRE(whole.report.status == Status::ok);
    CHECK(told.size() >= 3);
    CHECK(std::is_sorted(told.begin(), told.end()));
    CHECK(told.front() >= 0);
    CHECK(told.back() == 1);
    CHECK(std::count(told.begin(), told.end(), 1.0) == 1);
    CHECK(same_bits(whole.value, cageform::bind(coordinates, points).value)); // the callback changes nothing

    for (const double last : {0.0, 0.5, 1.0}) { // the number of steps depends on the time
        std::size_t asked_again = 0;
        bool stopped = false;
        const auto cancelled = cageform::bind(coordinates, points, {}, {.progress = [&](double done) {
                                                  asked_again += stopped ? 1 : 0;
                                                  stopped = done >= last;
                                                  return !stopped;
                                              }});
        CAPTURE(last);
        CHECK(cancelled.report.status == Status::cancelled);
        CHECK(cancelled.value.point_count() == 0);
        CHECK(cancelled.value.handle_count() == 0);
        CHECK(asked_again == 0); // no call after cancellation
    }
}

TEMPLATE_TEST_CASE("threads and arbitrary ranges give the same bits and the same report",
                   "[binding][threads]", Mean<float>, Harmonic<double>) {
    using T = typename TestType::scalar;
    const Polygon<T> cage(random_star<T>(8));
    auto points = points_about(cage, 3000, 500, 600);
    for (std::size_t i = 0; i < 3000; ++i) points.push_back(points[i]); // ties for every extremum
    const TestType coordinates(cage);
    const auto expected = cageform::bind(coordinates, points);
    REQUIRE(expected.report.status == Status::ok);

    const auto backwards = [](std::size_t count, std::size_t, const cageform::RangeBody& body) {
        for (std::size_t i = count; i-- > 0;) body(i, i + 1);
    };
    const auto uneven = [](std::size_t count, std::size_t, const cageform::RangeBody& body) {
        std::size_t begin = 0;
        for (std::size_t step = 1; begin < count; begin += step, step = step * 2 + 1)
            body(begin, std::min(begin + step, count));
    };
    for (const cageform::ParallelFor& parallel :
         {cageform::ParallelFor(cageform::ThreadedFor{2}), cageform::ParallelFor(cageform::ThreadedFor{5}),
          cageform::ParallelFor(cageform::ThreadedFor{}), cageform::ParallelFor(backwards),
          cageform::ParallelFor(uneven)}) {
        const auto result = cageform::bind(coordinates, points, {}, {.parallel = parallel});
        REQUIRE(result.report.status == Status::ok);
        CHECK(same_bits(result.value, expected.value));
        CHECK(same_figures(result.report, expected.report));
    }
}

TEST_CASE("points can be in any kind of range", "[binding][ranges]") {
    const Mean<double> coordinates(square<double>);
    const std::vector<Vec<double, 2>> plain{{1, 1}, {2, 3}, {0.5, 2.5}, {3.25, 0.75}, {2, 4}};
    const auto expected = cageform::bind(coordinates, plain).value;
    REQUIRE(expected.point_count() == 5);
    const auto binds_alike = [&](const auto& points) {
        const auto result = cageform::bind(coordinates, points);
        return result.report.status == Status::ok && same_bits(result.value, expected);
    };

    std::vector<std::array<double, 2>> arrays;
    std::vector<std::array<float, 2>> floats; // exact in float, converted
    std::vector<glm::dvec2> glms;
    std::vector<glm::vec2> glm_floats;
    std::vector<Eigen::Vector2d> columns;
    double c_array[5][2];
    Eigen::MatrixXd rows(5, 2), wide(2, 5);
    Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor> row_major(5, 2);
    std::vector<float> interleaved; // x y and three unused numbers
    std::array<std::vector<double>, 2> apart;
    for (std::size_t i = 0; i < plain.size(); ++i) {
        const auto [x, y] = plain[i].v;
        const auto n = Eigen::Index(i);
        arrays.push_back({x, y});
        floats.push_back({float(x), float(y)});
        glms.emplace_back(x, y);
        glm_floats.emplace_back(float(x), float(y));
        columns.emplace_back(x, y);
        c_array[i][0] = x;
        c_array[i][1] = y;
        rows.row(n) << x, y;
        wide.col(n) << x, y;
        row_major.row(n) << float(x), float(y);
        for (const double f : {x, y, 1e9, -1e9, 1e9}) interleaved.push_back(float(f));
        apart[0].push_back(x);
        apart[1].push_back(y);
    }
    CHECK(binds_alike(arrays));
    CHECK(binds_alike(floats));
    CHECK(binds_alike(glms));
    CHECK(binds_alike(glm_floats));
    CHECK(binds_alike(columns));
    CHECK(binds_alike(c_array));
    CHECK(binds_alike(std::span<const Vec<double, 2>>(plain)));
    CHECK(binds_alike(std::to_array<Vec<float, 2>>({{1, 1}, {2, 3}, {0.5f, 2.5f}, {3.25f, 0.75f}, {2, 4}})));
    CHECK(binds_alike(cageform::points_in_rows<2>(rows)));
    CHECK(binds_alike(cageform::points_in_rows<2>(row_major)));
    CHECK(binds_alike(cageform::points_in_columns<2>(wide)));
    CHECK(binds_alike(cageform::StridedPoints<const float, 2>(interleaved.data(), 5, 5 * sizeof(float))));
    // Points in two arrays: the axis stride is the distance of the arrays.
    std::vector<double> both(apart[0]);
    both.insert(both.end(), apart[1].begin(), apart[1].end());
    CHECK(binds_alike(
        cageform::StridedPoints<const double, 2>(both.data(), 5, sizeof(double), 5 * sizeof(double))));
}

TEST_CASE("a double too large for a float binding is not finite there", "[binding][ranges]") {
    const auto [binding, report] =
        cageform::bind(Mean<float>(square<float>), std::vector<Vec<double, 2>>{{1, 1}, {1e300, 1}, {1, 1e9}});
    REQUIRE(report.status == Status::ok);
    CHECK(report.not_finite == Indices{1});
    CHECK(report.outside == Indices{2});
}

TEST_CASE("a user's coordinate type can be bound", "[binding][concept]") {
    const AreaCoordinates coordinates({{{0, 0}, {4, 0}, {0, 2}}});
    const std::vector<Vec<double, 2>> points{
        {1, 0.5}, {9, 9}, {0.125, 1}, {2, 0.25}, {not_a_number<double>, 0}};
    const auto [binding, report] = cageform::bind(coordinates, points);
    REQUIRE(report.status == Status::ok);
    CHECK(report.outside == Indices{1});
    CHECK(report.unreached == Indices{2});
    CHECK(report.not_finite == Indices{4});
    CHECK(report.on_boundary.empty());
    const auto own = row_of(binding, 0);
    CHECK(difference(own, std::array{0.5, 0.25, 0.25}) <= 1e-15);
    const auto moved = cloned(binding, {{1, 1}, {5, 1}, {1, 3}});
    CHECK(distance(moved[0], Vec<double, 2>{2, 1.5}) <= 1e-14);
    CHECK(moved[1] == points[1]); // no extension
    CHECK(moved[2] == points[2]); // unreached
    CHECK(distance(moved[3], Vec<double, 2>{3, 1.25}) <= 1e-14);

    const auto followed = cageform::bind(coordinates, points, {.outside = OutsidePoints::nearest_boundary});
    const auto with_corner = cloned(followed.value, {{1, 1}, {4, 0}, {0, 2}});
    CHECK(with_corner[1] == Vec<double, 2>{10, 10}); // with the corner returned by nearest_boundary
    CHECK(with_corner[2] == points[2]);
}

TEMPLATE_TEST_CASE("linear precision of a degraded coordinate type is restored", "[binding][concept]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    const Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    const auto points = points_about(cage, 100, 0, std::uint64_t(seed) + 700);
    const auto [binding, report] = cageform::bind(Thinned<T>(cage), points);
    REQUIRE(report.status == Status::ok);
    Random random{std::uint64_t(seed)};
    const double scale = size_of(cage.vertices());
    const auto map = random_affine<2>(random, scale);
    const auto pose = map(cage.vertices());
    const auto moved = cloned(binding, pose);
    for (std::size_t i = 0; i < points.size(); ++i)
        CHECK(distance(moved[i], map(points[i])) <= 32 * double(epsilon<T>) * std::max(scale, size_of(pose)));
}

TEST_CASE("bindings of simplices in one to four dimensions", "[binding][dimensions]") {
    const auto seed = GENERATE(seeds(10));
    CAPTURE(seed);
    const auto check = [&]<std::size_t D>(std::integral_constant<std::size_t, D>) {
        Random random(std::uint64_t(seed) + D);
        const auto corners = random_simplex<double, D>(std::uint64_t(seed));
        std::vector<Vec<double, D>> points;
        for (int i = 0; i < 20; ++i)
            points.push_back(cageform::vec_cast<double>(combine(random_shares(D + 1, random), corners)));
        points.push_back(corners[0]);
        const auto [binding, report] =
            cageform::bind(cageform::BarycentricCoordinates<double, D>(corners), points);
        REQUIRE(report.status == Status::ok);
        CHECK(report.on_boundary == Indices{20});
        CHECK(report.outside.empty());
        const double rounding = 8 * epsilon<double>;
        CHECK(report.partition_error.value <= rounding);
        CHECK(report.reproduction_error.value <= rounding * size_of(corners));
        CHECK(report.least_weight.value >=
              -256 * epsilon<double>); // the corner's weight is an affine function
        CHECK(cloned(binding, corners) == points);
    };
    check(std::integral_constant<std::size_t, 1>{});
    check(std::integral_constant<std::size_t, 2>{});
    check(std::integral_constant<std::size_t, 3>{});
    check(std::integral_constant<std::size_t, 4>{});
}

namespace elsewhere {
// A program that uses both namespaces, with arguments that belong to std: std::bind must not be found
// instead.
using namespace cageform; // NOLINT(google-build-using-namespace): what is tested

auto bound() {
    const MeanValueCoordinates<double, 2> c(square<double>);
    const std::vector<std::array<double, 2>> points{{1, 1}};
    return bind(c, points);
}
auto bound_by_default_options() {
    const MeanValueCoordinates<float, 2> c(square<float>);
    const std::vector<std::array<float, 2>> points{{1, 1}};
    return bind(c, points, {});
}
} // namespace elsewhere

TEST_CASE("an unqualified call of bind never finds std::bind", "[binding][names]") {
    STATIC_REQUIRE(std::is_same_v<decltype(elsewhere::bound()),
                                  cageform::Result<cageform::Binding<double, 2>, cageform::BindReport>>);
    CHECK(elsewhere::bound().report.status == Status::ok);
    CHECK(elsewhere::bound_by_default_options().report.status == Status::ok);
}

TEST_CASE("points of another dimension do not compile", "[binding][concept]") {
    using Bind = decltype(cageform::bind);
    STATIC_REQUIRE(std::is_invocable_v<Bind, const Mean<double>&, const std::vector<Vec<float, 2>>&>);
    STATIC_REQUIRE(!std::is_invocable_v<Bind, const Mean<double>&, const std::vector<Vec<double, 3>>&>);
    STATIC_REQUIRE(!std::is_invocable_v<Bind, const Mean<double>&, const std::vector<double>&>);
    STATIC_REQUIRE(!std::is_invocable_v<Bind, int, const std::vector<Vec<double, 2>>&>);
}

} // namespace bind_tests
