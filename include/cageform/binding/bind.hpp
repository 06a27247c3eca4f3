// From a coordinate type and a figure's points to a binding, and the report of how it went.
#pragma once

#include <cageform/binding/binding.hpp>
#include <cageform/coordinates/coordinate.hpp>
#include <cageform/core/detail/pack.hpp>

#include <Eigen/LU>

#include <chrono>
#include <limits>

namespace cageform::inline CAGEFORM_ABI {

/// What happens to points outside the cage.
enum class OutsidePoints : std::uint8_t {
    extend,           ///< the coordinate type's own extension; kept in place where it has none
    keep_in_place,    ///< no pose moves them
    nearest_boundary, ///< they follow the nearest point of the cage's boundary, at the same offset
};

/// Whether weights that miss Σw = 1 and Σwc = p (solvers leave a residual) are moved by the least change,
/// in the sense of least squares over the handles, that restores both. Affine poses are then exact.
enum class LinearPrecision : std::uint8_t { restore, leave };

struct BindOptions {
    OutsidePoints outside = OutsidePoints::extend;
    LinearPrecision linear_precision = LinearPrecision::restore;
    ParallelFor parallel = SerialFor{};
    Progress progress{};
};

/// The largest (or least) value met, and at which point; `point` is meaningless while no point was bound.
struct Extreme {
    double value = 0;
    std::size_t point = 0;
};

/// How a bind went. Lists hold indices of points in ascending order.
struct BindReport {
    Status status = Status::ok;
    CageReport cage;
    SolverReport solver;
    std::size_t points = 0; ///< given
    std::vector<std::size_t> on_boundary;
    std::vector<std::size_t> outside;    ///< treated as BindOptions::outside says
    std::vector<std::size_t> not_finite; ///< kept as they are in every pose
    std::vector<std::size_t> unreached;  ///< no value from the solver; kept in place
    Extreme partition_error;             ///< largest |Σw − 1| of the finished weights
    Extreme reproduction_error; ///< largest |Σwc − p| of the finished weights, in the units of the cage
    Extreme weight_change;      ///< largest change of a weight by LinearPrecision::restore
    Extreme residual_restored;  ///< largest |Σwc − p| before it
    Extreme least_weight;       ///< negative weights are no fault of closed forms
    double seconds = 0;         ///< wall-clock time, the solver's included
};

template <Scalar T, std::size_t D>
struct BindResult {
    Binding<T, D> binding; ///< empty unless the report's status is ok
    BindReport report;
};

namespace detail {

/// The least change of a point's weights that restores Σw = 1 and Σwc = p, for all points of a block.
///
/// With A = [1 … 1; ĉ_0 … ĉ_{m−1}] (ĉ centred and scaled to the cage) the change is Aᵀ(AAᵀ)⁻¹ r, r what is
/// missing; AAᵀ is (D+1)² and the same for all points.
template <Scalar T, std::size_t D>
class LinearRestorer {
public:
    struct Result {
        Lanes<T> partition, reproduction, before, change, least;
    };

    explicit LinearRestorer(std::span<const Vec<T, D>> handles) {
        const auto bounds = bounds_of(handles);
        centre_ = T(0.5) * (bounds.lower + bounds.upper);
        size_ = bounds.diagonal();
        columns_.resize(handles.size());
        Eigen::Matrix<double, int(D + 1), int(D + 1)> normal;
        normal.setZero();
        for (std::size_t i = 0; i < handles.size(); ++i) {
            Eigen::Matrix<double, int(D + 1), 1> a;
            a[0] = 1;
            for (std::size_t k = 0; k < D; ++k) {
                columns_[i][k] = (handles[i][k] - centre_[k]) / size_;
                a[long(k) + 1] = double(columns_[i][k]);
            }
            normal += a * a.transpose();
        }
        const auto inverse = normal.inverse().eval();
        for (std::size_t r = 0; r <= D; ++r) {
            for (std::size_t c = 0; c <= D; ++c) inverse_[r][c] = static_cast<T>(inverse(long(r), long(c)));
        }
    }

