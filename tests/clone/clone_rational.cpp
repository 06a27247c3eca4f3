// The rational clone: its definition and refusals.
#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/bindings.hpp"
#include "support/larger.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone_rational.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/sibson.hpp>
#include <cageform/parallel/threads.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace clone_rational_tests {

using namespace cageform_tests;
using cageform::Binding;
using cageform::epsilon;
using cageform::Lanes;
using cageform::rational_view;
using cageform::WeightFormat;

namespace {

/// Points with `heard` handles each; weights are non-negative and sum to one.
template <class T, std::size_t D>
Binding<T, D> convex_binding(std::size_t points, std::size_t handles, std::size_t heard, std::uint64_t seed) {
    Random random(seed);
    const auto places = random_points<T, D>(handles, 10, seed + 1);
    const std::size_t blocks = cageform::block_count<T>(points);
    std::vector<Lanes<T>> weights(blocks * handles), rest(blocks * D);
    for (auto& row : weights) std::fill(std::begin(row.v), std::end(row.v), T(0));
    const cageform::BlockView<T> w{weights.data(), handles, points}, p{rest.data(), D, points};
    for (std::size_t i = 0; i < blocks * cageform::lane_count<T>; ++i) {
        const auto shares = random_shares(heard, random);
        Vec<long double, D> sum{};
        for (std::size_t n = 0; n < heard; ++n) {
            const std::size_t h = (i / 40 + n * 7) % handles; // points nearby in memory share handles
            w(i, h) += T(shares[n]);
            sum = sum + static_cast<long double>(T(shares[n])) * cageform::vec_cast<long double>(places[h]);
        }
        for (std::size_t k = 0; k < D; ++k) p(i, k) = T(sum[k]);
    }
    return {std::move(weights), std::move(rest), places, points};
}

template <class T>
std::vector<T> random_weights(std::size_t count, double reach, std::uint64_t seed) {
    Random random(seed);
    std::vector<T> weights(count);
    for (T& w : weights) w = T(std::exp(random.uniform(-reach, reach)));
    return weights;
}

template <class B, class Pose, class T>
auto rational(const B& binding, const Pose& pose, const std::vector<T>& weights) {
    std::vector<Vec<T, B::dimension>> out(cageform::detail::as_rational(binding).value.point_count());
    REQUIRE(cageform::clone_rational(binding, pose, weights, out) == Status::ok);
    return out;
}

/// Σ r_i C'_i in long double.
template <class T, std::size_t D>
Vec<long double, D> weighted_mean(const Binding<T, D>& binding, const std::vector<Vec<T, D>>& pose,
                                  const std::vector<T>& weights, std::size_t i) {
    Vec<long double, D> sum{};
    long double whole = 0;
    for (std::size_t h = 0; h < pose.size(); ++h) {
        const long double r = static_cast<long double>(weights[h]) * binding.weight(i, h);
        whole += r;
        sum = sum + r * cageform::vec_cast<long double>(pose[h]);
    }
    return (1 / whole) * sum;
}

template <class T, std::size_t D>
void check_laws(std::uint64_t seed) {
    CAPTURE(seed, D);
    const std::size_t points = seed % 2 == 0 ? 300 : 37, handles = seed % 3 == 0 ? 9 : 60;
    const auto binding = convex_binding<T, D>(points, handles, std::min<std::size_t>(handles, 6), seed);
    const auto pose = random_points<T, D>(handles, 10, seed + 2);
    const auto weights = random_weights<T>(handles, 3, seed + 3);
    const auto out = rational(binding, pose, weights);
    const double size = 20 * std::sqrt(double(D)), error = 100 * double(epsilon<T>) * size;
    double drawn = 0;
    for (std::size_t i = 0; i < points; ++i) {
        CHECK(distance(out[i], weighted_mean(binding, pose, weights, i)) <= error);
        drawn =
            std::max(drawn, distance(out[i], weighted_mean(binding, pose, std::vector<T>(handles, 1), i)));
    }
    CHECK(drawn > 0.1); // weights have an effect

    auto scaled = weights; // by powers of two: bitwise equal; by other factors: to rounding
    for (T& w : scaled) w *= T(8);
    CHECK(rational(binding, pose, scaled) == out);
    for (T& w : scaled) w *= T(1e-3);
    const auto close = rational(binding, pose, scaled);
    for (std::size_t i = 0; i < points; ++i) CHECK(distance(close[i], out[i]) <= error);

    auto heavy = weights; // attracts the points of this handle, and no others
    heavy[5] = T(1e9);
    const auto to_it = rational(binding, pose, heavy);
    for (std::size_t i = 0; i < points; ++i) {
        const double w = double(binding.weight(i, 5));
        if (w > 1e-2) CHECK(distance(to_it[i], pose[5]) <= 1e-4 * size);
        if (w == 0) CHECK(distance(to_it[i], out[i]) <= error);
    }
}

} // namespace

