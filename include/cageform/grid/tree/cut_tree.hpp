// A tree of cells with a boundary: which facets intersect which cells, and which other cells are inside.
#pragma once

#include <cageform/grid/tree/boundary.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

namespace cageform::inline CAGEFORM_ABI::grid {

enum class CellState : std::uint8_t {
    out,     ///< outside, without facets
    in,      ///< inside, without facets
    cut,     ///< facets or bones intersect it
    unknown, ///< without facets, before find_states
};

/// A cell tree that stores, for every cell, the facets and bones that intersect it. The boundary must
/// outlive it.
template <std::size_t D>
class CutTree {
public:
    using Cell = typename CellTree<D>::Cell;
    using Index = typename CellTree<D>::Index;

    ///   screening  κ² of the equation Δu = κ²u that is solved on the tree, in units of the tree
    explicit CutTree(const TreeBoundary<D>& boundary, double screening = 0)
        : boundary_(&boundary)
        , tree_(boundary.depth())
        , screening_(screening) {
        for (std::uint32_t n = 0; n < boundary.elements(); ++n) facets_.push_back(n);
        ranges_.push_back({0, std::uint32_t(facets_.size())});
        states_.push_back(CellState::cut);
    }

    const TreeBoundary<D>& boundary() const noexcept { return *boundary_; }
    const CellTree<D>& cells() const noexcept { return tree_; }
    double screening() const noexcept { return screening_; }
    CellState state(std::uint32_t cell) const noexcept { return states_[cell]; }
    /// Returns the leaf at a point. For a point outside the cube, returns the leaf at the nearest point of
    /// the cube.
    Cell leaf_at(const Vec<double, D>& p) const noexcept {
        Index doubled{};
        const double end = 2.0 * tree_.size();
        for (std::size_t k = 0; k < D; ++k)
            doubled[k] = std::int32_t(std::floor(std::clamp(2 * p[k], 0.0, end)));
        return tree_.leaf_at(doubled);
    }
    /// Returns the facets and bones that intersect a cell, whether a leaf or not, in ascending order.
    std::span<const std::uint32_t> facets(std::uint32_t cell) const noexcept {
        return {facets_.data() + ranges_[cell].begin, ranges_[cell].count};
    }
    std::size_t bytes() const noexcept {
        return tree_.bytes() + facets_.capacity() * sizeof(std::uint32_t) +
               ranges_.capacity() * sizeof(Range) + states_.capacity();
    }

    /// Splits a leaf and distributes its facets and bones to the children.
    void split(const Cell& leaf) {
        tree_.split(leaf);
        const Range all = ranges_[leaf.number];
        for (std::size_t n = 0; n < CellTree<D>::children; ++n) {
            const Cell child = tree_.child(leaf, n);
            const auto begin = std::uint32_t(facets_.size());
            for (std::uint32_t k = 0; k < all.count; ++k) {
                const std::uint32_t facet = facets_[all.begin + k];
                if (boundary_->passes(facet, child)) facets_.push_back(facet);
            }
            const auto count = std::uint32_t(facets_.size()) - begin;
            ranges_.push_back({begin, count});
            const CellState above = states_[leaf.number];
            states_.push_back(count > 0                 ? CellState::cut
                              : above == CellState::cut ? CellState::unknown
                                                        : above);
            if (states_known_ && states_.back() == CellState::unknown)
                states_.back() = state_at_middle(child);
        }
    }
    /// Finds which leaves without facets are inside. Later splits update the states.
    void find_states() {
        // Visits leaves at lower coordinates first, so that their states are known.
        tree_.for_each_leaf([&](const Cell& leaf) {
            if (states_[leaf.number] == CellState::unknown) states_[leaf.number] = state_at_middle(leaf);
        });
        for (std::size_t family = tree_.families(); family-- > 0;) { // children come after their parents
            const std::uint32_t parent = tree_.parent(family).number;
            if (states_[parent] == CellState::unknown) states_[parent] = states_[tree_.first_child(parent)];
        }
        states_known_ = true;
    }

