// One fused pass over a level: prolongation, sweeps of relaxation, and restriction of the residual.
//
// The finest level is relaxed by red-black Gauss–Seidel: its regular stencil couples a node only with nodes
// of the other colour. The half sweep of colour 0 also relaxes the irregular nodes of both colours. Coarser
// levels have 3^D-point stencils and are relaxed by Gauss–Seidel along the rows. In each range of rows,
// irregular nodes are relaxed before regular ones.
//
// A `Pass` selects the steps. `run` at the end of this file executes them in a single traversal of memory.
// Each step follows the one before it at the distance that the stencil requires.
#pragma once

#include <cageform/grid/multigrid/error_estimate.hpp>
#include <cageform/grid/multigrid/transfer.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The steps on the finest level. Without `HasSource`, b is zero at all regular nodes.
template <std::size_t D, bool HasSource>
struct FinestLevel {
    using Vector = Simd<float>;
    using Rows = typename Level<D>::Range;
    static constexpr std::size_t colours = 2;

    LevelFields<D> fields;

    void relax(Rows rows, std::uint32_t colour) const noexcept {
        if (colour == 0) relax_irregular(*this, rows);
        const Vector inverse(1 / fields.level.diagonal);
        for (const auto& run : fields.level.runs_of(rows)) {
            for_each_second(run, run.first_of(colour),
                            [&](NodeRow& u, const Vector& sum) { (sum * inverse).store(u); });
        }
    }
    /// Restricts the residual. Regular nodes of the second colour have no residual, because they were
    /// relaxed last.
    void restrict_residual(Rows rows, Residual& largest) const noexcept {
        const Vector diagonal(fields.level.diagonal);
        for (const auto& run : fields.level.runs_of(rows)) {
            const std::uint32_t begin = run.first_of(0);
            RunRestriction<D> restriction(run, run.x + std::int32_t(begin), fields.coarser->b.data());
            for_each_second(run, begin, [&](const NodeRow& u, const Vector& sum) {
                const Vector residual = sum - diagonal * Vector::load(u);
                largest.add(residual);
                restriction.add_second(residual);
            });
            restriction.finish();
        }
        restrict_irregular(*this, rows, largest);
    }
    /// Returns the largest residuals of all nodes.
    Residual residual() const noexcept {
        Residual largest;
        const Vector diagonal(fields.level.diagonal);
        for (std::size_t j = 0; j < fields.level.irregular.size(); ++j)
            largest.add(irregular_residual(*this, j), fields.level.irregular[j].row_sum);
        for (const auto& run : fields.level.runs) {
            for (const std::uint32_t begin : {0u, 1u}) {
                for_each_second(run, begin, [&](const NodeRow& u, const Vector& sum) {
                    largest.add(sum - diagonal * Vector::load(u));
                });
            }
        }
        return largest;
    }

    /// Returns b minus the off-diagonal part of A u.
    Vector irregular_sum(std::size_t j) const noexcept {
        const auto* const entry = fields.level.entries.data() + j * 2 * D;
        Vector sum = Vector::load(fields.irregular_b[j]);
        for (std::size_t n = 0; n < 2 * D; ++n)
            sum = sum + Vector(entry[n].weight) * Vector::load(fields.u[entry[n].node]);
        return sum;
    }

private:
    /// Calls body(u, b minus the off-diagonal part of A u) for every second node of a run.
    template <class Body>
    void for_each_second(const RegularRun<D>& run, std::uint32_t begin, Body body) const noexcept {
        const auto to = run.nearest();
        NodeRow* const first = fields.u + run.first;
        const NodeRow* const b = fields.b + run.first;
        const NodeRow* const end = first + run.count;
        Vector before = Vector::load(first[std::ptrdiff_t(begin) - 1]);
        for (NodeRow* here = first + begin; here < end; here += 2) {
            const Vector after = Vector::load(here[1]);
            Vector sum = before + after;
            before = after; // has the other colour and does not change
            if constexpr (HasSource) sum = sum + Vector::load(b[here - first]);
            for (std::size_t k = 1; k < D; ++k)
                sum = sum + (Vector::load(here[to[2 * k]]) + Vector::load(here[to[2 * k + 1]]));
            body(*here, sum);
        }
    }
};

template <std::size_t D>
struct CoarseLevel {
    using Vector = Simd<float>;
    using Rows = typename Level<D>::Range;
    static constexpr std::size_t colours = 1;

    LevelFields<D> fields;

    void relax(Rows rows, std::uint32_t) const noexcept {
        relax_irregular(*this, rows);
        const float inverse = 1 / fields.level.diagonal;
        for (const auto& run : fields.level.runs_of(rows)) {
            for_each_node(run, inverse, [](NodeRow& u, const Vector& sum, const Vector&) {
                sum.store(u);
                return sum;
            });
        }
    }
    void restrict_residual(Rows rows, Residual& largest) const noexcept {
        const Vector diagonal(fields.level.diagonal);
        for (const auto& run : fields.level.runs_of(rows)) {
            RunRestriction<D> restriction(run, run.x, fields.coarser->b.data());
            for_each_node(run, 1.0f, [&](const NodeRow&, const Vector& sum, const Vector& before) {
                const Vector residual = sum - diagonal * before;
                largest.add(residual);
                restriction.add(residual);
                return before;
            });
            restriction.finish();
        }
        restrict_irregular(*this, rows, largest);
    }

