// The fewest pieces that meet a tolerance.
#include "animate/curves.hpp"
#include "catch.hpp"

#include <cageform/animate/fit.hpp>

namespace fit_tests {

using namespace cageform_tests;
using cageform::fit;
using enum FitCondition;

namespace {

/// The fewest pieces with ends on a grid of `steps` parameters, by breadth-first search; 0 if none.
std::size_t fewest_on_grid(const BezierCurve& curve, double tolerance, const FitOptions& options,
                           std::size_t steps) {
    const SobolevFitter fitter(curve, options);
    std::vector<std::size_t> least(steps + 1, 0); // pieces up to here
    for (std::size_t k = 1; k <= steps; ++k) {
        for (std::size_t j = 0; j < k; ++j) {
            if ((j > 0 && least[j] == 0) || (least[k] > 0 && least[j] + 1 >= least[k])) continue;
            const auto piece = fitter.fit_piece(double(j) / double(steps), double(k) / double(steps));
            if (piece.solved && fitter.largest_error(piece) <= tolerance) least[k] = least[j] + 1;
        }
    }
    return least[steps];
}

FitOptions with(FitCondition conditions, std::size_t degree = 3) {
    FitOptions options;
    options.conditions = conditions;
    options.degree = degree;
    return options;
}

} // namespace

TEST_CASE("every tolerance is met", "[animate][fit][tolerance][property]") {
    const auto seed = GENERATE(seeds(300));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 7);
    const auto curve = random_curve(random, seed % 3 == 0 ? 1e-5 : 0.02);
    constexpr std::array<std::size_t, 4> numbers{3, 3, 13,
                                                 7}; // 7 is III with continuous and prescribed slopes
    auto options = with(configuration(numbers[random.below(3)]), 3 + random.below(3));
    const double height = height_of(curve), tolerance = height * std::pow(10.0, random.uniform(-6, -1));
    const auto result = fit(curve, tolerance, options);
    CAPTURE(tolerance, options.degree, unsigned(options.conditions), result.value.pieces());
    REQUIRE(result.status() == Status::ok);
    CHECK(result.report.sup_error <= tolerance);
    const auto error = sampled_error(result.value, curve, 2000);
    CHECK(error.sampled <= tolerance * (1 + 1e-9));
    CHECK(result.report.sup_error >= error.sampled - 1e-13 * height);
    CHECK(result.report.sup_error <= error.polished + 1e-9 * height);
    CHECK(result.value.knots.front() == curve.begin());
    CHECK(result.value.knots.back() == curve.end());
    CHECK(result.value.knots.size() == result.value.parameters.size());
    CHECK(result.value.bernstein.size() == result.value.pieces() * (options.degree + 1));
    CHECK(result.value.free_coefficients <= result.value.bernstein.size());
    for (std::size_t i = 0; i < result.value.pieces(); ++i)
        CHECK(result.value.knots[i] < result.value.knots[i + 1]);
    // The conditions hold.
    const auto conditions = conditions_of(result.value, curve, options.conditions);
    const Eigen::VectorXd v =
        Eigen::Map<const Eigen::VectorXd>(result.value.bernstein.data(), long(result.value.bernstein.size()));
    CHECK((conditions.a * v - conditions.d).lpNorm<Eigen::Infinity>() <= 1e-9 * height);
    // The result equals that of a fit with those knots given.
    const auto again = cageform::fit_pieces(curve, result.value.parameters, options);
    REQUIRE(again.status() == Status::ok);
    CHECK(again.report.sup_error == Approx(result.report.sup_error).epsilon(1e-9).margin(1e-14 * height));
    CHECK(again.report.w12_error() == Approx(result.report.w12_error()).epsilon(1e-9));
}

TEST_CASE("no knots on a fine grid need fewer pieces", "[animate][fit][tolerance][property]") {
#if defined(CAGEFORM_SANITIZED)
    constexpr int curves = 10;
#else
    constexpr int curves = 60;
#endif
    for (int seed = 0; seed < curves; ++seed) {
        Random random(std::uint64_t(seed) + 19);
        const auto curve = seed < 10 ? test_curves[std::size_t(seed)] : random_normal_curve(random);
        const auto options = with(end_value | knot_value, 3 + random.below(3));
        const double tolerance =
            seed % 2 == 0 ? cageform::screen_tolerance : std::pow(10.0, random.uniform(-5, -2));
        const auto result = fit(curve, tolerance, options);
        const std::size_t fewest = fewest_on_grid(curve, tolerance, options, 100);
        CAPTURE(seed, tolerance, options.degree);
        REQUIRE(result.status() == Status::ok);
        if (fewest > 0) CHECK(result.value.pieces() <= fewest); // 0: the grid is too coarse for the curve
    }
}

TEST_CASE("coupled pieces meet every tolerance with the fewest pieces", "[animate][fit][tolerance]") {
    for (std::size_t c = 0; c < 10; ++c) {
        for (const std::size_t number : {2u, 4u, 16u}) {
            CAPTURE(c + 1, number);
            const auto options = with(configuration(number));
            const double tolerance = 1.0 / 256;
            const auto result = fit(test_curves[c], tolerance, options);
            REQUIRE(result.status() == Status::ok);
            CHECK(result.report.sup_error <= tolerance);
            if (result.value.pieces() == 1) continue;
            // At the optimal knots in the W12 norm, as documented.
            const auto search = cageform::optimal_knots(test_curves[c], result.value.pieces() - 1, {options});
            if (search.status() != Status::ok) continue;
            const auto fewer = cageform::fit_pieces(test_curves[c], search.value.parameters, options);
            CHECK(fewer.report.sup_error > tolerance);
        }
    }
}

