// The clone operator on the GPU: GLSL code that reads a blob, or the joints and weights of a skin.
//
// Upload the bytes of a blob once, as a storage buffer. Upload the result of `write_displacements` every
// frame, `displacement_count` vec4s. A compute shader then writes all points:
//
//     #version 430                         (or 310 es)
//     #define CAGEFORM_BLOB 0              bindings of the buffers: the blob,
//     #define CAGEFORM_DISPLACEMENTS 1     the result of write_displacements,
//     #define CAGEFORM_OUT 2               the points, as floats
//     #define CAGEFORM_OUT_STRIDE 6        floats per point; default: the dimension
//     #define CAGEFORM_OUT_OFFSET 0        floats before the first point; default: 0
//     #define CAGEFORM_BASE 0u             the four-byte word at which the blob begins; default: 0u
//     #define CAGEFORM_TANGENTS 1000u      for normals: the words at which the blobs of tangents
//     #define CAGEFORM_BITANGENTS 2000u    and bitangents begin,
//     #define CAGEFORM_NORMAL_OFFSET 3     and the floats before the first normal
//     glsl::displacements, glsl::blob, glsl::compute     in this order; one thread per point, 64 per group
//
// Other shaders can call the functions of `blob`: cageform_displacement, cageform_rest, cageform_point,
// cageform_normal. Their argument `place` is the position of a point in the blob's order. A vertex shader of
// a skin (binding/skin_weights.hpp) needs no blob:
//
//     #define CAGEFORM_UNIFORM_HANDLES 112 number of vec4s in a uniform block of displacements, needed in
//                                          WebGL 2 (#version 300 es); default: a storage buffer
//     glsl::displacements, glsl::skin
//     … gl_Position = view * vec4(rest + cageform_skin(joints, weights), 1) …
//
// The code has no #version, and no main except in `compute`. All names begin with cageform_.
#pragma once

#include <cageform/clone/clone.hpp>
#include <cageform/figure/types/blob.hpp>

#include <array>

