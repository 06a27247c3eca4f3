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
            for (std::size_t k = 0; k < width; ++k) values[k] += double(fields_[0].u[node][k]);
            return values;
        }

    private:
        friend TreeMultigrid;
        std::vector<detail::Fields> fields_; ///< by level
        Buffer<Values> refined_;             ///< empty until it is needed
        std::span<const TreeData> data_;
        std::size_t first_ = 0;
    };

    /// What is left of the functions' errors after a cycle.
    struct Error {
        double correction; ///< the largest change of any function, much like the error before
        Values bound;      ///< of each, by the maximum principle alone; far above
    };

    TreeMultigrid(const CutTree<D>& tree, const TreeNodes<D>& nodes)
        : TreeMultigrid(tree, nodes, links_of(tree, nodes)) {}
    TreeMultigrid(const CutTree<D>& tree, const TreeNodes<D>& nodes, TreeLinks links)
        : data_(std::move(links.data))
        , volume_(std::move(links.volume))
        , diagonal_(links.equations.diagonal)
        , levels_(detail::TreeCoarsener<D>(tree, nodes).make(std::move(links.equations)))
        , reach_(0.5 * std::ldexp(1.0, 2 * int(tree.boundary().depth()))) {}

    std::uint32_t unknowns() const noexcept { return levels_[0].nodes(); }
    std::span<const detail::TreeLevel> levels() const noexcept { return levels_; }
    std::span<const TreeData> data() const noexcept { return {data_.data(), data_.size()}; }
    std::size_t bytes() const noexcept {
        std::size_t sum = data_.capacity() * sizeof(TreeData) + volume_.capacity() * sizeof(float) +
                          diagonal_.capacity() * sizeof(double);
        for (const auto& level : levels_) sum += level.bytes();
        return sum;
    }
    /// Of a block, refined or not.
    std::size_t block_bytes(bool refined) const noexcept {
        std::size_t rows = 0;
        for (const auto& level : levels_) rows += level.nodes();
        return 2 * rows * sizeof(Row) + (refined ? unknowns() * sizeof(Values) : 0);
    }
    Block make_block() const {
        Block block;
        for (const auto& level : levels_) {
            auto& fields = block.fields_.emplace_back();
            fields.u.resize(level.nodes());
            fields.b.resize(level.nodes());
        }
        return block;
    }

    /// Begins with functions first … first + width − 1: a cycle on every level from the coarsest up.
    void start(Block& block, std::size_t first) const {
        const auto by_handle = [](const TreeData& a, std::size_t handle) { return a.handle < handle; };
        const auto from = std::lower_bound(data_.begin(), data_.end(), first, by_handle);
        const auto to = std::lower_bound(from, data_.end(), first + width, by_handle);
        block.data_ = {from, to};
        block.first_ = first;
        block.refined_.clear();
        for (auto& fields : block.fields_) {
            set_zero(fields.u);
            set_zero(fields.b);
        }
        for (const auto& [handle, node, weight] : block.data_)
            block.fields_[0].b[node][handle - first] += weight;
        for (std::size_t l = 0; l + 1 < levels_.size(); ++l) restrict_rows(block, l, false);
        for (std::size_t l = levels_.size(); l-- > 0;) {
            Simd largest(0.0f);
            if (l + 1 < levels_.size()) interpolate(block, l, largest);
            if (l > 0) descend(block, l);
        }
    }

    /// One V(2,1) cycle; returns the largest change it made to any of the first `functions`.
    double cycle(Block& block, std::size_t functions) const {
        const Simd largest = descend(block, 0);
        detail::NodeRow row;
        largest.store(row);
        double change = 0;
        for (std::size_t k = 0; k < functions; ++k) change = std::max(change, double(row[k]));
        return change;
    }

    /// Takes the functions into double; what remains of the equations becomes their right-hand side.
    void refine(Block& block) const {
        auto& u = block.fields_[0].u;
        auto& b = block.fields_[0].b;
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
        Buffer<std::uint32_t> with_data;
        for (const TreeData& part : block.data_) with_data.push_back(part.node);
        std::sort(with_data.begin(), with_data.end());
        with_data.erase_from(std::unique(with_data.begin(), with_data.end()));
        rows = Buffer<Values>(with_data.size(), Values{});
        for (const auto& [handle, node, weight] : block.data_) {
            const auto at = std::lower_bound(with_data.begin(), with_data.end(), node);
            rows[std::size_t(at - with_data.begin())][handle - block.first_] += double(weight);
        }
        std::size_t next = 0;
        for (std::uint32_t n = 0; n < unknowns(); ++n) {
            Values sum{};
            if (next < with_data.size() && with_data[next] == n) sum = rows[next++];
            data(n, sum);
            for (std::size_t k = 0; k < width; ++k) b[n][k] = float(sum[k]);
        }
    }

    /// By which the functions may be off at most, by the maximum principle alone: w = (R² − r²)/2 has
    /// A w = D · volume at every node, so no error exceeds R²/2 · |residual| / (D · volume).
    Values bound(const Block& block) const noexcept {
        Simd largest(0.0f);
        for (std::uint32_t n = 0; n < unknowns(); ++n)
            largest = (detail::max)(largest, abs(residual(block, 0, n) * Simd(1 / (float(D) * volume_[n]))));
        detail::NodeRow row;
        largest.store(row);
        Values bound{};
        for (std::size_t k = 0; k < width; ++k) bound[k] = reach_ * double(row[k]);
        return bound;
    }

private:
    using Simd = detail::Simd<float>;

    Simd residual(const Block& block, std::size_t l, std::uint32_t n) const noexcept {
        const auto& level = levels_[l];
        const auto& [u, b] = block.fields_[l];
        Simd r = Simd::load(b[n]) - Simd::load(u[n]) * Simd(1 / level.inverse_diagonal[n]);
        for (const auto& [column, weight] : level.neighbours.of(n))
            r = multiply_add(Simd(weight), Simd::load(u[column]), r);
        return r;
    }
    /// Gauss and Seidel along the Morton curve; keeps the largest change.
    void relax(Block& block, std::size_t l, Simd& largest) const noexcept {
        const auto& level = levels_[l];
        auto& [u, b] = block.fields_[l];
        for (std::uint32_t n = 0; n < level.nodes(); ++n) {
            Simd sum = Simd::load(b[n]);
            for (const auto& [column, weight] : level.neighbours.of(n))
                sum = multiply_add(Simd(weight), Simd::load(u[column]), sum);
            sum = sum * Simd(level.inverse_diagonal[n]);
            largest = (detail::max)(largest, abs(sum - Simd::load(u[n])));
            sum.store(u[n]);
        }
    }
    /// The right-hand side of the next level, from the residual or, of u = 0, from the right-hand
    /// side.
    void restrict_rows(Block& block, std::size_t l, bool of_residual) const noexcept {
        auto& coarse = block.fields_[l + 1].b;
        detail::set_zero(coarse);
        for (std::uint32_t n = 0; n < levels_[l].nodes(); ++n) {
            const Simd r = of_residual ? residual(block, l, n) : Simd::load(block.fields_[l].b[n]);
            for (const auto& [column, weight] : levels_[l].interpolation.of(n))
                multiply_add(Simd(weight), r, Simd::load(coarse[column])).store(coarse[column]);
        }
    }
    /// Adds the next level's functions; keeps the largest change.
    void interpolate(Block& block, std::size_t l, Simd& largest) const noexcept {
        auto& u = block.fields_[l].u;
        const auto& coarse = block.fields_[l + 1].u;
        for (std::uint32_t n = 0; n < levels_[l].nodes(); ++n) {
            Simd sum(0.0f);
            for (const auto& [column, weight] : levels_[l].interpolation.of(n))
                sum = multiply_add(Simd(weight), Simd::load(coarse[column]), sum);
            largest = (detail::max)(largest, abs(sum));
            (Simd::load(u[n]) + sum).store(u[n]);
        }
    }
    Simd descend(Block& block, std::size_t l) const noexcept {
        Simd largest(0.0f), other(0.0f);
        if (l + 1 == levels_.size()) {
            relax(block, l, largest);
            for (std::size_t sweep = 1; sweep < coarsest_sweeps; ++sweep) relax(block, l, other);
            return largest;
        }
        relax(block, l, largest);
        relax(block, l, other);
        restrict_rows(block, l, true);
        detail::set_zero(block.fields_[l + 1].u);
        (void)descend(block, l + 1);
        interpolate(block, l, largest);
        relax(block, l, other);
        return largest;
    }

    static constexpr std::size_t coarsest_sweeps = 15;

    Buffer<TreeData> data_;
    Buffer<float> volume_;
    Buffer<double> diagonal_;
    std::vector<detail::TreeLevel> levels_; ///< the finest first
    double reach_;                          ///< half the square of the cube's side
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
