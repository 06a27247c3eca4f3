/* The C interface of cageform: everything by plain C99, for engines and other languages.
 *
 * One file of a C++20 program defines CAGEFORM_C_IMPLEMENTATION before it includes this header; it has the
 * code. With CAGEFORM_C_RUNTIME_ONLY too it has what a game runs every frame (the first half of this
 * header), without dependencies, exceptions and RTTI. Or link the library of the CMake target
 * cageform::compiled.
 *
 * Every function that can fail returns a status: 0, or a code below, of which cageform_status_text() is
 * the sentence. No argument crashes a function that is what its type says; one that is null, too short,
 * not finite, or an object of another kind is refused by a status, and outputs are then untouched. An
 * object is used by one thread at a time, but for figures, coordinates, bindings, samples and bytes, which
 * may be read by several.
 *
 * Structs that begin with `size` grow in later versions: set it to sizeof(the struct), and the rest to
 * zero, which stands for the default everywhere. cageform_abi_version() changes when anything else does. */
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
/* Codes never change. X(code, NAME, name) gives CAGEFORM_NAME = code. Those of the C++ library: */
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
    X(400, RESOLUTION_NOT_SUPPORTED, resolution_not_supported)                                               \
    X(401, ACCURACY_NOT_SUPPORTED, accuracy_not_supported)                                                   \
    X(402, TOLERANCE_NOT_POSITIVE, tolerance_not_positive)                                                   \
    X(403, GRID_TOO_COARSE, grid_too_coarse)                                                                 \
    X(404, RIM_NOT_GIVEN, rim_not_given)                                                                     \
    X(405, CELLS_UNREACHED, cells_unreached)                                                                 \
    X(406, VALUE_NOT_FINITE, value_not_finite)                                                               \
    X(407, NOT_CONVERGED, not_converged)                                                                     \
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
    X(954, INFLUENCES_NOT_SUPPORTED, influences_not_supported)
/* Those of this interface: */
#define CAGEFORM_C_STATUSES(X)                                                                               \
    X(1000, ARGUMENT_NULL, argument_null, "an argument is null that may not be")                             \
    X(1001, OBJECT_OF_ANOTHER_KIND, object_of_another_kind, "an object is of another kind, or freed")        \
    X(1002, SIZE_NOT_SET, size_not_set, "the size of a struct is not set")                                   \
    X(1003, POINTS_LEAVE_MEMORY, points_leave_memory, "points are more than their memory holds, or overlap") \
    X(1004, POINTS_MISALIGNED, points_misaligned, "points or their stride are not aligned to their numbers") \
    X(1005, SCALAR_DIFFERS, scalar_differs, "numbers are float where double is needed, or double for float") \
    X(1006, DIMENSION_DIFFERS, dimension_differs, "points are of another dimension")                         \
    X(1007, CHOICE_UNKNOWN, choice_unknown, "a choice is none of its constants")                             \
    X(1008, COUNTS_DO_NOT_MATCH, counts_do_not_match,                                                        \
      "counts do not add up to the number of what they count")                                               \
    X(1009, INDEX_OUT_OF_BOUNDS, index_out_of_bounds, "an index is not below the number of what it counts")  \
    X(1010, MEMORY_TOO_SMALL, memory_too_small, "memory that was given is too small or not aligned")         \
    X(1011, CAGE_KIND_NOT_SUPPORTED, cage_kind_not_supported,                                                \
      "these coordinates do not take this kind of cage")                                                     \
    X(1012, FAILED, failed, "the standard library failed")

enum {
#define CAGEFORM_STATUS_CODE(code, NAME, name) CAGEFORM_##NAME = (code),
#define CAGEFORM_C_STATUS_CODE(code, NAME, name, text) CAGEFORM_##NAME = (code),
    CAGEFORM_STATUSES(CAGEFORM_STATUS_CODE) CAGEFORM_C_STATUSES(CAGEFORM_C_STATUS_CODE)
#undef CAGEFORM_STATUS_CODE
#undef CAGEFORM_C_STATUS_CODE
        CAGEFORM_STATUS_END
};

