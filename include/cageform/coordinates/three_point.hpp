// Three-point coordinates of convex polygons: a family with Wachspress and discrete harmonic coordinates.
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/boundary_data.hpp>
#include <cageform/coordinates/detail/checked_cage.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/three_point/formula.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// f(r) = 1: Wachspress coordinates (A Rational Finite Element Basis, 1975).
struct Wachspress {
    static constexpr bool homogeneous = true;
    template <class X>
    X operator()(const X&) const noexcept {
        return X(1);
    }
};

/// f(r) = r²: discrete harmonic coordinates, the cotangent weights (Pinkall & Polthier 1993).
struct DiscreteHarmonic {
    static constexpr bool homogeneous = true;
    template <class X>
    X operator()(const X& rr) const noexcept {
        return rr;
    }
};

/// Whether f(μr) is a multiple of f(r) for every μ. The unit of length then has no effect.
template <class F>
inline constexpr bool is_homogeneous = false;
template <class F>
    requires(bool(F::homogeneous))
inline constexpr bool is_homogeneous<F> = true;

/// Coordinates in a convex polygon, given by a function f of the distances r_i = |C_i − p|:
///
///   w_i = (c_{i+1} A_{i−1} − c_i B_i + c_{i−1} A_i) / (A_{i−1} A_i),  c_i = f(r_i),  λ_i = w_i / Σ w,
///   A_i and B_i the signed areas of p C_i C_{i+1} and p C_{i−1} C_{i+1}
///
/// Floater, Hormann & Kós, A general construction of barycentric coordinates over convex polygons (Adv.
/// Comput. Math. 24, 2006); Floater, Acta Numerica 24 (2015), sec. 6. f = 1 gives Wachspress coordinates, f =
/// r mean value coordinates (see `MeanValueCoordinates`, for any polygon), f = r² discrete harmonic
/// coordinates. The first and the last agree if all vertices lie on a circle. f = 1 and f = r² need only
/// products and one division per edge. Code: `three_point_weights` in three_point/formula.hpp.
///
///   F        f as a function of r², with a call operator for any number type X: a scalar, a register of
///            scalars, or either with a gradient. For √(1 + r²): `using std::sqrt; return sqrt(X(1) + rr);`.
///            Optional F::homogeneous: whether f(μr) is a multiple of f(r) for every μ
///   cage     one strictly convex loop, of either orientation. Vertices on the line of their neighbours are
///            refused, because Wachspress coordinates would give them no weight
///   range    sum to 1; ≥ 0 in every cage if and only if f ≥ 0, f' ≥ 0, f'' ≥ 0 and f ≥ r f': for 1, r and
///            √(1 + r²), not for r² and √r
///   outside  undefined: there are poles on the lines of the edges
///   limits   the unit row on vertices, linear on edges, for every f
///   accuracy a few roundings; next to a vertex of outer angle θ, a few roundings divided by θ. For other f
///            than 1 and r², the differences f(r_{i+1}) − f(r_i) have the rounding of f: a few roundings
///            divided by the length of the shortest edge in diagonals
///   units    unless F is homogeneous, r² is in the user's unit and must be in the range of T. If Σ w is zero
///            or not a number, the point is unreached
///   cost     O(#V) a point: a division per vertex for 8 (float: 16) points, and f
///   gradients  always in double. At boundary points: the gradient 1e-6 diagonals inside. Errors for double:
///              1e-11 of 1/diagonal; within 1e-8 diagonals of the boundary 1e-19/distance, where long double
///              is wider than double. Σ ∇λ_i = 0 and Σ C_i ∇λ_i = identity hold with the same errors
///   faults   those of `check`, vertex_not_convex, interior_cells_not_supported
template <Scalar T, class F>
class ThreePointCoordinates : public detail::CheckedCage<Polygon<T>> {
    using Base = detail::CheckedCage<Polygon<T>>;

public:
    static constexpr bool has_extension = false;

    /// Takes a Polygon, its vertices, or a cell complex without interior cells.
    template <class Cage>
        requires std::constructible_from<Base, const Cage&>
    explicit ThreePointCoordinates(const Cage& cage, F f = {})
        : Base(cage)
        , f_(std::move(f)) {
        if (report_.status != Status::ok) return;
        report_.status = detail::guard_memory([&] {
            fill_tables();
            return report_.status;
        });
    }
    template <UnknownPointRange R>
    explicit ThreePointCoordinates(const R&, F = {}, detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    std::span<const Vec<T, 2>> handles() const noexcept { return cage_.vertices(); }

    /// See CageCoordinates.
    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const Running& running = {}) const {
        return evaluate_numbers<detail::Simd<T>>({points, weights, states}, running);
    }
    /// See GradientCoordinates.
    Evaluation evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                  std::span<PointState> states, const Running& running = {}) const {
        return evaluate_numbers<detail::Dual<detail::Simd<double>, 2>>({points, gradients, states}, running);
    }
    Vec<T, 2> nearest_boundary(const Vec<T, 2>& p, std::span<T> row) const noexcept {
        return nearest_boundary_weights(cage_, p, row);
    }

