// From a binding to a skin as engines and glTF have it: a few handles a point, with weights that are not negative.
#pragma once

#include <cageform/binding/bind.hpp>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

struct SkinWeightsOptions {
    std::size_t influences = 4; ///< K, the most handles a point may have; glTF takes 4 a set
    double threshold = 0;       ///< lesser weights are left out as well, where the rest can do without
    ParallelFor parallel = SerialFor{};
    Progress progress{};
};

/// A skin: every handle is a joint that is only moved, p' = p + Σ w_k (C'_joint − C_joint). A point's entries lie side
/// by side, in the order of falling weights; unused ones have weight 0 and joint 0.
struct SkinWeights {
    std::size_t influences = 0;        ///< K
    std::vector<std::uint16_t> joints; ///< #points · K: handles
    std::vector<float> weights; ///< #points · K: none negative; a point's sum is 1 to half a rounding of 1

    std::size_t point_count() const noexcept { return influences == 0 ? 0 : joints.size() / influences; }
};

/// How a skin differs from its binding. Lists hold indices of points in ascending order.
struct SkinWeightsReport {
    Status status = Status::ok;
    std::size_t points = 0;
    std::vector<std::size_t>
        not_reproduced; ///< outside the hull of the handles, or of K of them: Σwc is not p
    std::vector<std::size_t>
        without_weights;              ///< kept in place by the binding, or not finite: all weights are 0
    std::vector<float> weight_errors; ///< #points: Σ|w − w0|, w0 the binding's weights, over all handles
    Extreme weight_error;             ///< the largest of them
    double mean_weight_error = 0;     ///< of the points that have weights
    Extreme partition_error;          ///< largest |Σw − 1| of the finished weights
    Extreme reproduction_error; ///< largest |Σwc − p| of the finished weights, in the units of the cage
    Extreme weight_added;       ///< largest w − w0: what negative and dropped weights cost the others
    double mean_influences = 0; ///< weights other than 0, of the points that have any
    double seconds = 0;         ///< wall-clock time
};

struct SkinWeightsResult {
    SkinWeights skin; ///< empty unless the report's status is ok
    SkinWeightsReport report;
};

namespace detail {

/// The weights of one point nearest to given ones, in the sense of least squares, among those that are not negative,
/// belong to some handles, sum to 1 and reproduce a place q.
///
/// With the affine rows a_i of the handles in a frame at q they are w_i = max(0, w0_i + a_i·y) for the y of D + 1 numbers that makes
/// Σ w_i a_i = (1, 0): Newton's method for the dual problem, which is smooth, convex and quadratic in pieces.
/// Its penalty (the proximal term E) keeps equations solvable where q cannot be reproduced, and y then tells the
/// nearest place that can; repeated about the last y it fades away where q can.
template <std::size_t D>
class ConvexWeights {
public:
    static constexpr double reproduced = 1e-7; ///< of the size: what weights in single precision resolve

    /// Takes up a point: its weights, and the handles in a frame at q.
    template <Scalar T, class Weight>
    void load(const HandleView<T, D>& handles, const AffineFrame<double, D>& frame, const Weight& weight) {
        columns_.resize(handles.count);
        given_.resize(handles.count);
        weights_.assign(handles.count, 0.0);
        support_.resize(handles.count);
        trial_.resize(handles.count);
        needed_.assign(handles.count, 0);
        for (std::size_t i = 0; i < handles.count; ++i) {
            const auto row = frame.row(handles, i);
            for (std::size_t r = 0; r <= D; ++r) columns_[i][long(r)] = row[r];
            given_[i] = weight(i);
            support_[i] = i;
        }
    }

    /// The weights of at most `most` handles, in `weight(i)`; false where q is not reproduced. Handles are left out
    /// from the least weight on, at most half of the surplus at once, where the others can do without: a good choice, not
    /// the best of all. (Exchanging handles for weights still nearer to the given ones was tried: motions came out twice as
    /// far off, for handles that are far away move differently.)
    bool reduce(std::size_t most, double threshold) {
        bool exact = start();
        std::size_t at_once = support_.size();
        for (;;) {
            sort();
            const bool too_many = support_.size() > most;
            const auto is_least = [&](std::size_t i) { return !needed_[i] && weights_[i] < threshold; };
            const std::size_t surplus =
                too_many ? support_.size() - most
                         : std::size_t(std::count_if(support_.begin(), support_.end(), is_least));
            if (surplus == 0) return exact;
            bool dropped = false;
            at_once = std::min(2 * at_once, (surplus + 1) / 2);
            while (!dropped) {
                const auto least = without_least(at_once);
                if (!least) break;
                dropped = solve(trial_, true);
                if (dropped) {
                    accept(trial_);
                } else if (at_once > 1) {
                    at_once /= 2;
                } else {
                    needed_[*least] = 1; // and ever will be: the hull of fewer handles is no larger
                    break;
                }
            }
            if (dropped || !too_many || !all_needed()) continue;
            // Too few for q: the nearest that some of them can do.
            exact = false;
            trial_.assign(support_.begin(), support_.end() - 1);
            solve(trial_, false);
            accept(trial_);
        }
    }

