// Wraps one figure onto another: finds a pose of a lattice, or of a cage, that lays a source on a target. The
// map moves all of space, so clothes, hair and joints of the source can follow.
#pragma once

#include <cageform/fit/detail/move_wrap.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Wraps a source onto a target by a lattice of cubic B-splines. The search needs no landmarks if both
/// figures have about the same pose. No step folds space at the samples, at the vertices of the source, or at
/// the followers.
///
///     const auto [wrap, report] = cageform::wrap({body, body_faces}, {scan, scan_faces});
///     Status status = move(wrap, clothes, clothes_on_scan);
///
///   source, target  triangle meshes of any topology; open, noisy or in parts. Both must have the same
///                   direction of up and front, unless three or more landmarks align them
///   returns         the map, and a report. For cancelled and fit_not_reached, the best map so far
///   cost            see fit/README.md; about 6 s for bodies of 13,000 vertices; memory about 200 MB
///   fails           figure_empty; figure_not_finite (a vertex); index_out_of_range (a face);
///                   figure_has_no_size; value_not_finite (a landmark, a follower or an option);
///                   weights_not_positive (a landmark); too_many_handles (of the coarsest lattice: the source
///                   or a landmark is far larger or farther than the target); fit_not_reached (less than half
///                   of the source or of the target has a match); cancelled; out_of_memory. The report names
///                   the culprit
template <Scalar T = double>
Result<Wrap<T>, WrapReport> wrap(const SurfaceMesh& source, const SurfaceMesh& target,
                                 const WrapOptions& options = {}, const Running& running = {}) {
    Result<Wrap<T>, WrapReport> result;
    WrapReport timed;
    detail::run_into(timed, [&] { return detail::find_wrap<T>({source, target, options}, running, result); });
    result.report.status = timed.status;
    result.report.seconds = timed.seconds;
    return result;
}

/// Wraps by a pose of a cage, then by a lattice behind the cage (WrapOptions::finest; 0: the cage alone). The
/// pose is one for `clone`, with all that is bound to the cage.
///
///   coordinates  any with gradients. Coordinates without weights outside keep points outside near the cage
///   cost         as above, plus the weights of all vertices, followers and samples; O(#handles) memory for
///                each of them
///   fails        as above, and as the cage's check and `bind_jacobians`
template <detail::SampledCoordinates C>
    requires(C::dimension == 3)
Result<Wrap<typename C::scalar>, WrapReport> wrap(const C& coordinates, const SurfaceMesh& source,
                                                  const SurfaceMesh& target, const WrapOptions& options = {},
                                                  const Running& running = {}) {
    using T = typename C::scalar;
    Result<Wrap<T>, WrapReport> result;
    WrapReport timed;
    detail::run_into(timed, [&] {
        if (coordinates.cage_report().status != Status::ok) return coordinates.cage_report().status;
        if constexpr (!GradientCoordinates<C>) {
            if (!coordinates.has_gradients()) return Status::gradients_not_supported;
        }
        C solved = coordinates; // keeps its functions for all calls
        if constexpr (requires(C& c) { c.solve(running); }) {
            const Status status = solved.solve(running.subtask(0, 0.2)).status;
            if (status != Status::ok) return status;
        }
        const auto handles = handle_view(solved);
        detail::WrapCageInput cage;
        for (std::size_t i = 0; i < handles.count; ++i) {
            cage.rest.push_back(vec_cast<double>(handles.rest[i]));
            cage.is_point.push_back(handles.is_point(i) ? 1 : 0);
        }
        cage.evaluate = [&](std::span<const Vec<double, 3>> points, bool derivatives,
                            detail::DenseRows& rows) {
            return detail::evaluate_for_wrap(solved, points, derivatives, running, rows);
        };
        return detail::find_wrap<T>({source, target, options, &cage}, running.subtask(0.2, 1), result);
    });
    result.report.status = timed.status;
    result.report.seconds = timed.seconds;
    return result;
}

/// Moves points by a wrap without a cage.
///
///   points     in the space of the source; may be `out`
///   out        at least #points
///   jacobians  out: the columns of the Jacobian of the map at each point; or empty
///   cost       that of `bind` to the lattice, 64 weights per point: about 2 µs
///   fails      bindings_differ (the wrap has a cage: pass its coordinates); output_too_small; as `bind`;
///              cancelled; out_of_memory. `out` is then unchanged
template <Scalar T, PointRangeIn<3> R, MutablePointRangeIn<3> Out>
Status move(const Wrap<T>& wrap, const R& points, Out&& out,
            std::type_identity_t<std::span<std::array<Vec<T, 3>, 3>>> jacobians = {},
            const Running& running = {}) {
    if (!wrap.pose.empty()) return Status::bindings_differ;
    return detail::move_with<T>(points, out, jacobians, [&](auto& moved, auto& matrices) {
        return detail::move_by_lattice(wrap, moved, matrices, running);
    });
}

/// Moves points by a wrap with a cage.
///
///   coordinates  those of the wrap
///   fails        pose_size_differs (the coordinates have another number of handles); as above
template <detail::SampledCoordinates C, PointRangeIn<3> R, MutablePointRangeIn<3> Out>
// NOLINTNEXTLINE(readability-function-size): one parameter more than for a wrap without a cage
Status move(const Wrap<typename C::scalar>& wrap, const C& coordinates, const R& points, Out&& out,
            std::type_identity_t<std::span<std::array<Vec<typename C::scalar, 3>, 3>>> jacobians = {},
            const Running& running = {}) {
    using T = typename C::scalar;
    return detail::move_with<T>(points, out, jacobians, [&](auto& moved, auto& matrices) {
        const Status status = detail::move_by_cage(wrap, coordinates, moved, matrices, running);
        return status == Status::ok ? detail::move_by_lattice(wrap, moved, matrices, running) : status;
    });
}

} // namespace cageform::inline CAGEFORM_ABI
