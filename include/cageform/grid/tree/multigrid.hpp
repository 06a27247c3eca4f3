// Multigrid on a tree of cells, for sixteen functions at a time.
//
// `start` is full multigrid: it solves the coarsest level; then, on each finer level, it interpolates the
// solution and runs one cycle. After that the caller repeats `cycle`. coordinates/harmonic/tree_solver.hpp
// stops when change · ratio is at most accuracy/100 in 2D and accuracy/10 in 3D. Here change is the change of
// the last cycle, and ratio is its ratio to the change before, limited to 0.2 … 0.9.
//
// One V-cycle (`v_cycle`) relaxes twice by Gauss-Seidel and restricts the residual to the next coarser level.
// It computes a correction there by the same method, adds the interpolated correction, and relaxes once more.
// The rows, the prolongation and its transpose are made by grid/tree/hierarchy.hpp.
//
// Most boundary functions are nearly zero in most of the domain. With a cutoff, cycles visit only the active
// nodes: those where a function exceeds the cutoff, those with boundary data, and a ring of neighbours. The
// outermost active nodes, which may have inactive neighbours, are the rim. The set grows when a function
// exceeds the cutoff on the rim.
#pragma once

#include <cageform/core/detail/flush_denormals.hpp>
#include <cageform/core/detail/simd.hpp>
#include <cageform/grid/multigrid/node_values.hpp>
#include <cageform/grid/tree/hierarchy.hpp>

#include <functional>

namespace cageform::inline CAGEFORM_ABI::grid {

/// The equations of a tree's nodes on all levels, and the cycles that solve them in float. `refine` adds
/// the solution to one in double and makes the residual the new right-hand side, so any tolerance can be
/// reached. Denormal numbers are flushed to zero.
template <std::size_t D>
class TreeMultigrid {
public:
    static constexpr std::size_t width = detail::functions_together;
    using Values = detail::NodeValues;
    using Row = detail::NodeRow;
    /// Called several times per second. If it returns false, the work stops, and the block is invalid until
    /// `start`.
    using KeepGoing = std::function<bool()>;

    /// The solution of one group of functions and the working memory.
    class Block {
    public:
        Values value(std::uint32_t node) const noexcept {
            Values values{};
            if (!refined_.empty()) values = refined_[node];
            for (std::size_t k = 0; k < width; ++k) values[k] += double(levels_[0].u[node][k]);
            return values;
        }
        /// Returns the number of active nodes on the finest level.
        std::size_t active() const noexcept { return levels_[0].list.size(); }
        /// Returns the nodes whose values may differ from zero, unordered.
        std::span<const std::uint32_t> valued() const noexcept {
            return {levels_[0].touched.data(), levels_[0].touched.size()};
        }

    private:
        friend TreeMultigrid;
        static constexpr std::uint8_t once = 2; ///< a flag of nodes that have or had a flag
        struct Level : detail::Fields {
            Buffer<std::uint8_t> flags;      ///< per node
            Buffer<std::uint32_t> touched{}; ///< nodes that have or had a flag; values of others are zero
            std::size_t with_data = 0;       ///< number of nodes with boundary data, first in `touched`
            Buffer<std::uint32_t> list{};    ///< the active nodes, ascending
            Buffer<std::uint32_t> rim{};     ///< active nodes that may have inactive neighbours

            void mark(std::uint32_t n, std::uint8_t flag) {
                if (flags[n] == 0) touched.push_back(n);
                flags[n] |= flag | once;
            }
        };
        std::vector<Level> levels_;
        Buffer<Values> refined_; ///< the solution in double; empty before `refine`
        std::span<const TreeData> data_;
        std::size_t first_ = 0;
        double cutoff_ = 0;
        bool is_zero_ = false; ///< whether all values that are not touched are zero
        const KeepGoing* keep_going_ = nullptr;
    };

    TreeMultigrid(const CutTree<D>& tree, const TreeNodes<D>& nodes)
        : TreeMultigrid(tree, nodes, links_of(tree, nodes)) {}
    TreeMultigrid(const CutTree<D>& tree, const TreeNodes<D>& nodes, TreeLinks links,
                  const Running& running = {})
        : data_(std::move(links.data))
        , diagonal_(links.equations.diagonal)
        , decay_(std::move(links.decay))
        , levels_(detail::TreeCoarsener<D>(tree, nodes, decay(), running).make(std::move(links.equations))) {}

