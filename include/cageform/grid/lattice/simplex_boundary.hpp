// A polygon or a closed mesh, with its interior cells, as the boundary of a problem on a lattice. Finds the
// crossings with lattice lines, and interpolates between nodes up to the boundary.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/lattice/bones.hpp>
#include <cageform/grid/lattice/grid_boundary.hpp>
#include <cageform/grid/lattice/placed_facet.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The facets and bones that intersect each cell of a lattice of fewer than 2²⁰ cells per axis.
template <std::size_t D>
class ElementsByCell {
public:
    using Index = typename grid::NodeRuns<D>::Index;
    struct Pass {
        std::uint64_t cell;
        std::uint32_t element;
        auto operator<=>(const Pass&) const = default;
    };

    void add(const Index& low, std::uint32_t element) { passes_.push_back({key(low), element}); }
    void sort() { std::sort(passes_.begin(), passes_.end()); }
    void clear() noexcept { passes_.clear(); }

    /// Returns the elements in the cell with this lower corner. O(log #passes).
    std::span<const Pass> find(const Index& low) const noexcept {
        const auto cell = key(low);
        const auto first = std::lower_bound(passes_.begin(), passes_.end(), Pass{cell, 0});
        auto last = first;
        while (last != passes_.end() && last->cell == cell) ++last;
        return {first, last};
    }

private:
    static std::uint64_t key(const Index& low) noexcept {
        constexpr unsigned bits = 64 / D;
        std::uint64_t key = 0;
        for (std::size_t k = D; k-- > 0;)
            key = (key << bits) | (std::uint64_t(std::uint32_t(low[k])) & ((std::uint64_t{1} << bits) - 1));
        return key;
    }

    Buffer<Pass> passes_; ///< sorted
};

} // namespace detail
namespace grid {

/// The edges of a polygon or the triangles of a mesh, and the interior cells, on a lattice. The lattice has
/// at most 1024 cells per axis (16384 in 2D). Its *elements* are the facets, then the bones.
template <std::size_t D>
class SimplexBoundary {
public:
    static constexpr std::size_t dimension = D;
    using Index = typename NodeRuns<D>::Index;

    /// Takes a Polygon, a TriangleMesh or a CellComplex. It also takes cells without a boundary
    /// (fields/strokes.hpp), whose facets may have other handles on the back side: `back_offset` is added
    /// to the handles there.
    template <class Cage>
    SimplexBoundary(const Cage& whole, const Lattice<double, D>& lattice, std::uint32_t back_offset = 0)
        : lattice_(lattice)
        , bones_(interior_cells(whole).bones, lattice.in_cells(whole.vertices()), lattice) {
        const auto vertices = lattice.in_cells(whole.vertices());
        for_each_facet(boundary_of(whole), [&](const auto& facet) {
            facets_.push_back({facet, std::span<const Vec<double, D>>(vertices), true});
        });
        const auto& cells = interior_cells(whole);
        for (const auto& facet : cells.facets)
            facets_.push_back({facet, std::span<const Vec<double, D>>(vertices), false, back_offset});
    }

    const Lattice<double, D>& lattice() const noexcept { return lattice_; }

    /// Returns the crossings with the lattice lines. O(n log n), where n is the sum of #facets and
    /// #crossings.
    Crossings<D> crossings() const {
        Crossings<D> all;
        for (std::size_t axis = 0; axis < D; ++axis) {
            for (const Facet& facet : facets_) detail::add_crossings(facet, axis, lattice_, all[axis]);
        }
        bones_.add_crossings(all);
        for (auto& along : all) sort_along_lines<D>(along);
        return all;
    }
    Buffer<FixedNode<D>> fixed_nodes() const { return bones_.nodes(); }
    std::optional<std::uint32_t> too_thin_bone() const noexcept { return bones_.too_thin(); }

    /// Returns the data of the boundary point nearest to a node. O(elements).
    BoundaryValue<D> nearest(const Index& node) const noexcept {
        const auto p = node_position<D>(node);
        double least = (std::numeric_limits<double>::max)();
        BoundaryValue<D> value;
        for (const Facet& facet : facets_) {
            const auto weights = nearest_on_facet(p, facet.corner);
            const auto d = facet.position(weights) - p;
            if (dot(d, d) >= least) continue;
            least = dot(d, d);
            value = value_on_facet(facet.vertex, weights);
        }
        const auto bone = bones_.nearest(p, std::sqrt(least));
        return bone ? bone->value : value;
    }

