// A cage with cells inside that carry handles of their own: points, edges, and in space faces.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A point (`i` = `j`), or in space an edge of a chain. It has a radius because without one it has no capacity, and no
/// harmonic function takes notice of its value. Places within the radius have the value of the bone's nearest place.
struct Bone {
    std::uint32_t i = 0, j = 0; ///< handles
    double radius = 0;          ///< in the units of the cage
};

/// Cells inside a cage, by their handles.
template <std::size_t D>
struct InteriorCells {
    std::vector<std::array<std::uint32_t, D>> facets; ///< edges of chains in the plane, faces in space
    std::vector<Bone> bones;                          ///< points, and chains in space

    bool empty() const noexcept { return facets.empty() && bones.empty(); }
};

/// A boundary and cells inside it (Joshi et al. 2007, sec. 4.1), for local control: a vertex in the head, a line of bones,
/// a wall between two legs. The functions are linear on the cells and only continuous across them. The handles are
/// the vertices of the boundary, then those of the cells in the order they were added.
///
///     CellComplex<double, 2> cage(Polygon<double>(outline));
///     const std::size_t head = cage.add_point(eye, 12.0);
///     cage.add_chain(spine);
///
/// About bones linear functions are missed, by at most the radius. `bind` restores them by default, for poses that turn
/// the whole cage; weights then leave [0, 1] by about the radius over the cage's size (LinearPrecision::leave keeps them).
///
/// A point that equals a vertex already there is that vertex: so cells meet, and a chain from boundary to boundary
/// parts the cage. Construction never fails; `check` tells whether the complex can serve as a cage. To add a point takes
/// O(#handles).
///
/// Next to the free rim of faces in space, and the end of a chain without ten grid cells of room about it, the functions rise
/// like the square root of the distance, which a grid misses by some tenths within a cell.
template <Scalar T, std::size_t D>
    requires(D == 2 || D == 3)
class CellComplex {
public:
    using scalar = T;
    using Boundary = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>;
    static constexpr std::size_t dimension = D;

    CellComplex() = default;
    explicit CellComplex(Boundary boundary)
        : boundary_(std::move(boundary))
        , vertices_(boundary_.vertices().begin(), boundary_.vertices().end()) {}

    /// An isolated vertex; everything within `radius` follows it. Returns its handle.
    template <Point P>
    std::size_t add_point(const P& point, T radius) {
        const auto i = vertex(to_vec<T>(point));
        cells_.bones.push_back({i, i, double(radius)});
        return i;
    }

    /// Edges from each of the points to the next, in the plane. Returns the handles of the points.
    template <PointRange R>
        requires(D == 2 && range_dimension<R> == 2)
    std::vector<std::size_t> add_chain(const R& points) {
        auto handles = vertices_of(points);
        for (std::size_t n = 0; n + 1 < handles.size(); ++n)
            cells_.facets.push_back({std::uint32_t(handles[n]), std::uint32_t(handles[n + 1])});
        return handles;
    }
    /// Edges in space; everything within `radius` of them follows them.
    template <PointRange R>
        requires(D == 3 && range_dimension<R> == 3)
    std::vector<std::size_t> add_chain(const R& points, T radius) {
        auto handles = vertices_of(points);
        if (handles.size() == 1) (void)add_point(vertices_[handles[0]], radius);
        for (std::size_t n = 0; n + 1 < handles.size(); ++n)
            cells_.bones.push_back(
                {std::uint32_t(handles[n]), std::uint32_t(handles[n + 1]), double(radius)});
        return handles;
    }
    /// Triangles in space: `faces[f][k]`, k = 0, 1, 2, is the place in `points` of a corner. Returns the handles of the
    /// points. Faces that name a point that there is not are remembered and reported by `check`.
    template <PointRange R, class Faces>
        requires(D == 3 && range_dimension<R> == 3)
    std::vector<std::size_t> add_faces(const R& points, const Faces& faces) {
        auto handles = vertices_of(points);
        for (std::size_t f = 0; f < std::size(faces); ++f) {
            std::array<std::uint32_t, D> facet;
            for (std::size_t k = 0; k < D; ++k) {
                const auto n = faces[f][k];
                const bool there = n >= 0 && std::uint64_t(n) < handles.size();
                facet[k] = there ? std::uint32_t(handles[std::size_t(n)]) : TriangleMesh<T>::no_vertex;
            }
            cells_.facets.push_back(facet);
        }
        return handles;
    }

