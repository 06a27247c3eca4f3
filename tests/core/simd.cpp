#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/core/detail/number.hpp>
#include <cageform/core/detail/simd_exp.hpp>
#include <cageform/core/detail/simd_log.hpp>

#include <bit>
#include <cmath>

namespace simd_tests {

using cageform::epsilon;
using cageform::lane_count;
using cageform::Lanes;
using cageform::detail::Simd;
using cageform_tests::Random;

namespace {

/// Mostly ordinary numbers, some special values.
template <class T>
Lanes<T> random_lanes(Random& random) {
    using limits = std::numeric_limits<T>;
    const T special[] = {T(0),
                         T(-0.0),
                         T(1),
                         limits::infinity(),
                         -limits::infinity(),
                         limits::quiet_NaN(),
                         limits::denorm_min(),
                         limits::max(),
                         limits::lowest(),
                         limits::min()};
    Lanes<T> lanes;
    for (std::size_t i = 0; i < lane_count<T>; ++i) {
        lanes[i] = random.below(3) == 0 ? special[random.below(std::size(special))]
                                        : T(random.uniform(-2, 2) * std::pow(10.0, random.uniform(-8, 8)));
    }
    return lanes;
}

/// Whether both have equal bits or both are NaN.
template <class T>
bool same(T a, T b) {
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    return (std::isnan(a) && std::isnan(b)) || std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}

template <class T, class Scalars>
void check_lanes(const Simd<T>& pack, const Scalars& expected) {
    Lanes<T> got;
    pack.store(got);
    for (std::size_t i = 0; i < lane_count<T>; ++i) {
        CAPTURE(i, got[i], expected(i));
        CHECK(same<T>(got[i], expected(i)));
    }
}

} // namespace

TEMPLATE_TEST_CASE("register arithmetic equals that of its lanes", "[core][simd][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto a = random_lanes<T>(random);
    const auto b = random_lanes<T>(random);
    const auto x = Simd<T>::load(a);
    const auto y = Simd<T>::load(b);
    check_lanes<T>(x, [&](std::size_t i) { return a[i]; });
    check_lanes<T>(x + y, [&](std::size_t i) { return a[i] + b[i]; });
    check_lanes<T>(x - y, [&](std::size_t i) { return a[i] - b[i]; });
    check_lanes<T>(x * y, [&](std::size_t i) { return a[i] * b[i]; });
    check_lanes<T>(x / y, [&](std::size_t i) { return a[i] / b[i]; });
    check_lanes<T>(sqrt(x), [&](std::size_t i) { return std::sqrt(a[i]); });
    check_lanes<T>(max(x, y), [&](std::size_t i) { return a[i] < b[i] ? b[i] : a[i]; });
    check_lanes<T>(min(x, y), [&](std::size_t i) { return a[i] < b[i] ? a[i] : b[i]; });
    // abs may keep the sign of a zero.
    const Simd<T> size = abs(x) + Simd<T>(T(0));
    check_lanes<T>(size, [&](std::size_t i) { return std::fabs(a[i]); });
    check_lanes<T>(sqrt(size), [&](std::size_t i) { return std::sqrt(std::fabs(a[i])); });
}

TEMPLATE_TEST_CASE("register comparisons select lane by lane", "[core][simd][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto a = random_lanes<T>(random);
    auto b = random_lanes<T>(random);
    for (std::size_t i = 0; i < lane_count<T>; ++i) {
        if (random.below(4) == 0) b[i] = a[i]; // where < and <= differ
    }
    const auto x = Simd<T>::load(a);
    const auto y = Simd<T>::load(b);
    const Simd<T> yes(T(1));
    const Simd<T> no(T(2));
    const Simd<T> zero(T(0));
    const auto choice = [](bool first) { return first ? T(1) : T(2); };
    check_lanes<T>(select<T>(x < y, yes, no), [&](std::size_t i) { return choice(a[i] < b[i]); });
    check_lanes<T>(select<T>(x <= y, yes, no), [&](std::size_t i) { return choice(a[i] <= b[i]); });
    check_lanes<T>(select<T>((x < y) & (zero < x), yes, no),
                   [&](std::size_t i) { return choice(a[i] < b[i] && 0 < a[i]); });
    check_lanes<T>(select<T>((x < y) | (zero < x), yes, no),
                   [&](std::size_t i) { return choice(a[i] < b[i] || 0 < a[i]); });
    check_lanes<T>(select<T>(x < y, x, y), [&](std::size_t i) { return a[i] < b[i] ? a[i] : b[i]; });
}

TEMPLATE_TEST_CASE("functions of registers and scalars agree", "[core][simd][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    namespace number = cageform::detail;
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto a = random_lanes<T>(random);
    const auto b = random_lanes<T>(random);
    const auto x = Simd<T>::load(a);
    const auto y = Simd<T>::load(b);
    const auto zero = Simd<T>(T(0));
    check_lanes<T>(sqrt(x), [&](std::size_t i) { return number::sqrt(a[i]); });
    check_lanes<T>(max(x, y), [&](std::size_t i) { return (number::max)(a[i], b[i]); });
    check_lanes<T>(min(x, y), [&](std::size_t i) { return (number::min)(a[i], b[i]); });
    check_lanes<T>(select(number::both(x < y, zero < x), x, y), [&](std::size_t i) {
        return number::select(number::both(a[i] < b[i], T(0) < a[i]), a[i], b[i]);
    });
    bool some = false;
    for (std::size_t i = 0; i < lane_count<T>; ++i) some = some || a[i] < b[i];
    CHECK(number::any(x < y) == some);
}

TEMPLATE_TEST_CASE("angle of registers is accurate", "[core][simd][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(200));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    Lanes<T> sine, cosine, angles;
    for (std::size_t i = 0; i < lane_count<T>; ++i) {
        // Values of all magnitudes, some near the directions where the formula changes:
        // multiples of π/8.
        const double around = random.below(2) == 0 ? random.uniform(0, 3.14159265358979)
                                                   : 0.39269908169872414 * double(random.below(9)) +
                                                         9 * double(epsilon<T>) * random.uniform(-1, 1);
        const double flat = random.below(3) == 0 ? std::pow(2.0, random.uniform(-100, 0)) : 1.0;
        sine[i] = T(flat * std::fabs(std::sin(around)));
        cosine[i] = T(std::cos(around));
    }
    sine[0] = 0, cosine[0] = 1;
    sine[1] = 0, cosine[1] = -1;
    sine[2] = 1, cosine[2] = 0;
    angle(Simd<T>::load(sine), Simd<T>::load(cosine)).store(angles);
    CHECK(angles[0] == 0);
    for (std::size_t i = 0; i < lane_count<T>; ++i) {
        const long double expected =
            std::atan2(static_cast<long double>(sine[i]), static_cast<long double>(cosine[i]));
        CAPTURE(i, sine[i], cosine[i], angles[i]);
        CHECK(std::fabs(static_cast<long double>(angles[i]) - expected) <=
              1.5L * static_cast<long double>(epsilon<T>) * expected); // three roundings
    }
}

TEMPLATE_TEST_CASE("roots and inverse roots from estimates are accurate", "[core][simd][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    if constexpr (cageform::detail::estimates_roots<Simd<T>>) {
        using limits = std::numeric_limits<T>;
        const auto seed = GENERATE(seeds(200));
        CAPTURE(seed);
        Random random{std::uint64_t(seed)};
        Lanes<T> numbers, roots, inverses;
        for (T& x : numbers.v)
            x = T(std::pow(2.0, random.uniform(limits::min_exponent, limits::max_exponent - 1)));
        numbers[0] = limits::min();
        numbers[1] = limits::max();
        const auto both = root_and_inverse(Simd<T>::load(numbers));
        both.root.store(roots);
        both.inverse.store(inverses);
        for (std::size_t i = 0; i < lane_count<T>; ++i) {
            const long double root = std::sqrt(static_cast<long double>(numbers[i]));
            CAPTURE(i, numbers[i], roots[i], inverses[i]);
            CHECK(std::fabs(static_cast<long double>(roots[i]) / root - 1) <= epsilon<T>);
            CHECK(std::fabs(static_cast<long double>(inverses[i]) * root - 1) <= epsilon<T>);
        }
    } else {
        SUCCEED("registers of 64 bytes alone");
    }
}

