// The prefix of the header of all packed data, and the checksum.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace cageform::inline CAGEFORM_ABI {

/// The first 32 bytes of all packed data. The checksum covers all bytes after them.
struct PackedPrefix {
    std::uint64_t magic = 0;
    std::uint32_t version = 0;
    std::uint32_t endian = 0x01020304u;
    std::uint64_t bytes = 0; ///< total size, a multiple of 64
    std::uint64_t checksum = 0;
};
static_assert(sizeof(PackedPrefix) == 32);

/// How thoroughly a blob is checked before it is used.
enum class BlobCheck : std::uint8_t {
    all,       ///< `structure` and the checksum, which reads every byte once
    structure, ///< everything that could cause reads or writes out of bounds
};

/// Computes `hash_memory` incrementally, for instance of a file that is read in blocks.
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

    /// Returns the hash of all bytes. Do not call `add` afterwards.
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

    // Eight independent sums. Every step is invertible, so a single different word always changes the hash.
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

/// Returns a 64-bit hash. Data that differ in a single 8-byte word always have different hashes, other
/// data almost always. Not cryptographic. To hash several pieces, pass the hash of one as the `seed` of
/// the next. About 20 GB/s.
inline std::uint64_t hash_memory(std::span<const std::byte> bytes, std::uint64_t seed = 0) noexcept {
    MemoryHash hash(seed);
    hash.add(bytes);
    return hash.value();
}

/// Hashes contiguous values, for instance the vertices of a cage.
template <class X>
    requires std::is_trivially_copyable_v<X>
std::uint64_t hash_memory(std::span<const X> values, std::uint64_t seed = 0) noexcept {
    return hash_memory(std::as_bytes(values), seed);
}

} // namespace cageform::inline CAGEFORM_ABI
