// The grid of the harmonic coordinates papers: the tags of its cells, and its placement around a
// cage.
#pragma once

#include <cageform/grid/lattice/lattice.hpp>

#include <cstdint>

namespace cageform_sources::averaging {

using cageform::Bounds, cageform::CellBox, cageform::Lattice, cageform::Scalar, cageform::Vec;

/// The tags of a cell (Joshi et al. 2007, sec. 4).
enum class CellTag : std::uint8_t {
    untyped,  ///< not yet tagged
    boundary, ///< its value is given and fixed
    interior, ///< its value is unknown
    exterior, ///< not part of the problem
};

/// The number of empty cells left around a cage on every side, so that the exterior is connected.
inline constexpr std::size_t papers_margin = 2;

/// Returns the papers' grid: `resolution` cells along the cage's longest extent, margin included.
/// Shorter axes get only as many cells as the cage needs; the omitted cells would be exterior.
template <Scalar T, std::size_t D>
Lattice<T, D> lattice_about(const Bounds<T, D>& bounds, std::size_t resolution) noexcept {
    CAGEFORM_ASSERT(resolution > 2 * papers_margin, "room for the cage between the margins");
    const auto extent = bounds.upper - bounds.lower;
    T longest = 0;
    for (std::size_t k = 0; k < D; ++k) longest = std::fmax(longest, extent[k]);
    Lattice<T, D> lattice;
    lattice.spacing = longest / static_cast<T>(resolution - 2 * papers_margin);
    for (std::size_t k = 0; k < D; ++k) {
        const auto needed = static_cast<std::size_t>(std::ceil(extent[k] / lattice.spacing - T(1e-3)));
        lattice.cells[k] = (std::min)(resolution, needed + 2 * papers_margin);
        const T side = static_cast<T>(lattice.cells[k]) * lattice.spacing;
        lattice.origin[k] = T(0.5) * (bounds.lower[k] + bounds.upper[k] - side);
    }
    return lattice;
}

} // namespace cageform_sources::averaging
