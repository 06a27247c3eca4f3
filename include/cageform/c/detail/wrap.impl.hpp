// The functions of the C interface that wrap figures.
#pragma once

#include <cageform/c/detail/bind.impl.hpp>
#include <cageform/fit/wrap.hpp>

namespace cageform::inline CAGEFORM_ABI::detail::c {

template <class T>
struct BoundWrap {
    using scalar = T;
    Wrap<T> map;
    AnyCoordinates<T, 3> coordinates; ///< empty without a cage
};

} // namespace cageform::inline CAGEFORM_ABI::detail::c

struct cageform_wrap : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::wrap;

    std::variant<cageform::detail::c::BoundWrap<double>, cageform::detail::c::BoundWrap<float>> bound;
    cageform_cage lattice{}; // refers to the knots of the map's lattice
};

namespace cageform::inline CAGEFORM_ABI::detail::c {

template <class T>
cageform_cage describe_lattice(const LatticeCoordinates<T, 3>& lattice) {
    cageform_cage its{};
    its.size = sizeof(its);
    its.kind = CAGEFORM_LATTICE;
    its.dimension = 3;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto knots = lattice.knots(k);
        its.points[k] = static_cast<std::uint32_t>(lattice.points(k));
        its.degree[k] = static_cast<std::uint32_t>(knots.size() - lattice.points(k) - 1);
        its.knots[k] = knots.data();
        its.knot_counts[k] = knots.size();
        its.origin[k] = static_cast<double>(lattice.box().translation[k]);
        for (std::size_t n = 0; n < 3; ++n) its.axes[k][n] = static_cast<double>(lattice.box().columns[k][n]);
    }
    return its;
}

/// Returns the word for the culprit of a wrap that failed.
inline const char* word_of(const WrapReport& report, const WrapOptions& options) {
    switch (report.status) {
    case Status::figure_not_finite: return report.of_target ? "target vertex" : "source vertex";
    case Status::index_out_of_range: return report.of_target ? "target face" : "source face";
    case Status::value_not_finite: {
        const auto is_wrong = [](const Landmark& mark) {
            return !is_finite(mark.from) || !is_finite(mark.to) || !is_finite(mark.weight);
        };
        const std::size_t n = report.culprit;
        return n < options.landmarks.size() && is_wrong(options.landmarks[n]) ? "landmark" : "follower";
    }
    default: return "landmark";
    }
}

template <class T>
cageform_status keep_wrap(Result<Wrap<T>, WrapReport> made, AnyCoordinates<T, 3> coordinates,
                          cageform_wrap& object, WrapReport& report) {
    report = std::move(made.report);
    auto& kept = object.bound.template emplace<BoundWrap<T>>();
    kept = {std::move(made.value), std::move(coordinates)};
    if (kept.map.lattice) object.lattice = describe_lattice(*kept.map.lattice);
    return code_of(report.status);
}

inline cageform_status fit_wrap_of(const cageform_coordinates* coordinates, const SurfaceMesh& source,
                                   const SurfaceMesh& target, const WrapOptions& options,
                                   const Running& running, cageform_wrap& object, WrapReport& report) {
    if (coordinates == nullptr) return keep_wrap(wrap(source, target, options, running), {}, object, report);
    return with(coordinates->coordinates, [&](const auto& any) {
        if constexpr (std::remove_cvref_t<decltype(any)>::dimension == 3) {
            return keep_wrap(wrap(any, source, target, options, running), any, object, report);
        } else {
            return cageform_status(CAGEFORM_DIMENSION_DIFFERS);
        }
    });
}

