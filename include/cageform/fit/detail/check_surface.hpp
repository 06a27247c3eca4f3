// Checks of surfaces.
#pragma once

#include <cageform/fit/types/surface.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Checks that all vertices are finite, and that all faces have their vertices.
///
///   culprit  out: the vertex or face that is refused
inline Status check_vertices(const SurfaceMesh& mesh, std::size_t& culprit) noexcept {
    if (mesh.status() != Status::ok) return mesh.status();
    for (std::size_t i = 0; i < mesh.vertices().size(); ++i) {
        culprit = i;
        // Areas are products of four lengths, and must not overflow.
        for (const double x : mesh.vertices()[i].v) {
            if (!(std::fabs(x) < 1e70)) return Status::figure_not_finite;
        }
    }
    for (std::size_t f = 0; f < mesh.faces().size(); ++f) {
        culprit = f;
        if (has_missing_vertex(mesh.faces()[f])) return Status::index_out_of_range;
    }
    culprit = ~std::size_t{0};
    return Status::ok;
}
/// Also checks that a face has an area.
inline Status check_surface(const SurfaceMesh& mesh, std::size_t& culprit) noexcept {
    if (const Status status = check_vertices(mesh, culprit); status != Status::ok) return status;
    const auto v = mesh.vertices();
    if (v.empty() || mesh.faces().empty()) return Status::figure_empty;
    for (const auto& [a, b, c] : mesh.faces()) {
        const auto n = cross(v[b] - v[a], v[c] - v[a]);
        if (dot(n, n) > 0) return Status::ok;
    }
    return Status::figure_has_no_size;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