TEMPLATE_TEST_CASE("a rational clone is the mean of the pose by weights of handles", "[clone][rational]",
                   CAGEFORM_SCALARS) {
    const auto seed = std::uint64_t(GENERATE(range(0, 6)));
    check_laws<TestType, 2>(seed);
    check_laws<TestType, 3>(seed);
}

TEMPLATE_TEST_CASE("equal weights give what clone does, bit for bit", "[clone][rational]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto binding = convex_binding<T, 3>(1000, 80, 6, 41);
    const auto pose = random_points<T, 3>(80, 10, 42);
    const auto expected = cloned(binding, pose);
    for (const T weight : {T(1), T(0.7), T(3e5)}) {
        const std::vector<T> equal(80, weight);
        CHECK(rational(binding, pose, equal) == expected);
        CHECK(rational(rational_view(binding).value, pose, equal) == expected);
        std::vector<Vec<T, 3>> rest, at_rest = rational(binding, binding_handles(binding), equal);
        for (std::size_t i = 0; i < 1000; ++i) rest.push_back(binding.rest_point(i));
        CHECK(std::memcmp(rest.data(), at_rest.data(), rest.size() * sizeof(rest[0])) == 0);
    }
}

TEMPLATE_TEST_CASE("packed bindings clone rationally as their weights in effect do",
                   "[clone][rational][packed]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto binding = convex_binding<T, 3>(500, 60, 6, 43);
    const auto pose = random_points<T, 3>(60, 10, 44);
    const auto weights = random_weights<T>(60, 1, 45);
    const auto exact = rational(binding, pose, weights);
    // The error of rounding a weight to 24, 11, 15 and 7 bits, for points with six handles.
    const double bounds[] = {1e-4, 0.05, 0.05, 1.0};
    int formats = 0;
    for (const WeightFormat format :
         {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8}) {
        const auto [packed, report] = cageform::pack(binding, {.format = format, .threshold = 1e-30});
        REQUIRE(report.status == Status::ok);
        const auto view = rational_view(packed);
        CAPTURE(int(format), double(view.value.slack()));
        REQUIRE(view.status() == Status::ok);
        const auto out = rational(view.value, pose, weights);
        CHECK(out == rational(packed, pose, weights));
        double worst = 0;
        for (std::size_t i = 0; i < out.size(); ++i)
            worst = cageform_tests::larger(worst, distance(out[i], exact[i]));
        CHECK(worst <= bounds[formats++]);
        CHECK(rational(packed, pose, std::vector<T>(60, T(2))) == [&] {
            std::vector<Vec<T, 3>> plain(500);
            REQUIRE(cageform::clone(packed, pose, plain) == Status::ok);
            return plain;
        }());
    }
}

TEMPLATE_TEST_CASE("rational clones by threads and in ranges are bitwise equal", "[clone][rational][threads]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto binding = convex_binding<T, 2>(3000, 50, 5, 46);
    const auto pose = random_points<T, 2>(50, 10, 47);
    const auto weights = random_weights<T>(50, 2, 48);
    const auto packed = cageform::pack(binding, {.threshold = 1e-30}).value;
    const auto backwards = [](std::size_t count, std::size_t, const auto& body) {
        for (std::size_t end = count; end > 0; --end) body(end - 1, end);
    };
    const auto check = [&](const auto& any) {
        const auto fit = rational_view(any);
        REQUIRE(fit.status() == Status::ok);
        const auto expected = rational(fit.value, pose, weights);
        std::vector<Vec<T, 2>> out(3000);
        CHECK(cageform::clone_rational(fit.value, pose, weights, out, cageform::ThreadedFor{3}) ==
              Status::ok);
        CHECK(out == expected);
        std::fill(out.begin(), out.end(), Vec<T, 2>{});
        const auto before = allocations.load();
        CHECK(cageform::clone_rational(fit.value, pose, weights, out, backwards) == Status::ok);
        CHECK(allocations.load() == before);
        CHECK(out == expected);
        STATIC_REQUIRE(noexcept(cageform::clone_rational(fit.value, pose, weights, out)));
    };
    check(binding);
    check(packed);
}

TEMPLATE_TEST_CASE("points kept in place do not move under any weights", "[clone][rational][outside]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const std::vector<Vec<T, 2>> cage{{0, 0}, {4, 0}, {4, 3}, {0, 3}}, points{{1, 1}, {7, 1}, {2, 2}};
    const auto [binding, report] = cageform::bind(cageform::MeanValueCoordinates<T, 2>(cage), points,
                                                  {.outside = cageform::OutsidePoints::keep_in_place});
    REQUIRE(report.status == Status::ok);
    const auto out = rational(binding, cage, std::vector<T>{1, 2, 3, 4});
    CHECK(out[1] == points[1]);
    CHECK(distance(out[0], points[0]) > 0.1); // moved towards the heavier corners only
}

