// Solves the functions of a cage with any solver, and keeps them or samples and discards them by groups.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/harmonic/difference_gradients.hpp>
#include <cageform/coordinates/harmonic/project_blocks.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// A solver S made for its input, and its functions if they are kept.
template <class S, Scalar T>
    requires CageSolver<S, T>
class Solution final : public CageFunctions<T, S::dimension> {
    static constexpr std::size_t D = S::dimension;

public:
    explicit Solution(std::shared_ptr<const SolverInput<D>> input)
        : input_(std::move(input)) {}

    template <class... More>
    Status make(const Running& running, const More&... more) {
        const Status status = S::make(*input_, report_, solver_, running, more...);
        if (status != Status::ok) return status;
        const auto [hierarchy, block] = memory();
        report_.bytes = hierarchy + block;
        return Status::ok;
    }

    const SolverReport& report() const noexcept override { return report_; }
    SolverMemory memory() const noexcept override { return solver().memory(); }

    Status solve(SolverReport& into, const Running& running) override {
        if (!functions_.empty()) return Status::ok;
        const double kept = 0.5 * double(memory().block) * double(solver().groups());
        if (double(into.bytes) + kept > double(input_->options.memory_limit)) {
            into.bytes += std::size_t(kept);
            return Status::out_of_memory;
        }
        std::vector<typename S::Functions> functions(solver().groups());
        const Status status = grid::solve_groups(
            solver(), into,
            [&](std::size_t group, const auto& block) { functions[group] = solver().keep(block); }, running);
        if (status != Status::ok) return status;
        functions_ = std::move(functions);
        report_ = into;
        return Status::ok;
    }

    Status sample(const Batch<T>& batch, SolverReport& report, const Running& running) const override {
        const bool is_local = input_->screening > 0;
        const Status status =
            sample(batch, report, is_local ? running.subtask(0, 0.9) : running,
                   [&](std::span<const std::size_t> points) { return solver().samples(batch, points); });
        if (status != Status::ok || !is_local) return status;
        return BlockProjection<T, D>(input_->cage.vertices().first(input_->handles))
            .run(batch, running.subtask(0.9, 1));
    }

    /// Computes the gradients. With kept functions, a few blocks are processed at a time, so that their
    /// values stay in the caches.
    Status sample_gradients([[maybe_unused]] const Batch<T>& batch, [[maybe_unused]] SolverReport& report,
                            [[maybe_unused]] const Running& running) const override {
        if constexpr (!DifferentiableSolver<S, T>) {
            return Status::solver_not_supported;
        } else {
            if constexpr (BlendedSolver<S, T>) {
                if (solver().has_gradient_samples()) {
                    return sample(batch, report, running, [&](std::span<const std::size_t> points) {
                        return solver().gradient_samples(batch, points);
                    });
                }
            }
            constexpr std::size_t together = 4; // the values of a hundred handles fill the second-level cache
            const std::size_t blocks = batch.points.blocks();
            if (!functions_.empty()) {
                return for_each_block(blocks, running, [&](std::size_t begin, std::size_t end) {
                    DifferenceSamples<S, T> positions(solver(), batch, (std::min)(together, end - begin));
                    for (std::size_t b = begin; b < end; b += together) {
                        const std::size_t count = (std::min)(together, end - b);
                        for (std::size_t n = 0; n < count; ++n) positions.set(b + n, n);
                        (void)sample(positions.batch(count), report, {});
                        for (std::size_t n = 0; n < count; ++n) positions.differentiate(n, b + n);
                    }
                });
            }
            DifferenceSamples<S, T> positions(solver(), batch, blocks);
            const auto in_blocks = [&](const auto& f) {
                in_parallel(running, blocks, 16, [&](std::size_t begin, std::size_t end) {
                    for (std::size_t b = begin; b < end; ++b) f(b);
                });
            };
            in_blocks([&](std::size_t b) { positions.set(b, b); });
            const Status status = sample(positions.batch(blocks), report, running);
            if (status == Status::ok) in_blocks([&](std::size_t b) { positions.differentiate(b, b); });
            return status;
        }
    }

