// The faults that `check` finds in a cage, with the indices of the vertices and faces involved.
#pragma once

#include <cageform/core/detail/guard_memory.hpp>

#include <cstddef>
#include <iterator>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

// X(kind, its Status (ok for a warning), "text", "meaning of the indices a and b")
// clang-format off
#define CAGEFORM_DETAIL_FAULTS(X) \
    X(too_few_vertices, too_few_vertices, "too few vertices", \
      "loop or face `a` has `b` vertices (< 3); a mesh or point set has `b` (< D + 1)") \
    X(not_a_simplex, not_a_simplex, "not a simplex", "a simplex has `b` vertices, but `a` were given") \
    X(loops_do_not_match, loops_do_not_match, "loop sizes do not add up", \
      "the loop sizes add up to `a`, but there are `b` vertices") \
    X(vertex_not_finite, vertex_not_finite, "vertex not finite", \
      "vertex `a` is NaN or infinite; in a cage of curves, point `b` of edge `a`") \
    X(duplicate_vertices, duplicate_vertices, "duplicate vertices", \
      "vertices `a` and `b` coincide within rounding; in a polygon they are neighbours") \
    X(edges_cross, cage_self_crossing, "edges cross or touch", \
      "the edges from vertices `a` and `b` cross or touch; `a` = `b`: one curve") \
    X(no_area, cage_has_no_area, "loop without area", "all vertices of loop `a` lie on one line") \
    X(degenerate_simplex, degenerate_simplex, "simplex without volume", \
      "the simplex has no volume relative to its size") \
    X(no_volume, cage_has_no_volume, "no volume", "a mesh has no faces, or the shell of face `a` is flat") \
    X(face_without_vertex, face_without_vertex, "vertex index of a face out of range", \
      "face `a` of a mesh has a vertex index out of range") \
    X(face_without_area, face_without_area, "face without area", "the corners of face `a` lie on one line") \
    X(face_not_planar, face_not_planar, "face not planar", \
      "vertex `b`, a corner of face `a`, lies off the face's plane") \
    X(face_crosses_itself, face_crosses_itself, "face crosses or touches itself", \
      "the loop of face `a` crosses or touches itself, first at vertex `b`") \
    X(face_fan_folds, face_fan_folds, "fan of a face folds", \
      "the fan of face `a` folds at the edge after vertex `b`") \
    X(open_edge, cage_not_closed, "open edge", "only one face has the edge between vertices `a` and `b`") \
    X(edge_not_manifold, cage_not_manifold, "edge of more than two faces", \
      "more than two faces have the edge between vertices `a` and `b`") \
    X(face_flipped, cage_faces_flipped, "neighbouring faces are oppositely oriented", \
      "the neighbouring faces `a` and `b` have opposite orientations") \
    X(vertex_not_manifold, cage_not_manifold, "faces around a vertex are not one fan", \
      "the faces around vertex `a` do not form one closed fan") \
    X(faces_cross, cage_faces_cross, "faces cross", "the faces `a` and `b` pass through each other") \
    X(radius_not_positive, radius_not_positive, "radius not positive", \
      "the interior cell at handle `a` has no positive radius") \
    X(interior_cell_outside, interior_cell_outside, "interior cell outside", \
      "the interior cell at handle `a` is not inside the boundary") \
    X(interior_cells_touch, interior_cells_touch, "interior cells touch", \
      "the cells or facets at handles `a` and `b` meet outside common vertices") \
    X(vertex_not_convex, cage_not_convex, "vertex not convex", \
      "vertex `a` is not a convex corner, or begins a second loop") \
    X(sites_in_a_plane, sites_in_a_plane, "sites lie in a plane", \
      "all sites lie in one plane; in 2D, on one line") \
    X(bone_axes_dependent, bone_axes_dependent, "axes of a bone lie in a plane", \
      "the axes of bone `a` lie in one plane; in 2D, on one line") \
    X(lattice_degree, lattice_degree_not_supported, "unsupported degree of a lattice", \
      "a lattice has degree `b` along axis `a`, which is zero or too high") \
    X(lattice_knots, lattice_knots_not_supported, "invalid knot of a lattice", \
      "axis `a` of a lattice has an invalid knot `b`, or an invalid number `b` of knots") \
    X(frame_not_finite, vertex_not_finite, "box not finite", \
      "column `a` of a box, or its origin (`a` = D), is NaN or infinite") \
    X(frame_flat, frame_flat, "axis of a box depends on the others", \
      "axis `a` of a box depends on the others") \
    X(falloff_negative, falloff_negative, "falloff negative", "the falloff of a lattice is negative or NaN") \
    X(face_divisions, divisions_not_supported, "divisions not supported", \
      "`a` divisions of faces: not 1 to 64, or not 1 where only 1 is supported") \
    X(loop_not_closed, loop_not_closed, "loop of curves not closed", \
      "loop `a` of curves is open after edge `b`") \
    X(curve_degree, curve_degree_not_supported, "unsupported degree of a curve", \
      "edge `a` has the unsupported degree `b` at rest or in poses") \
    X(disk_too_small, disk_too_small, "control point outside the disk", \
      "control point `a` of the cage lies outside the disk, or there is no disk") \
    X(interior_cells_not_supported, interior_cells_not_supported, "interior cells not supported", \
      "the coordinate type does not support interior cells; there are `a`") \
    X(face_fanned, ok, "face not planar, bound as a fan (warning)", \
      "warning: face `a` is not planar and is bound as a fan; see `fan_distances`") \
    X(edge_has_cusp, ok, "edge with a cusp (warning)", \
      "warning: edge `a` has a cusp at `b` thousandths of its parameter; divide it there") \
    X(gap_closed, ok, "open edge, closed (warning)", \
      "warning: only one face had the edge between vertices `a` and `b`; the gap was closed") \
    X(collinear_vertex, ok, "collinear vertex (warning)", \
      "warning: vertex `a` lies on the straight line between its neighbours") \
    X(vertex_unused, ok, "unused vertex (warning)", \
      "warning: no face uses vertex `a`; its weights are zero") \
    X(shell_orientation_reversed, ok, "shell oriented inwards (warning)", \
      "warning: the shell of face `a` is oriented inwards; this is corrected") \
    X(loop_orientation_reversed, ok, "loop orientation reversed (warning)", \
      "warning: outer loop `a` is clockwise, or hole `a` is not")
