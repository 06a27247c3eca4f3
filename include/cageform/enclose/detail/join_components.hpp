// make_cage, step 2: connects separate components by bridges and closes gaps too narrow to deform.
#pragma once

#include <cageform/core/detail/disjoint_sets.hpp>
#include <cageform/enclose/detail/distance_lattice.hpp>

#include <limits>
#include <map>
#include <tuple>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Connected components of the nodes that are not outside; diagonal neighbours are connected.
struct LatticeComponents {
    static constexpr std::uint32_t none = ~std::uint32_t{0};
    std::vector<std::uint32_t> of_node; ///< component of each node; `none` outside
    std::size_t count = 0;

    template <std::size_t D>
    LatticeComponents(const DistanceLattice<D>& lattice, const std::vector<std::uint8_t>& outside)
        : of_node(lattice.size(), none) {
        std::vector<std::size_t> front;
        for (std::size_t start = 0; start < lattice.size(); ++start) {
            const auto enter = [&](std::size_t node) {
                if (outside[node] != 0 || of_node[node] != none) return;
                of_node[node] = static_cast<std::uint32_t>(count);
                front.push_back(node);
            };
            enter(start);
            if (front.empty()) continue;
            while (!front.empty()) {
                const std::size_t node = front.back();
                front.pop_back();
                lattice.for_each_adjacent(node, enter);
            }
            ++count;
        }
    }
};

/// Returns the (nearly) nearest node with is_source(node) for each node; lattice.size() if there is no
/// source. Sweeps the lattice; each node takes the best source of its neighbours (Danielsson, Euclidean
/// distance mapping, 1980).
template <std::size_t D, class Test>
std::vector<std::size_t> nearest_sources(const DistanceLattice<D>& lattice, const Test& is_source) {
    const std::size_t none = lattice.size();
    std::vector<std::size_t> nearest(lattice.size(), none);
    for (std::size_t node = 0; node < lattice.size(); ++node) {
        if (is_source(node)) nearest[node] = node;
    }
    const auto update = [&](std::size_t node) {
        std::size_t& found = nearest[node];
        if (found == node) return; // a source
        double least =
            found != none ? lattice.squared_steps(found, node) : std::numeric_limits<double>::infinity();
        lattice.for_each_adjacent(node, [&](std::size_t other) {
            const std::size_t candidate = nearest[other];
            if (candidate == none || candidate == found) return; // most common case
            const double squared_steps = lattice.squared_steps(candidate, node);
            if (!(squared_steps < least)) return;
            least = squared_steps;
            found = candidate;
        });
    };
    for (int pass = 0; pass < 2; ++pass) {
        for (std::size_t node = 0; node < lattice.size(); ++node) update(node);
        for (std::size_t node = lattice.size(); node-- > 0;) update(node);
    }
    return nearest;
}

/// Two nodes of different components and their squared distance in spacings.
struct Bridge {
    double squared_steps;
    std::size_t from, to;
};

/// Bridges of a minimum spanning tree over the components, by Kruskal's algorithm. Each node belongs to the
/// region of its nearest component. The edges are the shortest bridges found between components with adjacent
/// regions.
template <std::size_t D>
std::vector<Bridge> shortest_bridges(const DistanceLattice<D>& lattice, const LatticeComponents& components) {
    const auto nearest = nearest_sources(
        lattice, [&](std::size_t node) { return components.of_node[node] != LatticeComponents::none; });
    std::map<std::pair<std::uint32_t, std::uint32_t>, Bridge> between;
    for (std::size_t node = 0; node < lattice.size(); ++node) {
        lattice.for_each_neighbour(node, [&](std::size_t other) {
            if (other < node) return;
            std::size_t from = nearest[node], to = nearest[other];
            if (components.of_node[from] == components.of_node[to]) return;
            if (components.of_node[from] > components.of_node[to]) std::swap(from, to);
            const Bridge bridge{lattice.squared_steps(from, to), from, to};
            const auto [entry, is_new] =
                between.try_emplace({components.of_node[from], components.of_node[to]}, bridge);
            if (!is_new && bridge.squared_steps < entry->second.squared_steps) entry->second = bridge;
        });
    }
    std::vector<Bridge> bridges;
    bridges.reserve(between.size());
    for (const auto& [pair, bridge] : between) bridges.push_back(bridge);
    std::sort(bridges.begin(), bridges.end(), [](const Bridge& a, const Bridge& b) {
        return std::tuple(a.squared_steps, a.from, a.to) < std::tuple(b.squared_steps, b.from, b.to);
    });
    DisjointSets joined(components.count);
    std::erase_if(bridges, [&](const Bridge& bridge) {
        return !joined.join(components.of_node[bridge.from], components.of_node[bridge.to]);
    });
    return bridges;
}

/// Adds bridges (capsules) until the figure has one component, in at most eight rounds. With `mirrored`, also
/// adds the images of the bridges. Returns the number of bridges without images.
///
///   components  of the lattice before the call
template <std::size_t D>
std::size_t join_components(DistanceLattice<D>& lattice, LatticeComponents components, double margin,
                            bool mirrored) {
    std::size_t count = 0;
    for (int round = 0; round < 8 && components.count > 1; ++round) {
        for (const auto& bridge : shortest_bridges(lattice, components)) {
            auto a = lattice.position(bridge.from), b = lattice.position(bridge.to);
            const auto u = (margin / length(b - a)) * (b - a);
            a = a - u;
            b = b + u;
            lattice.add_capsule(a, b, 1.3 * margin, 2 * margin);
            ++count;
        }
        if (mirrored) lattice.mirror();
        components = {lattice, lattice.outside(0)};
    }
    return count;
}

/// Morphological closing by discs or balls (Serra, Image analysis and mathematical morphology, 1982): points
/// that no disc of this radius reaches from outside become inside. With `holes`, discs may also start in
/// holes.
template <std::size_t D>
void close_slits(DistanceLattice<D>& lattice, double radius, bool holes) {
    std::vector<std::uint8_t> outside = lattice.outside(static_cast<float>(radius));
    if (holes) {
        for (std::size_t node = 0; node < lattice.size(); ++node)
            outside[node] = double(lattice[node]) > radius;
    }
    // Squared distance from the positions that a disc's centre can reach.
    const double reach = radius + lattice.spacing();
    std::vector<float> free2(lattice.size(), static_cast<float>(reach * reach));
    const auto h = static_cast<float>(lattice.spacing());
    for (std::size_t node = 0; node < lattice.size(); ++node) {
        if (outside[node] == 0) continue;
        lattice.for_each_neighbour(node, [&](std::size_t other) {
            if (outside[other] != 0) return;
            const double f = double(lattice[node]), g = double(lattice[other]);
            const double t = std::clamp((f - radius) / (f - g), 0.0, 1.0);
            const auto p = (1 - t) * lattice.position(node) + t * lattice.position(other);
            const auto box = bounds_of(std::span(&p, 1)).widened(reach);
            lattice.for_each_row(box, [&](std::size_t row, std::size_t first, std::size_t last) {
                auto d = vec_cast<float>(lattice.position(row) - p);
                const float from = d[0];
                d[0] = 0;
                const float across2 = dot(d, d);
                for (std::size_t i = first; i < last; ++i) {
                    const float along = from + h * static_cast<float>(i);
                    free2[row + i] = (std::min)(free2[row + i], across2 + along * along);
                }
            });
        });
    }
    for (std::size_t node = 0; node < lattice.size(); ++node) {
        if (outside[node] == 0)
            lattice[node] = (std::min)(lattice[node], static_cast<float>(radius) - std::sqrt(free2[node]));
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail
