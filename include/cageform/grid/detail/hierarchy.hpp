// How the levels of the multigrid are made: coarse nodes, interpolation, Galerkin equations, and the order in which a
// level is walked.
#pragma once

#include <cageform/grid/node_runs.hpp>

#include <cmath>
#include <cstdlib>
#include <optional>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// A link of the lattice that ends on given data before it reaches the neighbouring node.
struct CutLink {
    std::uint32_t node;     ///< number of the unknown
    std::uint8_t direction; ///< 2·axis, + 1 towards larger indices
    double weight;          ///< 1/θ, θ in (0, 1] the part of the link up to the data
};

namespace detail {

constexpr std::size_t power(std::size_t base, std::size_t exponent) noexcept {
    std::size_t p = 1;
    while (exponent-- > 0) p *= base;
    return p;
}

/// The 3^D places of a stencil, axis 0 fastest.
template <std::size_t D>
struct Places {
    static constexpr std::size_t count = power(3, D);
    static constexpr std::size_t centre = count / 2;
    using Offset = std::array<std::int32_t, D>;

    static constexpr const Offset& offset(std::size_t place) noexcept { return offsets[place]; }
    static constexpr std::size_t place(const Offset& o) noexcept {
        std::size_t n = 0;
        for (std::size_t k = D; k-- > 0;) n = 3 * n + std::size_t(o[k] + 1);
        return n;
    }
    /// Number of axes along which a place is off centre.
    static constexpr std::size_t distance(std::size_t place) noexcept {
        std::size_t n = 0;
        for (const auto o : offset(place)) n += o != 0 ? 1 : 0;
        return n;
    }

private:
    static constexpr std::array<Offset, count> offsets = [] {
        std::array<Offset, count> all{};
        for (std::size_t p = 0; p < count; ++p) {
            for (std::size_t k = 0, rest = p; k < D; ++k, rest /= 3) all[p][k] = std::int32_t(rest % 3) - 1;
        }
        return all;
    }();
};

/// The place of a corner of the cell above a node; bit k: the upper end along axis k.
template <std::size_t D>
constexpr std::size_t corner_place(std::size_t corner) noexcept {
    typename Places<D>::Offset o{};
    for (std::size_t k = 0; k < D; ++k) o[k] = std::int32_t((corner >> k) & 1u);
    return Places<D>::place(o);
}

template <std::size_t D>
constexpr std::array<std::int32_t, D> shifted(std::array<std::int32_t, D> index,
                                              const std::array<std::int32_t, D>& by) noexcept {
    for (std::size_t k = 0; k < D; ++k) index[k] += by[k];
    return index;
}

/// The equations of one level while the hierarchy is built.
template <std::size_t D>
struct Equations {
    using Stencil = std::array<double, Places<D>::count>; ///< of A, the diagonal at the centre
    struct Special {                                      ///< a node whose stencil is not `regular`
        Stencil a{};
        std::array<double, D> pull{}; ///< what draws it to boundary data, along each axis
    };

    NodeRuns<D> nodes;
    Stencil regular{};
    std::vector<std::uint32_t> slot; ///< #nodes: into `special`, or none
    std::vector<Special> special;

    const Stencil& stencil(std::uint32_t node) const noexcept {
        return slot[node] == NodeRuns<D>::none ? regular : special[slot[node]].a;
    }
};

/// How a node takes its value from the coarse grid: the weight of each corner of the coarse cell it lies in. Bit k of
/// a corner's number: the upper end along axis k. A node that has an even index along an axis lies at the lower end.
template <std::size_t D>
using Interpolation = std::array<double, power(2, D)>;

/// Interpolation from every second node, and the equations there.
template <std::size_t D>
struct Coarsening {
    std::vector<std::uint32_t> slot; ///< #nodes: into `special`, or none: multilinear
    std::vector<Interpolation<D>> special;
    Equations<D> coarse;

