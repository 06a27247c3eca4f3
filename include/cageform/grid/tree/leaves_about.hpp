// The 2^D leaves around a node.
#pragma once

#include <cageform/grid/tree/cut_tree.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The leaves around a node, one per octant (in 2D per quadrant). Octant n is on the upper side along the
/// axes of its set bits. A large leaf may fill several octants.
template <std::size_t D>
struct LeavesAbout {
    using Cell = typename grid::CellTree<D>::Cell;
    std::array<Cell, grid::CellTree<D>::children> leaf;
    std::array<bool, grid::CellTree<D>::children> counts; ///< whether the leaf counts

    /// Descends the tree once for all octants, to the first cell that the node halves along an axis, and
    /// from there separately.
    ///
    ///   is_leaf(cell number)     whether a cell is a leaf of the tree or of a coarser level
    ///   does_count(cell number)  whether a leaf counts
    template <class IsLeaf, class Counts>
    LeavesAbout(const grid::CellTree<D>& tree, const std::array<std::int32_t, D>& node, const IsLeaf& is_leaf,
                const Counts& does_count) {
        Cell shared = tree.root();
        auto doubled = node;
        for (auto& x : doubled) x *= 2;
        const auto divides_octants = [&] {
            bool divides = false;
            for (std::size_t k = 0; k < D; ++k)
                divides = divides || doubled[k] == 2 * shared.low[k] + shared.size;
            return divides;
        };
        while (!is_leaf(shared.number) && !divides_octants()) shared = tree.child_at(shared, doubled);
        for (std::size_t n = 0; n < leaf.size(); ++n) {
            auto position = doubled;
            for (std::size_t k = 0; k < D; ++k) position[k] += ((n >> k) & 1u) != 0 ? 1 : -1;
            leaf[n] = shared;
            while (!is_leaf(leaf[n].number)) leaf[n] = tree.child_at(leaf[n], position);
            counts[n] = does_count(leaf[n].number);
        }
    }
    /// Returns the smallest leaf that counts among the octants with the given bits under `mask`, or null.
    const Cell* smallest(std::size_t mask = 0, std::size_t bits = 0) const noexcept {
        const Cell* best = nullptr;
        for (std::size_t n = 0; n < leaf.size(); ++n) {
            if ((n & mask) == bits && counts[n] && (best == nullptr || leaf[n].size < best->size))
                best = &leaf[n];
        }
        return best;
    }
};

/// Returns the leaves around a node; those that are not outside count.
template <std::size_t D>
LeavesAbout<D> leaves_about(const grid::CutTree<D>& tree, const std::array<std::int32_t, D>& node) {
    return {tree.cells(), node, [&](std::uint32_t cell) { return tree.cells().is_leaf(cell); },
            [&](std::uint32_t cell) { return tree.state(cell) != grid::CellState::out; }};
}

} // namespace cageform::inline CAGEFORM_ABI::detail
