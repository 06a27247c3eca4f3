/* The C interface of cageform (C99), for engines and other languages.
 *
 * To compile the implementation, define CAGEFORM_C_IMPLEMENTATION in one file of a C++20 program before it
 * includes this header. With CAGEFORM_C_RUNTIME_ONLY, only the functions of every frame (the first half of
 * this header) are compiled, without dependencies, exceptions and RTTI. Alternatively, link the library of
 * the CMake target cageform::compiled.
 *
 * Functions that can fail return a status: 0, or a code below; cageform_status_text() gives its message.
 * Arguments are validated: null pointers, short memory, numbers that are not finite and objects of another
 * kind give a status and leave outputs unchanged. Figures, coordinates, bindings, samples and bytes may be
 * read by several threads at once; any other object may be used by one thread at a time.
 *
 * Structs that begin with `size` may grow in later versions: set `size` to sizeof(the struct). Set all other
 * bytes to zero to select the defaults. cageform_abi_version() changes with any other change of the ABI. */
#ifndef CAGEFORM_C_H
#define CAGEFORM_C_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32) && defined(CAGEFORM_C_SHARED) && defined(CAGEFORM_C_IMPLEMENTATION)
#define CAGEFORM_API __declspec(dllexport)
#elif defined(_WIN32) && defined(CAGEFORM_C_SHARED)
#define CAGEFORM_API __declspec(dllimport)
#elif defined(__GNUC__)
#define CAGEFORM_API __attribute__((visibility("default")))
#else
#define CAGEFORM_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define CAGEFORM_C_ABI 1
#define CAGEFORM_NONE SIZE_MAX /* no index */

/* ---- Status -------------------------------------------------------------------------------------------- */

