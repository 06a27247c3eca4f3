/* Calls every function of the C interface from C99, on a square and a cube, and prints what fails. It is a program,
 * and with CALLS_MAIN defined a function of that name of another. */
#include <cageform/c/cageform.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;
#define CHECK(condition)                                                                                     \
    do {                                                                                                     \
        if (!(condition)) {                                                                                  \
            ++failures;                                                                                      \
            fprintf(stderr, "calls.c:%d: %s\n", __LINE__, #condition);                                       \
        }                                                                                                    \
    } while (0)

static cageform_points points_of(const void* data, size_t count, uint32_t scalar, uint32_t dimension) {
    cageform_points points;
    points.data = data;
    points.count = count;
    points.stride = 0;
    points.bytes = count * dimension * (scalar == CAGEFORM_FLOAT ? sizeof(float) : sizeof(double));
    points.scalar = scalar;
    points.dimension = dimension;
    return points;
}
static cageform_output output_of(void* data, size_t count, uint32_t scalar, uint32_t dimension) {
    cageform_output output;
    output.data = data;
    output.count = count;
    output.stride = 0;
    output.bytes = count * dimension * (scalar == CAGEFORM_FLOAT ? sizeof(float) : sizeof(double));
    output.scalar = scalar;
    output.dimension = dimension;
    return output;
}

/* A loop in three pieces, backwards, and a progress that counts or stops. */
typedef struct counts {
    int loops, steps, stops_after;
    double done;
} counts;
static void loop_in_pieces(void* context, size_t count, size_t grain, cageform_range_body body,
                           void* argument) {
    const size_t third = count / 3;
    (void)grain;
    ++((counts*)context)->loops;
    body(argument, 2 * third, count);
    body(argument, third, 2 * third);
    body(argument, 0, third);
}
static int step(void* context, double done) {
    counts* its = context;
    its->done = done;
    return ++its->steps != its->stops_after;
}
static cageform_running running_of(counts* its) {
    cageform_running running;
    memset(&running, 0, sizeof running);
    running.size = sizeof running;
    running.context = its;
    running.parallel_for = loop_in_pieces;
    running.progress = step;
    return running;
}

static const float square[8] = {0, 0, 4, 0, 4, 4, 0, 4};
static const float inside[10] = {1, 1, 2, 3, 3, 1, 2, 2, 0.5f, 3.5f};
static const double cube[24] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1,
                                -1, -1, 1,  1, -1, 1,  1, 1, 1,  -1, 1, 1};
static const uint32_t quads[24] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};
static const uint32_t fours[6] = {4, 4, 4, 4, 4, 4};
static uint32_t triangles[36];

static cageform_cage square_cage(void) {
    cageform_cage cage;
    memset(&cage, 0, sizeof cage);
    cage.size = sizeof cage;
    cage.kind = CAGEFORM_POLYGON;
    cage.vertices = points_of(square, 4, CAGEFORM_FLOAT, 2);
    return cage;
}
static cageform_cage cube_cage(void) {
    cageform_cage cage;
    memset(&cage, 0, sizeof cage);
    cage.size = sizeof cage;
    cage.kind = CAGEFORM_MESH;
    cage.vertices = points_of(cube, 8, CAGEFORM_DOUBLE, 3);
    cage.indices = triangles;
    cage.index_count = 36;
    return cage;
}

static cageform_coordinates* coordinates_of(cageform_cage cage, uint32_t type, uint32_t scalar) {
    cageform_coordinates* coordinates = NULL;
    cageform_coordinates_options options;
    cageform_report report;
    memset(&options, 0, sizeof options);
    options.size = sizeof options;
    options.type = type;
    options.scalar = scalar;
    report.size = sizeof report;
    if (cageform_coordinates_create(&cage, &options, &coordinates, &report) != CAGEFORM_OK) {
        ++failures;
        fprintf(stderr, "coordinates %u: %s\n", (unsigned)type, report.message);
    }
    return coordinates;
}

