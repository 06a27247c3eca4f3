// Cages with faces of any number of corners.
#pragma once

#include "cages.hpp"

#include <cageform/cage/polyhedral_mesh.hpp>

namespace cageform_tests {

using Loops = std::vector<std::vector<std::uint32_t>>;

struct PolyhedronData {
    std::vector<Vec<double, 3>> vertices;
    Loops faces;

    template <class T>
    cageform::PolyhedralMesh<T> cage() const {
        return {vertices, faces};
    }
};

/// The prism over a polygon from z = 0 to z = height, outward: its floor is face 0, its ceiling face 1.
inline PolyhedronData prism_over(std::vector<Vec<double, 2>> base, double height) {
    double area = 0;
    for (std::size_t k = 0; k < base.size(); ++k) area += cross(base[k], base[(k + 1) % base.size()]);
    if (area < 0) std::reverse(base.begin(), base.end());
    PolyhedronData data;
    const auto n = std::uint32_t(base.size());
    for (const double z : {0.0, height}) {
        for (const auto& p : base) data.vertices.push_back({p[0], p[1], z});
    }
    data.faces.resize(2);
    for (std::uint32_t k = 0; k < n; ++k) {
        data.faces[0].push_back(n - 1 - k);
        data.faces[1].push_back(n + k);
        data.faces.push_back({k, (k + 1) % n, n + (k + 1) % n, n + k});
    }
    return data;
}

/// The prism over a random star with vertices in the middle of some edges, each loop begun anywhere.
inline PolyhedronData random_prism(std::uint64_t seed) {
    Random random(seed);
    const auto star = random_star<double>(seed);
    const double size = double(cageform::bounds_of(std::span<const Vec<double, 2>>(star)).diagonal());
    std::vector<Vec<double, 2>> corners, base;
    for (std::size_t k = 0; k < star.size(); k += 1 + star.size() / 12) corners.push_back(star[k]);
    for (std::size_t k = 0; k < corners.size(); ++k) {
        base.push_back(corners[k]);
        if (random.below(3) == 0) base.push_back(0.5 * (corners[k] + corners[(k + 1) % corners.size()]));
    }
    auto data = prism_over(base, size * random.uniform(0.2, 1));
    for (auto& face : data.faces)
        std::rotate(face.begin(), face.begin() + std::ptrdiff_t(random.below(face.size())), face.end());
    return data;
}

/// (0,0) (2,0) (2,1) (1,1) (1,2) (0,2), one high.
inline PolyhedronData l_prism() {
    return prism_over({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, 1);
}

} // namespace cageform_tests
