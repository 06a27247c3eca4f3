// A cage with interior cells that have their own handles: points, edges and, in 3D, faces.
#pragma once

#include <cageform/cage/detail/bones.hpp>
#include <cageform/cage/polygon.hpp>
#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/cage/types/interior_cells.hpp>
#include <cageform/core/types/buffer.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A boundary with interior cells for local control (Joshi et al. 2007, sec. 4.1): a vertex in the head, a
/// line of bones, a wall between two legs. The coordinate functions are linear on the cells and continuous,
/// but not smooth, across them. The first handles are the vertices of the boundary. The vertices of the cells
/// follow in the order in which they were added.
///
///     CellComplex<double, 2> cage(Polygon<double>(outline));
///     const std::size_t head = cage.add_point(eye, 12.0);
///     cage.add_chain(spine);
///
/// Near bones, linear functions are reproduced with an error of at most the radius. By default `bind`
/// corrects this error for poses that rotate the whole cage. Corrected weights may leave [0, 1] by about the
/// radius divided by the cage's size (LinearPrecision::leave disables the correction).
///
/// A point equal to an existing vertex reuses that vertex. Cells that share a vertex are joined there. A
/// chain from boundary to boundary divides the cage. Construction never fails; `check` reports whether the
/// complex is a valid cage. Adding a point takes O(#handles).
///
/// In 3D, near the free rim of faces, the functions grow like the square root of the distance from the rim.
/// The same holds near the end of a chain if the free space around this end is less than a grid cell. Within
/// one grid cell of such a rim or end, the weights have errors of some tenths.
template <Scalar T, std::size_t D>
    requires(D == 2 || D == 3)
class CellComplex {
public:
    using scalar = T;
    using Boundary = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>;
    static constexpr std::size_t dimension = D;

    CellComplex() = default;
    explicit CellComplex(Boundary boundary)
        : boundary_(std::move(boundary)) {
        keep([&] { vertices_.assign(boundary_.vertices().begin(), boundary_.vertices().end()); });
    }

    /// Makes a complex of known cells. `vertices` begins with those of the boundary.
    CellComplex(Boundary boundary, const PointRange auto& vertices, InteriorCells<D> cells)
        : boundary_(std::move(boundary))
        , cells_(std::move(cells)) {
        keep([&] {
            for (const auto& vertex : vertices) vertices_.push_back(to_vec<T>(vertex));
        });
    }

    /// Adds an isolated vertex that moves all points within `radius`, in units of the cage. Returns its
    /// handle.
    template <Point P>
    std::size_t add_point(const P& point, T radius) {
        std::uint32_t i = no_vertex;
        keep([&] {
            i = vertex(to_vec<T>(point));
            cells_.bones.push_back({i, i, double(radius)});
        });
        return i;
    }

    /// Adds edges in 2D, from each point to the next. Returns the handles of the points.
    template <PointRange R>
        requires(D == 2 && range_dimension<R> == 2)
    std::vector<std::size_t> add_chain(const R& points) {
        std::vector<std::size_t> handles;
        keep([&] {
            handles = vertices_of(points);
            for (std::size_t n = 0; n + 1 < handles.size(); ++n)
                cells_.facets.push_back({std::uint32_t(handles[n]), std::uint32_t(handles[n + 1])});
        });
        return handles;
    }
    /// Adds edges in 3D that move all points within `radius`. Returns the handles of the points.
    template <PointRange R>
        requires(D == 3 && range_dimension<R> == 3)
    std::vector<std::size_t> add_chain(const R& points, T radius) {
        std::vector<std::size_t> handles;
        keep([&] {
            handles = vertices_of(points);
            if (handles.size() == 1) (void)add_point(vertices_[handles[0]], radius);
            for (std::size_t n = 0; n + 1 < handles.size(); ++n)
                cells_.bones.push_back(
                    {std::uint32_t(handles[n]), std::uint32_t(handles[n + 1]), double(radius)});
        });
        return handles;
    }
    /// Adds triangles in 3D: `faces[f][k]`, k = 0, 1, 2, is the index in `points` of a corner. Returns the
    /// handles of the points. Indices out of range are kept, and `check` reports them.
    template <PointRange R, FaceRange F>
        requires(D == 3 && range_dimension<R> == 3)
    std::vector<std::size_t> add_faces(const R& points, const F& faces) {
        std::vector<std::size_t> handles;
        keep([&] {
            handles = vertices_of(points);
            for (std::size_t f = 0; f < std::size(faces); ++f) {
                const auto face = detail::checked_face(faces[f], handles.size());
                auto& facet = cells_.facets.emplace_back();
                for (std::size_t k = 0; k < 3; ++k)
                    facet[k] = face[k] == no_vertex ? no_vertex : std::uint32_t(handles[face[k]]);
            }
        });
        return handles;
    }