    Status
    for_each_cell([[maybe_unused]] const std::function<void(const GridCell<T, D>&)>& f) const override {
        const auto in_scalar = [&](const auto& cell) {
            f({vec_cast<T>(cell.low), static_cast<T>(cell.size), cell.is_cut});
        };
        if constexpr (requires { solver_->for_each_cell(in_scalar); }) {
            solver().for_each_cell(in_scalar);
            return Status::ok;
        }
        return Status::solver_not_supported;
    }

    Status save([[maybe_unused]] std::vector<std::byte>& bytes) const override {
        if constexpr (requires { solver_->solution_header(); }) {
            bytes = pack_solution(solver().solution_header(), functions_, report_);
            return Status::ok;
        }
        return Status::solver_not_supported;
    }
    Status load([[maybe_unused]] std::span<const std::byte> bytes,
                [[maybe_unused]] SolverReport& report) override {
        if constexpr (requires { solver_->solution_header(); }) {
            SolverReport stored = report;
            const Status status = open_solution(bytes, solver().solution_header(), functions_, stored);
            if (status == Status::ok) report = report_ = stored;
            return status;
        }
        return Status::solver_not_supported;
    }

private:
    /// Computes weights or gradients from kept functions. Without kept functions, solves group by group, and
    /// frees each group after sampling.
    ///
    ///   samples_of  samples_of(points): returns the stencils of the points with these indices
    template <class SamplesOf>
    Status sample(const Batch<T>& batch, SolverReport& report, const Running& running,
                  const SamplesOf& samples_of) const {
        // Points sampled together share work: `many` with kept functions, else `together`. A thread gets at
        // least `few` points.
        constexpr std::size_t few = 256, many = 4096, together = 1024;
        const auto order = order_of(batch);
        const std::size_t count = order.size(), pieces = (count + together - 1) / together;
        const auto samples_between = [&](std::size_t first, std::size_t last) {
            return samples_of(std::span(order).subspan(first, last - first));
        };
        if (!functions_.empty()) {
            return for_each_block((count + few - 1) / few, running, [&](std::size_t begin, std::size_t end) {
                const std::size_t last = (std::min)(end * few, count);
                for (std::size_t n = begin * few; n < last; n += many) {
                    auto samples = samples_between(n, (std::min)(n + many, last));
                    for (std::size_t group = 0; group < functions_.size(); ++group)
                        solver().sample(samples, group, functions_[group], batch.rows);
                    solver().finish(samples, batch.rows);
                }
            });
        }
        if (count == 0) return Status::ok;
        std::vector<decltype(samples_of(order))> samples(pieces);
        in_parallel(running, pieces, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n)
                samples[n] = samples_between(n * together, (std::min)((n + 1) * together, count));
        });
        const auto sample_group = [&](std::size_t group, const auto& block) {
            for (auto& piece : samples) solver().sample(piece, group, block, batch.rows);
        };
        const Status status = grid::solve_groups(solver(), report, sample_group, running);
        if (status != Status::ok) return status;
        in_parallel(running, pieces, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) solver().finish(samples[n], batch.rows);
        });
        return Status::ok;
    }

    std::vector<std::size_t> order_of(const Batch<T>& batch) const {
        if constexpr (requires { solver_->order(batch); }) {
            return solver().order(batch);
        } else {
            auto order = first_indices<std::size_t>(batch.points.blocks() * lane_count<T>);
            return order;
        }
    }

    // NOLINTNEXTLINE(bugprone-unchecked-optional-access): used only after `make`
    const S& solver() const noexcept { return *solver_; }

    std::shared_ptr<const SolverInput<D>> input_;
    std::optional<S> solver_;
    std::vector<typename S::Functions> functions_; ///< by group; empty until `solve`
    SolverReport report_;
};

} // namespace detail

/// Makes the functions of a cage by the solver S. A HarmonicSolver.
///
///   more  further arguments of S::make
template <class S, class T, std::size_t D, class... More>
Status make_functions(std::shared_ptr<const SolverInput<D>> input, SolverReport& report,
                      std::shared_ptr<CageFunctions<T, D>>& made, const Running& running,
                      const More&... more) {
    auto solution = std::make_shared<detail::Solution<S, T>>(std::move(input));
    const Status status = solution->make(running, more...);
    report = solution->report();
    if (status == Status::ok) made = std::move(solution);
    return status;
}

} // namespace cageform::inline CAGEFORM_ABI