/* Returns CAGEFORM_C_ABI of the library that is linked, and its version, as "0.2.0". */
CAGEFORM_API uint32_t cageform_abi_version(void);
CAGEFORM_API const char* cageform_version(void);
/* Returns an English sentence without a full stop, and the name of a code in small letters; never null. */
CAGEFORM_API const char* cageform_status_text(cageform_status status);
CAGEFORM_API const char* cageform_status_name(cageform_status status);

/* ---- Points in the caller's memory --------------------------------------------------------------------- */

enum { CAGEFORM_FLOAT = 0, CAGEFORM_DOUBLE = 1 }; /* scalars */

/* `count` points or vectors of `dimension` numbers (2 or 3; tangents may have 4). Numbers are aligned. */
typedef struct cageform_points {
    const void* data;
    size_t count;
    size_t stride; /* bytes from a point to the next; 0: they follow each other */
    size_t bytes;  /* the memory from `data` on, which no function leaves */
    uint32_t scalar;
    uint32_t dimension;
} cageform_points;

/* As cageform_points, to be written. */
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
     * `grain` is the shortest worthwhile range. Null: the calling thread, or `threads`. */
    void (*parallel_for)(void* context, size_t count, size_t grain, cageform_range_body body, void* argument);
    /* Is told the fraction done, on the calling thread; 0 cancels. Not called by functions of every frame. */
    int (*progress)(void* context, double done);
    uint32_t threads; /* without parallel_for: started for each loop; 0: the calling thread alone */
} cageform_running;

/* ---- Objects ------------------------------------------------------------------------------------------- */

typedef struct cageform_figure cageform_figure;           /* bound points, normals, tangents: to be cloned */
typedef struct cageform_player cageform_player;           /* plays a clip */
typedef struct cageform_bytes cageform_bytes;             /* a file's bytes, aligned to 64 */
typedef struct cageform_coordinates cageform_coordinates; /* of a cage */
typedef struct cageform_binding cageform_binding;         /* a figure with all its weights */
typedef struct cageform_made_cage cageform_made_cage;     /* by cageform_make_cage */
typedef struct cageform_skeleton cageform_skeleton;       /* by cageform_fit_skeleton */
typedef struct cageform_samples cageform_samples;         /* of a cage's inside, for pins */
typedef struct cageform_pins cageform_pins;               /* poses a cage by pins */

/* Frees an object of any kind; null is allowed. Those made of it go first. */
CAGEFORM_API cageform_status cageform_free(void* object);

/* ---- Reports ------------------------------------------------------------------------------------------- */

enum {
    CAGEFORM_NO_ELEMENT = 0,
    CAGEFORM_VERTEX = 1,
    CAGEFORM_EDGE = 2,
    CAGEFORM_FACE = 3,
    CAGEFORM_LOOP = 4
};

/* A fault of a cage, or a warning. */
typedef struct cageform_fault {
    cageform_status status; /* 0: a warning */
    uint32_t a_is, b_is;    /* which elements the indices name; an edge is named by its first vertex */
    uint32_t reserved;
    size_t a, b;
    const char* text; /* never freed */
} cageform_fault;

