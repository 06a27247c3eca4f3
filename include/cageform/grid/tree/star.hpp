// The star of a point in 2D: the nodes and boundary points that its value is computed from.
//
// In generalised finite differences the star is the set of points in the equation of a node. Here it has
// the corners of the leaves around the point. If a facet lies between the point and a corner, the point on
// that facet, whose value is known, replaces the corner. A point is *visible* if no facet lies in between.
// grid/tree/harmonic_mean.hpp computes weights for a star.
#pragma once

#include <cageform/grid/tree/cut_tree.hpp>
#include <cageform/grid/tree/harmonic_mean.hpp>
#include <cageform/grid/tree/nodes.hpp>

#include <numbers>

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

/// Collects a star of at most HarmonicMean::most points.
class Star {
public:
    using Nodes = grid::TreeNodes<2>;
    using Index = Nodes::Index;
    using Cell = grid::CellTree<2>::Cell;
    struct StarPoint {
        Vec<double, 2> offset;  ///< from the centre of the star, in units of the tree
        std::uint32_t node;     ///< none: the point lies on the boundary
        BoundaryValue<2> value; ///< only for a point on the boundary
    };

    Star(const grid::CutTree<2>& tree, const Nodes& nodes)
        : tree_(tree)
        , nodes_(nodes) {}

    /// Collects the star of a node. Returns false if a bone intersects a leaf around it, because visibility
    /// ignores bones.
    bool collect(const Index& index, const LeavesAbout<2>& about) {
        begin(node_position<2>(index), about.smallest()->size);
        return add_leaves(index, about);
    }
    /// Collects the star of a point in a leaf. First come the visible points of the leaf, then the boundary
    /// along the four axis directions. The stars of the visible corners of the leaf follow, those of the
    /// nearest corner first. Returns false if a bone intersects the leaf.
    bool collect(const Vec<double, 2>& p, const Cell& leaf) {
        begin(p, leaf.size);
        const auto facets = tree_.facets(leaf.number);
        if (!add_leaf(p, leaf)) return false;
        for (std::size_t side = 0; side < 4 && !facets.empty(); ++side) {
            Vec<double, 2> along{};
            along[side / 2] =
                (side % 2 == 0 ? leaf.low[side / 2] : leaf.low[side / 2] + leaf.size) - p[side / 2];
            if (const auto met = tree_.boundary().first_met(p, along, facets))
                add_boundary_point(met->fraction * along, met->value);
        }
        std::array<std::pair<double, Index>, 4> corners;
        std::size_t count = 0;
        for (std::size_t n = 0; n < 4; ++n) {
            const Index there = on_rim(leaf, n);
            const auto along = node_position<2>(there) - p;
            if (nodes_.find(there) != Nodes::none && !tree_.boundary().first_met(p, along, facets))
                corners[count++] = {dot(along, along), there};
        }
        std::sort(corners.begin(), corners.begin() + std::ptrdiff_t(count));
        for (std::size_t n = 0; n < count; ++n) {
            add_node(corners[n].second);
            if (!add_leaves(corners[n].second, leaves_about(tree_, corners[n].second))) break;
        }
        return true;
    }
    /// Adds the visible points in evenly spaced directions, up to the leaf's size away: the boundary, or
    /// the nodes of the leaf at that distance. Adds nothing if a bone is within twice that distance. This
    /// is for parts of the domain narrower than a leaf, where the leaf may have no node.
    void add_directions(const Vec<double, 2>& p, const Cell& leaf) {
        constexpr std::size_t directions = 16;
        const auto& boundary = tree_.boundary();
        if (boundary.bones().nearest(p, 2.0 * leaf.size)) return;
        for (std::size_t n = 0; n < directions; ++n) {
            const double angle = 2 * std::numbers::pi * double(n) / directions;
            const Vec<double, 2> along{leaf.size * std::cos(angle), leaf.size * std::sin(angle)};
            if (const auto met = boundary.first_met(p, along)) {
                add_boundary_point(met->fraction * along, met->value);
                continue;
            }
            const Cell there = tree_.leaf_at(p + along);
            for (std::size_t corner = 0; corner < 4; ++corner) {
                const Index node = on_rim(there, corner);
                if (nodes_.find(node) != Nodes::none && !boundary.first_met(p, node_position<2>(node) - p))
                    add_node(node);
            }
        }
    }
    /// Returns the size of the smallest leaf around the node, or of the point's leaf.
    double size() const noexcept { return size_; }
    std::span<const StarPoint> points() const noexcept { return {points_.data(), points_.size()}; }

private:
    void begin(const Vec<double, 2>& centre, std::int32_t size) {
        points_.clear();
        centre_ = centre;
        size_ = size;
    }
    /// Returns the position of a target. Targets 0 to 3 are the corners of the leaf, and 4 to 7 are the
    /// middles of its sides. A middle is rounded to a unit, because it only gives a direction.
    static Index on_rim(const Cell& leaf, std::size_t target) noexcept {
        Index at = leaf.low;
        if (target < 4) {
            for (std::size_t k = 0; k < 2; ++k) at[k] += ((target >> k) & 1u) != 0 ? leaf.size : 0;
        } else {
            const std::size_t axis = (target - 4) / 2;
            at[1 - axis] += leaf.size / 2;
            at[axis] += (target & 1u) != 0 ? leaf.size : 0;
        }
        return at;
    }
    /// Adds the visible points of each leaf around a node, unless the leaf is outside.
    bool add_leaves(const Index& index, const LeavesAbout<2>& about) {
        for (std::size_t n = 0; n < about.leaf.size(); ++n) {
            if (about.counts[n] && !add_leaf(node_position<2>(index), about.leaf[n])) return false;
        }
        return true;
    }
    /// Adds the first node or boundary point towards each corner of a leaf and, if the leaf has facets,
    /// towards the middles of its sides.
    bool add_leaf(const Vec<double, 2>& from, const Cell& leaf) {
        const auto facets = tree_.facets(leaf.number);
        if (!facets.empty() && facets.back() >= tree_.boundary().size()) return false;
        for (std::size_t target = 0; target < (facets.empty() ? 4 : 8); ++target) {
            const Index there = on_rim(leaf, target);
            const auto along = node_position<2>(there) - from;
            if (dot(along, along) == 0) continue;
            if (const auto met = tree_.boundary().first_met(from, along, facets)) {
                add_boundary_point(from + met->fraction * along - centre_, met->value);
            } else if (target < 4 && nodes_.find(there) != Nodes::none) {
                add_node(there);
            }
        }
        return true;
    }
    void add_node(const Index& there) {
        const std::uint32_t node = nodes_.find(there);
        for (const StarPoint& point : points_) {
            if (point.node == node) return;
        }
        if (points_.size() < HarmonicMean::most)
            points_.push_back({node_position<2>(there) - centre_, node, {}});
    }
    void add_boundary_point(const Vec<double, 2>& offset, const BoundaryValue<2>& value) {
        if (length(offset) <= grid::on_facet_distance) return;
        for (const StarPoint& point : points_) {
            if (point.node == Nodes::none && length(point.offset - offset) <= 1e-6 * size_) return;
        }
        if (points_.size() < HarmonicMean::most) points_.push_back({offset, Nodes::none, value});
    }
    const grid::CutTree<2>& tree_;
    const Nodes& nodes_;
    double size_ = 0;
    Vec<double, 2> centre_{};
    std::vector<StarPoint> points_;
};

