#pragma once

// Triangle meshes of implicit surfaces, and functions of solids, which are negative inside.

#include <cageform/core/vec.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace cageform_support {

using Point3 = cageform::Vec<double, 3>;

struct ImplicitMesh {
    std::vector<Point3> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces;
};

inline double length(const Point3& p) {
    return std::hypot(p[0], p[1], p[2]);
}

// Functions that are negative inside, with values close to the signed distance.

inline double ball(const Point3& p, const Point3& centre, double radius) {
    return length(p - centre) - radius;
}

inline double ellipsoid(const Point3& p, const Point3& centre, const Point3& radii) {
    const Point3 d = p - centre;
    const Point3 u{d[0] / radii[0], d[1] / radii[1], d[2] / radii[2]};
    const Point3 slope{u[0] / radii[0], u[1] / radii[1], u[2] / radii[2]}; // gradient of |u|, times |u|
    const double level = length(u);
    // Near the centre, where the slope vanishes, any negative value is correct.
    return level > 1e-6 ? level * (level - 1) / length(slope) : -radii[0];
}

/// A rod from `a` to `b` with round ends and a radius for each end.
inline double limb(const Point3& p, const Point3& a, const Point3& b, double radius_a, double radius_b) {
    const Point3 axis = b - a;
    const double t = std::clamp(dot(p - a, axis) / dot(axis, axis), 0.0, 1.0);
    return length(p - a - t * axis) - (radius_a + t * (radius_b - radius_a));
}

/// The union of two solids, rounded where the functions differ by less than `blend`.
inline double join(double a, double b, double blend) {
    const double near = std::max(blend - std::fabs(a - b), 0.0);
    return std::min(a, b) - near * near / (4 * blend);
}

/// The difference of two solids: the part of `a` outside `b`.
inline double carve(double a, double b, double blend) {
    return -join(-a, b, blend);
}

/// The gradient, which points outwards, by finite differences.
template <class F>
Point3 slope(const F& f, const Point3& p) {
    constexpr double step = 1e-5;
    Point3 g;
    for (std::size_t k = 0; k < 3; ++k) {
        Point3 a = p, b = p;
        a[k] -= step;
        b[k] += step;
        g[k] = (f(b) - f(a)) / (2 * step);
    }
    return g;
}

/// Adds two triangles around every edge of a grid that the surface intersects.
///
///   value    of the function, by node
///   vertex   of the mesh, by the lowest node of its cell
///   stride   from a node to the next, by axis
inline void add_faces(ImplicitMesh& mesh, const std::vector<double>& value,
                      const std::vector<std::uint32_t>& vertex, const std::array<std::size_t, 3>& stride) {
    for (std::size_t i = 0; i < value.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t u = stride[(axis + 1) % 3], v = stride[(axis + 2) % 3];
            if (i + stride[axis] >= value.size()) continue;
            const bool inside = value[i] < 0;
            if (inside == (value[i + stride[axis]] < 0)) continue;
            // The border of the grid is outside, so all four cells around the edge exist.
            std::array<std::uint32_t, 4> quad{vertex[i - u - v], vertex[i - v], vertex[i], vertex[i - u]};
            if (!inside) std::swap(quad[1], quad[3]);
            const auto& p = mesh.vertices;
            const bool other = length(p[quad[1]] - p[quad[3]]) < length(p[quad[0]] - p[quad[2]]);
            const std::size_t first = other ? 1 : 0;
            for (const std::size_t k : {first + 1, first + 2})
                mesh.faces.push_back({quad[first], quad[k % 4], quad[(k + 1) % 4]});
        }
    }
}

/// The surface where a function is zero, by surface nets (Gibson 1998): a vertex in every cell of a grid that
/// the surface intersects, and a quadrilateral around every edge of the grid that it crosses.
template <class F>
ImplicitMesh surface_nets(const F& f, const Point3& low, const Point3& high, double cell) {
    std::array<std::size_t, 3> n;
    for (std::size_t k = 0; k < 3; ++k) n[k] = std::size_t(std::ceil((high[k] - low[k]) / cell)) + 1;
    const auto node = [&](std::size_t x, std::size_t y, std::size_t z) { return (z * n[1] + y) * n[0] + x; };
    const std::array<std::size_t, 3> stride{1, n[0], n[0] * n[1]};
    const auto place = [&](std::size_t x, std::size_t y, std::size_t z) {
        return low + cell * Point3{double(x), double(y), double(z)};
    };
    std::vector<double> value(n[0] * n[1] * n[2]);
    for (std::size_t z = 0; z < n[2]; ++z) {
        for (std::size_t y = 0; y < n[1]; ++y) {
            for (std::size_t x = 0; x < n[0]; ++x) value[node(x, y, z)] = f(place(x, y, z));
        }
    }

    ImplicitMesh mesh;
    std::vector<std::uint32_t> vertex(value.size(), ~std::uint32_t{0}); // by the lowest node of its cell
    for (std::size_t z = 0; z + 1 < n[2]; ++z) {
        for (std::size_t y = 0; y + 1 < n[1]; ++y) {
            for (std::size_t x = 0; x + 1 < n[0]; ++x) {
                const std::size_t lowest = node(x, y, z);
                // The mean of the intersections with the twelve edges.
                Point3 sum{};
                int crossings = 0;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
                    for (std::size_t edge = 0; edge < 4; ++edge) {
                        Point3 from{};
                        from[u] = double(edge % 2);
                        from[v] = edge < 2 ? 0 : 1;
                        const std::size_t i = lowest + (edge % 2) * stride[u] + (edge / 2) * stride[v];
                        const double a = value[i], b = value[i + stride[axis]];
                        if ((a < 0) == (b < 0)) continue;
                        from[axis] = a / (a - b);
                        sum = sum + from;
                        ++crossings;
                    }
                }
                if (crossings == 0) continue;
                Point3 p = place(x, y, z) + (cell / crossings) * sum;
                for (int step = 0; step < 3; ++step) { // onto the surface, by Newton's method
                    const Point3 g = slope(f, p);
                    p = p - (f(p) / dot(g, g)) * g;
                }
                vertex[lowest] = std::uint32_t(mesh.vertices.size());
                mesh.vertices.push_back(p);
            }
        }
    }
    add_faces(mesh, value, vertex, stride);
    return mesh;
}

} // namespace cageform_support
