// The parts of a cage in space.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A part of a cage: the trunk, a limb, a head.
struct CagePart {
    int number = 1; ///< the trunk is 1; mirror images share a number, one of them with a minus
    int parent = 0; ///< the part that it hangs on; 0: none
    std::vector<std::uint32_t> vertices; ///< ascending; without those of parts that hang on it
    /// The vertices of the loop by which it hangs on its parent, ascending; none of them is its own. Turn the
    /// part about their mean.
    std::vector<std::uint32_t> joint;
};

/// The parts of a cage. They form a tree, or in a cage of several shells one tree each.
struct CageParts {
    std::vector<CagePart> parts; ///< by number: 1, 2, -2, 3, …
    std::vector<int> of_face;    ///< #faces
    /// #vertices. Where several parts meet, a vertex belongs to the part that the others hang on.
    std::vector<int> of_vertex;

    /// Returns the part of a number; null where there is none.
    const CagePart* find(int number) const noexcept {
        for (const CagePart& part : parts) {
            if (part.number == number) return &part;
        }
        return nullptr;
    }
    /// Returns the vertices that move with a part, ascending: its own, and those of parts that hang on it.
    /// The first part of a tree, which hangs on none, moves alone.
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
