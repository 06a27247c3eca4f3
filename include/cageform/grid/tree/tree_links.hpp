// The Laplace equation at the corners of a tree's leaves.
//
// Along each axis the second difference of Shortley and Weller (J. Appl. Phys. 9 (1938)) between the
// ends of two links. A link ends on the boundary, on a node, or, at a hanging node, on a place of the
// opposite face of the large leaf beside it, whose value is interpolated there. What that adds to the
// second differences along the other axes is taken off again (Min, Gibou, Ceniceros, J. Comput. Phys.
// 218 (2006); here by second moments, which covers interpolation that ends on the boundary). All
// weights are positive, linear functions exact, the order is two.
#pragma once

#include <cageform/grid/tree/leaf_gather.hpp>
#include <cageform/grid/tree/level_rows.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// A part of the right-hand side: the weight of a handle's value at a node.
struct TreeData {
    std::uint32_t handle, node;
    float weight;
};

/// The equations of the nodes, times the volume about each.
struct TreeLinks {
    detail::TreeEquations equations;
    Buffer<TreeData> data;  ///< sorted by handle, then by node
    Buffer<float> volume;   ///< by node
    double least_share = 1; ///< of all factors that the corrections put before second differences
};

} // namespace grid

namespace detail {

/// The leaves about a node; octant n lies at the upper side along the axes of its set bits.
template <std::size_t D>
struct LeavesAbout {
    using Cell = typename grid::CellTree<D>::Cell;
    std::array<Cell, grid::CellTree<D>::children> leaf;
    std::array<bool, grid::CellTree<D>::children> counts; ///< not outside

    ///   is_leaf(cell number)     where the way down ends: a leaf of the tree or of a coarser level
    ///   does_count(cell number)  whether a leaf counts
    /// All octants share the way down to the first cell that the node lies in the middle of, along
    /// any axis.
    template <class IsLeaf, class Counts>
    LeavesAbout(const grid::CellTree<D>& tree, const std::array<std::int32_t, D>& node, const IsLeaf& is_leaf,
                const Counts& does_count) {
        Cell shared = tree.root();
        auto doubled = node;
        for (auto& x : doubled) x *= 2;
        const auto parts_octants = [&] {
            bool parts = false;
            for (std::size_t k = 0; k < D; ++k)
                parts = parts || doubled[k] == 2 * shared.low[k] + shared.size;
            return parts;
        };
        while (!is_leaf(shared.number) && !parts_octants()) shared = tree.child_at(shared, doubled);
        for (std::size_t n = 0; n < leaf.size(); ++n) {
            auto place = doubled;
            for (std::size_t k = 0; k < D; ++k) place[k] += ((n >> k) & 1u) != 0 ? 1 : -1;
            leaf[n] = shared;
            while (!is_leaf(leaf[n].number)) leaf[n] = tree.child_at(leaf[n], place);
            counts[n] = does_count(leaf[n].number);
        }
    }
    /// The smallest among the octants whose bits under `mask` are `bits`; null where none counts.
    const Cell* smallest(std::size_t mask = 0, std::size_t bits = 0) const noexcept {
        const Cell* best = nullptr;
        for (std::size_t n = 0; n < leaf.size(); ++n) {
            if ((n & mask) == bits && counts[n] && (best == nullptr || leaf[n].size < best->size))
                best = &leaf[n];
        }
        return best;
    }
};

/// Makes the equations node by node. Data is what cages call it: data.for_each_weight(value, f).
template <std::size_t D, class Data>
class LinkMaker {
public:
    using Nodes = grid::TreeNodes<D>;
    using Index = typename Nodes::Index;
    using Cell = typename grid::CellTree<D>::Cell;
    using AxisRay = grid::AxisRay<D>;

    LinkMaker(const grid::CutTree<D>& tree, const Nodes& nodes, const Data& data)
        : tree_(tree)
        , nodes_(nodes)
        , data_(data) {}

    grid::TreeLinks make() {
        for (std::uint32_t node = 0; node < nodes_.count(); ++node) add_equation(node);
        std::sort(out_.data.begin(), out_.data.end(), [](const grid::TreeData& a, const grid::TreeData& b) {
            return a.handle != b.handle ? a.handle < b.handle : a.node < b.node;
        });
        out_.equations.neighbours.shrink_to_fit();
        return std::move(out_);
    }

private:
    struct Side {
        double length;
        bool hangs;
        Vec<double, D> moments; ///< of an interpolated end, about it
        grid::CutStencil<D> end;
    };

    struct MomentSink {
        const Nodes& nodes;
        Side& side;
        Vec<double, D> centre;

        void at_node(const Index& index, double share) {
            side.end.add(nodes.find(index), share);
            add(node_position<D>(index), share);
        }
        void at_place(const BoundaryValue<D>& value, const Vec<double, D>& place, double share) {
            side.end.add(value, share);
            add(place, share);
        }
        void add(const Vec<double, D>& place, double share) {
            for (std::size_t k = 0; k < D; ++k)
                side.moments[k] += share * (place[k] - centre[k]) * (place[k] - centre[k]);
        }
    };

