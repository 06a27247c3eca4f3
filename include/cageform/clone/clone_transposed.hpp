// The transpose of a clone: gradients of a function of the moved points become gradients of the handles. For
// optimisers, trackers and training loops that move a cage.
#pragma once

#include <cageform/clone/clone.hpp>
#include <cageform/clone/detail/normal_gradients.hpp>
#include <cageform/clone/detail/transposed_clone.hpp>
#include <cageform/clone/jacobians.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Computes ∂f/∂C'_i = Σ_p m_p w_pi ∂f/∂p'_p, the gradients of a function f of the points that
/// `clone(binding, pose, out, options)` writes. A clone is linear in the pose, so they do not depend on it.
///
///   binding           dense or packed, an owner or a view. The gradients are those of what `clone` computes
///                     by it: whatever a packed binding dropped or rounded
///   point_gradients   any PointRange of at least #points vectors, indexed as the output of `clone`. One that
///                     is not finite passes through to handles, some of weight 0 among them
///   handle_gradients  out, any MutablePointRange of at least #handles vectors, which may not overlap
///                     the other arguments
///   options           the mask of the clone; with CloneMode::output the gradients are added to those in
///                     `handle_gradients`, else they replace them
///   parallel_for      see core/types/parallel_for.hpp; threads take handles, and the result does not depend
///                     on it
///   returns           output_too_small, too_few_gradients, mask_too_small (`handle_gradients` is then
///                     untouched), or ok
///   cost              reads every stored weight once, and the gradients of points once for every 32 kB of
///                     sums (170 handles in space, 256 in the plane) and thread; no allocation
///
/// Sums of floats are put into double after some 200 additions.
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
    detail::transpose(views, gradients, handle_gradients, options.onto, parallel_for);
    return Status::ok;
}

/// Computes the gradients of handles from those of the Jacobians that `clone_jacobians` writes.
///
///   columns             as for `clone_jacobians`
///   jacobian_gradients  at least #points matrices of ∂f/∂J: column k is the gradient of column k
///   handle_gradients    as for `clone_transposed`
///   onto                CloneMode::output adds to `handle_gradients`, for functions of points and Jacobians
///   returns             bindings_differ, output_too_small, too_few_gradients (`handle_gradients` is then
///                       untouched), or ok
///   cost                that of D transposed clones; no allocation
template <AnyBinding B, std::size_t D, class S, MutablePointRangeIn<D> Out, class Parallel = SerialFor>
    requires(B::dimension == D)
Status clone_jacobians_transposed(const std::array<B, D>& columns,
                                  const StridedMatrices<S, D>& jacobian_gradients, Out&& handle_gradients,
                                  CloneMode onto = CloneMode::rest, const Parallel& parallel_for = {})
noexcept {
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
        detail::transpose(views, gradients, handle_gradients, onto, parallel_for);
        return Status::ok;
    }
    (std::make_index_sequence<D>{});
}

/// Computes the gradients of handles from those of the normals that `clone_normals` writes.
///
///   tangents, pose    as for `clone_normals`
///   normal_gradients  at least #points vectors ∂f/∂n'
///   handle_gradients  as for `clone_transposed`
///   onto              CloneMode::output adds to `handle_gradients`, for functions of points and normals
///   degenerate        where the normal is that at rest, no handle moves it
///   returns           bindings_differ, output_too_small, too_few_gradients, pose_size_differs,
///                     pose_not_finite (`handle_gradients` is then untouched), or ok
///   cost              that of `clone_normals` for every thread and 16 kB of sums, and of D − 1 transposed
///                     clones; no allocation
template <AnyBinding B, std::size_t K, PointRangeIn<B::dimension> Pose, PointRangeIn<B::dimension> Gradients,
          MutablePointRangeIn<B::dimension> Out, class Parallel = SerialFor>
    requires(K + 1 == B::dimension)
// NOLINTNEXTLINE(readability-function-size): as clone_normals, and what the gradients are added to
Status clone_normals_transposed(const std::array<B, K>& tangents, const Pose& pose,
                                const Gradients& normal_gradients, Out&& handle_gradients,
                                CloneMode onto = CloneMode::rest, const Parallel& parallel_for = {})
noexcept {
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
    detail::transpose(views, gradients, handle_gradients, onto, parallel_for);
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI
