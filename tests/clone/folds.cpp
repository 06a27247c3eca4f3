// Folds: determinants and singular values against their definitions, steps against bisection.
#include "../support/allocation_count.hpp"
#include "../support/effort.hpp"
#include "../support/larger.hpp"
#include "../support/packed.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/folds.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <Eigen/SVD>

#include <functional>

namespace folds_tests {

using namespace cageform_tests;
using cageform::FoldReport;
using cageform::largest_step;
using cageform::report_folds;
using cageform::StepReport;
using cageform::detail::Columns;

namespace {

template <std::size_t D>
Columns<D> random_matrix(Random& random) {
    Columns<D> m{};
    for (auto& column : m) {
        for (double& x : column.v) x = random.uniform(-1, 1);
    }
    return m;
}

template <std::size_t D>
Eigen::Matrix<double, int(D), int(D)> eigen(const Columns<D>& m) {
    Eigen::Matrix<double, int(D), int(D)> result;
    for (std::size_t j = 0; j < D; ++j) {
        for (std::size_t i = 0; i < D; ++i) result(Eigen::Index(i), Eigen::Index(j)) = m[j][i];
    }
    return result;
}

/// A mesh whose cells fill a box of `n` cubes (squares) per axis, slightly perturbed at rest.
template <std::size_t D>
struct Box {
    std::vector<Vec<double, D>> rest;
    std::vector<std::array<std::uint32_t, D + 1>> cells;

    Box(std::size_t n, std::uint64_t seed) {
        Random random(seed);
        const std::size_t side = n + 1;
        const std::size_t count = D == 2 ? side * side : side * side * side;
        for (std::size_t i = 0; i < count; ++i) {
            Vec<double, D> p{};
            for (std::size_t k = 0, rest_of = i; k < D; ++k, rest_of /= side)
                p[k] = (double(rest_of % side) + random.uniform(-0.1, 0.1)) / double(n);
            rest.push_back(p);
        }
        // A cube splits into one simplex per permutation of the axes.
        std::array<std::size_t, D> axes{}, step{};
        for (std::size_t k = 0; k < D; ++k) {
            axes[k] = k;
            step[k] = k == 0 ? 1 : step[k - 1] * side;
        }
        for (std::size_t i = 0; i < count; ++i) {
            bool inside = true;
            for (std::size_t k = 0, rest_of = i; k < D; ++k, rest_of /= side)
                inside = inside && rest_of % side < n;
            if (!inside) continue;
            auto order = axes;
            do {
                std::array<std::uint32_t, D + 1> cell{};
                cell[0] = std::uint32_t(i);
                for (std::size_t k = 0; k < D; ++k) cell[k + 1] = std::uint32_t(cell[k] + step[order[k]]);
                cells.push_back(cell);
            } while (std::next_permutation(order.begin(), order.end()));
        }
    }

