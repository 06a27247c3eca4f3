// The functions of the C interface that pack figures and clips.
#pragma once

#include <cageform/c/detail/bind.impl.hpp>

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
    if (const auto code = cageform::detail::c::check_object(bytes); code != CAGEFORM_OK) return code;
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
        if (const cageform_status status = c::read_struct(options, own); status != CAGEFORM_OK) return status;
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
                return c::make_filled(samples, [&](cageform_samples& object) {
                    return c::sample_cage(any, choice, how, object, its);
                });
            });
        });
    });
}

cageform_status cageform_samples_pack(const cageform_samples* samples, cageform_bytes** packed,
                                      cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "number", [&](cageform_report& its) {
        if (const auto code = c::check_object(samples); code != CAGEFORM_OK) return code;
        if (packed == nullptr) return cageform_status(CAGEFORM_ARGUMENT_NULL);
        return c::with(samples->samples, [&](const auto& own) { return c::pack_samples(own, packed, its); });
    });
}

} // extern "C"