typedef int32_t cageform_status;
/* Codes never change. X(code, NAME, name) defines CAGEFORM_NAME = code. The codes of the C++ library: */
#define CAGEFORM_STATUSES(X)                                                                                 \
    X(0, OK, ok)                                                                                             \
    X(1, CANCELLED, cancelled)                                                                               \
    X(2, OUT_OF_MEMORY, out_of_memory)                                                                       \
    X(3, INDEX_OUT_OF_RANGE, index_out_of_range)                                                             \
    X(100, TOO_FEW_VERTICES, too_few_vertices)                                                               \
    X(101, LOOPS_DO_NOT_MATCH, loops_do_not_match)                                                           \
    X(102, VERTEX_NOT_FINITE, vertex_not_finite)                                                             \
    X(103, DUPLICATE_VERTICES, duplicate_vertices)                                                           \
    X(104, CAGE_SELF_CROSSING, cage_self_crossing)                                                           \
    X(105, CAGE_HAS_NO_AREA, cage_has_no_area)                                                               \
    X(106, CAGE_HAS_NO_VOLUME, cage_has_no_volume)                                                           \
    X(107, FACE_WITHOUT_VERTEX, face_without_vertex)                                                         \
    X(108, FACE_WITHOUT_AREA, face_without_area)                                                             \
    X(109, FACE_NOT_PLANAR, face_not_planar)                                                                 \
    X(110, FACE_CROSSES_ITSELF, face_crosses_itself)                                                         \
    X(111, FACE_FAN_FOLDS, face_fan_folds)                                                                   \
    X(112, DIVISIONS_NOT_SUPPORTED, divisions_not_supported)                                                 \
    X(113, CAGE_NOT_CLOSED, cage_not_closed)                                                                 \
    X(114, CAGE_NOT_MANIFOLD, cage_not_manifold)                                                             \
    X(115, CAGE_FACES_CROSS, cage_faces_cross)                                                               \
    X(116, CAGE_FACES_FLIPPED, cage_faces_flipped)                                                           \
    X(117, RADIUS_NOT_POSITIVE, radius_not_positive)                                                         \
    X(118, INTERIOR_CELL_OUTSIDE, interior_cell_outside)                                                     \
    X(119, INTERIOR_CELLS_TOUCH, interior_cells_touch)                                                       \
    X(120, SITES_IN_A_PLANE, sites_in_a_plane)                                                               \
    X(200, FIGURE_EMPTY, figure_empty)                                                                       \
    X(201, FIGURE_NOT_FINITE, figure_not_finite)                                                             \
    X(202, FIGURE_HAS_NO_SIZE, figure_has_no_size)                                                           \
    X(203, MARGIN_NOT_POSITIVE, margin_not_positive)                                                         \
    X(204, MARGIN_TOO_SMALL, margin_too_small)                                                               \
    X(205, TOO_FEW_CAGE_VERTICES, too_few_cage_vertices)                                                     \
    X(206, MIRROR_NOT_SUPPORTED, mirror_not_supported)                                                       \
    X(207, CAGE_NOT_FOUND, cage_not_found)                                                                   \
    X(300, INTERIOR_CELLS_NOT_SUPPORTED, interior_cells_not_supported)                                       \
    X(301, CAGE_NOT_CONVEX, cage_not_convex)                                                                 \
    X(302, COORDINATES_EMPTY, coordinates_empty)                                                             \
    X(303, NOT_A_SIMPLEX, not_a_simplex)                                                                     \
    X(304, DEGENERATE_SIMPLEX, degenerate_simplex)                                                           \
    X(305, LATTICE_DEGREE_NOT_SUPPORTED, lattice_degree_not_supported)                                       \
    X(306, LATTICE_KNOTS_NOT_SUPPORTED, lattice_knots_not_supported)                                         \
    X(307, FRAME_FLAT, frame_flat)                                                                           \
    X(308, FALLOFF_NEGATIVE, falloff_negative)                                                               \
    X(309, LOOP_NOT_CLOSED, loop_not_closed)                                                                 \
    X(310, CURVE_DEGREE_NOT_SUPPORTED, curve_degree_not_supported)                                           \
    X(311, DISK_TOO_SMALL, disk_too_small)                                                                   \
    X(312, SIBSON_DEGREE_NOT_SUPPORTED, sibson_degree_not_supported)                                         \
    X(313, GRADIENTS_NOT_SUPPORTED, gradients_not_supported)                                                 \
    X(314, SOLVER_NOT_SUPPORTED, solver_not_supported)                                                       \
    X(315, FALLOFF_NOT_SUPPORTED, falloff_not_supported)                                                     \
    X(316, POINT_NOT_SURROUNDED, point_not_surrounded)                                                       \
    X(400, RESOLUTION_NOT_SUPPORTED, resolution_not_supported)                                               \
    X(401, ACCURACY_NOT_SUPPORTED, accuracy_not_supported)                                                   \
    X(402, TOLERANCE_NOT_POSITIVE, tolerance_not_positive)                                                   \
    X(403, GRID_TOO_COARSE, grid_too_coarse)                                                                 \
    X(404, RIM_NOT_GIVEN, rim_not_given)                                                                     \
    X(405, CELLS_UNREACHED, cells_unreached)                                                                 \
    X(406, VALUE_NOT_FINITE, value_not_finite)                                                               \
    X(407, NOT_CONVERGED, not_converged)                                                                     \
    X(408, LOCALITY_NOT_SUPPORTED, locality_not_supported)                                                   \
    X(500, INTERVAL_EMPTY, interval_empty)                                                                   \
    X(501, TIME_NOT_MONOTONE, time_not_monotone)                                                             \
    X(502, DEGREE_NOT_SUPPORTED, degree_not_supported)                                                       \
    X(503, NORM_NOT_SUPPORTED, norm_not_supported)                                                           \
    X(504, WEIGHTS_NOT_POSITIVE, weights_not_positive)                                                       \
    X(505, KEYS_MISSING, keys_missing)                                                                       \
    X(506, KEYS_NOT_ASCENDING, keys_not_ascending)                                                           \
    X(507, KNOTS_NOT_ASCENDING, knots_not_ascending)                                                         \
    X(508, SLOPE_UNBOUNDED, slope_unbounded)                                                                 \
    X(509, TOO_MANY_CONDITIONS, too_many_conditions)                                                         \
    X(510, TOO_MANY_TRIALS, too_many_trials)                                                                 \
    X(511, TOLERANCE_NOT_MET, tolerance_not_met)                                                             \
    X(512, INPUT_MALFORMED, input_malformed)                                                                 \
    X(513, HANDLE_NOT_ALLOWED, handle_not_allowed)                                                           \
    X(600, TOO_MANY_HANDLES, too_many_handles)                                                               \
    X(601, HANDLES_NOT_POINTS, handles_not_points)                                                           \
    X(602, BONE_AXES_DEPENDENT, bone_axes_dependent)                                                         \
    X(603, BONE_WEIGHTS_DO_NOT_MATCH, bone_weights_do_not_match)                                             \
    X(604, TOO_FEW_WEIGHTS, too_few_weights)                                                                 \
    X(605, TOO_FEW_INFLUENCES, too_few_influences)                                                           \
    X(606, ORDER_NOT_A_PERMUTATION, order_not_a_permutation)                                                 \
    X(607, FORMAT_TOO_COARSE, format_too_coarse)                                                             \
    X(608, WEIGHT_NOT_FINITE, weight_not_finite)                                                             \
    X(609, BINDING_NOT_DENSE, binding_not_dense)                                                             \
    X(610, BINDING_EMPTY, binding_empty)                                                                     \
    X(611, TARGETS_DO_NOT_MATCH, targets_do_not_match)                                                       \
    X(612, FIT_NOT_DETERMINED, fit_not_determined)                                                           \
    X(613, VECTORS_DO_NOT_MATCH, vectors_do_not_match)                                                       \
    X(614, LABELS_DO_NOT_MATCH, labels_do_not_match)                                                         \
    X(615, DUPLICATE_TAG, duplicate_tag)                                                                     \
    X(616, DUPLICATE_NAME, duplicate_name)                                                                   \
    X(617, TOO_MANY_PARTS, too_many_parts)                                                                   \
    X(700, NOT_A_BLOB, not_a_blob)                                                                           \
    X(701, NOT_A_FIGURE, not_a_figure)                                                                       \
    X(702, NOT_A_CLIP, not_a_clip)                                                                           \
    X(703, BLOB_VERSION_DIFFERS, blob_version_differs)                                                       \
    X(704, BLOB_KIND_DIFFERS, blob_kind_differs)                                                             \
    X(705, BLOB_TRUNCATED, blob_truncated)                                                                   \
    X(706, BLOB_MALFORMED, blob_malformed)                                                                   \
    X(707, BLOB_CORRUPT, blob_corrupt)                                                                       \
    X(708, BLOB_OF_ANOTHER_CAGE, blob_of_another_cage)                                                       \
    X(709, BLOB_OF_ANOTHER_FIGURE, blob_of_another_figure)                                                   \
    X(710, NOT_POSE_SAMPLES, not_pose_samples)                                                               \
    X(711, NOT_A_SOLUTION, not_a_solution)                                                                   \
    X(712, BLOB_OF_ANOTHER_GRID, blob_of_another_grid)                                                       \
    X(800, VECTORS_MISSING, vectors_missing)                                                                 \
    X(801, BINDINGS_DIFFER, bindings_differ)                                                                 \
    X(802, POSE_SIZE_DIFFERS, pose_size_differs)                                                             \
    X(803, POSE_NOT_FINITE, pose_not_finite)                                                                 \
    X(804, OUTPUT_TOO_SMALL, output_too_small)                                                               \
    X(805, TOO_FEW_GRADIENTS, too_few_gradients)                                                             \
    X(806, MASK_TOO_SMALL, mask_too_small)                                                                   \
    X(807, WEIGHTS_DO_NOT_MATCH, weights_do_not_match)                                                       \
    X(808, WEIGHTS_TOO_FAR_APART, weights_too_far_apart)                                                     \
    X(809, BINDING_WEIGHTS_NEGATIVE, binding_weights_negative)                                               \
    X(810, HANDLES_NOT_FACES, handles_not_faces)                                                             \
    X(811, THRESHOLD_NOT_SUPPORTED, threshold_not_supported)                                                 \
    X(812, HANDLES_NOT_BONES, handles_not_bones)                                                             \
    X(900, SAMPLES_MISSING, samples_missing)                                                                 \
    X(901, PINS_DO_NOT_MATCH, pins_do_not_match)                                                             \
    X(902, PIN_WITHOUT_WEIGHTS, pin_without_weights)                                                         \
    X(903, POSE_NOT_DETERMINED, pose_not_determined)                                                         \
    X(950, MOTION_EMPTY, motion_empty)                                                                       \
    X(951, FRAMES_DO_NOT_MATCH, frames_do_not_match)                                                         \
    X(952, FRAME_NOT_FINITE, frame_not_finite)                                                               \
    X(953, BONES_NOT_SUPPORTED, bones_not_supported)                                                         \
    X(954, INFLUENCES_NOT_SUPPORTED, influences_not_supported)                                               \
    X(970, FIT_NOT_REACHED, fit_not_reached)
