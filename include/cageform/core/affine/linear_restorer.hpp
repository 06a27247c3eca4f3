// Restores linear precision of approximate weights.
#pragma once

#include <cageform/core/affine/affine_rows.hpp>
#include <cageform/core/affine/compensated_sum.hpp>
#include <cageform/core/affine/entropy_solver.hpp>
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
///
/// Where this change would make a non-negative row negative, the row is projected instead
/// (entropy_solver.hpp): weights stay positive or zero. If the handles with positive weights do not surround
/// the point, no such weights exist, and the change is made. Weights of vectors, and of handles that include
/// vectors, are not projected.
template <Scalar T, std::size_t D>
class LinearRestorer {
public:
    struct Result {
        Lanes<T> partition, reproduction, before, change, least, sizes; ///< sizes: Σ|w|
        Lanes<T> missed; ///< 1 in lanes whose residual exceeds rounding errors, else 0
    };

    /// The memory of projections; each thread needs its own.
    struct Scratch {
        Buffer<detail::Simd<T>> prior, weights;
    };

    explicit LinearRestorer(const HandleView<T, D>& handles, bool local = false)
        : rows_(handles, frame_of(handles))
        , local_(local)
        , only_points_(handles.point_count() == handles.count) {
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
    Result run(const Lanes<T>* target, const Lanes<T>& bound, Lanes<T>* row, bool restore,
               Scratch& scratch) const {
        Row wanted;
        wanted[0] = Simd(T(1));
        for (std::size_t k = 0; k < D; ++k)
            wanted[k + 1] = (Simd::load(target[k]) - Simd(frame().centre[k])) * Simd(T(1) / frame().size);
        return run_to({wanted, Simd(T(1))}, bound, row, restore, only_points_ ? &scratch : nullptr);
    }

    /// Restores weights of vectors. The threshold for a change is relative to the vectors' lengths.
    Result run_vectors(const Lanes<T>* target, const Lanes<T>& bound, Lanes<T>* row, bool restore) const {
        Row wanted;
        wanted[0] = Simd(T(0));
        for (std::size_t k = 0; k < D; ++k) wanted[k + 1] = Simd::load(target[k]) * Simd(T(1) / frame().size);
        return run_to({wanted, largest(wanted)}, bound, row, restore, nullptr);
    }

private:
    using Simd = detail::Simd<T>;
    /// One number for κ and one for each axis.
    using Row = std::array<Simd, D + 1>;

    const AffineFrame<T, D>& frame() const noexcept { return rows_.frame(); }

    struct Measures {
        Row missing; ///< residual to `wanted`
        Simd least;
        Simd sizes;
    };
    /// The measures of the present weights.
    struct State : Measures {
        Simd worst; ///< the largest number of `missing`
        Simd change = Simd(T(0));

        explicit State(const Measures& measures)
            : Measures(measures)
            , worst(largest(measures.missing)) {}
        void accept(const typename Simd::Mask& lanes, const Measures& measures) {
            for (std::size_t k = 0; k <= D; ++k)
                this->missing[k] = select<T>(lanes, measures.missing[k], this->missing[k]);
            this->least = select<T>(lanes, measures.least, this->least);
            this->sizes = select<T>(lanes, measures.sizes, this->sizes);
            worst = select<T>(lanes, largest(measures.missing), worst);
        }
    };

    /// The row sums to reach. Residuals below a few epsilon times `unit` count as rounding errors.
    struct Goal {
        Row wanted;
        Simd unit;
    };

    /// Makes the row sums Σ w a equal `goal.wanted`. Without scratch memory, no weights are projected.
    Result run_to(const Goal& goal, const Lanes<T>& bound, Lanes<T>* row, bool restore,
                  Scratch* scratch) const {
        const Row& wanted = goal.wanted;
        // Keeps weights with residuals below 4 epsilon: a change would destroy exact zeros on edges.
        const Simd enough = Simd(4 * epsilon<T>) * goal.unit, zero(T(0));
        Simd treat = restore ? Simd::load(bound) : zero;
        Result result;
        State now(measure(wanted, [&](std::size_t i) { return Simd::load(row[i]); }));
        distance(now.missing).store(result.before);
        for (int round = 0; round < 3; ++round) {
            treat = select<T>(enough < now.worst, treat, zero);
            if (!any(zero < treat)) break;
            Row step = in_basis(triangle_, now.missing);
            if (local_) step = solve_among(row, step);
            const auto tried =
                measure(wanted, [&](std::size_t i) { return Simd::load(row[i]) + change_of(step, row, i); });
            treat = select<T>(largest(tried.missing) < now.worst, treat, zero);
            auto accepted = zero < treat;
            const auto turns = accepted & (zero <= now.least) & (tried.least < zero);
            if (scratch != nullptr && any(turns)) {
                const auto rounded = turns & (now.worst <= Simd(2) * enough); // left as it is
                treat = select<T>(rounded, zero, treat);
                accepted = accepted ^ rounded ^ project(wanted, turns ^ rounded, row, now, *scratch);
            }
            for (Simd& s : step) s = select<T>(accepted, s, zero);
            for (std::size_t i = 0; i < rows_.size(); ++i) {
                const Simd delta = change_of(step, row, i);
                now.change = max<T>(now.change, abs<T>(delta));
                (Simd::load(row[i]) + delta).store(row[i]);
            }
            now.accept(accepted, tried);
        }
        abs<T>(now.missing[0]).store(result.partition);
        distance(now.missing).store(result.reproduction);
        now.change.store(result.change);
        now.least.store(result.least);
        now.sizes.store(result.sizes);
        // Far outside, weights grow with the distance, and so does the rounding of their sums.
        const Simd rounding = Simd(128 * epsilon<T>) * max<T>(goal.unit, largest(wanted));
        select<T>(rounding < now.worst, restore ? Simd::load(bound) : zero, zero).store(result.missed);
        return result;
    }

    /// Replaces the weights in some lanes by their projections if this lowers the residual. Returns the
    /// lanes whose projections exist.
    CAGEFORM_DETAIL_NO_INLINE typename Simd::Mask project(const Row& wanted, const typename Simd::Mask& lanes,
                                                          Lanes<T>* row, State& now, Scratch& scratch) const {
        const Simd zero(T(0)), one(T(1));
        if (!any(lanes)) return lanes;
        scratch.prior.resize(rows_.size());
        scratch.weights.resize(rows_.size());
        for (std::size_t i = 0; i < rows_.size(); ++i)
            scratch.prior[i] = select<T>(lanes, Simd::load(row[i]), one);
        const auto to_handle = [&](std::size_t i) {
            Vec<Simd, D> u;
            for (std::size_t k = 0; k < D; ++k) u[k] = Simd(rows_[i][k + 1]) - wanted[k + 1];
            return u;
        };
        const std::span prior(scratch.prior.data(), rows_.size());
        const std::span weights(scratch.weights.data(), rows_.size());
        EntropySolver<Simd, D, decltype(to_handle)> solver(prior, to_handle, weights);
        const Simd converged = solver.solve(select<T>(lanes, zero, one), false);
        const Simd inverse = one / solver.sum();
        const auto projected = measure(wanted, [&](std::size_t i) { return weights[i] * inverse; });
        const auto exists = lanes & (zero < converged);
        const auto accepted = exists & (largest(projected.missing) < now.worst);
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            const Simd before = Simd::load(row[i]);
            const Simd after = select<T>(accepted, weights[i] * inverse, before);
            now.change = max<T>(now.change, abs<T>(after - before));
            after.store(row[i]);
        }
        now.accept(accepted, projected);
        return exists;
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
    bool local_ = false, only_points_ = false;
    Buffer<Vec<T, D + 1>> basis_; ///< the rows of Q
    Vec<Vec<T, D + 1>, D + 1> triangle_{};
};

} // namespace cageform::inline CAGEFORM_ABI::detail
