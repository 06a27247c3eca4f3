// Scan conversion of a cage onto a grid: which cells the boundary passes, and which are inside.
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/grid/detail/placed_facet.hpp>
#include <cageform/grid/pyramid/papers_lattice.hpp>

#include <algorithm>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// The domain of a boundary value problem on a grid and where its data comes from. Knows no solver.
template <Scalar T, std::size_t D>
struct GridDomain {
    Lattice<T, D> lattice;
    std::vector<CellTag> tags;               ///< #cells
    std::vector<std::size_t> boundary_cells; ///< their numbers
    std::vector<BoundaryPoint<T>> places;    ///< parallel to them: where the cage gives their data
    std::size_t crowded_cells = 0;           ///< those that hold edges without a common vertex
};

} // namespace grid

namespace detail {

/// The edges that pass a cell. Edges that meet pairwise are two neighbours, or all three of a
/// triangle: so a further edge has to meet the first two only.
struct EdgesOfCell {
    using Edge = std::array<std::uint32_t, 2>;

    std::array<Edge, 2> first{};
    std::size_t count = 0;
    bool crowded = false; ///< two of them have no common vertex

    void add(const Edge& edge) noexcept {
        for (std::size_t n = 0; n < count; ++n) {
            const auto& [i, j] = first[n];
            if (edge[0] != i && edge[0] != j && edge[1] != i && edge[1] != j) crowded = true;
        }
        if (count < first.size()) first[count++] = edge;
    }
};

/// The first step of `rasterise`: boundary cells and their data.
template <Scalar T>
void mark_boundary(const Polygon<T>& polygon, grid::GridDomain<T, 2>& domain) {
    constexpr double slack = 1e-6; // cells: an edge through a corner touches all four cells there
    constexpr std::size_t none = ~std::size_t{0};
    const Lattice<T, 2>& lattice = domain.lattice;
    const auto counts = lattice.counts();
    std::vector<std::size_t> slot(lattice.size(), none); // of a boundary cell in `places`
    std::vector<EdgesOfCell> edges;                      // parallel to `places`
    std::vector<Vec<double, 2>> vertices;
    for (const auto& p : polygon.vertices()) vertices.push_back(vec_cast<double>(lattice.in_cells(p)));
    for_each_facet(polygon, [&](const EdgesOfCell::Edge& edge) {
        const PlacedFacet<2> placed(edge, vertices, true);
        for_each_cell(placed, slack, [&](const std::array<std::int32_t, 2>& at) {
            if (at[0] < 0 || at[1] < 0 || at[0] >= counts[0] || at[1] >= counts[1]) return;
            const typename CellBox<2>::Index index{std::size_t(at[0]), std::size_t(at[1])};
            const std::size_t cell = lattice.number(index);
            const auto place = nearest_on_edge(polygon, edge[0], edge[1], lattice.centre(index));
            if (slot[cell] == none) {
                slot[cell] = domain.places.size();
                domain.tags[cell] = grid::CellTag::boundary;
                domain.boundary_cells.push_back(cell);
                domain.places.push_back(place);
                edges.emplace_back();
            }
            edges[slot[cell]].add(edge);
            auto& nearest = domain.places[slot[cell]];
            if (place.distance < nearest.distance) nearest = place;
        });
    });
    domain.crowded_cells = std::size_t(
        std::count_if(edges.begin(), edges.end(), [](const EdgesOfCell& cell) { return cell.crowded; }));
}

/// Tags the untyped cells that are connected with one of them along the axes.
template <Scalar T, std::size_t D>
void flood(grid::GridDomain<T, D>& domain, std::size_t seed, grid::CellTag tag) {
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
                if (domain.tags[next] != grid::CellTag::untyped) continue;
                domain.tags[next] = tag;
                front.push_back(next);
            }
        }
    }
}

} // namespace detail
namespace grid {

/// Tags every cell that an edge passes as boundary (its data: that of the nearest edge at the place
/// nearest to the cell's centre), and the connected rest as interior or exterior, each part by one
/// inside test.
///
/// Watertight: an edge marks all cells it touches, those met in a corner included, so no path from
/// cell to neighbouring cell, diagonals included, gets from the interior to the exterior. Cost
/// O(#cells + #parts · #V + cells passed). Joshi et al. 2007, sec. 4, steps 1 and 2, which flood
/// only the exterior, from a corner; deciding every part by itself serves holes and several outer
/// loops too.
template <Scalar T>
GridDomain<T, 2> rasterise(const Polygon<T>& polygon, const Lattice<T, 2>& lattice) {
    GridDomain<T, 2> domain;
    domain.lattice = lattice;
    domain.tags.assign(lattice.size(), CellTag::untyped);
    detail::mark_boundary(polygon, domain);
    for (std::size_t seed = 0; seed < domain.tags.size(); ++seed) {
        if (domain.tags[seed] != CellTag::untyped) continue;
        const auto centre = lattice.centre(lattice.index(seed));
        const bool inside = locate(polygon, centre, T(0)) == PointState::inside;
        detail::flood(domain, seed, inside ? CellTag::interior : CellTag::exterior);
    }
    return domain;
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
