// The bare solve, as other code is measured against it: right-hand sides in, functions out.
#pragma once

#include <cageform/grid/multigrid.hpp>

#include <algorithm>

namespace cageform_bench {

/// Solves a block whose source is written to an estimated error; returns the cycles.
template <std::size_t D>
std::size_t run_cycles(const cageform::Multigrid<D>& multigrid, typename cageform::Multigrid<D>::Block& block,
                       double tolerance = 1e-6) {
    auto error = multigrid.start(block);
    std::size_t cycles = 0;
    while (!block.is_refined() ||
           *std::max_element(error.estimate.begin(), error.estimate.end()) > tolerance) {
        error = multigrid.cycle(block);
        ++cycles;
    }
    return cycles;
}

} // namespace cageform_bench
