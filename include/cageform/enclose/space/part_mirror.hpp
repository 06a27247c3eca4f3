// The mirror of a cage, which find_parts looks for.
#pragma once

#include <cageform/enclose/space/part_surface.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A mirror across an axis that maps a mesh to itself: images of vertices and faces.
struct MeshMirror {
    std::size_t axis = 0;
    double position = 0;
    MirrorImages vertices, faces;
};

/// The first of the axes x, y, z across whose middle the mesh is its own image, to 1e-5 of its diagonal, less
/// than a written cage is rounded to. O(n log n), more where many vertices have one coordinate.
inline std::optional<MeshMirror> mirror_of(std::span<const Vec<double, 3>> points,
                                           std::span<const std::array<std::uint32_t, 3>> faces) {
    Vec<double, 3> low = points[0], high = low;
    for (const auto& p : points) {
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = (std::min)(low[k], p[k]);
            high[k] = (std::max)(high[k], p[k]);
        }
    }
    const auto size = high - low;
    const double close = 1e-5 * std::sqrt(dot(size, size));
    constexpr std::uint32_t none = ~std::uint32_t{0};
    using Face = std::array<std::uint32_t, 3>;
    std::vector<std::pair<Face, std::uint32_t>> sorted; // corners ascending
    const auto ascending = [](Face face) {
        std::sort(face.begin(), face.end());
        return face;
    };
    for (std::uint32_t f = 0; f < faces.size(); ++f) sorted.push_back({ascending(faces[f]), f});
    std::sort(sorted.begin(), sorted.end());

    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t along = (axis + 1) % 3; // in whose order vertices are looked up
        std::vector<std::uint32_t> order(points.size());
        for (std::uint32_t v = 0; v < order.size(); ++v) order[v] = v;
        std::sort(order.begin(), order.end(),
                  [&](auto v, auto w) { return points[v][along] < points[w][along]; });
        MeshMirror mirror{axis, 0.5 * (low[axis] + high[axis]), {}, {}};
        for (const auto& p : points) {
            auto wanted = p;
            wanted[axis] = 2 * mirror.position - p[axis];
            auto found = none;
            auto n = std::lower_bound(order.begin(), order.end(), wanted[along] - close,
                                      [&](auto v, double x) { return points[v][along] < x; });
            for (; n != order.end() && points[*n][along] <= wanted[along] + close && found == none; ++n) {
                const auto off = points[*n] - wanted;
                if (dot(off, off) <= close * close) found = *n;
            }
            if (found == none) break;
            mirror.vertices.push_back(found);
        }
        if (mirror.vertices.size() < points.size()) continue;
        bool is_symmetric = true;
        for (std::uint32_t v = 0; v < points.size(); ++v)
            is_symmetric &= mirror.vertices[mirror.vertices[v]] == v;
        for (const auto& [a, b, c] : faces) {
            const Face image = ascending({mirror.vertices[a], mirror.vertices[b], mirror.vertices[c]});
            const auto at =
                std::lower_bound(sorted.begin(), sorted.end(), std::pair{image, std::uint32_t{0}});
            is_symmetric &= at != sorted.end() && at->first == image;
            if (!is_symmetric) break;
            mirror.faces.push_back(at->second);
        }
        if (is_symmetric) return mirror;
    }
    return std::nullopt;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
