// The sums of a rational clone, and the check of the handles' weights.
#pragma once

#include <cageform/clone/clone.hpp>
#include <cageform/clone/types/rational_view.hpp>
#include <cageform/core/result.hpp>

#include <cstddef>
#include <span>
#include <type_traits>

namespace cageform::inline CAGEFORM_ABI {

template <AnyBinding B>
auto rational_view(const B& binding) noexcept; // in clone/clone_rational.hpp

namespace detail {

template <class View>
inline constexpr bool is_rational_view = false;
template <class View>
inline constexpr bool is_rational_view<RationalView<View>> = true;

template <class B>
auto as_rational(const B& binding) noexcept {
    if constexpr (is_rational_view<B>) {
        return Result<RationalView<std::remove_cvref_t<decltype(binding.binding())>>>{binding, Status::ok};
    } else {
        return rational_view(binding);
    }
}

/// The range of the handles' weights.
template <Scalar T>
struct WeightRange {
    T least, most;
};

/// Checks the handles' weights. The bounded ratio keeps 1 + Ω of every point at least 1/2, and products do
/// not overflow unless the pose is out of range.
template <Scalar T>
Status check_weights(std::span<const T> weights, std::size_t handles, T slack,
                     WeightRange<T>& range) noexcept {
    if (weights.size() != handles) return Status::weights_do_not_match;
    range = {1, 1};
    for (std::size_t i = 0; i < handles; ++i) {
        const T w = weights[i];
        if (!is_finite(w) || !(w > 0)) return Status::weights_not_positive;
        if (i == 0) range = {w, w};
        if (w < range.least) range.least = w;
        if (w > range.most) range.most = w;
    }
    const T gap = range.most - range.least;
    if (T(0x1p-60) * range.most > range.least || slack * gap > range.least / 2)
        return Status::weights_too_far_apart;
    return Status::ok;
}

/// Returns the mean of a pose.
template <Scalar T, std::size_t D, class Pose>
Vec<T, D> middle_of(const Pose& pose, std::size_t handles) noexcept {
    Vec<T, D> middle{};
    for (std::size_t i = 0; i < handles; ++i) middle = middle + (T(1) / T(handles)) * to_vec<T>(pose[i]);
    return middle;
}

/// The terms of a handle in the numerator and denominator of a rational clone: d + (ω − 1)(C' − g) and ω − 1.
/// ω is relative to the smallest weight, so nothing cancels.
template <Scalar T, std::size_t D, class Pose>
struct RationalDisplacements {
    PoseDisplacements<T, D, Pose> displacement;
    const T* weights;
    T least;
    Vec<T, D> middle;

    Vec<T, D + 1> operator()(std::size_t i) const noexcept {
        const Vec<T, D> d = displacement(i), from_middle = to_vec<T>(displacement.pose[i]) - middle;
        Vec<T, D + 1> sum;
        sum[D] = (weights[i] - least) / least;
        for (std::size_t k = 0; k < D; ++k) sum[k] = multiply_add<T>(sum[D], from_middle[k], d[k]);
        return sum;
    }
};

/// Stores the points of a rational clone: p + (N − Ω (p − g)) / (1 + Ω).
template <Scalar T, std::size_t D, class Out>
struct RationalTarget {
    static constexpr std::size_t columns = D + 1;

    CloneTarget<T, D, Out> target;
    const Lanes<T>* rest;
    Vec<T, D> middle;

    void write(std::size_t block, Lanes<T>* sums) const noexcept {
        const Simd<T> omega = Simd<T>::load(sums[D]), whole = Simd<T>(T(1)) + omega;
        for (std::size_t k = 0; k < D; ++k) {
            const Simd<T> from_middle = Simd<T>::load(rest[block * D + k]) - Simd<T>(middle[k]);
            ((Simd<T>::load(sums[k]) - omega * from_middle) / whole).store(sums[k]);
        }
        target.write(block, sums);
    }
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
