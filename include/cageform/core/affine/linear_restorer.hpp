// Restores linear precision of approximate weights.
#pragma once

#include <cageform/core/affine/affine_rows.hpp>
#include <cageform/core/affine/compensated_sum.hpp>
#include <cageform/core/affine/orthonormal_rows.hpp>
#include <cageform/core/detail/simd_instructions.hpp>
#include <cageform/core/types/blocks.hpp>
#include <cageform/core/types/buffer.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Changes the weights of each point p as little as possible (in the 2-norm), so that Σwκ = 1 and ΣwH = p.
/// Weights of a vector t are changed so that Σwκ = 0 and ΣwH = t.
///
/// The rows of A are the affine rows of the handles; r is the residual of the row sums. With A = QR the
/// change is Q R⁻ᵀ r. This equals A(AᵀA)⁻¹ r but does not square the condition number, which is large
/// for thin cages. A change that would not lower the residual is discarded: for large weights, rounding
/// may exceed the residual.
///
/// With `local`, zero weights stay zero. The change is then the smallest one among the other handles, Q
/// M⁻¹ R⁻ᵀ r. M is the sum of q qᵀ over the rows q of Q of these handles.
template <Scalar T, std::size_t D>
class LinearRestorer {
public:
    struct Result {
        Lanes<T> partition, reproduction, before, change, least, sizes; ///< sizes: Σ|w|
        Lanes<T> missed; ///< 1 in lanes whose residual exceeds rounding errors, else 0
    };

    explicit LinearRestorer(const HandleView<T, D>& handles, bool local = false)
        : rows_(handles, frame_of(handles))
        , local_(local) {
        Buffer<Vec<double, D + 1>> rows;
        rows.reserve(rows_.size());
        basis_.reserve(rows_.size());
        for (std::size_t i = 0; i < rows_.size(); ++i) rows.push_back(vec_cast<double>(rows_[i]));
        const OrthonormalRows<D + 1> orthonormal(std::move(rows));
        for (std::size_t i = 0; i < rows_.size(); ++i) basis_.push_back(vec_cast<T>(orthonormal[i]));
        for (std::size_t k = 0; k <= D; ++k) triangle_[k] = vec_cast<T>(orthonormal.triangle()[k]);
    }

    /// Restores a block of points. `row` holds their weights; `bound` is 1 in lanes to restore, else 0.
    /// Without `restore` it only measures the residuals.
    Result run(const Lanes<T>* target, const Lanes<T>& bound, Lanes<T>* row, bool restore) const {
        Row wanted;
        wanted[0] = Simd(T(1));
        for (std::size_t k = 0; k < D; ++k)
            wanted[k + 1] = (Simd::load(target[k]) - Simd(frame().centre[k])) * Simd(T(1) / frame().size);
        return run_to(wanted, Simd(T(1)), bound, row, restore);
    }

    /// Restores weights of vectors. The threshold for a change is relative to the vectors' lengths.
    Result run_vectors(const Lanes<T>* target, const Lanes<T>& bound, Lanes<T>* row, bool restore) const {
        Row wanted;
        wanted[0] = Simd(T(0));
        for (std::size_t k = 0; k < D; ++k) wanted[k + 1] = Simd::load(target[k]) * Simd(T(1) / frame().size);
        return run_to(wanted, largest(wanted), bound, row, restore);
    }

private:
    using Simd = detail::Simd<T>;
    /// One number for κ and one for each axis.
    using Row = std::array<Simd, D + 1>;

    const AffineFrame<T, D>& frame() const noexcept { return rows_.frame(); }

    /// Makes the row sums Σ w a equal `wanted`. Residuals below a few epsilon times `unit` count as
    /// rounding errors.
    Result run_to(const Row& wanted, const Simd& unit, const Lanes<T>& bound, Lanes<T>* row,
                  bool restore) const {
        // Keeps weights with residuals below 4 epsilon: a change would destroy exact zeros on edges.
        const Simd enough = Simd(4 * epsilon<T>) * unit, zero(T(0));
        Simd treat = restore ? Simd::load(bound) : zero;
        Result result;
        auto [missing, least, sizes] = measure(wanted, [&](std::size_t i) { return Simd::load(row[i]); });
        Simd worst = largest(missing), change = zero;
        distance(missing).store(result.before);
        for (int round = 0; round < 3; ++round) {
            treat = select<T>(enough < worst, treat, zero);
            if (!any(zero < treat)) break;
            Row step = in_basis(triangle_, missing);
            if (local_) step = solve_among(row, step);
            const auto tried =
                measure(wanted, [&](std::size_t i) { return Simd::load(row[i]) + change_of(step, row, i); });
            const Simd left = largest(tried.missing);
            treat = select<T>(left < worst, treat, zero);
            const auto accepted = zero < treat;
            for (Simd& s : step) s = select<T>(accepted, s, zero);
            for (std::size_t i = 0; i < rows_.size(); ++i) {
                const Simd delta = change_of(step, row, i);
                change = max<T>(change, abs<T>(delta));
                (Simd::load(row[i]) + delta).store(row[i]);
            }
            for (std::size_t k = 0; k <= D; ++k)
                missing[k] = select<T>(accepted, tried.missing[k], missing[k]);
            least = select<T>(accepted, tried.least, least);
            sizes = select<T>(accepted, tried.sizes, sizes);
            worst = select<T>(accepted, left, worst);
        }
        abs<T>(missing[0]).store(result.partition);
        distance(missing).store(result.reproduction);
        change.store(result.change);
        least.store(result.least);
        sizes.store(result.sizes);
        // Far outside, weights grow with the distance, and so does the rounding of their sums.
        const Simd rounding = Simd(128 * epsilon<T>) * max<T>(unit, largest(wanted));
        select<T>(rounding < worst, restore ? Simd::load(bound) : zero, zero).store(result.missed);
        return result;
    }