/* From a cage to a clip that plays: a square, its points, a pose, a file. */
static void test_square(void) {
    cageform_coordinates* coordinates = coordinates_of(square_cage(), CAGEFORM_HARMONIC, CAGEFORM_FLOAT);
    cageform_coordinates_info about;
    cageform_binding* binding = NULL;
    cageform_figure *figure = NULL, *opened = NULL, *found = NULL;
    cageform_figure_info info;
    cageform_bytes *clip = NULL, *packed = NULL;
    cageform_player *player = NULL, *second = NULL;
    cageform_clip_info played;
    cageform_report report;
    cageform_part part;
    cageform_pack_options pack;
    cageform_open_options open;
    cageform_play_options play;
    cageform_points points = points_of(inside, 5, CAGEFORM_FLOAT, 2);
    const char* const labels[4] = {"foot", NULL, "head", ""};
    const char* const long_labels[4] = {"the left foot", "a hand with fingers", "", "the head of the figure"};
    const char* text = NULL;
    const double times[3] = {0, 1, 3};
    float poses[24], out[10], pose[8], gradients[8], weights[20];
    void* memory = NULL;
    const void* data = NULL;
    size_t n, length = 0, index = 0, bytes = 0, listed[2];
    counts its = {0, 0, 0, 0};
    cageform_running running = running_of(&its);

    about.size = sizeof about;
    CHECK(cageform_coordinates_describe(coordinates, &about) == CAGEFORM_OK);
    CHECK(about.handles == 4 && about.vertices == 4 && about.dimension == 2 &&
          about.scalar == CAGEFORM_FLOAT);
    CHECK(!about.has_weights_outside && about.has_gradients);
    CHECK(cageform_coordinates_rest(coordinates, output_of(pose, 4, CAGEFORM_FLOAT, 2)) == CAGEFORM_OK);
    CHECK(memcmp(pose, square, sizeof square) == 0);
    report.size = sizeof report;
    CHECK(cageform_coordinates_solve(coordinates, &running, &report) == CAGEFORM_OK);
    CHECK(report.unknowns > 0 && its.steps > 0 && its.done == 1);
    CHECK(cageform_bind(coordinates, points, NULL, NULL, NULL, &running, &binding, &report) == CAGEFORM_OK);
    CHECK(report.points == 5 && report.outside == 0 && report.message[0] == 0 && report.seconds >= 0);
    CHECK(cageform_binding_weights(binding, 0, 5, weights, sizeof weights) == CAGEFORM_OK);
    for (n = 0; n < 5; ++n)
        CHECK(fabs(weights[4 * n] + weights[4 * n + 1] + weights[4 * n + 2] + weights[4 * n + 3] - 1.0) <
              1e-6);
    CHECK(cageform_binding_list(binding, CAGEFORM_LIST_OUTSIDE, listed, 2, &length) == CAGEFORM_OK &&
          length == 0);
    CHECK(cageform_binding_set_labels(binding, long_labels, 4) == CAGEFORM_OK);
    CHECK(cageform_binding_figure(binding, &found) == CAGEFORM_OK);
    CHECK(cageform_binding_set_labels(binding, labels, 4) == CAGEFORM_OK);
    CHECK(cageform_binding_set_labels(binding, labels, 3) == CAGEFORM_LABELS_DO_NOT_MATCH);
    for (n = 0; n < 4; ++n) /* the figure has the labels before */
        CHECK(cageform_figure_label(found, n, &text, &length) == CAGEFORM_OK &&
              length == strlen(long_labels[n]) && memcmp(text, long_labels[n], length) == 0);
    CHECK(cageform_free(found) == CAGEFORM_OK);
    found = NULL;

    for (n = 0; n < 24; ++n) poses[n] = square[n % 8];
    poses[12] = poses[20] = 6; /* vertex 2 goes right */
    CHECK(cageform_compile_clip(times, 3, points_of(poses, 12, CAGEFORM_FLOAT, 2), NULL, NULL, &clip,
                                &report) == CAGEFORM_OK);
    CHECK(report.vertices == 4 && report.bytes > 0);
    memset(&part, 0, sizeof part);
    part.name = "wave";
    CHECK(cageform_bytes_view(clip, &part.data, &part.bytes) == CAGEFORM_OK && part.bytes == report.bytes);
    memset(&pack, 0, sizeof pack);
    pack.size = sizeof pack;
    pack.tolerance = 1e-3;
    pack.clips = &part;
    pack.clip_count = 1;
    pack.origin[0] = 500000;
    pack.origin[1] = -4600000.25;
    pack.origin[1] = NAN;
    CHECK(cageform_pack(binding, &pack, NULL, &packed, &report) == CAGEFORM_VALUE_NOT_FINITE);
    pack.origin[1] = -4600000.25;
    CHECK(cageform_pack(binding, &pack, NULL, &packed, &report) == CAGEFORM_OK);
    CHECK(cageform_bytes_view(packed, &data, &bytes) == CAGEFORM_OK && bytes == report.bytes);

    memory = malloc(cageform_figure_bytes() + 64);
    memset(&open, 0, sizeof open);
    open.size = sizeof open;
    open.memory = (char*)memory + (64 - (uintptr_t)memory % 64) % 64;
    open.memory_bytes = cageform_figure_bytes();
    CHECK(cageform_open(data, bytes, &open, &opened, &index) == CAGEFORM_OK);
    CHECK((void*)opened == open.memory);
    info.size = sizeof info;
    CHECK(cageform_figure_describe(opened, &info) == CAGEFORM_OK);
    CHECK(info.points == 5 && info.handles == 4 && info.vertices == 4 && info.clips == 1 && info.levels == 0);
    CHECK(info.has_labels && !info.has_normals && !info.has_tangents && info.dimension == 2);
    CHECK(info.origin[0] == 500000 && info.origin[1] == -4600000.25 && info.origin[2] == 0);
    CHECK(cageform_open_level(opened, 0, NULL, &found) == CAGEFORM_OK);
    CHECK(cageform_free(found) == CAGEFORM_OK);
    CHECK(cageform_open_level(opened, 1, NULL, &found) == CAGEFORM_NOT_A_FIGURE);
    CHECK(cageform_figure_label(opened, 2, &text, &length) == CAGEFORM_OK && length == 4);
    CHECK(memcmp(text, "head", 4) == 0);
    CHECK(cageform_figure_find_handle(opened, "head", 4, &index) == CAGEFORM_OK && index == 2);
    CHECK(cageform_figure_find_handle(opened, "tail", 4, &index) == CAGEFORM_OK && index == CAGEFORM_NONE);
    CHECK(cageform_figure_rest(opened, output_of(pose, 4, CAGEFORM_FLOAT, 2)) == CAGEFORM_OK);
    CHECK(cageform_clone(opened, points_of(pose, 4, CAGEFORM_FLOAT, 2), output_of(out, 5, CAGEFORM_FLOAT, 2),
                         NULL, NULL, &running) == CAGEFORM_OK);
    CHECK(memcmp(out, inside, sizeof inside) == 0); /* to the bit */
    CHECK(cageform_clone_transposed(opened, points_of(out, 5, CAGEFORM_FLOAT, 2),
                                    output_of(gradients, 4, CAGEFORM_FLOAT, 2), NULL) == CAGEFORM_OK);

    CHECK(cageform_figure_find_clip(opened, "wave", 4, &index) == CAGEFORM_OK && index == 0);
    CHECK(cageform_player_bytes(opened, 0, &length) == CAGEFORM_OK && length > 0);
    CHECK(cageform_play(opened, 0, NULL, &player) == CAGEFORM_OK);
    memset(&play, 0, sizeof play);
    play.size = sizeof play;
    CHECK(cageform_play_bytes(part.data, part.bytes, &play, &second) == CAGEFORM_OK);
    played.size = sizeof played;
    CHECK(cageform_player_describe(player, &played) == CAGEFORM_OK);
    CHECK(played.vertices == 4 && played.begin == 0 && played.end == 3 && played.name_length == 4);
    CHECK(cageform_player_sample(player, 1, output_of(pose, 4, CAGEFORM_FLOAT, 2)) == CAGEFORM_OK);
    CHECK(pose[4] == 6 && pose[5] == 4 && pose[0] == 0);
    CHECK(cageform_player_sample(second, 0, output_of(pose, 4, CAGEFORM_FLOAT, 2)) == CAGEFORM_OK);
    CHECK(memcmp(pose, square, sizeof square) == 0);

    CHECK(cageform_binding_figure(binding, &figure) == CAGEFORM_OK);
    CHECK(cageform_free(figure) == CAGEFORM_OK && cageform_free(player) == CAGEFORM_OK);
    CHECK(cageform_free(second) == CAGEFORM_OK && cageform_free(opened) == CAGEFORM_OK);
    CHECK(cageform_free(packed) == CAGEFORM_OK && cageform_free(clip) == CAGEFORM_OK);
    CHECK(cageform_free(binding) == CAGEFORM_OK && cageform_free(coordinates) == CAGEFORM_OK);
    CHECK(cageform_free(NULL) == CAGEFORM_OK);
    free(memory);
}

/* Every type of coordinates, on every kind of cage, in space and in the plane. */
static void test_types(void) {
    const double controls[24] = {0, 0, 1, -1, 3, -1, 4, 0, 4, 0, 4, 4, 4, 4, 0, 4, 0, 4, 0, 0};
    const uint32_t degrees[4] = {3, 1, 1, 1};
    const uint32_t types[5] = {CAGEFORM_MEAN_VALUE, CAGEFORM_HARMONIC, CAGEFORM_GREEN, CAGEFORM_SIBSON,
                               CAGEFORM_MAXIMUM_ENTROPY};
    const uint32_t flat[7] = {CAGEFORM_WACHSPRESS, CAGEFORM_DISCRETE_HARMONIC, CAGEFORM_SIBSON_C1,
                              CAGEFORM_GREEN,      CAGEFORM_MAXIMUM_ENTROPY,   CAGEFORM_MEC_1,
                              CAGEFORM_MEC_2};
    const double middle[3] = {0.25, -0.5, 0.125}, there[2] = {2, 1};
    double pose[200], vertices[200], out[3];
    size_t n;
    cageform_cage cage;
    for (n = 0; n < 16; ++n) {
        cageform_coordinates* coordinates;
        cageform_coordinates_info info;
        cageform_binding* binding = NULL;
        cageform_figure* figure = NULL;
        cageform_report report;
        const int in_space = n < 7;
        cage = in_space ? cube_cage() : square_cage();
        if (n == 5) { /* quads */
            cage.indices = quads;
            cage.index_count = 24;
            cage.counts = fours;
            cage.count_count = 6;
            cage.divisions = 2;
        }
        if (n == 6) { /* a lattice of the cube */
            cage.kind = CAGEFORM_LATTICE;
            cage.dimension = 3;
            cage.points[0] = cage.points[1] = cage.points[2] = 2;
            cage.origin[0] = cage.origin[1] = cage.origin[2] = -1;
            cage.axes[0][0] = cage.axes[1][1] = cage.axes[2][2] = 2;
        }
        if (n >= 14) {
            cage.kind = CAGEFORM_CURVES;
            cage.vertices = points_of(controls, 10, CAGEFORM_DOUBLE, 2);
            cage.counts = degrees;
            cage.count_count = 4;
        }
        coordinates = coordinates_of(cage,
                                     n < 5     ? types[n]
                                     : n == 5  ? (uint32_t)CAGEFORM_MEAN_VALUE
                                     : n == 6  ? (uint32_t)CAGEFORM_SPLINES
                                     : n < 14  ? flat[n - 7]
                                     : n == 14 ? (uint32_t)CAGEFORM_CURVED_GREEN
                                               : (uint32_t)CAGEFORM_GREEN, /* of curves it is the same */
                                     CAGEFORM_DOUBLE);
        info.size = sizeof info;
        report.size = sizeof report;
        CHECK(cageform_coordinates_describe(coordinates, &info) == CAGEFORM_OK);
        CHECK(info.handles <= 60);
        CHECK(cageform_bind(coordinates,
                            points_of(in_space ? middle : there, 1, CAGEFORM_DOUBLE, info.dimension), NULL,
                            NULL, NULL, NULL, &binding, &report) == CAGEFORM_OK);
        CHECK(cageform_binding_figure(binding, &figure) == CAGEFORM_OK);
        /* All handles move by (3, …): so does the point. */
        CHECK(cageform_coordinates_rest(coordinates, output_of(pose, info.handles, CAGEFORM_DOUBLE,
                                                               info.dimension)) == CAGEFORM_OK);
        memcpy(vertices, pose, info.vertices * info.dimension * sizeof(double));
        {
            size_t i;
            for (i = 0; i < info.vertices * info.dimension; ++i) vertices[i] += 3;
        }
        if (n < 14) /* the vectors of curves are not behind the points alone */
            CHECK(cageform_pose_handles(
                      figure, points_of(vertices, info.vertices, CAGEFORM_DOUBLE, info.dimension),
                      output_of(pose, info.handles, CAGEFORM_DOUBLE, info.dimension)) == CAGEFORM_OK);
        CHECK(cageform_clone(figure, points_of(pose, info.handles, CAGEFORM_DOUBLE, info.dimension),
                             output_of(out, 1, CAGEFORM_DOUBLE, info.dimension), NULL, NULL,
                             NULL) == CAGEFORM_OK);
        if (n < 14) CHECK(fabs(out[0] - (in_space ? middle[0] : there[0]) - 3) < 1e-9);
        cageform_free(figure);
        cageform_free(binding);
        cageform_free(coordinates);
    }
}

