// Converts the cages of the C interface to coordinates.
#pragma once

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/c/detail/reports.hpp>

#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail::c {

/// Copies points of either scalar.
template <class T, std::size_t D>
cageform_status copy_points(const cageform_points& points, std::vector<Vec<T, D>>& copied) {
    cageform_status status = CAGEFORM_OK;
    const auto copy = [&](const auto& view) {
        copied.reserve(view.size());
        for (std::size_t i = 0; i < view.size(); ++i) copied.push_back(vec_cast<T>(view[i]));
    };
    if (points.scalar == CAGEFORM_DOUBLE)
        copy(view_of<double, D>(points, status));
    else
        copy(view_of<float, D>(points, status));
    return status;
}

inline std::vector<std::array<std::uint32_t, 3>> triangles_of(const std::uint32_t* indices,
                                                              std::size_t count) {
    std::vector<std::array<std::uint32_t, 3>> faces(count / 3);
    for (std::size_t n = 0; n < faces.size(); ++n) std::copy_n(indices + 3 * n, 3, faces[n].begin());
    return faces;
}

/// The dimension of a cage.
inline std::size_t dimension_of(const cageform_cage& cage) noexcept {
    switch (cage.kind) {
    case CAGEFORM_POLYGON:
    case CAGEFORM_CURVES: return 2;
    case CAGEFORM_MESH: return 3;
    case CAGEFORM_LATTICE: return cage.dimension;
    default: return cage.vertices.dimension;
    }
}

/// Whether a cage has cells inside.
inline bool has_cells(const cageform_cage& cage) noexcept {
    return cage.cell_vertices > 0 || cage.bone_count > 0 || cage.wall_index_count > 0;
}

/// Makes coordinates of a cage.
template <class T, std::size_t D>
cageform_status coordinates_of(const cageform_cage& cage, const cageform_coordinates_options& options,
                               AnyCoordinates<T, D>& made);

/// Makes coordinates of several cages, blended where cages overlap.
template <class T, std::size_t D>
cageform_status blend_of(std::span<const cageform_cage* const> cages,
                         const cageform_coordinates_options& options, AnyCoordinates<T, D>& made,
                         std::size_t& culprit);

/// Checks a cage as its coordinates do.
template <class T, std::size_t D>
cageform_status check_cage(const cageform_cage& cage, CageReport& report);

} // namespace cageform::inline CAGEFORM_ABI::detail::c

#if !defined(CAGEFORM_COMPILED)
#include <cageform/c/detail/cages.impl.hpp>
#endif
