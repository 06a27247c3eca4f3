// The functions of the C interface that pack figures and clips.
#pragma once

#include <cageform/c/detail/bind.impl.hpp>

#include <cageform/animate/compile.hpp>
#include <cageform/animate/pack_clip.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/pose/pose_samples.hpp>

struct cageform_bytes : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::bytes;

    std::shared_ptr<const void> owner;
    std::span<const std::byte> bytes;
};
namespace cageform::inline CAGEFORM_ABI::detail::c {

/// Makes bytes of what has a member bytes(), which they keep.
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
    if (options.format > CAGEFORM_FORMAT_INT8) return CAGEFORM_CHOICE_UNKNOWN;
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
    if (options.format != CAGEFORM_FORMAT_SMALLEST)
        own.weights.format = static_cast<WeightFormat>(options.format - CAGEFORM_FORMAT_SCALAR);
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

} // namespace cageform::inline CAGEFORM_ABI::detail::c

extern "C" {

cageform_status cageform_pack(const cageform_binding* binding, const cageform_pack_options* options,
                              const cageform_running* running, cageform_bytes** packed,
                              cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "number", [&](cageform_report& its) {
        cageform_pack_options own;
        cageform_status status = c::check_object(binding);
        if (status == CAGEFORM_OK) status = c::read_struct(options, own);
        if (status == CAGEFORM_OK && packed == nullptr) status = CAGEFORM_ARGUMENT_NULL;
        if (status != CAGEFORM_OK) return status;
        return c::with_running(running, [&](const cageform::Running& how) {
            return c::with(binding->figure,
                           [&](const auto& figure) { return c::pack_figure(figure, own, how, packed, its); });
        });
    });
}

cageform_status cageform_bytes_view(const cageform_bytes* bytes, const void** data, size_t* size) {
    const cageform_status status = cageform::detail::c::check_object(bytes);
    if (status != CAGEFORM_OK) return status;
    if (data == nullptr || size == nullptr) return CAGEFORM_ARGUMENT_NULL;
    *data = bytes->bytes.data();
    *size = bytes->bytes.size();
    return CAGEFORM_OK;
}

cageform_status cageform_compile_clip(const double* times, size_t count, cageform_points poses,
                                      const cageform_clip_options* options, const cageform_running* running,
                                      cageform_bytes** clip, cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "key", [&](cageform_report& its) {
        cageform_clip_options own;
        const cageform_status status = c::read_struct(options, own);
        if (status != CAGEFORM_OK) return status;
        if (clip == nullptr || (times == nullptr && count > 0))
            return cageform_status(CAGEFORM_ARGUMENT_NULL);
        if (own.keys > CAGEFORM_HOLD || own.before > CAGEFORM_PING_PONG || own.after > CAGEFORM_PING_PONG)
            return cageform_status(CAGEFORM_CHOICE_UNKNOWN);
        return c::with_running(running, [&](const cageform::Running& how) {
            return c::with_type(own.scalar, poses.dimension, [&]<class T, std::size_t D>() {
                std::vector<cageform::Vec<T, D>> copied;
                const cageform_status read = c::copy_points(poses, copied);
                if (read != CAGEFORM_OK) return read;
                return c::compile_poses(times, count, copied, own, how, clip, its);
            });
        });
    });
}

cageform_status cageform_pose_samples(const cageform_coordinates* coordinates,
                                      const cageform_samples_options* options,
                                      const cageform_running* running, cageform_samples** samples,
                                      cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "number", [&](cageform_report& its) {
        cageform_samples_options own;
        cageform_status status = c::check_object(coordinates);
        if (status == CAGEFORM_OK) status = c::read_struct(options, own);
        if (status == CAGEFORM_OK && samples == nullptr) status = CAGEFORM_ARGUMENT_NULL;
        if (status != CAGEFORM_OK) return status;
        cageform::PoseSampleOptions choice;
        choice.samples = own.samples;
        choice.rotations = own.rotations;
        choice.smoothing = own.smoothing;
        return c::with_running(running, [&](const cageform::Running& how) {
            return c::with(coordinates->coordinates, [&](const auto& any) {
                auto made = cageform::pose_samples(any, choice, how);
                its.samples = made.report.samples;
                its.rotations = made.report.rotations;
                its.seconds = made.report.seconds;
                if (!made) return c::code_of(made.status());
                its.bytes = made.value.bytes();
                return c::make_filled(samples, [&](cageform_samples& object) {
                    object.samples = std::move(made.value);
                    return cageform_status(CAGEFORM_OK);
                });
            });
        });
    });
}

cageform_status cageform_samples_pack(const cageform_samples* samples, cageform_bytes** packed,
                                      cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "number", [&](cageform_report& its) {
        const cageform_status status = c::check_object(samples);
        if (status != CAGEFORM_OK) return status;
        if (packed == nullptr) return cageform_status(CAGEFORM_ARGUMENT_NULL);
        return c::with(samples->samples, [&](const auto& own) {
            auto made = pack(own);
            if (!made) return c::code_of(made.status());
            its.bytes = made.value.bytes().size();
            return c::make_bytes(std::move(made.value), packed);
        });
    });
}

} // extern "C"
