// Fits in a Sobolev norm: reference cases, and laws for random curves.
#include "animate/curves.hpp"
#include "catch.hpp"
#include "support/larger.hpp"

#include <cageform/animate/fit/sobolev_fit.hpp>

#include <nlohmann/json.hpp>

#include <fstream>

namespace sobolev_fit_tests {

using namespace cageform_tests;
using cageform::contains;
using cageform::epsilon;
using cageform::fit_pieces;
using cageform::uniform_in_parameter;
using cageform::uniform_in_time;
using enum FitCondition;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

FitCondition condition_of(const std::string& name) {
    constexpr std::array names{"end_value", "knot_c0", "knot_value", "end_d1", "knot_c1",
                               "knot_d1",   "end_d2",  "knot_c2",    "knot_d2"};
    for (std::size_t k = 0; k < names.size(); ++k) {
        if (name == names[k]) return FitCondition(1u << k);
    }
    FAIL("unknown condition " << name);
    return none;
}

double largest(const std::vector<double>& values) {
    double most = 0;
    for (const double v : values) most = cageform_tests::larger(most, std::fabs(v));
    return most;
}
double difference(const std::vector<double>& a, const std::vector<double>& b) {
    if (a.size() != b.size()) return infinity;
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        most = std::fabs(a[i] - b[i]) <= most ? most : std::fabs(a[i] - b[i]);
    return most;
}

/// A random feasible fit: a curve, parameters of knots, conditions.
struct RandomFit {
    BezierCurve curve;
    std::vector<double> parameters;
    FitOptions options;
    BezierFit fit;
    cageform::FitReport report;
};
RandomFit random_fit(Random& random, const BezierCurve& curve) {
    RandomFit result;
    result.curve = curve;
    do {
        result.parameters = random_parameters(random, 1 + random.below(5));
        result.options.degree = 3 + random.below(3);
        result.options.conditions = configurations[random.below(configurations.size())];
        result.options.slope_weight = std::pow(10.0, random.uniform(-2, 1));
        result.options.scale_free = random.below(2) == 0;
        auto fitted = fit_pieces(curve, result.parameters, result.options);
        REQUIRE((fitted || fitted.status() == Status::too_many_conditions));
        result.fit = std::move(fitted.value);
        result.report = fitted.report;
    } while (result.report.status != Status::ok);
    return result;
}

/// A fit of a normal curve with the default norm.
cageform::Result<BezierFit, cageform::FitReport> fit_of(const BezierCurve& curve,
                                                        const std::vector<double>& parameters,
                                                        FitCondition conditions, std::size_t degree = 3) {
    FitOptions options;
    options.conditions = conditions;
    options.degree = degree;
    return fit_pieces(curve, parameters, options);
}

} // namespace

