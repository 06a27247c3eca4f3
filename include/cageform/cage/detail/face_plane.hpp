// The plane of a face with any number of corners, and the triangulation of the face in this plane.
#pragma once

#include <cageform/cage/detail/primitives.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// An orthonormal frame of a face's plane. `normal` points outward if the corners are counter-clockwise seen
/// from outside; `u` is parallel to the longest edge, so the sides of a rectangle are parallel to the axes.
struct FacePlane {
    Vec<double, 3> origin{}, u{1, 0, 0}, v{0, 1, 0}, normal{0, 0, 1};
    bool has_area = false; ///< whether the corners define a normal; if not, the frame is the default

    FacePlane() = default;
    /// Makes the plane through the centroid of the corners with Newell's normal, the sum of the cross
    /// products of consecutive corners.
    explicit FacePlane(std::span<const Vec<double, 3>> corners) noexcept {
        const auto scale = unit_scale(bounds_of(corners)); // keeps products in range
        for (const auto& c : corners) origin = origin + (1.0 / double(corners.size())) * c;
        Vec<double, 3> sum{}, longest{};
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const auto a = scale * (corners[k] - origin);
            const auto b = scale * (corners[(k + 1) % corners.size()] - origin);
            sum = sum + cross(a, b);
            if (dot(b - a, b - a) > dot(longest, longest)) longest = b - a;
        }
        if (!(dot(sum, sum) > 0) || !is_finite(sum)) return;
        const auto n = (1 / length(sum)) * sum;
        const auto along = longest - dot(longest, n) * n;
        if (!(dot(along, along) > 0)) return;
        has_area = true;
        normal = n;
        u = (1 / length(along)) * along;
        v = cross(normal, u);
    }

    Vec<double, 2> flat(const Vec<double, 3>& p) const noexcept {
        return {dot(p - origin, u), dot(p - origin, v)};
    }
    double height(const Vec<double, 3>& p) const noexcept { return dot(p - origin, normal); }
};

/// The corner of a face with the largest distance from its plane, and that distance.
struct FarthestCorner {
    std::size_t corner = 0;
    double distance = 0;

    FarthestCorner(std::span<const Vec<double, 3>> corners, const FacePlane& plane) noexcept {
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const double height = std::fabs(plane.height(corners[k]));
            if (height > distance) corner = k;
            distance = std::fmax(distance, height);
        }
    }
};

/// Triangulates a simple counter-clockwise polygon. Clips ears (Meisters, Polygons have ears, Amer. Math.
/// Monthly 82, 1975), then flips diagonals until they are locally Delaunay (Lawson, Software for C1 surface
/// interpolation, 1977). The flips remove degenerate triangles at vertices with collinear neighbours.
class PolygonTriangulation {
public:
    using Triangle = std::array<std::uint32_t, 3>;

    explicit PolygonTriangulation(std::span<const Vec<double, 2>> at)
        : at_(at) {
        clip_ears();
        find_neighbours();
        flip_diagonals();
    }

    /// Returns n − 2 triangles as indices of the polygon's vertices, for any n ≥ 3 vertices, even if the
    /// polygon is not simple. Usually O(n²), O(n³) at worst.
    const Buffer<Triangle>& triangles() const noexcept { return triangles_; }

private:
    struct Corner {
        std::uint32_t before, after;
    };

    double area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const noexcept {
        return cross(at_[b] - at_[a], at_[c] - at_[a]);
    }
    double corner_area(const Buffer<Corner>& corners, std::uint32_t i) const noexcept {
        return area(corners[i].before, i, corners[i].after);
    }
    bool is_ear(const Buffer<Corner>& corners, std::uint32_t tip) const noexcept {
        if (!(corner_area(corners, tip) > 0)) return false;
        const auto [a, c] = corners[tip];
        // If any vertex lies in an ear, a non-convex vertex does.
        for (auto p = corners[c].after; p != a; p = corners[p].after) {
            const bool in_ear = area(a, tip, p) >= 0 && area(tip, c, p) >= 0 && area(c, a, p) >= 0;
            if (in_ear && corner_area(corners, p) <= 0) return false;
        }
        return true;
    }
    void clip_ears() {
        Buffer<Corner> corners;
        const auto n = std::uint32_t(at_.size());
        for (std::uint32_t i = 0; i < n; ++i) corners.push_back({(i + n - 1) % n, (i + 1) % n});
        std::uint32_t tip = 0;
        for (std::uint32_t left = n; left >= 3; --left) {
            for (std::uint32_t tried = 0; tried < left && !is_ear(corners, tip); ++tried)
                tip = corners[tip].after;
            const auto [before, after] = corners[tip];
            triangles_.push_back({before, tip, after});
            corners[before].after = after;
            corners[after].before = before;
            tip = corners[after].after; // skips a corner, so that the triangles do not form one fan
        }
    }

