// Facets of a boundary (edges in 2D, triangles in 3D) on a lattice: their crossings with lattice lines,
// rays and cells.
//
// Every lattice line must cross a closed boundary an even number of times. The crossing rules guarantee this:
// half-open edges in 2D, integer arithmetic in 3D.
#pragma once

#include <cageform/cage/cell_complex.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/lattice/grid_boundary.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A facet in units of the lattice.
template <std::size_t D>
struct PlacedFacet : Facet<D> {
    using Weights = std::array<double, D>; ///< barycentric coordinates

    PlacedFacet(const std::array<std::uint32_t, D>& of, std::span<const Vec<double, D>> vertices,
                bool separating, std::uint32_t offset_at_back = 0)
        : Facet<D>(of, vertices)
        , separates(separating)
        , back_offset(offset_at_back) {}

    bool separates; ///< whether the facet separates inside from outside; false for a wall
    /// Added to the handles for the back side, opposite to the normal; 0 if both sides share handles.
    std::uint32_t back_offset;

    Vec<double, D> position(const Weights& weights) const noexcept {
        Vec<double, D> p;
        for (std::size_t k = 0; k < D; ++k) p[k] = coordinate(weights, k);
        return p;
    }
    double coordinate(const Weights& weights, std::size_t axis) const noexcept {
        if constexpr (D == 2) { // exact if the edge is perpendicular to the axis
            return this->corner[0][axis] + weights[1] * (this->corner[1][axis] - this->corner[0][axis]);
        } else {
            double sum = 0;
            for (std::size_t k = 0; k < D; ++k) sum += weights[k] * this->corner[k][axis];
            return sum;
        }
    }
};