/* How a call went; a call fills what it knows and sets the rest to 0, indices to CAGEFORM_NONE. */
typedef struct cageform_report {
    size_t size;
    cageform_status status;
    uint32_t faults, warnings; /* of the cage: cageform_check lists them */
    uint32_t reserved;
    size_t culprit;       /* the index that the status names: a point, handle, pin, face, clip, … */
    cageform_fault fault; /* of the cage: the first, or the first warning */
    double seconds;
    char message[256]; /* the status and the culprit in a sentence; empty if all went well */

    /* cageform_bind; cageform_binding_list has the indices */
    size_t points, on_boundary, outside, faded, not_finite, unreached, not_restored;
    double partition_error,
        reproduction_error;             /* the largest |sum of weights - 1|, and distance from its place */
    double least_weight, amplification; /* the largest sum of |weights| of a point */

    /* harmonic coordinates */
    size_t unknowns, memory;    /* of one function; bytes */
    double grid_error;          /* an estimate of the largest error of a weight */
    double sufficient_accuracy; /* with CAGEFORM_OUT_OF_MEMORY: an accuracy that works; 0: none is known */

    /* cageform_pack */
    size_t bytes, dense_bytes;
    double distance, mean_distance; /* from where all weights put a point */

    /* cageform_make_cage; volumes are areas in the plane */
    size_t vertices, components, tunnels;
    double margin, clearance, volume, tightest_volume, least_angle;

    /* cageform_pose_samples */
    size_t samples, rotations;

    /* cageform_pins_solve: the largest miss, and the pin of it is the culprit; in the units of the cage */
    double miss, step, rigid_energy, least_stretch, largest_stretch;
    size_t iterations, folded;
    int settled;

    /* cageform_compile_clip */
    double curve_error; /* the largest distance of a coordinate from its keys' curve */

    /* cageform_fit_skeleton; distances are shares of the figure's diagonal at rest. The culprit is the vertex
     * of the largest, or the one that is refused; CAGEFORM_NONE for its frame is the rest */
    size_t bones, frame;
    size_t beyond; /* vertices farther away than max_distance */
    double rms, max_distance;
    double turn; /* degrees by which 99 % of the faces are turned wrongly at most */
    double mean_influences;
} cageform_report;

/* ==== Every frame ======================================================================================= */

typedef struct cageform_open_options {
    size_t size;
    uint64_t cage_hash, figure_hash; /* as bound; 0: any */
    int skip_checksum;               /* trusts the bytes; reads tables and clips alone */
    void* memory;                    /* for the object, cageform_figure_bytes() long; null: allocated */
    size_t memory_bytes;
} cageform_open_options;

typedef struct cageform_figure_info {
    size_t size;
    size_t points, handles;
    size_t vertices; /* handles that are points: what clips and cageform_pose_handles take */
    size_t clips, levels;
    uint32_t scalar, dimension;
    int has_normals, has_tangents, has_labels;
    double origin[3]; /* the place from which points, handles and clips count: add it to clones */
} cageform_figure_info;

/* Opens a packed figure or binding in place; `data` is aligned to 64 bytes and stays as it is while the
 * figure is in use. `options` may be null. `culprit` too: it becomes the tag of the part that is refused,
 * four letters, the first in the lowest byte; 0 is the whole. */
CAGEFORM_API size_t cageform_figure_bytes(void);
CAGEFORM_API cageform_status cageform_open(const void* data, size_t bytes,
                                           const cageform_open_options* options, cageform_figure** figure,
                                           size_t* culprit);
/* Opens a level of less detail, which takes the same poses; level 0 is the figure again. */
CAGEFORM_API cageform_status cageform_open_level(const cageform_figure* figure, size_t level,
                                                 const cageform_open_options* options,
                                                 cageform_figure** opened);
CAGEFORM_API cageform_status cageform_figure_describe(const cageform_figure* figure,
                                                      cageform_figure_info* info);
/* Writes the handles at rest, a pose to start from: info.handles points. */
CAGEFORM_API cageform_status cageform_figure_rest(const cageform_figure* figure, cageform_output handles);
/* Finds a handle's label (not terminated by a zero), and the first handle with a label: CAGEFORM_NONE if
 * none has. */
CAGEFORM_API cageform_status cageform_figure_label(const cageform_figure* figure, size_t handle,
                                                   const char** text, size_t* length);
CAGEFORM_API cageform_status cageform_figure_find_handle(const cageform_figure* figure, const char* text,
                                                         size_t length, size_t* handle);