/* The codes of this interface: */
#define CAGEFORM_C_STATUSES(X)                                                                               \
    X(1000, ARGUMENT_NULL, argument_null, "an argument must not be null")                                    \
    X(1001, OBJECT_OF_ANOTHER_KIND, object_of_another_kind, "an object is of another kind, or freed")        \
    X(1002, SIZE_NOT_SET, size_not_set, "the size of a struct is not set")                                   \
    X(1003, POINTS_LEAVE_MEMORY, points_leave_memory, "points exceed their memory, or overlap")              \
    X(1004, POINTS_MISALIGNED, points_misaligned, "points or their stride are not aligned to their scalar")  \
    X(1005, SCALAR_DIFFERS, scalar_differs, "float is given where double is needed, or double for float")    \
    X(1006, DIMENSION_DIFFERS, dimension_differs, "points are of another dimension")                         \
    X(1007, CHOICE_UNKNOWN, choice_unknown, "an enumerator does not exist")                                  \
    X(1008, COUNTS_DO_NOT_MATCH, counts_do_not_match,                                                        \
      "the sum of the counts differs from the number of elements")                                           \
    X(1009, INDEX_OUT_OF_BOUNDS, index_out_of_bounds, "an index is not below the number of elements")        \
    X(1010, MEMORY_TOO_SMALL, memory_too_small, "the given memory is too small or not aligned")              \
    X(1011, CAGE_KIND_NOT_SUPPORTED, cage_kind_not_supported,                                                \
      "these coordinates do not support this kind of cage")                                                  \
    X(1012, FAILED, failed, "the standard library failed")

enum {
#define CAGEFORM_STATUS_CODE(code, NAME, name) CAGEFORM_##NAME = (code),
#define CAGEFORM_C_STATUS_CODE(code, NAME, name, text) CAGEFORM_##NAME = (code),
    CAGEFORM_STATUSES(CAGEFORM_STATUS_CODE) CAGEFORM_C_STATUSES(CAGEFORM_C_STATUS_CODE)
#undef CAGEFORM_STATUS_CODE
#undef CAGEFORM_C_STATUS_CODE
        CAGEFORM_STATUS_END
};

/* Return CAGEFORM_C_ABI and the version ("0.2.0") of the linked library. */
CAGEFORM_API uint32_t cageform_abi_version(void);
CAGEFORM_API const char* cageform_version(void);
/* Return a message without a full stop, and the name of a code in lower case; never null. */
CAGEFORM_API const char* cageform_status_text(cageform_status status);
CAGEFORM_API const char* cageform_status_name(cageform_status status);

/* ---- Points in the caller's memory --------------------------------------------------------------------- */

enum { CAGEFORM_FLOAT = 0, CAGEFORM_DOUBLE = 1 }; /* scalars */

/* `count` points or vectors of `dimension` numbers (2 or 3; 4 for tangents), each number aligned. */
typedef struct cageform_points {
    const void* data;
    size_t count;
    size_t stride; /* bytes from one point to the next; 0: contiguous */
    size_t bytes;  /* size of the memory at `data`; accesses stay within it */
    uint32_t scalar;
    uint32_t dimension;
} cageform_points;

/* As cageform_points, but writable. */
typedef struct cageform_output {
    void* data;
    size_t count;
    size_t stride;
    size_t bytes;
    uint32_t scalar;
    uint32_t dimension;
} cageform_output;

/* ---- Threads, progress, cancellation ------------------------------------------------------------------- */

typedef void (*cageform_range_body)(void* argument, size_t begin, size_t end);

typedef struct cageform_running {
    size_t size;
    void* context; /* passed to the functions below */
    /* Calls body(argument, begin, end) for ranges that together cover [0, count) once, on any threads;
     * `grain` is the smallest range worth a task. Null: `threads` applies. */
    void (*parallel_for)(void* context, size_t count, size_t grain, cageform_range_body body, void* argument);
    /* Receives the completed fraction, 0 to 1, on the calling thread; returns 0 to cancel. Functions of every
     * frame do not call it. */
    int (*progress)(void* context, double done);
    uint32_t threads; /* without parallel_for: threads started per loop; 0: only the calling thread */
} cageform_running;

/* ---- Objects ------------------------------------------------------------------------------------------- */

typedef struct cageform_figure cageform_figure;           /* bound points, normals, tangents */
typedef struct cageform_player cageform_player;           /* plays a clip */
typedef struct cageform_bytes cageform_bytes;             /* a file's contents, aligned to 64 bytes */
typedef struct cageform_coordinates cageform_coordinates; /* of a cage */
typedef struct cageform_binding cageform_binding;         /* all weights of a figure */
typedef struct cageform_made_cage cageform_made_cage;     /* result of cageform_make_cage */
typedef struct cageform_skeleton cageform_skeleton;       /* result of cageform_fit_skeleton */
typedef struct cageform_wrap cageform_wrap;               /* result of cageform_fit_wrap */
typedef struct cageform_samples cageform_samples;         /* samples of a cage's interior, for pins */
typedef struct cageform_pins cageform_pins;               /* poses a cage by pins */

/* Frees an object of any kind; null is allowed. Before an object, free all objects that refer to it. */
CAGEFORM_API cageform_status cageform_free(void* object);

/* ---- Reports ------------------------------------------------------------------------------------------- */

enum {
    CAGEFORM_NO_ELEMENT = 0,
    CAGEFORM_VERTEX = 1,
    CAGEFORM_EDGE = 2,
    CAGEFORM_FACE = 3,
    CAGEFORM_LOOP = 4
};

/* An error or a warning about a cage. */
typedef struct cageform_fault {
    cageform_status status; /* 0: a warning */
    uint32_t a_is, b_is;    /* kinds of the elements a and b: CAGEFORM_VERTEX, … */
    uint32_t reserved;
    size_t a, b;      /* indices; the index of an edge is that of its first vertex */
    const char* text; /* static */
} cageform_fault;