namespace detail {

/// Returns a normal of a facet, not normalised.
inline Vec<double, 2> normal_of(const PlacedFacet<2>& edge) noexcept {
    const auto along = edge.corner[1] - edge.corner[0];
    return {-along[1], along[0]};
}
inline Vec<double, 3> normal_of(const PlacedFacet<3>& face) noexcept {
    return cross(face.corner[1] - face.corner[0], face.corner[2] - face.corner[0]);
}

/// Returns the data at a point of a facet seen along an axis. It is the data of the front side, to which the
/// normal points, or of the back side. In 2D a facet seen edge-on gives the mean of both.
template <std::size_t D>
BoundaryValue<D> value_from_side(const PlacedFacet<D>& facet, const std::array<double, D>& weights,
                                 std::size_t axis, bool up) noexcept {
    auto value = value_on_facet(facet.vertex, weights);
    if (facet.back_offset == 0) return value;
    const double along = normal_of(facet)[axis];
    if (D == 2 && along == 0) { // at an end, where one weight is 1
        const std::uint32_t end = facet.vertex[weights[0] > 0 ? 0 : 1];
        value.handle[0] = end;
        value.handle[1] = end + facet.back_offset;
        value.weight[0] = value.weight[1] = 0.5;
    } else if (up == (along > 0)) {
        for (std::uint32_t& handle : value.handle) handle += facet.back_offset;
    }
    return value;
}

/// Returns the intersection of a ray of unlimited length with an edge; the nearer end if the edge is on the
/// ray.
inline std::optional<std::array<double, 2>> meeting_weights(const PlacedFacet<2>& edge,
                                                            const grid::AxisRay<2>& ray) noexcept {
    const auto &a = edge.corner[0], &b = edge.corner[1];
    const std::size_t across = 1 - ray.axis;
    const double from = a[across], to = b[across], at = ray.from[across];
    if (at < (std::min)(from, to) || at > (std::max)(from, to)) return std::nullopt;
    double s = 0;
    if (from != to) {
        s = (at - from) / (to - from);
    } else {
        const double to_a = ray.distance(a[ray.axis]), to_b = ray.distance(b[ray.axis]);
        s = to_b >= 0 && (to_a < 0 || to_b <= to_a) ? 1 : 0;
    }
    return std::array<double, 2>{1 - s, s};
}

/// Returns the barycentric coordinates of the point where the line along `axis` through the position (x, y)
/// meets a face's plane; nullopt if the face is seen edge-on.
inline std::optional<std::array<double, 3>> weights_at(const PlacedFacet<3>& face, std::size_t axis, double x,
                                                       double y) noexcept {
    const auto [u, v] = other_axes[axis];
    std::array<Vec<double, 2>, 3> c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = {face.corner[k][u] - x, face.corner[k][v] - y};
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    if (area == 0) return std::nullopt;
    std::array<double, 3> w;
    for (std::size_t k = 0; k < 3; ++k) w[k] = cross(c[(k + 1) % 3], c[(k + 2) % 3]) / area;
    return w;
}
/// Moves a point outside a facet by rounding onto its boundary.
template <std::size_t D>
std::array<double, D> onto_facet(std::array<double, D> w) noexcept {
    double sum = 0;
    for (double& x : w) sum += (x = std::clamp(x, 0.0, 1.0));
    for (double& x : w) x /= sum;
    return w;
}

/// Returns the intersection of a ray of unlimited length with a face.
inline std::optional<std::array<double, 3>> meeting_weights(const PlacedFacet<3>& face,
                                                            const grid::AxisRay<3>& ray) noexcept {
    constexpr double margin = 1e-9; // no ray passes between two faces
    const auto [u, v] = other_axes[ray.axis];
    const auto w = weights_at(face, ray.axis, ray.from[u], ray.from[v]);
    if (!w || (*w)[0] < -margin || (*w)[1] < -margin || (*w)[2] < -margin) return std::nullopt;
    return onto_facet(*w);
}

template <std::size_t D>
std::optional<grid::Hit<D>> hit(const PlacedFacet<D>& facet, const grid::AxisRay<D>& ray) noexcept {
    const auto weights = meeting_weights(facet, ray);
    if (!weights) return std::nullopt;
    const double position = facet.coordinate(*weights, ray.axis);
    const double distance = ray.distance(position);
    if (distance < 0 || distance > ray.length) return std::nullopt;
    return grid::Hit<D>{position, value_from_side(facet, *weights, ray.axis, ray.up)};
}

/// Returns the barycentric coordinates of a point on a facet's line or plane.
inline std::array<double, 2> weights_in_plane(const PlacedFacet<2>& edge, const Vec<double, 2>& p) noexcept {
    const auto along = edge.corner[1] - edge.corner[0];
    const double s = dot(p - edge.corner[0], along) / dot(along, along);
    return {1 - s, s};
}
inline std::array<double, 3> weights_in_plane(const PlacedFacet<3>& face, const Vec<double, 3>& p) noexcept {
    const auto& [a, b, c] = face.corner;
    const auto n = normal_of(face);
    const double u = dot(cross(c - b, p - b), n) / dot(n, n), v = dot(cross(a - c, p - c), n) / dot(n, n);
    return {u, v, 1 - u - v};
}

/// Whether the segment between two points crosses a facet. Returns nullopt if rounding might decide the
/// result: if the segment passes near the facet's boundary, or has an end near the facet's line or plane.
template <std::size_t D>
std::optional<bool> crosses(const PlacedFacet<D>& facet, const Vec<double, D>& from,
                            const Vec<double, D>& to) noexcept {
    constexpr double rounding = 1e-7; // in cells, and in barycentric coordinates
    const auto normal = normal_of(facet);
    const double size = std::sqrt(dot(normal, normal));
    const double at_from = dot(normal, from - facet.corner[0]), at_to = dot(normal, to - facet.corner[0]);
    if (!(std::fabs(at_from) > rounding * size && std::fabs(at_to) > rounding * size)) return std::nullopt;
    if ((at_from > 0) == (at_to > 0)) return false;
    const auto weights = weights_in_plane(facet, from + (at_from / (at_from - at_to)) * (to - from));
    const double least = *std::min_element(weights.begin(), weights.end());
    if (!(std::fabs(least) > rounding)) return std::nullopt;
    return least > 0;
}

/// Adds a crossing at a point of a facet, or one per side if the sides differ.
template <std::size_t D>
void add_crossing(const PlacedFacet<D>& facet, const std::array<double, D>& weights, std::size_t axis,
                  grid::Crossing<D> crossing, Buffer<grid::Crossing<D>>& out) {
    crossing.value = value_from_side(facet, weights, axis, true);
    if (facet.back_offset != 0) {
        crossing.from_above = false;
        out.push_back(crossing);
        crossing.value = value_from_side(facet, weights, axis, false);
        std::swap(crossing.from_below, crossing.from_above);
    }
    out.push_back(crossing);
}

/// Adds the crossings of the lattice lines along an axis with an edge. An edge includes its lower end but not
/// its upper one. So a line through a common end of two edges has an odd number of crossings only if it
/// changes sides there.
inline void add_crossings(const PlacedFacet<2>& edge, std::size_t axis, const Lattice<double, 2>& lattice,
                          Buffer<grid::Crossing<2>>& out) {
    const std::size_t across = 1 - axis;
    const double from = edge.corner[0][across], to = edge.corner[1][across];
    const auto box = edge.bounds();
    const double low = box.lower[across], high = box.upper[across];
    const double last = (std::min)(high, double(lattice.cells[across]) - 1);
    const auto add = [&](double line, bool separates, double s) {
        const std::array<double, 2> weights{1 - s, s};
        add_crossing(edge, weights, axis,
                     {std::uint32_t(line), separates, edge.coordinate(weights, axis), {}}, out);
    };
    for (double line = (std::max)(std::ceil(low), 0.0); line <= last; ++line) {
        if (from != to) {
            add(line, edge.separates && line < high, (line - from) / (to - from));
            continue;
        }
        // The edge is on the line: it crosses at its ends and at every node.
        const auto add_at = [&, first = edge.corner[0][axis], second = edge.corner[1][axis]](double x) {
            const double s = (x - first) / (second - first);
            const std::array<double, 2> weights{1 - s, s};
            add_crossing(edge, weights, axis, {std::uint32_t(line), false, x, {}}, out);
        };
        const double end = box.upper[axis];
        for (double x = box.lower[axis]; x < end; x = std::floor(x) + 1) add_at(x);
        add_at(end);
    }
}

/// A face projected along an axis. Its corners are rounded to 2⁻²⁰ of a cell, so that integers decide which
/// lattice lines cross the face. A line through an edge or a vertex is treated like a line shifted by an
/// infinitesimal offset, equal for all faces.
class FaceAcross {
public:
    /// `fraction` is the number of fractional bits of a coordinate. A coordinate has at most 30 bits, so
    /// that products fit into 61.
    FaceAcross(const PlacedFacet<3>& face, std::size_t axis, int fraction = 20) noexcept
        : face_(face)
        , fraction_(fraction) {
        const auto [u, v] = other_axes[axis];
        for (std::size_t k = 0; k < 3; ++k) {
            corners_[k] = {std::llround(face.corner[k][u] * double(one())),
                           std::llround(face.corner[k][v] * double(one()))};
        }
        area_ = side(corners_[0], corners_[1], corners_[2]);
    }