    const Interpolation<D>& of(std::uint32_t node, const std::array<std::int32_t, D>& index) const noexcept {
        if (slot[node] != NodeRuns<D>::none) return special[slot[node]];
        std::size_t odd = 0;
        for (std::size_t k = 0; k < D; ++k) odd |= std::size_t(index[k] & 1) << k;
        return multilinear[odd];
    }
    /// The index of a corner of the coarse cell of a node.
    static std::array<std::int32_t, D> corner_index(std::array<std::int32_t, D> index,
                                                    std::size_t corner) noexcept {
        for (std::size_t k = 0; k < D; ++k) index[k] = (index[k] >> 1) + std::int32_t((corner >> k) & 1u);
        return index;
    }

private:
    /// By the axes along which a node lies between coarse ones.
    static constexpr auto multilinear = [] {
        std::array<Interpolation<D>, power(2, D)> all{};
        for (std::size_t odd = 0; odd < all.size(); ++odd) {
            for (std::size_t corner = 0; corner < all.size(); ++corner) {
                if ((corner & ~odd) != 0) continue;
                double weight = 1;
                for (std::size_t k = 0; k < D; ++k) weight *= ((odd >> k) & 1u) != 0 ? 0.5 : 1.0;
                all[odd][corner] = weight;
            }
        }
        return all;
    }();
};

template <std::size_t D>
Equations<D> finest_equations(const NodeRuns<D>& nodes, std::span<const CutLink> cuts) {
    Equations<D> e;
    e.nodes = nodes;
    e.regular[Places<D>::centre] = 2.0 * double(D);
    for (std::size_t p = 0; p < Places<D>::count; ++p) {
        if (Places<D>::distance(p) == 1) e.regular[p] = -1;
    }
    e.slot.assign(nodes.count(), NodeRuns<D>::none);
    for (const CutLink& cut : cuts) {
        auto& slot = e.slot[cut.node];
        if (slot == NodeRuns<D>::none) {
            slot = std::uint32_t(e.special.size());
            e.special.push_back({e.regular, {}});
        }
        auto& special = e.special[slot];
        typename Places<D>::Offset o{};
        o[cut.direction / 2] = (cut.direction & 1) != 0 ? 1 : -1;
        CAGEFORM_ASSERT(special.a[Places<D>::place(o)] != 0, "a link is cut once");
        special.a[Places<D>::place(o)] = 0;
        special.a[Places<D>::centre] += cut.weight - 1;
        special.pull[cut.direction / 2] += cut.weight;
    }
    return e;
}

/// Galerkin's coarse stencil where nothing is special.
template <std::size_t D>
typename Equations<D>::Stencil regular_coarse_stencil(const typename Equations<D>::Stencil& a) noexcept {
    using P = Places<D>;
    typename Equations<D>::Stencil coarse{};
    const auto hat = [](std::int32_t t) { return t == 0 ? 1.0 : t == 1 || t == -1 ? 0.5 : 0.0; };
    for (std::size_t f = 0; f < P::count; ++f) {
        double wf = 1;
        for (const auto t : P::offset(f)) wf *= hat(t);
        for (std::size_t o = 0; o < P::count; ++o) {
            const auto g = shifted<D>(P::offset(f), P::offset(o));
            for (std::size_t j = 0; j < P::count; ++j) {
                double wg = 1;
                for (std::size_t k = 0; k < D; ++k) wg *= hat(g[k] - 2 * P::offset(j)[k]);
                coarse[j] += wf * a[o] * wg;
            }
        }
    }
    return coarse;
}

template <std::size_t D>
class Coarsener {
public:
    using P = Places<D>;
    using Index = typename NodeRuns<D>::Index;
    static constexpr std::uint32_t none = NodeRuns<D>::none;

    explicit Coarsener(const Equations<D>& fine)
        : fine_(fine) {
        coarse_nodes();
        interpolation();
        equations();
    }
    Coarsening<D> take() { return std::move(out_); }

private:
    void coarse_nodes() {
        Index size{};
        for (std::size_t k = 0; k < D; ++k) size[k] = (fine_.nodes.size()[k] + 1) / 2;
        NodeRuns<D> coarse(size);
        for (std::size_t r = 0; r < coarse.rows(); ++r) {
            Index row = coarse.row_index(r);
            for (std::size_t k = 1; k < D; ++k) row[k] *= 2;
            const std::size_t fine_row = fine_.nodes.row(row);
            for (auto* run = fine_.nodes.row_runs(fine_row); run != fine_.nodes.row_runs_end(fine_row); ++run)
                coarse.add_run((run->begin + 1) / 2, (run->end + 1) / 2);
            coarse.end_row();
        }
        out_.coarse.nodes = std::move(coarse);
    }

    static std::size_t odd_axes(const Index& index) noexcept {
        std::size_t n = 0;
        for (const auto x : index) n += std::size_t(x & 1);
        return n;
    }
    /// Which nodes have a special one among their 3^D. Where a neighbour is missing some other is special.
    std::vector<bool> near_special() const {
        std::vector<bool> near(fine_.nodes.count());
        Neighbours<D> around(fine_.nodes);
        fine_.nodes.for_each([&](const Index& index, std::uint32_t node) {
            if (fine_.slot[node] == none) return;
            around.move_to(index);
            for (std::size_t p = 0; p < P::count; ++p) {
                const auto n = around.at(p);
                if (n != none) near[n] = true;
            }
        });
        return near;
    }
    /// Nodes on coarse lines first, then on faces, then in cells: each takes from those before.
    void interpolation() {
        out_.slot.assign(fine_.nodes.count(), none);
        const auto near = near_special();
        for (std::size_t odd = 1; odd <= D; ++odd) {
            Neighbours<D> around(fine_.nodes);
            fine_.nodes.for_each([&](const Index& index, std::uint32_t node) {
                if (!near[node] || odd_axes(index) != odd) return;
                if (fine_.slot[node] == none && odd == 1) return;
                around.move_to(index);
                auto special = between(node, index, around);
                out_.slot[node] = std::uint32_t(out_.special.size());
                out_.special.push_back(special);
            });
        }
    }
    /// The equation of the node itself, collapsed onto the axes along which it lies between coarse nodes.
    Interpolation<D> between(std::uint32_t node, const Index& index, Neighbours<D>& around) const noexcept {
        const auto& a = fine_.stencil(node);
        std::array<double, P::count> collapsed{};
        for (std::size_t p = 0; p < P::count; ++p) {
            if (a[p] == 0) continue;
            auto o = P::offset(p);
            for (std::size_t k = 0; k < D; ++k) o[k] *= index[k] & 1;
            collapsed[P::place(o)] -= a[p];
        }
        double total = 0;
        if (fine_.slot[node] != none) {
            for (std::size_t k = 0; k < D; ++k) {
                if ((index[k] & 1) != 0) total += fine_.special[fine_.slot[node]].pull[k];
            }
        }
        for (std::size_t p = 0; p < P::count; ++p) {
            if (p != P::centre) total += std::fabs(collapsed[p]);
        }
        Interpolation<D> result{};
        if (!(total > 0)) return result;
        for (std::size_t p = 0; p < P::count; ++p) {
            if (p == P::centre || collapsed[p] == 0) continue;
            const auto n = around.at(p);
            if (n == none) continue;
            // Its cell's lower corner is ours, but for the axes along which it is our upper corner.
            std::size_t up = 0;
            for (std::size_t k = 0; k < D; ++k) up |= P::offset(p)[k] > 0 ? std::size_t{1} << k : 0u;
            const auto& from = out_.of(n, shifted<D>(index, P::offset(p)));
            for (std::size_t corner = 0; corner < from.size(); ++corner) {
                if (from[corner] != 0) result[corner | up] += from[corner] * collapsed[p] / total;
            }
        }
        return result;
    }

