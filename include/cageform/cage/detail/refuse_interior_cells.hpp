// The fault of a cell complex in a coordinate type that does not support interior cells.
#pragma once

#include <cageform/cage/cell_complex.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <Scalar T, std::size_t D>
void refuse_interior_cells(const CellComplex<T, D>& cage, CageReport& report) {
    const std::size_t cells = cage.cells().facets.size() + cage.cells().bones.size();
    if (cells > 0 || cage.size() > cage.boundary().size())
        report.add(CageFaultKind::interior_cells_not_supported, cells);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
