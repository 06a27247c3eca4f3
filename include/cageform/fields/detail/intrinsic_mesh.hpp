// A triangle mesh defined by its edge lengths, and the edge flips that make it Delaunay.
#pragma once

#include <cageform/cage/detail/gaps.hpp>
#include <cageform/cage/triangle_mesh.hpp>

#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The shape of a triangle. Side k is opposite to corner k.
struct TriangleShape {
    std::array<double, 3> length{}; ///< lengths of the sides
    std::array<double, 3> dot{};    ///< per corner, dot product of the two sides from it
    double area2 = 0;               ///< twice the area

    double cotangent(std::size_t k) const noexcept { return dot[k] / area2; }

    /// Whether the triangle has an area and its numbers are consistent. The tolerance is loose, because
    /// flips may involve sides that are 1e-10 as long as others.
    bool is_valid() const noexcept {
        constexpr double rounding = 1e-6;
        bool valid = area2 > 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double product = length[(k + 1) % 3] * length[(k + 2) % 3];
            valid = valid && std::fabs(std::hypot(dot[k], area2) - product) <= rounding * product;
        }
        return valid;
    }

    static TriangleShape of(const Corners<3>& corner) noexcept {
        TriangleShape shape;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto &a = corner[(k + 1) % 3], &b = corner[(k + 2) % 3];
            shape.length[k] = detail::length(b - a);
            shape.dot[k] = cageform::dot(a - corner[k], b - corner[k]);
        }
        shape.area2 = detail::length(cross(corner[1] - corner[0], corner[2] - corner[0]));
        return shape;
    }
};

/// Two triangles with the common side ab, unfolded into a plane with c above and d below it. Each array has
/// an element for c and one for d. `from_a` is the distance along ab from a (towards b), `from_b` the
/// distance from b (towards a), and `height` the height over ab.
struct UnfoldedPair {
    std::array<double, 2> from_a, from_b, height;
    double diagonal; ///< length of cd

    /// The triangles are `first` = (c, a, b) from corner k and `second` = (d, b, a) from corner m.
    UnfoldedPair(const TriangleShape& first, std::size_t k, const TriangleShape& second,
                 std::size_t m) noexcept {
        const double ab = first.length[k];
        from_a = {first.dot[(k + 1) % 3] / ab, second.dot[(m + 2) % 3] / ab};
        from_b = {first.dot[(k + 2) % 3] / ab, second.dot[(m + 1) % 3] / ab};
        height = {first.area2 / ab, second.area2 / ab};
        // Both differences are equal except for rounding; the one of the smaller numbers is more accurate.
        const auto &x = from_a, &y = from_b;
        const bool is_nearer_a = std::fabs(x[0]) + std::fabs(x[1]) <= std::fabs(y[0]) + std::fabs(y[1]);
        diagonal = std::hypot(is_nearer_a ? x[0] - x[1] : y[0] - y[1], height[0] + height[1]);
    }

    /// Returns the triangle (c, x, d), with corners and sides in this order. `from` is measured from x, an
    /// end of ab. `to_c` and `to_d` are the lengths of the sides from x to c and d.
    TriangleShape half(const std::array<double, 2>& from, double to_c, double to_d) const noexcept {
        const double across = from[0] - from[1], up = height[0] + height[1];
        TriangleShape shape;
        shape.length = {to_d, diagonal, to_c};
        shape.dot = {from[0] * across + height[0] * up, from[0] * from[1] - height[0] * height[1],
                     height[1] * up - from[1] * across};
        shape.area2 = from[1] * height[0] + from[0] * height[1];
        return shape;
    }
};

/// A triangle mesh without positions: open or closed, orientable or not. After flips two triangles may have
/// two common edges, and an edge may connect a vertex to itself.
class IntrinsicMesh {
public:
    static constexpr std::uint32_t rim = ~std::uint32_t{0};

    /// Vertices must be finite, faces must have an area, and an edge at most two faces.
    template <Scalar T>
    IntrinsicMesh(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces,
                  std::span<const HalfEdge> half_edges)
        : corner_(faces.begin(), faces.end())
        , twin_(3 * faces.size(), rim)
        , aligned_(3 * faces.size()) {
        shape_.reserve(faces.size());
        for (const auto& face : faces) shape_.push_back(TriangleShape::of(Facet<3>(face, vertices).corner));
        for_each_edge(half_edges, [&](std::span<const HalfEdge> edge) {
            if (edge.size() == 2) join(side_of(edge[0]), side_of(edge[1]), edge[0].from == edge[1].from);
        });
    }

    std::size_t sides() const noexcept { return twin_.size(); }
    /// Returns the side of the other triangle at the same edge, or `rim`.
    std::uint32_t twin(std::uint32_t side) const noexcept { return twin_[side]; }
    std::array<std::uint32_t, 2> ends(std::uint32_t side) const noexcept {
        const auto& corner = corner_[side / 3];
        return {corner[(side + 1) % 3], corner[(side + 2) % 3]};
    }
    double cotangent(std::uint32_t side) const noexcept { return shape_[side / 3].cotangent(side % 3); }

    /// The sum of the cotangents of the angles opposite to an edge, with a bound of its rounding error.
    struct Sum {
        double value, rounding;
    };
    Sum cotangents(std::uint32_t side) const noexcept {
        const double here = cotangent(side), there = twin_[side] == rim ? 0 : cotangent(twin_[side]);
        return {here + there, 64 * epsilon<double> * (1 + std::fabs(here) + std::fabs(there))};
    }

