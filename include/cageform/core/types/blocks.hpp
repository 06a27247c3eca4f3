// The memory layout of bound data: points in blocks of one cache line, the rows of a block stored
// one after another.
//
//     block 0: row 0 of points 0…7 | row 1 of points 0…7 | …    block 1: row 0 of points 8…15 | …
//
// (8 points for double, 16 for float). For positions a row is an axis, for weights a row is a handle.
// Binding writes and cloning reads such blocks sequentially, a full vector register at a time.
#pragma once

#include <cageform/core/vec.hpp>

#include <type_traits>

namespace cageform::inline CAGEFORM_ABI {

/// Points in a block: 16 for float, 8 for double. A row is one cache line on every target.
template <Scalar T>
inline constexpr std::size_t lane_count = 64 / sizeof(T);

/// One row of a block. Left uninitialised, because large arrays of rows are written sequentially anyway.
template <Scalar T>
struct alignas(64) Lanes {
    T v[lane_count<T>];

    Lanes() noexcept {} // NOLINT(modernize-use-equals-default): `= default` would zero in `Lanes()`
    T& operator[](std::size_t lane) noexcept { return v[lane]; }
    const T& operator[](std::size_t lane) const noexcept { return v[lane]; }
};

/// Returns the number of blocks for `points` points; the last one may be partly used.
template <Scalar T>
constexpr std::size_t block_count(std::size_t points) noexcept {
    return (points + lane_count<T> - 1) / lane_count<T>;
}

/// A view over blocks of `rows` rows each; `T` is const for a read-only view.
template <class T>
struct BlockView {
    using Value = Lanes<std::remove_const_t<T>>;
    using Row = std::conditional_t<std::is_const_v<T>, const Value, Value>;

    Row* data = nullptr;
    std::size_t rows = 0;
    std::size_t points = 0;

    static constexpr std::size_t lanes = lane_count<std::remove_const_t<T>>;

    std::size_t blocks() const noexcept { return block_count<std::remove_const_t<T>>(points); }
    Row* block(std::size_t b) const noexcept { return data + b * rows; }
    T& operator()(std::size_t point, std::size_t row) const noexcept {
        return data[(point / lanes) * rows + row].v[point % lanes];
    }
    operator BlockView<const T>() const noexcept
        requires(!std::is_const_v<T>)
    {
        return {data, rows, points};
    }
};

/// Returns point `i` of blocks whose rows are axes.
template <std::size_t D, class T>
Vec<std::remove_const_t<T>, D> block_point(const BlockView<T>& points, std::size_t i) noexcept {
    Vec<std::remove_const_t<T>, D> p{};
    for (std::size_t k = 0; k < D; ++k) p[k] = points(i, k);
    return p;
}

} // namespace cageform::inline CAGEFORM_ABI
