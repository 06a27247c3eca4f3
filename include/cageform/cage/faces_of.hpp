// A view of an index buffer as triangles.
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

/// Replaces the index of a missing vertex.
inline constexpr std::uint32_t no_vertex = ~std::uint32_t{0};

/// A non-owning view of an index buffer as triangles, with three indices per face.
template <std::integral I>
    requires(sizeof(I) <= sizeof(std::uint32_t))
class FlatFaces {
public:
    constexpr FlatFaces(const I* indices, std::size_t count) noexcept
        : indices_(indices)
        , count_(count) {}

    constexpr std::size_t size() const noexcept { return (count_ + 2) / 3; }

    /// Returns the vertices of a face. Negative indices, and the missing indices of an incomplete last
    /// face, become numbers beyond every vertex.
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

/// Views an index buffer as triangles, for any function that takes faces: `TriangleMesh(points,
/// faces_of(indices))`.
///
///   indices  contiguous integers of at most 32 bits, three per face; they must outlive the view. If the
///            count is not a multiple of three, the last face lacks a vertex. `check` reports this like an
///            index out of range
template <class R>
    requires std::integral<std::remove_cvref_t<decltype(*std::data(std::declval<const R&>()))>>
constexpr auto faces_of(const R& indices) noexcept {
    return FlatFaces(std::data(indices), std::size(indices));
}

} // namespace cageform::inline CAGEFORM_ABI
