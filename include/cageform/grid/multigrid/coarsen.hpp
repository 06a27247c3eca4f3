// Makes the equations of the next coarser level by Dendy's black box multigrid (J. Comput. Phys. 48 (1982)).
//
// Every second node is a coarse node. The interpolation P is derived from the equations: a node between
// coarse nodes takes the value given by its own equation. This equation is first collapsed onto the line,
// face or cell of coarse nodes that contains the node. The coarse operator is the Galerkin product Pᵀ A P.
// Parts of the domain that are one node wide are preserved on every level.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/multigrid/equations.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>
#include <cageform/parallel/running.hpp>

#include <cmath>
#include <cstdlib>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The interpolation of a node from its coarse cell: a weight for each corner (`corner_offset`). The lower
/// corner of the cell is coarse node ⌊index / 2⌋. Along an axis with an even index, the upper corners have
/// weight 0.
template <std::size_t D>
using CornerWeights = std::array<double, power(2, D)>;

/// The interpolation P, and the equations of the coarse nodes.
template <std::size_t D>
struct Coarsening {
    using Index = typename grid::NodeRuns<D>::Index;

    std::vector<std::uint32_t> slot; ///< per node: index into `irregular`, or none for multilinear
    Buffer<CornerWeights<D>> irregular;
    Equations<D> coarse;

    bool is_irregular(std::uint32_t node) const noexcept { return slot[node] != grid::NodeRuns<D>::none; }
    const CornerWeights<D>& of(std::uint32_t node, const Index& index) const noexcept {
        if (is_irregular(node)) return irregular[slot[node]];
        std::size_t odd = 0;
        for (std::size_t k = 0; k < D; ++k) odd |= std::size_t(index[k] & 1) << k;
        return multilinear[odd];
    }
    /// Returns the index of a corner of a node's coarse cell.
    static Index corner_index(Index index, std::size_t corner) noexcept {
        for (auto& x : index) x >>= 1;
        return shifted<D>(index, corner_offset<D>(corner));
    }

private:
    /// The multilinear interpolation, indexed by the set of axes along which a node lies between coarse
    /// nodes.
    static constexpr auto multilinear = [] {
        std::array<CornerWeights<D>, power(2, D)> all{};
        for (std::size_t odd = 0; odd < all.size(); ++odd) {
            double weight = 1;
            for (std::size_t k = 0; k < D; ++k) weight *= ((odd >> k) & 1u) != 0 ? 0.5 : 1.0;
            for (std::size_t corner = 0; corner < all.size(); ++corner)
                all[odd][corner] = (corner & ~odd) == 0 ? weight : 0.0;
        }
        return all;
    }();
};

/// Returns the Galerkin stencil of a coarse node with regular surroundings.
template <std::size_t D>
typename Equations<D>::Stencil regular_coarse_stencil(const typename Equations<D>::Stencil& a) noexcept {
    using P = StencilPositions<D>;
    const auto multilinear = [](const typename P::Offset& from_coarse_node) {
        double weight = 1;
        for (const auto t : from_coarse_node) weight *= t == 0 ? 1.0 : t == 1 || t == -1 ? 0.5 : 0.0;
        return weight;
    };
    typename Equations<D>::Stencil coarse{};
    for (std::size_t f = 0; f < P::count; ++f) {
        for (std::size_t o = 0; o < P::count; ++o) {
            const auto neighbour = shifted<D>(P::offset(f), P::offset(o));
            for (std::size_t c = 0; c < P::count; ++c) {
                coarse[c] +=
                    multilinear(P::offset(f)) * a[o] * multilinear(shifted<D>(neighbour, P::offset(c), -2));
            }
        }
    }
    return coarse;
}

/// Makes a `Coarsening`: the coarse nodes, then P, then Pᵀ A P.
template <std::size_t D>
class Coarsener {
public:
    using P = StencilPositions<D>;
    using Index = typename grid::NodeRuns<D>::Index;
    static constexpr std::uint32_t none = grid::NodeRuns<D>::none;

