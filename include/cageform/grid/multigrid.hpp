// The Laplace equation on the nodes of a lattice, solved for eight right-hand sides at once.
//
// Dirichlet data enters through cut links (CutLink): where it lies is known to the node. Coarse grids are
// every second node, with interpolation built from the equations and Galerkin operators, so that walls, slits and
// legs of one node's width stay what they are on every level (Dendy, Black box multigrid, J. Comput. Phys. 48
// (1982); in 2D and 3D the same code here). The finest level is relaxed in red-black order, its residual and the
// way to the coarse grid done in the same pass over memory; the way back likewise.
#pragma once

#include <cageform/core/detail/pack.hpp>
#include <cageform/grid/detail/hierarchy.hpp>

#include <Eigen/Cholesky>

#include <limits>

namespace cageform::inline CAGEFORM_ABI {

/// The hierarchy for one set of unknowns; serves any number of right-hand sides and threads.
template <std::size_t D>
class Multigrid {
public:
    static constexpr std::size_t width = lane_count<double>; ///< right-hand sides solved together
    using Row = Lanes<double>;

    /// What one block of right-hand sides needs. `solution` and `source` are the caller's to read and write.
    struct Block {
        struct Fields {
            std::vector<Row> u, b;
        };
        std::vector<Fields> fields; ///< a level each; the finest has no b unless every node has a source
        std::vector<Row> source;    ///< right-hand sides of the nodes that may have one (`source_slot`)
        Row gain;                   ///< error per residual, as the cycles so far showed
        Row residual;               ///< largest, after the last cycle
        std::span<Row> solution() noexcept { return fields.front().u; }
    };

    /// cuts     every link of an unknown that does not end on an unknown
    /// sources  further nodes that take a right-hand side of their own
    Multigrid(const NodeRuns<D>& nodes, std::span<const CutLink> cuts,
              std::span<const std::uint32_t> sources) {
        std::vector<bool> marked;
        if (!sources.empty()) {
            marked.resize(nodes.count());
            for (const auto node : sources) marked[node] = true;
        }
        // ∇²(−|x|²/2D) = −1: over a ball of radius R about the nodes the error is at most R²/2D residuals.
        double squares = 0;
        for (const auto n : nodes.size()) squares += 0.25 * double(n) * double(n);
        reach_ = squares / (2.0 * double(D));
        auto equations = detail::finest_equations<D>(nodes, cuts);
        for (;;) {
            constexpr std::uint32_t direct = 160; // unknowns solved at once at the bottom
            const std::uint32_t count = equations.nodes.count();
            if (count > direct) {
                auto coarsening = detail::Coarsener<D>(equations).take();
                if (coarsening.coarse.nodes.count() > 0) {
                    levels_.push_back(detail::make_level<D>(equations, &coarsening, marked, levels_.empty()));
                    equations = std::move(coarsening.coarse);
                    marked.clear();
                    continue;
                }
            }
            levels_.push_back(detail::make_level<D>(equations, nullptr, marked, levels_.empty()));
            if (count <= direct) factorise(equations);
            return;
        }
    }

    std::uint32_t unknowns() const noexcept { return levels_.front().count; }

    /// Nodes that may have a right-hand side, ascending within a slab; `Block::source` is parallel to them.
    std::size_t source_count() const noexcept { return levels_.front().odd.size(); }
    std::uint32_t source_node(std::size_t slot) const noexcept { return levels_.front().odd[slot].node; }

    Block make_block() const {
        Block block;
        block.fields.resize(levels_.size());
        for (std::size_t l = 0; l < levels_.size(); ++l) {
            block.fields[l].u.resize(levels_[l].count);
            if (l > 0) block.fields[l].b.resize(levels_[l].count);
        }
        block.source.resize(source_count());
        Pack(0.0).store(block.gain);
        Pack(0.0).store(block.residual);
        return block;
    }

    /// What is known of the error of a block's solution, per right-hand side.
    struct Error {
        Row estimate; ///< from the residual, by what the corrections were for the residuals before them; twofold
        Row bound;    ///< from the residual alone, by the maximum principle: never less than the error
    };