/* Binds a point and moves all handles by (3, 3, …): so does the point. Returns the weight of a handle. */
static double weight_and_move(const cageform_coordinates* coordinates, const double* point, size_t handles,
                              uint32_t dimension, size_t handle) {
    cageform_binding* binding = NULL;
    cageform_figure* figure = NULL;
    double weights[16], pose[48], out[3];
    size_t n;
    CHECK(cageform_bind(coordinates, points_of(point, 1, CAGEFORM_DOUBLE, dimension), NULL, NULL, NULL, NULL,
                        &binding, NULL) == CAGEFORM_OK);
    CHECK(cageform_binding_figure(binding, &figure) == CAGEFORM_OK);
    CHECK(cageform_binding_weights(binding, 0, 1, weights, sizeof weights) == CAGEFORM_OK);
    CHECK(cageform_figure_rest(figure, output_of(pose, handles, CAGEFORM_DOUBLE, dimension)) == CAGEFORM_OK);
    for (n = 0; n < handles * dimension; ++n) pose[n] += 3;
    CHECK(cageform_clone(figure, points_of(pose, handles, CAGEFORM_DOUBLE, dimension),
                         output_of(out, 1, CAGEFORM_DOUBLE, dimension), NULL, NULL, NULL) == CAGEFORM_OK);
    for (n = 0; n < dimension; ++n) CHECK(fabs(out[n] - point[n] - 3) < 1e-9);
    cageform_free(figure);
    cageform_free(binding);
    return weights[handle];
}

/* The locality of harmonic coordinates. */
static void test_locality(void) {
    const cageform_cage cage = square_cage();
    const double point[2] = {1, 1};
    double weights[3];
    cageform_coordinates* coordinates = NULL;
    cageform_binding* binding = NULL;
    cageform_coordinates_options options;
    cageform_report report;
    int n;
    memset(&options, 0, sizeof options);
    options.size = sizeof options;
    options.type = CAGEFORM_HARMONIC;
    options.scalar = CAGEFORM_DOUBLE;
    report.size = sizeof report;
    for (n = 0; n < 3; ++n, options.locality += 20) {
        CHECK(cageform_coordinates_create(&cage, &options, &coordinates, &report) == CAGEFORM_OK);
        weights[n] = weight_and_move(coordinates, point, 4, 2, 2); /* of the far corner */
        cageform_free(coordinates);
    }
    CHECK(weights[1] < 0.1 * weights[0]);
    CHECK(weights[2] < 0.1 * weights[1]);
    options.locality = 41;
    CHECK(cageform_coordinates_create(&cage, &options, &coordinates, &report) == CAGEFORM_OK);
    CHECK(cageform_bind(coordinates, points_of(point, 1, CAGEFORM_DOUBLE, 2), NULL, NULL, NULL, NULL,
                        &binding, &report) == CAGEFORM_LOCALITY_NOT_SUPPORTED);
    CHECK(binding == NULL);
    cageform_free(coordinates);
}

/* Cells inside a cage, and several cages. */
static void test_cells_and_blends(void) {
    const double with_point[10] = {0, 0, 4, 0, 4, 4, 0, 4, 2, 2}, beside[2] = {2.25, 2}, both[2] = {3, 1};
    const double right[8] = {2, 0, 6, 0, 6, 4, 2, 4}, crossing[8] = {2, 0, 6, 4, 6, 0, 2, 4};
    const cageform_bone bone = {4, 4, 0.5};
    const uint32_t wall[3] = {8, 9, 10}, left_wall[2] = {4, 5};
    double with_wall[33], with_edge[12];
    const double on_wall[3] = {0.4, 0, 0.0};
    cageform_cage cage = square_cage(), second = square_cage(), third;
    const cageform_cage* cages[2];
    cageform_coordinates* coordinates;
    cageform_coordinates_options options;
    cageform_report report;
    cageform_fault faults[4];
    size_t count = 0;
    memset(&options, 0, sizeof options);
    options.size = sizeof options;
    options.scalar = CAGEFORM_DOUBLE;
    report.size = sizeof report;

    cage.vertices = points_of(with_point, 5, CAGEFORM_DOUBLE, 2);
    cage.cell_vertices = 1;
    cage.bones = &bone;
    cage.bone_count = 1;
    coordinates = coordinates_of(cage, CAGEFORM_HARMONIC, CAGEFORM_DOUBLE);
    CHECK(weight_and_move(coordinates, beside, 5, 2, 4) > 0.9); /* within the radius it follows the point */
    cageform_free(coordinates);
    CHECK(cageform_check(&cage, faults, 4, &count) == CAGEFORM_OK && count == 0);
    CHECK(cageform_coordinates_create(&cage, NULL, &coordinates, &report) ==
          CAGEFORM_INTERIOR_CELLS_NOT_SUPPORTED);
    options.type = CAGEFORM_HARMONIC;
    cage.bones = NULL;
    CHECK(cageform_coordinates_create(&cage, &options, &coordinates, &report) == CAGEFORM_ARGUMENT_NULL);
    cage.bone_count = 0;
    memcpy(with_edge, with_point, sizeof with_point);
    with_edge[10] = 1;
    with_edge[11] = 2;
    cage.vertices = points_of(with_edge, 6, CAGEFORM_DOUBLE, 2);
    cage.cell_vertices = 2;
    cage.walls = left_wall;
    cage.wall_index_count = 2;
    coordinates = coordinates_of(cage, CAGEFORM_HARMONIC, CAGEFORM_DOUBLE);
    CHECK(weight_and_move(coordinates, with_point + 8, 6, 2, 4) == 1); /* a vertex follows itself */
    cageform_free(coordinates);
    cage.wall_index_count = 1;
    CHECK(cageform_coordinates_create(&cage, &options, &coordinates, &report) ==
          CAGEFORM_COUNTS_DO_NOT_MATCH);
    cage.wall_index_count = 2;
    cage.walls = wall;
    CHECK(cageform_coordinates_create(&cage, &options, &coordinates, &report) ==
          CAGEFORM_INDEX_OUT_OF_BOUNDS);
    cage.cell_vertices = 7;
    CHECK(cageform_coordinates_create(&cage, &options, &coordinates, &report) ==
          CAGEFORM_COUNTS_DO_NOT_MATCH);

    memcpy(with_wall, cube, sizeof cube);
    with_wall[24] = with_wall[27] = -0.5;
    with_wall[30] = 0.5;
    with_wall[25] = with_wall[28] = with_wall[31] = 0;
    with_wall[26] = -0.5;
    with_wall[29] = 0.5;
    with_wall[32] = 0;
    third = cube_cage();
    third.vertices = points_of(with_wall, 11, CAGEFORM_DOUBLE, 3);
    third.cell_vertices = 3;
    third.walls = wall;
    third.wall_index_count = 3;
    options.accuracy = 0.05;
    CHECK(cageform_coordinates_create(&third, &options, &coordinates, &report) == CAGEFORM_OK);
    CHECK(weight_and_move(coordinates, on_wall, 11, 3, 10) > 0.8); /* linear on the triangle: 0.9 */
    cageform_free(coordinates);
    third.indices = quads;
    third.index_count = 24;
    third.counts = fours;
    third.count_count = 6;
    CHECK(cageform_coordinates_create(&third, &options, &coordinates, &report) ==
          CAGEFORM_CAGE_KIND_NOT_SUPPORTED);

    cage = square_cage();
    cages[0] = &cage;
    cages[1] = &second;
    second.vertices = points_of(right, 4, CAGEFORM_DOUBLE, 2);
    for (options.type = CAGEFORM_MEAN_VALUE; options.type <= CAGEFORM_HARMONIC; ++options.type) {
        CHECK(cageform_coordinates_blend(cages, 2, &options, &coordinates, &report) == CAGEFORM_OK);
        CHECK(report.culprit == CAGEFORM_NONE && report.message[0] == 0);
        CHECK(weight_and_move(coordinates, both, 8, 2, 1) > 0.1); /* both cages take part */
        CHECK(weight_and_move(coordinates, both, 8, 2, 4) > 0.1);
        cageform_free(coordinates);
    }
    CHECK(cageform_coordinates_blend(cages, 2, &options, &coordinates, &report) ==
          CAGEFORM_CAGE_KIND_NOT_SUPPORTED);
    options.type = CAGEFORM_MEAN_VALUE;
    second.vertices = points_of(crossing, 4, CAGEFORM_DOUBLE, 2);
    CHECK(cageform_coordinates_blend(cages, 2, &options, &coordinates, &report) ==
          CAGEFORM_CAGE_SELF_CROSSING);
    CHECK(report.culprit == 1);
    cages[1] = NULL;
    CHECK(cageform_coordinates_blend(cages, 2, &options, &coordinates, &report) == CAGEFORM_ARGUMENT_NULL);
    CHECK(cageform_coordinates_blend(cages, 0, &options, &coordinates, &report) == CAGEFORM_TOO_FEW_VERTICES);
    CHECK(cageform_coordinates_blend(NULL, 1, &options, &coordinates, &report) == CAGEFORM_ARGUMENT_NULL);
}