/* The result of a call. Fields that do not apply are 0, indices CAGEFORM_NONE. */
typedef struct cageform_report {
    size_t size;
    cageform_status status;
    uint32_t faults, warnings; /* number of errors and of warnings of the cage; cageform_check lists them */
    uint32_t reserved;
    size_t culprit;       /* index of the element with the error: a point, handle, pin, face, clip, … */
    cageform_fault fault; /* the first error of the cage, or the first warning */
    double seconds;       /* wall-clock time */
    char message[256];    /* the status and the culprit as text; empty without an error */

    /* cageform_bind: numbers of points; cageform_binding_list returns their indices */
    size_t points, on_boundary, outside, faded, not_finite, unreached, not_restored;
    double partition_error;    /* max |sum of weights - 1| */
    double reproduction_error; /* max distance of a point from the weighted sum of handles, in cage units */
    double least_weight;
    double amplification; /* max sum of |weights| of a point */

    /* harmonic coordinates */
    size_t unknowns, memory;    /* unknowns of one function; memory in bytes */
    double grid_error;          /* estimated maximum error of a weight */
    double sufficient_accuracy; /* after CAGEFORM_OUT_OF_MEMORY: an accuracy that fits; 0: unknown */

    /* cageform_pack */
    size_t bytes, dense_bytes;
    double distance, mean_distance; /* maximum and mean change of a point by packing */

    /* cageform_make_cage; lengths in figure units; volumes are areas in 2D */
    size_t vertices, components, tunnels; /* components of the figure grown by the margin; genus in 3D */
    double margin, clearance;       /* requested margin; exact minimum distance between cage and figure */
    double volume, tightest_volume; /* of the cage; of the figure grown by the margin, gaps closed */
    double least_angle;             /* smallest angle between adjacent edges, in degrees */

    /* cageform_pose_samples */
    size_t samples, rotations;

    /* cageform_pins_solve; lengths in the units of the cage */
    double miss; /* largest distance of a pin from its target; `culprit` is that pin */
    double step; /* largest distance that a handle moved */
    double rigid_energy;
    double least_stretch, largest_stretch; /* singular values of the mean deformations of the clusters */
    size_t iterations, folded;             /* folded: number of inverted clusters */
    int settled;                           /* 1: `step` is at most 3e-5 of the cage's size */

    /* cageform_compile_clip */
    double curve_error; /* maximum distance of a coordinate from the curve through its keys */

    /* cageform_fit_skeleton; distances are relative to the figure's diagonal at rest. `culprit` is the vertex
     * with the largest distance, or the invalid vertex. `frame` is its frame; CAGEFORM_NONE: at rest */
    size_t bones, frame;
    size_t beyond; /* number of vertices over options.max_distance */
    double rms, max_distance;
    double turn; /* rotation error of the faces: 99th percentile, in degrees */
    double mean_influences;

    /* cageform_fit_wrap; distances are relative to `height`. `miss` is the largest distance of a landmark from
     * its place, and `culprit` is that landmark, or the invalid element. `folded` and the stretches are those
     * of the map at the source's vertices, the followers and the samples */
    double height; /* of the target, along the longest axis of the source */
    double start;  /* mean distance from the aligned source to the target */
    /* From the vertices of the wrapped source to the target, and from those of the target to the wrapped
     * source: mean, 95th percentile, maximum. */
    double to_target_mean, to_target_upper, to_target_largest;
    double to_source_mean, to_source_upper, to_source_largest;
    double unmatched_source, unmatched_target; /* share of the vertices without a match */
    double noise;         /* standard deviation of the target's vertices; below 1e-3: 0 */
    size_t skipped_faces; /* faces of the target without area */
    size_t left_out;      /* spans of the first lattice with more than options.handles; 0: none */
    size_t far_followers; /* followers too far from the source to be checked */
    uint32_t ended;       /* CAGEFORM_ENDED_STAGES, … */
    uint32_t of_target;   /* 1: `culprit` is of the target */
} cageform_report;

/* ==== Every frame ======================================================================================= */

typedef struct cageform_open_options {
    size_t size;
    uint64_t cage_hash, figure_hash; /* expected hashes; 0: any */
    int skip_checksum;               /* 1: does not verify the checksum; reads only tables and clips */
    void* memory;                    /* for the object, cageform_figure_bytes() long; null: allocates */
    size_t memory_bytes;
} cageform_open_options;

typedef struct cageform_figure_info {
    size_t size;
    size_t points, handles;
    size_t vertices; /* number of point handles; clips and the input of cageform_pose_handles have so many */
    size_t clips, levels;
    uint32_t scalar, dimension;
    int has_normals, has_tangents, has_labels;
    double origin[3]; /* origin of the coordinates of points, handles and clips: add it to clones */
} cageform_figure_info;

/* Returns the bytes that options.memory needs for a figure object. */
CAGEFORM_API size_t cageform_figure_bytes(void);
/* Opens a packed figure or binding in place. `data` must be aligned to 64 bytes and must not change while the
 * figure is in use. `options` and `culprit` may be null. After an error `culprit` is the tag of the invalid
 * part, four letters, the first one in the lowest byte; 0 for the whole file. */
CAGEFORM_API cageform_status cageform_open(const void* data, size_t bytes,
                                           const cageform_open_options* options, cageform_figure** figure,
                                           size_t* culprit);
/* Opens a level of less detail, for the same poses; level 0 is the figure itself. */
CAGEFORM_API cageform_status cageform_open_level(const cageform_figure* figure, size_t level,
                                                 const cageform_open_options* options,
                                                 cageform_figure** opened);
CAGEFORM_API cageform_status cageform_figure_describe(const cageform_figure* figure,
                                                      cageform_figure_info* info);
/* Writes the handles at rest, the initial pose: info.handles points. */
CAGEFORM_API cageform_status cageform_figure_rest(const cageform_figure* figure, cageform_output handles);
/* Return a handle's label (not zero-terminated), and the first handle with a given label; CAGEFORM_NONE if no
 * handle has it. */
CAGEFORM_API cageform_status cageform_figure_label(const cageform_figure* figure, size_t handle,
                                                   const char** text, size_t* length);
CAGEFORM_API cageform_status cageform_figure_find_handle(const cageform_figure* figure, const char* text,
                                                         size_t length, size_t* handle);

/* Deforms a figure by a pose of its handles. Pose and outputs have the figure's scalar.
 *
 *   pose      info.handles points
 *   points    out, info.points
 *   normals, tangents  out, or null; tangents only in 3D, of 3 or 4 numbers, the fourth is the handedness
 *   running   only parallel_for and threads are used; or null. The result does not depend on it
 *   cost      as clone/clone.hpp; no allocation. The pose at rest gives the bound points bit for bit */
CAGEFORM_API cageform_status cageform_clone(const cageform_figure* figure, cageform_points pose,
                                            cageform_output points, const cageform_output* normals,
                                            const cageform_output* tangents, const cageform_running* running);
/* Computes the gradients of a function with respect to the handles (out, info.handles) from its gradients
 * with respect to the cloned points (info.points). */
CAGEFORM_API cageform_status cageform_clone_transposed(const cageform_figure* figure,
                                                       cageform_points gradients, cageform_output handles,
                                                       const cageform_running* running);
/* Computes a pose of all handles (out, info.handles) from a pose of the vertices (info.vertices). Needed if
 * some handles are vectors (Green). */
CAGEFORM_API cageform_status cageform_pose_handles(const cageform_figure* figure, cageform_points vertices,
                                                   cageform_output handles);

