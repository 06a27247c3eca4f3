// The module of the page: the C interface as in the npm package, for double in 2D and float in 3D,
// and functions that only the page needs. The scripts of the npm package call both.
//
// Functions return a cageform_status. cageform_bytes_view reads the bytes that they make, cageform_free frees
// them.

#define CAGEFORM_C_TYPES Type<double, 2>, Type<float, 3>
#include <cageform/c/detail/figures.impl.hpp>
#include <cageform/coordinates/mean_value.hpp>

namespace cageform::inline CAGEFORM_ABI::detail::c {

/// Makes mean value coordinates of triangle meshes. All 3D coordinates would enlarge the module by 40 %.
template <>
inline cageform_status coordinates_of(const cageform_cage& cage, const cageform_coordinates_options&,
                                      AnyCoordinates<float, 3>& made) {
    std::vector<Vec<float, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces(cage.index_count / 3);
    const cageform_status status = copy_points(cage.vertices, vertices);
    if (status != CAGEFORM_OK) return status;
    for (std::size_t n = 0; n < faces.size(); ++n) std::copy_n(cage.indices + 3 * n, 3, faces[n].begin());
    made = MeanValueCoordinates<float, 3>(TriangleMesh<float>(vertices, faces));
    return CAGEFORM_OK;
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c

#if defined(__wasm__)
#include "../bindings/npm/cageform.cpp"
#define PAGE_EXPORT(name) extern "C" __attribute__((export_name(#name)))
#else // a test compiles this file
#define CAGEFORM_C_IMPLEMENTATION
#include <cageform/c/cageform.h>
#define PAGE_EXPORT(name) extern "C"
#endif

#include "pins.hpp"

#include <cageform/animate/compile.hpp>
#include <cageform/binding/skin_weights.hpp>
#include <cageform/clone/glsl.hpp>

namespace c = cageform::detail::c;

struct page_pins : c::Object {
    static constexpr Kind its_kind = Kind::pins;

    c::OfAnyType<cageform_page::Pins> pins;
};

namespace {

using cageform::AnyCoordinates;

template <class X>
struct List {
    std::vector<X> all;
    std::span<const std::byte> bytes() const { return std::as_bytes(std::span(all)); }
};

/// Calls use(pins, coordinates) with coordinates of the type of the pins.
template <class Use>
cageform_status with_both(page_pins* pins, const cageform_coordinates* coordinates, const Use& use) {
    return c::with(pins->pins, [&](auto& its) {
        using Coordinates = typename std::remove_reference_t<decltype(its)>::Coordinates;
        const auto* const own = std::get_if<Coordinates>(&coordinates->coordinates);
        return own == nullptr ? cageform_status(CAGEFORM_DIMENSION_DIFFERS) : use(its, *own);
    });
}

} // namespace

/// Writes the weight of a handle at every bound point.
PAGE_EXPORT(page_weights)
cageform_status page_weights(const cageform_binding* binding, std::size_t handle, double* weights) {
    return c::with(binding->figure, [&](const auto& figure) {
        for (std::size_t i = 0; i < figure.points.point_count(); ++i)
            weights[i] = double(figure.points.weight(i, handle));
        return cageform_status(CAGEFORM_OK);
    });
}

/// Writes vertex normals, not normalised: sums of the normals of the triangles, weighted by area.
PAGE_EXPORT(page_normals)
void page_normals(const cageform::Vec<float, 3>* places, std::size_t count, const std::uint32_t* faces,
                  std::size_t corners, cageform::Vec<float, 3>* normals) {
    std::fill_n(normals, count, cageform::Vec<float, 3>{});
    for (const std::uint32_t* face = faces; face != faces + corners; face += 3) {
        const auto a = places[face[0]], normal = cross(places[face[1]] - a, places[face[2]] - a);
        for (std::size_t k = 0; k < 3; ++k) normals[face[k]] = normals[face[k]] + normal;
    }
}

/// Makes a skin: `influences` weights (float) per point, then as many joints (16 bits) per point.
PAGE_EXPORT(page_skin)
cageform_status page_skin(const cageform_binding* binding, std::size_t influences, cageform_bytes** made) {
    return c::with(binding->figure, [&](const auto& figure) {
        auto [skin, report] = cageform::skin_weights(figure.points, {.influences = influences});
        if (report.status != cageform::Status::ok) return c::code_of(report.status);
        List<std::byte> all;
        const auto weights = std::as_bytes(std::span(skin.weights)),
                   joints = std::as_bytes(std::span(skin.joints));
        all.all.assign(weights.begin(), weights.end());
        all.all.insert(all.all.end(), joints.begin(), joints.end());
        return c::make_bytes(std::move(all), made);
    });
}
/// Returns the library's text for the vertex shader of a skin.
PAGE_EXPORT(page_glsl) const char* page_glsl() {
    static const std::string text = std::string(cageform::glsl::displacements) + cageform::glsl::skin;
    return text.c_str();
}

/// Compiles a track of Bézier keys to cubic pieces.
///
///   keys    seven numbers each: time, value, kind, in-handle, out-handle
///   pieces  the largest error, then for each piece its begin and four coefficients
PAGE_EXPORT(page_compile)
cageform_status page_compile(const double* keys, std::size_t count, double tolerance,
                             cageform_bytes** pieces) {
    std::vector<cageform::Key> track(count);
    for (cageform::Key& key : track) {
        key.time = keys[0];
        key.value = keys[1];
        key.kind = static_cast<cageform::KeyKind>(keys[2]);
        key.in_handle = {keys[3], keys[4]};
        key.out_handle = {keys[5], keys[6]};
        keys += 7;
    }
    cageform::TrackOptions options;
    options.tolerance = tolerance;
    const auto [compiled, report] = cageform::compile<double>(track, options);
    if (report.status != cageform::Status::ok) return c::code_of(report.status);
    List<double> made{{report.sup_error}};
    for (const auto& piece : compiled.curve.pieces())
        made.all.insert(made.all.end(), {piece.begin, piece.c0, piece.c1, piece.c2, piece.c3});
    return c::make_bytes(std::move(made), pieces);
}

// ---- pins. A pose has all points of the cage ----

PAGE_EXPORT(page_pins_create)
cageform_status page_pins_create(const cageform_coordinates* coordinates, const cageform_samples* samples,
                                 page_pins** made) {
    return c::with(coordinates->coordinates, [&]<class T, std::size_t D>(const AnyCoordinates<T, D>& any) {
        const auto* const its = std::get_if<cageform::PoseSamples<T, D>>(&samples->samples);
        if (its == nullptr) return cageform_status(CAGEFORM_DIMENSION_DIFFERS);
        return c::make_filled(made, [&](page_pins& object) {
            return c::code_of(object.pins.emplace<cageform_page::Pins<T, D>>().take(any, *its));
        });
    });
}
/// Sets pins by their rest points, flags of those that rotate (null: none), and the held points of the cage.
///
///   culprit  out: the invalid pin
PAGE_EXPORT(page_pins_set)
cageform_status page_pins_set(page_pins* pins, const cageform_coordinates* coordinates, const double* places,
                              std::size_t count, const std::uint8_t* turned, const std::uint32_t* held,
                              std::size_t held_count, std::size_t* culprit) {
    return with_both(pins, coordinates, [&](auto& its, const auto& own) {
        const std::size_t dimension = std::remove_reference_t<decltype(its)>::dimension;
        const auto status = its.set(own, {places, count * dimension}, {turned, turned == nullptr ? 0 : count},
                                    {held, held_count});
        *culprit = its.culprit();
        return c::code_of(status);
    });
}
/// Sets the initial pose of the solver.
PAGE_EXPORT(page_pins_begin)
cageform_status page_pins_begin(page_pins* pins, const double* pose, std::size_t count) {
    return c::with(pins->pins, [&](auto& its) { return c::code_of(its.begin(pose, count)); });
}
/// Moves a pose towards the targets.
///
///   turns  of pins that rotate: 2D an angle, 3D the axis times the angle, in radians; or null
///   told   out: 1 if the pose has settled, the largest miss, the iterations, the number of inverted clusters
PAGE_EXPORT(page_pins_solve)
cageform_status page_pins_solve(page_pins* pins, const double* targets, const double* turns, double* pose,
                                std::size_t count, double* told) {
    return c::with(pins->pins, [&](auto& its) {
        const auto report = its.solve(targets, turns, pose, count);
        const double all[] = {double(report.settled), report.miss, double(report.iterations),
                              double(report.folded)};
        std::copy(std::begin(all), std::end(all), told);
        return c::code_of(report.status);
    });
}
/// Writes the position of each pin in a pose, and the Jacobian of the pose there, column-major.
PAGE_EXPORT(page_pins_locate)
cageform_status page_pins_locate(page_pins* pins, const double* pose, std::size_t count, double* places) {
    return c::with(pins->pins, [&](auto& its) { return c::code_of(its.locate(pose, count, places)); });
}
/// Finds the rest point that a pose in 2D moves to a place.
///
///   ends   the start point and the place
///   found  out: the rest point, and its distance from the place in the pose
PAGE_EXPORT(page_pins_find)
cageform_status page_pins_find(page_pins* pins, const cageform_coordinates* coordinates, const double* ends,
                               const double* pose, std::size_t count, double* found) {
    return with_both(pins, coordinates, [&](auto& its, const auto& own) {
        if constexpr (std::remove_reference_t<decltype(its)>::dimension == 2) {
            const auto point = its.find(own, ends, pose, count);
            std::copy_n(point.at.v, 2, found);
            found[2] = point.miss;
        }
        return cageform_status(CAGEFORM_OK);
    });
}
