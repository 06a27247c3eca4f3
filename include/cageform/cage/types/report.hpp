// The faults that `check` finds in a cage, with the indices of the vertices and faces involved.
#pragma once

#include <cageform/core/detail/guard_memory.hpp>

#include <cstddef>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

enum class CageFaultKind : std::uint8_t {
    too_few_vertices,    ///< loop or face `a` has `b` vertices (< 3); a mesh or point set has `b` (< D + 1)
    not_a_simplex,       ///< a simplex has `b` vertices, but `a` were given
    loops_do_not_match,  ///< the loop sizes add up to `a`, but there are `b` vertices
    vertex_not_finite,   ///< vertex `a` is NaN or infinite; in a cage of curves, point `b` of edge `a`
    duplicate_vertices,  ///< vertices `a` and `b` coincide within rounding; in a polygon they are neighbours
    edges_cross,         ///< the edges from vertices `a` and `b` cross or touch; `a` = `b`: one curve
    no_area,             ///< all vertices of loop `a` lie on one line
    degenerate_simplex,  ///< the simplex has no volume relative to its size
    no_volume,           ///< a mesh has no faces, or the shell of face `a` is flat
    face_without_vertex, ///< face `a` of a mesh has a vertex index out of range
    face_without_area,   ///< the corners of face `a` lie on one line
    face_not_planar,     ///< vertex `b`, a corner of face `a`, lies off the face's plane
    face_crosses_itself, ///< the loop of face `a` crosses or touches itself, first at vertex `b`
    face_fan_folds,      ///< the fan of face `a` folds at the edge after vertex `b`
    open_edge,           ///< only one face has the edge between vertices `a` and `b`
    edge_not_manifold,   ///< more than two faces have the edge between vertices `a` and `b`
    face_flipped,        ///< the neighbouring faces `a` and `b` have opposite orientations
    vertex_not_manifold, ///< the faces around vertex `a` do not form one closed fan
    faces_cross,         ///< the faces `a` and `b` pass through each other
    radius_not_positive, ///< the interior cell at handle `a` has no positive radius
    interior_cell_outside, ///< the interior cell at handle `a` is not inside the boundary
    interior_cells_touch,  ///< the cells or facets at handles `a` and `b` meet outside common vertices
    vertex_not_convex,     ///< vertex `a` is not a convex corner, or begins a second loop
    sites_in_a_plane,      ///< all sites lie in one plane; in 2D, on one line
    bone_axes_dependent,   ///< the axes of bone `a` lie in one plane; in 2D, on one line
    lattice_degree,        ///< the degree `b` of a lattice along axis `a` is zero or too high
    lattice_knots,         ///< along axis `a` of a lattice, knot `b` or the number `b` of knots is invalid
    frame_not_finite,      ///< column `a` of a box is NaN or infinite; `a` = D: the origin is
    frame_flat,            ///< axis `a` of a box depends on the others
    falloff_negative,      ///< the falloff of a lattice is negative or NaN
    face_divisions,        ///< `a` divisions of faces: not 1 to 64, or not 1 where only 1 is supported
    loop_not_closed,       ///< loop `a` of curves is open after edge `b`
    curve_degree,          ///< edge `a` has the unsupported degree `b` at rest or in poses
    disk_too_small,        ///< control point `a` of the cage lies outside the disk, or there is no disk
    interior_cells_not_supported, ///< the coordinate type does not support interior cells; there are `a`
    face_fanned,   ///< warning: face `a` is not planar and is bound as a fan; see `fan_distances`
    edge_has_cusp, ///< warning: edge `a` has a cusp at `b` thousandths of its parameter; divide it there
    gap_closed,    ///< warning: only one face had the edge between vertices `a` and `b`; the gap was closed
    collinear_vertex,           ///< warning: vertex `a` lies on the straight line between its neighbours
    vertex_unused,              ///< warning: no face uses vertex `a`; its weights are zero
    shell_orientation_reversed, ///< warning: the shell of face `a` is oriented inwards; this is corrected
    loop_orientation_reversed,  ///< warning: outer loop `a` is clockwise, or hole `a` is not
};

/// One fault. The kind defines the meaning of `a` and `b`.
struct CageFault {
    CageFaultKind kind;
    std::size_t a = 0;
    std::size_t b = 0;
};

