// The binary layout of a packed binding, which is written to a file, mapped, and cloned in place.
//
// Byte order is that of the machine that wrote the blob; a field records it. Every array begins at a
// multiple of 64 bytes. The block contains offsets, no pointers. A block has L = 64 / sizeof(T) points
// (16 for float, 8 for double); B = ⌈#points / L⌉.
//
//     BlobHeader
//     weights       #rows × L of the format: a row holds the weights of a block's points for one
//                   handle, block by block
//     row_begin     (B + 1) × uint32  only in sparse bindings; else #rows = B · #handles
//     row_handle    #rows × uint16    with row_begin
//     order         #points × uint32: the point at each position; only if points are reordered
//     scale         B × T             not with scalar weights
//     residual      B × (D + 1) × L × T         with scale
//     affine_fit    #handles × (D + 1) × T      with scale
//     rest          B × D × L × T
//     rest_handles  #handles × D × T
//     handle_kinds  #handles × uint8: 0 a point, 1 a vector; only if some are vectors
//     handle_faces  #vectors × D × uint32: the corners of a face (HandleFace); only if the vectors
//                   have faces
//     handle_loops  #loop_numbers × uint32: HandleView::loops; only if corners of faces are means of loops
//
// Older readers reject blobs with loops, because they see corners out of range. Version 1 has no
// vectors and can be opened too. GPUs can use these bytes as buffers (clone/glsl.hpp).
#pragma once

#include <cageform/core/detail/packed_memory.hpp>
#include <cageform/core/result.hpp>
#include <cageform/figure/packed_binding.hpp>

#include <array>

namespace cageform::inline CAGEFORM_ABI {

/// The first 192 bytes of a blob. Offsets are in bytes from the beginning of the blob, 0 if an array is
/// absent.
struct BlobHeader {
    static constexpr std::uint64_t magic_number = 0x6D726F6665676163u; // "cageform" in little endian
    static constexpr std::uint32_t current_version = 2, endian_tag = 0x01020304u;

