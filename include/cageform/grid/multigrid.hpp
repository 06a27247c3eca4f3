// The Laplace equation on the nodes of a lattice, solved for sixteen right-hand sides at once.
//
// Dirichlet data enters through cut links (CutLink): where it lies is known to the node. Coarse grids are
// every second node, with interpolation built from the equations and Galerkin operators, so that walls, slits and
// legs of one node's width stay what they are on every level (Dendy, Black box multigrid, J. Comput. Phys. 48
// (1982); in 2D and 3D the same code here). The finest level is relaxed in red-black order, its residual and the
// way to the coarse grid done in the same pass over memory; the way back likewise.
//
// Cycles work in float, a row of sixteen functions a cache line. Every second cycle begins by putting
// the solution so far aside and computing its residual in double; the cycles go on with the rest (iterative refinement;
// Wilkinson, Rounding Errors in Algebraic Processes (1963), ch. 3), so that the sum is right to the digits of double.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/grid/detail/hierarchy.hpp>

#include <Eigen/Cholesky>

#include <limits>

namespace cageform::inline CAGEFORM_ABI {

/// The hierarchy for one set of unknowns; serves any number of right-hand sides and threads.
template <std::size_t D>
class Multigrid {
public:
    static constexpr std::size_t width = lane_count<float>; ///< right-hand sides solved together
    using Values = std::array<double, width>;               ///< one number for each of them
    using Row = Lanes<float>;

    /// What one block of right-hand sides needs. `source` is the caller's to write, between cycles too.
    struct Block {
        /// The solution at a node.
        Values value(std::uint32_t node) const noexcept {
            if constexpr (D == 1) return exact_[node];
            Values v;
            for (std::size_t k = 0; k < width; ++k) v[k] = double(fields_[0].u[node][k]);
            if (settled_.empty()) return v;
            for (std::size_t k = 0; k < width; ++k) v[k] += double(settled_[node][k]);
            if (remainder_.empty()) return v;
            for (std::size_t k = 0; k < width; ++k) v[k] += double(remainder_[node][k]);
            return v;
        }
        bool empty() const noexcept { return fields_.empty() && exact_.empty(); }

        /// Whether the error is known in double: until then, the second cycle, the bound is one only up to what float
        /// rounds.
        bool is_refined() const noexcept { return refined_; }
        std::size_t bytes() const noexcept {
            std::size_t rows = settled_.capacity() + remainder_.capacity() + odd_source_.capacity();
            for (const auto& level : fields_) rows += level.u.capacity() + level.b.capacity();
            return rows * sizeof(Row) +
                   (source.capacity() + settled_part_.capacity() + exact_.capacity()) * sizeof(Values);
        }

    private:
        friend class Multigrid;
        struct Fields {
            std::vector<Row> u, b;
        };
        Row gain_;                             ///< error per residual, as the cycles so far showed
        Row residual_;                         ///< largest, after the last cycle
        std::vector<Values> exact_;            ///< in one dimension all there is
        std::vector<Fields> fields_;           ///< a level each
        std::vector<Row> settled_, remainder_; ///< the part put aside: together twice float's digits
        std::vector<Values> settled_part_;     ///< what of `source` it takes up
        std::vector<Row> odd_source_;          ///< the rest
        std::size_t cycles_ = 0;

    public:
        std::vector<Values> source; ///< right-hand sides of the nodes that may have one (`source_node`)

    private:
        bool refined_ = false; ///< the finest level has a right-hand side everywhere
        bool blank_ = true;    ///< the finest level's u is zero, whatever it holds
    };

    /// cuts     every link of an unknown that does not end on an unknown
    /// sources  further nodes that take a right-hand side of their own
    Multigrid(const NodeRuns<D>& nodes, std::span<const CutLink> cuts,
              std::span<const std::uint32_t> sources) {
        // ∇²(−|x|²/2D) = −1: over a ball of radius R about the data the error is at most R²/2D residuals.
        double squares = 0;
        for (const auto n : nodes.size()) squares += 0.25 * (double(n) + 1) * (double(n) + 1);
        reach_ = squares / (2.0 * double(D));
        auto equations = detail::finest_equations<D>(nodes, cuts);
        if constexpr (D == 1) { // no hierarchy: the equations are tridiagonal
            levels_.push_back(detail::make_level<D>(equations, nullptr, true));
            eliminate(equations);
            find_inner_sources(nodes, sources);
            return;
        }
        for (;;) {
            constexpr std::uint32_t direct = 160; // unknowns solved at once at the bottom
            const std::uint32_t count = equations.nodes.count();
            if (count > direct) {
                auto coarsening = detail::Coarsener<D>(equations).take();
                if (coarsening.coarse.nodes.count() > 0) {
                    levels_.push_back(detail::make_level<D>(equations, &coarsening, levels_.empty()));
                    equations = std::move(coarsening.coarse);
                    continue;
                }
            }
            levels_.push_back(detail::make_level<D>(equations, nullptr, levels_.empty()));
            if (count <= direct) factorise(equations);
            break;
        }
        find_inner_sources(nodes, sources);
    }

