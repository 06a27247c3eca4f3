// Folds: where a pose inverts a figure, and the largest step without a fold.
#pragma once

#include <cageform/clone/clone.hpp>
#include <cageform/clone/detail/fold_places.hpp>
#include <cageform/clone/types/fold_report.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Reports folds of the deformation at the bound points. The space between points is not tested; test the
/// cells of a mesh instead.
///
///   columns  bindings of the D axes (`bind_jacobians`), D = 2 or 3, in one order
///   pose     as for `clone`
///   fails    threshold_not_supported, bindings_differ, pose_size_differs, pose_not_finite
///   cost     that of D clones, and D³ operations a point; no allocation
template <AnyBinding B, std::size_t D, PointRangeIn<D> Pose>
    requires(B::dimension == D && (D == 2 || D == 3))
FoldReport report_folds(const std::array<B, D>& columns, const Pose& pose,
                        const FoldOptions& options = {}) noexcept {
    const auto views = detail::views_of(columns);
    FoldReport report;
    report.status = detail::is_supported(options) ? detail::check_jacobians(views, pose)
                                                  : Status::threshold_not_supported;
    if (report.status != Status::ok) return report;
    detail::JacobianPlaces(views).for_each(
        [&](std::size_t point, const detail::Columns<D>& jacobian) {
            detail::add_to_report(report, options, point, jacobian);
        },
        pose);
    return report;
}

/// Reports the folded cells of a mesh. A cell is folded if the ratio of its posed volume to its volume at
/// rest is not above the threshold. Cells at rest may have either orientation.
///
///   rest, posed  the same number of points in 2D or 3D
///   cells        a range of cells of D + 1 indices: triangles in 2D, tetrahedra in 3D. Triangles in 3D do
///                not compile
///   fails        threshold_not_supported; pose_size_differs; index_out_of_range and degenerate_simplex (flat
///                at rest), with the cell. Cells with a corner that is not finite are skipped
///   cost         O(#cells); no allocation
template <PointRange Rest, PointRangeIn<range_dimension<Rest>> Posed,
          detail::SimplexRange<range_dimension<Rest>> Cells>
    requires(range_dimension<Rest> == 2 || range_dimension<Rest> == 3)
FoldReport report_folds(const Rest& rest, const Posed& posed, const Cells& cells,
                        const FoldOptions& options = {}) noexcept {
    const detail::CellPlaces<Rest, Cells> places(rest, cells);
    FoldReport report;
    report.status = detail::check_cells(places, options, report.culprit, rest, posed);
    if (report.status != Status::ok) return report;
    places.for_each(
        [&](std::size_t cell, const detail::Columns<range_dimension<Rest>>& edges) {
            detail::add_to_report(report, options, cell, places.jacobian(cell, edges));
        },
        posed);
    return report;
}

/// Finds the largest step from one pose towards another without a fold at a bound point. Jacobians are linear
/// in the step, so the first fold is the root of a polynomial.
///
///   columns, from, to  as for `report_folds`
///   returns            step 1 and nowhere if nothing folds; step 0 and a point that is folded at `from`;
///                      else a step, and the first point to fold. The step ends before the first fold, by a
///                      relative 1e-9 or by rounding (float: 1e-6)
///   fails              as `report_folds`
///   cost               3 D clones and some 100 operations a point; no allocation
template <AnyBinding B, std::size_t D, PointRangeIn<D> From, PointRangeIn<D> To>
    requires(B::dimension == D && (D == 2 || D == 3))
StepReport largest_step(const std::array<B, D>& columns, const From& from, const To& to,
                        const FoldOptions& options = {}) noexcept {
    const auto views = detail::views_of(columns);
    StepReport report;
    report.status = detail::is_supported(options) ? detail::check_jacobians(views, from)
                                                  : Status::threshold_not_supported;
    if (report.status == Status::ok) report.status = detail::check_jacobians(views, to);
    if (report.status != Status::ok) return report;
    return detail::step_over(detail::JacobianPlaces(views), options, from, to);
}

/// Finds the largest step from one set of points towards another in which no cell folds.
template <PointRange Rest, PointRangeIn<range_dimension<Rest>> From, PointRangeIn<range_dimension<Rest>> To,
          detail::SimplexRange<range_dimension<Rest>> Cells>
    requires(range_dimension<Rest> == 2 || range_dimension<Rest> == 3)
StepReport largest_step(const Rest& rest, const From& from, const To& to, const Cells& cells,
                        const FoldOptions& options = {}) noexcept {
    const detail::CellPlaces<Rest, Cells> places(rest, cells);
    StepReport report;
    report.status = detail::check_cells(places, options, report.culprit, rest, from);
    if (report.status == Status::ok && std::size(to) != std::size(rest))
        report.status = Status::pose_size_differs;
    if (report.status != Status::ok) return report;
    return detail::step_over(places, options, from, to);
}

} // namespace cageform::inline CAGEFORM_ABI
