// Nearest places of a surface, by position and normal at once.
#pragma once

#include <cageform/cage/detail/box_tree.hpp>
#include <cageform/cage/types/facet.hpp>
#include <cageform/fit/types/surface.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

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

} // namespace detail

/// A place of a surface.
struct ClosestPlace {
    std::uint32_t face = no_vertex;   ///< no_vertex: the surface has no faces
    std::array<double, 3> weights{};  ///< of the face's corners
    Vec<double, 3> place{}, normal{}; ///< the normal is interpolated from the vertices
};

/// Finds the nearest place of a surface with a similar normal: the place (y, m) with the least
///
///     |x − y|² + κ² |n − m|²
///
/// where m is interpolated linearly from the vertices. Thus a face is a triangle in six dimensions, and the
/// nearest place is exact. Without normals (κ = 0), the nearest place by distance.
///
///   memory  about 350 bytes per face
///   cost    O(#faces log #faces) to make; a search usually takes O(log #faces), about 2 µs for 20,000 faces
class ClosestPlaces {
public:
    ClosestPlaces() = default;
    /// Throws std::bad_alloc. Vertices must be finite and indices in range. Faces without area are skipped.
    ///
    ///   normal_length  κ, a length
    ClosestPlaces(std::span<const Vec<double, 3>> vertices, std::span<const SurfaceMesh::Face> faces,
                  double normal_length = 0)
        : vertices_(vertices.begin(), vertices.end())
        , normals_(detail::vertex_normals(vertices, faces))
        , faces_(faces.begin(), faces.end())
        , on_rim_(detail::rim_vertices(vertices.size(), faces)) {
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            const auto& [i, j, k] = faces_[f];
            const auto n = cross(vertices_[j] - vertices_[i], vertices_[k] - vertices_[i]);
            if (dot(n, n) > 0) tree_faces_.push_back(f);
        }
        set_normal_length(normal_length);
    }
    /// Changes κ. Throws std::bad_alloc. O(#faces log #faces).
    void set_normal_length(double normal_length) {
        normal_length_ = normal_length;
        tree_ = detail::BoxTree<6>(tree_faces_.size(), [&](std::uint32_t n) {
            const auto corners = corners_of(tree_faces_[n]);
            return bounds_of(std::span<const Vec<double, 6>>(corners));
        });
    }

    /// Returns the nearest place.
    ///
    ///   guess  a face near the place, which makes the search faster; or no_vertex
    ClosestPlace find(const Vec<double, 3>& x, const Vec<double, 3>& normal = {},
                      std::uint32_t guess = no_vertex) const noexcept {
        const auto q = detail::with_normal(x, normal, normal_length_);
        ClosestPlace best;
        double least = std::numeric_limits<double>::infinity();
        const auto visit = [&](std::uint32_t face) {
            const auto corners = corners_of(face);
            const auto weights = detail::nearest_on_triangle(q, corners);
            const auto e = detail::point_of(weights, corners) - q;
            const double square = dot(e, e);
            if (square < least || (square == least && face < best.face)) {
                least = square;
                best.face = face;
                best.weights = weights;
            }
            return least;
        };
        if (guess != no_vertex) (void)visit(guess);
        tree_.for_each_near(q, least, [&](std::uint32_t n) { return visit(tree_faces_[n]); });
        if (best.face == no_vertex) return best;
        const auto& [a, b, c] = faces_[best.face];
        best.place = detail::point_of<3>(best.weights, {vertices_[a], vertices_[b], vertices_[c]});
        best.normal =
            detail::unit_or_zero(detail::point_of<3>(best.weights, {normals_[a], normals_[b], normals_[c]}));
        return best;
    }
    /// Whether a corner of a face lies on the rim, at an edge with one face.
    bool is_on_rim(std::uint32_t face) const noexcept {
        const auto& [a, b, c] = faces_[face];
        return on_rim_[a] != 0 || on_rim_[b] != 0 || on_rim_[c] != 0;
    }
    std::size_t skipped_faces() const noexcept { return faces_.size() - tree_faces_.size(); }
    std::span<const Vec<double, 3>> vertices() const noexcept { return vertices_; }
    std::span<const Vec<double, 3>> normals() const noexcept { return normals_; }

private:
    std::array<Vec<double, 6>, 3> corners_of(std::uint32_t face) const noexcept {
        std::array<Vec<double, 6>, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t i = faces_[face][k];
            corners[k] = detail::with_normal(vertices_[i], normals_[i], normal_length_);
        }
        return corners;
    }

    double normal_length_ = 0;
    std::vector<Vec<double, 3>> vertices_, normals_;
    std::vector<SurfaceMesh::Face> faces_;
    std::vector<char> on_rim_;              ///< #vertices
    std::vector<std::uint32_t> tree_faces_; ///< the faces with an area: the items of the tree
    detail::BoxTree<6> tree_;
};

/// Returns the distances of points from a surface. O(#points log #faces).
inline SurfaceDistance distances_to(const ClosestPlaces& surface, std::span<const Vec<double, 3>> points) {
    std::vector<double> distances;
    SurfaceDistance result;
    std::uint32_t guess = no_vertex;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const ClosestPlace at = surface.find(points[i], {}, guess);
        guess = at.face;
        if (guess == no_vertex) continue;
        const auto e = at.place - points[i];
        distances.push_back(std::sqrt(dot(e, e)));
        result.mean += distances.back();
        if (!(distances.back() > result.largest)) continue;
        result.largest = distances.back();
        result.farthest = i;
    }
    if (distances.empty()) return result;
    result.mean /= double(distances.size());
    const auto upper = distances.begin() + std::ptrdiff_t(0.95 * double(distances.size() - 1));
    std::nth_element(distances.begin(), upper, distances.end());
    result.upper = *upper;
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
