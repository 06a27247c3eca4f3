// Estimates the discretisation error of an adaptive grid: compares values interpolated in leaves
// with values interpolated in cells of twice the size.
#pragma once

#include <cageform/coordinates/harmonic/stencil_table.hpp>
#include <cageform/grid/tree/leaf_gather.hpp>
#include <cageform/grid/tree/star.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Two means of the same functions at points spread over the leaves: one in the leaf, one in its
/// parent cell. Where functions are smooth the means differ by three times the error of the first,
/// next to kinks by once or twice that error. The errors of node values are of the same size.
/// Measured against finer grids, the largest difference is between half and four times the largest
/// error anywhere. In 2D two harmonic means are compared instead, exact for four powers and for two.
template <std::size_t D>
class GridErrors {
public:
    GridErrors() = default;
    using Stencil = grid::CutStencil<D>;
    using Corrections = std::span<const typename StencilTable<D>::Handle>;

    template <class Data>
    GridErrors(const grid::CutTree<D>& tree, const grid::TreeNodes<D>& nodes, const Data& data,
               const Running& running)
        : GridErrors(tree, nodes, data, running, [](Stencil&, Stencil&, const Vec<double, D>&, double) {
            return std::array<Corrections, 2>{};
        }) {}
    ///   data     the cage's BoundaryData
    ///   correct  correct(fine, coarse, point, size): the Corrections of two means at a point of a leaf;
    ///            it may change the weights of nodes
    template <class Data, class Correct>
    GridErrors(const grid::CutTree<D>& tree, const grid::TreeNodes<D>& nodes, const Data& data,
               const Running& running, const Correct& correct) {
        constexpr std::uint32_t most = 1000;
        const std::uint32_t step = 1 + tree.cells().leaves() / most;
        std::uint32_t count = 0;
        tree.cells().for_each_leaf([&](const Cell& leaf) {
            if (tree.state(leaf.number) == grid::CellState::out || leaf.number == 0) return;
            if (count++ % step != 0) return;
            report_progress(running, double(count) / double(tree.cells().leaves()));
            const auto middle = leaf.middle();
            const auto facets = tree.facets(leaf.number);
            if (!tree.is_inside(middle)) return;
            if (tree.boundary().nearest(facets, middle).distance <= grid::on_facet_distance) return;
            if constexpr (D == 2) {
                constexpr unsigned degree = HarmonicMean::most_degree;
                const auto fine = harmonic_mean_of(tree, nodes, middle, leaf, degree);
                const auto coarse = harmonic_mean_of(tree, nodes, middle, leaf, degree - 2);
                if (fine && coarse) {
                    fine_.add(*fine, data);
                    coarse_.add(*coarse, data);
                    return;
                }
            }
            auto fine = stencil(tree, nodes, leaf, middle);
            auto coarse = stencil(tree, nodes, tree.cells().parent_of(leaf.number), middle);
            const auto corrections = correct(fine, coarse, middle, double(leaf.size));
            fine_.add(fine, data, corrections[0]);
            coarse_.add(coarse, data, corrections[1]);
        });
    }

    std::size_t bytes() const noexcept { return fine_.bytes() + coarse_.bytes(); }

    /// Returns per point the largest difference over functions first … first + count − 1.
    ///
    ///   functions  functions.value(node): an array of at least `count` values
    template <class Functions>
    std::vector<float> of(const Functions& functions, std::size_t first, std::size_t count) const {
        std::vector<float> errors;
        for (std::size_t n = 0; n < fine_.size(); ++n) {
            auto difference = value(fine_, n, functions, first, count);
            const auto coarse = value(coarse_, n, functions, first, count);
            double largest = 0;
            for (std::size_t k = 0; k < count; ++k)
                largest = (std::max)(largest, std::fabs(difference[k] - coarse[k]));
            errors.push_back(float(largest));
        }
        return errors;
    }

private:
    using Cell = typename grid::CellTree<D>::Cell;

    static grid::CutStencil<D> stencil(const grid::CutTree<D>& tree, const grid::TreeNodes<D>& nodes,
                                       const Cell& cell, const Vec<double, D>& p) {
        grid::CutStencil<D> stencil;
        grid::StencilSink<D> sink{nodes, stencil};
        LeafGather<D, grid::StencilSink<D>>(tree.boundary(), nodes, sink)
            .gather(cell, tree.facets(cell.number), p);
        return stencil;
    }
    template <class Functions>
    static auto value(const StencilTable<D>& stencils, std::size_t n, const Functions& functions,
                      std::size_t first, std::size_t count) {
        std::decay_t<decltype(functions.value(0))> sum{};
        for (const auto& [node, share] : stencils.nodes(n)) {
            const auto& at_node = functions.value(node);
            for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += share * at_node[k];
        }
        for (const auto& [handle, share] : stencils.handles(n, first, count)) sum[handle - first] += share;
        return sum;
    }

    StencilTable<D> fine_, coarse_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
