// Pushes points that lie inside a surface to its outside, such as clothes after a wrap.
#pragma once

#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/fit/detail/check_surface.hpp>
#include <cageform/fit/detail/outward_pusher.hpp>
#include <cageform/parallel/running.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Moves the vertices of a figure that lie inside a surface to its outside, and spreads the moves over the
/// figure. No face of the figure turns by more than 90°. Faces may still cross the surface between vertices.
///
///   surface   triangles; points near its rim are not moved
///   figure    its vertices and faces; without faces, each vertex moves by itself
///   may_move  #vertices. 0 marks vertices that may stay inside; they may move along with others. An empty
///             list requires all vertices to be outside. For clothes: `ClosestPlaces::are_outside` of the
///             source
///   out       at least #vertices
///   distance  from the surface at least, in the units of the mesh; not negative
///   cost      O(#vertices log #faces) and a sparse factorisation per round
///   fails     figure_empty; figure_not_finite, index_out_of_range, figure_has_no_size (the surface);
///             input_malformed (#may_move); value_not_finite (the distance); output_too_small; cancelled;
///             out_of_memory. `out` is then unchanged
template <MutablePointRangeIn<3> Out>
// NOLINTNEXTLINE(readability-function-size): surface, figure, mask, output, distance, threads
PushOutReport push_out(const SurfaceMesh& surface, const SurfaceMesh& figure, std::span<const char> may_move,
                       Out&& out, double distance = 0, const Running& running = {}) {
    PushOutReport report;
    detail::run_into(report, [&] {
        Status status = detail::check_surface(surface, report.culprit);
        if (status == Status::ok) status = detail::check_vertices(figure, report.culprit);
        if (status != Status::ok) return status;
        if (!may_move.empty() && may_move.size() != figure.vertices().size()) return Status::input_malformed;
        if (!(distance >= 0) || !is_finite(distance)) return Status::value_not_finite;
        if (std::size(out) < figure.vertices().size()) return Status::output_too_small;
        const ClosestPlaces places(surface.vertices(), surface.faces());
        detail::OutwardPusher pusher(places, figure, may_move, distance, report);
        status = pusher.run(running);
        if (status == Status::ok) status = running.end(status);
        if (status != Status::ok) return status;
        for (std::size_t i = 0; i < pusher.places().size(); ++i)
            store_point(out, i, vec_cast<range_scalar_t<Out>>(pusher.places()[i]));
        return Status::ok;
    });
    return report;
}

} // namespace cageform::inline CAGEFORM_ABI
