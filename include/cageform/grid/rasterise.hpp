// Scan conversion of a cage onto a grid: which cells the boundary passes, and which are inside.
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/grid/lattice.hpp>

#include <algorithm>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The domain of a boundary value problem on a grid and where its data comes from. Knows no solver.
template <Scalar T, std::size_t D>
struct GridDomain {
    Lattice<T, D> lattice;
    std::vector<CellTag> tags;               ///< #cells
    std::vector<std::size_t> boundary_cells; ///< numbers of the boundary cells
    std::vector<BoundaryPoint<T>> places;    ///< for each of them: the cage point its data is taken at
    std::size_t crowded_cells = 0;           ///< boundary cells that hold edges without a common vertex
};

/// Tags every cell that an edge passes as boundary (its data: that of the nearest edge at the place nearest
/// to the cell's centre), and the connected rest as interior or exterior, each part by one inside test.
///
/// Watertight: an edge marks all cells it touches, those met in a corner included, so no walk from cell to
/// neighbouring cell, diagonals included, gets from the interior to the exterior.
/// Cost O(#cells + #parts · #V + cells passed). Joshi et al. 2007, sec. 4, steps 1 and 2, which flood only
/// the exterior, from a corner; deciding every part by itself serves holes and several outer loops too.
template <Scalar T>
GridDomain<T, 2> rasterise(const Polygon<T>& polygon, const Lattice<T, 2>& lattice) {
    GridDomain<T, 2> domain;
    domain.lattice = lattice;
    domain.tags.assign(lattice.size(), CellTag::untyped);
    constexpr std::size_t none = ~std::size_t{0};
    std::vector<std::size_t> slot(lattice.size(), none); // of a boundary cell in `places`
    // Edges of a cell that meet each other pairwise are two neighbours, or all three of a triangle: a further
    // edge has to meet the first two only.
    using Edge = std::array<std::size_t, 2>;
    struct Held {
        std::array<Edge, 2> edges;
        std::size_t count = 1;
        bool crowded = false;
    };
    std::vector<Held> held;

    const auto visit = [&](std::size_t x, std::size_t y, std::size_t i, std::size_t j) {
        const std::size_t cell = lattice.number({x, y});
        const auto place = nearest_on_edge(polygon, i, j, lattice.centre({x, y}));
        if (slot[cell] == none) {
            slot[cell] = domain.places.size();
            domain.tags[cell] = CellTag::boundary;
            domain.boundary_cells.push_back(cell);
            domain.places.push_back(place);
            held.push_back({.edges = {Edge{i, j}}});
            return;
        }
        auto& cell_edges = held[slot[cell]];
        for (std::size_t n = 0; n < cell_edges.count; ++n) {
            const auto [k, l] = cell_edges.edges[n];
            if (k != i && k != j && l != i && l != j) cell_edges.crowded = true;
        }
        if (cell_edges.count < 2) cell_edges.edges[cell_edges.count++] = {i, j};
        auto& nearest = domain.places[slot[cell]];
        if (place.distance < nearest.distance) nearest = place;
    };
    // An edge is cut into the columns of cells it passes; in each it covers a range of rows. The slack makes
    // an edge through a corner touch all four cells.
    constexpr double slack = 1e-6;
    const auto to_cell = [](double x, std::size_t cells) {
        return static_cast<std::size_t>(std::clamp(std::floor(x), 0.0, double(cells) - 1));
    };
    polygon.for_each_edge([&](std::size_t i, std::size_t j) {
        auto a = vec_cast<double>(lattice.in_cells(polygon[i]));
        auto b = vec_cast<double>(lattice.in_cells(polygon[j]));
        if (a[0] > b[0]) std::swap(a, b);
        const std::size_t first = to_cell(a[0] - slack, lattice.cells[0]);
        const std::size_t last = to_cell(b[0] + slack, lattice.cells[0]);
        const double width = b[0] - a[0];
        for (std::size_t x = first; x <= last; ++x) {
            const auto height_at = [&](double at) {
                const double s = width > 0 ? std::clamp((at - a[0]) / width, 0.0, 1.0) : 0.0;
                return a[1] + s * (b[1] - a[1]);
            };
            double low = height_at(double(x) - slack);
            double high = width > slack ? height_at(double(x) + 1 + slack) : b[1];
            if (width <= slack) low = a[1];
            if (low > high) std::swap(low, high);
            const std::size_t top = to_cell(high + slack, lattice.cells[1]);
            for (std::size_t y = to_cell(low - slack, lattice.cells[1]); y <= top; ++y) visit(x, y, i, j);
        }
    });
    domain.crowded_cells = static_cast<std::size_t>(
        std::count_if(held.begin(), held.end(), [](const Held& cell) { return cell.crowded; }));

    std::vector<std::size_t> front;
    for (std::size_t seed = 0; seed < domain.tags.size(); ++seed) {
        if (domain.tags[seed] != CellTag::untyped) continue;
        const bool inside = locate(polygon, lattice.centre(lattice.index(seed)), T(0)) == PointState::inside;
        const CellTag tag = inside ? CellTag::interior : CellTag::exterior;
        domain.tags[seed] = tag;
        front.push_back(seed);
        while (!front.empty()) {
            const std::size_t cell = front.back();
            front.pop_back();
            const auto index = lattice.index(cell);
            for (std::size_t axis = 0; axis < 2; ++axis) {
                const std::size_t stride = lattice.stride(axis);
                for (const bool up : {false, true}) {
                    if (up ? index[axis] + 1 == lattice.cells[axis] : index[axis] == 0) continue;
                    const std::size_t next = up ? cell + stride : cell - stride;
                    if (domain.tags[next] != CellTag::untyped) continue;
                    domain.tags[next] = tag;
                    front.push_back(next);
                }
            }
        }
    }
    return domain;
}

} // namespace cageform::inline CAGEFORM_ABI