    std::uint32_t unknowns() const noexcept { return levels_.front().count; }

    /// Nodes that may have a right-hand side, those with cut links first; `Block::source` is parallel to them.
    std::size_t source_count() const noexcept { return levels_.front().odd.size() + inner_sources_.size(); }
    std::uint32_t source_node(std::size_t slot) const noexcept {
        const auto& odd = levels_.front().odd;
        return slot < odd.size() ? odd[slot].node : inner_sources_[slot - odd.size()].node;
    }

    /// The other way round: the slot in `Block::source` of every node that may have a right-hand side, else 0.
    std::vector<std::uint32_t> source_slots() const {
        std::vector<std::uint32_t> slots(unknowns());
        for (std::size_t s = 0; s < source_count(); ++s) slots[source_node(s)] = std::uint32_t(s);
        return slots;
    }

    Block make_block() const {
        Block block;
        if constexpr (D == 1) {
            block.source.resize(source_count());
            block.exact_.resize(unknowns());
            return block;
        }
        block.fields_.resize(levels_.size());
        for (std::size_t l = 0; l < levels_.size(); ++l) {
            block.fields_[l].u.resize(levels_[l].count);
            block.fields_[l].b.resize(levels_[l].count);
        }
        block.source.resize(source_count());
        block.settled_part_.resize(source_count());
        block.odd_source_.resize(levels_[0].odd.size());
        return block;
    }

    /// What is known of the error of a block's solution, per right-hand side.
    struct Error {
        Values
            estimate; ///< from the residual, by what the corrections were for the residuals before them, twofold;
                      ///< not a bound: next to one, rarely a little too small
        Values
            bound; ///< from the residual alone, by the maximum principle: never less than the error, up to rounding (see is_refined)
    };

    /// A first guess of a block whose `source` is set, from the coarse grids up.
    Error start(Block& block) const {
        if constexpr (D == 1) return solve_lines(block);
        const std::size_t bottom_level = levels_.size() - 1;
        Simd(0.0f).store(block.gain_);
        Simd(0.0f).store(block.residual_);
        block.settled_.clear();
        block.remainder_.clear();
        block.refined_ = false;
        for (auto& part : block.settled_part_) part.fill(0.0);
        if (bottom_level == 0 || !inner_sources_.empty()) clear(block.fields_[0].b);
        take_sources(block);
        block.cycles_ = 0;
        block.blank_ = true;
        if (bottom_level > 0 && inner_sources_.empty()) {
            clear(block.fields_[1].b);
            for (std::size_t j = 0; j < block.odd_source_.size(); ++j)
                give_to_coarse(block, 0, j, Simd::load(block.odd_source_[j]));
        } else if (bottom_level > 0) {
            clear(block.fields_[0].u);
            pass(block, 0, false, 1, true);
        }
        for (std::size_t l = 1; l < bottom_level; ++l) {
            clear(block.fields_[l].u);
            pass(block, l, false, 1, true);
        }
        bottom(block);
        for (std::size_t l = bottom_level; l-- > 1;) {
            pass(block, l, true, 2, true);
            correct(block, l);
            pass(block, l, true, 1, false);
        }
        return finish(block, bottom_level == 0);
    }

    /// One cycle more.
    Error cycle(Block& block) const {
        if constexpr (D == 1) return solve_lines(block);
        const bool direct = levels_.size() == 1;
        take_sources(block);
        if (direct || block.cycles_++ % refine_every == 1) refine(block);
        if (direct)
            bottom(block);
        else
            correct(block, 0);
        return finish(block, direct);
    }

    /// To be told when `source` has been changed between cycles: by how much at most, per right-hand side.
    static void disturb(Block& block, const Values& change) noexcept {
        for (std::size_t k = 0; k < width; ++k) block.residual_[k] += float(change[k]);
    }

    /// Bytes of the hierarchy, and of every block beside it.
    std::size_t bytes() const noexcept {
        std::size_t n = factor_.size() * sizeof(float) + inner_sources_.size() * sizeof(InnerSource) +
                        lines_.size() * sizeof(Line);
        for (const auto& level : levels_) n += level.bytes();
        return n;
    }
    /// At most; with three cycles a row for each unknown less.
    std::size_t block_bytes() const noexcept {
        if constexpr (D == 1) return (unknowns() + source_count()) * sizeof(Values);
        std::size_t rows = levels_.front().odd.size() + 2 * std::size_t(levels_.front().count);
        for (const auto& level : levels_) rows += 2 * std::size_t(level.count);
        return rows * sizeof(Row) + 2 * source_count() * sizeof(Values);
    }

private:
    using Simd = detail::Simd<float>;
    using Stretch = detail::Stretch<D>;

