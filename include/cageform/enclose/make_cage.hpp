// Makes a cage for a figure in the plane: loops of few vertices around everything that is drawn. The figure
// needs only finite coordinates: strokes, open paths, self-crossing outlines, scattered parts are fine.
//
// f is the unsigned distance from the figure minus the margin. A flood from the rim of the lattice through
// f > 0 finds the outside. Inside is all that it does not reach: the figure needs no inside of its own.
// With MakeCageOptions::holes, painted areas are filled first, and enclosed empty regions larger than 16
// squared margins count as outside too.
//
// The steps (make_cage_3d.hpp does this in space):
//   1  detail/distance_lattice.hpp  samples f on a lattice
//   2  detail/join_components.hpp   joins separate components by bridges and closes narrow slits
//   3  plane/contour.hpp            traces the border of the outside: a tight cage of very many vertices
//   4  plane/reduce_loop.hpp        merges neighbouring vertices so that the loop only grows, to n, 7n/8,
//                                   6n/8 and 5n/8 of the n vertices of a loop
//   5  plane/relax_loop.hpp         moves, inserts, removes vertices to lower the energy of cage_loop.hpp;
//                                   of the four the loop of least energy stays
//   6  plane/cage_maker.hpp         runs these steps, then measures the exact clearance; if too small,
//                                   tries again farther off
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/enclose/detail/make_cage_into.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Makes a cage of few vertices around everything that is drawn.
///
///   figure   a range of DrawnSegment, radii not negative; or a Drawing, which also says which segments are
///            outlines of painted areas. Only options.holes uses these
///   returns  a loop of options.vertices vertices, counter-clockwise. Several loops share them by the roots
///            of their areas, at least four each, so report.vertices can be larger. The cage passes `check`
///            and contains the figure exactly; report.clearance is at least 0.9 of the margin
///   parts    are joined by bridges 2.6 margins wide, a shortest tree; gaps of the drawing below 3.2
///            margins are closed: grown by the margin, they leave slits below 1.2 margins
///   mirror   vertices come in pairs, except for those on the axis; the figure need not be symmetric
///   fewest   options.looseness searches for the fewest vertices, in up to ten times the time
///   cost     some 50 ms for a drawing of a thousand segments; up to 70 bytes for each of at most 2^24 nodes
///            of a lattice, whose spacing is at most 1/256 of the figure's longer side, and margin / 3
///   errors   figure_empty; figure_not_finite, by segment; figure_has_no_size; margin_not_positive;
///            margin_too_small; too_few_cage_vertices; mirror_not_supported; index_out_of_range, by area;
///            cancelled; out_of_memory; cage_not_found, with the clearance of the last cage tried
///
/// Equal input gives equal cages. Moving the figure, or scaling it by a power of two, moves and scales the
/// cage, as far as coordinates are not rounded.
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

/// Encloses a range of DrawnSegment without painted areas.
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
