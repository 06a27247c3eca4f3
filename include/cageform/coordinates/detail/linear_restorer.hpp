// Linear precision for weights that miss it by a little.
#pragma once

#include <cageform/coordinates/detail/affine_rows.hpp>
#include <cageform/core/blocks.hpp>
#include <cageform/core/detail/simd_sqrt.hpp>

#include <Eigen/LU>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The least change of a point's weights that restores Σwκ = 1 and ΣwH = p, for all points of a
/// block; or, of weights that move a vector t, Σwκ = 0 and ΣwH = t.
///
/// The columns of A are the affine rows of the handles, r is the residual of the row sums. The
/// change is Aᵀ(AAᵀ)⁻¹ r. AAᵀ has D + 1 rows and is the same for all points.
template <Scalar T, std::size_t D>
class LinearRestorer {
public:
    struct Result {
        Lanes<T> partition, reproduction, before, change, least;
    };

    explicit LinearRestorer(const HandleView<T, D>& handles)
        : rows_(handles, frame_of(handles)) {
        const auto inverse = inverse_of(rows_.sum_of_squares());
        for (std::size_t r = 0; r <= D; ++r) {
            for (std::size_t c = 0; c <= D; ++c) inverse_[r][c] = static_cast<T>(inverse(long(r), long(c)));
        }
    }

    /// `row` holds the weights of a block of points; `bound` is one in lanes to treat and zero in
    /// others. Measures alone unless `restore`.
    Result run(const Lanes<T>* target, const Lanes<T>& bound, Lanes<T>* row, bool restore) const {
        Simd wanted[D + 1];
        wanted[0] = Simd(T(1));
        for (std::size_t k = 0; k < D; ++k)
            wanted[k + 1] = (Simd::load(target[k]) - Simd(frame().centre[k])) * Simd(T(1) / frame().size);
        return run_to(wanted, Simd(T(1)), bound, row, restore);
    }

    /// The same for vectors. What is worth a change is relative to their length.
    Result run_vectors(const Lanes<T>* target, const Lanes<T>& bound, Lanes<T>* row, bool restore) const {
        Simd wanted[D + 1], longest(T(0));
        wanted[0] = Simd(T(0));
        for (std::size_t k = 0; k < D; ++k) {
            wanted[k + 1] = Simd::load(target[k]) * Simd(T(1) / frame().size);
            longest = max<T>(longest, abs<T>(wanted[k + 1]));
        }
        return run_to(wanted, longest, bound, row, restore);
    }

private:
    using Simd = detail::Simd<T>;
    using Square = typename AffineRows<T, D>::Square;

    /// Eigen has formulas for up to four rows; above it compiles one algorithm for each size.
    static Square inverse_of(const Square& m) {
        if constexpr (D <= 3) {
            return m.inverse();
        } else {
            return Eigen::MatrixXd(m).fullPivLu().inverse();
        }
    }

    const AffineFrame<T, D>& frame() const noexcept { return rows_.frame(); }

    /// `wanted`: Σ w a. Residuals are rounding when they are below some epsilon times `unit`.
    Result run_to(const Simd* wanted, const Simd& unit, const Lanes<T>& bound, Lanes<T>* row,
                  bool restore) const {
        // Below 4 epsilon nothing is changed: exact zeros on edges would be lost.
        const Simd enough = Simd(4 * epsilon<T>) * unit;
        const Simd treat = Simd::load(bound);
        Simd missing[D + 1], change(T(0));
        Result result;
        Simd least = measure(row, wanted, missing);
        distance(missing).store(result.before);
        for (int round = 0; restore && round < 3; ++round) {
            Simd worst = abs<T>(missing[0]);
            for (std::size_t k = 1; k <= D; ++k) worst = max<T>(worst, abs<T>(missing[k]));
            const Simd apply = select<T>(enough < worst, treat, Simd(T(0)));
            if (!any(apply)) break;
            Simd y[D + 1];
            for (std::size_t r = 0; r <= D; ++r) {
                y[r] = Simd(inverse_[r][0]) * missing[0];
                for (std::size_t c = 1; c <= D; ++c) y[r] = y[r] + Simd(inverse_[r][c]) * missing[c];
                y[r] = y[r] * apply;
            }
            for (std::size_t i = 0; i < rows_.size(); ++i) {
                Simd delta = y[0] * Simd(rows_[i][0]);
                for (std::size_t r = 1; r <= D; ++r) delta = delta + y[r] * Simd(rows_[i][r]);
                change = max<T>(change, abs<T>(delta));
                (Simd::load(row[i]) + delta).store(row[i]);
            }
            least = measure(row, wanted, missing);
        }
        abs<T>(missing[0]).store(result.partition);
        distance(missing).store(result.reproduction);
        change.store(result.change);
        least.store(result.least);
        return result;
    }

    /// What is missing to what is wanted; returns the least weight.
    Simd measure(const Lanes<T>* row, const Simd* wanted, Simd* missing) const {
        for (std::size_t k = 0; k <= D; ++k) missing[k] = wanted[k];
        Simd least = Simd::load(row[0]);
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            const Simd w = Simd::load(row[i]);
            least = min<T>(least, w);
            for (std::size_t r = 0; r <= D; ++r) missing[r] = missing[r] - w * Simd(rows_[i][r]);
        }
        return least;
    }

    Simd distance(const Simd* missing) const {
        // Squared in units of the cage: in the caller's the square of a small error may vanish.
        Simd sum(T(0));
        for (std::size_t k = 0; k < D; ++k) {
            const Simd d = missing[k + 1] + Simd(frame().centre[k] / frame().size) * missing[0];
            sum = sum + d * d;
        }
        return Simd(frame().size) * sqrt(sum);
    }

    static bool any(const Simd& flags) {
        Lanes<T> lanes;
        flags.store(lanes);
        T sum = 0;
        for (const T x : lanes.v) sum += x;
        return sum != T(0);
    }

    AffineRows<T, D> rows_;
    T inverse_[D + 1][D + 1];
};

} // namespace cageform::inline CAGEFORM_ABI::detail