/* Moves a figure with a pose of its handles. Pose and outputs have the figure's scalar.
 *
 *   pose      info.handles points
 *   points    out, info.points
 *   normals, tangents  out, or null; tangents in space, of 3 or 4 numbers, the fourth for the handedness
 *   running   its parallel_for or threads; or null. The result does not depend on it
 *   cost      as clone/clone.hpp; no allocation. The pose at rest gives the bound points to the bit */
CAGEFORM_API cageform_status cageform_clone(const cageform_figure* figure, cageform_points pose,
                                            cageform_output points, const cageform_output* normals,
                                            const cageform_output* tangents, const cageform_running* running);
/* Computes the gradients of the handles (out, info.handles) from those of the points that a clone writes. */
CAGEFORM_API cageform_status cageform_clone_transposed(const cageform_figure* figure,
                                                       cageform_points gradients, cageform_output handles,
                                                       const cageform_running* running);
/* Computes a pose of all handles from one of the cage's vertices, where some handles are vectors (Green). */
CAGEFORM_API cageform_status cageform_pose_handles(const cageform_figure* figure, cageform_points vertices,
                                                   cageform_output handles);

typedef struct cageform_clip_info {
    size_t size;
    size_t vertices;
    double begin, end; /* times */
    uint32_t scalar, dimension;
    const char* name; /* not terminated by a zero; null for a clip that belongs to no figure */
    size_t name_length;
} cageform_clip_info;

typedef struct cageform_play_options {
    size_t size;
    int skip_checksum; /* of bytes */
    void* memory;      /* for the player, as long as cageform_player_bytes says; null: allocated */
    size_t memory_bytes;
} cageform_play_options;

/* Finds the first clip of a figure with a name: CAGEFORM_NONE if none has it. */
CAGEFORM_API cageform_status cageform_figure_find_clip(const cageform_figure* figure, const char* name,
                                                       size_t length, size_t* clip);
/* Plays a clip of a figure, which has to outlive the player, or a packed clip, whose bytes have to.
 * Everyone who plays has a player. `options` may be null. */
CAGEFORM_API cageform_status cageform_play(const cageform_figure* figure, size_t clip,
                                           const cageform_play_options* options, cageform_player** player);
CAGEFORM_API cageform_status cageform_play_bytes(const void* data, size_t bytes,
                                                 const cageform_play_options* options,
                                                 cageform_player** player);
/* Says how much memory a player of a figure's clip takes. */
CAGEFORM_API cageform_status cageform_player_bytes(const cageform_figure* figure, size_t clip, size_t* bytes);
CAGEFORM_API cageform_status cageform_player_describe(const cageform_player* player,
                                                      cageform_clip_info* info);
/* Writes the cage's vertices at a time: info.vertices points of its scalar. No allocation. */
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
/* Opens packed samples, which are copied; `data` is aligned to 64 bytes. */
CAGEFORM_API cageform_status cageform_samples_open(const void* data, size_t bytes, int skip_checksum,
                                                   cageform_samples** samples);

typedef struct cageform_pins_options {
    size_t size;
    double pin_weight; /* 0: 1e4 */
    int hard;
    size_t iterations; /* of a frame; 0: 4 */
} cageform_pins_options;
/* Copies the samples. */
CAGEFORM_API cageform_status cageform_pins_create(const cageform_samples* samples,
                                                  const cageform_pins_options* options, cageform_pins** pins);
/* Sets pins among the points of a figure, which is copied from; count 0 takes all away. `weights` may be
 * null. The report may be null too, and names the pin that is refused. */
CAGEFORM_API cageform_status cageform_pins_set(cageform_pins* pins, const cageform_figure* figure,
                                               const uint32_t* points, size_t count, const double* weights,
                                               cageform_report* report);
/* Holds handles where the pose has them. */
CAGEFORM_API cageform_status cageform_pins_hold(cageform_pins* pins, const uint32_t* handles, size_t count,
                                                cageform_report* report);