    std::size_t size() const noexcept { return vertices_.size(); } ///< handles
    std::span<const Vec<T, D>> vertices() const noexcept { return vertices_; }
    const Vec<T, D>& operator[](std::size_t i) const noexcept { return vertices_[i]; }
    const Boundary& boundary() const noexcept { return boundary_; }
    const InteriorCells<D>& cells() const noexcept { return cells_; }

private:
    std::uint32_t vertex(const Vec<T, D>& p) {
        const auto known = std::find(vertices_.begin(), vertices_.end(), p);
        const auto i = std::uint32_t(known - vertices_.begin());
        if (known == vertices_.end()) vertices_.push_back(p);
        return i;
    }
    template <class R>
    std::vector<std::size_t> vertices_of(const R& points) {
        std::vector<std::size_t> handles;
        for (std::size_t n = 0; n < std::size(points); ++n) handles.push_back(vertex(to_vec<T>(points[n])));
        return handles;
    }

    Boundary boundary_;
    std::vector<Vec<T, D>> vertices_;
    InteriorCells<D> cells_;
};

template <Scalar T>
CellComplex(Polygon<T>) -> CellComplex<T, 2>;
template <Scalar T>
CellComplex(TriangleMesh<T>) -> CellComplex<T, 3>;

/// The boundary of any cage, and the cells inside it.
template <class Cage>
const Cage& boundary_of(const Cage& cage) noexcept {
    return cage; // NOLINT(bugprone-return-const-ref-from-parameter): no temporaries, see below
}
template <class Cage>
const Cage& boundary_of(const Cage&& cage) = delete; // of a temporary
template <Scalar T, std::size_t D>
const typename CellComplex<T, D>::Boundary& boundary_of(const CellComplex<T, D>& cage) noexcept {
    return cage.boundary();
}
template <class Cage>
InteriorCells<Cage::dimension> interior_cells(const Cage&) noexcept {
    return {};
}
template <Scalar T, std::size_t D>
const InteriorCells<D>& interior_cells(const CellComplex<T, D>& cage) noexcept {
    return cage.cells();
}

/// What coordinate types that know no interior cells report.
template <Scalar T, std::size_t D>
void refuse_interior_cells(const CellComplex<T, D>& cage, CageReport& report) {
    const std::size_t cells = cage.cells().facets.size() + cage.cells().bones.size();
    if (cells > 0 || cage.size() > cage.boundary().size())
        report.add(CageFaultKind::interior_cells_not_supported, cells);
}

