// Converts a binding to a skin for engines and glTF: a few handles per point, with non-negative weights.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/detail/convex_weights.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

struct SkinWeightsOptions {
    std::size_t influences = 4; ///< K, the most handles a point may have; glTF has sets of 4
    double threshold = 0;       ///< smaller weights are dropped too, if the others can do without them
};

/// A skin. Every handle is a joint that only translates: p' = p + Σ w_k (C'_joint − C_joint). The
/// entries of a point lie side by side, in the order of falling weights; unused ones have weight 0
/// and joint 0.
struct SkinWeights {
    std::size_t influences = 0;        ///< K
    std::vector<std::uint16_t> joints; ///< #points · K: handles
    /// #points · K, non-negative; the sum of a point's weights is 1 to half a rounding of 1
    std::vector<float> weights;

    std::size_t point_count() const noexcept { return influences == 0 ? 0 : joints.size() / influences; }
};

/// How a skin differs from its binding. Lists hold indices of points in ascending order.
struct SkinWeightsReport {
    Status status = Status::ok;
    std::size_t points = 0;
    /// Outside the hull of the handles, or of any K of them: Σwc is not p.
    std::vector<std::size_t> not_reproduced;
    /// Kept in place by the binding, or not finite: all weights are 0.
    std::vector<std::size_t> without_weights;
    /// #points: Σ|w − w0| over all handles, where w0 are the binding's weights
    std::vector<float> weight_errors;
    Extreme weight_error;         ///< the largest of them
    double mean_weight_error = 0; ///< of the points that have weights
    Extreme partition_error;      ///< largest |Σw − 1| of the final weights
    /// Largest |Σwc − p| of the final weights, in the units of the cage.
    Extreme reproduction_error;
    /// Largest w − w0: the increase that makes up for negative and dropped weights.
    Extreme weight_added;
    double mean_influences = 0; ///< weights other than 0, of the points that have any
    double seconds = 0;         ///< wall-clock time
};

