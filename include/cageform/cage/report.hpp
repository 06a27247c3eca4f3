// What is wrong with a cage, fault by fault, with indices.
#pragma once

#include <cageform/core/detail/guard_memory.hpp>

#include <cstddef>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

enum class CageFaultKind : std::uint8_t {
    too_few_vertices, ///< loop or face `a` has `b` vertices, less than three; a point set `b`, less than D + 1
    not_a_simplex,    ///< `a` vertices where a simplex has `b`
    loops_do_not_match, ///< the loop sizes add up to `a`, the vertices to `b`
    vertex_not_finite,  ///< vertex `a`
    duplicate_vertices, ///< `a` and `b` coincide within rounding; in a polygon, neighbours
    edges_cross,        ///< the edges that start at vertices `a` and `b` cross or touch
    no_area,            ///< all vertices of loop `a` lie on one line
    degenerate_simplex, ///< the simplex has no volume relative to its size
    no_volume, ///< a box has no extent along axis `a`; a mesh has no faces, or the shell of face `a` is flat
    face_without_vertex,   ///< face `a` of a mesh names a vertex that there is not
    face_without_area,     ///< the corners of face `a` lie on one line
    face_not_planar,       ///< vertex `b` lies off the plane of face `a`, whose corner it is
    face_crosses_itself,   ///< the loop of face `a` crosses or touches itself, first at vertex `b`
    open_edge,             ///< only one face has the edge between vertices `a` and `b`
    edge_not_manifold,     ///< more than two faces have the edge between vertices `a` and `b`
    face_flipped,          ///< of the neighbouring faces `a` and `b` one is turned inside out
    vertex_not_manifold,   ///< the faces about vertex `a` are not one closed fan
    faces_cross,           ///< the faces `a` and `b` pass through each other
    radius_not_positive,   ///< of the interior cell at handle `a`
    interior_cell_outside, ///< the interior cell at handle `a`
    interior_cells_touch, ///< the cells or facets at handles `a` and `b`, elsewhere than in a vertex they share
    vertex_not_convex,   ///< vertex `a` is no convex corner, or the first of a second loop; not for this type
    sites_in_a_plane,    ///< all sites of a point set lie in a plane, or in the plane on a line
    bone_axes_dependent, ///< the axes of bone `a` lie in a plane, or in the plane on a line
    interior_cells_not_supported, ///< by this coordinate type; there are `a` cells
    gap_closed, ///< warning: only one face has the edge between vertices `a` and `b`; the gap was closed
    collinear_vertex,      ///< warning: vertex `a` lies on the straight line between its neighbours
    vertex_unused,         ///< warning: no face has vertex `a`; its weights are zero
    shell_turns_otherwise, ///< warning: the shell of face `a` is counter-clockwise seen from inside; handled
    loop_turns_otherwise,  ///< warning: loop `a` is clockwise, or a hole `a` counter-clockwise; handled
};

/// One fault; what `a` and `b` are stands with each kind.
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
    {CageFaultKind::face_without_vertex, Status::face_without_vertex, "face names a missing vertex"},
    {CageFaultKind::face_without_area, Status::face_without_area, "face without area"},
    {CageFaultKind::face_not_planar, Status::face_not_planar, "face not planar"},
    {CageFaultKind::face_crosses_itself, Status::face_crosses_itself, "face crosses or touches itself"},
    {CageFaultKind::open_edge, Status::cage_not_closed, "open edge"},
    {CageFaultKind::edge_not_manifold, Status::cage_not_manifold, "edge of more than two faces"},
    {CageFaultKind::face_flipped, Status::cage_faces_flipped, "neighbouring faces turn differently"},
    {CageFaultKind::vertex_not_manifold, Status::cage_not_manifold, "faces about a vertex are no fan"},
    {CageFaultKind::faces_cross, Status::cage_faces_cross, "faces cross"},
    {CageFaultKind::radius_not_positive, Status::radius_not_positive, "radius not positive"},
    {CageFaultKind::interior_cell_outside, Status::interior_cell_outside, "interior cell outside"},
    {CageFaultKind::interior_cells_touch, Status::interior_cells_touch, "interior cells touch"},
    {CageFaultKind::vertex_not_convex, Status::cage_not_convex, "vertex not convex"},
    {CageFaultKind::sites_in_a_plane, Status::sites_in_a_plane, "sites in a plane"},
    {CageFaultKind::bone_axes_dependent, Status::bone_axes_dependent, "axes of a bone in a plane"},
    {CageFaultKind::interior_cells_not_supported, Status::interior_cells_not_supported,
     "interior cells not supported"},
    {CageFaultKind::gap_closed, Status::ok, "open edge, closed (warning)"},
    {CageFaultKind::collinear_vertex, Status::ok, "collinear vertex (warning)"},
    {CageFaultKind::vertex_unused, Status::ok, "unused vertex (warning)"},
    {CageFaultKind::shell_turns_otherwise, Status::ok, "shell turns inside out (warning)"},
    {CageFaultKind::loop_turns_otherwise, Status::ok, "loop turns the other way (warning)"},
};
constexpr CageFaultText text_of(CageFaultKind kind) noexcept {
    for (const auto& row : cage_fault_texts) {
        if (row.kind == kind) return row;
    }
    return {kind, Status::ok, "unknown fault"};
}

} // namespace detail

/// The Status a fault leads to; ok for a fault that is only a warning.
constexpr Status status_of(CageFaultKind kind) noexcept {
    return detail::text_of(kind).status;
}
constexpr const char* to_string(CageFaultKind kind) noexcept {
    return detail::text_of(kind).text;
}

/// The faults of a cage. `status` is that of the first fault that is not a warning; out_of_memory
/// where the cage or its check found none.
struct CageReport {
    /// A tangle has as many crossings as pairs of edges.
    static constexpr std::size_t most_listed = 1000;

    Status status = Status::ok;
    std::vector<CageFault> faults; ///< all warnings, and the first `most_listed` of the others
    std::size_t fault_count = 0;   ///< of all that are no warnings, listed or not

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

/// What `check` is for a cage made with the status `made`: steps(report).
template <class Steps>
CageReport report_on(Status made, const Steps& steps) {
    CageReport report;
    report.status = made;
    if (made != Status::ok) return report;
    const Status status = guard_memory([&] {
        steps(report);
        return report.status;
    });
    if (status == Status::out_of_memory) report = {status, {}, 0};
    return report;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
