// A polygon, and cells inside it, as the boundary of a problem on a lattice: crossings with the lattice lines, and values
// between the nodes that are right up to it.
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/grid/bones.hpp>
#include <cageform/grid/cut_stencil.hpp>
#include <cageform/grid/embed.hpp>
#include <cageform/grid/lattice.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A polygon in units of a lattice. Node i of the lattice lies at i.
template <Scalar T>
class PolygonBoundary {
public:
    using Index = NodeRuns<2>::Index;
    static constexpr std::size_t dimension = 2;

    /// Of a Polygon or a CellComplex. `lattice.cells` are the nodes along each axis, the first at `origin`.
    template <class Cage>
    PolygonBoundary(const Cage& whole, const Lattice<double, 2>& lattice)
        : lattice_(lattice)
        , bones_(interior_cells(whole).bones, lattice.in_cells(whole.vertices()), lattice) {
        const auto vertices = lattice.in_cells(whole.vertices());
        const auto add = [&](std::size_t i, std::size_t j, bool turns) {
            edges_.push_back({std::uint32_t(i), std::uint32_t(j), vertices[i], vertices[j], turns});
        };
        boundary_of(whole).for_each_edge([&](std::size_t i, std::size_t j) { add(i, j, true); });
        const auto& cells = interior_cells(whole);
        for (const auto& facet : cells.facets) add(facet[0], facet[1], false);
    }

    const Lattice<double, 2>& lattice() const noexcept { return lattice_; }
    /// O(edges + lattice lines they cross, and the logarithm of that).
    Crossings<2> crossings() const {
        Crossings<2> all;
        for (std::size_t axis = 0; axis < 2; ++axis) {
            for (const Edge& edge : edges_) add_crossings(all[axis], edge, axis);
        }
        bones_.add_crossings(all);
        for (auto& along : all) sort_along_lines<2>(along);
        return all;
    }
    std::vector<FixedNode<2>> fixed_nodes() const { return bones_.nodes(); } ///< within interior cells
    std::optional<std::uint32_t> too_thin_bone() const noexcept { return bones_.too_thin(); }

    BoundaryValue<2> nearest(const Index& node) const noexcept {
        const Vec<double, 2> p{double(node[0]), double(node[1])};
        double least = std::numeric_limits<double>::max();
        BoundaryValue<2> value;
        for (const Edge& edge : edges_) {
            const double s = detail::part_of_segment(p, edge.a, edge.b);
            const auto d = edge.a + s * (edge.b - edge.a) - p;
            if (dot(d, d) >= least) continue;
            least = dot(d, d);
            value = edge.at(s);
        }
        double distance = std::sqrt(least);
        (void)bones_.nearest(p, distance, value);
        return value;
    }

    /// How far a point can go along an axis, up or down, before it meets the boundary, but no farther than `limit`. O(edges).
    double free_distance(const Vec<double, 2>& p, std::size_t axis, bool up, double limit) const noexcept {
        const std::size_t across = 1 - axis;
        for (const Edge& edge : edges_) {
            const double from = edge.a[across], to = edge.b[across];
            if (p[across] < std::min(from, to) || p[across] > std::max(from, to)) continue;
            const auto meet = [&](double s) {
                const double way =
                    (edge.a[axis] + s * (edge.b[axis] - edge.a[axis]) - p[axis]) * (up ? 1 : -1);
                if (way >= 0) limit = std::min(limit, way);
            };
            if (from != to) {
                meet((p[across] - from) / (to - from));
            } else {
                meet(0);
                meet(1);
            }
        }
        double position = 0;
        BoundaryValue<2> value;
        for (std::size_t n = 0; n < bones_.size(); ++n)
            (void)bones_.meet(n, p, axis, up ? 1.0 : -1.0, limit, position, value);
        return limit;
    }

    /// Prepares `sample` and `is_cut`: which edges (and, numbered after them, bones) pass which cell, or come as near
    /// as `slack`.
    void index_cells(double slack) {
        passes_.clear();
        for (std::uint32_t n = 0; n < edges_.size(); ++n) {
            const Edge& edge = edges_[n];
            const double left = std::min(edge.a[0], edge.b[0]), right = std::max(edge.a[0], edge.b[0]);
            for (double x = std::floor(left - slack); x <= std::floor(right + slack); ++x) {
                const double y0 = edge.height(std::clamp(x - slack, left, right));
                const double y1 = edge.height(std::clamp(x + 1 + slack, left, right));
                double low = std::min(y0, y1), high = std::max(y0, y1);
                if (right - left <= 2 * slack) {
                    low = std::min(edge.a[1], edge.b[1]);
                    high = std::max(edge.a[1], edge.b[1]);
                }
                for (double y = std::floor(low - slack); y <= std::floor(high + slack); ++y)
                    passes_.push_back({cell(std::int32_t(x), std::int32_t(y)), n});
            }
        }
        for (std::uint32_t n = 0; n < bones_.size(); ++n) {
            bones_.for_each_cell_about(n, [&](const Index& low) {
                passes_.push_back({cell(low[0], low[1]), std::uint32_t(edges_.size()) + n});
            });
        }
        std::sort(passes_.begin(), passes_.end());
    }

    /// Whether a part of the boundary passes a cell, by its lower corner.
    bool is_cut(const Index& low) const noexcept {
        const std::pair key(cell(low[0], low[1]), std::uint32_t{0});
        const auto first = std::lower_bound(passes_.begin(), passes_.end(), key);
        return first != passes_.end() && first->first == key.first;
    }

