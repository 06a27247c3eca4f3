// A whole figure in memory: bindings of its points and of what gives normals and tangents, labels
// of its handles, and whatever else a game wants beside them. Written to one file, mapped, and
// cloned from where it lies (clone/clone_figure.hpp).
//
// Little or big endian as the machine that made it, told by a tag; every part begins at a multiple
// of 64 bytes from the beginning.
//
//     FigureHeader
//     table    #parts × FigurePart, by ascending offset
//     PNTS     a blob (binding/blob.hpp): the points
//     TAN1     a blob: unit tangents; only where there are normals
//     TAN2     a blob: unit bitangents, the normal is cross(TAN1, TAN2); only in space, with TAN1
//     HAND     #points × int8: 1 or −1, the handedness of the texture; only where the tangents are
//              the figure's own, not just any that make its normals
//     LABL     (#handles + 1) × uint32, ascending: where the label of a handle begins in the
//              characters that follow, and where the last one ends; only where there are labels
//     CLPS     uint64 #clips, #clips × FigureClip, the characters of all names, and packed clips
//              (animate/clip_blob.hpp) that begin at multiples of 64; only where there are clips
//     LVL1 …   packed figures of the same handles: levels of less detail, up to LVL9
//     …        the user's, under tags of their own
//
// The blobs are of the same points in the same order, and of the same handles. Version 1 has no
// clips and levels, and is what figures without them still are: its parts CLPS and LVL1 … LVL9 are
// the user's.
#pragma once

#include <cageform/animate/clip_blob.hpp>
#include <cageform/binding/detail/figure_parts.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Stands for vectors that a figure has none of, or that nobody wants.
struct NoVectors {};

namespace detail {

template <class Range>
inline constexpr bool is_wanted = !std::is_same_v<std::remove_cvref_t<Range>, NoVectors>;

} // namespace detail

/// The labels of handles; owns nothing.
struct HandleLabels {
    const std::uint32_t* begin = nullptr; ///< #handles + 1; null where there are none
    const char* text = nullptr;

    std::string_view operator[](std::size_t handle) const noexcept {
        return begin == nullptr ? std::string_view{}
                                : std::string_view(text + begin[handle], begin[handle + 1] - begin[handle]);
    }
};

/// What `clone` reads of a figure, dense or packed; owns nothing.
template <Scalar T, std::size_t D>
struct PackedFigureView {
    using scalar = T;
    static constexpr std::size_t dimension = D;

    PackedBindingView<T, D> points;
    /// In space tangents and bitangents, whose cross product is the normal; in the plane the
    /// tangent, the normal turned clockwise. Of no weights where there are no normals.
    std::array<PackedBindingView<T, D>, D - 1> tangents;
    const std::int8_t* handedness = nullptr; ///< #points, as bound; null without tangents of its own
    HandleLabels labels;
    std::span<const FigurePart> table; ///< of a packed figure
    const std::byte* data = nullptr;   ///< where that begins
    std::span<const FigureClip> clips; ///< of a packed figure
    std::size_t levels = 0;            ///< of less detail, of a packed figure

    std::size_t handle_count() const noexcept { return points.handle_count(); }
    std::size_t point_count() const noexcept { return points.point_count(); }
    HandleView<T, D> handle_view() const noexcept { return points.handle_view(); }
    /// Where the handles are in the pose at rest, #handles: a pose to begin with.
    std::span<const Vec<T, D>> rest_handles() const noexcept { return {points.rest_handles, handle_count()}; }
    bool has_normals() const noexcept { return tangents[0].rest_handles != nullptr; }
    bool has_tangents() const noexcept { return handedness != nullptr; }

    /// The label of a handle; empty where it has none.
    std::string_view label(std::size_t handle) const noexcept { return labels[handle]; }
    /// The first handle of that label; #handles where there is none. An empty label is that of the
    /// first handle without one. O(#handles).
    std::size_t find_handle(std::string_view label) const noexcept {
        std::size_t handle = 0;
        while (handle < handle_count() && labels[handle] != label) ++handle;
        return handle;
    }

