// The values of sixteen functions at one node.
#pragma once

#include <cageform/core/types/blocks.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/multigrid/helping_threads.hpp>

#include <array>
#include <cstring>

namespace cageform::inline CAGEFORM_ABI::detail {

using NodeRow = Lanes<float>; ///< in the cycles: a cache line
inline constexpr std::size_t functions_together = lane_count<float>;
using NodeValues = std::array<double, functions_together>; ///< in the interface

/// The unknowns u and right-hand sides b of one level, A u = b.
struct Fields {
    Buffer<NodeRow> u, b;
};

inline void set_zero(Buffer<NodeRow>& rows, std::size_t begin, std::size_t end) noexcept {
    if (begin == end) return; // memset must not receive a null pointer
    std::memset(static_cast<void*>(rows.data() + begin), 0, (end - begin) * sizeof(NodeRow));
}
inline void set_zero(Buffer<NodeRow>& rows, const WorkShare& share) noexcept {
    constexpr std::size_t worth_sharing = 16384; // a megabyte
    share.for_ranges(rows.size(), worth_sharing,
                     [&](std::size_t begin, std::size_t end) { set_zero(rows, begin, end); });
}

} // namespace cageform::inline CAGEFORM_ABI::detail