    /// Pᵀ A P; only near what is special it has to be worked out.
    void equations() {
        auto& coarse = out_.coarse;
        coarse.regular = regular_coarse_stencil<D>(fine_.regular);
        coarse.slot.assign(coarse.nodes.count(), none);
        const auto close = close_to_special();
        coarse.nodes.for_each([&](const Index&, std::uint32_t node) {
            if (!close[node]) return;
            coarse.slot[node] = std::uint32_t(coarse.special.size());
            coarse.special.push_back({});
        });
        Neighbours<D> around(fine_.nodes), coarse_around(coarse.nodes);
        fine_.nodes.for_each([&](const Index& index, std::uint32_t node) {
            std::array<std::uint32_t, power(2, D)> to{};
            const auto& own = out_.of(node, index);
            coarse_around.move_to(out_.corner_index(index, 0));
            bool wanted = false;
            for (std::size_t corner = 0; corner < own.size(); ++corner) {
                to[corner] = none;
                if (own[corner] == 0) continue;
                const auto n = coarse_around.at(corner_place<D>(corner));
                if (n != none) to[corner] = coarse.slot[n];
                wanted = wanted || to[corner] != none;
            }
            if (!wanted) return;
            around.move_to(index);
            add_row(node, index, own, to, around);
        });
        for (auto& special : coarse.special) share_out_pull(special);
    }
    /// Coarse nodes with special interpolation within two fine nodes or a special equation within one.
    std::vector<bool> close_to_special() const {
        std::vector<bool> close(out_.coarse.nodes.count());
        Neighbours<D> coarse_around(out_.coarse.nodes);
        fine_.nodes.for_each([&](const Index& index, std::uint32_t node) {
            if (fine_.slot[node] == none && out_.slot[node] == none) return;
            coarse_around.move_to(out_.corner_index(index, 0));
            const std::int32_t reach = out_.slot[node] == none ? 1 : 2;
            for (std::size_t p = 0; p < P::count; ++p) {
                bool near = true;
                for (std::size_t k = 0; k < D; ++k)
                    near = near && std::abs(2 * ((index[k] >> 1) + P::offset(p)[k]) - index[k]) <= reach;
                const auto n = near ? coarse_around.at(p) : none;
                if (n != none) close[n] = true;
            }
        });
        return close;
    }
    /// The row of A P of a fine node, given to the coarse nodes it interpolates from.
    void add_row(std::uint32_t node, const Index& index, const Interpolation<D>& own,
                 const std::array<std::uint32_t, power(2, D)>& to, Neighbours<D>& around) {
        std::array<double, P::count> row{}; // places from the lower corner of the node's coarse cell
        const auto& a = fine_.stencil(node);
        for (std::size_t q = 0; q < P::count; ++q) {
            if (a[q] == 0) continue;
            const auto at = shifted<D>(index, P::offset(q));
            const auto n = q == P::centre ? node : around.at(q);
            if (n == none) continue;
            const auto& from = out_.of(n, at);
            for (std::size_t corner = 0; corner < from.size(); ++corner) {
                if (from[corner] != 0)
                    row[place_from(index, out_.corner_index(at, corner))] += a[q] * from[corner];
            }
        }
        for (std::size_t corner = 0; corner < to.size(); ++corner) {
            if (to[corner] == none) continue;
            auto& stencil = out_.coarse.special[to[corner]].a;
            for (std::size_t p = 0; p < P::count; ++p) {
                if (row[p] == 0) continue;
                auto o = P::offset(p);
                for (std::size_t k = 0; k < D; ++k) o[k] -= std::int32_t((corner >> k) & 1u);
                stencil[P::place(o)] += own[corner] * row[p];
            }
        }
    }
    static std::size_t place_from(const Index& index, Index coarse) noexcept {
        for (std::size_t k = 0; k < D; ++k) coarse[k] -= index[k] >> 1;
        return P::place(coarse);
    }
    /// What is left of a row's sum draws to the boundary; it is laid along the axes that miss a neighbour.
    static void share_out_pull(typename Equations<D>::Special& s) noexcept {
        double left = 0;
        for (const double a : s.a) left += a;
        std::array<bool, D> misses{};
        std::size_t count = 0;
        for (std::size_t k = 0; k < D; ++k) {
            double down = 0, up = 0;
            for (std::size_t p = 0; p < P::count; ++p) {
                if (P::offset(p)[k] < 0) down += std::fabs(s.a[p]);
                if (P::offset(p)[k] > 0) up += std::fabs(s.a[p]);
            }
            misses[k] = std::fmin(down, up) < 1e-3 * s.a[P::centre];
            count += misses[k] ? 1 : 0;
        }
        for (std::size_t k = 0; k < D; ++k)
            s.pull[k] = misses[k] ? std::fmax(left, 0.0) / double(count) : 0.0;
    }

