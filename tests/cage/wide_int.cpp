#include "catch.hpp"
#include "support/cages.hpp"

#include <cageform/cage/sites/wide_int.hpp>

namespace wide_int_tests {

using cageform::detail::WideFloat;
using cageform::detail::WideInt;
using cageform_tests::Random;

TEST_CASE("WideInt follows the laws of integers", "[core][wide_int][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 100)));
    CAPTURE(seed);
    Random random(seed);
    const auto any = [&] { return std::int64_t(random.bits()) >> random.below(64); };
    const WideInt a = WideInt(any()) * WideInt(any()), b = WideInt(any()) * WideInt(any()), c(any());
    const auto equal = [](const WideInt& x, const WideInt& y) { return (x - y).sign() == 0; };
    CHECK(equal(a * b, b * a));
    CHECK(equal((a + b) * c, a * c + b * c));
    CHECK(equal((a - b) * (a + b), a * a - b * b));
    CHECK((a * a + WideInt(1)).sign() == 1);
    CHECK((-(a * a) - WideInt(1)).sign() == -1);
    const std::int64_t x = any() >> 32, y = any() >> 32;
    CHECK((WideInt(x) * WideInt(y) - WideInt(x * y)).sign() == 0);
    CHECK((WideInt(x) - WideInt(y)).sign() == (x > y) - (x < y));
    // A factor of 2^64 at a time, up to the largest.
    WideInt power(1);
    for (int n = 0; n < 318; ++n) power = power + power;
    CHECK(power.sign() == 1);
    CHECK(double(WideFloat(power)) == std::ldexp(1.0, 318));
    CHECK(double(WideFloat(-power)) == -std::ldexp(1.0, 318));
}

TEST_CASE("WideFloat is accurate to 120 bits", "[core][wide_int][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 100)));
    CAPTURE(seed);
    Random random(seed);
    const auto any = [&] { return (std::int64_t(random.bits()) >> random.below(63)) | 1; };
    const std::int64_t x = any(), y = any(), z = any();
    const WideInt sum = WideInt(x) * WideInt(y) + WideInt(z); // below 2^127: nothing is rounded
    const WideFloat same = WideFloat(x) * WideFloat(y) + WideFloat(z);
    CHECK(double(WideFloat(sum) - same) == 0);
    CHECK(double(WideFloat(x) - WideFloat(x)) == 0);
    CHECK(double(WideFloat(x)) == double(x));
    const double left = double(WideFloat(y) * inverse(WideFloat(y)) - WideFloat(1));
    CHECK(std::fabs(left) <= 0x1p-118);
    // A difference far below both operands.
    const WideFloat quotient = WideFloat(x) * inverse(WideFloat(y));
    CHECK(std::fabs(double(quotient * WideFloat(y) - WideFloat(x))) <= 0x1p-116 * std::fabs(double(x)));
    const WideFloat large = WideFloat(x) * WideFloat(x) * WideFloat(x) * WideFloat(x);
    CHECK(double(large + WideFloat(1) - large) ==
          (std::fabs(double(x)) < 0x1p30 ? 1 : double(large + WideFloat(1) - large)));
    CHECK(double(WideFloat() + WideFloat(y)) == double(y));
    CHECK(double(WideFloat() * WideFloat(y)) == 0);
}

} // namespace wide_int_tests
