// The 3D cage, a closed triangle mesh: its data, point location, and its check.
#pragma once

#include <cageform/cage/detail/boundary_value.hpp>
#include <cageform/cage/detail/faces_of.hpp>
#include <cageform/cage/detail/facet_pairs.hpp>
#include <cageform/cage/detail/gaps.hpp>
#include <cageform/cage/types/report.hpp>
#include <cageform/core/detail/buffer.hpp>
#include <cageform/core/view.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A range of faces that can be read by index: `faces[f][k]`, k = 0, 1, 2, is an integer.
template <class F>
concept FaceRange = requires(const F& faces, std::size_t i) {
    { std::size(faces) } -> std::convertible_to<std::size_t>;
    requires std::integral<std::remove_cvref_t<decltype(faces[i][i])>>;
};

namespace detail {

/// Returns a face with no_vertex in place of indices below 0 or from `count` on.
template <class F>
MeshFace checked_face(const F& face, std::size_t count) noexcept {
    MeshFace checked;
    for (std::size_t k = 0; k < 3; ++k)
        checked[k] = face[k] >= 0 && std::uint64_t(face[k]) < count ? std::uint32_t(face[k]) : no_vertex;
    return checked;
}
template <std::size_t D>
bool lacks_vertex(const std::array<std::uint32_t, D>& facet) noexcept {
    return std::find(facet.begin(), facet.end(), no_vertex) != facet.end();
}

} // namespace detail

/// A cage in space: triangles over shared vertices, counter-clockwise seen from outside. Any genus,
/// components and cavities are allowed; shells that are oriented inwards as a whole are handled.
///
/// Copies the vertices and faces (a cage is small). Construction never fails; `check` reports
/// whether the mesh can serve as a cage, and every coordinate type calls it.
///
/// Small gaps are closed by faces over the vertices around them, so that coordinates keep their
/// laws; `check` names the edges of these gaps in warnings. Gaps are small if they add up to at
/// most a quarter of the area. Takes O(#F log #F) and, for a gap of n edges, O(n min(n, 256)).
template <Scalar T>
class TriangleMesh {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 3;
    using Face = std::array<std::uint32_t, 3>;

    TriangleMesh() = default;

    /// `faces[f][k]`, k = 0, 1, 2, is the vertex at a corner of a face. Indices out of range are
    /// remembered, and `check` reports them.
    template <PointRange R, FaceRange F>
        requires(range_dimension<R> == 3)
    TriangleMesh(const R& vertices, const F& faces)
        : status_(detail::guard_memory([&] { return fill(vertices, faces); })) {
        if (status_ != Status::ok) *this = TriangleMesh(status_);
    }

    /// Returns out_of_memory if vertices and faces did not fit in memory; the mesh is then empty.
    /// `check` reports it. (Copying throws, as copying a std::vector does.)
    Status status() const noexcept { return status_; }
    std::size_t size() const noexcept { return vertices_.size(); }
    std::span<const Vec<T, 3>> vertices() const noexcept { return vertices_; }
    const Vec<T, 3>& operator[](std::size_t i) const noexcept { return vertices_[i]; }
    /// Returns the given faces, then those that close gaps.
    std::span<const Face> faces() const noexcept { return faces_; }
    std::size_t given_faces() const noexcept { return given_; }

private:
    explicit TriangleMesh(Status status) noexcept
        : status_(status) {}

    template <class R, class F>
    Status fill(const R& vertices, const F& faces) {
        vertices_.reserve(std::size(vertices));
        for (std::size_t i = 0; i < std::size(vertices); ++i) vertices_.push_back(to_vec<T>(vertices[i]));
        faces_.reserve(std::size(faces));
        for (std::size_t f = 0; f < std::size(faces); ++f)
            faces_.push_back(detail::checked_face(faces[f], vertices_.size()));
        given_ = faces_.size();
        if (std::any_of(faces_.begin(), faces_.end(), detail::lacks_vertex<3>)) return Status::ok;
        const auto closing = detail::GapCloser<T>(vertices_, faces_).closing_faces();
        faces_.insert(faces_.end(), closing.begin(), closing.end());
        return Status::ok;
    }

    std::vector<Vec<T, 3>> vertices_;
    std::vector<Face> faces_;
    std::size_t given_ = 0;
    Status status_ = Status::ok; // declared last: its initialiser fills the other members
};

/// Deduces the scalar from the points.
template <PointRange R, FaceRange F>
TriangleMesh(const R&, const F&) -> TriangleMesh<range_scalar_t<R>>;

/// Calls f(face) with arrays of vertices.
template <Scalar T, class F>
void for_each_facet(const TriangleMesh<T>& mesh, F&& f) {
    for (const auto& face : mesh.faces()) f(face);
}

// ---- inside -------------------------------------------------------------------------------------

