#pragma once

// Packed figures that are written piece by piece, in the memory of one piece: a figure of any number of
// points (cageform/figure/figure.hpp). Beside its points it holds a part of our own:
//
//     TILE  TileRecord

#include "io/atomic_file.hpp"

#include <cageform/figure/types/blob.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// Tells what a figure was made of, and how well. It holds no times: equal input gives equal bytes.
struct TileRecord {
    std::uint64_t points_hash = 0;     ///< hash_memory of the bytes of the file with the points
    std::uint64_t parameters_hash = 0; ///< of all that decides about the bytes beside it
    std::uint64_t points = 0, outside = 0;
    std::uint64_t farthest = 0;   ///< the number of the point of `distance`
    double distance = 0;          ///< the largest that a point is off by, in units of the cage
    double weights_per_point = 0; ///< stored, zeros included
    std::uint64_t not_finite = 0; ///< points that no pose moves
};
static_assert(sizeof(TileRecord) == 64);

class BlockReader;

/// Writes a packed figure of points, piece by piece. Its weights go into the file as they come, all else
/// into a second temporary beside it, from which finish() appends it. Both together need up to twice the
/// figure's bytes on the disk.
class FigureStream {
public:
    using Points = std::span<const cageform::Vec<float, 3>>;

    /// Opens the temporaries. A failure is remembered: error() tells it.
    explicit FigureStream(const std::filesystem::path& path);

    /// Appends the points of a packed binding after those so far. All pieces are of the same handles and
    /// format, and all but the last have whole blocks (a multiple of sixteen points). False after a failure,
    /// and where the figure gets more points or rows than a file can count.
    ///
    ///   piece    PackedBinding::bytes
    ///   points   as they were bound, in their order
    bool append(std::span<const std::byte> piece, Points points);

    /// Appends what is missing, computes the checksums and puts the file in its place. `record` gets the
    /// number of points and of their weights.
    bool finish(TileRecord& record);

    const std::string& error() const { return error_; } ///< the first failure; empty while there is none
    bool may_pass() const { return may_pass_; }
    std::uint64_t bytes() const { return bytes_; } ///< of the figure; after finish()

private:
    /// The arrays of a blob but its weights, in the order of for_each_blob_array.
    static constexpr std::size_t arrays = 11;
    struct Section { // a part of an array, in the second temporary
        std::uint64_t offset = 0, bytes = 0;
    };

    bool fail(const std::string& why);
    bool is_sound(const AtomicFile& file);
    void put(std::span<const std::byte> bytes);
    void put_rest(std::size_t array, std::span<const std::byte> bytes);
    bool put_array(std::size_t array, BlockReader& rest);

    AtomicFile figure_, rest_;
    std::array<std::vector<Section>, arrays> sections_; // by array and piece
    cageform::BlobHeader header_;                       // of all pieces so far
    cageform::MemoryHash points_;
    std::uint64_t bytes_ = 0, bytes_of_rest_ = 0;
    std::string error_;
    bool may_pass_ = false;
};

/// The record of a figure file that is whole, with the right checksum; nothing where it is not, or where it
/// is no figure of a tile. It reads the file once, in blocks.
std::optional<TileRecord> read_tile_record(const std::filesystem::path& path);

} // namespace cageform_support
