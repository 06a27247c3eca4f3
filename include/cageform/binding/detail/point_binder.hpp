// Binds points: evaluates weights, restores linear precision, and measures the result.
#pragma once

#include <cageform/binding/detail/bind_input.hpp>
#include <cageform/binding/detail/falloff.hpp>
#include <cageform/binding/detail/piece_measures.hpp>
#include <cageform/core/affine/linear_restorer.hpp>
#include <cageform/core/detail/huge_pages.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/core/result.hpp>
#include <cageform/core/types/bounds.hpp>
#include <cageform/figure/binding.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <algorithm>
#include <optional>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The common base of binding points and vectors; several bindings may share the points. Blocks are
/// processed in pieces that fit the cache. The results of pieces are stored separately and combined in
/// order, so they do not depend on the threads.
template <Scalar T, std::size_t D>
class Binder {
protected:
    static constexpr std::size_t lanes = lane_count<T>;

    Binder(const BindInput<T, D>& input, const BindOptions& options, std::size_t piece_blocks)
        : input_(input)
        , options_(options)
        , piece_blocks_(piece_blocks)
        , handles_(input.handles())
        , restorer_(handles_, input.local)
        , count_(input.points.size)
        , states_(count_, PointState::unreached)
        , missed_(count_)
        , faded_out_(options.falloff > 0 ? count_ : 0)
        , pieces_((block_count<T>(count_) + piece_blocks - 1) / piece_blocks) {
        if (!faded_out_.empty() && input.is_within_handles && handles_.point_count() > 0)
            bounds_ = bounds_of_points<T>(handles_);
    }

    /// Makes the bindings and reuses their memory; fill() computes weights, rest and states.
    template <class Fill>
    Status run(std::span<Binding<T, D>> bindings, BindReport& report, const Fill& fill) {
        const std::size_t blocks = block_count<T>(count_);
        std::vector<typename Binding<T, D>::Memory> memory(bindings.size());
        for (std::size_t n = 0; n < bindings.size(); ++n) {
            memory[n] = std::move(bindings[n]).release();
            memory[n].rest.resize(blocks * D);
            resize_large(memory[n].weights, blocks * handles_.count);
            rest_.push_back({memory[n].rest.data(), D, count_});
            weights_.push_back({memory[n].weights.data(), handles_.count, count_});
        }
        Status status = fill();
        if (status == Status::ok) status = report_into(report);
        if (status != Status::ok) return status;
        for (std::size_t n = 0; n < bindings.size(); ++n)
            bindings[n] =
                Binding<T, D>(std::move(memory[n].weights), std::move(memory[n].rest), handles_, count_);
        return Status::ok;
    }

    /// Runs body(piece) for all pieces in parallel.
    template <class Body>
    Status for_each_piece(const Running& running, const Body& body) const {
        return for_each_block(pieces_.size(), running, [&](std::size_t begin, std::size_t end) {
            for (std::size_t piece = begin; piece < end; ++piece) body(piece);
        });
    }

    /// The first point of a piece, and the states of its points.
    std::size_t first_of(std::size_t piece) const noexcept { return piece * piece_blocks_ * lanes; }
    std::span<PointState> states_of(std::size_t piece) noexcept {
        const std::size_t first = first_of(piece);
        return std::span(states_).subspan(first, (std::min)(piece_blocks_ * lanes, count_ - first));
    }

    /// Whether a point in this state gets weights.
    bool is_bound(PointState state) const noexcept {
        if (state == PointState::inside || state == PointState::on_boundary) return true;
        return state == PointState::outside &&
               (options_.outside == OutsidePoints::nearest_boundary ||
                (options_.outside == OutsidePoints::extend && input_.has_extension));
    }
    /// Returns the falloff of point i, which lies outside at `p`. A point with a factor of 0 gets no weights.
    FalloffValue<D> falloff_of(std::size_t i, const Vec<T, D>& p) {
        if (faded_out_.empty()) return {};
        FalloffValue<D> falloff;
        if (is_far(p)) // avoids the search for the nearest boundary point
            falloff.kept = 0;
        else
            falloff = {input_.distance(p), options_.falloff};
        falloff.kept = static_cast<T>(falloff.kept);
        faded_out_[i] = falloff.kept == 0;
        return falloff;
    }
    /// Whether a point is at least the falloff away from the bounds of the cage, if these are known.
    bool is_far(const Vec<T, D>& p) const noexcept {
        if (!bounds_) return false;
        Vec<double, D> away{};
        for (std::size_t k = 0; k < D; ++k)
            away[k] = double(p[k]) - double(std::clamp(p[k], bounds_->lower[k], bounds_->upper[k]));
        return OutsideDistance<D>(away).distance >= options_.falloff;
    }
    bool is_faded_out(std::size_t i) const noexcept { return !faded_out_.empty() && faded_out_[i] != 0; }
    bool restores() const noexcept { return options_.linear_precision == LinearPrecision::restore; }

