// Interpolates values between the cells of a grid.
#pragma once

#include "averaging/lattice.hpp"

#include <span>

namespace cageform_sources::averaging {

enum class Interpolation : std::uint8_t {
    nearest_cell, ///< the look-up of the papers: constant within a cell
    multilinear,  ///< between the 2^D nearest centres, leaving out exterior ones
};

/// The cells and weights that interpolate values at one point, for any number of fields.
template <Scalar T, std::size_t D>
struct SampleStencil {
    std::array<std::size_t, (std::size_t{1} << D)> cells{};
    std::array<T, (std::size_t{1} << D)> shares{};
    std::size_t count = 0; ///< number of cells used; zero if no cell around the point has a value

    T sample(std::span<const T> field) const noexcept {
        T sum = 0;
        for (std::size_t i = 0; i < count; ++i) sum += shares[i] * field[cells[i]];
        return sum;
    }
};

/// Returns the stencil at a finite point. Exterior cells are left out; the weights of the others
/// are rescaled to sum to 1.
template <Scalar T, std::size_t D>
SampleStencil<T, D> sample_stencil(const Lattice<T, D>& lattice, std::span<const CellTag> tags,
                                   const Vec<T, D>& p, Interpolation interpolation) noexcept {
    SampleStencil<T, D> stencil;
    const auto x = lattice.in_cells(p);
    typename CellBox<D>::Index low{};
    Vec<T, D> fraction{};
    for (std::size_t k = 0; k < D; ++k) {
        const T reach = static_cast<T>(lattice.cells[k]);
        if (!(x[k] >= T(0) && x[k] <= reach)) return stencil;
        const T shifted = interpolation == Interpolation::nearest_cell ? x[k] : x[k] - T(0.5);
        const T cell = std::fmin(std::fmax(std::floor(shifted), T(0)), reach - T(1));
        low[k] = static_cast<std::size_t>(cell);
        fraction[k] = std::fmin(std::fmax(shifted - cell, T(0)), T(1));
        if (interpolation == Interpolation::nearest_cell || low[k] + 1 == lattice.cells[k])
            fraction[k] = T(0);
    }
    T total = 0;
    for (std::size_t corner = 0; corner < (std::size_t{1} << D); ++corner) {
        auto index = low;
        T share = 1;
        for (std::size_t k = 0; k < D; ++k) {
            const bool high = (corner >> k) & 1u;
            share *= high ? fraction[k] : T(1) - fraction[k];
            if (high && share > T(0)) ++index[k];
        }
        if (!(share > T(0))) continue;
        const std::size_t cell = lattice.number(index);
        if (tags[cell] != CellTag::boundary && tags[cell] != CellTag::interior) continue;
        stencil.cells[stencil.count] = cell;
        stencil.shares[stencil.count++] = share;
        total += share;
    }
    for (std::size_t i = 0; i < stencil.count; ++i) stencil.shares[i] /= total;
    return stencil;
}

} // namespace cageform_sources::averaging