namespace cageform::inline CAGEFORM_ABI {

/// Returns the number of entries that `write_displacements` writes.
template <std::size_t D>
constexpr std::size_t displacement_count(const PackedBindingView<float, D>& binding) noexcept {
    return binding.handle_count() + D + 1;
}

/// Writes the data that shaders read every frame: the displacements of the handles, then their best affine
/// fit, each as a vec4 (std140 and std430). One result serves all bindings to the same cage.
///
///   out      at least displacement_count() entries, write-only: may be a mapped buffer
///   returns  pose_size_differs, pose_not_finite, output_too_small (`out` is then untouched), or ok
///   cost     O(#handles); no allocation
template <std::size_t D, PointRangeIn<D> Pose>
    requires(D <= 3)
Status write_displacements(const PackedBindingView<float, D>& binding, const Pose& pose,
                           std::span<std::array<float, 4>> out) noexcept {
    if (out.size() < displacement_count(binding)) return Status::output_too_small;
    const Status status = detail::check_pose(binding, pose);
    if (status != Status::ok) return status;
    const detail::PoseDisplacements<float, D, Pose> displacement{binding.rest_handles, pose};
    const auto write = [&out](std::size_t index, const Vec<float, D>& v) {
        std::array<float, 4> padded{};
        for (std::size_t k = 0; k < D; ++k) padded[k] = v[k];
        out[index] = padded;
    };
    for (std::size_t i = 0; i < binding.handle_count(); ++i) write(i, displacement(i));
    const detail::AffineFit<float, D> fit(binding, displacement);
    for (std::size_t r = 0; r <= D; ++r) write(binding.handle_count() + r, fit.rows[r]);
    return Status::ok;
}

namespace glsl {

/// The buffer of displacements.
inline constexpr const char* displacements = R"(
#ifdef CAGEFORM_UNIFORM_HANDLES
#if __VERSION__ == 300 // WebGL 2: the program sets the binding by uniformBlockBinding
layout(std140) uniform CageformDisplacements {
#else
layout(std140, binding = CAGEFORM_DISPLACEMENTS) uniform CageformDisplacements {
#endif
    highp vec4 cageform_displacements[CAGEFORM_UNIFORM_HANDLES];
};
#else
layout(std430, binding = CAGEFORM_DISPLACEMENTS) readonly buffer CageformDisplacements {
    highp vec4 cageform_displacements[];
};
#endif
)";

/// Functions that read blobs (figure/types/blob.hpp) of float, of at most 16 GiB. `base` is the four-byte
/// word of the buffer at which a blob begins; a buffer may hold several blobs. If all blobs have the same
/// format or dimension, these definitions may make a shader faster:
///
///     #define CAGEFORM_FORMAT 0u       the value of a WeightFormat
///     #define CAGEFORM_DIMENSION 3u
inline constexpr const char* blob = R"(
layout(std430, binding = CAGEFORM_BLOB) readonly buffer CageformBlob {
    highp uint cageform_blob[];
};
#ifndef CAGEFORM_DIMENSION
#define CAGEFORM_DIMENSION cageform_blob[base + 9u]
#endif
#ifndef CAGEFORM_FORMAT
#define CAGEFORM_FORMAT cageform_blob[base + 10u]
#endif

// Returns the word at which a part begins. Its 64-bit offset in bytes is in a field of the header.
highp uint cageform_part(highp uint base, highp uint field) {
    return base + ((cageform_blob[base + field] >> 2) | (cageform_blob[base + field + 1u] << 30));
}

highp uint cageform_points(highp uint base) {
    return cageform_blob[base + 14u];
}

highp float cageform_weight(highp uint weights, highp uint format, highp uint row, highp uint lane) {
    if (format == 0u) return uintBitsToFloat(cageform_blob[weights + row * 16u + lane]);
    if (format == 3u) {
        highp int four = int(cageform_blob[weights + row * 4u + lane / 4u]);
        return float(bitfieldExtract(four, int(lane % 4u) * 8, 8));
    }
    highp uint two = cageform_blob[weights + row * 8u + lane / 2u];
    if (format == 2u) return float(bitfieldExtract(int(two), int(lane % 2u) * 16, 16));
    highp vec2 halves = unpackHalf2x16(two);
    return lane % 2u == 0u ? halves.x : halves.y;
}

// Returns the displacement of the point at a place.
highp vec3 cageform_displacement(highp uint base, highp uint place) {
    highp uint format = CAGEFORM_FORMAT;
    highp uint handles = cageform_blob[base + 12u], block = place / 16u, lane = place % 16u;
    highp uint first = block * handles, end = first + handles;
    bool sparse = cageform_blob[base + 24u] != 0u;
    if (sparse) {
        highp uint row_begin = cageform_part(base, 24u) + block;
        first = cageform_blob[row_begin];
        end = cageform_blob[row_begin + 1u];
    }
    highp uint weights = cageform_part(base, 22u), row_handle = cageform_part(base, 26u);
    highp vec3 sum = vec3(0.0);
    for (highp uint row = first; row < end; ++row) {
        highp uint handle = row - first;
        if (sparse) handle = (cageform_blob[row_handle + row / 2u] >> (row % 2u * 16u)) & 0xFFFFu;
        sum += cageform_weight(weights, format, row, lane) * cageform_displacements[handle].xyz;
    }
    if (format != 0u) { // the rounding errors of weights
        highp uint terms = CAGEFORM_DIMENSION + 1u;
        highp uint residual = cageform_part(base, 32u) + block * terms * 16u + lane;
        sum *= uintBitsToFloat(cageform_blob[cageform_part(base, 30u) + block]);
        for (highp uint r = 0u; r < terms; ++r)
            sum += uintBitsToFloat(cageform_blob[residual + r * 16u]) * cageform_displacements[handles + r].xyz;
    }
    return sum;
}

// Returns the bound point at a place; z is 0 in 2D.
highp vec3 cageform_rest(highp uint base, highp uint place) {
    highp uint rest = cageform_part(base, 36u) + place / 16u * CAGEFORM_DIMENSION * 16u + place % 16u;
    highp vec3 p = vec3(uintBitsToFloat(cageform_blob[rest]), uintBitsToFloat(cageform_blob[rest + 16u]), 0.0);
    if (CAGEFORM_DIMENSION == 3u) p.z = uintBitsToFloat(cageform_blob[rest + 32u]);
    return p;
}

// Returns the index of the point at a place.
highp uint cageform_point(highp uint base, highp uint place) {
    if (cageform_blob[base + 28u] == 0u) return place;
    return cageform_blob[cageform_part(base, 28u) + place];
}

bool cageform_across(highp vec3 t, highp vec3 b, out highp vec3 normal) {
    highp float t_size = max(abs(t.x), max(abs(t.y), abs(t.z))), b_size = max(abs(b.x), max(abs(b.y), abs(b.z)));
    normal = vec3(0.0);
    if (!(t_size > 0.0 && b_size > 0.0)) return false;
    t /= t_size;
    b /= b_size;
    normal = cross(t, b);
    highp float square = dot(normal, normal);
    if (!(square > 2.3e-13 * dot(t, t) * dot(b, b))) return false;
    normal *= inversesqrt(square);
    return true;
}

// Returns the normal at a place from two blobs of vectors, computed as by clone_normals.
highp vec3 cageform_normal(highp uint tangents, highp uint bitangents, highp uint place) {
    highp vec3 t = cageform_rest(tangents, place), b = cageform_rest(bitangents, place), normal, at_rest;
    if (cageform_across(t + cageform_displacement(tangents, place), b + cageform_displacement(bitangents, place), normal))
        return normal;
    return cageform_across(t, b, at_rest) ? at_rest : vec3(0.0);
}
)";

/// Writes the points of one blob, and optionally their normals, one per thread: ⌈#points / 64⌉ work groups.
inline constexpr const char* compute = R"(
layout(local_size_x = 64) in;
layout(std430, binding = CAGEFORM_OUT) writeonly buffer CageformOut {
    highp float cageform_out[];
};
#ifndef CAGEFORM_BASE
#define CAGEFORM_BASE 0u
#endif
#ifndef CAGEFORM_OUT_OFFSET
#define CAGEFORM_OUT_OFFSET 0
#endif
#ifndef CAGEFORM_OUT_STRIDE
#define CAGEFORM_OUT_STRIDE CAGEFORM_DIMENSION
#endif

void main() {
    const highp uint base = CAGEFORM_BASE;
    highp uint place = gl_GlobalInvocationID.x;
    if (place >= cageform_points(base)) return;
    highp vec3 rest = cageform_rest(base, place), moved = cageform_displacement(base, place);
    highp uint at = uint(CAGEFORM_OUT_OFFSET) + cageform_point(base, place) * uint(CAGEFORM_OUT_STRIDE);
    for (highp uint k = 0u; k < CAGEFORM_DIMENSION; ++k) // an unmoved coordinate keeps its bits
        cageform_out[at + k] = moved[k] == 0.0 ? rest[k] : rest[k] + moved[k];
#ifdef CAGEFORM_NORMAL_OFFSET
    highp vec3 normal = cageform_normal(CAGEFORM_TANGENTS, CAGEFORM_BITANGENTS, place);
    at = uint(CAGEFORM_NORMAL_OFFSET) + cageform_point(CAGEFORM_TANGENTS, place) * uint(CAGEFORM_OUT_STRIDE);
    for (highp uint k = 0u; k < 3u; ++k) cageform_out[at + k] = normal[k];
#endif
}
)";

/// Returns the displacement of a point with four joints. For more joints, add the results of several sets.
inline constexpr const char* skin = R"(
highp vec3 cageform_skin(highp uvec4 joints, highp vec4 weights) {
    return weights.x * cageform_displacements[joints.x].xyz + weights.y * cageform_displacements[joints.y].xyz +
           weights.z * cageform_displacements[joints.z].xyz + weights.w * cageform_displacements[joints.w].xyz;
}
)";

} // namespace glsl

// Header fields read by `glsl::blob`, in words of four bytes.
static_assert(offsetof(BlobHeader, dimension) == 9 * sizeof(float) &&
              offsetof(BlobHeader, format) == 10 * sizeof(float) &&
              offsetof(BlobHeader, handles) == 12 * sizeof(float) &&
              offsetof(BlobHeader, points) == 14 * sizeof(float) &&
              offsetof(BlobHeader, weights) == 22 * sizeof(float) &&
              offsetof(BlobHeader, row_begin) == 24 * sizeof(float) &&
              offsetof(BlobHeader, row_handle) == 26 * sizeof(float) &&
              offsetof(BlobHeader, order) == 28 * sizeof(float) &&
              offsetof(BlobHeader, scale) == 30 * sizeof(float) &&
              offsetof(BlobHeader, residual) == 32 * sizeof(float) &&
              offsetof(BlobHeader, rest) == 36 * sizeof(float) && lane_count<float> == 16);

} // namespace cageform::inline CAGEFORM_ABI