    /// Flips edges until no two angles opposite to an edge exceed π in sum (Bobenko, Springborn, A discrete
    /// Laplace–Beltrami operator for simplicial surfaces, Discrete Comput. Geom. 38 (2007), sec. 2). Each
    /// flip decreases the Dirichlet energy, so the flips end, usually after few. Returns the number of flips.
    std::size_t make_delaunay() {
        std::vector<std::uint32_t> pending(sides());
        for (std::uint32_t side = 0; side < sides(); ++side) pending[side] = side;
        std::size_t flips = 0;
        // The limit guards against endless flips by rounding, which have never been observed.
        for (const std::size_t most = 1000 + 64 * sides(); !pending.empty() && flips < most;) {
            const std::uint32_t side = pending.back();
            pending.pop_back();
            const auto [value, rounding] = cotangents(side);
            if (twin_[side] == rim || value >= -rounding || !flip(side)) continue;
            ++flips;
            const std::uint32_t f = side / 3, g = twin_[3 * f + 1] / 3;
            pending.insert(pending.end(), {3 * f, 3 * f + 2, 3 * g, 3 * g + 2});
        }
        return flips;
    }

private:
    std::uint32_t side_of(const HalfEdge& half_edge) const noexcept {
        const auto& corner = corner_[half_edge.face];
        for (std::uint32_t k = 0; k < 2; ++k) {
            if (corner[k] != half_edge.from && corner[k] != half_edge.to) return 3 * half_edge.face + k;
        }
        return 3 * half_edge.face + 2;
    }
    void join(std::uint32_t a, std::uint32_t b, bool aligned) noexcept {
        twin_[a] = b;
        twin_[b] = a;
        aligned_[a] = aligned_[b] = aligned ? 1 : 0;
    }

    /// Reverses the orientation of a triangle: swaps corners 1 and 2.
    void reverse(std::uint32_t g) noexcept {
        const std::uint32_t first = 3 * g;
        std::swap(corner_[g][1], corner_[g][2]);
        std::swap(shape_[g].length[1], shape_[g].length[2]);
        std::swap(shape_[g].dot[1], shape_[g].dot[2]);
        std::swap(twin_[first + 1], twin_[first + 2]);
        std::swap(aligned_[first + 1], aligned_[first + 2]);
        for (std::uint32_t side = first; side < first + 3; ++side) {
            const std::uint32_t other = twin_[side];
            if (other == rim) continue;
            if (other / 3 == g) {
                twin_[side] = first + (3 - other % 3) % 3;
            } else {
                join(side, other, aligned_[side] == 0);
            }
        }
    }

    /// Flips side ab of the triangles cab and dba, which become cad and dbc. Changes nothing and returns
    /// false if a new triangle would be degenerate up to rounding, or if both sides belong to one triangle.
    bool flip(std::uint32_t side) noexcept {
        const std::uint32_t f = side / 3, g = twin_[side] / 3;
        if (f == g) return false;
        if (aligned_[side] != 0) reverse(g);
        const std::uint32_t k = side % 3, m = twin_[side] % 3;
        const UnfoldedPair pair(shape_[f], k, shape_[g], m);
        const auto next = [](std::uint32_t triangle, std::uint32_t corner) {
            return 3 * triangle + corner % 3;
        };
        const std::array<std::uint32_t, 4> before{next(g, m + 1), next(f, k + 2), next(f, k + 1),
                                                  next(g, m + 2)}; // ad, ca, bc, db
        const std::array<std::uint32_t, 4> after{3 * f, 3 * f + 2, 3 * g, 3 * g + 2};
        std::array<double, 4> length{};
        for (std::size_t n = 0; n < 4; ++n) length[n] = shape_[before[n] / 3].length[before[n] % 3];
        const TriangleShape at_a = pair.half(pair.from_a, length[1], length[0]);
        TriangleShape at_b = pair.half(pair.from_b, length[2], length[3]);
        if (!at_a.is_valid() || !at_b.is_valid()) return false;
        std::swap(at_b.length[0], at_b.length[2]); // from (c, b, d) to (d, b, c)
        std::swap(at_b.dot[0], at_b.dot[2]);

        std::array<std::uint32_t, 4> twin{};
        std::array<std::uint8_t, 4> aligned{};
        for (std::size_t n = 0; n < 4; ++n) {
            twin[n] = twin_[before[n]];
            aligned[n] = aligned_[before[n]];
            for (std::size_t o = 0; o < 4; ++o) {
                if (twin_[before[n]] == before[o]) twin[n] = after[o];
            }
        }
        const auto c = corner_[f][k], a = corner_[f][(k + 1) % 3], b = corner_[f][(k + 2) % 3],
                   d = corner_[g][m];
        corner_[f] = {c, a, d};
        corner_[g] = {d, b, c};
        shape_[f] = at_a;
        shape_[g] = at_b;
        join(3 * f + 1, 3 * g + 1, false);
        for (std::size_t n = 0; n < 4; ++n) {
            twin_[after[n]] = rim;
            aligned_[after[n]] = 0;
            if (twin[n] != rim) join(after[n], twin[n], aligned[n] != 0);
        }
        return true;
    }

    std::vector<MeshFace> corner_;
    std::vector<TriangleShape> shape_;
    std::vector<std::uint32_t> twin_;   ///< per side
    std::vector<std::uint8_t> aligned_; ///< per side, whether both triangles have the edge in one direction
};

} // namespace cageform::inline CAGEFORM_ABI::detail
