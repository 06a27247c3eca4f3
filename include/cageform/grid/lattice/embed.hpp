// Embeds a boundary in a lattice without moving it.
//
// The crossings of the boundary with lattice lines decide which nodes are inside. They also give every link
// that ends on the boundary its length and its data. This header is independent of cages and solvers.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/lattice/grid_boundary.hpp>
#include <cageform/grid/lattice/node_runs.hpp>

#include <limits>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// The unknown nodes of a boundary value problem, and their links to the boundary data.
template <std::size_t D>
struct EmbeddedProblem {
    NodeRuns<D> nodes;
    Buffer<CutLink> cuts;            ///< sorted by node
    Buffer<BoundaryValue<D>> values; ///< parallel to `cuts`
};

} // namespace grid

namespace detail {

/// Calls f(before, after) for consecutive crossings of a line if the part between them is inside.
template <std::size_t D, class F>
void for_each_inner_interval(const Buffer<grid::Crossing<D>>& crossings, F&& f) {
    bool inside = false;
    for (std::size_t i = 0; i < crossings.size(); ++i) {
        if (i > 0 && crossings[i].line == crossings[i - 1].line) {
            if (inside) f(crossings[i - 1], crossings[i]);
        } else {
            inside = false;
        }
        inside = inside != crossings[i].separates;
    }
}
/// Returns the nodes strictly between two crossings as a range [first, second).
template <std::size_t D>
std::pair<std::int32_t, std::int32_t> nodes_between(const grid::Crossing<D>& a,
                                                    const grid::Crossing<D>& b) noexcept {
    return {std::int32_t(std::floor(a.position + grid::on_boundary_distance)) + 1,
            std::int32_t(std::ceil(b.position - grid::on_boundary_distance))};
}

/// The nodes next to a crossing, which lies on a node or between two.
struct NodesAround {
    std::int32_t below, above; ///< the nearest nodes on both sides of the crossing
    bool on_node;              ///< whether the crossing lies on a node, which is then `below` + 1

    explicit NodesAround(double position) noexcept {
        const double nearest = std::round(position);
        on_node = std::fabs(position - nearest) <= grid::on_boundary_distance;
        below = std::int32_t(on_node ? nearest - 1 : std::floor(position));
        above = on_node ? below + 2 : below + 1;
    }
};

template <grid::EmbeddableBoundary B>
class Embedding {
public:
    static constexpr std::size_t D = B::dimension;
    using Index = typename grid::NodeRuns<D>::Index;

    Embedding(const B& boundary, const grid::Crossings<D>& crossings)
        : boundary_(boundary)
        , crossings_(crossings)
        , nodes_(boundary.lattice().counts()) {
        const auto fixed = boundary.fixed_nodes();
        fixed_.append(fixed.data(), fixed.data() + fixed.size());
        std::sort(fixed_.begin(), fixed_.end(), before_node);
    }

    grid::EmbeddedProblem<D> make() {
        find_nodes();
        cut_links_at_crossings();
        cut_links_to_other_nodes();
        grid::EmbeddedProblem<D> problem;
        for (const Cut& cut : cuts_) {
            problem.cuts.push_back(cut.link);
            problem.values.push_back(cut.value);
        }
        problem.nodes = std::move(nodes_);
        return problem;
    }

private:
    struct RowPosition {
        std::uint32_t row;
        std::int32_t x;

        bool operator<(const RowPosition& other) const noexcept {
            return row != other.row ? row < other.row : x < other.x;
        }
    };
    struct Cut {
        grid::CutLink link;
        BoundaryValue<D> value;
    };

    static bool before_node(const grid::FixedNode<D>& a, const grid::FixedNode<D>& b) noexcept {
        return a.index < b.index;
    }
    /// Orders by link, and crossings of one link by distance.
    static bool before(const Cut& a, const Cut& b) noexcept {
        if (a.link.node != b.link.node) return a.link.node < b.link.node;
        if (a.link.direction != b.link.direction) return a.link.direction < b.link.direction;
        return a.link.weight > b.link.weight;
    }
    static bool same_link(const Cut& a, const Cut& b) noexcept {
        return a.link.node == b.link.node && a.link.direction == b.link.direction;
    }
    RowPosition row_position(const Index& index) const noexcept {
        return {std::uint32_t(nodes_.row(index)), index[0]};
    }

    /// Returns the nodes that are not unknowns, sorted: fixed nodes, and nodes on the boundary according to
    /// the lines of the other axes.
    Buffer<RowPosition> known_nodes() const {
        Buffer<RowPosition> all;
        all.reserve(fixed_.size());
        for (const auto& fixed : fixed_) all.push_back(row_position(fixed.index));
        for (std::size_t axis = 1; axis < D; ++axis) {
            for (const auto& crossing : crossings_[axis]) {
                const NodesAround around(crossing.position);
                if (around.on_node)
                    all.push_back(
                        row_position(boundary_.lattice().on_line(axis, crossing.line, around.below + 1)));
            }
        }
        std::sort(all.begin(), all.end());
        return all;
    }

