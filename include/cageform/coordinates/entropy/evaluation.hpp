// Evaluation of maximum entropy coordinates.
#pragma once

#include <cageform/coordinates/entropy/facing.hpp>
#include <cageform/coordinates/entropy/project.hpp>
#include <cageform/coordinates/entropy/published.hpp>
#include <cageform/coordinates/mean_value/evaluation.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The prior of MaximumEntropyCoordinates.
enum class EntropyPrior : std::uint8_t {
    facing, ///< mean value weights of the facets that face the point
    mec1,   ///< plane only: 1/(ρ_(k−1) ρ_k) with ρ = |a| + |b| − |a − b| of an edge
    mec2,   ///< plane only: with ρ = |a||b| + a·b
};

namespace detail {

/// The base of MaximumEntropyCoordinates. Tables and boundary values are those of mean value coordinates.
template <class Cage>
class EntropyEvaluation : public MeanValueEvaluation<Cage> {
    using Base = MeanValueEvaluation<Cage>;

public:
    using Base::Base;
    /// As the constructor from `cage` alone: a cage, a cell complex, or vertices.
    template <class Any>
        requires std::constructible_from<Base, const Any&>
    explicit EntropyEvaluation(const Any& cage, EntropyPrior prior)
        : Base(cage)
        , prior_(prior) {}
    using scalar = typename Cage::scalar;
    static constexpr std::size_t dimension = Cage::dimension;
    static constexpr bool has_extension = false;

    /// See CageCoordinates.
    Evaluation evaluate(BlockView<const scalar> points, BlockView<scalar> weights,
                        std::span<PointState> states, const Running& running = {}) const;
    /// See GradientCoordinates. Derivatives on the boundary are those at a point 1e-6 diagonals inside.
    Evaluation evaluate_gradients(BlockView<const scalar> points, BlockView<scalar> gradients,
                                  std::span<PointState> states, const Running& running = {}) const;

private:
    using T = scalar;
    static constexpr std::size_t D = dimension;
    using Base::cage_;
    using typename Base::Wide;

    template <class N>
    struct Memory {
        WeightRows<N> rows;
        std::vector<ValueOf<N>> prior, weights;

        Memory(const typename Base::Form::Topology& topology, std::size_t points)
            : rows(topology, points)
            , prior(has_gradient<N> ? points : 0)
            , weights(points) {}
    };

    template <class N>
    Evaluation evaluate_numbers(const Batch<T>& batch, const Running& running) const {
        return this->template evaluate_blocks_with<N, Memory<N>>(
            batch, running, [&](std::size_t b, std::size_t first, Lanes<T>* rows, Memory<N>& memory) {
                evaluate_lanes(batch, b, first, rows, memory);
            });
    }

    /// Computes the weights of a number at p, in units of the frame. Returns 1 in lanes that converged.
    ///
    ///   skipped  1 in lanes whose weights are not needed
    template <class N, class S>
    ValueOf<N> project(const Buffer<Vec<S, D>>& vertices, const Vec<ValueOf<N>, D>& p,
                       const ValueOf<N>& skipped, Memory<N>& memory) const noexcept {
        using X = ValueOf<N>;
        const auto u = [&](std::size_t k) {
            Vec<X, D> to;
            for (std::size_t c = 0; c < D; ++c) to[c] = X(vertices[k][c]) - p[c];
            return to;
        };
        return project_rows<N, D>(memory.rows.weights, u, memory.prior, memory.weights, skipped);
    }
    template <class N>
    static const std::vector<N>& result(const Memory<N>& memory) noexcept {
        if constexpr (has_gradient<N>)
            return memory.rows.weights;
        else
            return memory.weights;
    }

    template <class S>
    static MeanValueLimits<S> limits_at(double near_distance) noexcept {
        return {S(near_distance), (std::numeric_limits<float>::max)(), sizeof(S) == 4 ? S(1e-3) : S(5e-4)};
    }

