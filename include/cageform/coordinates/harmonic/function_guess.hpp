// Samples the functions of a cage before an edit, as start values for the edited cage.
#pragma once

#include <cageform/coordinates/harmonic/embedded_cage.hpp>
#include <cageform/coordinates/harmonic/stencil_table.hpp>
#include <cageform/grid/multigrid/node_values.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Values at the nodes of a new grid, interpolated from functions that a solver S has kept on an
/// old grid. Both solvers must live as long as the guess.
template <class S>
class FunctionGuess {
    static constexpr std::size_t D = S::Problem::dimension;
    using T = typename S::Problem::scalar;

public:
    static constexpr std::size_t none = ~std::size_t{0};

    /// old_handles   #handles of the new cage: the number that each had in the old one, or none
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
        stencils_.reserve(nodes.count());
        nodes.for_each([&](const auto& index, std::uint32_t) {
            // Most nodes are the same after an edit.
            const std::uint32_t same = same_lattice ? old_nodes.find(index) : grid::NodeRuns<D>::none;
            if (same != grid::NodeRuns<D>::none) {
                stencils_.add_node(same);
            } else {
                const auto place = lattice.origin + lattice.spacing * node_position<D>(index);
                stencils_.add(before.grid().stencil_near(vec_cast<T>(place)), before.grid().data());
            }
        });
    }

    /// Returns the values of functions `first` … first + 15 at a node.
    NodeRow values(std::uint32_t node, std::size_t first) const {
        NodeRow row; // the constructor leaves it unset
        for (float& value : row.v) value = 0;
        for (std::size_t k = 0; k < width && first + k < old_handles_.size(); ++k) {
            const std::size_t handle = old_handles_[first + k];
            if (handle == none) continue;
            double sum = 0;
            for (const auto& [old_node, share] : stencils_.nodes(node))
                sum += share * functions_[handle / width].value(old_node)[handle % width];
            for (const auto& [on_boundary, share] : stencils_.handles(node)) {
                if (on_boundary == handle) sum += share;
            }
            row[k] = float(sum);
        }
        return row;
    }

private:
    static constexpr std::size_t width = functions_together;
    std::span<const typename S::Functions> functions_;
    std::span<const std::size_t> old_handles_;
    StencilTable<D> stencils_; ///< one per node
};

} // namespace cageform::inline CAGEFORM_ABI::detail
