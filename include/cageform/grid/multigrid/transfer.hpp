// Restriction Pᵀ of the residual to the next coarser level, and prolongation P of the correction
// (coarsen.hpp).
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/grid/multigrid/level.hpp>
#include <cageform/grid/multigrid/node_values.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A level, and the arrays of a pass over it.
template <std::size_t D>
struct LevelFields {
    const Level<D>& level;
    NodeRow *u, *b;             ///< A u = b; at irregular nodes of the finest level `irregular_b` replaces b
    const NodeRow* irregular_b; ///< parallel to `level.irregular`
    Fields* coarser;            ///< the next level's correction u and restricted residual b

    /// Adds Pᵀ r to b of the next level for the residual r of irregular node j.
    void restrict_irregular(std::size_t j, const Simd<float>& r) const noexcept {
        NodeRow* const coarse = coarser->b.data();
        for (const auto& entry : level.interpolation_of(j)) {
            NodeRow& row = coarse[entry.node];
            (Simd<float>::load(row) + Simd<float>(entry.weight) * r).store(row);
        }
    }
};

/// Applies Pᵀ along a run. Residuals are added in order; contributions to one coarse node are summed before
/// they are written.
template <std::size_t D>
class RunRestriction {
    using Vector = Simd<float>;

public:
    ///   x  index along axis 0 of the first node with a residual
    RunRestriction(const RegularRun<D>& run, std::int32_t x, NodeRow* coarse) noexcept
        : run_(run)
        , coarse_(coarse)
        , x_(x >> 1)
        , between_((x & 1) != 0)
        , share_(1.0f / float(run.coarse_rows)) {}

    CAGEFORM_DETAIL_INLINE void add(const Vector& residual) noexcept {
        const Vector r = share_ * residual;
        if (between_) {
            add_between(r);
        } else {
            gathered_ = gathered_ + r;
        }
        between_ = !between_;
    }
    /// Adds the residual of the node after the next; the node between has no residual.
    CAGEFORM_DETAIL_INLINE void add_second(const Vector& residual) noexcept {
        const Vector r = share_ * residual;
        if (between_) {
            add_between(r);
        } else {
            give(r);
            ++x_;
        }
    }
    /// Writes the remaining sum to the last coarse node, if the run reaches it.
    void finish() const noexcept {
        if (2 * x_ <= run_.x + std::int32_t(run_.count)) give(gathered_);
    }

private:
    CAGEFORM_DETAIL_INLINE void add_between(const Vector& r) noexcept {
        const Vector half = Vector(0.5f) * r;
        give(gathered_ + half);
        gathered_ = half;
        ++x_;
    }
    CAGEFORM_DETAIL_INLINE void give(const Vector& r) const noexcept {
        for (std::uint32_t c = 0; c < run_.coarse_rows; ++c) {
            NodeRow& row = coarse_[run_.coarse[c] + std::uint32_t(x_)];
            (Vector::load(row) + r).store(row);
        }
    }

    const RegularRun<D>& run_;
    NodeRow* coarse_;
    std::int32_t x_; ///< the coarse node of the next residual, or the lower one of two
    bool between_;   ///< whether the next residual goes to two coarse nodes
    Vector share_;   ///< fraction of each coarse row
    Vector gathered_{0.0f};
};

/// Adds P · correction to u at the nodes of some rows; if `Set`, sets u to it.
template <bool Set, std::size_t D>
void prolong(const LevelFields<D>& fields, typename Level<D>::Range rows) noexcept {
    using Vector = Simd<float>;
    const auto add = [](NodeRow& row, const Vector& x) {
        if constexpr (Set) {
            x.store(row);
        } else {
            (Vector::load(row) + x).store(row);
        }
    };
    NodeRow* const u = fields.u;
    const NodeRow* const coarse = fields.coarser->u.data();
    for (const auto& run : fields.level.runs_of(rows)) {
        const std::uint32_t coarse_rows = run.coarse_rows;
        const auto from = run.coarse;
        const Vector share(1.0f / float(coarse_rows)), half(0.5f);
        const auto mean = [=](std::int32_t x) { // the mean of the coarse rows
            Vector sum = Vector::load(coarse[from[0] + std::uint32_t(x)]);
            for (std::uint32_t c = 1; c < coarse_rows; ++c)
                sum = sum + Vector::load(coarse[from[c] + std::uint32_t(x)]);
            return share * sum;
        };
        NodeRow* here = u + run.first;
        NodeRow* const end = here + run.count;
        std::int32_t x = run.x / 2;
        Vector left = mean(x);
        if ((run.x & 1) == 0) {
            add(*here, left);
            ++here;
        }
        for (; here < end; here += 2) { // an odd node and the even one after it
            const Vector right = mean(++x);
            add(here[0], half * (left + right));
            if (here + 1 < end) add(here[1], right);
            left = right;
        }
    }
    const auto irregular = fields.level.irregular_of(rows);
    for (std::size_t j = irregular.begin; j < irregular.end; ++j) {
        Vector sum(0.0f);
        for (const auto& entry : fields.level.interpolation_of(j))
            sum = sum + Vector(entry.weight) * Vector::load(coarse[entry.node]);
        add(u[fields.level.irregular[j].node], sum);
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail
