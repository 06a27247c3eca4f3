// The rational clone: every handle has a weight that may change every frame. A heavier handle pulls
// the figure towards it.
#pragma once

#include <cageform/clone/clone.hpp>
#include <cageform/core/result.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// A binding whose weights are suitable for rational clones; owns nothing. Made by `rational_view`.
template <class View>
class RationalView {
public:
    using scalar = typename View::scalar;
    static constexpr std::size_t dimension = View::dimension;

    RationalView() = default;
    RationalView(const View& binding, scalar slack) noexcept
        : binding_(binding)
        , slack_(slack) {}

    std::size_t handle_count() const noexcept { return binding_.handle_count(); }
    std::size_t point_count() const noexcept { return binding_.point_count(); }
    const View& binding() const noexcept { return binding_; }
    /// Returns the largest absolute sum of a point's negative weights.
    scalar slack() const noexcept { return slack_; }

private:
    View binding_;
    scalar slack_ = 0;
};

namespace detail {

/// Sums max(−w, 0) for the points of a block, given their weights one handle after the other.
template <Scalar T>
struct BlockSlack {
    Simd<T> negative = Simd<T>(T(0)), sum = Simd<T>(T(0));

    void add(const Simd<T>& w) noexcept {
        sum += w;
        negative -= (min)(w, Simd<T>(T(0)));
    }

    /// Returns the largest sum of the first `used` points, or infinity if one of their weights is
    /// not finite.
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

/// Loads a block's row of weights from their storage format.
template <WeightFormat Format, Scalar T>
Simd<T> load_row(const std::byte* row) noexcept {
    constexpr std::size_t part_bytes = lane_count<T> * weight_bytes<T>(Format) / Simd<T>::count;
    Simd<T> w;
    for (std::size_t part = 0; part < Simd<T>::count; ++part)
        w.r[part] = load_weights<Format, T>(row + part * part_bytes);
    return w;
}

/// Returns the slack of one block, for the weights in effect, which include the residual of the format.
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

/// Returns the largest slack of all points; not finite if a weight is not.
template <Scalar T, std::size_t D>
T largest_slack(const PackedBindingView<T, D>& binding) noexcept {
    const auto of_block = [&](std::size_t b) {
        switch (binding.format) {
        case WeightFormat::half: return block_slack<WeightFormat::half>(binding, b);
        case WeightFormat::int16: return block_slack<WeightFormat::int16>(binding, b);
        case WeightFormat::int8: return block_slack<WeightFormat::int8>(binding, b);
        case WeightFormat::scalar: break;
        }
        return block_slack<WeightFormat::scalar>(binding, b);
    };
    T most = 0;
    for (std::size_t b = 0; b < binding.block_count(); ++b) {
        const T slack = of_block(b);
        if (!is_finite(slack)) return slack;
        if (slack > most) most = slack;
    }
    return most;
}

template <class View>
inline constexpr bool is_rational_view = false;
template <class View>
inline constexpr bool is_rational_view<RationalView<View>> = true;

} // namespace detail

/// Checks once, for all frames, whether a binding is suitable for rational clones.
///
///   returns  the view, or handles_not_points; weight_not_finite; binding_weights_negative, if the
///            negative weights of a point sum to more than 1/16: rounding to one-byte formats stays
///            well below this, mean value coordinates in concave cages do not; or ok
///   cost     reads every stored weight once; no allocation. The memory of the binding must not
///            change while the view is used
template <AnyBinding B>
auto rational_view(const B& binding) noexcept {
    using T = typename B::scalar;
    const auto view = detail::view_of(binding);
    Result<RationalView<std::remove_const_t<decltype(view)>>> result;
    if (view.handle_view().vector_count() != 0) {
        result.report = Status::handles_not_points;
        return result;
    }
    const T slack = detail::largest_slack(PackedBindingView<T, B::dimension>(view));
    if (!is_finite(slack)) {
        result.report = Status::weight_not_finite;
    } else if (slack > T(0x1p-4)) {
        result.report = Status::binding_weights_negative;
    } else {
        result.value = {view, slack};
    }
    return result;
}

/// The input of `clone_rational`: a binding, or a view that was checked before.
template <class B>
concept RationalBinding = AnyBinding<B> || detail::is_rational_view<B>;

namespace detail {

template <class B>
auto as_rational(const B& binding) noexcept {
    if constexpr (is_rational_view<B>) {
        return Result<RationalView<std::remove_cvref_t<decltype(binding.binding())>>>{binding, Status::ok};
    } else {
        return rational_view(binding);
    }
}

/// The range of the weights of handles.
template <Scalar T>
struct WeightRange {
    T least, most;
};

/// Checks the weights of handles. Their ratio is bounded, so that 1 + Ω of every point is at least
/// 1/2 and no product overflows unless the pose itself is out of range.
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

/// Returns the terms of a handle in the numerator and denominator of a rational clone: d + (ω −
/// 1)(C' − g) and ω − 1. ω is relative to the smallest weight, so nothing cancels.
template <Scalar T, std::size_t D, class Pose>
struct RationalDisplacements {
    TakenDisplacements<T, D, Pose> taken;
    const T* weights;
    T least;
    Vec<T, D> middle;

