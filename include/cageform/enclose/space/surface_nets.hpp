// make_cage in 3D, step 3: the tightest cage. It has a vertex in every lattice cell that the border of the
// outside crosses.
#pragma once

#include <cageform/enclose/space/shell.hpp>

#include <cstring>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Calls visit(node, numbers) for the nodes of a lattice, row by row. A node stands for the cell of which it
/// is the lowest corner. Skips seven nodes at a time if their cells lie on one side of the border.
template <class Visit>
void for_each_mixed(const DistanceLattice<3>& lattice, const std::vector<std::uint8_t>& outside,
                    const Visit& visit) {
    const std::size_t u = lattice.stride()[1], v = lattice.stride()[2];
    const auto& count = lattice.count();
    // Whether eight nodes of a row, and those of three rows beside it, are on one side.
    const auto are_alike = [&](std::size_t node) {
        std::uint64_t all = ~std::uint64_t{0}, some = 0;
        for (const std::size_t beside : {std::size_t{0}, u, v, u + v}) {
            std::uint64_t eight = 0;
            std::memcpy(&eight, &outside[node + beside], 8);
            all &= eight;
            some |= eight;
        }
        return some == 0 || all == 0x0101010101010101U;
    };
    DistanceLattice<3>::Count n{};
    for (n[2] = 0; n[2] < count[2]; ++n[2]) {
        for (n[1] = 0; n[1] < count[1]; ++n[1]) {
            const std::size_t row = n[1] * u + n[2] * v;
            const bool has_beside = n[1] + 1 < count[1] && n[2] + 1 < count[2];
            for (n[0] = 0; n[0] < count[0];) {
                if (has_beside && n[0] + 8 <= count[0] && are_alike(row + n[0])) {
                    n[0] += 7;
                } else {
                    visit(row + n[0], n);
                    ++n[0];
                }
            }
        }
    }
}

/// Changes outside nodes to inside until the border is a manifold (Latecki, 3D well-composed pictures, 1997).
/// Squares of four nodes and cubes of eight must not have two opposite corners on one side and all others on
/// the other. Nodes on the rim of the lattice stay outside.
inline void make_well_composed(const DistanceLattice<3>& lattice, std::vector<std::uint8_t>& outside) {
    const auto& stride = lattice.stride();
    const auto& count = lattice.count();
    const auto fill = [&](std::size_t node) {
        outside[node] = 0;
        return true;
    };
    // If the diagonals of a square are on different sides, one of the two outside nodes becomes inside.
    const auto fix_square = [&](std::size_t node, std::size_t u, std::size_t v) {
        const bool a = outside[node] != 0, b = outside[node + u] != 0, c = outside[node + v] != 0,
                   d = outside[node + u + v] != 0;
        if (a != d || b != c || a == b) return false;
        return fill(a ? node : node + u);
    };
    const auto fix_cube = [&](std::size_t node) {
        for (std::size_t corner = 0; corner < 4; ++corner) {
            const auto at = [&](std::size_t bits) {
                return node + (bits & 1) * stride[0] + (bits >> 1 & 1) * stride[1] + (bits >> 2) * stride[2];
            };
            const std::size_t opposite = 7 - corner;
            std::size_t alike = 0; // corners on the same side as this one, including itself
            const bool kind = outside[at(corner)] != 0;
            for (std::size_t other = 0; other < 8; ++other) alike += (outside[at(other)] != 0) == kind;
            if ((outside[at(opposite)] != 0) != kind || alike != 2) continue;
            return fill(kind ? at(corner) : at(corner ^ 1));
        }
        return false;
    };
    for (bool changed = true; changed;) {
        changed = false;
        for_each_mixed(lattice, outside, [&](std::size_t node, const DistanceLattice<3>::Count& n) {
            std::array<bool, 3> has{};
            for (std::size_t k = 0; k < 3; ++k) has[k] = n[k] + 1 < count[k];
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t l = (k + 1) % 3;
                if (has[k] && has[l] && fix_square(node, stride[k], stride[l])) changed = true;
            }
            if (has[0] && has[1] && has[2] && fix_cube(node)) changed = true;
        });
    }
}

/// Makes the border of the outside by surface nets (Gibson, Constrained elastic surface nets, 1998). Each
/// mixed cell gets a vertex at the mean of the points where its edges cross the border. Each crossed lattice
/// edge gets two triangles, divided along the shorter diagonal. With `half`, the lattice is symmetric, and
/// its middle plane is midway between nodes. Then only the part x >= 0 is made. The vertices of cells that
/// the plane halves lie on it and form the rim.
class SurfaceNets {
public:
    using Point = Vec<double, 3>;

    SurfaceNets(const DistanceLattice<3>& lattice, const std::vector<std::uint8_t>& outside, bool half)
        : lattice_(lattice)
        , outside_(outside)
        , half_(half)
        , vertex_(lattice.size(), none) {}

    Shell shell() {
        Shell shell;
        shell.half = half_;
        const auto& stride = lattice_.stride();
        const auto& count = lattice_.count();
        for_each_mixed(lattice_, outside_, [&](std::size_t node, const DistanceLattice<3>::Count& n) {
            if (half_ && n[0] < count[0] / 2) return;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if (n[axis] + 1 >= count[axis]) continue;
                const bool from = outside_[node] != 0, to = outside_[node + stride[axis]] != 0;
                if (from == to) continue;
                add_faces(node, axis, from, shell);
            }
        });
        shell.link();
        return shell;
    }

private:
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    /// Adds two triangles across the lattice edge from a node along an axis. They join the vertices of the
    /// four cells around the edge. These cells exist, because the rim of the lattice is outside.
    void add_faces(std::size_t node, std::size_t axis, bool from_outside, Shell& shell) {
        const auto& stride = lattice_.stride();
        const std::size_t u = stride[(axis + 1) % 3], v = stride[(axis + 2) % 3];
        std::array<std::uint32_t, 4> quad{};
        const std::array<std::size_t, 4> cells{node - u - v, node - v, node, node - u};
        for (std::size_t k = 0; k < 4; ++k) quad[k] = vertex_of(cells[k], shell);
        if (from_outside) std::swap(quad[1], quad[3]);
        const auto& p = shell.points;
        const auto d = p[quad[1]] - p[quad[3]], e = p[quad[0]] - p[quad[2]];
        const std::size_t first = dot(d, d) < dot(e, e) ? 1 : 0;
        for (const std::size_t k : {first + 1, first + 2})
            shell.faces.push_back({quad[first], quad[k % 4], quad[(k + 1) % 4]});
    }

    std::uint32_t vertex_of(std::size_t cell, Shell& shell) {
        if (vertex_[cell] != none) return vertex_[cell];
        const auto& stride = lattice_.stride();
        const Point low = lattice_.position(cell);
        const double h = lattice_.spacing();
        Point sum{};
        int crossings = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
            for (std::size_t corner = 0; corner < 4; ++corner) {
                const std::size_t a = cell + (corner & 1) * stride[u] + (corner >> 1) * stride[v],
                                  b = a + stride[axis];
                if ((outside_[a] != 0) == (outside_[b] != 0)) continue;
                const double f = double(lattice_[a]), g = double(lattice_[b]);
                Point at{};
                at[u] = double(corner & 1);
                at[v] = double(corner >> 1);
                at[axis] = f != g ? std::clamp(f / (f - g), 0.05, 0.95) : 0.5;
                sum = sum + at;
                ++crossings;
            }
        }
        Point p = low + (h / crossings) * sum;
        const bool on_rim = half_ && lattice_.numbers(cell)[0] + 1 == lattice_.count()[0] / 2;
        if (on_rim) p[0] = 0;
        vertex_[cell] = static_cast<std::uint32_t>(shell.points.size());
        shell.points.push_back(to_outside(p, on_rim));
        shell.on_rim.push_back(on_rim);
        return vertex_[cell];
    }

    /// Moves a point to f >= 0 by a few steps of Newton's method along the gradient of f.
    Point to_outside(Point p, bool on_rim) const {
        const double h = lattice_.spacing();
        for (int step = 0; step < 4; ++step) {
            const double f = lattice_.value(p);
            if (f >= 0) break;
            Point slope{};
            for (std::size_t k = on_rim ? 1 : 0; k < 3; ++k) {
                Point a = p, b = p;
                a[k] -= 0.5 * h;
                b[k] += 0.5 * h;
                slope[k] = (lattice_.value(b) - lattice_.value(a)) / h;
            }
            const double steep = dot(slope, slope);
            if (!(steep > 0.01)) break;
            p = p - (f / steep) * slope;
        }
        return p;
    }

    const DistanceLattice<3>& lattice_;
    const std::vector<std::uint8_t>& outside_;
    bool half_;
    std::vector<std::uint32_t> vertex_; ///< the vertex of the cell whose lowest corner is this node
};

} // namespace cageform::inline CAGEFORM_ABI::detail
