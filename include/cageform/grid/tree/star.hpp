// What a node or a place in a tree sees about it in the plane: nodes, and places of the boundary.
#pragma once

#include <cageform/grid/tree/harmonic_mean.hpp>
#include <cageform/grid/tree/leaves_about.hpp>
#include <cageform/grid/tree/nodes.hpp>

#include <numbers>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The corners of the leaves about a node, and where facets hide them the places of these; no more than
/// a HarmonicMean takes.
class Star {
public:
    using Nodes = grid::TreeNodes<2>;
    using Index = Nodes::Index;
    using Cell = grid::CellTree<2>::Cell;
    struct Place {
        Vec<double, 2> offset; ///< from the centre, in units
        std::uint32_t node;    ///< or none: on the boundary
        BoundaryValue<2> value;
    };

    Star(const grid::CutTree<2>& tree, const Nodes& nodes)
        : tree_(tree)
        , nodes_(nodes) {}

    /// From a node. False where it is not known what is seen, next to bones.
    bool look(const Index& index, const LeavesAbout<2>& about) {
        begin(node_position<2>(index), about.smallest()->size);
        return look_about(index, about);
    }
    /// From a place in a leaf: what it sees in the leaf, with what the leaf's corners that it sees do,
    /// the nearest first. False where that is not known.
    bool look(const Vec<double, 2>& p, const Cell& leaf) {
        begin(p, leaf.size);
        const auto facets = tree_.facets(leaf.number);
        if (!look_at(p, leaf)) return false;
        for (std::size_t side = 0; side < 4 && !facets.empty(); ++side) {
            Vec<double, 2> along{};
            along[side / 2] =
                (side % 2 == 0 ? leaf.low[side / 2] : leaf.low[side / 2] + leaf.size) - p[side / 2];
            if (const auto met = tree_.boundary().first_met(p, along, facets))
                add_place(met->part * along, met->value);
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
            if (!look_about(corners[n].second, leaves_about(tree_, corners[n].second))) break;
        }
        return true;
    }
    /// Adds what a place in a leaf sees in evenly spread directions up to the leaf's size away: the boundary, or
    /// nodes of the leaf there. Nothing where a bone is as near. In a limb narrower than the leaf the leaf itself
    /// may have no nodes.
    void look_around(const Vec<double, 2>& p, const Cell& leaf) {
        constexpr std::size_t directions = 16;
        const auto& boundary = tree_.boundary();
        if (boundary.bones().nearest(p, 2.0 * leaf.size)) return;
        for (std::size_t n = 0; n < directions; ++n) {
            const double angle = 2 * std::numbers::pi * double(n) / directions;
            const Vec<double, 2> along{leaf.size * std::cos(angle), leaf.size * std::sin(angle)};
            if (const auto met = boundary.first_met(p, along)) {
                add_place(met->part * along, met->value);
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
    double size() const noexcept { return size_; } ///< of the smallest leaf about, or of the leaf
    std::span<const Place> places() const noexcept { return {places_.data(), places_.size()}; }

private:
    void begin(const Vec<double, 2>& centre, std::int32_t size) {
        places_.clear();
        centre_ = centre;
        size_ = size;
    }
    /// The corners of a leaf, then the middles of its sides, up to a unit, as they are only looked towards.
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
    bool look_about(const Index& index, const LeavesAbout<2>& about) {
        for (std::size_t n = 0; n < about.leaf.size(); ++n) {
            if (about.counts[n] && !look_at(node_position<2>(index), about.leaf[n])) return false;
        }
        return true;
    }
    bool look_at(const Vec<double, 2>& from, const Cell& leaf) {
        const auto facets = tree_.facets(leaf.number);
        if (!facets.empty() && facets.back() >= tree_.boundary().size()) return false;
        for (std::size_t target = 0; target < (facets.empty() ? 4 : 8); ++target) {
            const Index there = on_rim(leaf, target);
            const auto along = node_position<2>(there) - from;
            if (dot(along, along) == 0) continue;
            if (const auto met = tree_.boundary().first_met(from, along, facets)) {
                add_place(from + met->part * along - centre_, met->value);
            } else if (target < 4 && nodes_.find(there) != Nodes::none) {
                add_node(there);
            }
        }
        return true;
    }
    void add_node(const Index& there) {
        const std::uint32_t node = nodes_.find(there);
        for (const Place& place : places_) {
            if (place.node == node) return;
        }
        if (places_.size() < HarmonicMean::most)
            places_.push_back({node_position<2>(there) - centre_, node, {}});
    }
    void add_place(const Vec<double, 2>& offset, const BoundaryValue<2>& value) {
        if (length(offset) <= grid::on_facet_distance) return;
        for (const Place& place : places_) {
            if (place.node == Nodes::none && length(place.offset - offset) <= 1e-6 * size_) return;
        }
        if (places_.size() < HarmonicMean::most) places_.push_back({offset, Nodes::none, value});
    }
    const grid::CutTree<2>& tree_;
    const Nodes& nodes_;
    double size_ = 0;
    Vec<double, 2> centre_{};
    std::vector<Place> places_;
};

/// The value at a place in a leaf by what it sees, exact for powers up to `most_degree`. None where
/// nothing is known of that. Weights may be negative where these are the more exact.
inline std::optional<grid::CutStencil<2>>
harmonic_mean_of(const grid::CutTree<2>& tree, const grid::TreeNodes<2>& nodes, const Vec<double, 2>& p,
                 const grid::CellTree<2>::Cell& leaf, unsigned most_degree) {
    constexpr double largest_sum = 4; // of the weights' sizes
    Star star(tree, nodes);
    if (!star.look(p, leaf)) return std::nullopt;
    HarmonicMean mean;
    const auto take_places = [&] {
        mean.clear();
        for (const auto& place : star.places()) mean.add((1 / star.size()) * place.offset);
    };
    take_places();
    if (mean.solve_signed(most_degree, 3, largest_sum) == 0) {
        star.look_around(p, leaf);
        take_places();
        if (mean.solve_signed(most_degree, 2, largest_sum) == 0 && mean.solve(most_degree, 1) == 0)
            return std::nullopt;
    }
    std::optional<grid::CutStencil<2>> stencil(std::in_place);
    for (std::size_t n = 0; n < mean.count(); ++n) {
        const auto& place = star.places()[n];
        if (place.node != grid::TreeNodes<2>::none) {
            stencil->add(place.node, mean.weight(n));
        } else {
            stencil->add(place.value, mean.weight(n));
        }
    }
    return stencil;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
