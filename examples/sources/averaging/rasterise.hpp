// Scan conversion of a cage onto a grid: finds the cells on the boundary, inside and outside.
#pragma once

#include "averaging/lattice.hpp"

#include <cageform/cage/polygon.hpp>
#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/grid/lattice/placed_facet.hpp>

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace cageform_sources::averaging {

using cageform::BoundaryPoint, cageform::BoundaryValue, cageform::PointState;
using cageform::Facet, cageform::nearest_on_facet, cageform::PlacedFacet;
using cageform::Polygon, cageform::TriangleMesh;
using cageform::value_on_facet, cageform::vec_cast;

/// The value of a handle's function in a boundary cell.
template <Scalar T>
struct CellData {
    std::uint32_t handle, cell;
    T value; ///< not 0
};

/// The domain of a boundary value problem on a grid, with its data. Independent of any solver.
template <Scalar T, std::size_t D>
struct GridDomain {
    Lattice<T, D> lattice;
    std::vector<CellTag> tags;        ///< #cells
    std::vector<CellData<T>> data;    ///< by handle, then by cell; in every boundary cell they sum to 1
    std::size_t unresolved_cells = 0; ///< cells that touch facets without a common vertex

    std::span<const CellData<T>> data_of(std::size_t handle) const noexcept {
        const auto before = [](const CellData<T>& a, std::size_t b) { return a.handle < b; };
        const auto begin = std::lower_bound(data.begin(), data.end(), handle, before);
        return {begin, std::lower_bound(begin, data.end(), handle + 1, before)};
    }
};

/// The tolerance of contact, in cells. A facet through a corner touches all cells that meet there.
inline constexpr double touch_slack = 1e-6;

/// Returns the number of a cell given by its indices; nothing if they lie beyond the lattice.
template <Scalar T, std::size_t D>
std::optional<std::uint32_t> cell_number(const Lattice<T, D>& lattice,
                                         const std::array<std::int32_t, D>& at) noexcept {
    const auto counts = lattice.counts();
    typename CellBox<D>::Index index{};
    for (std::size_t k = 0; k < D; ++k) {
        if (at[k] < 0 || at[k] >= counts[k]) return std::nullopt;
        index[k] = std::size_t(at[k]);
    }
    return std::uint32_t(lattice.number(index));
}

/// Sorts the data by handle and cell, and adds up values with the same handle and cell.
template <Scalar T>
void sort_data(std::vector<CellData<T>>& data) {
    using Data = CellData<T>;
    std::sort(data.begin(), data.end(), [](const Data& a, const Data& b) {
        return a.handle != b.handle ? a.handle < b.handle : a.cell < b.cell;
    });
    std::size_t count = 0;
    for (const Data& next : data) {
        if (count > 0 && data[count - 1].handle == next.handle && data[count - 1].cell == next.cell) {
            data[count - 1].value += next.value;
        } else {
            data[count++] = next;
        }
    }
    data.resize(count);
}

// ---- in the plane: the nearest edge -------------------------------------------------------------

/// The edges that pass through a cell. Edges that share vertices pairwise are two neighbours or the three
/// edges of a triangle. So a further edge is compared only with the first two.
struct EdgesOfCell {
    using Edge = std::array<std::uint32_t, 2>;

    std::array<Edge, 2> first{};
    std::size_t count = 0;
    bool crowded = false; ///< two of the edges have no common vertex

    void add(const Edge& edge) noexcept {
        for (std::size_t n = 0; n < count; ++n) {
            const auto& [i, j] = first[n];
            if (edge[0] != i && edge[0] != j && edge[1] != i && edge[1] != j) crowded = true;
        }
        if (count < first.size()) first[count++] = edge;
    }
};

/// The first step of `rasterise` in 2D: marks boundary cells. The data of a cell is taken at the
/// boundary point nearest to the cell's centre.
template <Scalar T>
void mark_boundary(const Polygon<T>& polygon, GridDomain<T, 2>& domain) {
    constexpr std::size_t none = ~std::size_t{0};
    const Lattice<T, 2>& lattice = domain.lattice;
    std::vector<std::size_t> slot(lattice.size(), none); // index of each boundary cell in `points`
    std::vector<std::uint32_t> cells;
    std::vector<BoundaryPoint<T>> points; // parallel to `cells`
    std::vector<EdgesOfCell> edges;       // parallel to `cells`
    std::vector<Vec<double, 2>> vertices;
    for (const auto& p : polygon.vertices()) vertices.push_back(vec_cast<double>(lattice.in_cells(p)));
    for_each_facet(polygon, [&](const EdgesOfCell::Edge& edge) {
        const PlacedFacet<2> placed(edge, vertices, true);
        for_each_cell(placed, touch_slack, [&](const std::array<std::int32_t, 2>& at) {
            const auto cell = cell_number(lattice, at);
            if (!cell) return;
            const auto point =
                cageform::nearest_on_edge(polygon, edge[0], edge[1], lattice.centre(lattice.index(*cell)));
            if (slot[*cell] == none) {
                slot[*cell] = points.size();
                domain.tags[*cell] = CellTag::boundary;
                cells.push_back(*cell);
                points.push_back(point);
                edges.emplace_back();
            }
            edges[slot[*cell]].add(edge);
            auto& nearest = points[slot[*cell]];
            if (point.distance < nearest.distance) nearest = point;
        });
    });
    for (std::size_t n = 0; n < cells.size(); ++n) {
        const auto& [i, j, s, distance, position] = points[n];
        if (s < T(1)) domain.data.push_back({std::uint32_t(i), cells[n], T(1) - s});
        if (s > T(0)) domain.data.push_back({std::uint32_t(j), cells[n], s});
    }
    domain.unresolved_cells = std::size_t(
        std::count_if(edges.begin(), edges.end(), [](const EdgesOfCell& cell) { return cell.crowded; }));
}

// ---- in space: the mean over the faces ----------------------------------------------------------

/// Whether a face and a cell are separated by one of the nine axes that are cross products of their
/// edges. Together with the cell's axes and the face's normal, which `for_each_cell` tests, these
/// are all possible separating axes (Akenine-Möller, Fast 3D triangle-box overlap testing, 2001).
inline bool apart_across_edges(const PlacedFacet<3>& face, const Vec<double, 3>& middle,
                               double half) noexcept {
    for (std::size_t k = 0; k < 3; ++k) {
        const auto along = face.corner[(k + 1) % 3] - face.corner[k];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            Vec<double, 3> of_cell{};
            of_cell[axis] = 1;
            const auto across = cross(of_cell, along);
            const auto [low, high] = std::minmax(
                {dot(across, face.corner[k] - middle), dot(across, face.corner[(k + 2) % 3] - middle)});
            const double reach = half * (std::fabs(across[0]) + std::fabs(across[1]) + std::fabs(across[2]));
            if (low > reach || high < -reach) return true;
        }
    }
    return false;
}

