// Bindings of random weights, and what clones of them are by definition.
#pragma once

#include "../catch.hpp"
#include "weights.hpp"

#include <cageform/clone/clone.hpp>

namespace cageform_tests {

/// Handles and points without a cage: any weights at all.
template <class T, std::size_t D>
cageform::Binding<T, D> random_binding(std::size_t points, std::size_t handles, std::uint64_t seed) {
    Random random(seed);
    const std::size_t blocks = cageform::block_count<T>(points);
    std::vector<cageform::Lanes<T>> weights(blocks * handles), rest(blocks * D);
    for (auto& lanes : weights) {
        for (T& w : lanes.v) w = T(random.uniform(-1, 1) / double(handles));
    }
    for (auto& lanes : rest) {
        for (T& x : lanes.v) x = T(random.uniform(-10, 10));
    }
    std::vector<Vec<T, D>> rest_handles(handles);
    for (auto& h : rest_handles) {
        for (std::size_t k = 0; k < D; ++k) h[k] = T(random.uniform(-10, 10));
    }
    return {std::move(weights), std::move(rest), std::move(rest_handles), points};
}

template <class T, std::size_t D>
std::vector<Vec<T, D>> random_points(std::size_t count, double reach, std::uint64_t seed) {
    Random random(seed);
    std::vector<Vec<T, D>> points(count);
    for (auto& p : points) {
        for (std::size_t k = 0; k < D; ++k) p[k] = T(random.uniform(-reach, reach));
    }
    return points;
}

/// The formula, in long double, point by point.
template <class T, std::size_t D>
Vec<long double, D> by_definition(const cageform::Binding<T, D>& binding, const std::vector<Vec<T, D>>& pose,
                                  std::size_t i) {
    auto p = cageform::vec_cast<long double>(binding.rest_point(i));
    for (std::size_t h = 0; h < binding.handle_count(); ++h) {
        p = p + static_cast<long double>(binding.weight(i, h)) *
                    (cageform::vec_cast<long double>(pose[h]) -
                     cageform::vec_cast<long double>(binding.rest_handle(h)));
    }
    return p;
}

/// Where the handles were when bound.
template <class T, std::size_t D>
std::vector<Vec<T, D>> binding_handles(const cageform::Binding<T, D>& binding) {
    const auto handles = binding.handle_view();
    return {handles.rest, handles.rest + handles.count};
}

template <class T, std::size_t D, class Pose>
std::vector<Vec<T, D>> cloned(const cageform::Binding<T, D>& binding, const Pose& pose) {
    std::vector<Vec<T, D>> out(binding.point_count());
    REQUIRE(cageform::clone(binding, pose, out) == Status::ok);
    return out;
}

} // namespace cageform_tests
