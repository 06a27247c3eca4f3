// Stores the interpolation stencils of many points as weights of nodes and handles.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/lattice/cut_stencil.hpp>

#include <algorithm>
#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A list of stencils. Weights of boundary points are converted to weights of handles.
template <std::size_t D>
class StencilTable {
public:
    using Node = typename grid::CutStencil<D>::Node;
    std::size_t size() const noexcept { return ends_.size(); }
    std::size_t bytes() const noexcept {
        return nodes_.capacity() * sizeof(Node) + handles_.capacity() * sizeof(Handle) +
               ends_.capacity() * sizeof(Ends);
    }

    struct Handle {
        std::uint32_t handle;
        double share;
    };

    /// Appends a stencil. `data` is a BoundaryData.
    template <class Data>
    void add(const grid::CutStencil<D>& stencil, const Data& data) {
        nodes_.append(stencil.nodes.data(), stencil.nodes.data() + stencil.node_count);
        for (std::uint32_t n = 0; n < stencil.boundary_count; ++n) {
            const auto& [value, share] = stencil.boundary_points[n];
            data.for_each_weight(value, [&, factor = share](std::uint32_t handle, double weight) {
                handles_.push_back({handle, factor * weight});
            });
        }
        end_stencil();
    }

    /// Appends a stencil given by shares of nodes and vertices. handle_of(vertex) returns a vertex's handle.
    template <class HandleOf>
    void add(std::span<const Node> nodes, std::span<const Handle> vertices, const HandleOf& handle_of) {
        nodes_.append(nodes.data(), nodes.data() + nodes.size());
        for (const auto& [vertex, share] : vertices) handles_.push_back({handle_of(vertex), share});
        end_stencil();
    }

    /// Multiplies the shares of all nodes by factors, one per node; without factors, does nothing.
    void scale_nodes(std::span<const float> factors) noexcept {
        if (factors.empty()) return;
        for (auto& [node, share] : nodes_) share *= double(factors[node]);
    }

    std::span<const Node> nodes(std::size_t n) const noexcept {
        const std::size_t begin = n == 0 ? 0 : ends_[n - 1].nodes;
        return {nodes_.data() + begin, ends_[n].nodes - begin};
    }
    /// Returns the weights of a stencil's handles in [first, first + count), ascending. A handle may occur
    /// more than once.
    std::span<const Handle> handles(std::size_t n, std::size_t first, std::size_t count) const noexcept {
        const auto* const begin = handles_.data() + (n == 0 ? 0 : ends_[n - 1].handles);
        const auto* const end = handles_.data() + ends_[n].handles;
        const auto is_before = [](const Handle& a, std::size_t handle) { return a.handle < handle; };
        const auto* const from = std::lower_bound(begin, end, first, is_before);
        return {from, std::lower_bound(from, end, first + count, is_before)};
    }

private:
    struct Ends {
        std::uint32_t nodes, handles;
    };
    void end_stencil() {
        std::sort(handles_.data() + (ends_.empty() ? 0 : ends_.back().handles),
                  handles_.data() + handles_.size(),
                  [](const Handle& a, const Handle& b) { return a.handle < b.handle; });
        ends_.push_back({std::uint32_t(nodes_.size()), std::uint32_t(handles_.size())});
    }

    Buffer<Node> nodes_;
    Buffer<Handle> handles_;
    Buffer<Ends> ends_; ///< ends of each stencil's nodes and handles
};

} // namespace cageform::inline CAGEFORM_ABI::detail
