// What went wrong, as values: nothing in the library throws or prints.
#pragma once

#include <cageform/config.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// Outcome of a call. A bad *input* is a Status; a broken *promise* of the caller is CAGEFORM_ASSERT.
enum class [[nodiscard]] Status : std::uint8_t{
    ok,
    cancelled,           ///< the progress callback asked to stop
    too_few_vertices,    ///< a cage loop of fewer than three vertices
    loops_do_not_match,  ///< the loop sizes do not add up to the number of vertices
    vertex_not_finite,   ///< a cage vertex is NaN or infinite
    duplicate_vertices,  ///< two cage vertices coincide
    cage_self_crossing,  ///< two edges of the cage cross or touch
    cage_has_no_area,    ///< all vertices of a loop lie on one line
    cage_has_no_volume,  ///< a box has no extent along some axis, a mesh no faces
    face_without_vertex, ///< a face of a mesh names a vertex that there is not
    face_without_area,   ///< the corners of a face lie on one line
    cage_not_closed,     ///< an edge of a mesh belongs to one face only
    cage_not_manifold,  ///< an edge belongs to more than two faces, or a vertex to more than one fan of faces
    cage_faces_cross,   ///< two faces of a mesh pass through each other
    cage_faces_flipped, ///< neighbouring faces of a mesh turn different ways
    radius_not_positive,          ///< the radius of an interior cell is zero, negative, NaN or infinite
    interior_cell_outside,        ///< an interior cell lies outside the cage
    interior_cells_touch,         ///< an interior cell comes too near to another or to the boundary
    interior_cells_not_supported, ///< the coordinate type knows no interior cells
    not_a_simplex,                ///< barycentric coordinates need exactly dimension + 1 vertices
    degenerate_simplex,           ///< the simplex has no volume relative to its size
    solver_not_supported,         ///< the solver asked for is not there for this cage
    resolution_not_supported,     ///< the grid is too small to hold a cage, or too large to index
    tolerance_not_positive,       ///< a solver's tolerance is zero, negative or NaN
    grid_too_coarse,      ///< no node of the grid feels some handle; SolverReport names it and a resolution
    rim_not_given,        ///< an unknown cell has no neighbour on some side (SolverReport::culprit)
    value_not_finite,     ///< a given value is NaN or infinite (SolverReport::culprit)
    interval_empty,       ///< the second key of a curve is not later than the first
    curve_turns_back,     ///< time turns back along a curve
    degree_not_supported, ///< the degree of a fit is not 3, 4 or 5
    norm_not_supported,   ///< the sup norm with conditions that tie the pieces of a fit together
    weights_not_positive, ///< the weights of a norm are not positive
    keys_missing,         ///< a track without keys
    keys_not_ascending,   ///< a key is not later than the one before
    knots_not_ascending,  ///< the knots of a fit do not ascend from key to key
    slope_unbounded,      ///< a condition asks for a slope where the curve has a vertical tangent
    too_many_conditions,  ///< the conditions of a fit leave no freedom, or repeat each other
    too_many_trials,      ///< a search among knots would take more trials than it may
    tolerance_not_met,    ///< a fit would need more pieces than it may have
    input_malformed,      ///< a text or the sizes of arrays are not as their format asks for
    handle_not_allowed,   ///< a curve's handle lies where the other program's format has none
    not_converged,        ///< a solver ran out of sweeps or cycles before its tolerance was met
    pose_size_differs,    ///< a pose has another number of points than the binding has handles
    pose_not_finite,      ///< a pose holds NaN or infinity, or lies too far off to be represented
    output_too_small,     ///< fewer places in the output than points
    mask_too_small,       ///< fewer numbers in the mask than points
    too_many_handles,     ///< more handles than a format can count
    too_few_weights,      ///< fewer weights a point than linear precision takes
    too_few_influences,   ///< a skin of no influence a point
    order_not_a_permutation, ///< an order of points leaves one out or names one twice
    weight_not_finite,       ///< a weight of a binding is NaN or infinite
    binding_empty,           ///< a binding without points, where other points are to go by it
    not_a_blob, ///< memory that does not begin as a packed binding does, or is not aligned to 64 bytes
    blob_version_differs,   ///< a packed binding of another version of the format or byte order
    blob_kind_differs,      ///< a packed binding of another scalar or dimension
    blob_truncated,         ///< less memory than the packed binding says it takes
    blob_malformed,         ///< parts of a packed binding overlap its ends, or point beyond each other
    blob_corrupt,           ///< the checksum of a packed binding differs
    blob_of_another_cage,   ///< made for a cage of another hash
    blob_of_another_figure, ///< made for a figure of another hash
    out_of_memory,
};