    /// Finds the nodes inside by the even-odd rule along the rows (the lines of axis 0).
    void find_nodes() {
        const auto known = known_nodes();
        std::uint32_t row = 0;
        auto next = known.begin();
        for_each_inner_interval<D>(
            crossings_[0], [&](const grid::Crossing<D>& a, const grid::Crossing<D>& b) {
                for (; row < a.line; ++row) nodes_.end_row();
                auto [x, end] = nodes_between(a, b);
                x = (std::max)(x, 0);
                end = (std::min)(end, nodes_.size()[0]);
                next = std::lower_bound(next, known.end(), RowPosition{a.line, x});
                for (; next != known.end() && *next < RowPosition{a.line, end}; ++next) {
                    nodes_.add_run(x, next->x);
                    x = next->x + 1;
                }
                nodes_.add_run(x, end);
            });
        for (; row < nodes_.rows(); ++row) nodes_.end_row();
    }

    /// Cuts the links that the boundary crosses, with the weights of Shortley and Weller (J. Appl. Phys. 9
    /// (1938), p. 334): 1/θ, where θ is the fraction of the link before the boundary. If a link has several
    /// crossings, the nearest is used.
    void cut_links_at_crossings() {
        for (std::size_t axis = 0; axis < D; ++axis) {
            for (const auto& crossing : crossings_[axis]) {
                const auto cut = [&](std::int32_t x, bool up, double theta) {
                    const auto node = nodes_.find(boundary_.lattice().on_line(axis, crossing.line, x));
                    const auto direction = std::uint8_t(2 * axis + (up ? 1 : 0));
                    if (node != grid::NodeRuns<D>::none)
                        cuts_.push_back({{node, direction, 1 / theta}, crossing.value});
                };
                const NodesAround around(crossing.position);
                if (crossing.from_below)
                    cut(around.below, true, around.on_node ? 1.0 : crossing.position - double(around.below));
                if (crossing.from_above)
                    cut(around.above, false, around.on_node ? 1.0 : double(around.above) - crossing.position);
            }
        }
        std::sort(cuts_.begin(), cuts_.end(), before);
        cuts_.erase_from(std::unique(cuts_.begin(), cuts_.end(), same_link));
    }

    /// Cuts the remaining links to nodes that are not unknowns: fixed nodes, and nodes that the lines of
    /// different axes classify differently because of rounding.
    void cut_links_to_other_nodes() {
        Buffer<Cut> more;
        nodes_.for_each_end([&](const Index& index, std::uint32_t node, std::size_t direction) {
            Cut cut{{node, std::uint8_t(direction), (std::numeric_limits<double>::max)()}, {}};
            const auto known = std::lower_bound(cuts_.begin(), cuts_.end(), cut, before);
            if (known != cuts_.end() && same_link(*known, cut)) return;
            Index there = index;
            there[direction / 2] += (direction & 1) != 0 ? 1 : -1;
            cut.link.weight = 1;
            cut.value = value_at(there);
            more.push_back(cut);
        });
        cuts_.append(more.begin(), more.end());
        std::sort(cuts_.begin(), cuts_.end(), before);
    }
    BoundaryValue<D> value_at(const Index& node) const noexcept {
        const grid::FixedNode<D> key{node, {}};
        const auto at = std::lower_bound(fixed_.begin(), fixed_.end(), key, before_node);
        return at != fixed_.end() && at->index == node ? at->value : boundary_.nearest(node);
    }

    const B& boundary_;
    const grid::Crossings<D>& crossings_;
    grid::NodeRuns<D> nodes_;
    Buffer<grid::FixedNode<D>> fixed_; ///< sorted by index
    Buffer<Cut> cuts_;                 ///< sorted after each step
};

} // namespace detail
namespace grid {

/// Returns the unknowns and their links to the boundary: nodes inside by the even-odd rule along axis 0,
/// and links cut along all axes.
///
///   crossings  the crossings of the boundary
///   cost       O(#crossings log #crossings + #rows); nodes outside have no cost
template <EmbeddableBoundary B>
EmbeddedProblem<B::dimension> embed(const B& boundary, const Crossings<B::dimension>& crossings) {
    return detail::Embedding<B>(boundary, crossings).make();
}

/// Returns which handles the grid resolves: those with data on a link of an inner node.
///
///   for_each_handle  for_each_handle(value, f) calls f(handle) for every handle with non-zero weight in a
///                    boundary value
template <std::size_t D, class ForEachHandle>
std::vector<bool> resolved_handles(const Crossings<D>& crossings, std::size_t handles,
                                   const ForEachHandle& for_each_handle) {
    std::vector<bool> resolved(handles);
    const auto mark = [&](const BoundaryValue<D>& value) {
        for_each_handle(value, [&](std::uint32_t handle) { resolved[handle] = true; });
    };
    for (const auto& along : crossings) {
        detail::for_each_inner_interval<D>(along, [&](const Crossing<D>& a, const Crossing<D>& b) {
            const auto [begin, end] = detail::nodes_between(a, b);
            if (begin >= end) return;
            mark(a.value);
            mark(b.value);
        });
    }
    return resolved;
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
