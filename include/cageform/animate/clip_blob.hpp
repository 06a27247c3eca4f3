// The format of a packed clip: one block of memory that is written to a file, mapped, and played in place.
//
// Numbers have the byte order of the machine that made it, which a tag records. Every table begins at
// a multiple of 64 bytes; there are offsets, no pointers. T is the clip's scalar, D its dimension. A
// curve of n pieces has n + 1 knots: the begins of its pieces, and the end of the last one.
//
//     ClipHeader
//     curves        #curves × BankCurve: the coordinates of a vertex are adjacent
//     knots         (#pieces + #steps) × T: the knots of unquantised curves, one curve after the other,
//                   then the knots of quantised curves
//     pieces        #pieces × 4 × T: c0 … c3 for each knot of an unquantised curve; the value at the
//                   time u after the knot is c0 + u (c1 + u (c2 + u c3)), constant after the last knot
//     steps         #steps × 4 × uint16: Bernstein coefficients from each knot of a quantised curve to
//                   the next; n stands for low + n · step of the curve. Unused at the last knot of a
//                   curve, from which on the value is end_value
//     entries       #knots × BankEntry: sorted by time, then by the number of the knot
//     ends          3 × #curves × T: all slopes at the first time, all slopes at the last, all rises
//                   between them; only if an extrapolation uses them (linear, cycle_with_offset)
//     motion        PackedMotion; only if the cage is rotated and moved as a whole
//     track_begins  #track_pieces × T: the begins of the motion's pieces, one track after the other
//     track_pieces  #track_pieces × 5 × T: begin, c0 … c3
//     rotations     #rotations × 4 × T: x, y, z, w; only in space
//
// An empty table is absent, and its offset is 0.
#pragma once

#include <cageform/animate/clip.hpp>
#include <cageform/core/detail/packed_memory.hpp>
#include <cageform/core/result.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The first 192 bytes of a packed clip. Offsets are in bytes from its beginning.
struct ClipHeader {
    static constexpr std::uint64_t magic_number = 0x70696C6365676163u; // "cageclip" in little endian
    static constexpr std::uint32_t current_version = 1;

    std::uint64_t magic = magic_number;
    std::uint32_t version = current_version;
    std::uint32_t endian = 0x01020304u;
    std::uint64_t bytes = 0;    ///< of the whole clip, a multiple of 64
    std::uint64_t checksum = 0; ///< `hash_memory` of all bytes after this field
    std::uint32_t scalar_bytes = 0, dimension = 0;
    std::uint32_t before = 0, after = 0; ///< Extrapolation
    std::uint64_t curves = 0, pieces = 0, steps = 0;
    double begin = 0, end = 0; ///< times, representable in T
    std::uint64_t curve_table = 0, knot_table = 0, piece_table = 0, step_table = 0, entry_table = 0, ends = 0;
    std::uint64_t motion = 0, tracks = 0, turns = 0; ///< tracks: #track_pieces, turns: #rotations
    std::uint64_t track_begins = 0, track_pieces = 0, rotations = 0;
    std::uint64_t padding = 0;
};
static_assert(sizeof(ClipHeader) == 192);

/// A track of a packed motion; its pieces follow those of the track before. A track without pieces
/// has no effect.
template <Scalar T>
struct PackedTrack {
    std::uint32_t first = 0, pieces = 0;
    std::uint32_t before = 0, after = 0; ///< Extrapolation
    T end = 0, end_value = 0;
};

/// A RigidMotion.
template <Scalar T, std::size_t D>
struct PackedMotion {
    std::array<PackedTrack<T>, 1 + D> tracks; ///< the rotation, and the translation along each axis
    Vec<T, D> pivot{};
};

struct OpenClipReport {
    Status status = Status::ok;
    std::size_t bytes = 0; ///< size of the packed clip; other data may follow it
};