TEST_CASE("fits equal the reference cases", "[animate][fit][oracle]") {
    std::ifstream file(CAGEFORM_TEST_DATA "/bezier-cases.json");
    const auto cases = nlohmann::json::parse(file).at("cases");
    REQUIRE(cases.size() == 6);
    for (const auto& one : cases) {
        const auto id = one.at("id").get<std::string>();
        CAPTURE(id);
        BezierCurve curve;
        for (std::size_t k = 0; k < 4; ++k) {
            for (std::size_t axis = 0; axis < 2; ++axis)
                curve.points[k][axis] = one.at("control_points")[k][axis];
        }
        FitOptions options;
        options.degree = one.at("degree");
        options.value_weight = one.at("weights")[0];
        options.slope_weight = one.at("weights")[1];
        options.conditions = none;
        options.scale_free = false;
        for (const auto& name : one.at("conditions"))
            options.conditions = options.conditions | condition_of(name.get<std::string>());
        const auto& knots = one.at("knots");
        const auto& expected = one.at("expected");
        const auto mode = knots.at("mode").get<std::string>();
        const std::size_t pieces = knots.at("pieces");
        std::vector<double> parameters;
        if (mode == "uniform_x") parameters = uniform_in_time(curve, pieces);
        if (mode == "uniform_t") parameters = uniform_in_parameter(pieces);
        if (mode == "given") {
            for (const double x : knots.at("x"))
                parameters.push_back(cageform::BezierFunction(curve).parameter(x));
        }
        if (mode == "search_t") {
            const auto search =
                cageform::search_knots(curve, uniform_in_parameter(knots.at("K")), pieces, {options});
            REQUIRE(search.status() == Status::ok);
            CHECK(search.value.indices == expected.at("search_index").get<std::vector<std::size_t>>());
            parameters = search.value.parameters;
        }
        const auto fit = fit_pieces(curve, parameters, options);
        REQUIRE(fit.status() == Status::ok);
        const auto list = [&](const char* name) { return expected.at(name).get<std::vector<double>>(); };
        const double range = std::max(1.0, height_of(curve));
        CHECK(difference(fit.value.knots, list("knots_x")) <= 1e-12 * (1 + std::fabs(curve.end())));
        CHECK(difference(fit.value.parameters, list("knots_t")) <= 1e-12);
        std::vector<double> bernstein;
        for (const auto& piece : expected.at("bernstein"))
            bernstein.insert(bernstein.end(), piece.begin(), piece.end());
        CHECK(difference(fit.value.bernstein, bernstein) <= 1e-10 * range); // measured: 7e-15
        const auto error = [&](const char* name, double value) {
            CAPTURE(name, value);
            if (expected.at(name).is_null()) {
                CHECK(value == infinity);
                return;
            }
            const double e = expected.at(name);
            CHECK(std::fabs(value - e) <= 1e-9 * e + 1e-12);
        };
        error("l2_error", fit.report.l2_error);
        error("h1_semi_error", fit.report.slope_error);
        error("w12_error", fit.report.w12_error());
        const double sup = expected.at("sup_error");
        CHECK(std::fabs(fit.report.sup_error - sup) <= (sup > 0 ? 1e-9 * sup : 1e-12));
        CHECK(fit.value.free_coefficients == expected.at("free_coefficients").get<std::size_t>());
        // The position, unless the error is 0 or symmetry leaves two.
        if (!expected.at("sup_at_x").is_null() && mode != "uniform_t") {
            const double at = expected.at("sup_at_x");
            const double mirrored = curve.begin() + curve.end() - at;
            CHECK(std::min(std::fabs(fit.report.sup_at - at), std::fabs(fit.report.sup_at - mirrored)) <=
                  1e-6 * (1 + std::fabs(at)));
        }
        // The polynomials in powers of time, as curves.
        for (std::size_t i = 0; i < pieces; ++i) {
            const auto power = expected.at("power_x")[i].get<std::vector<double>>();
            for (int n = 0; n <= 10; ++n) {
                const double u = double(n) / 10,
                             x = fit.value.knots[i] + u * (fit.value.knots[i + 1] - fit.value.knots[i]);
                long double sum = 0;
                for (const double c : power) sum = sum * x + c;
                const auto value = piece_at(fit.value.coefficients(i), 1, u).value;
                CHECK(std::fabs(double(sum - value)) <= 1e-9 * largest(power));
            }
        }
    }
}

TEST_CASE("values in another unit give the same fit bit for bit", "[animate][fit][property]") {
    const auto seed = GENERATE(seeds(100));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 907);
    const auto some = random_fit(random, random_curve(random));
    const double unit = std::ldexp(1.0, int(random.below(1801)) - 900);
    CAPTURE(unit);
    BezierCurve curve = some.curve;
    for (auto& p : curve.points) p[1] *= unit;
    const auto fit = fit_pieces(curve, some.parameters, some.options);
    REQUIRE(fit.status() == Status::ok);
    for (std::size_t i = 0; i < fit.value.bernstein.size(); ++i)
        CHECK(fit.value.bernstein[i] == unit * some.fit.bernstein[i]);
    CHECK(fit.report.l2_error == unit * some.report.l2_error);
    CHECK(fit.report.slope_error == unit * some.report.slope_error);
    CHECK(fit.report.sup_error == unit * some.report.sup_error);
    CHECK(fit.report.sup_at == some.report.sup_at);
}

TEST_CASE("errors equal those of brute-force quadrature", "[animate][fit][property]") {
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 11);
    const auto [curve, parameters, options, fit, report] = random_fit(random, random_curve(random, 0.05));
    const auto slow = slow_errors(fit, curve);
    const double length = curve.end() - curve.begin(), height = height_of(curve);
    CHECK(report.l2_error == Approx(slow.l2).epsilon(1e-8).margin(1e-13 * height * std::sqrt(length)));
    CHECK(report.slope_error == Approx(slow.slope).epsilon(1e-8).margin(1e-12 * height / std::sqrt(length)));
}

