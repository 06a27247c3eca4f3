// Solves the Laplace equation on the nodes of a lattice by multigrid, sixteen right-hand sides at once.
//
// The method is Dendy's black box multigrid (J. Comput. Phys. 48 (1982)) in two and three dimensions. Read
// this comment first, then relax.hpp, transfer.hpp and coarsen.hpp.
//
// A few sweeps of relaxation remove the high frequencies of the error. The remaining error e is smooth and
// satisfies A e = r, where r = b − A u is the residual. So r is restricted to a lattice of every second node.
// There e is computed by the same method. It is prolonged back as a correction of u. On the coarsest level
// the equations are solved directly.
//
// At the start of a cycle (`cycle`) the residual of level 0, the finest, is already restricted to level 1.
//
//   1. `w_cycle` computes the correction on level 1, from zero: relax, restrict the residual,
//      w_cycle of the next level, prolong, relax, and the same again.
//   2. `finish` prolongs the correction to level 0 and relaxes five (2D) or seven (3D) sweeps.
//      Then it restricts the new residual, and estimates the error from this residual.
//
// `start` is an F-cycle of W-cycles. On the way down, each level from 1 on relaxes once and restricts its
// residual. On the way up, each level adds the correction and runs the second half of a W-cycle. groups.hpp
// repeats cycles until the error estimate is within the tolerance. It runs at least two cycles, because the
// solution is refined in the second one (see below). The error bound is only reported.
//
// Irregular nodes, such as those at cut links, have their own stencil or interpolation. A run consists of
// consecutive regular nodes of a row; a slab consists of all nodes of one index along the last axis. Data are
// boundary values; they are part of the source, the right-hand side set by the caller. The reach is the
// largest error of an interior node for a residual of 1.
//
//   equations        the finest equations: Shortley and Weller's, made symmetric (Gibou et al.)
//   coarsen          P from the equations, and the coarse equations Pᵀ A P
//   level            a level in the layout of the cycles
//   relax            Gauss–Seidel, red-black on the finest level, and the pass that fuses all steps
//   transfer         restriction and prolongation
//   dense_solver     Cholesky factors for the coarsest level
//   error_estimate   the error estimate, which is the stopping criterion, and the error bound
//   high_low         the solution with twice float's digits
//   tridiagonal      elimination in one dimension, without levels
//
// Cycles use float; a row of sixteen functions fills a cache line. Every second cycle begins with iterative
// refinement (Wilkinson, Rounding Errors in Algebraic Processes (1963), ch. 3): u is added to a solution
// stored as a high and a low float. The residual of this solution, computed in double, becomes the new
// right-hand side. The solution has the accuracy of double. Denormal numbers are flushed to zero.
#pragma once

#include <cageform/core/detail/flush_denormals.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/multigrid/dense_solver.hpp>
#include <cageform/grid/multigrid/high_low.hpp>
#include <cageform/grid/multigrid/relax.hpp>
#include <cageform/grid/multigrid/tridiagonal.hpp>

namespace cageform::inline CAGEFORM_ABI::grid {

/// The levels for one set of unknowns, for any number of right-hand sides and threads.
template <std::size_t D>
class Multigrid {
public:
    /// Number of right-hand sides solved at once.
    static constexpr std::size_t width = detail::functions_together;
    using Values = detail::NodeValues; ///< one number per right-hand side
    using Error = detail::SolveError;
    using Row = detail::NodeRow;

    /// The solution of sixteen right-hand sides and the working memory. The caller writes `source`, also
    /// between cycles.
    struct Block {
        Values value(std::uint32_t node) const noexcept {
            if constexpr (D == 1) return exact_[node];
            Values v;
            for (std::size_t k = 0; k < width; ++k) v[k] = double(fields_[0].u[node][k]);
            base_.add_to(v, node, 1);
            return v;
        }
        bool empty() const noexcept { return fields_.empty() && exact_.empty(); }

        /// Whether residuals have been computed in double, which is after the second cycle. Before that,
        /// the error bound ignores the rounding of float.
        bool is_refined() const noexcept { return refined_; }
        std::size_t bytes() const noexcept {
            std::size_t rows = irregular_b_.capacity();
            for (const auto& level : fields_) rows += level.u.capacity() + level.b.capacity();
            return rows * sizeof(Row) + base_.bytes() +
                   (source.capacity() + refined_source_.capacity() + exact_.capacity()) * sizeof(Values);
        }