    /// Records the measures of a block. A point whose weights or their sums overflow the scalar becomes
    /// unreached. Returns whether there is one.
    template <class Outcome>
    bool record(const Outcome& outcome, const Lanes<T>& bound, std::size_t block,
                PieceMeasures<T>& measures) noexcept {
        using Number = Simd<T>;
        const Number most((std::numeric_limits<T>::max)()), zero(T(0)), one(T(1));
        const auto finite = Number::load(outcome.partition) + Number::load(outcome.reproduction) <= most;
        Lanes<T> reached = bound;
        bool unreached = false;
        if (any(zero < select<T>(finite, Number::load(outcome.missed), one))) {
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                if (bound[lane] == T(0)) continue;
                const std::size_t i = block * lanes + lane;
                if (outcome.missed[lane] != T(0)) missed_[i] = 1;
                if (is_finite(outcome.partition[lane]) && is_finite(outcome.reproduction[lane])) continue;
                reached[lane] = T(0);
                states_[i] = PointState::unreached;
                unreached = true;
            }
        }
        measures.add(outcome, reached, block);
        return unreached;
    }
    /// Clears the weights of unreached points and of lanes without weights. Where lengths overflow, the
    /// restorer does not leave these weights at zero.
    void clear_unreached(const Lanes<T>& bound, std::size_t block, Lanes<T>* row) const noexcept {
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            if (bound[lane] == T(0) || states_[block * lanes + lane] == PointState::unreached)
                clear(row, lane);
        }
    }
    void clear(Lanes<T>* row, std::size_t lane) const noexcept {
        for (std::size_t h = 0; h < handles_.count; ++h) row[h][lane] = T(0);
    }

    /// Combines the pieces in order, and lists the points.
    Status report_into(BindReport& report) const {
        for (const BindPiece& piece : pieces_) {
            if (piece.status != Status::ok) return piece.status;
            piece.put_into(report);
        }
        for (std::size_t i = 0; i < count_; ++i) {
            switch (states_[i]) {
            case PointState::inside: break;
            case PointState::on_boundary: report.on_boundary.push_back(i); break;
            case PointState::outside:
                report.outside.push_back(i);
                if (!faded_out_.empty() && faded_out_[i] == 0) report.faded.push_back(i);
                break;
            case PointState::not_finite: report.not_finite.push_back(i); break;
            case PointState::unreached: report.unreached.push_back(i); break;
            }
            if (missed_[i] != 0 && states_[i] != PointState::unreached) report.not_restored.push_back(i);
        }
        return Status::ok;
    }

    const BindInput<T, D>& input_;
    const BindOptions& options_;
    std::size_t piece_blocks_;
    HandleView<T, D> handles_;
    LinearRestorer<T, D> restorer_;
    std::size_t count_;
    std::vector<BlockView<T>> weights_, rest_; // of each binding
    std::vector<PointState> states_;
    std::vector<char> missed_;           // linear precision is not restored
    std::vector<char> faded_out_;        // outside with a falloff factor of 0; empty without a falloff
    std::optional<Bounds<T, D>> bounds_; // of the cage; only with a falloff
    std::vector<BindPiece> pieces_;
};

/// Binds points once.
template <Scalar T, std::size_t D>
class PointBinder : Binder<T, D> {
    using Base = Binder<T, D>;
    using Base::input_, Base::count_, Base::handles_, Base::lanes, Base::states_;

public:
    PointBinder(const BindInput<T, D>& input, const BindOptions& options)
        : Base(input, options, 16) {}

    Status run(Binding<T, D>& binding, const Running& running, BindReport& report) {
        return Base::run({&binding, 1}, report,
                         [&] { return input_.closed_form ? in_pieces(running) : at_once(running, report); });
    }

private:
    Status in_pieces(const Running& running) {
        return this->for_each_piece(running, [this](std::size_t piece) {
            load(piece);
            this->pieces_[piece].status =
                input_
                    .evaluate({piece_of(this->rest_[0], piece), piece_of(this->weights_[0], piece),
                               this->states_of(piece)},
                              {})
                    .status;
            finish(piece);
        });
    }

    /// Evaluates all points at once, so that a solver solves only once.
    Status at_once(const Running& running, BindReport& report) {
        const Status status =
            this->for_each_piece(running.subtask(0, 0.1), [this](std::size_t piece) { load(piece); });
        if (status != Status::ok) return status;
        const Evaluation evaluation =
            input_.evaluate({this->rest_[0], this->weights_[0], states_}, running.subtask(0.1, 0.9));
        report.solver = evaluation.solver;
        if (evaluation.status != Status::ok) return evaluation.status;
        return this->for_each_piece(running.subtask(0.9, 1), [this](std::size_t piece) { finish(piece); });
    }

    BlockView<T> piece_of(const BlockView<T>& all, std::size_t piece) noexcept {
        return {all.block(this->first_of(piece) / lanes), all.rows, this->states_of(piece).size()};
    }

