// Points inside meshes, and poses at random.
#pragma once

#include "meshes.hpp"
#include "weights.hpp"

namespace cageform_tests {

template <class T>
Points3<T> points_in(const cageform::TriangleMesh<T>& mesh, std::size_t count, std::uint64_t seed) {
    MeshData data;
    for (const auto& v : mesh.vertices()) data.vertices.push_back(vec_cast<double>(v));
    Random random(seed);
    Points3<T> points;
    while (points.size() < count) {
        const auto p = vec_cast<T>(points_about(data, 1, random.bits())[0]);
        if (locate(mesh, p, T(0)) == PointState::inside) points.push_back(p);
    }
    return points;
}

/// Handles, each moved along every axis by up to `reach`.
template <class T, std::size_t D>
std::vector<Vec<T, D>> shaken(std::span<const Vec<T, D>> handles, double reach, std::uint64_t seed) {
    Random random(seed);
    std::vector<Vec<T, D>> pose(handles.begin(), handles.end());
    for (auto& c : pose) {
        for (std::size_t k = 0; k < D; ++k) c[k] += T(random.uniform(-reach, reach));
    }
    return pose;
}

} // namespace cageform_tests
