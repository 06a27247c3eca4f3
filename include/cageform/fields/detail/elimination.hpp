// The elimination order of the nodes of a graph, and the groups (supernodes) eliminated together.
#pragma once

#include <cageform/core/vec.hpp>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The links of every node in compressed sparse rows.
struct Adjacency {
    std::vector<std::size_t> first{0}; ///< #nodes + 1: begin of each node's links
    std::vector<std::uint32_t> node;   ///< the node at the other end of each link
    std::vector<double> conductance;

    std::size_t nodes() const noexcept { return first.size() - 1; }
    std::span<const std::uint32_t> neighbours(std::uint32_t i) const noexcept {
        return std::span(node).subspan(first[i], first[i + 1] - first[i]);
    }
};

/// An elimination order with little fill-in. It is Eigen's approximate minimum degree order, postordered
/// along the elimination tree. Nodes are grouped into supernodes (Liu, The role of elimination trees in
/// sparse factorization, SIAM J. Matrix Anal. Appl. 11 (1990), sec. 2, 3 and 5).
class Elimination {
public:
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    /// A supernode: nodes that are eliminated together.
    struct Group {
        std::size_t begin, end; ///< range in `nodes`
        std::uint32_t parent;   ///< group of the first later node linked to this group, or none
    };

    explicit Elimination(const Adjacency& graph)
        : graph_(graph)
        , nodes_(graph.nodes())
        , position_(graph.nodes()) {
        if (nodes_.empty()) return;
        order_by_degree();
        find_parents();
        order_by_tree();
        find_groups();
    }

