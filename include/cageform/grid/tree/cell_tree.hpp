// A binary tree, quadtree or octree: a cube that is recursively halved along all axes.
//
// This folder solves the Laplace equation on such a tree. The discretisation is in this header, in
// node_equation.hpp (the equation of a node), and in star.hpp (2D) or leaf_gather.hpp (3D, and
// interpolation). The solver is in hierarchy.hpp (the levels) and grid/tree/multigrid.hpp (the cycles).
//
// Terms:
//
//   unit      the side of the smallest possible cell; the cube has a side of 2^depth units
//   family    the children of one cell
//   rim       the boundary of a cell
//   handle    a control point of the cage; the solver computes one harmonic function per handle
//   wall      a facet of an interior cell of the cage. It has boundary values, but the domain is on both its
//             sides. The rim of a wall is its boundary
//   bone      a point or an edge with a radius inside the cage, whose interior is not in the domain
//   node      an unknown: a corner of a leaf inside the domain, unless the leaf is cut and the corner is
//             within 1e-6 units of the boundary (nodes.hpp)
//   counts    a leaf counts if it is not outside the domain
//
// Facets are rounded to 2⁻³⁰ of the cube, so that integer arithmetic decides what is inside (boundary.hpp).
// Local harmonic models give the values between nodes (coordinates/harmonic/leaf_models.hpp). In cages with
// bones, and in 3D cages with walls or with faces of more than three corners,
// coordinates/harmonic/tree_cage.hpp interpolates instead. Within 0.01 (2D) or 0.3 (3D) leaf sizes from the
// boundary, the interpolation is linear: from the nearest point of the unrounded boundary to a point inside.
//
// All headers, in the order of their use:
//
//   cell_tree        the cells, and their balance: neighbours differ by at most a factor of two in size
//   boundary         the facets and bones of a cage in units of the tree
//   cut_tree         which facets intersect which cells, and which cells are inside
//   cell_sizes       the allowed cell size at facets
//   features         the allowed cell size near vertices and edges where functions are singular
//   bone_sizes       the allowed cell size near bones
//   refinement       splits cells to the allowed size, and predicts their number
//   nodes            the unknowns: corners of leaves
//   leaf_gather      interpolation inside a leaf
//   leaves_about     the leaves around a node
//   harmonic_mean    weights that are exact for harmonic polynomials, in 2D
//   star             the neighbours of a point, in 2D
//   node_equation    the equation of one node
//   links            the equations of all nodes
//   level_rows       sparse matrices
//   hierarchy        the coarser levels
//
// coordinates/harmonic/tree_solver.hpp combines them.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/core/vec.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI::grid {

/// A tree over a cube of 2^depth units. All coordinates are in units. The children of a cell have
/// consecutive indices. Child n is the upper one along the axes of the set bits of n.
template <std::size_t D>
class CellTree {
public:
    using Index = std::array<std::int32_t, D>;
    static constexpr std::size_t children = std::size_t{1} << D;
    static constexpr unsigned most_depth = 20;

    struct Cell {
        std::uint32_t number;
        Index low; ///< the lower corner
        std::int32_t size;

        Vec<double, D> middle() const noexcept {
            Vec<double, D> p{};
            for (std::size_t k = 0; k < D; ++k) p[k] = low[k] + 0.5 * size;
            return p;
        }
        /// Returns a corner: the upper one along the axes of the set bits of n.
        Index corner(std::size_t n) const noexcept {
            Index index = low;
            for (std::size_t k = 0; k < D; ++k) index[k] += ((n >> k) & 1u) != 0 ? size : 0;
            return index;
        }
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
    /// Returns the parent of a family. Families are numbered in order of creation.
    const Cell& parent(std::size_t family) const noexcept { return families_[family]; }
    Cell child(const Cell& parent, std::size_t n) const noexcept {
        Cell cell{first_child_[parent.number] + std::uint32_t(n), parent.low, parent.size / 2};
        for (std::size_t k = 0; k < D; ++k) cell.low[k] += ((n >> k) & 1u) != 0 ? cell.size : 0;
        return cell;
    }
    Cell cell(std::uint32_t number) const noexcept {
        return number == 0 ? root() : child(parent_of(number), (number - 1) % children);
    }
    const Cell& parent_of(std::uint32_t number) const noexcept { return families_[(number - 1) / children]; }

    /// Splits a leaf of at least two units into a family of children.
    void split(const Cell& leaf) {
        CAGEFORM_ASSERT(is_leaf(leaf.number) && leaf.size > 1, "a leaf that can be halved");
        first_child_[leaf.number] = cells();
        families_.push_back(leaf);
        for (std::size_t n = 0; n < children; ++n) first_child_.push_back(0);
    }

    /// Returns the leaf at a position in half units; between leaves, the upper one. Positions outside the
    /// cube are clamped. O(depth).
    Cell leaf_at(Index doubled) const noexcept {
        for (auto& x : doubled) x = x < 0 ? 0 : x > 2 * size() - 1 ? 2 * size() - 1 : x;
        return leaf_at(doubled, root());
    }
    /// Returns the leaf that contains a position inside a cell. O(depth).
    Cell leaf_at(const Index& doubled, Cell cell) const noexcept {
        while (!is_leaf(cell.number)) cell = child_at(cell, doubled);
        return cell;
    }
    /// Returns the child of a cell at a position in half units.
    Cell child_at(const Cell& parent, const Index& doubled) const noexcept {
        std::size_t n = 0;
        for (std::size_t k = 0; k < D; ++k)
            n |= std::size_t{doubled[k] >= 2 * parent.low[k] + parent.size ? 1u : 0u} << k;
        return child(parent, n);
    }
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
    Buffer<std::uint32_t> first_child_; ///< per cell; 0: a leaf
    Buffer<Cell> families_;
};

/// Splits leaves until every neighbour of a leaf, across a face, an edge or a corner, has at least half its
/// size.
///
///   counts  counts(cell number): whether a leaf takes part; other leaves are not split and cause no splits
///   split   split(leaf) gives a leaf its children
template <std::size_t D, class Counts, class Split>
void balance(const CellTree<D>& tree, const Counts& counts, const Split& split) {
    using Index = typename CellTree<D>::Index;
    std::size_t neighbours = 1;
    for (std::size_t k = 0; k < D; ++k) neighbours *= 3;
    // A neighbour of a child may be at most as large as the child's parent. New families are appended, so
    // this loop visits them too.
    for (std::size_t family = 0; family < tree.families(); ++family) {
        const auto parent = tree.parent(family);
        bool any = false;
        for (std::size_t n = 0; n < CellTree<D>::children; ++n)
            any = any || counts(tree.child(parent, n).number);
        if (!any) continue;
        for (std::size_t position = 0; position < neighbours; ++position) {
            // The middle of the neighbouring cell; leaf_at clamps it to the cube.
            Index beside{};
            for (std::size_t k = 0, rest = position; k < D; ++k, rest /= 3)
                beside[k] = 2 * parent.low[k] + (2 * std::int32_t(rest % 3) - 1) * parent.size;
            for (;;) {
                const auto leaf = tree.leaf_at(beside);
                if (leaf.size <= parent.size || !counts(leaf.number)) break;
                split(leaf);
            }
        }
    }
}

} // namespace cageform::inline CAGEFORM_ABI::grid