    private:
        friend class Multigrid;
        detail::ErrorEstimator error_;
        std::vector<detail::Fields> fields_; ///< per level
        Buffer<Row> irregular_b_;            ///< b at the irregular nodes of the finest level
        detail::HighLow base_;               ///< the solution is base_ + u of the finest level
        Buffer<Values> refined_source_;      ///< A · base_, parallel to `source`
        Buffer<Values> exact_;               ///< the solution in one dimension
        std::size_t cycles_ = 0;
        detail::WorkShare share_; ///< of the current call

    public:
        Buffer<Values> source; ///< right-hand sides of the nodes that may have one (`source_nodes_`)

    private:
        bool refined_ = false;  ///< whether b of the finest level is set at every node
        bool u_is_zero_ = true; ///< whether u of the finest level counts as zero, regardless of its contents
    };

    /// Makes the levels.
    ///
    ///   cuts     every link of an unknown that does not end at an unknown
    ///   sources  further nodes with a right-hand side
    ///   running  its parallel_for makes the levels
    ///   screening  κ² of the equation −∇²u + κ²u = b, in units of the lattice
    Multigrid(const NodeRuns<D>& nodes, std::span<const CutLink> cuts, std::span<const std::uint32_t> sources,
              const Running& running = {}, double screening = 0)
        : unknowns_(nodes.count())
        , diagonal_(2.0 * double(D) + screening) {
        // −∇²(R² − |x|²)/2D = 1. So in a ball of radius R around the nodes, an error is at most R²/2D times
        // the largest residual.
        double squares = 0;
        for (const auto n : nodes.size()) squares += 0.25 * (double(n) + 1) * (double(n) + 1);
        reach_ = squares / (2.0 * double(D));
        auto equations = detail::shortley_weller_equations<D>(nodes, cuts, screening);
        if constexpr (D == 1) {
            for (std::uint32_t node = 0; node < unknowns_; ++node) {
                if (equations.is_irregular(node)) source_nodes_.push_back(node);
            }
            tridiagonal_ = detail::TridiagonalSolver(equations);
        } else {
            make_levels(std::move(equations), running);
            for (const auto& irregular : levels_[0].irregular) source_nodes_.push_back(irregular.node);
        }
        find_inner_sources(nodes, sources);
    }

    std::uint32_t unknowns() const noexcept { return unknowns_; }

    /// The nodes that may have a right-hand side, those with cut links first. Parallel to `Block::source`.
    std::size_t source_count() const noexcept { return source_nodes_.size(); }

    /// Returns how many additional threads can share the work of a block (`start`).
    std::size_t helpers() const noexcept {
        constexpr std::uint32_t a_millisecond = 20000; // nodes that take a millisecond in a pass
        return D == 1 || unknowns_ < a_millisecond ? 0 : 3;
    }

    /// Returns for every node its index in `Block::source`, or 0 if it has no right-hand side.
    std::vector<std::uint32_t> source_slots() const {
        std::vector<std::uint32_t> slots(unknowns_);
        for (std::size_t s = 0; s < source_count(); ++s) slots[source_nodes_[s]] = std::uint32_t(s);
        return slots;
    }

    Block make_block() const {
        Block block;
        block.source.resize(source_count());
        if constexpr (D == 1) {
            block.exact_.resize(unknowns_);
            return block;
        }
        block.fields_.resize(levels_.size());
        for (std::size_t l = 0; l < levels_.size(); ++l) {
            block.fields_[l].u.resize(levels_[l].count);
            block.fields_[l].b.resize(levels_[l].count);
        }
        block.refined_source_.resize(source_count());
        block.irregular_b_.resize(levels_[0].irregular.size());
        return block;
    }

    /// Computes a first solution for the `source` of the block by an F-cycle (see above).
    ///
    ///   share  threads that take part in the work; the result does not depend on them
    Error start(Block& block, const detail::WorkShare& share = {}) const {
        const detail::FlushDenormals flush;
        if constexpr (D == 1) return solve_in_one_dimension(block);
        block.share_ = share;
        reset(block);
        restrict_source(block);
        for (std::size_t l = 1; l < coarsest(); ++l) pre_relax_and_restrict(block, l);
        solve_coarsest(block);
        for (std::size_t l = coarsest(); l-- > 1;) second_half_of_cycle(block, l);
        return finish(block);
    }