/* Normals and tangents; points outside; a point that is not finite. */
static void test_normals(void) {
    const double points[12] = {0.5, 0, 0, 0, 0.5, 0, 5, 0, 0, 0, 0, 0.5};
    const double normals[12] = {1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1};
    const double tangents[16] = {0, 1, 0, 1, 0, 0, 1, -1, 0, 1, 0, 1, 1, 0, 0, 1};
    double moved[12], turned[12], along[16];
    double bad[12];
    cageform_coordinates* coordinates = coordinates_of(cube_cage(), CAGEFORM_MEAN_VALUE, CAGEFORM_DOUBLE);
    cageform_binding* binding = NULL;
    cageform_figure* figure = NULL;
    cageform_figure_info info;
    cageform_points given = points_of(normals, 4, CAGEFORM_DOUBLE, 3),
                    with = points_of(tangents, 4, CAGEFORM_DOUBLE, 4);
    cageform_output out = output_of(turned, 4, CAGEFORM_DOUBLE, 3),
                    forth = output_of(along, 4, CAGEFORM_DOUBLE, 4);
    cageform_bind_options options;
    cageform_report report;
    size_t list[4], count = 0;
    memset(&options, 0, sizeof options);
    options.size = sizeof options;
    options.outside = CAGEFORM_NEAREST_BOUNDARY;
    options.falloff = 100;
    report.size = sizeof report;
    memcpy(bad, points, sizeof bad);
    bad[10] = NAN;
    CHECK(cageform_bind(coordinates, points_of(bad, 4, CAGEFORM_DOUBLE, 3), &given, &with, &options, NULL,
                        &binding, &report) == CAGEFORM_OK);
    CHECK(report.outside == 1 && report.not_finite == 1 && report.faded == 1);
    CHECK(cageform_binding_list(binding, CAGEFORM_LIST_OUTSIDE, list, 4, &count) == CAGEFORM_OK);
    CHECK(count == 1 && list[0] == 2);
    CHECK(cageform_binding_list(binding, CAGEFORM_LIST_NOT_FINITE, list, 4, &count) == CAGEFORM_OK);
    CHECK(count == 1 && list[0] == 3);
    CHECK(cageform_binding_figure(binding, &figure) == CAGEFORM_OK);
    info.size = sizeof info;
    CHECK(cageform_figure_describe(figure, &info) == CAGEFORM_OK && info.has_normals && info.has_tangents);
    CHECK(cageform_clone(figure, points_of(cube, 8, CAGEFORM_DOUBLE, 3),
                         output_of(moved, 4, CAGEFORM_DOUBLE, 3), &out, &forth, NULL) == CAGEFORM_OK);
    CHECK(memcmp(moved, points, 9 * sizeof(double)) == 0);
    CHECK(fabs(turned[0] - 1) < 1e-15 && fabs(along[1] - 1) < 1e-15 && along[7] == -1);
    cageform_free(figure);
    cageform_free(binding);
    cageform_free(coordinates);
}

/* A cage that is made, around a bar in space and a drawing in the plane. */
static void test_made_cages(void) {
    const uint32_t segments[8] = {0, 1, 1, 2, 2, 3, 3, 0};
    const double radii[4] = {0.1, 0.1, 0.1, 0.1};
    const uint32_t areas[1] = {4};
    size_t n;
    for (n = 0; n < 2; ++n) {
        cageform_drawing drawing;
        cageform_make_cage_options options;
        cageform_made_cage* made = NULL;
        cageform_cage cage;
        cageform_report report;
        cageform_coordinates* coordinates = NULL;
        size_t faults = 7;
        memset(&drawing, 0, sizeof drawing);
        memset(&options, 0, sizeof options);
        memset(&cage, 0, sizeof cage);
        drawing.size = sizeof drawing;
        drawing.points =
            n == 0 ? points_of(square, 4, CAGEFORM_FLOAT, 2) : points_of(cube, 8, CAGEFORM_DOUBLE, 3);
        drawing.indices = n == 0 ? segments : triangles;
        drawing.index_count = n == 0 ? 8 : 36;
        if (n == 0) {
            drawing.radii = radii;
            drawing.areas = areas;
            drawing.area_count = 1;
        }
        options.size = sizeof options;
        options.shape = CAGEFORM_SHAPE_BOX;
        cage.size = sizeof cage;
        report.size = sizeof report;
        CHECK(cageform_make_cage(&drawing, &options, NULL, &made, &report) == CAGEFORM_OK);
        CHECK(report.vertices == (n == 0 ? 4u : 8u) && report.clearance > 0);
        CHECK(cageform_made_cage_describe(made, &cage) == CAGEFORM_OK);
        CHECK(cage.vertices.count == report.vertices);
        CHECK(cageform_check(&cage, NULL, 0, &faults) == CAGEFORM_OK && faults == 0);
        CHECK(cageform_coordinates_create(&cage, NULL, &coordinates, &report) == CAGEFORM_OK);
        cageform_free(coordinates);
        cageform_free(made);
    }
}

