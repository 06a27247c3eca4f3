#include "files/figure_stream.hpp"

#include "io/input_file.hpp"

#include <cageform/figure/figure.hpp>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace cageform_support {

using cageform::BlobHeader;
using cageform::FigureHeader;
using cageform::FigurePart;

static constexpr std::uint64_t whole_lines(std::uint64_t bytes) {
    return (bytes + 63) / 64 * 64;
}

static constexpr std::size_t parts = 2;
static constexpr std::uint64_t blob_begin = whole_lines(sizeof(FigureHeader) + parts * sizeof(FigurePart));
static constexpr cageform::FigureTag record_tag = "TILE";
static constexpr std::uint64_t most_of_32_bits = 0xFFFFFFFFU;

template <class X>
static std::span<const std::byte> bytes_of(const X& x) {
    return std::as_bytes(std::span(&x, 1));
}

static std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Reads ranges of a file in blocks, with its own descriptor.
class BlockReader {
public:
    explicit BlockReader(const std::filesystem::path& path)
        : file_(open(path.c_str(), O_RDONLY | O_CLOEXEC))
        , code_(file_ < 0 ? errno : 0) {}
    BlockReader(const BlockReader&) = delete;
    BlockReader& operator=(const BlockReader&) = delete;
    ~BlockReader() {
        if (file_ >= 0) close(file_);
    }

    /// Calls use(bytes) for each block of a range; false if it cannot be read, or the file is shorter.
    template <class Use>
    bool read(std::uint64_t begin, std::uint64_t bytes, const Use& use) {
        while (code_ == 0 && bytes > 0) {
            const auto most = std::size_t(std::min<std::uint64_t>(bytes, block_.size()));
            const ssize_t count = pread(file_, block_.data(), most, off_t(begin));
            if (count < 0 && errno == EINTR) continue;
            if (count <= 0) code_ = count < 0 ? errno : ENODATA;
            if (count <= 0) break;
            use(std::span<const std::byte>(block_).first(std::size_t(count)));
            begin += std::uint64_t(count);
            bytes -= std::uint64_t(count);
        }
        return code_ == 0;
    }
    template <class X>
    bool read(std::uint64_t begin, X& x) {
        std::size_t done = 0;
        return read(begin, sizeof(X), [&](std::span<const std::byte> bytes) {
            std::memcpy(reinterpret_cast<std::byte*>(&x) + done, bytes.data(), bytes.size());
            done += bytes.size();
        });
    }
    std::optional<std::uint64_t> hash(std::uint64_t begin, std::uint64_t end) {
        cageform::MemoryHash hash;
        if (!read(begin, end - begin, [&](std::span<const std::byte> bytes) { hash.add(bytes); }))
            return std::nullopt;
        return hash.value();
    }
    int code() const { return code_; } ///< the errno of the first failure, or 0

private:
    int file_;
    int code_;
    std::vector<std::byte> block_ = std::vector<std::byte>(std::size_t{1} << 20);
};

FigureStream::FigureStream(const std::filesystem::path& path)
    : figure_(path)
    , rest_(path) {
    header_.points = header_.rows = 0;
    if (!is_sound(figure_) || !is_sound(rest_)) return;
    put(std::vector<std::byte>(blob_begin + sizeof(BlobHeader)));
}

bool FigureStream::fail(const std::string& why) {
    if (error_.empty()) error_ = why;
    return false;
}

bool FigureStream::is_sound(const AtomicFile& file) {
    if (!file.error()) return error_.empty();
    may_retry_ = may_retry_ || (error_.empty() && file.may_retry());
    return fail(*file.error());
}

void FigureStream::put(std::span<const std::byte> bytes) {
    figure_.write(text_of(bytes));
    bytes_ += bytes.size();
}

void FigureStream::put_rest(std::size_t array, std::span<const std::byte> bytes) {
    rest_.write(text_of(bytes));
    sections_[array].push_back({bytes_of_rest_, bytes.size()});
    bytes_of_rest_ += bytes.size();
}

bool FigureStream::append(std::span<const std::byte> piece, Points points) {
    constexpr std::size_t row_begin = 0, order = 2; // among the arrays
    constexpr std::array of_handles{false, false, false, false, false, true, false, true, true, true, true};
    BlobHeader header;
    std::memcpy(&header, piece.data(), sizeof(header));
    const bool is_first = sections_[row_begin].empty() && header_.points == 0;
    if (header.points + header_.points > most_of_32_bits ||
        (header.row_begin != 0 && header.rows + header_.rows > most_of_32_bits))
        return fail(figure_.path().string() + ": a figure has at most 4294967295 points and rows of weights: "
                                              "cut the tile, or keep fewer weights");
    if (!error_.empty()) return false;
    std::size_t array = 0;
    bool is_weights = true;
    cageform::for_each_blob_array<float, 3>(
        header, [&](std::uint64_t offset, std::uint64_t bytes, bool wanted) {
            if (wanted && is_weights) put(piece.subspan(offset, bytes));
            if (!is_weights && wanted && (is_first || !of_handles[array])) {
                const auto from = piece.subspan(offset, bytes);
                if (array == row_begin || array == order) {
                    std::vector<std::uint32_t> numbers(bytes / 4);
                    std::memcpy(numbers.data(), from.data(), bytes);
                    const std::uint64_t before = array == order ? header_.points : header_.rows;
                    for (std::uint32_t& number : numbers) number += std::uint32_t(before);
                    const std::size_t known =
                        array == row_begin && !is_first ? 1 : 0; // entry 0 equals the last piece's end
                    put_rest(array, std::as_bytes(std::span(numbers).subspan(known)));
                } else {
                    put_rest(array, from);
                }
            }
            array += is_weights ? 0 : 1;
            is_weights = false;
        });
    points_.add(std::as_bytes(points));
    header.points += header_.points;
    header.rows += header_.rows;
    header_ = header;
    return is_sound(figure_) && is_sound(rest_);
}