    /// Runs one more cycle. The previous pass has already restricted the residual, so the cycle begins on
    /// level 1.
    Error cycle(Block& block, const detail::WorkShare& share = {}) const {
        const detail::FlushDenormals flush;
        if constexpr (D == 1) return solve_in_one_dimension(block);
        block.share_ = share;
        set_right_hand_side(block);
        if (coarsest() == 0 || block.cycles_++ % refine_every == 1) refine(block);
        w_cycle(block, std::min<std::size_t>(1, coarsest()));
        return finish(block);
    }

    /// Call this after a change of `source` between cycles, with the largest change of each right-hand side.
    static void disturb(Block& block, const Values& change) noexcept { block.error_.disturb(change); }

    /// Returns the memory of the levels, without blocks.
    std::size_t bytes() const noexcept {
        std::size_t n = coarsest_solver_.bytes() + tridiagonal_.bytes() +
                        source_nodes_.size() * sizeof(std::uint32_t) +
                        inner_neighbours_.size() * sizeof(Nearest);
        for (const auto& level : levels_) n += level.bytes();
        return n;
    }
    /// Returns the maximum memory of a block. With fewer than four cycles the low part is not allocated,
    /// which saves one row per unknown.
    std::size_t block_bytes() const noexcept {
        if constexpr (D == 1) return (unknowns_ + source_count()) * sizeof(Values);
        std::size_t rows = levels_[0].irregular.size() + 2 * std::size_t(unknowns_);
        for (const auto& level : levels_) rows += 2 * std::size_t(level.count);
        return rows * sizeof(Row) + 2 * source_count() * sizeof(Values);
    }

private:
    using Prolong = detail::Pass::Prolong;
    using Nearest = std::array<std::uint32_t, 2 * D>;

    // ---- the hierarchy --------------------------------------------------------------------------

    void make_levels(detail::Equations<D> equations, const Running& running) {
        while (equations.nodes.count() > dense_unknowns) {
            auto coarsening = detail::Coarsener<D>(equations, running).take();
            if (coarsening.coarse.nodes.count() == 0) break;
            levels_.push_back(detail::LevelMaker<D>(equations, &coarsening, levels_.empty()).take());
            equations = std::move(coarsening.coarse);
        }
        levels_.push_back(detail::LevelMaker<D>(equations, nullptr, levels_.empty()).take());
        if (equations.nodes.count() <= dense_unknowns) coarsest_solver_ = detail::DenseSolver(equations);
    }
    /// Finds the nodes without cut links that may have a right-hand side, and their neighbours.
    void find_inner_sources(const NodeRuns<D>& nodes, std::span<const std::uint32_t> sources) {
        if (sources.empty()) return;
        std::vector<bool> wanted(nodes.count());
        for (const auto node : sources) wanted[node] = true;
        for (const auto node : source_nodes_) wanted[node] = false;
        detail::Neighbours<D> around(nodes);
        nodes.for_each([&](const auto& index, std::uint32_t node) {
            if (!wanted[node]) return;
            source_nodes_.push_back(node);
            around.move_to(index);
            Nearest neighbours;
            std::size_t n = 0;
            for (std::size_t p = 0; p < detail::StencilPositions<D>::count; ++p) {
                if (detail::StencilPositions<D>::distance(p) == 1) neighbours[n++] = around.at(p);
            }
            inner_neighbours_.push_back(neighbours);
        });
    }
    std::size_t coarsest() const noexcept { return levels_.size() - 1; }

    // ---- cycles ---------------------------------------------------------------------------------