TEST_CASE("the fit meets its conditions and is optimal under them", "[animate][fit][property]") {
    const auto seed = GENERATE(seeds(120));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 23);
    const auto [curve, parameters, options, fit, report] = random_fit(random, random_curve(random, 0.05));
    CAPTURE(unsigned(options.conditions), options.degree, parameters.size());
    const auto conditions = conditions_of(fit, curve, options.conditions);
    const Eigen::VectorXd v =
        Eigen::Map<const Eigen::VectorXd>(fit.bernstein.data(), long(fit.bernstein.size()));
    const double height = height_of(curve);
    if (conditions.a.rows() > 0)
        CHECK((conditions.a * v - conditions.d).lpNorm<Eigen::Infinity>() <= 1e-10 * height);
    CHECK(fit.free_coefficients == fit.bernstein.size() - std::size_t(conditions.a.rows()));

    // Stationary: changes in the free directions have no first-order effect. So the objective rises
    // by exactly the square of the change.
    Eigen::MatrixXd kernel = Eigen::MatrixXd::Identity(v.size(), v.size());
    if (conditions.a.rows() > 0) kernel = Eigen::FullPivLU<Eigen::MatrixXd>(conditions.a).kernel();
    const double length = curve.end() - curve.begin();
    const double w0 = options.value_weight;
    const double w1 = options.slope_weight * (options.scale_free ? length * length : 1);
    for (long column = 0; column < kernel.cols(); ++column) {
        if (fit.free_coefficients == 0) break; // Eigen's kernel is then a zero vector
        const Eigen::VectorXd change = kernel.col(column) / kernel.col(column).norm();
        long double first = 0, of_change = 0, of_error = 0;
        for_each_node(fit, curve,
                      [&](long double t, long double dx, std::size_t i, long double h, long double u) {
                          const auto c = derivatives_at(curve, t);
                          const auto f = piece_at(fit.coefficients(i), h, u);
                          const std::size_t n = fit.degree + 1;
                          const auto d = piece_at({change.data() + i * n, n}, h, u);
                          first += dx * (w0 * (c[0] - f.value) * d.value + w1 * (c[1] - f.slope) * d.slope);
                          of_change += dx * (w0 * d.value * d.value + w1 * d.slope * d.slope);
                          of_error += dx * (w0 * c[0] * c[0] + w1 * c[1] * c[1]);
                      });
        CAPTURE(column);
        CHECK(std::fabs(double(first)) <= 1e-10 * double(std::sqrt(of_change * of_error)));
    }
}

TEST_CASE("a curve with linear time is fitted exactly", "[animate][fit][property]") {
    const auto seed = GENERATE(seeds(100));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 37);
    const double length = std::pow(10.0, random.uniform(-2, 2));
    const auto curve = moved(bezier(1. / 3, random.uniform(-1, 2), 2. / 3, random.uniform(-1, 2)),
                             random.uniform(-3, 3), length, random.uniform(-3, 3), random.uniform(1, 5));
    const auto [same, parameters, options, fit, report] = random_fit(random, curve);
    CHECK(report.sup_error <= 1e-12 * height_of(curve));
    CHECK(report.l2_error <= 1e-12 * height_of(curve) * std::sqrt(length));
    CHECK(report.slope_error <= 1e-10 * height_of(curve) / std::sqrt(length));
    for (std::size_t i = 0; i < fit.pieces(); ++i) {
        for (const double u : {0.0, 0.25, 0.5, 1.0}) {
            const double x = fit.knots[i] + u * (fit.knots[i + 1] - fit.knots[i]);
            CHECK(double(piece_at(fit.coefficients(i), 1, u).value) ==
                  Approx(double(point_at(curve, (x - curve.begin()) / length)[1]))
                      .margin(1e-11 * height_of(curve)));
        }
    }
}

TEST_CASE("a fit is equivariant under scaling and shifts of values, and shears keep its error",
          "[animate][fit][property]") {
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 41);
    const auto [curve, parameters, options, fit, report] = random_fit(random, random_normal_curve(random));
    const double factor = random.uniform(-5, 5), shift = random.uniform(-5, 5), shear = random.uniform(-5, 5);
    auto scaled = curve, sheared = curve;
    for (std::size_t k = 0; k < 4; ++k) {
        scaled.points[k][1] = factor * curve.points[k][1] + shift;
        sheared.points[k][1] += shear * curve.points[k][0];
    }
    const auto of_scaled = fit_pieces(scaled, parameters, options);
    REQUIRE(of_scaled.status() == Status::ok);
    for (std::size_t k = 0; k < fit.bernstein.size(); ++k)
        CHECK(of_scaled.value.bernstein[k] == Approx(factor * fit.bernstein[k] + shift)
                                                  .epsilon(0)
                                                  .margin(1e-10 * (1 + largest(fit.bernstein))));
    const double size = 1 + largest(fit.bernstein);
    CHECK(of_scaled.report.sup_error ==
          Approx(std::fabs(factor) * report.sup_error).epsilon(0).margin(1e-11 * size));
    CHECK(of_scaled.report.l2_error ==
          Approx(std::fabs(factor) * report.l2_error).epsilon(0).margin(1e-11 * size));
    CHECK(of_scaled.report.slope_error ==
          Approx(std::fabs(factor) * report.slope_error).epsilon(0).margin(1e-9 * size));

    const auto of_sheared = fit_pieces(sheared, parameters, options);
    REQUIRE(of_sheared.status() == Status::ok);
    CHECK(of_sheared.report.sup_error == Approx(report.sup_error).epsilon(0).margin(1e-11 * size));
    CHECK(of_sheared.report.l2_error == Approx(report.l2_error).epsilon(0).margin(1e-11 * size));
    CHECK(of_sheared.report.slope_error == Approx(report.slope_error).epsilon(0).margin(1e-9 * size));
}