    /// Returns the groups in elimination order, a postorder: every subtree is contiguous and precedes its
    /// parent.
    std::span<const Group> groups() const noexcept { return groups_; }
    std::span<const std::uint32_t> nodes(const Group& group) const noexcept {
        return std::span(nodes_).subspan(group.begin, group.end - group.begin);
    }
    std::span<const std::uint32_t> positions() const noexcept { return position_; }

private:
    void order_by_degree() {
        using Index = std::int32_t;
        Eigen::SparseMatrix<double, Eigen::ColMajor, Index> matrix(Index(nodes_.size()),
                                                                   Index(nodes_.size()));
        matrix.resizeNonZeros(Eigen::Index(nodes_.size() + graph_.node.size()));
        Index* next = matrix.innerIndexPtr();
        for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
            matrix.outerIndexPtr()[i] = Index(next - matrix.innerIndexPtr());
            Index* const first = next;
            *next++ = Index(i); // the ordering expects a diagonal
            for (const std::uint32_t j : graph_.neighbours(i)) *next++ = Index(j);
            std::sort(first, next);
            next = std::unique(first, next); // merges repeated links
        }
        matrix.outerIndexPtr()[nodes_.size()] = Index(next - matrix.innerIndexPtr());
        matrix.resizeNonZeros(next - matrix.innerIndexPtr());
        std::fill_n(matrix.valuePtr(), matrix.nonZeros(), 1.0);
        Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, Index> order;
        Eigen::AMDOrdering<Index>()(matrix.selfadjointView<Eigen::Lower>(), order);
        for (std::size_t i = 0; i < nodes_.size(); ++i)
            nodes_[i] = std::uint32_t(order.indices()[Eigen::Index(i)]);
        find_positions();
    }
    void find_positions() noexcept {
        for (std::uint32_t position = 0; position < nodes_.size(); ++position)
            position_[nodes_[position]] = position;
    }

    /// Finds the parent of every position in the elimination tree: the first later position to which it is
    /// linked after elimination. `top` has shortcuts over subtrees already visited (path compression).
    void find_parents() {
        std::vector<std::uint32_t> top(nodes_.size(), none);
        parent_.assign(nodes_.size(), none);
        for (std::uint32_t position = 0; position < nodes_.size(); ++position) {
            for (const std::uint32_t i : graph_.neighbours(nodes_[position])) {
                for (std::uint32_t below = position_[i]; below < position;) {
                    const std::uint32_t up = top[below];
                    top[below] = position;
                    if (up == none) parent_[below] = position;
                    below = up; // `none` exceeds every position and ends the loop
                }
            }
        }
    }

    /// Renumbers in postorder: every subtree is contiguous and ends with its root.
    void order_by_tree() {
        const auto size = std::uint32_t(nodes_.size());
        std::vector<std::uint32_t> child(size, none), sibling(size, none), moved(size), path, ordered;
        for (std::uint32_t position = size; position-- > 0;) {
            if (parent_[position] == none) continue;
            sibling[position] = child[parent_[position]];
            child[parent_[position]] = position;
        }
        for (std::uint32_t root = 0; root < size; ++root) {
            if (parent_[root] != none) continue;
            path.assign(1, root);
            while (!path.empty()) {
                const std::uint32_t position = path.back(), below = child[position];
                if (below != none) {
                    child[position] = sibling[below];
                    path.push_back(below);
                    continue;
                }
                path.pop_back();
                moved[position] = std::uint32_t(ordered.size());
                ordered.push_back(nodes_[position]);
            }
        }
        std::vector<std::uint32_t> parent(size, none);
        for (std::uint32_t position = 0; position < size; ++position) {
            if (parent_[position] != none) parent[moved[position]] = moved[parent_[position]];
        }
        parent_ = std::move(parent);
        nodes_ = std::move(ordered);
        find_positions();
    }

    /// A group whose parent has not been reached, and the later positions linked to this group.
    struct Open {
        std::uint32_t group;
        std::vector<std::uint32_t> rows;
        double zeros; ///< explicit zeros stored in its columns
    };

    void find_groups() {
        std::vector<Open> open;
        std::vector<std::uint32_t> marked(nodes_.size(), none), rows;
        for (std::uint32_t position = 0; position < nodes_.size(); ++position) {
            rows.clear();
            const auto add = [&](std::uint32_t row) {
                if (row <= position || marked[row] == position) return;
                marked[row] = position;
                rows.push_back(row);
            };
            for (const std::uint32_t i : graph_.neighbours(nodes_[position])) add(position_[i]);
            std::size_t first = open.size(); // first child of the position
            for (; first > 0 && parent_[groups_[open[first - 1].group].end - 1] == position; --first) {
                for (const std::uint32_t row : open[first - 1].rows) add(row);
            }
            std::uint32_t group = std::uint32_t(groups_.size());
            double zeros = 0;
            if (first < open.size() && joins(open.back(), rows.size(), zeros)) {
                group = open.back().group;
                open.pop_back();
                groups_[group].end = position + 1;
            } else {
                groups_.push_back({position, position + 1, none});
                zeros = 0;
            }
            for (std::size_t n = first; n < open.size(); ++n) groups_[open[n].group].parent = group;
            open.resize(first);
            open.push_back({group, rows, zeros});
        }
    }
    /// Whether a node with `rows` later neighbours joins the group of its last child (relaxed supernodes).
    /// The fraction of stored zeros must be small; the limit is higher for small groups (similar to CHOLMOD).
    bool joins(const Open& last, std::size_t rows, double& zeros) const noexcept {
        const double own = double(groups_[last.group].end - groups_[last.group].begin);
        zeros = last.zeros + own * double(rows + 1 - last.rows.size());
        const double numbers = (own + 1) * (double(rows) + 0.5 * (own + 1));
        return zeros <= numbers * (own < 4 ? 0.8 : own < 16 ? 0.3 : own < 48 ? 0.1 : 0.05);
    }

    const Adjacency& graph_;
    std::vector<std::uint32_t> nodes_;    ///< in elimination order
    std::vector<std::uint32_t> position_; ///< per node
    std::vector<std::uint32_t> parent_;   ///< per position
    std::vector<Group> groups_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