    /// A first guess of a block whose `source` is set, from the coarse grids up.
    Error start(Block& block) const {
        const std::size_t bottom_level = levels_.size() - 1;
        Pack(0.0).store(block.gain);
        Pack(0.0).store(block.residual);
        for (std::size_t l = 0; l < bottom_level; ++l) {
            clear(block.fields[l].u);
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
        const bool direct = levels_.size() == 1;
        if (direct)
            bottom(block);
        else
            correct(block, 0);
        return finish(block, direct);
    }

    /// To be told when `source` has been changed between cycles: by how much at most, per right-hand side.
    static void disturb(Block& block, const Row& change) noexcept {
        (Pack::load(block.residual) + Pack::load(change)).store(block.residual);
    }

    /// Bytes of the hierarchy, and of every block beside it.
    std::size_t bytes() const noexcept {
        std::size_t n = std::size_t(factor_.size()) * sizeof(double);
        for (const auto& level : levels_) n += level.bytes();
        return n;
    }
    std::size_t block_bytes() const noexcept {
        std::size_t rows = source_count();
        for (std::size_t l = 0; l < levels_.size(); ++l) rows += levels_[l].count * (l > 0 ? 2u : 1u);
        return rows * sizeof(Row);
    }

private:
    using Pack = detail::Pack<double>;
    using Stretch = detail::Stretch<D>;

    /// Largest |b − A u|: of nodes without given data beside them, and of the others over what draws them to it.
    struct Residual {
        Pack inner, drawn;

        void add(const Pack& r) noexcept { inner = max<double>(inner, abs<double>(r)); }
        void add_odd(const typename detail::Level<D>::Odd& node, const Pack& r) noexcept {
            if (node.pull >= 1) {
                drawn = max<double>(drawn, Pack(1 / node.pull) * abs<double>(r));
            } else {
                add(r);
            }
        }
    };

    /// The last pass of a cycle over the finest level, and what it says of the error.
    Error finish(Block& block, bool direct) const {
        Residual now;
        if (direct) {
            now = {Pack(0.0), Pack(0.0)};
            for (std::size_t j = 0; j < levels_[0].odd.size(); ++j)
                now.add_odd(levels_[0].odd[j], odd_residual(block, 0, j));
        } else {
            // The correction just found is the error of the solution before, up to what relaxation takes away.
            Pack correction(0.0);
            for (const Row& row : block.fields[1].u)
                correction = max<double>(correction, abs<double>(Pack::load(row)));
            const Pack before = Pack::load(block.residual);
            const Pack gain = correction / max<double>(before, Pack(std::numeric_limits<double>::min()));
            const Pack known = select<double>(Pack(0.0) < before, gain, Pack(0.0));
            max<double>(Pack::load(block.gain), known).store(block.gain);
            now = pass(block, 0, true, finest_sweeps, true);
        }
        const Pack largest = max<double>(now.inner, now.drawn);
        largest.store(block.residual);
        Error error;
        const Pack known = Pack::load(block.gain);
        const Pack gain = select<double>(Pack(0.0) < known, max<double>(Pack(1.0), known), Pack(4.0));
        (Pack(2.0) * gain * largest).store(error.estimate);
        (Pack(reach_) * now.inner + now.drawn).store(error.bound);
        return error;
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
        if (llt.info() == Eigen::Success) factor_ = llt.matrixL();
    }

    static void clear(std::vector<Row>& rows) noexcept {
        std::memset(static_cast<void*>(rows.data()), 0, rows.size() * sizeof(Row));
    }

    void bottom(Block& block) const {
        const std::size_t l = levels_.size() - 1;
        auto& u = block.fields[l].u;
        if (factor_.rows() != Eigen::Index(levels_[l].count)) {
            // Too thin for coarser grids, hence close to the data everywhere: relaxation is quick.
            clear(u);
            pass(block, l, false, 8, false);
            return;
        }
        const std::size_t n = levels_[l].count;
        for (std::size_t i = 0; i < n; ++i) {
            Pack x = right_hand_side(block, l, i);
            for (std::size_t j = 0; j < i; ++j)
                x = x - Pack(factor_(Eigen::Index(i), Eigen::Index(j))) * Pack::load(u[j]);
            (x * Pack(1 / factor_(Eigen::Index(i), Eigen::Index(i)))).store(u[i]);
        }
        for (std::size_t i = n; i-- > 0;) {
            Pack x = Pack::load(u[i]);
            for (std::size_t j = i + 1; j < n; ++j)
                x = x - Pack(factor_(Eigen::Index(j), Eigen::Index(i))) * Pack::load(u[j]);
            (x * Pack(1 / factor_(Eigen::Index(i), Eigen::Index(i)))).store(u[i]);
        }
    }
    /// Of a node of the bottom level.
    Pack right_hand_side(const Block& block, std::size_t l, std::size_t node) const noexcept {
        if (l > 0) return Pack::load(block.fields[l].b[node]);
        for (std::size_t j = 0; j < levels_[0].odd.size(); ++j) {
            if (levels_[0].odd[j].node == node) return Pack::load(block.source[j]);
        }
        return Pack(0.0);
    }

    // ---- one node ---------------------------------------------------------------------------------

    Pack odd_neighbours(const Block& block, std::size_t l, std::size_t j) const noexcept {
        const auto& level = levels_[l];
        const Row* const u = block.fields[l].u.data();
        Pack sum = Pack::load(l == 0 ? block.source[j] : block.fields[l].b[level.odd[j].node]);
        const auto* entry = level.entries.data();
        if (l == 0) {
            entry += j * finest_entries;
            for (std::size_t n = 0; n < finest_entries; ++n)
                sum = sum + Pack(entry[n].weight) * Pack::load(u[entry[n].node]);
            return sum;
        }
        const auto* const end = entry + level.odd[j].stencil_end;
        Pack other(0.0); // two sums side by side hide the time an addition takes
        for (entry += j == 0 ? 0 : level.odd[j - 1].stencil_end; entry != end; entry += 2) {
            sum = sum + Pack(entry[0].weight) * Pack::load(u[entry[0].node]);
            other = other + Pack(entry[1].weight) * Pack::load(u[entry[1].node]);
        }
        return sum + other;
    }
    Pack odd_residual(const Block& block, std::size_t l, std::size_t j) const noexcept {
        const auto& node = levels_[l].odd[j];
        return odd_neighbours(block, l, j) - Pack(node.diagonal) * Pack::load(block.fields[l].u[node.node]);
    }

    // ---- one stretch ------------------------------------------------------------------------------

    /// body(n, i, x) for nodes n = begin, begin + step, … of a stretch (number i), where x is b − A u when
    /// `Residual`, else the value that makes the node's equation hold.
    template <bool Residual, class Body>
    void walk(const Block& block, std::size_t l, const Stretch& s, std::uint32_t begin, std::uint32_t step,
              Body&& body) const noexcept {
        const auto& level = levels_[l];
        const Row* const u = block.fields[l].u.data();
        const Pack share(Residual ? 1.0 : 1 / level.diagonal);
        const Pack diagonal(level.diagonal);
        const auto finish = [&](std::uint32_t n, Pack sum) {
            const std::size_t i = s.first + n;
            if constexpr (Residual) {
                body(n, i, sum - diagonal * Pack::load(u[i]));
            } else {
                body(n, i, sum * share);
            }
        };
        if (l == 0) {
            for (std::uint32_t n = begin; n < s.count; n += step) {
                const Row* const at = u + s.first + n;
                Pack sum = Pack::load(at[-1]) + Pack::load(at[1]);
                for (std::size_t k = 1, r = 1; k < D; ++k, r *= 3)
                    sum =
                        sum + (Pack::load(at[s.row[middle_row - r]]) + Pack::load(at[s.row[middle_row + r]]));
                finish(n, sum);
            }
            return;
        }
        // Sums over the neighbouring rows are carried along: what is a column ahead now is beside next.
        const Row* const b = block.fields[l].b.data();
        std::array<Pack, D + 1> weight;
        for (std::size_t d = 1; d <= D; ++d) weight[d] = Pack(level.by_distance[d]);
        struct Column {
            std::array<Pack, D> sum; ///< over the rows at distance 1 … D − 1 from the node's own
        };
        const auto column = [&](const Row* at) {
            Column c;
            for (std::size_t d = 1; d < D; ++d) c.sum[d] = Pack(0.0);
            for (std::size_t r = 0; r < row_count; ++r) {
                if (r != middle_row)
                    c.sum[row_distance[r]] = c.sum[row_distance[r]] + Pack::load(at[s.row[r]]);
            }
            return c;
        };
        const Row* at = u + s.first;
        Column before = column(at - 1), here = column(at);
        for (std::uint32_t n = 0; n < s.count; ++n, ++at) {
            const Column ahead = column(at + 1);
            Pack sum = Pack::load(b[s.first + n]);
            for (std::size_t d = 1; d < D; ++d)
                sum = sum + (weight[d] * here.sum[d] + weight[d + 1] * (before.sum[d] + ahead.sum[d]));
            finish(n, sum + weight[1] * (Pack::load(at[-1]) + Pack::load(at[1])));
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
            (odd_neighbours(block, l, j) * Pack(node.inverse)).store(block.fields[l].u[node.node]);
        }
    }
    /// Every `step`-th node of the stretches: all (a sweep along the row), or those of one colour.
    void relax(Block& block, std::size_t l, std::size_t q, std::uint32_t step,
               std::uint32_t colour) const noexcept {
        Row* const u = block.fields[l].u.data();
        for (std::size_t t = first_stretch(l, q); t < levels_[l].slabs[q].stretches_end; ++t) {
            const auto& s = levels_[l].stretches[t];
            walk<false>(block, l, s, step == 2 ? first_of(s, colour) : 0, step,
                        [&](std::uint32_t, std::size_t i, const Pack& x) { x.store(u[i]); });
        }
    }
    /// Adds the residual of a slab to the right-hand side of the coarse level. Just relaxed nodes of the finest
    /// level's second colour have none.
    void restrict_slab(Block& block, std::size_t l, std::size_t q, Residual& largest) const noexcept {
        const auto& level = levels_[l];
        Row* const coarse = block.fields[l + 1].b.data();
        for (std::size_t t = first_stretch(l, q); t < level.slabs[q].stretches_end; ++t) {
            const auto& s = level.stretches[t];
            const Pack share(1.0 / double(s.coarse_rows)), half(0.5);
            const auto give = [&](std::int32_t x, const Pack& r) {
                for (std::uint32_t c = 0; c < s.coarse_rows; ++c) {
                    Row& row = coarse[s.coarse[c] + std::uint32_t(x)];
                    (Pack::load(row) + r).store(row);
                }
            };
            Pack gathered(0.0); // for the coarse node at or before the place reached
            std::int32_t reached = (s.x & 1) != 0 ? s.x / 2 : (s.x + 1) / 2;
            walk<true>(block, l, s, l == 0 ? first_of(s, 0) : 0, l == 0 ? 2 : 1,
                       [&](std::uint32_t n, std::size_t, const Pack& residual) {
                           largest.add(residual);
                           const std::int32_t x = s.x + std::int32_t(n);
                           const Pack r = share * residual;
                           if (x / 2 != reached) {
                               give(reached, gathered);
                               gathered = Pack(0.0);
                               reached = x / 2;
                           }
                           if ((x & 1) == 0) {
                               gathered = gathered + r;
                           } else {
                               give(reached, gathered + half * r);
                               gathered = half * r;
                               reached = x / 2 + 1;
                           }
                       });
            // The last may lie one beyond the stretch only if it got something.
            const std::int32_t last = s.x + std::int32_t(s.count) - 1;
            if (s.count > 0 && reached <= (last + 1) / 2) give(reached, gathered);
        }
        for (std::size_t j = first_odd(l, q); j < level.slabs[q].odd_end; ++j) {
            const Pack r = odd_residual(block, l, j);
            largest.add_odd(level.odd[j], r);
            for (std::uint32_t n = j == 0 ? 0 : level.odd[j - 1].coarse_end; n < level.odd[j].coarse_end;
                 ++n) {
                Row& row = coarse[level.from_coarse[n].node];
                (Pack::load(row) + Pack(level.from_coarse[n].weight) * r).store(row);
            }
        }
    }
    /// Adds the interpolated coarse solution.
    void prolong(Block& block, std::size_t l, std::size_t q) const noexcept {
        const auto& level = levels_[l];
        Row* const u = block.fields[l].u.data();
        const Row* const coarse = block.fields[l + 1].u.data();
        for (std::size_t t = first_stretch(l, q); t < level.slabs[q].stretches_end; ++t) {
            const auto& s = level.stretches[t];
            const Pack share(1.0 / double(s.coarse_rows)), half(0.5);
            const auto take = [&](std::int32_t x) {
                Pack sum = Pack::load(coarse[s.coarse[0] + std::uint32_t(x)]);
                for (std::uint32_t c = 1; c < s.coarse_rows; ++c)
                    sum = sum + Pack::load(coarse[s.coarse[c] + std::uint32_t(x)]);
                return share * sum;
            };
            Row* here = u + s.first;
            Row* const end = here + s.count;
            std::int32_t x = s.x / 2;
            Pack low = take(x);
            if ((s.x & 1) == 0) {
                (Pack::load(*here) + low).store(*here);
                ++here;
            }
            for (; here < end; here += 2) { // an odd node and the even one after it
                const Pack high = take(++x);
                (Pack::load(here[0]) + half * (low + high)).store(here[0]);
                if (here + 1 < end) (Pack::load(here[1]) + high).store(here[1]);
                low = high;
            }
        }
        for (std::size_t j = first_odd(l, q); j < level.slabs[q].odd_end; ++j) {
            Row& here = u[level.odd[j].node];
            Pack sum = Pack::load(here);
            for (std::uint32_t n = j == 0 ? 0 : level.odd[j - 1].coarse_end; n < level.odd[j].coarse_end; ++n)
                sum = sum + Pack(level.from_coarse[n].weight) * Pack::load(coarse[level.from_coarse[n].node]);
            sum.store(here);
        }
    }

    // ---- one level, in a single pass over memory ---------------------------------------------------

    /// Interpolates from the coarse level (when `from_coarse`), relaxes `sweeps` times, and gives the residual to
    /// the coarse level (when `to_coarse`), each a few slabs behind the one before. Returns that residual's size.
    Residual pass(Block& block, std::size_t l, bool from_coarse, std::size_t sweeps,
                  bool to_coarse) const noexcept {
        const std::size_t slabs = levels_[l].slabs.size();
        const std::size_t start = from_coarse ? 1 : 0;
        const std::size_t lag = l == 0 ? 2 : 1; // slabs a sweep is behind the one before
        const std::size_t steps = slabs + start + lag * sweeps;
        const auto at = [&](std::size_t step, std::size_t behind) {
            return step >= behind && step - behind < slabs ? step - behind : slabs;
        };
        Residual largest{Pack(0.0), Pack(0.0)};
        if (to_coarse) clear(block.fields[l + 1].b);
        for (std::size_t step = 0; step < steps; ++step) {
            if (from_coarse && step < slabs) prolong(block, l, step);
            for (std::size_t sweep = 0; sweep < sweeps; ++sweep) {
                const std::size_t q = at(step, start + lag * sweep);
                if (q < slabs) {
                    relax_odd(block, l, q);
                    relax(block, l, q, l == 0 ? 2 : 1, 0);
                }
                if (l > 0) continue;
                const std::size_t second = at(step, start + lag * sweep + 1);
                if (second < slabs) relax(block, l, second, 2, 1);
            }
            const std::size_t q = at(step, start + lag * sweeps);
            if (to_coarse && q < slabs) restrict_slab(block, l, q, largest);
        }
        return largest;
    }
    /// Solves the coarse level below `l`, whose right-hand side is set, well enough.
    void correct(Block& block, std::size_t l) const noexcept {
        const std::size_t below = l + 1;
        if (below + 1 == levels_.size()) return bottom(block);
        clear(block.fields[below].u);
        pass(block, below, false, 1, true);
        correct(block, below);
        pass(block, below, true, 2, true); // a W-cycle: these levels are small, and thin parts need them well
        correct(block, below);
        pass(block, below, true, 1, false);
    }

    static constexpr std::size_t finest_sweeps = 3;
    static constexpr std::size_t finest_entries = 2 * D;
    static constexpr std::size_t row_count = detail::power(3, D - 1);
    static constexpr std::size_t middle_row = row_count / 2;
    static constexpr std::array<std::size_t, row_count> row_distance = [] {
        std::array<std::size_t, row_count> distance{};
        for (std::size_t r = 0; r < row_count; ++r) distance[r] = detail::Places<D>::distance(3 * r + 1);
        return distance;
    }();

    std::vector<detail::Level<D>> levels_;
    double reach_ = 1;       ///< error per inner residual at most
    Eigen::MatrixXd factor_; ///< lower Cholesky factor of the bottom level; empty where that is large
};

} // namespace cageform::inline CAGEFORM_ABI
