// Binds vectors by the directional derivatives of the weights.
#pragma once

#include <cageform/binding/detail/point_binder.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Binds vectors, one or more per point. The input must have gradients.
template <Scalar T, std::size_t D>
class VectorBinder : Binder<T, D> {
    using Base = Binder<T, D>;
    using Base::input_, Base::count_, Base::handles_, Base::lanes, Base::states_;
    // The gradients of a hundred handles fill the second-level cache.
    static constexpr std::size_t piece_blocks = 4;

public:
    VectorBinder(const BindInput<T, D>& input, std::span<const PointReader<T>> vectors,
                 const BindOptions& options)
        : Base(input, options, piece_blocks)
        , vectors_(vectors) {}

    Status run(std::span<Binding<T, D>> bindings, const Running& running, BindReport& report) {
        return Base::run(bindings, report,
                         [&] { return input_.closed_form ? in_pieces(running) : at_once(running, report); });
    }

private:
    /// Points outside with a falloff, ascending, and their weights.
    struct FadedPoints {
        std::vector<std::size_t> numbers; ///< relative to the first point of the gradients
        std::vector<FalloffValue<D>> falloff;
        std::vector<Lanes<T>> position, memory;
        BlockView<T> points, weights;

        void add(std::size_t number, const FalloffValue<D>& falloff_at) {
            numbers.push_back(number);
            falloff.push_back(falloff_at);
        }
        /// Allocates positions and weights. Lanes after the last point lie at `filler`.
        void make_room(std::size_t handles, const Vec<T, D>& filler) {
            const std::size_t blocks = block_count<T>(numbers.size());
            position.resize(blocks * D);
            memory.resize(blocks * handles);
            points = {position.data(), D, numbers.size()};
            weights = {memory.data(), handles, numbers.size()};
            for (auto& row : memory) Simd<T>(T(0)).store(row);
            for (std::size_t i = 0; i < blocks * D; ++i) Simd<T>(filler[i % D]).store(position[i]);
        }
    };

    /// Memory for the gradients at points [first, first + points.points).
    struct Gradients {
        std::vector<Lanes<T>> position, slopes;
        std::size_t first = 0;
        BlockView<T> points, rows;
        FadedPoints faded; ///< evaluated at the same positions

        Gradients(std::size_t most, std::size_t handles)
            : position(block_count<T>(most) * D)
            , slopes(block_count<T>(most) * D * handles)
            , points{position.data(), D, most}
            , rows{slopes.data(), D * handles, most} {}
    };

    /// Evaluates a few points at a time, so that their gradients fit the cache.
    Status in_pieces(const Running& running) {
        return for_each_block(this->pieces_.size(), running, [&](std::size_t begin, std::size_t end) {
            Gradients gradients(piece_blocks * lanes, handles_.count);
            for (std::size_t piece = begin; piece < end; ++piece) {
                gradients.first = this->first_of(piece);
                gradients.points.points = gradients.rows.points = this->states_of(piece).size();
                this->pieces_[piece].status = evaluate(gradients, {}).status;
                if (this->pieces_[piece].status == Status::ok) finish(gradients, piece);
            }
        });
    }

    /// Evaluates all points at once, so that a solver solves only once.
    Status at_once(const Running& running, BindReport& report) {
        Gradients gradients(count_, handles_.count);
        for (auto& row : gradients.slopes)
            Simd<T>(T(0)).store(row); // points without gradients are not written
        const Evaluation evaluation = evaluate(gradients, running.subtask(0, 0.9));
        report.solver = evaluation.solver;
        if (evaluation.status != Status::ok) return evaluation.status;
        return this->for_each_piece(running.subtask(0.9, 1),
                                    [&](std::size_t piece) { finish(gradients, piece); });
    }

