// Strokes and walls on a lattice: interior cells without a cage, on a canvas whose boundary has no data.
#pragma once

#include <cageform/grid/lattice/simplex_boundary.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Cells without an outer boundary, with the interface of a cage for `SimplexBoundary`.
template <std::size_t D>
struct OpenCells {
    std::vector<Vec<double, D>> points;
    InteriorCells<D> cells;

    std::span<const Vec<double, D>> vertices() const noexcept { return points; }
};
template <std::size_t D, class F>
void for_each_facet(const OpenCells<D>&, F&&) {}
template <std::size_t D>
const InteriorCells<D>& interior_cells(const OpenCells<D>& drawing) noexcept {
    return drawing.cells;
}

/// Strokes on a canvas. The boundary of the canvas is half a cell beyond the last nodes and has no data.
template <std::size_t D>
class CanvasBoundary : public grid::SimplexBoundary<D> {
    using Base = grid::SimplexBoundary<D>;

public:
    CanvasBoundary(const OpenCells<D>& drawing, const Lattice<double, D>& lattice)
        : Base(drawing, lattice, std::uint32_t(drawing.points.size())) {}

    grid::Crossings<D> crossings() const {
        auto all = Base::crossings();
        for (std::size_t axis = 0; axis < D; ++axis) {
            const std::size_t nodes = this->lattice().cells[axis], lines = this->lattice().size() / nodes;
            for (std::uint32_t line = 0; line < lines; ++line) {
                all[axis].push_back({line, true, -0.5, {}});
                all[axis].push_back({line, true, double(nodes) - 0.5, {}});
            }
            grid::sort_along_lines<D>(all[axis]);
        }
        return all;
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
