// The PointTraits of types whose components are read and written by `p[axis]`.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class P, class T, std::size_t D>
struct IndexedPointTraits {
    using scalar = T;
    static constexpr std::size_t dimension = D;
    static constexpr T get(const P& p, std::size_t axis) noexcept { return p[axis]; }
    static constexpr void set(P& p, std::size_t axis, T x) noexcept { p[axis] = x; }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
