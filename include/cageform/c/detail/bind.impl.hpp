// The functions of the C interface that check and make cages, and bind.
#pragma once

#include <cageform/c/detail/pins.impl.hpp>

#include <cageform/c/detail/cages.hpp>
#include <cageform/enclose/make_cage.hpp>
#include <cageform/enclose/make_cage_3d.hpp>

#include <atomic>
#include <exception>

struct cageform_coordinates : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::coordinates;

    cageform::detail::c::OfAnyType<cageform::AnyCoordinates> coordinates;
};
struct cageform_binding : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::binding;

    cageform::detail::c::OfAnyType<cageform::FigureBinding> figure;
    cageform::BindReport report;
};
struct cageform_made_cage : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::made_cage;

    std::vector<double> vertices;
    std::vector<std::uint32_t> counts, indices;
    std::uint32_t dimension = 2;
};
namespace cageform::inline CAGEFORM_ABI::detail::c {

/// Calls use(running) with the caller's threads and progress. An exception of a body on another thread of the
/// caller's loop is thrown again here, for C functions are not passed by exceptions.
template <class Use>
cageform_status with_running(const cageform_running* given, const Use& use) {
    cageform_running own;
    const cageform_status status = read_struct(given, own);
    if (status != CAGEFORM_OK) return status;
    Running running;
    if (own.parallel_for != nullptr) {
        running.parallel = [own](std::size_t count, std::size_t grain, const RangeBody& body) {
#if defined(__cpp_exceptions)
            std::atomic<bool> has_thrown = false;
            std::exception_ptr thrown;
            CallersFor{&own}(count, grain, [&](std::size_t begin, std::size_t end) {
                try {
                    body(begin, end);
                } catch (...) {
                    if (!has_thrown.exchange(true)) thrown = std::current_exception();
                }
            });
            if (thrown) std::rethrow_exception(thrown);
#else
            CallersFor{&own}(count, grain, body);
#endif
        };
    }
#if defined(CAGEFORM_DETAIL_C_THREADS)
    else if (own.threads > 1)
        running.parallel = ThreadedFor{own.threads};
#endif
    if (own.progress != nullptr)
        running.progress = [own](double done) { return own.progress(own.context, done) != 0; };
    return use(running);
}

/// Calls use(view) with the points of a drawing and the numbers that name them, all below their count.
inline cageform_status check_drawing(const cageform_drawing& drawing, std::size_t together) noexcept {
    if (drawing.indices == nullptr && drawing.index_count > 0) return CAGEFORM_ARGUMENT_NULL;
    if (drawing.areas == nullptr && drawing.area_count > 0) return CAGEFORM_ARGUMENT_NULL;
    return drawing.index_count % together == 0 ? CAGEFORM_OK : CAGEFORM_COUNTS_DO_NOT_MATCH;
}

inline cageform_status make_cage_in_plane(const cageform_drawing& drawing, const MakeCageOptions& options,
                                          const Running& running, cageform_made_cage& object,
                                          cageform_report& report) {
    std::vector<Vec<double, 2>> points;
    cageform_status status = check_drawing(drawing, 2);
    if (status == CAGEFORM_OK) status = copy_points(drawing.points, points);
    if (status != CAGEFORM_OK) return status;
    std::vector<DrawnSegment<double>> segments(drawing.index_count / 2);
    for (std::size_t n = 0; n < segments.size(); ++n) {
        for (const std::size_t i : {2 * n, 2 * n + 1}) {
            if (drawing.indices[i] >= points.size()) {
                report.culprit = i;
                return CAGEFORM_INDEX_OUT_OF_BOUNDS;
            }
        }
        segments[n] = {points[drawing.indices[2 * n]], points[drawing.indices[2 * n + 1]],
                       drawing.radii != nullptr ? drawing.radii[n] : 0};
    }
    std::vector<PaintedArea> areas;
    std::size_t end = 0;
    for (std::size_t n = 0; n < drawing.area_count; ++n) {
        areas.push_back({end, end + drawing.areas[n]});
        end += drawing.areas[n];
    }
    auto [cage, made] = make_cage(Drawing<double>{segments, areas}, options, running);
    fill(report, made);
    if (made.status != Status::ok) return code_of(made.status);
    for (const auto& vertex : cage.vertices())
        object.vertices.insert(object.vertices.end(), vertex.v, vertex.v + 2);
    for (const auto& loop : cage.loops()) object.counts.push_back(static_cast<std::uint32_t>(loop.size()));
    return CAGEFORM_OK;
}

inline cageform_status make_cage_in_space(const cageform_drawing& drawing, const MakeCageOptions& options,
                                          const Running& running, cageform_made_cage& object,
                                          cageform_report& report) {
    std::vector<Vec<double, 3>> points;
    cageform_status status = check_drawing(drawing, 3);
    if (status == CAGEFORM_OK) status = copy_points(drawing.points, points);
    if (status != CAGEFORM_OK) return status;
    std::vector<std::array<std::uint32_t, 3>> faces(drawing.index_count / 3);
    for (std::size_t n = 0; n < faces.size(); ++n) std::copy_n(drawing.indices + 3 * n, 3, faces[n].begin());
    auto [cage, made] = make_cage(points, faces, options, running);
    fill(report, made);
    if (made.status != Status::ok) return code_of(made.status);
    for (const auto& vertex : cage.vertices())
        object.vertices.insert(object.vertices.end(), vertex.v, vertex.v + 3);
    for (const auto& face : cage.faces())
        object.indices.insert(object.indices.end(), face.begin(), face.end());
    object.dimension = 3;
    return CAGEFORM_OK;
}

/// Makes coordinates, which make(options, coordinates) fills, of a scalar that the options choose.
template <class Make>
cageform_status make_coordinates(std::size_t dimension, const cageform_coordinates_options* options,
                                 cageform_coordinates** coordinates, cageform_report& report,
                                 const Make& make) {
    if (coordinates == nullptr) return CAGEFORM_ARGUMENT_NULL;
    cageform_coordinates_options choice;
    const cageform_status read = read_struct(options, choice);
    if (read != CAGEFORM_OK) return read;
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

/// Binds points that are copied, with normals and tangents if there are any.
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

} // namespace cageform::inline CAGEFORM_ABI::detail::c

extern "C" {

cageform_status cageform_check(const cageform_cage* cage, cageform_fault* faults, size_t room,
                               size_t* count) {
    namespace c = cageform::detail::c;
    if (cage == nullptr || count == nullptr || (faults == nullptr && room > 0)) return CAGEFORM_ARGUMENT_NULL;
    return c::guarded([&] {
        cageform_cage own;
        cageform::CageReport report;
        cageform_status status = c::read_struct(cage, own);
        if (status == CAGEFORM_OK) status = c::report_of(own, report);
        if (status != CAGEFORM_OK) return status;
        *count = report.faults.size();
        for (std::size_t n = 0; n < report.faults.size() && n < room; ++n)
            faults[n] = c::fault_of(report.faults[n]);
        return c::code_of(report.status);
    });
}

cageform_status cageform_make_cage(const cageform_drawing* figure, const cageform_make_cage_options* options,
                                   const cageform_running* running, cageform_made_cage** made,
                                   cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "element", [&](cageform_report& its) {
        if (figure == nullptr || made == nullptr) return cageform_status(CAGEFORM_ARGUMENT_NULL);
        cageform_drawing drawing;
        cageform_make_cage_options own;
        cageform_status status = c::read_struct(figure, drawing);
        if (status == CAGEFORM_OK) status = c::read_struct(options, own);
        if (status != CAGEFORM_OK) return status;
        if (own.shape > CAGEFORM_SHAPE_BOX || own.mirror > 3) return cageform_status(CAGEFORM_CHOICE_UNKNOWN);
        cageform::MakeCageOptions choice;
        choice.vertices = own.vertices;
        choice.margin = own.margin;
        choice.shape = static_cast<cageform::CageShape>(own.shape);
        if (own.mirror > 0) choice.mirror = cageform::MirrorPlane{own.mirror - 1, {}};
        choice.one_cage = own.many_cages == 0;
        choice.holes = own.holes != 0;
        choice.fill_tunnels = own.fill_tunnels != 0;
        if (own.regular != 0) choice.regular = own.regular;
        return c::with_running(running, [&](const cageform::Running& how) {
            return c::make_filled(made, [&](cageform_made_cage& object) {
                return drawing.points.dimension == 3
                           ? c::make_cage_in_space(drawing, choice, how, object, its)
                           : c::make_cage_in_plane(drawing, choice, how, object, its);
            });
        });
    });
}

cageform_status cageform_made_cage_describe(const cageform_made_cage* made, cageform_cage* cage) {
    namespace c = cageform::detail::c;
    const cageform_status status = c::check_object(made);
    if (status != CAGEFORM_OK) return status;
    cageform_cage its{};
    const std::size_t dimension = made->dimension;
    its.kind = dimension == 2 ? CAGEFORM_POLYGON : CAGEFORM_MESH;
    its.vertices = {made->vertices.data(),
                    made->vertices.size() / dimension,
                    0,
                    made->vertices.size() * sizeof(double),
                    CAGEFORM_DOUBLE,
                    made->dimension};
    its.dimension = made->dimension;
    if (!made->counts.empty()) its.counts = made->counts.data();
    its.count_count = made->counts.size();
    if (!made->indices.empty()) its.indices = made->indices.data();
    its.index_count = made->indices.size();
    return c::write_struct(its, cage);
}

cageform_status cageform_coordinates_create(const cageform_cage* cage,
                                            const cageform_coordinates_options* options,
                                            cageform_coordinates** coordinates, cageform_report* report) {
    namespace c = cageform::detail::c;
    return c::reported(report, "element", [&](cageform_report& its) {
        if (cage == nullptr) return cageform_status(CAGEFORM_ARGUMENT_NULL);
        cageform_cage own;
        const cageform_status status = c::read_struct(cage, own);
        if (status != CAGEFORM_OK) return status;
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
    const cageform_status status = c::check_object(coordinates);
    if (status != CAGEFORM_OK) return status;
    return c::with(coordinates->coordinates, [&](const auto& any) {
        using Any = std::remove_cvref_t<decltype(any)>;
        const auto handles = any.handles();
        cageform_coordinates_info its{};
        its.handles = handles.count;
        its.vertices = handles.count - handles.vector_count();
        its.scalar = c::scalar_code<Any>;
        its.dimension = Any::dimension;
        its.has_weights_outside = any.has_extension() ? 1 : 0;
        its.has_gradients = any.has_gradients() ? 1 : 0;
        return c::write_struct(its, info);
    });
}

cageform_status cageform_coordinates_rest(const cageform_coordinates* coordinates, cageform_output handles) {
    namespace c = cageform::detail::c;
    const cageform_status status = c::check_object(coordinates);
    if (status != CAGEFORM_OK) return status;
    return c::with(coordinates->coordinates, [&](const auto& any) {
        using Any = std::remove_cvref_t<decltype(any)>;
        return c::with_points<typename Any::scalar, Any::dimension>(handles, [&](const auto& out) {
            const auto its = any.handles();
            if (out.size() < its.count) return c::code_of(cageform::Status::output_too_small);
            for (std::size_t i = 0; i < its.count; ++i) out.store(i, its.rest[i]);
            return cageform_status(CAGEFORM_OK);
        });
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
        if (own.outside > CAGEFORM_NEAREST_BOUNDARY) return cageform_status(CAGEFORM_CHOICE_UNKNOWN);
        cageform::BindOptions choice;
        choice.outside = static_cast<cageform::OutsidePoints>(own.outside);
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
    const cageform_status status = c::check_object(binding);
    if (status != CAGEFORM_OK) return status;
    if (figure == nullptr) return CAGEFORM_ARGUMENT_NULL;
    return c::with(binding->figure, [&](const auto& its) {
        const auto labels = its.label_bytes();
        return c::make_object(
            nullptr, 0, labels.size(),
            [&](cageform_figure& made, std::byte* memory) {
                auto view = its.view();
                if (view.labels.begin != nullptr) { // copied, for the binding may get others
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
    const cageform_status status = c::check_object(binding);
    if (status != CAGEFORM_OK) return status;
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
    const cageform_status status = c::check_object(binding);
    if (status != CAGEFORM_OK) return status;
    if (labels == nullptr && count > 0) return CAGEFORM_ARGUMENT_NULL;
    return c::guarded([&] {
        return c::with(binding->figure, [&](auto& its) {
            if (count != its.points.handle_count()) return c::code_of(cageform::Status::labels_do_not_match);
            std::vector<std::string_view> texts;
            for (std::size_t n = 0; n < count; ++n)
                texts.push_back(labels[n] == nullptr ? std::string_view{} : std::string_view(labels[n]));
            return c::code_of(its.set_labels(texts));
        });
    });
}

cageform_status cageform_binding_list(const cageform_binding* binding, uint32_t list, size_t* indices,
                                      size_t room, size_t* count) {
    namespace c = cageform::detail::c;
    const cageform_status status = c::check_object(binding);
    if (status != CAGEFORM_OK) return status;
    if (count == nullptr || (indices == nullptr && room > 0)) return CAGEFORM_ARGUMENT_NULL;
    if (list > CAGEFORM_LIST_FADED) return CAGEFORM_CHOICE_UNKNOWN;
    const auto& report = binding->report;
    const std::array lists{&report.on_boundary, &report.outside,      &report.not_finite,
                           &report.unreached,   &report.not_restored, &report.faded};
    const auto& its = *lists[list];
    *count = its.size();
    std::copy_n(its.begin(), std::min(room, its.size()), indices);
    return CAGEFORM_OK;
}

} // extern "C"