    const Equations<D>& fine_;
    Coarsening<D> out_;
};

/// Equal stretches of a row, as the relaxation walks them: a stretch has `count` nodes with the regular stencil
/// and interpolation; nodes of the neighbouring rows, fine and coarse, lie at constant distances.
template <std::size_t D>
struct Stretch {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    std::int32_t x = 0;                                  ///< index of the first node along axis 0
    std::uint32_t odd = 0;                               ///< bit k: the row's index along axis k + 1 is odd
    bool odd_sum = false;                                ///< of the row's indices
    std::array<std::int32_t, power(3, D - 1)> row{};     ///< from a node to the same x of a neighbouring row
    std::array<std::uint32_t, power(2, D - 1)> coarse{}; ///< number of coarse node X = coarse + X
    std::uint32_t coarse_rows = 0;
};

/// One level as the cycles use it.
template <std::size_t D>
struct Level {
    struct Entry {
        std::uint32_t node;
        float weight;
    };
    /// A node outside the stretches.
    struct Odd {
        std::uint32_t node;
        std::uint32_t stencil_end; ///< in `entries`; begins where the one before ends
        std::uint32_t coarse_end;  ///< in `from_coarse`
        double diagonal;
        float inverse;
        float pull; ///< the sum of its row of A: what draws it to the data
    };
    struct Slab { ///< of constant index along the last axis
        std::uint32_t stretches_end, odd_end;
    };

    std::uint32_t count = 0;
    float diagonal = 1;                     ///< of the regular stencil
    std::array<float, D + 1> by_distance{}; ///< minus its other entries, by the number of axes off centre
    std::vector<Slab> slabs;
    std::vector<Stretch<D>> stretches;
    std::vector<Odd> odd;
    std::vector<Entry> entries;     ///< minus the off-diagonal entries of A
    std::vector<Entry> from_coarse; ///< interpolation