/// Returns the generalised winding number, which says how often the mesh encloses a point; it lies
/// between integers if the mesh has gaps (Jacobson, Kavan, Sorkine-Hornung, Robust inside-outside
/// segmentation using generalized winding numbers, SIGGRAPH 2013, sec. 4). O(#F).
template <Scalar T>
double winding_number(const TriangleMesh<T>& mesh, const Vec<T, 3>& p) noexcept {
    double sum = 0;
    for (const auto& face : mesh.faces())
        sum += detail::half_solid_angle(vec_cast<double>(p), detail::Facet<3>(face, mesh.vertices()).corner);
    return sum / (2 * std::numbers::pi);
}

/// The connected components of a closed mesh.
struct Shells {
    std::vector<std::uint32_t> of_face;    ///< the shell of every face
    std::vector<std::uint32_t> first_face; ///< of every shell
    /// Six times the volume of every shell; positive if counter-clockwise seen from outside.
    std::vector<double> volume;
    /// Whether a shell's faces must be flipped to be counter-clockwise seen from outside the cage.
    std::vector<bool> turned;
};

namespace detail {

/// Finds the connected components, numbers them by their first faces, and fills `of_face` and
/// `first_face`.
template <Scalar T>
Shells connected_faces(const TriangleMesh<T>& mesh) {
    std::vector<std::uint32_t> root(mesh.size());
    std::iota(root.begin(), root.end(), std::uint32_t{0});
    const auto find = [&](std::uint32_t i) {
        while (root[i] != i) i = root[i] = root[root[i]];
        return i;
    };
    for (const auto& face : mesh.faces()) root[find(face[1])] = root[find(face[2])] = find(face[0]);
    Shells shells;
    std::vector<std::uint32_t> number(mesh.size(), no_vertex);
    for (const auto& face : mesh.faces()) {
        auto& shell = number[find(face[0])];
        if (shell == no_vertex) {
            shell = std::uint32_t(shells.first_face.size());
            shells.first_face.push_back(std::uint32_t(shells.of_face.size()));
        }
        shells.of_face.push_back(shell);
    }
    return shells;
}

/// Counts the other shells that enclose a shell.
template <Scalar T>
std::size_t shell_depth(const TriangleMesh<T>& mesh, const Shells& shells, std::uint32_t shell) {
    if (shells.first_face.size() == 1) return 0;
    std::vector<double> turns(shells.first_face.size());
    const auto q = vec_cast<double>(mesh[mesh.faces()[shells.first_face[shell]][0]]);
    for (std::size_t f = 0; f < mesh.faces().size(); ++f) {
        const auto other = shells.of_face[f];
        if (other != shell)
            turns[other] += half_solid_angle(q, Facet<3>(mesh.faces()[f], mesh.vertices()).corner) /
                            (2 * std::numbers::pi);
    }
    return std::size_t(std::count_if(turns.begin(), turns.end(), is_enclosed));
}

/// Finds the shells of a mesh. O(#F) for one shell, O(#F · shells) for more.
template <Scalar T>
Shells shells_of(const TriangleMesh<T>& mesh) {
    Shells shells = detail::connected_faces(mesh);
    shells.volume.resize(shells.first_face.size());
    for (std::size_t f = 0; f < mesh.faces().size(); ++f) {
        const auto shell = shells.of_face[f];
        const auto origin = vec_cast<double>(mesh[mesh.faces()[shells.first_face[shell]][0]]);
        const auto [a, b, c] = detail::Facet<3>(mesh.faces()[f], mesh.vertices()).corner;
        shells.volume[shell] += dot(a - origin, cross(b - origin, c - origin));
    }
    for (std::uint32_t s = 0; s < shells.first_face.size(); ++s) {
        const bool is_cavity = detail::shell_depth(mesh, shells, s) % 2 == 1;
        shells.turned.push_back((shells.volume[s] > 0) == is_cavity);
    }
    return shells;
}

/// Returns the faces with those of wrongly oriented shells flipped, so that all are
/// counter-clockwise seen from outside the cage. Costs as much as `shells_of`.
template <Scalar T>
std::vector<typename TriangleMesh<T>::Face> outward_faces(const TriangleMesh<T>& mesh) {
    const auto shells = detail::shells_of(mesh);
    std::vector<typename TriangleMesh<T>::Face> faces(mesh.faces().begin(), mesh.faces().end());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if (shells.turned[shells.of_face[f]]) std::swap(faces[f][1], faces[f][2]);
    }
    return faces;
}

} // namespace detail