    void set_side(Side& side, const Index& index, const LeavesAbout<D>& about, std::size_t axis, bool up) {
        side.hangs = false;
        side.end.node_count = side.end.place_count = 0;
        const std::size_t bit = std::size_t{1} << axis;
        const Cell* leaf = about.smallest(bit, up ? bit : 0);
        const bool beyond = leaf == nullptr; // on the boundary, up to rounding
        if (beyond) leaf = about.smallest();
        const auto facets = tree_.facets(leaf->number);
        const auto& boundary = tree_.boundary();
        side.length = leaf->size;
        Index there = index;
        there[axis] += up ? leaf->size : -leaf->size;
        const auto place = node_position<D>(there);
        const auto end_on = [&](const grid::Hit<D>& hit, const AxisRay& ray) {
            side.length = std::clamp(ray.distance(hit.position), grid::on_facet_distance, side.length);
            side.end.add(hit.value, 1.0);
        };
        AxisRay ray{node_position<D>(index), axis, up, side.length};
        if (const auto hit = boundary.first_hit(facets, ray)) return end_on(*hit, ray);
        const std::uint32_t node = beyond ? Nodes::none : nodes_.find(there);
        if (node != Nodes::none) {
            side.end.add(node, 1.0);
            return;
        }
        bool is_corner = true;
        for (std::size_t k = 0; k < D; ++k)
            is_corner = is_corner && (there[k] == leaf->low[k] || there[k] == leaf->low[k] + leaf->size);
        if (beyond || is_corner) { // no node, so next to a facet
            side.end.add(boundary.nearest(facets, place).value, 1.0);
            return;
        }
        side.hangs = true;
        side.moments = {};
        MomentSink sink{nodes_, side, place};
        LeafGather<D, MomentSink>(boundary, nodes_, sink).gather(*leaf, facets, place);
    }

    void add_equation(std::uint32_t node) {
        const Index index = nodes_.index(node);
        const LeavesAbout<D> about(
            tree_.cells(), index, [&](std::uint32_t cell) { return tree_.cells().is_leaf(cell); },
            [&](std::uint32_t cell) { return tree_.state(cell) != grid::CellState::out; });
        for (std::size_t n = 0; n < 2 * D; ++n) set_side(sides_[n], index, about, n / 2, n % 2 == 1);
        double volume = 1;
        std::array<std::array<double, 2>, D> c{};
        for (std::size_t k = 0; k < D; ++k) {
            const double both = sides_[2 * k].length + sides_[2 * k + 1].length;
            volume *= 0.5 * both;
            for (std::size_t s = 0; s < 2; ++s) c[k][s] = 2 / (sides_[2 * k + s].length * both);
        }
        const auto shares = shares_of_axes(c);
        row_.clear();
        double diagonal = 0;
        for (std::size_t n = 0; n < 2 * D; ++n) {
            const double weight = volume * shares[n / 2] * c[n / 2][n % 2];
            const auto& end = sides_[n].end;
            for (std::uint32_t k = 0; k < end.node_count; ++k)
                add_to_row(end.nodes[k].node, weight * end.nodes[k].share);
            for (std::uint32_t k = 0; k < end.place_count; ++k) {
                const auto& [value, share] = end.places[k];
                data_.for_each_weight(value, [&, w = weight * share](std::uint32_t handle, double of_handle) {
                    const auto part = float(w * of_handle);
                    if (!(part > 0)) return;
                    out_.data.push_back({handle, node, part});
                    diagonal += double(part);
                });
            }
        }
        std::sort(row_.begin(), row_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        for (const auto& [column, weight] : row_) {
            out_.equations.neighbours.entries.push_back({column, float(weight)});
            diagonal += double(float(weight));
        }
        out_.equations.neighbours.end_row();
        out_.equations.diagonal.push_back(diagonal);
        out_.volume.push_back(float(volume));
    }
    void add_to_row(std::uint32_t column, double weight) {
        for (auto& [known, sum] : row_) {
            if (known != column) continue;
            sum += weight;
            return;
        }
        row_.push_back({column, weight});
    }

    /// What remains of the second difference along each axis, so that all are exact for squares:
    /// share_k = 1 − Σ share_a σ(a, k), a ≠ k.
    std::array<double, D> shares_of_axes(const std::array<std::array<double, 2>, D>& c) {
        std::array<double, D> shares{};
        shares.fill(1);
        bool hangs = false;
        for (const Side& side : sides_) hangs = hangs || side.hangs;
        for (int step = 0; hangs && step < 30; ++step) { // contracts by (D − 1)/4
            auto next = shares;
            for (std::size_t k = 0; k < D; ++k) {
                next[k] = 1;
                for (std::size_t n = 0; n < 2 * D; ++n) {
                    if (sides_[n].hangs && n / 2 != k)
                        next[k] -= shares[n / 2] * c[n / 2][n % 2] * sides_[n].moments[k] / 2;
                }
            }
            shares = next;
        }
        for (const double share : shares) out_.least_share = std::min(out_.least_share, share);
        return shares;
    }

    const grid::CutTree<D>& tree_;
    const Nodes& nodes_;
    const Data& data_;
    std::array<Side, 2 * D> sides_;
    std::vector<std::pair<std::uint32_t, double>> row_;
    grid::TreeLinks out_;
};

} // namespace detail
namespace grid {

///   data  data.for_each_weight(value, f): f(handle, weight) for the handles whose value at a place of
///         the boundary is not zero; none negative
template <std::size_t D, class Data = detail::HatData<D>>
TreeLinks links_of(const CutTree<D>& tree, const TreeNodes<D>& nodes, const Data& data = {}) {
    return detail::LinkMaker<D, Data>(tree, nodes, data).make();
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
