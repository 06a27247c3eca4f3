// Bones (points and edges with a radius) as parts of the boundary of a problem on a lattice.
#pragma once

#include <cageform/cage/cell_complex.hpp>
#include <cageform/grid/embed.hpp>
#include <cageform/grid/lattice.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The bones of a cage, balls and in space capsules, in units of a lattice. Node i of the lattice lies at i.
template <std::size_t D>
class GridBones {
public:
    using Index = typename NodeRuns<D>::Index;

    /// `vertices` in units of the lattice; the radii of `cells` not.
    GridBones(std::span<const Bone> cells, std::span<const Vec<double, D>> vertices,
              const Lattice<double, D>& lattice) {
        for (std::size_t k = 0; k < D; ++k) size_[k] = std::int32_t(lattice.cells[k]);
        for (const auto& cell : cells)
            cells_.push_back(
                {cell.i, cell.j, vertices[cell.i], vertices[cell.j], cell.radius / lattice.spacing});
    }

    std::size_t size() const noexcept { return cells_.size(); }
    /// The handle of a cell that is too thin for the lattice to feel it rightly, wherever its nodes lie.
    std::optional<std::uint32_t> too_thin() const noexcept {
        for (const Cell& cell : cells_) {
            if (cell.radius < 0.5) return cell.i;
        }
        return std::nullopt;
    }

    /// Where the lattice lines enter and leave. O(lines that meet their boxes · cells).
    void add_crossings(Crossings<D>& all) const {
        for (std::size_t axis = 0; axis < D; ++axis) {
            for (const Cell& cell : cells_) {
                for_each_node_about(cell, axis, [&](const Index& index) {
                    const auto p = place(index);
                    double low = 0, high = 0;
                    if (!chord(cell, p, axis, low, high)) return;
                    for (const double x : {low, high}) {
                        auto q = p;
                        q[axis] = x;
                        double within = on_boundary_distance; // where cells overlap, of all of them
                        BoundaryValue<D> value;
                        if (!nearest(q, within, value)) value = bone_value<D>(cell, q);
                        all[axis].push_back({line(index, axis), false, x, value});
                    }
                });
            }
        }
    }

    /// The nodes within a cell, each once. O(nodes in the cells' boxes · cells).
    std::vector<FixedNode<D>> nodes() const {
        std::vector<FixedNode<D>> all;
        for (const Cell& cell : cells_) {
            for_each_node_about(cell, D, [&](const Index& index) {
                double least = on_boundary_distance;
                BoundaryValue<D> value;
                if (nearest(place(index), least, value)) all.push_back({index, value});
            });
        }
        const auto by_index = [](const FixedNode<D>& a, const FixedNode<D>& b) { return a.index < b.index; };
        const auto same = [](const FixedNode<D>& a, const FixedNode<D>& b) { return a.index == b.index; };
        std::sort(all.begin(), all.end(), by_index);
        all.erase(std::unique(all.begin(), all.end(), same), all.end());
        return all;
    }

    /// The value of the cells nearest to `p` where their surface is not farther than `least`, which becomes that distance
    /// (negative within). O(cells).
    bool nearest(const Vec<double, D>& p, double& least, BoundaryValue<D>& value) const noexcept {
        const auto hit = nearest_bone<D>(
            cells_.size(), [&](std::size_t n) -> const Cell& { return cells_[n]; }, p, least);
        if (!hit) return false;
        least = hit->distance;
        value = hit->value;
        return true;
    }

    /// Whether cell `n` lies on the way from `p` along an axis within `limit`, which becomes the distance to it.
    bool meet(std::size_t n, const Vec<double, D>& p, std::size_t axis, double sign, double& limit,
              double& position, BoundaryValue<D>& value) const noexcept {
        double low = 0, high = 0;
        if (!chord(cells_[n], p, axis, low, high)) return false;
        if (sign > 0 ? high < p[axis] : low > p[axis]) return false;
        const double at = sign > 0 ? std::fmax(low, p[axis]) : std::fmin(high, p[axis]);
        if (std::fabs(at - p[axis]) > limit) return false;
        limit = std::fabs(at - p[axis]);
        position = at;
        auto q = p;
        q[axis] = at;
        double within = on_boundary_distance; // where cells overlap, of all of them
        if (!nearest(q, within, value)) value = bone_value<D>(cells_[n], q);
        return true;
    }

    /// f(index) for the lower corners of the lattice's cells near cell `n`. O(cells of the lattice in its box).
    template <class F>
    void for_each_cell_about(std::size_t n, F&& f) const {
        const Cell& cell = cells_[n];
        const double reach = cell.radius + 0.51 * std::sqrt(double(D)); // half a diagonal and some slack
        for_each_node_about(cell, D, [&](const Index& index) {
            auto middle = place(index);
            for (std::size_t k = 0; k < D; ++k) middle[k] += 0.5;
            if (detail::length(detail::nearest_on_segment(middle, cell.a, cell.b) - middle) <= reach)
                f(index);
        });
    }

private:
    using Cell = PlacedBone<D>;

    static Vec<double, D> place(const Index& index) noexcept {
        Vec<double, D> p{};
        for (std::size_t k = 0; k < D; ++k) p[k] = double(index[k]);
        return p;
    }
    /// See Crossing::line.
    std::uint32_t line(const Index& index, std::size_t axis) const noexcept {
        std::uint32_t number = 0;
        for (std::size_t k = D; k-- > 0;) {
            if (k != axis) number = number * std::uint32_t(size_[k]) + std::uint32_t(index[k]);
        }
        return number;
    }
    /// The nodes of the lattice in a box about a cell, one of each line along `axis` (all for axis D).
    template <class F>
    void for_each_node_about(const Cell& cell, std::size_t axis, F&& f) const {
        Index low{}, high{};
        for (std::size_t k = 0; k < D; ++k) {
            if (k == axis) continue;
            const double least = std::fmin(cell.a[k], cell.b[k]) - cell.radius - 1;
            const double most = std::fmax(cell.a[k], cell.b[k]) + cell.radius;
            low[k] = std::max(std::int32_t(std::floor(least)), 0);
            high[k] = std::min(std::int32_t(std::ceil(most)), size_[k] - 1);
            if (low[k] > high[k]) return;
        }
        Index index = low;
        for (std::size_t k = 0; k < D;) {
            f(index);
            for (k = 0; k < D; ++k) {
                if (++index[k] <= high[k]) break;
                index[k] = low[k];
            }
        }
    }

    /// The part [low, high] of the line through `p` along an axis that lies in a cell.
    static bool chord(const Cell& cell, const Vec<double, D>& p, std::size_t axis, double& low,
                      double& high) noexcept {
        low = std::numeric_limits<double>::infinity();
        high = -low;
        const auto add = [&](double begin, double end) {
            if (begin > end) return;
            low = std::fmin(low, begin);
            high = std::fmax(high, end);
        };
        // A capsule is convex: the line's part is what spans its parts in the balls about the ends and in the cylinder.
        const double r2 = cell.radius * cell.radius;
        for (const auto& end : {cell.a, cell.b}) {
            auto across = p - end;
            across[axis] = 0;
            const double h2 = r2 - dot(across, across);
            if (h2 >= 0) add(end[axis] - std::sqrt(h2), end[axis] + std::sqrt(h2));
        }
        const auto e = cell.b - cell.a;
        const double e2 = dot(e, e);
        auto m = p - cell.a;
        m[axis] = 0; // positions along the line count from a
        const double across2 = e2 - e[axis] * e[axis];
        if (across2 > 1e-12 * e2) {
            // |m + t u|² less its part along e, = r²
            const double me = dot(m, e), a = across2 / e2, b = -me * e[axis] / e2;
            const double c = dot(m, m) - me * me / e2 - r2, root = b * b - a * c;
            if (root >= 0) {
                double begin = (-b - std::sqrt(root)) / a, end = (-b + std::sqrt(root)) / a;
                if (e[axis] != 0) {
                    const double first = -me / e[axis], last = (e2 - me) / e[axis];
                    begin = std::fmax(begin, std::fmin(first, last));
                    end = std::fmin(end, std::fmax(first, last));
                } else if (me < 0 || me > e2) {
                    end = -std::numeric_limits<double>::infinity();
                }
                add(cell.a[axis] + begin, cell.a[axis] + end);
            }
        }
        return low <= high;
    }

    std::array<std::int32_t, D> size_{};
    std::vector<Cell> cells_;
};

} // namespace cageform::inline CAGEFORM_ABI