    /// The clips of a packed figure: poses of the vertices of its cage, which are the handles, or
    /// those handles that are points where there are vectors (clone/pose_handles.hpp).
    std::size_t clip_count() const noexcept { return clips.size(); }
    std::string_view clip_name(std::size_t clip) const noexcept {
        CAGEFORM_ASSERT(clip < clip_count(), "a clip of the figure");
        const auto bytes = part(FigureTags::clips).subspan(clips[clip].name, clips[clip].name_bytes);
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    /// The bytes of a clip, as `open_clip` and `pack` take them.
    std::span<const std::byte> clip_bytes(std::size_t clip) const noexcept {
        CAGEFORM_ASSERT(clip < clip_count(), "a clip of the figure");
        return part(FigureTags::clips).subspan(clips[clip].offset, clips[clip].bytes);
    }
    /// As `open_clip` gives it.
    CageClipView<T, D> clip(std::size_t clip) const noexcept {
        const std::byte* const begin = clip_bytes(clip).data();
        ClipHeader header;
        std::memcpy(&header, begin, sizeof(header));
        return detail::view_clip<T, D>(begin, header);
    }
    /// The first clip of that name; #clips where there is none.
    std::size_t find_clip(std::string_view name) const noexcept {
        std::size_t clip = 0;
        while (clip < clip_count() && clip_name(clip) != name) ++clip;
        return clip;
    }

    /// How many levels of less detail a packed figure has; `open_level` opens them.
    std::size_t level_count() const noexcept { return levels; }

    /// The bytes of a part, at a multiple of 64; none where there is no such part.
    std::span<const std::byte> part(FigureTag tag) const noexcept {
        for (const FigurePart& line : table) {
            if (line.tag == tag) return {data + line.offset, static_cast<std::size_t>(line.bytes)};
        }
        return {};
    }
    /// The same as an array: of #bytes / sizeof(X), whatever is in it.
    template <class X>
        requires std::is_trivially_copyable_v<X> std::span<const X> part_as(FigureTag tag)
    const noexcept {
        const auto bytes = part(tag);
        return {reinterpret_cast<const X*>(bytes.data()), bytes.size() / sizeof(X)};
    }
};

struct OpenReport : BlobReport {
    FigureTag culprit; ///< the part that the status is about; 0: the figure as a whole
};

namespace detail {

/// Whether a table that is known to be within the figure names parts that are, one after the other.
inline bool is_sound(std::span<const FigurePart> table, std::uint64_t bytes) noexcept {
    std::uint64_t end = sizeof(FigureHeader) + table.size_bytes();
    for (std::size_t n = 0; n < table.size(); ++n) {
        const FigurePart& part = table[n];
        if (part.offset % 64 != 0 || part.offset < end || part.offset > bytes ||
            part.bytes > bytes - part.offset)
            return false;
        end = part.offset + part.bytes;
        for (const FigurePart& other : table.first(n)) {
            if (other.tag == part.tag) return false;
        }
    }
    return true;
}

/// Whether the handles at rest are the same, to the bit.
template <Scalar T, std::size_t D>
bool same_handles(const HandleView<T, D>& a, const HandleView<T, D>& b) noexcept {
    const auto same = []<class X>(const X* p, const X* q, std::size_t count) {
        return p == q || (p != nullptr && q != nullptr && std::memcmp(p, q, count * sizeof(X)) == 0);
    };
    return a.count == b.count && same(a.rest, b.rest, a.count) && same(a.kinds, b.kinds, a.count) &&
           same(a.faces, b.faces, a.vector_count());
}

/// Opens the bindings of a figure whose table is sound.
template <Scalar T, std::size_t D>
Status open_bindings(Result<PackedFigureView<T, D>, OpenReport>& opened,
                     const BlobExpectation& expected) noexcept {
    const auto open = [&opened](FigureTag tag, const BlobExpectation& wanted) {
        opened.report.culprit = tag;
        return open_blob<T, D>(opened.value.part(tag), wanted);
    };
    const auto points =
        open(FigureTags::points, {expected.cage_hash, expected.figure_hash, BlobCheck::structure});
    if (!points) return points.status();
    opened.value.points = points.value;
    opened.report.cage_hash = points.report.cage_hash;
    opened.report.figure_hash = points.report.figure_hash;
    const std::array<FigureTag, 2> tags{FigureTags::tangents, FigureTags::bitangents};
    const bool wanted = opened.value.part(tags[0]).data() != nullptr;
    for (std::size_t k = 0; k < 2; ++k) {
        const bool there = opened.value.part(tags[k]).data() != nullptr;
        opened.report.culprit = tags[k];
        if (there != (wanted && k + 1 < D)) return Status::blob_malformed;
        if (!there) continue;
        const auto vectors = open(tags[k], {0, 0, BlobCheck::structure});
        if (!vectors) return vectors.status();
        if (vectors.report.cage_hash != points.report.cage_hash ||
            !bindings_match(points.value, vectors.value) ||
            !same_handles(points.value.handle_view(), vectors.value.handle_view()))
            return Status::bindings_differ;
        opened.value.tangents[k] = vectors.value;
    }
    return Status::ok;
}

/// The parts of a figure that are no bindings.
template <Scalar T, std::size_t D>
Status open_tables(Result<PackedFigureView<T, D>, OpenReport>& opened) noexcept {
    auto& figure = opened.value;
    opened.report.culprit = FigureTags::handedness;
    if (const auto signs = figure.template part_as<std::int8_t>(opened.report.culprit);
        signs.data() != nullptr) {
        if (signs.size() != figure.point_count() || !figure.has_normals()) return Status::blob_malformed;
        for (const std::int8_t sign : signs) {
            if (sign != 1 && sign != -1) return Status::blob_malformed;
        }
        figure.handedness = signs.data();
    }
    opened.report.culprit = FigureTags::labels;
    const auto begin = figure.template part_as<std::uint32_t>(opened.report.culprit);
    if (begin.data() == nullptr) return Status::ok;
    const std::size_t handles = figure.handle_count();
    if (begin.size() <= handles || begin[0] != 0) return Status::blob_malformed;
    const auto bytes = figure.part(opened.report.culprit);
    for (std::size_t i = 0; i < handles; ++i) {
        if (begin[i] > begin[i + 1]) return Status::blob_malformed;
    }
    const std::size_t text = (handles + 1) * sizeof(std::uint32_t);
    if (begin[handles] > bytes.size() - text) return Status::blob_malformed;
    figure.labels = {begin.data(), reinterpret_cast<const char*>(bytes.data() + text)};
    return Status::ok;
}

/// Whether a clip poses the vertices of a cage: all handles, or those that are points.
template <Scalar T, std::size_t D>
Status check_clip_of(const Result<CageClipView<T, D>, OpenClipReport>& clip,
                     const HandleView<T, D>& handles) noexcept {
    if (!clip) return clip.status();
    const std::size_t vertices = clip.value.vertex_count();
    return vertices == handles.count || vertices + handles.vector_count() == handles.count
               ? Status::ok
               : Status::blob_of_another_cage;
}

template <Scalar T, std::size_t D>
Status open_clips(Result<PackedFigureView<T, D>, OpenReport>& opened) noexcept {
    opened.report.culprit = FigureTags::clips;
    const auto bytes = opened.value.part(opened.report.culprit);
    if (bytes.data() == nullptr) return Status::ok;
    std::uint64_t count = 0;
    if (bytes.size() < sizeof(count)) return Status::blob_malformed;
    std::memcpy(&count, bytes.data(), sizeof(count));
    if (count > (bytes.size() - sizeof(count)) / sizeof(FigureClip)) return Status::blob_malformed;
    opened.value.clips = {reinterpret_cast<const FigureClip*>(bytes.data() + sizeof(count)),
                          static_cast<std::size_t>(count)};
    std::uint64_t end = sizeof(count) + count * sizeof(FigureClip); // clips lie one after the other
    for (const FigureClip& clip : opened.value.clips) {
        if (clip.name > bytes.size() || clip.name_bytes > bytes.size() - clip.name || clip.offset < end ||
            clip.offset > bytes.size() || clip.bytes > bytes.size() - clip.offset)
            return Status::blob_malformed;
        end = clip.offset + clip.bytes;
        const auto packed = bytes.subspan(std::size_t(clip.offset), std::size_t(clip.bytes));
        const Status status =
            check_clip_of(open_clip<T, D>(packed, BlobCheck::structure), opened.value.handle_view());
        if (status != Status::ok) return status;
    }
    return Status::ok;
}

template <Scalar T, std::size_t D>
Result<PackedFigureView<T, D>, OpenReport> open_figure_within(std::span<const std::byte> data,
                                                              const BlobExpectation& expected,
                                                              bool may_have_levels) noexcept;

/// Levels are figures of the same handles, without levels of their own.
template <Scalar T, std::size_t D>
Status open_levels(Result<PackedFigureView<T, D>, OpenReport>& opened, bool may_have_levels) noexcept {
    for (std::size_t n = 1; n <= FigureTags::most_levels; ++n) {
        opened.report.culprit = FigureTags::level(n);
        const auto bytes = opened.value.part(opened.report.culprit);
        if (bytes.data() == nullptr) continue;
        if (!may_have_levels || opened.value.levels + 1 < n) return Status::blob_malformed;
        const auto level = open_figure_within<T, D>(bytes, {0, 0, BlobCheck::structure}, false);
        if (!level) return level.status();
        if (!same_handles(level.value.handle_view(), opened.value.handle_view()))
            return Status::blob_of_another_cage;
        opened.value.levels = n;
    }
    return Status::ok;
}

template <Scalar T, std::size_t D>
Result<PackedFigureView<T, D>, OpenReport> open_figure_within(std::span<const std::byte> data,
                                                              const BlobExpectation& expected,
                                                              bool may_have_levels) noexcept {
    Result<PackedFigureView<T, D>, OpenReport> opened;
    const auto refused = [&opened](Status status) {
        Result<PackedFigureView<T, D>, OpenReport> result;
        result.report.status = status;
        result.report.culprit = opened.report.culprit;
        return result;
    };
    Status status = check_prefix(data, prefix_of(FigureHeader{}), sizeof(FigureHeader), expected.check,
                                 Status::not_a_figure);
    if (status != Status::ok) return refused(status);
    FigureHeader header;
    std::memcpy(&header, data.data(), sizeof(header));
    if (header.scalar_bytes != sizeof(T) || header.dimension != D) return refused(Status::blob_kind_differs);
    if (header.parts > FigureHeader::most_parts ||
        header.parts * sizeof(FigurePart) > header.bytes - sizeof(header))
        return refused(Status::blob_malformed);
    opened.value.data = data.data();
    opened.value.table = {reinterpret_cast<const FigurePart*>(data.data() + sizeof(header)), header.parts};
    if (!is_sound(opened.value.table, header.bytes)) return refused(Status::blob_malformed);
    status = open_bindings(opened, expected);
    if (status == Status::ok) status = open_tables(opened);
    if (status == Status::ok && header.version > 1) status = open_clips(opened);
    if (status == Status::ok && header.version > 1) status = open_levels(opened, may_have_levels);
    if (status != Status::ok) return refused(status);
    opened.report.culprit = {};
    opened.report.bytes = static_cast<std::size_t>(header.bytes);
    return opened;
}

} // namespace detail

/// Opens a packed figure, or a single packed binding, where it lies, in a mapped file for instance; `data`
/// must stay as it is while the figure is used. A single binding becomes a figure of points alone.
///
///   data      at least the figure, aligned to 64 bytes; what follows it is left alone
///   expected  as for `open_blob`; the hashes are those of the points' blob
///   returns   not_a_figure, not_a_blob, not_a_clip; blob_version_differs, blob_kind_differs, blob_truncated, blob_corrupt,
///             blob_malformed, blob_of_another_cage, blob_of_another_figure, of the figure or of
///             the part `culprit`; bindings_differ, where a part is of other points or handles than
///             the first, or in another order; or ok. A clip is of another cage where it has another
///             number of vertices, a level where it has other handles. What was opened never reads or
///             writes out of bounds, whatever the bytes. What the parts of the user hold is not
///             looked at
///   cost      no allocation; with BlobCheck::all reads everything once, else the tables and the
///             clips
template <Scalar T, std::size_t D>
    requires(D == 2 || D == 3)
Result<PackedFigureView<T, D>, OpenReport> open(std::span<const std::byte> data,
                                                const BlobExpectation& expected = {})
noexcept {
    std::uint64_t magic = 0;
    if (data.size() >= sizeof(magic)) std::memcpy(&magic, data.data(), sizeof(magic));
    if (magic != BlobHeader::magic_number) return detail::open_figure_within<T, D>(data, expected, true);
    const auto blob = open_blob<T, D>(data, expected);
    Result<PackedFigureView<T, D>, OpenReport> opened;
    opened.value.points = blob.value;
    static_cast<BlobReport&>(opened.report) = blob.report;
    return opened;
}

/// A level of less detail of a figure that `open` gave: another figure of the same cage, which
/// the same poses and clips move.
///
///   level    0: the figure itself; up to PackedFigureView::level_count
///   returns  as `open`; not_a_figure where there is no such level. No allocation; reads the
///            tables of that level
template <Scalar T, std::size_t D>
Result<PackedFigureView<T, D>, OpenReport> open_level(const PackedFigureView<T, D>& figure,
                                                      std::size_t level) noexcept {
    if (level == 0) {
        Result<PackedFigureView<T, D>, OpenReport> itself;
        itself.value = figure;
        return itself;
    }
    const auto bytes =
        level > figure.level_count() ? std::span<const std::byte>{} : figure.part(FigureTags::level(level));
    return detail::open_figure_within<T, D>(bytes, {0, 0, BlobCheck::structure}, false);
}

/// The owner of a packed figure; made by `pack`. Copies are whole figures.
template <Scalar T, std::size_t D>
class PackedFigure {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    PackedFigure() = default;
    /// Puts parts together, in their order. std::bad_alloc where there is no memory.
    explicit PackedFigure(std::span<const FigurePartData> parts) {
        const auto whole = [](std::size_t bytes) { return (bytes + 63) / 64 * 64; };
        const std::size_t table = sizeof(FigureHeader) + parts.size() * sizeof(FigurePart);
        FigureHeader header;
        header.scalar_bytes = sizeof(T);
        header.dimension = D;
        header.parts = static_cast<std::uint32_t>(parts.size());
        header.version = 1;
        for (const auto& part : parts) {
            if (FigureTags::is_since_version_2(part.tag)) header.version = 2;
        }
        std::size_t end = whole(table);
        for (const auto& part : parts) end += whole(part.bytes.size());
        header.bytes = end;
        memory_.resize(end);
        std::byte* const data = memory_.data();
        end = whole(table);
        for (std::size_t n = 0; n < parts.size(); ++n) {
            const FigurePart line{parts[n].tag, 0, end, parts[n].bytes.size()};
            std::memcpy(data + sizeof(header) + n * sizeof(line), &line, sizeof(line));
            if (line.bytes > 0) std::memcpy(data + end, parts[n].bytes.data(), parts[n].bytes.size());
            end += whole(parts[n].bytes.size());
        }
        std::memcpy(data, &header, sizeof(header));
        memory_.seal();
    }

    /// What to write to a file, and what `open` takes: aligned to 64 bytes.
    std::span<const std::byte> bytes() const noexcept { return memory_.bytes(); }

private:
    detail::PackedMemory memory_;
};

} // namespace cageform::inline CAGEFORM_ABI