namespace detail {

/// The result for one point of a skin.
struct SkinnedPoint {
    enum class Kind : std::uint8_t { reproduced, not_reproduced, without_weights };
    Kind kind = Kind::without_weights;
    double error = 0, partition = 0, reproduction = 0, added = 0;
    std::size_t used = 0;
};

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

/// Lets the first, largest weight absorb all rounding, so the sum is 1. If the second was as large,
/// the order is corrected afterwards.
inline void make_up_for_rounding(std::span<std::uint16_t> joints, std::span<float> weights) noexcept {
    double others = 0;
    for (std::size_t k = 1; k < weights.size(); ++k) others += double(weights[k]);
    weights[0] = static_cast<float>(1 - others);
    for (std::size_t k = 0; k + 1 < weights.size() && weights[k] < weights[k + 1]; ++k) {
        std::swap(weights[k], weights[k + 1]);
        std::swap(joints[k], joints[k + 1]);
    }
}

/// Keeps the largest shares of a point, divided by their sum; none if no share is positive or one
/// is not finite. `order` is working memory, an entry per bone.
template <Scalar W>
SkinnedPoint keep_largest(std::span<const W> shares, double threshold, std::span<std::uint16_t> order,
                          std::span<std::uint16_t> joints, std::span<float> weights) {
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
    make_up_for_rounding(joints.first(result.used), weights.first(result.used));
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

/// Computes the points that a binding's weights reproduce, and how far a skin is from them.
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
    struct Place {
        Vec<double, D> p, offset{}; ///< to the reproduced point, in units of the size
        double whole = 0;           ///< Σ|w|
        bool is_bound = false;
    };

    Place place_of(std::size_t i) const {
        Place place{vec_cast<double>(block_point<D>(binding_.rest, i))};
        for (std::size_t h = 0; h < binding_.handle_count(); ++h) {
            const double w = binding_.weights(i, h);
            place.whole += std::fabs(w);
            place.offset = place.offset + w * from(place.p, h);
        }
        place.is_bound =
            is_finite(place.p) && is_finite(place.whole) && is_finite(place.offset) && place.whole != 0;
        // Points that follow their nearest boundary point reproduce that one. A smaller offset is a
        // solver's residual or rounding, and is ignored.
        if (dot(place.offset, place.offset) < 1e-8) place.offset = {};
        return place;
    }
    AffineFrame<double, D> frame_of(const Place& place) const {
        return {place.p + size_ * place.offset, size_};
    }

    /// Stores weights in falling order, and compares them with the binding's.
    ///
    ///   weight    of a handle
    ///   support   handles, in falling order; storing stops at the first weight that single precision
    ///             rounds away
    template <class Weight>
    void store(std::size_t i, const Place& place, std::span<const std::size_t> support, const Weight& weight,
               std::span<std::uint16_t> joints, std::span<float> weights, SkinnedPoint& result) const {
        for (const std::size_t h : support) {
            constexpr double rounding = 0x1p-26; // of 1, in single precision
            if (!(weight(h) > rounding)) break;
            joints[result.used] = static_cast<std::uint16_t>(h);
            weights[result.used++] = static_cast<float>(weight(h));
        }
        if (result.used == 0) { // numbers too large to compute with
            result.kind = SkinnedPoint::Kind::not_reproduced;
            result.used = 1;
            for (std::size_t h = 1; h < binding_.handle_count(); ++h) {
                if (binding_.weights(i, h) > binding_.weights(i, joints[0]))
                    joints[0] = static_cast<std::uint16_t>(h);
            }
        }
        make_up_for_rounding(joints.first(result.used), weights.first(result.used));
        Vec<double, D> missed = -1.0 * place.offset;
        result.error = place.whole;
        result.partition = -1;
        for (std::size_t k = 0; k < result.used; ++k) {
            const double w = weights[k], w0 = binding_.weights(i, joints[k]);
            missed = missed + w * from(place.p, joints[k]);
            result.partition += w;
            result.error += std::fabs(w - w0) - std::fabs(w0);
            result.added = (std::max)(result.added, w - w0);
        }
        result.partition = std::fabs(result.partition);
        result.error = (std::max)(result.error, 0.0);
        result.reproduction = size_ * std::sqrt(dot(missed, missed));
    }

private:
    /// Returns a handle relative to a point, in units of the cage's size.
    Vec<double, D> from(const Vec<double, D>& p, std::size_t handle) const {
        return (1 / size_) * (vec_cast<double>(binding_.rest_handles[handle]) - p);
    }

    const BindingView<T, D>& binding_;
    double size_ = 1;
};

/// Makes one skin. As in Binder, the results of each point are stored separately and combined at
/// the end.
template <Scalar T, std::size_t D>
class Skinner {
public:
    Skinner(const BindingView<T, D>& binding, const SkinWeightsOptions& options, const Running& running)
        : binding_(binding)
        , options_(options)
        , running_(running)
        , measure_(binding)
        , count_(binding.point_count()) {}

    Status run(SkinWeights& skin, SkinWeightsReport& report) {
        const std::size_t most = options_.influences;
        points_.assign(count_, {});
        const Status status = for_each_block(count_, running_, [&](std::size_t begin, std::size_t end) {
            ConvexWeights<D> solver;
            for (std::size_t i = begin; i < end; ++i) {
                points_[i] = make(solver, i, std::span(skin.joints).subspan(i * most, most),
                                  std::span(skin.weights).subspan(i * most, most));
            }
        });
        if (status != Status::ok) return status;
        gather_skin(points_, report);
        return Status::ok;
    }

private:
    SkinnedPoint make(ConvexWeights<D>& solver, std::size_t i, std::span<std::uint16_t> joints,
                      std::span<float> weights) const {
        const auto place = measure_.place_of(i);
        if (!place.is_bound) return {};
        solver.load(binding_.handle_view(), measure_.frame_of(place),
                    [&](std::size_t h) { return double(binding_.weights(i, h)); });
        SkinnedPoint result;
        result.kind = solver.reduce(joints.size(), options_.threshold) ? SkinnedPoint::Kind::reproduced
                                                                       : SkinnedPoint::Kind::not_reproduced;
        measure_.store(
            i, place, solver.support(), [&](std::size_t h) { return solver.weight(h); }, joints, weights,
            result);
        return result;
    }

