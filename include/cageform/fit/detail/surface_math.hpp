// Points, normals and rims of triangles in any dimension.
#pragma once

#include <cageform/cage/detail/mesh_face.hpp>
#include <cageform/cage/types/facet.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the point of a triangle nearest to `p`, as barycentric weights, in any dimension.
template <std::size_t N>
std::array<double, 3> nearest_on_triangle(const Vec<double, N>& p,
                                          const std::array<Vec<double, N>, 3>& corner) noexcept {
    const auto b = corner[1] - corner[0], c = corner[2] - corner[0], d = p - corner[0];
    const double bb = dot(b, b), bc = dot(b, c), cc = dot(c, c), bd = dot(b, d), cd = dot(c, d);
    const double area2 = bb * cc - bc * bc;
    if (area2 > 1e-14 * bb * cc) {
        const double v = (cc * bd - bc * cd) / area2, w = (bb * cd - bc * bd) / area2;
        if (v >= 0 && w >= 0 && v + w <= 1) return {1 - v - w, v, w};
    }
    std::array<double, 3> best{1, 0, 0};
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t l = (k + 1) % 3;
        const double s = segment_parameter(p, corner[k], corner[l]);
        const auto e = corner[k] + s * (corner[l] - corner[k]) - p;
        if (!(dot(e, e) < least)) continue;
        least = dot(e, e);
        best = {0, 0, 0};
        best[k] = 1 - s;
        best[l] = s;
    }
    return best;
}

/// A position and κ times a normal, as one point in six dimensions.
inline Vec<double, 6> with_normal(const Vec<double, 3>& p, const Vec<double, 3>& n, double kappa) noexcept {
    return {p[0], p[1], p[2], kappa * n[0], kappa * n[1], kappa * n[2]};
}

/// Returns a quantile of numbers; 0 for none. Changes their order.
inline double quantile(std::vector<double>& of, double share) {
    if (of.empty()) return 0;
    const auto at = of.begin() + std::ptrdiff_t(share * double(of.size() - 1));
    std::nth_element(of.begin(), at, of.end());
    return *at;
}

/// Returns a radius of search slightly above a squared distance. So rounding of the distances of boxes does
/// not exclude items at the same distance, and the result does not depend on the order of the search.
inline double with_ties(double distance2) noexcept {
    return (1 + 1e-12) * distance2;
}

/// Returns a vector of length 1, or zero.
inline Vec<double, 3> unit_or_zero(const Vec<double, 3>& v) noexcept {
    const double square = dot(v, v);
    return square > 0 ? (1 / std::sqrt(square)) * v : Vec<double, 3>{};
}

/// Returns the point of a triangle with given barycentric weights.
template <std::size_t N>
Vec<double, N> point_of(const std::array<double, 3>& weights,
                        const std::array<Vec<double, N>, 3>& corner) noexcept {
    return weights[0] * corner[0] + (weights[1] * corner[1] + weights[2] * corner[2]);
}

/// A sphere about a triangle: a cheap test before the exact distance.
template <std::size_t N>
class TriangleSphere {
public:
    explicit TriangleSphere(const std::array<Vec<double, N>, 3>& corner) noexcept
        : centre_(point_of({1.0 / 3, 1.0 / 3, 1.0 / 3}, corner)) {
        for (const auto& c : corner) radius_ = (std::max)(radius_, std::sqrt(dot(c - centre_, c - centre_)));
    }
    /// Whether the triangle is surely farther from a point than a squared distance. Ties are not.
    bool is_beyond(const Vec<double, N>& p, double distance2) const noexcept {
        const auto e = p - centre_;
        const double outer = (1 + 1e-9) * (std::sqrt(distance2) + radius_);
        return dot(e, e) > outer * outer;
    }

private:
    Vec<double, N> centre_;
    double radius_ = 0;
};

/// Returns the normals of the vertices: the normalised sums of the area vectors of their faces.
inline std::vector<Vec<double, 3>> vertex_normals(std::span<const Vec<double, 3>> vertices,
                                                  std::span<const MeshFace> faces) {
    std::vector<Vec<double, 3>> normals(vertices.size());
    for (const auto& [a, b, c] : faces) {
        const auto n = cross(vertices[b] - vertices[a], vertices[c] - vertices[a]);
        for (const std::uint32_t i : {a, b, c}) normals[i] = normals[i] + n;
    }
    for (auto& n : normals) n = unit_or_zero(n);
    return normals;
}

/// Returns which vertices lie at an edge with one face.
inline std::vector<char> rim_vertices(std::size_t count, std::span<const MeshFace> faces) {
    std::vector<std::array<std::uint32_t, 2>> edges;
    for (const auto& face : faces) {
        for (std::size_t k = 0; k < 3; ++k)
            edges.push_back({(std::min)(face[k], face[(k + 1) % 3]), (std::max)(face[k], face[(k + 1) % 3])});
    }
    std::sort(edges.begin(), edges.end());
    std::vector<char> is_rim(count);
    for (std::size_t n = 0; n < edges.size();) {
        std::size_t end = n + 1;
        while (end < edges.size() && edges[end] == edges[n]) ++end;
        for (const std::uint32_t i : edges[n]) is_rim[i] |= end == n + 1 ? 1 : 0;
        n = end;
    }
    return is_rim;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
