// Transfers a binding to a changed figure without evaluating coordinates again.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/detail/rebinder.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Transfers a binding to a changed figure: points may be added, removed, reordered, or moved a
/// little. The cage stays the same, and its coordinates are not evaluated.
///
///   binding  of points, not of vectors; views are read without copying
///   points   any PointRange of the same dimension, converted to the binding's scalar: the new
///            figure
///   weights  a point with exactly the coordinates of an old point gets its weights, bit for bit.
///            Other points get weights interpolated linearly from the nearest old points, with the
///            least change that restores Σw = 1 and Σwc = p. If most weights of the binding are zero,
///            zeros stay zeros. If old points follow the boundary at an offset, so do new ones
///            between them. Linear weights are exact to rounding up to half a spacing off the old
///            figure, others to second order in its spacing: a figure twice as dense has errors a
///            quarter as large. Slopes that the old points do not determine (off a sheet in 3D, far
///            away) follow from the least change
///   special  a new point is kept in place if its nearest old point is (all weights zero). Old
///            points that are not finite are ignored; a bad new *point* is listed and kept in
///            place, and the others are transferred nevertheless
///   returns  the binding and its report. Unless the report's status is ok the binding is empty; no
///            points give a binding of none. The result depends neither on threads nor on the order
///            of the points
///   cost     O(#old (log #old + #handles)), and O(log #old + #handles) for a point that is
///            matched, O(log #old + neighbours · #handles) for one that is not: 3 µs at 66 handles
///            in 3D. Memory: the new binding, and some 60 bytes for each old and new point
///   fails    binding_empty: points, but none before; weight_not_finite (RebindReport::culprit);
///            cancelled; out_of_memory
template <Scalar T, std::size_t D, PointRange R>
    requires(range_dimension<R> == D)
Result<Binding<T, D>, RebindReport> rebind(const BindingView<T, D>& binding, const R& points,
                                           const RebindOptions& options = {}, const Running& running = {}) {
    return detail::rebind_points(binding, detail::read_points<T>(points), options, running);
}
template <Scalar T, std::size_t D, PointRange R>
    requires(range_dimension<R> == D)
Result<Binding<T, D>, RebindReport> rebind(const Binding<T, D>& binding, const R& points,
                                           const RebindOptions& options = {}, const Running& running = {}) {
    return rebind(binding.view(), points, options, running);
}

} // namespace cageform::inline CAGEFORM_ABI