namespace detail {

struct CageFaultText {
    CageFaultKind kind;
    Status status; ///< ok for a warning
    const char* text;
};
inline constexpr CageFaultText cage_fault_texts[] = {
    {CageFaultKind::too_few_vertices, Status::too_few_vertices, "too few vertices"},
    {CageFaultKind::not_a_simplex, Status::not_a_simplex, "not a simplex"},
    {CageFaultKind::loops_do_not_match, Status::loops_do_not_match, "loop sizes do not add up"},
    {CageFaultKind::vertex_not_finite, Status::vertex_not_finite, "vertex not finite"},
    {CageFaultKind::duplicate_vertices, Status::duplicate_vertices, "duplicate vertices"},
    {CageFaultKind::edges_cross, Status::cage_self_crossing, "edges cross or touch"},
    {CageFaultKind::no_area, Status::cage_has_no_area, "loop without area"},
    {CageFaultKind::degenerate_simplex, Status::degenerate_simplex, "simplex without volume"},
    {CageFaultKind::no_volume, Status::cage_has_no_volume, "no volume"},
    {CageFaultKind::face_without_vertex, Status::face_without_vertex, "vertex index of a face out of range"},
    {CageFaultKind::face_without_area, Status::face_without_area, "face without area"},
    {CageFaultKind::face_not_planar, Status::face_not_planar, "face not planar"},
    {CageFaultKind::face_crosses_itself, Status::face_crosses_itself, "face crosses or touches itself"},
    {CageFaultKind::face_fan_folds, Status::face_fan_folds, "fan of a face folds"},
    {CageFaultKind::open_edge, Status::cage_not_closed, "open edge"},
    {CageFaultKind::edge_not_manifold, Status::cage_not_manifold, "edge of more than two faces"},
    {CageFaultKind::face_flipped, Status::cage_faces_flipped, "neighbouring faces are oppositely oriented"},
    {CageFaultKind::vertex_not_manifold, Status::cage_not_manifold, "faces around a vertex are not one fan"},
    {CageFaultKind::faces_cross, Status::cage_faces_cross, "faces cross"},
    {CageFaultKind::radius_not_positive, Status::radius_not_positive, "radius not positive"},
    {CageFaultKind::interior_cell_outside, Status::interior_cell_outside, "interior cell outside"},
    {CageFaultKind::interior_cells_touch, Status::interior_cells_touch, "interior cells touch"},
    {CageFaultKind::vertex_not_convex, Status::cage_not_convex, "vertex not convex"},
    {CageFaultKind::sites_in_a_plane, Status::sites_in_a_plane, "sites lie in a plane"},
    {CageFaultKind::bone_axes_dependent, Status::bone_axes_dependent, "axes of a bone lie in a plane"},
    {CageFaultKind::lattice_degree, Status::lattice_degree_not_supported, "unsupported degree of a lattice"},
    {CageFaultKind::lattice_knots, Status::lattice_knots_not_supported, "invalid knot of a lattice"},
    {CageFaultKind::frame_not_finite, Status::vertex_not_finite, "box not finite"},
    {CageFaultKind::frame_flat, Status::frame_flat, "axis of a box depends on the others"},
    {CageFaultKind::falloff_negative, Status::falloff_negative, "falloff negative"},
    {CageFaultKind::face_divisions, Status::divisions_not_supported, "divisions not supported"},
    {CageFaultKind::loop_not_closed, Status::loop_not_closed, "loop of curves not closed"},
    {CageFaultKind::curve_degree, Status::curve_degree_not_supported, "unsupported degree of a curve"},
    {CageFaultKind::disk_too_small, Status::disk_too_small, "control point outside the disk"},
    {CageFaultKind::interior_cells_not_supported, Status::interior_cells_not_supported,
     "interior cells not supported"},
    {CageFaultKind::face_fanned, Status::ok, "face not planar, bound as a fan (warning)"},
    {CageFaultKind::edge_has_cusp, Status::ok, "edge with a cusp (warning)"},
    {CageFaultKind::gap_closed, Status::ok, "open edge, closed (warning)"},
    {CageFaultKind::collinear_vertex, Status::ok, "collinear vertex (warning)"},
    {CageFaultKind::vertex_unused, Status::ok, "unused vertex (warning)"},
    {CageFaultKind::shell_orientation_reversed, Status::ok, "shell oriented inwards (warning)"},
    {CageFaultKind::loop_orientation_reversed, Status::ok, "loop orientation reversed (warning)"},
};
constexpr CageFaultText text_of(CageFaultKind kind) noexcept {
    for (const auto& row : cage_fault_texts) {
        if (row.kind == kind) return row;
    }
    return {kind, Status::ok, "unknown fault"};
}

} // namespace detail

/// Returns the Status of a fault; ok for a warning.
constexpr Status status_of(CageFaultKind kind) noexcept {
    return detail::text_of(kind).status;
}
constexpr const char* to_string(CageFaultKind kind) noexcept {
    return detail::text_of(kind).text;
}

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
