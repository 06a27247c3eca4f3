// Linear blend skinning as a binding: bones as handles.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/detail/bone_handles.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/core/types/scalar_range.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

namespace cageform::inline CAGEFORM_ABI {

struct BindBonesReport : BindReport {
    std::vector<std::uint32_t> unused; ///< bones without a non-zero weight, ascending
};

/// Binds points to bones by given weights, so that `clone` is linear blend skinning:
///
///     p' = Σ_b ω_b (A_b p + t_b)
///
/// A bone has D + 1 consecutive handles: its origin o, a point, and its axes, vectors. Their weights
/// are ω_b, and ω_b times the coordinates of p − o along the axes. Poses common to all bones are
/// therefore exact, also in packed bindings. Blobs, shaders and normals work as for any binding.
/// (`skin_weights` makes a skin for engines and glTF from the same weights.)
///
///   points   any PointRange of the bones' dimension
///   bones    frames at rest: columns are axes, of any length, linearly independent. For `clone`, pass the
///            posed frames, or the result of `pose_bones` for the bones' transforms. For packing, use axes
///            as long as the figure, because formats round all weights by the same scale
///   weights  #points · #bones: the weights of a point are consecutive
///   options  `restore` divides the weights of a point by their sum and corrects rounding errors;
///            BindReport::weight_change has the largest change
///   returns  the binding, its report, and the unused bones. Points whose weights are not finite, or have a
///            sum of at most 0, are unreached. least_weight and amplification include the weights of the axes
///   cost     O(#bones) per point; (#handles + D) scalars of memory per point
///   fails    bone_weights_do_not_match, vertex_not_finite (by handle), bone_axes_dependent (by bone),
///            cancelled, out_of_memory
template <PointRange R, class Bones, ScalarRange Weights,
          Scalar T = typename detail::element_t<const Bones>::scalar, std::size_t D = range_dimension<R>>
    requires(std::is_same_v<detail::element_t<const Bones>, const Transform<T, D>> && (D == 2 || D == 3))
Result<Binding<T, D>, BindBonesReport>
bind_bones(const R& points, const Bones& frames, const Weights& bone_weights, const BindOptions& options = {},
           const Running& running = {}) {
    using W = std::remove_cv_t<detail::element_t<const Weights>>;
    const std::span<const Transform<T, D>> bones(frames);
    const std::span<const W> weights(bone_weights);
    Result<Binding<T, D>, BindBonesReport> result;
    result.report.points = std::size(points);
    if (bones.empty() || weights.size() / bones.size() != std::size(points) ||
        weights.size() % bones.size() != 0) {
        result.report.status = Status::bone_weights_do_not_match;
        return result;
    }
    Extreme missed;
    const Status status = detail::guard_memory([&] {
        CageReport faults;
        const detail::BoneHandles<T, D> handles(bones, faults);
        const detail::BoneShares<T, D, W> shares{handles, weights,
                                                 options.linear_precision == LinearPrecision::restore};
        const auto evaluate = [&](const Batch<T>& batch, const Running& subtask) -> Evaluation {
            std::vector<Extreme> found(batch.points.blocks());
            const Status done =
                detail::for_each_block(found.size(), subtask, [&](std::size_t begin, std::size_t end) {
                    for (std::size_t i = begin * lane_count<T>;
                         i < (std::min)(end * lane_count<T>, batch.points.points); ++i) {
                        if (batch.states[i] != PointState::not_finite)
                            found[i / lane_count<T>].raise(shares.weigh(batch, i));
                    }
                });
            for (const Extreme& each : found) missed.raise(each);
            return {done, {}};
        };
        // All points count as inside. `local`: zero weights stay zero.
        const auto stay = [](const Vec<T, D>& p, std::span<T>) { return p; };
        const detail::BindInput<T, D> input{.cage = faults,
                                            .handles = [&] { return handles.view(); },
                                            .local = true,
                                            .evaluate = evaluate,
                                            .nearest_boundary = stay,
                                            .distance = {},
                                            .points = detail::read_points<T>(points)};
        auto bound = detail::bind_points(input, options, Binding<T, D>{}, running);
        result.value = std::move(bound.value);
        static_cast<BindReport&>(result.report) = std::move(bound.report);
        for (std::size_t b = 0; b < bones.size() && result.report.status == Status::ok; ++b) {
            bool moves = false;
            for (std::size_t i = b; i < weights.size() && !moves; i += bones.size())
                moves = weights[i] != W(0);
            if (!moves) result.report.unused.push_back(static_cast<std::uint32_t>(b));
        }
        return result.report.status;
    });
    if (status == Status::out_of_memory) result.report.status = status;
    if (status != Status::ok) {
        result.value = {};
        result.report.unused.clear();
        return result;
    }
    result.report.weight_change.raise(missed);
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
