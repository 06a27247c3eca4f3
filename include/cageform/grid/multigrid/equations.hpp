// The equations A u = b of one level while the multigrid is built. Most nodes share one regular stencil;
// the others, called irregular, have their own.
//
// The finest equations follow Shortley and Weller (J. Appl. Phys. 9 (1938), p. 334): a link that is cut at
// the fraction θ of its length has the weight 1/θ instead of 1. The factor 2/(θ₋ + θ₊) of each axis is
// omitted, which makes A symmetric and keeps linear functions exact (Gibou, Fedkiw, Cheng and Kang, J.
// Comput. Phys. 176 (2002), sec. 2).
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/multigrid/stencil.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

template <std::size_t D>
struct Equations {
    using Stencil = std::array<double, StencilPositions<D>::count>; ///< a row of A
    struct Irregular {
        Stencil a{};
        std::array<double, D> row_sum{}; ///< of A, distributed to the axes; zero at regular nodes
    };

    grid::NodeRuns<D> nodes;
    Stencil regular{};
    std::vector<std::uint32_t> slot; ///< per node: index into `irregular`, or none
    Buffer<Irregular> irregular;

    bool is_irregular(std::uint32_t node) const noexcept { return slot[node] != grid::NodeRuns<D>::none; }
    const Stencil& stencil(std::uint32_t node) const noexcept {
        return is_irregular(node) ? irregular[slot[node]].a : regular;
    }
};

/// Returns −∇² + κ² on the finest level, in units of the lattice.
///
///   screening  κ², in units of the lattice
template <std::size_t D>
Equations<D> shortley_weller_equations(const grid::NodeRuns<D>& nodes, std::span<const grid::CutLink> cuts,
                                       double screening) {
    using P = StencilPositions<D>;
    Equations<D> e;
    e.nodes = nodes;
    e.regular[P::centre] = 2.0 * double(D) + screening;
    for (std::size_t p = 0; p < P::count; ++p) {
        if (P::distance(p) == 1) e.regular[p] = -1;
    }
    e.slot.assign(nodes.count(), grid::NodeRuns<D>::none);
    for (const grid::CutLink& cut : cuts) {
        auto& slot = e.slot[cut.node];
        if (slot == grid::NodeRuns<D>::none) {
            slot = std::uint32_t(e.irregular.size());
            e.irregular.push_back({e.regular, {}});
        }
        auto& [a, row_sum] = e.irregular[slot];
        const std::size_t axis = cut.direction / 2;
        typename P::Offset o{};
        o[axis] = (cut.direction & 1) != 0 ? 1 : -1;
        CAGEFORM_ASSERT(a[P::position(o)] != 0, "a link is cut once");
        a[P::position(o)] = 0; // the data at the end of the link goes to b
        a[P::centre] += cut.weight - 1;
        row_sum[axis] += cut.weight;
    }
    return e;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
