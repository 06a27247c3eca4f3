// Polynomials in Bernstein form, their extremes, quadrature, and minima of functions.
#include "animate/curves.hpp"
#include "catch.hpp"
#include "support/larger.hpp"

#include <cageform/animate/fit/line_minimum.hpp>

namespace detail_tests {

using namespace cageform_tests;
using cageform::detail::Bernstein;

namespace {

Bernstein random_polynomial(Random& random, std::size_t degree) {
    Bernstein p{degree, {}};
    for (std::size_t i = 0; i <= degree; ++i) p.c[i] = random.uniform(-2, 2);
    return p;
}

} // namespace

TEST_CASE("Gauss rules are exact up to their degree", "[animate][detail]") {
    const auto exact_to = [](const auto& rule, std::size_t degree) {
        for (std::size_t n = 0; n <= degree; ++n) {
            const double integral = rule(0.0, 1.0, [&](double x) { return std::pow(x, double(n)); });
            CAPTURE(n);
            CHECK(integral == Approx(1 / (double(n) + 1)).epsilon(1e-14));
        }
    };
    exact_to(cageform::detail::Gauss<8>::rule(), 15);
    exact_to(cageform::detail::Gauss<11>::rule(), 21);
    exact_to(cageform::detail::Gauss<16>::rule(), 31);
}

TEST_CASE("products, derivatives, elevations and splits of polynomials are exact",
          "[animate][detail][property]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    const auto p = random_polynomial(random, 1 + random.below(7)),
               q = random_polynomial(random, 1 + random.below(7));
    const double at = random.uniform(0, 1);
    const auto [low, high] = p.split(at);
    for (int n = 0; n <= 20; ++n) {
        const double u = double(n) / 20, e = 1e-5;
        CHECK((p * q)(u) == Approx(p(u) * q(u)).epsilon(0).margin(1e-13));
        CHECK(elevated(p, 9)(u) == Approx(p(u)).epsilon(0).margin(1e-13));
        CHECK(low(u) == Approx(p(at * u)).epsilon(0).margin(1e-13));
        CHECK(high(u) == Approx(p(at + (1 - at) * u)).epsilon(0).margin(1e-13));
        CHECK(p.slope(u) == Approx((p(u + e) - p(u - e)) / (2 * e)).epsilon(0).margin(1e-6));
    }
}

TEST_CASE("the maximum of a polynomial is at least that of samples, and attained",
          "[animate][detail][property]") {
    const auto seed = GENERATE(seeds(300));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 50);
    auto p = random_polynomial(random, 1 + random.below(15));
    if (seed % 5 == 0) { // symmetric: extrema in pairs
        for (std::size_t i = 0; i <= p.degree / 2; ++i) p.c[p.degree - i] = p.c[i];
    }
    if (seed % 7 == 0) { // a double extremum
        const double at = random.uniform(0, 1);
        const Bernstein line{1, {-at, 1 - at}};
        p = line * line * line * Bernstein{1, {1, 1.5}};
    }
    const auto largest = largest_absolute(p);
    CHECK(std::fabs(p(largest.at)) == Approx(largest.value).epsilon(0).margin(1e-14));
    double sampled = 0;
    for (int n = 0; n <= 4000; ++n) sampled = cageform_tests::larger(sampled, std::fabs(p(double(n) / 4000)));
    CHECK(largest.value >= sampled - 1e-15);
    CHECK(largest.value <= sampled + 1e-3);
}

TEST_CASE("constants and zero have a maximum", "[animate][detail]") {
    CHECK(largest_absolute(Bernstein{0, {-3}}).value == 3);
    CHECK(largest_absolute(Bernstein{9, {}}).value == 0);
    Bernstein constant{14, {}};
    constant.c.fill(-2);
    CHECK(largest_absolute(constant).value == 2);
    // Nearly constant polynomials terminate.
    Random random(5);
    for (int n = 0; n < 1000; ++n) {
        constant = {9, {}};
        for (double& c : constant.c) c = 1 + double(random.below(3)) * 0x1p-52;
        CHECK(largest_absolute(constant).value == Approx(1).epsilon(1e-13));
    }
    for (const double bad : {std::numeric_limits<double>::infinity(), std::nan("")}) {
        constant.c[4] = bad;
        CHECK(largest_absolute(constant).value == std::numeric_limits<double>::infinity());
    }
}

TEST_CASE("line_minimum is accurate to two tolerances", "[animate][detail][property]") {
    for (int seed = 0; seed < 2000; ++seed) {
        CAPTURE(seed);
        Random random(std::uint64_t(seed) + 70);
        const double low = random.uniform(-2, 0), high = low + random.uniform(0.1, 3);
        const double at = low + (high - low) * random.uniform(0.01, 0.99);
        const double least = low + (high - low) * random.uniform(0, 1);
        const double tolerance = std::pow(10.0, random.uniform(-6, -2));
        const auto error = [&](const auto& f) {
            return std::fabs(cageform::detail::line_minimum(low, at, high, tolerance, f) - least);
        };
        const double left = random.uniform(0.01, 1), right = random.uniform(0.01, 1);
        CHECK(error([&](double x) { return x < least ? left * (least - x) : right * (x - least); }) <=
              2 * tolerance);
        CHECK(error([&](double x) {
                  const double square = (x - least) * (x - least);
                  return square * (1 + left * square);
              }) <= 2 * tolerance);
    }
}

} // namespace detail_tests
