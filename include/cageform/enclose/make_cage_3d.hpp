// Makes a 3D cage: a closed triangle mesh of few vertices around all faces of a figure. The figure may have
// holes, torn vertices, crossing faces and separate parts; only its coordinates must be finite.
//
// f is the unsigned distance from the faces minus 1.12 margins; the surplus covers interpolation errors. A
// flood from the lattice boundary through f > 0 finds the outside; all other nodes are inside.
//
// Steps (2D: make_cage.hpp):
//   1  space/space_distance.hpp    samples f on a lattice (detail/distance_lattice.hpp)
//   2  detail/join_components.hpp  connects components by bridges and closes narrow gaps
//   3  space/surface_nets.hpp      meshes the border of the outside (shell.hpp): tight, with many vertices
//      space/limb_rings.hpp        with options.rings: cuts the mesh along a plane across each limb
//   4  space/reduce_shell.hpp      collapses edges without touching the figure or the mesh itself
//   5  space/relax_shell.hpp       moves vertices and flips edges to lower an energy (volume, poor shapes)
//   6  space/cage_maker.hpp        runs the steps and measures the exact clearance; if the clearance is too
//                                  small, repeats the steps with a larger distance
// pair_faces then merges triangles to quads (space/pair_faces.hpp, space/matching.hpp).
#pragma once

#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/enclose/detail/make_cage_into.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Makes a 3D cage of few vertices around all faces of a figure.
///
///   vertices, faces  any triangles; vertices without a face are ignored
///   returns          a closed mesh of options.vertices vertices (exceptions: MakeCageOptions::vertices),
///                    counter-clockwise seen from outside. It passes `check`. No cage face touches the
///                    figure, and report.clearance, which is exact, is at least 0.9 margins. A corner of each
///                    connected component is inside (tested for at most 4,096 components)
///   parts            connected by bridges 2.9 margins wide along a minimum spanning tree; without one_cage,
///                    the shells share options.vertices. Gaps below 3.6 margins are closed
///   tunnels          kept, unless options.fill_tunnels; counted in report.tunnels
///   mirror           vertices are symmetric; their number may differ from the request by one
///   fewest           with options.looseness, the search for the fewest vertices takes two to three times as
///                    long, and longer above 1,000 vertices
///   rings            with options.rings, report.parts has the parts of the cage. Each joint is a closed,
///                    planar (up to rounding) path of at least four edges. Limbs are found as by find_parts,
///                    on meshes of four times, twice and once the requested vertices. Takes 1.3 to 2 times as
///                    long
///   cost             about a second, and 40 bytes for each of at most 250^3 lattice nodes. Because of this
///                    limit, small margins span fewer than two nodes. Margins below 0.6 % of the longest side
///                    fail. Only the work per figure face is divided among threads. Two threads save 25 % of
///                    the time for a million faces, and little below 10,000 faces
///   errors           figure_empty; index_out_of_range (face); figure_not_finite (vertex);
///                    figure_has_no_size; margin_not_positive; margin_too_small; too_few_cage_vertices;
///                    mirror_not_supported; cancelled; out_of_memory; cage_not_found, with the clearance of
///                    the last cage tried
///
/// Deterministic.
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

/// Merges pairs of triangles to quads, as many as possible, so that artists can select edge loops.
///
///   made     the result of make_cage for this figure and these options; its vertices may have been rounded
///            since
///   returns  the vertices of `made`; each face is a triangle of `made` or a pair. The report is that of
///            `made` with `quads`, `triangles`, `worst_warp` and the least clearance over all triangulations
///   quads    convex seen along their normal, with angles of 20 to 160 degrees and a warp of at most 0.4. The
///            cage is at least a quarter of the margin from the figure, encloses it and does not cross
///            itself. This holds for both diagonals of each quad, and for fans. Edges of joints in
///            made.report.parts are kept
///   choice   as many quads as possible; among such choices, the greatest sum of qualities, which rate right
///            angles and low warp (maximum weight matching). If two quads may intersect, the worse one is
///            dropped
///   mirror   the quads are symmetric
///   cost     typically O(n log n) for n cage faces; each figure face is tested against nearby pairs
///   errors   those of `made`, and of make_cage for an invalid figure
///
/// Cage coordinates treat non-planar faces as fans (PolyhedralOptions). Green coordinates have four scaled
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
