// Triangles in a flat index buffer, as engines keep them.
#pragma once

#include <cageform/core/vec.hpp>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <type_traits>
#include <utility>

namespace cageform::inline CAGEFORM_ABI {

/// Stands for the index of a vertex that does not exist.
inline constexpr std::uint32_t no_vertex = ~std::uint32_t{0};

/// A view of triangles over a flat index buffer, three indices a face. Owns nothing and copies nothing.
template <std::integral I>
    requires(sizeof(I) <= sizeof(std::uint32_t))
class FlatFaces {
public:
    constexpr FlatFaces(const I* indices, std::size_t count) noexcept
        : indices_(indices)
        , count_(count) {}

    constexpr std::size_t size() const noexcept { return (count_ + 2) / 3; }

    /// Negative indices are far beyond every vertex; so are those that the last face lacks where there
    /// is no multiple of three.
    constexpr std::array<std::uint32_t, 3> operator[](std::size_t face) const noexcept {
        std::array<std::uint32_t, 3> corners{no_vertex, no_vertex, no_vertex};
        for (std::size_t k = 0; k < 3 && 3 * face + k < count_; ++k)
            corners[k] = static_cast<std::uint32_t>(indices_[3 * face + k]);
        return corners;
    }

private:
    const I* indices_;
    std::size_t count_;
};

/// The triangles of a flat index buffer, for all that takes faces: `TriangleMesh(points, faces_of(indices))`.
///
///   indices  whole numbers of 32 bits at most that lie side by side, three a face; they have to outlive
///            the view. A count that is no multiple of three gives a last face that lacks a vertex, which
///            `check` and all that takes meshes refuse by its number, as they do an index that no vertex has
template <class R>
    requires std::integral<std::remove_cvref_t<decltype(*std::data(std::declval<const R&>()))>>
constexpr auto faces_of(const R& indices) noexcept {
    return FlatFaces(std::data(indices), std::size(indices));
}

} // namespace cageform::inline CAGEFORM_ABI
