// Evaluates coordinates of closed form block by block.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <cstddef>
#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Implements `evaluate` for closed forms: calls body(first, last) for ranges of blocks if the cage
/// is sound.
template <class T, class Body>
Evaluation evaluate_blocks(const CageReport& cage, [[maybe_unused]] std::size_t rows, const Batch<T>& batch,
                           const Running& running, const Body& body) {
    if (cage.status != Status::ok) return {cage.status, {}};
    CAGEFORM_ASSERT(batch.rows.rows == rows && batch.states.size() == batch.points.points,
                    "one row per handle");
    return {for_each_block(batch.points.blocks(), running, body), {}};
}

} // namespace cageform::inline CAGEFORM_ABI::detail
