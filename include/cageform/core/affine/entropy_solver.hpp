// The row of weights nearest to a positive prior that reproduces linear functions.
#pragma once

#include <cageform/core/affine/dual.hpp>
#include <cageform/core/detail/simd_exp.hpp>
#include <cageform/core/detail/simd_log.hpp>

#include <limits>
#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Whether any lane of a mask is set.
inline bool any_of(bool mask) noexcept {
    return mask;
}
template <class Mask>
    requires requires(const Mask& mask) { any(mask); }
bool any_of(const Mask& mask) noexcept {
    return any(mask);
}

/// The Cholesky factors L D Lᵀ of a symmetric matrix.
template <class X, std::size_t D>
struct SmallFactors {
    X lower[D][D]; ///< of L, below the diagonal
    X inverse[D];  ///< reciprocals of the diagonal factor

    /// Adds `floor` to the diagonal.
    SmallFactors(const X (&matrix)[D][D], const X& floor) noexcept {
        using S = ScalarOf<X>;
        for (std::size_t k = 0; k < D; ++k) {
            X diagonal = matrix[k][k] + floor;
            X scaled[D];
            for (std::size_t j = 0; j < k; ++j) {
                X entry = matrix[k][j];
                for (std::size_t i = 0; i < j; ++i) entry = entry - scaled[i] * lower[j][i];
                scaled[j] = entry;
                lower[k][j] = entry * inverse[j];
                diagonal = diagonal - scaled[j] * lower[k][j];
            }
            inverse[k] = X(S(1)) / (max)(diagonal, floor);
        }
    }
    template <class Y>
    Vec<Y, D> solve(Vec<Y, D> x) const noexcept {
        for (std::size_t k = 0; k < D; ++k) {
            for (std::size_t j = 0; j < k; ++j) x[k] = x[k] - lower[k][j] * x[j];
        }
        for (std::size_t k = 0; k < D; ++k) x[k] = inverse[k] * x[k];
        for (std::size_t k = D; k-- > 0;) {
            for (std::size_t j = k + 1; j < D; ++j) x[k] = x[k] - lower[j][k] * x[j];
        }
        return x;
    }
};

/// Finds the weights w_k = q_k e^(−λ·u_k) / Σ q e^(−λ·u) with Σ w u = 0: the row with Σ w = 1 and Σ w u = 0
/// that minimises Σ w ln(w/q). They exist if 0 is inside the hull of the vectors u_k with q_k > 0.
///
/// λ minimises the convex function F = ln Σ q e^(−λ·u), by Newton's method. If a step does not lower F
/// enough, the step ln(1 + R)/R does, where R is the extent of the vectors along the step: |F'''| ≤ R F''
/// along it. After a short step d, weights are multiplied by a series of e^(−d·u).
///
///   X      a scalar or a register
///   U      u(k): the vector to handle k, a Vec<X, D>, at most a few units long
template <class X, std::size_t D, class U>
class EntropySolver {
    using S = ScalarOf<X>;

public:
    static constexpr int most_passes = 200; ///< rarely more than 10; more if the prior spans many magnitudes
    static constexpr S most_length = 4;     ///< upper bound of the components of u, for speed
    static constexpr S most_multiplier = S(1e6); ///< a larger one means that no minimum exists

    ///   q        the prior, not negative; not all zero
    ///   rows     scratch memory and result: the weights, not normalised
    EntropySolver(std::span<const X> q, const U& u, std::span<X> rows) noexcept
        : q_(q)
        , u_(u)
        , rows_(rows) {}