/* Moves the pose (in and out, all handles) towards the targets, one for each pin; again until
 * report.settled. The scalar is that of the coordinates. No allocation. */
CAGEFORM_API cageform_status cageform_pins_solve(cageform_pins* pins, cageform_points targets,
                                                 cageform_output pose, cageform_report* report);
#if !defined(CAGEFORM_C_RUNTIME_ONLY)
/* ==== Bind time ========================================================================================= */

/* ---- Cages --------------------------------------------------------------------------------------------- */

enum {
    CAGEFORM_POLYGON = 0, /* in the plane: loops of vertices */
    CAGEFORM_MESH = 1,    /* in space: faces, counter-clockwise seen from outside */
    CAGEFORM_CURVES = 2,  /* in the plane: loops of Bezier curves of degree 1 to 3, for CAGEFORM_CURVED_GREEN */
    CAGEFORM_LATTICE = 3, /* a box of splines, in the plane or in space */
    CAGEFORM_SITES = 4    /* points without a cage, in the plane or in space */
};

/* A point inside a cage (a = b) or, in space, an edge; everything within the radius follows it. */
typedef struct cageform_bone {
    uint32_t a, b; /* vertices of the cage */
    double radius;
} cageform_bone;

/* A cage in the caller's memory, of which coordinates take copies. Any scalar. */
typedef struct cageform_cage {
    size_t size;
    uint32_t kind;
    uint32_t divisions; /* of a mesh: quads are divided k times each way, for mean value and harmonic; 0: 1 */
    cageform_points vertices; /* of curves the control points of all edges, ends included */
    /* POLYGON: vertices of each loop; null: one loop. MESH: corners of each face; null: triangles.
     * CURVES: the degree of each edge. */
    const uint32_t* counts;
    size_t count_count;
    const uint32_t* indices; /* MESH: the vertices at the corners of all faces */
    size_t index_count;
    const uint32_t* loops; /* CURVES: edges of each loop; null: one loop */
    size_t loop_count;
    double
        off_plane; /* MESH: how far a corner may lie off its face; farther off, a face is a fan of its mean */

    /* LATTICE: no vertices */
    uint32_t dimension;
    uint32_t points[3], degree[3]; /* along each axis; 0: 4, and 3 */
    double origin[3], axes[3][3];  /* axes[k] is the edge of the box along axis k */
    double falloff; /* outside, displacements fade to nothing at this distance; 0: they do not */

    /* Cells inside a POLYGON or a MESH of triangles, for CAGEFORM_HARMONIC. The last `cell_vertices` of
     * `vertices` are not on the boundary; they are handles too. */
    size_t cell_vertices;
    const cageform_bone* bones;
    size_t bone_count;
    const uint32_t* walls; /* in the plane the two ends of each edge, in space the corners of each triangle */
    size_t wall_index_count;
} cageform_cage;

/* Checks whether a cage can serve, as coordinates do. Lists faults and warnings as far as there is room:
 * `count` is their number. */
CAGEFORM_API cageform_status cageform_check(const cageform_cage* cage, cageform_fault* faults, size_t room,
                                            size_t* count);

typedef struct cageform_make_cage_options {
    size_t size;
    size_t vertices;  /* 0: 24 in the plane, 112 in space */
    double margin;    /* a share of the figure's diagonal; 0: 0.025 in the plane, 0.02 in space */
    uint32_t shape;   /* CAGEFORM_SHAPE_FIGURE, … */
    uint32_t mirror;  /* 0: none; 1, 2, 3: symmetric along x, y, z, about the middle of the figure */
    int many_cages;   /* parts stay apart instead of being joined */
    int holes;        /* in the plane: keeps large empty regions of areas */
    int fill_tunnels; /* in space */
    double regular;   /* weight of regular shapes against a tight fit; 0: 1 */
} cageform_make_cage_options;
enum cageform_shape { CAGEFORM_SHAPE_FIGURE = 0, CAGEFORM_SHAPE_HULL = 1, CAGEFORM_SHAPE_BOX = 2 };

