// Evaluation of mean value coordinates in 2D and 3D. The formulas are in plane.hpp, space.hpp, polygons.hpp.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/boundary_data.hpp>
#include <cageform/coordinates/detail/checked_cage.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/detail/fold_rows.hpp>
#include <cageform/coordinates/mean_value/frame.hpp>
#include <cageform/core/affine/moment_test.hpp>
#include <cageform/core/types/buffer.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Calls `compute_weights` with everything inlined, which keeps numbers in registers.
template <class N, class Frame, class S, std::size_t D, class Rows>
CAGEFORM_DETAIL_FLATTEN WeightSum<N>
compute_weights_inlined(const Frame& frame, const MeanValueLimits<S>& limits, const Vec<ValueOf<N>, D>& p,
                        Rows& memory) noexcept {
    return compute_weights(frame, limits, p, memory);
}

/// The base of MeanValueCoordinates. Points are evaluated a SIMD register at a time, gradients always in
/// double. Next to the boundary and far away the formula cancels. There single points are evaluated in a
/// wider scalar, in units of their distance from the boundary, so that nothing overflows.
template <class Cage>
class MeanValueEvaluation : public CheckedCage<Cage> {
public:
    using CheckedCage<Cage>::CheckedCage;
    using scalar = typename Cage::scalar;
    static constexpr std::size_t dimension = Cage::dimension;

    std::span<const Vec<scalar, dimension>> handles() const noexcept { return cage_.vertices(); }

    /// See CageCoordinates.
    Evaluation evaluate(BlockView<const scalar> points, BlockView<scalar> weights,
                        std::span<PointState> states, const Running& running = {}) const;
    /// See GradientCoordinates. Derivatives on the boundary are one-sided: the gradient at a point 1e-6
    /// diagonals inside is returned.
    Evaluation evaluate_gradients(BlockView<const scalar> points, BlockView<scalar> gradients,
                                  std::span<PointState> states, const Running& running = {}) const;
    Vec<scalar, dimension> nearest_boundary(const Vec<scalar, dimension>& p,
                                            std::span<scalar> row) const noexcept {
        return nearest_boundary_weights(cage_, p, row, data_);
    }

protected:
    using CheckedCage<Cage>::cage_;
    using CheckedCage<Cage>::report_;

    Status prepare();
    void fill_tables() {
        const auto bounds = bounds_of(surface().vertices());
        tolerance_ = double(coincidence_tolerance(bounds));
        scale_ = double(unit_scale(bounds)); // products of three lengths stay in range
        if constexpr (D == 3) origin_ = cage_[0];
        topology_ = typename Form::Topology(cage_);
        data_ = Form::data(cage_);
        const auto at = seen_from(vec_cast<double>(origin_), scale_);
        frame_ = {topology_, at};
        gradient_frame_ = {topology_, at};
        test_ = MomentTest<T, D>(at);
        gradient_test_ = MomentTest<double, D>(at);
    }

    using T = scalar;
    static constexpr std::size_t D = dimension;
    using Form = MeanValueForm<Cage>;
    template <class N>
    using Rows = typename Form::template Rows<N>;

    /// The mesh of the formula. Its points are the cage's vertices, then those of fans.
    const auto& surface() const noexcept { return surface_of(cage_); }
    std::size_t points() const noexcept { return surface().size(); }
    using Wide = std::conditional_t<std::is_same_v<T, float>, double, long double>;

    /// Returns the vertices relative to `origin`, in units of 1/scale.
    template <class Number>
    Buffer<Vec<Number, D>> seen_from(const Vec<Number, D>& origin, Number scale) const {
        Buffer<Vec<Number, D>> at;
        at.reserve(points());
        for (const auto& v : surface().vertices()) at.push_back(scale * (vec_cast<Number>(v) - origin));
        return at;
    }

    /// Returns the limits for evaluation in registers, in units of 1/scale_ (one to two diagonals).
    /// `far_distance` limits cancellation to some ten roundings, for gradients to a hundred. Next to the
    /// boundary, gradients in double lose accuracy in proportion to 1/distance. In float this loss is below
    /// rounding.
    template <class N>
    MeanValueLimits<ScalarOf<ValueOf<N>>> limits() const noexcept {
        using S = ScalarOf<ValueOf<N>>;
        const double near_distance = scale_ * tolerance_;
        if constexpr (has_gradient<N>) {
            return {(std::max)(near_distance, sizeof(T) == 8 ? 1e-5 : 0.0), 2, 2e-3};
        } else {
            return {S(near_distance), D == 2 ? S(64) : S(16), sizeof(T) == 8 ? S(5e-4) : S(1e-3)};
        }
    }

