// The clone operator: moves the points of a figure with a pose of the handles, every frame.
#pragma once

#include <cageform/clone/detail/block_cloner.hpp>
#include <cageform/clone/detail/check_clone.hpp>
#include <cageform/core/status.hpp>
#include <cageform/core/types/parallel_for.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A BindingView, a PackedBindingView, or a type whose view() returns one, such as Binding and PackedBinding.
template <class B>
concept AnyBinding = detail::is_binding_view<decltype(detail::view_of(std::declval<const B&>()))>;

/// Moves the points of a binding with a pose of its handles: p' = p + Σ w_i (C'_i − C_i).
///
///   binding       dense or packed, an owner or a view
///   pose          any PointRange of #handles points
///   out           any MutablePointRange of at least #points points; may not overlap the pose. Further points
///                 are unchanged. `out` and the mask are in the order of the bound points
///   options       a mask, and whether displacements are added to `out`
///   parallel_for  see core/types/parallel_for.hpp; no effect on the result
///   returns       pose_size_differs, pose_not_finite, output_too_small, mask_too_small (`out` is then
///                 untouched), or ok
///   cost          reads every stored weight once: #points × (#handles + D) scalars of a dense binding; no
///                 allocation
///
/// The pose at rest reproduces the bound points bitwise. An affine pose applies its affine map to every bound
/// point, to rounding. Exceptions are points outside the cage: those kept in place do not move, and those
/// that follow the nearest boundary point move as that point does. For other poses, `pack` reports the
/// deviation of packed bindings.
template <AnyBinding B, PointRangeIn<B::dimension> Pose, MutablePointRangeIn<B::dimension> Out,
          class Parallel = SerialFor>
Status clone(const B& binding, const Pose& pose, Out&& out,
             const CloneOptions<typename B::scalar>& options = {},
             const Parallel& parallel_for = {}) noexcept {
    const auto view = detail::view_of(binding);
    const Status status = detail::check_clone(view, pose, out, options);
    if (status != Status::ok) return status;
    using T = typename B::scalar;
    auto&& source = detail::as_strided<const T, B::dimension>(pose);
    auto&& target = detail::as_strided<T, B::dimension>(out);
    const detail::BlockCloner cloner(view, source, target, options);
    parallel_for(block_count<T>(view.point_count()), detail::clone_grain,
                 [&](std::size_t begin, std::size_t end) { cloner.run(begin, end); });
    return Status::ok;
}

// Further arguments are accepted, so that the first line of the compiler's message names the reason.
template <AnyBinding B, class Pose, class Out, class... More>
    requires(UnknownPointRange<Pose> || UnknownPointRange<Out>)
detail::ReasonOr<detail::PointTraitsNotSpecialisedForThesePoints, Status>
clone(const B&, const Pose&, Out&&, const More&...) = CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;
template <AnyBinding B, PointRange Pose, PointRange Out, class... More>
    requires(range_dimension<Pose> != B::dimension || range_dimension<Out> != B::dimension)
detail::ReasonOr<detail::PointsOfAnotherDimensionThanTheCage, Status>
clone(const B&, const Pose&, Out&&, const More&...) = CAGEFORM_DETAIL_DELETE_DIMENSION;
template <AnyBinding B, PointRangeIn<B::dimension> Pose, PointRangeIn<B::dimension> Out, class... More>
    requires(!MutablePointRange<Out>)
detail::ReasonOr<detail::PointsThatCannotBeWritten, Status>
clone(const B&, const Pose&, Out&&, const More&...) = CAGEFORM_DETAIL_DELETE_NOT_WRITTEN;

} // namespace cageform::inline CAGEFORM_ABI