    double weight(std::size_t i) const noexcept { return weights_[i]; }
    /// The handles of weights other than 0, in the order of falling weights.
    std::span<const std::size_t> support() const noexcept { return support_; }

private:
    static constexpr int N = int(D) + 1;
    using Row = Eigen::Matrix<double, N, 1>;
    using Square = Eigen::Matrix<double, N, N>;

    /// All handles. Where these cannot reproduce q either, the nearest place that they can takes its stead.
    bool start() {
        bool sound = true;
        Row sum = Row::Zero();
        for (std::size_t i = 0; i < given_.size(); ++i) {
            sound = sound && given_[i] >= 0;
            sum += given_[i] * columns_[i];
        }
        sum[0] -= 1;
        if (sound && sum.template lpNorm<Eigen::Infinity>() < 1e-12) {
            found_ = given_;
            accept(support_);
            return true;
        }
        trial_ = support_;
        if (solve(trial_, true)) {
            accept(trial_);
            return true;
        }
        solve(trial_, false);
        Row place = Row::Zero();
        for (std::size_t i = 0; i < given_.size(); ++i) place += found_[i] * columns_[i];
        place[0] = 0;
        for (Row& column : columns_) column -= place;
        accept(trial_);
        return false;
    }

    void sort() {
        std::sort(support_.begin(), support_.end(), [this](std::size_t a, std::size_t b) {
            return weights_[a] != weights_[b] ? weights_[a] > weights_[b] : a < b;
        });
    }
    bool all_needed() const {
        return std::all_of(support_.begin(), support_.end(), [this](std::size_t i) { return needed_[i]; });
    }
    /// Tries the support without its `count` least handles that are not needed; the first of them, or nothing where
    /// there are none.
    std::optional<std::size_t> without_least(std::size_t count) {
        std::optional<std::size_t> least;
        trial_.clear();
        for (std::size_t n = support_.size(); n-- > 0;) {
            const std::size_t i = support_[n];
            if (count > 0 && !needed_[i]) {
                --count;
                if (!least) least = i;
            } else {
                trial_.push_back(i);
            }
        }
        return least;
    }
    /// Takes the weights found over.
    void accept(std::span<const std::size_t> over) {
        std::vector<std::size_t>& kept = spare_;
        kept.clear();
        for (const std::size_t i : support_) weights_[i] = 0;
        for (const std::size_t i : over) {
            weights_[i] = found_[i];
            if (found_[i] > 0) kept.push_back(i);
        }
        support_.swap(kept);
    }

    /// Weights over some handles, into `found_`. Exact ones, or false; or those of the nearest place.
    bool solve(std::span<const std::size_t> over, bool exact) {
        found_.assign(given_.size(), 0.0);
        if (over.empty()) return false;
        // E: small beside the equations, and large enough for y to keep digits where they have no solution.
        Row penalty = Row::Constant(exact ? 1e-10 : 1e-6);
        if (!exact) penalty[0] = 1e-9;
        Row y = Row::Zero(), centre = Row::Zero();
        y[0] = 1 / double(over.size());
        for (const std::size_t i : over) y[0] -= given_[i] / double(over.size());
        double missed = std::numeric_limits<double>::infinity();
        for (int round = 0; round < 12; ++round) {
            newton(over, penalty, centre, y);
            const Row error = sum(over, y);
            const double now = exact ? error.template lpNorm<Eigen::Infinity>() : std::fabs(error[0]);
            if (now < 1e-14 || !(now < 0.9 * missed)) {
                missed = std::min(missed, now);
                break;
            }
            missed = now;
            if (exact)
                centre = y;
            else
                centre[0] = y[0];
        }
        double total = 0;
        for (const std::size_t i : over) {
            found_[i] = std::max(0.0, given_[i] + columns_[i].dot(y));
            total += found_[i];
        }
        if (!(total > 0.5)) return false;
        for (const std::size_t i : over) found_[i] /= total;
        return missed <= reproduced;
    }

