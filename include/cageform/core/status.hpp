// The status codes of all functions. The library neither throws nor prints.
#pragma once

#include <cageform/config.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// The outcome of a call. Invalid input gives a Status; a violated precondition fails CAGEFORM_ASSERT.
/// Grouped by folder, each with its text for `to_string`.
// clang-format off
#define CAGEFORM_DETAIL_STATUSES(X)                                                               \
    /* Every layer */                                                                             \
    X(ok, "ok")                                                                                   \
    X(cancelled, "cancelled by the progress callback")                                            \
    X(out_of_memory, "out of memory")                                                             \
    X(index_out_of_range, "an index names a point that does not exist")                           \
    /* cage/: check */                                                                            \
    X(too_few_vertices, "a cage loop has fewer than three vertices, or a point set too few sites")\
    X(loops_do_not_match, "the loop sizes do not add up to the number of vertices")               \
    X(vertex_not_finite, "a cage vertex is not a finite number, or too large")                    \
    X(duplicate_vertices, "two cage vertices coincide")                                           \
    X(cage_self_crossing, "two edges of the cage cross or touch")                                 \
    X(cage_has_no_area, "a cage loop encloses no area")                                           \
    X(cage_has_no_volume, "the cage encloses no volume")                                          \
    X(face_without_vertex, "a face names a vertex that does not exist")                           \
    X(face_without_area, "a face of the cage has no area")                                        \
    X(face_not_planar, "a corner of a face lies off the plane of the face")                       \
    X(face_crosses_itself, "a face of the cage crosses or touches itself")                        \
    X(face_fan_folds, "some edges of a face are not visible from its corners' mean: divide the face") \
    X(divisions_not_supported, "faces can be divided by 1 to 64, for Green coordinates by 1 only")\
    X(cage_not_closed, "the cage is not closed: an edge belongs to one face only")                \
    X(cage_not_manifold, "the cage is not a manifold at an edge or a vertex")                     \
    X(cage_faces_cross, "two faces of the cage pass through each other")                          \
    X(cage_faces_flipped, "neighbouring faces of the cage have opposite orientations")                   \
    X(radius_not_positive, "the radius of an interior cell is not a positive number")             \
    X(interior_cell_outside, "an interior cell lies outside the cage")                            \
    X(interior_cells_touch, "an interior cell touches another one or the boundary")               \
    X(sites_in_a_plane, "all sites lie in a plane (in 2D on a line)")                             \
    /* enclose/: make_cage */                                                                     \
    X(figure_empty, "the figure has no points, or no faces")                                      \
    X(figure_not_finite, "a coordinate of the figure is not a finite number, or too large")       \
    X(figure_has_no_size, "the figure has no extent, or no area")                                 \
    X(margin_not_positive, "the margin of a cage is not a positive number")                       \
    X(margin_too_small, "the margin is too small for the largest grid")                           \
    X(too_few_cage_vertices, "the vertex limit is too small for a cage")                          \
    X(mirror_not_supported, "the mirror's axis does not exist, or its position is not finite")  \
    X(cage_not_found, "no cage around the figure was found")                                      \
    /* coordinates/: requirements of a type beyond a valid cage */                                \
    X(interior_cells_not_supported, "this coordinate type does not support interior cells")          \
    X(cage_not_convex, "these coordinates need one strictly convex loop")                         \
    X(coordinates_empty, "the coordinates have no handles: they were moved from")                 \
    X(not_a_simplex, "barycentric coordinates need a simplex: dimension + 1 vertices")            \
    X(degenerate_simplex, "the simplex has no volume relative to its size")                       \
    X(lattice_degree_not_supported, "lattices have degree 1 to 3, with a single span up to 63")   \
    X(lattice_knots_not_supported, "the knots of a lattice are not clamped, or do not ascend")    \
    X(frame_flat, "the axes of a lattice's box do not span the space")                            \
    X(falloff_negative, "the falloff of a lattice is negative or not a number")                   \
    X(loop_not_closed, "a loop of curves is not closed: an edge ends where the next does not begin") \
    X(curve_degree_not_supported, "curves have degree 1 to 3 at rest, and from that to 5 in poses") \
    X(disk_too_small, "the disk does not contain the cage")                                       \
    X(sibson_degree_not_supported, "Sibson coordinates are of degree 1 or 3")                     \
    X(gradients_not_supported, "these coordinates have no gradients, which normals need")         \
    X(point_not_surrounded, "the point does not lie inside the hull of the handles")              \
    X(solver_not_supported, "this solver does not exist for these coordinates")                       \
    /* grid/: solvers; SolverReport has the culprit */                                            \
    X(resolution_not_supported, "the grid resolution is out of range")                            \
    X(accuracy_not_supported, "the requested accuracy is out of range")                           \
    X(locality_not_supported, "the locality is not a number from 0 to 40")                        \
    X(tolerance_not_positive, "the solver's tolerance is not a positive number")                  \
    X(grid_too_coarse, "the grid is too coarse for a part of the cage")                        \
    X(rim_not_given, "an unknown cell lies on the border of the grid")                            \
    X(cells_unreached, "some unknown cells have no path to a given value")                        \
    X(value_not_finite, "a given value is not a finite number, or too large")                     \
    X(not_converged, "the solver did not reach its tolerance")                                    \
    /* animate/ */                                                                                \
    X(interval_empty, "the second key is not later than the first")                               \
    X(time_not_monotone, "time decreases somewhere along the curve")                              \
    X(degree_not_supported, "pieces are of degree 3, 4 or 5")                                     \
    X(norm_not_supported, "the sup norm does not support conditions that couple pieces")          \
    X(weights_not_positive, "some weights are not positive numbers")                              \
    X(keys_missing, "the track has no keys")                                                      \
    X(keys_not_ascending, "a key is not later than the one before it")                            \
    X(knots_not_ascending, "the knots do not ascend from key to key")                             \
    X(slope_unbounded, "a condition prescribes a slope where the curve's slope is unbounded")     \
    X(too_many_conditions, "too many conditions for the number of pieces")                        \
    X(too_many_trials, "the search for knots would take too many trials")                         \
    X(tolerance_not_met, "the tolerance cannot be met with the allowed number of pieces")         \
    X(input_malformed, "the text or the arrays do not follow their format")                 \
    X(handle_not_allowed, "the format does not allow a handle at this position")                  \
    /* binding/: bind, pack, skins */                                                     \
    X(falloff_not_supported, "a falloff must be finite, and needs weights of points outside")     \
    X(too_many_handles, "more handles than can be counted or stored")                             \
    X(handles_not_points, "some handles are vectors; only points are supported")                  \
    X(bone_axes_dependent, "the axes of a bone do not span the space")                            \
    X(bone_weights_do_not_match, "there are no bones, or not one weight per bone and point")      \
    X(too_few_weights, "linear precision needs more weights per point")                           \
    X(too_few_influences, "a skin needs at least one influence per point")                        \
    X(order_not_a_permutation, "the order is not a permutation of the points")                    \
    X(format_too_coarse, "weights in this format cannot meet the tolerance")                      \
    X(weight_not_finite, "a weight of the binding is not a finite number")                        \
    X(binding_not_dense, "weights of the packed binding were dropped or rounded")                 \
    X(binding_empty, "the binding has no points")                                        \
    X(targets_do_not_match, "there is not one target or weight for every point of the lattice's figure")\
    X(fit_not_determined, "the points do not determine the pose: give more, or more smoothness")  \
    X(vectors_do_not_match, "there is not one normal or tangent for every point")                 \
    X(labels_do_not_match, "there is not one label for every handle")                             \
    X(duplicate_tag, "two parts of a figure have the same tag, or one has a tag of the library")  \
    X(duplicate_name, "two clips of a figure have the same name")                                 \
    X(too_many_parts, "a figure has more parts than its table can hold")                          \
    /* figure/types/blob.hpp */                                                                        \
    X(not_a_blob, "the memory holds no packed binding, or is not aligned to 64 bytes")            \
    X(not_a_figure, "the memory holds no packed figure, or is not aligned to 64 bytes")           \
    X(not_a_clip, "the memory holds no packed clip, or is not aligned to 64 bytes")               \
    X(not_pose_samples, "the memory holds no packed samples, or is not aligned to 64 bytes")      \
    X(not_a_solution, "the memory holds no packed functions, or is not aligned to 64 bytes")      \
    X(blob_version_differs, "the packed data is of another version or byte order")                \
    X(blob_kind_differs, "the packed data is of another scalar or dimension")                     \
    X(blob_truncated, "the packed data is cut off")                                               \
    X(blob_malformed, "the packed data contradicts itself")                                       \
    X(blob_corrupt, "the checksum of the packed data differs")                                    \
    X(blob_of_another_cage, "the packed data was made for another cage")                          \
    X(blob_of_another_figure, "the packed data was made for another figure")                      \
    X(blob_of_another_grid, "the packed functions are of another accuracy or another grid")       \
    /* clone/ */                                                                                  \
    X(vectors_missing, "the figure was bound without normals, or without tangents")               \
    X(bindings_differ, "the bindings are of different points or handles, or in different orders") \
    X(pose_size_differs, "the pose has another number of points than the cage")                   \
    X(pose_not_finite, "the pose holds a number that is not finite")                              \
    X(output_too_small, "the output has fewer elements than there are points, or handles")          \
    X(too_few_gradients, "there are fewer gradients than points")                                   \
    X(mask_too_small, "the mask has fewer numbers than there are points")                         \
    X(weights_do_not_match, "there is not one weight for every handle")                           \
    X(weights_too_far_apart, "the ratio of two handles' weights is too large")                    \
    X(binding_weights_negative, "the binding has negative weights: rational clones need non-negative ones") \
    X(handles_not_faces, "some vector handles belong to no face")                                 \
    X(threshold_not_supported, "the threshold of folds is not a finite number below 1")           \
    X(handles_not_bones, "the handles are not the origins and axes of bones")                     \
    /* pose/ */                                                                                   \
    X(samples_missing, "there are no samples of the inside of the cage")                          \
    X(pins_do_not_match, "there is not one target, weight or turn for every pin")                 \
    X(pin_without_weights, "a pin lies where the coordinates have no weights")                    \
    X(pose_not_determined, "the pins and samples do not determine a handle: add spokes")  \
    /* skeleton/ */                                                                               \
    X(motion_empty, "there are no vertices, or fewer than two frames")                            \
    X(frames_do_not_match, "a frame has another number of vertices than the rest")                \
    X(frame_not_finite, "a coordinate of a frame is not a finite number, or too large")           \
    X(bones_not_supported, "a skeleton needs a number of bones or a maximum distance")            \
    X(influences_not_supported, "a vertex of a skeleton has 1 to 8 weights")                      \
    /* fit/ */                                                                                    \
    X(fit_not_reached, "less than half of the source or of the target found a match")
// clang-format on

enum class [[nodiscard]] Status : std::uint8_t {
#define CAGEFORM_DETAIL_NAME(name, text) name,
    CAGEFORM_DETAIL_STATUSES(CAGEFORM_DETAIL_NAME)
#undef CAGEFORM_DETAIL_NAME
};

/// Returns a short message without a full stop. Never null.
constexpr const char* to_string(Status status) noexcept {
    switch (status) {
#define CAGEFORM_DETAIL_CASE(name, text)                                                                     \
    case Status::name: return text;
        CAGEFORM_DETAIL_STATUSES(CAGEFORM_DETAIL_CASE)
#undef CAGEFORM_DETAIL_CASE
    }
    return "unknown status";
}
#undef CAGEFORM_DETAIL_STATUSES

/// The position of a point relative to its cage.
enum class PointState : std::uint8_t {
    inside,
    on_boundary, ///< within rounding of a vertex, edge or face
    outside,
    not_finite, ///< NaN or infinite; never bound
    unreached,  ///< without weights: the grid is too coarse there, or the point too far away
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