private:
    using Base::cage_;
    using Base::report_;
    using Wide = std::conditional_t<std::is_same_v<T, float>, double, long double>;

    void fill_tables() {
        const auto bounds = bounds_of(cage_.vertices());
        tolerance_ = double(coincidence_tolerance(bounds));
        if (cage_.loops().size() > 1)
            return report_.add(CageFaultKind::vertex_not_convex, cage_.loops()[1].begin);
        left_ = signed_area(cage_, cage_.loops()[0]) > 0;
        for (std::size_t i = 0; i < cage_.size(); ++i) {
            if (!is_convex(i)) report_.add(CageFaultKind::vertex_not_convex, i);
        }
        if (report_.status != Status::ok) return;
        scale_ = double(unit_scale(bounds)); // products of lengths stay in range
        frame_ = frame_about<T>(Vec<double, 2>{}, 1 / scale_);
        gradient_frame_ = frame_about<double>(Vec<double, 2>{}, 1 / scale_);
    }
    /// Returns whether vertex i lies outside the line of its neighbours by more than the tolerance.
    bool is_convex(std::size_t i) const noexcept {
        const std::size_t last = cage_.size() - 1;
        const auto at = vec_cast<double>(cage_[i]);
        const auto from = vec_cast<double>(cage_[i > 0 ? i - 1 : last]) - at;
        const auto to = vec_cast<double>(cage_[i < last ? i + 1 : 0]) - at;
        return (left_ ? 1 : -1) * cross(to, from) > tolerance_ * detail::length(to - from);
    }

    /// Returns the cage relative to a point, in units of `unit`.
    template <class S, class Number>
    detail::ThreePointFrame<S> frame_about(const Vec<Number, 2>& origin, Number unit) const {
        Buffer<Vec<Number, 2>> at;
        at.reserve(cage_.size());
        for (const auto& v : cage_.vertices()) at.push_back((1 / unit) * (vec_cast<Number>(v) - origin));
        return {at, left_, static_cast<S>(is_homogeneous<F> ? Number(1) : unit)};
    }

    template <class N, class S>
    detail::ThreePointSum<N> compute_weights(const detail::ThreePointFrame<S>& frame, S near_distance,
                                             const Vec<detail::ValueOf<N>, 2>& p,
                                             std::vector<N>& weights) const {
        constexpr auto differences = std::is_same_v<F, Wachspress> ? detail::DifferenceFormula::none
                                     : std::is_same_v<F, DiscreteHarmonic>
                                         ? detail::DifferenceFormula::of_squares
                                         : detail::DifferenceFormula::of_any;
        return detail::three_point_weights<differences, N>(frame, f_, near_distance, p, weights);
    }

    template <class N>
    Evaluation evaluate_numbers(const Batch<T>& batch, const Running& running) const {
        using S = detail::ScalarOf<detail::ValueOf<N>>;
        const std::size_t rows = detail::has_gradient<N> ? 2 * cage_.size() : cage_.size();
        return detail::evaluate_blocks(
            report_, rows, batch, running, [&](std::size_t begin, std::size_t end) {
                std::vector<N> memory(cage_.size());
                for (std::size_t b = begin; b < end; ++b) {
                    for (std::size_t first = 0; first < lane_count<T>; first += lane_count<S>)
                        evaluate_lanes(batch, b, first, memory);
                }
            });
    }

    /// Evaluates as many lanes of block `b` as N has, from `first` on. Points next to the line of an edge are
    /// evaluated one by one.
    template <class N>
    void evaluate_lanes(const Batch<T>& batch, std::size_t b, std::size_t first,
                        std::vector<N>& memory) const {
        using X = detail::ValueOf<N>;
        using S = detail::ScalarOf<X>;
        Lanes<T>* const rows = batch.rows.block(b);
        Vec<X, 2> p;
        for (std::size_t k = 0; k < 2; ++k)
            p[k] = X(S(scale_)) * detail::load_lanes<S>(batch.points.block(b)[k], first);
        const auto& frame = detail::for_number<N>(frame_, gradient_frame_);
        const auto result = compute_weights<N>(frame, near_distance<N>(), p, memory);
        const N inverse = X(S(1)) / result.sum;
        for (std::size_t i = 0; i < cage_.size(); ++i) {
            detail::for_each_component(
                memory[i] * inverse, i, cage_.size(), S(scale_),
                [&](std::size_t row, const X& x) { detail::store_lanes(x, rows[row], first); });
        }
        Lanes<S> sums, beside, outside;
        detail::value_of(result.sum).store(sums);
        result.beside.store(beside);
        result.outside.store(outside);
        for (std::size_t lane = 0; lane < lane_count<S>; ++lane) {
            const std::size_t i = b * lane_count<T> + first + lane;
            if (i >= batch.points.points || batch.states[i] == PointState::not_finite) continue;
            if (outside[lane] != S(0)) {
                batch.states[i] = PointState::outside;
            } else if (beside[lane] != S(0) || !is_finite(sums[lane]) || sums[lane] == S(0)) {
                using One = std::conditional_t<detail::has_gradient<N>, detail::Dual<Wide, 2>, Wide>;
                batch.states[i] = evaluate_point<One>(block_point<2>(batch.points, i), rows, first + lane);
            } else {
                batch.states[i] = PointState::inside;
            }
        }
    }

    /// Returns the distance from the line of an edge above which registers are accurate enough, in units of
    /// the frame. Next to the boundary, gradients in double lose accuracy in proportion to 1/distance.
    template <class N, class S = detail::ScalarOf<detail::ValueOf<N>>>
    S near_distance() const noexcept {
        const double edge = scale_ * tolerance_;
        return static_cast<S>(detail::has_gradient<N> && sizeof(T) == 8 ? std::fmax(edge, 1e-5) : edge);
    }

    /// Evaluates one point in a wider scalar. On the boundary it returns the limit.
    template <class N>
    PointState evaluate_point(const Vec<T, 2>& p, Lanes<T>* rows, std::size_t lane) const {
        Vec<T, 2> position;
        const auto value = nearest_boundary_value(cage_, p, position);
        const double distance = detail::length(scale_ * (vec_cast<double>(position) - vec_cast<double>(p)));
        const bool on_boundary = distance <= scale_ * tolerance_;
        if (!on_boundary && locate(cage_, p, T(0)) != PointState::inside) return PointState::outside;
        if constexpr (!detail::has_gradient<N>) {
            if (on_boundary) {
                detail::store_boundary_value(value, cage_.size(), rows, lane);
                return PointState::on_boundary;
            }
        }
        const auto q = on_boundary ? step_inside(vec_cast<Wide>(p)) : vec_cast<Wide>(p);
        const Wide unit = Wide(1) / Wide(scale_);
        std::vector<N> memory(cage_.size());
        const auto result = compute_weights<N>(frame_about<Wide>(q, unit), Wide(0), Vec<Wide, 2>{}, memory);
        if (detail::value_of(result.sum) == 0) return PointState::unreached;
        if (!detail::store_weights<N>(memory, Wide(1) / result.sum, Wide(scale_), rows, lane))
            return PointState::unreached;
        return on_boundary ? PointState::on_boundary : PointState::inside;
    }

    /// Moves a boundary point 1e-6 diagonals towards the mean of the vertices, at most half of the way.
    Vec<Wide, 2> step_inside(const Vec<Wide, 2>& p) const noexcept {
        Vec<Wide, 2> way{};
        for (const auto& v : cage_.vertices())
            way = way + (Wide(scale_) / Wide(cage_.size())) * (vec_cast<Wide>(v) - p);
        const double step = std::fmin(0.5, 0x1p-20 / detail::length(vec_cast<double>(way)));
        return p + (Wide(step) / Wide(scale_)) * way;
    }

    F f_;
    detail::ThreePointFrame<T> frame_;
    detail::ThreePointFrame<double> gradient_frame_;
    double tolerance_ = 0, scale_ = 1;
    bool left_ = true;
};

template <Scalar T>
using WachspressCoordinates = ThreePointCoordinates<T, Wachspress>;

template <Scalar T>
using DiscreteHarmonicCoordinates = ThreePointCoordinates<T, DiscreteHarmonic>;

// `ThreePointCoordinates coordinates(cage, Wachspress{})` deduces the scalar.
template <Scalar T, class F>
ThreePointCoordinates(Polygon<T>, F) -> ThreePointCoordinates<T, F>;
template <Scalar T, class F>
ThreePointCoordinates(CellComplex<T, 2>, F) -> ThreePointCoordinates<T, F>;
template <PointRangeIn<2> R, class F>
ThreePointCoordinates(const R&, F) -> ThreePointCoordinates<range_scalar_t<R>, F>;

} // namespace cageform::inline CAGEFORM_ABI