    /// Largest |b − A u|: of nodes without given data beside them, and of the others over what draws them to it.
    struct Residual {
        Simd inner, drawn;

        void add(const Simd& r) noexcept { inner = max<float>(inner, abs<float>(r)); }
        void add_odd(const typename detail::Level<D>::Odd& node, const Simd& r) noexcept {
            if (node.pull >= 1) {
                drawn = max<float>(drawn, Simd(1 / node.pull) * abs<float>(r));
            } else {
                add(r);
            }
        }
    };

    /// A node in one dimension: the reciprocal of its pivot and what the elimination leaves of the link to the next node.
    struct Line {
        double inverse_pivot, to_next;
        bool from_last; ///< linked to the node before
    };
    void eliminate(const detail::Equations<D>& equations) {
        double to_here = 0;
        for (std::uint32_t node = 0; node < equations.nodes.count(); ++node) {
            const auto& a = equations.stencil(node);
            const bool linked = node > 0 &&
                                equations.nodes.index(node)[0] == equations.nodes.index(node - 1)[0] + 1 &&
                                a[0] != 0 && equations.stencil(node - 1)[2] != 0;
            const double inverse = 1 / (a[1] - (linked ? to_here : 0.0));
            to_here = inverse * -a[2];
            lines_.push_back({inverse, to_here, linked});
        }
        for (std::size_t n = 0; n + 1 < lines_.size(); ++n)
            lines_[n].to_next *= lines_[n + 1].from_last ? 1.0 : 0.0;
    }
    /// Both ways along the line, in double; right up to rounding.
    Error solve_lines(Block& block) const {
        auto& x = block.exact_;
        for (auto& values : x) values.fill(0.0);
        for (std::size_t j = 0; j < source_count(); ++j) x[source_node(j)] = block.source[j];
        for (std::size_t n = 0; n < x.size(); ++n) {
            for (std::size_t k = 0; k < width; ++k)
                x[n][k] = ((lines_[n].from_last ? x[n - 1][k] : 0.0) + x[n][k]) * lines_[n].inverse_pivot;
        }
        for (std::size_t n = x.size(); n-- > 1;) {
            for (std::size_t k = 0; k < width && lines_[n].from_last; ++k)
                x[n - 1][k] += lines_[n - 1].to_next * x[n][k];
        }
        block.refined_ = true;
        return {Values{}, Values{}};
    }

    static Values widened(const Simd& p) noexcept {
        Row row;
        p.store(row);
        Values values;
        for (std::size_t k = 0; k < width; ++k) values[k] = double(row[k]);
        return values;
    }

    /// A node without cut links that may have a right-hand side, and its neighbours.
    struct InnerSource {
        std::uint32_t node;
        std::array<std::uint32_t, 2 * D> neighbours;
    };
    void find_inner_sources(const NodeRuns<D>& nodes, std::span<const std::uint32_t> sources) {
        std::vector<bool> wanted(sources.empty() ? 0 : nodes.count());
        for (const auto node : sources) wanted[node] = true;
        if (wanted.empty()) return;
        for (const auto& odd : levels_.front().odd) wanted[odd.node] = false;
        Neighbours<D> around(nodes);
        nodes.for_each([&](const auto& index, std::uint32_t node) {
            if (!wanted[node]) return;
            around.move_to(index);
            InnerSource source{node, {}};
            std::size_t n = 0;
            for (std::size_t p = 0; p < detail::Places<D>::count; ++p) {
                if (detail::Places<D>::distance(p) == 1) source.neighbours[n++] = around.at(p);
            }
            inner_sources_.push_back(source);
        });
    }

    /// The right-hand sides that are left when what is put aside has taken its part.
    void take_sources(Block& block) const noexcept {
        const std::size_t odd = block.odd_source_.size();
        for (std::size_t j = 0; j < block.source.size(); ++j) {
            Row& rest = j < odd ? block.odd_source_[j] : block.fields_[0].b[inner_sources_[j - odd].node];
            for (std::size_t k = 0; k < width; ++k)
                rest[k] = float(block.source[j][k] - block.settled_part_[j][k]);
        }
    }