    /// Returns b minus the off-diagonal part of A u.
    Vector irregular_sum(std::size_t j) const noexcept {
        const NodeRow* const u = fields.u;
        const auto entries = fields.level.entries_of(j);
        Vector sum = Vector::load(fields.b[fields.level.irregular[j].node]), other(0.0f);
        for (std::size_t n = 0; n < entries.size(); n += 2) { // two independent sums, as in DenseSolver
            sum = sum + Vector(entries[n].weight) * Vector::load(u[entries[n].node]);
            other = other + Vector(entries[n + 1].weight) * Vector::load(u[entries[n + 1].node]);
        }
        return sum + other;
    }

private:
    static constexpr std::size_t row_count = power(3, D - 1);
    static constexpr std::array<std::size_t, row_count> row_distance = [] {
        std::array<std::size_t, row_count> distance{};
        for (std::size_t r = 0; r < row_count; ++r) distance[r] = StencilPositions<D>::distance(3 * r + 1);
        return distance;
    }();

    /// Sums of u over the neighbouring rows at one x, indexed by the distance of a row minus one.
    using Column = std::array<Vector, D - 1>;
    static Column column(const NodeRow* at, const std::array<std::ptrdiff_t, row_count>& to) noexcept {
        Column sum;
        for (auto& s : sum) s = Vector(0.0f);
        for (std::size_t r = 0; r < row_count; ++r) {
            const std::size_t d = row_distance[r];
            if (d != 0) sum[d - 1] = sum[d - 1] + Vector::load(at[to[r]]);
        }
        return sum;
    }
    /// Calls body(u, sum, before) for every node of a run. `sum` is factor · (b minus the off-diagonal part
    /// of A u), and `before` is the node's old value. body returns the value of this node for the sum of
    /// the next node.
    template <class Body>
    void for_each_node(const RegularRun<D>& run, float factor, Body body) const noexcept {
        std::array<std::ptrdiff_t, row_count> to{};
        for (std::size_t r = 0; r < row_count; ++r) to[r] = run.row[r];
        std::array<Vector, D + 1> weight;
        for (std::size_t d = 1; d <= D; ++d) weight[d] = Vector(factor * fields.level.by_distance[d]);
        const Vector one(factor);
        NodeRow* at = fields.u + run.first;
        const NodeRow* const b = fields.b + run.first;
        // The column ahead of this node is the column of the next one.
        Column before = column(at - 1, to), here = column(at, to);
        Vector left = Vector::load(at[-1]), middle = Vector::load(at[0]);
        const std::uint32_t count = run.count;
        for (std::uint32_t n = 0; n < count; ++n, ++at) {
            const Column ahead = column(at + 1, to);
            const Vector right = Vector::load(at[1]);
            Vector sum = one * Vector::load(b[n]);
            for (std::size_t d = 1; d < D; ++d)
                sum = sum + (weight[d] * here[d - 1] + weight[d + 1] * (before[d - 1] + ahead[d - 1]));
            // The newest value is added last, so that the other terms do not depend on it.
            sum = (sum + weight[1] * right) + weight[1] * left;
            left = body(*at, sum, middle);
            middle = right;
            before = here;
            here = ahead;
        }
    }
};

template <class AnyLevel>
void relax_irregular(const AnyLevel& level, typename AnyLevel::Rows rows) noexcept {
    const auto [begin, end] = level.fields.level.irregular_of(rows);
    for (std::size_t j = begin; j < end; ++j) {
        const auto& node = level.fields.level.irregular[j];
        (level.irregular_sum(j) * Simd<float>(node.inverse)).store(level.fields.u[node.node]);
    }
}
template <class AnyLevel>
Simd<float> irregular_residual(const AnyLevel& level, std::size_t j) noexcept {
    const auto& node = level.fields.level.irregular[j];
    return level.irregular_sum(j) -
           Simd<float>(float(node.diagonal)) * Simd<float>::load(level.fields.u[node.node]);
}
template <class AnyLevel>
void restrict_irregular(const AnyLevel& level, typename AnyLevel::Rows rows, Residual& largest) noexcept {
    const auto [begin, end] = level.fields.level.irregular_of(rows);
    for (std::size_t j = begin; j < end; ++j) {
        const auto r = irregular_residual(level, j);
        largest.add(r, level.fields.level.irregular[j].row_sum);
        level.fields.restrict_irregular(j, r);
    }
}

/// The steps of one pass over a level, in order.
struct Pass {
    enum class Prolong : std::uint8_t { none, add, set };
    Prolong prolong = Prolong::none; ///< adds the correction of the next level, or sets u to it
    std::size_t sweeps = 0;          ///< of relaxation
    bool restrict_residual = false;  ///< the restricted residual is the next level's right-hand side
};

