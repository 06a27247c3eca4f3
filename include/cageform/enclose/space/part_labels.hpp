// The parts of a cage from the numbers of its faces.
#pragma once

#include <cageform/enclose/types/cage_parts.hpp>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <queue>
#include <span>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// 1, 2, -2, 3, -3, …
inline bool part_precedes(int a, int b) noexcept {
    return std::abs(a) != std::abs(b) ? std::abs(a) < std::abs(b) : a > b;
}

/// Which parts hang on which, which vertices they have, and where their joints are.
///
///   faces     lists of vertices below `vertices`, of any length
///   numbers   #faces, none of them 0
///   returns   the first part in the order above is the first of the tree. A part hangs on the part in the
///             tree with which it has the most edges in common, as soon as these are two thirds of the most
///             that it has with any. Where it has as many with n as with -n, it hangs on what n hangs on.
///             Where no part can hang so, those with the most edges do; n and -n come last
template <class Faces>
CageParts parts_of_faces(const Faces& faces, std::size_t vertices, std::span<const int> numbers) {
    CageParts found;
    found.of_face.assign(numbers.begin(), numbers.end());
    std::vector<int> names = found.of_face;
    std::sort(names.begin(), names.end(), part_precedes);
    names.erase(std::unique(names.begin(), names.end()), names.end());
    const std::size_t count = names.size();
    std::vector<std::size_t> part(numbers.size());
    for (std::size_t f = 0; f < part.size(); ++f)
        part[f] = std::size_t(std::lower_bound(names.begin(), names.end(), numbers[f], part_precedes) -
                              names.begin());

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
    std::vector<std::array<std::size_t, 2>> pairs; // of parts, one for each edge between them, and both ways
    for (std::size_t e = 1; e < edges.size(); ++e) {
        const auto& [a, b, p] = edges[e];
        const auto& [c, d, q] = edges[e - 1];
        if (a == c && b == d && p != q) pairs.insert(pairs.end(), {{p, q}, {q, p}});
    }
    std::sort(pairs.begin(), pairs.end());

    constexpr std::size_t none = ~std::size_t{0};
    std::vector<std::size_t> opposite(count, none); // n and -n
    for (std::size_t p = 0; p + 1 < count; ++p) {
        if (names[p] != -names[p + 1]) continue;
        opposite[p] = p + 1;
        opposite[p + 1] = p;
    }
    struct Link {
        std::size_t edges, from, to;
        bool operator<(const Link& other) const noexcept { // the greatest is taken first
            if (edges != other.edges) return edges < other.edges;
            return to != other.to ? to > other.to : from > other.from;
        }
    };
    std::vector<std::vector<Link>> beside(count); // to each part, by the other part
    std::vector<std::size_t> most(count);         // edges in common with another part
    for (std::size_t n = 0; n < pairs.size();) {
        const auto [to, from] = pairs[n];
        std::size_t edges_between = 0;
        for (; n < pairs.size() && pairs[n] == std::array{to, from}; ++n) ++edges_between;
        if (from == opposite[to]) edges_between = 0;
        beside[to].push_back({edges_between, from, to});
        most[to] = (std::max)(most[to], edges_between);
    }
    const auto will_do = [&](const Link& link) {
        return link.edges > 0 && 3 * link.edges >= 2 * most[link.to];
    };
    std::vector<std::size_t> parent(count, none), depth(count);
    std::vector<bool> in_tree(count);
    const auto hang = [&](const Link& link) {
        std::size_t from = link.from;
        const auto has_as_many = [&](const Link& other) {
            return other.from == opposite[from] && other.edges == link.edges;
        };
        while (parent[from] != none && opposite[from] != none &&
               std::any_of(beside[link.to].begin(), beside[link.to].end(), has_as_many))
            from = parent[from];
        parent[link.to] = from;
        depth[link.to] = depth[from] + 1;
    };
    std::priority_queue<Link> links; // from parts in the tree
    for (std::size_t start = 0; start < count; ++start) {
        if (in_tree[start]) continue;
        for (std::vector<std::size_t> added{start}; !added.empty();) {
            for (const std::size_t p : added) in_tree[p] = true;
            std::vector<std::size_t> next;
            for (const std::size_t p : added) {
                for (const Link& link : beside[p]) {
                    const Link back{link.edges, p, link.from};
                    if (in_tree[back.to]) continue;
                    links.push(back);
                    if (will_do(back)) next.push_back(back.to);
                }
            }
            std::sort(next.begin(), next.end());
            next.erase(std::unique(next.begin(), next.end()), next.end());
            for (const std::size_t p : next) {
                Link best{0, none, p};
                for (const Link& link : beside[p]) {
                    if (in_tree[link.from] && link.edges > best.edges) best = link;
                }
                hang(best);
            }
            if (!next.empty()) {
                added = std::move(next);
                continue;
            }
            for (std::size_t edges_between = 0; !links.empty(); links.pop()) {
                const Link link = links.top();
                if (in_tree[link.to] || std::find(next.begin(), next.end(), link.to) != next.end()) continue;
                if (!next.empty() && (link.edges == 0 || link.edges != edges_between)) break;
                edges_between = link.edges;
                hang(link);
                next.push_back(link.to);
            }
            added = std::move(next);
        }
    }
    const auto above_both = [&](std::size_t p, std::size_t q) {
        while (p != q) {
            if (depth[p] < depth[q]) std::swap(p, q);
            if (parent[p] == none) return (std::min)(p, q); // of two trees
            p = parent[p];
        }
        return p;
    };

    for (std::size_t p = 0; p < count; ++p)
        found.parts.push_back({names[p], parent[p] == none ? 0 : names[parent[p]], {}, {}});
    std::vector<std::array<std::size_t, 2>> corners; // a vertex, and the part of a face there
    for (std::size_t f = 0; f < part.size(); ++f) {
        for (const auto v : faces[f]) corners.push_back({std::size_t(v), part[f]});
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    std::vector<std::size_t> of(vertices, none);
    for (const auto& [v, p] : corners) of[v] = of[v] == none ? p : above_both(of[v], p);
    for (const auto& [v, p] : corners) { // is on the joints of all parts from there down to its faces
        for (std::size_t q = p; q != of[v] && parent[q] != none; q = parent[q]) {
            auto& joint = found.parts[q].joint;
            if (joint.empty() || joint.back() != v) joint.push_back(std::uint32_t(v));
        }
    }
    for (std::size_t v = 0; v < vertices; ++v) {
        const std::size_t p = of[v] == none ? 0 : of[v];
        found.of_vertex.push_back(count == 0 ? 1 : names[p]);
        if (count != 0) found.parts[p].vertices.push_back(std::uint32_t(v));
    }
    return found;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
