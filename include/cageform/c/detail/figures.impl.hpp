// Defines the functions of figures.hpp. That header includes this file, unless the program links
// cageform::compiled.
#pragma once

#include <cageform/animate/compile.hpp>
#include <cageform/animate/pack_clip.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/binding/pose_samples.hpp>
#include <cageform/c/detail/figures.hpp>

namespace cageform::inline CAGEFORM_ABI::detail::c {

template <class T, std::size_t D>
cageform_status bind_copied(const AnyCoordinates<T, D>& coordinates, const std::vector<Vec<T, D>>& points,
                            const cageform_points* normals, const cageform_points* tangents,
                            const BindOptions& options, const Running& running,
                            Result<FigureBinding<T, D>, FigureBindReport>& result) {
    if (normals == nullptr) {
        result = coordinates.bind(FigurePoints{points}, options, running);
        return CAGEFORM_OK;
    }
    std::vector<Vec<T, D>> turned;
    cageform_status status = copy_points(*normals, turned);
    if (status != CAGEFORM_OK) return status;
    if (tangents == nullptr) {
        result = coordinates.bind(FigurePoints{points, turned}, options, running);
        return CAGEFORM_OK;
    }
    if constexpr (D == 3) {
        const auto with_tangents = [&]<std::size_t E>(std::vector<Vec<T, E>> along) {
            status = copy_points(*tangents, along);
            if (status == CAGEFORM_OK)
                result = coordinates.bind(FigurePoints{points, turned, along}, options, running);
            return status;
        };
        return tangents->dimension == 4 ? with_tangents(std::vector<Vec<T, 4>>{})
                                        : with_tangents(std::vector<Vec<T, 3>>{});
    } else {
        return CAGEFORM_DIMENSION_DIFFERS;
    }
}

/// Makes a bytes object that owns `packed`, an object with a member bytes().
template <class Packed>
cageform_status make_bytes(Packed packed, cageform_bytes** made) {
    return make_filled(made, [&](cageform_bytes& object) {
        const auto owner = std::make_shared<const Packed>(std::move(packed));
        object.bytes = owner->bytes();
        object.owner = owner;
        return cageform_status(CAGEFORM_OK);
    });
}

inline cageform_status read_parts(const cageform_part* parts, std::size_t count) noexcept {
    if (parts == nullptr && count > 0) return CAGEFORM_ARGUMENT_NULL;
    for (std::size_t n = 0; n < count; ++n) {
        if (parts[n].data == nullptr) return CAGEFORM_ARGUMENT_NULL;
    }
    return CAGEFORM_OK;
}
inline std::span<const std::byte> bytes_of(const cageform_part& part) noexcept {
    return {static_cast<const std::byte*>(part.data), part.bytes};
}

template <class T, std::size_t D>
cageform_status pack_figure(const FigureBinding<T, D>& figure, const cageform_pack_options& options,
                            const Running& running, cageform_bytes** packed, cageform_report& report) {
    std::optional<WeightFormat> format; // none: the smallest
    switch (options.format) {
    case CAGEFORM_FORMAT_SMALLEST: break;
#define CAGEFORM_DETAIL_FORMAT(name, NAME, ...)                                                              \
    case CAGEFORM_FORMAT_##NAME: format = WeightFormat::name; break;
        CAGEFORM_WEIGHT_FORMATS(CAGEFORM_DETAIL_FORMAT)
#undef CAGEFORM_DETAIL_FORMAT
    default: return CAGEFORM_CHOICE_UNKNOWN;
    }
    std::vector<Vec<T, D>> posed;
    cageform_status status = copy_points(options.poses, posed);
    if (status == CAGEFORM_OK) status = read_parts(options.clips, options.clip_count);
    if (status == CAGEFORM_OK) status = read_parts(options.levels, options.level_count);
    if (status != CAGEFORM_OK) return status;
    const std::size_t handles = figure.points.handle_count();
    if (!posed.empty() && posed.size() % handles != 0) return CAGEFORM_COUNTS_DO_NOT_MATCH;
    std::vector<double> poses;
    append_pose(poses, posed);
    std::vector<FigureClipData> clips;
    for (std::size_t n = 0; n < options.clip_count; ++n)
        clips.push_back(
            {options.clips[n].name == nullptr ? "" : options.clips[n].name, bytes_of(options.clips[n])});
    std::vector<std::span<const std::byte>> levels;
    for (std::size_t n = 0; n < options.level_count; ++n) levels.push_back(bytes_of(options.levels[n]));
    FigurePackOptions own;
    own.weights.tolerance = options.tolerance;
    own.weights.threshold = options.threshold;
    own.weights.largest = options.largest;
    own.weights.reach = options.reach;
    own.weights.poses = poses;
    own.clips = clips;
    own.levels = levels;
    const auto origin = std::span(options.origin).template first<D>();
    if (!std::all_of(origin.begin(), origin.end(), [](double x) { return std::isfinite(x); }))
        return CAGEFORM_VALUE_NOT_FINITE;
    const FigurePartData place{"ORIG", std::as_bytes(origin)};
    if (std::any_of(origin.begin(), origin.end(), [](double x) { return x != 0; })) own.parts = {&place, 1};
    own.weights.format = format;
    auto made = pack(figure, own, running);
    fill(report, made.report);
    report.seconds = made.report.seconds;
    return made ? make_bytes(std::move(made.value), packed) : code_of(made.status());
}

template <class T, std::size_t D>
cageform_status compile_poses(const double* times, std::size_t count, const std::vector<Vec<T, D>>& poses,
                              const cageform_clip_options& options, const Running& running,
                              cageform_bytes** clip, cageform_report& report) {
    if (count == 0 || poses.size() % count != 0) return CAGEFORM_COUNTS_DO_NOT_MATCH;
    const std::size_t vertices = poses.size() / count;
    std::vector<std::vector<Key>> curves(vertices * D, std::vector<Key>(count));
    constexpr std::array kinds{KeyKind::automatic, KeyKind::linear, KeyKind::hold};
    for (std::size_t k = 0; k < count; ++k) {
        for (std::size_t c = 0; c < curves.size(); ++c) {
            Key& key = curves[c][k];
            key.time = times[k];
            key.value = double(poses[k * vertices + c / D][c % D]);
            key.kind = kinds[options.keys];
        }
    }
    TrackOptions own;
    if (options.tolerance != 0) own.tolerance = options.tolerance;
    own.before = static_cast<Extrapolation>(options.before);
    own.after = static_cast<Extrapolation>(options.after);
    const auto compiled = compile<T, D>(curves, own, running);
    report.curve_error = compiled.report.sup_error;
    report.seconds = compiled.report.seconds;
    if (!compiled) {
        report.culprit = compiled.report.culprit;
        return code_of(compiled.status());
    }
    auto packed = pack_clip(compiled.value, {.tolerance = options.pack_tolerance});
    report.bytes = packed.report.bytes;
    report.vertices = packed.report.vertices;
    return packed ? make_bytes(std::move(packed.value), clip) : code_of(packed.status());
}

template <class T, std::size_t D>
cageform_status sample_cage(const AnyCoordinates<T, D>& coordinates, const PoseSampleOptions& options,
                            const Running& running, cageform_samples& samples, cageform_report& report) {
    auto made = pose_samples(coordinates, options, running);
    report.samples = made.report.samples;
    report.rotations = made.report.rotations;
    report.seconds = made.report.seconds;
    if (!made) return code_of(made.status());
    report.bytes = made.value.bytes();
    samples.samples = std::move(made.value);
    return CAGEFORM_OK;
}

template <class T, std::size_t D>
cageform_status pack_samples(const PoseSamples<T, D>& samples, cageform_bytes** packed,
                             cageform_report& report) {
    auto made = pack(samples);
    if (!made) return code_of(made.status());
    report.bytes = made.value.bytes().size();
    return make_bytes(std::move(made.value), packed);
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c
