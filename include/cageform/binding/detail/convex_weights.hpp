// Finds non-negative weights of a point for few handles that are closest to given weights.
#pragma once

#include <cageform/binding/detail/symmetric_matrix.hpp>
#include <cageform/core/affine/affine_rows.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Finds the weights of one point that are closest to given ones in the least-squares sense. They are
/// non-negative, non-zero only for chosen handles, have the sum 1 and reproduce a point q.
///
/// Let a_i be the affine rows of the handles in a frame at q. The solution is w_i = max(0, w0_i +
/// a_i·y), where y has D + 1 numbers such that Σ w_i a_i = (1, 0). Newton's method solves the dual
/// problem, which is smooth, convex and piecewise quadratic. A proximal term E keeps the equations
/// solvable if q cannot be reproduced; y then gives the closest reproducible point. The term is centred
/// at the previous y, so it vanishes on convergence if q can be reproduced.
template <std::size_t D>
class ConvexWeights {
public:
    /// The tolerance relative to the size: the resolution of weights in single precision.
    static constexpr double reproduced = 1e-7;

    /// Sets the point: its given weights, and the handles in a frame at q.
    template <Scalar T, class Weight>
    void load(const HandleView<T, D>& handles, const AffineFrame<double, D>& frame, const Weight& weight) {
        columns_.resize(handles.count);
        given_.resize(handles.count);
        weights_.assign(handles.count, 0.0);
        support_.resize(handles.count);
        needed_.assign(handles.count, 0);
        for (std::size_t i = 0; i < handles.count; ++i) {
            const auto row = frame.row(handles, i);
            for (std::size_t r = 0; r <= D; ++r) columns_[i][long(r)] = row[r];
            given_[i] = weight(i);
            support_[i] = i;
        }
    }

    /// Computes weights for at most `most` handles; `weight(i)` returns them. Returns false if q is not
    /// reproduced. Handles with the smallest weights are dropped, at most half of the surplus per step, while
    /// the others can reproduce q. This greedy choice is not optimal. (Exchanging handles to get closer
    /// weights was tried. It doubled the distances in motion, because handles far away move differently.)
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
            at_once = (std::min)(2 * at_once, (surplus + 1) / 2);
            while (!dropped) {
                const auto least = without_least(at_once);
                if (!least) break;
                dropped = solve(trial_, true);
                if (dropped) {
                    accept(trial_);
                } else if (at_once > 1) {
                    at_once /= 2;
                } else {
                    needed_[*least] = 1; // permanently: the hull of fewer handles is no larger
                    break;
                }
            }
            if (dropped || !too_many || !all_needed()) continue;
            // Too few handles can reproduce q: uses the closest point that they reproduce.
            exact = false;
            trial_.assign(support_.begin(), support_.end() - 1);
            solve(trial_, false);
            accept(trial_);
        }
    }

    double weight(std::size_t i) const noexcept { return weights_[i]; }
    /// Returns the handles with non-zero weights, by descending weight.
    std::span<const std::size_t> support() const noexcept { return support_; }

private:
    static constexpr int N = int(D) + 1;
    using Row = Eigen::Matrix<double, N, 1>;
    using Square = Eigen::Matrix<double, N, N>;

    /// Solves with all handles. If they cannot reproduce q, replaces q by the closest point that they can.
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
        Row centre = Row::Zero();
        for (std::size_t i = 0; i < given_.size(); ++i) centre += found_[i] * columns_[i];
        centre[0] = 0;
        for (Row& column : columns_) column -= centre;
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
    /// Sets trial_ to the support without the `count` smallest handles that can be dropped. Returns the
    /// smallest of these, or nothing.
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
    /// Accepts the solution for the handles `over`.
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

    /// Computes weights for some handles, in `found_`. With `exact`, returns false if they do not
    /// reproduce q. Otherwise they reproduce the closest point.
    bool solve(std::span<const std::size_t> over, bool exact) {
        found_.assign(given_.size(), 0.0);
        if (over.empty()) return false;
        // E is small relative to the equations, but large enough to keep y accurate if they have no solution.
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
                missed = (std::min)(missed, now);
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
            found_[i] = (std::max)(0.0, given_[i] + columns_[i].dot(y));
            total += found_[i];
        }
        if (!(total > 0.5)) return false;
        for (const std::size_t i : over) found_[i] /= total;
        return missed <= reproduced;
    }

    /// Returns Σ w a − (1, 0).
    Row sum(std::span<const std::size_t> over, const Row& y) const {
        Row total = Row::Zero();
        total[0] = -1;
        for (const std::size_t i : over)
            total += (std::max)(0.0, given_[i] + columns_[i].dot(y)) * columns_[i];
        return total;
    }
    /// Returns the objective of the dual problem: Σ w²/2 − y_0 + (y − centre)·E (y − centre)/2.
    double objective(std::span<const std::size_t> over, const Row& penalty, const Row& centre,
                     const Row& y) const {
        double squares = 0;
        for (const std::size_t i : over) {
            const double w = (std::max)(0.0, given_[i] + columns_[i].dot(y));
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
            const Row direction = -SmallMatrix<N>(matrix).llt().solve(gradient);
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
                if (length < 1e-14) { // the rest is rounding
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
    std::vector<char> needed_; // handles that cannot be dropped
};

} // namespace cageform::inline CAGEFORM_ABI::detail
