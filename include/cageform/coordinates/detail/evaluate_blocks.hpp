// Evaluates coordinates of closed form in blocks.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Implements `evaluate`: calls body(first, last) for ranges of blocks, unless the cage is refused.
template <class T, class Body>
Evaluation evaluate_blocks(const CageReport& cage, [[maybe_unused]] std::size_t rows, const Batch<T>& batch,
                           const Running& running, const Body& body) {
    if (cage.status != Status::ok) return {cage.status, {}};
    CAGEFORM_ASSERT(batch.rows.rows == rows && batch.states.size() == batch.points.points,
                    "one row per handle");
    return {for_each_block(batch.points.blocks(), running, body), {}};
}

} // namespace cageform::inline CAGEFORM_ABI::detail