    Vec<T, D + 1> operator()(std::size_t i) const noexcept {
        const Vec<T, D> d = taken(i), from_middle = to_vec<T>(taken.pose[i]) - middle;
        Vec<T, D + 1> sum;
        sum[D] = (weights[i] - least) / least;
        for (std::size_t k = 0; k < D; ++k) sum[k] = multiply_add<T>(sum[D], from_middle[k], d[k]);
        return sum;
    }
};

/// Writes the points of a rational clone: p + (N − Ω (p − g)) / (1 + Ω).
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

/// Moves the points of a binding with a pose of its handles and a weight ω_i for each:
///
///     p' = (Σ ω_i w_i C'_i + e) / Σ ω_i w_i,   e = p − Σ w_i C_i,   0 to rounding
///
/// With ω relative to the smallest weight and g the mean of the pose, it is computed as
///
///     p' = p + (N − Ω (p − g)) / (1 + Ω),  N = Σ w_i (d_i + (ω_i − 1)(C'_i − g)),  Ω = Σ w_i (ω_i − 1)
///
/// Only ratios of weights matter. Equal weights give the result of `clone`, bit for bit. A handle
/// heavier than others pulls points towards it even if nothing has moved. If no weight of a point
/// is negative, the point stays in the convex hull of the handles that it has weights for. A point
/// kept in place stays.
///
///   binding       the result of `rational_view`, made once; or any binding, which is then checked
///                 every time, at the cost of reading its weights twice
///   pose          any PointRange of #handles points
///   weights       #handles, finite and above 0
///   out           any MutablePointRange of at least #points points, which may not overlap pose and
///                 weights; indexed as the points were when bound
///   parallel_for  see core/detail/parallel.hpp; the result does not depend on it
///   returns       as `rational_view`; weights_do_not_match, weights_not_positive;
///                 weights_too_far_apart, if one is 2^60 times another, or so many times that small
///                 negative weights of the binding could outweigh others;
///                 pose_size_differs, pose_not_finite, output_too_small. `out` is then untouched
///   cost          as `clone`, with D + 1 sums instead of D; no allocation
///
/// Rational DFFD: Moccozet, Magnenat-Thalmann, Computer Animation '97, sec. 2 and 3.2. As there, points
/// are weighted and not displacements: weighted displacements would leave an unmoved figure where it is.
template <RationalBinding B, PointRangeIn<B::dimension> Pose, MutablePointRangeIn<B::dimension> Out,
          class Parallel = SerialFor>
Status clone_rational(const B& binding, const Pose& pose, std::span<const typename B::scalar> weights,
                      Out&& out, const Parallel& parallel_for = {}) noexcept {
    using T = typename B::scalar;
    constexpr std::size_t D = B::dimension;
    const auto [rational, fit] = detail::as_rational(binding);
    if (fit != Status::ok) return fit;
    const auto& view = rational.binding();
    detail::WeightRange<T> range;
    Status status = detail::check_weights(weights, view.handle_count(), rational.slack(), range);
    if (status == Status::ok) status = detail::check_clone(view, pose, out);
    if (status != Status::ok) return status;
    if (!(range.least < range.most)) return clone(view, pose, out, {}, parallel_for);

    auto&& target = detail::as_target<T, D>(out);
    using Target = detail::RationalTarget<T, D, std::remove_reference_t<decltype(target)>>;
    const PackedBindingView<T, D> packed(view);
    const Vec<T, D> middle = detail::middle_of<T, D>(pose, view.handle_count());
    const CloneOptions<T> options;
    const detail::DisplacedBlocks<T, D, Target> blocks(packed,
                                                       {{packed, options, target}, packed.rest, middle});
    const detail::RationalDisplacements<T, D, Pose> displacements{
        {view.rest_handles, pose}, weights.data(), range.least, middle};
    parallel_for(block_count<T>(view.point_count()), detail::clone_grain,
                 [&](std::size_t begin, std::size_t end) {
                     blocks.template write<std::remove_cvref_t<decltype(view)>>(displacements, begin, end);
                 });
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI
