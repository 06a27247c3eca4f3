// Multigrid on a tree of cells for sixteen functions at a time.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/grid/detail/node_values.hpp>
#include <cageform/grid/tree/tree_hierarchy.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// The equations of a tree's nodes and their levels. The cycles work in float; `refine` takes what
/// they have found into double, so that any tolerance can be met.
template <std::size_t D>
class TreeMultigrid {
public:
    static constexpr std::size_t width = detail::functions_together;
    using Values = detail::NodeValues;
    using Row = detail::NodeRow;

    /// The memory of one group of functions.
    class Block {
    public:
        Values value(std::uint32_t node) const noexcept {
            Values values{};
            if (!refined_.empty()) values = refined_[node];
            for (std::size_t k = 0; k < width; ++k) values[k] += double(levels_[0].u[node][k]);
            return values;
        }
        /// The nodes whose values are not left at zero.
        std::size_t active() const noexcept { return levels_[0].list.size(); }

    private:
        friend TreeMultigrid;
        struct Level : detail::Fields {
            Buffer<std::uint8_t> flags;   ///< by node
            Buffer<std::uint32_t> list{}; ///< the active nodes, ascending
        };
        std::vector<Level> levels_;
        Buffer<Values> refined_; ///< empty until it is needed
        std::span<const TreeData> data_;
        std::size_t first_ = 0;
        double cutoff_ = 0;
    };

    TreeMultigrid(const CutTree<D>& tree, const TreeNodes<D>& nodes)
        : TreeMultigrid(tree, nodes, links_of(tree, nodes)) {}
    TreeMultigrid(const CutTree<D>& tree, const TreeNodes<D>& nodes, TreeLinks links)
        : data_(std::move(links.data))
        , diagonal_(links.equations.diagonal)
        , levels_(detail::TreeCoarsener<D>(tree, nodes).make(std::move(links.equations))) {}

    std::uint32_t unknowns() const noexcept { return levels_[0].nodes(); }
    std::span<const detail::TreeLevel> levels() const noexcept { return levels_; }
    std::span<const TreeData> data() const noexcept { return {data_.data(), data_.size()}; }
    std::size_t bytes() const noexcept {
        std::size_t sum = data_.capacity() * sizeof(TreeData) + diagonal_.capacity() * sizeof(double);
        for (const auto& level : levels_) sum += level.bytes();
        return sum;
    }
    /// Of a block, refined or not.
    std::size_t block_bytes(bool refined) const noexcept {
        std::size_t rows = 0;
        for (const auto& level : levels_) rows += level.nodes();
        return rows * (2 * sizeof(Row) + sizeof(std::uint32_t) + 1) +
               (refined ? unknowns() * sizeof(Values) : 0);
    }
    Block make_block() const {
        Block block;
        for (const auto& level : levels_) {
            auto& fields = block.levels_.emplace_back();
            fields.u.resize(level.nodes());
            fields.b.resize(level.nodes());
            fields.flags.resize(level.nodes());
        }
        return block;
    }

    /// Begins with functions first … first + width − 1: from the coarsest level up a cycle on each
    /// but the finest, for which `cycle` is to be called.
    ///
    ///   cutoff  the functions are solved for where any is larger, and are zero elsewhere. As they
    ///           are given no data there, they are too small by about twice that at most (by 1.8 as
    ///           measured). 0: everywhere
    void start(Block& block, std::size_t first, double cutoff = 0) const {
        block.first_ = first;
        block.cutoff_ = cutoff;
        block.refined_.clear();
        for (auto& level : block.levels_) {
            set_zero(level.u);
            set_zero(level.b);
            std::fill(level.flags.begin(), level.flags.end(), cutoff > 0 ? std::uint8_t{0} : active);
        }
        set_data(block);
        const std::size_t coarsest = levels_.size() - 1;
        auto& bottom = block.levels_[coarsest].flags;
        std::fill(bottom.begin(), bottom.end(), active);
        list_active(block, coarsest);
        for (std::size_t l = coarsest;; --l) {
            if (l < coarsest) {
                interpolate_all(block, l);
                if (cutoff > 0) add_ring(block, l);
                list_active(block, l);
            }
            if (l == 0) return;
            (void)descend(block, l);
            grow(block, l);
        }
    }

    /// One V(2,1) cycle; returns the largest change it made to any of the first `functions`. With a
    /// cutoff the nodes that are solved for may become more.
    double cycle(Block& block, std::size_t functions) const {
        const Simd largest = descend(block, 0);
        grow(block, 0);
        detail::NodeRow row;
        largest.store(row);
        double change = 0;
        for (std::size_t k = 0; k < functions; ++k) change = std::max(change, double(row[k]));
        return change;
    }

    /// Takes the functions into double; what remains of the equations becomes their right-hand side.
    void refine(Block& block) const {
        auto& u = block.levels_[0].u;
        auto& b = block.levels_[0].b;
        if (block.refined_.empty()) block.refined_ = Buffer<Values>(unknowns(), Values{});
        for (std::uint32_t n = 0; n < unknowns(); ++n) {
            for (std::size_t k = 0; k < width; ++k) block.refined_[n][k] += double(u[n][k]);
        }
        detail::set_zero(u);
        const auto data = [&](std::uint32_t n, Values& sum) {
            for (std::size_t k = 0; k < width; ++k) sum[k] -= diagonal_[n] * block.refined_[n][k];
            for (const auto& [column, weight] : levels_[0].neighbours.of(n)) {
                for (std::size_t k = 0; k < width; ++k) sum[k] += double(weight) * block.refined_[column][k];
            }
        };
        // Data is sorted by handle: first all that is sparse, in double.
        Buffer<Values> rows;
        Buffer<std::uint32_t> places;
        for (const TreeData& part : block.data_) places.push_back(part.node);
        std::sort(places.begin(), places.end());
        places.erase_from(std::unique(places.begin(), places.end()));
        rows = Buffer<Values>(places.size(), Values{});
        for (const auto& [handle, node, weight] : block.data_) {
            const auto at = std::lower_bound(places.begin(), places.end(), node);
            rows[std::size_t(at - places.begin())][handle - block.first_] += double(weight);
        }
        std::size_t next = 0;
        for (std::uint32_t n = 0; n < unknowns(); ++n) {
            Values sum{};
            if (next < places.size() && places[next] == n) sum = rows[next++];
            data(n, sum);
            for (std::size_t k = 0; k < width; ++k) b[n][k] = float(sum[k]);
        }
    }

private:
    using Simd = detail::Simd<float>;
    static constexpr std::uint8_t active = 1, with_data = 2, ringed = 4; ///< flags
    static constexpr std::size_t coarsest_sweeps = 15;

    // ---- which nodes are solved for -------------------------------------------------------------------

    /// The right-hand sides of all levels, and the nodes that have one.
    void set_data(Block& block) const {
        const auto by_handle = [](const TreeData& a, std::size_t handle) { return a.handle < handle; };
        const auto from = std::lower_bound(data_.begin(), data_.end(), block.first_, by_handle);
        const auto to = std::lower_bound(from, data_.end(), block.first_ + width, by_handle);
        block.data_ = {from, to};
        for (const auto& [handle, node, weight] : block.data_) {
            block.levels_[0].b[node][handle - block.first_] += weight;
            block.levels_[0].flags[node] |= with_data;
        }
        for (std::size_t l = 0; l + 1 < levels_.size(); ++l) {
            auto& fine = block.levels_[l];
            auto& coarse = block.levels_[l + 1];
            for (std::uint32_t n = 0; n < levels_[l].nodes(); ++n) {
                if ((fine.flags[n] & with_data) == 0) continue;
                for (const auto& [column, weight] : levels_[l].interpolation.of(n)) {
                    coarse.flags[column] |= with_data;
                    multiply_add(Simd(weight), Simd::load(fine.b[n]), Simd::load(coarse.b[column]))
                        .store(coarse.b[column]);
                }
            }
        }
    }
    static float largest_lane(const Row& row) noexcept {
        float largest = 0;
        for (std::size_t k = 0; k < width; ++k) largest = std::max(largest, std::fabs(row[k]));
        return largest;
    }
    /// Lists the active nodes of a level, and of the coarser ones those of them that stay.
    void list_active(Block& block, std::size_t l) const {
        auto& level = block.levels_[l];
        level.list.clear();
        for (std::uint32_t n = 0; n < level.flags.size(); ++n) {
            if ((level.flags[n] & active) != 0) level.list.push_back(n);
        }
        for (; l + 1 < levels_.size(); ++l) {
            auto& coarse = block.levels_[l + 1];
            for (const std::uint32_t n : coarse.list) {
                coarse.flags[n] &= std::uint8_t(~active);
                Simd(0.0f).store(coarse.u[n]);
            }
            coarse.list.clear();
            for (const std::uint32_t n : block.levels_[l].list) {
                const std::uint32_t number = levels_[l].numbers[n];
                if (number == TreeNodes<D>::none) continue;
                coarse.flags[number] |= active;
                coarse.list.push_back(number);
            }
        }
    }
    /// Takes over the functions of the next level. Those that are larger than the cutoff are active,
    /// and those with data.
    void interpolate_all(Block& block, std::size_t l) const noexcept {
        auto& level = block.levels_[l];
        const auto& coarse = block.levels_[l + 1];
        for (std::uint32_t n = 0; n < levels_[l].nodes(); ++n) {
            bool any = false;
            for (const auto& [column, weight] : levels_[l].interpolation.of(n))
                any = any || (coarse.flags[column] & active) != 0;
            if ((level.flags[n] & with_data) != 0) level.flags[n] |= active;
            if (!any) continue;
            Simd sum(0.0f);
            for (const auto& [column, weight] : levels_[l].interpolation.of(n))
                sum = multiply_add(Simd(weight), Simd::load(coarse.u[column]), sum);
            sum.store(level.u[n]);
            if (block.cutoff_ == 0 || double(largest_lane(level.u[n])) > block.cutoff_)
                level.flags[n] |= active;
        }
    }
    /// Makes the neighbours of active nodes active, and leaves zero elsewhere.
    void add_ring(Block& block, std::size_t l) const {
        auto& level = block.levels_[l];
        for (std::uint32_t n = 0; n < level.flags.size(); ++n) {
            if ((level.flags[n] & active) == 0) continue;
            for (const auto& [column, weight] : levels_[l].neighbours.of(n)) level.flags[column] |= ringed;
        }
        for (std::uint32_t n = 0; n < level.flags.size(); ++n) {
            if ((level.flags[n] & ringed) != 0)
                level.flags[n] = std::uint8_t((level.flags[n] & ~ringed) | active);
            if ((level.flags[n] & active) == 0) Simd(0.0f).store(level.u[n]);
        }
    }
    /// Adds nodes where functions larger than the cutoff end at nodes that are not active.
    void grow(Block& block, std::size_t l) const {
        if (block.cutoff_ == 0) return;
        const std::size_t rings = l == 0 ? 3 : 1;
        for (bool grown = true; grown;) {
            auto& level = block.levels_[l];
            grown = false;
            for (const std::uint32_t n : level.list) {
                if (!(double(largest_lane(level.u[n])) > block.cutoff_)) continue;
                for (const auto& [column, weight] : levels_[l].neighbours.of(n)) {
                    if ((level.flags[column] & active) != 0) continue;
                    level.flags[column] |= active;
                    grown = true;
                }
            }
            if (!grown) return;
            for (std::size_t ring = 0; ring < rings; ++ring) add_ring(block, l);
            list_active(block, l);
            (void)descend(block, l);
        }
    }