    /// Puts the solution so far aside and makes its residual, in double, the right-hand side.
    void refine(Block& block) const {
        auto& [u, b] = block.fields_[0];
        if (!block.refined_) {
            std::swap(u, block.settled_);
            u.resize(levels_[0].count);
        } else {
            if (block.remainder_.empty()) {
                block.remainder_.resize(levels_[0].count);
                clear(block.remainder_);
            }
            for (std::size_t i = 0; i < u.size(); ++i) {
                for (std::size_t k = 0; k < width; ++k) {
                    const double low = double(block.remainder_[i][k]) + double(u[i][k]);
                    const double sum = double(block.settled_[i][k]) + low;
                    block.settled_[i][k] = float(sum);
                    block.remainder_[i][k] = float(sum - double(block.settled_[i][k]));
                }
            }
        }
        block.blank_ = true;
        block.refined_ = true;
        const auto& level = levels_[0];
        const Row* const remainder = block.remainder_.empty() ? nullptr : block.remainder_.data();
        for (std::size_t q = 0; q < level.slabs.size(); ++q) {
            for (std::size_t t = first_stretch(0, q); t < level.slabs[q].stretches_end; ++t)
                residual_in_double(block.settled_.data(), remainder, level.stretches[t], b.data());
            for (std::size_t j = first_odd(0, q); j < level.slabs[q].odd_end; ++j) {
                auto& part = block.settled_part_[j];
                part.fill(0.0);
                add_settled(block, level.odd[j].node, level.odd[j].diagonal, part);
                const auto* const entries = level.entries.data() + j * finest_entries;
                for (std::size_t n = 0; n < finest_entries; ++n)
                    add_settled(block, entries[n].node, -double(entries[n].weight), part);
            }
        }
        for (std::size_t n = 0; n < inner_sources_.size(); ++n) {
            auto& part = block.settled_part_[level.odd.size() + n];
            part.fill(0.0);
            add_settled(block, inner_sources_[n].node, 2.0 * double(D), part);
            for (const auto neighbour : inner_sources_[n].neighbours)
                add_settled(block, neighbour, -1.0, part);
        }
        take_sources(block);
    }
    static void add_settled(const Block& block, std::uint32_t node, double factor, Values& sum) noexcept {
        for (std::size_t k = 0; k < width; ++k) sum[k] += factor * double(block.settled_[node][k]);
        if (block.remainder_.empty()) return;
        for (std::size_t k = 0; k < width; ++k) sum[k] += factor * double(block.remainder_[node][k]);
    }
    /// −A applied to a stretch of a solution and, where there is one, its remainder.
    static void residual_in_double(const Row* u, const Row* remainder, const Stretch& s, Row* b) noexcept {
        std::array<std::ptrdiff_t, 2 * D> to{-1, 1};
        for (std::size_t k = 1, r = 1; k < D; ++k, r *= 3) {
            to[2 * k] = s.row[middle_row - r];
            to[2 * k + 1] = s.row[middle_row + r];
        }
        const auto add = [&to](Values& sum, const Row* here) {
            for (std::size_t n = 0; n < to.size(); ++n) {
                const Row& there = here[to[n]];
                for (std::size_t k = 0; k < width; ++k) sum[k] += double(there[k]);
            }
            for (std::size_t k = 0; k < width; ++k) sum[k] -= 2.0 * double(D) * double((*here)[k]);
        };
        for (std::size_t i = s.first; i < s.first + s.count; ++i) {
            Values sum{};
            add(sum, u + i);
            if (remainder != nullptr) add(sum, remainder + i);
            for (std::size_t k = 0; k < width; ++k) b[i][k] = float(sum[k]);
        }
    }

    /// The last pass of a cycle over the finest level, and what it says of the error.
    Error finish(Block& block, bool direct) const {
        Residual now;
        Simd caution(2.0f);
        if (direct) {
            now = {Simd(0.0f), Simd(0.0f)};
            for (std::size_t j = 0; j < levels_[0].odd.size(); ++j)
                now.add_odd(levels_[0].odd[j], odd_residual(block, 0, j));
            const auto& [u, b] = block.fields_[0];
            const auto add = [&now](std::uint32_t, const Simd& r) { now.add(r); };
            for (const auto& s : levels_[0].stretches) {
                for (const std::uint32_t begin : {0u, 1u}) {
                    if (block.refined_ || !inner_sources_.empty()) {
                        walk_finest<true, true>(u.data() + s.first, b.data() + s.first, s, begin, add);
                    } else {
                        walk_finest<true, false>(u.data() + s.first, b.data() + s.first, s, begin, add);
                    }
                }
            }
        } else {
            // The correction just found is the error of the solution before, up to what relaxation takes away.
            Simd correction(0.0f);
            for (const Row& row : block.fields_[1].u)
                correction = max<float>(correction, abs<float>(Simd::load(row)));
            const Simd before = Simd::load(block.residual_);
            const Simd gain = correction / max<float>(before, Simd(std::numeric_limits<float>::min()));
            const Simd known = select<float>(Simd(0.0f) < before, gain, Simd(0.0f));
            // Residuals get smoother and tell of more error: as the gain has grown it may grow again.
            const Simd last = Simd::load(block.gain_), largest = max<float>(last, known);
            const Simd growth = largest / max<float>(last, Simd(std::numeric_limits<float>::min()));
            caution = caution * select<float>(Simd(0.0f) < last, min<float>(growth, Simd(2.0f)), Simd(2.0f));
            largest.store(block.gain_);
            now = pass(block, 0, true, finest_sweeps, true);
        }
        const Simd largest = max<float>(now.inner, now.drawn);
        largest.store(block.residual_);
        const Simd known = Simd::load(block.gain_);
        const Simd gain = select<float>(Simd(0.0f) < known, max<float>(Simd(1.0f), known), Simd(4.0f));
        return {widened(caution * gain * largest), widened(Simd(float(reach_)) * now.inner + now.drawn)};
    }

