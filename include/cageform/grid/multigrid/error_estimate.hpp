// How far a solution is from the exact one of its equations, as its residuals tell.
#pragma once

#include <cageform/core/detail/buffer.hpp>
#include <cageform/core/detail/simd.hpp>
#include <cageform/grid/multigrid/node_values.hpp>

#include <limits>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The largest residuals |b − A u| of a level. Nodes beside data have a positive row sum (at least
/// 1, as θ is at most 1); theirs are divided by it.
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

/// What is known of the error of a solution, per function.
struct SolveError {
    /// The residual times the largest ratio of correction to residual so far, with a safety factor
    /// of 2 to 4. Not a bound, but most often above the error.
    NodeValues estimate;
    /// From the residual alone, by the maximum principle: never less than the error, up to
    /// rounding.
    NodeValues bound;
};

/// Learns how much error a residual means from one cycle to the next.
///
/// The correction that a cycle finds on the coarse grid is the error before it, up to what
/// relaxation takes away. Correction over residual is called the gain.
///     estimate = caution · max(gain, 1) · residual
class ErrorEstimator {
public:
    void reset() noexcept {
        Vector(0.0f).store(gain_);
        Vector(0.0f).store(residual_);
        Vector(margin).store(caution_);
    }
    /// To be told of a cycle's correction on the first coarse level.
    void learn(const Buffer<NodeRow>& correction) noexcept {
        Vector largest(0.0f);
        for (const NodeRow& row : correction) largest = max<float>(largest, abs<float>(Vector::load(row)));
        const Vector residual = Vector::load(residual_), last = Vector::load(gain_), tiny(smallest);
        const Vector now =
            select<float>(Vector(0.0f) < residual, largest / max<float>(residual, tiny), Vector(0.0f));
        const Vector gain = max<float>(last, now);
        // Residuals get smoother from cycle to cycle and tell of more error. As the gain has grown
        // it may grow again, though hardly more than twofold; after the first cycle nothing is
        // known of it.
        const Vector growth = min<float>(gain / max<float>(last, tiny), Vector(2.0f));
        const Vector expected = select<float>(Vector(0.0f) < last, growth, Vector(2.0f));
        (Vector(margin) * expected).store(caution_);
        gain.store(gain_);
    }
    /// The error of a solution with this residual.
    ///
    ///   reach   the largest error of an interior node that a residual of 1 everywhere can mean
    SolveError judge(const Residual& residual, double reach) noexcept {
        const Vector largest = max<float>(residual.interior, residual.beside_data);
        largest.store(residual_);
        // A gain below 1 would trust relaxation; before the first cycle, 4 is a guess on the high
        // side.
        const Vector known = Vector::load(gain_);
        const Vector gain =
            select<float>(Vector(0.0f) < known, max<float>(Vector(1.0f), known), Vector(4.0f));
        return {widened(Vector::load(caution_) * gain * largest),
                widened(Vector(float(reach)) * residual.interior + residual.beside_data)};
    }
    /// To be told that the residual has changed by that much at most.
    void disturb(const NodeValues& change) noexcept {
        for (std::size_t k = 0; k < functions_together; ++k) residual_[k] += float(change[k]);
    }

private:
    using Vector = Simd<float>;
    /// What an estimate is more than the error that the gain tells of. A seventh is missing at
    /// worst in 1000 random domains (tests/grid/multigrid.cpp).
    static constexpr float margin = 2;
    static constexpr float smallest = (std::numeric_limits<float>::min)(); ///< divides zeros

    static NodeValues widened(const Vector& v) noexcept {
        NodeRow row;
        v.store(row);
        NodeValues values;
        for (std::size_t k = 0; k < functions_together; ++k) values[k] = double(row[k]);
        return values;
    }

    NodeRow gain_;     ///< the largest so far; 0 while unknown
    NodeRow residual_; ///< after the last cycle
    NodeRow caution_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
