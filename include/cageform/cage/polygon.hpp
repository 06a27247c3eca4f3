// The 2D cage: one or more closed polygons.
#pragma once

#include <cageform/core/view.hpp>

#include <cmath>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A cage in the plane: closed loops of vertices, outer loops and holes in any order and orientation
/// (inside is where the even-odd rule says so). A loop is a run of consecutive vertices; the edge from
/// its last vertex to its first is implied.
///
/// Copies the vertices (a cage is small). Construction never fails; `check` (cage/check.hpp) tells
/// whether the polygon can serve as a cage, and every coordinate type asks it.
template <Scalar T>
class Polygon {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 2;

    struct Loop {
        std::size_t begin; ///< index of the first vertex
        std::size_t end;   ///< one past the last
    };

    Polygon() = default;

    /// A single loop.
    template <PointRange R>
        requires(range_dimension<R> == 2)
    explicit Polygon(const R& vertices)
        : Polygon(vertices, {}) {}

    /// Several loops: `loop_sizes[k]` vertices each, in the order of the vertices. Sizes that do not add
    /// up to the number of vertices are remembered and reported by `check`.
    template <PointRange R>
        requires(range_dimension<R> == 2)
    Polygon(const R& vertices, std::span<const std::size_t> loop_sizes) {
        const std::size_t count = std::size(vertices);
        vertices_.reserve(count);
        for (std::size_t i = 0; i < count; ++i) vertices_.push_back(to_vec<T>(vertices[i]));
        if (loop_sizes.empty()) {
            loops_.push_back({0, count});
            return;
        }
        std::size_t begin = 0;
        for (const std::size_t size : loop_sizes) {
            loops_.push_back({begin, begin + size});
            loops_match_ = loops_match_ && begin <= count && size <= count - begin;
            begin += size;
        }
        loops_match_ = loops_match_ && begin == count;
    }

    std::size_t size() const noexcept { return vertices_.size(); }
    std::span<const Vec<T, 2>> vertices() const noexcept { return vertices_; }
    const Vec<T, 2>& operator[](std::size_t i) const noexcept { return vertices_[i]; }
    std::span<const Loop> loops() const noexcept { return loops_; }
    bool loops_match() const noexcept { return loops_match_; }

    /// Calls `f(i, j)` for every edge, from vertex `i` to its successor `j`, in the order of the vertices.
    template <class F>
    void for_each_edge(F&& f) const {
        for (const Loop& loop : loops_) {
            for (std::size_t i = loop.begin; i < loop.end; ++i) {
                f(i, i + 1 < loop.end ? i + 1 : loop.begin);
            }
        }
    }

private:
    std::vector<Vec<T, 2>> vertices_;
    std::vector<Loop> loops_;
    bool loops_match_ = true;
};

/// Deduces the scalar from the points: `Polygon cage(points)` is a Polygon<double> for double points.
template <PointRange R>
Polygon(const R&) -> Polygon<range_scalar_t<R>>;
template <PointRange R, class Sizes>
Polygon(const R&, const Sizes&) -> Polygon<range_scalar_t<R>>;

/// Axis-aligned bounds of points, empty (lower above upper) for none.
template <Scalar T, std::size_t D>
struct Bounds {
    Vec<T, D> lower;
    Vec<T, D> upper;

    /// Squared in double, so that no float overflows or vanishes.
    T diagonal() const noexcept {
        const auto d = vec_cast<double>(upper - lower);
        return static_cast<T>(std::sqrt(dot(d, d)));
    }
    /// The largest absolute coordinate: what the rounding of the coordinates is relative to.
    T magnitude() const noexcept {
        T m = 0;
        for (std::size_t k = 0; k < D; ++k)
            m = std::fmax(m, std::fmax(std::fabs(lower[k]), std::fabs(upper[k])));
        return m;
    }
};

template <Scalar T, std::size_t D>
Bounds<T, D> bounds_of(std::span<const Vec<T, D>> points) noexcept {
    Bounds<T, D> b;
    for (std::size_t k = 0; k < D; ++k) {
        b.lower[k] = std::numeric_limits<T>::max();
        b.upper[k] = std::numeric_limits<T>::lowest();
        for (const auto& p : points) {
            b.lower[k] = std::fmin(b.lower[k], p[k]);
            b.upper[k] = std::fmax(b.upper[k], p[k]);
        }
    }
    return b;
}

/// Two places of a cage nearer than this are one: eight roundings of its largest coordinate. Points this
/// near to a vertex or an edge are on it. In the units of the cage.
template <Scalar T, std::size_t D>
T coincidence_tolerance(const Bounds<T, D>& bounds) noexcept {
    return 8 * epsilon<T> * std::fmax(bounds.diagonal(), bounds.magnitude());
}

namespace detail {

template <std::size_t D>
double length(const Vec<double, D>& v) noexcept {
    return std::sqrt(dot(v, v));
}

/// Where on the segment from `a` to `b` the place nearest to `p` lies: 0 at a, 1 at b; 0 where both are one.
template <std::size_t D>
double part_of_segment(const Vec<double, D>& p, const Vec<double, D>& a, const Vec<double, D>& b) noexcept {
    const auto e = b - a;
    const double length2 = dot(e, e);
    return length2 > 0 ? std::fmin(std::fmax(dot(p - a, e) / length2, 0.0), 1.0) : 0.0;
}

/// The place of that segment nearest to `p`.
template <std::size_t D>
Vec<double, D> nearest_on_segment(const Vec<double, D>& p, const Vec<double, D>& a,
                                  const Vec<double, D>& b) noexcept {
    return a + part_of_segment(p, a, b) * (b - a);
}

} // namespace detail

/// A power of two that makes the diagonal at most 1: scaling by it is exact.
template <Scalar T, std::size_t D>
T unit_scale(const Bounds<T, D>& bounds) noexcept {
    int exponent = 0;
    std::frexp(bounds.diagonal(), &exponent);
    return std::ldexp(T(1), -exponent);
}

/// The signed area of a loop, positive when counter-clockwise (y up).
template <Scalar T>
double signed_area(const Polygon<T>& polygon, typename Polygon<T>::Loop loop) noexcept {
    double twice = 0;
    const auto origin = vec_cast<double>(polygon[loop.begin]);
    for (std::size_t i = loop.begin + 1; i + 1 < loop.end; ++i) {
        twice += cross(vec_cast<double>(polygon[i]) - origin, vec_cast<double>(polygon[i + 1]) - origin);
    }
    return twice / 2;
}

/// How many other loops enclose loop `k`: even for an outer loop, odd for a hole. Loops must not touch.
template <Scalar T>
std::size_t loop_depth(const Polygon<T>& polygon, std::size_t k) noexcept {
    const auto q = vec_cast<double>(polygon[polygon.loops()[k].begin]);
    std::size_t depth = 0;
    for (std::size_t other = 0; other < polygon.loops().size(); ++other) {
        if (other == k) continue;
        const auto& loop = polygon.loops()[other];
        bool inside = false;
        for (std::size_t i = loop.begin, j = loop.end - 1; i < loop.end; j = i++) {
            const auto a = vec_cast<double>(polygon[j]);
            const auto b = vec_cast<double>(polygon[i]);
            if ((a[1] > q[1]) != (b[1] > q[1]) && (cross(b - a, q - a) > 0) == (b[1] > a[1]))
                inside = !inside;
        }
        depth += inside;
    }
    return depth;
}

} // namespace cageform::inline CAGEFORM_ABI
