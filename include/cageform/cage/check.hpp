// What is wrong with a cage, fault by fault, with indices.
#pragma once

#include <cageform/cage/inside.hpp>

#include <algorithm>
#include <numeric>
#include <tuple>

namespace cageform::inline CAGEFORM_ABI {

enum class CageFaultKind : std::uint8_t {
    too_few_vertices,   ///< loop `a` has `b` vertices, less than three
    not_a_simplex,      ///< `a` vertices where a simplex has `b`
    loops_do_not_match, ///< the loop sizes add up to `a`, the vertices to `b`
    vertex_not_finite,  ///< vertex `a`
    duplicate_vertices, ///< `a` and `b` coincide within rounding; in a polygon, neighbours
    edges_cross,        ///< the edges that start at vertices `a` and `b` cross or touch
    no_area,            ///< all vertices of loop `a` lie on one line
    degenerate_simplex, ///< the simplex has no volume relative to its size
    no_volume, ///< a box has no extent along axis `a`; a mesh has no faces, or the shell of face `a` is flat
    face_without_vertex,   ///< face `a` of a mesh names a vertex that there is not
    face_without_area,     ///< the corners of face `a` lie on one line
    open_edge,             ///< only one face has the edge between vertices `a` and `b`
    edge_not_manifold,     ///< more than two faces have the edge between vertices `a` and `b`
    face_flipped,          ///< of the neighbouring faces `a` and `b` one is turned inside out
    vertex_not_manifold,   ///< the faces about vertex `a` are not one closed fan
    faces_cross,           ///< the faces `a` and `b` pass through each other
    radius_not_positive,   ///< of the interior cell at handle `a`
    interior_cell_outside, ///< the interior cell at handle `a`
    interior_cells_touch, ///< the interior cell at handle `a` and the cell or facet at handle `b`, elsewhere than in a vertex
    interior_cells_not_supported, ///< by this coordinate type; there are `a` cells
    gap_closed, ///< warning: only one face has the edge between vertices `a` and `b`; the gap was closed
    collinear_vertex,      ///< warning: vertex `a` lies on the straight line between its neighbours
    vertex_unused,         ///< warning: no face has vertex `a`; its weights are zero
    shell_turns_otherwise, ///< warning: the shell of face `a` is counter-clockwise seen from inside; handled
    loop_turns_otherwise,  ///< warning: loop `a` is clockwise, or a hole `a` counter-clockwise; handled
};

/// One fault; what `a` and `b` are stands with each kind.
struct CageFault {
    CageFaultKind kind;
    std::size_t a = 0;
    std::size_t b = 0;
};

/// The Status a fault leads to; ok for a fault that is only a warning.
constexpr Status status_of(CageFaultKind kind) noexcept {
    switch (kind) {
    case CageFaultKind::too_few_vertices: return Status::too_few_vertices;
    case CageFaultKind::not_a_simplex: return Status::not_a_simplex;
    case CageFaultKind::loops_do_not_match: return Status::loops_do_not_match;
    case CageFaultKind::vertex_not_finite: return Status::vertex_not_finite;
    case CageFaultKind::duplicate_vertices: return Status::duplicate_vertices;
    case CageFaultKind::edges_cross: return Status::cage_self_crossing;
    case CageFaultKind::no_area: return Status::cage_has_no_area;
    case CageFaultKind::degenerate_simplex: return Status::degenerate_simplex;
    case CageFaultKind::no_volume: return Status::cage_has_no_volume;
    case CageFaultKind::face_without_vertex: return Status::face_without_vertex;
    case CageFaultKind::face_without_area: return Status::face_without_area;
    case CageFaultKind::open_edge: return Status::cage_not_closed;
    case CageFaultKind::edge_not_manifold:
    case CageFaultKind::vertex_not_manifold: return Status::cage_not_manifold;
    case CageFaultKind::face_flipped: return Status::cage_faces_flipped;
    case CageFaultKind::faces_cross: return Status::cage_faces_cross;
    case CageFaultKind::radius_not_positive: return Status::radius_not_positive;
    case CageFaultKind::interior_cell_outside: return Status::interior_cell_outside;
    case CageFaultKind::interior_cells_touch: return Status::interior_cells_touch;
    case CageFaultKind::interior_cells_not_supported: return Status::interior_cells_not_supported;
    case CageFaultKind::gap_closed:
    case CageFaultKind::collinear_vertex:
    case CageFaultKind::vertex_unused:
    case CageFaultKind::shell_turns_otherwise:
    case CageFaultKind::loop_turns_otherwise: return Status::ok;
    }
    return Status::ok;
}

constexpr const char* to_string(CageFaultKind kind) noexcept {
    switch (kind) {
    case CageFaultKind::too_few_vertices: return "too few vertices";
    case CageFaultKind::not_a_simplex: return "not a simplex";
    case CageFaultKind::loops_do_not_match: return "loop sizes do not add up";
    case CageFaultKind::vertex_not_finite: return "vertex not finite";
    case CageFaultKind::duplicate_vertices: return "duplicate vertices";
    case CageFaultKind::edges_cross: return "edges cross or touch";
    case CageFaultKind::no_area: return "loop without area";
    case CageFaultKind::degenerate_simplex: return "simplex without volume";
    case CageFaultKind::no_volume: return "no volume";
    case CageFaultKind::face_without_vertex: return "face names a missing vertex";
    case CageFaultKind::face_without_area: return "face without area";
    case CageFaultKind::open_edge: return "open edge";
    case CageFaultKind::edge_not_manifold: return "edge of more than two faces";
    case CageFaultKind::face_flipped: return "neighbouring faces turn differently";
    case CageFaultKind::vertex_not_manifold: return "faces about a vertex are no fan";
    case CageFaultKind::faces_cross: return "faces cross";
    case CageFaultKind::radius_not_positive: return "radius not positive";
    case CageFaultKind::interior_cell_outside: return "interior cell outside";
    case CageFaultKind::interior_cells_touch: return "interior cells touch";
    case CageFaultKind::interior_cells_not_supported: return "interior cells not supported";
    case CageFaultKind::vertex_unused: return "unused vertex (warning)";
    case CageFaultKind::gap_closed: return "open edge, closed (warning)";
    case CageFaultKind::collinear_vertex: return "collinear vertex (warning)";
    case CageFaultKind::shell_turns_otherwise: return "shell turns inside out (warning)";
    case CageFaultKind::loop_turns_otherwise: return "loop turns the other way (warning)";
    }
    return "unknown fault";
}

/// All faults of a cage. `status` is that of the first fault that is not a warning.
struct CageReport {
    Status status = Status::ok;
    std::vector<CageFault> faults;

