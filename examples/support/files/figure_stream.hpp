#pragma once

// Writes packed figures (cageform/figure/figure.hpp) of any number of points piece by piece; memory holds one
// piece. The figures contain an additional part:
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

/// Input hashes and quality of a figure. Contains no times: equal input gives equal bytes.
struct TileRecord {
    std::uint64_t points_hash = 0;     ///< hash_memory of the file of points
    std::uint64_t parameters_hash = 0; ///< of all other inputs that determine the bytes
    std::uint64_t points = 0, outside = 0;
    std::uint64_t farthest = 0;   ///< index of the point with `distance`
    double distance = 0;          ///< largest error of a point, in units of the cage
    double weights_per_point = 0; ///< stored, zeros included
    std::uint64_t not_finite = 0; ///< points that are not finite and do not move
};
static_assert(sizeof(TileRecord) == 64);

class BlockReader;

/// Writes a packed figure of points in pieces. Weights go directly into the file, all else into a second
/// temporary file, which finish() appends. Disk space: up to twice the figure.
class FigureStream {
public:
    using Points = std::span<const cageform::Vec<float, 3>>;

    /// Opens the temporary files; on failure error() is set.
    explicit FigureStream(const std::filesystem::path& path);

    /// Appends the points of a packed binding. All pieces must have the same handles and format, and all but
    /// the last a multiple of sixteen points. False after a failure, or if the figure gets more points or
    /// rows than the format can count.
    ///
    ///   piece    PackedBinding::bytes
    ///   points   in the order in which they were bound
    bool append(std::span<const std::byte> piece, Points points);

    /// Completes the file, computes the checksums and renames it into place. Sets the numbers of points and
    /// weights in `record`.
    bool finish(TileRecord& record);

    const std::string& error() const { return error_; } ///< the first failure; empty while there is none
    bool may_retry() const { return may_retry_; }       ///< AtomicFile::may_retry
    std::uint64_t bytes() const { return bytes_; }      ///< size of the figure, after finish()

private:
    /// The arrays of a blob without weights, in the order of for_each_blob_array.
    static constexpr std::size_t arrays = 11;
    struct Section { // a part of an array in the second temporary file
        std::uint64_t offset = 0, bytes = 0;
    };

    bool fail(const std::string& why);
    bool is_sound(const AtomicFile& file);
    void put(std::span<const std::byte> bytes);
    void put_rest(std::size_t array, std::span<const std::byte> bytes);
    bool put_array(std::size_t array, BlockReader& rest);

    AtomicFile figure_, rest_;
    std::array<std::vector<Section>, arrays> sections_; // #arrays · #pieces
    cageform::BlobHeader header_;                       // of all pieces so far
    cageform::MemoryHash points_;
    std::uint64_t bytes_ = 0, bytes_of_rest_ = 0;
    std::string error_;
    bool may_retry_ = false;
};

/// The record of a complete figure file with a correct checksum; else nothing. Reads the file once, in
/// blocks.
std::optional<TileRecord> read_tile_record(const std::filesystem::path& path);

} // namespace cageform_support
