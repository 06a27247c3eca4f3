// Gradients of sampled functions by finite differences.
#pragma once

#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/harmonic/cage_solver.hpp>
#include <cageform/core/detail/simd.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The sample points for the derivatives at blocks of points: each point and its two neighbours along each
/// axis, one cell apart or nearer at the boundary. At a distance of one cell, the discretisation errors of
/// values are alike and cancel.
template <DifferentiableSolver S, Scalar T>
class DifferenceSamples {
    using Place = Vec<double, S::dimension>;
    using Simd = detail::Simd<T>;
    static constexpr std::size_t D = S::dimension, lanes = lane_count<T>;
    /// The point, then below and above along each axis.
    static constexpr std::size_t samples = 2 * D + 1;
    using Point = Vec<T, D>;

public:
    /// Allocates memory for `blocks` blocks at a time.
    DifferenceSamples(const S& solver, const Batch<T>& batch, std::size_t blocks)
        : solver_(solver)
        , batch_(batch)
        , handles_(batch.rows.rows / D)
        , positions_(blocks * samples * D)
        , rows_(blocks * samples * handles_)
        , factors_(blocks * 2 * D)
        , states_(blocks * samples * lanes) {}

    /// Sets the sample points of block `b` in slot `at`, and the states of the block's points. A point is
    /// unreached if both neighbours along an axis coincide with it.
    void set(std::size_t b, std::size_t at) noexcept {
        const std::size_t first = b * lanes;
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::size_t i = first + lane;
            bool there = i < batch_.states.size() && batch_.states[i] != PointState::not_finite;
            if (there) {
                batch_.states[i] = set_point(at, lane, block_point<D>(batch_.points, i));
                there = is_bound(batch_.states[i]);
            }
            for (std::size_t n = 0; n < samples; ++n)
                states_[(at * samples + n) * lanes + lane] =
                    there ? PointState::inside : PointState::not_finite;
        }
    }

    /// Returns the sample points of the first `blocks` slots as a batch.
    Batch<T> batch(std::size_t blocks) noexcept {
        const std::size_t count = blocks * samples * lanes;
        return {BlockView<T>{positions_.data(), D, count},
                {rows_.data(), handles_, count},
                std::span(states_).first(count)};
    }

    /// Computes the gradients of block `b` from the values in slot `at`, in row axis · #handles + handle.
    /// Rows of points that are not inside or on the boundary are unchanged.
    void differentiate(std::size_t at, std::size_t b) const noexcept {
        Lanes<T> bound;
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::size_t i = b * lanes + lane;
            bound[lane] = i < batch_.states.size() && is_bound(batch_.states[i]) ? T(1) : T(0);
        }
        const auto is_set = Simd(T(0)) < Simd::load(bound);
        const Lanes<T>* const values = rows_.data() + at * samples * handles_;
        for (std::size_t axis = 0; axis < D; ++axis) {
            const Lanes<T>* const below = values + (2 * axis + 1) * handles_;
            const Lanes<T>* const above = below + handles_;
            const Simd to_below = Simd::load(factors_[(at * D + axis) * 2]);
            const Simd to_above = Simd::load(factors_[(at * D + axis) * 2 + 1]);
            Lanes<T>* const slopes = batch_.rows.block(b) + axis * handles_;
            for (std::size_t h = 0; h < handles_; ++h) {
                const Simd here = Simd::load(values[h]);
                const Simd slope =
                    to_below * (here - Simd::load(below[h])) + to_above * (Simd::load(above[h]) - here);
                select<T>(is_set, slope, Simd::load(slopes[h])).store(slopes[h]);
            }
        }
    }

private:
    static Place placed(const Point& p) noexcept { return vec_cast<double>(p); }
    static bool is_bound(PointState state) noexcept {
        return state == PointState::inside || state == PointState::on_boundary;
    }

    /// Sets the sample points of one point. Returns the point's state.
    PointState set_point(std::size_t at, std::size_t lane, Point p) noexcept {
        const PointState state = solver_.state_of(placed(p));
        if (state == PointState::on_boundary && !step_inside(p)) return PointState::unreached;
        if (!is_bound(state)) return state;
        const auto put = [&](std::size_t sample, const Point& q) {
            for (std::size_t k = 0; k < D; ++k) positions_[(at * samples + sample) * D + k][lane] = q[k];
        };
        put(0, p);
        for (std::size_t axis = 0; axis < D; ++axis) {
            const Point below = neighbour(p, axis, false), above = neighbour(p, axis, true);
            put(2 * axis + 1, below);
            put(2 * axis + 2, above);
            // Distances of the stored positions, which are rounded.
            const double to_below = std::fabs(double(p[axis]) - double(below[axis]));
            const double to_above = std::fabs(double(above[axis]) - double(p[axis]));
            if (!(to_below + to_above > 0)) return PointState::unreached;
            const auto factors = difference_factors(to_below, to_above);
            for (std::size_t n = 0; n < 2; ++n)
                factors_[(at * D + axis) * 2 + n][lane] = static_cast<T>(factors[n]);
        }
        return state;
    }
    /// Returns the sample point one cell from `p`, or less if the boundary is nearer. The sample point never
    /// reaches the boundary: projected weights jump at the edge of the disc of a point handle inside.
    Point neighbour(const Point& p, std::size_t axis, bool up) const noexcept {
        const double cells = (std::min)(0.9 * solver_.free_distance(placed(p), axis, up, 1.25), 1.0);
        Point q = p;
        q[axis] = static_cast<T>(double(p[axis]) + (up ? cells : -cells) * solver_.spacing(placed(p)));
        return q;
    }
    /// Returns the factors of (value at p − value below) and (value above − value at p) in the derivative.
    /// The factors are exact for parabolas, but for linear functions only if one distance is below a tenth of
    /// the other. Factors for parabolas would then divide errors of values by the small distance.
    static std::array<double, 2> difference_factors(double below, double above) noexcept {
        if (below < 0.1 * above) return {0, 1 / above};
        if (above < 0.1 * below) return {1 / below, 0};
        return {above / (below * (below + above)), below / (above * (below + above))};
    }
    /// Moves a boundary point half a cell inwards, along the diagonal that ends farthest from the boundary.
    /// Returns false if no diagonal ends inside.
    bool step_inside(Point& p) const noexcept {
        const double step = 0.5 * solver_.spacing(placed(p)) / std::sqrt(double(D));
        double most = 0;
        const Point from = p;
        for (std::size_t direction = 0; direction < (std::size_t{1} << D); ++direction) {
            Point q = from;
            for (std::size_t k = 0; k < D; ++k)
                q[k] = static_cast<T>(double(from[k]) + (((direction >> k) & 1u) != 0 ? step : -step));
            if (solver_.state_of(placed(q)) != PointState::inside) continue;
            double least = 1;
            for (std::size_t k = 0; k < D; ++k) {
                for (const bool up : {false, true}) least = solver_.free_distance(placed(q), k, up, least);
            }
            if (least <= most) continue;
            most = least;
            p = q;
        }
        return most > 0;
    }

    const S& solver_;
    Batch<T> batch_;
    std::size_t handles_;
    std::vector<Lanes<T>> positions_, rows_; ///< by slot, sample point, and axis or handle
    std::vector<Lanes<T>> factors_;          ///< by slot and axis: of the differences below and above
    std::vector<PointState> states_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
