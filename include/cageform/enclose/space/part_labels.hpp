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
///   returns   the first part in the order above is the first of the tree. The others follow: of all pairs of
///             a part in the tree and one that is not, the pair with the most edges in common is next
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
    struct Link {
        std::size_t edges, from, to;
        bool operator<(const Link& other) const noexcept { // the greatest is taken first
            if (edges != other.edges) return edges < other.edges;
            return to != other.to ? to > other.to : from > other.from;
        }
    };
    std::vector<std::size_t> parent(count, none), depth(count);
    std::vector<bool> in_tree(count);
    std::priority_queue<Link> links;
    const auto add = [&](std::size_t p) {
        in_tree[p] = true;
        auto at = std::lower_bound(pairs.begin(), pairs.end(), std::array<std::size_t, 2>{p, 0});
        while (at != pairs.end() && (*at)[0] == p) {
            const auto end = std::find_if(at, pairs.end(), [&](const auto& pair) { return pair != *at; });
            links.push({std::size_t(end - at), p, (*at)[1]});
            at = end;
        }
    };
    for (std::size_t start = 0; start < count; ++start) {
        if (!in_tree[start]) add(start);
        while (!links.empty()) {
            const Link link = links.top();
            links.pop();
            if (in_tree[link.to]) continue;
            parent[link.to] = link.from;
            depth[link.to] = depth[link.from] + 1;
            add(link.to);
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
