// The parts that all packed data shares: the prefix of its header, its checksum, and its owner.
#pragma once

#include <cageform/core/detail/blocks.hpp>
#include <cageform/core/status.hpp>

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Returns a 64-bit hash. It certainly changes if a single 8-byte word changes, and almost
/// certainly otherwise. It does not protect against forgery. `seed` chains several pieces. About 20
/// GB/s.
inline std::uint64_t hash_memory(std::span<const std::byte> bytes, std::uint64_t seed = 0) noexcept {
    // Eight independent sums. Every step is invertible, so a difference is never lost on the way.
    constexpr std::uint64_t prime = 0x9E3779B97F4A7C15u;
    std::uint64_t sums[8];
    for (std::size_t j = 0; j < 8; ++j) sums[j] = seed + (j + 1) * prime;
    const auto add = [&](std::size_t j, std::uint64_t word) {
        sums[j] = (sums[j] ^ word) * prime;
        sums[j] ^= sums[j] >> 32;
    };
    std::size_t i = 0;
    for (; i + 64 <= bytes.size(); i += 64) {
        std::uint64_t words[8];
        std::memcpy(words, bytes.data() + i, 64);
        for (std::size_t j = 0; j < 8; ++j) add(j, words[j]);
    }
    for (std::size_t j = 0; i < bytes.size(); i += 8, ++j) {
        std::uint64_t word = 0;
        std::memcpy(&word, bytes.data() + i, bytes.size() - i < 8 ? bytes.size() - i : 8);
        add(j, word);
    }
    std::uint64_t hash = bytes.size() * prime;
    for (const std::uint64_t sum : sums) {
        hash = (hash ^ sum) * prime;
        hash ^= hash >> 29;
    }
    return hash;
}

/// Hashes any contiguous values: the vertices of a cage, the faces of a figure.
template <class X>
    requires std::is_trivially_copyable_v<X> std::uint64_t hash_memory(std::span<const X> values,
                                                                       std::uint64_t seed = 0)
noexcept {
    return hash_memory(std::as_bytes(values), seed);
}

/// How thoroughly a blob is checked before it is used.
enum class BlobCheck : std::uint8_t {
    all,       ///< `structure` and the checksum, which reads every byte once
    structure, ///< everything that could make a clone read or write out of bounds
};

namespace detail {

/// Returns `x` in the opposite byte order.
constexpr std::uint64_t byte_swapped(std::uint64_t x) noexcept {
    std::uint64_t swapped = 0;
    for (int byte = 0; byte < 8; ++byte, x >>= 8) swapped = (swapped << 8) | (x & 0xFFu);
    return swapped;
}

/// The first 32 bytes of all packed data. The checksum covers everything after them.
struct PackedPrefix {
    std::uint64_t magic = 0;
    std::uint32_t version = 0;
    std::uint32_t endian = 0x01020304u;
    std::uint64_t bytes = 0; ///< total size, a multiple of 64
    std::uint64_t checksum = 0;
};
static_assert(sizeof(PackedPrefix) == 32);

/// Returns the prefix that a header begins with.
template <class Header>
PackedPrefix prefix_of(const Header& header) noexcept {
    return {header.magic, header.version, header.endian, header.bytes, header.checksum};
}

/// Checks that memory begins with complete, undamaged packed data of a kind.
///
///   expected  the kind's magic number, and the newest version that is understood
///   header    size in bytes of the kind's header
///   none      the status for data of another kind, or not aligned to 64 bytes
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
    /// Writes the checksum into the prefix, once the data is complete.
    void seal() noexcept {
        const std::uint64_t sum = hash_memory(bytes().subspan(sizeof(PackedPrefix)));
        std::memcpy(data() + offsetof(PackedPrefix, checksum), &sum, sizeof(sum));
    }

private:
    std::vector<Lanes<double>> memory_; // 64 bytes each
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
