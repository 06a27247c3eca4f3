// The transpose of a clone: gradients with respect to points become gradients with respect to handles. For
// optimisers, trackers and training loops.
#pragma once

#include <cageform/clone/clone.hpp>
#include <cageform/clone/detail/normal_gradients.hpp>
#include <cageform/clone/detail/transposed_clone.hpp>
#include <cageform/clone/jacobians.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Computes ∂f/∂C'_i = Σ_p m_p w_pi ∂f/∂p'_p for a function f of the points that `clone(binding, pose, out,
/// options)` writes. A clone is linear in the pose, so the gradients do not depend on the pose.
///
///   binding           dense or packed, an owner or a view. The gradients are exact for the stored weights,
///                     which a packed binding has pruned and rounded
///   point_gradients   any PointRange of at least #points vectors, in the order of the output of `clone`. A
///                     vector that is not finite propagates to handles, including some of weight 0
///   handle_gradients  out, any MutablePointRange of at least #handles vectors; may not overlap the other
///                     arguments
///   options           the mask of the clone; CloneMode::add adds to `handle_gradients`
///   parallel_for      see core/types/parallel_for.hpp; runs over handles; no effect on the result
///   returns           output_too_small, too_few_gradients, mask_too_small (`handle_gradients` is then
///                     untouched), or ok
///   cost              reads every stored weight once. Reads the gradients of points once per thread and per
///                     32 kB of sums (170 handles in 3D, 256 in 2D). No allocation. Sums are in T for some
///                     200 additions, then in double
template <AnyBinding B, PointRangeIn<B::dimension> Gradients, MutablePointRangeIn<B::dimension> Out,
          class Parallel = SerialFor>
Status clone_transposed(const B& binding, const Gradients& point_gradients, Out&& handle_gradients,
                        const CloneOptions<typename B::scalar>& options = {},
                        const Parallel& parallel_for = {}) noexcept {
    using T = typename B::scalar;
    constexpr std::size_t D = B::dimension;
    const std::array views{detail::view_of(binding)};
    const Status status = detail::check_transposed(views[0], point_gradients, handle_gradients, options.mask);
    if (status != Status::ok) return status;
    auto&& source = detail::as_strided<const T, D>(point_gradients);
    using Source = std::remove_cvref_t<decltype(source)>;
    const detail::GivenGradients<T, D, Source> gradients{
        {detail::PointRows<T, D, Source>(PackedBindingView<T, D>(views[0]), source, options.mask)}};
    detail::transpose(views, gradients, handle_gradients, options.mode, parallel_for);
    return Status::ok;
}

/// Computes the gradients of handles from those of the Jacobians that `clone_jacobians` writes.
///
///   columns             as for `clone_jacobians`
///   jacobian_gradients  at least #points matrices ∂f/∂J: column k is the gradient of column k
///   handle_gradients    as for `clone_transposed`
///   mode                CloneMode::add adds to `handle_gradients`
///   returns             bindings_differ, output_too_small, too_few_gradients (`handle_gradients` is then
///                       untouched), or ok
///   cost                D transposed clones; no allocation
template <AnyBinding B, std::size_t D, class S, MutablePointRangeIn<D> Out, class Parallel = SerialFor>
    requires(B::dimension == D)
Status clone_jacobians_transposed(const std::array<B, D>& columns,
                                  const StridedMatrices<S, D>& jacobian_gradients, Out&& handle_gradients,
                                  CloneMode mode = CloneMode::replace,
                                  const Parallel& parallel_for = {}) noexcept {
    using T = typename B::scalar;
    const auto views = detail::views_of(columns);
    for (const auto& view : views) {
        if (view.point_count() != views[0].point_count() || view.handle_count() != views[0].handle_count())
            return Status::bindings_differ;
    }
    const Status status = detail::check_transposed(views[0], jacobian_gradients, handle_gradients);
    if (status != Status::ok) return status;
    using Source = StridedPoints<S, D>;
    using Rows = detail::PointRows<T, D, Source>;
    return [&]<std::size_t... K>(std::index_sequence<K...>) {
        const std::array sources{jacobian_gradients.column(K)...};
        const detail::GivenGradients<T, D, Source, D> gradients{
            {Rows(PackedBindingView<T, D>(views[K]), sources[K], {nullptr, 0})...}};
        detail::transpose(views, gradients, handle_gradients, mode, parallel_for);
        return Status::ok;
    }(std::make_index_sequence<D>{});
}

/// Computes the gradients of handles from those of the normals that `clone_normals` writes.
///
///   tangents, pose    as for `clone_normals`
///   normal_gradients  at least #points vectors ∂f/∂n'
///   handle_gradients  as for `clone_transposed`
///   mode              CloneMode::add adds to `handle_gradients`
///   degenerate        gradients are zero where `clone_normals` returns the normal at rest
///   returns           bindings_differ, output_too_small, too_few_gradients, pose_size_differs,
///                     pose_not_finite (`handle_gradients` is then untouched), or ok
///   cost              `clone_normals` once per thread and per 16 kB of sums, and D − 1 transposed clones; no
///                     allocation
template <AnyBinding B, std::size_t K, PointRangeIn<B::dimension> Pose, PointRangeIn<B::dimension> Gradients,
          MutablePointRangeIn<B::dimension> Out, class Parallel = SerialFor>
    requires(K + 1 == B::dimension)
// NOLINTNEXTLINE(readability-function-size): one parameter more than clone_normals
Status clone_normals_transposed(const std::array<B, K>& tangents, const Pose& pose,
                                const Gradients& normal_gradients, Out&& handle_gradients,
                                CloneMode mode = CloneMode::replace,
                                const Parallel& parallel_for = {}) noexcept {
    using T = typename B::scalar;
    constexpr std::size_t D = B::dimension;
    const auto views = detail::views_of(tangents);
    Status status = detail::check_transposed(views[0], normal_gradients, handle_gradients);
    if (status == Status::ok) status = detail::check_clone(views, pose, normal_gradients);
    if (status != Status::ok) return status;
    auto&& source = detail::as_strided<const T, D>(normal_gradients);
    using Rows = detail::PointRows<T, D, std::remove_cvref_t<decltype(source)>>;
    const detail::NormalGradients<std::remove_cvref_t<decltype(views[0])>, Pose, Rows> gradients{
        views, pose, Rows(PackedBindingView<T, D>(views[0]), source, {nullptr, 0})};
    detail::transpose(views, gradients, handle_gradients, mode, parallel_for);
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI
