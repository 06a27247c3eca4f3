// The formula of Green coordinates in 3D, for SIMD registers of points.
#pragma once

#include <cageform/coordinates/green/frame.hpp>
#include <cageform/coordinates/mean_value/space.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class S>
struct GreenFrame<S, 3> {
    struct Edge {
        std::uint32_t from, to;
        Vec<S, 3> direction; ///< of unit length
        S length;
    };
    using Face = typename MeanValueFrame<S, 3>::Face;
    Buffer<Vec<S, 3>> vertices;
    Buffer<Edge> edges;
    Buffer<Face> faces;
    Buffer<S> inverse_size; ///< per face, 1/√area

    GreenFrame() = default;
    GreenFrame(const MeanValueTopology<3>& topology, const Buffer<Vec<double, 3>>& at, double) {
        Buffer<Vec<Precise<S>, 3>> positions;
        for (const auto& v : at) {
            vertices.push_back(vec_cast<S>(v));
            positions.push_back(vec_cast<Precise<S>>(v));
        }
        const MeanValueFrame<S, 3> frame(topology, positions);
        faces = frame.faces;
        for (std::size_t e = 0; e < frame.edges.size(); ++e) {
            const auto [from, to] = topology.edges[e];
            edges.push_back({from, to, frame.edges[e].direction, frame.edges[e].length});
        }
        for (const auto& [a, b, c] : topology.facets) {
            const auto n = cross(at[b] - at[a], at[c] - at[a]);
            inverse_size.push_back(S(1 / std::sqrt(length(n) / 2)));
        }
    }
};

template <class S>
struct GreenRows<S, 3> {
    using X = Simd<S>;
    struct Corner {
        Vec<X, 3> u; ///< C − p
        X r;         ///< |u|
    };
    /// An edge from A to B relative to the points: q, the nearest point of its line; s₁ = A·τ, s₂ = B·τ; f,
    /// the integral of 1/r along the edge; touched, 1 for points on the edge, else 0.
    struct Edge {
        Vec<X, 3> q;
        X qq, begin, end, f, touched;
    };
    std::vector<Corner> corners;
    std::vector<Edge> edges;

    explicit GreenRows(const GreenFrame<S, 3>& frame)
        : corners(frame.vertices.size())
        , edges(frame.edges.size()) {}
};

template <class S>
Simd<S> product(const Vec<Simd<S>, 3>& a, const Vec<S, 3>& b) noexcept {
    using X = Simd<S>;
    return a[0] * X(b[0]) + (a[1] * X(b[1]) + a[2] * X(b[2]));
}

/// Computes the vectors from the points to all vertices.
template <class S>
void find_corners(const GreenFrame<S, 3>& cage, const Vec<Simd<S>, 3>& p, GreenRows<S, 3>& seen) noexcept {
    for (std::size_t i = 0; i < cage.vertices.size(); ++i) {
        auto& [u, r] = seen.corners[i];
        for (std::size_t k = 0; k < 3; ++k) u[k] = Simd<S>(cage.vertices[i][k]) - p[k];
        r = sqrt(u[0] * u[0] + (u[1] * u[1] + u[2] * u[2]));
    }
}

/// Computes the data of an edge for both its faces. Next to the edge, the angles of the two faces are
/// sensitive to rounding of q, but their sum is not if both use the same q. q is computed from the nearer end
/// and projected twice, so that its error is relative to its own length.
template <bool gradients, class S>
void find_edge(const typename GreenFrame<S, 3>::Edge& edge, S near_distance, GreenRows<S, 3>& seen,
               typename GreenRows<S, 3>::Edge& out) noexcept {
    using X = Simd<S>;
    const X zero(S(0)), one(S(1)), reach(near_distance), length(edge.length), least(least_square<S>);
    const auto &a = seen.corners[edge.from], &b = seen.corners[edge.to];
    const auto from_a = a.r <= b.r;
    for (std::size_t k = 0; k < 3; ++k) out.q[k] = select(from_a, a.u[k], b.u[k]);
    X along = product(out.q, edge.direction);
    for (std::size_t k = 0; k < 3; ++k) out.q[k] = out.q[k] - along * X(edge.direction[k]);
    const X rest = product(out.q, edge.direction);
    for (std::size_t k = 0; k < 3; ++k) out.q[k] = out.q[k] - rest * X(edge.direction[k]);
    along = along + rest;
    out.begin = select(from_a, along, along - length);
    out.end = select(from_a, along + length, along);
    out.qq = out.q[0] * out.q[0] + (out.q[1] * out.q[1] + out.q[2] * out.q[2]);
    const auto on_line = both(out.qq <= reach * reach, both(out.begin <= zero, zero <= out.end));
    const auto on_edge = on_line | ((min)(a.r, b.r) <= reach);
    out.touched = select(on_edge, one, zero);
    // f diverges at the edge, but weights contain f times a distance. Derivatives use f at a distance of 1e-6
    // diagonals.
    const auto at_least = [&](const X& x, S step) {
        return (max)(x, gradients ? select(on_edge, X(step), least) : least);
    };
    const auto ahead = zero <= out.begin, past = out.end <= zero;
    const X a_beyond = a.r - out.begin, b_beyond = b.r + out.end;
    const X over = select(ahead, b_beyond, select(past, a_beyond, a_beyond * b_beyond));
    const X under = select(ahead, at_least(a.r + out.begin, S(0x1p-20)),
                           select(past, at_least(b.r - out.end, S(0x1p-20)), at_least(out.qq, S(0x1p-40))));
    out.f = log(over / under);
}

/// Returns the contribution of an edge to the solid angle of a face, with the sign of ρ: a difference of two
/// angles. The first is the angle of the edge, seen from the foot of p in the face's plane: from atan(s₁/ρ)
/// to atan(s₂/ρ).
/// The second is from atan(|H| s₁/(ρ A)) to atan(|H| s₂/(ρ B)). A and B are the distances of the ends from p.
/// The difference at each end is one arctangent:
///
///   atan2(ρ s₂, D + |H| B) − atan2(ρ s₁, D + |H| A),   D = ρ² + H²
///
/// Both are combined into one angle. If s₁ and s₂ have the same sign, s₂ A − s₁ B is computed as
/// D L (s₁ + s₂)/(s₂ A + s₁ B).
///
///   height  |H|
template <class S>
Simd<S> edge_angle(const typename GreenFrame<S, 3>::Edge& edge, const GreenRows<S, 3>& seen,
                   const typename GreenRows<S, 3>::Edge& line, const Simd<S>& height,
                   const Simd<S>& rho) noexcept {
    using X = Simd<S>;
    const X &a = seen.corners[edge.from].r, &b = seen.corners[edge.to].r, &s1 = line.begin, &s2 = line.end;
    const X zero(S(0)), one(S(1)), length(edge.length);
    const auto beyond = zero < s1 * s2;
    const X factor = select(beyond, abs(s2 * a + s1 * b), one);
    const X cross_term = select(beyond, line.qq * length * abs(s1 + s2), s2 * a - s1 * b);
    const X y = rho * (length * line.qq * factor + height * cross_term);
    const X x = factor * ((line.qq + height * a) * (line.qq + height * b) + rho * rho * s1 * s2);
    const X size = angle(abs(y), x + X(least_square<S>));
    return select(rho < zero, zero - size, size);
}

/// Returns the unsigned solid angle of a face by a single arctangent, inaccurate next to the lines of edges.
/// van Oosterom, Strackee, IEEE Trans. Biomed. Eng. 30 (1983). `height` is |H|.
template <class S>
Simd<S> angle_off_edges(const typename GreenFrame<S, 3>::Face& face, const GreenFrame<S, 3>& cage,
                        const GreenRows<S, 3>& seen, const Simd<S>& height) noexcept {
    using X = Simd<S>;
    X x(S(1));
    for (const std::uint32_t c : face.corner) x *= seen.corners[c].r;
    for (std::size_t k = 0; k < 3; ++k) { // the edge is opposite the corner
        const auto& edge = seen.edges[face.edge[k]];
        x += (edge.qq + edge.begin * edge.end) * seen.corners[face.corner[k]].r;
    }
    const X twice_area(cage.edges[face.edge[0]].length / face.inverse_altitude[0]);
    return X(S(2)) * angle(height * twice_area, x);
}

/// The integrals of a face: H, the height of its plane above the points; ρ_k, the signed distances of the
/// points' feet from its edges, positive inside; f_k of its edges; and the solid angle Ω, zero for points on
/// the face.
///
///   quick  whether Ω may have an error of 1e-10 (in double)
template <class S, bool quick = false>
struct FaceIntegrals {
    using X = Simd<S>;
    X height, rho[3], f[3], angle, touched;

    FaceIntegrals(const typename GreenFrame<S, 3>::Face& face, const GreenFrame<S, 3>& cage,
                  const GreenRows<S, 3>& seen, S near_distance) noexcept {
        const X zero(S(0)), one(S(1)), reach(near_distance);
        const typename GreenRows<S, 3>::Edge* edges[3];
        for (std::size_t k = 0; k < 3; ++k) {
            edges[k] = &seen.edges[face.edge[k]];
            rho[k] = product(edges[k]->q, face.across[k]);
            f[k] = edges[k]->f;
        }
        height = product(edges[0]->q, face.normal); // relative to the nearest edge
        X least = edges[0]->qq;
        for (std::size_t k = 1; k < 3; ++k) {
            const auto nearer = edges[k]->qq < least;
            height = select(nearer, product(edges[k]->q, face.normal), height);
            least = select(nearer, edges[k]->qq, least);
        }
        const X size = abs(height);
        angle = zero;
        X beside(S(quick ? 0 : 1)); // positive where Ω must be computed exactly, next to an edge's line
        if constexpr (quick) {
            angle = angle_off_edges(face, cage, seen, size);
            for (std::size_t k = 0; k < 3; ++k) {
                const X r =
                    seen.corners[face.corner[(k + 1) % 3]].r + seen.corners[face.corner[(k + 2) % 3]].r;
                beside = (max)(beside, r * r - X(S(1e8)) * edges[k]->qq);
            }
        }
        if (any(zero < beside)) {
            X exact = zero;
            for (std::size_t k = 0; k < 3; ++k)
                exact += edge_angle<S>(cage.edges[face.edge[k]], seen, *edges[k], size, rho[k]);
            angle = select(zero < beside, exact, angle);
        }
        const X inmost = (min)(rho[0], (min)(rho[1], rho[2]));
        touched = (max)(edges[0]->touched, (max)(edges[1]->touched, edges[2]->touched));
        touched = select(both(size <= reach, zero <= inmost), one, touched);
        angle = select(zero < touched, zero, select(height < zero, zero - angle, angle));
    }
    /// Returns Σ_l (ν_k·ν_l) f_l.
    X across(const typename GreenFrame<S, 3>::Face& face, std::size_t k) const noexcept {
        const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
        return f[k] + (X(face.cosine[m]) * f[l] + X(face.cosine[l]) * f[m]);
    }
};

/// Computes the coordinates of Lipman, Levin, Cohen-Or: Green Coordinates (ACM Trans. Graph. 27, 2008), from
/// integrals over the faces in each face's own frame. ν_k is the outward normal of edge k in the face's
/// plane, h_k the altitude of corner k:
///
///   4π h_k φ_k += ρ_k Ω + H Σ_l (ν_k·ν_l) f_l,   4π ψ = Σ_k ρ_k f_k − H Ω
///
/// The derivatives of Ω and f cancel between the two faces of an edge and are left out (n × ν_k/h_k is the
/// vortex sheet of the hat function; Biot and Savart):
///
///   4π h_k ∇φ_k += −(Ω ν_k + n Σ_l (ν_k·ν_l) f_l),   4π ∇ψ = Ω n − Σ_l f_l ν_l
///
/// ψ is divided by the handle's length √area. `rows` must be zero on entry.
template <bool gradients, class S>
GreenSum<S> integrate(const GreenFrame<S, 3>& cage, S near_distance, const Vec<Simd<S>, 3>& p,
                      GreenRows<S, 3>& seen, Lanes<S>* rows) noexcept {
    using X = Simd<S>;
    constexpr S full = S(4 * 3.14159265358979323846);
    const std::size_t vertices = cage.vertices.size(), handles = vertices + cage.faces.size();
    find_corners(cage, p, seen);
    for (std::size_t e = 0; e < cage.edges.size(); ++e)
        find_edge<gradients>(cage.edges[e], near_distance, seen, seen.edges[e]);
    X angles(S(0)), touched(S(0));
    for (std::size_t j = 0; j < cage.faces.size(); ++j) {
        const auto& face = cage.faces[j];
        const FaceIntegrals<S> of(face, cage, seen, near_distance);
        angles += of.angle;
        touched = (max)(touched, of.touched);
        const X size(cage.inverse_size[j] / full);
        X normal = of.height * of.angle; // for ψ
        Vec<X, 3> slope;
        for (std::size_t axis = 0; axis < 3; ++axis) slope[axis] = of.angle * X(face.normal[axis]);
        for (std::size_t k = 0; k < 3; ++k) {
            const X across = of.across(face, k);
            const X share(face.inverse_altitude[k] / full);
            if constexpr (gradients) {
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const X v(face.across[k][axis]);
                    add(-(share * (of.angle * v + across * X(face.normal[axis]))),
                        rows[axis * handles + face.corner[k]]);
                    slope[axis] = slope[axis] - of.f[k] * v;
                }
            } else {
                add(share * (of.rho[k] * of.angle + of.height * across), rows[face.corner[k]]);
                normal = normal - of.rho[k] * of.f[k];
            }
        }
        if constexpr (gradients) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                (size * slope[axis]).store(rows[axis * handles + vertices + j]);
        } else {
            (-(size * normal)).store(rows[vertices + j]);
        }
    }
    return {X(1 / full) * angles, touched};
}

} // namespace cageform::inline CAGEFORM_ABI::detail