    /// Whether the projection is degenerate, so that no line crosses the face.
    bool is_edge_on() const noexcept { return area_ == 0; }
    bool crosses_line(std::int64_t x, std::int64_t y) const noexcept {
        return crosses({x * one(), y * one()});
    }
    /// Whether the line at a position in multiples of 2^-fraction crosses the face.
    bool crosses(const std::array<std::int64_t, 2>& p) const noexcept {
        const bool left = area_ > 0;
        return is_left(0, 1, p) == left && is_left(1, 2, p) == left && is_left(2, 0, p) == left;
    }
    /// Returns a range [first, last], within `count` lines along an axis of the projection, of all lines
    /// that cross the face.
    std::pair<std::int64_t, std::int64_t> lines(std::size_t k, std::size_t count) const noexcept {
        const auto [low, high] = std::minmax({corners_[0][k], corners_[1][k], corners_[2][k]});
        return {std::max<std::int64_t>((low + one() - 1) >> fraction_, 0),
                std::min<std::int64_t>(high >> fraction_, std::int64_t(count) - 1)};
    }

private:
    using Whole = std::array<std::int64_t, 2>;
    std::int64_t one() const noexcept { return std::int64_t{1} << fraction_; }

    /// Positive if `p` is to the left of the line from `a` to `b`.
    static std::int64_t side(const Whole& a, const Whole& b, const Whole& p) noexcept {
        return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    }
    /// Whether the edge from corner k to corner l has a line on its left. Both faces of the edge compute this
    /// for the same direction of the edge.
    bool is_left(std::size_t k, std::size_t l, const Whole& p) const noexcept {
        const bool reversed = face_.vertex[k] > face_.vertex[l];
        const auto &a = corners_[reversed ? l : k], &b = corners_[reversed ? k : l];
        std::int64_t s = side(a, b, p);
        // A wall includes its boundary on all sides.
        if (s == 0 && !face_.separates) return area_ > 0;
        // The line is on the edge. It is treated as shifted, along u far more than along v.
        if (s == 0) s = b[1] != a[1] ? a[1] - b[1] : b[0] - a[0];
        return (s > 0) != reversed;
    }