    std::uint32_t unknowns() const noexcept { return levels_[0].nodes(); }
    std::span<const detail::TreeLevel> levels() const noexcept { return levels_; }
    std::span<const TreeData> data() const noexcept { return {data_.data(), data_.size()}; }
    /// See TreeLinks::decay.
    std::span<const float> decay() const noexcept { return {decay_.data(), decay_.size()}; }
    std::size_t bytes() const noexcept {
        std::size_t sum = data_.capacity() * sizeof(TreeData) + diagonal_.capacity() * sizeof(double) +
                          decay_.capacity() * sizeof(float);
        for (const auto& level : levels_) sum += level.bytes();
        return sum;
    }
    std::size_t block_bytes(bool refined) const noexcept {
        std::size_t rows = 0;
        for (const auto& level : levels_) rows += level.nodes();
        return rows * (2 * sizeof(Row) + 3 * sizeof(std::uint32_t) + 1) +
               (refined ? unknowns() * sizeof(Values) : 0);
    }
    Block make_block() const {
        Block block;
        for (const auto& level : levels_) {
            auto& fields = block.levels_.emplace_back();
            fields.u.resize(level.nodes());
            fields.b.resize(level.nodes());
            fields.flags = Buffer<std::uint8_t>(level.nodes(), 0);
        }
        return block;
    }

    /// Starts a group with functions first … first + width − 1: one cycle per coarse level from the
    /// coarsest up. The finest level then has the interpolated solution; call `cycle`.
    ///
    ///   cutoff  solves at nodes where any function is larger; 0: everywhere
    ///
    /// Nodes that are not solved for keep the values interpolated from the next coarser level. Each coarser
    /// level has a quarter of the cutoff, so it is solved in a larger region. Values below a thousandth of
    /// the cutoff for all functions become zero. A value that is not solved for has the relative error of the
    /// coarser level; the largest error measured was a quarter of the cutoff.
    void start(Block& block, std::size_t first, double cutoff = 0, const KeepGoing& keep_going = {}) const {
        const detail::FlushDenormals flush;
        block.keep_going_ = &keep_going;
        block.first_ = first;
        block.cutoff_ = cutoff;
        block.refined_.clear();
        clear(block);
        set_data(block);
        const std::size_t coarsest = levels_.size() - 1;
        for (std::uint32_t n = 0; n < levels_[coarsest].nodes(); ++n) block.levels_[coarsest].mark(n, active);
        list_active(block, coarsest);
        for (std::size_t l = coarsest; l > 0; --l) {
            (void)v_cycle(block, l);
            if (cutoff > 0) activate_more(block, l);
            interpolate_solution(block, l - 1);
            relax_data(block, l - 1);
        }
    }

    /// Runs one V(2,1) cycle. Returns the largest change of the first `functions` functions. With a cutoff,
    /// nodes may become active.
    double cycle(Block& block, std::size_t functions, const KeepGoing& keep_going = {}) const {
        const detail::FlushDenormals flush;
        block.keep_going_ = &keep_going;
        const Simd largest = v_cycle(block, 0);
        if (block.cutoff_ > 0) activate_more(block, 0);
        detail::NodeRow row;
        largest.store(row);
        double change = 0;
        for (std::size_t k = 0; k < functions; ++k) change = (std::max)(change, double(row[k]));
        return change;
    }

