// The table of a packed figure (figure/figure.hpp): its header, and the tags of its parts.
#pragma once

#include <cageform/figure/types/blob.hpp>

#include <array>
#include <string_view>

namespace cageform::inline CAGEFORM_ABI {

/// The name of a part of a figure: four characters.
struct FigureTag {
    std::uint32_t number = 0;

    FigureTag() = default;
    constexpr FigureTag(const char (&text)[5]) noexcept { // NOLINT(google-explicit-constructor): "TRIS"
        for (std::size_t n = 4; n-- > 0;) number = number << 8 | static_cast<unsigned char>(text[n]);
    }
    std::array<char, 5> text() const noexcept {
        std::array<char, 5> text{};
        for (std::size_t n = 0; n < 4; ++n) text[n] = static_cast<char>(number >> (8 * n) & 0xFFu);
        return text;
    }
    friend constexpr bool operator==(const FigureTag&, const FigureTag&) = default;
};

/// The tags of the library's own parts.
struct FigureTags {
    static constexpr FigureTag points = "PNTS", tangents = "TAN1", bitangents = "TAN2", handedness = "HAND",
                               labels = "LABL", clips = "CLPS";
    static constexpr std::size_t most_levels = 9;

    /// Returns the tag of a level of less detail; levels count from 1.
    static constexpr FigureTag level(std::size_t n) noexcept {
        FigureTag tag = "LVL0";
        tag.number += static_cast<std::uint32_t>(n) << 24;
        return tag;
    }
    static constexpr bool has(FigureTag tag) noexcept {
        return tag == points || tag == tangents || tag == bitangents || tag == handedness || tag == labels ||
               is_since_version_2(tag);
    }
    static constexpr bool is_since_version_2(FigureTag tag) noexcept {
        bool is_level = false;
        for (std::size_t n = 1; n <= most_levels; ++n) is_level = is_level || tag == level(n);
        return tag == clips || is_level;
    }
};

/// The first 64 bytes of a packed figure.
struct FigureHeader {
    static constexpr std::uint64_t magic_number = 0x6572756769666763u; // "cgfigure" in little endian
    static constexpr std::uint32_t current_version = 2, endian_tag = BlobHeader::endian_tag, most_parts = 256;

    std::uint64_t magic = magic_number;
    std::uint32_t version = current_version;
    std::uint32_t endian = endian_tag;
    std::uint64_t bytes = 0;    ///< of the whole figure, a multiple of 64
    std::uint64_t checksum = 0; ///< `hash_memory` of all that follows this field
    std::uint32_t scalar_bytes = 0, dimension = 0, parts = 0, reserved[5] = {};
};
static_assert(sizeof(FigureHeader) == 64);

/// An entry of the table.
struct FigurePart {
    FigureTag tag;
    std::uint32_t reserved = 0;
    std::uint64_t offset = 0; ///< from the beginning of the figure, a multiple of 64
    std::uint64_t bytes = 0;  ///< without the padding to a multiple of 64
};
static_assert(sizeof(FigurePart) == 24);

/// A part to be packed.
struct FigurePartData {
    FigureTag tag;
    std::span<const std::byte> bytes;
};

/// A clip of a figure. Offsets are from the beginning of the CLPS part.
struct FigureClip {
    std::uint64_t offset = 0, bytes = 0; ///< of the packed clip
    std::uint32_t name = 0, name_bytes = 0;
};
static_assert(sizeof(FigureClip) == 24);

/// A packed clip to be stored in a figure, and its name.
struct FigureClipData {
    std::string_view name;
    std::span<const std::byte> bytes; ///< PackedClip::bytes
};

} // namespace cageform::inline CAGEFORM_ABI
