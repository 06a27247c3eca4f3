// How the levels of the multigrid are made: coarse nodes, interpolation, Galerkin equations, and the order in which a
// level is walked.
#pragma once

#include <cageform/grid/node_runs.hpp>

#include <cmath>
#include <cstdlib>
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

    static constexpr Offset offset(std::size_t place) noexcept {
        Offset o{};
        for (std::size_t k = 0; k < D; ++k, place /= 3) o[k] = std::int32_t(place % 3) - 1;
        return o;
    }
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
};

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

/// How a node takes its value from the coarse grid.
template <std::size_t D>
struct Interpolation {
    std::uint32_t count = 0;
    std::array<std::uint32_t, power(2, D)> node{};
    std::array<double, power(2, D)> weight{};

    void add(std::uint32_t n, double w) noexcept {
        for (std::uint32_t i = 0; i < count; ++i) {
            if (node[i] == n) {
                weight[i] += w;
                return;
            }
        }
        CAGEFORM_ASSERT(count < node.size(), "a node lies in a cell of the coarse grid");
        node[count] = n;
        weight[count++] = w;
    }
};

/// Interpolation from every second node, and the equations there.
template <std::size_t D>
struct Coarsening {
    std::vector<std::uint32_t> slot; ///< #nodes: into `special`, or none: multilinear
    std::vector<Interpolation<D>> special;
    Equations<D> coarse;
};