/* Makes a cage around a figure.
 *
 *   points   in the plane the ends of segments, in space vertices
 *   indices  in the plane two a segment, in space three a triangle; any faces, holes and crossings are fine
 *   radii    in the plane half the width of each segment, or null
 *   areas    in the plane: the numbers of segments that are closed outlines of painted areas, from the first
 *            segment on; or null. Only options.holes looks at them */
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
/* Describes a cage that was made; its arrays live as long as the object. */
CAGEFORM_API cageform_status cageform_made_cage_describe(const cageform_made_cage* made, cageform_cage* cage);

/* ---- Coordinates --------------------------------------------------------------------------------------- */

enum cageform_coordinate_type {
    CAGEFORM_MEAN_VALUE = 0,
    CAGEFORM_HARMONIC = 1,
    CAGEFORM_GREEN = 2,  /* edges or faces are handles too: cageform_pose_handles */
    CAGEFORM_SIBSON = 3, /* of sites, and the vertices of any cage */
    CAGEFORM_BARYCENTRIC = 4,
    CAGEFORM_WACHSPRESS = 5,
    CAGEFORM_DISCRETE_HARMONIC = 6,
    CAGEFORM_SPLINES = 7,      /* of a lattice */
    CAGEFORM_CURVED_GREEN = 8, /* of curves; CAGEFORM_GREEN of curves is the same */
    CAGEFORM_SIBSON_C1 = 9     /* CAGEFORM_SIBSON of degree 3 */
};

typedef struct cageform_coordinates_options {
    size_t size;
    uint32_t type;          /* cageform_coordinate_type */
    uint32_t scalar;        /* of weights and poses */
    double accuracy;        /* harmonic: the largest error of a weight; 0: 1e-3 */
    size_t memory_limit;    /* harmonic, in bytes; 0: 8 GiB */
    uint32_t sibson_degree; /* 1, or 3, smooth at the sites; 0: 1 */
    uint32_t reserved;
    double disk[3]; /* of curves: centre and radius of a disk; radius 0: none */
} cageform_coordinates_options;

/* Makes coordinates of a cage. `options` may be null: mean value in float. */
CAGEFORM_API cageform_status cageform_coordinates_create(const cageform_cage* cage,
                                                         const cageform_coordinates_options* options,
                                                         cageform_coordinates** coordinates,
                                                         cageform_report* report);
/* Makes coordinates of several cages over one figure, such as a body and a head; where cages overlap, they are
 * blended by depth. Handles are those of the first cage, then of the next. Takes polygons and meshes of
 * triangles, and CAGEFORM_MEAN_VALUE or CAGEFORM_HARMONIC. The culprit is the cage that is refused. */
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
/* Solves for harmonic functions and keeps them, so that several binds solve only once. Others are ready. */
CAGEFORM_API cageform_status cageform_coordinates_solve(cageform_coordinates* coordinates,
                                                        const cageform_running* running,
                                                        cageform_report* report);

/* ---- Bind and pack ------------------------------------------------------------------------------------- */

enum cageform_outside_points {
    CAGEFORM_EXTEND = 0,
    CAGEFORM_KEEP_IN_PLACE = 1,
    CAGEFORM_NEAREST_BOUNDARY = 2
};

typedef struct cageform_bind_options {
    size_t size;
    uint32_t outside;           /* what becomes of points outside */
    int leave_linear_precision; /* leaves weights as the coordinates gave them */
    double falloff;             /* outside, displacements fade to nothing at this distance; 0: they do not */
} cageform_bind_options;

/* Binds points, and normals and tangents if they are not null (one for each point; tangents of 3 or 4
 * numbers). Bad points are listed and kept in place, the others are bound. */
CAGEFORM_API cageform_status cageform_bind(const cageform_coordinates* coordinates, cageform_points points,
                                           const cageform_points* normals, const cageform_points* tangents,
                                           const cageform_bind_options* options,
                                           const cageform_running* running, cageform_binding** binding,
                                           cageform_report* report);
