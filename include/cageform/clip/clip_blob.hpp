// The format of a packed clip: one block of memory that is written to a file, mapped, and played in place.
//
// Byte order is that of the machine that wrote the clip; a field records it. Every table begins at a
// multiple of 64 bytes. The block contains offsets, no pointers. T is the clip's scalar, D its
// dimension. A curve of n pieces has n + 1 knots: the begins of its pieces and the end of the last
// piece. Knots, begin and end are relative to the header's origin; the motion's times are absolute.
//
//     ClipHeader
//     curves        #curves × BankCurve: the coordinates of a vertex are adjacent
//     knots         (#pieces + #steps) × T: the knots of unquantised curves, one curve after the other,
//                   then the knots of quantised curves
//     pieces        #pieces × 4 × T: c0 … c3 for each knot of an unquantised curve; the value at the
//                   time u after the knot is c0 + u (c1 + u (c2 + u c3)), constant after the last knot
//     steps         #steps × 4 × uint16: Bernstein coefficients from each knot of a quantised curve to
//                   the next; integer n means low + n · step. Unused at the last knot of a curve, after
//                   which the value is end_value
//     entries       #knots × KnotEvent: sorted by time, then by the number of the knot
//     ends          3 × #curves × T: slopes at the first time, slopes at the last time, differences of
//                   the end values; only if an extrapolation uses them (linear, cycle_with_offset)
//     motion        PackedMotion; only if the cage is rotated and moved as a whole
//     track_begins  #track_pieces × T: the begins of the motion's pieces, one track after the other
//     track_pieces  #track_pieces × 5 × T: begin, c0 … c3
//     rotations     #rotations × 4 × T: x, y, z, w; only in 3D
//
// An empty table is absent, and its offset is 0.
#pragma once

#include <cageform/clip/clip.hpp>
#include <cageform/clip/detail/clip_tables.hpp>
#include <cageform/clip/types/clip_header.hpp>
#include <cageform/core/detail/packed_memory.hpp>
#include <cageform/core/result.hpp>

namespace cageform::inline CAGEFORM_ABI {

struct OpenClipReport {
    Status status = Status::ok;
    std::size_t bytes = 0; ///< size of the packed clip; other data may follow it
};

/// Opens a packed clip in place, for instance in a mapped file. `data` must not change while the clip
/// is used.
///
///   data     at least the clip, aligned to 64 bytes; bytes after it are ignored
///   check    BlobCheck::structure skips the checksum
///   returns  not_a_clip, blob_version_differs, blob_kind_differs, blob_truncated, blob_corrupt,
///            blob_malformed, or ok: times ascend, all numbers are finite, and rotations have
///            length 1. An opened clip never reads or writes out of bounds, whatever its bytes. If no
///            curve is quantised, it gives the same bits as the clip that was packed
///   cost     no allocation; O(#pieces), about 50 ns each; with BlobCheck::all reads every byte twice
template <Scalar T, std::size_t D>
    requires(D == 2 || D == 3)
Result<CageClipView<T, D>, OpenClipReport> open_clip(std::span<const std::byte> data,
                                                     BlobCheck check = BlobCheck::all) noexcept {
    Result<CageClipView<T, D>, OpenClipReport> opened;
    Status& status = opened.report.status;
    ClipHeader header;
    status = detail::read_header(data, check, {Status::not_a_clip, sizeof(T), D}, header);
    if (status == Status::ok) status = detail::check_clip<T, D>(data.data(), header);
    if (status != Status::ok) return opened;
    opened.value = detail::view_clip<T, D>(data.data(), header);
    opened.report.bytes = static_cast<std::size_t>(header.bytes);
    return opened;
}

/// Owns a packed clip; made by `pack_clip` (animate/pack_clip.hpp). Copying copies all bytes.
template <Scalar T, std::size_t D>
class PackedClip {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    PackedClip() = default;
    /// Packs a clip exactly, without quantising. Throws std::bad_alloc if memory runs out.
    explicit PackedClip(const CageClipView<T, D>& clip) {
        ClipHeader header;
        header.version = clip.origin != 0 ? ClipHeader::current_version : 1;
        header.scalar_bytes = sizeof(T);
        header.dimension = D;
        header.before = std::uint32_t(clip.before);
        header.after = std::uint32_t(clip.after);
        header.curves = clip.bank.size();
        header.pieces = clip.bank.pieces.size();
        header.steps = clip.bank.steps.size();
        header.begin = double(clip.first_time);
        header.end = double(clip.last_time);
        header.origin = clip.origin;
        header.motion = clip.moves ? 1 : 0;
        PackedMotion<T, D> motion;
        motion.pivot = clip.motion.pivot;
        for (std::size_t n = 0; n <= D && clip.moves; ++n) {
            const TrackView<T>& track = track_of(clip, n);
            motion.tracks[n] = {std::uint32_t(header.tracks),
                                std::uint32_t(track.curve.pieces.size()),
                                std::uint32_t(track.before),
                                std::uint32_t(track.after),
                                track.curve.end,
                                track.curve.end_value};
            header.tracks += track.curve.pieces.size();
        }
        header.turns = clip.moves && D == 3 ? clip.motion.rotations.size() : 0;
        std::uint64_t end = sizeof(ClipHeader);
        detail::for_each_clip_array<T, D>(header, [&end](std::uint64_t& offset, std::uint64_t bytes) {
            detail::place_array(end, offset, bytes, bytes != 0);
        });
        header.bytes = end;
        memory_.resize(end);
        write(0, std::span<const ClipHeader>(&header, 1));
        write(header.curve_table, clip.bank.curves);
        write(header.knot_table, clip.bank.knots);
        write(header.piece_table, clip.bank.pieces);
        write(header.step_table, clip.bank.steps);
        write(header.entry_table, clip.bank.entries);
        if (header.ends != 0) write(header.ends, clip.ends);
        if (header.motion != 0) {
            write(header.motion, std::span<const PackedMotion<T, D>>(&motion, 1));
            for (std::size_t n = 0; n <= D; ++n) {
                const auto& curve = track_of(clip, n).curve;
                const std::uint64_t first = motion.tracks[n].first;
                write(header.track_begins + first * sizeof(T), std::span(curve.begins, curve.pieces.size()));
                write(header.track_pieces + first * sizeof(CubicPiece<T>), curve.pieces);
            }
            if (header.turns != 0) write(header.rotations, clip.motion.rotations);
        }
        memory_.seal();
    }

    /// Returns the bytes to write to a file and to pass to `open_clip`, aligned to 64.
    std::span<const std::byte> bytes() const noexcept { return memory_.bytes(); }
    CageClipView<T, D> view() const noexcept {
        if (bytes().empty()) return {};
        ClipHeader header;
        std::memcpy(&header, bytes().data(), sizeof(header));
        return detail::view_clip<T, D>(bytes().data(), header);
    }

private:
    static const TrackView<T>& track_of(const CageClipView<T, D>& clip, std::size_t n) noexcept {
        return n == 0 ? clip.motion.angle_or_phase : clip.motion.translation[n - 1];
    }
    template <class X>
    void write(std::uint64_t offset, std::span<const X> array) noexcept {
        if (!array.empty()) std::memcpy(memory_.data() + offset, array.data(), array.size_bytes());
    }

    detail::PackedMemory memory_;
};

} // namespace cageform::inline CAGEFORM_ABI