TEST_CASE("weights in the curve's units correspond to scaled weights of the normal form",
          "[animate][fit][property]") {
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 53);
    const auto curve = random_curve(random);
    const auto form = normal_form(curve);
    const auto drawn = random_fit(random, curve);
    FitOptions in_units = drawn.options, scale_free = drawn.options, normal = drawn.options;
    in_units.slope_weight = scale_free.slope_weight = 1;
    in_units.scale_free = false;
    scale_free.scale_free = true;
    for (const bool units : {true, false}) {
        CAPTURE(units);
        normal.slope_weight = units ? 1 / (form.length * form.length) : 1;
        normal.scale_free = random.below(2) == 0; // the same for an interval of length 1
        const auto fit = fit_pieces(curve, drawn.parameters, units ? in_units : scale_free);
        const auto of_form = fit_pieces(form.curve, drawn.parameters, normal);
        REQUIRE(fit.status() == Status::ok);
        REQUIRE(of_form.status() == Status::ok);
        const double size = 1 + largest(of_form.value.bernstein), height = std::fabs(form.height);
        for (std::size_t k = 0; k < fit.value.bernstein.size(); ++k)
            CHECK((fit.value.bernstein[k] - form.value) / form.height ==
                  Approx(of_form.value.bernstein[k]).epsilon(0).margin(1e-10 * size));
        CHECK(fit.report.sup_error ==
              Approx(height * of_form.report.sup_error).epsilon(0).margin(1e-11 * size * height));
        CHECK(fit.report.l2_error / height / std::sqrt(form.length) ==
              Approx(of_form.report.l2_error).epsilon(0).margin(1e-11 * size));
        CHECK(fit.report.slope_error / height * std::sqrt(form.length) ==
              Approx(of_form.report.slope_error).epsilon(0).margin(1e-9 * size));
    }
}

TEST_CASE("shifted times change nothing, reversed time mirrors the fit", "[animate][fit][property]") {
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 61);
    const auto [curve, parameters, options, fit, report] = random_fit(random, random_normal_curve(random));
    const auto shifted = fit_pieces(moved(curve, 1e3, 1, 0, 1), parameters, options);
    REQUIRE(shifted.status() == Status::ok);
    CHECK(difference(shifted.value.bernstein, fit.bernstein) <= 1e-9 * (1 + largest(fit.bernstein)));
    CHECK(shifted.report.sup_error == Approx(report.sup_error).epsilon(0).margin(1e-9));

    BezierCurve back;
    for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t axis = 0; axis < 2; ++axis) back.points[k][axis] = 1 - curve.points[3 - k][axis];
    }
    std::vector<double> mirrored(parameters.rbegin(), parameters.rend());
    for (double& t : mirrored) t = 1 - t;
    const auto of_back = fit_pieces(back, mirrored, options);
    REQUIRE(of_back.status() == Status::ok);
    for (std::size_t k = 0; k < fit.bernstein.size(); ++k)
        CHECK(of_back.value.bernstein[k] == Approx(1 - fit.bernstein[fit.bernstein.size() - 1 - k])
                                                .margin(1e-10 * (1 + largest(fit.bernstein))));
    CHECK(of_back.report.sup_error == Approx(report.sup_error).epsilon(0).margin(1e-11));
    CHECK(of_back.report.slope_error == Approx(report.slope_error).epsilon(0).margin(1e-9));
}

TEST_CASE("the error is linear in the handles' distance from a straight line", "[animate][fit][property]") {
    // Curves 7 and 10 of the source: 5.5 times the distance.
    for (std::size_t pieces = 1; pieces <= 6; ++pieces) {
        const auto t = uniform_in_parameter(pieces);
        const auto seventh = fit_pieces(test_curves[6], t), tenth = fit_pieces(test_curves[9], t);
        CHECK(tenth.report.w12_error() == Approx(5.5 * seventh.report.w12_error()).epsilon(1e-11));
        CHECK(tenth.report.sup_error == Approx(5.5 * seventh.report.sup_error).epsilon(1e-11));
    }
    for (int seed = 0; seed < 50; ++seed) {
        CAPTURE(seed);
        Random random(std::uint64_t(seed) + 71);
        const auto [curve, parameters, options, fit, report] =
            random_fit(random, random_normal_curve(random));
        const double factor = random.uniform(-6, 6);
        auto other = curve;
        for (const std::size_t k : {1u, 2u})
            other.points[k][1] = curve.points[k][0] + factor * (curve.points[k][1] - curve.points[k][0]);
        const auto of_other = fit_pieces(other, parameters, options);
        REQUIRE(of_other.status() == Status::ok);
        CHECK(of_other.report.w12_error() ==
              Approx(std::fabs(factor) * report.w12_error()).epsilon(1e-8).margin(1e-9));
        CHECK(of_other.report.sup_error ==
              Approx(std::fabs(factor) * report.sup_error).epsilon(1e-8).margin(1e-11));
    }
}

