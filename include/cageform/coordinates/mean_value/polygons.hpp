// The formula of mean value weights in 3D for faces with any number of corners.
#pragma once

#include <cageform/cage/detail/flat_face.hpp>
#include <cageform/coordinates/detail/face_coordinates.hpp>
#include <cageform/coordinates/mean_value/evaluation.hpp>
#include <cageform/coordinates/mean_value/plane.hpp>
#include <cageform/coordinates/mean_value/space.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T, std::size_t D, class Cage>
class MeanValueCoordinates; // in coordinates/mean_value.hpp

namespace detail {

/// The connectivity of the triangles, and the planar faces with more than three corners.
struct PolygonTopology : MeanValueTopology<3> {
    struct Polygon {
        std::vector<std::uint32_t> corners;
        std::pair<std::size_t, std::size_t> triangles; ///< [first, second)
        Vec<double, 3> u, v;                           ///< axes of the plane
        MeanValueTopology<2> plane;
    };
    std::vector<Polygon> polygons;
    std::vector<std::size_t> triangles; ///< triangular faces and triangles of fans
    std::size_t most_corners = 0;       ///< the largest number of corners of a polygon

    PolygonTopology() = default;
    template <Scalar T>
    explicit PolygonTopology(const PolyhedralMesh<T>& mesh)
        : MeanValueTopology<3>(mesh.triangles()) {
        std::size_t next = 0;
        for (std::size_t f = 0; f < mesh.face_count(); ++f) {
            const auto loop = mesh.face(f);
            if (loop.size() < 4 || mesh.is_fan(f)) continue;
            const FacePlane plane = plane_of(mesh, f);
            polygons.push_back({{loop.begin(), loop.end()},
                                mesh.triangles_of(f),
                                plane.u,
                                plane.v,
                                MeanValueTopology<2>(flat_face(mesh, f, plane))});
            most_corners = (std::max)(most_corners, loop.size());
            for (; next < polygons.back().triangles.first; ++next) triangles.push_back(next);
            next = polygons.back().triangles.second;
        }
        for (; next < facets.size(); ++next) triangles.push_back(next);
    }
};

template <class S>
struct PolygonFrame : MeanValueFrame<S, 3> {
    using Point = Vec<S, 2>;
    struct Polygon {
        std::vector<std::uint32_t> corners;
        std::pair<std::size_t, std::size_t> triangles;
        std::vector<std::array<Point, 3>> corners_of_triangle; ///< in the plane of the polygon
        MeanValueFrame<S, 2> plane;
        Point lower, upper; ///< bounds of the corners
    };
    std::vector<Polygon> polygons;
    std::vector<std::size_t> triangles;

    PolygonFrame() = default;
    PolygonFrame(const PolygonTopology& topology, const Buffer<Vec<Precise<S>, 3>>& at)
        : MeanValueFrame<S, 3>(topology, at)
        , triangles(topology.triangles) {
        for (const auto& of : topology.polygons) {
            const auto u = vec_cast<Precise<S>>(of.u), v = vec_cast<Precise<S>>(of.v);
            const auto flat = [&](std::uint32_t i) {
                const auto d = at[i] - at[of.corners[0]];
                return Vec<Precise<S>, 2>{dot(d, u), dot(d, v)};
            };
            Buffer<Vec<Precise<S>, 2>> corners;
            Point lower{}, upper{}; // corner 0, which is the origin
            for (const std::uint32_t i : of.corners) {
                const auto position = vec_cast<S>(corners.push_back(flat(i)));
                for (std::size_t k = 0; k < 2; ++k) {
                    lower[k] = (std::min)(lower[k], position[k]);
                    upper[k] = (std::max)(upper[k], position[k]);
                }
            }
            std::vector<std::array<Point, 3>> of_triangles;
            for (std::size_t t = of.triangles.first; t < of.triangles.second; ++t) {
                const auto& [a, b, c] = topology.facets[t];
                of_triangles.push_back({vec_cast<S>(flat(a)), vec_cast<S>(flat(b)), vec_cast<S>(flat(c))});
            }
            polygons.push_back(
                {of.corners, of.triangles, std::move(of_triangles), {of.plane, corners}, lower, upper});
        }
    }
};

/// Scratch memory of the formula, and of the formula in a polygon's plane.
template <class N>
struct PolygonRows : WeightRows<N> {
    using InPlane = std::conditional_t<has_gradient<N>, Dual<ValueOf<N>, 2>, N>;
    WeightRows<InPlane> in_plane;
    ValueOf<N> special{}; ///< as in WeightSum

