// The functions of the C interface that create coordinates and bind points.
#pragma once

#include <cageform/c/detail/figures.hpp>
#include <cageform/c/detail/make_cage.impl.hpp>

struct cageform_coordinates : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::coordinates;

    cageform::detail::c::OfAnyType<cageform::AnyCoordinates> coordinates;
};
struct cageform_binding : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::binding;

    cageform::detail::c::OfAnyType<cageform::FigureBinding> figure;
    cageform::BindReport report;
};

namespace cageform::inline CAGEFORM_ABI::detail::c {

/// Makes a coordinates object: calls make(options, coordinates) with the scalar of the options.
template <class Make>
cageform_status make_coordinates(std::size_t dimension, const cageform_coordinates_options* options,
                                 cageform_coordinates** coordinates, cageform_report& report,
                                 const Make& make) {
    if (coordinates == nullptr) return CAGEFORM_ARGUMENT_NULL;
    cageform_coordinates_options choice;
    if (const cageform_status read = read_struct(options, choice); read != CAGEFORM_OK) return read;
    return with_type(choice.scalar, dimension, [&]<class T, std::size_t D>() {
        AnyCoordinates<T, D> made;
        const cageform_status status = make(choice, made);
        if (status != CAGEFORM_OK) return status;
        fill(report, made.cage_report());
        if (made.cage_report().status != Status::ok) return code_of(made.cage_report().status);
        report.culprit = CAGEFORM_NONE;
        return make_filled(coordinates, [&](cageform_coordinates& object) {
            object.coordinates = std::move(made);
            return cageform_status(CAGEFORM_OK);
        });
    });
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c

extern "C" {

cageform_status cageform_coordinates_create(const cageform_cage* cage,
                                            const cageform_coordinates_options* options,
                                            cageform_coordinates** coordinates, cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "element", [&](cageform_report& its) {
        if (cage == nullptr) return cageform_status(CAGEFORM_ARGUMENT_NULL);
        cageform_cage own;
        if (const cageform_status status = c::read_struct(cage, own); status != CAGEFORM_OK) return status;
        if (own.kind > CAGEFORM_SITES) return cageform_status(CAGEFORM_CHOICE_UNKNOWN);
        return c::make_coordinates(
            c::dimension_of(own), options, coordinates, its,
            [&](const auto& choice, auto& made) { return c::coordinates_of(own, choice, made); });
    });
}

cageform_status cageform_coordinates_blend(const cageform_cage* const* cages, std::size_t count,
                                           const cageform_coordinates_options* options,
                                           cageform_coordinates** coordinates, cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "cage", [&](cageform_report& its) {
        if (count == 0) return cageform_status(CAGEFORM_TOO_FEW_VERTICES);
        if (cages == nullptr || cages[0] == nullptr) return cageform_status(CAGEFORM_ARGUMENT_NULL);
        cageform_cage first;
        const cageform_status status = c::read_struct(cages[0], first);
        if (status != CAGEFORM_OK) return status;
        if (first.kind > CAGEFORM_SITES) return cageform_status(CAGEFORM_CHOICE_UNKNOWN);
        return c::make_coordinates(c::dimension_of(first), options, coordinates, its,
                                   [&](const auto& choice, auto& made) {
                                       return c::blend_of(std::span(cages, count), choice, made, its.culprit);
                                   });
    });
}

cageform_status cageform_coordinates_describe(const cageform_coordinates* coordinates,
                                              cageform_coordinates_info* info) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(coordinates); code != CAGEFORM_OK) return code;
    return c::with(coordinates->coordinates, [&](const auto& any) {
        using Any = std::remove_cvref_t<decltype(any)>;
        const auto handles = any.handles();
        cageform_coordinates_info its{};
        its.handles = handles.count;
        its.vertices = handles.point_count();
        its.scalar = c::scalar_code<Any>;
        its.dimension = Any::dimension;
        its.has_weights_outside = any.has_extension() ? 1 : 0;
        its.has_gradients = any.has_gradients() ? 1 : 0;
        return c::write_struct(its, info);
    });
}

cageform_status cageform_coordinates_rest(const cageform_coordinates* coordinates, cageform_output handles) {
    namespace c = cageform::detail::c;
    cageform_status status = c::check_object(coordinates);
    if (status != CAGEFORM_OK) return status;
    return c::with(coordinates->coordinates, [&](const auto& any) {
        using Any = std::remove_cvref_t<decltype(any)>;
        const auto out = c::view_of<typename Any::scalar, Any::dimension>(handles, status);
        const auto its = any.handles();
        if (status != CAGEFORM_OK) return status;
        if (out.size() < its.count) return c::code_of(cageform::Status::output_too_small);
        for (std::size_t i = 0; i < its.count; ++i) out.store(i, its.rest[i]);
        return status;
    });
}

cageform_status cageform_coordinates_solve(cageform_coordinates* coordinates, const cageform_running* running,
                                           cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "handle", [&](cageform_report& its) {
        const cageform_status status = c::check_object(coordinates);
        if (status != CAGEFORM_OK) return status;
        return c::with_running(running, [&](const cageform::Running& how) {
            return c::with(coordinates->coordinates, [&](const auto& any) {
                const cageform::Evaluation solved = any.solve(how);
                c::fill(its, solved.solver);
                its.seconds = solved.solver.seconds;
                return c::code_of(solved.status);
            });
        });
    });
}

