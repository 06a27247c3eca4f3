// Boundary data at a point of a cage's boundary: handles and the values of their hat functions.
#pragma once

#include <cageform/cage/detail/primitives.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The boundary data at a point: the handles with non-zero hat functions there, and the values of these
/// functions, which sum to 1.
template <std::size_t D>
struct BoundaryValue {
    static constexpr std::size_t most = D; ///< maximum number of handles: those of a facet
    std::array<std::uint32_t, most> handle{};
    std::array<double, most> weight{};
};

template <std::size_t D>
BoundaryValue<D> value_on_facet(const std::array<std::uint32_t, D>& vertex,
                                const std::array<double, D>& weight) noexcept {
    return {vertex, weight};
}

namespace detail {

/// Boundary data that is linear on facets. It needs no data besides the BoundaryValue of a point.
template <std::size_t D>
class LinearBoundaryData {
public:
    using Value = BoundaryValue<D>;

    template <class F>
    static void for_each_weight(const Value& value, F&& f) {
        for (std::size_t n = 0; n < Value::most; ++n) {
            if (value.weight[n] != 0) f(value.handle[n], value.weight[n]);
        }
    }
    template <class F>
    static void for_each_handle(const Value& value, F&& f) {
        for_each_weight(value, [&](std::uint32_t handle, double) { f(handle); });
    }
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