    /// V'/V of a cell, in long double.
    double volume_ratio(std::size_t cell, const std::vector<Vec<double, D>>& posed) const {
        const auto volume = [&](const std::vector<Vec<double, D>>& points) {
            std::array<Vec<long double, D>, D> e;
            const auto& c = cells[cell];
            for (std::size_t k = 0; k < D; ++k)
                e[k] = cageform::vec_cast<long double>(points[c[k + 1]]) -
                       cageform::vec_cast<long double>(points[c[0]]);
            if constexpr (D == 2) {
                return cross(e[0], e[1]);
            } else {
                return dot(e[0], cross(e[1], e[2]));
            }
        };
        return double(volume(posed) / volume(rest));
    }
};

/// The box bent around an axis by `turn` radians in total, and perturbed.
template <std::size_t D>
std::vector<Vec<double, D>> bent(const std::vector<Vec<double, D>>& rest, double turn, double shake,
                                 std::uint64_t seed) {
    Random random(seed);
    auto posed = rest;
    for (auto& p : posed) {
        const double angle = turn * p[0], x = p[0] - 0.5, y = p[1] - 0.5;
        p[0] = std::cos(angle) * x - std::sin(angle) * y;
        p[1] = std::sin(angle) * x + std::cos(angle) * y;
        for (double& c : p.v) c += random.uniform(-shake, shake);
    }
    return posed;
}

template <std::size_t D>
std::vector<Vec<double, D>> between(const std::vector<Vec<double, D>>& from,
                                    const std::vector<Vec<double, D>>& to, double t) {
    auto result = from;
    for (std::size_t i = 0; i < from.size(); ++i) result[i] = from[i] + t * (to[i] - from[i]);
    return result;
}

/// The first t in [0, 1] where `ratio(t)` is not above a threshold, by samples and bisection; else 2.
double by_bisection(const std::function<double(double)>& ratio, double threshold, int samples) {
    double above = 0;
    for (int n = 0; n <= samples; ++n) {
        double below = double(n) / samples;
        if (ratio(below) > threshold) {
            above = below;
            continue;
        }
        if (n == 0) return 0;
        for (int halved = 0; halved < 60; ++halved) {
            const double middle = (above + below) / 2;
            (ratio(middle) > threshold ? above : below) = middle;
        }
        return above;
    }
    return 2;
}

} // namespace

TEMPLATE_TEST_CASE_SIG("singular values are those of Eigen, also for singular and nearly singular matrices",
                       "[folds]", ((std::size_t D), D), 2, 3) {
    Random random(1);
    for (int n = 0; n < effort(20000, 2000); ++n) {
        auto m = random_matrix<D>(random);
        const double flat = std::pow(10.0, random.uniform(-12, 0)),
                     scale = std::pow(10.0, random.uniform(-20, 20));
        if (n % 3 == 1) m[D - 1] = m[0] + flat * m[D - 1];
        if (n % 7 == 2) m = {}; // a similarity
        for (std::size_t k = 0; n % 7 == 2 && k < D; ++k) m[k][(k + 1) % D] = 1;
        for (auto& column : m) column = scale * column;
        const auto values = cageform::detail::singular_values(m);
        const auto expected = eigen<D>(m).jacobiSvd().singularValues();
        CAPTURE(n, flat, scale);
        CHECK(std::fabs(values.largest - expected(0)) <= 1e-14 * expected(0));
        // Rounding of the matrix changes singular values by 1e-16 of the largest.
        CHECK(std::fabs(values.least - expected(D - 1)) <= 1e-14 * expected(0));
    }
    CHECK(cageform::detail::singular_values(Columns<D>{}).largest == 0);
    CHECK(cageform::detail::singular_values(Columns<D>{}).least == 0);
}

TEMPLATE_TEST_CASE_SIG("the first fold along a line is the first root, known from its factors", "[folds]",
                       ((std::size_t D), D), 2, 3) {
    // det(A + t B) = det(A) Π (1 − t / r_k), for B = A diag(−1 / r_k).
    Random random(2);
    int found = 0;
    for (int n = 0; n < effort(20000, 2000); ++n) {
        auto a = random_matrix<D>(random);
        if (cageform::detail::determinant(a) < 0) std::swap(a[0], a[1]);
        const double volume = cageform::detail::determinant(a);
        if (volume < 1e-2) continue;
        Columns<D> b;
        std::array<double, D> roots;
        double first = 2;
        for (std::size_t k = 0; k < D; ++k) {
            roots[k] = random.uniform(-3, 3);
            if (std::fabs(roots[k]) < 1e-3) roots[k] = 1e-3;
            b[k] = (-1 / roots[k]) * a[k];
            if (roots[k] > 0 && roots[k] < first) first = roots[k];
        }
        std::sort(roots.begin(), roots.end());
        bool apart = std::fabs(first - 1) > 1e-6;
        for (std::size_t k = 1; k < D; ++k) apart = apart && roots[k] - roots[k - 1] > 1e-3;
        if (!apart) continue; // a double root may be missed
        CAPTURE(n, first);
        const double fold = cageform::detail::DeterminantAlong<D>(a, b, 1 / volume, 0).first_fold();
        if (first < 1) {
            CHECK(std::fabs(fold - first) <= 1e-9 * first);
            ++found;
        } else {
            CHECK(fold == 2);
        }
    }
    CHECK(found > effort(3000, 300));
    // Lower degrees: no change, and a single axis.
    Columns<D> one{}, change{};
    for (std::size_t k = 0; k < D; ++k) one[k][k] = 1;
    CHECK(cageform::detail::DeterminantAlong<D>(one, change, 1, 0).first_fold() == 2);
    change[1][1] = -4;
    CHECK(std::fabs(cageform::detail::DeterminantAlong<D>(one, change, 1, 0.5).first_fold() - 0.125) <=
          1e-15);
    CHECK(cageform::detail::DeterminantAlong<D>(one, change, 1, 1).first_fold() == 0);
}

TEMPLATE_TEST_CASE_SIG("cells that fold are those whose volume changes its sign", "[folds][cells]",
                       ((std::size_t D), D), 2, 3) {
    const std::uint64_t seed = GENERATE(range(std::uint64_t{1}, std::uint64_t{7}));
    CAPTURE(seed);
    const Box<D> box(D == 2 ? 12 : 4, seed);
    const double threshold = std::array{0.0, 0.3, -0.2}[seed % 3];
    const auto posed = bent(box.rest, 1, seed % 2 == 0 ? 0.15 : 0.05, seed + 10);
    const FoldReport report = report_folds(box.rest, posed, box.cells, {threshold});
    REQUIRE(report.status == Status::ok);
    std::vector<std::size_t> folded;
    double least = 2;
    std::size_t at = 0;
    for (std::size_t c = 0; c < box.cells.size(); ++c) {
        const double ratio = box.volume_ratio(c, posed);
        REQUIRE(std::fabs(ratio - threshold) > 1e-9); // rounding must not decide
        if (ratio <= threshold) folded.push_back(c);
        if (ratio < least) {
            least = ratio;
            at = c;
        }
    }
    CHECK(report.count == folded.size());
    for (std::size_t n = 0; n < std::min(folded.size(), report.folded.size()); ++n)
        CHECK(report.folded[n] == folded[n]);
    CHECK(std::fabs(report.least_determinant - least) <= 1e-10);
    CHECK(report.least_determinant_at == at);
    CHECK(report.skipped == 0);
    // Ratios depend neither on the size of rest and pose nor on the orientation of cells at rest.
    auto larger_rest = box.rest;
    auto larger_pose = posed;
    for (auto* points : {&larger_rest, &larger_pose}) {
        for (auto& p : *points) p = 1e6 * p;
    }
    auto turned = box.cells;
    for (auto& cell : turned) std::swap(cell[0], cell[1]);
    for (const auto& again : {report_folds(larger_rest, larger_pose, box.cells, {threshold}),
                              report_folds(box.rest, posed, turned, {threshold})}) {
        CHECK(again.count == report.count);
        CHECK(again.folded == report.folded);
        CHECK(std::fabs(again.largest_stretch - report.largest_stretch) <= 1e-9 * report.largest_stretch);
        CHECK(again.largest_stretch_at == report.largest_stretch_at);
        CHECK(std::fabs(again.least_stretch - report.least_stretch) <= 1e-9);
    }
    // The pose at rest has no folds.
    const FoldReport still = report_folds(box.rest, box.rest, box.cells);
    CHECK(still.count == 0);
    for (const double one : {still.least_determinant, still.largest_stretch, still.least_stretch})
        CHECK(std::fabs(one - 1) <= 1e-12);
}

TEMPLATE_TEST_CASE_SIG("the largest step of cells is that of bisection, and leaves no fold",
                       "[folds][cells][step]", ((std::size_t D), D), 2, 3) {
    const std::uint64_t seed = GENERATE(range(std::uint64_t{1}, std::uint64_t{10}));
    CAPTURE(seed);
    const Box<D> box(D == 2 ? 8 : 3, seed);
    const double threshold = std::array{0.0, 0.25, -0.5}[seed % 3];
    const auto from = bent(box.rest, 0.2, 0.01, seed + 20);
    const auto to = bent(box.rest, double(seed) / 2, 0.1, seed + 30);
    const StepReport report = largest_step(box.rest, from, to, box.cells, {threshold});
    REQUIRE(report.status == Status::ok);
    double expected = 2;
    for (std::size_t c = 0; c < box.cells.size(); ++c) {
        const double first = by_bisection([&](double t) { return box.volume_ratio(c, between(from, to, t)); },
                                          threshold, effort(50, 10));
        expected = std::min(expected, first);
    }
    CHECK(report.step == (expected > 1 ? 1 : report.step));
    CHECK(std::fabs(report.step - std::min(expected, 1.0)) <= 1e-6);
    CHECK(report_folds(box.rest, between(from, to, report.step), box.cells, {threshold}).count == 0);
    if (expected > 1) {
        CHECK(report.culprit == StepReport::nowhere);
    } else {
        REQUIRE(report.culprit < box.cells.size());
        CHECK(std::fabs(box.volume_ratio(report.culprit, between(from, to, report.step)) - threshold) <=
              1e-6);
        const auto over =
            report_folds(box.rest, between(from, to, report.step * (1 + 1e-6)), box.cells, {threshold});
        CHECK(over.count > 0);
    }
    // From a folded pose, the step is 0.
    const auto folded = report_folds(box.rest, to, box.cells, {threshold});
    if (folded.count == 0) return;
    const StepReport back = largest_step(box.rest, to, from, box.cells, {threshold});
    CHECK(back.step == 0);
    CHECK(back.culprit == folded.folded[0]);
}

namespace {

/// Jacobians of points inside a star, and a pose that drags some of its vertices.
template <class T>
struct Dragged {
    std::vector<Vec<T, 2>> rest, pose, points;
    std::array<cageform::Binding<T, 2>, 2> columns;

