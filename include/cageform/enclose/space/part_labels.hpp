// Order, hierarchy and adjacency of the parts of a cage.
#pragma once

#include <cageform/cage/detail/indices.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <queue>
#include <span>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Order of part numbers: 1, 2, -2, 3, -3, …
inline bool part_precedes(int a, int b) noexcept {
    return std::abs(a) != std::abs(b) ? std::abs(a) < std::abs(b) : a > b;
}

/// Numbers parts 1, 2, … by decreasing area; mirrored parts get n and -n.
///
///   images    mirror image of each part, or the part itself
///   moments   moment about the mirror plane; the part with the larger moment gets n
///   is_trunk  is_trunk(n): whether part n may be number 1; the largest such part becomes number 1
template <class IsTrunk>
std::vector<int> part_numbers(std::span<const double> areas, std::span<const std::size_t> images,
                              std::span<const double> moments, IsTrunk is_trunk) {
    const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
    const auto rank = [&](std::size_t n) { // areas of images differ by rounding
        return std::round(areas[n] / total * 1e9);
    };
    auto order = first_indices<std::size_t>(areas.size());
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t p, std::size_t q) { return rank(p) > rank(q); });
    const auto trunk = std::find_if(order.begin(), order.end(), is_trunk);
    if (trunk != order.end()) std::rotate(order.begin(), trunk, trunk + 1);
    std::vector<int> numbers(areas.size(), 0);
    int next = 1;
    for (const std::size_t n : order) {
        if (numbers[n] != 0) continue;
        numbers[n] = next++;
        const std::size_t image = images[n];
        if (image == n) continue;
        numbers[image] = -numbers[n];
        if (moments[n] < moments[image]) std::swap(numbers[n], numbers[image]);
    }
    return numbers;
}

/// Hierarchy of parts.
class PartTree {
public:
    static constexpr std::size_t none = ~std::size_t{0};

    ///   names  part numbers, sorted by part_precedes
    ///   pairs  pairs of adjacent parts, in both orders, one entry per common edge; sorted
    PartTree(std::span<const int> names, std::span<const std::array<std::size_t, 2>> pairs)
        : mirrored_(names.size(), none)
        , adjacent_(names.size())
        , max_edges_(names.size())
        , parent_(names.size(), none)
        , depth_(names.size())
        , in_tree_(names.size()) {
        for (std::size_t p = 0; p + 1 < names.size(); ++p) {
            if (names[p] != -names[p + 1]) continue;
            mirrored_[p] = p + 1;
            mirrored_[p + 1] = p;
        }
        for (std::size_t n = 0; n < pairs.size();) {
            const auto [to, from] = pairs[n];
            std::size_t edges = 0;
            for (; n < pairs.size() && pairs[n] == std::array{to, from}; ++n) ++edges;
            if (from == mirrored_[to]) edges = 0;
            adjacent_[to].push_back({edges, from, to});
            max_edges_[to] = (std::max)(max_edges_[to], edges);
        }
        for (std::size_t start = 0; start < names.size(); ++start) {
            if (in_tree_[start]) continue;
            for (std::vector<std::size_t> added{start}; !added.empty();) {
                auto next = attach_strong_neighbours(added);
                if (next.empty()) next = attach_strongest();
                added = std::move(next);
            }
        }
    }

    std::size_t parent(std::size_t p) const noexcept { return parent_[p]; }
    /// Lowest common ancestor.
    std::size_t common_ancestor(std::size_t p, std::size_t q) const noexcept {
        while (p != q) {
            if (depth_[p] < depth_[q]) std::swap(p, q);
            if (parent_[p] == none) return (std::min)(p, q); // different trees
            p = parent_[p];
        }
        return p;
    }

private:
    struct Link {
        std::size_t edges, from, to;
        bool operator<(const Link& other) const noexcept { // the queue pops the greatest
            if (edges != other.edges) return edges < other.edges;
            return to != other.to ? to > other.to : from > other.from;
        }
    };

    /// Adds parts to the tree. Attaches adjacent parts whose common edges suffice, and returns these.
    std::vector<std::size_t> attach_strong_neighbours(const std::vector<std::size_t>& added) {
        for (const std::size_t p : added) in_tree_[p] = true;
        std::vector<std::size_t> next;
        for (const std::size_t p : added) {
            for (const Link& link : adjacent_[p]) {
                const Link back{link.edges, p, link.from};
                if (in_tree_[back.to]) continue;
                links_.push(back);
                if (back.edges > 0 && 3 * back.edges >= 2 * max_edges_[back.to]) next.push_back(back.to);
            }
        }
        sort_unique(next);
        for (const std::size_t p : next) {
            Link best{0, none, p};
            for (const Link& link : adjacent_[p]) {
                if (in_tree_[link.from] && link.edges > best.edges) best = link;
            }
            attach(best);
        }
        return next;
    }
    std::vector<std::size_t> attach_strongest() {
        std::vector<std::size_t> next;
        for (std::size_t edges = 0; !links_.empty(); links_.pop()) {
            const Link link = links_.top();
            if (in_tree_[link.to] || std::find(next.begin(), next.end(), link.to) != next.end()) continue;
            if (!next.empty() && (link.edges == 0 || link.edges != edges)) break;
            edges = link.edges;
            attach(link);
            next.push_back(link.to);
        }
        return next;
    }
    void attach(const Link& link) {
        std::size_t from = link.from;
        const auto has_as_many = [&](const Link& other) {
            return other.from == mirrored_[from] && other.edges == link.edges;
        };
        while (parent_[from] != none && mirrored_[from] != none &&
               std::any_of(adjacent_[link.to].begin(), adjacent_[link.to].end(), has_as_many))
            from = parent_[from];
        parent_[link.to] = from;
        depth_[link.to] = depth_[from] + 1;
    }

    std::vector<std::size_t> mirrored_;       ///< index of -n
    std::vector<std::vector<Link>> adjacent_; ///< links to each part from adjacent parts
    std::vector<std::size_t> max_edges_;      ///< maximum of common edges with another part
    std::vector<std::size_t> parent_, depth_;
    std::vector<bool> in_tree_;       ///< parts in the tree
    std::priority_queue<Link> links_; ///< links from parts in the tree
};

/// Returns the pairs of adjacent parts, in both orders, one entry per common edge; sorted.
///
///   part  of each face
template <class Faces>
std::vector<std::array<std::size_t, 2>> adjacent_parts(const Faces& faces,
                                                       std::span<const std::size_t> part) {
    std::vector<std::array<std::size_t, 3>> edges; // two vertices, and the part of a face there
    for (std::size_t f = 0; f < part.size(); ++f) {
        const std::size_t size = std::size(faces[f]);
        for (std::size_t k = 0; k < size; ++k) {
            const auto [a, b] =
                std::minmax({std::size_t(faces[f][k]), std::size_t(faces[f][(k + 1) % size])});
            edges.push_back({a, b, part[f]});
        }
    }
    std::sort(edges.begin(), edges.end());
    std::vector<std::array<std::size_t, 2>> pairs;
    for (std::size_t e = 1; e < edges.size(); ++e) {
        const auto& [a, b, p] = edges[e];
        const auto& [c, d, q] = edges[e - 1];
        if (a == c && b == d && p != q) pairs.insert(pairs.end(), {{p, q}, {q, p}});
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