template <std::size_t D>
Interpolation<D> multilinear(const NodeRuns<D>& coarse, const std::array<std::int32_t, D>& index) noexcept {
    Interpolation<D> p;
    for (std::size_t corner = 0; corner < power(2, D); ++corner) {
        auto place = index;
        double weight = 1;
        bool used = true;
        for (std::size_t k = 0; k < D; ++k) {
            const bool odd = (index[k] & 1) != 0;
            const bool up = ((corner >> k) & 1u) != 0;
            if (!odd && up) used = false;
            if (odd) weight *= 0.5;
            place[k] = (index[k] >> 1) + (up ? 1 : 0);
        }
        if (used) p.add(coarse.find(place), weight);
    }
    return p;
}

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
        fine_.nodes.for_each([&](const Index& index, std::uint32_t node) {
            if (fine_.slot[node] == none) return;
            for (std::size_t p = 0; p < P::count; ++p) {
                const auto n = fine_.nodes.find(shifted<D>(index, P::offset(p)));
                if (n != none) near[n] = true;
            }
        });
        return near;
    }
    Interpolation<D> interpolation_of(std::uint32_t node, const Index& index) const noexcept {
        return out_.slot[node] == none ? multilinear<D>(out_.coarse.nodes, index)
                                       : out_.special[out_.slot[node]];
    }

    /// Nodes on coarse lines first, then on faces, then in cells: each takes from those before.
    void interpolation() {
        out_.slot.assign(fine_.nodes.count(), none);
        const auto near = near_special();
        for (std::size_t odd = 1; odd <= D; ++odd) {
            fine_.nodes.for_each([&](const Index& index, std::uint32_t node) {
                if (odd_axes(index) != odd) return;
                if (fine_.slot[node] == none && (odd == 1 || !near[node])) return;
                auto special = between(node, index);
                out_.slot[node] = std::uint32_t(out_.special.size());
                out_.special.push_back(special);
            });
        }
    }
    /// The equation of the node itself, collapsed onto the axes along which it lies between coarse nodes.
    Interpolation<D> between(std::uint32_t node, const Index& index) const noexcept {
        const auto& a = fine_.stencil(node);
        std::array<double, P::count> collapsed{};
        for (std::size_t p = 0; p < P::count; ++p) {
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
        Interpolation<D> result;
        if (!(total > 0)) return result;
        for (std::size_t p = 0; p < P::count; ++p) {
            if (p == P::centre || collapsed[p] == 0) continue;
            const auto at = shifted<D>(index, P::offset(p));
            const auto n = fine_.nodes.find(at);
            if (n == none) continue;
            const auto from = interpolation_of(n, at);
            for (std::uint32_t i = 0; i < from.count; ++i)
                result.add(from.node[i], from.weight[i] * collapsed[p] / total);
        }
        return result;
    }

    /// Pᵀ A P; only near what is special it has to be worked out.
    void equations() {
        auto& coarse = out_.coarse;
        coarse.regular = regular_coarse_stencil<D>(fine_.regular);
        coarse.slot.assign(coarse.nodes.count(), none);
        const auto touched = touched_coarse_nodes();
        coarse.nodes.for_each([&](const Index& index, std::uint32_t node) {
            if (!touched[node]) return;
            coarse.slot[node] = std::uint32_t(coarse.special.size());
            coarse.special.push_back(galerkin(index, node));
        });
    }
    /// Coarse nodes with something special within two fine nodes.
    std::vector<bool> touched_coarse_nodes() const {
        std::vector<bool> touched(out_.coarse.nodes.count());
        fine_.nodes.for_each([&](const Index& index, std::uint32_t node) {
            if (fine_.slot[node] == none && out_.slot[node] == none) return;
            for (std::size_t p = 0; p < P::count; ++p) {
                Index at{};
                bool close = true;
                for (std::size_t k = 0; k < D; ++k) {
                    at[k] = (index[k] >> 1) + P::offset(p)[k];
                    close = close && std::abs(2 * at[k] - index[k]) <= 2;
                }
                const auto n = close ? out_.coarse.nodes.find(at) : none;
                if (n != none) touched[n] = true;
            }
        });
        return touched;
    }
    typename Equations<D>::Special galerkin(const Index& coarse, std::uint32_t number) const {
        typename Equations<D>::Special result;
        Index at = coarse;
        for (auto& x : at) x *= 2;
        std::array<std::uint32_t, P::count> around{};
        for (std::size_t p = 0; p < P::count; ++p)
            around[p] = out_.coarse.nodes.find(shifted<D>(coarse, P::offset(p)));
        for (std::size_t p = 0; p < P::count; ++p) {
            const auto f_index = shifted<D>(at, P::offset(p));
            const auto f = fine_.nodes.find(f_index);
            if (f == none) continue;
            const auto pf = interpolation_of(f, f_index);
            double wf = 0;
            for (std::uint32_t i = 0; i < pf.count; ++i) wf += pf.node[i] == number ? pf.weight[i] : 0.0;
            if (wf == 0) continue;
            const auto& a = fine_.stencil(f);
            for (std::size_t q = 0; q < P::count; ++q) {
                if (a[q] == 0) continue;
                const auto g_index = shifted<D>(f_index, P::offset(q));
                const auto g = fine_.nodes.find(g_index);
                if (g == none) continue;
                const auto pg = interpolation_of(g, g_index);
                for (std::uint32_t i = 0; i < pg.count; ++i) {
                    for (std::size_t j = 0; j < P::count; ++j) {
                        if (around[j] == pg.node[i]) {
                            result.a[j] += wf * a[q] * pg.weight[i];
                            break;
                        }
                    }
                }
            }
        }
        share_out_pull(result);
        return result;
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
        double weight;
    };
    /// A node outside the stretches.
    struct Odd {
        std::uint32_t node;
        std::uint32_t stencil_end; ///< in `entries`; begins where the one before ends
        std::uint32_t coarse_end;  ///< in `from_coarse`
        double diagonal, inverse;
        double pull; ///< the sum of its row of A: what draws it to the data
    };
    struct Slab { ///< of constant index along the last axis
        std::uint32_t stretches_end, odd_end;
    };

    std::uint32_t count = 0;
    double diagonal = 1;                     ///< of the regular stencil
    std::array<double, D + 1> by_distance{}; ///< minus its other entries, by the number of axes off centre
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

/// `sources` marks nodes that take a right-hand side of their own although their stencil is regular.
template <std::size_t D>
Level<D> make_level(const Equations<D>& e, const Coarsening<D>* coarsening, const std::vector<bool>& sources,
                    bool finest) {
    using P = Places<D>;
    using Index = typename NodeRuns<D>::Index;
    constexpr auto none = NodeRuns<D>::none;
    Level<D> level;
    level.count = e.nodes.count();
    level.diagonal = e.regular[P::centre];
    for (std::size_t p = 0; p < P::count; ++p) level.by_distance[P::distance(p)] = -e.regular[p];

    std::size_t row = 0;
    const std::size_t rows = e.nodes.rows();
    const std::size_t slab_rows = D == 1 ? 1 : rows / std::size_t(e.nodes.size()[D - 1]);
    const auto start_stretch = [&](const Index& index, std::uint32_t node) {
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
            const auto n = e.nodes.find(shifted<D>(index, P::offset(3 * r + 1)));
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
                const bool plain = e.slot[node] == none &&
                                   (coarsening == nullptr || coarsening->slot[node] == none) &&
                                   (sources.empty() || !sources[node]);
                if (plain) {
                    if (!open) start_stretch(index, node);
                    ++level.stretches.back().count;
                    open = true;
                    continue;
                }
                open = false;
                const auto& a = e.stencil(node);
                double pull = 0;
                for (std::size_t p = 0; p < P::count; ++p) {
                    pull += a[p];
                    if (p == P::centre || a[p] == 0) continue;
                    const auto n = e.nodes.find(shifted<D>(index, P::offset(p)));
                    if (n != none) level.entries.push_back({n, -a[p]});
                }
                // Filled up with entries of no weight: to equal lengths on the finest level, to even ones else.
                while (finest ? level.entries.size() % (2 * D) != 0 ||
                                    level.entries.size() == 2 * D * level.odd.size()
                              : level.entries.size() % 2 != 0)
                    level.entries.push_back({node, 0.0});
                if (coarsening != nullptr) {
                    const auto from = coarsening->slot[node] == none
                                          ? multilinear<D>(coarsening->coarse.nodes, index)
                                          : coarsening->special[coarsening->slot[node]];
                    for (std::uint32_t i = 0; i < from.count; ++i)
                        level.from_coarse.push_back({from.node[i], from.weight[i]});
                }
                level.odd.push_back({node, std::uint32_t(level.entries.size()),
                                     std::uint32_t(level.from_coarse.size()), a[P::centre], 1 / a[P::centre],
                                     pull});
            }
        }
        if ((row + 1) % slab_rows == 0)
            level.slabs.push_back({std::uint32_t(level.stretches.size()), std::uint32_t(level.odd.size())});
    }
    return level;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
