// The papers' solver of the Laplace equation on a grid: averaging sweeps, from coarse grids to fine
// ones.
//
// It is the historical baseline, with a known weakness: it stops when values change little, even if they are
// inaccurate. On large grids errors of 1e-2 remain at the published tolerance.
#pragma once

#include "averaging/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace cageform_sources::averaging {

/// The neighbours of a cell. Their mean is the value of the cell.
enum class Stencil : std::uint8_t {
    /// 2, 4 or 6 (in 1D, 2D, 3D): the usual discrete Laplace equation.
    face_neighbours,
    all_neighbours, ///< 2, 8 or 26, including diagonals, with equal weights: "harmonic crosswords"
};

struct AveragingOptions {
    Stencil stencil = Stencil::face_neighbours;
    /// Cells per side of the coarsest level. If the grid is not larger, there is one level.
    std::size_t coarsest = 16;
    double tolerance = 1e-5;         ///< τ: sweeps end when the mean change of a cell is below it; 0: never
    std::size_t max_sweeps = 100000; ///< on each level
    /// Sweeps start with the given values of interior cells instead of 0. There is then one level,
    /// whatever `coarsest` is.
    bool use_initial_values = false;
};

struct AveragingOutcome {
    std::size_t sweeps = 0; ///< on the finest level
    double mean_change = 0; ///< in the last sweep
    bool converged = false;
    bool cancelled = false;
};

/// Solves for the interior cells of a grid of any dimension, given the values of the boundary
/// cells. These may lie anywhere (a border, strokes, single cells). Neighbours that are exterior or
/// beyond the grid are left out of the mean; with face neighbours this equals mirroring the grid
/// there.
///
/// Joshi, Meyer, DeRose, Green, Sanocki, Harmonic Coordinates for Character Articulation (SIGGRAPH 2007),
/// sec. 4 and 4.2. If a side has an odd number of cells, the last coarse cell has only one child along it.
/// The paper's grids have 2^s cells per side. Sweeps are in place (Gauss-Seidel), in the order of the cells.
///
/// Construction O(#cells); a solve O(#interior · sweeps). Solves one function at a time, as
/// published. A cell takes a tag and a scalar on each level; in float, including the field itself,
/// about 10 bytes (the paper's: 12).
template <Scalar T, std::size_t D>
class AveragingPyramid {
public:
    AveragingPyramid(const CellBox<D>& box, std::vector<CellTag> tags, const AveragingOptions& options = {})
        : options_(options) {
        CAGEFORM_ASSERT(tags.size() == box.size(), "one tag per cell");
        CAGEFORM_ASSERT(box.size() <= (std::numeric_limits<std::uint32_t>::max)(),
                        "cells have 32-bit numbers");
        levels_.push_back(Level(box, std::move(tags), options.stencil));
        for (;;) {
            const auto& cells = levels_.back().box.cells;
            const std::size_t longest = *std::max_element(cells.begin(), cells.end());
            if (options.use_initial_values || longest <= options.coarsest || longest < 2) break;
            levels_.push_back(coarsen(levels_.back(), options.stencil));
        }
    }

    std::size_t unknowns() const noexcept { return levels_[0].unknowns; }

    /// Fills the interior cells of `values` (#cells). Reads the boundary cells, and with use_initial_values
    /// the interior cells, which must then be finite. Ignores all other cells. Calls `keep_going()`
    /// regularly; false cancels. The object holds scratch memory, so use one pyramid per thread.
    template <class KeepGoing>
    AveragingOutcome solve(std::span<T> values, const KeepGoing& keep_going) {
        CAGEFORM_ASSERT(values.size() == levels_[0].box.size(), "one value per cell");
        levels_[0].values.assign(values.begin(), values.end());
        for (std::size_t l = 1; l < levels_.size(); ++l) restrict_data(levels_[l - 1], levels_[l]);
        if (!options_.use_initial_values)
            levels_.back().for_each_unknown([&](std::size_t c) { levels_.back().values[c] = T(0); });
        AveragingOutcome outcome;
        for (std::size_t l = levels_.size(); l-- > 0;) {
            Level& level = levels_[l];
            if (l + 1 < levels_.size()) push(levels_[l + 1], level);
            outcome = relax(level, keep_going);
            if (outcome.cancelled) return outcome;
        }
        levels_[0].for_each_unknown([&](std::size_t c) { values[c] = levels_[0].values[c]; });
        return outcome;
    }