    /// Adds the functions to the solution in double. The residual becomes the right-hand side of the next
    /// cycles.
    void refine(Block& block, const KeepGoing& keep_going = {}) const {
        const detail::FlushDenormals flush;
        block.keep_going_ = &keep_going;
        auto& u = block.levels_[0].u;
        auto& b = block.levels_[0].b;
        if (block.refined_.empty()) block.refined_ = Buffer<Values>(unknowns(), Values{});
        for_each(block, unknowns(), [&](std::size_t n) {
            for (std::size_t k = 0; k < width; ++k) block.refined_[n][k] += double(u[n][k]);
            Simd(0.0f).store(u[n]);
        });
        const auto data = [&](std::uint32_t n, Values& sum) {
            for (std::size_t k = 0; k < width; ++k) sum[k] -= diagonal_[n] * block.refined_[n][k];
            for (const auto& [column, weight] : levels_[0].neighbours.of(n)) {
                for (std::size_t k = 0; k < width; ++k) sum[k] += double(weight) * block.refined_[column][k];
            }
        };
        // Boundary data is sorted by handle. Few nodes have data; they are collected first, and their data is
        // summed in double.
        Buffer<Values> rows;
        Buffer<std::uint32_t> data_nodes;
        for (const TreeData& entry : block.data_) data_nodes.push_back(entry.node);
        std::sort(data_nodes.begin(), data_nodes.end());
        data_nodes.erase_from(std::unique(data_nodes.begin(), data_nodes.end()));
        rows = Buffer<Values>(data_nodes.size(), Values{});
        for (const auto& [handle, node, weight] : block.data_) {
            const auto at = std::lower_bound(data_nodes.begin(), data_nodes.end(), node);
            rows[std::size_t(at - data_nodes.begin())][handle - block.first_] += double(weight);
        }
        std::size_t next = 0;
        for_each(block, unknowns(), [&](std::size_t n) {
            Values sum{};
            if (next < data_nodes.size() && data_nodes[next] == n) sum = rows[next++];
            data(std::uint32_t(n), sum);
            for (std::size_t k = 0; k < width; ++k) b[n][k] = float(sum[k]);
        });
    }

private:
    using Simd = detail::Simd<float>;
    static constexpr std::uint8_t active = 1; ///< a flag: the node is solved for
    static constexpr std::size_t coarsest_sweeps = 15, data_sweeps = 2;

    /// Calls f(n) for n < count in order, and regularly calls KeepGoing. Returns false if KeepGoing returned
    /// false.
    template <class F>
    static bool for_each(const Block& block, std::size_t count, const F& f) {
        constexpr std::size_t together = std::size_t{1} << 18; // some hundredths of a second
        for (std::size_t begin = 0; begin < count; begin += together) {
            if (begin > 0 && *block.keep_going_ && !(*block.keep_going_)()) return false;
            const std::size_t end = (std::min)(count, begin + together);
            for (std::size_t n = begin; n < end; ++n) f(n);
        }
        return true;
    }

    // ---- active nodes -----------------------------------------------------------------------------

