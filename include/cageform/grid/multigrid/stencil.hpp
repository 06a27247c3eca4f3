// The 3^D positions of a stencil, and fast access to their nodes.
#pragma once

#include <cageform/grid/lattice/node_runs.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

constexpr std::size_t power(std::size_t base, std::size_t exponent) noexcept {
    std::size_t p = 1;
    while (exponent-- > 0) p *= base;
    return p;
}

/// The 3^D positions of a stencil, numbered with axis 0 fastest.
template <std::size_t D>
struct StencilPositions {
    static constexpr std::size_t count = power(3, D);
    static constexpr std::size_t centre = count / 2;
    using Offset = std::array<std::int32_t, D>;

    static constexpr const Offset& offset(std::size_t position) noexcept { return offsets[position]; }
    static constexpr std::size_t position(const Offset& o) noexcept {
        std::size_t n = 0;
        for (std::size_t k = D; k-- > 0;) n = 3 * n + std::size_t(o[k] + 1);
        return n;
    }
    /// Returns the difference in position between a corner of a cell (`corner_offset`) and its lowest corner.
    static constexpr std::size_t corner_step(std::size_t corner) noexcept { return steps[corner]; }
    /// Returns the number of axes along which a position is off centre.
    static constexpr std::size_t distance(std::size_t position) noexcept {
        std::size_t n = 0;
        for (const auto o : offset(position)) n += o != 0 ? 1 : 0;
        return n;
    }

private:
    static constexpr std::array<std::size_t, power(2, D)> steps = [] {
        std::array<std::size_t, power(2, D)> all{};
        for (std::size_t corner = 0; corner < all.size(); ++corner) {
            for (std::size_t k = 0, step = 1; k < D; ++k, step *= 3)
                all[corner] += ((corner >> k) & 1u) * step;
        }
        return all;
    }();
    static constexpr std::array<Offset, count> offsets = [] {
        std::array<Offset, count> all{};
        for (std::size_t p = 0; p < count; ++p) {
            for (std::size_t k = 0, rest = p; k < D; ++k, rest /= 3) all[p][k] = std::int32_t(rest % 3) - 1;
        }
        return all;
    }();
};

/// Returns a corner of the cell above a node as an offset. Bit k of `corner` is set at the upper end of
/// axis k.
template <std::size_t D>
constexpr std::array<std::int32_t, D> corner_offset(std::size_t corner) noexcept {
    std::array<std::int32_t, D> o{};
    for (std::size_t k = 0; k < D; ++k) o[k] = std::int32_t((corner >> k) & 1u);
    return o;
}

template <std::size_t D>
constexpr std::array<std::int32_t, D> shifted(std::array<std::int32_t, D> index,
                                              const std::array<std::int32_t, D>& by,
                                              std::int32_t factor = 1) noexcept {
    for (std::size_t k = 0; k < D; ++k) index[k] += factor * by[k];
    return index;
}

/// The nodes around an index that moves along the rows in order, as in `NodeRuns::for_each`. A look-up
/// takes constant time; `NodeRuns::find` has to search.
template <std::size_t D>
class Neighbours {
public:
    using Index = typename grid::NodeRuns<D>::Index;

    explicit Neighbours(const grid::NodeRuns<D>& nodes)
        : nodes_(nodes) {}

    void move_to(const Index& index) noexcept {
        const bool onwards = x_ != before_all && index[0] >= x_ &&
                             std::equal(index.begin() + 1, index.end(), row_.begin() + 1);
        x_ = index[0];
        if (onwards) return;
        row_ = index;
        for (std::size_t r = 0; r < rows; ++r) {
            const Index there = shifted<D>(index, StencilPositions<D>::offset(3 * r + 1));
            bool inside = true;
            for (std::size_t k = 1; k < D; ++k)
                inside = inside && there[k] >= 0 && there[k] < nodes_.size()[k];
            run_[r] = inside ? nodes_.row_runs(nodes_.row(there)) : nullptr;
            end_[r] = inside ? nodes_.row_runs_end(nodes_.row(there)) : nullptr;
        }
    }
    /// Returns the node at a position of the stencil, or `NodeRuns::none`.
    std::uint32_t at(std::size_t position) noexcept {
        const std::size_t r = position / 3;
        const std::int32_t x = x_ + std::int32_t(position % 3) - 1;
        while (run_[r] != end_[r] && run_[r]->end < x_) ++run_[r];
        const auto* run = run_[r];
        while (run != end_[r] && run->end <= x) ++run;
        return run != end_[r] && run->begin <= x ? run->first + std::uint32_t(x - run->begin)
                                                 : grid::NodeRuns<D>::none;
    }

private:
    static constexpr std::size_t rows = power(3, D - 1);
    static constexpr std::int32_t before_all = (std::numeric_limits<std::int32_t>::min)();

    const grid::NodeRuns<D>& nodes_;
    Index row_{};
    std::int32_t x_ = before_all;
    std::array<const typename grid::NodeRuns<D>::Run*, rows> run_{}, end_{};
};

} // namespace cageform::inline CAGEFORM_ABI::detail