    const PlacedFacet<3>& face_;
    int fraction_;
    std::array<Whole, 3> corners_;
    std::int64_t area_; ///< twice the area
};

/// Adds the crossings of the lattice lines along an axis with a face.
inline void add_crossings(const PlacedFacet<3>& face, std::size_t axis, const Lattice<double, 3>& lattice,
                          Buffer<grid::Crossing<3>>& out) {
    const auto [u, v] = other_axes[axis];
    const FaceAcross across(face, axis);
    if (across.is_edge_on()) return;
    const auto [begin_x, end_x] = across.lines(0, lattice.cells[u]);
    const auto [begin_y, end_y] = across.lines(1, lattice.cells[v]);
    const auto box = face.bounds();
    for (auto y = begin_y; y <= end_y; ++y) {
        for (auto x = begin_x; x <= end_x; ++x) {
            if (!across.crosses_line(x, y)) continue;
            const auto w = weights_at(face, axis, double(x), double(y));
            if (!w) continue;
            const double position = std::clamp(face.coordinate(*w, axis), box.lower[axis], box.upper[axis]);
            const auto line = std::uint32_t(x) + std::uint32_t(lattice.cells[u]) * std::uint32_t(y);
            add_crossing(face, onto_facet(*w), axis, {line, face.separates, position, {}}, out);
        }
    }
}

} // namespace detail

/// Calls f(lower corner) for the cells within `slack` of an edge.
template <class F>
void for_each_cell(const PlacedFacet<2>& edge, double slack, F&& f) {
    const auto &a = edge.corner[0], &b = edge.corner[1];
    const auto box = edge.bounds();
    const double left = box.lower[0], right = box.upper[0];
    const auto height = [&](double x) {
        return b[0] == a[0] ? a[1] : a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
    };
    for (double x = std::floor(left - slack); x <= std::floor(right + slack); ++x) {
        double low = box.lower[1], high = box.upper[1];
        if (right - left > 2 * slack) {
            const double y0 = height(std::clamp(x - slack, left, right));
            const double y1 = height(std::clamp(x + 1 + slack, left, right));
            low = (std::min)(y0, y1);
            high = (std::max)(y0, y1);
        }
        for (double y = std::floor(low - slack); y <= std::floor(high + slack); ++y)
            f(std::array<std::int32_t, 2>{std::int32_t(x), std::int32_t(y)});
    }
}

/// Calls f(lower corner) for the cells within `slack` of a face, and for some other cells in the bounds of
/// the face.
template <class F>
void for_each_cell(const PlacedFacet<3>& face, double slack, F&& f) {
    const auto& [a, b, c] = face.corner;
    const auto box = face.bounds();
    const auto normal = cross(b - a, c - a);
    const double reach = (0.5 + slack) * (std::fabs(normal[0]) + std::fabs(normal[1]) + std::fabs(normal[2]));
    std::array<std::int32_t, 3> begin{}, end{}, low{};
    for (std::size_t k = 0; k < 3; ++k) {
        begin[k] = std::int32_t(std::floor(box.lower[k] - slack));
        end[k] = std::int32_t(std::floor(box.upper[k] + slack));
    }
    for (low[2] = begin[2]; low[2] <= end[2]; ++low[2]) {
        for (low[1] = begin[1]; low[1] <= end[1]; ++low[1]) {
            for (low[0] = begin[0]; low[0] <= end[0]; ++low[0]) {
                const auto middle = node_position<3>(low) + Vec<double, 3>{0.5, 0.5, 0.5};
                if (std::fabs(dot(normal, middle - a)) <= reach) f(low);
            }
        }
    }
}

} // namespace cageform::inline CAGEFORM_ABI