    void factorise(const detail::Equations<D>& e) {
        const auto n = Eigen::Index(e.nodes.count());
        Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
        e.nodes.for_each([&](const auto& index, std::uint32_t node) {
            for (std::size_t p = 0; p < detail::Places<D>::count; ++p) {
                const auto m = e.nodes.find(detail::shifted<D>(index, detail::Places<D>::offset(p)));
                if (m != NodeRuns<D>::none) a(Eigen::Index(node), Eigen::Index(m)) += e.stencil(node)[p];
            }
        });
        const Eigen::LLT<Eigen::MatrixXd> llt(a);
        if (llt.info() != Eigen::Success) return;
        const Eigen::MatrixXd factor = llt.matrixL();
        for (Eigen::Index i = 0; i < n; ++i) {
            for (Eigen::Index j = 0; j < i; ++j) factor_.push_back(float(factor(i, j) / factor(i, i)));
            factor_.push_back(float(1 / factor(i, i)));
        }
        for (Eigen::Index i = n; i-- > 0;) {
            for (Eigen::Index j = i + 1; j < n; ++j) factor_.push_back(float(factor(j, i) / factor(i, i)));
            factor_.push_back(float(1 / factor(i, i)));
        }
    }

    static void clear(std::vector<Row>& rows) noexcept {
        std::memset(static_cast<void*>(rows.data()), 0, rows.size() * sizeof(Row));
    }

    void bottom(Block& block) const noexcept {
        const std::size_t l = levels_.size() - 1, n = levels_[l].count;
        auto& [u, b] = block.fields_[l];
        if (factor_.empty()) {
            // Too thin for coarser grids, hence close to the data everywhere: relaxation is quick.
            clear(u);
            pass(block, l, false, 8, false);
            return;
        }
        if (l == 0) {
            for (std::size_t j = 0; j < levels_[0].odd.size(); ++j)
                b[levels_[0].odd[j].node] = block.odd_source_[j];
        }
        const float* factor = factor_.data();
        const auto eliminate = [&](const Row& right, std::size_t begin, std::size_t end) {
            Simd sum(0.0f), other(0.0f); // two sums side by side hide the time an addition takes
            for (; begin + 1 < end; begin += 2, factor += 2) {
                sum = sum + Simd(factor[0]) * Simd::load(u[begin]);
                other = other + Simd(factor[1]) * Simd::load(u[begin + 1]);
            }
            if (begin < end) sum = sum + Simd(*factor++) * Simd::load(u[begin]);
            return Simd(*factor++) * Simd::load(right) - (sum + other);
        };
        for (std::size_t i = 0; i < n; ++i) eliminate(b[i], 0, i).store(u[i]);
        for (std::size_t i = n; i-- > 0;) eliminate(u[i], i + 1, n).store(u[i]);
    }

    // ---- one node ---------------------------------------------------------------------------------

    Simd odd_neighbours(const Block& block, std::size_t l, std::size_t j) const noexcept {
        const auto& level = levels_[l];
        const Row* const u = block.fields_[l].u.data();
        const auto* entry = level.entries.data();
        if (l == 0) {
            Simd sum = Simd::load(block.odd_source_[j]);
            entry += j * finest_entries;
            for (std::size_t n = 0; n < finest_entries; ++n)
                sum = sum + Simd(entry[n].weight) * Simd::load(u[entry[n].node]);
            return sum;
        }
        Simd sum = Simd::load(block.fields_[l].b[level.odd[j].node]);
        const auto* const end = entry + level.odd[j].stencil_end;
        Simd other(0.0f);
        for (entry += j == 0 ? 0 : level.odd[j - 1].stencil_end; entry != end; entry += 2) {
            sum = sum + Simd(entry[0].weight) * Simd::load(u[entry[0].node]);
            other = other + Simd(entry[1].weight) * Simd::load(u[entry[1].node]);
        }
        return sum + other;
    }
    Simd odd_residual(const Block& block, std::size_t l, std::size_t j) const noexcept {
        const auto& node = levels_[l].odd[j];
        return odd_neighbours(block, l, j) -
               Simd(float(node.diagonal)) * Simd::load(block.fields_[l].u[node.node]);
    }

    // ---- one stretch ------------------------------------------------------------------------------