typedef struct cageform_clip_info {
    size_t size;
    size_t vertices;
    double begin, end; /* times, in the units of the keys */
    uint32_t scalar, dimension;
    const char* name; /* not zero-terminated; null for a clip without a figure */
    size_t name_length;
} cageform_clip_info;

typedef struct cageform_play_options {
    size_t size;
    int skip_checksum; /* for cageform_play_bytes */
    void* memory;      /* memory for the player, see cageform_player_bytes; null: allocates */
    size_t memory_bytes;
} cageform_play_options;

/* Finds the first clip of a figure with a given name; CAGEFORM_NONE if no clip has it. */
CAGEFORM_API cageform_status cageform_figure_find_clip(const cageform_figure* figure, const char* name,
                                                       size_t length, size_t* clip);
/* Create a player of a clip of a figure, or of a packed clip; the figure or the bytes must outlive it.
 * Create one player per playing instance. `options` may be null. */
CAGEFORM_API cageform_status cageform_play(const cageform_figure* figure, size_t clip,
                                           const cageform_play_options* options, cageform_player** player);
CAGEFORM_API cageform_status cageform_play_bytes(const void* data, size_t bytes,
                                                 const cageform_play_options* options,
                                                 cageform_player** player);
/* Returns the size of a player of a figure's clip in bytes. */
CAGEFORM_API cageform_status cageform_player_bytes(const cageform_figure* figure, size_t clip, size_t* bytes);
CAGEFORM_API cageform_status cageform_player_describe(const cageform_player* player,
                                                      cageform_clip_info* info);
/* Writes the cage's vertices at a time: info.vertices points of info.scalar. No allocation. */
CAGEFORM_API cageform_status cageform_player_sample(cageform_player* player, double time,
                                                    cageform_output pose);

/* ---- Pins ---------------------------------------------------------------------------------------------- */

typedef struct cageform_samples_info {
    size_t size;
    size_t handles;
    uint32_t scalar, dimension; /* of poses and targets */
} cageform_samples_info;
CAGEFORM_API cageform_status cageform_samples_describe(const cageform_samples* samples,
                                                       cageform_samples_info* info);
/* Opens packed samples and copies them; `data` must be aligned to 64 bytes. */
CAGEFORM_API cageform_status cageform_samples_open(const void* data, size_t bytes, int skip_checksum,
                                                   cageform_samples** samples);

typedef struct cageform_pins_options {
    size_t size;
    double pin_weight; /* stiffness of a pin of weight 1 relative to the stretch of the figure; 0: 1e4 */
    int hard;          /* 1: pins are a thousand times nearer to their targets */
    size_t iterations; /* per call of cageform_pins_solve; 0: 4 */
} cageform_pins_options;
/* Creates a solver without pins. It copies the samples; `options` may be null. */
CAGEFORM_API cageform_status cageform_pins_create(const cageform_samples* samples,
                                                  const cageform_pins_options* options, cageform_pins** pins);
/* Replaces all pins by `count` pins at points of a figure, given by index; count 0 removes all pins. Copies
 * the weights of the points. `weights` has one factor of the stiffness per pin; null: 1. `report` may be
 * null. After an error report.culprit is the invalid pin. */
CAGEFORM_API cageform_status cageform_pins_set(cageform_pins* pins, const cageform_figure* figure,
                                               const uint32_t* points, size_t count, const double* weights,
                                               cageform_report* report);
/* Replaces the set of fixed handles, which keep their positions in the pose; count 0 releases all. */
CAGEFORM_API cageform_status cageform_pins_hold(cageform_pins* pins, const uint32_t* handles, size_t count,
                                                cageform_report* report);
/* Moves the pose (in and out, all handles) towards the targets, one per pin. Call it, for instance once per
 * frame, until report.settled. The scalar is that of the coordinates. No allocation. */
CAGEFORM_API cageform_status cageform_pins_solve(cageform_pins* pins, cageform_points targets,
                                                 cageform_output pose, cageform_report* report);
#if !defined(CAGEFORM_C_RUNTIME_ONLY)
/* ==== Bind time ========================================================================================= */

/* ---- Cages --------------------------------------------------------------------------------------------- */

enum {
    CAGEFORM_POLYGON = 0, /* 2D: loops of vertices */
    CAGEFORM_MESH = 1,    /* 3D: faces, counter-clockwise seen from outside */
    CAGEFORM_CURVES = 2,  /* 2D: loops of Bezier curves of degree 1 to 3, for CAGEFORM_CURVED_GREEN */
    CAGEFORM_LATTICE = 3, /* 2D or 3D: a box of splines */
    CAGEFORM_SITES = 4    /* 2D or 3D: points without a cage */
};

/* A point inside a cage (a = b) or, in 3D, an edge; everything within the radius moves rigidly with it. */
typedef struct cageform_bone {
    uint32_t a, b; /* vertices of the cage */
    double radius;
} cageform_bone;

/* A cage in the caller's memory, of any scalar. Coordinates copy it. */
typedef struct cageform_cage {
    size_t size;
    uint32_t kind;
    uint32_t divisions;       /* MESH: divisions per side of quads, for mean value and harmonic; 0: 1 */
    cageform_points vertices; /* CURVES: the control points of all edges, including their ends */
    /* POLYGON: vertices per loop; null: one loop. MESH: corners per face; null: triangles.
     * CURVES: the degree of each edge. */
    const uint32_t* counts;
    size_t count_count;
    const uint32_t* indices; /* MESH: the vertices at the corners of all faces */
    size_t index_count;
    const uint32_t* loops; /* CURVES: edges per loop; null: one loop */
    size_t loop_count;
    /* MESH: maximum distance of a corner from its face's plane; beyond it, a face is a fan around its mean */
    double off_plane;

    /* LATTICE: these fields instead of vertices */
    uint32_t dimension;
    uint32_t points[3], degree[3]; /* control points and degree along each axis; 0: 4 points, degree 3 */
    double origin[3], axes[3][3];  /* axes[k] is the edge of the box along axis k */
    double falloff;                /* distance outside at which displacements reach 0; 0: no falloff */

    /* Cells inside a POLYGON or a MESH of triangles, for CAGEFORM_HARMONIC. The last `cell_vertices` of
     * `vertices` are not on the boundary, but are handles. */
    size_t cell_vertices;
    const cageform_bone* bones;
    size_t bone_count;
    const uint32_t* walls; /* 2D: the two ends of each edge; 3D: the corners of each triangle */
    size_t wall_index_count;

    /* LATTICE: points + degree + 1 knots along each axis, ascending from 0 to 1; null: uniform */
    const double* knots[3];
    size_t knot_counts[3];
} cageform_cage;

