// The 2D cage, one or more closed polygons: its data, point location, and its check.
#pragma once

#include <cageform/cage/types/boundary_value.hpp>
#include <cageform/cage/types/report.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/core/view.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI {

/// A 2D cage of closed vertex loops. Outer loops and holes may have any order and orientation; the even-odd
/// rule decides what is inside. A loop is a range of consecutive vertices; the edge from its last vertex to
/// its first is implied.
///
/// Copies the vertices. Construction never fails; `check` reports whether the polygon is a valid cage, and
/// every coordinate type calls it.
template <Scalar T>
class Polygon {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 2;

    struct Loop {
        std::size_t begin; ///< index of the first vertex
        std::size_t end;   ///< one past the last

        std::size_t size() const noexcept { return end - begin; }
        /// Calls `f(i, j)` for every edge in order, from vertex `i` to the next vertex `j`.
        template <class F>
        void for_each_edge(F&& f) const {
            for (std::size_t i = begin; i < end; ++i) f(i, i + 1 < end ? i + 1 : begin);
        }
    };

    Polygon() = default;

    template <PointRange R>
        requires(range_dimension<R> == 2)
    explicit Polygon(const R& vertices)
        : Polygon(vertices, {}) {}

    /// Makes several loops of `loop_sizes[k]` vertices each, in the order of the vertices. `check` reports
    /// sizes that do not add up to the number of vertices.
    template <PointRange R>
        requires(range_dimension<R> == 2)
    Polygon(const R& vertices, std::span<const std::size_t> loop_sizes)
        : status_(detail::guard_memory([&] { return fill(vertices, loop_sizes); })) {
        if (status_ != Status::ok) *this = Polygon(status_);
    }

    /// Returns ok, or out_of_memory if the vertices did not fit in memory. The polygon is then empty, and
    /// `check` reports this status. Copying may throw.
    Status status() const noexcept { return status_; }
    std::size_t size() const noexcept { return vertices_.size(); }
    std::span<const Vec<T, 2>> vertices() const noexcept { return vertices_; }
    const Vec<T, 2>& operator[](std::size_t i) const noexcept { return vertices_[i]; }
    std::span<const Loop> loops() const noexcept { return loops_; }
    bool loops_match() const noexcept { return loops_match_; }

    template <class F>
    void for_each_edge(F&& f) const {
        for (const Loop& loop : loops_) loop.for_each_edge(f);
    }

private:
    explicit Polygon(Status status) noexcept
        : status_(status) {}

    template <class R>
    Status fill(const R& vertices, std::span<const std::size_t> loop_sizes) {
        const std::size_t count = std::size(vertices);
        vertices_.reserve(count);
        for (std::size_t i = 0; i < count; ++i) vertices_.push_back(to_vec<T>(vertices[i]));
        if (loop_sizes.empty()) {
            loops_.push_back({0, count});
            return Status::ok;
        }
        std::size_t begin = 0;
        for (const std::size_t size : loop_sizes) {
            loops_.push_back({begin, begin + size});
            loops_match_ = loops_match_ && begin <= count && size <= count - begin;
            begin += size;
        }
        loops_match_ = loops_match_ && begin == count;
        return Status::ok;
    }

    std::vector<Vec<T, 2>> vertices_;
    Buffer<Loop> loops_;
    bool loops_match_ = true;
    Status status_ = Status::ok; // declared last: its initialiser fills the other members
};

/// Deduces the scalar: `Polygon cage(points)` is a Polygon<double> for points of double.
template <PointRange R>
Polygon(const R&) -> Polygon<range_scalar_t<R>>;
template <PointRange R, class Sizes>
Polygon(const R&, const Sizes&) -> Polygon<range_scalar_t<R>>;

/// Calls f(edge) with arrays of vertices.
template <Scalar T, class F>
void for_each_facet(const Polygon<T>& polygon, F&& f) {
    polygon.for_each_edge([&](std::size_t i, std::size_t j) {
        f(std::array<std::uint32_t, 2>{std::uint32_t(i), std::uint32_t(j)});
    });
}

/// Returns the signed area of a loop, positive if it is counter-clockwise (y up).
template <Scalar T>
double signed_area(const Polygon<T>& polygon, typename Polygon<T>::Loop loop) noexcept {
    double twice = 0;
    const auto origin = vec_cast<double>(polygon[loop.begin]);
    for (std::size_t i = loop.begin + 1; i + 1 < loop.end; ++i) {
        twice += cross(vec_cast<double>(polygon[i]) - origin, vec_cast<double>(polygon[i + 1]) - origin);
    }
    return twice / 2;
}

