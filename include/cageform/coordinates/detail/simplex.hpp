// Gradients of barycentric coordinates in a simplex, and the nearest point of its boundary.
#pragma once

#include <cageform/core/affine/orthonormal_rows.hpp>
#include <cageform/core/types/buffer.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the edges from one vertex of a simplex to others, a column per edge, a row per axis.
template <std::size_t D>
OrthonormalRows<D> edges_of_simplex(std::span<const Vec<double, D>> vertices, std::size_t from,
                                    std::span<const std::size_t> to) {
    Buffer<Vec<double, D>> rows(D);
    for (std::size_t k = 0; k < to.size(); ++k) {
        for (std::size_t axis = 0; axis < D; ++axis)
            rows[axis][k] = vertices[to[k]][axis] - vertices[from][axis];
    }
    return OrthonormalRows<D>(std::move(rows));
}

/// Returns the gradients of the barycentric coordinates, one per vertex. Empty if the volume is zero to
/// working precision.
template <std::size_t D>
std::vector<Vec<double, D>> simplex_gradients(std::span<const Vec<double, D>> vertices) {
    std::array<std::size_t, D> others;
    std::iota(others.begin(), others.end(), std::size_t{0});
    const auto edges = edges_of_simplex<D>(vertices, D, others);
    std::vector<Vec<double, D>> gradients(D + 1);
    for (std::size_t axis = 0; axis < D; ++axis) {
        if (edges.triangle()[axis][axis] == 0) return {};
        const auto inverse = coefficients(edges.triangle(), edges[axis]);
        for (std::size_t k = 0; k < D; ++k) {
            gradients[k][axis] = inverse[k];
            gradients[D][axis] -= inverse[k];
        }
    }
    return gradients;
}

/// Returns the barycentric coordinates of the boundary point nearest to `p`: the nearest projection of `p`
/// onto the span of a face that lies in that face.
template <std::size_t D>
Vec<double, D + 1> nearest_on_simplex_boundary(std::span<const Vec<double, D>> vertices,
                                               const Vec<double, D>& p) {
    double least = -1; // none found yet
    Vec<double, D + 1> best{};
    for (unsigned face = 1; face + 1 < (1u << (D + 1)); ++face) {
        std::vector<std::size_t> corner;
        for (std::size_t i = 0; i <= D; ++i) {
            if ((face >> i) & 1u) corner.push_back(i);
        }
        const std::span<const std::size_t> others(corner.begin() + 1, corner.end());
        const auto edges = edges_of_simplex<D>(vertices, corner[0], others);
        const Vec<double, D> away = p - vertices[corner[0]];
        Vec<double, D> projected{};
        for (std::size_t axis = 0; axis < D; ++axis) projected = projected + away[axis] * edges[axis];
        const auto shares = coefficients(edges.triangle(), projected);
        Vec<double, D + 1> found{};
        Vec<double, D> left = away;
        double first = 1;
        bool inside = true;
        for (std::size_t k = 0; k < others.size(); ++k) {
            found[others[k]] = shares[k];
            left = left - shares[k] * (vertices[others[k]] - vertices[corner[0]]);
            first -= shares[k];
            inside = inside && shares[k] >= 0;
        }
        if (!inside || first < 0) continue;
        found[corner[0]] = first;
        double distance = 0;
        for (std::size_t axis = 0; axis < D; ++axis) distance = std::hypot(distance, left[axis]);
        if (least >= 0 && distance >= least) continue; // infinite if p is too far away
        least = distance;
        best = found;
    }
    return best;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
