// Chooses the weights of a block to keep, and fits them so that points move as before.
#pragma once

#include <cageform/binding/detail/moments.hpp>
#include <cageform/binding/detail/weight_loss.hpp>

#include <array>
#include <cmath>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The mean squared displacement of a point caused by a change δ of its weights: δᵀ K δ, where
///
///     K = mean over poses of m mᵀ + ν² I + α A Aᵀ
///
/// The vector m contains the handles' displacements in a pose minus their best affine fit; A contains
/// the affine rows. The second term accounts for movements of single handles; without it, weights would
/// fit only the given poses. ν is a fraction of the mean displacement. The third term accounts for
/// affine movements of mean size.
template <std::size_t D>
class SquareLoss {
public:
    SquareLoss(const Moments<D>& moments, const WeightLoss<D>& loss)
        : moments_(moments)
        , handles_(moments.size()) {
        if (loss.poses() == 0 || handles_ == 0) return;
        poses_.assign(handles_ * handles_, 0.0);
        double trace = 0;
        for (std::size_t p = 0; p < loss.poses(); ++p) {
            for (std::size_t k = 0; k < D; ++k) trace += add_pose(loss.displacements(p, k));
        }
        const double mean = trace / double(loss.poses()) / double(handles_);
        for (double& x : poses_) x /= double(loss.poses());
        // Chosen on bench_clone's figures. A third of this ν saves up to a third of the bytes but
        // doubles the distances in other kinds of poses; three times this ν needs up to two thirds more
        // bytes. Displacements below a millionth of the cage's size count as rounding errors.
        constexpr double share = 0.1, least = 1e-6;
        noise_ = (std::max)(share * share * mean, least * least);
        affine_ = (std::max)(mean, least * least);
    }

    std::size_t handles() const { return handles_; }
    const Moments<D>& moments() const { return moments_; }

    /// Writes K's column of a handle.
    void column(std::size_t handle, std::span<double> out) const {
        for (std::size_t h = 0; h < handles_; ++h)
            out[h] = affine_ * dot(moments_[h], moments_[handle]) +
                     (poses_.empty() ? 0 : poses_[handle * handles_ + h]);
        out[handle] += noise_;
    }
    /// A lower bound of the pivots of any Schur complement.
    double least_pivot() const { return noise_; }
    double diagonal(std::size_t handle) const {
        return affine_ * dot(moments_[handle], moments_[handle]) + noise_ +
               (poses_.empty() ? 0 : poses_[handle * handles_ + handle]);
    }

private:
    /// Adds m mᵀ; returns |m|².
    double add_pose(std::span<const double> displacements) {
        typename Moments<D>::Column fit{};
        for (std::size_t h = 0; h < handles_; ++h) fit = fit + displacements[h] * moments_.fit(h);
        std::vector<double> m(handles_);
        double squared = 0;
        for (std::size_t h = 0; h < handles_; ++h) {
            m[h] = displacements[h] - dot(fit, moments_[h]);
            squared += m[h] * m[h];
        }
        for (std::size_t a = 0; a < handles_; ++a) {
            for (std::size_t b = 0; b < handles_; ++b) poses_[a * handles_ + b] += m[a] * m[b];
        }
        return squared;
    }

    const Moments<D>& moments_;
    std::size_t handles_;
    std::vector<double> poses_; // #handles²; empty: no poses
    double noise_ = 1, affine_ = 1;
};

/// Ranks the handles of a block: `best` returns the next handle, and `add` appends it. `solution(n)` returns
/// new weights for the first n handles: those with the least square loss among all weights with the row sums
/// Σ wκ and Σ wH of the binding (κ, H: core/types/handles.hpp). Orthogonal least squares (Chen, Billings,
/// Luo, Int. J. Control 50 (1989)), on a Cholesky factorisation of K that grows by one row per handle.
///
///   L     number of points of the block
///   cost  O(#handles · (count + L)) for the next handle, and for a solution O(count² · L)
template <std::size_t D, std::size_t L>
class GreedyRowSelection {
public:
    using Column = typename Moments<D>::Column;
    using Row = std::array<double, L>;

    /// Starts with no handles. `weights` are #handles rows of L numbers.
    GreedyRowSelection(const SquareLoss<D>& loss, std::span<const double> weights)
        : loss_(loss)
        , weights_(weights)
        , is_candidate_(loss.handles(), 0)
        , pivots_(loss.handles())
        , gradients_(loss.handles())
        , scratch_(loss.handles()) {
        const std::size_t handles = loss.handles();
        for (auto& row : gradients_) row.fill(0);
        for (std::size_t h = 0; h < handles; ++h) {
            pivots_[h] = loss.diagonal(h);
            const double* const w = weights.data() + h * L;
            if (std::all_of(w, w + L, [](double x) { return x == 0; })) continue;
            is_candidate_[h] = 1;
            ++candidates_;
            loss.column(h, scratch_);
            for (std::size_t other = 0; other < handles; ++other) {
                for (std::size_t lane = 0; lane < L; ++lane)
                    gradients_[other][lane] += scratch_[other] * w[lane];
            }
            for (std::size_t lane = 0; lane < L; ++lane)
                sums_[lane] = sums_[lane] + w[lane] * loss.moments()[h];
        }
        for (std::size_t h = 0; h < handles; ++h) {
            for (std::size_t lane = 0; lane < L; ++lane)
                lost_[lane] += gradients_[h][lane] * weights[h * L + lane];
        }
    }