    explicit Coarsener(const Equations<D>& fine, const Running& running = {})
        : fine_(fine)
        , running_(running) {
        choose_coarse_nodes();
        make_interpolation();
        make_galerkin_operator();
    }
    Coarsening<D> take() { return std::move(out_); }

private:
    static std::size_t slab_rows(const grid::NodeRuns<D>& nodes) noexcept {
        return nodes.rows() / std::size_t(nodes.size()[D - 1]);
    }
    /// Calls body(begin, end), possibly in parallel, for ranges of rows that consist of whole slabs and
    /// cover all rows.
    template <class Body>
    void for_slabs(const grid::NodeRuns<D>& nodes, const Body& body) const {
        constexpr std::size_t worth_a_thread = 4096; // nodes, which take about a millisecond
        if (nodes.rows() == 0) return;
        const std::size_t slabs = std::size_t(nodes.size()[D - 1]), rows = slab_rows(nodes);
        const std::size_t grain = slabs * worth_a_thread / (nodes.count() + 1) + 4;
        in_parallel(running_, slabs, (std::min)(grain, slabs),
                    [&](std::size_t begin, std::size_t end) { body(begin * rows, end * rows); });
    }

    void choose_coarse_nodes() {
        Index size = fine_.nodes.size();
        for (auto& n : size) n = (n + 1) / 2;
        grid::NodeRuns<D> coarse(size);
        for (std::size_t r = 0; r < coarse.rows(); ++r) {
            const Index row = coarse.row_index(r);
            const std::size_t fine_row = fine_.nodes.row(shifted<D>(row, row));
            for (auto* run = fine_.nodes.row_runs(fine_row); run != fine_.nodes.row_runs_end(fine_row); ++run)
                coarse.add_run((run->begin + 1) / 2, (run->end + 1) / 2);
            coarse.end_row();
        }
        out_.coarse.nodes = std::move(coarse);
    }

    // ---- interpolation --------------------------------------------------------------------------

    static std::size_t odd_axes(const Index& index) noexcept {
        std::size_t n = 0;
        for (const auto x : index) n += std::size_t(x & 1);
        return n;
    }
    /// Makes P for nodes on coarse lines first, then on faces, then in cells, because each depends on the
    /// previous ones. A node with regular surroundings keeps multilinear interpolation.
    void make_interpolation() {
        out_.slot.assign(fine_.nodes.count(), none);
        const auto is_near = near_irregular();
        std::uint32_t count = 0;
        fine_.nodes.for_each([&](const Index& index, std::uint32_t node) {
            const std::size_t odd = is_near[node] ? odd_axes(index) : 0;
            if (odd > 1 || (odd == 1 && fine_.is_irregular(node))) out_.slot[node] = count++;
        });
        out_.irregular.resize(count);
        for (std::size_t odd = 1; odd <= D; ++odd) {
            for_slabs(fine_.nodes, [&](std::size_t begin, std::size_t end) {
                Neighbours<D> around(fine_.nodes);
                fine_.nodes.for_each_of_rows(begin, end, [&](const Index& index, std::uint32_t node) {
                    if (!out_.is_irregular(node) || odd_axes(index) != odd) return;
                    around.move_to(index);
                    out_.irregular[out_.slot[node]] = interpolate(node, index, around);
                });
            });
        }
    }
    /// Returns the nodes with an irregular node among their 3^D neighbours. A missing neighbour always has
    /// an irregular node next to it.
    std::vector<bool> near_irregular() const {
        std::vector<bool> is_near(fine_.nodes.count());
        Neighbours<D> around(fine_.nodes);
        fine_.nodes.for_each([&](const Index& index, std::uint32_t node) {
            if (!fine_.is_irregular(node)) return;
            around.move_to(index);
            for (std::size_t p = 0; p < P::count; ++p) {
                const auto n = around.at(p);
                if (n != none) is_near[n] = true;
            }
        });
        return is_near;
    }
    /// Returns Dendy's interpolation: the node's own equation with b = 0, solved for the node. The equation
    /// is first collapsed onto the axes along which the node lies between coarse nodes.
    CornerWeights<D> interpolate(std::uint32_t node, const Index& index,
                                 Neighbours<D>& around) const noexcept {
        const auto collapsed = collapsed_equation(node, index);
        // Dendy's choice of the diagonal: the row sum and the sum of the neighbours' entries.
        double total = 0;
        for (std::size_t k = 0; k < D && fine_.is_irregular(node); ++k) {
            if ((index[k] & 1) != 0) total += fine_.irregular[fine_.slot[node]].row_sum[k];
        }
        for (const double a : collapsed) total += std::fabs(a);
        CornerWeights<D> result{};
        if (!(total > 0)) return result;
        for (std::size_t p = 0; p < P::count; ++p) {
            const auto n = collapsed[p] != 0 ? around.at(p) : none;
            if (n == none) continue;
            // Along each axis the neighbour's coarse cell begins where this cell begins or ends.
            std::size_t upper = 0;
            for (std::size_t k = 0; k < D; ++k) upper |= P::offset(p)[k] > 0 ? std::size_t{1} << k : 0u;
            const auto& from = out_.of(n, shifted<D>(index, P::offset(p)));
            for (std::size_t corner = 0; corner < from.size(); ++corner) {
                if (from[corner] != 0) result[corner | upper] += from[corner] * collapsed[p] / total;
            }
        }
        return result;
    }
    /// Returns the negated off-diagonal entries of A, summed along the axes with an even index.
    typename Equations<D>::Stencil collapsed_equation(std::uint32_t node, const Index& index) const noexcept {
        const auto& a = fine_.stencil(node);
        typename Equations<D>::Stencil collapsed{};
        for (std::size_t p = 0; p < P::count; ++p) {
            if (a[p] == 0) continue;
            auto o = P::offset(p);
            for (std::size_t k = 0; k < D; ++k) o[k] *= index[k] & 1;
            collapsed[P::position(o)] -= a[p];
        }
        collapsed[P::centre] = 0;
        return collapsed;
    }