/// A short English sentence without a full stop, for messages. Never null.
constexpr const char* to_string(Status status) noexcept {
    switch (status) {
    case Status::ok: return "ok";
    case Status::cancelled: return "cancelled by the progress callback";
    case Status::too_few_vertices: return "a cage loop has fewer than three vertices";
    case Status::loops_do_not_match: return "the loop sizes do not add up to the number of vertices";
    case Status::vertex_not_finite: return "a cage vertex is not a finite number";
    case Status::duplicate_vertices: return "two cage vertices coincide";
    case Status::cage_self_crossing: return "two edges of the cage cross or touch";
    case Status::cage_has_no_area: return "a cage loop encloses no area";
    case Status::cage_has_no_volume: return "the cage encloses no volume";
    case Status::face_without_vertex: return "a face names a vertex that does not exist";
    case Status::face_without_area: return "a face of the cage has no area";
    case Status::cage_not_closed: return "the cage is not closed: an edge belongs to one face only";
    case Status::cage_not_manifold: return "the cage is not a manifold at an edge or a vertex";
    case Status::cage_faces_cross: return "two faces of the cage pass through each other";
    case Status::cage_faces_flipped: return "neighbouring faces of the cage turn different ways";
    case Status::radius_not_positive: return "the radius of an interior cell is not a positive number";
    case Status::interior_cell_outside: return "an interior cell lies outside the cage";
    case Status::interior_cells_touch: return "an interior cell touches another one or the boundary";
    case Status::interior_cells_not_supported: return "this coordinate type cannot honour interior cells";
    case Status::not_a_simplex: return "barycentric coordinates need a simplex: dimension + 1 vertices";
    case Status::degenerate_simplex: return "the simplex has no volume relative to its size";
    case Status::solver_not_supported: return "the solver is not there for this kind of cage";
    case Status::resolution_not_supported: return "the grid resolution is out of range";
    case Status::tolerance_not_positive: return "the solver's tolerance is not a positive number";
    case Status::grid_too_coarse: return "the grid is too coarse to see a part of the cage";
    case Status::rim_not_given: return "an unknown cell lies on the rim of the grid";
    case Status::value_not_finite: return "a given value is not a finite number";
    case Status::interval_empty: return "the second key is not later than the first";
    case Status::curve_turns_back: return "time turns back along the curve";
    case Status::degree_not_supported: return "pieces are of degree 3, 4 or 5";
    case Status::norm_not_supported: return "the sup norm is for pieces that are not tied together";
    case Status::weights_not_positive: return "the weights of the norm are not positive numbers";
    case Status::keys_missing: return "the track has no keys";
    case Status::keys_not_ascending: return "a key is not later than the one before it";
    case Status::knots_not_ascending: return "the knots do not ascend from key to key";
    case Status::slope_unbounded: return "a condition asks for a slope where the curve's is unbounded";
    case Status::too_many_conditions: return "too many conditions for the number of pieces";
    case Status::too_many_trials: return "the search for knots would take too many trials";
    case Status::tolerance_not_met: return "the tolerance cannot be met with so many pieces";
    case Status::input_malformed: return "the text or the arrays are not as their format asks for";
    case Status::handle_not_allowed: return "a handle lies where the format allows none";
    case Status::not_converged: return "the solver did not reach its tolerance";
    case Status::pose_size_differs: return "the pose has another number of points than the cage";
    case Status::pose_not_finite: return "the pose holds a number that is not finite";
    case Status::output_too_small: return "the output has fewer places than there are points";
    case Status::mask_too_small: return "the mask has fewer numbers than there are points";
    case Status::too_many_handles: return "more handles than the format can count";
    case Status::too_few_weights: return "linear precision takes more weights a point";
    case Status::too_few_influences: return "a skin needs at least one influence a point";
    case Status::order_not_a_permutation: return "the order leaves a point out or names one twice";
    case Status::weight_not_finite: return "a weight of the binding is not a finite number";
    case Status::binding_empty: return "the binding has no points to go by";
    case Status::not_a_blob: return "the memory holds no packed binding, or is not aligned to 64 bytes";
    case Status::blob_version_differs: return "the packed binding is of another version or byte order";
    case Status::blob_kind_differs: return "the packed binding is of another scalar or dimension";
    case Status::blob_truncated: return "the packed binding is cut off";
    case Status::blob_malformed: return "the packed binding contradicts itself";
    case Status::blob_corrupt: return "the checksum of the packed binding differs";
    case Status::blob_of_another_cage: return "the packed binding was made for another cage";
    case Status::blob_of_another_figure: return "the packed binding was made for another figure";
    case Status::out_of_memory: return "out of memory";
    }
    return "unknown status";
}

/// Where a point lies with respect to its cage.
enum class PointState : std::uint8_t {
    inside,
    on_boundary, ///< within rounding of a vertex, edge or face
    outside,
    not_finite, ///< NaN or infinite; never bound
    unreached,  ///< no weights can be had: a grid too coarse for the place, a distance too large to resolve
};

constexpr const char* to_string(PointState state) noexcept {
    switch (state) {
    case PointState::inside: return "inside";
    case PointState::on_boundary: return "on_boundary";
    case PointState::outside: return "outside";
    case PointState::not_finite: return "not_finite";
    case PointState::unreached: return "unreached";
    }
    return "unknown";
}

} // namespace cageform::inline CAGEFORM_ABI
