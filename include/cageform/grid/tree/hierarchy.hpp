// The levels of a multigrid on a tree of cells.
//
// On each next level, every family whose children are all leaves becomes one leaf. A node remains if it is
// still a corner of a leaf. The value of any other node is interpolated from the remaining nodes in the
// smallest leaf that contains it (the prolongation P). The coarse equations are the Galerkin product Pᵀ A
// P, and the restriction is Pᵀ.
#pragma once

#include <cageform/grid/tree/links.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// One level: its equations, and the prolongation from the next coarser level to it.
struct TreeLevel {
    LevelRows neighbours;            ///< the equations (TreeEquations)
    Buffer<float> inverse_diagonal;  ///< per node
    LevelRows interpolation;         ///< the prolongation, one row per node; empty on the coarsest level
    Buffer<std::uint32_t> numbers{}; ///< per node: index on the next level, or ~0; empty on the coarsest

    std::uint32_t nodes() const noexcept { return std::uint32_t(inverse_diagonal.size()); }
    std::size_t bytes() const noexcept {
        return neighbours.bytes() + interpolation.bytes() + inverse_diagonal.capacity() * sizeof(float) +
               numbers.capacity() * sizeof(std::uint32_t);
    }
};

template <std::size_t D>
class TreeCoarsener {
public:
    using Nodes = grid::TreeNodes<D>;
    using Index = typename Nodes::Index;
    using Cell = typename grid::CellTree<D>::Cell;
    static constexpr std::uint32_t none = Nodes::none;

    ///   decay  TreeLinks::decay
    TreeCoarsener(const grid::CutTree<D>& tree, const Nodes& nodes, std::span<const float> decay,
                  const Running& running)
        : tree_(tree)
        , nodes_(nodes)
        , decay_(decay)
        , running_(running)
        , merges_at_(tree.cells().cells(), 0)
        , number_(nodes.count()) {
        const auto& cells = tree.cells();
        for (std::size_t family = cells.families(); family-- > 0;) {
            const Cell& parent = cells.parent(family);
            std::uint8_t level = 0;
            for (std::size_t n = 0; n < grid::CellTree<D>::children; ++n)
                level = (std::max)(level, merges_at_[cells.first_child(parent.number) + n]);
            merges_at_[parent.number] = std::uint8_t(level + 1);
        }
        for (std::uint32_t node = 0; node < nodes.count(); ++node) {
            number_[node] = node;
            left_.push_back(node);
        }
    }

    /// Returns all levels, the finest first. Stops when few nodes are left or the tree cannot be coarsened.
    std::vector<TreeLevel> make(TreeEquations finest) {
        constexpr std::uint32_t few = 60; // solved by relaxation alone
        std::vector<TreeLevel> levels;
        TreeEquations equations = std::move(finest);
        for (;;) {
            TreeLevel& level = levels.emplace_back();
            for (const double d : equations.diagonal) level.inverse_diagonal.push_back(float(1 / d));
            const std::uint32_t count = level.nodes();
            // The progress assumes that each level takes half as long as the one before.
            const Running of_level =
                running_.subtask(1 - std::ldexp(1, -int(level_)), 1 - std::ldexp(0.5, -int(level_)));
            ++level_;
            if (count > few && level_ <= merges_at_[0])
                level.interpolation = interpolation(level, of_level.subtask(0, 0.5));
            const auto coarse = std::uint32_t(left_.size());
            const bool ends = level.interpolation.rows() == 0 || coarse == 0 || coarse == count;
            TreeEquations next;
            if (!ends) next = galerkin(equations, level.interpolation, coarse, of_level.subtask(0.5, 1));
            level.neighbours = std::move(equations.neighbours);
            level.neighbours.shrink_to_fit();
            level.inverse_diagonal.shrink_to_fit();
            if (ends) {
                level.interpolation = {};
                level.numbers = {};
                return levels;
            }
            equations = std::move(next);
        }
    }

private:
    /// Receives a row of the prolongation from LeafGather and sums the weights of equal nodes.
    struct Sink {
        const TreeCoarsener& coarsener;
        LevelRows& rows;
        std::size_t begin = 0;

