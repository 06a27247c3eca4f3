// The formula of mean value weights in 3D.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/cage/detail/shells.hpp>
#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/coordinates/mean_value/frame.hpp>
#include <cageform/core/types/buffer.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <>
struct MeanValueTopology<3> {
    std::vector<std::array<std::uint32_t, 3>> facets;    ///< counter-clockwise seen from outside
    Buffer<std::array<std::uint32_t, 3>> edges_of_facet; ///< edge k is opposite to corner k
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;

    std::size_t edge_count() const noexcept { return edges.size(); }

    MeanValueTopology() = default;
    template <Scalar T>
    explicit MeanValueTopology(const TriangleMesh<T>& mesh)
        : facets(detail::outward_faces(mesh)) {
        using Edge = std::pair<std::uint32_t, std::uint32_t>;
        const auto opposite = [](const auto& facet, std::size_t k) -> Edge {
            return std::minmax(facet[(k + 1) % 3], facet[(k + 2) % 3]);
        };
        for (const auto& facet : facets) {
            for (std::size_t k = 0; k < 3; ++k) edges.push_back(opposite(facet, k));
        }
        sort_unique(edges);
        for (const auto& facet : facets) {
            auto& numbers = edges_of_facet.push_back();
            for (std::size_t k = 0; k < 3; ++k) {
                const auto edge = std::lower_bound(edges.begin(), edges.end(), opposite(facet, k));
                numbers[k] = std::uint32_t(edge - edges.begin());
            }
        }
    }
};

template <class S>
struct MeanValueFrame<S, 3> {
    struct Edge {
        Vec<S, 3> origin, direction; ///< the direction is of unit length
        S length;
    };
    struct Face {
        std::array<std::uint32_t, 3> corner, edge; ///< edge k is opposite to corner k
        Vec<S, 3> normal;                          ///< n, outward, of unit length
        S offset;                                  ///< n·corner
        std::array<Vec<S, 3>, 3> across;           ///< ν_k: outward normal of edge k in the plane
        std::array<S, 3> across_offset;            ///< ν_k·(a point of edge k)
        std::array<S, 3> inverse_altitude;         ///< 1/h_k
        std::array<S, 3> cosine;                   ///< ν_l·ν_m, l and m the edges other than k
    };
    Buffer<Edge> edges;
    Buffer<Face> faces;

    MeanValueFrame() = default;
    MeanValueFrame(const MeanValueTopology<3>& topology, const Buffer<Vec<Precise<S>, 3>>& at) {
        edges.reserve(topology.edges.size());
        for (const auto& [i, j] : topology.edges) {
            const auto along = at[j] - at[i];
            edges.push_back({vec_cast<S>(at[i]), vec_cast<S>(unit(along)), S(std::sqrt(dot(along, along)))});
        }
        faces.reserve(topology.facets.size());
        for (std::size_t f = 0; f < topology.facets.size(); ++f) {
            Face& face = faces.push_back();
            face.corner = topology.facets[f];
            face.edge = topology.edges_of_facet[f];
            measure(face, {at[face.corner[0]], at[face.corner[1]], at[face.corner[2]]});
        }
    }

private:
    using Point = Vec<Precise<S>, 3>;

    static Point unit(const Point& v) noexcept { return (1 / std::sqrt(dot(v, v))) * v; }

    static void measure(Face& face, const std::array<Point, 3>& c) noexcept {
        const auto normal = unit(cross(c[1] - c[0], c[2] - c[0]));
        face.normal = vec_cast<S>(normal);
        face.offset = static_cast<S>(dot(normal, c[0]));
        std::array<Point, 3> across;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
            across[k] = unit(cross(c[m] - c[l], normal));
            face.across[k] = vec_cast<S>(across[k]);
            face.across_offset[k] = static_cast<S>(dot(across[k], c[l]));
            face.inverse_altitude[k] = static_cast<S>(1 / dot(across[k], c[l] - c[k]));
        }
        for (std::size_t k = 0; k < 3; ++k)
            face.cosine[k] = static_cast<S>(dot(across[(k + 1) % 3], across[(k + 2) % 3]));
    }
};

template <class X, class S>
X inner(const Vec<S, 3>& a, const Vec<X, 3>& b) noexcept {
    return X(a[0]) * b[0] + (X(a[1]) * b[1] + X(a[2]) * b[2]);
}

/// The lower limit of divisors, which keeps quotients finite.
template <class S>
inline constexpr S least_divisor = (std::numeric_limits<S>::min)() * S(1e6);

/// Returns whether a point lies beyond the ends of an edge: both ends are on the same side of the point's
/// foot on the edge's line, and more than 10 √rr from the foot. √rr is the distance of the point from the
/// line. Each term of the series in r/begin and r/end then adds two digits.
template <class U>
bool is_beyond_ends(const U& rr, const U& begin, const U& end) noexcept {
    using K = ValueOf<U>;
    return U(K(0)) < begin * end && K(100) * rr < begin * begin && K(100) * rr < end * end;
}

