// Nearest places of a surface, by position and normal at once.
#pragma once

#include <cageform/cage/detail/box_tree.hpp>
#include <cageform/fit/detail/surface_math.hpp>
#include <cageform/fit/types/surface.hpp>

namespace cageform::inline CAGEFORM_ABI {

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
    /// A place of a surface.
    struct Place {
        std::uint32_t face = no_vertex;   ///< no_vertex: the surface has no faces
        std::array<double, 3> weights{};  ///< of the face's corners
        Vec<double, 3> place{}, normal{}; ///< the normal is interpolated from the vertices
    };

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
        spheres_.clear();
        for (std::uint32_t f = 0; f < faces_.size(); ++f) spheres_.emplace_back(corners_of(f));
        tree_ = detail::BoxTree<6>(tree_faces_.size(), [&](std::uint32_t n) {
            const auto corners = corners_of(tree_faces_[n]);
            return bounds_of(std::span<const Vec<double, 6>>(corners));
        });
    }

    /// Returns the nearest place.
    ///
    ///   guess  a face near the place, which makes the search faster; or no_vertex
    Place find(const Vec<double, 3>& x, const Vec<double, 3>& normal = {},
               std::uint32_t guess = no_vertex) const noexcept {
        const auto q = detail::with_normal(x, normal, normal_length_);
        Place best;
        double least = std::numeric_limits<double>::infinity();
        const auto visit = [&](std::uint32_t face) {
            if (spheres_[face].is_beyond(q, least)) return detail::with_ties(least);
            const auto corners = corners_of(face);
            const auto weights = detail::nearest_on_triangle(q, corners);
            const auto e = detail::point_of(weights, corners) - q;
            const double square = dot(e, e);
            if (square < least || (square == least && face < best.face)) {
                least = square;
                best.face = face;
                best.weights = weights;
            }
            return detail::with_ties(least);
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
    /// Returns the distances of points. O(#points log #faces).
    SurfaceDistance distances(std::span<const Vec<double, 3>> points) const {
        std::vector<double> distances;
        SurfaceDistance result;
        std::uint32_t guess = no_vertex;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Place at = find(points[i], {}, guess);
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
        result.upper = detail::quantile(distances, 0.95);
        return result;
    }
    /// Returns which points lie outside: on the side of the normal at their nearest place. O(#points log
    /// #faces).
    std::vector<char> are_outside(std::span<const Vec<double, 3>> points) const {
        std::vector<char> result;
        std::uint32_t guess = no_vertex;
        for (const auto& p : points) {
            const Place at = find(p, {}, guess);
            guess = at.face;
            result.push_back(guess == no_vertex || dot(p - at.place, at.normal) > 0 ? 1 : 0);
        }
        return result;
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
    std::vector<char> on_rim_;                       ///< #vertices
    std::vector<std::uint32_t> tree_faces_;          ///< the faces with an area: the items of the tree
    std::vector<detail::TriangleSphere<6>> spheres_; ///< #faces
    detail::BoxTree<6> tree_;
};

} // namespace cageform::inline CAGEFORM_ABI
