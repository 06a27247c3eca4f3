#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/core/vec.hpp>

#include <cmath>
#include <type_traits>

namespace vec_tests {

using cageform::cross;
using cageform::dot;
using cageform::epsilon;
using cageform::is_finite;
using cageform::Vec;
using cageform_tests::Random;

namespace {

template <class T, std::size_t D>
Vec<T, D> random_vec(Random& random) {
    Vec<T, D> v{};
    for (std::size_t k = 0; k < D; ++k) v[k] = T(random.uniform(-10, 10));
    return v;
}

template <class T, std::size_t D>
void check_arithmetic(Random& random) {
    const auto a = random_vec<T, D>(random);
    const auto b = random_vec<T, D>(random);
    const T s = T(random.uniform(-3, 3));
    const auto sum = a + b;
    const auto difference = a - b;
    const auto scaled = s * a;
    T product = 0;
    T absolute = 0;
    for (std::size_t k = 0; k < D; ++k) {
        CHECK(sum[k] == a.v[k] + b.v[k]);
        CHECK(difference[k] == a.v[k] - b.v[k]);
        CHECK(scaled[k] == s * a.v[k]);
        product += a.v[k] * b.v[k];
        absolute += std::fabs(a.v[k] * b.v[k]);
    }
    // Equal up to the rounding of D products and sums: compilers may fuse either side.
    CHECK(std::fabs(dot(a, b) - product) <= T(D) * epsilon<T> * absolute);
    CHECK(dot(a, b) == dot(b, a));
    CHECK(a == a);
    CHECK((a == b) == (difference == Vec<T, D>{}));
    for (std::size_t k = 0; k < D; ++k) {
        auto other = a;
        other[k] += T(1);
        CHECK(!(other == a));
        CHECK(other - a != Vec<T, D>{});
    }
}

/// x is NaN or infinite if and only if all exponent bits are 1.
template <class T, class Bits>
void check_is_finite(unsigned exponent_bits, unsigned mantissa_bits, Random& random) {
    const Bits all_exponents = (Bits(1) << exponent_bits) - 1;
    const Bits all_mantissas = (Bits(1) << mantissa_bits) - 1;
    std::size_t wrong = 0;
    for (Bits exponent = 0; exponent <= all_exponents; ++exponent) {
        for (const Bits mantissa : {Bits(0), Bits(1), all_mantissas, Bits(random.bits()) & all_mantissas}) {
            for (const Bits sign : {Bits(0), Bits(1)}) {
                const Bits bits =
                    (sign << (exponent_bits + mantissa_bits)) | (exponent << mantissa_bits) | mantissa;
                wrong += is_finite(std::bit_cast<T>(bits)) != (exponent != all_exponents);
            }
        }
    }
    CHECK(wrong == 0);
}

} // namespace

TEMPLATE_TEST_CASE("vec arithmetic is componentwise", "[core][vec][property]", CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    check_arithmetic<TestType, 1>(random);
    check_arithmetic<TestType, 2>(random);
    check_arithmetic<TestType, 3>(random);
    check_arithmetic<TestType, 5>(random);
}

TEMPLATE_TEST_CASE("cross is the signed area of a parallelogram", "[core][vec][property]", CAGEFORM_SCALARS) {
    using V = Vec<TestType, 2>;
    STATIC_REQUIRE(cross(V{1, 0}, V{0, 1}) == 1); // left is positive
    STATIC_REQUIRE(cross(V{0, 1}, V{1, 0}) == -1);
    STATIC_REQUIRE(cross(V{2, 3}, V{5, 7}) == -1);

    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto a = random_vec<TestType, 2>(random);
    const auto b = random_vec<TestType, 2>(random);
    const TestType size = std::sqrt(dot(a, a) * dot(b, b));
    CHECK(std::fabs(cross(a, b) + cross(b, a)) <= 4 * epsilon<TestType> * size);
    CHECK(std::fabs(cross(a, a)) <= 2 * epsilon<TestType> * dot(a, a));
    const double angle = std::atan2(double(b[1]), double(b[0])) - std::atan2(double(a[1]), double(a[0]));
    CHECK(std::fabs(double(cross(a, b)) - double(size) * std::sin(angle)) <=
          8 * double(epsilon<TestType>) * double(size));
}

TEST_CASE("vec_cast rounds each component once", "[core][vec]") {
    const Vec<double, 3> fine{1.0 / 3, -2.5e-9, 7};
    const auto coarse = cageform::vec_cast<float>(fine);
    const auto back = cageform::vec_cast<double>(coarse);
    STATIC_REQUIRE(std::is_same_v<decltype(coarse), const Vec<float, 3>>);
    for (std::size_t k = 0; k < 3; ++k) {
        CHECK(coarse[k] == float(fine[k]));
        CHECK(back[k] == double(float(fine[k])));
    }
    STATIC_REQUIRE(cageform::vec_cast<float>(Vec<double, 2>{1, 2}) == Vec<float, 2>{1, 2});
}

TEST_CASE("is_finite tests the exponent", "[core][vec]") {
    Random random{1};
    check_is_finite<float, std::uint32_t>(8, 23, random);
    check_is_finite<double, std::uint64_t>(11, 52, random);
}

TEMPLATE_TEST_CASE("a vec is finite if all components are", "[core][vec]", CAGEFORM_SCALARS) {
    using limits = std::numeric_limits<TestType>;
    const Vec<TestType, 3> good{limits::max(), limits::lowest(), limits::denorm_min()};
    CHECK(is_finite(good));
    for (std::size_t k = 0; k < 3; ++k) {
        for (const TestType x : {limits::infinity(), -limits::infinity(), limits::quiet_NaN()}) {
            CAPTURE(k, x);
            auto bad = good;
            bad[k] = x;
            CHECK(!is_finite(bad));
        }
    }
    STATIC_REQUIRE(is_finite(TestType(1)));
    STATIC_REQUIRE(!is_finite(limits::infinity()));
}

TEMPLATE_TEST_CASE("a vec has the layout of its components", "[core][vec]", CAGEFORM_SCALARS) {
    using V = Vec<TestType, 3>;
    STATIC_REQUIRE(std::is_aggregate_v<V>);
    STATIC_REQUIRE(std::is_trivially_copyable_v<V>);
    STATIC_REQUIRE(std::is_trivially_default_constructible_v<V>);
    STATIC_REQUIRE(sizeof(V) == 3 * sizeof(TestType));
    STATIC_REQUIRE(V{1, 2, 3} + V{4, 5, 6} == V{5, 7, 9});
    STATIC_REQUIRE(dot(V{1, 2, 3}, V{4, 5, 6}) == 32);
    STATIC_REQUIRE(TestType(1) + epsilon<TestType> != TestType(1));
    STATIC_REQUIRE(TestType(1) + epsilon<TestType> / 2 == TestType(1));
}

TEST_CASE("scalars are float and double", "[core][vec]") {
    STATIC_REQUIRE(cageform::Scalar<float>);
    STATIC_REQUIRE(cageform::Scalar<double>);
    STATIC_REQUIRE(!cageform::Scalar<long double>);
    STATIC_REQUIRE(!cageform::Scalar<int>);
    STATIC_REQUIRE(!cageform::Scalar<const float>);
}

} // namespace vec_tests
