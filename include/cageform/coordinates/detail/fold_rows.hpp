// Distributes the weights of a mesh's fan points to its vertices, a block at a time.
#pragma once

#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/core/detail/simd.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Distributes the rows of a block for fan points to the vertices.
///
///   from  #V + #points rows
///   to    out, #V rows, summed in the order of the points
template <class T>
void fold_rows(const FanPoints& points, std::size_t vertices, const Lanes<T>* from, Lanes<T>* to) noexcept {
    using X = Simd<T>;
    std::copy_n(from, vertices, to);
    for (std::size_t n = 0; n < points.size(); ++n) {
        const X own = X::load(from[vertices + n]);
        points.for_each_corner(n, [&](std::uint32_t vertex, double weight) {
            (X::load(to[vertex]) + X(T(weight)) * own).store(to[vertex]);
        });
    }
}

/// Returns the triangles of a PolyhedralMesh, or any other cage itself.
template <class Cage>
const auto& surface_of(const Cage& cage) noexcept {
    if constexpr (requires { cage.triangles(); }) {
        return cage.triangles();
    } else {
        return cage;
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail
