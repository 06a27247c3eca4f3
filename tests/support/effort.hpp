// How large tests are: smaller under sanitizers, which look for what the code does wrong and not for what
// it computes.
#pragma once

#include "../catch.hpp"

namespace cageform_tests {

/// `full`, or in a build with sanitizers `reduced`: of resolutions, and of the number of random cases.
template <class Number>
constexpr Number effort([[maybe_unused]] Number full, [[maybe_unused]] Number reduced) {
#if defined(CAGEFORM_SANITIZED)
    return reduced;
#else
    return full;
#endif
}

} // namespace cageform_tests
