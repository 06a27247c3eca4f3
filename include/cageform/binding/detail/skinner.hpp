// Makes a skin point by point: finds a few non-negative weights per point, and measures their
// difference from the binding's.
#pragma once

#include <cageform/binding/detail/convex_weights.hpp>
#include <cageform/binding/types/skin_weights.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/core/result.hpp>
#include <cageform/figure/binding.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>
#include <cageform/parallel/running.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The result for one point of a skin.
struct SkinnedPoint {
    enum class Kind : std::uint8_t { reproduced, not_reproduced, without_weights };
    Kind kind = Kind::without_weights;
    double error = 0, partition = 0, reproduction = 0, added = 0;
    std::size_t used = 0;
    bool fades = false;
};

/// The K entries of one point in a skin.
struct SkinRow {
    std::span<std::uint16_t> joints;
    std::span<float> weights;
};
inline SkinRow row_of(SkinWeights& skin, std::size_t i) {
    const std::size_t most = skin.influences;
    return {std::span(skin.joints).subspan(i * most, most), std::span(skin.weights).subspan(i * most, most)};
}

inline void gather_skin(const std::vector<SkinnedPoint>& points, SkinWeightsReport& report) {
    report.weight_errors.resize(points.size());
    std::size_t used = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const SkinnedPoint& point = points[i];
        if (point.kind == SkinnedPoint::Kind::without_weights) {
            report.without_weights.push_back(i);
            continue;
        }
        if (point.kind == SkinnedPoint::Kind::not_reproduced) report.not_reproduced.push_back(i);
        if (point.fades) report.faded.push_back(i);
        report.weight_errors[i] = static_cast<float>(point.error);
        report.weight_error.raise({point.error, i});
        report.partition_error.raise({point.partition, i});
        report.reproduction_error.raise({point.reproduction, i});
        report.weight_added.raise({point.added, i});
        report.mean_weight_error += point.error;
        used += point.used;
    }
    const std::size_t bound = points.size() - report.without_weights.size();
    if (bound == 0) return;
    report.mean_weight_error /= double(bound);
    report.mean_influences = double(used) / double(bound);
}

/// Sets the largest weight, the first one, so that the sum is 1 in spite of rounding. Swaps weights
/// that are then out of order.
inline void absorb_rounding(std::span<std::uint16_t> joints, std::span<float> weights) noexcept {
    double others = 0;
    for (std::size_t k = 1; k < weights.size(); ++k) others += double(weights[k]);
    weights[0] = static_cast<float>(1 - others);
    for (std::size_t k = 0; k + 1 < weights.size() && weights[k] < weights[k + 1]; ++k) {
        std::swap(weights[k], weights[k + 1]);
        std::swap(joints[k], joints[k + 1]);
    }
}

/// Keeps the largest weights of a point, divided by their sum; none if no weight is positive or one is
/// not finite. `order` is scratch memory, one entry per bone.
template <Scalar W>
SkinnedPoint keep_largest(std::span<const W> shares, double threshold, std::span<std::uint16_t> order,
                          const SkinRow& row) {
    const auto [joints, weights] = row;
    SkinnedPoint result;
    double sum = 0;
    for (std::size_t b = 0; b < shares.size(); ++b) {
        if (!is_finite(shares[b])) return result;
        order[b] = static_cast<std::uint16_t>(b);
    }
    const std::size_t most = (std::min)(joints.size(), shares.size());
    std::partial_sort(order.begin(), order.begin() + std::ptrdiff_t(most), order.end(),
                      [&](std::uint16_t a, std::uint16_t b) {
                          return shares[a] != shares[b] ? shares[a] > shares[b] : a < b;
                      });
    const auto keeps = [&](std::size_t k) {
        return shares[order[k]] > W(0) && (k == 0 || double(shares[order[k]]) >= threshold);
    };
    for (; result.used < most && keeps(result.used); ++result.used) sum += double(shares[order[result.used]]);
    if (result.used == 0 || !is_finite(sum)) return {};
    result.kind = SkinnedPoint::Kind::reproduced;
    for (std::size_t k = 0; k < result.used; ++k) {
        joints[k] = order[k];
        weights[k] = static_cast<float>(double(shares[order[k]]) / sum);
    }
    absorb_rounding(joints.first(result.used), weights.first(result.used));
    for (const W share : shares) result.error += std::fabs(double(share));
    result.partition = -1;
    for (std::size_t k = 0; k < result.used; ++k) {
        const double w = weights[k], w0 = double(shares[joints[k]]);
        result.partition += w;
        result.error += std::fabs(w - w0) - std::fabs(w0);
        result.added = (std::max)(result.added, w - w0);
    }
    result.partition = std::fabs(result.partition);
    result.error = (std::max)(result.error, 0.0);
    return result;
}

