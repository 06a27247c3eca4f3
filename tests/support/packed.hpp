// Reads a packed binding number by number, as its documentation describes it.
#pragma once

#include "aligned.hpp"
#include "bindings.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone.hpp>

namespace cageform_tests {

using cageform::PackedBindingView;
using cageform::WeightFormat;

inline double plain_half(std::uint16_t half) {
    const int exponent = (half >> 10) & 31, fraction = half & 1023;
    const double size =
        exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
    return half & 0x8000 ? -size : size;
}

/// The number stored for a point of a row, without the scale.
template <class T, std::size_t D>
double stored_number(const PackedBindingView<T, D>& view, std::size_t row, std::size_t lane) {
    const std::size_t n = row * cageform::lane_count<T> + lane;
    const auto read = [&]<class X>(X x) {
        std::memcpy(&x, view.weights + n * sizeof(X), sizeof(X));
        return x;
    };
    switch (view.format) {
    case WeightFormat::scalar: return double(read(T{}));
    case WeightFormat::half: return plain_half(read(std::uint16_t{}));
    case WeightFormat::int16: return double(read(std::int16_t{}));
    case WeightFormat::int8: return double(read(std::int8_t{}));
    }
    return 0;
}

/// The weights a clone has in effect: [point][handle].
template <class T, std::size_t D>
std::vector<std::vector<double>> effective_weights(const PackedBindingView<T, D>& view) {
    std::vector<std::vector<double>> weights(view.points, std::vector<double>(view.handles, 0.0));
    constexpr std::size_t lanes = cageform::lane_count<T>;
    for (std::size_t place = 0; place < view.points; ++place) {
        const std::size_t block = place / lanes, lane = place % lanes;
        auto& row = weights[view.order != nullptr ? view.order[place] : place];
        for (std::size_t r = view.first_row(block); r < view.first_row(block + 1); ++r)
            row[view.handle_of_row(block, r)] +=
                (view.scale != nullptr ? double(view.scale[block]) : 1.0) * stored_number(view, r, lane);
        for (std::size_t h = 0; view.residual != nullptr && h < view.handles; ++h) {
            for (std::size_t k = 0; k <= D; ++k)
                row[h] += double(view.residual[block * (D + 1) + k][lane]) * double(view.affine_fit[h][k]);
        }
    }
    return weights;
}

} // namespace cageform_tests