    /// `bound` is one in lanes to treat and zero in others.
    Result run(const Lanes<T>* target, const Lanes<T>& bound, Lanes<T>* row, LinearPrecision mode) const {
        // Two roundings of the cage's size are not worth a change: exact zeros on edges would be lost.
        constexpr T enough = 4 * epsilon<T>;
        const Pack treat = Pack::load(bound);
        Pack position[D], missing[D + 1], change(T(0));
        for (std::size_t k = 0; k < D; ++k) {
            position[k] = (Pack::load(target[k]) - Pack(centre_[k])) * Pack(T(1) / size_);
        }
        Result result;
        Pack least = measure(row, position, missing);
        distance(missing).store(result.before);
        for (int round = 0; mode == LinearPrecision::restore && round < 3; ++round) {
            Pack worst = abs<T>(missing[0]);
            for (std::size_t k = 1; k <= D; ++k) worst = max<T>(worst, abs<T>(missing[k]));
            const Pack apply = select<T>(Pack(enough) < worst, treat, Pack(T(0)));
            if (!any(apply)) break;
            Pack y[D + 1];
            for (std::size_t r = 0; r <= D; ++r) {
                y[r] = Pack(inverse_[r][0]) * missing[0];
                for (std::size_t c = 1; c <= D; ++c) y[r] = y[r] + Pack(inverse_[r][c]) * missing[c];
                y[r] = y[r] * apply;
            }
            for (std::size_t i = 0; i < columns_.size(); ++i) {
                Pack delta = y[0];
                for (std::size_t k = 0; k < D; ++k) delta = delta + y[k + 1] * Pack(columns_[i][k]);
                change = max<T>(change, abs<T>(delta));
                (Pack::load(row[i]) + delta).store(row[i]);
            }
            least = measure(row, position, missing);
        }
        abs<T>(missing[0]).store(result.partition);
        distance(missing).store(result.reproduction);
        change.store(result.change);
        least.store(result.least);
        return result;
    }

private:
    using Pack = detail::Pack<T>;

    /// What is missing to 1 and to the position; returns the least weight.
    Pack measure(const Lanes<T>* row, const Pack* position, Pack* missing) const {
        missing[0] = Pack(T(1));
        for (std::size_t k = 0; k < D; ++k) missing[k + 1] = position[k];
        Pack least = Pack::load(row[0]);
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            const Pack w = Pack::load(row[i]);
            least = min<T>(least, w);
            missing[0] = missing[0] - w;
            for (std::size_t k = 0; k < D; ++k) missing[k + 1] = missing[k + 1] - w * Pack(columns_[i][k]);
        }
        return least;
    }

    Pack distance(const Pack* missing) const {
        Pack sum(T(0));
        for (std::size_t k = 0; k < D; ++k) {
            const Pack d = Pack(size_) * missing[k + 1] + Pack(centre_[k]) * missing[0];
            sum = sum + d * d;
        }
        return sqrt(sum);
    }

    static bool any(const Pack& flags) {
        Lanes<T> lanes;
        flags.store(lanes);
        T sum = 0;
        for (const T x : lanes.v) sum += x;
        return sum != T(0);
    }

    Vec<T, D> centre_;
    T size_ = 1;
    std::vector<Vec<T, D>> columns_;
    T inverse_[D + 1][D + 1];
};

inline void raise(Extreme& extreme, double value, std::size_t point) noexcept {
    if (value > extreme.value) extreme = {value, point};
}

} // namespace detail

namespace detail {

struct Bind {
    template <CageCoordinates C, PointRange R>
        requires(range_dimension<R> == C::dimension)
    BindResult<typename C::scalar, C::dimension>
    operator()(const C& coordinates, const R& points, const BindOptions& options = {}) const;
};

} // namespace detail

/// Binds points to the cage of `coordinates`: evaluates all weights, treats the points outside, restores
/// linear precision, and reports.
///
///   points   any PointRange of the same dimension, converted to the scalar of the coordinates
///   returns  the binding and its report. Unless the report's status is ok the binding is empty; a bad
///            *point* is listed and kept in place, and is no reason to refuse the others.
///   cost     that of the coordinates, plus O(#handles) a point; (#handles + D) scalars of memory a point
///   fails    as the cage's check and the coordinates say; cancelled; out_of_memory
///
/// A function object, so that argument-dependent lookup never finds std::bind in its place.
inline constexpr detail::Bind bind{};

template <CageCoordinates C, PointRange R>
    requires(range_dimension<R> == C::dimension)
