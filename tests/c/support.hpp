// Helpers of the tests of the C interface.
#pragma once

#include "../support/meshes.hpp"

#include <cageform/c/cageform.h>

namespace c_interface_tests {

using namespace cageform_tests;

template <class T, std::size_t D>
cageform_points points_of(const std::vector<Vec<T, D>>& points) {
    return {points.data(),
            points.size(),
            0,
            points.size() * sizeof(points[0]),
            std::is_same_v<T, double> ? 1u : 0u,
            std::uint32_t(D)};
}
template <class T, std::size_t D>
cageform_output output_of(std::vector<Vec<T, D>>& points) {
    return {points.data(),
            points.size(),
            0,
            points.size() * sizeof(points[0]),
            std::is_same_v<T, double> ? 1u : 0u,
            std::uint32_t(D)};
}
template <class S>
S sized() {
    S its{};
    its.size = sizeof(S);
    return its;
}

inline cageform_drawing drawing_of(const std::vector<Vec<double, 3>>& vertices,
                                   const std::vector<std::uint32_t>& indices) {
    auto its = sized<cageform_drawing>();
    its.points = points_of(vertices);
    its.indices = indices.data();
    its.index_count = indices.size();
    return its;
}

/// Frees an object at the end of a scope.
template <class X>
struct Owned {
    X* object = nullptr;
    Owned() = default;
    Owned(const Owned&) = delete;
    Owned& operator=(const Owned&) = delete;
    ~Owned() { cageform_free(object); }
};

} // namespace c_interface_tests