    /// Computes the gradients at the points; with nearest_boundary, at the nearest boundary points of
    /// those outside. Also computes the weights of points with a falloff.
    Evaluation evaluate(Gradients& gradients, const Running& running) {
        load(gradients);
        const auto states = std::span(states_).subspan(gradients.first, gradients.points.points);
        const bool to_boundary = this->options_.outside == OutsidePoints::nearest_boundary;
        const Batch<T> batch{gradients.points, gradients.rows, states};
        Evaluation evaluation = input_.evaluate_gradients(batch, running.subtask(0, to_boundary ? 0.5 : 1));
        if (evaluation.status != Status::ok) return evaluation;
        find_faded(gradients, states);
        if (!to_boundary) {
            const Status status = weigh(gradients, states);
            if (status != Status::ok) evaluation.status = status;
            return evaluation;
        }
        std::vector<std::size_t> outside;
        std::vector<T> row(handles_.count);
        FadedPoints& faded = gradients.faded;
        for (std::size_t i = 0, n = 0; i < states.size(); ++i) {
            if (states[i] != PointState::outside || this->is_faded_out(gradients.first + i)) continue;
            outside.push_back(i);
            const auto q = input_.nearest_boundary(block_point<D>(gradients.points, i), row);
            for (std::size_t k = 0; k < D; ++k) gradients.points(i, k) = q[k];
            if (n == faded.numbers.size()) continue;
            for (std::size_t k = 0; k < D; ++k) faded.points(n, k) = q[k];
            for (std::size_t h = 0; h < row.size(); ++h) faded.weights(n, h) = row[h];
            ++n;
        }
        if (outside.empty()) return evaluation;
        restore(faded);
        evaluation = input_.evaluate_gradients(batch, running.subtask(0.5, 1));
        for (const std::size_t i : outside) {
            const bool there = states[i] == PointState::inside || states[i] == PointState::on_boundary;
            states[i] = there || (states[i] == PointState::outside && input_.has_extension)
                            ? PointState::outside
                            : PointState::unreached;
        }
        return evaluation;
    }

    /// Finds the points outside whose falloff factor is not 0.
    void find_faded(Gradients& gradients, std::span<const PointState> states) {
        FadedPoints& points = gradients.faded;
        points = {};
        if (!(this->options_.falloff > 0)) return;
        for (std::size_t i = 0; i < states.size(); ++i) {
            if (states[i] != PointState::outside) continue;
            const auto falloff_at =
                this->falloff_of(gradients.first + i, block_point<D>(gradients.points, i));
            if (falloff_at.kept != 0) points.add(i, falloff_at);
        }
        points.make_room(handles_.count, handles_.rest[0]);
    }

    /// Computes the weights of the points with a falloff, by the extension of the coordinates.
    Status weigh(Gradients& gradients, std::span<PointState> states) {
        FadedPoints& points = gradients.faded;
        if (points.numbers.empty()) return Status::ok;
        for (std::size_t n = 0; n < points.numbers.size(); ++n) {
            const auto p = block_point<D>(gradients.points, points.numbers[n]);
            for (std::size_t k = 0; k < D; ++k) points.points(n, k) = p[k];
        }
        std::vector<PointState> found(points.numbers.size(), PointState::unreached);
        const auto status = input_.evaluate({points.points, points.weights, found}, {}).status;
        if (status != Status::ok) return status;
        for (std::size_t n = 0; n < found.size(); ++n) {
            if (found[n] == PointState::unreached) states[points.numbers[n]] = PointState::unreached;
        }
        restore(points);
        return Status::ok;
    }

    /// Restores linear precision of the weights, as `bind` does.
    void restore(FadedPoints& points) const {
        typename LinearRestorer<T, D>::Scratch scratch;
        for (std::size_t b = 0; b < points.weights.blocks(); ++b) {
            Lanes<T> bound;
            for (std::size_t lane = 0; lane < lanes; ++lane)
                bound[lane] = b * lanes + lane < points.numbers.size() ? T(1) : T(0);
            (void)this->restorer_.run(points.points.block(b), bound, points.weights.block(b),
                                      this->restores(), scratch);
        }
    }