TEST_CASE("more knots, a higher degree and fewer conditions never raise the error",
          "[animate][fit][property]") {
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 83);
    const auto curve = random_normal_curve(random);
    const auto knots = random_parameters(random, 3 + random.below(3));
    const auto never_above = [](const auto& a, const auto& b) {
        if (a.status() == Status::too_many_conditions || b.status() == Status::too_many_conditions) return;
        REQUIRE(a.status() == Status::ok);
        REQUIRE(b.status() == Status::ok);
        CHECK(a.report.w12_error() <= b.report.w12_error() * (1 + 1e-9) + 1e-12);
    };
    // Where conditions only couple neighbours.
    for (const std::size_t number : {1u, 2u, 4u, 8u}) {
        CAPTURE(number);
        const auto conditions = configuration(number);
        const auto fit = fit_of(curve, knots, conditions);
        auto nested = knots;
        for (std::size_t k = 1 + random.below(2); k > 0; --k) {
            const std::size_t at = 1 + random.below(nested.size() - 1);
            nested.insert(nested.begin() + long(at), 0.5 * (nested[at - 1] + nested[at]));
        }
        never_above(fit_of(curve, nested, conditions), fit);
        never_above(fit_of(curve, knots, conditions, 4), fit);
        never_above(fit_of(curve, knots, conditions, 5), fit_of(curve, knots, conditions, 4));
    }
    // At fixed knots a superset of conditions has at least the same error; knot_value implies
    // knot_c0.
    const auto closure = [](FitCondition set) {
        unsigned bits = unsigned(set);
        for (const unsigned order : {0u, 3u, 6u}) bits |= (bits >> 1) & (2u << order);
        return bits;
    };
    for (const std::size_t degree : {3u, 4u, 5u}) {
        std::vector<cageform::Result<BezierFit, cageform::FitReport>> fits;
        for (const auto conditions : configurations) fits.push_back(fit_of(curve, knots, conditions, degree));
        for (std::size_t a = 0; a < 27; ++a) {
            for (std::size_t b = 0; b < 27; ++b) {
                if ((closure(configurations[a]) & ~closure(configurations[b])) != 0) continue;
                CAPTURE(degree, a + 1, b + 1);
                never_above(fits[a], fits[b]);
            }
        }
    }
}

TEST_CASE("XXIV is the clamped spline, IX has two free coefficients", "[animate][fit]") {
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 97);
    const auto curve = random_normal_curve(random);
    const std::size_t pieces = 1 + random.below(8);
    const auto knots = random_parameters(random, pieces);
    const auto fit = fit_of(curve, knots, configuration(24));
    REQUIRE(fit.status() == Status::ok);
    CHECK(fit.value.free_coefficients == 0);
    // Slopes at the knots of the spline, from its tridiagonal system.
    const long n = long(pieces);
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n + 1, n + 1);
    Eigen::VectorXd right(n + 1);
    const auto value = [&](long i) { return double(point_at(curve, knots[std::size_t(i)])[1]); };
    const auto h = [&](long i) {
        return fit.value.knots[std::size_t(i) + 1] - fit.value.knots[std::size_t(i)];
    };
    for (const long end : {0L, n}) {
        a(end, end) = 1;
        right(end) = double(derivatives_at(curve, end == 0 ? 0 : 1)[1]);
    }
    for (long i = 1; i < n; ++i) {
        a(i, i - 1) = 1 / h(i - 1);
        a(i, i) = 2 / h(i - 1) + 2 / h(i);
        a(i, i + 1) = 1 / h(i);
        right(i) = 3 * ((value(i) - value(i - 1)) / (h(i - 1) * h(i - 1)) +
                        (value(i + 1) - value(i)) / (h(i) * h(i)));
    }
    const Eigen::VectorXd slope = a.partialPivLu().solve(right);
    for (long i = 0; i < n; ++i) {
        const std::array expected{value(i), value(i) + slope(i) * h(i) / 3,
                                  value(i + 1) - slope(i + 1) * h(i) / 3, value(i + 1)};
        for (std::size_t k = 0; k < 4; ++k)
            CHECK(fit.value.coefficients(std::size_t(i))[k] ==
                  Approx(expected[k]).epsilon(0).margin(1e-9 * (1 + slope.lpNorm<Eigen::Infinity>())));
    }
    const auto ninth = fit_of(curve, knots, configuration(9));
    REQUIRE(ninth.status() == Status::ok);
    CHECK(ninth.value.free_coefficients == 2);
    CHECK(ninth.report.w12_error() <= fit.report.w12_error() * (1 + 1e-9));
}

