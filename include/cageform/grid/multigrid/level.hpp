// One level of the multigrid in the layout of the cycles: row by row, regular nodes in runs and irregular
// nodes in a list.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/multigrid/coarsen.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Consecutive nodes of a row with the regular stencil and multilinear interpolation. The nodes of the
/// neighbouring rows, fine and coarse, are at constant distances in memory.
template <std::size_t D>
struct RegularRun {
    std::uint32_t first = 0;                             ///< index of the first node
    std::uint32_t count = 0;                             ///< number of nodes
    std::int32_t x = 0;                                  ///< position of the first node along axis 0
    std::uint32_t first_colour = 0;                      ///< parity of the sum of the first node's indices
    std::array<std::int32_t, power(3, D - 1)> row{};     ///< distance of each neighbouring row
    std::array<std::uint32_t, power(2, D - 1)> coarse{}; ///< coarse node X has index coarse + X
    std::uint32_t coarse_rows = 0;

    /// Returns the first node of a colour, relative to `first`.
    std::uint32_t first_of(std::uint32_t colour) const noexcept { return first_colour ^ colour; }
    /// Returns the distances in memory from a node to its 2·D nearest neighbours.
    std::array<std::ptrdiff_t, 2 * D> nearest() const noexcept {
        std::array<std::ptrdiff_t, 2 * D> to{-1, 1};
        for (std::size_t k = 1, r = 1; k < D; ++k, r *= 3) {
            to[2 * k] = row[row.size() / 2 - r];
            to[2 * k + 1] = row[row.size() / 2 + r];
        }
        return to;
    }
};

template <std::size_t D>
struct Level {
    struct Entry {
        std::uint32_t node;
        float weight;
    };
    struct Irregular {
        std::uint32_t node;
        std::uint32_t entries_end; ///< end in `entries`; the previous node's end is the beginning
        std::uint32_t coarse_end;  ///< likewise in `from_coarse`
        double diagonal;
        float inverse; ///< 1/diagonal
        float row_sum; ///< of A; zero except next to data
    };
    struct Range {
        std::size_t begin, end;
    };
    /// The first run and the first irregular node of a row of the lattice.
    struct Row {
        std::uint32_t runs, irregular;
    };

    std::uint32_t count = 0;                ///< number of nodes
    float diagonal = 1;                     ///< of the regular stencil
    std::array<float, D + 1> by_distance{}; ///< its negated other entries, by `StencilPositions::distance`
    std::size_t slab_rows = 1;              ///< rows of a slab: the nodes of one index along the last axis
    Buffer<Row> rows;                       ///< all rows, and one entry for their end
    Buffer<RegularRun<D>> runs;
    Buffer<Irregular> irregular;
    Buffer<Entry> entries;     ///< the negated off-diagonal entries of A at irregular nodes
    Buffer<Entry> from_coarse; ///< the interpolation of irregular nodes

    std::size_t slabs() const noexcept { return (rows.size() - 1) / slab_rows; }
    std::span<const RegularRun<D>> runs_of(Range r) const noexcept {
        return {runs.data() + rows[r.begin].runs, runs.data() + rows[r.end].runs};
    }
    Range irregular_of(Range r) const noexcept { return {rows[r.begin].irregular, rows[r.end].irregular}; }
    std::span<const Entry> entries_of(std::size_t j) const noexcept {
        const std::size_t begin = j == 0 ? 0 : irregular[j - 1].entries_end;
        return {entries.data() + begin, entries.data() + irregular[j].entries_end};
    }
    std::span<const Entry> interpolation_of(std::size_t j) const noexcept {
        const std::size_t begin = j == 0 ? 0 : irregular[j - 1].coarse_end;
        return {from_coarse.data() + begin, from_coarse.data() + irregular[j].coarse_end};
    }

    std::size_t bytes() const noexcept {
        return rows.capacity() * sizeof(Row) + runs.capacity() * sizeof(RegularRun<D>) +
               irregular.capacity() * sizeof(Irregular) +
               (entries.capacity() + from_coarse.capacity()) * sizeof(Entry);
    }
};

/// Converts equations into a `Level`. The coarsest level has no `coarsening`.
template <std::size_t D>
class LevelMaker {
public:
    LevelMaker(const Equations<D>& equations, const Coarsening<D>* coarsening, bool finest)
        : e_(equations)
        , coarsening_(coarsening)
        , finest_(finest)
        , around_(equations.nodes) {
        if (coarsening != nullptr) coarse_around_.emplace(coarsening->coarse.nodes);
        level_.count = e_.nodes.count();
        level_.diagonal = float(e_.regular[P::centre]);
        for (std::size_t p = 0; p < P::count; ++p) level_.by_distance[P::distance(p)] = -float(e_.regular[p]);
        const std::size_t rows = e_.nodes.rows();
        level_.slab_rows = rows / std::size_t(e_.nodes.size()[D - 1]);
        level_.rows.reserve(rows + 1);
        level_.rows.push_back();
        for (std::size_t row = 0; row < rows; ++row) {
            add_row(row);
            level_.rows.push_back(
                {std::uint32_t(level_.runs.size()), std::uint32_t(level_.irregular.size())});
        }
        level_.runs.shrink_to_fit();
        level_.irregular.shrink_to_fit();
        level_.entries.shrink_to_fit();
        level_.from_coarse.shrink_to_fit();
    }
    Level<D> take() { return std::move(level_); }

private:
    using P = StencilPositions<D>;
    using Index = typename grid::NodeRuns<D>::Index;
    static constexpr auto none = grid::NodeRuns<D>::none;

