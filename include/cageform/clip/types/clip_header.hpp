// The header of a packed clip, and its rigid motion; clip/clip_blob.hpp has the layout.
#pragma once

#include <cageform/core/vec.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// The first 192 bytes of a packed clip. Offsets are in bytes from the beginning of the clip.
struct ClipHeader {
    static constexpr std::uint64_t magic_number = 0x70696C6365676163u; // "cageclip" in little endian
    static constexpr std::uint32_t current_version = 2;                ///< 1 if the origin is 0

    std::uint64_t magic = magic_number;
    std::uint32_t version = current_version;
    std::uint32_t endian = 0x01020304u;
    std::uint64_t bytes = 0;    ///< of the whole clip, a multiple of 64
    std::uint64_t checksum = 0; ///< `hash_memory` of all bytes after this field
    std::uint32_t scalar_bytes = 0, dimension = 0;
    std::uint32_t before = 0, after = 0; ///< Extrapolation
    std::uint64_t curves = 0, pieces = 0, steps = 0;
    double begin = 0, end = 0; ///< times relative to `origin`, representable in T
    std::uint64_t curve_table = 0, knot_table = 0, piece_table = 0, step_table = 0, entry_table = 0, ends = 0;
    std::uint64_t motion = 0, tracks = 0, turns = 0; ///< tracks: #track_pieces, turns: #rotations
    std::uint64_t track_begins = 0, track_pieces = 0, rotations = 0;
    double origin = 0;
};
static_assert(sizeof(ClipHeader) == 192);

/// A track of a packed motion. Its pieces follow those of the previous track. A track without pieces
/// has no effect.
template <Scalar T>
struct PackedTrack {
    std::uint32_t first = 0, pieces = 0;
    std::uint32_t before = 0, after = 0; ///< Extrapolation
    T end = 0, end_value = 0;
};

/// A RigidMotion.
template <Scalar T, std::size_t D>
struct PackedMotion {
    std::array<PackedTrack<T>, 1 + D> tracks; ///< the rotation, and the translation along each axis
    Vec<T, D> pivot{};
};

} // namespace cageform::inline CAGEFORM_ABI