TEST_CASE("the W12 error is a sharp bound of the maximum error", "[animate][fit][property]") {
    const auto seed = GENERATE(seeds(150));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 103);
    const auto curve = random_normal_curve(random, seed % 3 == 0 ? 1e-4 : 0.02);
    const auto [same, parameters, options, fit, report] = random_fit(random, curve);
    if (contains(options.conditions, end_value)) {
        const double bound = std::sqrt(std::tanh(0.5) / 2);
        CHECK(bound == Approx(0.480686).epsilon(1e-6));
        CHECK(report.sup_error <= bound * report.w12_error() + 1e-13);
    }
    FitOptions apart = options;
    apart.conditions = end_value | knot_value;
    apart.slope_weight = 1;
    const SobolevFitter fitter(curve, apart);
    REQUIRE(fitter.decoupled());
    for (std::size_t i = 0; i + 1 < parameters.size(); ++i) {
        const auto piece = fitter.fit_piece(parameters[i], parameters[i + 1]);
        REQUIRE(piece.solved);
        const double h = piece.x_end - piece.x_begin;
        CHECK(fitter.largest_error(piece) <=
              std::sqrt(std::tanh(h / 2) / 2 * std::fmax(fitter.cost(piece), 0)) + 1e-13);
    }
}

TEST_CASE("the maximum error is at least that of samples, and attained", "[animate][fit][sup]") {
#if defined(CAGEFORM_SANITIZED)
    constexpr int curves = 100;
#else
    constexpr int curves = 2000;
#endif
    for (int seed = 0; seed < curves; ++seed) {
        Random random(std::uint64_t(seed) + 127);
        // Every third curve is near the boundary of the valid region.
        const auto curve = random_normal_curve(random, seed % 3 == 0 ? 1e-6 : 0.02);
        const auto [same, parameters, options, fit, report] = random_fit(random, curve);
        const auto error = sampled_error(fit, curve, 2000);
        const double size = 1 + largest(fit.bernstein);
        CAPTURE(seed, report.sup_error, error.sampled, error.polished, size);
        if (!(report.sup_error >= error.sampled - 64 * epsilon<double> * size))
            CHECK(report.sup_error >= error.sampled);
        if (!(report.sup_error <= error.polished + 1e-9 * std::fmin(size, 100)))
            CHECK(report.sup_error <= error.polished);
        if (seed % 10 == 0) { // and attained at sup_at
            const cageform::BezierFunction function(curve);
            const double slope = std::fabs(function.derivative(report.sup_at));
            if (slope < 1e3)
                CHECK(std::fabs(function(report.sup_at) - fit(report.sup_at)) ==
                      Approx(report.sup_error).epsilon(0).margin(1e-10 * size));
        }
    }
}

TEST_CASE("vertical tangents: the L2 norm, or the W12 norm without its infinite term",
          "[animate][fit][vertical]") {
    for (const auto& curve :
         {bezier(0, 1, 0.5, 1), bezier(0.5, 0, 1, 0.5), bezier(0, 0.5, 1, 0.2), bezier(1, 0, 0, 1),
          bezier(4. / 3, 0.2, 2. / 3, 0.9), moved(bezier(0, 1, 0.37, 1), 0.3, 0.7, 0, 2),
          moved(bezier(0.63, 0, 1, 0), 0.3, 0.7, 0, 2)}) {
        CAPTURE(curve.points[1][0], curve.points[2][0]);
        REQUIRE(cageform::check(curve).status == Status::ok);
        REQUIRE(cageform::check(curve).vertical_tangent);
        const auto t = uniform_in_parameter(4);
        FitOptions options;
        for (const double slope_weight : {0.0, 1.0}) {
            options.slope_weight = slope_weight;
            for (const std::size_t number : {1u, 2u, 3u, 4u, 8u}) {
                CAPTURE(slope_weight, number);
                options.conditions = configuration(number);
                const auto fit = fit_pieces(curve, t, options);
                REQUIRE(fit.status() == Status::ok);
                CHECK(fit.report.slope_error == infinity);
                CHECK(fit.report.w12_error() == infinity);
                CHECK(fit.report.sup_error < 1);
                const auto error = sampled_error(fit.value, curve, 4000);
                CHECK(fit.report.sup_error >= error.sampled - 1e-14);
                CHECK(fit.report.sup_error <= error.polished + 1e-9);
            }
        }
        // The minimiser is the limit of those of curves nearby.
        auto near = curve;
        near.points[1][0] += 1e-9 * (0.4 - near.points[1][0]);
        near.points[2][0] += 1e-9 * (0.6 - near.points[2][0]);
        options.slope_weight = 1;
        options.conditions = configuration(2);
        const auto fit = fit_pieces(curve, t, options), beside = fit_pieces(near, t, options);
        REQUIRE(beside.status() == Status::ok);
        CHECK(difference(fit.value.bernstein, beside.value.bernstein) <= 1e-4);
    }
}

