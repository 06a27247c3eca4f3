// Parts of a 3D cage.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A part of a cage: the trunk, a limb, a head.
struct CagePart {
    int number = 1;                      ///< 1: trunk; mirrored parts are n and -n
    int parent = 0;                      ///< number of the part that it is attached to; 0: none
    std::vector<std::uint32_t> vertices; ///< ascending; without the vertices of attached parts
    /// Vertices of the loop that separates this part from its parent, ascending. They belong to the parent or
    /// to another ancestor. Use their mean as the pivot.
    std::vector<std::uint32_t> joint;
};

/// Parts of a cage: one tree per shell.
struct CageParts {
    std::vector<CagePart> parts; ///< sorted by number: 1, 2, -2, 3, …
    std::vector<int> of_face;    ///< #faces
    /// #vertices. A vertex shared by several parts belongs to their common ancestor.
    std::vector<int> of_vertex;

    /// Returns the part with a number; null if there is none.
    const CagePart* find(int number) const noexcept {
        for (const CagePart& part : parts) {
            if (part.number == number) return &part;
        }
        return nullptr;
    }
    /// Returns the vertices that move with a part, ascending: those of the part and of its descendants. For a
    /// root, these are only its own vertices.
    std::vector<std::uint32_t> moved_with(int number) const {
        const auto hangs = [&](int other) {
            for (const CagePart* part = find(other); part != nullptr; part = find(part->parent)) {
                if (part->number == number) return part->parent != 0 || other == number;
            }
            return false;
        };
        std::vector<bool> moves(parts.size());
        for (std::size_t n = 0; n < parts.size(); ++n) moves[n] = hangs(parts[n].number);
        std::vector<std::uint32_t> list;
        for (std::size_t v = 0; v < of_vertex.size(); ++v) {
            for (std::size_t n = 0; n < parts.size(); ++n) {
                if (moves[n] && parts[n].number == of_vertex[v]) list.push_back(std::uint32_t(v));
            }
        }
        return list;
    }
};

} // namespace cageform::inline CAGEFORM_ABI