namespace detail {

inline bool is_extrapolation(std::uint32_t mode) noexcept {
    return mode <= std::uint32_t(Extrapolation::ping_pong);
}

/// Whether one of a clip's extrapolations uses slopes or rises.
inline bool takes_ends(std::uint32_t before, std::uint32_t after) noexcept {
    const auto takes = [](std::uint32_t mode) {
        return mode == std::uint32_t(Extrapolation::linear) ||
               mode == std::uint32_t(Extrapolation::cycle_with_offset);
    };
    return takes(before) || takes(after);
}

/// Visits the tables of a packed clip: visit(offset, bytes). Tables of 0 bytes are absent.
template <Scalar T, std::size_t D, class Header, class Visit>
void for_each_clip_part(Header& header, const Visit& visit) noexcept {
    visit(header.curve_table, header.curves * sizeof(BankCurve<T>));
    visit(header.knot_table, (header.pieces + header.steps) * sizeof(T));
    visit(header.piece_table, header.pieces * (4 * sizeof(T)));
    visit(header.step_table, header.steps * 8);
    visit(header.entry_table, (header.pieces + header.steps) * sizeof(BankEntry));
    visit(header.ends, takes_ends(header.before, header.after) ? header.curves * (3 * sizeof(T)) : 0);
    visit(header.motion, header.motion != 0 ? sizeof(PackedMotion<T, D>) : 0);
    visit(header.track_begins, header.tracks * sizeof(T));
    visit(header.track_pieces, header.tracks * sizeof(CubicPiece<T>));
    visit(header.rotations, header.turns * sizeof(Quaternion<T>));
}

template <Scalar T, std::size_t D>
CageClipView<T, D> view_clip(const std::byte* data, const ClipHeader& header) noexcept {
    CageClipView<T, D> view;
    const auto find = [data]<class X>(std::span<const X>& part, std::uint64_t offset, std::uint64_t count) {
        if (offset != 0) part = {reinterpret_cast<const X*>(data + offset), static_cast<std::size_t>(count)};
    };
    find(view.bank.curves, header.curve_table, header.curves);
    find(view.bank.knots, header.knot_table, header.pieces + header.steps);
    find(view.bank.pieces, header.piece_table, header.pieces);
    find(view.bank.steps, header.step_table, header.steps);
    find(view.bank.entries, header.entry_table, header.pieces + header.steps);
    find(view.ends, header.ends, 3 * header.curves);
    view.first_time = static_cast<T>(header.begin);
    view.last_time = static_cast<T>(header.end);
    view.before = static_cast<Extrapolation>(header.before);
    view.after = static_cast<Extrapolation>(header.after);
    view.moves = header.motion != 0;
    if (!view.moves) return view;
    std::span<const T> begins;
    std::span<const CubicPiece<T>> pieces;
    find(begins, header.track_begins, header.tracks);
    find(pieces, header.track_pieces, header.tracks);
    find(view.motion.rotations, header.rotations, header.turns);
    const auto& motion = *reinterpret_cast<const PackedMotion<T, D>*>(data + header.motion);
    view.motion.pivot = motion.pivot;
    for (std::size_t n = 0; n <= D; ++n) {
        const PackedTrack<T>& track = motion.tracks[n];
        if (track.pieces == 0) continue;
        const PiecewiseCubicView<T> curve{pieces.subspan(track.first, track.pieces),
                                          begins.data() + track.first, track.end, track.end_value};
        (n == 0 ? view.motion.turn : view.motion.translation[n - 1]) = TrackView<T>{
            curve, static_cast<Extrapolation>(track.before), static_cast<Extrapolation>(track.after)};
    }
    return view;
}

template <Scalar T>
bool is_finite_piece(const CubicPiece<T>& p) noexcept {
    return is_finite(p.begin) && is_finite(p.c0) && is_finite(p.c1) && is_finite(p.c2) && is_finite(p.c3);
}

/// Whether the curves of a bank share out its knots in order (unquantised curves, then quantised
/// ones), knots ascend, and all numbers are finite, also when decoded.
template <Scalar T>
bool is_sound(const CurveBankView<T>& bank) noexcept {
    std::array<std::size_t, 2> next{0, bank.pieces.size()}, end{bank.pieces.size(), bank.knots.size()};
    for (std::size_t k = 0; k < bank.size(); ++k) {
        const BankCurve<T>& curve = bank.curves[k];
        const std::size_t format = bank.is_quantised(k) ? 1 : 0, first = next[format];
        if (curve.first_knot != first || curve.knots < 2 || curve.knots > end[format] - first ||
            !is_finite(curve.end_value) || !is_finite(curve.low) || !is_finite(curve.step))
            return false;
        next[format] += curve.knots;
        for (std::size_t n = 0; n < curve.knots; ++n) {
            if (!is_finite(bank.knots[first + n]) || !is_finite_piece(bank.piece(k, n))) return false;
        }
        for (std::size_t n = 1; n < curve.knots; ++n) {
            const T before = bank.knots[first + n - 1], knot = bank.knots[first + n];
            if (!(n + 1 < curve.knots ? before < knot : before <= knot)) return false;
        }
        const auto [begin, c0, c1, c2, c3] = bank.piece(k, curve.knots - 1);
        if (c0 != curve.end_value || c1 != 0 || c2 != 0 || c3 != 0) return false;
    }
    return next == end;
}

/// Whether the entries of a valid bank are all of its knots, in order, and agree with the clip's times.
template <Scalar T, std::size_t D>
bool is_in_order(const CageClipView<T, D>& clip) noexcept {
    const auto& bank = clip.bank;
    const std::size_t count = bank.entries.size();
    if (count == 0) return clip.first_time == 0 && clip.last_time == 0;
    const auto time = [&](std::size_t n) { return bank.knots[bank.entries[n].knot]; };
    for (std::size_t n = 0; n < count; ++n) {
        const auto [knot, curve] = bank.entries[n];
        if (curve >= bank.size() || knot < bank.curves[curve].first_knot ||
            knot - bank.curves[curve].first_knot >= bank.curves[curve].knots)
            return false;
        if (n == 0 || time(n - 1) < time(n)) continue;
        if (time(n - 1) > time(n) || bank.entries[n - 1].knot >= knot) return false;
    }
    const T last = clip.last_time, after = std::nextafter(last, (std::numeric_limits<T>::max)());
    return is_finite(last - clip.first_time) && clip.first_time == time(0) &&
           (last == time(count - 1) || after == time(count - 1)) && clip.first_time <= last;
}

/// Whether the tracks of a motion share out its pieces in order, and their ends are finite.
template <Scalar T, std::size_t D>
bool tracks_follow(const PackedMotion<T, D>& motion, std::uint64_t pieces) noexcept {
    std::uint64_t first = 0;
    for (const PackedTrack<T>& track : motion.tracks) {
        if (track.first != first || track.pieces > pieces - first || !is_extrapolation(track.before) ||
            !is_extrapolation(track.after) || !is_finite(track.end) || !is_finite(track.end_value))
            return false;
        first += track.pieces;
    }
    return first == pieces;
}

/// Whether the pieces of a track ascend and are finite.
template <Scalar T>
bool is_sound(const TrackView<T>& track) noexcept {
    const auto pieces = track.curve.pieces;
    const T *const begins = track.curve.begins, end = track.curve.end;
    bool sound = pieces.empty() || is_finite(end - begins[0]);
    for (std::size_t n = 0; n < pieces.size() && sound; ++n) {
        sound = is_finite_piece(pieces[n]) && pieces[n].begin == begins[n] &&
                (n + 1 < pieces.size() ? begins[n] < begins[n + 1] : begins[n] <= end);
    }
    return sound;
}
template <Scalar T, std::size_t D>
bool is_sound(const RigidMotionView<T, D>& motion) noexcept {
    bool sound = is_finite(motion.pivot) && is_sound(motion.turn);
    for (const TrackView<T>& track : motion.translation) sound = sound && is_sound(track);
    for (const Quaternion<T>& turn : motion.rotations) {
        T square = 0;
        for (const T x : turn) square += x * x;
        sound = sound && square > T(0.98) && square < T(1.02); // length 1 up to rounding
    }
    return sound;
}

/// Checks a header and its tables. Counts must fit in 32 bits, so that the sizes in
/// `for_each_clip_part` stay below 2^64.
template <Scalar T, std::size_t D>
Status check_clip(const std::byte* data, const ClipHeader& header) noexcept {
    bool sound = is_extrapolation(header.before) && is_extrapolation(header.after) &&
                 header.curves % D == 0 && (D == 3 || header.turns == 0) &&
                 (header.motion != 0 || (header.tracks == 0 && header.turns == 0));
    for (const std::uint64_t count :
         {header.curves, header.pieces, header.steps, header.tracks, header.turns})
        sound = sound && count <= 0xFFFFFFFFu;
    for (const double time : {header.begin, header.end})
        sound = sound && is_finite(time) && std::fabs(time) <= double((std::numeric_limits<T>::max)()) &&
                double(static_cast<T>(time)) == time;
    if (!sound) return Status::blob_malformed;
    for_each_clip_part<T, D>(header, [&](std::uint64_t offset, std::uint64_t bytes) {
        if ((offset != 0) != (bytes != 0) || offset % 64 != 0 ||
            (offset != 0 && offset < sizeof(ClipHeader)) || offset > header.bytes ||
            bytes > header.bytes - offset)
            sound = false;
    });
    if (!sound) return Status::blob_malformed;
    if (header.motion != 0 &&
        !tracks_follow(*reinterpret_cast<const PackedMotion<T, D>*>(data + header.motion), header.tracks))
        return Status::blob_malformed;
    const auto view = view_clip<T, D>(data, header);
    for (const T x : view.ends) sound = sound && is_finite(x);
    sound = sound && is_sound(view.bank) && is_in_order(view) && is_sound(view.motion);
    return sound ? Status::ok : Status::blob_malformed;
}

} // namespace detail

