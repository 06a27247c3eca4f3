// make_cage in 2D: a loop of the cage between steps 3 and 5, the energy that relaxation lowers, and the
// obstacles of its edges.
#pragma once

#include <cageform/enclose/plane/contour.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A closed loop with the inside to its left. In a mirrored cage it may be the half with x >= 0: a chain with
/// both ends on the axis x = 0.
struct CageLoop {
    using Point = Vec<double, 2>;
    Loop points;
    bool half = false;

    std::size_t size() const noexcept { return points.size(); }
    std::size_t edge_count() const noexcept { return half ? size() - 1 : size(); }
    bool is_end(std::size_t i) const noexcept { return half && (i == 0 || i + 1 == size()); }
    /// Number of vertices of the whole loop.
    std::size_t whole_size() const noexcept { return half ? 2 * size() - 2 : size(); }
    std::size_t previous(std::size_t i) const noexcept { return i > 0 ? i - 1 : size() - 1; }
    std::size_t next(std::size_t i) const noexcept { return i + 1 < size() ? i + 1 : 0; }
    /// Neighbours of a vertex; at an end of a chain, one is the mirror image of the other.
    Point before(std::size_t i) const noexcept {
        return half && i == 0 ? mirrored(points[1]) : points[previous(i)];
    }
    Point after(std::size_t i) const noexcept {
        return half && i + 1 == size() ? mirrored(points[i - 1]) : points[next(i)];
    }
    static Point mirrored(const Point& p) noexcept { return {-p[0], p[1]}; }

    double perimeter() const noexcept {
        double sum = 0;
        for (std::size_t i = 0; i < edge_count(); ++i) sum += length(points[next(i)] - points[i]);
        return sum;
    }
};

/// Angle between two edges, in radians, in [0, pi].
inline double angle_between(const Vec<double, 2>& u, const Vec<double, 2>& v) noexcept {
    return std::atan2(std::fabs(cross(u, v)), dot(u, v));
}

/// Energy that relaxation lowers. It has terms for area, sharp angles, and short and long edges. It is
/// dimensionless; its weights were tuned on some hundred figures.
class LoopEnergy {
public:
    LoopEnergy(const CageLoop& contour, std::size_t vertices, double regular)
        : area_(std::fabs(signed_area(contour.points)))
        , length_(contour.perimeter() / double(vertices))
        , angle_weight_(0.03 * regular)
        , length_weight_(0.02 * regular) {}

    double of(const CageLoop& loop) const noexcept {
        double sum = signed_area(loop.points) / area_;
        for (std::size_t i = 0; i < loop.size(); ++i) sum += angle_term(loop, i);
        for (std::size_t i = 0; i < loop.edge_count(); ++i) sum += length_term(loop, i);
        return sum;
    }
    /// Sum of the terms that depend on vertex `i`.
    double about(const CageLoop& loop, std::size_t i) const noexcept {
        const std::size_t p = loop.previous(i), n = loop.next(i);
        const bool first = loop.half && i == 0, last = loop.half && i + 1 == loop.size();
        double sum = angle_term(loop, i);
        double twice_area = 0;
        if (!first) {
            sum += angle_term(loop, p) + length_term(loop, p);
            twice_area += cross(loop.points[p], loop.points[i]);
        }
        if (!last) {
            sum += angle_term(loop, n) + length_term(loop, i);
            twice_area += cross(loop.points[i], loop.points[n]);
        }
        return sum + twice_area / (2 * area_);
    }

private:
    double angle_term(const CageLoop& loop, std::size_t i) const noexcept {
        const auto u = loop.before(i) - loop.points[i], v = loop.after(i) - loop.points[i];
        const double along = dot(u, v);
        constexpr double wide = 1.05; // radians (60 degrees): larger angles cost nothing
        if (along <= 0 || along * along <= 0.247 * dot(u, u) * dot(v, v)) return 0; // cos(1.05)^2
        const double angle = angle_between(u, v), missing = (wide - angle) / wide;
        return angle < wide ? angle_weight_ * missing * missing * (1 + 4 * (std::max)(0.5 - angle, 0.0)) : 0;
    }
    double length_term(const CageLoop& loop, std::size_t i) const noexcept {
        const double t = length(loop.points[loop.next(i)] - loop.points[i]) / length_;
        const double is_short = (std::max)(0.5 - t, 0.0), is_tiny = (std::max)(0.15 - t, 0.0);
        return length_weight_ * (8 * is_short * is_short + 400 * is_tiny * is_tiny + 0.05 * t * t);
    }