/// Computes the points that a binding's weights reproduce, and the errors of a skin.
template <Scalar T, std::size_t D>
class SkinMeasure {
public:
    explicit SkinMeasure(const BindingView<T, D>& binding)
        : binding_(binding) {
        if (binding.handle_count() == 0) return;
        const auto bounds = bounds_of(std::span(binding.rest_handles, binding.handle_count()));
        size_ = (std::max)(double(bounds.diagonal()), (std::numeric_limits<double>::min)());
    }

    double size() const noexcept { return size_; } ///< of the cage

    /// A point of the binding, and the offset of the point that its weights reproduce.
    struct SkinPoint {
        Vec<double, D> p, offset{}; ///< to the reproduced point, in units of the size
        double abs_sum = 0;         ///< Σ|w|
        double sum = 1;             ///< Σw of a point with falloff; its weights are divided by it
        bool is_bound = false;
    };

    SkinPoint point_of(std::size_t i) const {
        SkinPoint point{vec_cast<double>(block_point<D>(binding_.rest, i))};
        double sum = 0;
        for (std::size_t h = 0; h < binding_.handle_count(); ++h) {
            const double w = binding_.weights(i, h);
            sum += w;
            point.abs_sum += std::fabs(w);
            point.offset = point.offset + w * from(point.p, h);
        }
        if (sum > 0 && sum < 1 - 1e-4) { // more than a solver's residual
            point.sum = sum;
            point.abs_sum /= sum;
            point.offset = (1 / sum) * point.offset;
        }
        point.is_bound =
            is_finite(point.p) && is_finite(point.abs_sum) && is_finite(point.offset) && point.abs_sum != 0;
        // With nearest_boundary, the weights reproduce the boundary point. Smaller offsets are
        // residuals or rounding errors and are ignored.
        if (dot(point.offset, point.offset) < 1e-8) point.offset = {};
        return point;
    }
    /// Returns the weight of a handle without falloff.
    double unfaded_weight(std::size_t i, const SkinPoint& point, std::size_t handle) const {
        return double(binding_.weights(i, handle)) / point.sum;
    }
    AffineFrame<double, D> frame_of(const SkinPoint& point) const {
        return {point.p + size_ * point.offset, size_};
    }

    /// Stores weights in descending order and compares them with the binding's.
    ///
    ///   found      support(): handles by descending weight; weight(handle). Stops at the first weight that
    ///              rounds to 0 beside 1 in single precision
    ///   is_exact   whether the weights reproduce the point
    template <class Found>
    SkinnedPoint store(std::size_t i, const SkinPoint& point, const Found& found, bool is_exact,
                       const SkinRow& row) const {
        const auto [joints, weights] = row;
        SkinnedPoint result;
        result.kind = is_exact ? SkinnedPoint::Kind::reproduced : SkinnedPoint::Kind::not_reproduced;
        for (const std::size_t h : found.support()) {
            constexpr double rounding = 0x1p-26; // of 1, in single precision
            if (!(found.weight(h) > rounding)) break;
            joints[result.used] = static_cast<std::uint16_t>(h);
            weights[result.used++] = static_cast<float>(found.weight(h));
        }
        if (result.used == 0) { // overflow
            result.kind = SkinnedPoint::Kind::not_reproduced;
            result.used = 1;
            for (std::size_t h = 1; h < binding_.handle_count(); ++h) {
                if (binding_.weights(i, h) > binding_.weights(i, joints[0]))
                    joints[0] = static_cast<std::uint16_t>(h);
            }
        }
        absorb_rounding(joints.first(result.used), weights.first(result.used));
        Vec<double, D> missed = -1.0 * point.offset;
        result.error = point.abs_sum;
        result.partition = -1;
        for (std::size_t k = 0; k < result.used; ++k) {
            const double w = weights[k], w0 = unfaded_weight(i, point, joints[k]);
            missed = missed + w * from(point.p, joints[k]);
            result.partition += w;
            result.error += std::fabs(w - w0) - std::fabs(w0);
            result.added = (std::max)(result.added, w - w0);
        }
        result.fades = point.sum != 1;
        result.partition = std::fabs(result.partition);
        result.error = (std::max)(result.error, 0.0);
        result.reproduction = size_ * std::sqrt(dot(missed, missed));
        return result;
    }

private:
    /// Returns a handle relative to a point, in units of the cage's size.
    Vec<double, D> from(const Vec<double, D>& p, std::size_t handle) const {
        return (1 / size_) * (vec_cast<double>(binding_.rest_handles[handle]) - p);
    }

