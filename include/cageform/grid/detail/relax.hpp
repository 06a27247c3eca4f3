// The work on one slab of a level: relaxation, and the residual restricted to the next level.
//
// The finest level is relaxed by Gauss–Seidel in red-black order. Its regular stencil couples a
// node with those of the other colour only. Coarser levels have all 3^D neighbours and are relaxed
// by Gauss–Seidel along the rows. Irregular nodes of a slab come before its regular ones.
#pragma once

#include <cageform/grid/detail/error_estimate.hpp>
#include <cageform/grid/detail/transfer.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The finest level. Without `HasSource`, b is zero at all regular nodes.
template <std::size_t D, bool HasSource>
struct FinestLevel {
    using Vector = Simd<float>;
    static constexpr std::size_t colours = 2;
    static constexpr float diagonal = 2.0f * float(D); ///< of the regular stencil

    LevelFields<D> fields;

    void relax(std::size_t slab, std::uint32_t colour) const noexcept {
        if (colour == 0) relax_irregular(*this, slab);
        for (const auto& run : fields.level.runs_of(slab)) {
            for_each_second(run, run.first_of(colour),
                            [](NodeRow& u, const Vector& sum) { (sum * Vector(1 / diagonal)).store(u); });
        }
    }
    /// Just relaxed nodes of the second colour have no residual.
    void restrict_residual(std::size_t slab, Residual& largest) const noexcept {
        for (const auto& run : fields.level.runs_of(slab)) {
            const std::uint32_t begin = run.first_of(0);
            RunRestriction<D> restriction(run, run.x + std::int32_t(begin), fields.coarser->b.data());
            for_each_second(run, begin, [&](const NodeRow& u, const Vector& sum) {
                const Vector residual = sum - Vector(diagonal) * Vector::load(u);
                largest.add(residual);
                restriction.add_second(residual);
            });
            restriction.finish();
        }
        restrict_irregular(*this, slab, largest);
    }
    /// Of all nodes.
    Residual residual() const noexcept {
        Residual largest;
        for (std::size_t j = 0; j < fields.level.irregular.size(); ++j)
            largest.add(irregular_residual(*this, j), fields.level.irregular[j].row_sum);
        for (const auto& run : fields.level.runs) {
            for (const std::uint32_t begin : {0u, 1u}) {
                for_each_second(run, begin, [&](const NodeRow& u, const Vector& sum) {
                    largest.add(sum - Vector(diagonal) * Vector::load(u));
                });
            }
        }
        return largest;
    }

    /// b minus the off-diagonal part of A u.
    Vector irregular_sum(std::size_t j) const noexcept {
        const auto* const entry = fields.level.entries.data() + j * 2 * D;
        Vector sum = Vector::load(fields.irregular_b[j]);
        for (std::size_t n = 0; n < 2 * D; ++n)
            sum = sum + Vector(entry[n].weight) * Vector::load(fields.u[entry[n].node]);
        return sum;
    }

private:
    /// body(u, b minus the off-diagonal part of A u) for every second node of a run.
    template <class Body>
    void for_each_second(const RegularRun<D>& run, std::uint32_t begin, Body body) const noexcept {
        const auto to = run.nearest();
        NodeRow* const first = fields.u + run.first;
        const NodeRow* const b = fields.b + run.first;
        const NodeRow* const end = first + run.count;
        for (NodeRow* here = first + begin; here < end; here += 2) {
            Vector sum = Vector::load(here[-1]) + Vector::load(here[1]);
            if constexpr (HasSource) sum = sum + Vector::load(b[here - first]);
            for (std::size_t k = 1; k < D; ++k)
                sum = sum + (Vector::load(here[to[2 * k]]) + Vector::load(here[to[2 * k + 1]]));
            body(*here, sum);
        }
    }
};

/// Any other level.
template <std::size_t D>
struct CoarseLevel {
    using Vector = Simd<float>;
    static constexpr std::size_t colours = 1;

    LevelFields<D> fields;

    void relax(std::size_t slab, std::uint32_t) const noexcept {
        relax_irregular(*this, slab);
        const float inverse = 1 / fields.level.diagonal;
        for (const auto& run : fields.level.runs_of(slab)) {
            for_each_node(run, inverse, [](NodeRow& u, const Vector& sum, const Vector&) {
                sum.store(u);
                return sum;
            });
        }
    }
    void restrict_residual(std::size_t slab, Residual& largest) const noexcept {
        const Vector diagonal(fields.level.diagonal);
        for (const auto& run : fields.level.runs_of(slab)) {
            RunRestriction<D> restriction(run, run.x, fields.coarser->b.data());
            for_each_node(run, 1.0f, [&](const NodeRow&, const Vector& sum, const Vector& before) {
                const Vector residual = sum - diagonal * before;
                largest.add(residual);
                restriction.add(residual);
                return before;
            });
            restriction.finish();
        }
        restrict_irregular(*this, slab, largest);
    }

