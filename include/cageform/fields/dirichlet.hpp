// The discrete Dirichlet problem on grids in one, two or three dimensions. Some cells have given values. The
// value of each other cell is the mean of its neighbours' values. The solver is that of harmonic coordinates.
// Applications: images filled in from known pixels, steady heat, number puzzles.
#pragma once

#include <cageform/core/types/scalar_range.hpp>
#include <cageform/core/view.hpp>
#include <cageform/fields/detail/unknown_cells.hpp>
#include <cageform/fields/types/dirichlet_options.hpp>
#include <cageform/grid/lattice/lattice.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Solves for the unknown cells of any number of fields.
///
///   cells    the grid, numbered with the first axis fastest
///   kinds    #cells. With Rim::given every unknown cell must have all its 2·D neighbours in the grid. With
///            either Rim, no flux passes to a neighbour that is Cell::outside
///   values   fields of #cells each, one after the other; reads given values and writes unknown ones, only
///            if the status is ok. Results lie between the smallest and the largest given value of their
///            component
///   cost     O(#unknown cells) per field; sixteen fields are solved together. Memory: Multigrid::bytes()
///            once, block_bytes() per thread, the unknown values, and 8 bytes per unknown cell. Reports
///            progress before every cycle. Usually 9 to 13 cycles suffice. If the outside cells form a maze,
///            more are needed; raise max_cycles then. SolverReport::Multigrid::error_bound is valid if
///            nothing is mirrored
///   fails    rim_not_given and value_not_finite (SolverReport::culprit is the cell, or the index in
///            `values`); cells_unreached if a connected component of unknown cells touches no given one
///            (its first cell, and the number of cells in all such components); input_malformed (an invalid
///            Cell, at `culprit`); tolerance_not_positive; not_converged; cancelled; out_of_memory (also
///            for 2³¹ cells and more)
template <std::size_t D, MutableScalarRange V>
Evaluation solve_dirichlet(const CellBox<D>& cells, std::span<const Cell> kinds, V&& values,
                           const DirichletOptions& options = {}, const Running& running = {}) {
    using T = detail::element_t<V>;
    const std::span<T> fields(values);
    const std::size_t size = cells.size();
    CAGEFORM_ASSERT(kinds.size() == size && (size == 0 ? fields.empty() : fields.size() % size == 0),
                    "one mark per cell, values of whole fields");
    return detail::guarded_evaluation([&](SolverReport& report) {
        const auto fail = [&](Status status, std::size_t culprit) {
            report.culprit = culprit;
            return status;
        };
        if (!(options.tolerance > 0)) return Status::tolerance_not_positive;
        for (std::size_t i = 0; i < size; ++i) {
            if (kinds[i] > Cell::outside) return fail(Status::input_malformed, i);
        }
        for (std::size_t i = 0; i < fields.size(); ++i) {
            if (kinds[i % size] == Cell::given && !std::isfinite(fields[i]))
                return fail(Status::value_not_finite, i);
        }
        constexpr auto most = std::size_t((std::numeric_limits<std::int32_t>::max)());
        if (size > most || cells.cells[0] > most) return Status::out_of_memory;
        const detail::UnknownCells<D> unknown(cells, kinds, options.rim);
        report.cells = unknown.cells.size();
        if (unknown.without_rim != SolverReport::none)
            return fail(Status::rim_not_given, unknown.without_rim);
        if (unknown.cells.empty()) return Status::ok;
        unknown.find_unreached(report);
        if (report.unreached_cells > 0) return Status::cells_unreached;
        return detail::solve_cells(unknown, fields, options, report, running);
    });
}
/// Solves the problem on grids without outside cells.
///
///   given    #cells; 0 if the value is unknown
template <std::size_t D, MutableScalarRange V>
Evaluation solve_dirichlet(const CellBox<D>& cells, std::span<const std::uint8_t> given, V&& values,
                           const DirichletOptions& options = {}, const Running& running = {}) {
    std::vector<Cell> kinds;
    const Status status = detail::guard_memory([&] {
        kinds.reserve(given.size());
        for (const std::uint8_t mark : given) kinds.push_back(mark != 0 ? Cell::given : Cell::unknown);
    });
    if (status != Status::ok) return {status, {}};
    return solve_dirichlet(cells, std::span<const Cell>(kinds), values, options, running);
}

} // namespace cageform::inline CAGEFORM_ABI
