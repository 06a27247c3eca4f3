#pragma once

// Self-intersection of a triangle mesh.

#include "files/mesh_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace cageform_sources {

using namespace cageform_support;

/// The intersection of the segment from p to q with the interior of a triangle, if any.
inline std::optional<Point3> pierced(const Point3& p, const Point3& q,
                                     const std::array<Point3, 3>& triangle) {
    const Point3 normal = cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
    const double from = dot(normal, p - triangle[0]), to = dot(normal, q - triangle[0]);
    if (!(from * to < 0)) return std::nullopt;
    const double t = from / (from - to);
    const Point3 at = (1 - t) * p + t * q;
    for (std::size_t k = 0; k < 3; ++k) {
        const Point3& a = triangle[k];
        if (dot(cross(triangle[(k + 1) % 3] - a, at - a), normal) < 0) return std::nullopt;
    }
    return at;
}

/// The bounds of a triangle.
struct TriangleBox {
    std::array<double, 3> low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};

    TriangleBox(std::span<const Point3> vertices, const std::array<std::uint32_t, 3>& triangle) {
        for (const std::uint32_t i : triangle) {
            for (std::size_t k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], vertices[i][k]);
                high[k] = std::max(high[k], vertices[i][k]);
            }
        }
    }
};

/// The segment in which two triangles intersect, if they intersect in one.
inline std::optional<std::array<Point3, 2>> intersection(const std::array<Point3, 3>& a,
                                                         const std::array<Point3, 3>& b) {
    std::vector<Point3> ends;
    for (std::size_t k = 0; k < 3; ++k) {
        if (const auto at = pierced(a[k], a[(k + 1) % 3], b)) ends.push_back(*at);
        if (const auto at = pierced(b[k], b[(k + 1) % 3], a)) ends.push_back(*at);
    }
    if (ends.size() != 2) return std::nullopt;
    return std::array{ends[0], ends[1]};
}

/// The double curve of a surface: one segment per pair of intersecting triangles. Triangles with a common
/// corner are ignored.
///
///   cost   O(triangles), if they have similar sizes
inline std::vector<std::array<Point3, 2>>
double_curve(std::span<const Point3> vertices, std::span<const std::array<std::uint32_t, 3>> triangles) {
    using Cell = std::array<std::int32_t, 3>;
    std::vector<TriangleBox> boxes;
    double side = 0; // of a cell: twice the mean extent
    for (const auto& triangle : triangles) {
        const TriangleBox& box = boxes.emplace_back(vertices, triangle);
        for (std::size_t k = 0; k < 3; ++k)
            side += (box.high[k] - box.low[k]) * 2 / (3 * double(triangles.size()));
    }
    std::vector<std::array<Point3, 2>> pieces;
    if (!(side > 0)) return pieces;
    const auto cell_of = [&](const std::array<double, 3>& at) {
        Cell cell;
        for (std::size_t k = 0; k < 3; ++k) cell[k] = std::int32_t(std::floor(at[k] / side));
        return cell;
    };
    std::vector<std::pair<Cell, std::uint32_t>> members; // triangles by cell, sorted by cell
    for (std::uint32_t f = 0; f < triangles.size(); ++f) {
        const Cell from = cell_of(boxes[f].low), to = cell_of(boxes[f].high);
        for (std::int32_t x = from[0]; x <= to[0]; ++x)
            for (std::int32_t y = from[1]; y <= to[1]; ++y)
                for (std::int32_t z = from[2]; z <= to[2]; ++z) members.push_back({{x, y, z}, f});
    }
    std::sort(members.begin(), members.end());
    const auto corners = [&](std::uint32_t f) {
        const auto& [a, b, c] = triangles[f];
        return std::array{vertices[a], vertices[b], vertices[c]};
    };
    for (std::size_t m = 0; m < members.size(); ++m) {
        const auto& [cell, f] = members[m];
        for (std::size_t n = m + 1; n < members.size() && members[n].first == cell; ++n) {
            const std::uint32_t g = members[n].second;
            std::array<double, 3> low{};
            bool apart = false;
            for (std::size_t k = 0; k < 3; ++k) {
                low[k] = std::max(boxes[f].low[k], boxes[g].low[k]);
                apart |= low[k] > std::min(boxes[f].high[k], boxes[g].high[k]);
            }
            if (apart || cell_of(low) != cell) continue; // tests each pair in one cell only
            const auto &a = triangles[f], &b = triangles[g];
            if (std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end()) continue;
            const auto piece = intersection(corners(f), corners(g));
            if (!piece) continue;
            const Point3 along = (*piece)[1] - (*piece)[0];
            if (dot(along, along) > 1e-18 * side * side) pieces.push_back(*piece); // else they touch
        }
    }
    return pieces;
}

} // namespace cageform_sources