    /// body(n, x) for every second node of a stretch of the finest level from `n` = begin on, where x is b − A u when
    /// `Residual`, else the value that makes the node's equation hold.
    template <bool Residual, bool WithSource, class Body>
    static void walk_finest(const Row* at, const Row* b, const Stretch& s, std::uint32_t begin,
                            Body body) noexcept {
        std::array<std::ptrdiff_t, 2 * D> to{};
        for (std::size_t k = 1, r = 1; k < D; ++k, r *= 3) {
            to[2 * k] = s.row[middle_row - r];
            to[2 * k + 1] = s.row[middle_row + r];
        }
        constexpr float diagonal = 2.0f * float(D);
        const std::uint32_t count = s.count;
        for (std::uint32_t n = begin; n < count; n += 2) {
            const Row* const here = at + n;
            Simd sum = Simd::load(here[-1]) + Simd::load(here[1]);
            if constexpr (WithSource) sum = sum + Simd::load(b[n]);
            for (std::size_t k = 1; k < D; ++k)
                sum = sum + (Simd::load(here[to[2 * k]]) + Simd::load(here[to[2 * k + 1]]));
            if constexpr (Residual) {
                body(n, sum - Simd(diagonal) * Simd::load(*here));
            } else {
                body(n, sum * Simd(1 / diagonal));
            }
        }
    }
    /// The same for all nodes of a stretch of a coarser level. A value given by `body` is stored before the next node's.
    template <bool Residual, class Body>
    static void walk_coarse(const detail::Level<D>& level, Row* at, const Row* b, const Stretch& s,
                            Body body) noexcept {
        // Sums over the neighbouring rows are carried along: what is a column ahead now is beside next.
        struct Column {
            std::array<Simd, D> sum; ///< over the rows at distance 1 … D − 1 from the node's own
        };
        std::array<std::ptrdiff_t, row_count> to{};
        for (std::size_t r = 0; r < row_count; ++r) to[r] = s.row[r];
        const auto column = [&to](const Row* x) {
            Column c;
            for (std::size_t d = 1; d < D; ++d) c.sum[d] = Simd(0.0f);
            for (std::size_t r = 0; r < row_count; ++r) {
                if (r != middle_row) c.sum[row_distance[r]] = c.sum[row_distance[r]] + Simd::load(x[to[r]]);
            }
            return c;
        };
        const float share = Residual ? 1.0f : 1 / level.diagonal;
        std::array<Simd, D + 1> weight;
        for (std::size_t d = 1; d <= D; ++d) weight[d] = Simd(share * level.by_distance[d]);
        const Simd diagonal(level.diagonal), one(share);
        Column before = column(at - 1), here = column(at);
        Simd left = Simd::load(at[-1]), middle = Simd::load(at[0]);
        const std::uint32_t count = s.count;
        for (std::uint32_t n = 0; n < count; ++n, ++at) {
            const Column ahead = column(at + 1);
            const Simd right = Simd::load(at[1]);
            Simd sum = one * Simd::load(b[n]);
            for (std::size_t d = 1; d < D; ++d)
                sum = sum + (weight[d] * here.sum[d] + weight[d + 1] * (before.sum[d] + ahead.sum[d]));
            sum = (sum + weight[1] * right) + weight[1] * left; // what the last step made comes in last
            if constexpr (Residual) {
                body(n, sum - diagonal * middle);
                left = middle;
            } else {
                sum.store(*at);
                left = sum;
            }
            middle = right;
            before = here;
            here = ahead;
        }
    }

    // ---- one slab ---------------------------------------------------------------------------------

    std::size_t first_stretch(std::size_t l, std::size_t q) const noexcept {
        return q == 0 ? 0 : levels_[l].slabs[q - 1].stretches_end;
    }
    std::size_t first_odd(std::size_t l, std::size_t q) const noexcept {
        return q == 0 ? 0 : levels_[l].slabs[q - 1].odd_end;
    }
    /// The first node of a stretch that has the colour (the parity of the sum of its indices).
    static std::uint32_t first_of(const Stretch& s, std::uint32_t colour) noexcept {
        return ((std::uint32_t(s.x) + (s.odd_sum ? 1u : 0u)) & 1u) ^ colour;
    }