/* A strip that bends at a hinge: 22 vertices, 20 faces, 6 frames. */
enum { STRIP = 22, STRIP_FRAMES = 6, STRIP_BONES = 2, STRIP_NODES = STRIP_FRAMES * STRIP_BONES };
typedef struct strip {
    float rest[STRIP][4]; /* the fourth number is none of the place */
    double frames[STRIP_FRAMES][STRIP][3];
    uint32_t faces[20][3];
} strip;
static strip bent_strip(void) {
    strip its;
    size_t i, t;
    memset(&its, 0, sizeof its);
    for (i = 0; i < STRIP; ++i) {
        const double x = (double)(i / 2), y = (double)(i % 2);
        its.rest[i][0] = (float)x;
        its.rest[i][1] = (float)y;
        for (t = 0; t < STRIP_FRAMES; ++t) {
            const double angle = 0.2 * (double)t, beyond = x > 5 ? x - 5 : 0;
            its.frames[t][i][0] = x - beyond + cos(angle) * beyond;
            its.frames[t][i][1] = y;
            its.frames[t][i][2] = sin(angle) * beyond;
        }
        if (i >= 2) {
            its.faces[i - 2][0] = (uint32_t)(i - 2);
            its.faces[i - 2][1] = (uint32_t)(i - 1);
            its.faces[i - 2][2] = (uint32_t)i;
        }
    }
    return its;
}
static cageform_points strip_rest(const strip* its) {
    cageform_points points = points_of(its->rest, STRIP, CAGEFORM_FLOAT, 3);
    points.stride = sizeof its->rest[0];
    points.bytes = sizeof its->rest;
    return points;
}
static cageform_points strip_frames(const strip* its) {
    return points_of(its->frames, (size_t)STRIP * STRIP_FRAMES, CAGEFORM_DOUBLE, 3);
}

/* out = rotation(scale * axes(v)) + translation, with quaternions x y z w. */
static void turn(const double* q, const double* v, double* out) {
    double u[3];
    size_t k;
    for (k = 0; k < 3; ++k) {
        const size_t a = (k + 1) % 3, b = (k + 2) % 3;
        u[k] = 2 * (q[a] * v[b] - q[b] * v[a]);
    }
    for (k = 0; k < 3; ++k) {
        const size_t a = (k + 1) % 3, b = (k + 2) % 3;
        out[k] = v[k] + q[3] * u[k] + q[a] * u[b] - q[b] * u[a];
    }
}

/* Skeletons of every kind: their arrays and their transforms put vertices where the frames have them. */
static void test_skeletons(void) {
    strip its = bent_strip();
    cageform_skeleton_options options;
    uint32_t kind;
    memset(&options, 0, sizeof options);
    options.size = sizeof options;
    options.bones = STRIP_BONES;
    options.influences = 2;
    for (kind = CAGEFORM_RIGID; kind <= CAGEFORM_STRETCHED; ++kind) {
        counts told = {0, 0, 0, 0};
        cageform_running running = running_of(&told);
        cageform_skeleton* skeleton = NULL;
        cageform_skeleton_info info;
        cageform_report report;
        double translations[STRIP_NODES][3], rotations[STRIP_NODES][4], axes[STRIP_NODES][4];
        float scales[STRIP_NODES][3];
        const cageform_output to_scales = output_of(scales, STRIP_NODES, CAGEFORM_FLOAT, 3),
                              to_axes = output_of(axes, STRIP_NODES, CAGEFORM_DOUBLE, 4);
        size_t t, i, k;
        memset(axes, 0, sizeof axes);
        for (i = 0; i < STRIP_NODES; ++i) axes[i][3] = scales[i][0] = scales[i][1] = scales[i][2] = 1;
        options.kind = kind;
        report.size = sizeof report;
        info.size = sizeof info;
        CHECK(cageform_fit_skeleton(strip_rest(&its), strip_frames(&its), its.faces[0], 60, &options,
                                    &running, &skeleton, &report) == CAGEFORM_OK);
        CHECK(told.loops > 0 && told.done == 1 && report.message[0] == 0);
        CHECK(report.bones == STRIP_BONES && report.frame < STRIP_FRAMES && report.culprit < STRIP);
        CHECK(report.max_distance < 1e-4 && report.rms <= report.max_distance && report.beyond == 0);
        CHECK(report.mean_influences >= 1 && report.mean_influences <= 2 && report.turn < 0.1);
        CHECK(report.seconds >= 0);
        CHECK(cageform_skeleton_describe(skeleton, &info) == CAGEFORM_OK);
        CHECK(info.bones == STRIP_BONES && info.frames == STRIP_FRAMES && info.vertices == STRIP &&
              info.influences == 2);
        CHECK(info.parents[0] == UINT32_MAX && info.parents[1] == 0);
        CHECK(fabs(info.joints[3] - 5) < 1e-2); /* the hinge */
        CHECK(cageform_skeleton_transforms(skeleton, output_of(translations, STRIP_NODES, CAGEFORM_DOUBLE, 3),
                                           output_of(rotations, STRIP_NODES, CAGEFORM_DOUBLE, 4),
                                           kind == CAGEFORM_RIGID ? NULL : &to_scales,
                                           kind == CAGEFORM_STRETCHED ? &to_axes : NULL) == CAGEFORM_OK);
        for (t = 0; t < STRIP_FRAMES; ++t) {
            for (i = 0; i < STRIP; ++i) {
                double mapped[3] = {0, 0, 0}, played[3] = {0, 0, 0}, square = 0;
                size_t w;
                for (w = 2 * i; w < 2 * i + 2; ++w) {
                    const size_t own = info.vertex_bones[w];
                    const double* map = info.maps + 12 * (t * STRIP_BONES + own);
                    double place[3], turned[3];
                    uint32_t bone;
                    for (k = 0; k < 3; ++k) {
                        mapped[k] += info.weights[w] *
                                     (its.rest[i][0] * map[k] + its.rest[i][1] * map[3 + k] + map[9 + k]);
                        place[k] = its.rest[i][k] - info.joints[3 * own + k];
                    }
                    for (bone = (uint32_t)own; bone != UINT32_MAX; bone = info.parents[bone]) {
                        const size_t n = t * STRIP_BONES + bone;
                        turn(axes[n], place, turned);
                        for (k = 0; k < 3; ++k) turned[k] *= scales[n][k];
                        turn(rotations[n], turned, place);
                        for (k = 0; k < 3; ++k) place[k] += translations[n][k];
                    }
                    for (k = 0; k < 3; ++k) played[k] += info.weights[w] * place[k];
                }
                for (k = 0; k < 3; ++k) {
                    CHECK(fabs(played[k] - mapped[k]) < 1e-5); /* scales are floats */
                    square += (mapped[k] - its.frames[t][i][k]) * (mapped[k] - its.frames[t][i][k]);
                }
                CHECK(sqrt(square) < report.max_distance * sqrt(101) + 1e-9); /* the strip's diagonal */
                CHECK(fabs(info.weights[2 * i] + info.weights[2 * i + 1] - 1) < 1e-6);
            }
        }
        if (kind > CAGEFORM_RIGID) /* it has scales */
            CHECK(cageform_skeleton_transforms(skeleton,
                                               output_of(translations, STRIP_NODES, CAGEFORM_DOUBLE, 3),
                                               output_of(rotations, STRIP_NODES, CAGEFORM_DOUBLE, 4), NULL,
                                               NULL) == CAGEFORM_ARGUMENT_NULL);
        CHECK(cageform_skeleton_transforms(skeleton,
                                           output_of(translations, STRIP_NODES - 1, CAGEFORM_DOUBLE, 3),
                                           output_of(rotations, STRIP_NODES, CAGEFORM_DOUBLE, 4), &to_scales,
                                           &to_axes) == CAGEFORM_OUTPUT_TOO_SMALL);
        CHECK(cageform_skeleton_transforms(skeleton, output_of(translations, STRIP_NODES, CAGEFORM_DOUBLE, 3),
                                           output_of(rotations, STRIP_NODES, CAGEFORM_DOUBLE, 3), &to_scales,
                                           &to_axes) == CAGEFORM_DIMENSION_DIFFERS);
        cageform_free(skeleton);
    }
}