namespace detail {

/// The place of a facet nearest to `p`, as weights of its vertices.
inline std::array<double, 2> nearest_on_facet(const Vec<double, 2>& p,
                                              const std::array<Vec<double, 2>, 2>& facet) noexcept {
    const double s = part_of_segment(p, facet[0], facet[1]);
    return {1 - s, s};
}
inline std::array<double, 3> nearest_on_facet(const Vec<double, 3>& p,
                                              const std::array<Vec<double, 3>, 3>& facet) noexcept {
    return nearest_on_triangle(p, facet[0], facet[1], facet[2]);
}

/// The place with these weights of a facet's vertices.
template <std::size_t D>
Vec<double, D> place_on_facet(const std::array<double, D>& weights,
                              const std::array<Vec<double, D>, D>& facet) noexcept {
    Vec<double, D> x{};
    for (std::size_t k = 0; k < D; ++k) x = x + weights[k] * facet[k];
    return x;
}

/// The distance of two segments, 0 where they cross in the plane.
template <std::size_t D>
double segment_distance(const Vec<double, D>& a, const Vec<double, D>& b, const Vec<double, D>& c,
                        const Vec<double, D>& d) noexcept {
    const auto to = [](const Vec<double, D>& p, const Vec<double, D>& s, const Vec<double, D>& t) {
        return length(p - nearest_on_segment(p, s, t));
    };
    double least = std::min({to(a, c, d), to(b, c, d), to(c, a, b), to(d, a, b)});
    // Nearer than at the ends only where the common perpendicular meets both.
    const auto e = b - a, f = d - c, g = a - c;
    const double ee = dot(e, e), ff = dot(f, f), ef = dot(e, f), determinant = ee * ff - ef * ef;
    if (determinant > 0) {
        const double s = (ef * dot(f, g) - ff * dot(e, g)) / determinant;
        const double t = (ee * dot(f, g) - ef * dot(e, g)) / determinant;
        if (s >= 0 && s <= 1 && t >= 0 && t <= 1) least = std::min(least, length(a + s * e - (c + t * f)));
    }
    return least;
}
/// The distance of a segment from a facet.
inline double distance_to_facet(const Vec<double, 2>& a, const Vec<double, 2>& b,
                                const std::array<Vec<double, 2>, 2>& facet) noexcept {
    return segment_distance(a, b, facet[0], facet[1]);
}
inline double distance_to_facet(const Vec<double, 3>& a, const Vec<double, 3>& b,
                                const std::array<Vec<double, 3>, 3>& facet) noexcept {
    if (pierces(a, b, facet[0], facet[1], facet[2])) return 0;
    double least = std::numeric_limits<double>::infinity();
    for (const auto& p : {a, b}) {
        least = std::min(least, length(p - place_on_facet(nearest_on_facet(p, facet), facet)));
    }
    for (std::size_t k = 0; k < 3; ++k)
        least = std::min(least, segment_distance(a, b, facet[k], facet[(k + 1) % 3]));
    return least;
}

/// f(facets of the boundary), as arrays of handles.
template <Scalar T, class F>
void for_each_facet(const Polygon<T>& polygon, F&& f) {
    polygon.for_each_edge([&](std::size_t i, std::size_t j) {
        f(std::array<std::uint32_t, 2>{std::uint32_t(i), std::uint32_t(j)});
    });
}
template <Scalar T, class F>
void for_each_facet(const TriangleMesh<T>& mesh, F&& f) {
    for (const auto& face : mesh.faces()) f(face);
}

template <Scalar T, std::size_t D>
std::array<Vec<double, D>, D> corners_of_facet(std::span<const Vec<T, D>> vertices,
                                               const std::array<std::uint32_t, D>& facet) noexcept {
    std::array<Vec<double, D>, D> corner;
    for (std::size_t k = 0; k < D; ++k) corner[k] = vec_cast<double>(vertices[facet[k]]);
    return corner;
}

/// Whether two facets meet elsewhere than in the vertices they share.
inline bool facets_touch(const std::array<std::uint32_t, 2>& a, const std::array<Vec<double, 2>, 2>& at_a,
                         const std::array<std::uint32_t, 2>& b, const std::array<Vec<double, 2>, 2>& at_b,
                         double tolerance) noexcept {
    for (std::size_t k = 0; k < 2; ++k) {
        for (std::size_t l = 0; l < 2; ++l) {
            if (a[k] != b[l]) continue;
            if (a[1 - k] == b[1 - l]) return true; // the same edge twice
            const auto u = at_a[1 - k] - at_a[k], v = at_b[1 - l] - at_b[l];
            return dot(u, v) > 0 &&
                   std::fabs(cross(u, v)) <= tolerance * std::sqrt(std::max(dot(u, u), dot(v, v)));
        }
    }
    return segments_touch(at_a[0], at_a[1], at_b[0], at_b[1], tolerance);
}
inline bool facets_touch(const std::array<std::uint32_t, 3>& a, const std::array<Vec<double, 3>, 3>& at_a,
                         const std::array<std::uint32_t, 3>& b, const std::array<Vec<double, 3>, 3>& at_b,
                         double tolerance) noexcept {
    const auto common = [](const std::array<std::uint32_t, 3>& of, std::uint32_t i) {
        return std::find(of.begin(), of.end(), i) != of.end();
    };
    std::size_t shared = 0;
    for (const auto i : a) shared += common(b, i);
    if (shared == 3) return true;
    // Edges without a shared end through or next to the other face; with one shared vertex that is all there can be.
    for (const bool turned : {false, true}) {
        const auto &f = turned ? b : a, &g = turned ? a : b;
        const auto &at_f = turned ? at_b : at_a, &at_g = turned ? at_a : at_b;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3;
            if (common(g, f[k]) || common(g, f[l])) continue;
            if (distance_to_facet(at_f[k], at_f[l], at_g) <= tolerance) return true;
        }
        // With a shared edge: folded flat onto each other?
        for (std::size_t k = 0; k < 3 && shared == 2; ++k) {
            if (common(g, f[k])) continue;
            if (length(at_f[k] - place_on_facet(nearest_on_facet(at_f[k], at_g), at_g)) <= tolerance)
                return true;
        }
    }
    return false;
}

} // namespace detail