    /// b minus the off-diagonal part of A u.
    Vector irregular_sum(std::size_t j) const noexcept {
        const NodeRow* const u = fields.u;
        const auto entries = fields.level.entries_of(j);
        Vector sum = Vector::load(fields.b[fields.level.irregular[j].node]), other(0.0f);
        for (std::size_t n = 0; n < entries.size(); n += 2) { // two sums: see DenseSolver
            sum = sum + Vector(entries[n].weight) * Vector::load(u[entries[n].node]);
            other = other + Vector(entries[n + 1].weight) * Vector::load(u[entries[n + 1].node]);
        }
        return sum + other;
    }

private:
    static constexpr std::size_t row_count = power(3, D - 1);
    static constexpr std::array<std::size_t, row_count> row_distance = [] {
        std::array<std::size_t, row_count> distance{};
        for (std::size_t r = 0; r < row_count; ++r) distance[r] = Places<D>::distance(3 * r + 1);
        return distance;
    }();

    /// Sums of u over the neighbouring rows at one x, by the distance of a row less one.
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
    /// body(u, sum, before) for every node of a run. sum is factor · (b minus the off-diagonal part
    /// of A u), before the node's value. It returns the value that the next node's sum is to take.
    template <class Body>
    void for_each_node(const RegularRun<D>& run, float factor, Body body) const noexcept {
        std::array<std::ptrdiff_t, row_count> to{};
        for (std::size_t r = 0; r < row_count; ++r) to[r] = run.row[r];
        std::array<Vector, D + 1> weight;
        for (std::size_t d = 1; d <= D; ++d) weight[d] = Vector(factor * fields.level.by_distance[d]);
        const Vector one(factor);
        NodeRow* at = fields.u + run.first;
        const NodeRow* const b = fields.b + run.first;
        // Columns are carried along: what is ahead now is beside the next node.
        Column before = column(at - 1, to), here = column(at, to);
        Vector left = Vector::load(at[-1]), middle = Vector::load(at[0]);
        const std::uint32_t count = run.count;
        for (std::uint32_t n = 0; n < count; ++n, ++at) {
            const Column ahead = column(at + 1, to);
            const Vector right = Vector::load(at[1]);
            Vector sum = one * Vector::load(b[n]);
            for (std::size_t d = 1; d < D; ++d)
                sum = sum + (weight[d] * here[d - 1] + weight[d + 1] * (before[d - 1] + ahead[d - 1]));
            sum = (sum + weight[1] * right) + weight[1] * left; // the newest value last
            left = body(*at, sum, middle);
            middle = right;
            before = here;
            here = ahead;
        }
    }
};

template <class AnyLevel>
void relax_irregular(const AnyLevel& level, std::size_t slab) noexcept {
    const auto [begin, end] = level.fields.level.irregular_of(slab);
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
void restrict_irregular(const AnyLevel& level, std::size_t slab, Residual& largest) noexcept {
    const auto [begin, end] = level.fields.level.irregular_of(slab);
    for (std::size_t j = begin; j < end; ++j) {
        const auto r = irregular_residual(level, j);
        largest.add(r, level.fields.level.irregular[j].row_sum);
        level.fields.restrict_irregular(j, r);
    }
}

/// What one pass over a level does, in this order.
struct Pass {
    enum class Prolong : std::uint8_t { none, add, set };
    Prolong prolong = Prolong::none; ///< the correction of the next level
    std::size_t sweeps = 0;          ///< of relaxation
    bool restrict_residual = false;  ///< to the next level, whose right-hand side it becomes
};

/// All steps in a single pass over memory: each works on the slab that the one before has just
/// left. Returns the residual where it is restricted.
template <class AnyLevel>
Residual run(const AnyLevel& level, const Pass& pass) noexcept {
    const std::size_t slabs = level.fields.level.slabs.size();
    const std::size_t first_sweep = pass.prolong == Pass::Prolong::none ? 0 : 1;
    const std::size_t relaxations = AnyLevel::colours * pass.sweeps;
    Residual largest;
    if (pass.restrict_residual) set_zero(level.fields.coarser->b);
    for (std::size_t step = 0; step < first_sweep + relaxations + slabs; ++step) {
        if (step < slabs && pass.prolong == Pass::Prolong::add) prolong<false>(level.fields, step);
        if (step < slabs && pass.prolong == Pass::Prolong::set) prolong<true>(level.fields, step);
        std::size_t slab = step - first_sweep; // wraps round before the first slab and is none then
        for (std::size_t n = 0; n < relaxations; ++n, --slab) {
            if (slab < slabs) level.relax(slab, std::uint32_t(n % AnyLevel::colours));
        }
        if (slab < slabs && pass.restrict_residual) level.restrict_residual(slab, largest);
    }
    return largest;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
