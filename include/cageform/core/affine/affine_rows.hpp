// The affine rows (κ, H) of a cage's handles. They define linear precision of points and vectors.
#pragma once

#include <cageform/core/types/bounds.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/core/types/handles.hpp>

#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The origin and unit in which handles are expressed.
template <Scalar T, std::size_t D>
struct AffineFrame {
    Vec<T, D> centre{};
    T size = 1;

    /// Returns (κ, (H − κ centre) / size) for a handle H, with κ = 1 for points and 0 for vectors.
    template <Scalar S>
    Vec<T, D + 1> row(const HandleView<S, D>& handles, std::size_t handle) const noexcept {
        const auto at = vec_cast<T>(handles.rest[handle]);
        return handles.is_point(handle) ? with(T(1), at - centre) : with(T(0), at);
    }
    Vec<T, D + 1> with(T kappa, const Vec<T, D>& v) const noexcept {
        Vec<T, D + 1> row{kappa};
        for (std::size_t k = 0; k < D; ++k) row[k + 1] = v[k] / size;
        return row;
    }
};

/// Returns the bounds of the point handles.
template <Scalar S, Scalar T, std::size_t D>
Bounds<S, D> bounds_of_points(const HandleView<T, D>& handles) {
    std::vector<Vec<S, D>> points;
    for (std::size_t i = 0; i < handles.count; ++i) {
        if (handles.is_point(i)) points.push_back(vec_cast<S>(handles.rest[i]));
    }
    return bounds_of(std::span<const Vec<S, D>>(points));
}

/// Returns the centre and diagonal of the points' bounds. If a vector is longer than the diagonal, its
/// length is the size.
template <Scalar T, std::size_t D>
AffineFrame<T, D> frame_of(const HandleView<T, D>& handles) {
    T longest = 0;
    for (std::size_t i = 0; i < handles.count; ++i) {
        if (!handles.is_point(i)) longest = std::fmax(longest, Bounds<T, D>{{}, handles.rest[i]}.diagonal());
    }
    if (handles.point_count() == 0) return {{}, longest > 0 ? longest : T(1)};
    const auto bounds = bounds_of_points<T>(handles);
    return {T(0.5) * (bounds.lower + bounds.upper), std::fmax(bounds.diagonal(), longest)};
}

/// The rows a_i of all handles in a frame. Weights have linear precision at a point p, or for a vector t, if
///
///     Σ w_i a_i = (1, (p − centre) / size),   Σ w_i a_i = (0, t / size).
template <Scalar T, std::size_t D>
class AffineRows {
public:
    template <Scalar S>
    AffineRows(const HandleView<S, D>& handles, const AffineFrame<T, D>& frame)
        : frame_(frame)
        , rows_(handles.count) {
        for (std::size_t i = 0; i < handles.count; ++i) rows_[i] = frame.row(handles, i);
    }

    const AffineFrame<T, D>& frame() const noexcept { return frame_; }
    std::size_t size() const noexcept { return rows_.size(); }
    const Vec<T, D + 1>& operator[](std::size_t handle) const noexcept { return rows_[handle]; }

private:
    AffineFrame<T, D> frame_;
    Buffer<Vec<T, D + 1>> rows_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
