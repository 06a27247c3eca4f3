// The unknown nodes of a lattice, stored as runs along the rows, and their links to the boundary.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/core/vec.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::grid {

/// The unknown nodes, numbered row by row (rows are parallel to axis 0). Converts between the index in this
/// order and the position on the lattice.
template <std::size_t D>
class NodeRuns {
public:
    using Index = std::array<std::int32_t, D>;
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    /// Nodes begin … end − 1 of a row, numbered from `first`.
    struct Run {
        std::int32_t begin, end;
        std::uint32_t first;
    };

    NodeRuns() = default;
    explicit NodeRuns(const Index& size)
        : size_(size)
        , row_begin_{0} {}

    const Index& size() const noexcept { return size_; } ///< the size of the lattice, in nodes
    std::uint32_t count() const noexcept { return count_; }
    std::size_t rows() const noexcept {
        std::size_t n = 1;
        for (std::size_t k = 1; k < D; ++k) n *= std::size_t(size_[k]);
        return n;
    }
    std::size_t row(const Index& index) const noexcept {
        std::size_t n = 0;
        for (std::size_t k = D; k-- > 1;) n = n * std::size_t(size_[k]) + std::size_t(index[k]);
        return n;
    }
    /// Returns the index of the first node of a row.
    Index row_index(std::size_t row) const noexcept {
        Index index{};
        for (std::size_t k = 1; k < D; ++k) {
            index[k] = std::int32_t(row % std::size_t(size_[k]));
            row /= std::size_t(size_[k]);
        }
        return index;
    }

    /// Adds a run to the current row. Runs must be added in order; adjacent runs are merged.
    void add_run(std::int32_t begin, std::int32_t end) {
        if (begin >= end) return;
        if (runs_.size() > row_begin_.back() && runs_.back().end == begin) {
            runs_.back().end = end;
        } else {
            runs_.push_back({begin, end, count_});
        }
        count_ += std::uint32_t(end - begin);
    }
    std::span<const Run> runs() const noexcept { return runs_; }
    void end_row() { row_begin_.push_back(std::uint32_t(runs_.size())); }

    const Run* row_runs(std::size_t row) const noexcept { return runs_.data() + row_begin_[row]; }
    const Run* row_runs_end(std::size_t row) const noexcept { return runs_.data() + row_begin_[row + 1]; }

    /// Returns the index of the first node of this row or of the next row that is not empty; `count` if
    /// there is none.
    std::uint32_t first_of_row(std::size_t row) const noexcept {
        return row < rows() && row_begin_[row] < runs_.size() ? runs_[row_begin_[row]].first : count_;
    }

    /// Returns the node at `index`, which may lie outside the lattice, or `none`.
    std::uint32_t find(const Index& index) const noexcept {
        for (std::size_t k = 0; k < D; ++k) {
            if (index[k] < 0 || index[k] >= size_[k]) return none;
        }
        const std::size_t r = row(index);
        const Run* const end = row_runs_end(r);
        const Run* const run =
            std::partition_point(row_runs(r), end, [&](const Run& a) { return a.end <= index[0]; });
        return run != end && index[0] >= run->begin ? run->first + std::uint32_t(index[0] - run->begin)
                                                    : none;
    }

    Index index(std::uint32_t number) const noexcept {
        const auto run = std::partition_point(runs_.begin(), runs_.end(),
                                              [&](const Run& a) { return a.first <= number; }) -
                         1;
        const auto row = std::partition_point(row_begin_.begin(), row_begin_.end(),
                                              [&](std::uint32_t begin) {
                                                  return begin <= std::uint32_t(run - runs_.begin());
                                              }) -
                         1;
        Index index = row_index(std::size_t(row - row_begin_.begin()));
        index[0] = run->begin + std::int32_t(number - run->first);
        return index;
    }

    template <class F>
    void for_each(F&& f) const {
        for_each_of_rows(0, rows(), f);
    }
    /// Calls f(index, number) for the nodes of rows begin … end − 1.
    template <class F>
    void for_each_of_rows(std::size_t begin, std::size_t end, F&& f) const {
        for (std::size_t r = begin; r < end; ++r) {
            Index index = row_index(r);
            for (const Run* run = row_runs(r); run != row_runs_end(r); ++run) {
                for (index[0] = run->begin; index[0] < run->end; ++index[0])
                    f(index, run->first + std::uint32_t(index[0] - run->begin));
            }
        }
    }

    /// Calls f(index, number, direction) for every link of a node to a position without a node. The
    /// direction is 2·axis, + 1 towards larger indices.
    template <class F>
    void for_each_end(F&& f) const {
        for (std::size_t r = 0; r < rows(); ++r) {
            for (std::size_t direction = 2; direction < 2 * D; ++direction) ends_across(r, direction, f);
            ends_along(r, f);
        }
    }

private:
    /// Finds the links of a row to positions without a node in one of the adjacent rows.
    template <class F>
    void ends_across(std::size_t r, std::size_t direction, F& f) const {
        Index index = row_index(r), other = index;
        const std::size_t axis = direction / 2;
        other[axis] += (direction & 1) != 0 ? 1 : -1;
        const bool there = other[axis] >= 0 && other[axis] < size_[axis];
        const Run* beside = there ? row_runs(row(other)) : nullptr;
        const Run* const end = there ? row_runs_end(row(other)) : nullptr;
        for (const Run* run = row_runs(r); run != row_runs_end(r); ++run) {
            for (index[0] = run->begin; index[0] < run->end; ++index[0]) {
                while (beside != end && beside->end <= index[0]) ++beside;
                if (beside != end && beside->begin <= index[0]) {
                    // skip to the end of the shorter run
                    index[0] = (std::min)(beside->end, run->end) - 1;
                } else {
                    f(index, run->first + std::uint32_t(index[0] - run->begin), direction);
                }
            }
        }
    }
    /// Finds the links along a row to positions without a node: those at the ends of its runs.
    template <class F>
    void ends_along(std::size_t r, F& f) const {
        Index index = row_index(r);
        for (const Run* run = row_runs(r); run != row_runs_end(r); ++run) {
            index[0] = run->begin;
            f(index, run->first, 0);
            index[0] = run->end - 1;
            f(index, run->first + std::uint32_t(index[0] - run->begin), 1);
        }
    }

    Index size_{};
    std::vector<std::uint32_t> row_begin_;
    Buffer<Run> runs_;
    std::uint32_t count_ = 0;
};

/// A link that the boundary cuts before the neighbouring node.
struct CutLink {
    std::uint32_t node;     ///< index of the unknown
    std::uint8_t direction; ///< 2·axis, + 1 towards larger indices
    double weight;          ///< 1/θ, where θ in (0, 1] is the fraction of the link before the boundary
};

} // namespace cageform::inline CAGEFORM_ABI::grid
