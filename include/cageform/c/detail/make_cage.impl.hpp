// The functions of the C interface that check and make cages.
#pragma once

#include <cageform/c/detail/pins.impl.hpp>

#include <cageform/c/detail/cages.hpp>
#include <cageform/c/detail/running.hpp>
#include <cageform/enclose/make_cage.hpp>
#include <cageform/enclose/make_cage_3d.hpp>

struct cageform_made_cage : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::made_cage;

    std::vector<double> vertices;
    std::vector<std::uint32_t> counts, indices;
    std::uint32_t dimension = 2;
};

namespace cageform::inline CAGEFORM_ABI::detail::c {

/// Checks the arrays of a drawing; each element has `together` indices.
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

/// Copies the vertices and the triangles of a drawing in space.
inline cageform_status copy_mesh(const cageform_drawing& drawing, std::vector<Vec<double, 3>>& points,
                                 std::vector<std::array<std::uint32_t, 3>>& faces) {
    cageform_status status = check_drawing(drawing, 3);
    if (status == CAGEFORM_OK) status = copy_points(drawing.points, points);
    if (status == CAGEFORM_OK) faces = triangles_of(drawing.indices, drawing.index_count);
    return status;
}

inline cageform_status make_cage_in_space(const cageform_drawing& drawing, const MakeCageOptions& options,
                                          const Running& running, cageform_made_cage& object,
                                          cageform_report& report) {
    std::vector<Vec<double, 3>> points;
    std::vector<std::array<std::uint32_t, 3>> faces;
    if (const cageform_status status = copy_mesh(drawing, points, faces); status != CAGEFORM_OK)
        return status;
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
        if (status != CAGEFORM_OK) return status;
        if (own.kind > CAGEFORM_SITES && !c::has_cells(own)) return cageform_status(CAGEFORM_CHOICE_UNKNOWN);
        status = c::with_type(CAGEFORM_DOUBLE, c::dimension_of(own),
                              [&]<class T, std::size_t D>() { return c::check_cage<T, D>(own, report); });
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
    if (const auto code = c::check_object(made); code != CAGEFORM_OK) return code;
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

} // extern "C"