    void add_row(std::size_t row) {
        Index index = e_.nodes.row_index(row);
        for (const auto* run = e_.nodes.row_runs(row); run != e_.nodes.row_runs_end(row); ++run) {
            bool open = false; // whether the last node was regular
            for (index[0] = run->begin; index[0] < run->end; ++index[0]) {
                const std::uint32_t node = run->first + std::uint32_t(index[0] - run->begin);
                const bool regular =
                    !e_.is_irregular(node) && (coarsening_ == nullptr || !coarsening_->is_irregular(node));
                if (!regular) {
                    add_irregular(index, node);
                } else {
                    if (!open) begin_run(index, node);
                    ++level_.runs.back().count;
                }
                open = regular;
            }
        }
    }

    void begin_run(const Index& index, std::uint32_t node) {
        around_.move_to(index);
        RegularRun<D> run;
        run.first = node;
        run.x = index[0];
        for (const auto x : index) run.first_colour ^= std::uint32_t(x & 1);
        for (std::size_t r = 0; r < run.row.size(); ++r) {
            const auto n = around_.at(3 * r + 1);
            run.row[r] = n == none ? 0 : std::int32_t(n - node);
        }
        if (coarsening_ != nullptr) find_coarse_rows(index, run);
        level_.runs.push_back(run);
    }
    /// Finds the coarse rows of the run's interpolation: two along each axis with an odd index, one along
    /// the others.
    void find_coarse_rows(Index index, RegularRun<D>& run) const {
        std::size_t odd = 0;
        for (std::size_t k = 1; k < D; ++k) odd |= std::size_t(index[k] & 1) << k;
        ++index[0]; // rounds up to a coarse node that is in all of these rows
        for (std::size_t corner = 0; corner < power(2, D); corner += 2) {
            if ((corner & ~odd) != 0) continue;
            const Index at = coarsening_->corner_index(index, corner);
            const auto n = coarsening_->coarse.nodes.find(at);
            CAGEFORM_ASSERT(n != none, "regular interpolation uses all surrounding coarse nodes");
            run.coarse[run.coarse_rows++] = n - std::uint32_t(at[0]);
        }
    }

    void add_irregular(const Index& index, std::uint32_t node) {
        const double row_sum = add_entries(index, node);
        if (coarsening_ != nullptr) add_interpolation(index, node);
        const double diagonal = e_.stencil(node)[P::centre];
        level_.irregular.push_back({node, std::uint32_t(level_.entries.size()),
                                    std::uint32_t(level_.from_coarse.size()), diagonal, float(1 / diagonal),
                                    float(row_sum)});
    }
    /// Adds the entries of an irregular node and returns their row sum. Pads with entries of weight 0, on
    /// the finest level to 2·D entries, on the others to an even number.
    double add_entries(const Index& index, std::uint32_t node) {
        auto& entries = level_.entries;
        const std::size_t begin = entries.size();
        around_.move_to(index);
        const auto& a = e_.stencil(node);
        double row_sum = 0;
        for (std::size_t p = 0; p < P::count; ++p) {
            row_sum += a[p];
            const auto n = p != P::centre && a[p] != 0 ? around_.at(p) : none;
            if (n != none) entries.push_back({n, -float(a[p])});
        }
        while (finest_ ? entries.size() < begin + 2 * D : (entries.size() - begin) % 2 != 0)
            entries.push_back({node, 0.0f});
        return row_sum;
    }
    void add_interpolation(const Index& index, std::uint32_t node) {
        auto& from_coarse = level_.from_coarse;
        const auto& weights = coarsening_->of(node, index);
        // NOLINTNEXTLINE(bugprone-unchecked-optional-access): there is one with every coarsening
        coarse_around_->move_to(coarsening_->corner_index(index, 0));
        for (std::size_t corner = 0; corner < weights.size(); ++corner) {
            if (weights[corner] == 0) continue;
            const auto n = coarse_around_->at(P::position(corner_offset<D>(corner)));
            from_coarse.push_back({n, float(weights[corner])});
        }
    }

    const Equations<D>& e_;
    const Coarsening<D>* coarsening_;
    bool finest_;
    Neighbours<D> around_;
    std::optional<Neighbours<D>> coarse_around_;
    Level<D> level_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
