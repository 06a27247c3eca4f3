// The unknown nodes of a lattice, kept as runs along the rows: a node elsewhere costs nothing.
#pragma once

#include <cageform/core/vec.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Nodes numbered row by row (rows run along axis 0), and back from a place to its number.
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

    const Index& size() const noexcept { return size_; } ///< of the lattice, in nodes
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
    /// The first node of a row.
    Index row_index(std::size_t row) const noexcept {
        Index index{};
        for (std::size_t k = 1; k < D; ++k) {
            index[k] = std::int32_t(row % std::size_t(size_[k]));
            row /= std::size_t(size_[k]);
        }
        return index;
    }

    /// Runs are added in order, a row at a time; those that touch become one.
    void add_run(std::int32_t begin, std::int32_t end) {
        if (begin >= end) return;
        if (runs_.size() > row_begin_.back() && runs_.back().end == begin) {
            runs_.back().end = end;
        } else {
            runs_.push_back({begin, end, count_});
        }
        count_ += std::uint32_t(end - begin);
    }
    void end_row() { row_begin_.push_back(std::uint32_t(runs_.size())); }

    const Run* row_runs(std::size_t row) const noexcept { return runs_.data() + row_begin_[row]; }
    const Run* row_runs_end(std::size_t row) const noexcept { return runs_.data() + row_begin_[row + 1]; }

    /// The number of the node at `index`, which may lie outside the lattice; `none` where there is none.
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

    /// The place of a node, from its number.
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

    /// f(index, number) for every node in order.
    template <class F>
    void for_each(F&& f) const {
        for (std::size_t r = 0; r < rows(); ++r) {
            Index index = row_index(r);
            for (const Run* run = row_runs(r); run != row_runs_end(r); ++run) {
                for (index[0] = run->begin; index[0] < run->end; ++index[0])
                    f(index, run->first + std::uint32_t(index[0] - run->begin));
            }
        }
    }

    /// f(index, number, direction) for every link of a node that leads to no node (2·axis, + 1 towards larger indices).
    template <class F>
    void for_each_end(F&& f) const {
        for (std::size_t r = 0; r < rows(); ++r) {
            const Index row = row_index(r);
            for (std::size_t axis = 1; axis < D; ++axis) {
                for (const std::int32_t step : {-1, 1}) {
                    const std::size_t direction = 2 * axis + (step > 0 ? 1u : 0u);
                    Index other = row;
                    other[axis] += step;
                    const bool there = other[axis] >= 0 && other[axis] < size_[axis];
                    const Run* beside = there ? row_runs(this->row(other)) : nullptr;
                    const Run* const end = there ? row_runs_end(this->row(other)) : nullptr;
                    Index index = row;
                    for (const Run* run = row_runs(r); run != row_runs_end(r); ++run) {
                        for (index[0] = run->begin; index[0] < run->end; ++index[0]) {
                            while (beside != end && beside->end <= index[0]) ++beside;
                            if (beside != end && beside->begin <= index[0]) {
                                index[0] = std::min(beside->end, run->end) - 1; // as far as both go
                                continue;
                            }
                            f(index, run->first + std::uint32_t(index[0] - run->begin), direction);
                        }
                    }
                }
            }
            for (const Run* run = row_runs(r); run != row_runs_end(r); ++run) {
                Index index = row;
                index[0] = run->begin;
                if (run == row_runs(r) || run[-1].end != run->begin) f(index, run->first, 0);
                index[0] = run->end - 1;
                if (run + 1 == row_runs_end(r) || run[1].begin != run->end)
                    f(index, run->first + std::uint32_t(run->end - 1 - run->begin), 1);
            }
        }
    }

private:
    Index size_{};
    std::vector<std::uint32_t> row_begin_;
    std::vector<Run> runs_;
    std::uint32_t count_ = 0;
};

/// The numbers of nodes around a place that goes along the rows in order, as `for_each` does: each in constant time, where
/// `find` has to search.
template <std::size_t D>
class Neighbours {
public:
    using Index = typename NodeRuns<D>::Index;

    explicit Neighbours(const NodeRuns<D>& nodes)
        : nodes_(nodes) {}

    void move_to(const Index& index) noexcept {
        const bool onwards = x_ != before_all && index[0] >= x_ &&
                             std::equal(index.begin() + 1, index.end(), row_.begin() + 1);
        x_ = index[0];
        if (onwards) return;
        row_ = index;
        for (std::size_t r = 0; r < rows; ++r) {
            Index there = index;
            bool inside = true;
            std::size_t rest = r;
            for (std::size_t k = 1; k < D; ++k, rest /= 3) {
                there[k] += std::int32_t(rest % 3) - 1;
                inside = inside && there[k] >= 0 && there[k] < nodes_.size()[k];
            }
            run_[r] = inside ? nodes_.row_runs(nodes_.row(there)) : nullptr;
            end_[r] = inside ? nodes_.row_runs_end(nodes_.row(there)) : nullptr;
        }
    }
    /// `place` is one of the 3^D around, axis 0 fastest; `NodeRuns::none` where there is no node.
    std::uint32_t at(std::size_t place) noexcept {
        const std::size_t r = place / 3;
        const std::int32_t x = x_ + std::int32_t(place % 3) - 1;
        while (run_[r] != end_[r] && run_[r]->end < x_) ++run_[r];
        const auto* run = run_[r];
        while (run != end_[r] && run->end <= x) ++run;
        return run != end_[r] && run->begin <= x ? run->first + std::uint32_t(x - run->begin)
                                                 : NodeRuns<D>::none;
    }

private:
    static constexpr std::size_t rows = D == 1 ? 1 : D == 2 ? 3 : 9;
    static constexpr std::int32_t before_all = std::numeric_limits<std::int32_t>::min();

    const NodeRuns<D>& nodes_;
    Index row_{};
    std::int32_t x_ = before_all;
    std::array<const typename NodeRuns<D>::Run*, rows> run_{}, end_{};
};

} // namespace cageform::inline CAGEFORM_ABI