/* Checks a cage as coordinates do. Writes up to `room` errors and warnings; `count` is their total number. */
CAGEFORM_API cageform_status cageform_check(const cageform_cage* cage, cageform_fault* faults, size_t room,
                                            size_t* count);

typedef struct cageform_make_cage_options {
    size_t size;
    size_t vertices;  /* 0: 24 in 2D, 112 in 3D */
    double margin;    /* relative to the figure's diagonal; 0: 0.025 in 2D, 0.02 in 3D */
    uint32_t shape;   /* CAGEFORM_SHAPE_FIGURE, … */
    uint32_t mirror;  /* 0: none; 1, 2, 3: symmetric along x, y, z, about the centre of the figure */
    int many_cages;   /* one cage per part, instead of joined parts */
    int holes;        /* 2D: preserves large empty regions of areas */
    int fill_tunnels; /* 3D */
    double regular;   /* trade-off: higher values give more regular, looser cages; 0: 1 */
} cageform_make_cage_options;
enum cageform_shape { CAGEFORM_SHAPE_FIGURE = 0, CAGEFORM_SHAPE_HULL = 1, CAGEFORM_SHAPE_BOX = 2 };

/* Makes a cage around a figure.
 *
 *   points   2D: the ends of segments; 3D: vertices
 *   indices  2D: two per segment; 3D: three per triangle. Any faces, holes and crossings are valid
 *   radii    2D: half the width of each segment, or null
 *   areas    2D: the sizes, in segments, of the closed outlines of filled areas, which come first among the
 *            segments; or null. Used only with options.holes */
typedef struct cageform_drawing {
    size_t size;
    cageform_points points;
    const uint32_t* indices;
    size_t index_count;
    const double* radii;
    const uint32_t* areas;
    size_t area_count;
} cageform_drawing;
CAGEFORM_API cageform_status cageform_make_cage(const cageform_drawing* figure,
                                                const cageform_make_cage_options* options,
                                                const cageform_running* running, cageform_made_cage** made,
                                                cageform_report* report);
/* Describes the result; the arrays are valid until the object is freed. */
CAGEFORM_API cageform_status cageform_made_cage_describe(const cageform_made_cage* made, cageform_cage* cage);

/* ---- Coordinates --------------------------------------------------------------------------------------- */

enum cageform_coordinate_type {
    CAGEFORM_MEAN_VALUE = 0,
    CAGEFORM_HARMONIC = 1,
    CAGEFORM_GREEN = 2,  /* also has handles for edges or faces, see cageform_pose_handles */
    CAGEFORM_SIBSON = 3, /* for sites, or the vertices of any cage */
    CAGEFORM_BARYCENTRIC = 4,
    CAGEFORM_WACHSPRESS = 5,
    CAGEFORM_DISCRETE_HARMONIC = 6,
    CAGEFORM_SPLINES = 7,      /* for lattices */
    CAGEFORM_CURVED_GREEN = 8, /* for curves; the same as CAGEFORM_GREEN for curves */
    CAGEFORM_SIBSON_C1 = 9,    /* CAGEFORM_SIBSON of degree 3 */
    CAGEFORM_MAXIMUM_ENTROPY = 10,
    CAGEFORM_MEC_1 = 11, /* CAGEFORM_MAXIMUM_ENTROPY with a published prior, in the plane */
    CAGEFORM_MEC_2 = 12
};

typedef struct cageform_coordinates_options {
    size_t size;
    uint32_t type;          /* cageform_coordinate_type */
    uint32_t scalar;        /* of weights and poses */
    double accuracy;        /* harmonic: maximum error of a weight; 0: 1e-3 */
    size_t memory_limit;    /* harmonic, in bytes; 0: 8 GiB */
    uint32_t sibson_degree; /* 1, or 3 (C1 at the sites); 0: 1 */
    uint32_t reserved;
    double disk[3]; /* curves: centre and radius of a disk; radius 0: none */
    double locality; /* harmonic: 0, or for local harmonic coordinates up to 40; see HarmonicOptions */
} cageform_coordinates_options;

/* Makes coordinates of a cage. Without `options`: mean value in float. */
CAGEFORM_API cageform_status cageform_coordinates_create(const cageform_cage* cage,
                                                         const cageform_coordinates_options* options,
                                                         cageform_coordinates** coordinates,
                                                         cageform_report* report);
/* Makes coordinates of several cages for one figure, such as a body and a head. Where cages overlap, weights
 * are blended by depth. The handles of the first cage come first, then those of the next. Supports polygons
 * and triangle meshes with CAGEFORM_MEAN_VALUE or CAGEFORM_HARMONIC. report.culprit is the invalid cage. */
CAGEFORM_API cageform_status cageform_coordinates_blend(const cageform_cage* const* cages, size_t count,
                                                        const cageform_coordinates_options* options,
                                                        cageform_coordinates** coordinates,
                                                        cageform_report* report);
typedef struct cageform_coordinates_info {
    size_t size;
    size_t handles, vertices;
    uint32_t scalar, dimension;
    int has_weights_outside, has_gradients;
} cageform_coordinates_info;
CAGEFORM_API cageform_status cageform_coordinates_describe(const cageform_coordinates* coordinates,
                                                           cageform_coordinates_info* info);
CAGEFORM_API cageform_status cageform_coordinates_rest(const cageform_coordinates* coordinates,
                                                       cageform_output handles);
/* Computes and stores the harmonic functions, so that several binds solve only once. Other types need no
 * solve. */
CAGEFORM_API cageform_status cageform_coordinates_solve(cageform_coordinates* coordinates,
                                                        const cageform_running* running,
                                                        cageform_report* report);

/* ---- Bind and pack ------------------------------------------------------------------------------------- */

enum cageform_outside_points {
    CAGEFORM_EXTEND = 0,        /* weights of the coordinates outside; without such weights, kept in place */
    CAGEFORM_KEEP_IN_PLACE = 1, /* no pose moves them */
    CAGEFORM_NEAREST_BOUNDARY = 2 /* they follow the nearest boundary point, at the same offset */
};

typedef struct cageform_bind_options {
    size_t size;
    uint32_t outside;           /* treatment of points outside */
    int leave_linear_precision; /* 1: weights are not corrected to make affine poses exact */
    double falloff;             /* distance outside at which displacements reach 0; 0: no falloff */
} cageform_bind_options;

/* Binds points, and normals and tangents unless they are null (one per point; tangents of 3 or 4 numbers).
 * Points without weights are listed and do not move. */
CAGEFORM_API cageform_status cageform_bind(const cageform_coordinates* coordinates, cageform_points points,
                                           const cageform_points* normals, const cageform_points* tangents,
                                           const cageform_bind_options* options,
                                           const cageform_running* running, cageform_binding** binding,
                                           cageform_report* report);
