// Reads the points, vectors and labels of a bound figure at rest.
#pragma once

#include <cageform/binding/detail/bind_input.hpp>
#include <cageform/binding/types/cage_rebind_report.hpp>
#include <cageform/binding/types/figure_binding.hpp>
#include <cageform/figure/packed_binding.hpp>

#include <algorithm>
#include <span>
#include <string_view>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Reads the points or vectors of a binding at rest, in their original order. Refers to the binding's memory.
template <Scalar T, std::size_t D>
PointReader<T> read_rest(const PackedBindingView<T, D>& binding) {
    const BlockView<const T> rest{binding.rest, D, binding.points};
    if (binding.order == nullptr) {
        return {binding.points,
                [rest](std::size_t block, Lanes<T>* rows) { std::copy_n(rest.block(block), D, rows); }};
    }
    std::vector<std::uint32_t> positions(binding.points);
    for (std::size_t n = 0; n < binding.points; ++n)
        positions[binding.order[n]] = static_cast<std::uint32_t>(n);
    return {binding.points, [rest, positions = std::move(positions)](std::size_t block, Lanes<T>* rows) {
                for (std::size_t lane = 0; lane < lane_count<T>; ++lane) {
                    const std::size_t i = (std::min)(block * lane_count<T> + lane, positions.size() - 1);
                    for (std::size_t k = 0; k < D; ++k) rows[k][lane] = rest(positions[i], k);
                }
            }};
}

/// Copies the labels of old handles; new handles have none.
template <Scalar T, std::size_t D>
Status transfer_labels(const HandleLabels& before, std::span<const std::size_t> old_handles,
                       FigureBinding<T, D>& after) {
    if (before.begin == nullptr) return Status::ok;
    std::vector<std::string_view> labels;
    for (const std::size_t handle : old_handles)
        labels.push_back(handle == new_handle ? std::string_view{} : before[handle]);
    return after.set_labels(labels);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
