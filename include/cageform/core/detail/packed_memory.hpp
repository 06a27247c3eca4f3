// Checks the prefix of packed data, and owns packed data.
#pragma once

#include <cageform/core/status.hpp>
#include <cageform/core/types/blocks.hpp>
#include <cageform/core/types/packed_data.hpp>

#include <concepts>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns `x` in the opposite byte order.
constexpr std::uint64_t byte_swapped(std::uint64_t x) noexcept {
    std::uint64_t swapped = 0;
    for (int byte = 0; byte < 8; ++byte, x >>= 8) swapped = (swapped << 8) | (x & 0xFFu);
    return swapped;
}

/// Checks the prefix of packed data, its size and its checksum.
///
///   expected  the magic number of the format, and the newest supported version
///   header    size of the format's header in bytes
///   none      the status for another magic number, or data not aligned to 64 bytes
inline Status check_prefix(std::span<const std::byte> data, const PackedPrefix& expected, std::size_t header,
                           BlobCheck check, Status none) noexcept {
    PackedPrefix prefix;
    if (data.size() < 16 || reinterpret_cast<std::uintptr_t>(data.data()) % 64 != 0) return none;
    std::memcpy(&prefix, data.data(), data.size() < sizeof(prefix) ? data.size() : sizeof(prefix));
    if (prefix.magic == byte_swapped(expected.magic)) return Status::blob_version_differs;
    if (prefix.magic != expected.magic) return none;
    if (prefix.version == 0 || prefix.version > expected.version || prefix.endian != expected.endian)
        return Status::blob_version_differs;
    if (data.size() < header || prefix.bytes > data.size()) return Status::blob_truncated;
    if (prefix.bytes < header || prefix.bytes % 64 != 0) return Status::blob_malformed;
    const auto checked = data.subspan(sizeof(prefix), std::size_t(prefix.bytes) - sizeof(prefix));
    return check == BlobCheck::all && hash_memory(checked) != prefix.checksum ? Status::blob_corrupt
                                                                              : Status::ok;
}

/// The kind of packed data that a reader expects.
struct PackedKind {
    Status none; ///< the status of data of another kind
    std::uint32_t scalar_bytes, dimension;
};

/// Runs `check_prefix`, reads the header, and checks its scalar and dimension.
template <class Header>
Status read_header(std::span<const std::byte> data, BlobCheck check, const PackedKind& kind,
                   Header& header) noexcept {
    const Status status =
        check_prefix(data, {header.magic, header.version}, sizeof(header), check, kind.none);
    if (status != Status::ok) return status;
    std::memcpy(&header, data.data(), sizeof(header));
    const bool is_expected = header.scalar_bytes == kind.scalar_bytes && header.dimension == kind.dimension;
    return is_expected ? Status::ok : Status::blob_kind_differs;
}

/// Rounds up to a multiple of 64.
template <std::unsigned_integral N>
constexpr N whole_lines(N bytes) noexcept {
    return (bytes + 63) / 64 * 64;
}
/// Sets the offset of the next array of packed data, or 0 if it is absent, and advances `end`.
inline void place_array(std::uint64_t& end, std::uint64_t& offset, std::uint64_t bytes,
                        bool is_there) noexcept {
    offset = is_there ? end : 0;
    if (is_there) end += whole_lines(bytes);
}
/// Checks the offset of an array: 0 if not `wanted`; else a multiple of 64, with the array between the header
/// and the end of the data.
template <class Header>
bool holds_array(const Header& header, std::uint64_t offset, std::uint64_t bytes, bool wanted) noexcept {
    if (offset == 0) return !wanted;
    return wanted && offset % 64 == 0 && offset >= sizeof(header) && offset <= header.bytes &&
           bytes <= header.bytes - offset;
}

/// Owns packed data.
class PackedMemory {
public:
    /// Resizes to a multiple of 64 bytes and zeroes them. Throws std::bad_alloc if memory runs out.
    void resize(std::uint64_t bytes) {
        memory_.resize(std::size_t(bytes / 64));
        if (bytes != 0) std::memset(data(), 0, std::size_t(bytes));
    }
    std::byte* data() noexcept { return std::as_writable_bytes(std::span(memory_)).data(); }
    std::span<const std::byte> bytes() const noexcept { return std::as_bytes(std::span(memory_)); }
    /// Writes the checksum into the prefix. Call it once the data is complete.
    void seal() noexcept {
        const std::uint64_t sum = hash_memory(bytes().subspan(sizeof(PackedPrefix)));
        std::memcpy(data() + offsetof(PackedPrefix, checksum), &sum, sizeof(sum));
    }

private:
    std::vector<Lanes<double>> memory_; // 64 bytes each
};

} // namespace cageform::inline CAGEFORM_ABI::detail