TEST_CASE("a heavier site among five attracts a point by the exact amount", "[clone][rational]") {
    const std::vector<Vec<double, 2>> sites{{0, 0}, {4, 0}, {4, 3}, {0, 3}, {2, 1}}, points{{1.5, 1.25}};
    const auto binding = cageform::bind(cageform::SibsonCoordinates<double, 2>(sites), points).value;
    const auto out = rational(binding, sites, std::vector<double>{1, 1, 1, 1, 3});
    CHECK(out[0][0] == Approx(80621.0 / 44897).epsilon(1e-14));
    CHECK(out[0][1] == Approx(98967.0 / 89794).epsilon(1e-14));
}

TEST_CASE("a rational clone refuses invalid arguments, and leaves the output unchanged",
          "[clone][rational][status]") {
    auto binding = convex_binding<double, 2>(20, 6, 3, 50);
    auto pose = random_points<double, 2>(6, 10, 51);
    auto weights = random_weights<double>(6, 1, 52);
    std::vector<Vec<double, 2>> out(20);
    const auto before = out;
    const auto status = [&](const auto& any) { return cageform::clone_rational(any, pose, weights, out); };
    REQUIRE(cageform::clone_rational(binding, pose, weights, out) == Status::ok);
    out = before;

    weights.pop_back();
    CHECK(status(binding) == Status::weights_do_not_match);
    for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
        weights.resize(5);
        weights.push_back(bad);
        CHECK(status(binding) == Status::weights_not_positive);
    }
    weights[5] = 1e30;
    CHECK(status(binding) == Status::weights_too_far_apart);
    weights[5] = 1;
    const double was = std::exchange(pose[2][0], std::nan(""));
    CHECK(status(binding) == Status::pose_not_finite);
    pose[2][0] = was;
    pose.pop_back();
    CHECK(status(binding) == Status::pose_size_differs);
    pose.push_back({1, 1});
    CHECK(cageform::clone_rational(binding, pose, weights, std::span(out).first(19)) ==
          Status::output_too_small);

    const auto with = [&](double first, double second) { // the weights of point 3 for two of its handles
        auto other = binding;
        const auto handles = binding_handles(other);
        auto [rows, rest] = std::move(other).release();
        const cageform::BlockView<double> w{rows.data(), 6, 20};
        w(3, 0) += first;
        w(3, 1) += second;
        return Binding<double, 2>(std::move(rows), std::move(rest), handles, 20);
    };
    CHECK(status(with(-2, 2)) == Status::binding_weights_negative);
    CHECK(status(with(std::nan(""), 0)) == Status::weight_not_finite);
    CHECK(rational_view(with(-2, 2)).status() == Status::binding_weights_negative);

    // Small negative weights pass until handle weights are extreme.
    auto little = convex_binding<double, 2>(20, 6, 3, 50);
    const auto handles = binding_handles(little);
    auto [rows, rest] = std::move(little).release();
    const cageform::BlockView<double> w{rows.data(), 6, 20};
    for (std::size_t h = 0; h < 6; ++h) w(3, h) = h == 0 ? -0.01 : h == 1 ? 1.01 : 0;
    little = {std::move(rows), std::move(rest), handles, 20};
    weights = {10, 1, 1, 1, 1, 1};
    CHECK(status(little) == Status::ok);
    out = before;
    weights[0] = 100; // 1.01 − 0.01 · 100 = 0.01: the divisor nearly vanishes
    CHECK(status(little) == Status::weights_too_far_apart);

    const std::vector<Vec<double, 2>> two_legs{{0, 0},   {4, 0},   {4, 4},   {2.1, 4},
                                               {2.1, 1}, {1.9, 1}, {1.9, 4}, {0, 4}};
    std::vector<Vec<double, 2>> figure;
    for (int i = 0; i < 20; ++i) figure.push_back({2.5, 1.5 + 0.1 * i}); // within a leg, next to the other
    weights.assign(8, 1.0);
    weights[0] = 2;
    CHECK(status(cageform::bind(cageform::MeanValueCoordinates<double, 2>(two_legs), figure).value) ==
          Status::binding_weights_negative);

    const std::vector kinds{cageform::HandleKind::point, cageform::HandleKind::point,
                            cageform::HandleKind::point, cageform::HandleKind::point,
                            cageform::HandleKind::point, cageform::HandleKind::vector};
    auto [vector_rows, vector_rest] = std::move(binding).release();
    const Binding<double, 2> of_vectors(std::move(vector_rows), std::move(vector_rest),
                                        {handles.data(), 6, kinds.data(), nullptr}, 20);
    CHECK(status(of_vectors) == Status::handles_not_points);
    CHECK(out == before);

    std::vector<Vec<double, 2>> nothing;
    CHECK(cageform::clone_rational(Binding<double, 2>(), nothing, {}, nothing) == Status::ok);
}

} // namespace clone_rational_tests
