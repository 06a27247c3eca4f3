// A boundary laid into a lattice where it is: its crossings with the lattice lines decide which nodes are inside, and
// give every link that ends on the boundary its length and its data. Knows no cage and no solver.
#pragma once

#include <cageform/grid/detail/hierarchy.hpp>
#include <cageform/grid/grid_boundary.hpp>

#include <limits>

namespace cageform::inline CAGEFORM_ABI {

template <std::size_t D>
void sort_along_lines(std::vector<Crossing<D>>& crossings) {
    std::sort(crossings.begin(), crossings.end(), [](const Crossing<D>& a, const Crossing<D>& b) {
        return a.line != b.line ? a.line < b.line : a.position < b.position;
    });
}

/// The unknown nodes of a boundary value problem and their links to the data.
template <std::size_t D>
struct EmbeddedProblem {
    NodeRuns<D> nodes;
    std::vector<CutLink> cuts;            ///< sorted by node
    std::vector<BoundaryValue<D>> values; ///< parallel to `cuts`
};

namespace detail {

/// The node at `x` on a line along `axis`. Lines along axis 0 are rows.
template <std::size_t D>
typename NodeRuns<D>::Index on_line(const typename NodeRuns<D>::Index& size, std::size_t axis,
                                    std::uint32_t line, std::int32_t x) noexcept {
    typename NodeRuns<D>::Index index{};
    for (std::size_t k = 0; k < D; ++k) {
        if (k == axis) {
            index[k] = x;
            continue;
        }
        index[k] = std::int32_t(line % std::uint32_t(size[k]));
        line /= std::uint32_t(size[k]);
    }
    return index;
}

/// f(before, after) for neighbouring crossings of a line with the inside between them.
template <std::size_t D, class F>
void for_each_inner_interval(const std::vector<Crossing<D>>& crossings, F&& f) {
    bool inside = false;
    for (std::size_t i = 0; i < crossings.size(); ++i) {
        if (i > 0 && crossings[i].line == crossings[i - 1].line) {
            if (inside) f(crossings[i - 1], crossings[i]);
        } else {
            inside = false;
        }
        inside = inside != crossings[i].turns;
    }
}
/// The nodes strictly between two crossings: [first, second).
template <std::size_t D>
std::pair<std::int32_t, std::int32_t> nodes_between(const Crossing<D>& a, const Crossing<D>& b) noexcept {
    return {std::int32_t(std::floor(a.position + on_boundary_distance)) + 1,
            std::int32_t(std::ceil(b.position - on_boundary_distance))};
}

} // namespace detail

/// Which handles the grid sees: those with data on a link of some inner node.
template <std::size_t D>
std::vector<bool> seen_handles(const Crossings<D>& crossings, std::size_t handles) {
    std::vector<bool> seen(handles);
    const auto see = [&](const BoundaryValue<D>& value) {
        for (std::size_t n = 0; n < BoundaryValue<D>::most; ++n) {
            if (value.weight[n] > 0) seen[value.handle[n]] = true;
        }
    };
    for (const auto& along : crossings) {
        detail::for_each_inner_interval<D>(along, [&](const Crossing<D>& a, const Crossing<D>& b) {
            const auto [begin, end] = detail::nodes_between(a, b);
            if (begin >= end) return;
            see(a.value);
            see(b.value);
        });
    }
    return seen;
}

/// Nodes inside by the even-odd rule along axis 0, links cut along all axes.
///
///   crossings  those of the boundary
///   cost       O(#crossings log #crossings + #rows); nodes outside cost nothing
template <EmbeddableBoundary B>
EmbeddedProblem<B::dimension> embed(const B& boundary, const Crossings<B::dimension>& crossings) {
    constexpr std::size_t D = B::dimension;
    using Index = typename NodeRuns<D>::Index;
    const Index size = boundary.lattice().counts();
    const auto fixed = boundary.fixed_nodes();
    EmbeddedProblem<D> problem;
    NodeRuns<D> nodes(size);

    // Nodes on the boundary as the other axes' lines see it, by row and x; and those fixed.
    using Place = std::pair<std::uint32_t, std::int32_t>;
    std::vector<Place> dropped;
    std::vector<std::pair<Place, std::size_t>> given;
    for (std::size_t n = 0; n < fixed.size(); ++n) {
        dropped.push_back({std::uint32_t(nodes.row(fixed[n].index)), fixed[n].index[0]});
        given.push_back({dropped.back(), n});
    }
    std::sort(given.begin(), given.end());
    for (std::size_t axis = 1; axis < D; ++axis) {
        for (const auto& crossing : crossings[axis]) {
            const double x = std::round(crossing.position);
            if (std::fabs(crossing.position - x) > on_boundary_distance) continue;
            const Index index = detail::on_line<D>(size, axis, crossing.line, std::int32_t(x));
            dropped.push_back({std::uint32_t(nodes.row(index)), index[0]});
        }
    }
    std::sort(dropped.begin(), dropped.end());

    std::size_t row = 0;
    auto drop = dropped.begin();
    detail::for_each_inner_interval<D>(crossings[0], [&](const Crossing<D>& a, const Crossing<D>& b) {
        for (; row < a.line; ++row) nodes.end_row();
        auto [x, end] = detail::nodes_between(a, b);
        x = std::max(x, 0);
        end = std::min(end, size[0]);
        while (drop != dropped.end() && *drop < std::pair(a.line, x)) ++drop;
        for (; drop != dropped.end() && *drop < std::pair(a.line, end); ++drop) {
            nodes.add_run(x, drop->second);
            x = drop->second + 1;
        }
        nodes.add_run(x, end);
    });
    for (; row < nodes.rows(); ++row) nodes.end_row();

    struct Cut {
        CutLink link;
        BoundaryValue<D> value;
    };
    std::vector<Cut> cuts;
    for (std::size_t axis = 0; axis < D; ++axis) {
        for (const auto& crossing : crossings[axis]) {
            const double near = std::round(crossing.position);
            const bool on_node = std::fabs(crossing.position - near) <= on_boundary_distance;
            const auto below = std::int32_t(on_node ? near - 1 : std::floor(crossing.position));
            const std::int32_t above = on_node ? below + 2 : below + 1;
            const auto cut = [&](std::int32_t x, bool up, double theta) {
                const auto node = nodes.find(detail::on_line<D>(size, axis, crossing.line, x));
                if (node == NodeRuns<D>::none) return;
                const auto direction = std::uint8_t(2 * axis + (up ? 1 : 0));
                cuts.push_back({{node, direction, 1 / theta}, crossing.value});
            };
            cut(below, true, on_node ? 1.0 : crossing.position - double(below));
            cut(above, false, on_node ? 1.0 : double(above) - crossing.position);
        }
    }
    // The nearest crossing of a link is the one that counts.
    const auto before = [](const Cut& a, const Cut& b) {
        if (a.link.node != b.link.node) return a.link.node < b.link.node;
        if (a.link.direction != b.link.direction) return a.link.direction < b.link.direction;
        return a.link.weight > b.link.weight;
    };
    std::sort(cuts.begin(), cuts.end(), before);
    const auto same = [](const Cut& a, const Cut& b) {
        return a.link.node == b.link.node && a.link.direction == b.link.direction;
    };
    cuts.erase(std::unique(cuts.begin(), cuts.end(), same), cuts.end());

    // Links to nodes that are no unknowns, without a crossing: fixed ones, or the axes disagree by rounding.
    std::vector<Cut> missing;
    const auto is_cut = [&](std::uint32_t node, std::size_t direction) {
        const Cut key{{node, std::uint8_t(direction), std::numeric_limits<double>::infinity()}, {}};
        const auto at = std::lower_bound(cuts.begin(), cuts.end(), key, before);
        return at != cuts.end() && same(*at, key);
    };
    nodes.for_each_end([&](const Index& index, std::uint32_t node, std::size_t direction) {
        if (is_cut(node, direction)) return;
        Index there = index;
        there[direction / 2] += (direction & 1) != 0 ? 1 : -1;
        const Place place{std::uint32_t(nodes.row(there)), there[0]};
        const auto at = std::lower_bound(given.begin(), given.end(), std::pair{place, std::size_t{0}});
        const bool known = at != given.end() && at->first == place;
        missing.push_back({{node, std::uint8_t(direction), 1.0},
                           known ? fixed[at->second].value : boundary.nearest(there)});
    });
    cuts.insert(cuts.end(), missing.begin(), missing.end());
    std::sort(cuts.begin(), cuts.end(), before);

    problem.nodes = std::move(nodes);
    for (const Cut& cut : cuts) {
        problem.cuts.push_back(cut.link);
        problem.values.push_back(cut.value);
    }
    return problem;
}

} // namespace cageform::inline CAGEFORM_ABI
