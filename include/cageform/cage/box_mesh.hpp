// An axis-aligned box with sides divided into rectangles.
#pragma once

#include <cageform/cage/polyhedral_mesh.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Makes an axis-aligned box with sides divided into rectangles. Vertices are numbered with the first axis
/// fastest; two divisions along each axis give 26 vertices. Harmonic coordinates are bilinear on each
/// rectangle.
///
///   divisions  number of rectangles along each axis. For 0, or for more than 2^24 vertices, the mesh is
///              empty, which `check` reports
///   cost       O(#V) time and memory; may throw std::bad_alloc
template <Scalar T>
PolyhedralMesh<T> box_mesh(const Vec<T, 3>& lower, const Vec<T, 3>& upper,
                           const std::array<std::size_t, 3>& divisions = {1, 1, 1}) {
    const std::size_t a = divisions[0], b = divisions[1], c = divisions[2];
    const double x = double(a), y = double(b), z = double(c);
    constexpr double most_vertices = 16777216;
    if (a == 0 || b == 0 || c == 0 || 2 * (x * y + y * z + z * x + 1) > most_vertices) return {};

    std::vector<Vec<T, 3>> vertices;
    const auto layer = (a + 1) * (b + 1), ring = 2 * (a + b);
    // Index of the surface vertex (i, j, k). Layers of the third axis are complete only at both ends.
    const auto slot = [&](const std::array<std::size_t, 3>& index) {
        const auto [i, j, k] = index;
        if (k == 0) return j * (a + 1) + i;
        const std::size_t before = layer + (k - 1) * ring;
        if (k == c) return before + j * (a + 1) + i;
        if (j == 0) return before + i;
        const std::size_t row = before + (a + 1) + 2 * (j - 1);
        return row + (j == b ? i : (std::min)(i, std::size_t{1}));
    };
    std::array<std::size_t, 3> index{};
    for (index[2] = 0; index[2] <= c; ++index[2]) {
        for (index[1] = 0; index[1] <= b; ++index[1]) {
            const bool whole = index[2] == 0 || index[2] == c || index[1] == 0 || index[1] == b;
            const std::size_t step = whole ? 1 : a; // skips the interior
            for (index[0] = 0; index[0] <= a; index[0] += step) {
                auto& p = vertices.emplace_back();
                for (std::size_t k = 0; k < 3; ++k) {
                    const double t = double(index[k]) / double(divisions[k]);
                    p[k] = static_cast<T>((1 - t) * double(lower[k]) + t * double(upper[k]));
                }
            }
        }
    }

    std::vector<std::array<std::uint32_t, 4>> faces; // counter-clockwise seen from outside
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [s, t] = detail::other_axes[axis];
        for (const bool on_upper : {false, true}) {
            std::array<std::size_t, 3> low{};
            low[axis] = on_upper ? divisions[axis] : 0;
            for (low[t] = 0; low[t] < divisions[t]; ++low[t]) {
                for (low[s] = 0; low[s] < divisions[s]; ++low[s]) {
                    auto& face = faces.emplace_back();
                    for (std::size_t n = 0; n < 4; ++n) { // around the rectangle
                        auto corner = low;
                        corner[s] += n == 1 || n == 2 ? 1 : 0;
                        corner[t] += n >= 2 ? 1 : 0;
                        face[n] = static_cast<std::uint32_t>(slot(corner));
                    }
                    // For the second axis, (axis, s, t) is a left-handed frame.
                    if (on_upper == (axis == 1)) std::swap(face[1], face[3]);
                }
            }
        }
    }
    return {vertices, faces};
}

} // namespace cageform::inline CAGEFORM_ABI
