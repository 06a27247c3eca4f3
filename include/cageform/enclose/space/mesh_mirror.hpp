// Mirror symmetry of a mesh.
#pragma once

#include <cageform/core/types/bounds.hpp>
#include <cageform/enclose/space/part_surface.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A reflection perpendicular to an axis that maps a mesh to itself.
struct MeshMirror {
    std::size_t axis = 0;
    double position = 0;
    MirrorImages vertices, faces;
};

/// Returns the reflection if it maps the mesh to itself.
///
///   tolerance  maximum distance of a vertex from the image of another
///   cost       O(n log n), more if many vertices share a coordinate
inline std::optional<MeshMirror> mirror_across(std::size_t axis, double position, double tolerance,
                                               std::span<const Vec<double, 3>> points,
                                               std::span<const std::array<std::uint32_t, 3>> faces) {
    constexpr std::uint32_t none = ~std::uint32_t{0};
    const std::size_t along = (axis + 1) % 3; // vertices are sorted along this axis
    std::vector<std::uint32_t> order(points.size());
    for (std::uint32_t v = 0; v < order.size(); ++v) order[v] = v;
    std::sort(order.begin(), order.end(),
              [&](auto v, auto w) { return points[v][along] < points[w][along]; });
    MeshMirror mirror{axis, position, {}, {}};
    for (const auto& p : points) {
        auto wanted = p;
        wanted[axis] = 2 * position - p[axis];
        auto found = none;
        auto n = std::lower_bound(order.begin(), order.end(), wanted[along] - tolerance,
                                  [&](auto v, double x) { return points[v][along] < x; });
        for (; n != order.end() && points[*n][along] <= wanted[along] + tolerance && found == none; ++n) {
            const auto off = points[*n] - wanted;
            if (dot(off, off) <= tolerance * tolerance) found = *n;
        }
        if (found == none) return std::nullopt;
        mirror.vertices.push_back(found);
    }
    for (std::uint32_t v = 0; v < points.size(); ++v) {
        if (mirror.vertices[mirror.vertices[v]] != v) return std::nullopt;
    }

    using Face = std::array<std::uint32_t, 3>;
    const auto ascending = [](Face face) {
        std::sort(face.begin(), face.end());
        return face;
    };
    std::vector<std::pair<Face, std::uint32_t>> sorted;
    sorted.reserve(faces.size());
    for (std::uint32_t f = 0; f < faces.size(); ++f) sorted.push_back({ascending(faces[f]), f});
    std::sort(sorted.begin(), sorted.end());
    for (const auto& [a, b, c] : faces) {
        const Face image = ascending({mirror.vertices[a], mirror.vertices[b], mirror.vertices[c]});
        const auto at = std::lower_bound(sorted.begin(), sorted.end(), std::pair{image, std::uint32_t{0}});
        if (at == sorted.end() || at->first != image) return std::nullopt;
        mirror.faces.push_back(at->second);
    }
    return mirror;
}

/// First axis x, y, z about whose middle the mesh is symmetric, within 1e-5 of its diagonal. This tolerates
/// the rounding of cage files.
inline std::optional<MeshMirror> mirror_of(std::span<const Vec<double, 3>> points,
                                           std::span<const std::array<std::uint32_t, 3>> faces) {
    const auto box = bounds_of(points);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double middle = 0.5 * (box.lower[axis] + box.upper[axis]);
        if (auto mirror = mirror_across(axis, middle, 1e-5 * box.diagonal(), points, faces)) return mirror;
    }
    return std::nullopt;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
