// Ranges of points: anything with size() and [i], and strided views of raw memory.
#pragma once

#include <cageform/core/detail/deleted_functions.hpp>
#include <cageform/core/point.hpp>

#include <cstddef>
#include <utility>

namespace cageform::inline CAGEFORM_ABI {

/// A non-owning view of points whose components lie at regular distances in memory: interleaved vertex
/// buffers, separate x and y arrays, rows or columns of a matrix.
///
///   T             float or double, `const` for a read-only view
///   point_stride  bytes from one point to the next
///   axis_stride   bytes from one component of a point to the next
template <class T, std::size_t D>
class StridedPoints {
public:
    using scalar = std::remove_const_t<T>;
    using value_type = Vec<scalar, D>;

    /// Views `size` points; by default all numbers are contiguous.
    constexpr StridedPoints(T* data, std::size_t size, std::ptrdiff_t point_stride = D * sizeof(T),
                            std::ptrdiff_t axis_stride = sizeof(T)) noexcept
        : data_(data)
        , size_(size)
        , point_stride_(point_stride)
        , axis_stride_(axis_stride) {}

    constexpr std::size_t size() const noexcept { return size_; }

    value_type operator[](std::size_t i) const noexcept {
        value_type r{};
        for (std::size_t k = 0; k < D; ++k) r[k] = *at(i, k);
        return r;
    }

    void store(std::size_t i, const value_type& p) const noexcept
        requires(!std::is_const_v<T>)
    {
        for (std::size_t k = 0; k < D; ++k) *at(i, k) = p[k];
    }
    /// Returns the address of coordinate `axis` of point 0 if this coordinate is contiguous over all
    /// points; else null.
    T* plain_axis(std::size_t axis) const noexcept {
        return point_stride_ == sizeof(T) ? at(0, axis) : nullptr;
    }
    /// Returns the address of the numbers if they are contiguous (x y z x y z …); else null.
    constexpr T* plain_numbers() const noexcept {
        return axis_stride_ == sizeof(T) && point_stride_ == D * sizeof(T) ? data_ : nullptr;
    }

    /// Returns a view of `count` points from point `first` on, for instance of one figure in a shared buffer.
    StridedPoints subview(std::size_t first, std::size_t count) const noexcept {
        return {at(first, 0), count, point_stride_, axis_stride_};
    }

private:
    using Byte = std::conditional_t<std::is_const_v<T>, const std::byte, std::byte>;

    T* at(std::size_t i, std::size_t axis) const noexcept {
        const auto offset =
            static_cast<std::ptrdiff_t>(i) * point_stride_ + static_cast<std::ptrdiff_t>(axis) * axis_stride_;
        return reinterpret_cast<T*>(reinterpret_cast<Byte*>(data_) + offset);
    }

    T* data_;
    std::size_t size_;
    std::ptrdiff_t point_stride_;
    std::ptrdiff_t axis_stride_;
};

/// The point type of a range: the type of `range[i]`.
template <class R>
using range_point_t = std::remove_cvref_t<decltype(std::declval<R&>()[std::size_t{}])>;

/// Points that can be read by index: std::vector, std::span, std::array, C arrays, StridedPoints, …
template <class R>
concept PointRange = requires(const std::remove_reference_t<R>& r, std::size_t i) {
    { std::size(r) } -> std::convertible_to<std::size_t>;
    r[i];
    // Compilers print this line for an unknown point type, so it names the headers that explain the fix.
    requires Point<std::remove_cvref_t<decltype(r[i])>>; // PointTraits: core/point.hpp, adapt/*.hpp
};

/// Ranges whose elements are no Point. Functions of points are deleted for them, so that the first line
/// of a compiler error states the reason.
template <class R>
concept UnknownPointRange = !PointRange<R> && requires(const std::remove_reference_t<R>& r, std::size_t i) {
    std::size(r);
    r[i];
};

/// A range that is written by `store(i, vec)`.
template <class R>
concept StoringRange =
    PointRange<R> && requires(const std::remove_reference_t<R>& r, std::size_t i) { r.store(i, r[i]); };
template <class R>
concept ReferenceRange = PointRange<R> && requires(R& r, std::size_t i) {
    requires std::is_lvalue_reference_v<decltype(r[i])>;
    requires !std::is_const_v<std::remove_reference_t<decltype(r[i])>>;
    requires MutablePoint<range_point_t<R>>;
};
template <class R>
concept MutablePointRange = PointRange<R> && (StoringRange<R> || ReferenceRange<R>);

/// The dimension and scalar of the points of a range.
template <class R>
inline constexpr std::size_t range_dimension = PointTraits<range_point_t<R>>::dimension;
template <class R>
using range_scalar_t = typename PointTraits<range_point_t<R>>::scalar;

/// Ranges of points in D dimensions.
template <class R, std::size_t D>
concept PointRangeIn = PointRange<R> && range_dimension<R> == D;
template <class R, std::size_t D>
concept MutablePointRangeIn = MutablePointRange<R> && range_dimension<R> == D;

/// Writes point `i` of a range, converted to the range's scalar.
template <MutablePointRange R, class T>
constexpr void store_point(R& range, std::size_t i, const Vec<T, range_dimension<R>>& p) noexcept {
    using S = range_scalar_t<R>;
    if constexpr (StoringRange<R>) {
        range.store(i, vec_cast<S>(p));
    } else {
        auto& target = range[i];
        for (std::size_t k = 0; k < range_dimension<R>; ++k) {
            PointTraits<range_point_t<R>>::set(target, k, static_cast<S>(p[k]));
        }
    }
}

} // namespace cageform::inline CAGEFORM_ABI
