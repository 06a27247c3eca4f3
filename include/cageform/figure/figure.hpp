// A packed figure: bindings of its points and tangents, labels of its handles, clips, levels, and custom
// parts. It is written to one file, mapped, and cloned in place (clone/clone_figure.hpp).
//
// Byte order is that of the machine that wrote the figure; a field records it. Every part begins at a
// multiple of 64 bytes.
//
//     FigureHeader
//     table    #parts × FigurePart, by ascending offset
//     PNTS     a blob (figure/types/blob.hpp): the points
//     TAN1     a blob: unit tangents; only if there are normals
//     TAN2     a blob: unit bitangents; the normal is cross(TAN1, TAN2); only in 3D, with TAN1
//     HAND     #points × int8: 1 or −1, the handedness of the texture; only if the figure was bound
//              with its own tangents
//     LABL     (#handles + 1) × uint32, ascending: the beginning of each handle's label in the
//              characters that follow, and the end of the last label; only if there are labels
//     CLPS     uint64 #clips, #clips × FigureClip, the characters of all names, and packed clips
//              (clip/clip_blob.hpp) that begin at multiples of 64; only if there are clips
//     LVL1 …   packed figures of the same handles: levels of less detail, up to LVL9
//     ORIG     D × double, optional: the origin of the coordinates of points, handles and clips
//     …        custom parts, with other tags
//
// All blobs have the same points in the same order, and the same handles. Version 1 has no clips and
// levels. Figures without clips and levels are written as version 1; in version 1, the parts CLPS and
// LVL1 … LVL9 are custom parts.
#pragma once

#include <cageform/clip/clip_blob.hpp>
#include <cageform/figure/detail/figure_opener.hpp>
#include <cageform/figure/types/figure_parts.hpp>
#include <cageform/figure/types/no_vectors.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A non-owning view of the labels of handles.
struct HandleLabels {
    const std::uint32_t* begin = nullptr; ///< #handles + 1; null if there are none
    const char* text = nullptr;

    std::string_view operator[](std::size_t handle) const noexcept {
        return begin == nullptr ? std::string_view{}
                                : std::string_view(text + begin[handle], begin[handle + 1] - begin[handle]);
    }
};

/// The input of `clone`: a non-owning view of a figure, dense or packed.
template <Scalar T, std::size_t D>
struct PackedFigureView {
    using scalar = T;
    static constexpr std::size_t dimension = D;

    PackedBindingView<T, D> points;
    /// 3D: tangents and bitangents; their cross product is the normal. 2D: tangents; the normal is the
    /// tangent rotated clockwise. Empty if there are no normals.
    std::array<PackedBindingView<T, D>, D - 1> tangents;
    /// #points, in the order of the input; null unless the figure was bound with its own tangents.
    const std::int8_t* handedness = nullptr;
    HandleLabels labels;
    std::span<const FigurePart> table; ///< of a packed figure
    const std::byte* data = nullptr;   ///< the beginning of the packed figure
    std::span<const FigureClip> clips; ///< of a packed figure
    std::size_t levels = 0;            ///< the number of levels of less detail in a packed figure

    std::size_t handle_count() const noexcept { return points.handle_count(); }
    std::size_t point_count() const noexcept { return points.point_count(); }
    HandleView<T, D> handle_view() const noexcept { return points.handle_view(); }
    /// Returns the handles at rest (#handles), the initial pose.
    std::span<const Vec<T, D>> rest_handles() const noexcept { return {points.rest_handles, handle_count()}; }
    bool has_normals() const noexcept { return tangents[0].rest_handles != nullptr; }
    bool has_tangents() const noexcept { return handedness != nullptr; }

    /// Returns the label of a handle; empty if it has none.
    std::string_view label(std::size_t handle) const noexcept { return labels[handle]; }
    /// Returns the first handle with that label, or #handles if there is none. An empty label finds the
    /// first handle without a label. O(#handles).
    std::size_t find_handle(std::string_view label) const noexcept {
        std::size_t handle = 0;
        while (handle < handle_count() && labels[handle] != label) ++handle;
        return handle;
    }

