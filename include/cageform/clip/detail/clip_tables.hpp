// Views and checks the tables of a packed clip.
#pragma once

#include <cageform/clip/clip.hpp>
#include <cageform/clip/types/clip_header.hpp>
#include <cageform/core/detail/packed_memory.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

inline bool is_extrapolation(std::uint32_t mode) noexcept {
    return mode <= std::uint32_t(Extrapolation::ping_pong);
}

/// Whether an extrapolation uses `CageClipView::ends`.
inline bool takes_ends(std::uint32_t before, std::uint32_t after) noexcept {
    const auto takes = [](std::uint32_t mode) {
        return mode == std::uint32_t(Extrapolation::linear) ||
               mode == std::uint32_t(Extrapolation::cycle_with_offset);
    };
    return takes(before) || takes(after);
}

/// Calls visit(offset, bytes) for each table of a packed clip; absent tables have 0 bytes.
template <Scalar T, std::size_t D, class Header, class Visit>
void for_each_clip_array(Header& header, const Visit& visit) noexcept {
    visit(header.curve_table, header.curves * sizeof(BankCurve<T>));
    visit(header.knot_table, (header.pieces + header.steps) * sizeof(T));
    visit(header.piece_table, header.pieces * (4 * sizeof(T)));
    visit(header.step_table, header.steps * 8);
    visit(header.entry_table, (header.pieces + header.steps) * sizeof(KnotEvent));
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
    view.origin = header.origin;
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
        (n == 0 ? view.motion.angle_or_phase : view.motion.translation[n - 1]) = TrackView<T>{
            curve, static_cast<Extrapolation>(track.before), static_cast<Extrapolation>(track.after)};
    }
    return view;
}

template <Scalar T>
bool is_finite_piece(const CubicPiece<T>& p) noexcept {
    return is_finite(p.begin) && is_finite(p.c0) && is_finite(p.c1) && is_finite(p.c2) && is_finite(p.c3);
}

/// Whether the curves partition the knots of a bank in order (unquantised curves first), knots ascend,
/// and all numbers are finite, also when decoded.
template <Scalar T>
bool is_valid(const CurveBankView<T>& bank) noexcept {
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

/// Whether the entries of a valid bank list all its knots in order and agree with the clip's times.
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

/// Whether the tracks partition the pieces of a motion in order, with finite ends.
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
bool is_valid(const TrackView<T>& track) noexcept {
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
bool is_valid(const RigidMotionView<T, D>& motion) noexcept {
    bool sound = is_finite(motion.pivot) && is_valid(motion.angle_or_phase);
    for (const TrackView<T>& track : motion.translation) sound = sound && is_valid(track);
    for (const Quaternion<T>& turn : motion.rotations) {
        T square = 0;
        for (const T x : turn) square += x * x;
        sound = sound && square > T(0.98) && square < T(1.02); // length 1 up to rounding
    }
    return sound;
}

/// Checks a header and its tables. Counts that fit in 32 bits keep the sizes in `for_each_clip_array`
/// below 2^64.
template <Scalar T, std::size_t D>
Status check_clip(const std::byte* data, const ClipHeader& header) noexcept {
    bool sound = is_extrapolation(header.before) && is_extrapolation(header.after) &&
                 header.curves % D == 0 && (D == 3 || header.turns == 0) &&
                 (header.motion != 0 || (header.tracks == 0 && header.turns == 0)) &&
                 is_finite(header.origin);
    for (const std::uint64_t count :
         {header.curves, header.pieces, header.steps, header.tracks, header.turns})
        sound = sound && count <= 0xFFFFFFFFu;
    for (const double time : {header.begin, header.end})
        sound = sound && is_finite(time) && std::fabs(time) <= double((std::numeric_limits<T>::max)()) &&
                double(static_cast<T>(time)) == time;
    if (!sound) return Status::blob_malformed;
    for_each_clip_array<T, D>(header, [&](std::uint64_t offset, std::uint64_t bytes) {
        sound = sound && holds_array(header, offset, bytes, bytes != 0);
    });
    if (!sound) return Status::blob_malformed;
    if (header.motion != 0 &&
        !tracks_follow(*reinterpret_cast<const PackedMotion<T, D>*>(data + header.motion), header.tracks))
        return Status::blob_malformed;
    const auto view = view_clip<T, D>(data, header);
    for (const T x : view.ends) sound = sound && is_finite(x);
    sound = sound && is_valid(view.bank) && is_in_order(view) && is_valid(view.motion);
    return sound ? Status::ok : Status::blob_malformed;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