    /// Returns ok, or out_of_memory if an addition did not fit in memory. Do not use the complex then;
    /// `check` reports this status. Copying may throw.
    Status status() const noexcept { return status_; }
    std::size_t size() const noexcept { return vertices_.size(); } ///< number of handles
    std::span<const Vec<T, D>> vertices() const noexcept { return vertices_; }
    const Vec<T, D>& operator[](std::size_t i) const noexcept { return vertices_[i]; }
    const Boundary& boundary() const noexcept { return boundary_; }
    const InteriorCells<D>& cells() const noexcept { return cells_; }

private:
    /// Runs add() and stores out_of_memory on failure.
    template <class Add>
    void keep(const Add& add) {
        const Status status = detail::guard_memory([&] { add(); });
        if (status_ == Status::ok) status_ = status;
    }
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
    Status status_ = Status::ok;
};

template <Scalar T>
CellComplex(Polygon<T>) -> CellComplex<T, 2>;
template <Scalar T>
CellComplex(TriangleMesh<T>) -> CellComplex<T, 3>;

/// boundary_of and interior_cells return the boundary and the interior cells of any cage.
template <class Cage>
const Cage& boundary_of(const Cage& cage) noexcept {
    return cage; // NOLINT(bugprone-return-const-ref-from-parameter): no temporaries, see below
}
template <class Cage>
const Cage& boundary_of(const Cage&& cage) = delete; // refuses temporaries
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

// ---- inside -------------------------------------------------------------------------------------

/// Returns the boundary data at the point of the boundary or of a cell that is nearest to `p`, and stores
/// that point in `position`. The data is linear on facets; within the radius of a bone it is the data of the
/// bone's nearest point. `p` must be finite and the complex valid. O(facets + bones).
template <Scalar T, std::size_t D>
BoundaryValue<D> nearest_boundary_value(const CellComplex<T, D>& cage, const Vec<T, D>& p,
                                        Vec<T, D>& position) noexcept {
    auto value = nearest_boundary_value(cage.boundary(), p, position);
    const auto q = vec_cast<double>(p);
    double least = detail::length(vec_cast<double>(position) - q);
    for (const auto& vertices : cage.cells().facets) {
        const Facet<D> facet(vertices, cage.vertices());
        const auto weight = nearest_on_facet(q, facet.corner);
        const auto x = detail::point_on_facet(weight, facet.corner);
        if (detail::length(x - q) >= least) continue;
        least = detail::length(x - q);
        position = vec_cast<T>(x);
        value = value_on_facet(vertices, weight);
    }
    const auto& bones = cage.cells().bones;
    const auto bone = [&](std::size_t n) { return detail::placed_bone(cage, bones[n]); };
    if (const auto hit = detail::nearest_bone<D>(bones.size(), bone, q, least)) {
        value = hit->value;
        Vec<double, D> x{};
        for (std::size_t n = 0; n < BoundaryValue<D>::most; ++n)
            x = x + value.weight[n] * vec_cast<double>(cage[value.handle[n]]);
        position = vec_cast<T>(x);
    }
    return value;
}

/// Classifies a point by the boundary. Points on a facet of a cell, or within the radius of a bone, are
/// on_boundary too.
template <Scalar T, std::size_t D>
PointState locate(const CellComplex<T, D>& cage, const Vec<T, D>& p, T tolerance) noexcept {
    const auto state = locate(cage.boundary(), p, tolerance);
    if (state != PointState::inside) return state;
    const auto q = vec_cast<double>(p);
    const auto& [facets, bones] = cage.cells();
    const auto on_facet = [&](const auto& vertices) {
        return detail::distance_to_facet(q, Facet<D>(vertices, cage.vertices()).corner) <= double(tolerance);
    };
    const auto in_bone = [&](const Bone& bone) { return detail::placed_bone(cage, bone).distance(q) <= 0; };
    const bool on_cell = std::any_of(facets.begin(), facets.end(), on_facet) ||
                         std::any_of(bones.begin(), bones.end(), in_bone);
    return on_cell ? PointState::on_boundary : state;
}

// ---- check --------------------------------------------------------------------------------------

/// Checks whether a complex is a valid cage. The boundary must be valid. Cells must not be degenerate and
/// must lie inside. They may meet the boundary and each other only in common vertices, edges and faces. Bones
/// must have a positive radius, and their distance from the boundary and from facets must be larger than this
/// radius. They may share vertices only with other bones. If two bones share a vertex, neither may contain
/// the other end of the other bone. O(cells · (cells + facets of the boundary)).
template <class T, std::size_t D>
CageReport check(const CellComplex<T, D>& cage);

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/cage/detail/check_cells.impl.hpp>
#endif
