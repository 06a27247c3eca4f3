// The tree of the parts of a cage whose faces have the numbers of their parts.
#pragma once

#include <cageform/enclose/space/part_labels.hpp>
#include <cageform/enclose/types/cage_parts.hpp>

namespace cageform::inline CAGEFORM_ABI {

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
    std::sort(names.begin(), names.end(), detail::part_precedes);
    names.erase(std::unique(names.begin(), names.end()), names.end());
    std::vector<std::size_t> part(numbers.size());
    for (std::size_t f = 0; f < part.size(); ++f)
        part[f] = std::size_t(
            std::lower_bound(names.begin(), names.end(), numbers[f], detail::part_precedes) - names.begin());
    constexpr std::size_t none = detail::PartTree::none;
    const detail::PartTree tree(names, detail::pairs_of_parts(faces, part));
    for (std::size_t p = 0; p < names.size(); ++p)
        found.parts.push_back({names[p], tree.parent(p) == none ? 0 : names[tree.parent(p)], {}, {}});
    std::vector<std::array<std::size_t, 2>> corners; // a vertex, and the part of a face there
    for (std::size_t f = 0; f < part.size(); ++f) {
        for (const auto v : faces[f]) corners.push_back({std::size_t(v), part[f]});
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    std::vector<std::size_t> of(vertices, none);
    for (const auto& [v, p] : corners) of[v] = of[v] == none ? p : tree.above_both(of[v], p);
    for (const auto& [v, p] : corners) { // is on the joints of all parts from there down to its faces
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