/// Synchronises the threads of a pass: counts the completed steps of each chunk for the next chunk.
class WavefrontCounter {
public:
    static constexpr std::size_t most_chunks = 8;

    void report(std::size_t chunk, std::size_t steps) noexcept {
        steps_[chunk].done.store(steps, std::memory_order_release);
    }
    void wait_for(std::size_t chunk, std::size_t steps) const noexcept {
        for (Waiting waiting; steps_[chunk].done.load(std::memory_order_acquire) < steps;) waiting.wait();
    }

private:
    struct alignas(64) Steps { // one cache line each, against false sharing
        std::atomic<std::size_t> done{0};
    };
    std::array<Steps, most_chunks> steps_;
};

/// The stages of a pass in order: prolongation, half sweeps, restriction.
template <class AnyLevel>
struct Stages {
    const AnyLevel& level;
    const Pass& pass;
    std::size_t prolongs = pass.prolong == Pass::Prolong::none ? 0 : 1;
    std::size_t relaxations = AnyLevel::colours * pass.sweeps;
    std::size_t count = prolongs + relaxations + (pass.restrict_residual ? 1 : 0);

    void run(std::size_t stage, typename AnyLevel::Rows rows, Residual& largest) const noexcept {
        if (stage < prolongs && pass.prolong == Pass::Prolong::add) return prolong<false>(level.fields, rows);
        if (stage < prolongs) return prolong<true>(level.fields, rows);
        stage -= prolongs;
        if (stage < relaxations) return level.relax(rows, std::uint32_t(stage % AnyLevel::colours));
        level.restrict_residual(rows, largest);
    }
    /// Returns the first stage of a chunk. Stages are divided evenly; a transfer counts as two half sweeps.
    std::size_t first_of(std::size_t chunk, std::size_t chunks) const noexcept {
        if (chunk == 0) return 0;
        if (chunk == chunks) return count;
        const std::size_t transfers = count - relaxations, before = (relaxations + 2 * transfers) * chunk;
        return std::clamp((before + chunks / 2) / chunks - prolongs, chunk, count - (chunks - chunk));
    }
};

/// Divides every slab into tiles, so that the working set of a pass, one tile per stage, stays in the
/// cache. The tiles of each stage are shifted down by one row from those of the stage before, because
/// stencils extend by one row (time skewing: Wonnacott, Int. J. Parallel Program. 30 (2002)).
template <std::size_t D>
struct Tiles {
    using Rows = typename Level<D>::Range;

    Tiles(const Level<D>& level, std::size_t stages) noexcept
        : slab_rows(level.slab_rows) {
        constexpr std::size_t in_flight = std::size_t{1} << 19, least_height = 8; // bytes, rows
        const std::size_t row_bytes = level.count * sizeof(NodeRow) / (level.rows.size() - 1) + 1;
        height =
            std::clamp(in_flight / (stages * row_bytes + 1), (std::min)(least_height, slab_rows), slab_rows);
        count = slab_rows / height;
    }
    Rows rows(std::size_t tile, std::size_t stage, std::size_t slab) const noexcept {
        const auto row = [&](std::size_t edge) {
            const std::size_t y = edge * height;
            return slab * slab_rows + (edge == count ? slab_rows : y > stage ? y - stage : 0);
        };
        return {row(tile), row(tile + 1)};
    }

    std::size_t slab_rows, height = 1, count = 1;
};

/// Runs all stages in a single pass over memory: each stage processes the slab that the previous stage has
/// just left, tile by tile. With several threads, each thread runs some of the stages and follows the thread
/// before it through the slabs. Dependent work keeps its order, so the result does not depend on the threads.
/// Returns the residual if it is restricted.
template <class AnyLevel>
Residual run(const AnyLevel& level, const Pass& pass, const WorkShare& share) noexcept {
    constexpr std::size_t worth_sharing = 4096; // nodes, about tens of microseconds
    const std::size_t slabs = level.fields.level.slabs();
    const Stages<AnyLevel> stages{level, pass};
    const Tiles tiles(level.fields.level, stages.count);
    Residual largest;
    if (pass.restrict_residual) set_zero(level.fields.coarser->b, share);
    std::size_t most = (std::min)(stages.count, WavefrontCounter::most_chunks);
    if (level.fields.level.count < worth_sharing) most = 1;
    WavefrontCounter progress;
    share.split(most, [&](std::size_t chunk, std::size_t chunks) {
        const std::size_t first = stages.first_of(chunk, chunks), end = stages.first_of(chunk + 1, chunks);
        for (std::size_t tile = 0; tile < tiles.count; ++tile) {
            const std::size_t done = tile * (slabs + stages.count); // steps of earlier tiles
            for (std::size_t step = first; step + 1 < slabs + end; ++step) {
                if (chunk > 0) progress.wait_for(chunk - 1, done + (std::min)(step + 1, slabs + first - 1));
                for (std::size_t stage = first; stage < end; ++stage) {
                    const std::size_t slab = step - stage; // wraps around before the first slab
                    if (slab < slabs) stages.run(stage, tiles.rows(tile, stage, slab), largest);
                }
                progress.report(chunk, done + step + 1);
            }
        }
    });
    return largest;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