    const BindingView<T, D>& binding_;
    double size_ = 1;
};

/// Makes one skin. As in Binder, results are stored per point and combined at the end.
template <Scalar T, std::size_t D>
class Skinner {
public:
    Skinner(const BindingView<T, D>& binding, const SkinWeightsOptions& options, const Running& running)
        : binding_(binding)
        , options_(options)
        , running_(running)
        , measure_(binding)
        , count_(binding.point_count()) {}

    Status run(SkinWeights& skin, SkinWeightsReport& report);

private:
    SkinnedPoint make(ConvexWeights<D>& solver, std::size_t i, const SkinRow& row) const;

    const BindingView<T, D>& binding_;
    const SkinWeightsOptions& options_;
    const Running& running_;
    SkinMeasure<T, D> measure_;
    std::size_t count_;
    std::vector<SkinnedPoint> points_;
};

// Not inline, for `extern template` below, as BlockCloner::run.
template <Scalar T, std::size_t D>
Status Skinner<T, D>::run(SkinWeights& skin, SkinWeightsReport& report) {
    points_.assign(count_, {});
    const Status status = for_each_block(count_, running_, [&](std::size_t begin, std::size_t end) {
        ConvexWeights<D> solver;
        for (std::size_t i = begin; i < end; ++i) points_[i] = make(solver, i, row_of(skin, i));
    });
    if (status != Status::ok) return status;
    gather_skin(points_, report);
    return Status::ok;
}

template <Scalar T, std::size_t D>
SkinnedPoint Skinner<T, D>::make(ConvexWeights<D>& solver, std::size_t i, const SkinRow& row) const {
    const auto point = measure_.point_of(i);
    if (!point.is_bound) return {};
    solver.load(binding_.handle_view(), measure_.frame_of(point),
                [&](std::size_t h) { return measure_.unfaded_weight(i, point, h); });
    const bool is_exact = solver.reduce(row.joints.size(), options_.threshold);
    return measure_.store(i, point, solver, is_exact, row);
}

/// Checks the binding and the options, and calls make(result), which returns a Status.
template <Scalar T, std::size_t D, class Make>
Result<SkinWeights, SkinWeightsReport> make_skin(const BindingView<T, D>& binding,
                                                 const SkinWeightsOptions& options, const Make& make) {
    Result<SkinWeights, SkinWeightsReport> result;
    result.report.points = binding.point_count();
    run_into(result.report, [&] {
        if (binding.handle_view().vector_count() > 0) return Status::handles_not_points;
        if (options.influences < 1) return Status::too_few_influences;
        if ((std::max)(binding.handle_count(), options.influences) > 65535) return Status::too_many_handles;
        if (!is_finite(options.threshold)) return Status::value_not_finite;
        result.value.influences = options.influences;
        result.value.joints.assign(binding.point_count() * options.influences, 0);
        result.value.weights.assign(binding.point_count() * options.influences, 0.0F);
        return make(result);
    });
    if (result.report.status != Status::ok) result.value = {};
    return result;
}

#if defined(CAGEFORM_COMPILED) // in the compiled library, which is always optimised
#define CAGEFORM_DETAIL_SKINNER(T)                                                                           \
    extern template Status Skinner<T, 2>::run(SkinWeights&, SkinWeightsReport&);                             \
    extern template Status Skinner<T, 3>::run(SkinWeights&, SkinWeightsReport&);
CAGEFORM_DETAIL_SKINNER(float)
CAGEFORM_DETAIL_SKINNER(double)
#undef CAGEFORM_DETAIL_SKINNER
#endif

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