cageform_status cageform_bind(const cageform_coordinates* coordinates, cageform_points points,
                              const cageform_points* normals, const cageform_points* tangents,
                              const cageform_bind_options* options, const cageform_running* running,
                              cageform_binding** binding, cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "point", [&](cageform_report& its) {
        cageform_bind_options own;
        cageform_status status = c::check_object(coordinates);
        if (status == CAGEFORM_OK) status = c::read_struct(options, own);
        if (status != CAGEFORM_OK) return status;
        if (binding == nullptr || (normals == nullptr && tangents != nullptr))
            return cageform_status(CAGEFORM_ARGUMENT_NULL);
        cageform::BindOptions choice;
        switch (own.outside) {
#define CAGEFORM_DETAIL_OUTSIDE(name, NAME, ...)                                                             \
    case CAGEFORM_##NAME: choice.outside = cageform::OutsidePoints::name; break;
            CAGEFORM_OUTSIDE_POINTS(CAGEFORM_DETAIL_OUTSIDE)
#undef CAGEFORM_DETAIL_OUTSIDE
        default: return cageform_status(CAGEFORM_CHOICE_UNKNOWN);
        }
        choice.falloff = own.falloff;
        if (own.leave_linear_precision != 0) choice.linear_precision = cageform::LinearPrecision::leave;
        return c::with_running(running, [&](const cageform::Running& how) {
            return c::with(coordinates->coordinates, [&](const auto& any) {
                using Any = std::remove_cvref_t<decltype(any)>;
                using T = typename Any::scalar;
                constexpr std::size_t D = Any::dimension;
                std::vector<cageform::Vec<T, D>> copied;
                cageform_status read = c::copy_points(points, copied);
                if (read != CAGEFORM_OK) return read;
                cageform::Result<cageform::FigureBinding<T, D>, cageform::FigureBindReport> bound;
                read = c::bind_copied(any, copied, normals, tangents, choice, how, bound);
                if (read != CAGEFORM_OK) return read;
                c::fill(its, bound.report.points);
                its.seconds = bound.report.seconds;
                if (!bound) return c::code_of(bound.status());
                return c::make_filled(binding, [&](cageform_binding& object) {
                    object.figure = std::move(bound.value);
                    object.report = std::move(bound.report.points);
                    return cageform_status(CAGEFORM_OK);
                });
            });
        });
    });
}

cageform_status cageform_binding_figure(const cageform_binding* binding, cageform_figure** figure) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(binding); code != CAGEFORM_OK) return code;
    if (figure == nullptr) return CAGEFORM_ARGUMENT_NULL;
    return c::with(binding->figure, [&](const auto& its) {
        const auto labels = its.label_bytes();
        return c::make_object(
            nullptr, 0, labels.size(),
            [&](cageform_figure& made, std::byte* memory) {
                auto view = its.view();
                if (view.labels.begin != nullptr) { // a copy: the labels of the binding may change
                    const auto text = view.labels.text - reinterpret_cast<const char*>(labels.data());
                    const void* const own = std::memcpy(memory, labels.data(), labels.size());
                    view.labels = {static_cast<const std::uint32_t*>(own),
                                   static_cast<const char*>(own) + text};
                }
                made.view = view;
            },
            figure);
    });
}

cageform_status cageform_binding_weights(const cageform_binding* binding, size_t first, size_t count,
                                         void* weights, size_t bytes) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(binding); code != CAGEFORM_OK) return code;
    if (weights == nullptr && count > 0) return CAGEFORM_ARGUMENT_NULL;
    return c::with(binding->figure, [&](const auto& its) {
        using T = typename std::remove_cvref_t<decltype(its)>::scalar;
        const std::size_t points = its.points.point_count(), handles = its.points.handle_count();
        if (first > points || count > points - first) return cageform_status(CAGEFORM_INDEX_OUT_OF_BOUNDS);
        if (count > 0 && bytes / count / sizeof(T) < handles)
            return c::code_of(cageform::Status::output_too_small);
        if (reinterpret_cast<std::uintptr_t>(weights) % sizeof(T) != 0)
            return cageform_status(CAGEFORM_POINTS_MISALIGNED);
        T* out = static_cast<T*>(weights);
        for (std::size_t n = first; n < first + count; ++n) {
            for (std::size_t i = 0; i < handles; ++i) *out++ = its.points.weight(n, i);
        }
        return cageform_status(CAGEFORM_OK);
    });
}

cageform_status cageform_binding_set_labels(cageform_binding* binding, const char* const* labels,
                                            size_t count) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(binding); code != CAGEFORM_OK) return code;
    if (labels == nullptr && count > 0) return CAGEFORM_ARGUMENT_NULL;
    return c::guarded([&] {
        return c::with(binding->figure, [&](auto& its) {
            if (count != its.points.handle_count()) return c::code_of(cageform::Status::labels_do_not_match);
            std::vector<std::string_view> texts;
            texts.reserve(count);
            for (std::size_t n = 0; n < count; ++n)
                texts.push_back(labels[n] == nullptr ? std::string_view{} : std::string_view(labels[n]));
            return c::code_of(its.set_labels(texts));
        });
    });
}

cageform_status cageform_binding_list(const cageform_binding* binding, uint32_t list, size_t* indices,
                                      size_t room, size_t* count) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(binding); code != CAGEFORM_OK) return code;
    if (count == nullptr || (indices == nullptr && room > 0)) return CAGEFORM_ARGUMENT_NULL;
    if (list > CAGEFORM_LIST_FADED) return CAGEFORM_CHOICE_UNKNOWN;
    const auto& report = binding->report;
    const std::array lists{&report.on_boundary, &report.outside,      &report.not_finite,
                           &report.unreached,   &report.not_restored, &report.faded};
    const auto& its = *lists[list];
    *count = its.size();
    std::copy_n(its.begin(), (std::min)(room, its.size()), indices);
    return CAGEFORM_OK;
}

} // extern "C"
