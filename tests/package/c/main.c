/* A C99 program of the installed package: binds points of a square, moves them, packs and opens them. */
#include <cageform/c/cageform.h>

#include <stdio.h>
#include <string.h>

static const double square[8] = {0, 0, 4, 0, 4, 4, 0, 4}, inside[4] = {1, 1, 3, 2};

static cageform_points points_of(const double* numbers, size_t count) {
    cageform_points points = {0};
    points.data = numbers;
    points.count = count;
    points.bytes = 2 * count * sizeof(double);
    points.scalar = CAGEFORM_DOUBLE;
    points.dimension = 2;
    return points;
}
static cageform_output output_of(double* numbers, size_t count) {
    cageform_output output = {0};
    output.data = numbers;
    output.count = count;
    output.bytes = 2 * count * sizeof(double);
    output.scalar = CAGEFORM_DOUBLE;
    output.dimension = 2;
    return output;
}

int main(void) {
    cageform_cage cage = {0};
    cageform_coordinates_options options = {0};
    cageform_coordinates* coordinates = NULL;
    cageform_binding* binding = NULL;
    cageform_bytes* packed = NULL;
    cageform_figure* figure = NULL;
    const void* data = NULL;
    size_t bytes = 0;
    double moved[4];
    int failures = 0;

    cage.size = sizeof cage;
    cage.kind = CAGEFORM_POLYGON;
    cage.vertices = points_of(square, 4);
    options.size = sizeof options;
    options.scalar = CAGEFORM_DOUBLE;
    failures += cageform_abi_version() != CAGEFORM_C_ABI;
    failures += cageform_coordinates_create(&cage, &options, &coordinates, NULL) != CAGEFORM_OK;
    failures += cageform_bind(coordinates, points_of(inside, 2), NULL, NULL, NULL, NULL, &binding, NULL) !=
                CAGEFORM_OK;
    failures += cageform_pack(binding, NULL, NULL, &packed, NULL) != CAGEFORM_OK;
    failures += cageform_bytes_view(packed, &data, &bytes) != CAGEFORM_OK;
    failures += cageform_open(data, bytes, NULL, &figure, NULL) != CAGEFORM_OK;
    failures +=
        cageform_clone(figure, points_of(square, 4), output_of(moved, 2), NULL, NULL, NULL) != CAGEFORM_OK;
    failures += memcmp(moved, inside, sizeof inside) != 0; /* at rest to the bit */
    failures +=
        cageform_free(figure) + cageform_free(packed) + cageform_free(binding) + cageform_free(coordinates);
    printf("cageform %s: %d failures\n", cageform_version(), failures);
    return failures != 0;
}