/// Finds the boundary point nearest to a finite point; returns the boundary data there, which is
/// linear on the faces, and stores the point in `place`. The mesh must be sound. O(#F).
template <Scalar T>
BoundaryValue<3> nearest_boundary_value(const TriangleMesh<T>& mesh, const Vec<T, 3>& p,
                                        Vec<T, 3>& place) noexcept {
    const auto q = vec_cast<double>(p);
    double least = std::numeric_limits<double>::infinity();
    BoundaryValue<3> value;
    for (const auto& face : mesh.faces()) {
        const detail::Facet<3> facet(face, mesh.vertices());
        const auto weight = detail::nearest_on_facet(q, facet.corner);
        const auto x = detail::place_on_facet(weight, facet.corner);
        if (dot(x - q, x - q) >= least) continue;
        least = dot(x - q, x - q);
        place = vec_cast<T>(x);
        value = value_on_facet(face, weight);
    }
    return value;
}

/// Classifies a point. It is inside if the winding number rounds to an odd integer, so a cavity
/// counts as outside in either orientation; it is on the boundary if it lies within `tolerance` of
/// a face. O(#F).
template <Scalar T>
PointState locate(const TriangleMesh<T>& mesh, const Vec<T, 3>& p, T tolerance) noexcept {
    if (!is_finite(p)) return PointState::not_finite;
    Vec<T, 3> place;
    (void)nearest_boundary_value(mesh, p, place);
    if (detail::length(vec_cast<double>(place) - vec_cast<double>(p)) <= double(tolerance))
        return PointState::on_boundary;
    return detail::is_enclosed(winding_number(mesh, p)) ? PointState::inside : PointState::outside;
}

// ---- check --------------------------------------------------------------------------------------

namespace detail {

/// The steps of `check` after the indices are known to be sound. Each step adds to the report.
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

    /// Checks that the edges opposite to a vertex form one loop. All edges must be manifold.
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

    /// Finds faces that pass through each other. Around a vertex of many faces (the apex of a fan),
    /// pairs are searched by direction from the apex.
    void check_crossing_faces() {
        const auto apex = apexes();
        FacetPairs<3>(facets_, apex, tolerance_)
            .for_each([&](std::size_t f, std::size_t g) { return cross_each_other(f, g); },
                      [&](std::size_t f, std::size_t g) { add_crossing(f, g); });
        std::vector<std::size_t> fans; // faces that have an apex, by apex
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
        const auto shells = detail::shells_of(mesh_);
        const double size = double(bounds_of(mesh_.vertices()).diagonal());
        for (std::size_t n = 0; n < shells.turned.size(); ++n) {
            const auto face = shells.first_face[n];
            if (std::fabs(shells.volume[n]) <= tolerance_ * size * size)
                report_.add(CageFaultKind::no_volume, face);
            if (shells.turned[n]) report_.add(CageFaultKind::shell_turns_otherwise, face);
        }
    }

private:
    bool is_given(std::size_t face) const noexcept { return face < mesh_.given_faces(); }
    /// Adds a fault of a face. If the face closes a gap, the gap cannot be closed; one of its edges
    /// is then reported as open.
    void add_at_face(CageFaultKind kind, std::size_t face, std::size_t a, std::size_t b = 0) {
        if (is_given(face)) return report_.add(kind, a, b);
        report_.add(CageFaultKind::open_edge, facets_[face].vertex[1], facets_[face].vertex[2]);
    }
    bool cross_each_other(std::size_t f, std::size_t g) const noexcept {
        return passes(facets_[f], facets_[g]) || passes(facets_[g], facets_[f]);
    }
    void add_crossing(std::size_t f, std::size_t g) { add_at_face(CageFaultKind::faces_cross, g, f, g); }
    /// Returns for every face its vertex with the most faces, if these are many; else no_apex.
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
    /// Reports faces around an apex that cross. Seen from the apex each face is an arc on the unit
    /// sphere. An arc's box is that of its ends, widened by the height of the arc.
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

/// Checks the numbers of vertices and faces, that indices are valid and vertices finite.
template <Scalar T>
void check_indices(const TriangleMesh<T>& mesh, CageReport& report) {
    if (mesh.size() < 4) report.add(CageFaultKind::too_few_vertices, 0, mesh.size());
    for (std::size_t i = 0; i < mesh.size(); ++i) {
        if (!is_finite(mesh[i])) report.add(CageFaultKind::vertex_not_finite, i);
    }
    const auto faces = mesh.faces();
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if (lacks_vertex(faces[f])) report.add(CageFaultKind::face_without_vertex, f);
    }
    if (faces.empty() && report.status == Status::ok) report.add(CageFaultKind::no_volume, 0);
}

} // namespace detail

/// Whether a mesh can serve as a cage. Indices must be in range and vertices finite; no two
/// vertices may coincide (within coincidence_tolerance), and faces must have an area. Every edge
/// must lie between two faces that run along it in opposite directions (including faces that close
/// a small gap). The faces around a vertex must form one fan, and no two faces may pass through
/// each other. Usually O(#F log #F), O(#F²) at worst.
template <Scalar T>
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