    AveragingOutcome solve(std::span<T> values) {
        return solve(values, [] { return true; });
    }

private:
    struct Run {
        std::uint32_t begin, end;
    };
    struct Level {
        CellBox<D> box;
        std::vector<CellTag> tags;
        std::vector<T> values;
        std::vector<Run> regular;       // interior cells whose neighbours all count
        std::vector<std::uint32_t> rim; // the other interior cells
        std::vector<std::ptrdiff_t> offsets;
        std::size_t unknowns = 0;

        Level(const CellBox<D>& b, std::vector<CellTag> t, Stencil stencil)
            : box(b)
            , tags(std::move(t)) {
            for_each_neighbour(stencil, [&](const std::array<int, D>& step) {
                std::ptrdiff_t offset = 0;
                for (std::size_t k = 0; k < D; ++k) offset += step[k] * std::ptrdiff_t(box.stride(k));
                offsets.push_back(offset);
            });
            for (std::size_t row = 0; row < tags.size(); row += box.cells[0]) find_unknowns(row);
        }

        bool counts(std::size_t c) const noexcept {
            return tags[c] == CellTag::boundary || tags[c] == CellTag::interior;
        }
        void find_unknowns(std::size_t row) {
            const std::size_t length = box.cells[0];
            const auto index = box.index(row);
            bool at_rim = false;
            for (std::size_t k = 1; k < D; ++k)
                at_rim = at_rim || index[k] == 0 || index[k] + 1 == box.cells[k];
            for (std::size_t x = 0; x < length; ++x) {
                const std::size_t c = row + x;
                if (tags[c] != CellTag::interior) continue;
                ++unknowns;
                bool all = !at_rim && x != 0 && x + 1 != length;
                for (std::size_t n = 0; all && n < offsets.size(); ++n)
                    all = counts(std::size_t(std::ptrdiff_t(c) + offsets[n]));
                if (!all) {
                    rim.push_back(std::uint32_t(c));
                } else if (regular.empty() || regular.back().end != c) {
                    regular.push_back({std::uint32_t(c), std::uint32_t(c + 1)});
                } else {
                    ++regular.back().end;
                }
            }
        }

        template <class F>
        void for_each_unknown(const F& f) const {
            for (const auto& [begin, end] : regular) {
                for (std::size_t c = begin; c < end; ++c) f(c);
            }
            for (const std::size_t c : rim) f(c);
        }

        template <class F>
        static void for_each_neighbour(Stencil stencil, const F& f) {
            std::array<int, D> step;
            std::size_t all = 1;
            for (std::size_t k = 0; k < D; ++k) all *= 3;
            for (std::size_t code = 0; code < all; ++code) {
                std::size_t rest = code, moved = 0;
                for (std::size_t k = 0; k < D; ++k, rest /= 3) {
                    step[k] = int(rest % 3) - 1;
                    moved += step[k] != 0;
                }
                if (moved == 1 || (moved > 1 && stencil == Stencil::all_neighbours)) f(step);
            }
        }

        template <class F>
        void each_counted_neighbour(std::size_t cell, Stencil stencil, const F& f) const {
            const auto index = box.index(cell);
            for_each_neighbour(stencil, [&](const std::array<int, D>& step) {
                auto next = index;
                for (std::size_t k = 0; k < D; ++k) {
                    if ((step[k] < 0 && next[k] == 0) || (step[k] > 0 && next[k] + 1 == box.cells[k])) return;
                    next[k] += std::size_t(step[k]);
                }
                const std::size_t n = box.number(next);
                if (counts(n)) f(n);
            });
        }
    };

    /// Returns the coarse cell that contains a cell.
    static std::size_t parent(const Level& fine, const CellBox<D>& coarse, std::size_t cell) noexcept {
        auto index = fine.box.index(cell);
        for (std::size_t& i : index) i /= 2;
        return coarse.number(index);
    }

