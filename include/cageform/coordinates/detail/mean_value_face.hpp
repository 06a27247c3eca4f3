// What one face of a mesh adds to mean value weights in space, and what is known of faces and edges beforehand.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>

#include <array>
#include <cmath>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The edges and faces of a mesh in numbers, moved by −origin and then scaled. Faces turn outwards.
template <class S>
struct MeshFrame {
    struct Edge {
        Vec<S, 3> origin, direction; ///< a unit vector
        S length;
    };
    struct Face {
        std::array<std::uint32_t, 3> corner, edge; ///< edge k is opposite to corner k
        Vec<S, 3> normal;                          ///< outward, of unit length
        S offset;                                  ///< normal · corner
        std::array<Vec<S, 3>, 3> across;           ///< ν_k: outward, in the plane
        std::array<S, 3> across_offset;
        std::array<S, 3> inverse_altitude;
        std::array<S, 3> cosine; ///< ν_l·ν_m, l and m the edges other than k
    };
    std::vector<Edge> edges;
    std::vector<Face> faces;
};

/// Worked out in double.
template <class S, Scalar T>
MeshFrame<S> frame_of(const TriangleMesh<T>& mesh, const Vec<T, 3>& origin, T scale) {
    MeshFrame<S> frame;
    std::vector<std::pair<std::uint64_t, std::uint32_t>> numbers;
    std::vector<Vec<double, 3>> at;
    for (const auto& v : mesh.vertices())
        at.push_back(double(scale) * (vec_cast<double>(v) - vec_cast<double>(origin)));
    const auto unit = [](const Vec<double, 3>& v) { return (1 / length(v)) * v; };
    for (const auto& corners : mesh.faces()) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [i, j] = std::minmax(corners[(k + 1) % 3], corners[(k + 2) % 3]);
            numbers.push_back({(std::uint64_t(i) << 32) | j, 0});
        }
    }
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    for (auto& [key, number] : numbers) {
        number = std::uint32_t(frame.edges.size());
        const auto a = at[key >> 32], b = at[key & 0xFFFFFFFFu];
        frame.edges.push_back({vec_cast<S>(a), vec_cast<S>(unit(b - a)), static_cast<S>(length(b - a))});
    }
    for (const auto& corners : outward_faces(mesh)) {
        typename MeshFrame<S>::Face face;
        face.corner = corners;
        const std::array<Vec<double, 3>, 3> c{at[corners[0]], at[corners[1]], at[corners[2]]};
        const auto normal = unit(cross(c[1] - c[0], c[2] - c[0]));
        face.normal = vec_cast<S>(normal);
        face.offset = static_cast<S>(dot(normal, c[0]));
        std::array<Vec<double, 3>, 3> across;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
            const auto [i, j] = std::minmax(corners[l], corners[m]);
            const auto number = std::lower_bound(numbers.begin(), numbers.end(),
                                                 std::pair((std::uint64_t(i) << 32) | j, std::uint32_t{0}));
            face.edge[k] = number->second;
            across[k] = unit(cross(c[m] - c[l], normal));
            face.across[k] = vec_cast<S>(across[k]);
            face.across_offset[k] = static_cast<S>(dot(across[k], c[l]));
            face.inverse_altitude[k] = static_cast<S>(1 / dot(across[k], c[l] - c[k]));
        }
        for (std::size_t k = 0; k < 3; ++k)
            face.cosine[k] = static_cast<S>(dot(across[(k + 1) % 3], across[(k + 2) % 3]));
        frame.faces.push_back(face);
    }
    return frame;
}

/// (g ρ − φ)/H² of an edge, φ the signed angle it is seen under from the foot point: those angles sum to zero outside the
/// face, so the sum of g ρ is the sum of these differences, and they are had without any. `U` is the scalar or a Dual of
/// `K`.
template <class U, class K>
U beside_face(const U& height, const std::array<U, 3>& rho, std::size_t k,
              const std::array<K, 3>& cosine) noexcept {
    using std::atan;
    using std::atan2;
    using std::fabs;
    using std::sqrt;
    // Where the edge's ends lie along it, from the foot point: by the distances to the edges that meet there.
    const std::size_t l = (k + 1) % 3, n = (k + 2) % 3;
    const auto along = [&](std::size_t other, K c) { // of the corner that edges k and `other` share
        const K sine = std::sqrt(std::fmax(K(0), (1 - c) * (1 + c)));
        return (rho[other] - c * rho[k]) / sine;
    };
    const U end = along(l, cosine[n]), begin = -along(n, cosine[l]);
    const U rr = rho[k] * rho[k], far2 = rr + height * height;
    // Near the edge's line, beyond its ends: the series of both arctangents in R/t and ρ/t, of which the H² is taken out.
    if (begin * end > U(0) && K(100) * far2 < begin * begin && K(100) * far2 < end * end) {
        const U b = U(K(1)) / begin, e = U(K(1)) / end;
        U b_power = b, e_power = e, powers = U(K(1)), rho_power = U(K(1)), sum{};
        constexpr int terms = sizeof(K) == 8 ? 8 : 10;
        for (int i = 1; i <= terms; ++i) {
            b_power = b_power * (b * b);
            e_power = e_power * (e * e);
            sum += (K(i % 2 == 0 ? 1 : -1) / K(2 * i + 1)) * (powers * (b_power - e_power));
            rho_power = rho_power * rr;
            powers = far2 * powers + rho_power;
        }
        return rho[k] * sum;
    }
    const U r = fabs(rho[k]), far = sqrt(far2);
    const auto part = [&](const U& t) { // (atan(t/R) − atan(t/r))/H²
        const U d = r * far + t * t;
        if (!(d > U(0))) return U(0);
        const U x = t * height * height / ((r + far) * d);
        const U slope =
            fabs(x) > U(K(1e-3)) ? atan(x) / x : U(K(1)) - x * x * (U(K(1) / K(3)) - K(0.2) * (x * x));
        return -(t * slope / ((r + far) * d));
    };
    const U seen = atan2(r * (end - begin), rr + begin * end); // from the foot point
    const K sign = rho[k] < U(0) ? K(-1) : K(1);
    return (rho[k] / far) * (part(end) - part(begin)) - sign * (seen / (far * (r + far)));
}

/// The weights of a face's corners by the formula of MeanValueCoordinates<T, 3>. `beside`: p lies next to the face's plane
/// and does not face it. `U` is the scalar or a Dual of `K`.
template <class U, class K>
std::array<U, 3> face_weights(const U& height, const std::array<U, 3>& rho, const std::array<U, 3>& g,
                              const std::array<K, 3>& altitude, const std::array<K, 3>& cosine,
                              bool beside) noexcept {
    U s{};
    if (beside) {
        for (std::size_t k = 0; k < 3; ++k)
            s += K(0.5) * (height * beside_face<U, K>(height, rho, k, cosine));
    } else if (height == U(0)) { // on the face, where weights are not made of this
        return {};
    } else {
        s = K(0.5) * (g[0] * rho[0] + g[1] * rho[1] + g[2] * rho[2]) / height;
    }
    std::array<U, 3> w;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t l = (k + 1) % 3, n = (k + 2) % 3;
        w[k] = (s * rho[k] + K(0.5) * (height * (g[k] + cosine[n] * g[l] + cosine[l] * g[n]))) / altitude[k];
    }
    return w;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