        void at_node(const Index& index, double share) {
            const std::uint32_t node = coarsener.number_[coarsener.nodes_.find(index)];
            for (std::size_t k = begin; k < rows.entries.size(); ++k) {
                if (rows.entries[k].column != node) continue;
                rows.entries[k].weight += float(share);
                return;
            }
            rows.entries.push_back({node, float(share)});
        }
        // The prolongation interpolates corrections, which are zero on the boundary. When it interpolates
        // the solution (TreeMultigrid::interpolate_solution), relax_data replaces these terms.
        void at_boundary(const BoundaryValue<D>&, const Vec<double, D>&, double) noexcept {}
    };

    /// Returns the leaves of the current coarse level around a node.
    LeavesAbout<D> about(std::uint32_t node) const {
        return {tree_.cells(), nodes_.index(node),
                [&](std::uint32_t cell) { return merges_at_[cell] <= level_; },
                [&](std::uint32_t cell) { return tree_.state(cell) != grid::CellState::out; }};
    }
    /// Whether a node is a corner of a leaf that counts.
    static bool is_corner(const Index& index, const LeavesAbout<D>& about) noexcept {
        for (std::size_t n = 0; n < about.leaf.size(); ++n) {
            const Cell& leaf = about.leaf[n];
            bool corner = about.counts[n];
            for (std::size_t k = 0; k < D; ++k)
                corner = corner && (index[k] == leaf.low[k] || index[k] == leaf.low[k] + leaf.size);
            if (corner) return true;
        }
        return false;
    }

    struct Marked {};

    /// Returns the prolongation from the nodes that remain on level_ to the nodes of the level before.
    LevelRows interpolation(TreeLevel& level, const Running& running) {
        Buffer<std::uint32_t> fine; // indices on the finest level
        std::swap(fine, left_);
        left_.clear();
        Buffer<std::uint8_t> stays(fine.size(), 0);
        const auto mark_corners = [&](std::size_t begin, std::size_t end, Marked&) {
            for (std::size_t n = begin; n < end; ++n)
                stays[n] = is_corner(nodes_.index(fine[n]), about(fine[n])) ? 1 : 0;
        };
        (void)in_runs<Marked>(running.subtask(0, 0.4), fine.size(), 4096, [&] { return mark_corners; });
        level.numbers.reserve(fine.size());
        for (std::uint32_t n = 0; n < fine.size(); ++n) {
            number_[fine[n]] = stays[n] != 0 ? std::uint32_t(left_.size()) : none;
            level.numbers.push_back(number_[fine[n]]);
            if (stays[n] != 0) left_.push_back(fine[n]);
        }
        const auto make_rows = [&](std::size_t begin, std::size_t end, LevelRows& rows) {
            Sink sink{*this, rows};
            LeafGather<D, Sink> gather(tree_.boundary(), nodes_, sink);
            for (std::size_t n = begin; n < end; ++n) {
                sink.begin = rows.entries.size();
                if (stays[n] != 0) {
                    rows.entries.push_back({number_[fine[n]], 1});
                } else {
                    const auto leaves = about(fine[n]);
                    const Cell* leaf = leaves.smallest();
                    if (leaf != nullptr)
                        gather.gather(*leaf, tree_.facets(leaf->number),
                                      node_position<D>(nodes_.index(fine[n])));
                }
                for (auto& entry :
                     std::span(rows.entries).subspan(decay_.empty() ? rows.entries.size() : sink.begin))
                    entry.weight *= decay_[left_[entry.column]] / decay_[fine[n]]; // interpolates u linearly
                rows.end_row();
            }
        };
        LevelRows rows =
            joined_runs<LevelRows>(running.subtask(0.4, 1), fine.size(), 1024, [&] { return make_rows; });
        rows.shrink_to_fit();
        return rows;
    }

    const grid::CutTree<D>& tree_;
    const Nodes& nodes_;
    std::span<const float> decay_;
    const Running& running_;
    Buffer<std::uint8_t> merges_at_; ///< per cell: the first level on which it is a leaf
    Buffer<std::uint32_t> number_;   ///< per node of the finest level: index on the current level, or none
    Buffer<std::uint32_t> left_;     ///< the nodes of the current level
    unsigned level_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