    // ---- cycles, on the active nodes ------------------------------------------------------------------

    Simd residual(const Block& block, std::size_t l, std::uint32_t n) const noexcept {
        const auto& [u, b] = static_cast<const detail::Fields&>(block.levels_[l]);
        Simd r = Simd::load(b[n]) - Simd::load(u[n]) * Simd(1 / levels_[l].inverse_diagonal[n]);
        for (const auto& [column, weight] : levels_[l].neighbours.of(n))
            r = multiply_add(Simd(weight), Simd::load(u[column]), r);
        return r;
    }
    /// Gauss and Seidel along the Morton curve.
    ///
    ///   largest  the largest change, if asked for
    template <bool keeps_largest = false>
    void relax(Block& block, std::size_t l, [[maybe_unused]] Simd* largest = nullptr) const noexcept {
        const auto& level = levels_[l];
        auto& at = block.levels_[l];
        for (const std::uint32_t n : at.list) {
            Simd sum = Simd::load(at.b[n]);
            for (const auto& [column, weight] : level.neighbours.of(n))
                sum = multiply_add(Simd(weight), Simd::load(at.u[column]), sum);
            sum = sum * Simd(level.inverse_diagonal[n]);
            if constexpr (keeps_largest) *largest = (detail::max)(*largest, abs(sum - Simd::load(at.u[n])));
            sum.store(at.u[n]);
        }
    }
    void restrict_residual(Block& block, std::size_t l) const noexcept {
        auto& coarse = block.levels_[l + 1];
        for (const std::uint32_t n : coarse.list) Simd(0.0f).store(coarse.b[n]);
        for (const std::uint32_t n : block.levels_[l].list) {
            const Simd r = residual(block, l, n);
            for (const auto& [column, weight] : levels_[l].interpolation.of(n)) {
                if ((coarse.flags[column] & active) != 0)
                    multiply_add(Simd(weight), r, Simd::load(coarse.b[column])).store(coarse.b[column]);
            }
        }
    }
    /// Adds the next level's functions; keeps the largest change.
    void interpolate(Block& block, std::size_t l, Simd& largest) const noexcept {
        auto& at = block.levels_[l];
        const auto& coarse = block.levels_[l + 1].u;
        for (const std::uint32_t n : at.list) {
            Simd sum(0.0f);
            for (const auto& [column, weight] : levels_[l].interpolation.of(n))
                sum = multiply_add(Simd(weight), Simd::load(coarse[column]), sum);
            largest = (detail::max)(largest, abs(sum));
            (Simd::load(at.u[n]) + sum).store(at.u[n]);
        }
    }
    Simd descend(Block& block, std::size_t l) const noexcept {
        Simd largest(0.0f);
        relax<true>(block, l, &largest);
        if (l + 1 == levels_.size()) {
            for (std::size_t sweep = 1; sweep < coarsest_sweeps; ++sweep) relax(block, l);
            return largest;
        }
        relax(block, l);
        restrict_residual(block, l);
        for (const std::uint32_t n : block.levels_[l + 1].list) Simd(0.0f).store(block.levels_[l + 1].u[n]);
        (void)descend(block, l + 1);
        interpolate(block, l, largest);
        relax(block, l);
        return largest;
    }

    Buffer<TreeData> data_;
    Buffer<double> diagonal_;
    std::vector<detail::TreeLevel> levels_; ///< the finest first
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