    double area_;
    double length_; ///< mean edge length
    double angle_weight_;
    double length_weight_;
};

/// Obstacles of a loop: the figure, and other loops near a box that bounds the loop.
class Obstacles {
public:
    using Point = Vec<double, 2>;

    Obstacles(const DistanceLattice<2>& distances, double loop_margin, const Bounds<double, 2>& bounds)
        : lattice(&distances)
        , margin(loop_margin)
        , box_(bounds) {}

    void add(const CageLoop& other) {
        for (std::size_t i = 0; i < other.edge_count(); ++i)
            add(other.points[i], other.points[other.next(i)]);
        const auto& p = other.points[0];
        if (in_bounds(p)) marks_.push_back(p);
    }
    void add(const Point& a, const Point& b) {
        const Corners<2> edge{a, b};
        if (bounds_of(std::span<const Point>(edge)).overlaps(box_.widened(margin))) edges_.push_back(edge);
    }

    /// Marks a point inside the contour, so that the loop keeps enclosing it. Without a mark, a step could
    /// jump over a small part of the figure.
    void add_inside(const CageLoop& contour) {
        const double h = lattice->spacing();
        for (std::size_t i = 0; i < contour.edge_count(); ++i) {
            const Point &a = contour.points[i], &b = contour.points[contour.next(i)];
            const auto e = b - a;
            const double size = length(e);
            if (!(size > 0)) continue;
            const Point p = 0.5 * (a + b) + (h / size) * Point{-e[1], e[0]};
            if (lattice->value(p) > -0.5 * h) continue;
            marks_.push_back(p);
            return;
        }
    }

    /// True if a vertex may be at `p`.
    bool in_bounds(const Point& p) const noexcept { return box_.covers({p, p}); }
    /// True if another loop comes closer to the segment than `gap`.
    bool is_near_other(const Point& a, const Point& b, double gap) const noexcept {
        return std::any_of(edges_.begin(), edges_.end(), [&](const Corners<2>& edge) {
            return segments_near(a, b, edge[0], edge[1], gap);
        });
    }
    /// True if a triangle contains a mark. A vertex that crosses a mark would make the loop enclose another
    /// loop, or exclude its own part of the figure.
    bool any_mark_in(const Point& a, const Point& b, const Point& c) const noexcept {
        return std::any_of(marks_.begin(), marks_.end(), [&](const Point& p) {
            for (std::size_t k = 0; k < 2; ++k) { // a degenerate triangle covers only a segment of its line
                if (p[k] < (std::min)({a[k], b[k], c[k]}) || p[k] > (std::max)({a[k], b[k], c[k]}))
                    return false;
            }
            const double u = cross(b - a, p - a), v = cross(c - b, p - b), w = cross(a - c, p - c);
            return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
        });
    }
    /// True if two segments touch or are closer than `gap`.
    static bool segments_near(const Point& a, const Point& b, const Point& c, const Point& d,
                              double gap) noexcept {
        for (std::size_t k = 0; k < 2; ++k) {
            if ((std::max)(a[k], b[k]) + gap < (std::min)(c[k], d[k])) return false;
            if ((std::max)(c[k], d[k]) + gap < (std::min)(a[k], b[k])) return false;
        }
        return gap > 0 ? segment_distance(a, b, c, d) < gap : segments_touch(a, b, c, d);
    }

    const DistanceLattice<2>* lattice;
    double margin;

private:
    Bounds<double, 2> box_;
    std::vector<Corners<2>> edges_;
    std::vector<Point> marks_; ///< a vertex of each other loop, and a point inside this one
};

} // namespace cageform::inline CAGEFORM_ABI::detail