TEST_CASE("unbounded slopes are rejected, a handle on its key is valid", "[animate][fit][vertical]") {
    Random random(5);
    for (int n = 0; n < 20; ++n) {
        CAPTURE(n);
        const double begin = random.uniform(-3, 3), length = random.uniform(0.1, 10),
                     height = random.uniform(1, 5);
        auto start = moved(bezier(0, 0.7, 0.4, 0.8), begin, length, 0, height);
        auto end = moved(bezier(0.6, 0.2, 1, 0.3), begin, length, 0, height);
        start.points[1][0] = start.points[0][0];
        end.points[2][0] = end.points[3][0];
        const auto t = uniform_in_parameter(3);
        for (const auto& curve : {start, end}) {
            REQUIRE(cageform::check(curve).vertical_tangent);
            CHECK(fit_of(curve, t, end_value | knot_value | end_d1).status() == Status::slope_unbounded);
            CHECK(fit_of(curve, t, end_value | knot_c0 | end_d1).status() == Status::slope_unbounded);
            CHECK(fit_of(curve, t, end_value | knot_c0 | end_d2).status() == Status::slope_unbounded);
            CHECK(fit_of(curve, t, end_value | knot_value | knot_d1).status() == Status::ok);
        }
        // With the handle on the key the curve is smooth there: everything is finite.
        start.points[1] = start.points[0];
        end.points[2] = end.points[3];
        for (const auto& curve : {start, end}) {
            for (const auto conditions :
                 {end_value | knot_value | end_d1, end_value | knot_c0 | knot_c1 | end_d1}) {
                const auto fit = fit_of(curve, t, conditions);
                REQUIRE(fit.status() == Status::ok);
                const auto slow = slow_errors(fit.value, curve);
                CHECK(fit.report.slope_error == Approx(slow.slope).epsilon(1e-6));
                CHECK(fit.report.l2_error == Approx(slow.l2).epsilon(1e-6));
                const auto rows = conditions_of(fit.value, curve, end_value);
                const double first = 3 * (fit.value.bernstein[1] - fit.value.bernstein[0]) /
                                     (fit.value.knots[1] - fit.value.knots[0]);
                if (&curve == &start)
                    CHECK(first == Approx((start.points[2][1] - start.points[0][1]) /
                                          (start.points[2][0] - start.points[0][0])));
            }
        }
    }
}

TEST_CASE("a vertical tangent at a knot cannot be prescribed", "[animate][fit][vertical]") {
    const auto curve = bezier(4. / 3, 0.2, 2. / 3, 0.9); // vertical at 2/3 of its parameter
    REQUIRE(cageform::check(curve).vertical_tangent);
    const auto t = uniform_in_parameter(3);
    CHECK(fit_of(curve, t, end_value | knot_value).status() == Status::ok);
    CHECK(fit_of(curve, t, end_value | knot_value | knot_d1).status() == Status::slope_unbounded);
    CHECK(fit_of(curve, t, end_value | knot_c0 | knot_d1).status() == Status::slope_unbounded);
}

TEST_CASE("errors are accurate at nearly vertical tangents", "[animate][fit][vertical]") {
    // Against the integral over 2000 panels graded towards the end.
    for (const double u1 : {1e-3, 1e-5, 1e-9}) {
        const auto curve = bezier(u1, 0.9, 0.6, 1);
        const auto fit = fit_pieces(curve, uniform_in_parameter(3));
        REQUIRE(fit.status() == Status::ok);
        long double sum = 0;
        const auto& rule = cageform::detail::Gauss<16>::rule();
        for (std::size_t i = 0; i < 3; ++i) {
            const double begin = fit.value.parameters[i], end = fit.value.parameters[i + 1];
            const long double x_begin = point_at(curve, begin)[0], h = point_at(curve, end)[0] - x_begin;
            const std::size_t panels = 400;
            const auto at = [&](std::size_t k) {
                return begin + (end - begin) * std::pow(double(k) / double(panels), 12);
            };
            for (std::size_t k = 0; k < panels; ++k) {
                sum += rule(at(k), at(k + 1), [&](double t) {
                    const auto velocity = velocity_at(curve, t);
                    const auto f =
                        piece_at(fit.value.coefficients(i), h, (point_at(curve, t)[0] - x_begin) / h);
                    const auto e = velocity[1] - f.slope * velocity[0];
                    return double(e * e / velocity[0]);
                });
            }
        }
        CAPTURE(u1);
        CHECK(fit.report.slope_error == Approx(double(std::sqrt(sum))).epsilon(1e-11));
    }
}