    const BindingView<T, D>& binding_;
    const SkinWeightsOptions& options_;
    const Running& running_;
    SkinMeasure<T, D> measure_;
    std::size_t count_;
    std::vector<SkinnedPoint> points_;
};

/// Calls make(skin, report), which returns a Status, if the binding can have a skin.
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
        return make(result.value, result.report);
    });
    if (result.report.status != Status::ok) result.value = {};
    return result;
}

} // namespace detail

/// Returns the skin closest to a binding: per point at most K non-negative weights, with Σw = 1 and
/// Σwc = p, so that the rest pose and affine poses stay as they are.
///
///   influences  K. A point in the hull of the handles needs at most D + 1 of them (Carathéodory), so
///               with K > D no point within a cage fails. Outside the hull, and for a smaller K, Σwc
///               is close to the point nearest to p that is possible, and the report lists the point
///   weights     closest to the binding's by least squares for the handles that are kept; these are
///               chosen greedily, from the smallest weight on. A pose that moves no handle by more
///               than d moves a point to within d · Σ|w − w0| of where the binding puts it
///   exact       except for rounding to single precision: 1e-7 of the cage's size
///   returns     the skin and its report; points that the binding keeps in place have no weights
///   cost        a few Newton steps of O(#handles) each time that handles are dropped,
///               log(#handles / K) times and more if the hull is narrow: 0.1 ms a point for 112
///               handles
///   fails       handles_not_points: a joint is a point; too_few_influences; too_many_handles: more
///               than 65535, or as many influences, as 16 bits count; value_not_finite: a threshold
///               that is no number; cancelled; out_of_memory
template <Scalar T, std::size_t D>
Result<SkinWeights, SkinWeightsReport> skin_weights(const BindingView<T, D>& binding,
                                                    const SkinWeightsOptions& options = {},
                                                    const Running& running = {}) {
    return detail::make_skin(binding, options, [&](SkinWeights& skin, SkinWeightsReport& report) {
        return detail::Skinner<T, D>(binding, options, running).run(skin, report);
    });
}
template <Scalar T, std::size_t D>
Result<SkinWeights, SkinWeightsReport> skin_weights(const Binding<T, D>& binding,
                                                    const SkinWeightsOptions& options = {},
                                                    const Running& running = {}) {
    return skin_weights(binding.view(), options, running);
}

/// Returns the skin of bones with given weights, as in `bind_bones`: for each point the K largest
/// shares that are positive and at least the threshold, divided by their sum. Joints are bones,
/// which also rotate in a skin.
///
///   shares   #points · #bones: those of a point lie side by side
///   returns  the skin and its report, with the shares as w0. Points with shares that are not finite, or
///            without positive ones, have no weights. Reproduced points are not checked
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
                                                 std::span(order),
                                                 std::span(result.value.joints).subspan(i * most, most),
                                                 std::span(result.value.weights).subspan(i * most, most));
            }
        });
        if (status == Status::ok) detail::gather_skin(points, result.report);
        return status;
    });
    if (result.report.status != Status::ok) result.value = {};
    return result;
}

/// Returns a binding with the weights of a skin instead of its own. `clone` then shows what an
/// engine will show.
///
///   skin     of this binding
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
        return Status::ok;
    });
    return result;
}
template <Scalar T, std::size_t D>
Result<Binding<T, D>> skin_to_binding(const Binding<T, D>& binding, const SkinWeights& skin) {
    return skin_to_binding(binding.view(), skin);
}

/// Converts a skin's weights to normalised integers, `std::uint8_t` or `std::uint16_t`. The weights
/// of a point sum to exactly 255 or 65535, or to 0 if it has none. Each is within one of the exact
/// value, and they still fall. After rounding down, the missing units go to the largest remainders.
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