TEST_CASE("vertical tangents: tolerances are met", "[animate][fit][tolerance][vertical]") {
    for (const auto& curve :
         {bezier(0, 1, 0.5, 1), bezier(0.5, 0, 1, 0.5), bezier(0, 0.5, 1, 0.2), bezier(1, 0, 0, 1),
          bezier(4. / 3, 0.2, 2. / 3, 0.9), bezier(0, 0, 0, 1), bezier(1, 0, 1, 1), bezier(0, 0, 1, 1)}) {
        for (const double tolerance : {0.1, 0.01, cageform::screen_tolerance, 1e-4}) {
            for (const double slope_weight : {0.0, 1.0}) {
                CAPTURE(curve.points[1][0], curve.points[2][0], tolerance, slope_weight);
                FitOptions options;
                options.slope_weight = slope_weight;
                const auto result = fit(curve, tolerance, options);
                REQUIRE(result.status() == Status::ok);
                CHECK(result.report.sup_error <= tolerance);
                CHECK(sampled_error(result.value, curve, 4000).sampled <= tolerance * (1 + 1e-9));
            }
        }
    }
}

TEST_CASE("a straight line is one piece", "[animate][fit][tolerance]") {
    const auto line = moved(bezier(0.3, 0.3, 0.8, 0.8), 2, 5, -1, 7);
    const auto result = fit(line, 1e-9);
    REQUIRE(result.status() == Status::ok);
    CHECK(result.value.pieces() == 1);
    CHECK(result.report.sup_error <= 1e-14 * 10);
    const auto flat = moved(bezier(0.3, 0, 0.8, 0), 0, 1, 3, 0);
    CHECK(fit(flat, 1e-9).value.pieces() == 1);
    CHECK(fit(flat, 1e-9).report.sup_error <= 1e-15);
}

TEST_CASE("unreachable tolerances and invalid input are rejected with a status",
          "[animate][fit][tolerance]") {
    const auto good = bezier(0.3, 0.4, 0.6, 1.2);
    REQUIRE(fit(good, 0.01).status() == Status::ok);
    const double not_a_number = std::numeric_limits<double>::quiet_NaN();
    for (const double tolerance : {0.0, -1.0, not_a_number})
        CHECK(fit(good, tolerance).status() == Status::tolerance_not_positive);
    const auto best = fit(test_curves[4], 1e-6, {.max_pieces = 3});
    CHECK(best.status() == Status::tolerance_not_met);
    CHECK(best.value.pieces() == 3);
    CHECK(best.report.w12_error() == Approx(0.183608).epsilon(0.005)); // the optimum of three pieces
    auto three = with(end_value | knot_c0);
    three.max_pieces = 3;
    const auto tied = fit(test_curves[4], 1e-6, three);
    CHECK(tied.status() == Status::tolerance_not_met);
    CHECK(tied.value.pieces() == 3);
    auto curve = good;
    curve.points[1][1] = not_a_number;
    CHECK(fit(curve, 0.01).status() == Status::value_not_finite);
    curve = good;
    std::swap(curve.points[0], curve.points[3]);
    CHECK(fit(curve, 0.01).status() == Status::interval_empty);
    CHECK(fit(bezier(1.3, 0, .3, 1), 0.01).status() == Status::time_not_monotone);
    CHECK(fit(good, 0.01, with(end_value | knot_value, 6)).status() == Status::degree_not_supported);
    FitOptions weights;
    weights.value_weight = 0;
    CHECK(fit(good, 0.01, weights).status() == Status::weights_not_positive);
    CHECK(fit(good, 0.01, with(end_value | knot_value | end_d1 | knot_d1 | end_d2 | knot_d2)).status() ==
          Status::too_many_conditions);
    CHECK(fit(bezier(0, 1, 0.5, 1), 0.01, with(end_value | knot_value | end_d1)).status() ==
          Status::slope_unbounded);
    CHECK(fit(good, 0.01, with(end_value | knot_c0 | knot_value)).status() ==
          Status::ok); // one piece has no inner knot
    three = with(end_value | knot_c0 | knot_value);
    three.max_pieces = 3;
    CHECK(fit(good, 1e-5, three).status() == Status::too_many_conditions);
}

TEST_CASE("in the sup norm no small change of a piece lowers the maximum error",
          "[animate][fit][sup][property]") {
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 70);
    const auto curve = random_normal_curve(random);
    auto options = with(end_value | knot_value, 3 + random.below(3));
    const auto plain = cageform::fit_pieces(curve, cageform::uniform_in_parameter(2), options);
    options.norm = cageform::FitNorm::sup;
    const auto refined = cageform::fit_pieces(curve, cageform::uniform_in_parameter(2), options);
    REQUIRE(refined.status() == Status::ok);
    CHECK(refined.report.sup_error <= plain.report.sup_error);
    CHECK(refined.report.w12_error() >= plain.report.w12_error() * (1 - 1e-9));
    const SobolevFitter fitter(curve, options);
    for (const auto& [begin, end] : {std::pair(0.0, 0.5), std::pair(0.5, 1.0)}) {
        const auto piece = fitter.fit_piece(begin, end);
        const double error = fitter.largest_error(piece);
        for (int n = 0; n < 60; ++n) {
            auto other = piece;
            for (std::size_t k = 1; k < options.degree; ++k)
                other.polynomial.c[k] += error * random.uniform(-0.3, 0.3);
            CHECK(fitter.largest_error(other) >= 0.97 * error);
        }
    }
    // It never needs more pieces.
    const double tolerance = 1e-3;
    CHECK(fit(curve, tolerance, options).value.pieces() <=
          fit(curve, tolerance, with(end_value | knot_value, options.degree)).value.pieces());
    options.conditions = end_value | knot_c0;
    CHECK(fit(curve, tolerance, options).status() == Status::norm_not_supported);
}

} // namespace fit_tests