    /// Runs a W-cycle on a coarse level, from zero: pre-relax, restrict the residual, recurse, prolong,
    /// post-relax, and all of it a second time. The post-relaxation of the first half and the
    /// pre-relaxation of the second are one pass of two sweeps. A V-cycle would need less work, but these
    /// levels are small, and thin parts of the domain need accurate corrections.
    void w_cycle(Block& block, std::size_t l) const noexcept {
        if (l == coarsest()) return solve_coarsest(block);
        pre_relax_and_restrict(block, l);
        w_cycle(block, l + 1);
        second_half_of_cycle(block, l);
    }
    void second_half_of_cycle(Block& block, std::size_t l) const noexcept {
        prolong_relax_and_restrict(block, l);
        w_cycle(block, l + 1);
        prolong_and_post_relax(block, l);
    }

    // Each of these is one pass over the level with fused steps (multigrid/relax.hpp).
    void pre_relax_and_restrict(Block& block, std::size_t l) const noexcept {
        detail::set_zero(block.fields_[l].u, block.share_);
        pass(block, l, {.sweeps = 1, .restrict_residual = true});
    }
    /// Combines the post-relaxation of one half of a cycle and the pre-relaxation of the next.
    void prolong_relax_and_restrict(Block& block, std::size_t l) const noexcept {
        pass(block, l, {.prolong = Prolong::add, .sweeps = 2, .restrict_residual = true});
    }
    void prolong_and_post_relax(Block& block, std::size_t l) const noexcept {
        pass(block, l, {.prolong = Prolong::add, .sweeps = 1});
    }

    void solve_coarsest(Block& block) const noexcept {
        const std::size_t l = coarsest();
        auto& [u, b] = block.fields_[l];
        if (coarsest_solver_.empty()) {
            // The level is large, but too thin for a coarser level. Then data is near every node, and
            // relaxation converges fast.
            detail::set_zero(u, block.share_);
            pass(block, l, {.sweeps = 8});
            return;
        }
        for (std::size_t j = 0; l == 0 && j < block.irregular_b_.size(); ++j)
            b[levels_[0].irregular[j].node] = block.irregular_b_[j];
        coarsest_solver_.solve(b, u);
    }

    /// Completes a cycle on the finest level, and estimates the error from its residual.
    Error finish(Block& block) const {
        if (coarsest() == 0) return block.error_.estimate(residual(block), reach_);
        block.error_.update_gain(block.fields_[1].u);
        const auto prolong = block.u_is_zero_ ? Prolong::set : Prolong::add;
        block.u_is_zero_ = false;
        const auto largest =
            pass(block, 0, {.prolong = prolong, .sweeps = finest_sweeps, .restrict_residual = true});
        return block.error_.estimate(largest, reach_);
    }

    detail::Residual pass(Block& block, std::size_t l, const detail::Pass& pass) const noexcept {
        const auto& share = block.share_;
        if (l > 0) return run(detail::CoarseLevel<D>{fields(block, l)}, pass, share);
        return has_source(block) ? run(detail::FinestLevel<D, true>{fields(block, 0)}, pass, share)
                                 : run(detail::FinestLevel<D, false>{fields(block, 0)}, pass, share);
    }
    detail::Residual residual(Block& block) const noexcept {
        return has_source(block) ? detail::FinestLevel<D, true>{fields(block, 0)}.residual()
                                 : detail::FinestLevel<D, false>{fields(block, 0)}.residual();
    }
    detail::LevelFields<D> fields(Block& block, std::size_t l) const noexcept {
        auto& [u, b] = block.fields_[l];
        auto* const coarser = l < coarsest() ? &block.fields_[l + 1] : nullptr;
        return {levels_[l], u.data(), b.data(), block.irregular_b_.data(), coarser};
    }
    /// Whether regular nodes of the finest level have a right-hand side.
    bool has_source(const Block& block) const noexcept {
        return block.refined_ || !inner_neighbours_.empty();
    }

    // ---- right-hand sides -----------------------------------------------------------------------