/// Returns G of `angle_over_distance`, G = −2 dg/d(R²), from the series g = Σ_k (−1)^k/(2k + 1) R^2k
/// (begin^−(2k+1) − end^−(2k+1)).
template <class X>
X radial_beyond_ends(X rr, X begin, X end) noexcept {
    constexpr int terms = sizeof(X) > 8 ? 10 : 8;
    X b_power = 1 / begin, e_power = 1 / end, power = 2, sum = 0;
    for (int k = 1; k <= terms + 1; ++k) {
        b_power /= begin * begin;
        e_power /= end * end;
        sum += X(k % 2 == 0 ? -k : k) / X(2 * k + 1) * (power * (b_power - e_power));
        power *= rr;
    }
    return sum;
}

/// An edge relative to a point p: the vector u from p to the start, the direction t of the edge, and the
/// distance R of p from its line. `begin` and `end` are the positions of the ends on the line, from the foot
/// of p.
template <class X, class S>
struct RelativeEdge {
    Vec<X, 3> u, t;
    X length, begin, end, rr, r;

    RelativeEdge(const typename MeanValueFrame<S, 3>::Edge& edge, const Vec<X, 3>& p) noexcept
        : u{X(edge.origin[0]) - p[0], X(edge.origin[1]) - p[1], X(edge.origin[2]) - p[2]}
        , t{X(edge.direction[0]), X(edge.direction[1]), X(edge.direction[2])}
        , length(edge.length)
        , begin(inner(u, t))
        , end(begin + length) {
        const auto c = cross(u, t);
        rr = (max)(inner(c, c), X(least_divisor<S>));
        r = sqrt(rr);
    }
    /// Sine and cosine of the angle θ that the edge subtends at p, times the distances of both ends.
    X sine() const noexcept { return r * length; }
    X cosine() const noexcept { return rr + begin * end; }
};

/// Returns g = θ/R of an edge: the integral of 1/distance² along it. With its direction τ, the vector R⃗ from
/// p to its foot on the line, and the distances a, b of the ends from p:
///
///   ∇g = τ (1/a² − 1/b²) + R⃗ G,   G = (g + end/b² − begin/a²)/R²
template <class N, class S>
N angle_over_distance(const typename MeanValueFrame<S, 3>::Edge& edge, const Vec<ValueOf<N>, 3>& p) noexcept {
    using X = ValueOf<N>;
    const RelativeEdge<X, S> seen(edge, p);
    const X g = angle(seen.sine(), seen.cosine()) / seen.r;
    if constexpr (has_gradient<N>) {
        const auto& [u, t, length, begin, end, rr, r] = seen;
        const X ends = length / ((rr + begin * begin) * (rr + end * end));
        const X axial = (begin + end) * ends;
        X radial = (g + (rr - begin * end) * ends) / rr;
        if constexpr (std::is_floating_point_v<X>) {
            if (is_beyond_ends(rr, begin, end)) radial = radial_beyond_ends(rr, begin, end);
        }
        Vec<X, 3> slope;
        for (std::size_t k = 0; k < 3; ++k) slope[k] = t[k] * axial + (u[k] - begin * t[k]) * radial;
        return {g, slope};
    } else {
        return g;
    }
}

/// Computes g of all edges. For SIMD registers, quotients and arctangents are separate loops, which are short
/// enough for a processor to overlap several edges.
template <class N, class S>
void angles_over_distances(const Buffer<typename MeanValueFrame<S, 3>::Edge>& edges,
                           const Vec<ValueOf<N>, 3>& p, std::vector<N>& g) noexcept {
    if constexpr (!has_gradient<N> && !std::is_floating_point_v<N>) {
        constexpr std::size_t most = 32;
        Lanes<S> quotient[most], offset[most], distance[most];
        for (std::size_t first = 0; first < edges.size(); first += most) {
            const std::size_t count = (std::min)(most, edges.size() - first);
            for (std::size_t e = 0; e < count; ++e) {
                const RelativeEdge<N, S> seen(edges[first + e], p);
                const AngleTerms<S> terms(seen.sine(), seen.cosine());
                (terms.numerator / terms.denominator).store(quotient[e]);
                terms.offset.store(offset[e]);
                seen.r.store(distance[e]);
            }
            for (std::size_t e = 0; e < count; ++e) {
                const N z = N::load(quotient[e]);
                g[first + e] = (z * atan_over(z * z) + N::load(offset[e])) / N::load(distance[e]);
            }
        }
    } else {
        for (std::size_t e = 0; e < edges.size(); ++e) g[e] = angle_over_distance<N, S>(edges[e], p);
    }
}

