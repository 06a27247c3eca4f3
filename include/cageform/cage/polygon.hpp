// The 2D cage, one or more closed polygons: its data, point location, and its check.
#pragma once

#include <cageform/cage/detail/boundary_value.hpp>
#include <cageform/cage/detail/facet_pairs.hpp>
#include <cageform/cage/types/report.hpp>
#include <cageform/core/detail/buffer.hpp>
#include <cageform/core/view.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A cage in the plane: closed loops of vertices. Outer loops and holes come in any order and
/// orientation; the even-odd rule decides what is inside. A loop is a run of consecutive vertices;
/// the edge from its last vertex to its first is implied.
///
/// Copies the vertices (a cage is small). Construction never fails; `check` reports whether the
/// polygon can serve as a cage, and every coordinate type calls it.
template <Scalar T>
class Polygon {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 2;

    struct Loop {
        std::size_t begin; ///< index of the first vertex
        std::size_t end;   ///< one past the last

        std::size_t size() const noexcept { return end - begin; }
        /// Calls `f(i, j)` for every edge, from vertex `i` to its successor `j`, in the order of
        /// the vertices.
        template <class F>
        void for_each_edge(F&& f) const {
            for (std::size_t i = begin; i < end; ++i) f(i, i + 1 < end ? i + 1 : begin);
        }
    };

    Polygon() = default;

    /// Makes a single loop.
    template <PointRange R>
        requires(range_dimension<R> == 2)
    explicit Polygon(const R& vertices)
        : Polygon(vertices, {}) {}

    /// Makes several loops of `loop_sizes[k]` vertices each, in the order of the vertices. Sizes
    /// that do not add up to the number of vertices are remembered, and `check` reports them.
    template <PointRange R>
        requires(range_dimension<R> == 2)
    Polygon(const R& vertices, std::span<const std::size_t> loop_sizes)
        : status_(detail::guard_memory([&] { return fill(vertices, loop_sizes); })) {
        if (status_ != Status::ok) *this = Polygon(status_);
    }

    /// Returns out_of_memory if the vertices did not fit in memory; the polygon is then empty.
    /// `check` reports it. (Copying throws, as copying a std::vector does.)
    Status status() const noexcept { return status_; }
    std::size_t size() const noexcept { return vertices_.size(); }
    std::span<const Vec<T, 2>> vertices() const noexcept { return vertices_; }
    const Vec<T, 2>& operator[](std::size_t i) const noexcept { return vertices_[i]; }
    std::span<const Loop> loops() const noexcept { return loops_; }
    bool loops_match() const noexcept { return loops_match_; }

    /// Calls `f(i, j)` for the edges of all loops.
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

/// Deduces the scalar from the points: `Polygon cage(points)` is a Polygon<double> for double
/// points.
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

namespace detail {

/// Counts the other loops that enclose loop `k`: an even number for an outer loop, odd for a hole.
/// Loops must not touch.
template <Scalar T>
std::size_t loop_depth(const Polygon<T>& polygon, std::size_t k) noexcept {
    const auto q = vec_cast<double>(polygon[polygon.loops()[k].begin]);
    std::size_t depth = 0;
    for (std::size_t other = 0; other < polygon.loops().size(); ++other) {
        if (other == k) continue;
        bool inside = false;
        polygon.loops()[other].for_each_edge([&](std::size_t i, std::size_t j) {
            const auto a = vec_cast<double>(polygon[i]), b = vec_cast<double>(polygon[j]);
            if (detail::crosses_ray(q, a, b)) inside = !inside;
        });
        depth += inside;
    }
    return depth;
}

/// Whether the inside of the polygon lies to the left of the edges of loop `k`, as it does for a
/// counter-clockwise outer loop and a clockwise hole. Loops must not touch. O(#V).
template <Scalar T>
bool inside_is_left(const Polygon<T>& polygon, std::size_t k) noexcept {
    return (signed_area(polygon, polygon.loops()[k]) > 0) == (detail::loop_depth(polygon, k) % 2 == 0);
}

} // namespace detail

/// A point on the boundary of a polygon: (1 − s) vertex[i] + s vertex[j].
template <Scalar T>
struct BoundaryPoint {
    std::size_t i = 0;
    std::size_t j = 0;
    T s = 0;            ///< in [0, 1]
    T distance = 0;     ///< to the query point
    Vec<T, 2> position; ///< of the boundary point
};

namespace detail {

/// Returns the point of edge (i, j) nearest to `p`. Interpolates from the nearer end, so that both
/// ends are reproduced exactly. `p` must be finite.
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

} // namespace detail

/// Returns the nearest point on the whole boundary. `p` must be finite and the polygon not empty.
/// O(#V).
template <Scalar T>
BoundaryPoint<T> nearest_on_boundary(const Polygon<T>& polygon, const Vec<T, 2>& p) noexcept {
    BoundaryPoint<T> best;
    polygon.for_each_edge([&](std::size_t i, std::size_t j) {
        const auto candidate = detail::nearest_on_edge(polygon, i, j, p);
        const bool first = best.i == best.j; // accepted as is: far away all distances may be infinite
        if (first || candidate.distance < best.distance) best = candidate;
    });
    return best;
}

/// Finds the boundary point nearest to a finite point; returns the boundary data there, which is
/// linear along the edges, and stores the point in `place`.
template <Scalar T>
BoundaryValue<2> nearest_boundary_value(const Polygon<T>& polygon, const Vec<T, 2>& p,
                                        Vec<T, 2>& place) noexcept {
    const auto q = nearest_on_boundary(polygon, p);
    place = q.position;
    return {{std::uint32_t(q.i), std::uint32_t(q.j)}, {1 - double(q.s), double(q.s)}};
}

/// Classifies a point by the even-odd rule. It is on the boundary if it lies within `tolerance` of
/// it (pass the cage's coincidence_tolerance); a NaN or infinite point is not_finite. O(#V).
///
/// Rounding can only confuse the sides of an edge closer to it than the tolerance, where the answer
/// is on_boundary anyway.
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
        if (std::fabs(cross(e, q - a)) <= reach &&
            detail::nearest_on_edge(polygon, i, j, p).distance <= tolerance)
            touches = true;
        if (detail::crosses_ray(q, a, b)) inside = !inside;
    });
    if (touches) return PointState::on_boundary;
    return inside ? PointState::inside : PointState::outside;
}

