// Values of many functions at many points: stencils worked out once, read for one group of
// functions after another.
#pragma once

#include <cageform/core/blocks.hpp>
#include <cageform/core/buffer.hpp>
#include <cageform/grid/cut_stencil.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The stencils of points `first`, first + 1, …, one after the other.
template <std::size_t D>
class CutSamples {
public:
    explicit CutSamples(std::size_t first = 0)
        : first_(first) {}

    void add(const grid::CutStencil<D>& stencil) {
        nodes_.append(stencil.nodes.data(), stencil.nodes.data() + stencil.node_count);
        places_.append(stencil.places.data(), stencil.places.data() + stencil.place_count);
        ends_.push_back({std::uint32_t(nodes_.size()), std::uint32_t(places_.size())});
    }

    /// Writes rows first_handle … of the points, `count` of them.
    ///
    ///   functions  functions.value(node): an array of at least `count` values
    template <class Functions, Scalar T>
    void sample(const Functions& functions, std::size_t first_handle, std::size_t count,
                BlockView<T> rows) const noexcept {
        std::uint32_t node = 0, place = 0;
        for (std::size_t n = 0; n < ends_.size(); ++n) {
            std::decay_t<decltype(functions.value(node))> value{};
            for (; node < ends_[n].nodes; ++node) {
                const auto& at_node = functions.value(nodes_[node].node);
                for (std::size_t k = 0; k < value.size(); ++k) value[k] += nodes_[node].share * at_node[k];
            }
            for (; place < ends_[n].places; ++place) {
                const auto& [at_place, share] = places_[place];
                for (std::size_t h = 0; h < BoundaryValue<D>::most; ++h) {
                    const std::size_t k = at_place.handle[h] - first_handle;
                    if (k < count) value[k] += share * at_place.weight[h];
                }
            }
            // A mean of boundary data is in [0, 1]; the solver's error may not leave it.
            const std::size_t i = first_ + n;
            auto* const row = rows.block(i / lane_count<T>) + first_handle;
            for (std::size_t k = 0; k < count; ++k)
                row[k][i % lane_count<T>] = static_cast<T>(std::clamp(value[k], 0.0, 1.0));
        }
    }

private:
    struct Ends {
        std::uint32_t nodes, places;
    };
    std::size_t first_;
    Buffer<typename grid::CutStencil<D>::Node> nodes_;
    Buffer<typename grid::CutStencil<D>::Place> places_;
    Buffer<Ends> ends_; ///< of each point's nodes and places
};

} // namespace cageform::inline CAGEFORM_ABI::detail
