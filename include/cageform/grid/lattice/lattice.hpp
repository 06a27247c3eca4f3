// A regular grid of cells over a box.
#pragma once

#include <cageform/cage/polygon.hpp>

#include <array>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// A box of cells, numbered with the first axis fastest.
template <std::size_t D>
struct CellBox {
    using Index = std::array<std::size_t, D>;
    using SignedIndex = std::array<std::int32_t, D>; ///< an index that may lie outside

    Index cells{}; ///< along each axis

    std::size_t size() const noexcept {
        std::size_t n = 1;
        for (const std::size_t c : cells) n *= c;
        return n;
    }
    std::size_t number(const Index& index) const noexcept {
        std::size_t n = 0;
        for (std::size_t k = D; k-- > 0;) n = n * cells[k] + index[k];
        return n;
    }
    Index index(std::size_t number) const noexcept {
        Index i{};
        for (std::size_t k = 0; k < D; ++k) {
            i[k] = number % cells[k];
            number /= cells[k];
        }
        return i;
    }
    /// Returns the difference between the indices of neighbours along an axis.
    std::size_t stride(std::size_t axis) const noexcept {
        std::size_t n = 1;
        for (std::size_t k = 0; k < axis; ++k) n *= cells[k];
        return n;
    }

    SignedIndex counts() const noexcept { ///< returns the number of cells along each axis
        SignedIndex counts{};
        for (std::size_t k = 0; k < D; ++k) counts[k] = std::int32_t(cells[k]);
        return counts;
    }
    /// Returns the index of the line along an axis through a cell. Lines are numbered like the cells of a
    /// face perpendicular to the axis.
    std::uint32_t line(std::size_t axis, const SignedIndex& index) const noexcept {
        std::uint32_t n = 0;
        for (std::size_t k = D; k-- > 0;) {
            if (k != axis) n = n * std::uint32_t(cells[k]) + std::uint32_t(index[k]);
        }
        return n;
    }
    /// Returns the cell at position `x` on a line along an axis.
    SignedIndex on_line(std::size_t axis, std::uint32_t line, std::int32_t x) const noexcept {
        SignedIndex index{};
        for (std::size_t k = 0; k < D; ++k) {
            if (k == axis) {
                index[k] = x;
                continue;
            }
            index[k] = std::int32_t(line % std::uint32_t(cells[k]));
            line /= std::uint32_t(cells[k]);
        }
        return index;
    }
};

/// Returns the position of a node in units of its lattice: node i of an axis is at i.
template <std::size_t D>
Vec<double, D> node_position(const std::array<std::int32_t, D>& node) noexcept {
    Vec<double, D> p{};
    for (std::size_t k = 0; k < D; ++k) p[k] = double(node[k]);
    return p;
}

/// A CellBox with a position and a spacing. Values are at cell centres; cell 0 begins at `origin`.
template <Scalar T, std::size_t D>
struct Lattice : CellBox<D> {
    Vec<T, D> origin{};
    T spacing = 1; ///< h, the side length of a cell

    Vec<T, D> centre(const typename CellBox<D>::Index& index) const noexcept {
        Vec<T, D> p = origin;
        for (std::size_t k = 0; k < D; ++k) p[k] += (static_cast<T>(index[k]) + T(0.5)) * spacing;
        return p;
    }
    /// Returns a position in units of cells: 0 at the lower corner of cell 0, 0.5 at its centre.
    Vec<T, D> in_cells(const Vec<T, D>& p) const noexcept { return (T(1) / spacing) * (p - origin); }
    template <Scalar S>
    std::vector<Vec<T, D>> in_cells(std::span<const Vec<S, D>> points) const {
        std::vector<Vec<T, D>> all;
        all.reserve(points.size());
        for (const auto& p : points) all.push_back(in_cells(vec_cast<T>(p)));
        return all;
    }
};

} // namespace cageform::inline CAGEFORM_ABI
