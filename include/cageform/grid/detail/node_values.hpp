// What one node holds: the values of sixteen functions, which are solved together.
#pragma once

#include <cageform/core/blocks.hpp>
#include <cageform/core/buffer.hpp>

#include <array>
#include <cstring>

namespace cageform::inline CAGEFORM_ABI::detail {

using NodeRow = Lanes<float>; ///< as the cycles work on them: a cache line
inline constexpr std::size_t functions_together = lane_count<float>;
using NodeValues = std::array<double, functions_together>; ///< as the caller gives and reads them

/// Of one level: A u = b.
struct Fields {
    Buffer<NodeRow> u, b;
};

inline void set_zero(Buffer<NodeRow>& rows) noexcept {
    if (rows.empty()) return; // memset is not to be given a null pointer
    std::memset(static_cast<void*>(rows.data()), 0, rows.size() * sizeof(NodeRow));
}

} // namespace cageform::inline CAGEFORM_ABI::detail
