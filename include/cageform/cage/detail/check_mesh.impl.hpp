// Closes small gaps of a triangle mesh, and checks whether it is a valid cage.
#pragma once

#include <cageform/cage/detail/facet_pairs.hpp>
#include <cageform/cage/detail/gaps.hpp>
#include <cageform/cage/detail/mesh_face.hpp>
#include <cageform/cage/detail/shells.hpp>
#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/cage/types/report.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The steps of `check` after the index check. Each step adds to the report.
template <Scalar T>
class MeshCheck {
public:
    MeshCheck(const TriangleMesh<T>& mesh, CageReport& report)
        : mesh_(mesh)
        , report_(report)
        , tolerance_(coincidence_tolerance(bounds_of(mesh.vertices()))) {
        for (const auto& face : mesh.faces()) facets_.push_back({face, mesh.vertices()});
    }

    void check_duplicate_vertices() {
        Buffer<Bounds<double, 3>> boxes;
        for (const auto& v : mesh_.vertices())
            boxes.push_back(Bounds<double, 3>{vec_cast<double>(v), vec_cast<double>(v)}.widened(tolerance_));
        for_each_overlap(boxes, [&](std::size_t i, std::size_t j) {
            if (length(vec_cast<double>(mesh_[i]) - vec_cast<double>(mesh_[j])) <= tolerance_)
                report_.add(CageFaultKind::duplicate_vertices, i, j);
        });
    }

    void check_areas() {
        for (std::size_t f = 0; f < facets_.size(); ++f) {
            if (is_flat(facets_[f].corner, tolerance_)) add_at_face(CageFaultKind::face_without_area, f, f);
        }
    }

    /// Checks that every edge has two half-edges of opposite directions.
    void check_edges() {
        const auto half_edges = half_edges_of(mesh_.faces());
        for_each_edge(half_edges, [&](std::span<const HalfEdge> edge) {
            const auto [low, high] = edge[0].edge();
            if (edge.size() == 1) {
                report_.add(CageFaultKind::open_edge, low, high);
            } else if (edge.size() > 2) {
                report_.add(CageFaultKind::edge_not_manifold, low, high);
            } else if (edge[0].from == edge[1].from) {
                report_.add(CageFaultKind::face_flipped, edge[0].face, edge[1].face);
            } else if (is_given(edge[0].face) != is_given(edge[1].face)) {
                report_.add(CageFaultKind::gap_closed, low, high);
            }
        });
    }

    /// Checks that the edges opposite to each vertex form one loop. All edges must be manifold.
    void check_fans() {
        using Edge = std::pair<std::uint32_t, std::uint32_t>;
        std::vector<std::vector<Edge>> opposite(mesh_.size());
        for (const auto& face : mesh_.faces()) {
            for (std::size_t k = 0; k < 3; ++k)
                opposite[face[k]].push_back({face[(k + 1) % 3], face[(k + 2) % 3]});
        }
        for (std::size_t i = 0; i < opposite.size(); ++i) {
            auto& edges = opposite[i];
            if (edges.empty()) {
                report_.add(CageFaultKind::vertex_unused, i);
                continue;
            }
            std::sort(edges.begin(), edges.end());
            std::size_t steps = 0;
            auto reached = edges.front().first;
            do {
                reached = std::lower_bound(edges.begin(), edges.end(), Edge(reached, 0))->second;
                ++steps;
            } while (reached != edges.front().first);
            if (steps != edges.size()) report_.add(CageFaultKind::vertex_not_manifold, i);
        }
    }

    /// Finds intersecting faces. Pairs around a vertex of many faces (the apex of a fan) are searched by
    /// direction from the apex.
    void check_crossing_faces() {
        const auto apex = apexes();
        FacetPairs<3>(facets_, apex, tolerance_)
            .for_each([&](std::size_t f, std::size_t g) { return cross_each_other(f, g); },
                      [&](std::size_t f, std::size_t g) { add_crossing(f, g); });
        std::vector<std::size_t> fans; // faces that have an apex, sorted by apex
        for (std::size_t f = 0; f < apex.size(); ++f) {
            if (apex[f] != no_apex) fans.push_back(f);
        }
        std::sort(fans.begin(), fans.end(), [&](std::size_t f, std::size_t g) {
            return apex[f] != apex[g] ? apex[f] < apex[g] : f < g;
        });
        for (std::size_t begin = 0, end = 0; begin < fans.size(); begin = end) {
            while (end < fans.size() && apex[fans[end]] == apex[fans[begin]]) ++end;
            check_fan(apex[fans[begin]], std::span(fans).subspan(begin, end - begin));
        }
    }

