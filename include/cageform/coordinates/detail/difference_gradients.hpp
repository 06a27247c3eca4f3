// Gradients of functions that can be sampled: differences of values a cell apart.
#pragma once

#include <cageform/coordinates/detail/solution.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The differences that make the derivatives at a batch of points, by a solver's places and
/// samples. Values a cell apart have the same part of their cells' error, so that it drops out;
/// they are nearer only where the boundary is.
template <DifferentiableSolver S>
class DifferenceGradients {
    using T = typename S::Problem::scalar;
    static constexpr std::size_t D = S::Problem::dimension;
    using Point = Vec<T, D>;

public:
    DifferenceGradients(const S& solver, const Batch<T>& batch)
        : solver_(solver) {
        for (std::size_t i = 0; i < batch.points.points; ++i) {
            if (batch.states[i] != PointState::not_finite)
                batch.states[i] = add_point(i, block_point<D>(batch.points, i));
        }
    }

    /// Row axis · #handles + handle of `gradients` gets the derivative of the handle's function
    /// along the axis.
    Status run(const Solution<S>& solution, BlockView<T> gradients, SolverReport& report,
               const Running& running) const {
        const std::size_t handles = gradients.rows / D;
        std::vector<Lanes<T>> positions(block_count<T>(places_.size()) * D);
        std::vector<Lanes<T>> rows(block_count<T>(places_.size()) * handles);
        std::vector<PointState> states(places_.size(), PointState::inside);
        const BlockView<T> points{positions.data(), D, places_.size()};
        const BlockView<T> weights{rows.data(), handles, places_.size()};
        for (std::size_t i = 0; i < places_.size(); ++i) {
            for (std::size_t k = 0; k < D; ++k) points(i, k) = places_[i][k];
        }
        const Status status = sample_solution(solution, {points, weights, states}, report, running);
        if (status != Status::ok) return status;
        for (const Difference& d : differences_) {
            for (std::size_t k = 0; k < handles; ++k) {
                double sum = 0;
                for (std::size_t n = 0; n < 3; ++n) {
                    if (d.factor[n] != 0) sum += d.factor[n] * double(weights(d.place[n], k));
                }
                gradients(d.point, d.axis * handles + k) = static_cast<T>(sum);
            }
        }
        return Status::ok;
    }

private:
    struct Difference { ///< Σ factor · value at a place
        std::size_t point, axis;
        std::array<std::size_t, 3> place; ///< below, the point itself, above
        std::array<double, 3> factor;
    };

    /// Adds the differences of a point; where it lies, unreached where both neighbours along an
    /// axis fall onto it.
    PointState add_point(std::size_t i, Point p) {
        const PointState state = solver_.state_of(p);
        if (state == PointState::on_boundary && !step_inside(p)) return PointState::unreached;
        if (state != PointState::inside && state != PointState::on_boundary) return state;
        const std::size_t middle = places_.size();
        places_.push_back(p);
        for (std::size_t axis = 0; axis < D; ++axis) {
            const double below = add_neighbour(p, axis, false), above = add_neighbour(p, axis, true);
            if (!(below + above > 0)) return PointState::unreached;
            differences_.push_back({i,
                                    axis,
                                    {places_.size() - 2, middle, places_.size() - 1},
                                    difference_factors(below, above)});
        }
        return state;
    }
    /// Adds the place a cell from `p`, or as far as the inside goes; returns its distance.
    double add_neighbour(const Point& p, std::size_t axis, bool up) {
        const double cells = solver_.free_distance(p, axis, up, 1.0);
        Point q = p;
        q[axis] = static_cast<T>(double(p[axis]) + (up ? cells : -cells) * solver_.spacing());
        places_.push_back(q);
        return std::fabs(double(q[axis]) - double(p[axis])); // as rounded
    }
    /// Of the values below, here and above, for the derivative: exact for parabolas; for lines
    /// where one distance is below a tenth of the other, since errors of the values count by the
    /// reciprocal of it.
    static std::array<double, 3> difference_factors(double below, double above) noexcept {
        if (below < 0.1 * above) return {0, -1 / above, 1 / above};
        if (above < 0.1 * below) return {-1 / below, 1 / below, 0};
        return {-above / (below * (below + above)), (above - below) / (below * above),
                below / (above * (below + above))};
    }
    /// From the boundary half a cell inwards, along the diagonal that is farthest from the
    /// boundary; false where none is inside.
    bool step_inside(Point& p) const noexcept {
        const double step = 0.5 * solver_.spacing() / std::sqrt(double(D));
        double most = 0;
        const Point from = p;
        for (std::size_t direction = 0; direction < (std::size_t{1} << D); ++direction) {
            Point q = from;
            for (std::size_t k = 0; k < D; ++k)
                q[k] = static_cast<T>(double(from[k]) + (((direction >> k) & 1u) != 0 ? step : -step));
            if (solver_.state_of(q) != PointState::inside) continue;
            double least = 1;
            for (std::size_t k = 0; k < D; ++k) {
                for (const bool up : {false, true}) least = solver_.free_distance(q, k, up, least);
            }
            if (least <= most) continue;
            most = least;
            p = q;
        }
        return most > 0;
    }

    const S& solver_;
    std::vector<Difference> differences_;
    std::vector<Point> places_; ///< that values are taken at
};

} // namespace cageform::inline CAGEFORM_ABI::detail