/// A bone where it lies.
template <std::size_t D>
struct PlacedBone {
    std::uint32_t i, j;
    Vec<double, D> a, b;
    double radius;
};

/// What a bone says at a place: the value of its nearest place.
template <std::size_t D>
BoundaryValue<D> bone_value(const PlacedBone<D>& cell, const Vec<double, D>& p) noexcept {
    const double s = detail::part_of_segment(p, cell.a, cell.b);
    BoundaryValue<D> value;
    value.handle.fill(cell.i);
    value.handle[1] = cell.j;
    value.weight[0] = 1 - s;
    value.weight[1] = s;
    return value;
}

/// What cells cell(0) … cell(count − 1) say at a place whose distance from the surface of one is at most `least`, which becomes
/// the least such distance, negative within. Where several overlap, as bones do at joints, the mean of what they say, by how
/// deep the place lies in each, so that it is continuous. (Of more than three bones at a joint, that of the deepest three.)
template <std::size_t D, class Cells>
bool nearest_bone_value(std::size_t count, const Cells& cell, const Vec<double, D>& p, double& least,
                        BoundaryValue<D>& value) noexcept {
    constexpr std::size_t most = BoundaryValue<D>::most;
    std::array<std::size_t, 3> deepest{};
    std::array<double, 3> depth{-1, -1, -1};
    bool found = false;
    std::size_t nearest = 0;
    for (std::size_t n = 0; n < count; ++n) {
        const auto& one = cell(n);
        const double d = detail::length(detail::nearest_on_segment(p, one.a, one.b) - p) - one.radius;
        if (d <= least) {
            least = d;
            nearest = n;
            found = true;
        }
        std::size_t to = n;
        double inside = -d;
        for (std::size_t k = 0; k < depth.size(); ++k) {
            if (!(inside > 0) || inside <= depth[k]) continue;
            std::swap(inside, depth[k]);
            std::swap(to, deepest[k]);
        }
    }
    if (!found) return false;
    value = bone_value<D>(cell(nearest), p);
    if (!(depth[1] > 0)) return true;
    BoundaryValue<D> mean;
    mean.handle.fill(value.handle[0]);
    std::size_t used = 0;
    double sum = 0;
    for (std::size_t k = 0; k < 3 && depth[k] > 0; ++k) sum += depth[k];
    for (std::size_t k = 0; k < 3 && depth[k] > 0; ++k) {
        const auto one = bone_value<D>(cell(deepest[k]), p);
        for (std::size_t n = 0; n < 2; ++n) {
            if (one.weight[n] == 0) continue;
            const auto known =
                std::find(mean.handle.begin(), mean.handle.begin() + std::ptrdiff_t(used), one.handle[n]);
            const auto slot = std::size_t(known - mean.handle.begin());
            if (slot == most) return true; // cells that share no joint, which `check` refuses
            mean.handle[slot] = one.handle[n];
            mean.weight[slot] += depth[k] / sum * one.weight[n];
            used = std::max(used, slot + 1);
        }
    }
    value = mean;
    return true;
}