    explicit Dragged(std::uint64_t seed)
        : rest(random_star<T>(seed))
        , pose(rest) {
        Random random(seed);
        const cageform::Polygon<T> cage(rest);
        for (int n = 0; n < 300; ++n) points.push_back(random_inside(cage, random, 0.01));
        const T size = T(size_of(rest)) / 3;
        for (auto& p : pose) p = p + size * Vec<T, 2>{T(random.uniform(-1, 1)), T(random.uniform(-1, 1))};
        columns = cageform::bind_jacobians(cageform::MeanValueCoordinates<T, 2>(cage), points).value;
    }

    double determinant(std::size_t i, const std::vector<Vec<T, 2>>& at) const {
        return double(cageform::cross(by_definition(columns[0], at, i), by_definition(columns[1], at, i)));
    }
};

} // namespace

TEMPLATE_TEST_CASE("folds at points, and the step to them, by bound Jacobians", "[folds][step]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const std::uint64_t seed = GENERATE(range(std::uint64_t{1}, std::uint64_t{9}));
    CAPTURE(seed);
    const Dragged<T> dragged(seed);
    const double digits = 1e3 * double(cageform::epsilon<T>);
    const auto& columns = dragged.columns;
    const FoldReport report = report_folds(columns, dragged.pose);
    REQUIRE(report.status == Status::ok);
    CHECK(report.skipped == 0);
    std::size_t surely = 0, perhaps = 0;
    double least = 1e9, scale = report.largest_stretch * report.largest_stretch;
    for (std::size_t i = 0; i < dragged.points.size(); ++i) {
        const double here = dragged.determinant(i, dragged.pose);
        surely += here < -digits * scale ? 1 : 0;
        perhaps += here < digits * scale ? 1 : 0;
        least = std::min(least, here);
    }
    CHECK(report.count >= surely);
    CHECK(report.count <= perhaps);
    CHECK(std::fabs(report.least_determinant - least) <= digits * scale);
    const StepReport step = largest_step(columns, dragged.rest, dragged.pose);
    REQUIRE(step.status == Status::ok);
    double expected = 2;
    for (std::size_t i = 0; i < dragged.points.size(); ++i) {
        // Jacobians are linear in the step.
        const auto j = [&](std::size_t k, const std::vector<Vec<T, 2>>& pose) {
            return by_definition(columns[k], pose, i);
        };
        const Vec<long double, 2> x0 = j(0, dragged.rest), x1 = j(0, dragged.pose), y0 = j(1, dragged.rest),
                                  y1 = j(1, dragged.pose);
        expected = std::min(expected, by_bisection(
                                          [&](double t) {
                                              const auto s = static_cast<long double>(t);
                                              return double(cross(x0 + s * (x1 - x0), y0 + s * (y1 - y0)));
                                          },
                                          0, 100));
    }
    CHECK(std::fabs(step.step - std::min(expected, 1.0)) <= (sizeof(T) == 4 ? 1e-3 : 1e-6));
    CHECK((step.culprit == StepReport::nowhere) == (step.step == 1));
    // At the step nothing folds, as computed by the library.
    std::vector<Vec<double, 2>> there;
    for (std::size_t h = 0; h < dragged.rest.size(); ++h) {
        const auto a = cageform::vec_cast<double>(dragged.rest[h]);
        there.push_back(a + step.step * (cageform::vec_cast<double>(dragged.pose[h]) - a));
    }
    CHECK(report_folds(columns, there).count == 0);
    // Packed with reordered points: places do not depend on the order.
    std::array<cageform::PackedBinding<T, 2>, 2> packed;
    std::array<PackedBindingView<T, 2>, 2> views;
    std::vector<std::uint32_t> order(dragged.points.size());
    for (std::size_t n = 0; n < order.size(); ++n) order[n] = std::uint32_t(n * 7 % order.size());
    for (std::size_t k = 0; k < 2; ++k) {
        packed[k] = cageform::pack(columns[k], {.format = WeightFormat::int16}).value;
        views[k] = packed[k].view();
        views[k].order = order.data();
    }
    const FoldReport of_packed = report_folds(views, dragged.pose);
    CHECK(of_packed.status == Status::ok);
    CHECK(of_packed.least_determinant_at == order[report.least_determinant_at]);
}

TEST_CASE("three axes in space: cubics by bound Jacobians", "[folds][step]") {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        CAPTURE(seed);
        std::array<cageform::Binding<double, 3>, 3> columns;
        for (std::size_t k = 0; k < 3; ++k) {
            // Axis k at rest, and random weights.
            auto [weights, rest] = random_binding<double, 3>(100, 8, 10 * seed + k).release();
            for (std::size_t row = 0; row < rest.size(); ++row) {
                for (double& x : rest[row].v) x = row % 3 == k ? 1 : 0;
            }
            columns[k] = {std::move(weights), std::move(rest), random_points<double, 3>(8, 1, 7), 100};
        }
        const auto rest = binding_handles(columns[0]);
        const auto pose = random_points<double, 3>(8, 2, seed + 8);
        const StepReport step = largest_step(columns, rest, pose);
        REQUIRE(step.status == Status::ok);
        double expected = 2;
        for (std::size_t i = 0; i < 100; ++i) {
            const auto ratio = [&](double t) {
                const auto at = between(rest, pose, t);
                return double(dot(by_definition(columns[0], at, i),
                                  cross(by_definition(columns[1], at, i), by_definition(columns[2], at, i))));
            };
            expected = std::min(expected, by_bisection(ratio, 0, 40));
        }
        CHECK(std::fabs(step.step - std::min(expected, 1.0)) <= 1e-6);
        CHECK(report_folds(columns, between(rest, pose, step.step)).count == 0);
    }
}