/// Returns the linear function offset − normal·p, or the same function from its value at p.
template <class N, class S>
N linear(const ValueOf<N>& value, const Vec<S, 3>& normal) noexcept {
    using X = ValueOf<N>;
    return with_gradient<N, 3>(value, {X(-normal[0]), X(-normal[1]), X(-normal[2])});
}
template <class N, class S>
N linear(S offset, const Vec<S, 3>& normal, const Vec<ValueOf<N>, 3>& p) noexcept {
    return linear<N>(ValueOf<N>(offset) - inner(normal, p), normal);
}

/// Returns (g ρ − φ)/H² of an edge of a face. φ is the signed angle that the edge subtends at the foot of p
/// in the plane; `begin` and `end` are the positions of its ends along its line.
template <class U>
U angle_beside_face(const U& height, const U& rho, const U& begin, const U& end) noexcept {
    using std::atan;
    using K = ValueOf<U>;
    const U zero(K(0)), one(K(1)), rr = rho * rho, distance2 = rr + height * height;
    if (is_beyond_ends(distance2, begin, end)) { // series of g and φ, divided by H²
        const U b = one / begin, e = one / end;
        U b_power = b, e_power = e, powers = one, rho_power = one, sum = zero;
        constexpr int terms = sizeof(K) == 8 ? 8 : 10;
        for (int i = 1; i <= terms; ++i) {
            b_power = b_power * (b * b);
            e_power = e_power * (e * e);
            sum += (K(i % 2 == 0 ? 1 : -1) / K(2 * i + 1)) * (powers * (b_power - e_power));
            rho_power = rho_power * rr;
            powers = distance2 * powers + rho_power;
        }
        return rho * sum;
    }
    const U r = abs(rho), distance = sqrt(distance2);
    const auto antiderivative = [&](const U& t) { // (atan(t/R) − atan(t/r))/H²
        const U d = r * distance + t * t;
        if (!(zero < d)) return zero;
        const U x = t * height * height / ((r + distance) * d);
        // Below 1e-3 the next term of the series of atan(x)/x, x⁶/7, is below rounding.
        const U slope =
            K(1e-3) < abs(value_of(x)) ? atan(x) / x : one - x * x * (U(K(1) / K(3)) - K(0.2) * (x * x));
        return -(t * slope / ((r + distance) * d));
    };
    const U seen = angle(r * (end - begin), rr + begin * end); // from the foot
    const U sign(rho < zero ? K(-1) : K(1));
    return (rho / distance) * (antiderivative(end) - antiderivative(begin)) -
           sign * (seen / (distance * (r + distance)));
}

/// Returns S of a face that p is not over. Then Σ φ_k = 0, so S = ½ H Σ (g_k ρ_k − φ_k)/H², which is accurate
/// next to the plane, where Σ g_k ρ_k cancels. `rho` must be the values from which the caller decided that p
/// is not over the face: recomputed values may round differently, and Σ φ_k would then be 2π.
template <class U, class S>
CAGEFORM_DETAIL_NO_INLINE U sum_beside_face(const typename MeanValueFrame<S, 3>::Face& face, const U& height,
                                            const std::array<U, 3>& rho) noexcept {
    using K = ValueOf<U>;
    U sum(K(0));
    for (std::size_t k = 0; k < 3; ++k) {
        // Returns the position of the common corner with edge `other` along edge k, from both distances.
        const auto along = [&](std::size_t other, K cosine) {
            const K sine = std::sqrt((max)(K(0), (1 - cosine) * (1 + cosine)));
            return (1 / sine) * (rho[other] - cosine * rho[k]);
        };
        const std::size_t l = (k + 1) % 3, n = (k + 2) % 3;
        const U begin = -along(n, K(face.cosine[l])), end = along(l, K(face.cosine[n]));
        sum += height * angle_beside_face(height, rho[k], begin, end);
    }
    return K(0.5) * sum;
}

/// Replaces `s` by `sum_beside_face` in the lanes of `beside`, one by one.
template <class N, class S>
CAGEFORM_DETAIL_NO_INLINE void set_beside_face(N& s, const typename Simd<S>::Mask& beside,
                                               const typename MeanValueFrame<S, 3>::Face& face,
                                               const N& height, const std::array<N, 3>& rho) noexcept {
    using One = std::conditional_t<has_gradient<N>, Dual<double, 3>, double>;
    constexpr std::size_t components = 1 + NumberTraits<N>::derivatives;
    Lanes<S> flags, heights, rhos[3], lanes[components];
    select(beside, Simd<S>(S(1)), Simd<S>(S(0))).store(flags);
    value_of(height).store(heights);
    for (std::size_t k = 0; k < 3; ++k) value_of(rho[k]).store(rhos[k]);
    for (std::size_t k = 0; k < components; ++k) NumberTraits<N>::component(s, k).store(lanes[k]);
    for (std::size_t lane = 0; lane < lane_count<S>; ++lane) {
        if (flags[lane] == S(0)) continue;
        std::array<One, 3> across;
        for (std::size_t k = 0; k < 3; ++k) across[k] = linear<One>(double(rhos[k][lane]), face.across[k]);
        const One sum =
            sum_beside_face<One, S>(face, linear<One>(double(heights[lane]), face.normal), across);
        for (std::size_t k = 0; k < components; ++k)
            lanes[k][lane] = static_cast<S>(NumberTraits<One>::component(sum, k));
    }
    for (std::size_t k = 0; k < components; ++k) NumberTraits<N>::component(s, k) = Simd<S>::load(lanes[k]);
}

