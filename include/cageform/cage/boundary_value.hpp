// Boundary data at a place of a cage.
#pragma once

#include <cageform/core/vec.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// The boundary data at a place: the handles whose hat functions do not vanish there, and their values, which sum to 1.
template <std::size_t D>
struct BoundaryValue {
    static constexpr std::size_t most = D <= 2 ? D : 4; ///< a vertex, an edge, a triangle or quadrilateral
    std::array<std::uint32_t, most> handle{};
    std::array<double, most> weight{};
};

namespace detail {

/// The two axes across an axis of space, in order.
inline constexpr std::array<std::array<std::size_t, 2>, 3> other_axes{{{1, 2}, {0, 2}, {0, 1}}};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
