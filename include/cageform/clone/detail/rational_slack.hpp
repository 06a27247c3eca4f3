// Sums the negative weights of each point of a binding, for all storage formats.
#pragma once

#include <cageform/clone/detail/weight_rows.hpp>

#include <cstddef>
#include <limits>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Sums max(−w, 0) for the points of a block, one handle at a time.
template <Scalar T>
struct BlockSlack {
    Simd<T> negative = Simd<T>(T(0)), sum = Simd<T>(T(0));

    void add(const Simd<T>& w) noexcept {
        sum += w;
        negative -= (min)(w, Simd<T>(T(0)));
    }

    /// Returns the largest sum of the first `used` points, or infinity if a weight is not finite.
    T largest(std::size_t used) const noexcept {
        Lanes<T> negatives, sums;
        negative.store(negatives);
        sum.store(sums);
        T most = 0;
        for (std::size_t lane = 0; lane < used; ++lane) {
            if (!is_finite(negatives[lane]) || !is_finite(sums[lane]))
                return std::numeric_limits<T>::infinity();
            if (negatives[lane] > most) most = negatives[lane];
        }
        return most;
    }
};

/// Loads a row of a block's weights from its storage format.
template <WeightFormat Format, Scalar T>
Simd<T> load_row(const std::byte* row) noexcept {
    constexpr std::size_t group_bytes = lane_count<T> * weight_bytes<T>(Format) / Simd<T>::count;
    Simd<T> w;
    for (std::size_t group = 0; group < Simd<T>::count; ++group)
        w.r[group] = load_weights<Format, T>(row + group * group_bytes);
    return w;
}

/// Returns the slack of one block. Weights include the residual of the format.
template <WeightFormat Format, Scalar T, std::size_t D>
T block_slack(const PackedBindingView<T, D>& binding, std::size_t block) noexcept {
    constexpr std::size_t row_bytes = lane_count<T> * weight_bytes<T>(Format);
    BlockSlack<T> slack;
    std::size_t row = binding.first_row(block);
    const std::size_t end = binding.first_row(block + 1);
    if (binding.scale == nullptr) {
        for (; row < end; ++row) slack.add(load_row<Format, T>(binding.weights + row * row_bytes));
    } else {
        for (std::size_t handle = 0; handle < binding.handles; ++handle) {
            Simd<T> w(T(0));
            if (row < end && binding.handle_of_row(block, row) == handle)
                w = Simd<T>(binding.scale[block]) * load_row<Format, T>(binding.weights + row++ * row_bytes);
            for (std::size_t r = 0; r <= D; ++r)
                w = multiply_add<T>(Simd<T>::load(binding.residual[block * (D + 1) + r]),
                                    Simd<T>(binding.affine_fit[handle][r]), w);
            slack.add(w);
        }
    }
    const std::size_t left = binding.points - block * lane_count<T>;
    return slack.largest(left < lane_count<T> ? left : lane_count<T>);
}

/// Returns the largest slack of all points; not finite if a weight is not finite.
template <Scalar T, std::size_t D>
T largest_slack(const PackedBindingView<T, D>& binding) noexcept {
    T most = 0;
    for (std::size_t b = 0; b < binding.block_count(); ++b) {
        const T slack = with_format(binding.format,
                                    [&]<WeightFormat Format>() { return block_slack<Format>(binding, b); });
        if (!is_finite(slack)) return slack;
        if (slack > most) most = slack;
    }
    return most;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