// clang-format on

enum class CageFaultKind : std::uint8_t {
#define CAGEFORM_DETAIL_NAME(kind, status, text, meaning) kind,
    CAGEFORM_DETAIL_FAULTS(CAGEFORM_DETAIL_NAME)
#undef CAGEFORM_DETAIL_NAME
};

/// One fault. The kind defines the meaning of `a` and `b`.
struct CageFault {
    CageFaultKind kind;
    std::size_t a = 0;
    std::size_t b = 0;
};

/// Returns the Status of a fault; ok for a warning.
constexpr Status status_of(CageFaultKind fault) noexcept {
#define CAGEFORM_DETAIL_STATUS(kind, status, text, meaning) Status::status,
    constexpr Status statuses[] = {CAGEFORM_DETAIL_FAULTS(CAGEFORM_DETAIL_STATUS)};
#undef CAGEFORM_DETAIL_STATUS
    return std::size_t(fault) < std::size(statuses) ? statuses[std::size_t(fault)] : Status::ok;
}
constexpr const char* to_string(CageFaultKind fault) noexcept {
    switch (fault) {
#define CAGEFORM_DETAIL_CASE(kind, status, text, meaning)                                                    \
    case CageFaultKind::kind: return text;
        CAGEFORM_DETAIL_FAULTS(CAGEFORM_DETAIL_CASE)
#undef CAGEFORM_DETAIL_CASE
    }
    return "unknown fault";
}
#undef CAGEFORM_DETAIL_FAULTS

/// The faults of a cage. `status` is that of the first fault that is not a warning, or out_of_memory.
struct CageReport {
    /// Limits the list, because a cage can have as many crossings as pairs of edges.
    static constexpr std::size_t most_listed = 1000;

    Status status = Status::ok;
    std::vector<CageFault> faults; ///< all warnings, and the first `most_listed` other faults
    std::size_t fault_count = 0;   ///< number of all faults that are not warnings
    /// Distance for each face_fanned, in the order of these warnings and in units of the cage. For four
    /// corners: from the fan to their bilinear patch. For more: from the plane to the farthest corner.
    std::vector<double> fan_distances = {};

    void add(CageFaultKind kind, std::size_t a = 0, std::size_t b = 0) {
        const Status fault = status_of(kind);
        if (fault != Status::ok && ++fault_count > most_listed) return;
        const Status listed = detail::guard_memory([&] {
            faults.push_back({kind, a, b});
            return fault;
        });
        if (status == Status::ok) status = listed;
    }
};

namespace detail {

/// Runs steps(report) if a cage was constructed with the status ok, and returns the report.
template <class Steps>
CageReport report_on(Status made, const Steps& steps) {
    CageReport report;
    report.status = made;
    if (made != Status::ok) return report;
    const Status status = guard_memory([&] {
        steps(report);
        return report.status;
    });
    if (status == Status::out_of_memory) report = {status, {}, 0, {}};
    return report;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
