// The functions of the C interface that pose a cage by pins.
#pragma once

#include <cageform/c/detail/every_frame.impl.hpp>

#include <cageform/c/detail/messages.hpp>
#include <cageform/c/detail/pins.hpp>
#include <cageform/pose/pose_solver.hpp>

struct cageform_pins : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::pins;

    cageform::detail::c::OfAnyType<cageform::PoseSolver> solver;
};

namespace cageform::inline CAGEFORM_ABI::detail::c {

inline void fill(cageform_report& report, const PoseSolverReport& posed) noexcept {
    report.culprit = posed.status == Status::ok ? posed.missed : posed.culprit;
    report.miss = posed.miss;
    report.step = posed.step;
    report.rigid_energy = posed.rigid_energy;
    report.least_stretch = posed.least_stretch;
    report.largest_stretch = posed.largest_stretch;
    report.iterations = posed.iterations;
    report.folded = posed.folded;
    report.settled = posed.settled ? 1 : 0;
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c

extern "C" {

cageform_status cageform_samples_open(const void* data, size_t bytes, int skip_checksum,
                                      cageform_samples** samples) {
    namespace c = cageform::detail::c;
    if (data == nullptr || samples == nullptr) return CAGEFORM_ARGUMENT_NULL;
    return c::guarded([&] {
        const c::BlobType type(data, bytes);
        return c::with_type(type.scalar, type.dimension, [&]<class T, std::size_t D>() {
            cageform::BlobExpectation expected;
            if (skip_checksum != 0) expected.check = cageform::BlobCheck::structure;
            auto opened =
                cageform::open_pose_samples<T, D>({static_cast<const std::byte*>(data), bytes}, expected);
            if (!opened) return c::code_of(opened.status());
            return c::make_filled(samples, [&](cageform_samples& object) {
                object.samples = std::move(opened.value);
                return cageform_status(CAGEFORM_OK);
            });
        });
    });
}

cageform_status cageform_samples_describe(const cageform_samples* samples, cageform_samples_info* info) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(samples); code != CAGEFORM_OK) return code;
    return c::with(samples->samples, [&](const auto& its) {
        using Samples = std::remove_cvref_t<decltype(its)>;
        return c::write_struct(
            cageform_samples_info{0, its.handle_count(), c::scalar_code<Samples>, Samples::dimension}, info);
    });
}

cageform_status cageform_pins_create(const cageform_samples* samples, const cageform_pins_options* options,
                                     cageform_pins** pins) {
    namespace c = cageform::detail::c;
    return c::guarded([&] {
        cageform_pins_options own;
        cageform_status status = c::check_object(samples);
        if (status == CAGEFORM_OK) status = c::read_struct(options, own);
        if (status == CAGEFORM_OK && pins == nullptr) status = CAGEFORM_ARGUMENT_NULL;
        if (status != CAGEFORM_OK) return status;
        if (!(own.pin_weight >= 0) || !cageform::is_finite(own.pin_weight))
            return c::code_of(cageform::Status::weights_not_positive);
        cageform::PoseOptions choice;
        if (own.pin_weight > 0) choice.pin_weight = own.pin_weight;
        if (own.iterations > 0) choice.iterations = own.iterations;
        choice.hard_pins = own.hard != 0;
        return c::with(samples->samples, [&]<class T, std::size_t D>(const cageform::PoseSamples<T, D>& its) {
            cageform::PoseSolver<T, D> solver(its, choice);
            if (solver.status() != cageform::Status::ok) return c::code_of(solver.status());
            return c::make_filled(pins, [&](cageform_pins& object) {
                object.solver = std::move(solver);
                return cageform_status(CAGEFORM_OK);
            });
        });
    });
}

cageform_status cageform_pins_set(cageform_pins* pins, const cageform_figure* figure, const uint32_t* points,
                                  size_t count, const double* weights, cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "pin", [&](cageform_report& its) {
        cageform_status status = c::check_object(pins);
        if (status == CAGEFORM_OK && count > 0) status = c::check_object(figure);
        if (status != CAGEFORM_OK) return status;
        if (points == nullptr && count > 0) return cageform_status(CAGEFORM_ARGUMENT_NULL);
        return c::with(pins->solver, [&]<class T, std::size_t D>(cageform::PoseSolver<T, D>& solver) {
            cageform::PosePins<T, D> chosen;
            if (count > 0) {
                const auto* const view = std::get_if<cageform::PackedFigureView<T, D>>(&figure->view);
                if (view == nullptr) return c::code_of(cageform::Status::bindings_differ);
                chosen.binding = view->points;
                chosen.points = {points, count};
                if (weights != nullptr) chosen.weights = {weights, count};
            }
            const cageform::Status set = solver.set_pins(chosen);
            if (set != cageform::Status::ok) its.culprit = solver.culprit();
            return c::code_of(set);
        });
    });
}

cageform_status cageform_pins_hold(cageform_pins* pins, const uint32_t* handles, size_t count,
                                   cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "handle", [&](cageform_report& its) {
        if (const auto code = c::check_object(pins); code != CAGEFORM_OK) return code;
        if (handles == nullptr && count > 0) return cageform_status(CAGEFORM_ARGUMENT_NULL);
        return c::with(pins->solver, [&](auto& solver) {
            const cageform::Status set = solver.set_held({handles, count});
            if (set != cageform::Status::ok) its.culprit = solver.culprit();
            return c::code_of(set);
        });
    });
}

cageform_status cageform_pins_solve(cageform_pins* pins, cageform_points targets, cageform_output pose,
                                    cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "pin", [&](cageform_report& its) {
        cageform_status status = c::check_object(pins);
        if (status != CAGEFORM_OK) return status;
        return c::with(pins->solver, [&]<class T, std::size_t D>(cageform::PoseSolver<T, D>& solver) {
            const auto to = c::view_of<T, D>(targets, status);
            const auto out = c::view_of<T, D>(pose, status);
            if (status != CAGEFORM_OK) return status;
            const cageform::PoseSolverReport posed = solver.solve(to, out);
            c::fill(its, posed);
            return c::code_of(posed.status);
        });
    });
}

} // extern "C"
