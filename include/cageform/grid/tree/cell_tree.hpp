// A tree of cells: a cube that is halved along all axes where it has to be finer.
//
// The headers of this folder in the order of the work: cell_tree (cells, their balance), tree_boundary
// (a cage's facets in units of the tree), cut_tree (which facets pass which cells, what is inside),
// sizing, cell_sizes with refinement, and bone_sizes (how fine a cage asks it to be: in the plane, in
// space, about bones), tree_nodes (the unknowns), leaf_gather (values within a leaf), leaves_about, harmonic_mean and
// star (values in the plane by what is seen about a place), tree_links (the equations) in level_rows
// (sparse matrices), tree_hierarchy (the coarser levels), tree_multigrid (the cycles).
// coordinates/harmonic/tree_solver.hpp puts them together.
#pragma once

#include <cageform/core/detail/buffer.hpp>
#include <cageform/core/vec.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// A binary tree, quadtree or octree over a cube of 2^depth units, in units. The children of a cell
/// are a family and lie side by side; child n lies at the upper end along the axes of its set bits.
template <std::size_t D>
class CellTree {
public:
    using Index = std::array<std::int32_t, D>;
    static constexpr std::size_t children = std::size_t{1} << D;
    static constexpr unsigned most_depth = 20;

    struct Cell {
        std::uint32_t number;
        Index low; ///< its lower corner
        std::int32_t size;
    };

    explicit CellTree(unsigned depth = 0)
        : depth_(depth)
        , first_child_(1, 0) {
        CAGEFORM_ASSERT(depth <= most_depth, "coordinates have 20 bits");
    }

    unsigned depth() const noexcept { return depth_; }
    std::int32_t size() const noexcept { return std::int32_t{1} << depth_; }
    std::uint32_t cells() const noexcept { return std::uint32_t(first_child_.size()); }
    std::uint32_t leaves() const noexcept { return cells() - std::uint32_t(families_.size()); }
    std::size_t families() const noexcept { return families_.size(); }
    std::size_t bytes() const noexcept {
        return first_child_.capacity() * sizeof(std::uint32_t) + families_.capacity() * sizeof(Cell);
    }

    bool is_leaf(std::uint32_t cell) const noexcept { return first_child_[cell] == 0; }
    std::uint32_t first_child(std::uint32_t cell) const noexcept { return first_child_[cell]; } ///< 0: none
    Cell root() const noexcept { return {0, {}, size()}; }
    /// The parent of a family; families are numbered in the order of their making.
    const Cell& parent(std::size_t family) const noexcept { return families_[family]; }
    Cell child(const Cell& parent, std::size_t n) const noexcept {
        Cell cell{first_child_[parent.number] + std::uint32_t(n), parent.low, parent.size / 2};
        for (std::size_t k = 0; k < D; ++k) cell.low[k] += ((n >> k) & 1u) != 0 ? cell.size : 0;
        return cell;
    }
    Cell cell(std::uint32_t number) const noexcept {
        return number == 0 ? root() : child(parent_of(number), (number - 1) % children);
    }
    /// Of a cell that is not the root.
    const Cell& parent_of(std::uint32_t number) const noexcept { return families_[(number - 1) / children]; }

    /// Gives a leaf of at least two units a family.
    void split(const Cell& leaf) {
        CAGEFORM_ASSERT(is_leaf(leaf.number) && leaf.size > 1, "a leaf that can be halved");
        first_child_[leaf.number] = cells();
        families_.push_back(leaf);
        for (std::size_t n = 0; n < children; ++n) first_child_.push_back(0);
    }

    /// The leaf at a place given in half units; on a rim between leaves the upper one. Places
    /// outside the cube are moved into it. O(depth).
    Cell leaf_at(Index doubled) const noexcept {
        for (auto& x : doubled) x = x < 0 ? 0 : x > 2 * size() - 1 ? 2 * size() - 1 : x;
        Cell cell = root();
        while (!is_leaf(cell.number)) cell = child_at(cell, doubled);
        return cell;
    }
    /// The child at such a place.
    Cell child_at(const Cell& parent, const Index& doubled) const noexcept {
        std::size_t n = 0;
        for (std::size_t k = 0; k < D; ++k)
            n |= std::size_t{doubled[k] >= 2 * parent.low[k] + parent.size ? 1u : 0u} << k;
        return child(parent, n);
    }
    /// f(leaf) along the Morton curve.
    template <class F>
    void for_each_leaf(F&& f) const {
        visit(root(), f);
    }

private:
    template <class F>
    void visit(const Cell& cell, F& f) const {
        if (is_leaf(cell.number)) {
            f(cell);
            return;
        }
        for (std::size_t n = 0; n < children; ++n) visit(child(cell, n), f);
    }

    unsigned depth_;
    Buffer<std::uint32_t> first_child_; ///< by cell; 0: a leaf
    Buffer<Cell> families_;
};

/// Splits leaves until none has a neighbour, across faces, edges or corners, of less than half its
/// size.
///
///   counts  counts(cell number): whether a leaf takes part; the others are split by none and split
///           none
///   split   split(leaf) gives it a family
template <std::size_t D, class Counts, class Split>
void balance(const CellTree<D>& tree, const Counts& counts, const Split& split) {
    using Index = typename CellTree<D>::Index;
    std::size_t neighbours = 1;
    for (std::size_t k = 0; k < D; ++k) neighbours *= 3;
    // What lies beside a child is at most as large as its parent. New families come last.
    for (std::size_t family = 0; family < tree.families(); ++family) {
        const auto parent = tree.parent(family);
        bool any = false;
        for (std::size_t n = 0; n < CellTree<D>::children; ++n)
            any = any || counts(tree.child(parent, n).number);
        if (!any) continue;
        for (std::size_t place = 0; place < neighbours; ++place) {
            Index beside{}; // its middle; what lies beside the tree is moved to another neighbour
            for (std::size_t k = 0, rest = place; k < D; ++k, rest /= 3)
                beside[k] = 2 * parent.low[k] + (2 * std::int32_t(rest % 3) - 1) * parent.size;
            for (;;) {
                const auto leaf = tree.leaf_at(beside);
                if (leaf.size <= parent.size || !counts(leaf.number)) break;
                split(leaf);
            }
        }
    }
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
