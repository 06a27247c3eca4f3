// Estimates the error of a solution from its residuals.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/multigrid/node_values.hpp>

#include <limits>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The largest residuals |b − A u| of a level. Nodes next to data have a positive row sum (at least 1,
/// since θ is at most 1); their residuals are divided by it.
struct Residual {
    Simd<float> interior{0.0f}, beside_data{0.0f};

    CAGEFORM_DETAIL_INLINE void add(const Simd<float>& r) noexcept {
        interior = max<float>(interior, abs<float>(r));
    }
    CAGEFORM_DETAIL_INLINE void add(const Simd<float>& r, float row_sum) noexcept {
        if (row_sum >= 1) {
            beside_data = max<float>(beside_data, Simd<float>(1 / row_sum) * abs<float>(r));
        } else {
            add(r);
        }
    }
};

/// The error of a solution: an estimate and a bound for each function.
struct SolveError {
    /// The residual times the largest ratio of correction to residual so far, with a safety factor of 2 to 4.
    /// This estimate is almost always above the error, but it is not a bound.
    NodeValues estimate;
    /// An upper bound from the residual alone, by the maximum principle, up to rounding.
    NodeValues bound;
};

/// Estimates the error from the residual and the corrections of previous cycles.
///
/// The correction of a cycle on the coarse grid is the error before it, except for the part that relaxation
/// removes. The ratio of correction to residual is called the gain:
///     estimate = safety · max(gain, 1) · residual
class ErrorEstimator {
public:
    void reset() noexcept {
        Vector(0.0f).store(gain_);
        Vector(0.0f).store(residual_);
        Vector(margin).store(safety_);
    }
    /// Updates the gain from a cycle's correction on the first coarse level.
    void update_gain(const Buffer<NodeRow>& correction) noexcept {
        Vector largest(0.0f);
        for (const NodeRow& row : correction) largest = max<float>(largest, abs<float>(Vector::load(row)));
        const Vector residual = Vector::load(residual_), last = Vector::load(gain_), tiny(smallest);
        const Vector now =
            select<float>(Vector(0.0f) < residual, largest / max<float>(residual, tiny), Vector(0.0f));
        const Vector gain = max<float>(last, now);
        // Residuals become smoother from cycle to cycle, and the error of a smooth residual is larger, so the
        // gain grows. The safety factor assumes the same growth, at most 2, for the next cycle. After the
        // first cycle the growth is unknown, and 2 is assumed.
        const Vector growth = min<float>(gain / max<float>(last, tiny), Vector(2.0f));
        const Vector expected = select<float>(Vector(0.0f) < last, growth, Vector(2.0f));
        (Vector(margin) * expected).store(safety_);
        gain.store(gain_);
    }
    /// Returns the error of a solution with this residual.
    ///
    ///   reach  the largest error of an interior node for a residual of 1 everywhere
    SolveError estimate(const Residual& residual, double reach) noexcept {
        const Vector largest = max<float>(residual.interior, residual.beside_data);
        largest.store(residual_);
        // The correction lacks the error that relaxation removes, so a gain below 1 is too small: 1 is used
        // instead. Before the first cycle the gain is unknown; 4 is a high guess.
        const Vector known = Vector::load(gain_);
        const Vector gain =
            select<float>(Vector(0.0f) < known, max<float>(Vector(1.0f), known), Vector(4.0f));
        return {widened(Vector::load(safety_) * gain * largest),
                widened(Vector(float(reach)) * residual.interior + residual.beside_data)};
    }
    /// Adds a change of the right-hand side to the residual.
    void disturb(const NodeValues& change) noexcept {
        for (std::size_t k = 0; k < functions_together; ++k) residual_[k] += float(change[k]);
    }

private:
    using Vector = Simd<float>;
    /// The safety factor of the estimate. In the worst of 1000 random domains the estimate is still a
    /// seventh too low (tests/grid/multigrid.cpp).
    static constexpr float margin = 2;
    static constexpr float smallest = (std::numeric_limits<float>::min)(); ///< avoids 0/0

    static NodeValues widened(const Vector& v) noexcept {
        NodeRow row;
        v.store(row);
        NodeValues values;
        for (std::size_t k = 0; k < functions_together; ++k) values[k] = double(row[k]);
        return values;
    }

    NodeRow gain_;     ///< the largest gain so far; 0 while unknown
    NodeRow residual_; ///< the residual after the last cycle
    NodeRow safety_;   ///< the safety factor of the next estimate, 2 to 4
};

} // namespace cageform::inline CAGEFORM_ABI::detail