/// The boundary data at the place of boundary and cells nearest to a finite point, and that place: linear on facets, that of
/// the nearest place within the radius of a bone. Of a sound complex; O(facets and cells).
template <Scalar T, std::size_t D>
BoundaryValue<D> nearest_boundary_value(const CellComplex<T, D>& cage, const Vec<T, D>& p,
                                        Vec<T, D>& place) noexcept {
    auto value = nearest_boundary_value(cage.boundary(), p, place);
    const auto q = vec_cast<double>(p);
    double least = detail::length(vec_cast<double>(place) - q);
    for (const auto& facet : cage.cells().facets) {
        const auto corner = detail::corners_of_facet(cage.vertices(), facet);
        const auto w = detail::nearest_on_facet(q, corner);
        const auto x = detail::place_on_facet(w, corner);
        if (detail::length(x - q) >= least) continue;
        least = detail::length(x - q);
        place = vec_cast<T>(x);
        value = {};
        value.handle.fill(facet[0]);
        for (std::size_t k = 0; k < D; ++k) {
            value.handle[k] = facet[k];
            value.weight[k] = w[k];
        }
    }
    const auto& bones = cage.cells().bones;
    const auto cell = [&](std::size_t n) {
        return PlacedBone<D>{bones[n].i, bones[n].j, vec_cast<double>(cage[bones[n].i]),
                             vec_cast<double>(cage[bones[n].j]), bones[n].radius};
    };
    if (nearest_bone_value<D>(bones.size(), cell, q, least, value)) {
        Vec<double, D> x{};
        for (std::size_t n = 0; n < BoundaryValue<D>::most; ++n)
            x = x + value.weight[n] * vec_cast<double>(cage[value.handle[n]]);
        place = vec_cast<T>(x);
    }
    return value;
}

/// As for the boundary; places on a facet, or within the radius of a bone, are on_boundary.
template <Scalar T, std::size_t D>
PointState locate(const CellComplex<T, D>& cage, const Vec<T, D>& p, T tolerance) noexcept {
    const auto state = locate(cage.boundary(), p, tolerance);
    if (state != PointState::inside) return state;
    const auto q = vec_cast<double>(p);
    for (const auto& facet : cage.cells().facets) {
        const auto corner = detail::corners_of_facet(cage.vertices(), facet);
        const auto x = detail::place_on_facet(detail::nearest_on_facet(q, corner), corner);
        if (detail::length(x - q) <= double(tolerance)) return PointState::on_boundary;
    }
    for (const auto& cell : cage.cells().bones) {
        const auto a = vec_cast<double>(cage[cell.i]), b = vec_cast<double>(cage[cell.j]);
        if (detail::length(detail::nearest_on_segment(q, a, b) - q) <= cell.radius)
            return PointState::on_boundary;
    }
    return state;
}