/* Makes the figure that is cloned, of a binding that outlives it. */
CAGEFORM_API cageform_status cageform_binding_figure(const cageform_binding* binding,
                                                     cageform_figure** figure);
/* Writes the weights of points: a row of info.handles numbers of the binding's scalar each. */
CAGEFORM_API cageform_status cageform_binding_weights(const cageform_binding* binding, size_t first,
                                                      size_t count, void* weights, size_t bytes);
/* Labels handles, one for each; texts end with a zero, null is none. A figure made before has the labels
 * before. */
CAGEFORM_API cageform_status cageform_binding_set_labels(cageform_binding* binding, const char* const* labels,
                                                         size_t count);
enum {
    CAGEFORM_LIST_ON_BOUNDARY = 0,
    CAGEFORM_LIST_OUTSIDE = 1,
    CAGEFORM_LIST_NOT_FINITE = 2,
    CAGEFORM_LIST_UNREACHED = 3,
    CAGEFORM_LIST_NOT_RESTORED = 4,
    CAGEFORM_LIST_FADED = 5
};
/* Lists points in ascending order, as far as there is room: `count` is their number. */
CAGEFORM_API cageform_status cageform_binding_list(const cageform_binding* binding, uint32_t list,
                                                   size_t* indices, size_t room, size_t* count);

enum cageform_weight_format {
    CAGEFORM_FORMAT_SMALLEST = 0,
    CAGEFORM_FORMAT_SCALAR = 1,
    CAGEFORM_FORMAT_HALF = 2,
    CAGEFORM_FORMAT_INT16 = 3,
    CAGEFORM_FORMAT_INT8 = 4
};

/* A clip, or a level of less detail, to be packed with a figure. */
typedef struct cageform_part {
    const char* name; /* of a clip; ends with a zero */
    const void* data;
    size_t bytes;
} cageform_part;

typedef struct cageform_pack_options {
    size_t size;
    double tolerance; /* the largest distance of a point from where all weights put it; 0: no limit */
    double threshold; /* weights below may be dropped; with tolerance and largest 0 as well, nothing is */
    size_t largest;   /* weights that a point keeps; 0: all */
    double reach; /* poses in which the tolerance holds: handles this far from an affine image; 0: a tenth */
    cageform_points poses; /* or these: pose after pose, all handles each; no data: none */
    uint32_t format;
    uint32_t reserved;
    const cageform_part* clips;
    size_t clip_count;
    const cageform_part* levels;
    size_t level_count;
    double origin[3]; /* the place from which points, handles and clips count; it is only stored */
} cageform_pack_options;

/* Packs a figure for cageform_open: the bytes that a game ships. */
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
    double tolerance;      /* the largest error of a coordinate; 0: a thousandth of the poses' size or less */
    double pack_tolerance; /* the largest distance that 16-bit curves may cost; 0: curves stay exact */
    uint32_t keys;         /* how poses are joined */
    uint32_t before, after; /* what is played before the first time and after the last */
    uint32_t scalar;        /* of the clip */
} cageform_clip_options;
/* Compiles poses of the cage's vertices at ascending times, pose after pose, to a packed clip. */
CAGEFORM_API cageform_status cageform_compile_clip(const double* times, size_t count, cageform_points poses,
                                                   const cageform_clip_options* options,
                                                   const cageform_running* running, cageform_bytes** clip,
                                                   cageform_report* report);

/* ---- Skeletons ----------------------------------------------------------------------------------------- */

enum cageform_bone_kind {
    CAGEFORM_RIGID = 0,    /* bones turn and move: every engine plays these */
    CAGEFORM_SIMILAR = 1,  /* one scale besides; the children of a bone scale with it */
    CAGEFORM_STRETCHED = 2 /* any affine map: only players that multiply matrices show these */
};