    // ---- the coarse operator --------------------------------------------------------------------

    /// Makes Pᵀ A P. It is computed only for coarse nodes near irregular ones; the others share one stencil.
    void make_galerkin_operator() {
        auto& coarse = out_.coarse;
        coarse.regular = regular_coarse_stencil<D>(fine_.regular);
        choose_irregular();
        for_slabs(coarse.nodes, [&](std::size_t begin, std::size_t end) { add_to_coarse_rows(begin, end); });
        for (auto& equation : coarse.irregular) distribute_row_sum(equation);
    }
    /// Sums the equations of the coarse nodes in rows begin … end − 1, which are whole slabs. Contributions
    /// are added in the order of the fine nodes, so the result does not depend on the threads.
    void add_to_coarse_rows(std::size_t begin, std::size_t end) noexcept {
        auto& coarse = out_.coarse;
        const std::uint32_t first = coarse.nodes.first_of_row(begin), last = coarse.nodes.first_of_row(end);
        const std::size_t fine_slab = slab_rows(fine_.nodes), slab = slab_rows(coarse.nodes);
        const std::size_t low = 2 * (begin / slab), high = 2 * (end / slab); // slabs of fine nodes
        Neighbours<D> around(fine_.nodes), coarse_around(coarse.nodes);
        const auto add = [&](const Index& index, std::uint32_t node) {
            CoarseRows to{};
            const auto& weights = out_.of(node, index);
            coarse_around.move_to(out_.corner_index(index, 0));
            bool wanted = false;
            for (std::size_t corner = 0; corner < weights.size(); ++corner) {
                const auto n =
                    weights[corner] != 0 ? coarse_around.at(P::position(corner_offset<D>(corner))) : none;
                to[corner] = n != none && n >= first && n < last ? coarse.slot[n] : none;
                wanted = wanted || to[corner] != none;
            }
            if (!wanted) return;
            around.move_to(index);
            add_restricted(weights, row_of_ap(node, index, around), to);
        };
        fine_.nodes.for_each_of_rows(fine_slab * (low > 0 ? low - 1 : 0),
                                     (std::min)(fine_slab * high, fine_.nodes.rows()), add);
    }
    /// Selects the irregular coarse nodes: those with irregular interpolation within two fine nodes, or an
    /// irregular equation within one.
    void choose_irregular() {
        auto& coarse = out_.coarse;
        std::vector<bool> is_near(coarse.nodes.count());
        Neighbours<D> coarse_around(coarse.nodes);
        fine_.nodes.for_each([&](const Index& index, std::uint32_t node) {
            if (!fine_.is_irregular(node) && !out_.is_irregular(node)) return;
            coarse_around.move_to(out_.corner_index(index, 0));
            const std::int32_t reach = out_.is_irregular(node) ? 2 : 1;
            for (std::size_t p = 0; p < P::count; ++p) {
                bool within = true;
                for (std::size_t k = 0; k < D; ++k)
                    within = within && std::abs(2 * P::offset(p)[k] - (index[k] & 1)) <= reach;
                const auto n = within ? coarse_around.at(p) : none;
                if (n != none) is_near[n] = true;
            }
        });
        coarse.slot.assign(coarse.nodes.count(), none);
        for (std::uint32_t node = 0; node < coarse.nodes.count(); ++node) {
            if (!is_near[node]) continue;
            coarse.slot[node] = std::uint32_t(coarse.irregular.size());
            coarse.irregular.push_back({});
        }
    }
    /// Returns a node's row of A P, indexed by positions around the lower corner of its coarse cell.
    typename Equations<D>::Stencil row_of_ap(std::uint32_t node, const Index& index,
                                             Neighbours<D>& around) const noexcept {
        typename Equations<D>::Stencil row{};
        const auto& a = fine_.stencil(node);
        for (std::size_t p = 0; p < P::count; ++p) {
            const auto n = a[p] != 0 ? around.at(p) : none;
            if (n == none) continue;
            const auto at = shifted<D>(index, P::offset(p));
            const auto& from = out_.of(n, at);
            const std::size_t low =
                P::position(shifted<D>(out_.corner_index(at, 0), out_.corner_index(index, 0), -1));
            for (std::size_t corner = 0; corner < from.size(); ++corner) {
                if (from[corner] != 0) row[low + P::corner_step(corner)] += a[p] * from[corner];
            }
        }
        return row;
    }
    using CoarseRows = std::array<std::uint32_t, power(2, D)>; ///< into `coarse.irregular`, or none
    /// Adds a node's row of A P to the equations of the coarse nodes of its interpolation.
    void add_restricted(const CornerWeights<D>& weights, const typename Equations<D>::Stencil& row,
                        const CoarseRows& to) noexcept {
        std::array<std::size_t, P::count> positions;
        std::size_t count = 0;
        for (std::size_t p = 0; p < P::count; ++p) {
            positions[count] = p;
            count += row[p] != 0 ? 1 : 0;
        }
        for (std::size_t corner = 0; corner < to.size(); ++corner) {
            if (to[corner] == none) continue;
            auto* const stencil = out_.coarse.irregular[to[corner]].a.data();
            for (std::size_t n = 0; n < count; ++n)
                stencil[positions[n] - P::corner_step(corner)] += weights[corner] * row[positions[n]];
        }
    }
    /// Distributes the row sum in equal parts to the axes on which the node lacks a neighbour on one side.
    /// The row sum is the weight of the data in a node's equation.
    static void distribute_row_sum(typename Equations<D>::Irregular& equation) noexcept {
        const auto& a = equation.a;
        double row_sum = 0;
        for (const double entry : a) row_sum += entry;
        std::array<bool, D> misses{};
        std::size_t count = 0;
        for (std::size_t k = 0; k < D; ++k) {
            double down = 0, up = 0;
            for (std::size_t p = 0; p < P::count; ++p) {
                if (P::offset(p)[k] < 0) down += std::fabs(a[p]);
                if (P::offset(p)[k] > 0) up += std::fabs(a[p]);
            }
            // Regular neighbours on one side have at least a sixth of the diagonal; rounding errors are
            // 1e-15.
            misses[k] = std::fmin(down, up) < 1e-3 * a[P::centre];
            count += misses[k] ? 1 : 0;
        }
        for (std::size_t k = 0; k < D; ++k)
            equation.row_sum[k] = misses[k] ? std::fmax(row_sum, 0.0) / double(count) : 0.0;
    }

    const Equations<D>& fine_;
    const Running& running_;
    Coarsening<D> out_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
