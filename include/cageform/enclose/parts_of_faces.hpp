// Builds the parts of a cage from the part number of each face.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/enclose/space/part_labels.hpp>
#include <cageform/enclose/types/cage_parts.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Determines the hierarchy, vertices and joints of parts.
///
///   faces    lists of vertices below `vertices`, of any length
///   numbers  #faces, never 0; order: 1, 2, -2, 3, -3, …
///   returns  the parts. The root of the tree is the first part in this order. Let m be the largest number of
///            edges that a part shares with another part (edges shared by n and -n do not count). The part is
///            added when it shares at least 2m/3 edges with a part in the tree. If there is no such part,
///            those that share most edges with a part in the tree are added. The parent is the part in the
///            tree with the most shared edges. If n and -n share equally many, it is the parent of n
template <class Faces>
CageParts parts_of_faces(const Faces& faces, std::size_t vertices, std::span<const int> numbers) {
    CageParts found;
    found.of_face.assign(numbers.begin(), numbers.end());
    std::vector<int> names = found.of_face;
    std::sort(names.begin(), names.end(), detail::part_precedes);
    names.erase(std::unique(names.begin(), names.end()), names.end());
    std::vector<std::size_t> part(numbers.size());
    for (std::size_t f = 0; f < part.size(); ++f)
        part[f] = std::size_t(
            std::lower_bound(names.begin(), names.end(), numbers[f], detail::part_precedes) - names.begin());
    constexpr std::size_t none = detail::PartTree::none;
    const detail::PartTree tree(names, detail::adjacent_parts(faces, part));
    for (std::size_t p = 0; p < names.size(); ++p)
        found.parts.push_back({names[p], tree.parent(p) == none ? 0 : names[tree.parent(p)], {}, {}});
    std::vector<std::array<std::size_t, 2>> corners; // a vertex, and the part of a face there
    for (std::size_t f = 0; f < part.size(); ++f) {
        for (const auto v : faces[f]) corners.push_back({std::size_t(v), part[f]});
    }
    detail::sort_unique(corners);
    std::vector<std::size_t> of(vertices, none);
    for (const auto& [v, p] : corners) of[v] = of[v] == none ? p : tree.common_ancestor(of[v], p);
    // A vertex of a face of part p is on the joint of p and of each ancestor of p below the vertex's own
    // part.
    for (const auto& [v, p] : corners) {
        for (std::size_t q = p; q != of[v] && tree.parent(q) != none; q = tree.parent(q)) {
            auto& joint = found.parts[q].joint;
            if (joint.empty() || joint.back() != v) joint.push_back(std::uint32_t(v));
        }
    }
    for (std::size_t v = 0; v < vertices; ++v) {
        const std::size_t p = of[v] == none ? 0 : of[v];
        found.of_vertex.push_back(names.empty() ? 1 : names[p]);
        if (!names.empty()) found.parts[p].vertices.push_back(std::uint32_t(v));
    }
    return found;
}

} // namespace cageform::inline CAGEFORM_ABI
