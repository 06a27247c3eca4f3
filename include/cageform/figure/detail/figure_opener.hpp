// Opens the parts of a packed figure and checks their consistency.
#pragma once

#include <cageform/clip/clip_blob.hpp>
#include <cageform/figure/types/figure_parts.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T, std::size_t D>
struct PackedFigureView; // in figure/figure.hpp
struct OpenReport;

namespace detail {

/// Checks that the parts lie within the figure, do not overlap, are in order and have different tags.
/// The table itself must lie within the figure.
inline bool is_valid(std::span<const FigurePart> table, std::uint64_t bytes) noexcept {
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

/// Returns whether the handles at rest are equal bit for bit.
template <Scalar T, std::size_t D>
bool same_handles(const HandleView<T, D>& a, const HandleView<T, D>& b) noexcept {
    const auto same = []<class X>(const X* p, const X* q, std::size_t count) {
        return p == q || (p != nullptr && q != nullptr && std::memcmp(p, q, count * sizeof(X)) == 0);
    };
    return a.count == b.count && same(a.rest, b.rest, a.count) && same(a.kinds, b.kinds, a.count) &&
           same(a.faces, b.faces, a.vector_count()) && a.loop_numbers() == b.loop_numbers() &&
           same(a.loops, b.loops, a.loop_numbers());
}

/// Opens the bindings of a figure whose table is valid.
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

/// Opens the parts of a figure that are not bindings.
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

/// Checks that a clip has one vertex per handle, or one per point handle.
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
    std::uint64_t end = sizeof(count) + count * sizeof(FigureClip); // clips do not overlap and are in order
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

/// Opens the levels: figures of the same handles that have no levels themselves.
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
    FigureHeader header;
    Status status = read_header(data, expected.check, {Status::not_a_figure, sizeof(T), D}, header);
    if (status != Status::ok) return refused(status);
    if (header.parts > FigureHeader::most_parts ||
        header.parts * sizeof(FigurePart) > header.bytes - sizeof(header))
        return refused(Status::blob_malformed);
    opened.value.data = data.data();
    opened.value.table = {reinterpret_cast<const FigurePart*>(data.data() + sizeof(header)), header.parts};
    if (!is_valid(opened.value.table, header.bytes)) return refused(Status::blob_malformed);
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

} // namespace cageform::inline CAGEFORM_ABI