    /// Σ w a − (1, 0).
    Row sum(std::span<const std::size_t> over, const Row& y) const {
        Row total = Row::Zero();
        total[0] = -1;
        for (const std::size_t i : over) total += std::max(0.0, given_[i] + columns_[i].dot(y)) * columns_[i];
        return total;
    }
    /// What the dual problem minimises: Σ w²/2 − y_0 + (y − centre)·E (y − centre)/2.
    double objective(std::span<const std::size_t> over, const Row& penalty, const Row& centre,
                     const Row& y) const {
        double squares = 0;
        for (const std::size_t i : over) {
            const double w = std::max(0.0, given_[i] + columns_[i].dot(y));
            squares += w * w;
        }
        const Row away = y - centre;
        return 0.5 * squares - y[0] + 0.5 * away.dot(penalty.cwiseProduct(away));
    }

    void newton(std::span<const std::size_t> over, const Row& penalty, const Row& centre, Row& y) const {
        double value = objective(over, penalty, centre, y);
        for (int step = 0; step < 60; ++step) {
            Square matrix = penalty.asDiagonal();
            Row gradient = penalty.cwiseProduct(y - centre);
            gradient[0] -= 1;
            for (const std::size_t i : over) {
                const double w = given_[i] + columns_[i].dot(y);
                if (!(w > 0)) continue;
                gradient += w * columns_[i];
                matrix += columns_[i] * columns_[i].transpose();
            }
            const Row direction = -matrix.llt().solve(gradient);
            const double fall = gradient.dot(direction);
            if (!(fall < 0) || gradient.template lpNorm<Eigen::Infinity>() < 1e-15) return;
            double length = 1;
            for (;; length *= 0.5) {
                const Row next = y + length * direction;
                const double there = objective(over, penalty, centre, next);
                if (there <= value + 1e-4 * length * fall) {
                    y = next;
                    value = there;
                    break;
                }
                if (length < 1e-14) { // nothing but rounding is left to gain
                    const Row whole = y + direction;
                    if (objective(over, penalty, centre, whole) <= value) y = whole;
                    return;
                }
            }
        }
    }

    std::vector<Row> columns_;
    std::vector<double> given_, weights_, found_;
    std::vector<std::size_t> support_, trial_, spare_;
    std::vector<char> needed_; // no other handles would do
};

/// The state of one making of a skin; as Binder, what a point finds out is kept apart and put together in the end.
template <Scalar T, std::size_t D>
class Skinner {
public:
    Skinner(const BindingView<T, D>& binding, const SkinWeightsOptions& options)
        : binding_(binding)
        , options_(options)
        , count_(binding.point_count()) {
        if (binding.handle_count() == 0) return;
        const auto bounds = bounds_of(std::span(binding.rest_handles, binding.handle_count()));
        size_ = std::max(double(bounds.diagonal()), std::numeric_limits<double>::min());
    }

    Status run(SkinWeights& skin, SkinWeightsReport& report) {
        const std::size_t most = options_.influences;
        skin.influences = most;
        skin.joints.assign(count_ * most, 0);
        skin.weights.assign(count_ * most, 0.0F);
        points_.assign(count_, {});
        const Status status = for_each_block(
            count_, {options_.parallel, options_.progress}, [&](std::size_t begin, std::size_t end) {
                ConvexWeights<D> solver;
                for (std::size_t i = begin; i < end; ++i) {
                    points_[i] = make(solver, i, std::span(skin.joints).subspan(i * most, most),
                                      std::span(skin.weights).subspan(i * most, most));
                }
            });
        if (status != Status::ok) return status;
        gather(report);
        return Status::ok;
    }

private:
    enum class Kind : std::uint8_t { reproduced, not_reproduced, without_weights };
    struct PointResult {
        Kind kind = Kind::without_weights;
        double error = 0, partition = 0, reproduction = 0, added = 0;
        std::size_t used = 0;
    };

