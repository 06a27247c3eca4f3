// Numbers of every kind that no one should use, for fuzzers.
#pragma once

#include "cages.hpp"

#include <cmath>
#include <limits>

namespace cageform_tests {

/// Returns a number in [-2, 2] scaled far up or down, moved far away, or in place of it NaN or infinity.
///
///   kind  0 … 17; above 8 the number stays
template <class T>
T spoilt(Random& random, double x, std::size_t kind) {
    switch (kind) {
    case 1: return T(x * 1e300 * 1e8);
    case 2: return T(x * 1e-300 * 1e-20);
    case 3: return T(1e6 + x);
    case 4: return random.below(8) == 0 ? std::numeric_limits<T>::quiet_NaN() : T(x);
    case 5: return random.below(8) == 0 ? std::numeric_limits<T>::infinity() : T(x);
    case 6:
        return T(x * std::pow(10.0, random.uniform(sizeof(T) == 4 ? -44 : -320, sizeof(T) == 4 ? 38 : 308)));
    case 7: return T(x * double(std::numeric_limits<T>::max()));
    case 8: return T(x * double(std::numeric_limits<T>::min()));
    default: return T(x);
    }
}

} // namespace cageform_tests
