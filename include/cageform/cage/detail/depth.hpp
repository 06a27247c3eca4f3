// A smooth measure of a point's depth inside a cage.
#pragma once

#include <cageform/cage/cell_complex.hpp>
#include <cageform/cage/detail/loop_sides.hpp>
#include <cageform/cage/detail/shells.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A function that is smooth inside and, close to the boundary, proportional to the distance from it. The
/// function is the reciprocal of the integral of 1/ρ over all directions, where ρ is the distance of the
/// boundary in a direction. Further crossings in a direction count with alternating signs. Mean value weights
/// are normalised by this integral (Dyken & Floater, Transfinite mean value interpolation, CAGD 26 (2009),
/// sec. 3). The cage must be valid, and points must lie inside. O(edges or faces).
template <class Cage>
class Depth;

template <Scalar T>
class Depth<Polygon<T>> {
public:
    explicit Depth(const Polygon<T>& polygon) {
        for (std::size_t k = 0; k < polygon.loops().size(); ++k) {
            const bool left = inside_is_left(polygon, k);
            polygon.loops()[k].for_each_edge([&](std::size_t i, std::size_t j) {
                const auto a = vec_cast<double>(polygon[i]), b = vec_cast<double>(polygon[j]);
                edges_.push_back(left ? std::pair(a, b) : std::pair(b, a));
            });
        }
    }
    /// Returns the depth in the units of the cage; 0 if the sum is not positive because of rounding.
    double operator()(const Vec<T, 2>& p) const noexcept {
        double sum = 0;
        for (const auto& [from, to] : edges_) {
            const auto a = from - vec_cast<double>(p), b = to - vec_cast<double>(p);
            const double r = length(a), s = length(b);
            const double over = cross(a, b), along = dot(a, b);
            const double tangent =
                along > 0 ? over / (r * s + along) : (r * s - along) / over; // tan(angle / 2)
            sum += tangent * (1 / r + 1 / s);
        }
        return sum > 0 ? 1 / sum : 0;
    }

private:
    std::vector<std::pair<Vec<double, 2>, Vec<double, 2>>> edges_;
};

template <Scalar T>
class Depth<TriangleMesh<T>> {
public:
    explicit Depth(const TriangleMesh<T>& mesh) {
        for (const auto& face : outward_faces(mesh)) {
            const auto corner = Facet<3>(face, mesh.vertices()).corner;
            const auto normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
            faces_.push_back({corner, (1 / length(normal)) * normal});
        }
    }
    double operator()(const Vec<T, 3>& p) const noexcept {
        double sum = 0;
        for (const auto& face : faces_) {
            std::array<Vec<double, 3>, 3> c;
            double largest = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                c[k] = face.corner[k] - vec_cast<double>(p);
                largest = (std::max)(largest, length(c[k]));
            }
            const double height = dot(face.normal, c[0]);
            // The vector area of the spherical triangle along the normal: half the sum, over the sides, of
            // the angle times the unit normal.
            double area = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto over = cross(c[k], c[(k + 1) % 3]);
                const double size = length(over);
                if (size > 0)
                    area += 0.5 * std::atan2(size, dot(c[k], c[(k + 1) % 3])) / size * dot(face.normal, over);
            }
            // If the point is in the plane of a face but not on the face, its term is only a rounding error.
            // Close to the face, `area` is about π.
            if (std::fabs(height) < 1e-7 * largest && std::fabs(area) < 1) continue;
            sum += area / height;
        }
        return sum > 0 ? 1 / sum : 0;
    }

private:
    struct Face {
        std::array<Vec<double, 3>, 3> corner;
        Vec<double, 3> normal;
    };
    std::vector<Face> faces_;
};

/// The depth in a cell complex ignores its cells.
template <Scalar T, std::size_t D>
class Depth<CellComplex<T, D>> : public Depth<typename CellComplex<T, D>::Boundary> {
public:
    explicit Depth(const CellComplex<T, D>& cage)
        : Depth<typename CellComplex<T, D>::Boundary>(cage.boundary()) {}
};

} // namespace cageform::inline CAGEFORM_ABI::detail
