// Checks whether a polygon is a valid cage.
#pragma once

#include <cageform/cage/detail/facet_pairs.hpp>
#include <cageform/cage/detail/loop_sides.hpp>
#include <cageform/cage/polygon.hpp>
#include <cageform/cage/types/report.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

template <Scalar T>
void check_loops(const Polygon<T>& polygon, CageReport& report) {
    const auto loops = polygon.loops();
    if (!polygon.loops_match()) {
        std::size_t in_loops = 0;
        for (const auto& loop : loops) in_loops += loop.size();
        return report.add(CageFaultKind::loops_do_not_match, in_loops, polygon.size());
    }
    if (polygon.size() == 0) return report.add(CageFaultKind::too_few_vertices, 0, 0);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        if (!is_finite(polygon[i])) report.add(CageFaultKind::vertex_not_finite, i);
    }
    for (std::size_t k = 0; k < loops.size(); ++k) {
        if (loops[k].size() < 3) report.add(CageFaultKind::too_few_vertices, k, loops[k].size());
    }
}

inline void check_crossing_edges(std::span<const Facet<2>> edges, double tolerance, CageReport& report) {
    FacetPairs<2>(edges, {}, tolerance)
        .for_each([&](std::size_t m, std::size_t n) { return facets_touch(edges[m], edges[n], tolerance); },
                  [&](std::size_t m, std::size_t n) {
                      report.add(CageFaultKind::edges_cross, edges[m].vertex[0], edges[n].vertex[0]);
                  });
}

/// Adds a warning for each vertex with collinear edges.
inline void check_collinear_vertices(std::span<const Facet<2>> edges, double tolerance, CageReport& report) {
    const Facet<2>* before = &edges.back();
    for (const auto& edge : edges) {
        const auto& from = before->corner[0];
        const auto along = edge.corner[1] - from;
        if (std::fabs(cross(along, edge.corner[0] - from)) <= tolerance * std::hypot(along[0], along[1]))
            report.add(CageFaultKind::collinear_vertex, edge.vertex[0]);
        before = &edge;
    }
}

template <Scalar T>
void check_polygon(const Polygon<T>& polygon, CageReport& report) {
    check_loops(polygon, report);
    if (report.status != Status::ok) return;

    const double tolerance = coincidence_tolerance(bounds_of(polygon.vertices()));
    Buffer<Facet<2>> edges; // edge i starts at vertex i
    for_each_facet(polygon, [&](const auto& edge) { edges.push_back({edge, polygon.vertices()}); });
    const auto edges_of = [&](std::size_t k) {
        return std::span(edges).subspan(polygon.loops()[k].begin, polygon.loops()[k].size());
    };
    for (const auto& edge : edges) {
        const auto e = edge.corner[1] - edge.corner[0];
        if (std::hypot(e[0], e[1]) <= tolerance)
            report.add(CageFaultKind::duplicate_vertices, edge.vertex[0], edge.vertex[1]);
    }
    for (std::size_t k = 0; k < polygon.loops().size(); ++k) {
        const auto& loop = polygon.loops()[k];
        if (are_collinear<T>(polygon.vertices().subspan(loop.begin, loop.size()), tolerance))
            report.add(CageFaultKind::no_area, k);
    }
    if (report.status != Status::ok) return;

    check_crossing_edges(edges, tolerance, report);
    if (report.status != Status::ok) return;

    for (std::size_t k = 0; k < polygon.loops().size(); ++k) {
        check_collinear_vertices(edges_of(k), tolerance, report);
        if (!inside_is_left(polygon, k)) report.add(CageFaultKind::loop_orientation_reversed, k);
    }
}

} // namespace detail

template <class T>
CageReport check(const Polygon<T>& polygon) {
    return detail::report_on(polygon.status(),
                             [&](CageReport& report) { detail::check_polygon(polygon, report); });
}

} // namespace cageform::inline CAGEFORM_ABI
