// Samples many functions at many points, with the same stencils for all functions.
#pragma once

#include <cageform/coordinates/harmonic/stencil_table.hpp>
#include <cageform/core/types/blocks.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Applies stencil `n` of a table to functions [first_handle, first_handle + count). See CutSamples::sample.
template <std::size_t D, class Functions>
auto values_at(const StencilTable<D>& stencils, std::size_t n, const Functions& functions,
               std::size_t first_handle, std::size_t count) noexcept {
    std::decay_t<decltype(functions.value(0))> value{};
    for (const auto& [node, share] : stencils.nodes(n)) {
        if constexpr (requires { functions.has(0); }) {
            if (!functions.has(node)) continue;
        }
        const auto& at_node = functions.value(node);
        for (std::size_t k = 0; k < value.size(); ++k) value[k] += share * at_node[k];
    }
    for (const auto& [handle, share] : stencils.handles(n, first_handle, count))
        value[handle - first_handle] += share;
    return value;
}

/// Stencils of points, by index.
template <std::size_t D>
class CutSamples {
public:
    /// Adds the stencil of point `i`. `data` is a BoundaryData.
    template <class Data>
    void add(std::size_t i, const grid::CutStencil<D>& stencil, const Data& data) {
        points_.push_back(i);
        stencils_.add(stencil, data);
    }
    /// Adds a stencil as shares of nodes and vertices; see StencilTable.
    template <class HandleOf>
    void add(std::size_t i, std::span<const typename StencilTable<D>::Node> nodes,
             std::span<const typename StencilTable<D>::Handle> vertices, const HandleOf& handle_of) {
        points_.push_back(i);
        stencils_.add(nodes, vertices, handle_of);
    }

    /// See StencilTable.
    void scale_nodes(std::span<const float> factors) noexcept { stencils_.scale_nodes(factors); }

    /// Writes the rows of handles [first_handle, first_handle + count) for all points.
    ///
    ///   functions  functions.value(node): an array of at least `count` values. If functions.has(node) exists
    ///              and is false, the node counts as zero
    ///   row_of     row_of(handle): the row of a handle; default: the handle
    template <class Functions, Scalar T, class RowOf = std::identity>
    void sample(const Functions& functions, std::size_t first_handle, std::size_t count, BlockView<T> rows,
                const RowOf& row_of = {}) const noexcept {
        for (std::size_t n = 0; n < stencils_.size(); ++n) {
            const auto value = values_at(stencils_, n, functions, first_handle, count);
            // Means of boundary values are in [0, 1]. Clamping removes solver errors.
            for (std::size_t k = 0; k < count; ++k)
                rows(points_[n], row_of(first_handle + k)) = static_cast<T>(std::clamp(value[k], 0.0, 1.0));
        }
    }

    /// Divides the weights of each point by their sum, which differs from 1 after clamping of negative
    /// values. Points whose weights have a sum of at most `least` are unchanged.
    template <Scalar T>
    void normalise(BlockView<T> rows, double least) const noexcept {
        for (const std::size_t i : points_) {
            double sum = 0;
            for (std::size_t k = 0; k < rows.rows; ++k) sum += double(rows(i, k));
            if (!(sum > least) || sum == 1) continue;
            for (std::size_t k = 0; k < rows.rows; ++k) rows(i, k) = static_cast<T>(double(rows(i, k)) / sum);
        }
    }

private:
    std::vector<std::size_t> points_;
    StencilTable<D> stencils_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
