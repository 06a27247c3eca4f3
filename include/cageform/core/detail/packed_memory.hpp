// The parts that all packed data shares: the prefix of its header, its checksum, and its owner.
#pragma once

#include <cageform/core/detail/blocks.hpp>
#include <cageform/core/status.hpp>

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Computes `hash_memory` of bytes that come in pieces, such as a file that is read in blocks.
class MemoryHash {
public:
    explicit MemoryHash(std::uint64_t seed = 0) noexcept {
        for (std::size_t j = 0; j < 8; ++j) sums_[j] = seed + (j + 1) * prime;
    }

    void add(std::span<const std::byte> bytes) noexcept {
        size_ += bytes.size();
        if (held_ > 0) {
            const std::size_t missing = 64 - held_, count = bytes.size() < missing ? bytes.size() : missing;
            if (count > 0) std::memcpy(line_ + held_, bytes.data(), count);
            held_ += count;
            bytes = bytes.subspan(count);
            if (held_ < 64) return;
            add_line(line_, 64);
            held_ = 0;
        }
        std::size_t i = 0;
        for (; i + 64 <= bytes.size(); i += 64) add_line(bytes.data() + i, 64);
        held_ = bytes.size() - i;
        if (held_ > 0) std::memcpy(line_, bytes.data() + i, held_);
    }

    /// Returns the hash of all bytes so far; nothing is added after it.
    std::uint64_t value() noexcept {
        add_line(line_, held_);
        std::uint64_t hash = size_ * prime;
        for (const std::uint64_t sum : sums_) {
            hash = (hash ^ sum) * prime;
            hash ^= hash >> 29;
        }
        return hash;
    }

private:
    static constexpr std::uint64_t prime = 0x9E3779B97F4A7C15u;

    // Eight independent sums. Every step is invertible, so a difference is never lost on the way.
    void add_line(const std::byte* line, std::size_t bytes) noexcept {
        std::uint64_t words[8] = {};
        if (bytes > 0) std::memcpy(words, line, bytes);
        for (std::size_t j = 0; j < (bytes + 7) / 8; ++j) {
            sums_[j] = (sums_[j] ^ words[j]) * prime;
            sums_[j] ^= sums_[j] >> 32;
        }
    }

    std::uint64_t sums_[8];
    std::uint64_t size_ = 0;
    std::size_t held_ = 0; ///< bytes of an incomplete line
    std::byte line_[64];
};

} // namespace detail

/// Returns a 64-bit hash. It certainly changes if a single 8-byte word changes, and almost
/// certainly otherwise. It does not protect against forgery. `seed` chains several pieces. About 20
/// GB/s.
inline std::uint64_t hash_memory(std::span<const std::byte> bytes, std::uint64_t seed = 0) noexcept {
    detail::MemoryHash hash(seed);
    hash.add(bytes);
    return hash.value();
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
