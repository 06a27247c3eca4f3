// Restores a figure that was packed without loss, for editing, and composes two levels of handles.
#pragma once

#include <cageform/binding/compose.hpp>
#include <cageform/binding/detail/copy_binding.hpp>
#include <cageform/binding/detail/figure_binder.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Restores a packed figure bit for bit: bindings, handedness and labels. Read clips, levels
/// and custom parts, such as the faces of the cage, from the packed figure itself. `pack` with
/// default options makes a dense figure, which this function can restore: an editor saves such a file
/// beside the run-time file, opens it later and packs it again.
///
///   figure   the result of `open`, or any other view
///   fails    binding_not_dense if weights were dropped, rounded or reordered; out_of_memory
///   cost     one copy
template <Scalar T, std::size_t D>
Result<FigureBinding<T, D>> unpack(const PackedFigureView<T, D>& figure) {
    Result<FigureBinding<T, D>> result;
    result.report = detail::guard_memory([&] {
        FigureBinding<T, D> made;
        const std::size_t vectors = figure.has_normals() ? D - 1 : 0;
        bool dense = figure.points.is_dense();
        for (std::size_t k = 0; k < vectors; ++k) dense = dense && figure.tangents[k].is_dense();
        if (!dense) return Status::binding_not_dense;
        made.points = detail::copy_binding(figure.points.dense());
        for (std::size_t k = 0; k < vectors; ++k)
            made.tangents[k] = detail::copy_binding(figure.tangents[k].dense());
        if (figure.has_tangents())
            made.handedness.assign(figure.handedness, figure.handedness + figure.point_count());
        if (figure.labels.begin != nullptr) {
            std::vector<std::string_view> labels;
            for (std::size_t h = 0; h < figure.handle_count(); ++h) labels.push_back(figure.label(h));
            if (const Status status = made.set_labels(labels); status != Status::ok) return status;
        }
        result.value = std::move(made);
        return Status::ok;
    });
    return result;
}

/// Composes a figure: its points, normals and tangents. Replaces a cage that is bound to a coarser cage
/// by the coarser one. The result has no labels, since the coarse binding has none.
///
///   fine, coarse, running, fails  as for `compose` of bindings
template <Scalar T, std::size_t D>
Result<FigureBinding<T, D>, ComposeReport> compose(const FigureBinding<T, D>& fine,
                                                   const Binding<T, D>& coarse, const Running& running = {}) {
    Result<FigureBinding<T, D>, ComposeReport> result;
    FigureBinding<T, D> made;
    const std::size_t bindings = fine.has_normals() ? D : 1;
    result.report.status = detail::guard_memory([&] {
        for (std::size_t n = 0; n < bindings; ++n) {
            auto composed =
                compose(n == 0 ? fine.points : fine.tangents[n - 1], coarse,
                        running.subtask(double(n) / double(bindings), double(n + 1) / double(bindings)));
            if (!composed) return composed.status();
            if (n == 0) result.report.still = std::move(composed.report.still);
            (n == 0 ? made.points : made.tangents[n - 1]) = std::move(composed.value);
        }
        made.handedness = fine.handedness;
        return Status::ok;
    });
    if (result)
        result.value = std::move(made);
    else
        result.report.still.clear();
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
