// Measures a cage in space that make_cage has made: the exact clearance, the least angle.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/core/detail/disjoint_sets.hpp>
#include <cageform/enclose/space/shell.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The distance between two triangles; 0 if they meet.
inline double facet_distance(const Corners<3>& a, const Corners<3>& b) noexcept {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3 && least > 0; ++k) {
        least = (std::min)(least, segment_to_facet(a[k], a[(k + 1) % 3], b));
        least = (std::min)(least, segment_to_facet(b[k], b[(k + 1) % 3], a));
    }
    return least;
}

/// The least distance between the faces of a cage and those of a figure; at most `reach` is returned.
template <Scalar T>
double exact_clearance(const TriangleMesh<T>& cage, std::span<const Corners<3>> figure, double reach) {
    std::vector<Facet<3>> facets;
    double edges = 0;
    for (const auto& face : cage.faces()) {
        facets.emplace_back(face, cage.vertices());
        edges += length(facets.back().corner[1] - facets.back().corner[0]);
    }
    FaceHash hash(edges / double(facets.size()), facets.size());
    for (std::uint32_t f = 0; f < facets.size(); ++f) hash.add(f, facets[f].corner);
    double least = reach;
    for (const auto& corner : figure) {
        const auto middle = (1.0 / 3) * (corner[0] + corner[1] + corner[2]);
        double radius = 0;
        for (const auto& p : corner) radius = (std::max)(radius, length(p - middle));
        const auto box = box_of(corner).widened(least);
        (void)hash.any(box, [&](std::uint32_t f) {
            if (distance_to_facet(middle, facets[f].corner) - radius < least)
                least = (std::min)(least, facet_distance(corner, facets[f].corner));
            return false;
        });
    }
    return least;
}

/// One vertex of each connected component of a figure; if there are more than 4,096, of components spread
/// over the list.
template <class F>
std::vector<std::size_t> component_corners(const F& faces, std::size_t vertices) {
    DisjointSets components(vertices);
    for (std::size_t f = 0; f < std::size(faces); ++f) {
        for (std::size_t k = 1; k < 3; ++k)
            components.join(std::uint32_t(faces[f][k]), std::uint32_t(faces[f][0]));
    }
    std::vector<std::size_t> corners;
    std::vector<bool> seen(vertices);
    for (std::size_t f = 0; f < std::size(faces); ++f) {
        const std::size_t component = components.find(std::uint32_t(faces[f][0]));
        if (!seen[component]) corners.push_back(std::size_t(faces[f][0]));
        seen[component] = true;
    }
    constexpr std::size_t most = 4096;
    if (corners.size() <= most) return corners;
    std::vector<std::size_t> some;
    some.reserve(most);
    for (std::size_t k = 0; k < most; ++k) some.push_back(corners[k * corners.size() / most]);
    return some;
}

/// The smallest angle of a face, in degrees.
template <Scalar T>
double least_angle(const TriangleMesh<T>& cage) {
    double least = std::numbers::pi;
    for (const auto& face : cage.faces()) {
        const Facet<3> facet(face, cage.vertices());
        for (std::size_t k = 0; k < 3; ++k) {
            const auto u = facet.corner[(k + 1) % 3] - facet.corner[k],
                       v = facet.corner[(k + 2) % 3] - facet.corner[k];
            least = (std::min)(least, std::atan2(length(cross(u, v)), dot(u, v)));
        }
    }
    return least * 180 / std::numbers::pi;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