/// Returns the value at a point in a leaf as a mean over the star of the point. The mean is exact for
/// harmonic polynomials up to degree `most_degree`, or up to the highest lower degree that works. Weights of
/// either sign are tried first, because they reach a higher degree. Returns nullopt if the star is too small
/// or next to a bone.
inline std::optional<grid::CutStencil<2>>
harmonic_mean_of(const grid::CutTree<2>& tree, const grid::TreeNodes<2>& nodes, const Vec<double, 2>& p,
                 const grid::CellTree<2>::Cell& leaf, unsigned most_degree) {
    constexpr double largest_sum = 4; // limit of Σ |weight|
    Star star(tree, nodes);
    if (!star.collect(p, leaf)) return std::nullopt;
    HarmonicMean mean;
    const auto take_points = [&] {
        mean.clear();
        const double screening = tree.screening() * star.size() * star.size();
        for (const auto& point : star.points()) mean.add((1 / star.size()) * point.offset, screening);
    };
    take_points();
    if (mean.solve_signed(most_degree, 3, largest_sum) == 0) {
        star.add_directions(p, leaf);
        take_points();
        if (mean.solve_signed(most_degree, 2, largest_sum) == 0 && mean.solve(most_degree, 1) == 0)
            return std::nullopt;
    }
    std::optional<grid::CutStencil<2>> stencil(std::in_place);
    for (std::size_t n = 0; n < mean.count(); ++n) {
        const auto& point = star.points()[n];
        if (point.node != grid::TreeNodes<2>::none) {
            stencil->add(point.node, mean.weight(n));
        } else {
            stencil->add(point.value, mean.weight(n));
        }
    }
    return stencil;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
