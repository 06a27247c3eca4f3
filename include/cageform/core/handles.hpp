// The handles of a cage, by which a figure is moved: points, and vectors such as scaled face
// normals or the axes of a bone.
#pragma once

#include <cageform/core/vec.hpp>

#include <array>

namespace cageform::inline CAGEFORM_ABI {

/// What an affine move x ↦ A x + b makes of a handle.
enum class HandleKind : std::uint8_t {
    point,  ///< H' = A H + b
    vector, ///< H' = A H
};

/// x ↦ A x + b: a move, or a frame of axes A and origin b.
template <Scalar T, std::size_t D>
struct Transform {
    std::array<Vec<T, D>, D> columns; ///< of A
    Vec<T, D> translation;            ///< b

    /// A v.
    Vec<T, D> turn(const Vec<T, D>& v) const noexcept {
        Vec<T, D> sum = v[0] * columns[0];
        for (std::size_t k = 1; k < D; ++k) sum = sum + v[k] * columns[k];
        return sum;
    }
};

/// The corners of a face, by the numbers of their handles.
template <std::size_t D>
using HandleFace = std::array<std::uint32_t, D>;

/// The handles of a cage at rest; owns nothing. Weights of a point p restore it by
///
///     Σ w_i κ_i = 1,   Σ w_i H_i = p,   κ = 1 for points and 0 for vectors
///
/// and all handles are of one unit: the vector of a face has the length of its edge in
/// the plane, the root of its area in space (core/detail/face_handles.hpp).
template <Scalar T, std::size_t D>
struct HandleView {
    const Vec<T, D>* rest = nullptr; ///< #handles
    std::size_t count = 0;
    const HandleKind* kinds = nullptr;    ///< #handles; null: all are points
    const HandleFace<D>* faces = nullptr; ///< of the vectors, in their order; null: they belong to no faces

    HandleView() = default;
    HandleView(const Vec<T, D>* handles, std::size_t size, const HandleKind* kinds_of,
               const HandleFace<D>* faces_of) noexcept
        : rest(handles)
        , count(size)
        , kinds(kinds_of)
        , faces(faces_of) {}
    /// Points, of a vector or span.
    template <class Points>
        requires requires(const Points& points) {
            { std::data(points) } -> std::convertible_to<const Vec<T, D>*>;
        }
    HandleView(
        const Points& points) noexcept // NOLINT(google-explicit-constructor): every range of points is one
        : rest(std::data(points))
        , count(std::size(points)) {}

    bool is_point(std::size_t handle) const noexcept {
        return kinds == nullptr || kinds[handle] == HandleKind::point;
    }
    std::size_t vector_count() const noexcept {
        std::size_t vectors = 0;
        for (std::size_t i = 0; i < count; ++i) vectors += is_point(i) ? 0 : 1;
        return vectors;
    }
};

} // namespace cageform::inline CAGEFORM_ABI
