// Vectors attached to a figure's points (tangents, axes, fibres), bound so that `clone` moves them.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/tangents.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Bindings of the D axes at every point: the columns of the Jacobian of whatever a pose does.
template <Scalar T, std::size_t D>
struct JacobianBindResult {
    std::array<Binding<T, D>, D> columns; ///< empty unless the report's status is ok
    BindReport report;
};

namespace detail {

/// The state of one bind of `K` vectors a point. vector(i, n) is vector n of point i.
template <std::size_t K, GradientCoordinates C, PointRange R, class Vectors>
class VectorBinder {
public:
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;

    VectorBinder(const C& coordinates, const R& points, const Vectors& vector, const BindOptions& options)
        : coordinates_(coordinates)
        , points_(points)
        , vector_(vector)
        , options_(options)
        , handles_(handle_view(coordinates))
        , restorer_(handles_)
        , count_(std::size(points)) {}

    Status run(std::array<Binding<T, D>, K>& bindings, BindReport& report) {
        const std::size_t blocks = block_count<T>(count_);
        std::array<std::vector<Lanes<T>>, K> weights, rest;
        for (std::size_t n = 0; n < K; ++n) {
            weights[n].resize(blocks * handles_.count);
            rest[n].resize(blocks * D);
            weights_[n] = {weights[n].data(), handles_.count, count_};
            rest_[n] = {rest[n].data(), D, count_};
        }
        states_.assign(count_, PointState::inside);
        pieces_.assign((blocks + piece_blocks - 1) / piece_blocks, {});
        const Status status = C::closed_form ? in_pieces() : at_once(report);
        if (status != Status::ok) return status;
        const Status gathered = gather(pieces_, states_, report);
        if (gathered != Status::ok) return gathered;
        for (std::size_t n = 0; n < K; ++n)
            bindings[n] = Binding<T, D>(std::move(weights[n]), std::move(rest[n]), handles_, count_);
        return Status::ok;
    }

private:
    static constexpr std::size_t lanes = lane_count<T>;
    static constexpr std::size_t piece_blocks = 4; // the gradients of a hundred handles fill the second cache

    /// Points [first, first + size) and their gradients.
    struct Batch {
        std::size_t first, size;
        std::vector<Lanes<T>> position, slopes;
        BlockView<T> points{}, gradients{};

        Batch(std::size_t begin, std::size_t count, std::size_t handles)
            : first(begin)
            , size(count)
            , position(block_count<T>(count) * D)
            , slopes(block_count<T>(count) * D * handles) {
            choose(begin, count, handles);
        }
        void choose(std::size_t begin, std::size_t count, std::size_t handles) {
            first = begin;
            size = count;
            points = {position.data(), D, count};
            gradients = {slopes.data(), D * handles, count};
        }
    };

    /// A few points at a time, whose gradients stay in cache.
    Status in_pieces() {
        constexpr std::size_t most = piece_blocks * lanes;
        return for_each_block(pieces_.size(), {options_.parallel, options_.progress},
                              [&](std::size_t begin, std::size_t end) {
                                  Batch batch(begin * most, most, handles_.count);
                                  for (std::size_t piece = begin; piece < end; ++piece) {
                                      const std::size_t first = piece * most;
                                      batch.choose(first, std::min(most, count_ - first), handles_.count);
                                      pieces_[piece].status = evaluate(batch, {}).status;
                                      if (pieces_[piece].status == Status::ok) finish(batch, piece);
                                  }
                              });
    }

    /// All points together, so that a solver solves once.
    Status at_once(BindReport& report) {
        Batch batch(0, count_, handles_.count);
        for (auto& row : batch.slopes) Simd<T>(T(0)).store(row); // where there are none nothing is written
        Running options{options_.parallel};
        if (options_.progress) {
            options.progress = [this](double done) { return options_.progress(0.9 * done); };
        }
        const Evaluation evaluation = evaluate(batch, options);
        report.solver = evaluation.solver;
        if (evaluation.status != Status::ok) return evaluation.status;
        if (options_.progress) {
            options.progress = [this](double done) { return options_.progress(0.9 + 0.1 * done); };
        }
        return for_each_block(pieces_.size(), options, [&](std::size_t begin, std::size_t end) {
            for (std::size_t piece = begin; piece < end; ++piece) finish(batch, piece);
        });
    }

    std::span<PointState> states_of(const Batch& batch) noexcept {
        return std::span<PointState>(states_).subspan(batch.first, batch.size);
    }