bool FigureStream::put_array(std::size_t array, BlockReader& rest) {
    for (const Section& section : sections_[array]) {
        if (!rest.read(section.offset, section.bytes,
                       [&](std::span<const std::byte> bytes) { put(bytes); })) {
            may_retry_ = may_retry_ || (error_.empty() && is_temporary_failure(rest.code()));
            return fail("cannot write " + figure_.path().string() + ": its temporary file cannot be read: " +
                        std::generic_category().message(rest.code()));
        }
    }
    put(std::vector<std::byte>(whole_lines(bytes_) - bytes_));
    return is_sound(figure_);
}

bool FigureStream::finish(TileRecord& record) {
    if (!error_.empty()) return false;
    (void)rest_.finish();
    if (!is_sound(rest_)) return false;
    BlockReader rest(rest_.temporary());
    put(std::vector<std::byte>(whole_lines(bytes_) - bytes_));
    std::size_t array = 0;
    bool is_weights = true;
    cageform::for_each_blob_array<float, 3>(header_, [&](std::uint64_t& offset, std::uint64_t, bool wanted) {
        if (is_weights) {
            offset = sizeof(BlobHeader);
        } else {
            offset = wanted ? bytes_ - blob_begin : 0;
            if (wanted) (void)put_array(array, rest);
            ++array;
        }
        is_weights = false;
    });
    if (!error_.empty()) return false;
    header_.bytes = bytes_ - blob_begin;
    header_.figure_hash = points_.value();
    record.points = header_.points;
    const std::uint64_t blocks =
        (header_.points + cageform::lane_count<float> - 1) / cageform::lane_count<float>;
    record.weights_per_point = blocks > 0 ? double(header_.rows) / double(blocks) : 0;
    const std::uint64_t record_begin = bytes_;
    put(bytes_of(record));

    FigureHeader header;
    header.version = 1;
    header.scalar_bytes = sizeof(float);
    header.dimension = 3;
    header.parts = parts;
    header.bytes = bytes_;
    const std::array table{FigurePart{cageform::FigureTags::points, 0, blob_begin, header_.bytes},
                           FigurePart{record_tag, 0, record_begin, sizeof(record)}};
    figure_.write_at(0, text_of(bytes_of(header)));
    figure_.write_at(sizeof(header), text_of(std::as_bytes(std::span(table))));
    figure_.write_at(blob_begin, text_of(bytes_of(header_)));
    if (!is_sound(figure_)) return false;
    // Each checksum covers all bytes after it; that of the figure includes that of the blob.
    BlockReader written(figure_.temporary());
    for (const auto& [begin, end] :
         {std::array{blob_begin, record_begin}, std::array{std::uint64_t{0}, bytes_}}) {
        constexpr std::uint64_t after = sizeof(cageform::PackedPrefix);
        const auto hash = written.hash(begin + after, end);
        if (!hash) {
            may_retry_ = is_temporary_failure(written.code());
            return fail("cannot write " + figure_.path().string() +
                        ": it cannot be read again: " + std::generic_category().message(written.code()));
        }
        figure_.write_at(begin + offsetof(cageform::PackedPrefix, checksum), text_of(bytes_of(*hash)));
    }
    (void)figure_.commit();
    return is_sound(figure_);
}

std::optional<TileRecord> read_tile_record(const std::filesystem::path& path) {
    BlockReader file(path);
    FigureHeader header;
    const FigureHeader known;
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    if (error || !file.read(0, header) || header.magic != known.magic || header.version != 1 ||
        header.endian != known.endian || header.parts != parts || header.bytes != size ||
        header.bytes < blob_begin + sizeof(TileRecord))
        return std::nullopt;
    std::array<FigurePart, parts> table{};
    TileRecord record;
    if (!file.read(sizeof(header), table) || table[1].tag != record_tag || table[1].bytes != sizeof(record) ||
        table[1].offset != header.bytes - sizeof(record) || !file.read(table[1].offset, record) ||
        file.hash(sizeof(cageform::PackedPrefix), header.bytes) != header.checksum)
        return std::nullopt;
    return record;
}

} // namespace cageform_support