// ---- inside -------------------------------------------------------------------------------------

/// A point on the boundary of a polygon: (1 − s) vertex[i] + s vertex[j].
template <Scalar T>
struct BoundaryPoint {
    std::size_t i = 0;
    std::size_t j = 0;
    T s = 0;            ///< in [0, 1]
    T distance = 0;     ///< to the query point
    Vec<T, 2> position; ///< of the boundary point
};

/// Returns the point of edge (i, j) nearest to `p`. Interpolates from the nearer end, so both ends are
/// exact. `p` must be finite.
template <Scalar T>
BoundaryPoint<T> nearest_on_edge(const Polygon<T>& polygon, std::size_t i, std::size_t j,
                                 const Vec<T, 2>& p) noexcept {
    const auto a = vec_cast<double>(polygon[i]);
    const auto b = vec_cast<double>(polygon[j]);
    const auto q = vec_cast<double>(p);
    const auto e = b - a;
    const double length2 = dot(e, e);
    const double from_a = length2 > 0 ? dot(q - a, e) / length2 : 0;
    const double from_b = length2 > 0 ? dot(b - q, e) / length2 : 1;
    const double s = from_a <= 0.5 ? std::fmax(from_a, 0.0) : std::fmin(1 - from_b, 1.0);
    const auto x = s <= 0.5 ? a + s * e : b - std::fmax(from_b, 0.0) * e;
    return {i, j, static_cast<T>(s), static_cast<T>(std::hypot(x[0] - q[0], x[1] - q[1])), vec_cast<T>(x)};
}

/// Returns the nearest point of the boundary. `p` must be finite and the polygon not empty. O(#V).
template <Scalar T>
BoundaryPoint<T> nearest_on_boundary(const Polygon<T>& polygon, const Vec<T, 2>& p) noexcept {
    BoundaryPoint<T> best;
    polygon.for_each_edge([&](std::size_t i, std::size_t j) {
        const auto candidate = nearest_on_edge(polygon, i, j, p);
        // The first edge is always accepted, because far away all distances may be infinite.
        const bool first = best.i == best.j;
        if (first || candidate.distance < best.distance) best = candidate;
    });
    return best;
}

/// Returns the boundary data, linear along edges, at the nearest boundary point, and stores that point in
/// `position`. `p` must be finite.
template <Scalar T>
BoundaryValue<2> nearest_boundary_value(const Polygon<T>& polygon, const Vec<T, 2>& p,
                                        Vec<T, 2>& position) noexcept {
    const auto q = nearest_on_boundary(polygon, p);
    position = q.position;
    return {{std::uint32_t(q.i), std::uint32_t(q.j)}, {1 - double(q.s), double(q.s)}};
}

/// Classifies a point by the even-odd rule: on_boundary within `tolerance` of the boundary (pass the cage's
/// coincidence_tolerance), not_finite for NaN and infinity. Rounding errors affect only points within the
/// tolerance, which are on_boundary. O(#V).
template <Scalar T>
PointState locate(const Polygon<T>& polygon, const Vec<T, 2>& p, T tolerance) noexcept {
    if (!is_finite(p)) return PointState::not_finite;
    bool inside = false;
    bool touches = false;
    const auto q = vec_cast<double>(p);
    polygon.for_each_edge([&](std::size_t i, std::size_t j) {
        const auto a = vec_cast<double>(polygon[i]);
        const auto b = vec_cast<double>(polygon[j]);
        const auto e = b - a;
        const double reach = tolerance * (std::fabs(e[0]) + std::fabs(e[1]));
        if (std::fabs(cross(e, q - a)) <= reach && nearest_on_edge(polygon, i, j, p).distance <= tolerance)
            touches = true;
        if (detail::crosses_ray(q, a, b)) inside = !inside;
    });
    if (touches) return PointState::on_boundary;
    return inside ? PointState::inside : PointState::outside;
}

// ---- check --------------------------------------------------------------------------------------

/// Checks whether a polygon is a valid cage. Every loop must have at least three vertices and an area.
/// Consecutive vertices must be farther apart than the cage's coincidence_tolerance. No two edges may touch,
/// except neighbours at their common vertex. Usually O(#V log #V), O(#V²) at worst.
template <class T>
CageReport check(const Polygon<T>& polygon);

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/cage/detail/check_polygon.impl.hpp>
#endif
