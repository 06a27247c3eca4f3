// Checks that the faces of a polyhedral mesh are planar polygons or fans, and that its triangles form a
// closed surface.
#pragma once

#include <cageform/cage/detail/flat_face.hpp>
#include <cageform/cage/faces_of.hpp>
#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/cage/types/report.hpp>

#include <algorithm>
#include <numbers>
#include <optional>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Returns a face that has the given vertex or fan point as a corner; face_count() if there is none.
template <Scalar T>
std::size_t face_at(const PolyhedralMesh<T>& mesh, std::size_t point) {
    const auto faces = mesh.triangles().faces();
    for (std::size_t t = 0; t < faces.size(); ++t) {
        if (std::find(faces[t].begin(), faces[t].end(), point) != faces[t].end()) return mesh.face_of(t);
    }
    return mesh.face_count();
}

/// Replaces the fan points in a fault of the triangle mesh by vertices or faces of the polyhedral mesh.
template <Scalar T>
void name_without_points(const PolyhedralMesh<T>& mesh, CageFault& fault) {
    using Kind = CageFaultKind;
    const auto is_point = [&](std::size_t i) { return i >= mesh.size() && i < mesh.triangles().size(); };
    if (fault.kind == Kind::vertex_not_finite) { // finite corners whose mean is not finite
        if (!is_point(fault.a)) return;
        const auto corners = mesh.fan_points().corners(fault.a - mesh.size());
        const auto size = [&](std::uint32_t i) {
            return bounds_of(mesh.vertices().subspan(i, 1)).magnitude();
        };
        fault.a = *std::max_element(corners.begin(), corners.end(),
                                    [&](auto i, auto j) { return size(i) < size(j); });
    } else if (fault.kind == Kind::duplicate_vertices) {
        if (!is_point(fault.a) && !is_point(fault.b)) return;
        fault = {Kind::faces_cross, face_at(mesh, fault.a), face_at(mesh, fault.b)};
    } else if (fault.kind == Kind::open_edge || fault.kind == Kind::edge_not_manifold ||
               fault.kind == Kind::gap_closed) { // part of a divided edge
        if (!is_point(fault.a) && !is_point(fault.b)) return;
        const auto corners = mesh.fan_points().corners((is_point(fault.a) ? fault.a : fault.b) - mesh.size());
        fault = {fault.kind, corners[0], corners[1]};
    } else if (fault.kind == Kind::vertex_not_manifold && is_point(fault.a)) {
        fault.a = mesh.fan_points().corners(fault.a - mesh.size())[0];
    }
}

/// Adds the faults of the triangle mesh, with triangle indices replaced by face indices.
template <Scalar T>
void add_faults_of_triangles(const PolyhedralMesh<T>& mesh, CageReport& report) {
    using Kind = CageFaultKind;
    const CageReport found = check(mesh.triangles());
    for (CageFault fault : found.faults) {
        const bool names_one = fault.kind == Kind::face_without_vertex ||
                               fault.kind == Kind::face_without_area || fault.kind == Kind::no_volume ||
                               fault.kind == Kind::shell_orientation_reversed;
        const bool names_two = fault.kind == Kind::face_flipped || fault.kind == Kind::faces_cross;
        if (names_one || names_two) fault.a = mesh.face_of(fault.a);
        if (names_two) fault.b = mesh.face_of(fault.b);
        name_without_points(mesh, fault);
        const auto same = [&](const CageFault& known) {
            return known.kind == fault.kind && known.a == fault.a && known.b == fault.b;
        };
        if (std::none_of(report.faults.begin(), report.faults.end(), same))
            report.add(fault.kind, fault.a, fault.b);
    }
    if (report.status == Status::ok) report.status = found.status;
}

