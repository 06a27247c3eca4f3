// Makes a cage for a figure in space: a closed triangle mesh of few vertices around all faces. The figure
// only needs finite coordinates: holes, torn vertices, faces that cross and scattered parts are fine.
//
// f is the unsigned distance from the faces minus 1.12 margins; the surplus makes up for interpolation.
// A flood from the rim of the lattice through f > 0 finds the outside. Inside is all that it does not reach.
//
// The steps (make_cage.hpp does this in the plane):
//   1  space/space_distance.hpp    samples f on a lattice (detail/distance_lattice.hpp)
//   2  detail/join_components.hpp  joins separate components by bridges and closes narrow slits
//   3  space/surface_nets.hpp      makes the border of the outside: a tight mesh (shell.hpp) of very
//                                  many vertices
//      space/limb_rings.hpp        with options.rings: cuts the mesh along a plane across each limb
//   4  space/reduce_shell.hpp      collapses edges; the mesh stays clear of the figure and of itself
//   5  space/relax_shell.hpp       moves vertices and flips edges to lower an energy: volume, bad shapes
//   6  space/cage_maker.hpp        runs these steps, then measures the exact clearance; if too small,
//                                  tries again farther off
// pair_faces then makes faces of four corners (space/pair_faces.hpp, by space/matching.hpp).
#pragma once

#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/enclose/detail/make_cage_into.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Makes a cage of few vertices around all faces of a figure.
///
///   vertices, faces   any triangles; vertices without a face do not count
///   returns  a closed mesh of options.vertices vertices, counter-clockwise seen from outside. It passes
///            `check`; no face meets one of the figure, and report.clearance, exact, is at least 0.9 of the
///            margin. A corner of each connected component of the figure (of 4,096, if there are more) is
///            inside
///   parts    are joined by bridges 2.9 margins wide, along a shortest tree; without one_cage, the
///            shells share options.vertices. Gaps of the figure below 3.6 margins are closed: grown by 1.12
///            margins, they leave slits below 1.2 of these
///   tunnels  stay, unless options.fill_tunnels; report.tunnels counts them
///   mirror   vertices come in pairs, except for those on the plane; the number requested is met up to one
///   vertices report.vertices can differ from options.vertices, see there; options.looseness searches for the
///            fewest, in twice to three times the time up to a thousand vertices, and then more
///   rings    with options.rings, report.parts has the parts of the cage; each joint is a closed path of four
///            edges or more in one plane, to within rounding. Limbs are found as by find_parts, on meshes of
///            four times the vertices, twice and once. This takes 1.3 to 2 times as long
///   cost     about a second, and some 40 bytes for each of at most 250^3 nodes of a lattice. With
///            small margins it has fewer than two nodes per margin; below 0.6 % of the longest
///            side, make_cage fails. Several threads share what grows with the figure's faces: two save a
///            quarter of the time for a million faces, and little below 10,000
///   errors   figure_empty; index_out_of_range, by face; figure_not_finite, by vertex; figure_has_no_size;
///            margin_not_positive; margin_too_small; too_few_cage_vertices; mirror_not_supported;
///            cancelled; out_of_memory; cage_not_found, with the clearance of the last cage tried
///
/// Equal input gives equal cages.
template <PointRange R, FaceRange F>
    requires(range_dimension<R> == 3)
Result<TriangleMesh<range_scalar_t<R>>, MakeCageReport> make_cage(const R& vertices, const F& faces,
                                                                  const MakeCageOptions& options = {},
                                                                  const Running& running = {}) {
    using T = range_scalar_t<R>;
    Result<TriangleMesh<T>, MakeCageReport> made;
    detail::run_into(made.report, [&] {
        const detail::FigureOfFaces<T> figure(vertices, faces);
        return detail::make_cage_into<T>(figure.vertices, figure.faces, options, running, made);
    });
    if (!made) made.value = {};
    return made;
}

/// Pairs triangles of a cage to faces of four corners, as many as possible: artists edit these by loops.
///
///   made      by make_cage, for the same figure and options; its vertices may have been rounded since
///   returns   the same vertices; every triangle is a face, or half of one. Its report is that of `made` with
///             `quads`, `triangles`, `worst_warp` and the least clearance of all cuts
///   a pair    is convex, seen along its normal, with angles of 20 to 160 degrees, and its warp is at most
///             0.4. However each face is cut along a diagonal, or bound as a fan, the cage keeps a quarter
///             of the margin from the figure, holds it, and does not cross itself. Edges of joints in
///             made.report.parts are sides of faces
///   choice    most pairs; of such choices the best sum of square angles and low warps, by a maximum weight
///             matching. Where faces would meet in some cut, one of them is given up
///   mirror    pairs come in mirrored pairs, or are their own images
///   cost      O(n log n) as a rule for n faces, and for each face of the figure a look at the pairs near it
///   errors    those of `made`, and of make_cage for an invalid figure
///
/// Coordinates bind faces that are not planar as fans (PolyhedralOptions). Green coordinates have four scaled
/// normals for such a face.
template <Scalar T, PointRange R, FaceRange F>
    requires(range_dimension<R> == 3)
Result<PolyhedralMesh<T>, MakeCageReport> pair_faces(const Result<TriangleMesh<T>, MakeCageReport>& made,
                                                     const R& vertices, const F& faces,
                                                     const MakeCageOptions& options = {}) {
    Result<PolyhedralMesh<T>, MakeCageReport> paired{{}, made.report};
    if (!made) return paired;
    detail::run_into(paired.report, [&] {
        const detail::FigureOfFaces<T> figure(vertices, faces);
        return detail::pair_faces_into<T>(made.value, figure.vertices, figure.faces, options, paired);
    });
    paired.report.seconds += made.report.seconds;
    if (!paired) paired.value = {};
    return paired;
}

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/enclose/space/pair_faces.hpp>
#endif
