// Values of many functions at many points: stencils worked out once, read for one group of
// functions after another.
#pragma once

#include <cageform/coordinates/harmonic/stencil_table.hpp>
#include <cageform/core/detail/blocks.hpp>

#include <functional>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The stencils of points `first`, first + 1, …, one after the other.
template <std::size_t D>
class CutSamples {
public:
    explicit CutSamples(std::size_t first = 0)
        : first_(first) {}

    /// `data` is the cage's BoundaryData.
    template <class Data>
    void add(const grid::CutStencil<D>& stencil, const Data& data) {
        stencils_.add(stencil, data);
    }

    /// Writes rows first_handle … of the points, `count` of them.
    ///
    ///   functions  functions.value(node): an array of at least `count` values; where there is
    ///              functions.has(node), zero where it is false
    ///   row_of     row_of(handle): where a handle's row is, if not at its number
    template <class Functions, Scalar T, class RowOf = std::identity>
    void sample(const Functions& functions, std::size_t first_handle, std::size_t count, BlockView<T> rows,
                const RowOf& row_of = {}) const noexcept {
        for (std::size_t n = 0; n < stencils_.size(); ++n) {
            std::decay_t<decltype(functions.value(0))> value{};
            for (const auto& [node, share] : stencils_.nodes(n)) {
                if constexpr (requires { functions.has(node); }) {
                    if (!functions.has(node)) continue;
                }
                const auto& at_node = functions.value(node);
                for (std::size_t k = 0; k < value.size(); ++k) value[k] += share * at_node[k];
            }
            for (const auto& [handle, share] : stencils_.handles(n)) {
                const std::size_t k = handle - first_handle;
                if (k < count) value[k] += share;
            }
            // A mean of boundary data is in [0, 1]; the solver's error may not leave it.
            const std::size_t i = first_ + n;
            auto* const row = rows.block(i / lane_count<T>);
            for (std::size_t k = 0; k < count; ++k)
                row[row_of(first_handle + k)][i % lane_count<T>] =
                    static_cast<T>(std::clamp(value[k], 0.0, 1.0));
        }
    }

private:
    std::size_t first_;
    StencilTable<D> stencils_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