/// Opens a packed clip in place, for example in a mapped file; `data` must stay unchanged while the
/// clip is in use.
///
///   data     at least the clip, aligned to 64 bytes; bytes after it are ignored
///   check    BlobCheck::structure skips the checksum
///   returns  not_a_clip, blob_version_differs, blob_kind_differs, blob_truncated, blob_corrupt,
///            blob_malformed, or ok: times ascend, all numbers are finite, and rotations have
///            length 1. An opened clip never reads or writes out of bounds, whatever the bytes, and
///            gives the same bits as the clip that was packed, if nothing was quantised
///   cost     no allocation; O(#pieces), some 50 ns each; with BlobCheck::all reads everything twice
template <Scalar T, std::size_t D>
    requires(D == 2 || D == 3)
Result<CageClipView<T, D>, OpenClipReport> open_clip(std::span<const std::byte> data,
                                                     BlobCheck check = BlobCheck::all)
noexcept {
    Result<CageClipView<T, D>, OpenClipReport> opened;
    Status& status = opened.report.status;
    status = detail::check_prefix(data, detail::prefix_of(ClipHeader{}), sizeof(ClipHeader), check,
                                  Status::not_a_clip);
    if (status != Status::ok) return opened;
    ClipHeader header;
    std::memcpy(&header, data.data(), sizeof(header));
    status = header.scalar_bytes != sizeof(T) || header.dimension != D
                 ? Status::blob_kind_differs
                 : detail::check_clip<T, D>(data.data(), header);
    if (status != Status::ok) return opened;
    opened.value = detail::view_clip<T, D>(data.data(), header);
    opened.report.bytes = static_cast<std::size_t>(header.bytes);
    return opened;
}