/* Motions that cannot be fitted are refused, with the place. */
static void test_skeleton_refusals(void) {
    strip its = bent_strip();
    const cageform_points rest = strip_rest(&its), frames = strip_frames(&its);
    cageform_points bad;
    cageform_skeleton_options options;
    cageform_skeleton* none = NULL;
    cageform_skeleton_info info;
    cageform_report report;
    counts told = {0, 0, 1, 0};
    cageform_running running = running_of(&told);
    const uint32_t* const faces = its.faces[0];
    memset(&options, 0, sizeof options);
    report.size = sizeof report;
    info.size = sizeof info;
    CHECK(cageform_fit_skeleton(rest, frames, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_SIZE_NOT_SET);
    options.size = sizeof options;
    CHECK(cageform_fit_skeleton(rest, frames, faces, 60, NULL, NULL, &none, &report) ==
          CAGEFORM_BONES_NOT_SUPPORTED);
    CHECK(cageform_fit_skeleton(rest, frames, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_BONES_NOT_SUPPORTED);
    options.bones = 2;
    CHECK(cageform_fit_skeleton(rest, frames, faces, 60, &options, NULL, NULL, &report) ==
          CAGEFORM_ARGUMENT_NULL);
    CHECK(cageform_fit_skeleton(rest, frames, NULL, 60, &options, NULL, &none, &report) ==
          CAGEFORM_ARGUMENT_NULL);
    CHECK(cageform_fit_skeleton(rest, frames, faces, 59, &options, NULL, &none, &report) ==
          CAGEFORM_COUNTS_DO_NOT_MATCH);
    options.kind = 3;
    CHECK(cageform_fit_skeleton(rest, frames, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_CHOICE_UNKNOWN);
    options.kind = CAGEFORM_RIGID;
    options.influences = 9;
    CHECK(cageform_fit_skeleton(rest, frames, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_INFLUENCES_NOT_SUPPORTED);
    options.influences = 0;
    options.max_distance = -1;
    CHECK(cageform_fit_skeleton(rest, frames, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_VALUE_NOT_FINITE);
    options.max_distance = 0;
    bad = frames;
    bad.count -= 1;
    CHECK(cageform_fit_skeleton(rest, bad, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_FRAMES_DO_NOT_MATCH);
    bad.count = STRIP;
    CHECK(cageform_fit_skeleton(rest, bad, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_MOTION_EMPTY);
    bad = rest;
    bad.count = 0;
    CHECK(cageform_fit_skeleton(bad, frames, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_MOTION_EMPTY);
    bad = frames;
    bad.count += STRIP;
    CHECK(cageform_fit_skeleton(rest, bad, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_POINTS_LEAVE_MEMORY);
    bad = rest;
    bad.dimension = 2;
    CHECK(cageform_fit_skeleton(bad, frames, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_DIMENSION_DIFFERS);
    its.faces[7][2] = STRIP;
    CHECK(cageform_fit_skeleton(rest, frames, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_FACE_WITHOUT_VERTEX);
    CHECK(strstr(report.message, "(face 7)") != NULL);
    its.faces[7][2] = 0;
    its.frames[3][4][1] = NAN;
    CHECK(cageform_fit_skeleton(rest, frames, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_FRAME_NOT_FINITE);
    CHECK(report.frame == 3 && report.culprit == 4 && strstr(report.message, "(frame 3, vertex 4)") != NULL);
    its.frames[3][4][1] = 0;
    its.rest[5][0] = INFINITY;
    CHECK(cageform_fit_skeleton(rest, frames, faces, 60, &options, NULL, &none, &report) ==
          CAGEFORM_FRAME_NOT_FINITE);
    CHECK(report.frame == CAGEFORM_NONE && report.culprit == 5 &&
          strstr(report.message, "(vertex 5)") != NULL);
    its.rest[5][0] = 2;
    CHECK(cageform_fit_skeleton(rest, frames, faces, 60, &options, &running, &none, &report) ==
          CAGEFORM_CANCELLED);
    CHECK(none == NULL && told.steps == 1);
    CHECK(cageform_skeleton_describe(NULL, &info) == CAGEFORM_ARGUMENT_NULL);
    CHECK(cageform_fit_skeleton(rest, frames, NULL, 0, &options, NULL, &none, NULL) == CAGEFORM_OK);
    CHECK(cageform_skeleton_describe(none, NULL) == CAGEFORM_ARGUMENT_NULL);
    CHECK(cageform_skeleton_describe((const cageform_skeleton*)(const void*)&running, &info) ==
          CAGEFORM_OBJECT_OF_ANOTHER_KIND);
    cageform_free(none);
}

/* A ball of points around two poles: 138 vertices, 272 faces. */
enum { SEGMENTS = 17, RINGS = 8, BALL = 2 + SEGMENTS * RINGS, BALL_FACES = 2 * SEGMENTS * RINGS };
typedef struct ball {
    double vertices[BALL][3];
    uint32_t faces[BALL_FACES][3];
} ball;
static ball scaled_ball(double x, double y, double z) {
    const double pi = 3.14159265358979;
    ball its;
    uint32_t i, ring, segment, face = 0;
    for (i = 0; i < BALL; ++i) {
        const double across = i == 0 ? 0 : i == BALL - 1 ? pi : pi * ((i - 1) / SEGMENTS + 1) / (RINGS + 1);
        const double around = 2 * pi * ((i + SEGMENTS - 1) % SEGMENTS) / SEGMENTS;
        its.vertices[i][0] = x * sin(across) * cos(around);
        its.vertices[i][1] = y * sin(across) * sin(around);
        its.vertices[i][2] = z * cos(across);
    }
    for (ring = 0; ring <= RINGS; ++ring) {
        for (segment = 0; segment < SEGMENTS; ++segment) {
            const uint32_t next = (segment + 1) % SEGMENTS, below = 1 + ring * SEGMENTS;
            const uint32_t a = ring == 0 ? 0 : below - SEGMENTS + segment,
                           b = ring == 0 ? 0 : below - SEGMENTS + next,
                           c = ring == RINGS ? BALL - 1 : below + segment,
                           d = ring == RINGS ? BALL - 1 : below + next;
            if (ring < RINGS) {
                its.faces[face][0] = a;
                its.faces[face][1] = c;
                its.faces[face++][2] = d;
            }
            if (ring > 0) {
                its.faces[face][0] = a;
                its.faces[face][1] = d;
                its.faces[face++][2] = b;
            }
        }
    }
    return its;
}
static cageform_drawing ball_drawing(const ball* its) {
    cageform_drawing drawing;
    memset(&drawing, 0, sizeof drawing);
    drawing.size = sizeof drawing;
    drawing.points = points_of(its->vertices, BALL, CAGEFORM_DOUBLE, 3);
    drawing.indices = its->faces[0];
    drawing.index_count = 3 * (size_t)BALL_FACES;
    return drawing;
}

/* Moves points by a binding to coordinates, and compares them with those of a wrap. */
static void check_pose(const cageform_coordinates* coordinates, const double* points, size_t count,
                       cageform_points pose, const double* wanted, double tolerance) {
    cageform_binding* binding = NULL;
    cageform_figure* figure = NULL;
    double out[3 * BALL];
    float rounded[3 * BALL];
    size_t n;
    CHECK(cageform_bind(coordinates, points_of(points, count, CAGEFORM_DOUBLE, 3), NULL, NULL, NULL, NULL,
                        &binding, NULL) == CAGEFORM_OK);
    CHECK(cageform_binding_figure(binding, &figure) == CAGEFORM_OK);
    CHECK(cageform_clone(figure, pose,
                         pose.scalar == CAGEFORM_DOUBLE ? output_of(out, count, CAGEFORM_DOUBLE, 3)
                                                        : output_of(rounded, count, CAGEFORM_FLOAT, 3),
                         NULL, NULL, NULL) == CAGEFORM_OK);
    for (n = 0; n < 3 * count; ++n)
        CHECK(fabs((pose.scalar == CAGEFORM_DOUBLE ? out[n] : (double)rounded[n]) - wanted[n]) < tolerance);
    cageform_free(figure);
    cageform_free(binding);
}

/* A spheroid is wrapped onto an ellipsoid by a lattice, and by a cage; another ball around it follows. */
static void test_wraps(void) {
    const ball source = scaled_ball(0.2, 0.2, 1), target = scaled_ball(0.15, 0.25, 1.2),
               coat = scaled_ball(0.23, 0.23, 1.1);
    const cageform_drawing from = ball_drawing(&source), to = ball_drawing(&target);
    const cageform_landmark top = {{0, 0, 1}, {0, 0, 1.2}, 0};
    cageform_coordinates *coordinates = coordinates_of(cube_cage(), CAGEFORM_MEAN_VALUE, CAGEFORM_FLOAT),
                         *lattice = NULL;
    cageform_coordinates_options splines;
    cageform_wrap_options options;
    cageform_wrap* wrap = NULL;
    cageform_wrap_info info;
    cageform_report report;
    counts its = {0, 0, 3, 0};
    cageform_running running = running_of(&its);
    double moved[BALL][3], first[BALL][3], jacobians[BALL][9], aside[BALL][3];
    cageform_output to_jacobians = output_of(jacobians, BALL, CAGEFORM_DOUBLE, 9);
    const double step_size = 1e-6;
    size_t n, k, j, inside_target = 0;
    memset(&options, 0, sizeof options);
    memset(&splines, 0, sizeof splines);
    options.size = sizeof options;
    options.landmarks = &top;
    options.landmark_count = 1;
    options.follow = points_of(coat.vertices, BALL, CAGEFORM_DOUBLE, 3);
    options.finest = 12;
    splines.size = sizeof splines;
    splines.type = CAGEFORM_SPLINES;
    splines.scalar = CAGEFORM_DOUBLE;
    report.size = sizeof report;
    info.size = sizeof info;
    CHECK(cageform_fit_wrap(NULL, &from, &to, &options, &running, &wrap, &report) == CAGEFORM_CANCELLED);
    CHECK(wrap == NULL && its.steps == 3);
    CHECK(cageform_fit_wrap(NULL, &from, &to, &options, NULL, &wrap, &report) == CAGEFORM_OK);
    CHECK(report.to_target_upper < 0.01 && report.to_source_upper < 0.01 && report.start > 0.01);
    CHECK(fabs(report.height - 2.4) < 1e-6 && report.miss < 0.02 && report.culprit == 0);
    CHECK(report.iterations > 0 && report.samples > 0 && report.folded == 0 && report.least_stretch > 0.1);
    CHECK(report.ended == CAGEFORM_ENDED_NOISE && report.noise > 1e-3); /* its faces are large */
    CHECK(report.unmatched_source < 0.1 && report.seconds >= 0);
    CHECK(cageform_wrap_move(wrap, points_of(coat.vertices, BALL, CAGEFORM_DOUBLE, 3),
                             output_of(moved, BALL, CAGEFORM_DOUBLE, 3), &to_jacobians, NULL) == CAGEFORM_OK);
    for (n = 0; n < BALL; ++n) {
        const double x = moved[n][0] / 0.15, y = moved[n][1] / 0.25, z = moved[n][2] / 1.2;
        inside_target += x * x + y * y + z * z < 1;
    }
    CHECK(inside_target == 0);
    for (k = 0; k < 3; ++k) { /* the Jacobians are the derivatives of the map */
        for (n = 0; n < BALL; ++n) {
            memcpy(aside[n], coat.vertices[n], sizeof aside[n]);
            aside[n][k] += step_size;
        }
        CHECK(cageform_wrap_move(wrap, points_of(aside, BALL, CAGEFORM_DOUBLE, 3),
                                 output_of(aside, BALL, CAGEFORM_DOUBLE, 3), NULL, NULL) == CAGEFORM_OK);
        for (n = 0; n < BALL; ++n) {
            for (j = 0; j < 3; ++j)
                CHECK(fabs((aside[n][j] - moved[n][j]) / step_size - jacobians[n][3 * k + j]) < 1e-4);
        }
    }
    /* The described lattice is the map. */
    CHECK(cageform_wrap_describe(wrap, &info) == CAGEFORM_OK);
    CHECK(info.lattice != NULL && info.lattice->kind == CAGEFORM_LATTICE && info.pose.count == 0);
    CHECK(info.lattice_pose.count ==
          (size_t)info.lattice->points[0] * info.lattice->points[1] * info.lattice->points[2]);
    for (n = 0; n < BALL; ++n) {
        for (j = 0; j < 3; ++j) {
            first[n][j] = info.first[9 + j];
            for (k = 0; k < 3; ++k) first[n][j] += coat.vertices[n][k] * info.first[3 * k + j];
        }
    }
    CHECK(cageform_coordinates_create(info.lattice, &splines, &lattice, NULL) == CAGEFORM_OK);
    check_pose(lattice, first[0], BALL, info.lattice_pose, moved[0], 1e-9);
    cageform_free(lattice);
    cageform_free(wrap);

    options.finest = 6; /* the cage alone */
    options.follow.count = 0;
    CHECK(cageform_fit_wrap(coordinates, &from, &to, &options, NULL, &wrap, &report) == CAGEFORM_OK);
    CHECK(report.to_target_upper < 0.05 && report.start > 0.01);
    CHECK(cageform_wrap_describe(wrap, &info) == CAGEFORM_OK);
    CHECK(info.lattice == NULL && info.lattice_pose.count == 0 && info.pose.count == 8);
    CHECK(cageform_wrap_move(wrap, points_of(source.vertices, BALL, CAGEFORM_DOUBLE, 3),
                             output_of(moved, BALL, CAGEFORM_DOUBLE, 3), NULL, NULL) == CAGEFORM_OK);
    check_pose(coordinates, source.vertices[0], BALL, info.pose, moved[0], 1e-5);
    CHECK(cageform_wrap_describe(wrap, NULL) == CAGEFORM_ARGUMENT_NULL);
    CHECK(cageform_wrap_describe((const cageform_wrap*)(const void*)coordinates, &info) ==
          CAGEFORM_OBJECT_OF_ANOTHER_KIND);
    CHECK(cageform_wrap_move(NULL, from.points, output_of(moved, BALL, CAGEFORM_DOUBLE, 3), NULL, NULL) ==
          CAGEFORM_ARGUMENT_NULL);
    cageform_free(coordinates);
    cageform_free(wrap);
}

/* Pins: one end of a square stays, the other goes up. */
static void test_pins(void) {
    const uint32_t chosen[2] = {0, 2}, held[1] = {0}, far[1] = {9};
    const float targets[4] = {1, 1, 3, 2};
    const double weights[2] = {1, 2};
    float pose[8], out[10];
    cageform_coordinates* coordinates = coordinates_of(square_cage(), CAGEFORM_MEAN_VALUE, CAGEFORM_FLOAT);
    cageform_binding* binding = NULL;
    cageform_figure* figure = NULL;
    cageform_samples *samples = NULL, *opened = NULL, *none = NULL;
    cageform_samples_info info;
    cageform_bytes* packed = NULL;
    const void* data = NULL;
    size_t bytes = 0;
    cageform_pins* pins = NULL;
    cageform_samples_options sampling;
    cageform_pins_options options;
    cageform_report report;
    int frame;
    memset(&sampling, 0, sizeof sampling);
    memset(&options, 0, sizeof options);
    sampling.size = sizeof sampling;
    sampling.samples = 500;
    options.size = sizeof options;
    report.size = sizeof report;
    CHECK(cageform_bind(coordinates, points_of(inside, 5, CAGEFORM_FLOAT, 2), NULL, NULL, NULL, NULL,
                        &binding, NULL) == CAGEFORM_OK);
    CHECK(cageform_binding_figure(binding, &figure) == CAGEFORM_OK);
    CHECK(cageform_pose_samples(coordinates, &sampling, NULL, &samples, &report) == CAGEFORM_OK);
    CHECK(report.samples > 400 && report.rotations > 0);
    CHECK(cageform_samples_pack(samples, &packed, &report) == CAGEFORM_OK);
    CHECK(cageform_bytes_view(packed, &data, &bytes) == CAGEFORM_OK && bytes == report.bytes);
    CHECK(cageform_samples_open(data, bytes, 0, &opened) == CAGEFORM_OK);
    CHECK(cageform_samples_open(data, bytes - 64, 0, &none) == CAGEFORM_BLOB_TRUNCATED && none == NULL);
    info.size = sizeof info;
    CHECK(cageform_samples_describe(opened, &info) == CAGEFORM_OK && info.handles == 4 &&
          info.dimension == 2);
    CHECK(cageform_pins_create(opened, &options, &pins) == CAGEFORM_OK);
    CHECK(cageform_pins_set(pins, figure, far, 1, NULL, &report) == CAGEFORM_INDEX_OUT_OF_RANGE);
    CHECK(report.culprit == 0 && strlen(report.message) > 0);
    CHECK(cageform_pins_set(pins, figure, chosen, 2, weights, &report) == CAGEFORM_OK);
    CHECK(cageform_pins_hold(pins, far, 1, &report) == CAGEFORM_INDEX_OUT_OF_RANGE);
    CHECK(cageform_pins_hold(pins, held, 0, &report) == CAGEFORM_OK);
    memcpy(pose, square, sizeof square);
    for (frame = 0; frame < 100; ++frame) {
        CHECK(cageform_pins_solve(pins, points_of(targets, 2, CAGEFORM_FLOAT, 2),
                                  output_of(pose, 4, CAGEFORM_FLOAT, 2), &report) == CAGEFORM_OK);
        if (report.settled) break;
    }
    CHECK(report.settled && report.miss < 0.01);
    CHECK(cageform_clone(figure, points_of(pose, 4, CAGEFORM_FLOAT, 2), output_of(out, 5, CAGEFORM_FLOAT, 2),
                         NULL, NULL, NULL) == CAGEFORM_OK);
    CHECK(fabs(out[4] - 3.0) < 0.02 && fabs(out[5] - 2.0) < 0.02);
    cageform_free(pins);
    cageform_free(opened);
    cageform_free(packed);
    cageform_free(samples);
    cageform_free(figure);
    cageform_free(binding);
    cageform_free(coordinates);
}

/* Wrong arguments are refused, each by its name. */
static void test_refusals(void) {
    cageform_cage cage = square_cage();
    cageform_coordinates* coordinates = coordinates_of(cage, CAGEFORM_MEAN_VALUE, CAGEFORM_FLOAT);
    cageform_coordinates* none = NULL;
    cageform_coordinates_options options;
    cageform_report report;
    cageform_fault fault[2];
    cageform_binding* binding = NULL;
    cageform_points points = points_of(inside, 5, CAGEFORM_FLOAT, 2), bad;
    float crossing[8] = {0, 0, 4, 4, 4, 0, 0, 4};
    size_t count = 0;
    counts its = {0, 0, 1, 0};
    cageform_running running = running_of(&its);
    report.size = sizeof report;
    memset(&options, 0, sizeof options);
    CHECK(cageform_coordinates_create(&cage, &options, &none, &report) == CAGEFORM_SIZE_NOT_SET &&
          none == NULL);
    options.size = sizeof options;
    options.type = 99;
    CHECK(cageform_coordinates_create(&cage, &options, &none, &report) == CAGEFORM_CHOICE_UNKNOWN);
    options.type = CAGEFORM_SPLINES;
    CHECK(cageform_coordinates_create(&cage, &options, &none, &report) == CAGEFORM_CAGE_KIND_NOT_SUPPORTED);
    cage.vertices = points_of(crossing, 4, CAGEFORM_FLOAT, 2);
    CHECK(cageform_coordinates_create(&cage, NULL, &none, &report) == CAGEFORM_CAGE_SELF_CROSSING);
    CHECK(report.faults == 1 && report.fault.a_is == CAGEFORM_EDGE);
    CHECK(strstr(report.message, "edge 0") != NULL);
    CHECK(cageform_check(&cage, fault, 2, &count) == CAGEFORM_CAGE_SELF_CROSSING && count == 1);
    CHECK(fault[0].status == CAGEFORM_CAGE_SELF_CROSSING);
    CHECK(cageform_coordinates_create(NULL, NULL, &none, NULL) == CAGEFORM_ARGUMENT_NULL);

    CHECK(cageform_bind(NULL, points, NULL, NULL, NULL, NULL, &binding, NULL) == CAGEFORM_ARGUMENT_NULL);
    bad = points;
    bad.bytes = 39;
    CHECK(cageform_bind(coordinates, bad, NULL, NULL, NULL, NULL, &binding, NULL) ==
          CAGEFORM_POINTS_LEAVE_MEMORY);
    bad = points;
    bad.count = (size_t)-1;
    CHECK(cageform_bind(coordinates, bad, NULL, NULL, NULL, NULL, &binding, NULL) ==
          CAGEFORM_POINTS_LEAVE_MEMORY);
    bad = points;
    bad.data = (const char*)points.data + 1;
    CHECK(cageform_bind(coordinates, bad, NULL, NULL, NULL, NULL, &binding, NULL) ==
          CAGEFORM_POINTS_MISALIGNED);
    bad = points;
    bad.dimension = 3;
    CHECK(cageform_bind(coordinates, bad, NULL, NULL, NULL, NULL, &binding, NULL) ==
          CAGEFORM_DIMENSION_DIFFERS);
    CHECK(cageform_bind(coordinates, points, NULL, NULL, NULL, &running, &binding, &report) ==
          CAGEFORM_CANCELLED);
    CHECK(binding == NULL && strcmp(report.message, cageform_status_text(CAGEFORM_CANCELLED)) == 0);
    CHECK(cageform_open(inside, sizeof inside, NULL, (cageform_figure**)&none, NULL) != CAGEFORM_OK);
    CHECK(cageform_figure_describe((const cageform_figure*)(const void*)coordinates, NULL) ==
          CAGEFORM_OBJECT_OF_ANOTHER_KIND);
    CHECK(strcmp(cageform_status_name(CAGEFORM_CAGE_SELF_CROSSING), "cage_self_crossing") == 0);
    CHECK(strcmp(cageform_status_text(4711), "unknown status") == 0);
    CHECK(cageform_abi_version() == CAGEFORM_C_ABI && strlen(cageform_version()) > 0);
    cageform_free(coordinates);
}

#if defined(CALLS_MAIN)
int CALLS_MAIN(void);
int CALLS_MAIN(void) {
#else
int main(void) {
#endif
    static const int corners[6] = {0, 1, 2, 0, 2, 3};
    size_t f, n;
    for (f = 0; f < 6; ++f) {
        for (n = 0; n < 6; ++n) triangles[6 * f + n] = quads[4 * f + (size_t)corners[n]];
    }
    test_square();
    test_types();
    test_locality();
    test_cells_and_blends();
    test_normals();
    test_made_cages();
    test_skeletons();
    test_skeleton_refusals();
    test_wraps();
    test_pins();
    test_refusals();
    if (failures == 0) puts("all is well");
    return failures == 0 ? 0 : 1;
}