    std::size_t bytes() const noexcept {
        return slabs.capacity() * sizeof(Slab) + stretches.capacity() * sizeof(Stretch<D>) +
               odd.capacity() * sizeof(Odd) + (entries.capacity() + from_coarse.capacity()) * sizeof(Entry);
    }
};

template <std::size_t D>
Level<D> make_level(const Equations<D>& e, const Coarsening<D>* coarsening, bool finest) {
    using P = Places<D>;
    using Index = typename NodeRuns<D>::Index;
    constexpr auto none = NodeRuns<D>::none;
    Level<D> level;
    level.count = e.nodes.count();
    level.diagonal = float(e.regular[P::centre]);
    for (std::size_t p = 0; p < P::count; ++p) level.by_distance[P::distance(p)] = -float(e.regular[p]);

    std::size_t row = 0;
    const std::size_t rows = e.nodes.rows();
    const std::size_t slab_rows = D == 1 ? 1 : rows / std::size_t(e.nodes.size()[D - 1]);
    Neighbours<D> around(e.nodes);
    std::optional<Neighbours<D>> coarse_around;
    if (coarsening != nullptr) coarse_around.emplace(coarsening->coarse.nodes);
    const auto start_stretch = [&](const Index& index, std::uint32_t node) {
        around.move_to(index);
        Stretch<D> s;
        s.first = node;
        s.x = index[0];
        std::int32_t sum = 0;
        for (std::size_t k = 1; k < D; ++k) {
            s.odd |= std::uint32_t(index[k] & 1) << (k - 1);
            sum += index[k];
        }
        s.odd_sum = (sum & 1) != 0;
        for (std::size_t r = 0; r < s.row.size(); ++r) {
            const auto n = around.at(3 * r + 1);
            s.row[r] = n == none ? 0 : std::int32_t(n - node);
        }
        if (coarsening != nullptr) {
            const std::int32_t x = (index[0] + 1) / 2; // a coarse node that all of the stretch's rows have
            for (std::size_t corner = 0; corner < s.coarse.size(); ++corner) {
                if ((corner & ~std::size_t(s.odd)) != 0) continue;
                Index at{};
                at[0] = x;
                for (std::size_t k = 1; k < D; ++k)
                    at[k] = (index[k] >> 1) + std::int32_t((corner >> (k - 1)) & 1u);
                const auto n = coarsening->coarse.nodes.find(at);
                CAGEFORM_ASSERT(n != none, "regular interpolation takes from all coarse nodes around");
                s.coarse[s.coarse_rows++] = n - std::uint32_t(x);
            }
        }
        level.stretches.push_back(s);
    };
    for (; row < rows; ++row) {
        Index index = e.nodes.row_index(row);
        for (const auto* run = e.nodes.row_runs(row); run != e.nodes.row_runs_end(row); ++run) {
            bool open = false;
            for (std::int32_t x = run->begin; x < run->end; ++x) {
                const std::uint32_t node = run->first + std::uint32_t(x - run->begin);
                index[0] = x;
                const bool plain =
                    e.slot[node] == none && (coarsening == nullptr || coarsening->slot[node] == none);
                if (plain) {
                    if (!open) start_stretch(index, node);
                    ++level.stretches.back().count;
                    open = true;
                    continue;
                }
                open = false;
                around.move_to(index);
                const auto& a = e.stencil(node);
                double pull = 0;
                for (std::size_t p = 0; p < P::count; ++p) {
                    pull += a[p];
                    if (p == P::centre || a[p] == 0) continue;
                    const auto n = around.at(p);
                    if (n != none) level.entries.push_back({n, -float(a[p])});
                }
                // Filled up with entries of no weight: to equal lengths on the finest level, else to even ones.
                while (finest ? level.entries.size() % (2 * D) != 0 ||
                                    level.entries.size() == 2 * D * level.odd.size()
                              : level.entries.size() % 2 != 0)
                    level.entries.push_back({node, 0.0f});
                if (coarsening != nullptr) {
                    const auto& from = coarsening->of(node, index);
                    coarse_around->move_to(coarsening->corner_index(index, 0));
                    std::uint32_t n = 0;
                    for (std::size_t corner = 0; corner < from.size(); ++corner) {
                        if (from[corner] == 0) continue;
                        n = coarse_around->at(corner_place<D>(corner));
                        level.from_coarse.push_back({n, float(from[corner])});
                    }
                    while (level.from_coarse.size() % 2 != 0) level.from_coarse.push_back({n, 0.0f});
                }
                level.odd.push_back({node, std::uint32_t(level.entries.size()),
                                     std::uint32_t(level.from_coarse.size()), a[P::centre],
                                     float(1 / a[P::centre]), float(pull)});
            }
        }
        if ((row + 1) % slab_rows == 0)
            level.slabs.push_back({std::uint32_t(level.stretches.size()), std::uint32_t(level.odd.size())});
    }
    return level;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
