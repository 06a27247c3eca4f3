// The functions of a cage before it was edited, as guesses of those of the edited one.
#pragma once

#include <cageform/coordinates/detail/embedded_cage.hpp>
#include <cageform/core/buffer.hpp>
#include <cageform/grid/detail/node_values.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Values at the nodes of a new grid, sampled from functions that a solver S of an old grid has
/// kept; both outlive it.
template <class S>
class FunctionGuess {
    static constexpr std::size_t D = S::Problem::dimension;
    using T = typename S::Problem::scalar;

public:
    static constexpr std::size_t none = ~std::size_t{0};

    /// old_handles   #handles of the new cage: the number of each in the old one, or none
    FunctionGuess(const S& solver, const S& before, std::span<const typename S::Functions> functions,
                  std::span<const std::size_t> old_handles)
        : functions_(functions)
        , old_handles_(old_handles) {
        const auto& nodes = solver.grid().problem().nodes;
        const auto& old_nodes = before.grid().problem().nodes;
        const auto& lattice = solver.grid().lattice();
        const auto& old_lattice = before.grid().lattice();
        const bool same_lattice = lattice.origin == old_lattice.origin &&
                                  lattice.spacing == old_lattice.spacing &&
                                  lattice.cells == old_lattice.cells;
        ends_.reserve(nodes.count());
        nodes.for_each([&](const auto& index, std::uint32_t) {
            const std::uint32_t same =
                same_lattice ? old_nodes.find(index) : grid::NodeRuns<D>::none; // most are, after an edit
            if (same != grid::NodeRuns<D>::none) {
                nodes_.push_back({same, 1.0});
            } else {
                const auto place = lattice.origin + lattice.spacing * node_position<D>(index);
                const auto stencil = before.grid().stencil_near(vec_cast<T>(place));
                nodes_.append(stencil.nodes.data(), stencil.nodes.data() + stencil.node_count);
                places_.append(stencil.places.data(), stencil.places.data() + stencil.place_count);
            }
            ends_.push_back({std::uint32_t(nodes_.size()), std::uint32_t(places_.size())});
        });
    }

    /// The values of functions `first` … first + 15 at a node.
    NodeRow values(std::uint32_t node, std::size_t first) const {
        NodeRow row; // not set by itself
        for (float& value : row.v) value = 0;
        const Ends begin = node == 0 ? Ends{0, 0} : ends_[node - 1], end = ends_[node];
        for (std::size_t k = 0; k < width && first + k < old_handles_.size(); ++k) {
            const std::size_t handle = old_handles_[first + k];
            if (handle == none) continue;
            double sum = 0;
            for (std::uint32_t n = begin.nodes; n < end.nodes; ++n)
                sum += nodes_[n].share * functions_[handle / width].value(nodes_[n].node)[handle % width];
            for (std::uint32_t n = begin.places; n < end.places; ++n) {
                for (std::size_t h = 0; h < BoundaryValue<D>::most; ++h) {
                    if (places_[n].value.handle[h] == handle)
                        sum += places_[n].share * places_[n].value.weight[h];
                }
            }
            row[k] = float(sum);
        }
        return row;
    }

private:
    static constexpr std::size_t width = functions_together;
    struct Ends {
        std::uint32_t nodes, places;
    };
    std::span<const typename S::Functions> functions_;
    std::span<const std::size_t> old_handles_;
    Buffer<typename grid::CutStencil<D>::Node> nodes_;
    Buffer<typename grid::CutStencil<D>::Place> places_;
    Buffer<Ends> ends_; ///< of each node's nodes and places
};

} // namespace cageform::inline CAGEFORM_ABI::detail