    static void clear(Block& block) {
        bool whole = true;
        for (auto& level : block.levels_) {
            const auto clear_node = [&level](std::size_t n) {
                Simd(0.0f).store(level.u[n]);
                Simd(0.0f).store(level.b[n]);
                level.flags[n] = 0;
            };
            if (!block.is_zero_) whole = for_each(block, level.flags.size(), clear_node) && whole;
            whole =
                for_each(block, level.touched.size(), [&](std::size_t k) { clear_node(level.touched[k]); }) &&
                whole;
            level.touched.clear();
            level.list.clear();
            level.rim.clear();
        }
        block.is_zero_ = whole;
    }
    /// Sets the right-hand sides of all levels: the data on the finest level, restricted to the others.
    void set_data(Block& block) const {
        const auto by_handle = [](const TreeData& a, std::size_t handle) { return a.handle < handle; };
        const auto from = std::lower_bound(data_.begin(), data_.end(), block.first_, by_handle);
        const auto to = std::lower_bound(from, data_.end(), block.first_ + width, by_handle);
        block.data_ = {from, to};
        for (const auto& [handle, node, weight] : block.data_) {
            block.levels_[0].b[node][handle - block.first_] += weight;
            block.levels_[0].mark(node, 0);
        }
        for (std::size_t l = 0; l < levels_.size(); ++l) {
            auto& level = block.levels_[l];
            level.with_data = level.touched.size();
            std::sort(level.touched.begin(), level.touched.end());
            if (l + 1 == levels_.size()) return;
            auto& coarse = block.levels_[l + 1];
            for (const std::uint32_t n : level.touched) {
                for (const auto& [column, weight] : levels_[l].interpolation.of(n)) {
                    coarse.mark(column, 0);
                    multiply_add(Simd(weight), Simd::load(level.b[n]), Simd::load(coarse.b[column]))
                        .store(coarse.b[column]);
                }
            }
        }
    }
    static bool any_larger(const Row& row, float limit) noexcept {
        bool any = false;
        for (std::size_t k = 0; k < width; ++k) any |= std::fabs(row[k]) > limit;
        return any;
    }
    /// Returns the cutoff of a level. Each coarser level has a quarter of it, because its error is four times
    /// as large.
    static float cutoff_of(const Block& block, std::size_t l) noexcept {
        return float(std::ldexp(block.cutoff_, -2 * int(l)));
    }
    /// Lists the active nodes of a level. On coarser levels activates the nodes that remain.
    void list_active(Block& block, std::size_t l) const {
        auto& level = block.levels_[l];
        level.list.clear();
        for (std::uint32_t n = 0; n < level.flags.size(); ++n) {
            if ((level.flags[n] & active) != 0) level.list.push_back(n);
        }
        for (; l + 1 < levels_.size(); ++l) {
            auto& coarse = block.levels_[l + 1];
            for (const std::uint32_t n : coarse.list) coarse.flags[n] &= std::uint8_t(~active);
            coarse.list.clear();
            for (const std::uint32_t n : block.levels_[l].list) {
                const std::uint32_t number = levels_[l].numbers[n];
                if (number == TreeNodes<D>::none) continue;
                coarse.mark(number, active);
                coarse.list.push_back(number);
            }
        }
    }
    /// Interpolates the functions from the next coarser level and clears them there for corrections. The
    /// interpolation lacks the boundary values, so relax_data follows. Activates nodes with data and nodes
    /// where a function exceeds the cutoff.
    void interpolate_solution(Block& block, std::size_t l) const {
        auto& level = block.levels_[l];
        auto& coarse = block.levels_[l + 1];
        const float cutoff = cutoff_of(block, l), least = float(1e-3 * block.cutoff_);
        const bool everywhere = block.cutoff_ == 0;
        for (std::size_t k = 0; k < level.with_data; ++k) level.mark(level.touched[k], active);
        for_each(block, levels_[l].nodes(), [&](std::size_t at) {
            const auto n = std::uint32_t(at);
            bool any = false;
            for (const auto& [column, weight] : levels_[l].interpolation.of(n))
                any = any || coarse.flags[column] != 0;
            if (any) {
                Simd sum(0.0f);
                for (const auto& [column, weight] : levels_[l].interpolation.of(n))
                    sum = multiply_add(Simd(weight), Simd::load(coarse.u[column]), sum);
                Row row;
                sum.store(row);
                any = any_larger(row, least);
                if (any) level.mark(n, any_larger(row, cutoff) ? active : std::uint8_t{0});
                // Values that are not solved for are clamped to zero, because the functions are not negative.
                if ((level.flags[n] & active) == 0) sum = (detail::max)(sum, Simd(0.0f));
                if (level.flags[n] != 0) sum.store(level.u[n]);
            }
            if (everywhere) level.mark(n, active);
        });
        for (const std::uint32_t n : coarse.touched) Simd(0.0f).store(coarse.u[n]);
        level.rim.clear();
        for (std::uint32_t n = 0; n < levels_[l].nodes() && !everywhere; ++n) {
            if ((level.flags[n] & active) != 0) level.rim.push_back(n);
        }
        add_ring(block, l);
        list_active(block, l);
    }
    /// Activates the neighbours of the rim. They form the new rim.
    void add_ring(Block& block, std::size_t l) const {
        auto& level = block.levels_[l];
        Buffer<std::uint32_t> rim;
        for (const std::uint32_t n : level.rim) {
            for (const auto& [column, weight] : levels_[l].neighbours.of(n)) {
                if ((level.flags[column] & active) != 0) continue;
                level.mark(column, active);
                rim.push_back(column);
            }
        }
        level.rim = std::move(rim);
    }
    /// Activates more nodes where a function exceeds the cutoff on the rim.
    void activate_more(Block& block, std::size_t l) const {
        auto& level = block.levels_[l];
        Buffer<std::uint32_t> large, rest;
        const float cutoff = cutoff_of(block, l);
        for (const std::uint32_t n : level.rim) (any_larger(level.u[n], cutoff) ? large : rest).push_back(n);
        level.rim = std::move(large);
        add_ring(block, l);
        const bool grown = !level.rim.empty();
        for (const std::uint32_t n : rest) level.rim.push_back(n);
        if (grown) list_active(block, l);
    }

    // ---- cycles, on the active nodes ------------------------------------------------------------------