TEST_CASE("invalid input of a fit is rejected with a status", "[animate][fit]") {
    const auto good = bezier(0.3, 0.4, 0.6, 0.7);
    const auto t = uniform_in_parameter(3);
    const FitOptions options;
    REQUIRE(fit_pieces(good, t, options).status() == Status::ok);
    const auto refused = [&](const BezierCurve& curve, Status why) {
        const auto fit = fit_pieces(curve, t, options);
        CHECK(fit.status() == why);
        CHECK(fit.value.pieces() == 0);
        CHECK(fit.value.bernstein.empty());
    };
    auto curve = good;
    curve.points[2][1] = std::numeric_limits<double>::quiet_NaN();
    refused(curve, Status::value_not_finite);
    curve = good;
    curve.points[0][0] = -infinity;
    refused(curve, Status::value_not_finite);
    curve = good;
    std::swap(curve.points[0], curve.points[3]); // keys reversed
    refused(curve, Status::interval_empty);
    curve = good;
    curve.points[3][0] = curve.points[0][0];
    refused(curve, Status::interval_empty);
    // The specification's list of invalid handles (2.2).
    refused(bezier(1.3, 0, .3, 1), Status::time_not_monotone);
    refused(bezier(-.05, 0, .5, 1), Status::time_not_monotone);
    refused(bezier(.5, 0, 1.05, 1), Status::time_not_monotone);

    const auto status_of = [&](const FitOptions& with) { return fit_pieces(good, t, with).status(); };
    for (const std::size_t degree : {0u, 1u, 2u, 6u, 100u}) {
        FitOptions with;
        with.degree = degree;
        CHECK(status_of(with) == Status::degree_not_supported);
    }
    const double not_a_number = std::numeric_limits<double>::quiet_NaN();
    for (const double weight : {0.0, -1.0, not_a_number, infinity}) {
        FitOptions with;
        with.value_weight = weight;
        CHECK(status_of(with) == Status::weights_not_positive);
    }
    for (const double weight : {-1e-9, not_a_number, infinity}) {
        FitOptions with;
        with.slope_weight = weight;
        CHECK(status_of(with) == Status::weights_not_positive);
    }
    for (const auto& knots : std::vector<std::vector<double>>{{},
                                                              {0},
                                                              {1},
                                                              {0, 0.5},
                                                              {0.1, 1},
                                                              {0, 0.6, 0.4, 1},
                                                              {0, 0.5, 0.5, 1},
                                                              {0, 1, 1},
                                                              {0, not_a_number, 1},
                                                              {0, 2, 1},
                                                              {0, -1, 1},
                                                              {not_a_number, 1},
                                                              {0, 0.5, std::nextafter(0.5, 1), 1}}) {
        const auto status = fit_pieces(good, knots, options).status();
        // The last: different parameters whose times may coincide after rounding.
        if (knots.size() != 4 || knots[1] >= knots[2]) CHECK(status == Status::knots_not_ascending);
    }
}

TEST_CASE("too many conditions are rejected, and free coefficients are counted", "[animate][fit]") {
    const auto curve = bezier(0.3, 0.4, 0.6, 1.2); // of no symmetry
    const auto status_of = [&](std::size_t number, std::size_t pieces, std::size_t degree = 3) {
        return fit_of(curve, uniform_in_parameter(pieces), configuration(number), degree).status();
    };
    // Free coefficients with 3 pieces (8.3), configuration by configuration.
    constexpr std::array free{12, 8, 6, 6, 4, 4, 2, 4, 2, 2, 2, 6, 4, 4,
                              2,  4, 2, 2, 0, 2, 0, 0, 2, 0, 0, 0, 0};
    for (std::size_t n = 1; n <= 27; ++n) {
        CAPTURE(n);
        const auto fit = fit_of(curve, uniform_in_parameter(3), configuration(n));
        REQUIRE(fit.status() == Status::ok);
        CHECK(int(fit.value.free_coefficients) == free[n - 1]);
    }
    // XXI, XXII and XXVII need three pieces (5.3), XIV, XV and XX two.
    for (const std::size_t n : {21u, 22u, 27u}) CHECK(status_of(n, 2) == Status::too_many_conditions);
    for (const std::size_t n : {14u, 15u, 20u, 21u, 22u, 27u})
        CHECK(status_of(n, 1) == Status::too_many_conditions);
    for (const std::size_t n : {14u, 15u, 20u}) CHECK(status_of(n, 2) == Status::ok);
    for (const std::size_t n : {14u, 15u, 20u}) CHECK(status_of(n, 1, 5) == Status::ok);
    // Redundant conditions.
    const auto t = uniform_in_parameter(3);
    CHECK(fit_of(curve, t, end_value | knot_c0 | knot_value).status() == Status::too_many_conditions);
    CHECK(fit_of(curve, t, end_value | knot_c0 | knot_c1 | knot_d1).status() == Status::too_many_conditions);
    CHECK(fit_of(curve, t, end_value | knot_value | end_d1 | knot_d1 | end_d2 | knot_d2).status() ==
          Status::too_many_conditions);
    CHECK(fit_of(curve, t, end_value | knot_value | end_d1 | knot_d1 | end_d2 | knot_d2, 5).status() ==
          Status::ok);
}

} // namespace sobolev_fit_tests