    /// Reads the user's points.
    void load(std::size_t piece) {
        const BlockView<T> positions = piece_of(this->rest_[0], piece);
        for (std::size_t b = 0; b < positions.blocks(); ++b)
            input_.points.read(this->first_of(piece) / lanes + b, positions.block(b));
        const std::span<PointState> states = this->states_of(piece);
        for (std::size_t i = 0; i < states.size(); ++i) {
            if (!is_finite(block_point<D>(positions, i))) states[i] = PointState::not_finite;
        }
    }

    /// Handles points outside as the options say, restores linear precision, and measures errors.
    void finish(std::size_t piece) {
        const auto weights = piece_of(this->weights_[0], piece);
        const std::size_t first = this->first_of(piece) / lanes;
        PieceMeasures<T> measures(this->first_of(piece));
        typename LinearRestorer<T, D>::Scratch scratch;
        for (std::size_t b = first; b < first + weights.blocks(); ++b) {
            Lanes<T>* const row = this->weights_[0].block(b);
            Lanes<T> target[D], bound, kept;
            for (std::size_t k = 0; k < D; ++k) target[k] = this->rest_[0].block(b)[k];
            bool has_falloff = false;
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                kept[lane] = T(1);
                bound[lane] = resolve(b * lanes + lane, target, kept[lane]) ? T(1) : T(0);
                has_falloff = has_falloff || kept[lane] != T(1);
            }
            auto outcome = this->restorer_.run(target, bound, row, this->restores(), scratch);
            if (has_falloff) apply_falloff(kept, row, outcome);
            if (this->record(outcome, bound, b, measures)) this->clear_unreached(bound, b, row);
        }
        measures.put_into(this->pieces_[piece]);
    }

    /// Multiplies the weights of points outside by their falloff factors. Sums are measured before
    /// this, sizes after it.
    template <class Outcome>
    void apply_falloff(const Lanes<T>& kept, Lanes<T>* row, Outcome& outcome) const noexcept {
        const auto factor = Simd<T>::load(kept);
        const auto scale = [&](Lanes<T>& numbers) { (factor * Simd<T>::load(numbers)).store(numbers); };
        for (std::size_t h = 0; h < handles_.count; ++h) scale(row[h]);
        scale(outcome.least);
        scale(outcome.sizes);
    }

    /// Returns whether a point gets weights. With nearest_boundary, a point outside gets those of the
    /// nearest boundary point, which is written to `target`. `kept` is the falloff factor. Points
    /// without weights get zeros and a finite target.
    bool resolve(std::size_t i, Lanes<T> (&target)[D], T& kept) {
        const PointState state = i < count_ ? states_[i] : PointState::not_finite;
        const bool is_outside = state == PointState::outside;
        const auto share =
            is_outside ? static_cast<T>(this->falloff_of(i, block_point<D>(this->rest_[0], i)).kept) : T(1);
        const bool as_nearest = is_outside && this->options_.outside == OutsidePoints::nearest_boundary;
        if (share != T(0)) kept = share;
        if (!as_nearest && share != T(0) && this->is_bound(state)) return true;
        Lanes<T>* const row = this->weights_[0].block(i / lanes);
        const std::size_t lane = i % lanes;
        if (as_nearest && share != T(0)) {
            std::vector<T> weights(handles_.count);
            const auto q = input_.nearest_boundary(block_point<D>(this->rest_[0], i), weights);
            for (std::size_t k = 0; k < D; ++k) target[k][lane] = q[k];
            for (std::size_t h = 0; h < weights.size(); ++h) row[h][lane] = weights[h];
            return true;
        }
        this->clear(row, lane);
        for (std::size_t k = 0; k < D; ++k) target[k][lane] = handles_.rest[0][k];
        return false;
    }
};

/// Checks the cage and the options, and calls make(report) if they are valid.
template <Scalar T, std::size_t D, class Make>
BindReport report_bind(const BindInput<T, D>& input, const BindOptions& options, const Make& make) {
    BindReport report;
    report.points = input.points.size;
    run_into(report, [&] {
        report.cage = input.cage;
        if (report.cage.status != Status::ok) return report.cage.status;
        if (input.handles().count == 0) return Status::coordinates_empty;
        const Status status = check_falloff(options, input.has_extension);
        return status == Status::ok ? make(report) : status;
    });
    return report;
}

template <class T, std::size_t D>
Result<Binding<T, D>, BindReport> bind_points(const BindInput<T, D>& input, const BindOptions& options,
                                              Binding<T, D>&& recycled, const Running& running) {
    Result<Binding<T, D>, BindReport> result;
    result.report = report_bind(input, options, [&](BindReport& report) {
        PointBinder<T, D> binder(input, options);
        result.value = std::move(recycled);
        return binder.run(result.value, running, report);
    });
    return result;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
