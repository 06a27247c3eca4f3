// A maximum that hides nothing.
#pragma once

#include <type_traits>

namespace cageform_tests {

/// The larger number; that which is none, where one is: no maximum hides it.
template <class A, class B>
constexpr std::common_type_t<A, B> larger(A a, B b) {
    return a != a || b <= a ? std::common_type_t<A, B>(a) : std::common_type_t<A, B>(b);
}

} // namespace cageform_tests