/// The faces of a mesh in lattice coordinates, numbered.
template <Scalar T>
class FacesInCells {
public:
    FacesInCells(const TriangleMesh<T>& mesh, const Lattice<T, 3>& lattice)
        : faces_(mesh.faces()) {
        for (const auto& p : mesh.vertices()) vertices_.push_back(vec_cast<double>(lattice.in_cells(p)));
    }

    /// Calls f(cell, face) for every cell that a face touches.
    template <class F>
    void for_each_touch(const F& f) const {
        for (std::uint32_t n = 0; n < faces_.size(); ++n) {
            const PlacedFacet<3> face(faces_[n], vertices_, true);
            for_each_cell(face, touch_slack, [&](const std::array<std::int32_t, 3>& at) {
                const auto middle = cageform::node_position<3>(at) + Vec<double, 3>{0.5, 0.5, 0.5};
                if (!apart_across_edges(face, middle, 0.5 + touch_slack)) f(at, n);
            });
        }
    }
    /// Returns the data at the point of face `n` nearest to `p`.
    BoundaryValue<3> nearest(std::uint32_t n, const Vec<double, 3>& p) const noexcept {
        const Facet<3> face(faces_[n], std::span<const Vec<double, 3>>(vertices_));
        return value_on_facet(face.vertex, nearest_on_facet(p, face.corner));
    }
    bool have_common_vertex(std::uint32_t m, std::uint32_t n) const noexcept {
        return std::find_first_of(faces_[m].begin(), faces_[m].end(), faces_[n].begin(), faces_[n].end()) !=
               faces_[m].end();
    }

private:
    std::span<const std::array<std::uint32_t, 3>> faces_;
    std::vector<Vec<double, 3>> vertices_;
};