    /// Calls `lanes` for all points of a batch, then distributes the rows of fan points to vertices. Each
    /// range of blocks has one object of the type Memory.
    ///
    ///   lanes(b, first, rows, memory)  has the contract of `evaluate_lanes`
    template <class N, class Memory, class EvaluateLanes>
    Evaluation evaluate_blocks_with(const Batch<T>& batch, const Running& running,
                                    const EvaluateLanes& lanes) const {
        const std::size_t rows = has_gradient<N> ? D * cage_.size() : cage_.size();
        const bool folds = points() != cage_.size();
        return evaluate_blocks(report_, rows, batch, running, [&](std::size_t begin, std::size_t end) {
            Memory memory(topology_, points());
            std::vector<Lanes<T>> of_points(folds ? rows / cage_.size() * points() : 0);
            for (std::size_t b = begin; b < end; ++b) {
                Lanes<T>* const own = folds ? of_points.data() : batch.rows.block(b);
                for (std::size_t first = 0; first < lane_count<T>; first += lane_count<ScalarOf<ValueOf<N>>>)
                    lanes(b, first, own, memory);
                if (folds) fold(rows / cage_.size(), own, batch.rows.block(b));
            }
        });
    }
    template <class N>
    Evaluation evaluate_numbers(const Batch<T>& batch, const Running& running) const {
        return evaluate_blocks_with<N, Rows<N>>(
            batch, running, [&](std::size_t b, std::size_t first, Lanes<T>* rows, Rows<N>& memory) {
                evaluate_lanes(batch, b, first, rows, memory);
            });
    }
    /// Distributes rows of means to the vertices, for weights or for derivatives along several axes.
    void fold([[maybe_unused]] std::size_t axes, [[maybe_unused]] const Lanes<T>* from,
              [[maybe_unused]] Lanes<T>* to) const noexcept {
        if constexpr (requires { cage_.fan_points(); }) {
            for (std::size_t axis = 0; axis < axes; ++axis)
                fold_rows(cage_.fan_points(), cage_.size(), from + axis * points(), to + axis * cage_.size());
        }
    }

    /// Evaluates as many lanes of block `b` as N has, from `first` on. Each component has one row per point.
    template <class N>
    void evaluate_lanes(const Batch<T>& batch, std::size_t b, std::size_t first, Lanes<T>* rows,
                        Rows<N>& memory) const {
        using X = ValueOf<N>;
        using S = ScalarOf<X>;
        Vec<X, D> p;
        for (std::size_t k = 0; k < D; ++k)
            p[k] = X(S(scale_)) * (load_lanes<S>(batch.points.block(b)[k], first) - X(S(origin_[k])));
        const WeightSum<N> result =
            compute_weights_inlined<N>(for_number<N>(frame_, gradient_frame_), limits<N>(), p, memory);
        const N inverse = X(S(1)) / result.sum;
        for (std::size_t i = 0; i < points(); ++i) {
            for_each_component(memory.weights[i] * inverse, i, points(), S(scale_),
                               [&](std::size_t row, const X& x) { store_lanes(x, rows[row], first); });
        }

        // Inside, the sum is at least 2π (4π in 3D) over the diagonal (Hormann & Floater 2006, sec. 4.1).
        X special = result.special;
        if (any(value_of(result.sum) < X(S(1))))
            special += for_number<N>(test_, gradient_test_).failed(p, memory.weights, value_of(result.sum));

        Lanes<S> sums, specials;
        value_of(result.sum).store(sums);
        special.store(specials);
        for (std::size_t lane = 0; lane < lane_count<S>; ++lane) {
            const std::size_t i = b * lane_count<T> + first + lane;
            if (i >= batch.points.points || batch.states[i] == PointState::not_finite) continue;
            if (specials[lane] != S(0) || !is_finite(sums[lane]) || sums[lane] == S(0)) {
                using One = std::conditional_t<has_gradient<N>, Dual<Wide, D>, Wide>;
                batch.states[i] = evaluate_point<One>(block_point<D>(batch.points, i), rows, first + lane);
            } else {
                batch.states[i] = sums[lane] > S(0) ? PointState::inside : PointState::outside;
            }
        }
    }

