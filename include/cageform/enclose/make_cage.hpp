// Makes a 2D cage: loops of few vertices around a drawing. The drawing may have strokes, open paths,
// self-intersecting outlines and separate parts; only its coordinates must be finite.
//
// f is the unsigned distance from the figure minus the margin. A flood from the lattice boundary through f >
// 0 finds the outside; all other nodes are inside. The figure therefore need not be closed. With
// MakeCageOptions::holes, painted areas are filled first, and enclosed empty regions larger than 16 squared
// margins also count as outside.
//
// Steps (3D: make_cage_3d.hpp):
//   1  detail/distance_lattice.hpp  samples f on a lattice
//   2  detail/join_components.hpp   connects components by bridges and closes narrow gaps
//   3  plane/contour.hpp            traces the border of the outside: a tight cage with many vertices
//   4  plane/reduce_loop.hpp        merges neighbouring vertices; the loop only grows. For n requested
//                                   vertices, four trials leave n, 7n/8, 6n/8 and 5n/8 vertices
//   5  plane/relax_loop.hpp         moves, inserts and removes vertices to lower the energy of cage_loop.hpp;
//                                   the trial of least energy is kept
//   6  plane/cage_maker.hpp         runs the steps and measures the exact clearance; if the clearance is too
//                                   small, repeats the steps with a larger distance
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/enclose/detail/make_cage_into.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Makes a 2D cage of few vertices around a drawing.
///
///   figure   a range of DrawnSegment with radii >= 0, or a Drawing, which also lists painted areas (used
///            only by options.holes)
///   returns  a counter-clockwise loop of options.vertices vertices. Several loops share these vertices in
///            proportion to the square roots of their areas. Each loop gets at least four, so report.vertices
///            can be larger. The cage passes `check` and contains the figure exactly; report.clearance is at
///            least 0.9 margins
///   parts    connected by bridges 2.6 margins wide along a minimum spanning tree. Gaps below 3.2 margins are
///            closed
///   mirror   vertices are symmetric; the figure need not be
///   fewest   options.looseness searches for the fewest vertices and takes up to ten times as long
///   cost     about 50 ms for 1,000 segments, and up to 70 bytes for each of at most 2^24 lattice nodes. The
///            spacing is at most margin / 3 and 1/256 of the figure's longer side
///   errors   figure_empty; figure_not_finite (segment); figure_has_no_size; margin_not_positive;
///            margin_too_small; too_few_cage_vertices; mirror_not_supported; index_out_of_range (area);
///            cancelled; out_of_memory; cage_not_found, with the clearance of the last cage tried
///
/// Deterministic. If the figure is translated, or scaled by a power of two, the cage changes in the same way,
/// up to rounding.
template <Scalar T>
Result<Polygon<T>, MakeCageReport> make_cage(const Drawing<T>& drawing, const MakeCageOptions& options = {},
                                             const Running& running = {}) {
    Result<Polygon<T>, MakeCageReport> made;
    detail::run_into(made.report, [&] {
        return detail::make_cage_into(drawing.segments, drawing.areas, options, running, made);
    });
    if (!made) made.value = {};
    return made;
}

/// Encloses segments without painted areas.
template <class Segments, class T = decltype(std::remove_cv_t<detail::element_t<const Segments>>::radius)>
    requires(std::is_same_v<detail::element_t<const Segments>, const DrawnSegment<T>>)
Result<Polygon<T>, MakeCageReport> make_cage(const Segments& figure, const MakeCageOptions& options = {},
                                             const Running& running = {}) {
    return make_cage(Drawing<T>{figure, {}}, options, running);
}

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/enclose/plane/cage_maker.hpp>
#endif
