// Converts a binding to a skin for engines and glTF: a few handles per point, with non-negative weights.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/detail/skinner.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/core/types/scalar_range.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <limits>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Returns the skin closest to a binding: at most K non-negative weights per point, with Σw = 1 and Σwc
/// = p. Rest and affine poses are therefore exact.
///
///   influences  K. A point in the hull of the handles needs at most D + 1 of them (Carathéodory). If K > D,
///               all points within a cage are reproduced. Otherwise Σwc is close to the nearest possible
///               point, and the report lists the point
///   weights     closest to the binding's by least squares for the kept handles; handles are dropped
///               greedily, by ascending weight. If no handle moves by more than d, the distance to the
///               point of the binding is at most d · Σ|w − w0|
///   exact       except for rounding to single precision: 1e-7 of the cage's size
///   returns     the skin and its report. Points that the binding keeps in place have no weights. The skin
///               ignores BindOptions::falloff; the report lists the affected points
///   cost        a few Newton steps of O(#handles) for each of log(#handles / K) rounds, more if the
///               hull is narrow: 0.1 ms per point for 112 handles
///   fails       handles_not_points; too_few_influences; too_many_handles: more than 65535 handles or
///               influences; value_not_finite: the threshold; cancelled; out_of_memory
template <Scalar T, std::size_t D>
Result<SkinWeights, SkinWeightsReport> skin_weights(const BindingView<T, D>& binding,
                                                    const SkinWeightsOptions& options = {},
                                                    const Running& running = {}) {
    return detail::make_skin(binding, options, [&](Result<SkinWeights, SkinWeightsReport>& result) {
        return detail::Skinner<T, D>(binding, options, running).run(result.value, result.report);
    });
}
template <Scalar T, std::size_t D>
Result<SkinWeights, SkinWeightsReport> skin_weights(const Binding<T, D>& binding,
                                                    const SkinWeightsOptions& options = {},
                                                    const Running& running = {}) {
    return skin_weights(binding.view(), options, running);
}

/// Returns the skin for given weights of bones, as in `bind_bones`: for each point the K largest weights that
/// are positive and at least the threshold, divided by their sum. Joints are bones, which may rotate.
///
///   shares   #points · #bones: the weights of a point are consecutive
///   returns  the skin and its report, with w0 = shares. Points with weights that are not finite, or
///            without positive ones, have no weights. Reproduction of points is not checked
///   fails    bone_weights_do_not_match, too_few_influences, too_many_handles, value_not_finite (the
///            threshold), cancelled, out_of_memory
template <ScalarRange Shares>
Result<SkinWeights, SkinWeightsReport> skin_weights(const Shares& bone_shares, std::size_t bones,
                                                    const SkinWeightsOptions& options = {},
                                                    const Running& running = {}) {
    using W = std::remove_cv_t<detail::element_t<const Shares>>;
    const std::span<const W> shares(bone_shares);
    Result<SkinWeights, SkinWeightsReport> result;
    detail::run_into(result.report, [&] {
        if (bones == 0 || shares.size() % bones != 0) return Status::bone_weights_do_not_match;
        if (options.influences < 1) return Status::too_few_influences;
        if ((std::max)(bones, options.influences) > 65535) return Status::too_many_handles;
        if (!is_finite(options.threshold)) return Status::value_not_finite;
        const std::size_t count = shares.size() / bones, most = options.influences;
        result.report.points = count;
        result.value.influences = most;
        result.value.joints.assign(count * most, 0);
        result.value.weights.assign(count * most, 0.0F);
        std::vector<detail::SkinnedPoint> points(count);
        const Status status = detail::for_each_block(count, running, [&](std::size_t begin, std::size_t end) {
            std::vector<std::uint16_t> order(bones);
            for (std::size_t i = begin; i < end; ++i) {
                points[i] = detail::keep_largest(shares.subspan(i * bones, bones), options.threshold,
                                                 std::span(order), detail::row_of(result.value, i));
            }
        });
        if (status == Status::ok) detail::gather_skin(points, result.report);
        return status;
    });
    if (result.report.status != Status::ok) result.value = {};
    return result;
}

/// Returns a binding with the weights of a skin. Its clones show what an engine will show.
///
///   skin     a skin of this binding
///   fails    out_of_memory
template <Scalar T, std::size_t D>
Result<Binding<T, D>> skin_to_binding(const BindingView<T, D>& binding, const SkinWeights& skin) {
    CAGEFORM_ASSERT(skin.point_count() == binding.point_count(), "a skin of this binding");
    Result<Binding<T, D>> result;
    result.report = detail::guard_memory([&] {
        const std::size_t blocks = block_count<T>(binding.point_count()), handles = binding.handle_count();
        std::vector<Lanes<T>> weights(blocks * handles);
        for (auto& row : weights) std::fill(std::begin(row.v), std::end(row.v), T(0));
        const BlockView<T> table{weights.data(), handles, binding.point_count()};
        for (std::size_t i = 0; i < skin.joints.size(); ++i)
            table(i / skin.influences, skin.joints[i]) += static_cast<T>(skin.weights[i]);
        result.value = Binding<T, D>(std::move(weights), {binding.rest.data, binding.rest.data + blocks * D},
                                     binding.handle_view(), binding.point_count());
    });
    return result;
}
template <Scalar T, std::size_t D>
Result<Binding<T, D>> skin_to_binding(const Binding<T, D>& binding, const SkinWeights& skin) {
    return skin_to_binding(binding.view(), skin);
}

/// Converts a skin's weights to normalised integers, `std::uint8_t` or `std::uint16_t`. The weights of a
/// point have a sum of exactly 255 or 65535, or 0 if it has none. Each is within 1 of the exact value, and
/// they still descend. Weights are rounded down; the missing units go to the largest remainders.
///
///   returns  #points · K, as in the skin; may throw std::bad_alloc
/// See glTF 2.0, sec. 3.7.3.3.
template <class Integer>
    requires(std::same_as<Integer, std::uint8_t> || std::same_as<Integer, std::uint16_t>)
std::vector<Integer> to_normalised(const SkinWeights& skin) {
    constexpr double most = (std::numeric_limits<Integer>::max)();
    std::vector<Integer> result(skin.weights.size());
    std::vector<std::size_t> order(skin.influences);
    for (std::size_t i = 0; i < skin.point_count(); ++i) {
        const float* const weights = skin.weights.data() + i * skin.influences;
        Integer* const out = result.data() + i * skin.influences;
        double sum = 0;
        for (std::size_t k = 0; k < skin.influences; ++k) sum += double(weights[k]);
        if (!(sum > 0)) continue;
        const auto exact = [&](std::size_t k) { return double(weights[k]) / sum * most; };
        auto missing = static_cast<std::size_t>(most);
        for (std::size_t k = 0; k < skin.influences; ++k) {
            order[k] = k;
            out[k] = static_cast<Integer>(exact(k));
            missing -= out[k];
        }
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            const double of_a = exact(a) - double(out[a]), of_b = exact(b) - double(out[b]);
            return of_a != of_b ? of_a > of_b : a < b;
        });
        for (std::size_t n = 0; n < missing && n < order.size(); ++n) ++out[order[n]];
    }
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