    PointResult make(ConvexWeights<D>& solver, std::size_t i, std::span<std::uint16_t> joints,
                     std::span<float> weights) const {
        const std::size_t handles = binding_.handle_count();
        const auto p = vec_cast<double>(block_point<D>(binding_.rest, i));
        // What the binding itself reproduces: another place for points that follow the nearest one of the boundary. A
        // solver's residual or a rounding is not meant.
        Vec<double, D> offset{};
        double whole = 0;
        for (std::size_t h = 0; h < handles; ++h) {
            const double w = binding_.weights(i, h);
            whole += std::fabs(w);
            offset = offset + w * from(p, h);
        }
        if (!is_finite(p) || !is_finite(whole) || !is_finite(offset) || whole == 0) return {};
        if (dot(offset, offset) < 1e-8) offset = {};
        solver.load(binding_.handle_view(), AffineFrame<double, D>{p + size_ * offset, size_},
                    [&](std::size_t h) { return double(binding_.weights(i, h)); });

        PointResult result;
        result.kind =
            solver.reduce(joints.size(), options_.threshold) ? Kind::reproduced : Kind::not_reproduced;
        const auto support = solver.support();
        for (std::size_t k = 0; k < support.size(); ++k) {
            constexpr double rounding = 0x1p-26; // of 1, to single precision
            if (!(solver.weight(support[k]) > rounding)) break;
            joints[k] = static_cast<std::uint16_t>(support[k]);
            weights[k] = static_cast<float>(solver.weight(support[k]));
            ++result.used;
        }
        if (result.used == 0) { // numbers too large to compute with
            result.kind = Kind::not_reproduced;
            result.used = 1;
            for (std::size_t h = 1; h < handles; ++h) {
                if (binding_.weights(i, h) > binding_.weights(i, joints[0]))
                    joints[0] = static_cast<std::uint16_t>(h);
            }
        }
        // The largest makes up for all roundings; where the second was as large it may now be the lesser by one.
        double others = 0;
        for (std::size_t k = 1; k < result.used; ++k) others += double(weights[k]);
        weights[0] = static_cast<float>(1 - others);
        for (std::size_t k = 0; k + 1 < result.used && weights[k] < weights[k + 1]; ++k) {
            std::swap(weights[k], weights[k + 1]);
            std::swap(joints[k], joints[k + 1]);
        }

        // The truth about what is stored.
        Vec<double, D> missed = -1.0 * offset;
        result.error = whole;
        result.partition = -1;
        for (std::size_t k = 0; k < result.used; ++k) {
            const double w = weights[k], w0 = binding_.weights(i, joints[k]);
            missed = missed + w * from(p, joints[k]);
            result.partition += w;
            result.error += std::fabs(w - w0) - std::fabs(w0);
            result.added = std::max(result.added, w - w0);
        }
        result.partition = std::fabs(result.partition);
        result.error = std::max(result.error, 0.0);
        result.reproduction = size_ * std::sqrt(dot(missed, missed));
        return result;
    }

    /// A handle as seen from a place, in units of the cage's size.
    Vec<double, D> from(const Vec<double, D>& p, std::size_t handle) const {
        return (1 / size_) * (vec_cast<double>(binding_.rest_handles[handle]) - p);
    }

    void gather(SkinWeightsReport& report) const {
        report.weight_errors.resize(count_);
        std::size_t used = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const PointResult& point = points_[i];
            if (point.kind == Kind::without_weights) {
                report.without_weights.push_back(i);
                continue;
            }
            if (point.kind == Kind::not_reproduced) report.not_reproduced.push_back(i);
            report.weight_errors[i] = static_cast<float>(point.error);
            report.weight_error.raise({point.error, i});
            report.partition_error.raise({point.partition, i});
            report.reproduction_error.raise({point.reproduction, i});
            report.weight_added.raise({point.added, i});
            report.mean_weight_error += point.error;
            used += point.used;
        }
        const std::size_t bound = count_ - report.without_weights.size();
        if (bound == 0) return;
        report.mean_weight_error /= double(bound);
        report.mean_influences = double(used) / double(bound);
    }

    const BindingView<T, D>& binding_;
    const SkinWeightsOptions& options_;
    std::size_t count_;
    double size_ = 1;
    std::vector<PointResult> points_;
};

} // namespace detail