/// Owns a packed clip; made by `pack_clip` (animate/pack_clip.hpp). A copy copies all bytes.
template <Scalar T, std::size_t D>
class PackedClip {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    PackedClip() = default;
    /// Packs a clip exactly, without quantising. Throws std::bad_alloc if memory runs out.
    explicit PackedClip(const CageClipView<T, D>& clip) {
        ClipHeader header;
        header.scalar_bytes = sizeof(T);
        header.dimension = D;
        header.before = std::uint32_t(clip.before);
        header.after = std::uint32_t(clip.after);
        header.curves = clip.bank.size();
        header.pieces = clip.bank.pieces.size();
        header.steps = clip.bank.steps.size();
        header.begin = double(clip.first_time);
        header.end = double(clip.last_time);
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
        detail::for_each_clip_part<T, D>(header, [&end](std::uint64_t& offset, std::uint64_t bytes) {
            offset = bytes != 0 ? end : 0;
            end += (bytes + 63) / 64 * 64;
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

    /// The bytes to write to a file and to give to `open_clip`, aligned to 64 bytes.
    std::span<const std::byte> bytes() const noexcept { return memory_.bytes(); }
    CageClipView<T, D> view() const noexcept {
        if (bytes().empty()) return {};
        ClipHeader header;
        std::memcpy(&header, bytes().data(), sizeof(header));
        return detail::view_clip<T, D>(bytes().data(), header);
    }

private:
    static const TrackView<T>& track_of(const CageClipView<T, D>& clip, std::size_t n) noexcept {
        return n == 0 ? clip.motion.turn : clip.motion.translation[n - 1];
    }
    template <class X>
    void write(std::uint64_t offset, std::span<const X> part) noexcept {
        if (!part.empty()) std::memcpy(memory_.data() + offset, part.data(), part.size_bytes());
    }

    detail::PackedMemory memory_;
};

} // namespace cageform::inline CAGEFORM_ABI
