// Packs a figure: its bindings, labels, clips, levels, and custom parts.
#pragma once

#include <cageform/binding/detail/packer.hpp>
#include <cageform/binding/types/figure_binding.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

template <Scalar T, std::size_t D>
Status check_tags(std::span<const FigurePartData> parts, FigureTag& culprit) noexcept {
    constexpr std::size_t own = 6 + FigureTags::most_levels;
    if (parts.size() > FigureHeader::most_parts - own) return Status::too_many_parts;
    for (std::size_t n = 0; n < parts.size(); ++n) {
        bool duplicate = FigureTags::has(parts[n].tag) || parts[n].tag == FigureTag{};
        for (std::size_t m = 0; m < n; ++m) duplicate = duplicate || parts[m].tag == parts[n].tag;
        culprit = parts[n].tag;
        if (duplicate) return Status::duplicate_tag;
    }
    culprit = {};
    return Status::ok;
}

/// Checks that handedness and labels match the figure's bindings.
template <Scalar T, std::size_t D>
Status check_tables(const FigureBinding<T, D>& figure, FigureTag& culprit) noexcept {
    culprit = FigureTags::handedness;
    if (!figure.handedness.empty() && figure.handedness.size() != figure.points.point_count())
        return Status::vectors_do_not_match;
    culprit = FigureTags::labels;
    if (!figure.label_bytes().empty() && figure.labels().begin == nullptr) return Status::labels_do_not_match;
    culprit = {};
    return Status::ok;
}

/// Checks that the clips and levels of a figure belong to its cage.
template <Scalar T, std::size_t D>
Status check_motion(const HandleView<T, D>& handles, const FigurePackOptions& options,
                    FigurePackReport& report) noexcept {
    report.culprit = FigureTags::clips;
    for (std::size_t n = 0; n < options.clips.size(); ++n) {
        report.culprit_clip = n;
        const Status status = check_clip_of(open_clip<T, D>(options.clips[n].bytes), handles);
        if (status != Status::ok) return status;
        for (const FigureClipData& other : options.clips.first(n)) {
            if (other.name == options.clips[n].name) return Status::duplicate_name;
        }
    }
    report.culprit_clip = 0;
    report.culprit = {};
    if (options.levels.size() > FigureTags::most_levels) return Status::too_many_parts;
    for (std::size_t n = 0; n < options.levels.size(); ++n) {
        report.culprit = FigureTags::level(n + 1);
        const auto level = open_figure_within<T, D>(options.levels[n], {}, false);
        if (!level) return level.status();
        if (!same_handles(level.value.handle_view(), handles)) return Status::blob_of_another_cage;
    }
    report.culprit = {};
    return Status::ok;
}

/// Returns the CLPS part of a figure.
inline std::vector<Lanes<double>> packed_clips(std::span<const FigureClipData> clips) {
    const std::uint64_t count = clips.size();
    std::size_t name = sizeof(count) + clips.size() * sizeof(FigureClip), end = name;
    for (const FigureClipData& clip : clips) end += clip.name.size();
    end = whole_lines(end);
    std::vector<FigureClip> lines;
    for (const FigureClipData& clip : clips) {
        lines.push_back({end, clip.bytes.size(), static_cast<std::uint32_t>(name),
                         static_cast<std::uint32_t>(clip.name.size())});
        name += clip.name.size();
        end += whole_lines(clip.bytes.size());
    }
    std::vector<Lanes<double>> memory(end / 64);
    std::byte* const data = std::as_writable_bytes(std::span(memory)).data();
    if (end > 0) std::memset(data, 0, end);
    std::memcpy(data, &count, sizeof(count));
    std::memcpy(data + sizeof(count), lines.data(), lines.size() * sizeof(FigureClip));
    for (std::size_t n = 0; n < clips.size(); ++n) {
        if (!clips[n].name.empty())
            std::memcpy(data + lines[n].name, clips[n].name.data(), lines[n].name_bytes);
        std::memcpy(data + lines[n].offset, clips[n].bytes.data(), clips[n].bytes.size());
    }
    return memory;
}

template <class T, std::size_t D>
Status pack_parts(const FigureBinding<T, D>& figure, const FigurePackOptions& options, const Running& running,
                  Result<PackedFigure<T, D>, FigurePackReport>& result) {
    FigurePackReport& report = result.report;
    Status status = check_tags<T, D>(options.parts, report.culprit);
    if (status == Status::ok) status = check_tables(figure, report.culprit);
    if (status == Status::ok) status = check_motion(figure.points.handle_view(), options, report);
    if (status != Status::ok) return status;
    std::vector<FigurePartData> parts;
    PackOptions how = options.weights;
    const std::size_t vectors = figure.has_normals() ? D - 1 : 0;
    const auto subtask = [&](std::size_t n) {
        return running.subtask(double(n) / double(vectors + 1), double(n + 1) / double(vectors + 1));
    };
    const bool own_tolerance = vectors > 0 && options.tangent_tolerance != 0;
    if (own_tolerance && how.tolerance == 0) // sparse, so that it has an order for the tangents
        how.threshold = (std::max)(how.threshold, (std::numeric_limits<double>::min)());
    auto points = pack_binding(figure.points.view(), how, subtask(0), {});
    how.threshold = options.weights.threshold;
    report.points = std::move(points.report);
    report.culprit = FigureTags::points;
    if (report.points.status != Status::ok) return report.points.status;
    parts.push_back({report.culprit, points.value.bytes()});
    const auto view = points.value.view();
    if (view.order != nullptr) how.order = {view.order, view.points};
    const double size = report.points.size, widest = 10 * how.tolerance;
    if (own_tolerance)
        how.tolerance = options.tangent_tolerance;
    else if (how.tolerance > 0)
        how.tolerance = widest < size ? widest / size : 1;
    std::array<PackedBinding<T, D>, D - 1> tangents;
    for (std::size_t k = 0; k < vectors; ++k) {
        report.culprit = k == 0 ? FigureTags::tangents : FigureTags::bitangents;
        auto packed = pack_binding(figure.tangents[k].view(), how, subtask(k + 1), {});
        report.vectors[k] = std::move(packed.report);
        if (report.vectors[k].status != Status::ok) return report.vectors[k].status;
        tangents[k] = std::move(packed.value);
        if (!bindings_match(view, tangents[k].view())) return Status::bindings_differ;
        parts.push_back({report.culprit, tangents[k].bytes()});
    }
    if (!figure.handedness.empty())
        parts.push_back({FigureTags::handedness, std::as_bytes(std::span(figure.handedness))});
    const auto labels = figure.label_bytes();
    if (!labels.empty()) parts.push_back({FigureTags::labels, labels});
    std::vector<Lanes<double>> clips;
    if (!options.clips.empty()) {
        clips = packed_clips(options.clips);
        parts.push_back({FigureTags::clips, std::as_bytes(std::span(clips))});
    }
    for (std::size_t n = 0; n < options.levels.size(); ++n)
        parts.push_back({FigureTags::level(n + 1), options.levels[n]});
    parts.insert(parts.end(), options.parts.begin(), options.parts.end());
    report.culprit = {};
    result.value = PackedFigure<T, D>(parts);
    report.bytes = result.value.bytes().size();
    return Status::ok;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
