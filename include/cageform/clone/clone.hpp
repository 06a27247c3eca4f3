// The clone operator, run every frame: from a pose of the handles to the points of the figure.
#pragma once

#include <cageform/binding/binding.hpp>
#include <cageform/core/detail/pack.hpp>
#include <cageform/core/parallel.hpp>
#include <cageform/core/status.hpp>
#include <cageform/core/view.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Handles are taken in groups whose displacements fit into the first cache level, so nothing is allocated
/// whatever their number.
inline constexpr std::size_t handle_group = 256;

/// Adds the weighted displacements of `size` handles to the sums of `Blocks` blocks. The blocks go side by side
/// so that their additions do not wait for each other.
template <std::size_t Blocks, Scalar T, std::size_t D>
void add_displacements(const Lanes<T>* weight, std::size_t block_stride, const Vec<T, D>* displacement,
                       std::size_t size, Lanes<T> (*sums)[D]) noexcept {
    Pack<T> sum[Blocks][D];
    for (std::size_t b = 0; b < Blocks; ++b) {
        for (std::size_t k = 0; k < D; ++k) sum[b][k] = Pack<T>::load(sums[b][k]);
    }
    for (std::size_t i = 0; i < size; ++i) {
        for (std::size_t b = 0; b < Blocks; ++b) {
            const Pack<T> w = Pack<T>::load(weight[b * block_stride + i]);
            for (std::size_t k = 0; k < D; ++k) sum[b][k] = sum[b][k] + w * Pack<T>(displacement[i][k]);
        }
    }
    for (std::size_t b = 0; b < Blocks; ++b) {
        for (std::size_t k = 0; k < D; ++k) sum[b][k].store(sums[b][k]);
    }
}

/// Points of blocks [begin, end) of a clone.
template <Scalar T, std::size_t D, class Pose, class Out>
void clone_blocks(const BindingView<T, D>& binding, const Pose& pose, Out& out, std::size_t begin,
                  std::size_t end) noexcept {
    constexpr std::size_t lanes = lane_count<T>;
    // As many blocks side by side as keep their sums in registers.
    constexpr std::size_t wanted = 12 / (D * Pack<T>::count);
    constexpr std::size_t together = wanted > 1 ? wanted : 1;
    constexpr std::size_t tile = 4 * together;
    const std::size_t handles = binding.handle_count();
    Vec<T, D> displacement[handle_group];
    Lanes<T> sums[tile][D];
    std::size_t loaded = handles; // first handle of the group in `displacement`; none yet

    for (std::size_t first = begin; first < end; first += tile) {
        const std::size_t blocks = end - first < tile ? end - first : tile;
        for (std::size_t b = 0; b < blocks; ++b) {
            for (std::size_t k = 0; k < D; ++k) sums[b][k] = binding.rest.block(first + b)[k];
        }
        for (std::size_t h = 0; h < handles; h += handle_group) {
            const std::size_t size = handles - h < handle_group ? handles - h : handle_group;
            if (loaded != h) {
                for (std::size_t i = 0; i < size; ++i) {
                    displacement[i] = to_vec<T>(pose[h + i]) - binding.rest_handles[h + i];
                }
                loaded = h;
            }
            std::size_t b = 0;
            for (; b + together <= blocks; b += together) {
                add_displacements<together>(binding.weights.block(first + b) + h, handles, displacement, size,
                                            sums + b);
            }
            for (; b < blocks; ++b) {
                add_displacements<1>(binding.weights.block(first + b) + h, handles, displacement, size,
                                     sums + b);
            }
        }
        for (std::size_t b = 0; b < blocks; ++b) {
            const std::size_t p = (first + b) * lanes;
            const std::size_t used = binding.point_count() - p < lanes ? binding.point_count() - p : lanes;
            for (std::size_t lane = 0; lane < used; ++lane) {
                // An unmoved point keeps its bits: −0 plus nothing would be +0.
                Vec<T, D> moved{};
                for (std::size_t k = 0; k < D; ++k) {
                    const T rest = binding.rest.block(first + b)[k][lane];
                    moved[k] = sums[b][k][lane] == rest ? rest : sums[b][k][lane];
                }
                store_point(out, p + lane, moved);
            }
        }
    }
}

} // namespace detail

/// Moves the points of a binding with a pose of its handles: p' = p + Σ w_i (C'_i − C_i).
///
///   pose          any PointRange of #handles points
///   out           any MutablePointRange of at least #points places; the rest of it is left alone. May not
///                 overlap the pose.
///   parallel_for  see core/parallel.hpp; the result does not depend on it
///   returns       pose_size_differs, pose_not_finite, output_too_small (`out` is then untouched), or ok
///   cost          reads every weight once: #points × (#handles + D) scalars; no allocation
///
/// The pose at rest gives the bound points bit for bit. An affine pose moves every bound point by the same
/// affine map, to rounding (points kept in place stay, points outside that follow the nearest boundary point move
/// as it does).
template <Scalar T, std::size_t D, PointRange Pose, class Out, class Parallel = SerialFor>
    requires(MutablePointRange<std::remove_reference_t<Out>>&& range_dimension<Pose> == D &&
             range_dimension<std::remove_reference_t<Out>> == D)
Status clone(const BindingView<T, D>& binding, const Pose& pose, Out&& out, const Parallel& parallel_for = {})
noexcept {
    if (std::size(pose) != binding.handle_count()) return Status::pose_size_differs;
    if (std::size(out) < binding.point_count()) return Status::output_too_small;
    for (std::size_t i = 0; i < binding.handle_count(); ++i) {
        if (!is_finite(to_vec<T>(pose[i]) - binding.rest_handles[i])) return Status::pose_not_finite;
    }
    constexpr std::size_t grain = 256;
    parallel_for(block_count<T>(binding.point_count()), grain, [&](std::size_t begin, std::size_t end) {
        detail::clone_blocks(binding, pose, out, begin, end);
    });
    return Status::ok;
}

/// The same for the owner of a binding.
template <Scalar T, std::size_t D, PointRange Pose, class Out, class Parallel = SerialFor>
    requires(MutablePointRange<std::remove_reference_t<Out>>&& range_dimension<Pose> == D &&
             range_dimension<std::remove_reference_t<Out>> == D)
Status clone(const Binding<T, D>& binding, const Pose& pose, Out&& out, const Parallel& parallel_for = {})
noexcept {
    return clone(binding.view(), pose, out, parallel_for);
}

} // namespace cageform::inline CAGEFORM_ABI
