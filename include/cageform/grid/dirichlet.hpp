// The discrete Dirichlet problem on the cells of a grid, in one, two or three dimensions: some values are given, each of
// the others is the mean of its neighbours. What harmonic coordinates are made with, for any use: images filled in from
// a few known pixels, heat that has come to rest, crosswords of numbers.
#pragma once

#include <cageform/grid/detail/group_progress.hpp>
#include <cageform/grid/lattice.hpp>
#include <cageform/grid/multigrid.hpp>

#include <chrono>
#include <mutex>

namespace cageform::inline CAGEFORM_ABI {

struct DirichletOptions {
    double tolerance =
        1e-6; ///< of the error, by its estimate, relative to the range of a field's given values
    std::size_t max_cycles = 60; ///< not_converged when they do not suffice
};

/// Fills in the unknown cells of any number of fields.
///
///   cells    of the grid, numbered along the first axis first
///   given    #cells; 0 where the value is unknown. Every unknown cell must have all its 2·D neighbours in the grid
///   values   fields of #cells each, one after the other; values given are read, unknown ones are written when the
///            status is ok, and not before
///   cost     O(#unknown cells) a field, sixteen together; memory: Multigrid::bytes() once, block_bytes() a thread, the
///            unknown values once more, and 8 bytes an unknown cell. The progress is asked after every cycle on the
///            calling thread, which has to take part in the work
///   fails    rim_not_given and value_not_finite (SolverReport::culprit is the cell, or the place in `values`);
///            tolerance_not_positive; not_converged; cancelled; out_of_memory (also for 2³¹ cells and more)
template <std::size_t D, Scalar T>
Evaluation solve_dirichlet(const CellBox<D>& cells, std::span<const std::uint8_t> given, std::span<T> values,
                           const DirichletOptions& options = {}, const Running& running = {}) {
    const std::size_t size = cells.size();
    CAGEFORM_ASSERT(given.size() == size && (size == 0 ? values.empty() : values.size() % size == 0),
                    "a mark for each cell, and whole fields");
    Evaluation evaluation;
    SolverReport& report = evaluation.solver;
    const auto fail = [&](Status status, std::size_t culprit) {
        report.culprit = culprit;
        return status;
    };
    evaluation.status = detail::guard_memory([&] {
        if (!(options.tolerance > 0)) return Status::tolerance_not_positive;
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (given[i % size] != 0 && !std::isfinite(values[i])) return fail(Status::value_not_finite, i);
        }
        constexpr auto most = std::size_t(std::numeric_limits<std::int32_t>::max());
        if (size > most || cells.cells[0] > most) return Status::out_of_memory;
        const auto start = std::chrono::steady_clock::now();
        typename NodeRuns<D>::Index counts;
        for (std::size_t k = 0; k < D; ++k) counts[k] = std::int32_t(cells.cells[k]);
        NodeRuns<D> nodes(counts);
        std::vector<std::size_t> unknown; // the cell of each node
        for (std::size_t row = 0; row < size; row += cells.cells[0]) {
            for (std::size_t x = 0; x < cells.cells[0];) {
                std::size_t end = x;
                for (; end < cells.cells[0] && given[row + end] == 0; ++end) unknown.push_back(row + end);
                nodes.add_run(std::int32_t(x), std::int32_t(end));
                x = end + 1;
            }
            nodes.end_row();
        }
        report.cells = nodes.count();
        if (unknown.empty()) return Status::ok;
        std::vector<CutLink> cuts;
        std::vector<std::size_t> cells_of_cuts;
        std::size_t open = SolverReport::none;
        nodes.for_each_end([&](const auto& index, std::uint32_t node, std::size_t direction) {
            const std::size_t axis = direction / 2;
            const bool up = (direction & 1) != 0;
            if (up ? index[axis] + 1 == counts[axis] : index[axis] == 0) {
                open = std::min(open, unknown[node]);
                return;
            }
            cuts.push_back({node, std::uint8_t(direction), 1.0});
            cells_of_cuts.push_back(up ? unknown[node] + cells.stride(axis)
                                       : unknown[node] - cells.stride(axis));
        });
        if (open != SolverReport::none) return fail(Status::rim_not_given, open);

        const Multigrid<D> multigrid(nodes, cuts, {});
        report.bytes = multigrid.bytes() + multigrid.block_bytes();
        const auto slot = multigrid.source_slots();
        constexpr std::size_t width = Multigrid<D>::width;
        const std::size_t fields = values.size() / size, groups = (fields + width - 1) / width;
        std::vector<T> solved(fields * unknown.size());
        std::mutex access;
        detail::GroupProgress progress(running.progress, groups);
        const auto solve_group = [&](std::size_t first, typename Multigrid<D>::Block& block) {
            const std::size_t count = std::min(width, fields - first);
            std::array<double, width> middle{},
                half{}; // of each field's values, which are solved for in [−1, 1]
            for (auto& row : block.source) row.fill(0.0);
            for (std::size_t k = 0; k < count; ++k) {
                const T* const field = values.data() + (first + k) * size;
                double low = double(field[cells_of_cuts[0]]), high = low;
                for (const std::size_t cell : cells_of_cuts) {
                    low = std::fmin(low, double(field[cell]));
                    high = std::fmax(high, double(field[cell]));
                }
                middle[k] = 0.5 * low + 0.5 * high;
                half[k] = 0.5 * high - 0.5 * low;
                for (std::size_t c = 0; c < cuts.size() && half[k] > 0; ++c) {
                    block.source[slot[cuts[c].node]][k] +=
                        (double(field[cells_of_cuts[c]]) - middle[k]) / half[k];
                }
            }
            auto error = multigrid.start(block);
            std::size_t cycles = 0;
            const auto is_met = [&] {
                bool met = block.is_refined();
                for (std::size_t k = 0; k < count; ++k)
                    met = met && error.estimate[k] <= 2 * options.tolerance;
                return met;
            };
            while (!is_met() && cycles < options.max_cycles && !progress.cancelled()) {
                error = multigrid.cycle(block);
                ++cycles;
                (void)progress.keep_going(double(cycles) / double(cycles + 4));
            }
            progress.end_group();
            for (std::uint32_t node = 0; node < unknown.size(); ++node) {
                const auto value = block.value(node);
                for (std::size_t k = 0; k < count; ++k)
                    solved[(first + k) * unknown.size() + node] =
                        static_cast<T>(middle[k] + half[k] * value[k]);
            }
            const std::lock_guard lock(access);
            report.solves += count;
            report.cycles = std::max(report.cycles, cycles);
            if (!is_met()) report.unconverged += count;
            for (std::size_t k = 0; k < count; ++k) {
                report.error_estimate = std::max(report.error_estimate, 0.5 * error.estimate[k]);
                report.error_bound = std::max(report.error_bound, 0.5 * error.bound[k]);
            }
        };
        detail::in_parallel(running, groups, 1, [&](std::size_t begin, std::size_t end) {
            auto block = multigrid.make_block();
            for (std::size_t group = begin; group < end && !progress.cancelled(); ++group)
                solve_group(group * width, block);
        });
        report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        if (progress.cancelled()) return Status::cancelled;
        if (report.unconverged > 0) return Status::not_converged;
        for (std::size_t f = 0; f < fields; ++f) {
            for (std::size_t node = 0; node < unknown.size(); ++node)
                values[f * size + unknown[node]] = solved[f * unknown.size() + node];
        }
        return Status::ok;
    });
    return evaluation;
}

} // namespace cageform::inline CAGEFORM_ABI
