// The rational clone: handles have weights that may change every frame. Heavy handles attract the figure.
#pragma once

#include <cageform/clone/clone.hpp>
#include <cageform/clone/detail/rational_slack.hpp>
#include <cageform/clone/detail/rational_sums.hpp>
#include <cageform/clone/types/rational_view.hpp>
#include <cageform/core/result.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// Checks once, for all frames, whether a binding is suitable for rational clones.
///
///   returns  the view, or handles_not_points; weight_not_finite; binding_weights_negative (the negative
///            weights of a point sum to more than 1/16. Rounding to one byte causes smaller sums, mean value
///            coordinates in concave cages larger ones)
///   cost     reads every stored weight once; no allocation. The view refers to the memory of the binding,
///            which must not change
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

/// The input of `clone_rational`: a binding, or the result of `rational_view`.
template <class B>
concept RationalBinding = AnyBinding<B> || detail::is_rational_view<B>;

/// Moves the points of a binding with a pose of its handles and a weight ω_i for each:
///
///     p' = (Σ ω_i w_i C'_i + e) / Σ ω_i w_i,   e = p − Σ w_i C_i,   0 to rounding
///
/// With ω relative to the smallest weight and g the mean of the pose, p' is computed as
///
///     p' = p + (N − Ω (p − g)) / (1 + Ω),  N = Σ w_i (d_i + (ω_i − 1)(C'_i − g)),  Ω = Σ w_i (ω_i − 1)
///
/// Only ratios of weights matter. Equal weights give bitwise the result of `clone`. A heavier handle attracts
/// points even in the pose at rest. If no weight of a point is negative, the point stays in the convex hull
/// of its handles. Outside points that `bind` kept in place do not move.
///
///   binding       the result of `rational_view`; or a binding, which every call then checks: its weights are
///                 read twice
///   pose          any PointRange of #handles points
///   weights       #handles, finite and above 0
///   out           any MutablePointRange of at least #points points, in the order of the bound points; may
///                 not overlap pose and weights
///   parallel_for  see core/types/parallel_for.hpp; no effect on the result
///   returns       as `rational_view`; weights_do_not_match, weights_not_positive; weights_too_far_apart (a
///                 ratio of 2^60, or so large that small negative weights of the binding could dominate);
///                 pose_size_differs, pose_not_finite, output_too_small. `out` is then untouched
///   cost          as `clone`, with D + 1 sums instead of D; no allocation
///
/// Rational DFFD: Moccozet, Magnenat-Thalmann, Computer Animation '97, sec. 2 and 3.2. As in this paper, ω
/// weights the posed handles, not their displacements, so weights act on the pose at rest too.
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

    auto&& target = detail::as_strided<T, D>(out);
    using Target = detail::RationalTarget<T, D, std::remove_reference_t<decltype(target)>>;
    const PackedBindingView<T, D> packed(view);
    const Vec<T, D> middle = detail::middle_of<T, D>(pose, view.handle_count());
    const CloneOptions<T> options;
    const detail::BlockAccumulator<T, D, Target> blocks(packed,
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