/* Makes a figure for cageform_clone; the binding must outlive it. */
CAGEFORM_API cageform_status cageform_binding_figure(const cageform_binding* binding,
                                                     cageform_figure** figure);
/* Writes the weights of points: a row of info.handles numbers per point, in the binding's scalar. */
CAGEFORM_API cageform_status cageform_binding_weights(const cageform_binding* binding, size_t first,
                                                      size_t count, void* weights, size_t bytes);
/* Sets one label per handle: zero-terminated, or null for none. Existing figures keep their labels. */
CAGEFORM_API cageform_status cageform_binding_set_labels(cageform_binding* binding, const char* const* labels,
                                                         size_t count);
enum {
    CAGEFORM_LIST_ON_BOUNDARY = 0,
    CAGEFORM_LIST_OUTSIDE = 1,
    CAGEFORM_LIST_NOT_FINITE = 2,   /* no pose moves them */
    CAGEFORM_LIST_UNREACHED = 3,    /* without weights, or with overflow; kept in place */
    CAGEFORM_LIST_NOT_RESTORED = 4, /* the correction failed: affine poses are not exact */
    CAGEFORM_LIST_FADED = 5         /* outside, within the falloff */
};
/* Writes up to `room` point indices in ascending order; `count` is their total number. */
CAGEFORM_API cageform_status cageform_binding_list(const cageform_binding* binding, uint32_t list,
                                                   size_t* indices, size_t room, size_t* count);

enum cageform_weight_format {
    CAGEFORM_FORMAT_SMALLEST = 0,
    CAGEFORM_FORMAT_SCALAR = 1,
    CAGEFORM_FORMAT_HALF = 2,
    CAGEFORM_FORMAT_INT16 = 3,
    CAGEFORM_FORMAT_INT8 = 4
};

/* A clip or a level of less detail to pack with a figure. */
typedef struct cageform_part {
    const char* name; /* of a clip; zero-terminated */
    const void* data;
    size_t bytes;
} cageform_part;

typedef struct cageform_pack_options {
    size_t size;
    double tolerance; /* maximum change of a point by packing; 0: no limit */
    double threshold; /* smaller weights may be dropped; if tolerance, threshold and largest are 0, none is */
    size_t largest;   /* maximum number of weights per point; 0: all */
    double reach; /* the tolerance holds for handles up to this far from an affine pose; 0: cage size / 10 */
    cageform_points poses; /* the tolerance holds for these poses, each of all handles; no data: `reach` */
    uint32_t format;
    uint32_t reserved;
    const cageform_part* clips;
    size_t clip_count;
    const cageform_part* levels;
    size_t level_count;
    double origin[3]; /* origin of the coordinates of points, handles and clips; only stored */
} cageform_pack_options;

/* Packs a figure for cageform_open. */
CAGEFORM_API cageform_status cageform_pack(const cageform_binding* binding,
                                           const cageform_pack_options* options,
                                           const cageform_running* running, cageform_bytes** packed,
                                           cageform_report* report);
CAGEFORM_API cageform_status cageform_bytes_view(const cageform_bytes* bytes, const void** data,
                                                 size_t* size);

enum cageform_keys { CAGEFORM_SMOOTH = 0, CAGEFORM_LINEAR = 1, CAGEFORM_HOLD = 2 };
enum {
    CAGEFORM_STAY = 0,
    CAGEFORM_GO_STRAIGHT_ON = 1,
    CAGEFORM_CYCLE = 2,
    CAGEFORM_CYCLE_WITH_OFFSET = 3,
    CAGEFORM_PING_PONG = 4
};
typedef struct cageform_clip_options {
    size_t size;
    double tolerance;       /* maximum error of a coordinate; 0: at most a thousandth of the poses' size */
    double pack_tolerance;  /* maximum distance caused by 16-bit curves; 0: curves stay exact */
    uint32_t keys;          /* interpolation between poses */
    uint32_t before, after; /* extrapolation before the first time and after the last */
    uint32_t scalar;        /* of the clip */
} cageform_clip_options;
/* Compiles poses of the cage's vertices at ascending times, pose after pose, to a packed clip. */
CAGEFORM_API cageform_status cageform_compile_clip(const double* times, size_t count, cageform_points poses,
                                                   const cageform_clip_options* options,
                                                   const cageform_running* running, cageform_bytes** clip,
                                                   cageform_report* report);

/* ---- Skeletons ----------------------------------------------------------------------------------------- */

enum cageform_bone_kind {
    CAGEFORM_RIGID = 0,    /* rotation and translation: supported by every engine */
    CAGEFORM_SIMILAR = 1,  /* and uniform scale, which children inherit */
    CAGEFORM_STRETCHED = 2 /* any affine map: only for players that multiply matrices */
};

typedef struct cageform_skeleton_options {
    size_t size;
    size_t bones;      /* 0: the fewest that meet max_distance */
    size_t influences; /* weights per vertex, 1 to 8; 0: 4 */
    /* Maximum distance of a vertex in any frame, relative to the figure's diagonal at rest; 0: none. With
     * `bones` it is not a limit: the report counts the vertices over it. */
    double max_distance;
    uint32_t kind; /* CAGEFORM_RIGID, … */
    uint32_t reserved;
} cageform_skeleton_options;

/* Fits a skeleton to a sequence of meshes: rotating bones, joints, a hierarchy, and a few weights per vertex.
 *
 *   rest     the vertices at rest (3D), where all bones have the identity map
 *   frames   at least two frames of all vertices each; the rest pose need not be one of them
 *   indices  three per triangle, or null: weights are smooth along edges
 *   options  requires bones or max_distance
 *   running  threads, progress, cancellation; or null. The result does not depend on threads */
CAGEFORM_API cageform_status cageform_fit_skeleton(cageform_points rest, cageform_points frames,
                                                   const uint32_t* indices, size_t index_count,
                                                   const cageform_skeleton_options* options,
                                                   const cageform_running* running,
                                                   cageform_skeleton** skeleton, cageform_report* report);

/* A skeleton. The position in frame t of a vertex v at rest is
 *
 *     sum over k < influences of weights[k] * maps[t][vertex_bones[k]](v)
 *
 * The arrays are valid until the object is freed. */
typedef struct cageform_skeleton_info {
    size_t size;
    size_t bones, frames, vertices, influences;
    const uint32_t* parents;      /* bones: parents precede children; UINT32_MAX for the root, bone 0 */
    const double* joints;         /* bones * 3: the joint with the parent, at rest */
    const uint16_t* vertex_bones; /* vertices * influences; 0 where a weight is 0 */
    const float* weights;         /* vertices * influences: descending per vertex, with sum 1 */
    const double* maps;           /* frames * bones * 12: the images of the x, y, z axes and of the origin */
} cageform_skeleton_info;
CAGEFORM_API cageform_status cageform_skeleton_describe(const cageform_skeleton* skeleton,
                                                        cageform_skeleton_info* info);
