// Shared parts of the tests of Green coordinates in the plane and in space.
#pragma once

#include "../catch.hpp"
#include "gradients.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/pose_handles.hpp>

namespace cageform_tests {

/// The residuals of Σ w κ = 1, and of Σ w H = p relative to the size of both.
template <class C, class T, std::size_t D>
double missed(const C& green, const std::vector<T>& row, const Vec<T, D>& p) {
    const auto moved = combine(row, green.handles());
    long double sum = -1;
    for (std::size_t i = 0; i < green.cage().size(); ++i) sum += static_cast<long double>(row[i]);
    const double size = size_of(green.cage().vertices()) + distance(p, green.cage()[0]);
    return std::max(double(std::fabs(sum)) / absolute_sum(row), distance(moved, p) / size);
}

/// Returns the Jacobian of the map of a pose at a point: J = Σ H' ∇wᵀ.
template <class T, std::size_t D>
Vec<Vec<long double, D>, D> jacobian(const std::vector<Vec<T, D>>& gradients,
                                     const std::vector<Vec<T, D>>& posed) {
    Vec<Vec<long double, D>, D> rows{};
    for (std::size_t h = 0; h < posed.size(); ++h) {
        for (std::size_t k = 0; k < D; ++k)
            rows[k] = rows[k] +
                      static_cast<long double>(posed[h][k]) * cageform::vec_cast<long double>(gradients[h]);
    }
    return rows;
}

template <class T, std::size_t D>
std::vector<Vec<T, D>> posed_handles(const cageform::Binding<T, D>& binding,
                                     const std::vector<Vec<T, D>>& vertices) {
    std::vector<Vec<T, D>> handles(binding.handle_count());
    REQUIRE(cageform::pose_handles(binding, vertices, handles).status == Status::ok);
    return handles;
}

} // namespace cageform_tests