    void add(CageFaultKind kind, std::size_t a = 0, std::size_t b = 0) {
        faults.push_back({kind, a, b});
        if (status == Status::ok) status = status_of(kind);
    }
};

namespace detail {

/// Whether the closed segments ab and cd come nearer to each other than `tolerance`.
inline bool segments_touch(const Vec<double, 2>& a, const Vec<double, 2>& b, const Vec<double, 2>& c,
                           const Vec<double, 2>& d, double tolerance) noexcept {
    const auto distance = [](const Vec<double, 2>& p, const Vec<double, 2>& s, const Vec<double, 2>& t) {
        return length(nearest_on_segment(p, s, t) - p);
    };
    const auto side = [](const Vec<double, 2>& s, const Vec<double, 2>& t, const Vec<double, 2>& p) {
        return cross(t - s, p - s) > 0;
    };
    // Segments either cross properly, and then each end is on its own side of the other segment, or the
    // least distance is taken at an end.
    if (side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b)) return true;
    return std::min({distance(c, a, b), distance(d, a, b), distance(a, c, d), distance(b, c, d)}) <=
           tolerance;
}

} // namespace detail

/// Whether a polygon can serve as a cage: every loop has three vertices and an area, consecutive vertices
/// are apart, and no two edges touch except neighbours at their common vertex. What "apart" means is the
/// cage's coincidence_tolerance. Usually O(#V log #V) (edges are swept by x), O(#V²) at worst.
template <Scalar T>
CageReport check(const Polygon<T>& polygon) {
    CageReport report;
    const std::size_t count = polygon.size();
    std::size_t in_loops = 0;
    for (const auto& loop : polygon.loops()) in_loops += loop.end - loop.begin;
    if (!polygon.loops_match()) {
        report.add(CageFaultKind::loops_do_not_match, in_loops, count);
        return report;
    }
    if (count == 0) report.add(CageFaultKind::too_few_vertices, 0, 0);
    for (std::size_t i = 0; i < count; ++i) {
        if (!is_finite(polygon[i])) report.add(CageFaultKind::vertex_not_finite, i);
    }
    for (std::size_t k = 0; k < polygon.loops().size() && count > 0; ++k) {
        const auto& loop = polygon.loops()[k];
        if (loop.end - loop.begin < 3) report.add(CageFaultKind::too_few_vertices, k, loop.end - loop.begin);
    }
    if (report.status != Status::ok) return report;

    const double tolerance = coincidence_tolerance(bounds_of(polygon.vertices()));
    struct Edge {
        std::size_t i, j;
        Vec<double, 2> a, b;
        double low, high;
    };
    std::vector<Edge> edges;
    edges.reserve(count);
    polygon.for_each_edge([&](std::size_t i, std::size_t j) {
        const auto a = vec_cast<double>(polygon[i]);
        const auto b = vec_cast<double>(polygon[j]);
        if (std::hypot(b[0] - a[0], b[1] - a[1]) <= tolerance)
            report.add(CageFaultKind::duplicate_vertices, i, j);
        edges.push_back({i, j, a, b, std::min(a[0], b[0]) - tolerance, std::max(a[0], b[0]) + tolerance});
    });
    std::vector<bool> flat(polygon.loops().size());
    for (std::size_t k = 0; k < flat.size(); ++k) {
        // Flat: no vertex leaves the line through the first vertex and the one farthest from it.
        const auto& loop = polygon.loops()[k];
        const auto a = vec_cast<double>(polygon[loop.begin]);
        Vec<double, 2> axis{0, 0};
        for (std::size_t i = loop.begin; i < loop.end; ++i) {
            const auto d = vec_cast<double>(polygon[i]) - a;
            if (dot(d, d) > dot(axis, axis)) axis = d;
        }
        flat[k] = true;
        const double length = std::sqrt(dot(axis, axis));
        for (std::size_t i = loop.begin; i < loop.end && flat[k]; ++i) {
            flat[k] = std::fabs(cross(axis, vec_cast<double>(polygon[i]) - a)) <= tolerance * length;
        }
        if (flat[k]) report.add(CageFaultKind::no_area, k);
    }
    if (report.status != Status::ok) return report;

    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t p, std::size_t q) { return edges[p].low < edges[q].low; });
    for (std::size_t p = 0; p < count; ++p) {
        for (std::size_t q = p + 1; q < count && edges[order[q]].low <= edges[order[p]].high; ++q) {
            const Edge& e = edges[std::min(order[p], order[q])];
            const Edge& f = edges[std::max(order[p], order[q])];
            bool touch = false;
            if (e.j == f.i || f.j == e.i) {
                // Neighbours share a vertex; they may not fold back onto each other.
                const auto& [tip, from, to] =
                    e.j == f.i ? std::tuple(e.b, e.a, f.b) : std::tuple(e.a, f.a, e.b);
                const auto u = from - tip, v = to - tip;
                const double shorter = std::sqrt(std::min(dot(u, u), dot(v, v)));
                const double longer = std::sqrt(std::max(dot(u, u), dot(v, v)));
                touch = dot(u, v) > 0 && std::fabs(cross(u, v)) <= tolerance * longer && shorter > 0;
            } else {
                touch = detail::segments_touch(e.a, e.b, f.a, f.b, tolerance);
            }
            if (touch) report.add(CageFaultKind::edges_cross, e.i, f.i);
        }
    }
    if (report.status != Status::ok) return report;

    for (std::size_t k = 0; k < polygon.loops().size(); ++k) {
        const auto& loop = polygon.loops()[k];
        for (std::size_t i = loop.begin; i < loop.end; ++i) {
            const auto& b = edges[i];
            const auto& a = edges[i > loop.begin ? i - 1 : loop.end - 1];
            if (std::fabs(cross(b.b - a.a, b.a - a.a)) <=
                tolerance * std::hypot(b.b[0] - a.a[0], b.b[1] - a.a[1])) {
                report.add(CageFaultKind::collinear_vertex, i);
            }
        }
        if ((signed_area(polygon, loop) < 0) != (loop_depth(polygon, k) % 2 == 1)) {
            report.add(CageFaultKind::loop_turns_otherwise, k);
        }
    }
    return report;
}

} // namespace cageform::inline CAGEFORM_ABI