    std::size_t candidates() const { return candidates_; } ///< the number of handles with a non-zero weight
    std::span<const std::uint32_t> order() const { return order_; }

    /// Returns the handle with the largest sum of gains. The gain of a point is the decrease of its
    /// square loss by a row for the handle, ignoring row sums, times its present square loss. So points
    /// with large losses count most.
    std::uint32_t best() const {
        double most = -1;
        std::uint32_t best = 0;
        for (std::size_t h = 0; h < loss_.handles(); ++h) {
            if (is_candidate_[h] == 0) continue;
            double gain = 0;
            for (std::size_t lane = 0; lane < L; ++lane)
                gain += lost_[lane] * gradients_[h][lane] * gradients_[h][lane];
            gain /= pivots_[h];
            if (gain > most) {
                most = gain;
                best = static_cast<std::uint32_t>(h);
            }
        }
        return best;
    }

    /// Adds a row for a candidate that is not yet added.
    void add(std::uint32_t handle) {
        const std::size_t handles = loss_.handles(), count = order_.size();
        factor_.resize((count + 1) * handles);
        double* const next = factor_.data() + count * handles;
        loss_.column(handle, {next, handles});
        for (std::size_t j = 0; j < count; ++j) {
            const double* const column = factor_.data() + j * handles;
            const double f = column[handle];
            for (std::size_t h = 0; h < handles; ++h) next[h] -= f * column[h];
        }
        const double root = std::sqrt(pivots_[handle]);
        Row step;
        for (std::size_t lane = 0; lane < L; ++lane) {
            step[lane] = gradients_[handle][lane] / root;
            lost_[lane] = (std::max)(lost_[lane] - step[lane] * step[lane], 0.0);
        }
        Column affine = loss_.moments()[handle];
        for (std::size_t j = 0; j < count; ++j)
            affine = affine - factor_[j * handles + handle] * affine_steps_[j];
        affine_steps_.push_back(1 / root * affine);
        for (std::size_t h = 0; h < handles; ++h) {
            next[h] /= root;
            pivots_[h] = (std::max)(pivots_[h] - next[h] * next[h], loss_.least_pivot());
            for (std::size_t lane = 0; lane < L; ++lane) gradients_[h][lane] -= next[h] * step[lane];
        }
        steps_.push_back(step);
        order_.push_back(handle);
        is_candidate_[handle] = 0;
    }

    /// Returns the weights of the first `count` added handles.
    std::vector<Row> solution(std::size_t count) const {
        std::vector<Row> x(count);
        if (count == candidates_) { // nothing is dropped
            for (std::size_t j = 0; j < count; ++j)
                std::copy_n(weights_.data() + order_[j] * L, L, x[j].begin());
            return x;
        }
        std::copy_n(steps_.begin(), count, x.begin());
        restore_sums(x);
        for (std::size_t j = count; j-- > 0;) {
            const double* const column = factor_.data() + j * loss_.handles();
            for (std::size_t i = j + 1; i < count; ++i) {
                for (std::size_t lane = 0; lane < L; ++lane) x[j][lane] -= column[order_[i]] * x[i][lane];
            }
            for (double& w : x[j]) w /= column[order_[j]];
        }
        return x;
    }

private:
    /// Adds the Lagrange multipliers of the row sums to the right-hand side Lᵀ x.
    void restore_sums(std::vector<Row>& x) const {
        typename Moments<D>::Matrix square{};
        for (std::size_t j = 0; j < x.size(); ++j)
            add_outer_product(square, affine_steps_[j], affine_steps_[j]);
        const auto inverse = Moments<D>::power(square, -1);
        for (std::size_t lane = 0; lane < L; ++lane) {
            Column missing = sums_[lane];
            for (std::size_t j = 0; j < x.size(); ++j) missing = missing - x[j][lane] * affine_steps_[j];
            const Column multipliers = product(inverse, missing);
            for (std::size_t j = 0; j < x.size(); ++j) x[j][lane] += dot(multipliers, affine_steps_[j]);
        }
    }

    const SquareLoss<D>& loss_;
    std::span<const double> weights_;
    std::vector<char> is_candidate_;
    std::vector<double> pivots_;  // the diagonal of K's Schur complement
    std::vector<Row> gradients_;  // K w minus the part of the added handles
    std::vector<double> scratch_; // #handles
    std::size_t candidates_ = 0;
    std::array<Column, L> sums_{};
    Row lost_{}; // the squared loss of every point
    std::vector<std::uint32_t> order_;
    std::vector<double> factor_; // columns of #handles numbers
    std::vector<Row> steps_;     // L⁻¹ K w of the handles added
    std::vector<Column> affine_steps_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