    /// Returns the change of a handle's weight.
    Simd change_of(const Row& step, const Lanes<T>* row, std::size_t handle) const {
        Simd delta = step[0] * Simd(basis_[handle][0]);
        for (std::size_t r = 1; r <= D; ++r) delta = delta + step[r] * Simd(basis_[handle][r]);
        return local_ ? delta * weighted(row[handle]) : delta;
    }
    /// Returns 1 in lanes with a non-zero weight, else 0.
    static Simd weighted(const Lanes<T>& weight) {
        const Simd zero(T(0));
        return select<T>(zero < abs<T>(Simd::load(weight)), Simd(T(1)), zero);
    }

    /// Solves M y = step by Gaussian elimination, where M is the sum of q qᵀ over the handles with a
    /// non-zero weight. If M is singular, y is zero in the components whose pivots vanish.
    Row solve_among(const Lanes<T>* row, Row step) const {
        std::array<Row, D + 1> m;
        for (Row& sums : m) sums.fill(Simd(T(0)));
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            const Simd one = weighted(row[i]);
            for (std::size_t r = 0; r <= D; ++r) {
                for (std::size_t c = r; c <= D; ++c)
                    m[r][c] = m[r][c] + one * Simd(basis_[i][r] * basis_[i][c]);
            }
        }
        Row first, inverse;
        for (std::size_t k = 0; k <= D; ++k) first[k] = m[k][k];
        for (std::size_t k = 0; k <= D; ++k) {
            const Simd zero(T(0)), one(T(1)), &pivot = m[k][k];
            const auto sound = Simd(64 * epsilon<T>) * first[k] < pivot;
            inverse[k] = select<T>(sound, one / select<T>(sound, pivot, one), zero);
            for (std::size_t r = k + 1; r <= D; ++r) {
                const Simd factor = m[k][r] * inverse[k];
                for (std::size_t c = r; c <= D; ++c) m[r][c] = m[r][c] - factor * m[k][c];
                step[r] = step[r] - factor * step[k];
            }
        }
        for (std::size_t k = D + 1; k-- > 0;) {
            for (std::size_t c = k + 1; c <= D; ++c) step[k] = step[k] - m[k][c] * step[c];
            step[k] = step[k] * inverse[k];
        }
        return step;
    }

    struct Measures {
        Row missing; ///< residual to `wanted`
        Simd least;
        Simd sizes;
    };
    /// Measures the weights that weight(i) returns for handle i.
    template <class Weight>
    Measures measure(const Row& wanted, const Weight& weight) const {
        Measures m{wanted, weight(0), Simd(T(0))};
        const Row sums = compensated_sums<Simd, D + 1>(rows_.size(), [&](std::size_t i, Row& sum) {
            const Simd w = weight(i);
            m.least = min<T>(m.least, w);
            m.sizes = m.sizes + abs<T>(w);
            for (std::size_t r = 0; r <= D; ++r) sum[r] = sum[r] + w * Simd(rows_[i][r]);
        });
        for (std::size_t r = 0; r <= D; ++r) m.missing[r] = m.missing[r] - sums[r];
        return m;
    }

    CAGEFORM_DETAIL_INLINE static Simd largest(const Row& row) {
        Simd most = abs<T>(row[0]);
        for (std::size_t k = 1; k <= D; ++k) most = max<T>(most, abs<T>(row[k]));
        return most;
    }

    Simd distance(const Row& missing) const {
        // In units of the cage's size, so that squares of small errors do not underflow.
        Simd sum(T(0));
        for (std::size_t k = 0; k < D; ++k) {
            const Simd d = missing[k + 1] + Simd(frame().centre[k] / frame().size) * missing[0];
            sum = sum + d * d;
        }
        return Simd(frame().size) * sqrt(sum);
    }

    AffineRows<T, D> rows_;
    bool local_ = false;
    Buffer<Vec<T, D + 1>> basis_; ///< the rows of Q
    Vec<Vec<T, D + 1>, D + 1> triangle_{};
};

} // namespace cageform::inline CAGEFORM_ABI::detail