    /// Finds the neighbours of all triangles; edge k is opposite to corner k.
    void find_neighbours() {
        struct LoopEdge {
            std::uint32_t low, high, triangle, edge;
        };
        Buffer<LoopEdge> edges;
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            neighbours_.push_back({none, none, none});
            for (std::uint32_t k = 0; k < 3; ++k) {
                const auto [low, high] = std::minmax(triangles_[t][(k + 1) % 3], triangles_[t][(k + 2) % 3]);
                edges.push_back({low, high, t, k});
            }
        }
        std::sort(edges.begin(), edges.end(), [](const LoopEdge& a, const LoopEdge& b) {
            return a.low != b.low ? a.low < b.low : a.high < b.high;
        });
        for (std::size_t e = 1; e < edges.size(); ++e) {
            const LoopEdge &a = edges[e - 1], &b = edges[e];
            if (a.low != b.low || a.high != b.high) continue;
            neighbours_[a.triangle][a.edge] = b.triangle;
            neighbours_[b.triangle][b.edge] = a.triangle;
        }
    }

    void flip_diagonals() {
        std::size_t flips = 64 + triangles_.size() * triangles_.size(); // upper bound
        for (bool flipped = true; flipped && flips > 0;) {
            flipped = false;
            for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
                for (std::uint32_t k = 0; k < 3 && flips > 0; ++k) {
                    if (!flip(t, k)) continue;
                    flipped = true;
                    --flips;
                }
            }
        }
    }
    /// Flips an edge of a triangle if the two angles opposite to it sum to more than 180°.
    bool flip(std::uint32_t t, std::uint32_t k) {
        const std::uint32_t other = neighbours_[t][k];
        if (other == none) return false;
        std::uint32_t l = 0;
        while (neighbours_[other][l] != t) ++l;
        const std::uint32_t a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
        const std::uint32_t c = triangles_[other][l], d = triangles_[t][(k + 2) % 3];
        const auto sine_and_cosine = [&](std::uint32_t apex, std::uint32_t from, std::uint32_t to) {
            const auto u = at_[from] - at_[apex], v = at_[to] - at_[apex];
            return std::pair(cross(u, v), dot(u, v));
        };
        const auto [s, x] = sine_and_cosine(a, b, d);
        const auto [r, y] = sine_and_cosine(c, d, b);
        const double rounding = 1e-12 * std::hypot(s, x) * std::hypot(r, y);
        if (!(s * y + x * r < -rounding) || !(area(a, b, c) > 0) || !(area(a, c, d) > 0)) return false;
        const std::uint32_t beyond_b = neighbours_[other][(l + 1) % 3]; // across the edge from c to b
        const std::uint32_t beyond_d = neighbours_[t][(k + 1) % 3];     // across the edge from d to a
        replace_neighbour(beyond_b, other, t);
        replace_neighbour(beyond_d, t, other);
        const std::uint32_t below = neighbours_[t][(k + 2) % 3], above = neighbours_[other][(l + 2) % 3];
        triangles_[t] = {a, b, c};
        neighbours_[t] = {beyond_b, other, below};
        triangles_[other] = {a, c, d};
        neighbours_[other] = {above, beyond_d, t};
        return true;
    }
    void replace_neighbour(std::uint32_t triangle, std::uint32_t from, std::uint32_t to) noexcept {
        if (triangle == none) return;
        for (auto& neighbour : neighbours_[triangle]) {
            if (neighbour == from) {
                neighbour = to;
                return;
            }
        }
    }

    static constexpr std::uint32_t none = ~std::uint32_t{0};

    std::span<const Vec<double, 2>> at_;
    Buffer<Triangle> triangles_, neighbours_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