TEMPLATE_TEST_CASE("log of registers is accurate", "[core][simd][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    using limits = std::numeric_limits<T>;
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    Lanes<T> numbers, logs;
    for (T& x : numbers.v) {
        // Values of all magnitudes, some near 1 and near the point where the mantissa is
        // halved.
        const double size = std::pow(2.0, random.uniform(limits::min_exponent, limits::max_exponent - 1));
        x = T(random.below(2) == 0 ? size
                                   : (1 + double(epsilon<T>) * random.uniform(-9, 9)) *
                                         (random.below(2) == 0 ? 1.0 : std::sqrt(2.0)));
    }
    numbers[0] = limits::min();
    numbers[1] = limits::max();
    numbers[2] = 1;
    log(Simd<T>::load(numbers)).store(logs);
    CHECK(logs[2] == 0);
    for (std::size_t i = 0; i < lane_count<T>; ++i) {
        const long double expected = std::log(static_cast<long double>(numbers[i]));
        CAPTURE(i, numbers[i], logs[i]);
        CHECK(std::fabs(static_cast<long double>(logs[i]) - expected) <=
              2.0L * static_cast<long double>(epsilon<T>) * std::fabs(expected)); // four roundings
    }
}

TEMPLATE_TEST_CASE("exp of registers is accurate", "[core][simd][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    using limits = std::numeric_limits<T>;
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const double most = sizeof(T) == 8 ? 700 : 85;
    Lanes<T> numbers, powers;
    for (T& x : numbers.v) x = T(random.uniform(-1.1 * most, most) * std::pow(10.0, random.uniform(-9, 0)));
    numbers[0] = 0;
    numbers[1] = random.below(2) == 0 ? -limits::infinity() : limits::lowest();
    numbers[2] = T(most);
    exp(Simd<T>::load(numbers)).store(powers);
    CHECK(powers[0] == 1);
    for (std::size_t i = 0; i < lane_count<T>; ++i) {
        const long double expected = std::exp(static_cast<long double>(numbers[i]));
        CAPTURE(i, numbers[i], powers[i]);
        // Powers up to 4 times the least normal number may be zero.
        const auto vanishing = powers[i] == 0 ? 4 * static_cast<long double>(limits::min()) : 0.0L;
        CHECK(std::fabs(static_cast<long double>(powers[i]) - expected) <=
              (std::max)(2.0L * static_cast<long double>(epsilon<T>) * expected, vanishing));
    }
}

TEMPLATE_TEST_CASE("any() is true if one lane is", "[core][simd]", CAGEFORM_SCALARS) {
    using T = TestType;
    for (std::size_t lane = 0; lane < lane_count<T>; ++lane) {
        Lanes<T> numbers;
        for (T& x : numbers.v) x = T(1);
        CHECK(!cageform::detail::any(Simd<T>::load(numbers) < Simd<T>(T(1))));
        numbers[lane] = T(0);
        CHECK(cageform::detail::any(Simd<T>::load(numbers) < Simd<T>(T(1))));
    }
}

TEMPLATE_TEST_CASE("a register from a scalar holds it in every lane", "[core][simd]", CAGEFORM_SCALARS) {
    using limits = std::numeric_limits<TestType>;
    for (const TestType x : {TestType(1.5), TestType(0), TestType(-0.0), limits::infinity(),
                             limits::quiet_NaN(), limits::denorm_min()}) {
        check_lanes<TestType>(Simd<TestType>(x), [&](std::size_t) { return x; });
    }
    STATIC_REQUIRE(sizeof(Simd<TestType>) == 64);
}

} // namespace simd_tests
