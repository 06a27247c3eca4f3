// A tree of cells about a boundary: which facets pass which cells, and on which side the others lie.
#pragma once

#include <cageform/grid/tree/boundary.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

enum class CellState : std::uint8_t {
    out,     ///< no facet passes it, its middle outside
    in,      ///< no facet passes it, its middle inside
    cut,     ///< facets pass it
    unknown, ///< out or in, until find_states is called
};

/// The boundary outlives it.
template <std::size_t D>
class CutTree {
public:
    using Cell = typename CellTree<D>::Cell;
    using Index = typename CellTree<D>::Index;

    explicit CutTree(const TreeBoundary<D>& boundary)
        : boundary_(&boundary)
        , tree_(boundary.depth()) {
        for (std::uint32_t n = 0; n < boundary.parts(); ++n) facets_.push_back(n);
        ranges_.push_back({0, std::uint32_t(facets_.size())});
        states_.push_back(CellState::cut);
    }

    const TreeBoundary<D>& boundary() const noexcept { return *boundary_; }
    const CellTree<D>& cells() const noexcept { return tree_; }
    CellState state(std::uint32_t cell) const noexcept { return states_[cell]; }
    /// The leaf at a place; outside the cube that at the nearest place in it.
    Cell leaf_at(const Vec<double, D>& p) const noexcept {
        Index doubled{};
        const double end = 2.0 * tree_.size();
        for (std::size_t k = 0; k < D; ++k)
            doubled[k] = std::int32_t(std::floor(std::clamp(2 * p[k], 0.0, end)));
        return tree_.leaf_at(doubled);
    }
    /// Those that pass a cell, a leaf or not; ascending.
    std::span<const std::uint32_t> facets(std::uint32_t cell) const noexcept {
        return {facets_.data() + ranges_[cell].begin, ranges_[cell].count};
    }
    std::size_t bytes() const noexcept {
        return tree_.bytes() + facets_.capacity() * sizeof(std::uint32_t) +
               ranges_.capacity() * sizeof(Range) + states_.capacity();
    }

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
    /// Finds on which side the leaves lie that no facet passes. Later splits keep that up.
    void find_states() {
        tree_.for_each_leaf([&](const Cell& leaf) { // towards the lower ends of all axes all are known
            if (states_[leaf.number] == CellState::unknown) states_[leaf.number] = state_at_middle(leaf);
        });
        for (std::size_t family = tree_.families(); family-- > 0;) { // children come after their parents
            const std::uint32_t parent = tree_.parent(family).number;
            if (states_[parent] == CellState::unknown) states_[parent] = states_[tree_.first_child(parent)];
        }
        states_known_ = true;
    }

    /// Whether a place is inside, by the crossings on an axis line from it down to a leaf that no facet
    /// passes. Along parts thinner than cells that may be far: the axes take turns, and the first
    /// that arrives tells.
    ///
    ///   line  the place in parts of 2^-fraction units (TreeBoundary::fraction)
    bool is_inside(const std::array<std::int64_t, D>& line) const noexcept {
        for (std::size_t most = 8;; most *= 4) {
            for (std::size_t axis = 0; axis < D; ++axis) {
                if (const auto inside = walk(line, axis, most)) return *inside;
            }
        }
    }

private:
    struct Range {
        std::uint32_t begin, count; ///< in facets_
    };

    CellState state_at_middle(const Cell& leaf) const noexcept {
        std::array<std::int64_t, D> line{};
        for (std::size_t k = 0; k < D; ++k)
            line[k] = (2 * std::int64_t(leaf.low[k]) + leaf.size) << (boundary_->fraction() - 1);
        return is_inside(line) ? CellState::in : CellState::out;
    }
    /// None after `most` leaves. Every axis line crosses the boundary as often as whole numbers say.
    std::optional<bool> walk(const std::array<std::int64_t, D>& line, std::size_t axis,
                             std::size_t most) const noexcept {
        Index doubled{};
        for (std::size_t k = 0; k < D; ++k) doubled[k] = std::int32_t(line[k] >> (boundary_->fraction() - 1));
        double at = std::ldexp(double(line[axis]), -boundary_->fraction());
        bool turned = false;
        for (; most > 0; --most) {
            const Cell leaf = tree_.leaf_at(doubled);
            const CellState state = states_[leaf.number];
            if (state == CellState::in || state == CellState::out) return turned != (state == CellState::in);
            for (const std::uint32_t n : facets(leaf.number)) {
                if (!boundary_->turns(n)) continue;
                const auto position = detail::crossing((*boundary_)[n], axis, line, boundary_->fraction());
                if (position && *position >= leaf.low[axis] && *position < at) turned = !turned;
            }
            if (leaf.low[axis] == 0) return turned;
            at = leaf.low[axis];
            doubled[axis] = 2 * leaf.low[axis] - 1;
        }
        return std::nullopt;
    }

    const TreeBoundary<D>* boundary_;
    CellTree<D> tree_;
    Buffer<std::uint32_t> facets_;
    Buffer<Range> ranges_;     ///< by cell
    Buffer<CellState> states_; ///< by cell
    bool states_known_ = false;
};

/// Splits leaves until none but those outside has a neighbour of less than half its size.
template <std::size_t D>
void balance(CutTree<D>& tree) {
    balance(
        tree.cells(), [&](std::uint32_t cell) { return tree.state(cell) != CellState::out; },
        [&](const typename CellTree<D>::Cell& leaf) { tree.split(leaf); });
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