/// Returns the first fault of a fan, if any: face_crosses_itself, face_without_area or face_fan_folds. The
/// triangles around the mean must turn once around the face's normal ½ Σ c_i × c_{i+1}. The normal of every
/// triangle must have a positive component along the face's normal. O(m log m) for m corners.
template <Scalar T>
std::optional<CageFault> fan_fault(const PolyhedralMesh<T>& mesh, std::size_t f) {
    using Kind = CageFaultKind;
    const auto loop = mesh.face(f);
    std::vector<std::uint32_t> sorted(loop.begin(), loop.end());
    std::sort(sorted.begin(), sorted.end());
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end()) return CageFault{Kind::face_crosses_itself, f, *twice};

    auto at = corners_of(mesh, f);
    const auto own = bounds_of(std::span<const Vec<double, 3>>(at));
    const double scale = unit_scale(own); // keeps products in range
    const double tolerance = scale * double(coincidence_tolerance(bounds_of(mesh.vertices())));
    Vec<double, 3> mean{}, normal{};
    for (const auto& c : at) mean = mean + (1 / double(at.size())) * c;
    for (auto& c : at) c = scale * (c - mean);
    const auto next = [&](std::size_t k) { return at[(k + 1) % at.size()]; };
    for (std::size_t k = 0; k < at.size(); ++k) normal = normal + 0.5 * cross(at[k], next(k));
    if (!(dot(normal, normal) > 0) || !is_finite(normal)) return CageFault{Kind::face_without_area, f};
    double turned = 0;
    for (std::size_t k = 0; k < at.size(); ++k) {
        if (distance_to_segment({}, at[k], next(k)) <= tolerance)
            return CageFault{Kind::face_without_area, f};
        const auto of_triangle = cross(at[k], next(k));
        if (!(dot(of_triangle, normal) > 0)) return CageFault{Kind::face_fan_folds, f, loop[k]};
        // The angle in the projection along the normal; both are scaled by |normal|².
        const double sine = dot(of_triangle, normal) * length(normal);
        const double cosine =
            dot(at[k], next(k)) * dot(normal, normal) - dot(at[k], normal) * dot(next(k), normal);
        turned += std::atan2(sine, cosine);
    }
    if (turned > 3 * std::numbers::pi) return CageFault{Kind::face_fan_folds, f, loop[0]};
    if (mesh.options().divisions == 1 || loop.size() != 4) return std::nullopt;
    const auto [first, last] = mesh.triangles_of(f);
    for (std::size_t t = first; t < last; ++t) { // cells of the patch
        const auto [a, b, c] = Facet<3>(mesh.triangles().faces()[t], mesh.triangles().vertices()).corner;
        if (!(dot(cross(scale * (b - a), scale * (c - a)), normal) > 0))
            return CageFault{Kind::face_fan_folds, f, loop[0]};
    }
    return std::nullopt;
}

/// Adds a warning for each non-planar fan. With k divisions, the reported distance is that of the k × k
/// cells.
template <Scalar T>
void add_fans(const PolyhedralMesh<T>& mesh, CageReport& report) {
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        if (!mesh.is_fan(f)) continue;
        const auto at = corners_of(mesh, f);
        const double off_plane = FarthestCorner(at, FacePlane(at)).distance;
        if (!(off_plane > mesh.off_plane())) continue;
        const double cells = double(mesh.options().divisions) * double(mesh.options().divisions);
        const double distance =
            at.size() == 4 ? length((at[0] - at[1]) + (at[2] - at[3])) / (16 * cells) : off_plane;
        report.add(CageFaultKind::face_fanned, f);
        report.fan_distances.push_back(distance);
    }
}

} // namespace detail

template <class T>
std::optional<CageFault> face_fault(const PolyhedralMesh<T>& mesh, std::size_t f) {
    using Kind = CageFaultKind;
    const auto loop = mesh.face(f);
    if (loop.size() < 3) return CageFault{Kind::too_few_vertices, f, loop.size()};
    if (std::find(loop.begin(), loop.end(), no_vertex) != loop.end())
        return CageFault{Kind::face_without_vertex, f};
    if (loop.size() == 3) return std::nullopt;
    if (mesh.is_fan(f)) return detail::fan_fault(mesh, f);
    const auto corners = detail::corners_of(mesh, f);
    const detail::FacePlane plane(corners);
    if (!plane.has_area) return CageFault{Kind::face_without_area, f};
    const detail::FarthestCorner farthest(corners, plane);
    if (farthest.distance > mesh.off_plane())
        return CageFault{Kind::face_not_planar, f, loop[farthest.corner]};
    const CageReport in_plane = check(detail::flat_face(mesh, f, plane));
    for (const CageFault& fault : in_plane.faults) {
        if (fault.kind == Kind::no_area) return CageFault{Kind::face_without_area, f};
        if (status_of(fault.kind) != Status::ok)
            return CageFault{Kind::face_crosses_itself, f, loop[fault.a]};
    }
    if (in_plane.status != Status::ok) return CageFault{Kind::face_crosses_itself, f, loop[0]};
    return std::nullopt;
}

template <class T>
CageReport check(const PolyhedralMesh<T>& mesh) {
    return detail::report_on(mesh.status(), [&](CageReport& report) {
        for (std::size_t i = 0; i < mesh.size(); ++i) {
            if (!is_finite(mesh[i])) report.add(CageFaultKind::vertex_not_finite, i);
        }
        const std::uint32_t divisions = mesh.options().divisions;
        if (divisions < 1 || divisions > mesh.most_divisions)
            report.add(CageFaultKind::face_divisions, divisions);
        if (report.status != Status::ok) return;
        for (std::size_t f = 0; f < mesh.face_count(); ++f) {
            if (const auto fault = face_fault(mesh, f)) report.add(fault->kind, fault->a, fault->b);
        }
        if (report.status != Status::ok) return;
        detail::add_fans(mesh, report);
        detail::add_faults_of_triangles(mesh, report);
    });
}

} // namespace cageform::inline CAGEFORM_ABI