typedef struct cageform_skeleton_options {
    size_t size;
    size_t bones;      /* 0: as few as keep max_distance */
    size_t influences; /* weights a vertex, 1 to 8; 0: 4 */
    /* The distance, a share of the figure's diagonal at rest, within which every vertex is to stay in every
     * frame; 0: none. With `bones` the report counts the vertices that are farther away. */
    double max_distance;
    uint32_t kind; /* CAGEFORM_RIGID, … */
    uint32_t reserved;
} cageform_skeleton_options;

/* Fits a skeleton to any sequence of meshes: bones that turn, joints, a hierarchy, and a few weights a vertex.
 *
 *   rest     the vertices at rest, in space, where no bone has moved
 *   frames   frame after frame, two or more, all vertices each; the rest need not be one
 *   indices  three a triangle, or null: weights are smooth along edges
 *   options  bones or max_distance has to be set
 *   running  threads, progress, cancel; or null. The result does not depend on threads */
CAGEFORM_API cageform_status cageform_fit_skeleton(cageform_points rest, cageform_points frames,
                                                   const uint32_t* indices, size_t index_count,
                                                   const cageform_skeleton_options* options,
                                                   const cageform_running* running,
                                                   cageform_skeleton** skeleton, cageform_report* report);

/* A skeleton. A vertex that is at v at rest is in frame t at
 *
 *     sum over k < influences of weights[k] * maps[t][vertex_bones[k]](v)
 *
 * The arrays live as long as the object. */
typedef struct cageform_skeleton_info {
    size_t size;
    size_t bones, frames, vertices, influences;
    const uint32_t* parents;      /* bones: those before their children; UINT32_MAX of the root, bone 0 */
    const double* joints;         /* bones * 3: where each meets its parent, at rest */
    const uint16_t* vertex_bones; /* vertices * influences; 0 where a weight is 0 */
    const float* weights;         /* vertices * influences: those of a vertex fall, and their sum is 1 */
    const double* maps;           /* frames * bones * 12: where x, y, z go, as directions, and the origin */
} cageform_skeleton_info;
CAGEFORM_API cageform_status cageform_skeleton_describe(const cageform_skeleton* skeleton,
                                                        cageform_skeleton_info* info);
/* Writes the transforms of the bones' nodes, as engines play them: frame after frame, all bones each.
 *
 *     x -> rotation(scale * axes(x)) + translation
 *
 * goes from a node's own axes, whose origin is its joint, to those of its parent: at rest without a turn. The
 * product of these along the way from the root, after a shift by -joint, is the bone's map.
 *
 *   translations  out, frames * bones of 3 numbers, any scalar
 *   rotations     out, of 4 numbers: quaternions x y z w, of one sign from frame to frame
 *   scales        out, of 3 numbers; null only if bones are RIGID, whose scales are 1
 *   axes          out, quaternions; null unless bones are STRETCHED
 *   fails         CAGEFORM_VALUE_NOT_FINITE: a parent is flat in some frame; use the maps */
CAGEFORM_API cageform_status cageform_skeleton_transforms(const cageform_skeleton* skeleton,
                                                          cageform_output translations,
                                                          cageform_output rotations,
                                                          const cageform_output* scales,
                                                          const cageform_output* axes);

/* ---- Samples for pins ---------------------------------------------------------------------------------- */

typedef struct cageform_samples_options {
    size_t size;
    size_t samples, rotations; /* 0: by the number of handles */
    double smoothing;          /* spreads bends over this share of the cage's size */
} cageform_samples_options;
/* Samples the inside of a cage; the coordinates need gradients. */
CAGEFORM_API cageform_status cageform_pose_samples(const cageform_coordinates* coordinates,
                                                   const cageform_samples_options* options,
                                                   const cageform_running* running,
                                                   cageform_samples** samples, cageform_report* report);
/* Packs samples for cageform_samples_open: what a game ships beside a figure. */
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
#endif
#endif
