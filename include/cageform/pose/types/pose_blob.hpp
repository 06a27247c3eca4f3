// The binary layout of packed PoseSamples, for a file or a part of a packed figure
// (FigurePackOptions::parts).
//
// The byte order is that of the writing machine, marked by a tag. Each array is given by an offset and begins
// at a multiple of 64 bytes. L = 64 / sizeof(T) clusters form a block; B = ⌈#clusters / L⌉. PoseSamples
// explains the arrays.
//
//     PoseBlobHeader
//     rest_handles     #handles × D × T
//     handle_kinds     #handles × uint8: 0 a point, 1 a vector
//     gradients        B × #handles × D × L × T
//     moments          B × D × D × L × T
//     stiffness        #handles (#handles + 1) / 2 × double
//     weak_handles     #weak_handles × uint32, ascending; absent if empty
//     points           #samples × D × T          optional, as the next two:
//     sample_clusters  #samples × uint32         not needed for frames
//     centres          #clusters × uint32
#pragma once

#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/figure/types/blob.hpp>
#include <cageform/pose/types/pose_samples.hpp>

#include <utility>

namespace cageform::inline CAGEFORM_ABI {

/// The first 192 bytes of packed samples. Offsets are in bytes from the beginning; 0: the array is absent.
struct PoseBlobHeader {
    static constexpr std::uint64_t magic_number = 0x65736F7065676163u; // "cagepose" in little endian
    static constexpr std::uint32_t current_version = 1;