TEST_CASE("folds refuse invalid arguments, skip what is not finite, and allocate nothing",
          "[folds][status]") {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double infinite = std::numeric_limits<double>::infinity();
    const Box<2> box(3, 1);
    const Dragged<double> dragged(1);
    for (const double threshold : {1.0, 2.0, nan, infinite, -infinite}) {
        CHECK(report_folds(box.rest, box.rest, box.cells, {threshold}).status ==
              Status::threshold_not_supported);
        CHECK(report_folds(dragged.columns, dragged.rest, {threshold}).status ==
              Status::threshold_not_supported);
        CHECK(largest_step(box.rest, box.rest, box.rest, box.cells, {threshold}).status ==
              Status::threshold_not_supported);
        CHECK(largest_step(dragged.columns, dragged.rest, dragged.pose, {threshold}).status ==
              Status::threshold_not_supported);
    }
    const std::span<const Vec<double, 2>> few(box.rest.data(), 3), few_handles(dragged.rest.data(), 2);
    CHECK(report_folds(box.rest, few, box.cells).status == Status::pose_size_differs);
    CHECK(largest_step(box.rest, few, box.rest, box.cells).status == Status::pose_size_differs);
    CHECK(largest_step(box.rest, box.rest, few, box.cells).status == Status::pose_size_differs);
    CHECK(report_folds(dragged.columns, few_handles).status == Status::pose_size_differs);
    CHECK(largest_step(dragged.columns, dragged.rest, few_handles).status == Status::pose_size_differs);
    auto pose = dragged.pose;
    pose[1][0] = nan;
    CHECK(report_folds(dragged.columns, pose).status == Status::pose_not_finite);
    CHECK(largest_step(dragged.columns, pose, dragged.rest).status == Status::pose_not_finite);
    CHECK(report_folds(std::array{dragged.columns[0].view(), random_binding<double, 2>(7, 3, 1).view()}, pose)
              .status == Status::bindings_differ);
    auto cells = box.cells;
    cells[4][1] = std::uint32_t(box.rest.size());
    const FoldReport out_of_range = report_folds(box.rest, box.rest, cells);
    CHECK(out_of_range.status == Status::index_out_of_range);
    CHECK(out_of_range.culprit == 4);
    cells = box.cells;
    cells[5][2] = cells[5][1];
    const StepReport flat = largest_step(box.rest, box.rest, box.rest, cells);
    CHECK(flat.status == Status::degenerate_simplex);
    CHECK(flat.culprit == 5);
    // Cells with a corner that is not finite are skipped.
    auto posed = box.rest;
    posed[0][1] = nan;
    const FoldReport skipped = report_folds(box.rest, posed, box.cells);
    CHECK(skipped.status == Status::ok);
    CHECK(skipped.skipped == 2);
    CHECK(skipped.count == 0);
    CHECK(largest_step(box.rest, box.rest, posed, box.cells).step == 1);
    // More folds than listed, and no folds.
    const Box<3> many(3, 2);
    auto mirrored = many.rest;
    for (auto& p : mirrored) p[2] = -p[2];
    const std::size_t allocated = allocations;
    const FoldReport all = report_folds(many.rest, mirrored, many.cells);
    const StepReport step = largest_step(many.rest, many.rest, mirrored, many.cells);
    const FoldReport at_points = report_folds(dragged.columns, dragged.pose);
    const std::size_t after = allocations;
    CHECK(after == allocated);
    CHECK(at_points.status == Status::ok);
    CHECK(all.count == many.cells.size());
    CHECK(all.folded[63] == 63);
    CHECK(std::fabs(all.least_determinant + 1) <= 1e-12);
    CHECK(std::fabs(all.largest_stretch - 1) <= 1e-12); // a reflection does not stretch
    CHECK(std::fabs(step.step - 0.5) <= 1e-8);
    CHECK(
        report_folds(many.rest, mirrored, std::vector<std::array<std::uint32_t, 4>>{}).least_determinant_at ==
        FoldReport::nowhere);
    STATIC_REQUIRE(noexcept(report_folds(box.rest, posed, box.cells)));
}

} // namespace folds_tests