    /// Returns 1 in lanes that converged or are skipped, else 0. No lane depends on the others.
    ///
    ///   skipped        1 in lanes whose weights are not needed, else 0
    ///   needs_factors  whether `factors` will be called
    X solve(const X& skipped, bool needs_factors) noexcept {
        const X zero(S(0)), one(S(1)), tolerance(sizeof(S) == 4 ? S(1e-8) : S(1e-15));
        constexpr S rounding = 8 * std::numeric_limits<S>::epsilon();
        Vec<X, D> base{}, step{};
        X least(S(0)), decrease(S(0)), is_sure(one), has_arrived(skipped), has_failed(zero);
        shift_ = zero;
        for (std::size_t k = 0; k < q_.size(); ++k) rows_[k] = q_[k];
        for (passes_ = 0; passes_ < most_passes; ++passes_) {
            evaluate();
            const auto rises = least - X(S(0.25)) * decrease + X(rounding) * (one + abs(least)) < value_;
            const auto is_rejected = both(rises, is_sure + has_arrived < X(S(0.5)));
            if (any_of(is_rejected)) {
                const X extent = extent_along(step), shorter = log(one + extent) / extent;
                for (std::size_t c = 0; c < D; ++c) {
                    multiplier_[c] = select(is_rejected, base[c] + shorter * step[c], multiplier_[c]);
                    change_[c] = select(is_rejected, X(most_length), zero); // any change that is not short
                }
                is_sure = select(is_rejected, one, is_sure);
                continue; // accepted lanes are evaluated again, with the same result
            }
            base = multiplier_;
            least = value_;
            step = SmallFactors<X, D>(hessian_, floor_).solve(mean_);
            for (X& s : step.v) s = select(X(S(0.5)) < has_arrived, zero, s);
            decrease = zero;
            for (std::size_t c = 0; c < D; ++c) decrease = decrease + step[c] * mean_[c];
            is_sure = zero;
            for (std::size_t c = 0; c < D; ++c) multiplier_[c] = base[c] + step[c];
            change_ = step;
            has_arrived = select(decrease < tolerance, one, has_arrived);
            // Without a minimum, the multiplier grows without bound.
            X size(S(0));
            for (const X& m : base.v) size = (max)(size, abs(m));
            has_failed = select(both(X(most_multiplier) < size, has_arrived < X(S(0.5))), one, has_failed);
            has_arrived = (max)(has_arrived, has_failed);
            if (!any_of(has_arrived < X(S(0.5)))) break;
        }
        if (needs_factors)
            evaluate();
        else
            evaluate_rows();
        return select(has_failed < X(S(0.5)), has_arrived, zero);
    }
    int passes() const noexcept { return passes_; }
    const Vec<X, D>& multiplier() const noexcept { return multiplier_; }
    const X& sum() const noexcept { return sum_; } ///< of the rows
    /// Of the Hessian, for derivatives. Next to the boundary its least eigenvalue may be below the floor of
    /// the steps.
    SmallFactors<X, D> factors() const noexcept {
        return {hessian_, X(std::numeric_limits<S>::epsilon()) * floor_ + X((std::numeric_limits<S>::min)())};
    }

private:
    /// Returns e^x for short steps; the error is below rounding.
    static X exp_of_short(const X& x) noexcept {
        const X square = x * x, one(S(1));
        const X third = X(S(1.0 / 2)) + x * X(S(1.0 / 6));
        if constexpr (sizeof(S) == 4) return one + x + square * (third + square * X(S(1.0 / 24)));
        return one + x +
               square * (third + square * (X(S(1.0 / 24)) + x * X(S(1.0 / 120)) + square * X(S(1.0 / 720))));
    }
    /// Calls add(row, u) for each handle, with its row at the multiplier, and stores the rows. Where the
    /// multiplier has changed little, rows are multiplied by a series.
    template <class Add>
    CAGEFORM_DETAIL_INLINE void for_each_row(const Add& add) noexcept {
        constexpr S small_product = S(sizeof(S) == 4 ? 0x1p-4 : 0x1p-6);
        X bound(S(0));
        for (std::size_t c = 0; c < D; ++c) bound = bound + abs(change_[c]);
        const auto is_long = X(small_product / most_length) < bound;
        const bool some_are_long = any_of(is_long);
        if (some_are_long) shift_ = select(is_long, least_exponent(), shift_);
        const auto by_series = [&](std::size_t k, const Vec<X, D>& u) {
            return rows_[k] * exp_of_short(-inner(change_, u));
        };
        const auto anew = [&](std::size_t k, const Vec<X, D>& u) {
            return q_[k] * exp(-(inner(multiplier_, u) + shift_));
        };
        const auto for_each = [&](const auto& row_of) {
            for (std::size_t k = 0; k < q_.size(); ++k) {
                const Vec<X, D> u = u_(k);
                const X row = row_of(k, u);
                rows_[k] = row;
                add(row, u);
            }
        };
        if (!any_of(X(S(0)) < bound))
            for_each([&](std::size_t k, const Vec<X, D>&) { return rows_[k]; });
        else if (!some_are_long)
            for_each(by_series);
        else if (!any_of(bound <= X(small_product / most_length)))
            for_each(anew);
        else
            for_each([&](std::size_t k, const Vec<X, D>& u) {
                return select(is_long, anew(k, u), by_series(k, u));
            });
        for (X& c : change_.v) c = X(S(0));
    }
    /// Computes the rows at the multiplier and their sum.
    void evaluate_rows() noexcept {
        X sum(S(0));
        for_each_row([&](const X& row, const Vec<X, D>&) { sum = sum + row; });
        sum_ = sum;
    }
    /// Computes the rows at the multiplier, their sum, F, the mean of u and the Hessian of F.
    void evaluate() noexcept {
        const X zero(S(0));
        X sum = zero;
        Vec<X, D> first{};
        X second[D][D];
        for (std::size_t r = 0; r < D; ++r) {
            first[r] = zero;
            for (std::size_t c = 0; c <= r; ++c) second[r][c] = zero;
        }
        for_each_row([&](const X& row, const Vec<X, D>& u) {
            sum = sum + row;
            for (std::size_t r = 0; r < D; ++r) {
                const X weighted = row * u[r];
                first[r] = first[r] + weighted;
                for (std::size_t c = 0; c <= r; ++c) second[r][c] = second[r][c] + weighted * u[c];
            }
        });
        sum_ = sum;
        const X inverse = X(S(1)) / sum_;
        X trace = zero, square = zero;
        for (std::size_t r = 0; r < D; ++r) {
            mean_[r] = inverse * first[r];
            for (std::size_t c = 0; c <= r; ++c)
                hessian_[r][c] = inverse * second[r][c] - mean_[r] * mean_[c];
            trace = trace + hessian_[r][r];
            square = square + mean_[r] * mean_[r];
        }
        // The difference cancels if nearly all weight is on distant handles of one direction.
        constexpr S cancels = sizeof(S) == 4 ? S(1e-2) : S(1e-5);
        const auto has_cancelled = trace < X(cancels) * square;
        if (any_of(has_cancelled)) trace = recompute_hessian(inverse, has_cancelled);
        constexpr S relative = sizeof(S) == 4 ? S(1e-7) : S(1e-14);
        floor_ = X(relative) * trace + X((std::numeric_limits<S>::min)());
        value_ = log((max)(sum_, X((std::numeric_limits<S>::min)()))) + shift_;
    }
    /// Computes the Hessian with the mean subtracted first, in the lanes of a mask. Returns the trace.
    template <class Mask>
    CAGEFORM_DETAIL_NO_INLINE X recompute_hessian(const X& inverse, const Mask& wanted) noexcept {
        X sum[D][D], trace(S(0));
        for (auto& row : sum) {
            for (X& entry : row) entry = X(S(0));
        }
        for (std::size_t k = 0; k < q_.size(); ++k) {
            const Vec<X, D> u = u_(k) - mean_;
            for (std::size_t r = 0; r < D; ++r) {
                for (std::size_t c = 0; c <= r; ++c) sum[r][c] = sum[r][c] + inverse * rows_[k] * u[r] * u[c];
            }
        }
        for (std::size_t r = 0; r < D; ++r) {
            for (std::size_t c = 0; c <= r; ++c) hessian_[r][c] = select(wanted, sum[r][c], hessian_[r][c]);
            trace = trace + hessian_[r][r];
        }
        return trace;
    }
    static X inner(const Vec<X, D>& a, const Vec<X, D>& b) noexcept {
        X sum = a[0] * b[0];
        for (std::size_t c = 1; c < D; ++c) sum = sum + a[c] * b[c];
        return sum;
    }
    /// Returns what makes all exponents at most zero where they might overflow, else zero.
    X least_exponent() const noexcept {
        constexpr S safe = sizeof(S) == 4 ? S(40) : S(300);
        const X zero(S(0));
        X bound = zero;
        for (std::size_t c = 0; c < D; ++c) bound = bound + abs(multiplier_[c]);
        const auto might_overflow = X(safe / most_length) < bound;
        if (!any_of(might_overflow)) return zero;
        X least((std::numeric_limits<S>::max)());
        for (std::size_t k = 0; k < q_.size(); ++k)
            least = (min)(least, select(zero < q_[k], inner(multiplier_, u_(k)), least));
        return select(might_overflow, -least, zero);
    }
    /// Returns the largest difference of d·u among handles with a positive prior.
    X extent_along(const Vec<X, D>& d) const noexcept {
        const X zero(S(0));
        X low((std::numeric_limits<S>::max)()), high = -low;
        for (std::size_t k = 0; k < q_.size(); ++k) {
            const Vec<X, D> u = u_(k);
            X along = zero;
            for (std::size_t c = 0; c < D; ++c) along = along + d[c] * u[c];
            const auto counts = zero < q_[k];
            low = (min)(low, select(counts, along, low));
            high = (max)(high, select(counts, along, high));
        }
        return high - low;
    }

    std::span<const X> q_;
    const U& u_;
    std::span<X> rows_;
    Vec<X, D> multiplier_{}, mean_{};
    Vec<X, D> change_{}; ///< of the multiplier since the last rows
    X hessian_[D][D], floor_, sum_, value_, shift_;
    int passes_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