BindResult<typename C::scalar, C::dimension> detail::Bind::operator()(const C& coordinates, const R& points,
                                                                      const BindOptions& options) const {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    constexpr std::size_t lanes = lane_count<T>;
    const auto start = std::chrono::steady_clock::now();

    BindResult<T, D> result;
    BindReport& report = result.report;
    report.cage = coordinates.cage_report();
    report.status = report.cage.status;
    report.points = std::size(points);
    if (report.status != Status::ok) return result;

    const auto handles = coordinates.handles();
    const std::size_t count = report.points;
    const std::size_t blocks = block_count<T>(count);
    const auto run = [&]() -> Status {
        std::vector<Lanes<T>> rest(blocks * D), weights(blocks * handles.size());
        std::vector<PointState> states(count, PointState::unreached);
        const BlockView<T> rest_view{rest.data(), D, count};
        const BlockView<T> weight_view{weights.data(), handles.size(), count};
        for (std::size_t i = 0; i < blocks * lanes; ++i) {
            const auto p = to_vec<T>(points[i < count ? i : count - 1]);
            if (i < count && !is_finite(p)) states[i] = PointState::not_finite;
            for (std::size_t k = 0; k < D; ++k) rest_view(i, k) = p[k];
        }

        EvaluateOptions evaluate_options{options.parallel, {}};
        if (options.progress) {
            evaluate_options.progress = [&](double done) { return options.progress(0.9 * done); };
        }
        const Evaluation evaluation = coordinates.evaluate(rest_view, weight_view, states, evaluate_options);
        report.solver = evaluation.solver;
        if (evaluation.status != Status::ok) return evaluation.status;

        for (std::size_t i = 0; i < count; ++i) {
            switch (states[i]) {
            case PointState::inside: break;
            case PointState::on_boundary: report.on_boundary.push_back(i); break;
            case PointState::outside: report.outside.push_back(i); break;
            case PointState::not_finite: report.not_finite.push_back(i); break;
            case PointState::unreached: report.unreached.push_back(i); break;
            }
        }

        const detail::LinearRestorer<T, D> restorer(handles);
        struct Partial {
            Extreme partition, reproduction, change, before, least;
        };
        std::vector<Partial> partials(blocks == 0 ? 0 : (blocks - 1) / 64 + 1);
        const auto finish_blocks = [&](std::size_t begin, std::size_t end) {
            std::vector<T> row(handles.size());
            Lanes<T> target[D];
            for (std::size_t b = begin; b < end; ++b) {
                auto* const block = weight_view.block(b);
                Lanes<T> bound;
                for (std::size_t k = 0; k < D; ++k) target[k] = rest_view.block(b)[k];
                for (std::size_t lane = 0; lane < lanes; ++lane) {
                    const std::size_t i = b * lanes + lane;
                    const PointState state = i < count ? states[i] : PointState::not_finite;
                    const bool outside = state == PointState::outside;
                    if (outside && options.outside == OutsidePoints::nearest_boundary) {
                        const auto q = coordinates.nearest_boundary(block_point<D>(rest_view, i), row);
                        for (std::size_t k = 0; k < D; ++k) target[k][lane] = q[k];
                        for (std::size_t h = 0; h < row.size(); ++h) block[h][lane] = row[h];
                    } else if (state == PointState::not_finite || state == PointState::unreached ||
                               (outside &&
                                (options.outside == OutsidePoints::keep_in_place || !C::has_extension))) {
                        for (std::size_t h = 0; h < row.size(); ++h) block[h][lane] = T(0);
                        for (std::size_t k = 0; k < D; ++k) target[k][lane] = handles[0][k];
                        bound[lane] = T(0);
                        continue;
                    }
                    bound[lane] = T(1);
                }
                const auto outcome = restorer.run(target, bound, block, options.linear_precision);
                Partial& partial = partials[b / 64];
                for (std::size_t lane = 0; lane < lanes; ++lane) {
                    if (bound[lane] == T(0)) continue;
                    const std::size_t i = b * lanes + lane;
                    detail::raise(partial.partition, double(outcome.partition[lane]), i);
                    detail::raise(partial.reproduction, double(outcome.reproduction[lane]), i);
                    detail::raise(partial.change, double(outcome.change[lane]), i);
                    if (outcome.change[lane] > T(0))
                        detail::raise(partial.before, double(outcome.before[lane]), i);
                    if (double(outcome.least[lane]) < partial.least.value)
                        partial.least = {double(outcome.least[lane]), i};
                }
            }
        };
        for (Partial& partial : partials) partial.least.value = std::numeric_limits<double>::infinity();
        // A grain of 64 blocks gives each range partial results of its own.
        options.parallel(blocks, 64, finish_blocks);
        report.least_weight.value = std::numeric_limits<double>::infinity();
        for (const Partial& partial : partials) {
            detail::raise(report.partition_error, partial.partition.value, partial.partition.point);
            detail::raise(report.reproduction_error, partial.reproduction.value, partial.reproduction.point);
            detail::raise(report.weight_change, partial.change.value, partial.change.point);
            detail::raise(report.residual_restored, partial.before.value, partial.before.point);
            if (partial.least.value < report.least_weight.value) report.least_weight = partial.least;
        }
        if (options.progress && !options.progress(1.0)) return Status::cancelled;
        result.binding =
            Binding<T, D>(std::move(weights), std::move(rest), {handles.begin(), handles.end()}, count);
        return Status::ok;
    };
    report.status = detail::guard_memory(run);
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