    /// The stencil of a point strictly inside: bilinear, where the boundary passes between the point and a node the
    /// boundary's value at that place in its stead. Exact for linear functions everywhere; a mean, so never beyond
    /// the values it is made of. Where the boundary passes the cell, the mean of going along one axis first and of
    /// going along the other first.
    CutStencil<2> sample(const Vec<double, 2>& p, const NodeRuns<2>& nodes) const noexcept {
        CutStencil<2> stencil;
        const auto x = std::int32_t(std::floor(p[0])), y = std::int32_t(std::floor(p[1]));
        const std::pair<std::uint64_t, std::uint32_t> key{cell(x, y), 0};
        const auto first = std::lower_bound(passes_.begin(), passes_.end(), key);
        const auto cast_in_cell = [&](const Vec<double, 2>& from, std::size_t axis, double end,
                                      double& position, BoundaryValue<2>& value) {
            return cast(from, axis, end, key.first, first, position, value);
        };
        const auto nearest_to = [&](const Index& node) { return nearest(node); };
        if (first == passes_.end() || first->first != key.first) {
            gather_cut<2>(stencil, p, {x, y}, {0, 1}, 0, 1.0, nodes, cast_in_cell, nearest_to);
        } else {
            gather_cut<2>(stencil, p, {x, y}, {0, 1}, 0, 0.5, nodes, cast_in_cell, nearest_to);
            gather_cut<2>(stencil, p, {x, y}, {1, 0}, 0, 0.5, nodes, cast_in_cell, nearest_to);
        }
        return stencil;
    }

private:
    struct Edge {
        std::uint32_t i, j; ///< the vertices at a and b
        Vec<double, 2> a, b;
        bool turns; ///< inside and outside change at it

        BoundaryValue<2> at(double s) const noexcept { return {{i, j}, {1 - s, s}}; }
        double height(double x) const noexcept {
            return b[0] == a[0] ? a[1] : a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
        }
    };
    using Pass = std::pair<std::uint64_t, std::uint32_t>;
    using PassIterator = typename std::vector<Pass>::const_iterator;

    static std::uint64_t cell(std::int32_t x, std::int32_t y) noexcept {
        return (std::uint64_t(std::uint32_t(y)) << 32) | std::uint32_t(x);
    }

    void add_crossings(std::vector<Crossing<2>>& out, const Edge& edge, std::size_t axis) const {
        const std::size_t across = 1 - axis;
        const double from = edge.a[across], to = edge.b[across];
        const double low = std::min(from, to), high = std::max(from, to);
        const double last = double(lattice_.cells[across]) - 1;
        for (double line = std::max(std::ceil(low), 0.0); line <= std::min(high, last); ++line) {
            if (from == to) { // along the line: every node on it is on the boundary
                const double begin = std::min(edge.a[axis], edge.b[axis]);
                const double end = std::max(edge.a[axis], edge.b[axis]);
                const auto put = [&](double x) {
                    const double s = (x - edge.a[axis]) / (edge.b[axis] - edge.a[axis]);
                    out.push_back({std::uint32_t(line), false, x, edge.at(s)});
                };
                put(begin);
                for (double x = std::floor(begin) + 1; x < end; ++x) put(x);
                put(end);
                return;
            }
            const double s = (line - from) / (to - from);
            const double position = edge.a[axis] + s * (edge.b[axis] - edge.a[axis]);
            // An edge owns its lower end: where two edges meet on a line, one, two or none of them turn as they must.
            out.push_back({std::uint32_t(line), edge.turns && line < high, position, edge.at(s)});
        }
    }

    /// The nearest place of the cell's edges on the line through `p` along `axis`, towards `end`; false if there is
    /// none before it.
    bool cast(const Vec<double, 2>& p, std::size_t axis, double end, std::uint64_t in, PassIterator first,
              double& position, BoundaryValue<2>& value) const noexcept {
        const std::size_t across = 1 - axis;
        const double sign = end > p[axis] ? 1.0 : -1.0;
        double nearest = std::fabs(end - p[axis]);
        bool found = false;
        for (auto pass = first; pass != passes_.end() && pass->first == in; ++pass) {
            if (pass->second >= edges_.size()) {
                found = bones_.meet(pass->second - edges_.size(), p, axis, sign, nearest, position, value) ||
                        found;
                continue;
            }
            const Edge& edge = edges_[pass->second];
            const double from = edge.a[across], to = edge.b[across];
            if (p[across] < std::min(from, to) || p[across] > std::max(from, to)) continue;
            const auto meet = [&](double s) {
                const double at = edge.a[axis] + s * (edge.b[axis] - edge.a[axis]);
                const double distance = sign * (at - p[axis]);
                if (distance < 0 || distance > nearest) return;
                nearest = distance;
                position = at;
                value = edge.at(s);
                found = true;
            };
            if (from != to) {
                meet((p[across] - from) / (to - from));
            } else {
                meet(0);
                meet(1);
            }
        }
        return found;
    }

    Lattice<double, 2> lattice_;
    GridBones<2> bones_;
    std::vector<Edge> edges_;
    std::vector<Pass> passes_; ///< cell and edge, sorted
};

template <Scalar T>
struct GridBoundaryOf<Polygon<T>> {
    using type = PolygonBoundary<T>;
};
template <Scalar T>
struct GridBoundaryOf<CellComplex<T, 2>> {
    using type = PolygonBoundary<T>;
};

} // namespace cageform::inline CAGEFORM_ABI
