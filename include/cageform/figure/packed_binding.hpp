// The layout of a packed binding: sparse, quantised, reordered, in one relocatable piece of memory.
//
// Points lie in blocks as in core/types/blocks.hpp. A block has a row of weights for every handle
// of which any of its points has a weight (compressed rows), or for every handle (dense). The error
// that a format leaves in Σ w and Σ w c is stored per point, as D + 1 numbers. They are multiplied
// by the best affine fit to the handles' displacements, which is computed once a frame. So rest and
// affine poses stay exact whatever is dropped or rounded:
//
//     p' = p + s Σ q_i d_i + Σ_r e_r a_r,   d_i = C'_i − C_i,   a = Σ_i F_i d_i
#pragma once

#include <cageform/figure/binding.hpp>

#include <cstdint>
#include <cstring>

namespace cageform::inline CAGEFORM_ABI {

// X(name, NAME, "description"): the enumerators here, and of C: CAGEFORM_FORMAT_NAME. Files hold the number:
// add new ones at the end.
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
    const std::byte* weights = nullptr; ///< a row: the weights of a block's points for one handle
    /// #blocks + 1: rows of a block; null: a row for every handle.
    const std::uint32_t* row_begin = nullptr;
    const std::uint16_t* row_handle = nullptr; ///< #rows: ascending in a block; null with `row_begin`
    /// #points: the point stored at each position; null: in order.
    const std::uint32_t* order = nullptr;
    const T* scale = nullptr;                  ///< #blocks: s; null for scalar weights
    const Lanes<T>* residual = nullptr;        ///< D + 1 rows a block: e; null for scalar weights
    const Vec<T, D + 1>* affine_fit = nullptr; ///< #handles: F; null for scalar weights
    const Lanes<T>* rest = nullptr;            ///< D rows a block
    const Vec<T, D>* rest_handles = nullptr;   ///< #handles
    const HandleKind* handle_kinds = nullptr;  ///< #handles; null: all are points
    /// The faces of the vectors, in their order; null: they belong to none.
    const HandleFace<D>* handle_faces = nullptr;
    const std::uint32_t* handle_loops = nullptr; ///< the loops of HandleView; null: no corner is a mean

    PackedBindingView() = default;
    /// Any binding can be read as a packed one from which nothing was dropped.
    PackedBindingView(const BindingView<T, D>& dense) noexcept // NOLINT(google-explicit-constructor)
        : handles(dense.handle_count())
        , points(dense.point_count())
        , weights(reinterpret_cast<const std::byte*>(dense.weights.data))
        , rest(dense.rest.data)
        , rest_handles(dense.rest_handles)
        , handle_kinds(dense.handle_kinds)
        , handle_faces(dense.handle_faces)
        , handle_loops(dense.handle_loops) {}

    /// Returns a view for a figure whose points have been sorted once into the order of the
    /// binding. Point n of the output is then the bound point `order[n]`, and nothing has to be
    /// scattered, which takes a third of the time of sparse clones.
    PackedBindingView in_order() const noexcept {
        auto view = *this;
        view.order = nullptr;
        return view;
    }

    /// Returns whether nothing was dropped or rounded, so every point has the weights it was bound with.
    bool is_dense() const noexcept {
        return format == WeightFormat::scalar && row_begin == nullptr && order == nullptr;
    }
    /// Returns a dense binding as it was bound.
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

/// Returns whether two bindings have the same number of handles and the same points in the same
/// order, so that their blocks correspond.
template <Scalar T, std::size_t D>
bool bindings_match(const PackedBindingView<T, D>& a, const PackedBindingView<T, D>& b) noexcept {
    if (a.points != b.points || a.handles != b.handles) return false;
    if (a.order == b.order || a.points == 0) return true;
    return a.order != nullptr && b.order != nullptr &&
           std::memcmp(a.order, b.order, a.points * sizeof(*a.order)) == 0;
}

} // namespace cageform::inline CAGEFORM_ABI