    /// Returns the number of clips of a packed figure. A clip poses all handles of the cage, or all
    /// point handles if there are vectors (clone/pose_handles.hpp).
    std::size_t clip_count() const noexcept { return clips.size(); }
    std::string_view clip_name(std::size_t clip) const noexcept {
        CAGEFORM_ASSERT(clip < clip_count(), "a clip of the figure");
        const auto bytes = part(FigureTags::clips).subspan(clips[clip].name, clips[clip].name_bytes);
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    /// Returns the bytes of a clip, for `open_clip` and `pack`.
    std::span<const std::byte> clip_bytes(std::size_t clip) const noexcept {
        CAGEFORM_ASSERT(clip < clip_count(), "a clip of the figure");
        return part(FigureTags::clips).subspan(clips[clip].offset, clips[clip].bytes);
    }
    /// Returns a clip as `open_clip` does.
    CageClipView<T, D> clip(std::size_t clip) const noexcept {
        const std::byte* const begin = clip_bytes(clip).data();
        ClipHeader header;
        std::memcpy(&header, begin, sizeof(header));
        return detail::view_clip<T, D>(begin, header);
    }
    /// Returns the first clip with that name, or #clips if there is none.
    std::size_t find_clip(std::string_view name) const noexcept {
        std::size_t clip = 0;
        while (clip < clip_count() && clip_name(clip) != name) ++clip;
        return clip;
    }

    /// Returns the number of levels of less detail; `open_level` opens them.
    std::size_t level_count() const noexcept { return levels; }

    /// Returns the bytes of a part, aligned to 64; empty if there is no such part.
    std::span<const std::byte> part(FigureTag tag) const noexcept {
        for (const FigurePart& line : table) {
            if (line.tag == tag) return {data + line.offset, static_cast<std::size_t>(line.bytes)};
        }
        return {};
    }
    /// Returns a part as an array of #bytes / sizeof(X) elements. The contents are not checked.
    template <class X>
        requires std::is_trivially_copyable_v<X>
    std::span<const X> part_as(FigureTag tag) const noexcept {
        const auto bytes = part(tag);
        return {reinterpret_cast<const X*>(bytes.data()), bytes.size() / sizeof(X)};
    }
};

struct OpenReport : BlobReport {
    FigureTag culprit; ///< the part that the status refers to; 0 for the figure as a whole
};

/// Opens a packed figure or a single packed binding without copying, for instance in a mapped file.
/// `data` must not change while the figure is used. A single binding becomes a figure with points only.
///
///   data      at least the figure, aligned to 64 bytes; bytes after it are ignored
///   expected  as for `open_blob`; the hashes are those of the points' blob
///   returns   the view and its report. Status: not_a_figure, not_a_blob, not_a_clip; blob_version_differs,
///             blob_kind_differs, blob_truncated, blob_corrupt, blob_malformed, blob_of_another_cage,
///             blob_of_another_figure, for the figure or the part `culprit`; bindings_differ, if the points,
///             their order or the handles differ between parts; or ok. blob_of_another_cage also for a clip
///             with another number of vertices and a level with other handles. An opened figure never
///             reads or writes out of bounds, whatever its bytes. Custom parts are not checked
///   cost      no allocation; with BlobCheck::all reads every byte once, else the tables and clips
template <Scalar T, std::size_t D>
    requires(D == 2 || D == 3)
Result<PackedFigureView<T, D>, OpenReport> open(std::span<const std::byte> data,
                                                const BlobExpectation& expected = {}) noexcept {
    std::uint64_t magic = 0;
    if (data.size() >= sizeof(magic)) std::memcpy(&magic, data.data(), sizeof(magic));
    if (magic != BlobHeader::magic_number) return detail::open_figure_within<T, D>(data, expected, true);
    const auto blob = open_blob<T, D>(data, expected);
    Result<PackedFigureView<T, D>, OpenReport> opened;
    opened.value.points = blob.value;
    static_cast<BlobReport&>(opened.report) = blob.report;
    return opened;
}

/// Opens a level of less detail of an opened figure. The level is a figure of the same cage; the same
/// poses and clips apply to it.
///
///   level    0: the figure itself; up to PackedFigureView::level_count
///   returns  as `open`; not_a_figure if there is no such level. No allocation; reads the
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

/// Owns a packed figure; made by `pack`. Copying copies all bytes.
template <Scalar T, std::size_t D>
class PackedFigure {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    PackedFigure() = default;
    /// Concatenates the parts in the given order. Throws std::bad_alloc if memory runs out.
    explicit PackedFigure(std::span<const FigurePartData> parts) {
        const std::size_t table = sizeof(FigureHeader) + parts.size() * sizeof(FigurePart);
        FigureHeader header;
        header.scalar_bytes = sizeof(T);
        header.dimension = D;
        header.parts = static_cast<std::uint32_t>(parts.size());
        header.version = 1;
        for (const auto& part : parts) {
            if (FigureTags::is_since_version_2(part.tag)) header.version = 2;
        }
        std::size_t end = detail::whole_lines(table);
        for (const auto& part : parts) end += detail::whole_lines(part.bytes.size());
        header.bytes = end;
        memory_.resize(end);
        std::byte* const data = memory_.data();
        end = detail::whole_lines(table);
        for (std::size_t n = 0; n < parts.size(); ++n) {
            const FigurePart line{parts[n].tag, 0, end, parts[n].bytes.size()};
            std::memcpy(data + sizeof(header) + n * sizeof(line), &line, sizeof(line));
            if (line.bytes > 0) std::memcpy(data + end, parts[n].bytes.data(), parts[n].bytes.size());
            end += detail::whole_lines(parts[n].bytes.size());
        }
        std::memcpy(data, &header, sizeof(header));
        memory_.seal();
    }

    /// Returns the bytes to write to a file and to pass to `open`, aligned to 64.
    std::span<const std::byte> bytes() const noexcept { return memory_.bytes(); }

private:
    detail::PackedMemory memory_;
};

} // namespace cageform::inline CAGEFORM_ABI