    std::uint64_t magic = magic_number;
    std::uint32_t version = current_version;
    std::uint32_t endian = 0x01020304u;
    std::uint64_t bytes = 0;    ///< size of the whole blob, a multiple of 64
    std::uint64_t checksum = 0; ///< `hash_memory` of all bytes after this field
    std::uint32_t scalar_bytes = 0, dimension = 0;
    std::uint64_t handles = 0, clusters = 0, weak_handle_count = 0;
    std::uint64_t samples = 0; ///< 0: `points`, `sample_clusters` and `centres` are absent
    std::uint64_t cage_hash = 0;
    double centre[3] = {}; ///< PoseSamples::centre, padded by 0 in 2D
    double size = 0;
    std::uint64_t rest_handles = 0, handle_kinds = 0, gradients = 0, moments = 0, stiffness = 0,
                  weak_handles = 0;
    std::uint64_t points = 0, sample_clusters = 0, centres = 0;
    std::uint64_t padding = 0;
};
static_assert(sizeof(PoseBlobHeader) == 192);

struct PosePackOptions {
    /// Whether to pack the points and clusters of the samples, for an editor that draws them.
    bool keep_points = false;
    std::uint64_t cage_hash = 0; ///< stored in the blob; 0: `hash_memory` of the handles at rest
};

/// Owns packed samples; made by `pack`.
class PackedPoseSamples {
public:
    PackedPoseSamples() = default;
    explicit PackedPoseSamples(detail::PackedMemory memory) noexcept
        : memory_(std::move(memory)) {}
    /// Returns the bytes for a file or for `open_pose_samples`, aligned to 64 bytes.
    std::span<const std::byte> bytes() const noexcept { return memory_.bytes(); }

private:
    detail::PackedMemory memory_;
};

namespace detail {

/// Calls visit(offset, part, #elements) for each array of a blob and its part of the samples. Arrays without
/// elements are absent.
template <Scalar T, std::size_t D, class Header, class Samples, class Visit>
void for_each_pose_array(Header& header, Samples& samples, const Visit& visit) {
    const std::uint64_t handles = header.handles, lanes = lane_count<T>;
    const std::uint64_t blocks = (header.clusters + lanes - 1) / lanes;
    visit(header.rest_handles, samples.rest_handles, handles);
    visit(header.handle_kinds, samples.handle_kinds, handles);
    visit(header.gradients, samples.gradients, blocks * handles * D);
    visit(header.moments, samples.moments, blocks * (D * D));
    visit(header.stiffness, samples.stiffness, handles * (handles + 1) / 2);
    visit(header.weak_handles, samples.weak_handles, header.weak_handle_count);
    visit(header.points, samples.points, header.samples);
    visit(header.sample_clusters, samples.clusters, header.samples);
    visit(header.centres, samples.centres, header.samples == 0 ? 0 : header.clusters);
}
template <class X>
constexpr std::uint64_t bytes_of(const std::vector<X>&, std::uint64_t count) noexcept {
    return count * sizeof(X);
}

/// Returns whether all numbers are finite and all indices valid. The sizes of the parts must agree.
template <Scalar T, std::size_t D>
bool is_sound(const PoseSamples<T, D>& samples) noexcept {
    bool sound = samples.size > 0 && is_finite(samples.size) && is_finite(samples.centre);
    for (const auto& h : samples.rest_handles) sound = sound && is_finite(h);
    for (const HandleKind kind : samples.handle_kinds) sound = sound && kind <= HandleKind::vector;
    for (const auto* rows : {&samples.gradients, &samples.moments}) {
        for (const Lanes<T>& row : *rows) {
            for (const T x : row.v) sound = sound && is_finite(x);
        }
    }
    for (const double x : samples.stiffness) sound = sound && is_finite(x);
    for (std::size_t n = 0; n < samples.weak_handles.size(); ++n)
        sound = sound && samples.weak_handles[n] < samples.handle_count() &&
                (n == 0 || samples.weak_handles[n - 1] < samples.weak_handles[n]);
    for (const auto& p : samples.points) sound = sound && is_finite(p);
    for (const std::uint32_t c : samples.clusters) sound = sound && c < samples.cluster_count;
    for (const std::uint32_t s : samples.centres) sound = sound && s < samples.points.size();
    return sound;
}

template <Scalar T, std::size_t D>
Status pack_pose_samples(const PoseSamples<T, D>& samples, const PosePackOptions& options, PackedMemory& to) {
    PoseBlobHeader header;
    header.scalar_bytes = sizeof(T);
    header.dimension = D;
    header.handles = samples.handle_count();
    header.clusters = samples.cluster_count;
    header.weak_handle_count = samples.weak_handles.size();
    header.samples = options.keep_points ? samples.points.size() : 0;
    header.cage_hash = options.cage_hash;
    for (std::size_t k = 0; k < D; ++k) header.centre[k] = samples.centre[k];
    header.size = samples.size;
    if (header.handles == 0 || header.clusters == 0) return Status::samples_missing;
    if (header.handles > samples.most_handles) return Status::too_many_handles;
    if (header.cage_hash == 0)
        header.cage_hash = hash_memory(std::span<const Vec<T, D>>(samples.rest_handles));
    std::uint64_t end = sizeof(PoseBlobHeader);
    bool sound = is_sound(samples) && header.clusters <= 0xFFFFFFFFu && header.samples <= 0xFFFFFFFFu;
    for_each_pose_array<T, D>(header, samples,
                              [&](std::uint64_t& offset, const auto& part, std::uint64_t count) {
                                  sound = sound && (count == 0 || part.size() == count);
                                  place_array(end, offset, bytes_of(part, count), count != 0);
                              });
    if (!sound) return Status::input_malformed;
    header.bytes = end;
    to.resize(end);
    std::memcpy(to.data(), &header, sizeof(header));
    for_each_pose_array<T, D>(
        header, samples, [&](std::uint64_t offset, const auto& part, std::uint64_t count) {
            if (count != 0) std::memcpy(to.data() + offset, part.data(), std::size_t(bytes_of(part, count)));
        });
    to.seal();
    return Status::ok;
}

/// Reads the arrays of a blob with a valid header prefix. Counts of 32 bits and at most 4,096 handles keep
/// the products of `for_each_pose_array` below 2^64.
template <Scalar T, std::size_t D>
Status read_pose_samples(const std::byte* data, const PoseBlobHeader& header, PoseSamples<T, D>& samples) {
    constexpr std::uint64_t most = 0xFFFFFFFFu;
    bool sound = header.handles > 0 && header.handles <= samples.most_handles && header.clusters > 0 &&
                 header.clusters <= most && header.weak_handle_count <= header.handles &&
                 header.samples <= most;
    if (!sound) return Status::blob_malformed;
    for_each_pose_array<T, D>(
        header, samples, [&](std::uint64_t offset, const auto& part, std::uint64_t count) {
            sound = sound && holds_array(header, offset, bytes_of(part, count), count != 0);
        });
    if (!sound) return Status::blob_malformed;
    for_each_pose_array<T, D>(header, samples, [&](std::uint64_t offset, auto& part, std::uint64_t count) {
        part.resize(std::size_t(count));
        if (count != 0) std::memcpy(part.data(), data + offset, std::size_t(bytes_of(part, count)));
    });
    samples.cluster_count = std::size_t(header.clusters);
    for (std::size_t k = 0; k < D; ++k) samples.centre[k] = header.centre[k];
    samples.size = header.size;
    return is_sound(samples) ? Status::ok : Status::blob_malformed;
}

} // namespace detail

/// Packs samples for `open_pose_samples`, bitwise.
///
///   returns  the bytes, empty unless the status is ok; samples_missing; too_many_handles (more than 4,096);
///            input_malformed (parts that do not agree, or a number that is not finite); out_of_memory
///   cost     a copy of all arrays; those with an element per sample only for PosePackOptions::keep_points
template <Scalar T, std::size_t D>
Result<PackedPoseSamples> pack(const PoseSamples<T, D>& samples, const PosePackOptions& options = {}) {
    Result<PackedPoseSamples> result;
    detail::PackedMemory memory;
    result.report = detail::guard_memory([&] { return detail::pack_pose_samples(samples, options, memory); });
    if (result.report == Status::ok) result.value = PackedPoseSamples(std::move(memory));
    return result;
}

/// Reads packed samples for a PoseSolver. Its results equal those with the original samples bit for bit.
/// The points and clusters of the samples are empty unless they were packed.
///
///   data      at least the blob, aligned to 64 bytes; later bytes are ignored
///   expected  as for `open_blob`, without a hash of a figure
///   returns   not_pose_samples, blob_version_differs, blob_kind_differs, blob_truncated, blob_corrupt,
///             blob_malformed, blob_of_another_cage, out_of_memory, or ok: all numbers are finite, and a
///             solver stays in bounds for any bytes
///   cost      a copy of the blob, without further memory; BlobCheck::all reads everything twice
template <Scalar T, std::size_t D>
Result<PoseSamples<T, D>, BlobReport> open_pose_samples(std::span<const std::byte> data,
                                                        const BlobExpectation& expected = {}) noexcept {
    Result<PoseSamples<T, D>, BlobReport> opened;
    Status& status = opened.report.status;
    PoseBlobHeader header;
    status = detail::read_header(data, expected.check, {Status::not_pose_samples, sizeof(T), D}, header);
    if (status != Status::ok) return opened;
    if (expected.cage_hash != 0 && header.cage_hash != expected.cage_hash)
        status = Status::blob_of_another_cage;
    else
        status = detail::guard_memory(
            [&] { return detail::read_pose_samples(data.data(), header, opened.value); });
    if (status != Status::ok) {
        opened.value = {};
        return opened;
    }
    opened.report.cage_hash = header.cage_hash;
    opened.report.bytes = std::size_t(header.bytes);
    return opened;
}

} // namespace cageform::inline CAGEFORM_ABI