/// The skin nearest to a binding: per point at most K weights, not negative, with Σw = 1 and Σwc = p, so that the
/// rest pose and affine poses stay as they are.
///
///   influences  K. Any D + 1 are enough for a point in the hull of the handles (Carathéodory), so with K > D no
///               point within a cage fails; outside the hull, and for a lesser K, Σwc is nearly the nearest to p that
///               can be had, and the report lists the point
///   weights     nearest to the binding's by least squares for the handles that are kept; these are chosen greedily,
///               from the least weight on. A pose that moves no handle by more than d moves a point to within
///               d · Σ|w − w0| of where the binding has it
///   exact       but for rounding to single precision: 1e-7 of the cage's size
///   returns     the skin and its report; points that the binding keeps in place have no weights
///   cost        a few Newton steps of O(#handles) for every time that handles are left out, log(#handles / K) times and
///               more where the hull is narrow: 0.1 ms a point for 112 handles
///   fails       too_few_influences; too_many_handles: more than 65535, or as many influences, as 16 bits count;
///               value_not_finite: a threshold that is no number; cancelled; out_of_memory
template <Scalar T, std::size_t D>
SkinWeightsResult skin_weights(const BindingView<T, D>& binding, const SkinWeightsOptions& options = {}) {
    const auto start = std::chrono::steady_clock::now();
    SkinWeightsResult result;
    auto& report = result.report;
    report.points = binding.point_count();
    report.status = binding.handle_view().vector_count() > 0 ? Status::handles_not_points
                    : options.influences < 1                 ? Status::too_few_influences
                    : std::max(binding.handle_count(), options.influences) > 65535 ? Status::too_many_handles
                    : !is_finite(options.threshold)                                ? Status::value_not_finite
                                                                                   : Status::ok;
    if (report.status != Status::ok) return result;
    report.status = detail::guard_memory(
        [&] { return detail::Skinner<T, D>(binding, options).run(result.skin, report); });
    if (report.status != Status::ok) result.skin = {};
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
}
template <Scalar T, std::size_t D>
SkinWeightsResult skin_weights(const Binding<T, D>& binding, const SkinWeightsOptions& options = {}) {
    return skin_weights(binding.view(), options);
}

/// The binding with the weights of a skin in the place of its own: `clone` then shows what an engine will.
///
///   skin     of this binding
///   out      overwritten where the result is ok
///   fails    out_of_memory
template <Scalar T, std::size_t D>
Status skin_to_binding(const BindingView<T, D>& binding, const SkinWeights& skin, Binding<T, D>& out) {
    CAGEFORM_ASSERT(skin.point_count() == binding.point_count(), "a skin of this binding");
    return detail::guard_memory([&] {
        const std::size_t blocks = block_count<T>(binding.point_count()), handles = binding.handle_count();
        std::vector<Lanes<T>> weights(blocks * handles);
        for (auto& row : weights) std::fill(std::begin(row.v), std::end(row.v), T(0));
        const BlockView<T> table{weights.data(), handles, binding.point_count()};
        for (std::size_t i = 0; i < skin.joints.size(); ++i)
            table(i / skin.influences, skin.joints[i]) += static_cast<T>(skin.weights[i]);
        out = Binding<T, D>(std::move(weights), {binding.rest.data, binding.rest.data + blocks * D},
                            binding.handle_view(), binding.point_count());
        return Status::ok;
    });
}
template <Scalar T, std::size_t D>
Status skin_to_binding(const Binding<T, D>& binding, const SkinWeights& skin, Binding<T, D>& out) {
    return skin_to_binding(binding.view(), skin, out);
}

/// A skin's weights as normalised integers, `std::uint8_t` or `std::uint16_t`. Those of a point sum to exactly 255 or 65535, and to
/// 0 where it has none; each is within one of the number it stands for, and they still fall. The integers that are lacking after
/// rounding down go to the largest remainders.
///
///   returns  #points · K, as in the skin; may throw std::bad_alloc
/// glTF 2.0, sec. 3.7.3.3.
template <class Integer>
    requires(std::same_as<Integer, std::uint8_t> || std::same_as<Integer, std::uint16_t>)
std::vector<Integer> to_normalised(const SkinWeights& skin) {
    constexpr double most = std::numeric_limits<Integer>::max();
    std::vector<Integer> result(skin.weights.size());
    std::vector<std::size_t> order(skin.influences);
    for (std::size_t i = 0; i < skin.point_count(); ++i) {
        const float* const weights = skin.weights.data() + i * skin.influences;
        Integer* const out = result.data() + i * skin.influences;
        double sum = 0;
        for (std::size_t k = 0; k < skin.influences; ++k) sum += double(weights[k]);
        if (!(sum > 0)) continue;
        const auto exact = [&](std::size_t k) { return double(weights[k]) / sum * most; };
        auto lacking = static_cast<std::size_t>(most);
        for (std::size_t k = 0; k < skin.influences; ++k) {
            order[k] = k;
            out[k] = static_cast<Integer>(exact(k));
            lacking -= out[k];
        }
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            const double of_a = exact(a) - double(out[a]), of_b = exact(b) - double(out[b]);
            return of_a != of_b ? of_a > of_b : a < b;
        });
        for (std::size_t n = 0; n < lacking && n < order.size(); ++n) ++out[order[n]];
    }
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
