// The view of a binding, and the checks of a clone's arguments.
#pragma once

#include <cageform/clone/detail/target.hpp>
#include <cageform/core/status.hpp>
#include <cageform/figure/binding.hpp>
#include <cageform/figure/packed_binding.hpp>

#include <array>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the view of a binding, or a view itself.
template <class B>
auto view_of(const B& binding) noexcept {
    if constexpr (requires { binding.view(); }) {
        return binding.view();
    } else {
        return binding;
    }
}

template <class View>
inline constexpr bool is_binding_view = false;
template <class T, std::size_t D>
inline constexpr bool is_binding_view<BindingView<T, D>> = true;
template <class T, std::size_t D>
inline constexpr bool is_binding_view<PackedBindingView<T, D>> = true;

template <class View, class Pose>
Status check_pose(const View& binding, const Pose& pose) noexcept {
    if (std::size(pose) != binding.handle_count()) return Status::pose_size_differs;
    for (std::size_t i = 0; i < binding.handle_count(); ++i) {
        if (!is_finite(to_vec<typename View::scalar>(pose[i]) - binding.rest_handles[i]))
            return Status::pose_not_finite;
    }
    return Status::ok;
}

template <class View, class Pose, class Out>
Status check_clone(const View& binding, const Pose& pose, const Out& out,
                   const CloneOptions<typename View::scalar>& options = {}) noexcept {
    if (std::size(out) < binding.point_count()) return Status::output_too_small;
    if (options.mask.size() != 0 && options.mask.size() < binding.point_count())
        return Status::mask_too_small;
    return check_pose(binding, pose);
}

/// Checks bindings that are processed together.
template <class View, std::size_t K, class Pose, class Out>
Status check_clone(const std::array<View, K>& views, const Pose& pose, const Out& out) noexcept {
    using Packed = PackedBindingView<typename View::scalar, View::dimension>;
    for (std::size_t k = 1; k < K; ++k) {
        if (!bindings_match(Packed(views[0]), Packed(views[k]))) return Status::bindings_differ;
    }
    return check_clone(views[0], pose, out);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
