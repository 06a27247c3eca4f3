// Rebinds a figure after an edit of its cage: vertices moved, added or removed.
#pragma once

#include <cageform/binding/detail/figure_binder.hpp>
#include <cageform/binding/detail/rest_figure.hpp>
#include <cageform/binding/types/cage_rebind_report.hpp>
#include <cageform/core/detail/stopwatch.hpp>

#include <map>

namespace cageform::inline CAGEFORM_ABI {

/// Matches handles across an edit of the cage: returns the old index of every handle, or `new_handle`.
///
///   same count    every handle keeps its index, even if it has moved
///   other count   the first handle of the same kind at the same position, or `new_handle`; vectors
///                 are compared by value
///   cost          O(#handles log #handles); may throw std::bad_alloc
template <Scalar T, std::size_t D>
std::vector<std::size_t> match_handles(const HandleView<T, D>& before, const HandleView<T, D>& after) {
    std::vector<std::size_t> numbers(after.count, new_handle);
    if (before.count == after.count) {
        for (std::size_t i = 0; i < after.count; ++i) numbers[i] = i;
        return numbers;
    }
    std::map<std::pair<bool, std::array<T, D>>, std::size_t> by_position;
    const auto position = [](const HandleView<T, D>& handles, std::size_t i) {
        std::array<T, D> key{};
        for (std::size_t k = 0; k < D; ++k) key[k] = handles.rest[i][k];
        return std::pair(handles.is_point(i), key);
    };
    for (std::size_t i = before.count; i-- > 0;) { // packed data may hold non-finite numbers
        if (is_finite(before.rest[i])) by_position[position(before, i)] = i;
    }
    for (std::size_t i = 0; i < after.count; ++i) {
        if (const auto found = by_position.find(position(after, i)); found != by_position.end())
            numbers[i] = found->second;
    }
    return numbers;
}

/// Rebinds a figure to an edited cage. The result is that of `bind` for the same points, normals and
/// tangents, bit for bit; the caller need not provide them. Handles keep their labels.
///
///   figure       the figure bound to the cage before the edit: a FigureBinding, or an opened packed figure,
///                which stores points at rest in full precision
///   coordinates  of the edited cage
///   old_handles  #handles of the edited cage: the old index of each, or `new_handle`. Empty: the result
///                of `match_handles`, which treats a removed and an added vertex as a moved one. Affects
///                only labels
///   options      as for `bind`
///   returns      the figure and its report; fails as `bind`; labels_do_not_match, if old_handles has
///                another length or an index out of range; vectors_do_not_match, if there is not one
///                handedness per point
template <CageCoordinates C>
    requires GradientCoordinates<C>
Result<FigureBinding<typename C::scalar, C::dimension>, CageRebindReport>
rebind_cage(const PackedFigureView<typename C::scalar, C::dimension>& figure, const C& coordinates,
            std::span<const std::size_t> old_handles = {}, const BindOptions& options = {},
            const Running& running = {}) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    Result<FigureBinding<T, D>, CageRebindReport> result;
    Result<FigureBinding<T, D>, FigureBindReport> bound;
    detail::run_into(bound.report, [&] {
        if (coordinates.cage_report().status != Status::ok) {
            bound.report.points.cage = coordinates.cage_report();
            return bound.report.points.status = coordinates.cage_report().status;
        }
        const HandleView<T, D> before = figure.points.handle_view(), after = handle_view(coordinates);
        result.report.old_handles.assign(old_handles.begin(), old_handles.end());
        if (old_handles.empty()) result.report.old_handles = match_handles(before, after);
        for (const std::size_t handle : result.report.old_handles) {
            if (handle >= before.count && handle != new_handle) return Status::labels_do_not_match;
        }
        if (result.report.old_handles.size() != after.count) return Status::labels_do_not_match;
        detail::FigureInput<T, D> input{detail::read_rest(figure.points), {}, {}};
        for (std::size_t k = 0; k + 1 < D && figure.has_normals(); ++k)
            input.tangents[k] = detail::read_rest(figure.tangents[k]);
        if (figure.has_tangents())
            input.handedness.assign(figure.handedness, figure.handedness + figure.point_count());
        const Status status = detail::bind_read_figure(detail::figure_input(coordinates, input.points), input,
                                                       options, running, bound);
        return status == Status::ok
                   ? detail::transfer_labels(figure.labels, result.report.old_handles, bound.value)
                   : status;
    });
    static_cast<FigureBindReport&>(result.report) = std::move(bound.report);
    if (result.report.status == Status::ok) result.value = std::move(bound.value);
    return result;
}
template <CageCoordinates C>
    requires GradientCoordinates<C>
Result<FigureBinding<typename C::scalar, C::dimension>, CageRebindReport>
rebind_cage(const FigureBinding<typename C::scalar, C::dimension>& figure, const C& coordinates,
            std::span<const std::size_t> old_handles = {}, const BindOptions& options = {},
            const Running& running = {}) {
    if (!figure.handedness.empty() && figure.handedness.size() != figure.points.point_count()) {
        Result<FigureBinding<typename C::scalar, C::dimension>, CageRebindReport> refused;
        refused.report.points.status = refused.report.status = Status::vectors_do_not_match;
        return refused;
    }
    return rebind_cage(figure.view(), coordinates, old_handles, options, running);
}

} // namespace cageform::inline CAGEFORM_ABI
