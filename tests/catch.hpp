// Hides which Catch2 is installed: version 2 (Debian 12) or 3.
#pragma once

#if defined(CAGEFORM_CATCH3)
#include <catch2/catch_approx.hpp>
#include <catch2/catch_template_test_macros.hpp>
#include <catch2/catch_test_macros.hpp>
#include <catch2/generators/catch_generators.hpp>
#include <catch2/generators/catch_generators_range.hpp>
#include <catch2/matchers/catch_matchers.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif

#include <string>

/// Whether this is a build with the address sanitizer, in which long computations take minutes.
#if defined(__SANITIZE_ADDRESS__)
#define CAGEFORM_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define CAGEFORM_SANITIZED 1
#endif
#endif

/// The scalars that a test is compiled for. Nothing that sanitizers detect depends on the scalar except
/// the width of the blocks, so they test one scalar: the other would double the time to compile.
#if defined(CAGEFORM_SANITIZED)
#define CAGEFORM_SCALARS float
#else
#define CAGEFORM_SCALARS float, double
#endif

/// `GENERATE(seeds(50))` runs a test case for the seeds 0 … 49.
inline auto seeds(int count) {
    return Catch::Generators::range(0, count);
}

/// `CHECK_THAT(text, containing("part"))`: the matcher's name differs.
inline auto containing(const std::string& part) {
#if defined(CAGEFORM_CATCH3)
    return Catch::Matchers::ContainsSubstring(part);
#else
    return Catch::Matchers::Contains(part);
#endif
}