    std::uint64_t magic = magic_number;
    std::uint32_t version = current_version;
    std::uint32_t endian = endian_tag;
    std::uint64_t bytes = 0;    ///< of the whole blob, a multiple of 64
    std::uint64_t checksum = 0; ///< `hash_memory` of all that follows this field
    std::uint32_t scalar_bytes = 0, dimension = 0, format = 0;
    std::uint32_t loop_numbers = 0; ///< of handle_loops; 0 in older blobs
    std::uint64_t handles = 0, points = 0, rows = 0;
    std::uint64_t cage_hash = 0, figure_hash = 0;
    std::uint64_t weights = 0, row_begin = 0, row_handle = 0, order = 0, scale = 0, residual = 0,
                  affine_fit = 0, rest = 0, rest_handles = 0;
    std::uint64_t handle_kinds = 0, handle_faces = 0, vectors = 0; ///< since version 2
    std::uint64_t handle_loops = 0;                                ///< 0 in older blobs
};
static_assert(sizeof(BlobHeader) == 192);

/// What `open_blob` requires of a blob, and how much it checks.
struct BlobExpectation {
    std::uint64_t cage_hash = 0;   ///< the required hash; 0: any
    std::uint64_t figure_hash = 0; ///< the required hash; 0: any
    BlobCheck check = BlobCheck::all;
};

struct BlobReport {
    Status status = Status::ok;
    std::uint64_t cage_hash = 0, figure_hash = 0;
    std::size_t bytes = 0; ///< size of the blob; other data may follow it
};

/// Calls visit(offset, size in bytes, whether the array is required) for each array of a blob.
template <Scalar T, std::size_t D, class Header, class Visit>
void for_each_blob_array(Header& header, const Visit& visit) noexcept {
    const std::uint64_t points = header.points, rows = header.rows, handles = header.handles;
    const std::uint64_t lanes = lane_count<T>, blocks = (points + lanes - 1) / lanes;
    const auto format = static_cast<WeightFormat>(header.format);
    const bool sparse = header.row_begin != 0, rounded = format != WeightFormat::scalar;
    visit(header.weights, rows * (lanes * weight_bytes<T>(format)), true);
    visit(header.row_begin, (blocks + 1) * 4, sparse);
    visit(header.row_handle, rows * 2, sparse);
    visit(header.order, points * 4, header.order != 0);
    visit(header.scale, blocks * sizeof(T), rounded);
    visit(header.residual, blocks * ((D + 1) * sizeof(Lanes<T>)), rounded);
    visit(header.affine_fit, handles * ((D + 1) * sizeof(T)), rounded);
    visit(header.rest, blocks * (D * sizeof(Lanes<T>)), true);
    visit(header.rest_handles, handles * (D * sizeof(T)), true);
    visit(header.handle_kinds, handles, header.handle_kinds != 0);
    visit(header.handle_faces, header.vectors * (D * sizeof(std::uint32_t)), header.handle_faces != 0);
    visit(header.handle_loops, std::uint64_t{header.loop_numbers} * 4, header.handle_loops != 0);
}

namespace detail {

template <Scalar T, std::size_t D>
PackedBindingView<T, D> view_blob(const std::byte* data, const BlobHeader& header) noexcept {
    PackedBindingView<T, D> view;
    view.format = static_cast<WeightFormat>(header.format);
    view.handles = static_cast<std::size_t>(header.handles);
    view.points = static_cast<std::size_t>(header.points);
    const auto find = [data]<class X>(const X*& array, std::uint64_t offset) {
        if (offset != 0) array = reinterpret_cast<const X*>(data + offset);
    };
    find(view.weights, header.weights);
    find(view.row_begin, header.row_begin);
    find(view.row_handle, header.row_handle);
    find(view.order, header.order);
    find(view.scale, header.scale);
    find(view.residual, header.residual);
    find(view.affine_fit, header.affine_fit);
    find(view.rest, header.rest);
    find(view.rest_handles, header.rest_handles);
    find(view.handle_kinds, header.handle_kinds);
    find(view.handle_faces, header.handle_faces);
    find(view.handle_loops, header.handle_loops);
    return view;
}

/// Checks that a table of `numbers` elements contains non-empty loops of point handles.
template <Scalar T, std::size_t D>
bool has_valid_loops(const HandleView<T, D>& handles, std::uint64_t numbers) noexcept {
    const std::uint32_t* const table = handles.loops;
    if (table == nullptr) return true;
    if (numbers < 2 || table[0] < 2 || table[0] > numbers) return false;
    const std::uint32_t loops = table[0] - 1;
    for (std::uint32_t l = 0; l < loops; ++l) {
        if (table[l] >= table[l + 1]) return false;
    }
    if (table[loops] != numbers) return false;
    for (std::uint64_t n = table[0]; n < numbers; ++n) {
        if (table[n] >= handles.count || !handles.is_point(table[n])) return false;
    }
    return true;
}

/// Checks the number of vector handles, and that the corners of their faces are points or means of
/// valid loops.
template <Scalar T, std::size_t D>
Status check_handles(const HandleView<T, D>& handles, std::uint64_t vectors,
                     std::uint64_t loop_numbers) noexcept {
    for (std::size_t i = 0; handles.kinds != nullptr && i < handles.count; ++i) {
        if (handles.kinds[i] > HandleKind::vector) return Status::blob_malformed;
    }
    if (handles.vector_count() != vectors || !has_valid_loops(handles, loop_numbers))
        return Status::blob_malformed;
    const std::size_t loops = handles.loops != nullptr ? handles.loops[0] - 1 : 0;
    for (std::size_t n = 0; handles.faces != nullptr && n < vectors; ++n) {
        for (const std::uint32_t corner : handles.faces[n]) {
            const bool exists =
                corner < handles.count ? handles.is_point(corner) : corner - handles.count < loops;
            if (!exists) return Status::blob_malformed;
        }
    }
    return Status::ok;
}

/// Checks a blob. Counts that fit in 32 bits keep the products in `for_each_blob_array` below 2^64; the
/// rows of dense blobs are checked by division.
template <Scalar T, std::size_t D>
Status check_blob(const std::byte* data, const BlobHeader& header) noexcept {
    constexpr std::uint64_t most = 0xFFFFFFFFu;
#define CAGEFORM_DETAIL_FORMAT(name, ...) WeightFormat::name,
    constexpr std::array formats{CAGEFORM_WEIGHT_FORMATS(CAGEFORM_DETAIL_FORMAT)};
#undef CAGEFORM_DETAIL_FORMAT
    if (header.format >= formats.size()) return Status::blob_malformed;
    if (header.points > most || header.handles > most || header.vectors > header.handles)
        return Status::blob_malformed;
    const std::uint64_t blocks = (header.points + lane_count<T> - 1) / lane_count<T>;
    if (header.row_begin != 0 ? header.rows > most
                              : (header.handles != 0 && blocks > header.bytes / header.handles) ||
                                    header.rows != blocks * header.handles)
        return Status::blob_malformed;
    if (header.rows > header.bytes) return Status::blob_malformed;
    Status status = Status::ok;
    for_each_blob_array<T, D>(header, [&](std::uint64_t offset, std::uint64_t bytes, bool wanted) {
        if (!holds_array(header, offset, bytes, wanted)) status = Status::blob_malformed;
    });
    if (status != Status::ok) return status;

    const auto view = view_blob<T, D>(data, header);
    if (view.row_begin != nullptr) {
        if (view.row_begin[0] != 0 || view.row_begin[blocks] != header.rows) return Status::blob_malformed;
        for (std::uint64_t b = 0; b < blocks; ++b) {
            if (view.row_begin[b] > view.row_begin[b + 1]) return Status::blob_malformed;
        }
        std::uint32_t highest = 0;
        for (std::uint64_t r = 0; r < header.rows; ++r)
            highest = view.row_handle[r] > highest ? view.row_handle[r] : highest;
        if (header.rows > 0 && highest >= header.handles) return Status::blob_malformed;
    }
    if (view.order != nullptr) {
        std::uint32_t highest = 0;
        for (std::uint64_t i = 0; i < header.points; ++i)
            highest = view.order[i] > highest ? view.order[i] : highest;
        if (header.points > 0 && highest >= header.points) return Status::blob_malformed;
    }
    return check_handles(view.handle_view(), header.vectors, header.loop_numbers);
}

} // namespace detail

/// Opens a blob in place, for instance in a mapped file. `data` must not change while the binding is
/// used.
///
///   data     at least the blob, aligned to 64 bytes; bytes after it are ignored
///   returns  not_a_blob, blob_version_differs, blob_kind_differs, blob_truncated, blob_corrupt,
///            blob_malformed, blob_of_another_cage, blob_of_another_figure, or ok. Clones of an opened
///            blob never read or write out of bounds, whatever its bytes. BlobCheck::all also detects
///            changed bytes
///   cost     no allocation; reads order, row_begin and row_handle; with BlobCheck::all reads every byte
///            once
template <Scalar T, std::size_t D>
Result<PackedBindingView<T, D>, BlobReport> open_blob(std::span<const std::byte> data,
                                                      const BlobExpectation& expected = {}) noexcept {
    const auto refused = [](Status status) {
        Result<PackedBindingView<T, D>, BlobReport> result;
        result.report.status = status;
        return result;
    };
    BlobHeader header;
    Status status = detail::read_header(data, expected.check, {Status::not_a_blob, sizeof(T), D}, header);
    if (status != Status::ok) return refused(status);
    if (header.version == 1) {
        header.handle_kinds = header.handle_faces = header.vectors = header.handle_loops = 0;
        header.loop_numbers = 0;
    }
    status = detail::check_blob<T, D>(data.data(), header);
    if (status != Status::ok) return refused(status);
    if (expected.cage_hash != 0 && header.cage_hash != expected.cage_hash)
        return refused(Status::blob_of_another_cage);
    if (expected.figure_hash != 0 && header.figure_hash != expected.figure_hash)
        return refused(Status::blob_of_another_figure);
    return {detail::view_blob<T, D>(data.data(), header),
            {Status::ok, header.cage_hash, header.figure_hash, std::size_t(header.bytes)}};
}

/// Owns a blob; made by `pack`. Copying copies all bytes.
template <Scalar T, std::size_t D>
class PackedBinding {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    PackedBinding() = default;
    /// Allocates a blob and sets the offsets and the size in `header`. A non-zero offset in `header`
    /// requests that array. All arrays are zero, and `writable` until `seal` is called. Throws
    /// std::bad_alloc if memory runs out.
    explicit PackedBinding(BlobHeader header) {
        header.scalar_bytes = sizeof(T);
        header.dimension = D;
        std::uint64_t end = sizeof(BlobHeader);
        for_each_blob_array<T, D>(header, [&end](std::uint64_t& offset, std::uint64_t bytes, bool wanted) {
            detail::place_array(end, offset, bytes, wanted);
        });
        header.bytes = end;
        memory_.resize(end);
        std::memcpy(memory_.data(), &header, sizeof(header));
    }
    template <class X>
    X* writable(const X* array_of_view) noexcept {
        return const_cast<X*>(array_of_view); // points into memory_, which is not const
    }
    void seal() noexcept { memory_.seal(); }

    /// Returns the bytes to write to a file; aligned to 64 bytes.
    std::span<const std::byte> bytes() const noexcept { return memory_.bytes(); }
    PackedBindingView<T, D> view() const noexcept {
        if (bytes().empty()) return {};
        BlobHeader header;
        std::memcpy(&header, bytes().data(), sizeof(header));
        return detail::view_blob<T, D>(bytes().data(), header);
    }
    HandleView<T, D> handle_view() const noexcept { return view().handle_view(); }

private:
    detail::PackedMemory memory_;
};

} // namespace cageform::inline CAGEFORM_ABI