/// The first step of `rasterise` in 3D: marks boundary cells. The data of a cell is the mean over
/// the faces that touch it, each taken at its point nearest to the cell's centre.
template <class C>
void mark_boundary(const C& cage, GridDomain<typename C::scalar, 3>& domain) {
    using T = typename C::scalar;
    struct Touch {
        std::uint32_t cell, face;
    };
    const FacesInCells<T> faces(cage, domain.lattice);
    std::vector<Touch> touches;
    faces.for_each_touch([&](const std::array<std::int32_t, 3>& at, std::uint32_t face) {
        if (const auto cell = cell_number(domain.lattice, at)) touches.push_back({*cell, face});
    });
    std::sort(touches.begin(), touches.end(), [](const Touch& a, const Touch& b) {
        return a.cell != b.cell ? a.cell < b.cell : a.face < b.face;
    });
    const auto are_crowded = [&](std::span<const Touch> here) {
        for (std::size_t m = 0; m < here.size(); ++m) {
            for (std::size_t n = m + 1; n < here.size(); ++n) {
                if (!faces.have_common_vertex(here[m].face, here[n].face)) return true;
            }
        }
        return false;
    };
    for (std::size_t begin = 0, end = 0; begin < touches.size(); begin = end) {
        const std::uint32_t cell = touches[begin].cell;
        while (end < touches.size() && touches[end].cell == cell) ++end;
        const auto index = domain.lattice.index(cell);
        const Vec<double, 3> middle{double(index[0]) + 0.5, double(index[1]) + 0.5, double(index[2]) + 0.5};
        for (std::size_t n = begin; n < end; ++n) {
            const auto value = faces.nearest(touches[n].face, middle);
            for (std::size_t k = 0; k < value.most; ++k) {
                if (value.weight[k] > 0)
                    domain.data.push_back({value.handle[k], cell, T(value.weight[k] / double(end - begin))});
            }
        }
        domain.tags[cell] = CellTag::boundary;
        domain.unresolved_cells += are_crowded({touches.data() + begin, end - begin}) ? 1 : 0;
    }
}

// ---- in the plane and in space ------------------------------------------------------------------

/// Tags a cell and all untyped cells connected with it along the axes.
template <Scalar T, std::size_t D>
void flood(GridDomain<T, D>& domain, std::size_t seed, CellTag tag) {
    const Lattice<T, D>& lattice = domain.lattice;
    std::vector<std::size_t> front{seed};
    domain.tags[seed] = tag;
    while (!front.empty()) {
        const std::size_t cell = front.back();
        front.pop_back();
        const auto index = lattice.index(cell);
        for (std::size_t axis = 0; axis < D; ++axis) {
            for (const bool up : {false, true}) {
                if (up ? index[axis] + 1 == lattice.cells[axis] : index[axis] == 0) continue;
                const std::size_t next = up ? cell + lattice.stride(axis) : cell - lattice.stride(axis);
                if (domain.tags[next] != CellTag::untyped) continue;
                domain.tags[next] = tag;
                front.push_back(next);
            }
        }
    }
}

/// Tags every cell that a facet (an edge, a triangle, a side of a box) touches as boundary. One inside test
/// tags each connected component of the rest as interior or exterior. In 2D a boundary cell has the data of
/// the nearest edge. In 3D it has the mean over the faces that touch it, each taken at its point nearest to
/// the cell's centre.
///
/// The boundary is watertight, because a facet marks all cells that it touches, even in a corner. No path
/// between neighbouring cells, including diagonal ones, leads from the interior to the exterior. Whether a
/// triangle touches a cell is decided by all thirteen separating axes. Cost O(#cells + #components · #facets
/// + cells in the facets' boxes). These are steps 1 and 2 of Joshi et al. 2007, sec. 4, who flood only the
/// exterior, from a corner. Testing every component also handles holes and several outer loops or shells.
template <class C>
GridDomain<typename C::scalar, C::dimension>
rasterise(const C& cage, const Lattice<typename C::scalar, C::dimension>& lattice) {
    CAGEFORM_ASSERT(lattice.size() <= (std::numeric_limits<std::uint32_t>::max)(),
                    "cells have 32-bit numbers");
    GridDomain<typename C::scalar, C::dimension> domain;
    domain.lattice = lattice;
    domain.tags.assign(lattice.size(), CellTag::untyped);
    mark_boundary(cage, domain);
    sort_data(domain.data);
    for (std::size_t seed = 0; seed < domain.tags.size(); ++seed) {
        if (domain.tags[seed] != CellTag::untyped) continue;
        const auto centre = lattice.centre(lattice.index(seed));
        const bool inside = locate(cage, centre, typename C::scalar(0)) == PointState::inside;
        flood(domain, seed, inside ? CellTag::interior : CellTag::exterior);
    }
    return domain;
}

} // namespace cageform_sources::averaging
