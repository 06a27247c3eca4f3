// Checks whether the faces of a polyhedral mesh are planar polygons, and its triangles a closed surface.
#pragma once

#include <cageform/cage/detail/faces_of.hpp>
#include <cageform/cage/detail/flat_face.hpp>
#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/cage/types/report.hpp>

#include <algorithm>
#include <optional>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Adds the faults of the triangle mesh, with triangle numbers translated to face numbers.
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
        const auto same = [&](const CageFault& known) {
            return known.kind == fault.kind && known.a == fault.a && known.b == fault.b;
        };
        if (std::none_of(report.faults.begin(), report.faults.end(), same))
            report.add(fault.kind, fault.a, fault.b);
    }
    if (report.status == Status::ok) report.status = found.status;
}

/// Returns the first fault of one face, if any: too_few_vertices, face_without_vertex and, for more
/// than three corners, face_without_area, face_not_planar or face_crosses_itself. Assumes finite
/// vertices. O(m log m) for m corners, O(m²) at worst.
template <Scalar T>
std::optional<CageFault> face_fault(const PolyhedralMesh<T>& mesh, std::size_t f) {
    using Kind = CageFaultKind;
    const auto loop = mesh.face(f);
    if (loop.size() < 3) return CageFault{Kind::too_few_vertices, f, loop.size()};
    if (std::find(loop.begin(), loop.end(), no_vertex) != loop.end())
        return CageFault{Kind::face_without_vertex, f};
    if (loop.size() == 3) return std::nullopt;
    const auto plane = plane_of(mesh, f);
    if (!plane.has_area) return CageFault{Kind::face_without_area, f};
    std::uint32_t farthest = loop[0];
    double most = 0;
    for (const std::uint32_t i : loop) {
        const double height = std::fabs(plane.height(vec_cast<double>(mesh[i])));
        if (height > most) farthest = i;
        most = std::fmax(most, height);
    }
    if (most > mesh.off_plane()) return CageFault{Kind::face_not_planar, f, farthest};
    const CageReport in_plane = check(flat_face(mesh, f, plane));
    for (const CageFault& fault : in_plane.faults) {
        if (fault.kind == Kind::no_area) return CageFault{Kind::face_without_area, f};
        if (status_of(fault.kind) != Status::ok)
            return CageFault{Kind::face_crosses_itself, f, loop[fault.a]};
    }
    if (in_plane.status != Status::ok) return CageFault{Kind::face_crosses_itself, f, loop[0]};
    return std::nullopt;
}

} // namespace detail

template <class T>
CageReport check(const PolyhedralMesh<T>& mesh) {
    return detail::report_on(mesh.status(), [&](CageReport& report) {
        for (std::size_t i = 0; i < mesh.size(); ++i) {
            if (!is_finite(mesh[i])) report.add(CageFaultKind::vertex_not_finite, i);
        }
        if (report.status != Status::ok) return;
        for (std::size_t f = 0; f < mesh.face_count(); ++f) {
            if (const auto fault = detail::face_fault(mesh, f)) report.add(fault->kind, fault->a, fault->b);
        }
        if (report.status != Status::ok) return;
        detail::add_faults_of_triangles(mesh, report);
    });
}

} // namespace cageform::inline CAGEFORM_ABI
