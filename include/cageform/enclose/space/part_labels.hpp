// The parts of a cage from the numbers of its faces.
#pragma once

#include <cageform/enclose/types/cage_parts.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <queue>
#include <span>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// 1, 2, -2, 3, -3, …
inline bool part_precedes(int a, int b) noexcept {
    return std::abs(a) != std::abs(b) ? std::abs(a) < std::abs(b) : a > b;
}

/// Numbers for parts: 1, 2, … by decreasing area, and n and -n for a part and its image.
///
///   images    of each part its image by a mirror, or itself
///   right     how far it lies where the coordinate is larger; n is the image that lies farther there
///   is_trunk  of part n, whether it may be number 1; the largest that may is, if there is any
template <class IsTrunk>
std::vector<int> part_numbers(std::span<const double> areas, std::span<const std::size_t> images,
                              std::span<const double> right, IsTrunk is_trunk) {
    const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
    const auto rank = [&](std::size_t n) { // the areas of images differ by rounding
        return std::round(areas[n] / total * 1e9);
    };
    std::vector<std::size_t> order(areas.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
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
        if (right[n] < right[image]) std::swap(numbers[n], numbers[image]);
    }
    return numbers;
}

/// Which of some parts hang on which.
class PartTree {
public:
    static constexpr std::size_t none = ~std::size_t{0};

    /// names   of the parts, in the order above
    /// pairs   of parts that have an edge in common, both ways, one for each edge; sorted
    PartTree(std::span<const int> names, std::span<const std::array<std::size_t, 2>> pairs)
        : opposite_(names.size(), none)
        , beside_(names.size())
        , most_(names.size())
        , parent_(names.size(), none)
        , depth_(names.size())
        , has_(names.size()) {
        for (std::size_t p = 0; p + 1 < names.size(); ++p) {
            if (names[p] != -names[p + 1]) continue;
            opposite_[p] = p + 1;
            opposite_[p + 1] = p;
        }
        for (std::size_t n = 0; n < pairs.size();) {
            const auto [to, from] = pairs[n];
            std::size_t edges = 0;
            for (; n < pairs.size() && pairs[n] == std::array{to, from}; ++n) ++edges;
            if (from == opposite_[to]) edges = 0;
            beside_[to].push_back({edges, from, to});
            most_[to] = (std::max)(most_[to], edges);
        }
        for (std::size_t start = 0; start < names.size(); ++start) {
            if (has_[start]) continue;
            for (std::vector<std::size_t> added{start}; !added.empty();) {
                auto next = those_that_will_do(added);
                if (next.empty()) next = those_with_most_edges();
                added = std::move(next);
            }
        }
    }

    std::size_t parent(std::size_t p) const noexcept { return parent_[p]; }
    /// The part from which the ways down to both begin.
    std::size_t above_both(std::size_t p, std::size_t q) const noexcept {
        while (p != q) {
            if (depth_[p] < depth_[q]) std::swap(p, q);
            if (parent_[p] == none) return (std::min)(p, q); // of two trees
            p = parent_[p];
        }
        return p;
    }

private:
    struct Link {
        std::size_t edges, from, to;
        bool operator<(const Link& other) const noexcept { // the greatest is taken first
            if (edges != other.edges) return edges < other.edges;
            return to != other.to ? to > other.to : from > other.from;
        }
    };

    /// Adds parts to the tree, and hangs those beside them that have enough edges in common with it.
    std::vector<std::size_t> those_that_will_do(const std::vector<std::size_t>& added) {
        for (const std::size_t p : added) has_[p] = true;
        std::vector<std::size_t> next;
        for (const std::size_t p : added) {
            for (const Link& link : beside_[p]) {
                const Link back{link.edges, p, link.from};
                if (has_[back.to]) continue;
                links_.push(back);
                if (back.edges > 0 && 3 * back.edges >= 2 * most_[back.to]) next.push_back(back.to);
            }
        }
        std::sort(next.begin(), next.end());
        next.erase(std::unique(next.begin(), next.end()), next.end());
        for (const std::size_t p : next) {
            Link best{0, none, p};
            for (const Link& link : beside_[p]) {
                if (has_[link.from] && link.edges > best.edges) best = link;
            }
            hang(best);
        }
        return next;
    }
    std::vector<std::size_t> those_with_most_edges() {
        std::vector<std::size_t> next;
        for (std::size_t edges = 0; !links_.empty(); links_.pop()) {
            const Link link = links_.top();
            if (has_[link.to] || std::find(next.begin(), next.end(), link.to) != next.end()) continue;
            if (!next.empty() && (link.edges == 0 || link.edges != edges)) break;
            edges = link.edges;
            hang(link);
            next.push_back(link.to);
        }
        return next;
    }
    void hang(const Link& link) {
        std::size_t from = link.from;
        const auto has_as_many = [&](const Link& other) {
            return other.from == opposite_[from] && other.edges == link.edges;
        };
        while (parent_[from] != none && opposite_[from] != none &&
               std::any_of(beside_[link.to].begin(), beside_[link.to].end(), has_as_many))
            from = parent_[from];
        parent_[link.to] = from;
        depth_[link.to] = depth_[from] + 1;
    }

    std::vector<std::size_t> opposite_;     ///< n of -n
    std::vector<std::vector<Link>> beside_; ///< to each part, by the other part
    std::vector<std::size_t> most_;         ///< edges in common with another part
    std::vector<std::size_t> parent_, depth_;
    std::vector<bool> has_;           ///< whether the tree has it
    std::priority_queue<Link> links_; ///< from parts in the tree
};

/// Pairs of parts, one for each edge between them, and both ways; sorted. `part` of each face.
template <class Faces>
std::vector<std::array<std::size_t, 2>> pairs_of_parts(const Faces& faces,
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