    /// Makes the next coarser level. A coarse cell is boundary if any child is, exterior if all
    /// children are, else interior (sec. 4.2).
    static Level coarsen(const Level& fine, Stencil stencil) {
        CellBox<D> box;
        for (std::size_t k = 0; k < D; ++k) box.cells[k] = (fine.box.cells[k] + 1) / 2;
        std::vector<CellTag> tags(box.size(), CellTag::exterior);
        for (std::size_t c = 0; c < fine.tags.size(); ++c) {
            CellTag& tag = tags[parent(fine, box, c)];
            if (fine.tags[c] == CellTag::boundary ||
                (fine.tags[c] == CellTag::interior && tag == CellTag::exterior)) {
                tag = fine.tags[c];
            }
        }
        return Level(box, std::move(tags), stencil);
    }

    /// Restricts the data: a coarse boundary cell gets the mean of its boundary children.
    static void restrict_data(const Level& fine, Level& coarse) {
        coarse.values.assign(coarse.tags.size(), T(0));
        std::vector<T> children(coarse.tags.size(), T(0));
        for (std::size_t c = 0; c < fine.tags.size(); ++c) {
            if (fine.tags[c] != CellTag::boundary) continue;
            const std::size_t p = parent(fine, coarse.box, c);
            coarse.values[p] += fine.values[c];
            children[p] += T(1);
        }
        for (std::size_t c = 0; c < children.size(); ++c) {
            if (children[c] > T(0)) coarse.values[c] /= children[c];
        }
    }

    /// Prolongs the solution: an interior cell starts with the value of its parent.
    static void push(const Level& coarse, Level& fine) {
        for (const auto& [begin, end] : fine.regular) {
            const std::size_t x = begin % fine.box.cells[0], first = parent(fine, coarse.box, begin) - x / 2;
            for (std::size_t c = begin; c < end; ++c)
                fine.values[c] = coarse.values[first + (x + c - begin) / 2];
        }
        for (const std::size_t c : fine.rim) fine.values[c] = coarse.values[parent(fine, coarse.box, c)];
    }

    template <class KeepGoing>
    AveragingOutcome relax(Level& level, const KeepGoing& keep_going) const {
        AveragingOutcome outcome;
        const std::size_t count = level.unknowns;
        outcome.converged = count == 0;
        const std::size_t check_every = std::max<std::size_t>(1, 1000000 / std::max<std::size_t>(count, 1));
        while (!outcome.converged && outcome.sweeps < options_.max_sweeps) {
            outcome.mean_change = sweep(level) / double(count);
            ++outcome.sweeps;
            outcome.converged = outcome.mean_change < options_.tolerance;
            if (outcome.sweeps % check_every == 0 && !keep_going()) {
                outcome.cancelled = true;
                break;
            }
        }
        return outcome;
    }

    /// Returns the sum of a regular cell's neighbours, except for the previous cell.
    static T others(const Level& level, const T* cell) noexcept {
        const auto all = level.offsets.size();
        if constexpr (D == 1) return cell[1];
        const auto row = std::ptrdiff_t(level.box.cells[0]);
        if (D == 2 && all == 4) return cell[1] + cell[-row] + cell[row];
        if constexpr (D == 3) {
            const auto layer = std::ptrdiff_t(level.box.stride(2));
            if (all == 6) return cell[1] + cell[-row] + cell[row] + cell[-layer] + cell[layer];
        }
        T sum = 0;
        for (const std::ptrdiff_t offset : level.offsets) sum += offset == -1 ? T(0) : cell[offset];
        return sum;
    }

    /// Sets every unknown to the mean of its neighbours; returns the sum of the absolute changes.
    double sweep(Level& level) const {
        double change = 0;
        T* const u = level.values.data();
        const auto set = [&change, u](std::size_t c, T mean) {
            change += std::fabs(double(mean - u[c]));
            u[c] = mean;
        };
        const T share = T(1) / static_cast<T>(level.offsets.size());
        for (const auto& [begin, end] : level.regular) {
            // The value just set is added last, so that only this addition waits for it.
            for (std::size_t c = begin; c < end; ++c) set(c, (others(level, u + c) + u[c - 1]) * share);
        }
        for (const std::size_t c : level.rim) {
            T sum = 0;
            T counted = 0;
            level.each_counted_neighbour(c, options_.stencil, [&](std::size_t n) {
                sum += u[n];
                counted += T(1);
            });
            if (counted > T(0)) set(c, sum / counted);
        }
        return change;
    }

    AveragingOptions options_;
    std::vector<Level> levels_;
};

} // namespace cageform_sources::averaging
