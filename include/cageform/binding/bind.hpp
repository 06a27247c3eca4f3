// From a coordinate type and a figure's points to a binding, and the report of how it went.
#pragma once

#include <cageform/binding/binding.hpp>
#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/linear_restorer.hpp>

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
/// in the sense of least squares over the handles, that restores both. Affine poses are then exact; a weight
/// near zero may turn negative by at most BindReport::weight_change.
enum class LinearPrecision : std::uint8_t { restore, leave };

struct BindOptions {
    OutsidePoints outside = OutsidePoints::extend;
    LinearPrecision linear_precision = LinearPrecision::restore;
    ParallelFor parallel = SerialFor{};
    Progress progress{};
};

/// The largest (or least) value met, and at which point.
struct Extreme {
    static constexpr std::size_t none = ~std::size_t{0};

    double value = 0;
    std::size_t point = none; ///< none while there was no value

    void raise(const Extreme& other) noexcept {
        if (other.point != none && (point == none || other.value > value)) *this = other;
    }
    void lower(const Extreme& other) noexcept {
        if (other.point != none && (point == none || other.value < value)) *this = other;
    }
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
    std::vector<std::size_t> unreached;  ///< weights cannot be had or represented; kept in place
    Extreme partition_error;             ///< largest |Σw − 1| of the finished weights
    Extreme reproduction_error; ///< largest |Σwc − p| of the finished weights, in the units of the cage; p is
                                ///< the boundary point for OutsidePoints::nearest_boundary
    Extreme weight_change;      ///< largest change of a weight by LinearPrecision::restore
    Extreme residual_restored; ///< largest |Σwc − p| before it
    Extreme least_weight;      ///< negative weights are no fault of closed forms
    double seconds = 0;        ///< wall-clock time, the solver's included
};

template <Scalar T, std::size_t D>
struct BindResult {
    Binding<T, D> binding; ///< empty unless the report's status is ok
    BindReport report;
};

namespace detail {

/// What a piece of the blocks finds out.
struct BindPiece {
    Status status = Status::ok;
    Extreme partition, reproduction, change, before, least;

    /// The outcome of a point.
    template <class Outcome>
    void note(const Outcome& outcome, std::size_t lane, std::size_t point) noexcept {
        partition.raise({double(outcome.partition[lane]), point});
        reproduction.raise({double(outcome.reproduction[lane]), point});
        change.raise({double(outcome.change[lane]), point});
        if (outcome.change[lane] > 0) before.raise({double(outcome.before[lane]), point});
        least.lower({double(outcome.least[lane]), point});
    }
};

/// Puts the pieces together, in their order, and lists the points.
inline Status gather(std::span<const BindPiece> pieces, std::span<const PointState> states,
                     BindReport& report) {
    for (const BindPiece& piece : pieces) {
        if (piece.status != Status::ok) return piece.status;
        report.partition_error.raise(piece.partition);
        report.reproduction_error.raise(piece.reproduction);
        report.weight_change.raise(piece.change);
        report.residual_restored.raise(piece.before);
        report.least_weight.lower(piece.least);
    }
    for (std::size_t i = 0; i < states.size(); ++i) {
        switch (states[i]) {
        case PointState::inside: break;
        case PointState::on_boundary: report.on_boundary.push_back(i); break;
        case PointState::outside: report.outside.push_back(i); break;
        case PointState::not_finite: report.not_finite.push_back(i); break;
        case PointState::unreached: report.unreached.push_back(i); break;
        }
    }
    return Status::ok;
}

/// The state of one bind. Blocks are worked on in pieces that stay in cache; what a piece finds out is kept
/// apart and put together in the end, so that nothing depends on the threads.
template <CageCoordinates C, PointRange R>
class Binder {
public:
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;

    Binder(const C& coordinates, const R& points, const BindOptions& options)
        : coordinates_(coordinates)
        , points_(points)
        , options_(options)
        , handles_(handle_view(coordinates))
        , restorer_(handles_)
        , count_(std::size(points)) {}

    Status run(Binding<T, D>& binding, BindReport& report) {
        auto [weights, rest] = std::move(binding).release();
        const std::size_t blocks = block_count<T>(count_);
        rest.resize(blocks * D);
        weights.resize(blocks * handles_.count);
        rest_ = {rest.data(), D, count_};
        weights_ = {weights.data(), handles_.count, count_};
        states_.assign(count_, PointState::unreached);
        pieces_.assign((blocks + piece_blocks - 1) / piece_blocks, {});

        if constexpr (C::closed_form) {
            const Status status = for_each_piece(0, 1, [this](std::size_t piece) {
                load(piece);
                const BlockView<T> weight_part = part(weights_, piece);
                pieces_[piece].status =
                    coordinates_.evaluate(part(rest_, piece), weight_part, states_of(piece), {}).status;
                finish(piece);
            });
            if (status != Status::ok) return status;
        } else {
            Status status = for_each_piece(0, 0.1, [this](std::size_t piece) { load(piece); });
            if (status != Status::ok) return status;
            Running options{options_.parallel};
            if (options_.progress) {
                options.progress = [this](double done) { return options_.progress(0.1 + 0.8 * done); };
            }
            const Evaluation evaluation = coordinates_.evaluate(rest_, weights_, states_, options);
            report.solver = evaluation.solver;
            if (evaluation.status != Status::ok) return evaluation.status;
            status = for_each_piece(0.9, 1, [this](std::size_t piece) { finish(piece); });
            if (status != Status::ok) return status;
        }
        const Status status = gather(pieces_, states_, report);
        if (status != Status::ok) return status;
        binding = Binding<T, D>(std::move(weights), std::move(rest), handles_, count_);
        return Status::ok;
    }

private:
    static constexpr std::size_t lanes = lane_count<T>;
    static constexpr std::size_t piece_blocks = 16;