    /// Returns the distance from a point along an axis to the boundary. O(cells on the way · elements in
    /// them).
    double free_distance(const Vec<double, D>& p, std::size_t axis, bool up, double limit) const noexcept {
        AxisRay<D> ray{p, axis, up, limit};
        Index low;
        for (std::size_t k = 0; k < D; ++k) low[k] = std::int32_t(std::floor(p[k]));
        const std::int32_t last = lattice_.counts()[axis];
        for (; low[axis] >= -1 && low[axis] <= last; low[axis] += up ? 1 : -1) {
            if (ray.distance(up ? low[axis] : low[axis] + 1) > ray.length) break;
            for (const auto& pass : elements_.find(low)) shorten_to(pass.element, ray);
        }
        return ray.length;
    }

    /// Builds the cell index for free_distance, locate and sample.
    void index_cells(double slack) {
        elements_.clear();
        std::uint32_t element = 0;
        const auto add = [&](const Index& low) { elements_.add(low, element); };
        for (const Facet& facet : facets_) {
            cageform::for_each_cell(facet, slack, add);
            ++element;
        }
        for (std::size_t n = 0; n < bones_.size(); ++n, ++element) bones_.for_each_cell(n, add);
        elements_.sort();
    }
    /// Returns the location of a point. In a cell with elements, returns nullopt near bones and where
    /// rounding might decide. O(elements in the cell).
    std::optional<Located<D>> locate(const Vec<double, D>& p, double tolerance,
                                     const NodeRuns<D>& nodes) const noexcept {
        Index low;
        for (std::size_t k = 0; k < D; ++k) low[k] = std::int32_t(std::floor(p[k]));
        const auto elements = elements_.find(low);
        const bool at_node = nodes.find(low) != NodeRuns<D>::none;
        if (elements.empty()) return Located<D>{at_node ? PointState::inside : PointState::outside, {}};
        // Positions are rounded by less than half of the tolerance.
        double least = 2 * tolerance;
        std::optional<Located<D>> result;
        for (const Pass& pass : elements) {
            if (pass.element >= facets_.size()) return std::nullopt;
            const Facet& facet = facets_[pass.element];
            const auto weights = nearest_on_facet(p, facet.corner);
            const double distance = detail::length(facet.position(weights) - p);
            // Of two equally near facets, the first is used.
            if (distance > least || (result && distance == least)) continue;
            least = distance;
            result = {PointState::on_boundary, value_on_facet(facet.vertex, weights)};
        }
        if (result) return least <= 0.5 * tolerance ? result : std::nullopt;
        for (std::size_t corner = 0; corner < CutStencil<D>::corners; ++corner) {
            Index index = low;
            for (std::size_t k = 0; k < D; ++k) index[k] += std::int32_t((corner >> k) & 1u);
            if (nodes.find(index) == NodeRuns<D>::none) continue;
            const auto separated = are_separated(elements, p, node_position<D>(index));
            if (separated) return Located<D>{*separated ? PointState::outside : PointState::inside, {}};
        }
        return std::nullopt;
    }

    /// Returns a stencil: multilinear, or in cells cut by the boundary the mean of D interpolations, one per
    /// cyclic order of the axes. The value never exceeds the values of the stencil. Beyond the last nodes, if
    /// there is no boundary, the values are mirrored.
    CutStencil<D> sample(const Vec<double, D>& p, const NodeRuns<D>& nodes) const noexcept {
        CutStencil<D> stencil;
        Cell cell{nodes, {}, {}, {}, stencil};
        for (std::size_t k = 0; k < D; ++k) cell.low[k] = std::int32_t(std::floor(p[k]));
        cell.elements = elements_.find(cell.low);
        bool between_nodes = true;
        for (std::size_t k = 0; k < D; ++k)
            between_nodes = between_nodes && cell.low[k] >= 0 && cell.low[k] + 1 < nodes.size()[k];
        if (cell.elements.empty() && between_nodes) {
            add_corners(cell.low, p, nodes, stencil);
            return stencil;
        }
        for (std::size_t first = 0; first < D; ++first) {
            for (std::size_t k = 0; k < D; ++k) cell.axes[k] = (first + k) % D;
            gather(cell, p, 1.0 / double(D));
        }
        return stencil;
    }

private:
    using Facet = PlacedFacet<D>;
    using Pass = typename detail::ElementsByCell<D>::Pass;
    struct Cell {
        const NodeRuns<D>& nodes;
        Index low;
        std::span<const Pass> elements;  ///< in the cell
        std::array<std::size_t, D> axes; ///< in order of interpolation
        CutStencil<D>& stencil;
    };

    /// Returns the intersection of a ray with an element, and shortens the ray to it.
    std::optional<Hit<D>> shorten_to(std::uint32_t element, AxisRay<D>& ray) const noexcept {
        const auto hit = element < facets_.size() ? detail::hit(facets_[element], ray)
                                                  : bones_.hit(element - facets_.size(), ray);
        if (hit) ray.length = ray.distance(hit->position);
        return hit;
    }
    std::optional<Hit<D>> first_hit(const Cell& cell, AxisRay<D> ray) const noexcept {
        std::optional<Hit<D>> first;
        for (const auto& pass : cell.elements) {
            if (const auto hit = shorten_to(pass.element, ray)) first = hit;
        }
        return first;
    }

    /// Whether exactly one of two points of a cell is inside, by the facets in the cell; nullopt if
    /// rounding might decide.
    std::optional<bool> are_separated(std::span<const Pass> elements, const Vec<double, D>& from,
                                      const Vec<double, D>& to) const noexcept {
        bool separated = false;
        for (const Pass& pass : elements) {
            if (!facets_[pass.element].separates) continue;
            const auto crosses = detail::crosses(facets_[pass.element], from, to);
            if (!crosses) return std::nullopt;
            separated = separated != *crosses;
        }
        return separated;
    }

    /// Adds the multilinear stencil of a cell without elements, whose corners are all unknowns. Corners
    /// along axis 0 are neighbours in a run.
    static void add_corners(const Index& low, const Vec<double, D>& p, const NodeRuns<D>& nodes,
                            CutStencil<D>& stencil) noexcept {
        for (std::size_t row = 0; row < CutStencil<D>::corners / 2; ++row) {
            Index index = low;
            double share = 1;
            for (std::size_t k = 1; k < D; ++k) {
                const auto up = std::int32_t((row >> (k - 1)) & 1u);
                const double at = p[k] - low[k];
                index[k] += up;
                share *= up != 0 ? at : 1 - at;
            }
            if (share == 0) continue;
            const std::uint32_t node = nodes.find(index);
            const double at = p[0] - low[0];
            if (at < 1) stencil.nodes[stencil.node_count++] = {node, share * (1 - at)};
            if (at > 0) stencil.nodes[stencil.node_count++] = {node + 1, share * at};
        }
    }

    /// Adds a share of the value at `p` to the cell's stencil, by linear interpolation along one axis after
    /// the other; `done` axes are finished. If the boundary is nearer than an end of the cell, its value
    /// replaces the value there.
    void gather(Cell& cell, const Vec<double, D>& p, double share, std::size_t done = 0) const noexcept {
        if (done == D) {
            Index index;
            for (std::size_t k = 0; k < D; ++k) index[k] = std::int32_t(p[k]);
            const auto node = cell.nodes.find(index);
            if (node != NodeRuns<D>::none) {
                cell.stencil.add(node, share);
            } else { // on the boundary, up to rounding
                cell.stencil.add(nearest(index), share);
            }
            return;
        }
        const std::size_t axis = cell.axes[done];
        const double low = cell.low[axis], high = low + 1;
        const auto below = first_hit(cell, {p, axis, low > p[axis], std::fabs(low - p[axis])});
        const auto above = first_hit(cell, {p, axis, high > p[axis], std::fabs(high - p[axis])});
        const double begin = below ? below->position : low, end = above ? above->position : high;
        const double length = end - begin;
        double at = length > 0 ? (p[axis] - begin) / length : 0.0;
        if (!below && low < 0) at = 1;
        if (!above && high >= cell.nodes.size()[axis]) at = 0;
        const auto take = [&](const std::optional<Hit<D>>& hit, double position, double weight) {
            if (!(weight > 0)) return;
            if (hit) {
                cell.stencil.add(hit->value, weight);
                return;
            }
            auto q = p;
            q[axis] = position;
            gather(cell, q, weight, done + 1);
        };
        take(below, begin, share * (1 - at));
        take(above, end, share * at);
    }

    Lattice<double, D> lattice_;
    GridBones<D> bones_;
    Buffer<Facet> facets_;
    detail::ElementsByCell<D> elements_;
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
