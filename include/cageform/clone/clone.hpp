// The clone operator, run every frame: from a pose of the handles to the points of the figure.
#pragma once

#include <cageform/binding/binding.hpp>
#include <cageform/clone/detail/row_sums.hpp>
#include <cageform/clone/detail/target.hpp>
#include <cageform/core/parallel.hpp>
#include <cageform/core/status.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Points of blocks [begin, end) of a clone.
template <Scalar T, std::size_t D, class Pose, class Out>
void clone_blocks(const BindingView<T, D>& binding, const Pose& pose, Out& out,
                  const CloneOptions<T>& options, std::size_t begin, std::size_t end) noexcept {
    const CloneTarget<T, D, Out> target{binding.rest.data, nullptr, binding.point_count(), options, out};
    const Displacements<T, D, Pose> displacements(binding.rest_handles, binding.handle_count(), pose);
    displacements.with([&](const auto& displacement) {
        sum_dense<WeightFormat::scalar, T, D>(reinterpret_cast<const std::byte*>(binding.weights.data),
                                              binding.handle_count(), binding.weights.blocks(), displacement,
                                              begin, end,
                                              [&](std::size_t b, Lanes<T>* sums) { target.write(b, sums); });
    });
}

/// Whether a pose and an output fit a binding of any kind.
template <class View, class Pose, class Out>
Status check_clone(const View& binding, const Pose& pose, const Out& out,
                   const CloneOptions<typename View::scalar>& options) noexcept {
    if (std::size(pose) != binding.handle_count()) return Status::pose_size_differs;
    if (std::size(out) < binding.point_count()) return Status::output_too_small;
    if (options.mask.size() != 0 && options.mask.size() < binding.point_count())
        return Status::mask_too_small;
    for (std::size_t i = 0; i < binding.handle_count(); ++i) {
        if (!is_finite(to_vec<typename View::scalar>(pose[i]) - binding.rest_handles[i]))
            return Status::pose_not_finite;
    }
    return Status::ok;
}

inline constexpr std::size_t clone_grain = 256; ///< blocks

} // namespace detail

/// Moves the points of a binding with a pose of its handles: p' = p + Σ w_i (C'_i − C_i).
///
///   pose          any PointRange of #handles points
///   out           any MutablePointRange of at least #points places; the rest of it is left alone. May not
///                 overlap the pose.
///   parallel_for  see core/parallel.hpp; the result does not depend on it
///   options       a mask, and what the displacements are added to
///   returns       pose_size_differs, pose_not_finite, output_too_small, mask_too_small (`out` is then untouched), or ok
///   cost          reads every weight once: #points × (#handles + D) scalars; no allocation
///
/// The pose at rest gives the bound points bit for bit. An affine pose moves every bound point by the same
/// affine map, to rounding (points kept in place stay, points outside that follow the nearest boundary point move
/// as it does).
template <Scalar T, std::size_t D, PointRange Pose, class Out, class Parallel = SerialFor>
    requires(MutablePointRange<std::remove_reference_t<Out>>&& range_dimension<Pose> == D &&
             range_dimension<std::remove_reference_t<Out>> == D)
Status clone(const BindingView<T, D>& binding, const Pose& pose, Out&& out, const Parallel& parallel_for = {},
             const CloneOptions<T>& options = {})
noexcept {
    const Status status = detail::check_clone(binding, pose, out, options);
    if (status != Status::ok) return status;
    parallel_for(block_count<T>(binding.point_count()), detail::clone_grain,
                 [&](std::size_t begin, std::size_t end) {
                     detail::clone_blocks(binding, pose, out, options, begin, end);
                 });
    return Status::ok;
}

/// The same for the owner of a binding.
template <Scalar T, std::size_t D, PointRange Pose, class Out, class Parallel = SerialFor>
    requires(MutablePointRange<std::remove_reference_t<Out>>&& range_dimension<Pose> == D &&
             range_dimension<std::remove_reference_t<Out>> == D)
Status clone(const Binding<T, D>& binding, const Pose& pose, Out&& out, const Parallel& parallel_for = {},
             const CloneOptions<T>& options = {})
noexcept {
    return clone(binding.view(), pose, out, parallel_for, options);
}

} // namespace cageform::inline CAGEFORM_ABI