    /// Runs body(piece) for all pieces in parallel, telling the progress from `from` to `to` in between.
    template <class Body>
    Status for_each_piece(double from, double to, const Body& body) const {
        Running options{options_.parallel};
        if (options_.progress) {
            options.progress = [&](double done) { return options_.progress(from + (to - from) * done); };
        }
        return for_each_block(pieces_.size(), options, [&](std::size_t begin, std::size_t end) {
            for (std::size_t piece = begin; piece < end; ++piece) body(piece);
        });
    }

    BlockView<T> part(const BlockView<T>& all, std::size_t piece) const {
        return {all.block(piece * piece_blocks), all.rows, states_of(piece).size()};
    }
    std::span<PointState> states_of(std::size_t piece) const {
        const std::size_t first = piece * piece_blocks * lanes;
        return std::span<PointState>(states_).subspan(first, std::min(piece_blocks * lanes, count_ - first));
    }

    /// Reads the user's points; what is left of the last block is filled with copies of the last one.
    void load(std::size_t piece) {
        const std::size_t first = piece * piece_blocks * lanes;
        const std::size_t used = block_count<T>(states_of(piece).size()) * lanes;
        for (std::size_t i = first; i < first + used; ++i) {
            const auto p = to_vec<T>(points_[i < count_ ? i : count_ - 1]);
            if (i < count_ && !is_finite(p)) states_[i] = PointState::not_finite;
            for (std::size_t k = 0; k < D; ++k) rest_(i, k) = p[k];
        }
    }

    /// Treats the points that are not simply inside, restores linear precision, takes the measures.
    void finish(std::size_t index) {
        BindPiece& piece = pieces_[index];
        const std::size_t first = index * piece_blocks;
        for (std::size_t b = first; b < first + block_count<T>(states_of(index).size()); ++b) {
            auto* const block = weights_.block(b);
            Lanes<T> target[D], bound;
            for (std::size_t k = 0; k < D; ++k) target[k] = rest_.block(b)[k];
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const std::size_t i = b * lanes + lane;
                const PointState state = i < count_ ? states_[i] : PointState::not_finite;
                bound[lane] = T(1);
                if (state == PointState::inside || state == PointState::on_boundary) continue;
                if (state == PointState::outside) {
                    if (options_.outside == OutsidePoints::extend && C::has_extension) continue;
                    if (options_.outside == OutsidePoints::nearest_boundary) {
                        std::vector<T> row(handles_.count);
                        const auto q = coordinates_.nearest_boundary(block_point<D>(rest_, i), row);
                        for (std::size_t k = 0; k < D; ++k) target[k][lane] = q[k];
                        for (std::size_t h = 0; h < row.size(); ++h) block[h][lane] = row[h];
                        continue;
                    }
                }
                // Kept in place: no weights. The target is any finite point.
                bound[lane] = T(0);
                for (std::size_t h = 0; h < handles_.count; ++h) block[h][lane] = T(0);
                for (std::size_t k = 0; k < D; ++k) target[k][lane] = handles_.rest[0][k];
            }
            const auto outcome =
                restorer_.run(target, bound, block, options_.linear_precision == LinearPrecision::restore);
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                if (bound[lane] == T(0)) continue;
                const std::size_t i = b * lanes + lane;
                if (!is_finite(outcome.partition[lane]) || !is_finite(outcome.reproduction[lane])) {
                    // Too far away for the scalar: a weight or what it makes is not representable.
                    states_[i] = PointState::unreached;
                    for (std::size_t h = 0; h < handles_.count; ++h) block[h][lane] = T(0);
                    continue;
                }
                piece.note(outcome, lane, i);
            }
        }
    }

    const C& coordinates_;
    const R& points_;
    const BindOptions& options_;
    HandleView<T, D> handles_;
    LinearRestorer<T, D> restorer_;
    std::size_t count_;
    BlockView<T> rest_, weights_;
    mutable std::vector<PointState> states_;
    std::vector<BindPiece> pieces_;
};

struct Bind {
    template <CageCoordinates C, PointRange R>
        requires(range_dimension<R> == C::dimension)
    BindResult<typename C::scalar, C::dimension>
    operator()(const C& coordinates, const R& points, const BindOptions& options = {},
               Binding<typename C::scalar, C::dimension> recycled = {}) const {
        const auto start = std::chrono::steady_clock::now();
        BindResult<typename C::scalar, C::dimension> result;
        BindReport& report = result.report;
        report.cage = coordinates.cage_report();
        report.status = report.cage.status;
        report.points = std::size(points);
        if (report.status != Status::ok) return result;
        report.status = guard_memory([&] {
            const Status status = Binder<C, R>(coordinates, points, options).run(recycled, report);
            if (status == Status::ok) result.binding = std::move(recycled);
            return status;
        });
        report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return result;
    }
};

} // namespace detail

/// Binds points to the cage of `coordinates`: evaluates all weights, treats the points outside, restores
/// linear precision, and reports.
///
///   points    any PointRange of the same dimension, converted to the scalar of the coordinates
///   recycled  a binding no longer needed, whose memory is used again: a megabyte of new memory costs the
///             system as much time as the weights to fill it
///   returns   the binding and its report. Unless the report's status is ok the binding is empty; a bad
///             *point* is listed and kept in place, and is no reason to refuse the others.
///   cost      that of the coordinates, plus O(#handles) a point; (#handles + D) scalars of memory a point
///   fails     as the cage's check and the coordinates say; cancelled; out_of_memory
///
/// A function object, so that argument-dependent lookup never finds std::bind in its place.
inline constexpr detail::Bind bind{};

} // namespace cageform::inline CAGEFORM_ABI
