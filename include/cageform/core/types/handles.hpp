// The handles of a cage: points, and vectors such as scaled face normals or the axes of a bone.
#pragma once

#include <cageform/core/vec.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// How an affine map x ↦ A x + b moves a handle from H at rest to H'.
enum class HandleKind : std::uint8_t {
    point,  ///< H' = A H + b
    vector, ///< H' = A H
};

/// An affine map x ↦ A x + b: a motion, or a frame with axes A and origin b.
template <Scalar T, std::size_t D>
struct Transform {
    using scalar = T;

    std::array<Vec<T, D>, D> columns; ///< of A
    Vec<T, D> translation;            ///< b

    /// Returns A v.
    Vec<T, D> map_vector(const Vec<T, D>& v) const noexcept {
        Vec<T, D> sum = v[0] * columns[0];
        for (std::size_t k = 1; k < D; ++k) sum = sum + v[k] * columns[k];
        return sum;
    }
};

/// The corners of a face as handle indices. An index i ≥ #handles refers to loop i − #handles of the
/// HandleView: the corner is the mean of the loop's handles.
template <std::size_t D>
using HandleFace = std::array<std::uint32_t, D>;

/// A non-owning view of a cage's handles at rest. Handle i is H_i, a point (κ_i = 1) or a vector (κ_i =
/// 0). Weights w_i reproduce a point p if
///
///     Σ w_i κ_i = 1,   Σ w_i H_i = p
///
/// The pair (κ_i, H_i) is the affine row of the handle; the two sums are the row sums of p. All handles
/// have the unit of length: the vector of a face has the length of its edge in 2D, and √area in 3D
/// (core/detail/face_handles.hpp).
template <Scalar T, std::size_t D>
struct HandleView {
    const Vec<T, D>* rest = nullptr; ///< #handles
    std::size_t count = 0;
    const HandleKind* kinds = nullptr;    ///< #handles; null if all are points
    const HandleFace<D>* faces = nullptr; ///< one per vector, in order; null if the vectors have no faces
    /// Loops of points whose means are corners of `faces`; null if there are none. Loop l consists of
    /// the elements loops[loops[l]] to loops[loops[l + 1] − 1]. loops[0] is the number of loops plus 1.
    const std::uint32_t* loops = nullptr;

    HandleView() = default;
    HandleView(const Vec<T, D>* handles, std::size_t size, const HandleKind* kinds_of,
               const HandleFace<D>* faces_of, const std::uint32_t* loops_of = nullptr) noexcept
        : rest(handles)
        , count(size)
        , kinds(kinds_of)
        , faces(faces_of)
        , loops(loops_of) {}
    /// Views points in a vector or span.
    template <class Points>
        requires requires(const Points& points) {
            { std::data(points) } -> std::convertible_to<const Vec<T, D>*>;
        }
    HandleView(const Points& points) noexcept // NOLINT(google-explicit-constructor): a range of points is one
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
    std::size_t point_count() const noexcept { return count - vector_count(); }
    /// Returns the number of elements of `loops`.
    std::size_t loop_numbers() const noexcept { return loops == nullptr ? 0 : loops[loops[0] - 1]; }
};

} // namespace cageform::inline CAGEFORM_ABI