    template <class N>
    void evaluate_lanes(const Batch<T>& batch, std::size_t b, std::size_t first, Lanes<T>* rows,
                        Memory<N>& memory) const {
        using X = ValueOf<N>;
        using S = ScalarOf<X>;
        Vec<X, D> p;
        for (std::size_t k = 0; k < D; ++k)
            p[k] = X(S(this->scale_)) *
                   (load_lanes<S>(batch.points.block(b)[k], first) - X(S(this->origin_[k])));
        const double near_distance = this->scale_ * this->tolerance_;
        const auto found = prior<N, S>(for_number<N>(this->frame_, this->gradient_frame_),
                                       limits_at<S>(near_distance), p, memory.rows);
        // Inside, the sum is at least 2π (4π in space) over the diagonal (Hormann, Floater 2006, sec. 4.1).
        const X one(S(1)), zero(S(0));
        const X skipped = select(one < found.sum, found.special, one); // also if the sum is not a number
        const X converged = project<N, S>(vertices<N>(), p, skipped, memory);
        const auto& weights = result<N>(memory);
        for (std::size_t i = 0; i < weights.size(); ++i) {
            for_each_component(weights[i], i, weights.size(), S(this->scale_),
                               [&](std::size_t row, const X& x) { store_lanes(x, rows[row], first); });
        }
        Lanes<S> specials, arrived;
        skipped.store(specials);
        select(zero < converged, one, zero).store(arrived);
        for (std::size_t lane = 0; lane < lane_count<S>; ++lane) {
            const std::size_t i = b * lane_count<T> + first + lane;
            if (i >= batch.points.points || batch.states[i] == PointState::not_finite) continue;
            if (specials[lane] == S(0) && arrived[lane] != S(0)) {
                batch.states[i] = PointState::inside;
            } else {
                using One = std::conditional_t<has_gradient<N>, Dual<double, D>, double>;
                batch.states[i] = evaluate_point<One>(block_point<D>(batch.points, i), rows, first + lane);
            }
        }
    }
    template <class N, class S, class Frame>
    WeightSum<ValueOf<N>> prior(const Frame& frame, const MeanValueLimits<S>& limits,
                                const Vec<ValueOf<N>, D>& p, WeightRows<N>& rows) const noexcept {
        if constexpr (D == 2) {
            if (prior_ != EntropyPrior::facing)
                return compute_published<N, S>(frame, limits, p, prior_ == EntropyPrior::mec1, rows);
        }
        return compute_facing<N, S>(frame, limits, p, rows);
    }
    template <class N>
    const auto& vertices() const noexcept {
        return for_number<N>(positions_, gradient_positions_);
    }

    /// Evaluates one point in double. On the boundary it returns the limit.
    template <class N>
    PointState evaluate_point(const Vec<T, D>& p, Lanes<T>* rows, std::size_t lane) const {
        Vec<T, D> position;
        const auto value = nearest_boundary_value(cage_, p, position);
        const double distance = length(vec_cast<double>(position) - vec_cast<double>(p));
        const bool on_boundary = distance <= this->tolerance_;
        if (!on_boundary) {
            const PointState state = locate(cage_, p, T(0));
            if (state != PointState::inside) return state;
        }
        if constexpr (!has_gradient<N>) {
            if (on_boundary) {
                store_boundary_value(value, this->points(), rows, lane, this->data_);
                return PointState::on_boundary;
            }
        }
        Memory<N> memory(this->topology_, this->points());
        bool is_found = false;
        const auto find_at = [&](const Vec<Wide, D>& q) {
            const Vec<double, D> place =
                this->scale_ * (vec_cast<double>(q) - vec_cast<double>(this->origin_));
            const auto found =
                prior<N, double>(this->gradient_frame_, limits_at<double>(0), place, memory.rows);
            is_found = found.sum > 0 && project<N, double>(gradient_positions_, place, 0, memory) != 0;
            return is_found;
        };
        if (on_boundary) {
            this->find_place_inside(vec_cast<double>(p), Wide(Base::step_inside) / Wide(this->scale_),
                                    find_at);
        } else {
            (void)find_at(vec_cast<Wide>(p));
        }
        if (!is_found ||
            !store_weights<N>(std::span<const N>(result<N>(memory)), N(1.0), this->scale_, rows, lane))
            return PointState::unreached;
        return on_boundary ? PointState::on_boundary : PointState::inside;
    }

    Status fill() {
        if (this->report_.status != Status::ok) return this->report_.status;
        return this->report_.status = guard_memory([&] {
                   positions_ = this->template seen_from<T>(this->origin_, T(this->scale_));
                   gradient_positions_ =
                       this->template seen_from<double>(vec_cast<double>(this->origin_), this->scale_);
                   // The facets of the prior are triangles, so boundary values are linear on triangles.
                   if constexpr (requires { this->data_.without_planar_faces(); })
                       this->data_.without_planar_faces();
               });
    }

    EntropyPrior prior_ = EntropyPrior::facing;
    Buffer<Vec<T, D>> positions_;
    Buffer<Vec<double, D>> gradient_positions_;
    Status filled_ = fill(); // declared last: its initialiser fills the other members
};

} // namespace detail
} // namespace cageform::inline CAGEFORM_ABI
