// Measures of a 3D cage.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/enclose/space/shell.hpp>

#include <numbers>

namespace cageform::inline CAGEFORM_ABI::detail {

/// One vertex of each connected component of a figure; of 4,096 components if there are more.
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
    if (corners.size() > most) {
        for (std::size_t k = 0; k < most; ++k) corners[k] = corners[k * corners.size() / most];
        corners.resize(most);
    }
    return corners;
}

/// Smallest angle of a face, in degrees.
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
