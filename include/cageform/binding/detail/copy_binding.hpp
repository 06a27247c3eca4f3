// Copies a view of a binding to an owning one.
#pragma once

#include <cageform/figure/binding.hpp>

#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

template <Scalar T, std::size_t D>
Binding<T, D> copy_binding(const BindingView<T, D>& view) {
    const std::size_t blocks = block_count<T>(view.point_count());
    std::vector<Lanes<T>> weights(view.weights.data, view.weights.data + blocks * view.handle_count());
    std::vector<Lanes<T>> rest(view.rest.data, view.rest.data + blocks * D);
    return {std::move(weights), std::move(rest), view.handle_view(), view.point_count()};
}

} // namespace cageform::inline CAGEFORM_ABI::detail