/* Writes the local transforms of the bones' nodes: frame after frame, all bones each.
 *
 *     x -> rotation(scale * axes(x)) + translation
 *
 * maps a node's frame, whose origin is its joint, to its parent's frame; at rest, rotation is the identity.
 * The product of the transforms from the root to a node, after a shift by -joint, is the bone's map.
 *
 *   translations  out, frames * bones of 3 numbers, any scalar
 *   rotations     out, of 4 numbers: quaternions x y z w, with consistent signs between frames
 *   scales        out, of 3 numbers; may be null only for RIGID bones, whose scales are 1
 *   axes          out, quaternions; null unless bones are STRETCHED
 *   fails         CAGEFORM_VALUE_NOT_FINITE: the map of a parent is singular in some frame; use the maps */
CAGEFORM_API cageform_status cageform_skeleton_transforms(const cageform_skeleton* skeleton,
                                                          cageform_output translations,
                                                          cageform_output rotations,
                                                          const cageform_output* scales,
                                                          const cageform_output* axes);

/* ---- Wraps --------------------------------------------------------------------------------------------- */

typedef struct cageform_landmark {
    double source[3], target[3]; /* a point of the source, and its place on the target */
    double weight;               /* relative to other landmarks; 0: 1 */
} cageform_landmark;

typedef struct cageform_wrap_options {
    size_t size;
    const cageform_landmark* landmarks;
    size_t landmark_count;
    cageform_points follow; /* points that will follow, such as the vertices of clothes; no data: none */
    int keep_place;         /* 1: the source is not scaled and moved to the target first */
    int other_pose;         /* 1: source and target have different poses; needs landmarks */
    int refine_contacts;    /* 1: a finer lattice where parts touch; twice the time; without coordinates only */
    /* Spans of the finest lattice along the target's height: 6, 12, 24, … up to 96; 0: 24. With coordinates
     * lattices begin at 12, and 6 is the cage alone. */
    uint32_t finest;
    double least_stiffness; /* the search ends at this weight of the rigidity; 0: 1e-7; for noise: 1e-5 */
    double floor;           /* lower bound of the map's least singular value; 0: 0.1 */
    double residual;        /* ends the search below this report.to_target_upper; 0: never */
    size_t samples; /* about the largest number of samples of space; 0: 16000 */
    size_t handles; /* the largest number of handles; lattices with more are left out; 0: 8000 */
} cageform_wrap_options;

/* Why a search ended. */
enum cageform_wrap_end {
    CAGEFORM_ENDED_STAGES = 0,   /* all stages are done */
    CAGEFORM_ENDED_RESIDUAL = 1, /* options.residual is reached */
    CAGEFORM_ENDED_NOISE = 2,    /* the median residual is at the noise of the target */
    CAGEFORM_ENDED_FOLD = 3      /* a finer fit would fold space */
};

/* Wraps a source onto a target: finds a map of space that lays one figure on another. Clothes, hair and joints
 * of the source follow by cageform_wrap_move.
 *
 *   coordinates     null: the map is a lattice. Else a pose of their cage, then a lattice behind it. They must
 *                   have gradients; the map refers to them, also after they are freed
 *   source, target  triangles in 3D of any topology; open, noisy or in parts. Both have the same up and front,
 *                   unless three or more landmarks align them; radii and areas are ignored
 *   options         or null
 *   running         threads, progress, cancellation; or null. The result does not depend on threads
 *   fails           CAGEFORM_FIT_NOT_REACHED: less than half of a figure has a match; `wrap` is set all the same */
CAGEFORM_API cageform_status cageform_fit_wrap(const cageform_coordinates* coordinates,
                                               const cageform_drawing* source, const cageform_drawing* target,
                                               const cageform_wrap_options* options,
                                               const cageform_running* running, cageform_wrap** wrap,
                                               cageform_report* report);
/* Moves points by the map.
 *
 *   points     in the space of the source; any scalar
 *   moved      out, as many points; may be the same memory
 *   jacobians  out, or null: 9 numbers a point, the images of the axes x, y, z by the map's derivative
 *   running    or null */
CAGEFORM_API cageform_status cageform_wrap_move(const cageform_wrap* wrap, cageform_points points,
                                                cageform_output moved, const cageform_output* jacobians,
                                                const cageform_running* running);

/* A map of space: `first`, then the pose of the cage, then the pose of the lattice. The poses are for
 * cageform_clone. The memory is valid until the object is freed. */
typedef struct cageform_wrap_info {
    size_t size;
    double first[12];             /* the images of the axes x, y, z and of the origin; identity with a cage */
    cageform_points pose;         /* of the coordinates' handles; count 0 without coordinates */
    const cageform_cage* lattice; /* in the space of the target; null: none */
    cageform_points lattice_pose; /* of its control points */
} cageform_wrap_info;
CAGEFORM_API cageform_status cageform_wrap_describe(const cageform_wrap* wrap, cageform_wrap_info* info);

/* ---- Samples for pins ---------------------------------------------------------------------------------- */

typedef struct cageform_samples_options {
    size_t size;
    size_t samples, rotations; /* 0: chosen from the number of handles */
    double smoothing;          /* distance over which bends are spread, relative to the cage's size */
} cageform_samples_options;
/* Samples the interior of a cage; the coordinates must have gradients. */
CAGEFORM_API cageform_status cageform_pose_samples(const cageform_coordinates* coordinates,
                                                   const cageform_samples_options* options,
                                                   const cageform_running* running,
                                                   cageform_samples** samples, cageform_report* report);
/* Packs samples for cageform_samples_open. */
CAGEFORM_API cageform_status cageform_samples_pack(const cageform_samples* samples, cageform_bytes** packed,
                                                   cageform_report* report);

#endif

#ifdef __cplusplus
}
#endif

#endif

#if defined(CAGEFORM_C_IMPLEMENTATION) && !defined(CAGEFORM_C_IMPLEMENTED)
#define CAGEFORM_C_IMPLEMENTED
#include <cageform/c/detail/every_frame.impl.hpp>
#include <cageform/c/detail/pins.impl.hpp>
#if !defined(CAGEFORM_C_RUNTIME_ONLY)
#include <cageform/c/detail/pack.impl.hpp>
#include <cageform/c/detail/skeleton.impl.hpp>
#include <cageform/c/detail/wrap.impl.hpp>
#endif
#endif