/// Returns the weights that a face adds to its corners. Sets `special` in lanes next to the face.
template <class N, class S>
std::array<N, 3> face_weights(const typename MeanValueFrame<S, 3>::Face& face, const std::array<N, 3>& g,
                              const MeanValueLimits<S>& limits, const Vec<ValueOf<N>, 3>& p,
                              ValueOf<N>& special) noexcept {
    using X = ValueOf<N>;
    const X zero(S(0)), one(S(1)), half(S(0.5)), least(least_divisor<S>);
    const N height = linear<N>(face.offset, face.normal, p);
    std::array<N, 3> rho, w;
    N height_times_s = zero; // S is the sum of the corners' weights
    for (std::size_t k = 0; k < 3; ++k) {
        rho[k] = linear<N>(face.across_offset[k], face.across[k], p);
        height_times_s = height_times_s + g[k] * rho[k];
    }
    height_times_s = half * height_times_s;
    const X distance = abs(value_of(height));
    const X inmost = (min)(value_of(rho[0]), (min)(value_of(rho[1]), value_of(rho[2])));
    special =
        select(both(distance <= X(limits.near_distance), X(-limits.near_distance) <= inmost), one, special);
    const X near_plane = X(limits.beside) * (max)(one, -inmost);
    const auto beside = both(distance < near_plane, both(inmost < zero, value_of(height_times_s) < half));
    N s = height_times_s / select(distance <= least, N(least), height);
    if constexpr (std::is_floating_point_v<X>) {
        if (beside) s = sum_beside_face<N, S>(face, height, rho);
    } else if (any(beside)) {
        set_beside_face<N, S>(s, beside, face, height, rho);
    }
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t l = (k + 1) % 3, n = (k + 2) % 3;
        const N across_sum = g[k] + (X(face.cosine[n]) * g[l] + X(face.cosine[l]) * g[n]);
        w[k] = X(face.inverse_altitude[k]) * (s * rho[k] + half * (height * across_sum));
    }
    return w;
}

/// Computes g of all edges and clears the weights. Returns 1 in lanes that are too far away, else 0.
template <class N, class S>
ValueOf<N> start_weights(const MeanValueFrame<S, 3>& cage, const MeanValueLimits<S>& limits,
                         const Vec<ValueOf<N>, 3>& p, WeightRows<N>& rows) noexcept {
    using X = ValueOf<N>;
    const X zero(S(0)), one(S(1));
    angles_over_distances<N, S>(cage.edges, p, rows.edges);
    for (N& w : rows.weights) w = zero;
    return select(X(limits.far_distance * limits.far_distance) < inner(p, p), one, zero);
}

/// Returns g of the three edges of a face.
template <class N, class S>
std::array<N, 3> angles_at(const typename MeanValueFrame<S, 3>::Face& face,
                           const WeightRows<N>& rows) noexcept {
    return {rows.edges[face.edge[0]], rows.edges[face.edge[1]], rows.edges[face.edge[2]]};
}

/// Adds the weights of a face to its corners.
template <class N, class S>
void add_triangle(const typename MeanValueFrame<S, 3>::Face& face, const MeanValueLimits<S>& limits,
                  const Vec<ValueOf<N>, 3>& p, ValueOf<N>& special, WeightRows<N>& rows) noexcept {
    const auto w = face_weights<N, S>(face, angles_at<N, S>(face, rows), limits, p, special);
    for (std::size_t k = 0; k < 3; ++k) rows.weights[face.corner[k]] += w[k];
}

/// Computes the unnormalised weights of MeanValueCoordinates in 3D.
template <class N, class S>
WeightSum<N> compute_weights(const MeanValueFrame<S, 3>& cage, const MeanValueLimits<S>& limits,
                             const Vec<ValueOf<N>, 3>& p, WeightRows<N>& rows) noexcept {
    auto special = start_weights<N, S>(cage, limits, p, rows);
    for (const auto& face : cage.faces) add_triangle<N, S>(face, limits, p, special, rows);
    return {rows.sum(), special};
}

} // namespace cageform::inline CAGEFORM_ABI::detail