/// Whether a complex can serve as a cage: its boundary can; its cells are not degenerate, lie inside, and meet the boundary
/// and each other in common vertices, edges and faces alone; bones have a radius, keep it from the boundary and
/// from facets, share vertices only with each other, and reach no other end of those. O(cells · (cells + facets of the
/// boundary)).
template <Scalar T, std::size_t D>
CageReport check(const CellComplex<T, D>& cage) {
    CageReport report = check(cage.boundary());
    if (report.status != Status::ok) return report;
    const std::size_t outer = cage.boundary().size();
    for (std::size_t i = outer; i < cage.size(); ++i) {
        if (!is_finite(cage[i])) report.add(CageFaultKind::vertex_not_finite, i);
    }
    const auto& [facets, bones] = cage.cells();
    for (std::size_t n = 0; n < facets.size(); ++n) {
        if (std::find(facets[n].begin(), facets[n].end(), TriangleMesh<T>::no_vertex) != facets[n].end())
            report.add(CageFaultKind::face_without_vertex, n);
    }
    for (const auto& cell : bones) {
        if (!(cell.radius > 0) || !std::isfinite(cell.radius))
            report.add(CageFaultKind::radius_not_positive, cell.i);
    }
    if (report.status != Status::ok) return report;
    // Vertices that cells use; those that nothing uses get a warning, as in a mesh.
    std::vector<bool> used(cage.size()), inner(cage.size());
    for (const auto& facet : facets) {
        for (const auto i : facet) used[i] = true;
    }
    for (const auto& cell : bones) used[cell.i] = used[cell.j] = true;
    std::erase_if(report.faults, [&](const CageFault& fault) {
        const bool by_cells = fault.kind == CageFaultKind::vertex_unused && used[fault.a];
        if (by_cells) inner[fault.a] = true;
        return by_cells;
    });
    for (std::size_t i = outer; i < cage.size(); ++i) {
        inner[i] = used[i];
        if (!used[i]) report.add(CageFaultKind::vertex_unused, i);
    }

    const T rounding = coincidence_tolerance(bounds_of(cage.vertices()));
    const double tolerance = double(rounding);
    const auto at = [&](std::size_t i) { return vec_cast<double>(cage[i]); };
    for (std::size_t i = 0; i < cage.size(); ++i) {
        if (!inner[i]) continue;
        for (std::size_t j = 0; j < i; ++j) {
            if (detail::length(at(i) - at(j)) <= tolerance)
                report.add(CageFaultKind::duplicate_vertices, j, i);
        }
        if (locate(cage.boundary(), cage[i], rounding) != PointState::inside)
            report.add(CageFaultKind::interior_cell_outside, i);
    }
    struct Facet {
        std::array<std::uint32_t, D> handles;
        std::array<Vec<double, D>, D> corner;
    };
    std::vector<Facet> all;
    for (const auto& facet : facets) all.push_back({facet, detail::corners_of_facet(cage.vertices(), facet)});
    for (std::size_t n = 0; n < facets.size(); ++n) {
        const auto& corner = all[n].corner;
        if constexpr (D == 2) {
            if (facets[n][0] == facets[n][1])
                report.add(CageFaultKind::duplicate_vertices, facets[n][0], facets[n][1]);
        } else {
            const auto u = corner[1] - corner[0], v = corner[2] - corner[0];
            const double longest =
                std::max({detail::length(u), detail::length(v), detail::length(corner[1] - corner[2])});
            if (detail::length(cross(u, v)) <= tolerance * longest)
                report.add(CageFaultKind::face_without_area, n);
        }
    }
    if (report.status != Status::ok) return report;
    for (const auto& facet : all) {
        Vec<double, D> middle{};
        for (const auto& c : facet.corner) middle = middle + (1.0 / double(D)) * c;
        if (locate(cage.boundary(), vec_cast<T>(middle), rounding) != PointState::inside)
            report.add(CageFaultKind::interior_cell_outside, facet.handles[0]);
    }
    detail::for_each_facet(cage.boundary(), [&](const std::array<std::uint32_t, D>& facet) {
        all.push_back({facet, detail::corners_of_facet(cage.vertices(), facet)});
    });
    for (std::size_t n = 0; n < facets.size(); ++n) {
        for (std::size_t m = n + 1; m < all.size(); ++m) {
            if (detail::facets_touch(all[n].handles, all[n].corner, all[m].handles, all[m].corner, tolerance))
                report.add(CageFaultKind::interior_cells_touch, all[n].handles[0], all[m].handles[0]);
        }
    }
    for (std::size_t n = 0; n < bones.size(); ++n) {
        const auto& cell = bones[n];
        for (const auto& facet : all) {
            if (detail::distance_to_facet(at(cell.i), at(cell.j), facet.corner) <= cell.radius + tolerance)
                report.add(CageFaultKind::interior_cells_touch, cell.i, facet.handles[0]);
        }
        for (std::size_t m = 0; m < n; ++m) {
            const auto& other = bones[m];
            const bool meet =
                cell.i == other.i || cell.i == other.j || cell.j == other.i || cell.j == other.j;
            // Of cells that meet, neither may swallow an end of the other.
            const auto swallows = [&](const Bone& a, const Bone& b) {
                const auto from = at(a.i), to = at(a.j);
                for (const auto end : {b.i, b.j}) {
                    if (end == a.i || end == a.j) continue;
                    const auto nearest = detail::nearest_on_segment(at(end), from, to);
                    if (detail::length(nearest - at(end)) <= a.radius + tolerance) return true;
                }
                return false;
            };
            if (meet && (swallows(cell, other) || swallows(other, cell)))
                report.add(CageFaultKind::interior_cells_touch, other.i, cell.i);
            if (!meet && detail::segment_distance(at(cell.i), at(cell.j), at(other.i), at(other.j)) <=
                             cell.radius + other.radius + tolerance)
                report.add(CageFaultKind::interior_cells_touch, other.i, cell.i);
        }
    }
    return report;
}

} // namespace cageform::inline CAGEFORM_ABI