    /// Reads the user's points and vectors.
    void load(Gradients& gradients) {
        const BlockView<T>& points = gradients.points;
        for (std::size_t b = 0; b < points.blocks(); ++b) {
            const std::size_t block = gradients.first / lanes + b;
            input_.points.read(block, points.block(b));
            for (std::size_t n = 0; n < vectors_.size(); ++n)
                vectors_[n].read(block, this->rest_[n].block(block));
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                bool finite = is_finite(block_point<D>(points, b * lanes + lane));
                for (const BlockView<T>& rest : this->rest_)
                    finite = finite && is_finite(block_point<D>(rest, block * lanes + lane));
                if (finite) continue;
                if (block * lanes + lane < count_) states_[block * lanes + lane] = PointState::not_finite;
                for (std::size_t k = 0; k < D; ++k) points.block(b)[k][lane] = handles_.rest[0][k];
            }
        }
    }

    /// Converts gradients to weights, restores linear precision, and measures.
    void finish(const Gradients& gradients, std::size_t piece) {
        const std::size_t first = this->first_of(piece) / lanes;
        PieceMeasures<T> measures(this->first_of(piece));
        for (std::size_t b = first; b < first + block_count<T>(this->states_of(piece).size()); ++b) {
            Lanes<T> bound;
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const std::size_t i = b * lanes + lane;
                bound[lane] =
                    i < count_ && this->is_bound(states_[i]) && !this->is_faded_out(i) ? T(1) : T(0);
            }
            for (std::size_t n = 0; n < vectors_.size(); ++n) bind_block(b, n, gradients, bound, measures);
            // A point with one unreached vector has no weights for any of its vectors.
            for (const BlockView<T>& weights : this->weights_)
                this->clear_unreached(bound, b, weights.block(b));
        }
        measures.put_into(this->pieces_[piece]);
    }

    /// Computes the weights of vector n in a block: w_i = t·∇w_i.
    void bind_block(std::size_t b, std::size_t n, const Gradients& gradients, const Lanes<T>& bound,
                    PieceMeasures<T>& measures) {
        const Lanes<T>* const slopes = gradients.rows.block(b - gradients.first / lanes);
        Lanes<T>* const row = this->weights_[n].block(b);
        Lanes<T> target[D];
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            for (std::size_t k = 0; k < D; ++k)
                target[k][lane] = bound[lane] == T(0) ? T(0) : this->rest_[n].block(b)[k][lane];
        }
        for (std::size_t h = 0; h < handles_.count; ++h) {
            Simd<T> sum(T(0));
            for (std::size_t k = 0; k < D; ++k)
                sum = sum + Simd<T>::load(target[k]) * Simd<T>::load(slopes[k * handles_.count + h]);
            sum.store(row[h]);
        }
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            if (bound[lane] == T(0)) this->clear(row, lane);
        }
        auto outcome = this->restorer_.run_vectors(target, bound, row, this->restores());
        apply_falloff(b, n, gradients, bound, outcome);
        this->record(outcome, bound, b, measures);
    }

    /// Sets the weights outside to f (t·∇w_i) + (t·∇f) w_i. Sums are measured before this, sizes after it.
    template <class Outcome>
    void apply_falloff(std::size_t b, std::size_t n, const Gradients& gradients, const Lanes<T>& bound,
                       Outcome& outcome) const noexcept {
        const FadedPoints& points = gradients.faded;
        const std::size_t first = b * lanes - gradients.first;
        Lanes<T>* const row = this->weights_[n].block(b);
        const auto begin = points.numbers.begin(), end = points.numbers.end();
        for (auto at = std::lower_bound(begin, end, first); at != end && *at < first + lanes; ++at) {
            const std::size_t lane = *at - first, point = std::size_t(at - begin);
            if (bound[lane] == T(0)) continue;
            const FalloffValue<D>& falloff_at = points.falloff[point];
            double slope = 0;
            for (std::size_t k = 0; k < D; ++k)
                slope += double(this->rest_[n].block(b)[k][lane]) * falloff_at.gradient[k];
            T least = (std::numeric_limits<T>::max)(), sizes = 0;
            for (std::size_t h = 0; h < handles_.count; ++h) {
                T& weight = row[h][lane];
                weight = static_cast<T>(falloff_at.kept * double(weight) +
                                        slope * double(points.weights(point, h)));
                least = (std::min)(least, weight);
                sizes += std::fabs(weight);
            }
            outcome.least[lane] = least;
            outcome.sizes[lane] = sizes;
            if (!is_finite(sizes)) outcome.partition[lane] = sizes; // too large for the scalar
        }
    }

    std::span<const PointReader<T>> vectors_;
};

template <class T, std::size_t D>
BindReport bind_vectors_into(std::span<Binding<T, D>> bindings, const BindInput<T, D>& input,
                             std::span<const PointReader<T>> vectors, const BindOptions& options,
                             const Running& running) {
    BindReport report = report_bind(input, options, [&](BindReport& into) {
        return VectorBinder<T, D>(input, vectors, options).run(bindings, running, into);
    });
    if (report.status != Status::ok) std::fill(bindings.begin(), bindings.end(), Binding<T, D>{});
    return report;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