    void relax_odd(Block& block, std::size_t l, std::size_t q) const noexcept {
        for (std::size_t j = first_odd(l, q); j < levels_[l].slabs[q].odd_end; ++j) {
            const auto& node = levels_[l].odd[j];
            (odd_neighbours(block, l, j) * Simd(node.inverse)).store(block.fields_[l].u[node.node]);
        }
    }
    /// Every second node of the finest level's stretches, those of one colour.
    template <bool WithSource>
    void relax_finest(Block& block, std::size_t q, std::uint32_t colour) const noexcept {
        auto& [u, b] = block.fields_[0];
        for (std::size_t t = first_stretch(0, q); t < levels_[0].slabs[q].stretches_end; ++t) {
            const auto& s = levels_[0].stretches[t];
            Row* const at = u.data() + s.first;
            walk_finest<false, WithSource>(at, b.data() + s.first, s, first_of(s, colour),
                                           [at](std::uint32_t n, const Simd& x) { x.store(at[n]); });
        }
    }
    /// A sweep along the rows of a coarser level.
    void relax_coarse(Block& block, std::size_t l, std::size_t q) const noexcept {
        auto& [u, b] = block.fields_[l];
        for (std::size_t t = first_stretch(l, q); t < levels_[l].slabs[q].stretches_end; ++t) {
            const auto& s = levels_[l].stretches[t];
            walk_coarse<false>(levels_[l], u.data() + s.first, b.data() + s.first, s, nullptr);
        }
    }
    /// Adds the residual of a slab to the right-hand side of the coarse level. Just relaxed nodes of the finest
    /// level's second colour have none.
    template <bool WithSource>
    void restrict_slab(Block& block, std::size_t l, std::size_t q, Residual& largest) const noexcept {
        const auto& level = levels_[l];
        auto& [u, b] = block.fields_[l];
        Row* const coarse = block.fields_[l + 1].b.data();
        const Simd half(0.5f);
        for (std::size_t t = first_stretch(l, q); t < level.slabs[q].stretches_end; ++t) {
            const auto& s = level.stretches[t];
            const Simd share(1.0f / float(s.coarse_rows));
            const auto give = [coarse, &s](std::int32_t x, const Simd& r) {
                for (std::uint32_t c = 0; c < s.coarse_rows; ++c) {
                    Row& row = coarse[s.coarse[c] + std::uint32_t(x)];
                    (Simd::load(row) + r).store(row);
                }
            };
            std::int32_t x = s.x >> 1;
            Simd gathered(0.0f); // for coarse node x
            if (l > 0) {
                bool between = (s.x & 1) != 0;
                walk_coarse<true>(level, u.data() + s.first, b.data() + s.first, s,
                                  [&](std::uint32_t, const Simd& residual) {
                                      largest.add(residual);
                                      const Simd r = share * residual;
                                      if (between) {
                                          give(x, gathered + half * r);
                                          gathered = half * r;
                                          ++x;
                                      } else {
                                          gathered = gathered + r;
                                      }
                                      between = !between;
                                  });
            } else {
                const std::uint32_t begin = first_of(s, 0);
                x = (s.x + std::int32_t(begin)) >> 1;
                const bool between = ((s.x + std::int32_t(begin)) & 1) != 0;
                const Simd part = between ? half * share : share;
                walk_finest<true, WithSource>(u.data() + s.first, b.data() + s.first, s, begin,
                                              [&](std::uint32_t, const Simd& residual) {
                                                  largest.add(residual);
                                                  const Simd r = part * residual;
                                                  give(x, gathered + r);
                                                  if (between) gathered = r;
                                                  ++x;
                                              });
                if (!between || begin >= s.count) continue;
            }
            // The last may lie one beyond the stretch only if it got something.
            if (2 * x <= s.x + std::int32_t(s.count)) give(x, gathered);
        }
        for (std::size_t j = first_odd(l, q); j < level.slabs[q].odd_end; ++j) {
            const Simd r = odd_residual(block, l, j);
            largest.add_odd(level.odd[j], r);
            give_to_coarse(block, l, j, r);
        }
    }
    void give_to_coarse(Block& block, std::size_t l, std::size_t j, const Simd& r) const noexcept {
        const auto& level = levels_[l];
        Row* const coarse = block.fields_[l + 1].b.data();
        for (std::uint32_t n = j == 0 ? 0 : level.odd[j - 1].coarse_end; n < level.odd[j].coarse_end; ++n) {
            Row& row = coarse[level.from_coarse[n].node];
            (Simd::load(row) + Simd(level.from_coarse[n].weight) * r).store(row);
        }
    }
    /// Adds the interpolated coarse solution, or sets it.
    template <bool Set>
    void prolong(Block& block, std::size_t l, std::size_t q) const noexcept {
        const auto add = [](Row& row, const Simd& x) {
            if constexpr (Set) {
                x.store(row);
            } else {
                (Simd::load(row) + x).store(row);
            }
        };
        const auto& level = levels_[l];
        Row* const u = block.fields_[l].u.data();
        const Row* const coarse = block.fields_[l + 1].u.data();
        for (std::size_t t = first_stretch(l, q); t < level.slabs[q].stretches_end; ++t) {
            const auto& s = level.stretches[t];
            const std::uint32_t rows = s.coarse_rows;
            const auto from = s.coarse;
            const Simd share(1.0f / float(rows)), half(0.5f);
            const auto take = [=](std::int32_t x) {
                Simd sum = Simd::load(coarse[from[0] + std::uint32_t(x)]);
                for (std::uint32_t c = 1; c < rows; ++c)
                    sum = sum + Simd::load(coarse[from[c] + std::uint32_t(x)]);
                return share * sum;
            };
            Row* here = u + s.first;
            Row* const end = here + s.count;
            std::int32_t x = s.x / 2;
            Simd low = take(x);
            if ((s.x & 1) == 0) {
                add(*here, low);
                ++here;
            }
            for (; here < end; here += 2) { // an odd node and the even one after it
                const Simd high = take(++x);
                add(here[0], half * (low + high));
                if (here + 1 < end) add(here[1], high);
                low = high;
            }
        }
        for (std::size_t j = first_odd(l, q); j < level.slabs[q].odd_end; ++j) {
            Simd sum(0.0f);
            for (std::uint32_t n = j == 0 ? 0 : level.odd[j - 1].coarse_end; n < level.odd[j].coarse_end; ++n)
                sum = sum + Simd(level.from_coarse[n].weight) * Simd::load(coarse[level.from_coarse[n].node]);
            add(u[level.odd[j].node], sum);
        }
    }