// ---- check --------------------------------------------------------------------------------------

namespace detail {

/// Checks the numbers of vertices, and that all are finite.
template <Scalar T>
void check_loops(const Polygon<T>& polygon, CageReport& report) {
    const auto loops = polygon.loops();
    if (!polygon.loops_match()) {
        std::size_t in_loops = 0;
        for (const auto& loop : loops) in_loops += loop.size();
        return report.add(CageFaultKind::loops_do_not_match, in_loops, polygon.size());
    }
    if (polygon.size() == 0) return report.add(CageFaultKind::too_few_vertices, 0, 0);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        if (!is_finite(polygon[i])) report.add(CageFaultKind::vertex_not_finite, i);
    }
    for (std::size_t k = 0; k < loops.size(); ++k) {
        if (loops[k].size() < 3) report.add(CageFaultKind::too_few_vertices, k, loops[k].size());
    }
}

/// Whether all vertices lie within tolerance of the line through the first vertex and the one
/// farthest from it.
inline bool is_flat_loop(std::span<const Facet<2>> edges, double tolerance) {
    const auto origin = edges[0].corner[0];
    Vec<double, 2> axis{0, 0};
    for (const auto& edge : edges) {
        const auto d = edge.corner[0] - origin;
        if (dot(d, d) > dot(axis, axis)) axis = d;
    }
    return std::all_of(edges.begin(), edges.end(), [&](const Facet<2>& edge) {
        return std::fabs(cross(axis, edge.corner[0] - origin)) <= tolerance * length(axis);
    });
}

inline void check_crossing_edges(std::span<const Facet<2>> edges, double tolerance, CageReport& report) {
    FacetPairs<2>(edges, {}, tolerance)
        .for_each([&](std::size_t m, std::size_t n) { return facets_touch(edges[m], edges[n], tolerance); },
                  [&](std::size_t m, std::size_t n) {
                      report.add(CageFaultKind::edges_cross, edges[m].vertex[0], edges[n].vertex[0]);
                  });
}

/// Warns of vertices whose two edges are collinear.
inline void check_collinear_vertices(std::span<const Facet<2>> edges, double tolerance, CageReport& report) {
    const Facet<2>* before = &edges.back();
    for (const auto& edge : edges) {
        const auto& from = before->corner[0];
        const auto along = edge.corner[1] - from;
        if (std::fabs(cross(along, edge.corner[0] - from)) <= tolerance * std::hypot(along[0], along[1]))
            report.add(CageFaultKind::collinear_vertex, edge.vertex[0]);
        before = &edge;
    }
}

/// Runs the steps of `check`.
template <Scalar T>
void check_polygon(const Polygon<T>& polygon, CageReport& report) {
    check_loops(polygon, report);
    if (report.status != Status::ok) return;

    const double tolerance = coincidence_tolerance(bounds_of(polygon.vertices()));
    Buffer<Facet<2>> edges; // edge i starts at vertex i
    for_each_facet(polygon, [&](const auto& edge) { edges.push_back({edge, polygon.vertices()}); });
    const auto edges_of = [&](std::size_t k) {
        return std::span(edges).subspan(polygon.loops()[k].begin, polygon.loops()[k].size());
    };
    for (const auto& edge : edges) {
        const auto e = edge.corner[1] - edge.corner[0];
        if (std::hypot(e[0], e[1]) <= tolerance)
            report.add(CageFaultKind::duplicate_vertices, edge.vertex[0], edge.vertex[1]);
    }
    for (std::size_t k = 0; k < polygon.loops().size(); ++k) {
        if (is_flat_loop(edges_of(k), tolerance)) report.add(CageFaultKind::no_area, k);
    }
    if (report.status != Status::ok) return;

    check_crossing_edges(edges, tolerance, report);
    if (report.status != Status::ok) return;

    for (std::size_t k = 0; k < polygon.loops().size(); ++k) {
        check_collinear_vertices(edges_of(k), tolerance, report);
        if (!detail::inside_is_left(polygon, k)) report.add(CageFaultKind::loop_turns_otherwise, k);
    }
}

} // namespace detail

/// Whether a polygon can serve as a cage: every loop has at least three vertices and an area,
/// consecutive vertices are apart, and no two edges touch except neighbours at their common vertex.
/// Vertices are apart if their distance exceeds the cage's coincidence_tolerance. Usually O(#V log
/// #V), O(#V²) at worst.
template <Scalar T>
CageReport check(const Polygon<T>& polygon) {
    return detail::report_on(polygon.status(),
                             [&](CageReport& report) { detail::check_polygon(polygon, report); });
}

} // namespace cageform::inline CAGEFORM_ABI