    PolygonRows(const PolygonTopology& topology, std::size_t handles)
        : WeightRows<N>(topology, handles)
        , in_plane(MeanValueTopology<2>(), topology.most_corners) {}
};

/// Computes the 2D weights at a point on the polygon's boundary: linear along the nearest edge.
template <class N, class S>
N compute_weights_on_edge(const MeanValueFrame<S, 2>& plane, const Vec<S, 2>& x,
                          WeightRows<N>& rows) noexcept {
    S least = (std::numeric_limits<S>::max)(), fraction = 0;
    std::size_t nearest = 0;
    const std::size_t count = plane.corners.size();
    const auto edge_of = [&](std::size_t i) {
        return plane.corners[(i + 1) % count].position - plane.corners[i].position;
    };
    for (std::size_t i = 0; i < count; ++i) {
        const auto e = edge_of(i), d = x - plane.corners[i].position;
        const S t = std::clamp(dot(d, e) / dot(e, e), S(0), S(1));
        const auto off = d - t * e;
        if (!(dot(off, off) < least)) continue;
        least = dot(off, off);
        fraction = t;
        nearest = i;
    }
    for (N& w : rows.weights) w = N(S(0));
    rows.weights[nearest] = N(1 - fraction);
    rows.weights[(nearest + 1) % count] = rows.weights[(nearest + 1) % count] + N(fraction);
    return N(S(1));
}

/// The sum of the weights of a polygon's corners, and the weighted mean of the corners in its plane.
template <class N>
struct PolygonMean {
    N sum;
    std::array<N, 2> position;
};

/// Computes the mean from the triangles of a polygon, whose weights satisfy Σ w_k (C_k − p) = m (see
/// MeanValueCoordinates). Sum and mean therefore do not depend on the triangulation.
template <class N, class S>
PolygonMean<N> mean_of(const PolygonFrame<S>& cage, const typename PolygonFrame<S>::Polygon& polygon,
                       const MeanValueLimits<S>& limits, const Vec<ValueOf<N>, 3>& p,
                       PolygonRows<N>& rows) noexcept {
    using X = ValueOf<N>;
    const X one(S(1)), zero(S(0));
    N sum = zero;
    std::array<N, 2> x{N(zero), N(zero)};
    for (std::size_t t = polygon.triangles.first; t < polygon.triangles.second; ++t) {
        const auto& face = cage.faces[t];
        const auto w = face_weights<N, S>(face, angles_at<N, S>(face, rows), limits, p, rows.special);
        const auto& corner = polygon.corners_of_triangle[t - polygon.triangles.first];
        for (std::size_t k = 0; k < 3; ++k) {
            sum += w[k];
            for (std::size_t axis = 0; axis < 2; ++axis) x[axis] += X(corner[k][axis]) * w[k];
        }
    }
    const auto vanishes = abs(value_of(sum)) <= X(least_divisor<S>); // next to the face, in its plane
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const X low(polygon.lower[axis]), high(polygon.upper[axis]);
        x[axis] = x[axis] / select(vanishes, N(one), sum);
        // Clamps rounding errors, which are large if the sum is small.
        x[axis] = select(value_of(x[axis]) < low, N(low), x[axis]);
        x[axis] = select(high < value_of(x[axis]), N(high), x[axis]);
    }
    return {sum, x};
}

/// Distributes the weights of a face with more than three corners. Let s be the sum of its triangles' weights
/// and x = Σ w_k C_k / s, a point of the face's convex hull. Corner i gets s μ_i(x), where μ are the mean
/// value coordinates in the face's plane, so Σ s μ_i(x) (C_i − p) = s (x − p) = m, as for triangles. Langer,
/// Belyaev, Seidel (Spherical barycentric coordinates, SGP 2006, sec. 4) also distribute m, but by spherical
/// coordinates around the direction of m.
template <class N, class S>
void distribute(const PolygonMean<N>& mean, const typename PolygonFrame<S>::Polygon& polygon,
                const MeanValueLimits<S>& limits, PolygonRows<N>& rows) noexcept {
    using X = ValueOf<N>;
    const auto& [sum, x] = mean;
    rows.in_plane.weights.resize(polygon.corners.size());
    const auto extent = polygon.upper - polygon.lower;
    const S size = extent[0] + extent[1];
    const MeanValueLimits<S> in_plane{
        (std::max)(limits.near_distance, 16 * std::numeric_limits<S>::epsilon() * size),
        std::sqrt((std::numeric_limits<S>::max)()) * S(0.5), S(0)};
    const Vec<X, 2> at{value_of(x[0]), value_of(x[1])};
    auto [total, near_edge] = compute_weights(polygon.plane, in_plane, at, rows.in_plane);
    if constexpr (std::is_floating_point_v<X>) {
        if (near_edge != 0) total = compute_weights_on_edge(polygon.plane, at, rows.in_plane);
    } else {
        rows.special = select(X(S(0)) < near_edge, X(S(1)), rows.special);
    }
    for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
        const auto mu = rows.in_plane.weights[i] / total;
        N weight = value_of(mu);
        if constexpr (has_gradient<N>)
            weight.gradient = mu.gradient[0] * x[0].gradient + mu.gradient[1] * x[1].gradient;
        rows.weights[polygon.corners[i]] += sum * weight;
    }
}

/// Computes the unnormalised weights of the vertices and of the means of fans.
template <class N, class S>
WeightSum<N> compute_weights(const PolygonFrame<S>& cage, const MeanValueLimits<S>& limits,
                             const Vec<ValueOf<N>, 3>& p, PolygonRows<N>& rows) noexcept {
    rows.special = start_weights<N, S>(cage, limits, p, rows);
    for (const std::size_t t : cage.triangles)
        add_triangle<N, S>(cage.faces[t], limits, p, rows.special, rows);
    for (const auto& polygon : cage.polygons)
        distribute<N, S>(mean_of<N, S>(cage, polygon, limits, p, rows), polygon, limits, rows);
    return {rows.sum(), rows.special};
}

/// The types of the formula for a PolyhedralMesh. `Plane` is a parameter because 2D MeanValueCoordinates are
/// still incomplete here.
template <Scalar T, class Plane>
struct PolygonForm {
    using Topology = PolygonTopology;
    template <class S>
    using Frame = PolygonFrame<S>;
    template <class N>
    using Rows = PolygonRows<N>;
    using Data = FaceCoordinates<Plane>;

    static Data data(const PolyhedralMesh<T>& mesh) {
        return Data(mesh, [](const Polygon<double>& polygon) { return Plane(polygon); });
    }
};
template <Scalar T>
struct MeanValueForm<PolyhedralMesh<T>> : PolygonForm<T, MeanValueCoordinates<double, 2, Polygon<double>>> {};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