    // ---- one level, in a single pass over memory ---------------------------------------------------

    /// Interpolates from the coarse level (when `from_coarse`), relaxes `sweeps` times, and gives the residual to
    /// the coarse level (when `to_coarse`), each a few slabs behind the one before. Returns that residual's size.
    Residual pass(Block& block, std::size_t l, bool from_coarse, std::size_t sweeps,
                  bool to_coarse) const noexcept {
        return l == 0 && (block.refined_ || !inner_sources_.empty())
                   ? pass<true>(block, l, from_coarse, sweeps, to_coarse)
                   : pass<false>(block, l, from_coarse, sweeps, to_coarse);
    }
    template <bool WithSource> // of every node of the finest level
    Residual pass(Block& block, std::size_t l, bool from_coarse, std::size_t sweeps,
                  bool to_coarse) const noexcept {
        const std::size_t slabs = levels_[l].slabs.size();
        const std::size_t start = from_coarse ? 1 : 0;
        const std::size_t lag = l == 0 ? 2 : 1; // slabs a sweep is behind the one before
        const std::size_t steps = slabs + start + lag * sweeps;
        const auto at = [&](std::size_t step, std::size_t behind) {
            return step >= behind && step - behind < slabs ? step - behind : slabs;
        };
        Residual largest{Simd(0.0f), Simd(0.0f)};
        const bool blank = l == 0 && block.blank_;
        block.blank_ = block.blank_ && l > 0;
        if (to_coarse) clear(block.fields_[l + 1].b);
        for (std::size_t step = 0; step < steps; ++step) {
            if (from_coarse && step < slabs) {
                if (blank) {
                    prolong<true>(block, l, step);
                } else {
                    prolong<false>(block, l, step);
                }
            }
            for (std::size_t sweep = 0; sweep < sweeps; ++sweep) {
                const std::size_t q = at(step, start + lag * sweep);
                if (q < slabs) {
                    relax_odd(block, l, q);
                    if (l > 0) {
                        relax_coarse(block, l, q);
                    } else {
                        relax_finest<WithSource>(block, q, 0);
                    }
                }
                if (l > 0) continue;
                const std::size_t second = at(step, start + lag * sweep + 1);
                if (second < slabs) relax_finest<WithSource>(block, second, 1);
            }
            const std::size_t q = at(step, start + lag * sweeps);
            if (to_coarse && q < slabs) restrict_slab<WithSource>(block, l, q, largest);
        }
        return largest;
    }
    /// Solves the coarse level below `l`, whose right-hand side is set, well enough.
    void correct(Block& block, std::size_t l) const noexcept {
        const std::size_t below = l + 1;
        if (below + 1 == levels_.size()) return bottom(block);
        clear(block.fields_[below].u);
        pass(block, below, false, 1, true);
        correct(block, below);
        pass(block, below, true, 2, true); // a W-cycle: these levels are small, and thin parts need them well
        correct(block, below);
        pass(block, below, true, 1, false);
    }

    static constexpr std::size_t finest_sweeps = 7;
    static constexpr std::size_t refine_every = 2; ///< cycles, from the second on: what float can do at once
    static constexpr std::size_t finest_entries = 2 * D;
    static constexpr std::size_t row_count = detail::power(3, D - 1);
    static constexpr std::size_t middle_row = row_count / 2;
    static constexpr std::array<std::size_t, row_count> row_distance = [] {
        std::array<std::size_t, row_count> distance{};
        for (std::size_t r = 0; r < row_count; ++r) distance[r] = detail::Places<D>::distance(3 * r + 1);
        return distance;
    }();

    std::vector<detail::Level<D>> levels_;
    std::vector<InnerSource> inner_sources_;
    std::vector<Line> lines_; ///< in one dimension
    double reach_ = 1;        ///< error per inner residual at most
    std::vector<float>
        factor_; ///< Cholesky's of the bottom level, as `bottom` reads it; empty where that is large
};

} // namespace cageform::inline CAGEFORM_ABI