/// Copies the landmarks, the followers and the numbers of the options.
inline cageform_status copy_options(const cageform_wrap_options& given, std::vector<Landmark>& landmarks,
                                    std::vector<Vec<double, 3>>& follow, WrapOptions& options) {
    if (given.landmarks == nullptr && given.landmark_count > 0) return CAGEFORM_ARGUMENT_NULL;
    for (std::size_t n = 0; n < given.landmark_count; ++n) {
        const cageform_landmark& mark = given.landmarks[n];
        landmarks.push_back({{mark.source[0], mark.source[1], mark.source[2]},
                             {mark.target[0], mark.target[1], mark.target[2]},
                             mark.weight != 0 ? mark.weight : 1});
    }
    const cageform_status status = copy_points(given.follow, follow);
    options.landmarks = landmarks;
    options.follow = follow;
    options.align = given.keep_place == 0;
    options.other_pose = given.other_pose != 0;
    options.refine_contacts = given.refine_contacts != 0;
    if (given.finest != 0) options.finest = given.finest;
    if (given.least_stiffness != 0) options.least_stiffness = given.least_stiffness;
    if (given.floor != 0) options.floor = given.floor;
    options.residual = given.residual;
    if (given.samples != 0) options.samples = given.samples;
    if (given.handles != 0) options.handles = given.handles;
    return status;
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c

extern "C" {

cageform_status cageform_fit_wrap(const cageform_coordinates* coordinates, const cageform_drawing* source,
                                  const cageform_drawing* target, const cageform_wrap_options* options,
                                  const cageform_running* running, cageform_wrap** wrap,
                                  cageform_report* report) {
    namespace c = cageform::detail::c;
    const char* word = "landmark";
    return c::reported(report, word, [&](cageform_report& its) {
        if (source == nullptr || target == nullptr || wrap == nullptr)
            return cageform_status(CAGEFORM_ARGUMENT_NULL);
        std::array<cageform_drawing, 2> given;
        std::array<cageform::SurfaceMesh, 2> meshes;
        cageform_wrap_options own;
        std::vector<cageform::Landmark> landmarks;
        std::vector<cageform::Vec<double, 3>> follow;
        cageform::WrapOptions choice;
        cageform_status status = coordinates == nullptr ? CAGEFORM_OK : c::check_object(coordinates);
        if (status == CAGEFORM_OK) status = c::read_struct(source, given[0]);
        if (status == CAGEFORM_OK) status = c::read_struct(target, given[1]);
        if (status == CAGEFORM_OK) status = c::read_struct(options, own);
        for (std::size_t n = 0; n < 2 && status == CAGEFORM_OK; ++n) {
            std::vector<cageform::Vec<double, 3>> points;
            std::vector<std::array<std::uint32_t, 3>> faces;
            status = c::copy_mesh(given[n], points, faces);
            if (status == CAGEFORM_OK) meshes[n] = cageform::SurfaceMesh(points, faces);
        }
        if (status == CAGEFORM_OK) status = c::copy_options(own, landmarks, follow, choice);
        if (status != CAGEFORM_OK) return status;
        cageform_status fitted = CAGEFORM_OK;
        status = c::with_running(running, [&](const cageform::Running& how) {
            return c::make_filled(wrap, [&](cageform_wrap& object) {
                cageform::WrapReport details;
                fitted = c::fit_wrap_of(coordinates, meshes[0], meshes[1], choice, how, object, details);
                c::fill(its, details);
                word = c::word_of(details, choice);
                return fitted == CAGEFORM_FIT_NOT_REACHED ? cageform_status(CAGEFORM_OK) : fitted;
            });
        });
        return status == CAGEFORM_OK ? fitted : status;
    });
}

cageform_status cageform_wrap_move(const cageform_wrap* wrap, cageform_points points, cageform_output moved,
                                   const cageform_output* jacobians, const cageform_running* running) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(wrap); code != CAGEFORM_OK) return code;
    c::AnyOutput<3> to_points;
    c::AnyOutput<9> to_jacobians;
    cageform_status status = to_points.set(&moved, points.count);
    if (status == CAGEFORM_OK) status = to_jacobians.set(jacobians, points.count);
    if (status != CAGEFORM_OK) return status;
    return c::guarded([&] {
        return c::with_running(running, [&](const cageform::Running& how) {
            return c::with(wrap->bound, [&]<class T>(const c::BoundWrap<T>& its) {
                std::vector<cageform::Vec<T, 3>> places;
                if (const auto code = c::copy_points(points, places); code != CAGEFORM_OK) return code;
                std::vector<std::array<cageform::Vec<T, 3>, 3>> matrices(
                    jacobians == nullptr ? 0 : places.size());
                const cageform::Status done =
                    its.map.pose.empty()
                        ? cageform::move(its.map, places, places, matrices, how)
                        : cageform::move(its.map, its.coordinates, places, places, matrices, how);
                if (done != cageform::Status::ok) return c::code_of(done);
                for (std::size_t n = 0; n < places.size(); ++n) {
                    to_points.store(n, places[n].v);
                    std::array<T, 9> numbers{};
                    for (std::size_t k = 0; k < 9 && !matrices.empty(); ++k)
                        numbers[k] = matrices[n][k / 3][k % 3];
                    to_jacobians.store(n, numbers.data());
                }
                return cageform_status(CAGEFORM_OK);
            });
        });
    });
}

cageform_status cageform_wrap_describe(const cageform_wrap* wrap, cageform_wrap_info* info) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(wrap); code != CAGEFORM_OK) return code;
    return c::with(wrap->bound, [&]<class T>(const c::BoundWrap<T>& its) {
        const auto view_of = [](const std::vector<cageform::Vec<T, 3>>& pose) -> cageform_points {
            return {pose.data(),
                    pose.size(),
                    0,
                    pose.size() * sizeof(pose[0]),
                    c::scalar_code<c::BoundWrap<T>>,
                    3};
        };
        cageform_wrap_info described{};
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t n = 0; n < 3; ++n)
                described.first[3 * k + n] = double(its.map.first.columns[k][n]);
            described.first[9 + k] = double(its.map.first.translation[k]);
        }
        described.pose = view_of(its.map.pose);
        if (its.map.lattice) described.lattice = &wrap->lattice;
        described.lattice_pose = view_of(its.map.lattice_pose);
        return c::write_struct(described, info);
    });
}

} // extern "C"
