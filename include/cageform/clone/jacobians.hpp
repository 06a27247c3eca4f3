// Jacobians of a clone, every frame, from axes that `bind_jacobians` bound.
#pragma once

#include <cageform/clone/clone.hpp>
#include <cageform/clone/detail/vector_tile.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A view of strided square matrices in column-major order; owns nothing.
///
///   T              float or double, `const` for a read-only view
///   matrix_stride  bytes between matrices
///   column_stride  bytes between columns of a matrix (16 for float columns padded to four, as in std430)
template <class T, std::size_t D>
class StridedMatrices {
public:
    using scalar = std::remove_const_t<T>;
    static constexpr std::size_t dimension = D;

    constexpr StridedMatrices(T* data, std::size_t size, std::ptrdiff_t matrix_stride = D * D * sizeof(T),
                              std::ptrdiff_t column_stride = D * sizeof(T)) noexcept
        : data_(data)
        , size_(size)
        , matrix_stride_(matrix_stride)
        , column_stride_(column_stride) {}

    constexpr std::size_t size() const noexcept { return size_; }

    /// Returns column k of all matrices.
    StridedPoints<T, D> column(std::size_t k) const noexcept {
        using Byte = std::conditional_t<std::is_const_v<T>, const std::byte, std::byte>;
        auto* const bytes = reinterpret_cast<Byte*>(data_) + static_cast<std::ptrdiff_t>(k) * column_stride_;
        return {reinterpret_cast<T*>(bytes), size_, matrix_stride_};
    }

private:
    T* data_;
    std::size_t size_;
    std::ptrdiff_t matrix_stride_;
    std::ptrdiff_t column_stride_;
};

/// Computes the Jacobian J of the deformation at every point, for objects with an extent: a splat of
/// covariance Σ becomes a splat of covariance J Σ Jᵀ.
///
///   columns    bindings of the D axes (`bind_jacobians`)
///   jacobians  out, at least #points matrices: column k is the image of axis k
///   returns    bindings_differ, or as `clone`; `jacobians` is then untouched
///   cost       D clones; no allocation. The pose at rest gives exactly the identity
template <AnyBinding B, std::size_t D, PointRangeIn<D> Pose, class S, class Parallel = SerialFor>
    requires(B::dimension == D)
Status clone_jacobians(const std::array<B, D>& columns, const Pose& pose,
                       const StridedMatrices<S, D>& jacobians, const Parallel& parallel_for = {}) noexcept {
    const auto views = detail::views_of(columns);
    for (const auto& view : views) {
        if (view.point_count() != views[0].point_count()) return Status::bindings_differ;
        const Status status = detail::check_clone(view, pose, jacobians.column(0));
        if (status != Status::ok) return status;
    }
    using T = typename B::scalar;
    auto&& source = detail::as_strided<const T, B::dimension>(pose);
    const std::size_t blocks = block_count<T>(views[0].point_count());
    parallel_for(blocks, detail::clone_grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = 0; k < D; ++k) {
            auto column = jacobians.column(k);
            detail::BlockCloner(views[k], source, column, {}).run(begin, end);
        }
    });
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI
