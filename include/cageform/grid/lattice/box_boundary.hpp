// A box as the boundary of a problem on a lattice.
#pragma once

#include <cageform/cage/box.hpp>
#include <cageform/core/detail/buffer.hpp>
#include <cageform/grid/lattice/grid_boundary.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// A box in units of a lattice. Node i of the lattice lies at i.
template <Scalar T>
class BoxBoundary {
public:
    using Index = NodeRuns<3>::Index;
    static constexpr std::size_t dimension = 3;

    BoxBoundary(const Box<T>& box, const Lattice<double, 3>& lattice)
        : box_(box)
        , lattice_(lattice)
        , lower_(lattice.in_cells(vec_cast<double>(box.lower())))
        , upper_(lattice.in_cells(vec_cast<double>(box.upper()))) {}

    const Lattice<double, 3>& lattice() const noexcept { return lattice_; }
    /// Returns two crossings for each lattice line. O(lines).
    Crossings<3> crossings() const {
        Crossings<3> all;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto [a, b] = detail::other_axes[axis];
            Vec<double, 3> p{};
            const auto [begin_a, end_a] = inside(a);
            const auto [begin_b, end_b] = inside(b);
            for (std::size_t y = begin_b; y < end_b; ++y) {
                for (std::size_t x = begin_a; x < end_a; ++x) {
                    p[a] = double(x);
                    p[b] = double(y);
                    const auto line = std::uint32_t(x + lattice_.cells[a] * y);
                    all[axis].push_back({line, true, lower_[axis], on_face(axis, false, p)});
                    all[axis].push_back({line, true, upper_[axis], on_face(axis, true, p)});
                }
            }
        }
        return all;
    }

    Buffer<FixedNode<3>> fixed_nodes() const { return {}; } // a box has no interior cells
    std::optional<std::uint32_t> too_thin_bone() const noexcept { return std::nullopt; }

    BoundaryValue<3> nearest(const Index& node) const noexcept {
        const auto p = node_position<3>(node);
        std::size_t axis = 0;
        bool up = false;
        for (std::size_t k = 0; k < 3; ++k) {
            for (const bool other : {false, true}) {
                if (free_distance(p, k, other) >= free_distance(p, axis, up)) continue;
                axis = k;
                up = other;
            }
        }
        return on_face(axis, up, p);
    }

    double free_distance(const Vec<double, 3>& p, std::size_t axis, bool up,
                         double limit = (std::numeric_limits<double>::max)()) const noexcept {
        return std::fmin(limit, up ? upper_[axis] - p[axis] : p[axis] - lower_[axis]);
    }

    void index_cells(double /*slack*/) noexcept {} // `sample` needs no preparation
    /// Always returns none; the box itself locates points as fast.
    std::optional<Located<3>> locate(const Vec<double, 3>& /*p*/, double /*tolerance*/,
                                     const NodeRuns<3>& /*nodes*/) const noexcept {
        return std::nullopt;
    }

    /// Returns the stencil of a point strictly inside, trilinear in the piece of its cell that lies
    /// in the box. Exact for trilinear functions everywhere; a mean, so it never exceeds the values
    /// that it is made of.
    CutStencil<3> sample(const Vec<double, 3>& p, const NodeRuns<3>& nodes) const noexcept {
        CutStencil<3> stencil;
        for (std::size_t corner = 0; corner < 8; ++corner) {
            double share = 1;
            Vec<double, 3> q;
            std::size_t cut = 3;
            bool cut_up = false;
            for (std::size_t k = 0; k < 3; ++k) {
                const double cell = std::floor(p[k]);
                const double low = std::fmax(cell, lower_[k]), high = std::fmin(cell + 1, upper_[k]);
                const bool up = ((corner >> k) & 1u) != 0;
                const double t = high > low ? (p[k] - low) / (high - low) : 0;
                share *= up ? t : 1 - t;
                q[k] = up ? high : low;
                if (q[k] == (up ? upper_ : lower_)[k]) {
                    cut = k;
                    cut_up = up;
                }
            }
            if (share == 0) continue;
            if (cut < 3) {
                stencil.add(on_face(cut, cut_up, q), share);
                continue;
            }
            const Index index{std::int32_t(q[0]), std::int32_t(q[1]), std::int32_t(q[2])};
            const auto node = nodes.find(index);
            if (node != NodeRuns<3>::none) {
                stencil.add(node, share);
            } else { // a node on the boundary, up to rounding
                stencil.add(nearest(index), share);
            }
        }
        return stencil;
    }

private:
    /// Returns the range of nodes along an axis that lie in the box and not on its faces.
    std::pair<std::size_t, std::size_t> inside(std::size_t axis) const noexcept {
        const double begin = std::floor(lower_[axis] + on_boundary_distance) + 1;
        const double end = std::ceil(upper_[axis] - on_boundary_distance);
        return {std::size_t(begin), std::size_t(std::fmax(begin, end))};
    }
    BoundaryValue<3> on_face(std::size_t axis, bool upper, const Vec<double, 3>& p) const noexcept {
        Vec<double, 3> part;
        for (std::size_t k = 0; k < 3; ++k) part[k] = (p[k] - lower_[k]) / (upper_[k] - lower_[k]);
        return box_.on_face(axis, upper, part);
    }

    Box<T> box_;
    Lattice<double, 3> lattice_;
    Vec<double, 3> lower_, upper_;
};

template <Scalar T>
struct GridBoundaryOf<Box<T>> {
    using type = BoxBoundary<T>;
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
