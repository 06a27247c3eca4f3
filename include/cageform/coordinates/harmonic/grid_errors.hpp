// Estimates the discretisation error of an adaptive grid from interpolation in leaves and in cells of twice
// their size.
#pragma once

#include <cageform/coordinates/harmonic/cut_samples.hpp>
#include <cageform/grid/tree/leaf_gather.hpp>
#include <cageform/grid/tree/star.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Two interpolants of the same functions at points spread over the leaves: in the leaf and in its parent
/// cell. Where functions are smooth, their difference is three times the error of the first; next to kinks
/// once or twice. Errors of node values are of the same size. Against finer grids, the largest difference is
/// between 0.5 and 4 times the largest error anywhere. In 2D, two stencils by HarmonicMean are compared:
/// exact for four powers and for two. For leaves with models, fits of harmonic polynomials of degree 3 and of
/// degree 1 are compared. On random meshes the largest error is 1.1 to 5.6 times the largest difference, so
/// the difference is multiplied by 4.
template <std::size_t D>
class GridErrors {
public:
    GridErrors() = default;
    /// Compares stencils made by `add`.
    ///
    ///   add  add(places, fine, coarse): adds one stencil per place to both tables
    template <class Add>
    GridErrors(const grid::CutTree<D>& tree, const Running& running, const Add& add) {
        constexpr std::uint32_t most = 250; // such stencils cost about fifty times as much
        std::vector<Vec<double, D>> places;
        for_each_place(tree, most, running,
                       [&](const Cell&, const Vec<double, D>& middle) { places.push_back(middle); });
        factor_ = 4;
        add(std::span<const Vec<double, D>>(places), fine_, coarse_);
    }
    ///   data  a BoundaryData
    template <class Data>
    GridErrors(const grid::CutTree<D>& tree, const grid::TreeNodes<D>& nodes, const Data& data,
               const Running& running) {
        constexpr std::uint32_t most = 1000;
        for_each_place(tree, most, running, [&](const Cell& leaf, const Vec<double, D>& middle) {
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
            fine_.add(stencil(tree, nodes, leaf, middle), data);
            coarse_.add(stencil(tree, nodes, tree.cells().parent_of(leaf.number), middle), data);
        });
    }

    /// Takes the factors of the unknowns (grid::TreeLinks::decay). Errors are then relative to the largest
    /// factor around a point.
    void scale_nodes(std::span<const float> decay) {
        if (decay.empty()) return;
        for (std::size_t n = 0; n < fine_.size(); ++n) {
            float largest = 0;
            for (const auto& [node, share] : fine_.nodes(n)) largest = (std::max)(largest, decay[node]);
            size_.push_back(largest > 0 ? largest : 1);
        }
        fine_.scale_nodes(decay);
        coarse_.scale_nodes(decay);
    }

    std::size_t bytes() const noexcept {
        return fine_.bytes() + coarse_.bytes() + size_.capacity() * sizeof(float);
    }

    /// Returns for each point the largest difference over functions [first, first + count).
    ///
    ///   functions  functions.value(node): an array of at least `count` values
    template <class Functions>
    std::vector<float> of(const Functions& functions, std::size_t first, std::size_t count) const {
        std::vector<float> errors;
        for (std::size_t n = 0; n < fine_.size(); ++n) {
            const auto fine = values_at(fine_, n, functions, first, count);
            const auto coarse = values_at(coarse_, n, functions, first, count);
            double largest = 0;
            for (std::size_t k = 0; k < count; ++k)
                largest = (std::max)(largest, std::fabs(fine[k] - coarse[k]));
            errors.push_back(float(factor_ * largest) / (size_.empty() ? 1 : size_[n]));
        }
        return errors;
    }

private:
    using Cell = typename grid::CellTree<D>::Cell;

    /// Calls f(leaf, middle) for at most `most` evenly spread leaves with an inside middle.
    template <class F>
    static void for_each_place(const grid::CutTree<D>& tree, std::uint32_t most, const Running& running,
                               const F& f) {
        const std::uint32_t step = 1 + tree.cells().leaves() / most;
        std::uint32_t count = 0;
        tree.cells().for_each_leaf([&](const Cell& leaf) {
            if (tree.state(leaf.number) == grid::CellState::out || leaf.number == 0) return;
            if (count++ % step != 0) return;
            report_progress(running, double(count) / double(tree.cells().leaves()));
            const auto middle = leaf.middle();
            if (!tree.is_inside(middle)) return;
            if (tree.boundary().nearest(tree.facets(leaf.number), middle).distance > grid::on_facet_distance)
                f(leaf, middle);
        });
    }
    static grid::CutStencil<D> stencil(const grid::CutTree<D>& tree, const grid::TreeNodes<D>& nodes,
                                       const Cell& cell, const Vec<double, D>& p) {
        grid::CutStencil<D> stencil;
        grid::StencilSink<D> sink{nodes, stencil};
        LeafGather<D, grid::StencilSink<D>>(tree.boundary(), nodes, sink)
            .gather(cell, tree.facets(cell.number), p);
        return stencil;
    }

    StencilTable<D> fine_, coarse_;
    std::vector<float> size_; ///< per point: the largest factor of its nodes; empty: 1
    double factor_ = 1;       ///< of differences
};

} // namespace cageform::inline CAGEFORM_ABI::detail