    /// The gradients of a batch; for points that follow the boundary, those at the nearest place of it.
    Evaluation evaluate(Batch& batch, const Running& options) {
        const auto states = states_of(batch);
        const std::size_t used = batch.points.blocks() * lanes;
        for (std::size_t i = 0; i < used; ++i) {
            const std::size_t from = batch.first + std::min(i, batch.size - 1);
            const auto p = to_vec<T>(points_[from]);
            bool finite = is_finite(p);
            for (std::size_t n = 0; n < K; ++n) finite = finite && is_finite(vector_(from, n));
            if (i < batch.size) states[i] = finite ? PointState::inside : PointState::not_finite;
            for (std::size_t k = 0; k < D; ++k) batch.points(i, k) = finite ? p[k] : handles_.rest[0][k];
        }
        Evaluation evaluation =
            coordinates_.evaluate_gradients(batch.points, batch.gradients, states, options);
        if (evaluation.status != Status::ok || options_.outside != OutsidePoints::nearest_boundary)
            return evaluation;
        std::vector<std::size_t> outside;
        std::vector<T> row(handles_.count);
        for (std::size_t i = 0; i < batch.size; ++i) {
            if (states[i] != PointState::outside) continue;
            outside.push_back(i);
            const auto q = coordinates_.nearest_boundary(block_point<D>(batch.points, i), row);
            for (std::size_t k = 0; k < D; ++k) batch.points(i, k) = q[k];
        }
        if (outside.empty()) return evaluation;
        evaluation = coordinates_.evaluate_gradients(batch.points, batch.gradients, states, options);
        for (const std::size_t i : outside) {
            const bool there = states[i] == PointState::inside || states[i] == PointState::on_boundary;
            states[i] = there || (states[i] == PointState::outside && C::has_extension)
                            ? PointState::outside
                            : PointState::unreached;
        }
        return evaluation;
    }

    bool is_bound(PointState state) const noexcept {
        if (state == PointState::outside) {
            return options_.outside == OutsidePoints::nearest_boundary ||
                   (options_.outside == OutsidePoints::extend && C::has_extension);
        }
        return state == PointState::inside || state == PointState::on_boundary;
    }

    /// From gradients to weights: w_i = t·∇w_i; restores linear precision, takes the measures.
    void finish(const Batch& batch, std::size_t piece) {
        const std::size_t end = std::min((piece + 1) * piece_blocks, block_count<T>(count_));
        for (std::size_t b = piece * piece_blocks; b < end; ++b) {
            const Lanes<T>* const slopes = batch.gradients.block(b - batch.first / lanes);
            Lanes<T> bound;
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const std::size_t i = b * lanes + lane;
                bound[lane] = i < count_ && is_bound(states_[i]) ? T(1) : T(0);
            }
            for (std::size_t n = 0; n < K; ++n) bind_block(b, n, slopes, bound, pieces_[piece]);
            for (std::size_t lane = 0; lane < lanes; ++lane) { // of a point that lost one, the others too
                if (bound[lane] == T(0) || states_[b * lanes + lane] != PointState::unreached) continue;
                for (std::size_t n = 0; n < K; ++n) clear(weights_[n].block(b), lane);
            }
        }
    }

    void bind_block(std::size_t b, std::size_t n, const Lanes<T>* slopes, const Lanes<T>& bound,
                    BindPiece& piece) {
        Lanes<T>* const row = weights_[n].block(b);
        Lanes<T> target[D];
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const auto t = vector_(std::min(b * lanes + lane, count_ - 1), n);
            for (std::size_t k = 0; k < D; ++k) {
                rest_[n].block(b)[k][lane] = t[k];
                target[k][lane] = bound[lane] == T(0) ? T(0) : t[k];
            }
        }
        for (std::size_t h = 0; h < handles_.count; ++h) {
            Simd<T> sum(T(0));
            for (std::size_t k = 0; k < D; ++k)
                sum = sum + Simd<T>::load(target[k]) * Simd<T>::load(slopes[k * handles_.count + h]);
            sum.store(row[h]);
        }
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            if (bound[lane] == T(0)) clear(row, lane);
        }
        const auto outcome =
            restorer_.run_vectors(target, bound, row, options_.linear_precision == LinearPrecision::restore);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::size_t i = b * lanes + lane;
            if (bound[lane] == T(0)) continue;
            if (is_finite(outcome.partition[lane]) && is_finite(outcome.reproduction[lane])) {
                piece.note(outcome, lane, i);
            } else { // too far away, or too long, for the scalar
                states_[i] = PointState::unreached;
            }
        }
    }

    void clear(Lanes<T>* row, std::size_t lane) const noexcept {
        for (std::size_t h = 0; h < handles_.count; ++h) row[h][lane] = T(0);
    }

    const C& coordinates_;
    const R& points_;
    const Vectors& vector_;
    const BindOptions& options_;
    HandleView<T, D> handles_;
    LinearRestorer<T, D> restorer_;
    std::size_t count_;
    std::array<BlockView<T>, K> rest_, weights_;
    std::vector<PointState> states_;
    std::vector<BindPiece> pieces_;
};

