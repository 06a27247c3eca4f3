// Hides which Catch2 is installed, version 2 (Debian 12) or 3, and chooses the scalars of the tests.
#pragma once

#include "support/precompiled.hpp"

#if defined(CAGEFORM_CATCH3)
using Catch::Approx;
#endif

/// Whether this is a build with the address sanitizer, in which long computations take minutes.
#if defined(__SANITIZE_ADDRESS__)
#define CAGEFORM_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define CAGEFORM_SANITIZED 1
#endif
#endif

/// The scalars that a test is compiled for: both, except under sanitizers, where a test of double takes twice
/// as long and goes through the same code.
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
