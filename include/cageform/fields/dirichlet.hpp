// The discrete Dirichlet problem on the cells of a grid in one, two or three dimensions: some
// values are given, and each of the others is the mean of its neighbours. This is the solver behind
// harmonic coordinates, for general use: images filled in from a few known pixels, steady heat,
// number puzzles.
#pragma once

#include <cageform/core/types/scalar_range.hpp>
#include <cageform/core/view.hpp>
#include <cageform/fields/detail/unknown_cells.hpp>
#include <cageform/fields/types/dirichlet_options.hpp>
#include <cageform/grid/lattice/lattice.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Solves for the unknown cells of any number of fields.
///
///   cells    of the grid, numbered with the first axis fastest
///   kinds    #cells. With Rim::given every unknown cell must have all its 2·D neighbours in the
///            grid; links to cells outside are mirrored in any case
///   values   fields of #cells each, one after the other; given values are read, unknown ones
///            written, only when the status is ok. They lie between the least and the largest value
///            given to their component
///   cost     O(#unknown cells) a field, sixteen together; memory: Multigrid::bytes() once,
///            block_bytes() a thread, the unknown values once more, and 8 bytes an unknown cell.
///            Progress is reported before every cycle. Usually 9 to 13 cycles; mazes of outside
///            cells need more, and max_cycles may have to be raised. SolverReport::Multigrid::error_bound
///            holds
///            if nothing is mirrored
///   fails    rim_not_given and value_not_finite (SolverReport::culprit is the cell, or the index
///            in `values`); cells_unreached, if a connected component of unknown cells touches no
///            given one (its first cell, and the number of cells in all such components);
///            input_malformed (a mark that is no Cell, at `culprit`); tolerance_not_positive;
///            not_converged; cancelled; out_of_memory (also for 2³¹ cells and more)
template <std::size_t D, MutableScalarRange V>
Evaluation solve_dirichlet(const CellBox<D>& cells, std::span<const Cell> kinds, V&& values,
                           const DirichletOptions& options = {}, const Running& running = {}) {
    using T = detail::element_t<V>;
    const std::span<T> fields(values);
    const std::size_t size = cells.size();
    CAGEFORM_ASSERT(kinds.size() == size && (size == 0 ? fields.empty() : fields.size() % size == 0),
                    "a mark for each cell, and whole fields");
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
        return detail::solve_fields(unknown, fields, options, report, running);
    });
}
/// Solves the problem on grids without outside cells.
///
///   given    #cells; 0 where the value is unknown
template <std::size_t D, MutableScalarRange V>
Evaluation solve_dirichlet(const CellBox<D>& cells, std::span<const std::uint8_t> given, V&& values,
                           const DirichletOptions& options = {}, const Running& running = {}) {
    std::vector<Cell> kinds;
    const Status status = detail::guard_memory([&] {
        kinds.reserve(given.size());
        for (const std::uint8_t mark : given) kinds.push_back(mark != 0 ? Cell::given : Cell::unknown);
        return Status::ok;
    });
    if (status != Status::ok) return {status, {}};
    return solve_dirichlet(cells, std::span<const Cell>(kinds), values, options, running);
}

} // namespace cageform::inline CAGEFORM_ABI