    void check_shells() {
        const auto shells = shells_of(mesh_);
        const double size = double(bounds_of(mesh_.vertices()).diagonal());
        for (std::size_t n = 0; n < shells.reversed.size(); ++n) {
            const auto face = shells.first_face[n];
            if (std::fabs(shells.volume[n]) <= tolerance_ * size * size)
                report_.add(CageFaultKind::no_volume, face);
            if (shells.reversed[n]) report_.add(CageFaultKind::shell_orientation_reversed, face);
        }
    }

private:
    bool is_given(std::size_t face) const noexcept { return face < mesh_.given_faces(); }
    /// Adds a fault of a face. If the face closes a gap, reports an open edge of the gap instead.
    void add_at_face(CageFaultKind kind, std::size_t face, std::size_t a, std::size_t b = 0) {
        if (is_given(face)) return report_.add(kind, a, b);
        report_.add(CageFaultKind::open_edge, facets_[face].vertex[1], facets_[face].vertex[2]);
    }
    bool cross_each_other(std::size_t f, std::size_t g) const noexcept {
        return passes(facets_[f], facets_[g]) || passes(facets_[g], facets_[f]);
    }
    void add_crossing(std::size_t f, std::size_t g) { add_at_face(CageFaultKind::faces_cross, g, f, g); }
    /// Returns the apex of every face: its vertex with the most faces, or no_apex if no vertex of the face
    /// has more than few_faces faces.
    std::vector<std::uint32_t> apexes() const {
        std::vector<std::uint32_t> faces_at(mesh_.size());
        for (const auto& facet : facets_) {
            for (const auto i : facet.vertex) ++faces_at[i];
        }
        std::vector<std::uint32_t> apex(facets_.size(), no_apex);
        for (std::size_t f = 0; f < facets_.size(); ++f) {
            std::uint32_t most = few_faces;
            for (const auto i : facets_[f].vertex) {
                if (faces_at[i] <= most) continue;
                most = faces_at[i];
                apex[f] = i;
            }
        }
        return apex;
    }
    /// Reports intersecting faces around an apex. Seen from the apex, each face is an arc on the unit
    /// sphere. The box of an arc is the box of its ends, widened by the height of the arc.
    void check_fan(std::uint32_t apex, std::span<const std::size_t> fan) {
        constexpr double rounding = 1e-12;
        const auto origin = vec_cast<double>(mesh_[apex]);
        Buffer<Bounds<double, 3>> arcs;
        for (const std::size_t f : fan) {
            std::array<Vec<double, 3>, 2> ends{};
            std::size_t n = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                if (facets_[f].vertex[k] == apex) continue;
                const auto d = facets_[f].corner[k] - origin;
                ends[n++] = (1 / length(d)) * d;
            }
            const double half_chord = 0.5 * length(ends[1] - ends[0]);
            const double height = 1 - std::sqrt(std::fmax(1 - half_chord * half_chord, 0.0));
            arcs.push_back(bounds_of(std::span<const Vec<double, 3>>(ends)).widened(height + rounding));
        }
        for_each_overlap(arcs, [&](std::size_t m, std::size_t n) {
            if (cross_each_other(fan[m], fan[n])) add_crossing(fan[m], fan[n]);
        });
    }
    /// Whether an edge of `f` passes through `g`. Edges that end in a shared vertex are skipped.
    static bool passes(const Facet<3>& f, const Facet<3>& g) noexcept {
        const std::array<bool, 3> shared{g.has(f.vertex[0]), g.has(f.vertex[1]), g.has(f.vertex[2])};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3;
            if (!shared[k] && !shared[l] && pierces(f.corner[k], f.corner[l], g.corner)) return true;
        }
        return false;
    }

    static constexpr std::uint32_t no_apex = FacetPairs<3>::no_group, few_faces = 32;

    const TriangleMesh<T>& mesh_;
    CageReport& report_;
    double tolerance_;
    Buffer<Facet<3>> facets_;
};

template <Scalar T>
void check_indices(const TriangleMesh<T>& mesh, CageReport& report) {
    if (mesh.size() < 4) report.add(CageFaultKind::too_few_vertices, 0, mesh.size());
    for (std::size_t i = 0; i < mesh.size(); ++i) {
        if (!is_finite(mesh[i])) report.add(CageFaultKind::vertex_not_finite, i);
    }
    const auto faces = mesh.faces();
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if (has_missing_vertex(faces[f])) report.add(CageFaultKind::face_without_vertex, f);
    }
    if (faces.empty() && report.status == Status::ok) report.add(CageFaultKind::no_volume, 0);
}

template <class T>
std::vector<MeshFace> closing_faces(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces) {
    return GapCloser<T>(vertices, faces).closing_faces();
}

} // namespace detail

template <class T>
CageReport check(const TriangleMesh<T>& mesh) {
    return detail::report_on(mesh.status(), [&](CageReport& report) {
        detail::check_indices(mesh, report);
        if (report.status != Status::ok) return;
        detail::MeshCheck<T> steps(mesh, report);
        steps.check_duplicate_vertices();
        steps.check_areas();
        steps.check_edges();
        if (report.status != Status::ok) return;
        steps.check_fans();
        steps.check_crossing_faces();
        if (report.status != Status::ok) return;
        steps.check_shells();
    });
}

} // namespace cageform::inline CAGEFORM_ABI