template <std::size_t K, class C, class R, class Vectors>
BindReport bind_each_vector(const C& coordinates, const R& points, const Vectors& vector,
                            const BindOptions& options,
                            std::array<Binding<typename C::scalar, C::dimension>, K>& bindings) {
    const auto start = std::chrono::steady_clock::now();
    BindReport report;
    report.cage = coordinates.cage_report();
    report.status = report.cage.status;
    report.points = std::size(points);
    if (report.status != Status::ok) return report;
    report.status = guard_memory([&] {
        return VectorBinder<K, C, R, Vectors>(coordinates, points, vector, options).run(bindings, report);
    });
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return report;
}

} // namespace detail

/// Binds vectors attached to points, so that a pose moves them as it moves the matter around the points:
///
///     t' = t + Σ (t·∇w_i(p)) (C'_i − C_i) = J t,   J the Jacobian of the deformation at p
///
/// That is a Binding with vectors in place of points and directional derivatives in place of weights; `clone` moves it, and
/// at rest gives the vectors bit for bit. Affine poses x ↦ A x + b give A t to rounding.
///
///   points    as for `bind`
///   vectors   as many as points, of any length, read as the scalar of the coordinates; or one for all points
///   options   as for `bind`. With nearest_boundary, vectors of points outside turn as matter does at the nearest place of the
///             boundary. Without extension, or with keep_in_place, they keep their direction and length
///   returns   the binding and its report, as `bind` does: lists of points (not finite: the point or its vector); the
///             largest |Σw| and |Σwc − t|; the changes and the least of these weights
///   cost      that of evaluate_gradients, plus O(#handles) a point; closed forms a few points at a time. A solver's gradients
///             are taken all at once, D #handles scalars a point, and anew with nearest_boundary if points lie outside: call
///             its `solve` first where more than one set is bound
///   fails     as `bind`, and as evaluate_gradients
template <GradientCoordinates C, PointRange R, PointRange V>
    requires(range_dimension<R> == C::dimension && range_dimension<V> == C::dimension)
BindResult<typename C::scalar, C::dimension> bind_vectors(const C& coordinates, const R& points,
                                                          const V& vectors, const BindOptions& options = {}) {
    CAGEFORM_ASSERT(std::size(vectors) == std::size(points), "a vector for every point");
    const auto vector = [&](std::size_t i, std::size_t) { return to_vec<typename C::scalar>(vectors[i]); };
    std::array<Binding<typename C::scalar, C::dimension>, 1> bindings;
    BindReport report = detail::bind_each_vector<1>(coordinates, points, vector, options, bindings);
    return {std::move(bindings[0]), std::move(report)};
}

/// The same with one vector for all points.
template <GradientCoordinates C, PointRange R, Point V>
    requires(range_dimension<R> == C::dimension && PointTraits<V>::dimension == C::dimension &&
             !PointRange<V>)
BindResult<typename C::scalar, C::dimension> bind_vectors(const C& coordinates, const R& points,
                                                          const V& vector, const BindOptions& options = {}) {
    const auto same = [t = to_vec<typename C::scalar>(vector)](std::size_t, std::size_t) { return t; };
    std::array<Binding<typename C::scalar, C::dimension>, 1> bindings;
    BindReport report = detail::bind_each_vector<1>(coordinates, points, same, options, bindings);
    return {std::move(bindings[0]), std::move(report)};
}

/// Binds the D axes at every point, with the gradients evaluated once: for `clone_jacobians`. Contract and cost as of
/// `bind_vectors`; the report is that of all axes together.
template <GradientCoordinates C, PointRange R>
    requires(range_dimension<R> == C::dimension)
JacobianBindResult<typename C::scalar, C::dimension> bind_jacobians(const C& coordinates, const R& points,
                                                                    const BindOptions& options = {}) {
    const auto axis = [](std::size_t, std::size_t n) {
        Vec<typename C::scalar, C::dimension> e{};
        e[n] = 1;
        return e;
    };
    JacobianBindResult<typename C::scalar, C::dimension> result;
    result.report =
        detail::bind_each_vector<C::dimension>(coordinates, points, axis, options, result.columns);
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