    void reset(Block& block) const {
        block.error_.reset();
        block.base_.clear();
        block.refined_ = false;
        block.u_is_zero_ = true;
        block.cycles_ = 0;
        for (auto& values : block.refined_source_) values.fill(0.0);
        if (coarsest() == 0 || !inner_neighbours_.empty()) detail::set_zero(block.fields_[0].b, block.share_);
        set_right_hand_side(block);
    }
    /// Restricts the residual of u = 0 on the finest level. If regular nodes have a right-hand side too,
    /// relaxes first.
    void restrict_source(Block& block) const noexcept {
        if (coarsest() == 0) return;
        if (has_source(block)) {
            pre_relax_and_restrict(block, 0);
            block.u_is_zero_ = false;
            return;
        }
        detail::set_zero(block.fields_[1].b, block.share_);
        const auto finest = fields(block, 0);
        for (std::size_t j = 0; j < block.irregular_b_.size(); ++j)
            finest.restrict_irregular(j, detail::Simd<float>::load(block.irregular_b_[j]));
    }
    /// Sets b = source − A · base at the nodes that may have a source.
    void set_right_hand_side(Block& block) const noexcept {
        const std::size_t irregular = block.irregular_b_.size();
        block.share_.for_ranges(block.source.size(), few_nodes, [&](std::size_t begin, std::size_t end) {
            for (std::size_t j = begin; j < end; ++j) {
                Row& b = j < irregular ? block.irregular_b_[j] : block.fields_[0].b[source_nodes_[j]];
                for (std::size_t k = 0; k < width; ++k)
                    b[k] = float(block.source[j][k] - block.refined_source_[j][k]);
            }
        });
    }
    /// Adds u to the base. The residual of the base, computed in double, becomes the right-hand side.
    void refine(Block& block) const {
        const auto& level = levels_[0];
        auto& base = block.base_;
        base.add(block.fields_[0].u, block.share_);
        block.u_is_zero_ = true;
        block.refined_ = true;
        const auto& share = block.share_;
        share.for_ranges(level.runs.size(), few_runs, [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r)
                base.apply_minus_a(level.runs[r], diagonal_, block.fields_[0].b);
        });
        share.for_ranges(source_count(), few_nodes, [&](std::size_t begin, std::size_t end) {
            for (std::size_t j = begin; j < end; ++j) apply_a(base, j, block.refined_source_[j]);
        });
        set_right_hand_side(block);
    }

    /// Sets sum = A · base at a node that may have a source.
    void apply_a(const detail::HighLow& base, std::size_t j, Values& sum) const noexcept {
        const auto& level = levels_[0];
        sum.fill(0.0);
        if (j < level.irregular.size()) {
            base.add_to(sum, level.irregular[j].node, level.irregular[j].diagonal);
            for (const auto& entry : level.entries_of(j)) base.add_to(sum, entry.node, -double(entry.weight));
        } else {
            base.add_to(sum, source_nodes_[j], diagonal_);
            for (const auto node : inner_neighbours_[j - level.irregular.size()])
                base.add_to(sum, node, -1.0);
        }
    }

    Error solve_in_one_dimension(Block& block) const {
        for (auto& values : block.exact_) values.fill(0.0);
        for (std::size_t j = 0; j < source_count(); ++j) block.exact_[source_nodes_[j]] = block.source[j];
        tridiagonal_.solve(block.exact_);
        block.refined_ = true;
        return {Values{}, Values{}};
    }

    /// A level of at most this many unknowns is solved directly.
    static constexpr std::uint32_t dense_unknowns = 160;
    /// Sweeps on the finest level. In 2D, five and seven sweeps were compared for eight figures at 256², 512²
    /// and 1024². The number of cycles was the same, except for one more in three cases and one less in one
    /// case.
    static constexpr std::size_t finest_sweeps = D == 2 ? 5 : 7;
    static constexpr std::size_t few_nodes = 2048, few_runs = 64; ///< fewer are not worth another thread
    /// Cycles 2, 4, … begin with a refinement. In a third cycle without one, the rounding of float would
    /// limit the reduction of the error.
    static constexpr std::size_t refine_every = 2;

    std::uint32_t unknowns_;
    double diagonal_;                       ///< of the regular stencil
    double reach_ = 1;                      ///< the largest error of an interior node for a residual of 1
    std::vector<detail::Level<D>> levels_;  ///< the finest first; empty in one dimension
    detail::DenseSolver coarsest_solver_;   ///< empty if the coarsest level is large
    detail::TridiagonalSolver tridiagonal_; ///< in one dimension
    std::vector<std::uint32_t> source_nodes_;
    Buffer<Nearest> inner_neighbours_; ///< parallel to the last source nodes, those without cut links
};

} // namespace cageform::inline CAGEFORM_ABI::grid
