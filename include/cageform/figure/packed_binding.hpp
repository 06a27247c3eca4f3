// A packed binding: sparse, quantised and reordered weights in one relocatable block of memory.
//
// Points are stored in blocks (core/types/blocks.hpp). A block of a sparse binding has a row of weights
// for each handle that has a non-zero weight at any of its points; a block of a dense binding has a row
// for every handle. Dropping and rounding weights changes Σ w and Σ w c. The changes are stored per point
// as D + 1 numbers e_r. Each frame multiplies e_r by the least-squares affine map a of the handles'
// displacements d. Poses at rest and affine poses therefore stay exact:
//
//     p' = p + s Σ q_i d_i + Σ_r e_r a_r,   d_i = C'_i − C_i,   a = Σ_i F_i d_i
#pragma once

#include <cageform/figure/binding.hpp>

#include <cstdint>
#include <cstring>

namespace cageform::inline CAGEFORM_ABI {

// X(name, NAME, "description"). In C the enumerators are CAGEFORM_FORMAT_NAME. Files store the number of a
// format, so append new ones at the end.
// clang-format off
#define CAGEFORM_WEIGHT_FORMATS(X)                                                                           \
    X(scalar, SCALAR, "as the binding's scalar")                                                             \
    X(half, HALF, "IEEE 754 binary16, times a scale per block")                                              \
    X(int16, INT16, "a signed integer of 16 bits, times a scale per block")                                  \
    X(int8, INT8, "a signed integer of 8 bits, times a scale per block")
// clang-format on

/// How a packed binding stores its weights.
enum class WeightFormat : std::uint8_t {
#define CAGEFORM_DETAIL_FORMAT(name, ...) name,
    CAGEFORM_WEIGHT_FORMATS(CAGEFORM_DETAIL_FORMAT)
#undef CAGEFORM_DETAIL_FORMAT
};

template <Scalar T>
constexpr std::size_t weight_bytes(WeightFormat format) noexcept {
    return format == WeightFormat::scalar ? sizeof(T) : format == WeightFormat::int8 ? 1 : 2;
}

/// The input of `clone`: a view of a packed binding. Pointers to absent parts are null.
template <Scalar T, std::size_t D>
struct PackedBindingView {
    using scalar = T;
    static constexpr std::size_t dimension = D;

    WeightFormat format = WeightFormat::scalar;
    std::size_t handles = 0, points = 0;
    const std::byte* weights = nullptr; ///< a row: the weights q of a block's points for one handle
    /// #blocks + 1: the first row of each block; null if every block has a row for every handle.
    const std::uint32_t* row_begin = nullptr;
    /// #rows: the handle of each row, ascending within a block; null if `row_begin` is.
    const std::uint16_t* row_handle = nullptr;
    /// #points: the point at each position; null for the original order.
    const std::uint32_t* order = nullptr;
    const T* scale = nullptr;                  ///< #blocks: s; null for scalar weights
    const Lanes<T>* residual = nullptr;        ///< D + 1 rows a block: e; null for scalar weights
    const Vec<T, D + 1>* affine_fit = nullptr; ///< #handles: F; null for scalar weights
    const Lanes<T>* rest = nullptr;            ///< D rows a block
    const Vec<T, D>* rest_handles = nullptr;   ///< #handles
    const HandleKind* handle_kinds = nullptr;  ///< #handles; null if all are points
    /// #vectors: the faces of the vectors, in order; null if the vectors have no faces.
    const HandleFace<D>* handle_faces = nullptr;
    const std::uint32_t* handle_loops = nullptr; ///< HandleView::loops; null if there are none

    PackedBindingView() = default;
    /// Views a dense binding.
    PackedBindingView(const BindingView<T, D>& dense) noexcept // NOLINT(google-explicit-constructor)
        : handles(dense.handle_count())
        , points(dense.point_count())
        , weights(reinterpret_cast<const std::byte*>(dense.weights.data))
        , rest(dense.rest.data)
        , rest_handles(dense.rest_handles)
        , handle_kinds(dense.handle_kinds)
        , handle_faces(dense.handle_faces)
        , handle_loops(dense.handle_loops) {}

    /// Returns a view for a figure whose points are stored in the order of the binding: output point n is the
    /// bound point `order[n]`. This avoids scattered writes, which take a third of the time of sparse clones.
    PackedBindingView in_order() const noexcept {
        auto view = *this;
        view.order = nullptr;
        return view;
    }

    /// Returns whether all weights are those of the binding: nothing was dropped, rounded or reordered.
    bool is_dense() const noexcept {
        return format == WeightFormat::scalar && row_begin == nullptr && order == nullptr;
    }
    /// Returns the dense binding; requires is_dense().
    BindingView<T, D> dense() const noexcept {
        CAGEFORM_ASSERT(is_dense(), "a dense binding");
        return {{reinterpret_cast<const Lanes<T>*>(weights), handles, points},
                {rest, D, points},
                rest_handles,
                handle_kinds,
                handle_faces,
                handle_loops};
    }

    std::size_t handle_count() const noexcept { return handles; }
    std::size_t point_count() const noexcept { return points; }
    HandleView<T, D> handle_view() const noexcept {
        return {rest_handles, handles, handle_kinds, handle_faces, handle_loops};
    }
    std::size_t block_count() const noexcept { return cageform::block_count<T>(points); }
    std::size_t first_row(std::size_t block) const noexcept {
        return row_begin != nullptr ? row_begin[block] : block * handles;
    }
    std::size_t row_count() const noexcept { return first_row(block_count()); }
    std::size_t handle_of_row(std::size_t block, std::size_t row) const noexcept {
        return row_handle != nullptr ? row_handle[row] : row - first_row(block);
    }
};

/// Returns whether two bindings have the same number of handles and the same points in the same order.
template <Scalar T, std::size_t D>
bool bindings_match(const PackedBindingView<T, D>& a, const PackedBindingView<T, D>& b) noexcept {
    if (a.points != b.points || a.handles != b.handles) return false;
    if (a.order == b.order || a.points == 0) return true;
    return a.order != nullptr && b.order != nullptr &&
           std::memcmp(a.order, b.order, a.points * sizeof(*a.order)) == 0;
}

} // namespace cageform::inline CAGEFORM_ABI