    /// Evaluates one point in a wider scalar. On the boundary it returns the limit.
    template <class N>
    PointState evaluate_point(const Vec<T, D>& p, Lanes<T>* rows, std::size_t lane) const {
        Vec<T, D> position;
        const auto value = nearest_boundary_value(cage_, p, position);
        const double distance = length(scale_ * (vec_cast<double>(position) - vec_cast<double>(p)));
        const bool on_boundary = distance <= scale_ * tolerance_;
        if constexpr (!has_gradient<N>) {
            if (on_boundary) {
                store_boundary_value(value, points(), rows, lane, data_);
                return PointState::on_boundary;
            }
        }
        Rows<N> memory(topology_, points());
        const Wide unit = Wide(on_boundary ? step_inside : distance) / Wide(scale_);
        const N sum = on_boundary ? compute_weights_inside(vec_cast<double>(p), unit, memory)
                                  : compute_weights_at(vec_cast<Wide>(p), unit, memory);
        if (value_of(sum) == 0) return PointState::unreached;
        if (!store_weights<N>(memory.weights, Wide(1) / sum, 1 / unit, rows, lane))
            return PointState::unreached;
        // The state does not come from the sum: near thin cages and far away, rounding can change its sign.
        return on_boundary ? PointState::on_boundary : locate(cage_, p, T(0));
    }

    /// The distance of the point where gradients of boundary points are evaluated, in diagonals.
    static constexpr double step_inside = 0x1p-20;

    /// Computes the unnormalised weights with p as origin, in units of `unit`. Returns their sum.
    template <class N>
    N compute_weights_at(const Vec<Wide, D>& p, Wide unit, Rows<N>& memory) const {
        // Only the last limit is reached. In these units, a point near a face's plane but not over the face
        // is at a distance of at least 1 from the face.
        const MeanValueLimits<Wide> limits{0, (std::numeric_limits<float>::max)(), Wide(0.1)};
        return compute_weights(typename Form::template Frame<Wide>(topology_, seen_from(p, 1 / unit)), limits,
                               Vec<Wide, D>{}, memory)
            .sum;
    }

    /// Calls accepts(q) for points q at a distance `step` from a boundary point p, until it returns true. The
    /// first step goes against the mean normal of the facets at p. If that leads outside, at very sharp
    /// corners, the next ones go inwards from one of the facets.
    template <class Accepts>
    void find_place_inside(const Vec<double, D>& p, Wide step, const Accepts& accepts) const {
        std::vector<Vec<double, D>> directions(1);
        for (const auto& facet : topology_.facets) {
            const auto corner = Facet<D>(facet, surface().vertices()).corner;
            if (distance_to_facet(p, corner) > 2 * tolerance_) continue;
            const auto normal = outward_normal(corner);
            Vec<double, D> to_middle = -1.0 * p;
            for (const auto& c : corner) to_middle = to_middle + (1.0 / D) * c;
            directions[0] = directions[0] - normal;
            directions.push_back(to_middle - 0.25 * length(to_middle) * normal);
        }
        for (const auto& direction : directions) {
            const Wide size = Wide(length(direction));
            if (size > 0 && accepts(vec_cast<Wide>(p) + (step / size) * vec_cast<Wide>(direction))) return;
        }
    }
    /// Computes the unnormalised weights at a point `step` inside from a boundary point p.
    template <class N>
    N compute_weights_inside(const Vec<double, D>& p, Wide step, Rows<N>& memory) const {
        N sum(Wide(0));
        find_place_inside(p, step, [&](const Vec<Wide, D>& q) {
            sum = compute_weights_at(q, step, memory);
            return value_of(sum) > 0;
        });
        return sum;
    }

    typename Form::Topology topology_;
    typename Form::Data data_;
    typename Form::template Frame<T> frame_;
    typename Form::template Frame<double> gradient_frame_;
    MomentTest<T, D> test_;
    MomentTest<double, D> gradient_test_;
    double tolerance_ = 0, scale_ = 1;
    Vec<T, D> origin_{};
    Status prepared_ = prepare(); // declared last: its initialiser fills the other members
};

} // namespace cageform::inline CAGEFORM_ABI::detail