    CAGEFORM_DETAIL_INLINE Simd sum_about(const typename Block::Level& at, std::size_t l,
                                          std::uint32_t n) const noexcept {
        const auto row = levels_[l].neighbours.of(n);
        Simd even = Simd::load(at.b[n]), odd(0.0f); // two independent sums hide the latency of additions
        std::size_t k = 0;
        for (; k + 2 <= row.size(); k += 2) {
            even = multiply_add(Simd(row[k].weight), Simd::load(at.u[row[k].column]), even);
            odd = multiply_add(Simd(row[k + 1].weight), Simd::load(at.u[row[k + 1].column]), odd);
        }
        if (k < row.size()) even = multiply_add(Simd(row[k].weight), Simd::load(at.u[row[k].column]), even);
        return even + odd;
    }
    /// One Gauss-Seidel sweep over the active nodes, in Morton order.
    ///
    ///   largest  out: the largest change, if keeps_largest
    template <bool keeps_largest = false>
    void relax(Block& block, std::size_t l, [[maybe_unused]] Simd* largest = nullptr) const {
        auto& at = block.levels_[l];
        for_each(block, at.list.size(), [&](std::size_t k) {
            const std::uint32_t n = at.list[k];
            const Simd u = sum_about(at, l, n) * Simd(levels_[l].inverse_diagonal[n]);
            if constexpr (keeps_largest) *largest = (detail::max)(*largest, abs(u - Simd::load(at.u[n])));
            u.store(at.u[n]);
        });
    }
    /// Relaxes only the nodes with data. The prolongation lacks the terms of boundary values, so
    /// interpolate_solution gives too small values next to the boundary. These sweeps correct them.
    void relax_data(Block& block, std::size_t l) const noexcept {
        auto& at = block.levels_[l];
        for (std::size_t sweep = 0; sweep < data_sweeps; ++sweep) {
            for (std::size_t k = 0; k < at.with_data; ++k) {
                const std::uint32_t n = at.touched[k];
                (sum_about(at, l, n) * Simd(levels_[l].inverse_diagonal[n])).store(at.u[n]);
            }
        }
    }
    /// Sets the right-hand side of the next level to the restricted residual.
    void restrict_residual(Block& block, std::size_t l) const {
        const auto& at = block.levels_[l];
        auto& coarse = block.levels_[l + 1];
        for (const std::uint32_t n : coarse.list) Simd(0.0f).store(coarse.b[n]);
        for_each(block, at.list.size(), [&](std::size_t k) {
            const std::uint32_t n = at.list[k];
            const Simd r =
                sum_about(at, l, n) - Simd::load(at.u[n]) * Simd(1 / levels_[l].inverse_diagonal[n]);
            for (const auto& [column, weight] : levels_[l].interpolation.of(n)) {
                if ((coarse.flags[column] & active) != 0)
                    multiply_add(Simd(weight), r, Simd::load(coarse.b[column])).store(coarse.b[column]);
            }
        });
    }
    /// Adds the correction interpolated from the next level. Updates the largest change.
    void interpolate(Block& block, std::size_t l, Simd& largest) const {
        auto& at = block.levels_[l];
        const auto& coarse = block.levels_[l + 1].u;
        for_each(block, at.list.size(), [&](std::size_t k) {
            const std::uint32_t n = at.list[k];
            Simd sum(0.0f);
            for (const auto& [column, weight] : levels_[l].interpolation.of(n))
                sum = multiply_add(Simd(weight), Simd::load(coarse[column]), sum);
            largest = (detail::max)(largest, abs(sum));
            (Simd::load(at.u[n]) + sum).store(at.u[n]);
        });
    }
    /// Runs one V-cycle from a level down. Returns the largest change.
    Simd v_cycle(Block& block, std::size_t l) const {
        Simd largest(0.0f);
        relax<true>(block, l, &largest);
        if (l + 1 == levels_.size()) {
            for (std::size_t sweep = 1; sweep < coarsest_sweeps; ++sweep) relax(block, l);
            return largest;
        }
        relax(block, l);
        restrict_residual(block, l);
        for (const std::uint32_t n : block.levels_[l + 1].list) Simd(0.0f).store(block.levels_[l + 1].u[n]);
        (void)v_cycle(block, l + 1);
        interpolate(block, l, largest);
        relax(block, l);
        return largest;
    }

    Buffer<TreeData> data_;
    Buffer<double> diagonal_;
    Buffer<float> decay_;
    std::vector<detail::TreeLevel> levels_; ///< the finest first
};

} // namespace cageform::inline CAGEFORM_ABI::grid