    /// Whether a point is inside. Follows an axis line downwards from the point, counts the crossings with
    /// facets, and stops at a leaf of known state. In thin parts of the domain that leaf may be far away,
    /// so the search alternates between the axes with a growing limit.
    ///
    ///   line  the point in multiples of 2^-fraction units (TreeBoundary::fraction)
    bool is_inside(const std::array<std::int64_t, D>& line) const noexcept {
        for (std::size_t most = 8;; most *= 4) {
            for (std::size_t axis = 0; axis < D; ++axis) {
                if (const auto inside = walk(line, axis, most)) return *inside;
            }
        }
    }
    /// Whether a point in units is inside; the point is rounded first.
    bool is_inside(const Vec<double, D>& p) const noexcept { return is_inside(line_of(p)); }
    /// Returns for each point whether it is inside. The points are in one leaf, on a line along axis 0, in
    /// ascending order.
    template <std::size_t count>
    std::array<bool, count> are_inside(const std::array<Vec<double, D>, count>& points) const noexcept {
        const auto line = line_of(points[0]);
        std::array<double, count> at{};
        std::array<bool, count> inside{};
        for (std::size_t n = 0; n < count; ++n)
            at[n] = std::ldexp(double(line_of(points[n])[0]), -boundary_->fraction());
        inside.fill(is_inside(line));
        for (const std::uint32_t facet : facets(leaf_at(points[0]).number)) {
            const auto position = crossing(facet, 0, line);
            for (std::size_t n = 1; n < count; ++n)
                inside[n] = inside[n] != (position && *position >= at[0] && *position < at[n]);
        }
        return inside;
    }

private:
    struct Range {
        std::uint32_t begin, count; ///< in facets_
    };

    std::array<std::int64_t, D> line_of(const Vec<double, D>& p) const noexcept {
        std::array<std::int64_t, D> line{};
        for (std::size_t k = 0; k < D; ++k) line[k] = std::llround(std::ldexp(p[k], boundary_->fraction()));
        return line;
    }
    /// Returns the position where an axis line crosses a facet that separates inside from outside, or
    /// nullopt.
    std::optional<double> crossing(std::uint32_t facet, std::size_t axis,
                                   const std::array<std::int64_t, D>& line) const noexcept {
        if (!boundary_->separates(facet)) return std::nullopt;
        return detail::crossing((*boundary_)[facet], axis, line, boundary_->fraction());
    }
    /// Returns the state of a cell without facets, which is that of its middle.
    CellState state_at_middle(const Cell& leaf) const noexcept {
        std::array<std::int64_t, D> line{};
        for (std::size_t k = 0; k < D; ++k)
            line[k] = (2 * std::int64_t(leaf.low[k]) + leaf.size) << (boundary_->fraction() - 1);
        return is_inside(line) ? CellState::in : CellState::out;
    }
    /// Follows one axis line for at most `most` leaves. Returns nullopt if all of them are cut or unknown.
    /// Integer arithmetic decides the crossings, so every line crosses the boundary an even number of times.
    std::optional<bool> walk(const std::array<std::int64_t, D>& line, std::size_t axis,
                             std::size_t most) const noexcept {
        Index doubled{};
        for (std::size_t k = 0; k < D; ++k) doubled[k] = std::int32_t(line[k] >> (boundary_->fraction() - 1));
        double at = std::ldexp(double(line[axis]), -boundary_->fraction());
        bool has_crossed = false;
        for (; most > 0; --most) {
            const Cell leaf = tree_.leaf_at(doubled);
            const CellState state = states_[leaf.number];
            if (state == CellState::in || state == CellState::out)
                return has_crossed != (state == CellState::in);
            for (const std::uint32_t n : facets(leaf.number)) {
                const auto position = crossing(n, axis, line);
                if (position && *position >= leaf.low[axis] && *position < at) has_crossed = !has_crossed;
            }
            if (leaf.low[axis] == 0) return has_crossed;
            at = leaf.low[axis];
            doubled[axis] = 2 * leaf.low[axis] - 1;
        }
        return std::nullopt;
    }

    const TreeBoundary<D>* boundary_;
    CellTree<D> tree_;
    double screening_;
    Buffer<std::uint32_t> facets_;
    Buffer<Range> ranges_;     ///< per cell
    Buffer<CellState> states_; ///< per cell
    bool states_known_ = false;
};

/// Splits leaves until every neighbour of a leaf that is not outside has at least half its size.
template <std::size_t D>
void balance(CutTree<D>& tree, const Running& running = {}) {
    std::size_t tested = 0;
    const auto counts = [&](std::uint32_t cell) {
        if (++tested % 65536 == 0) detail::report_progress(running, 0); // the total is unknown
        return tree.state(cell) != CellState::out;
    };
    balance(tree.cells(), counts, [&](const typename CellTree<D>::Cell& leaf) { tree.split(leaf); });
}

} // namespace cageform::inline CAGEFORM_ABI::grid
