// A triangle mesh, and cells inside it, as the boundary of a problem on a lattice; what polygon_boundary.hpp is for polygons.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/grid/bones.hpp>
#include <cageform/grid/cut_stencil.hpp>
#include <cageform/grid/embed.hpp>
#include <cageform/grid/lattice.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A closed mesh in units of a lattice of at most 1024 cells a side. Node i of the lattice lies at i.
template <Scalar T>
class MeshBoundary {
public:
    using Index = NodeRuns<3>::Index;
    static constexpr std::size_t dimension = 3;

    /// Of a TriangleMesh or a CellComplex.
    template <class Cage>
    MeshBoundary(const Cage& whole, const Lattice<double, 3>& lattice)
        : lattice_(lattice)
        , vertices_(lattice.in_cells(whole.vertices()))
        , bones_(interior_cells(whole).bones, vertices_, lattice) {
        const auto faces = boundary_of(whole).faces();
        faces_.assign(faces.begin(), faces.end());
        outer_ = faces_.size();
        const auto& cells = interior_cells(whole);
        for (const auto& facet : cells.facets) faces_.push_back(facet);
    }

    const Lattice<double, 3>& lattice() const noexcept { return lattice_; }
    /// Which lines meet which face is decided in whole numbers (vertices rounded to 2⁻²⁰ of a cell) and, where a line
    /// meets an edge or a vertex, as if all lines lay a little aside, the same for all faces: so every line crosses a
    /// closed mesh an even number of times. O(faces + lines they meet, and the logarithm of that).
    Crossings<3> crossings() const {
        Crossings<3> all;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::size_t f = 0; f < faces_.size(); ++f)
                add_crossings(all[axis], faces_[f], f < outer_, axis);
        }
        bones_.add_crossings(all);
        for (auto& along : all) sort_along_lines<3>(along);
        return all;
    }
    std::vector<FixedNode<3>> fixed_nodes() const { return bones_.nodes(); } ///< within interior cells
    std::optional<std::uint32_t> too_thin_bone() const noexcept { return bones_.too_thin(); }

    BoundaryValue<3> nearest(const Index& node) const noexcept {
        const Vec<double, 3> p{double(node[0]), double(node[1]), double(node[2])};
        double least = std::numeric_limits<double>::max();
        BoundaryValue<3> value;
        for (const auto& face : faces_) {
            const auto &a = vertices_[face[0]], &b = vertices_[face[1]], &c = vertices_[face[2]];
            const auto w = detail::nearest_on_facet(p, {a, b, c});
            const auto d = w[0] * a + w[1] * b + w[2] * c - p;
            if (dot(d, d) >= least) continue;
            least = dot(d, d);
            value = data(face, w);
        }
        double distance = std::sqrt(least);
        (void)bones_.nearest(p, distance, value);
        return value;
    }

    /// How far a point can go along an axis, up or down, before it meets the boundary, but no farther than `limit`. O(faces).
    double free_distance(const Vec<double, 3>& p, std::size_t axis, bool up, double limit) const noexcept {
        double position = 0;
        BoundaryValue<3> value;
        for (std::uint32_t n = 0; n < faces_.size() + bones_.size(); ++n)
            (void)meet(n, p, axis, up ? 1.0 : -1.0, limit, position, value);
        return limit;
    }

    /// Prepares `sample` and `is_cut`: which faces (and, numbered after them, bones) pass which cell, or come as near
    /// as `slack`.
    void index_cells(double slack) {
        passes_.clear();
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            const auto &a = vertices_[faces_[f][0]], &b = vertices_[faces_[f][1]],
                       &c = vertices_[faces_[f][2]];
            const auto normal = cross(b - a, c - a);
            const double reach =
                (0.5 + slack) * (std::fabs(normal[0]) + std::fabs(normal[1]) + std::fabs(normal[2]));
            std::array<std::int32_t, 3> low{}, high{};
            for (std::size_t k = 0; k < 3; ++k) {
                low[k] = std::int32_t(std::floor(std::min({a[k], b[k], c[k]}) - slack));
                high[k] = std::int32_t(std::floor(std::max({a[k], b[k], c[k]}) + slack));
            }
            for (auto z = low[2]; z <= high[2]; ++z) {
                for (auto y = low[1]; y <= high[1]; ++y) {
                    for (auto x = low[0]; x <= high[0]; ++x) {
                        const Vec<double, 3> middle{x + 0.5, y + 0.5, z + 0.5};
                        if (std::fabs(dot(normal, middle - a)) <= reach)
                            passes_.push_back({cell(x, y, z), f});
                    }
                }
            }
        }
        for (std::uint32_t n = 0; n < bones_.size(); ++n) {
            bones_.for_each_cell_about(n, [&](const Index& low) {
                passes_.push_back({cell(low[0], low[1], low[2]), std::uint32_t(faces_.size()) + n});
            });
        }
        std::sort(passes_.begin(), passes_.end());
    }

    /// Whether a part of the boundary passes a cell, by its lower corner.
    bool is_cut(const Index& low) const noexcept {
        const auto key = cell(low[0], low[1], low[2]);
        const auto first = std::lower_bound(passes_.begin(), passes_.end(), std::pair(key, std::uint32_t{0}));
        return first != passes_.end() && first->first == key;
    }

    /// The stencil of a point strictly inside: trilinear, where the boundary passes the cell as `gather_cut` says, in the mean
    /// of three orders of the axes. Exact for linear functions everywhere; a mean, so never beyond the values it is
    /// made of.
    CutStencil<3> sample(const Vec<double, 3>& p, const NodeRuns<3>& nodes) const noexcept {
        CutStencil<3> stencil;
        std::array<std::int32_t, 3> low{};
        for (std::size_t k = 0; k < 3; ++k) low[k] = std::int32_t(std::floor(p[k]));
        const auto key = cell(low[0], low[1], low[2]);
        const auto first = std::lower_bound(passes_.begin(), passes_.end(), std::pair(key, std::uint32_t{0}));
        const auto cast = [&](const Vec<double, 3>& from, std::size_t axis, double end, double& position,
                              BoundaryValue<3>& value) {
            double limit = std::fabs(end - from[axis]);
            bool found = false;
            for (auto pass = first; pass != passes_.end() && pass->first == key; ++pass)
                found =
                    meet(pass->second, from, axis, end > from[axis] ? 1.0 : -1.0, limit, position, value) ||
                    found;
            return found;
        };
        const auto nearest_to = [&](const Index& node) { return nearest(node); };
        const bool cut = first != passes_.end() && first->first == key;
        for (std::size_t order = 0; order < (cut ? 3u : 1u); ++order) {
            gather_cut<3>(stencil, p, low, {order, (order + 1) % 3, (order + 2) % 3}, 0, cut ? 1.0 / 3 : 1.0,
                          nodes, cast, nearest_to);
        }
        return stencil;
    }

private:
    using Face = typename TriangleMesh<T>::Face;
    using Pass = std::pair<std::uint64_t, std::uint32_t>;

    static std::uint64_t cell(std::int32_t x, std::int32_t y, std::int32_t z) noexcept {
        const auto part = [](std::int32_t i) { return std::uint64_t(std::uint32_t(i) & 0x1FFFFFu); };
        return (part(z) << 42) | (part(y) << 21) | part(x);
    }
    static BoundaryValue<3> data(const Face& face, const std::array<double, 3>& w) noexcept {
        return {{face[0], face[1], face[2], face[0]}, {w[0], w[1], w[2], 0.0}};
    }
    /// Where the line through a place (x, y) of the plane across an axis meets a face's plane: the weights of its corners,
    /// negative beyond an edge. False where the face is seen edge-on.
    bool weights_at(const Face& face, std::size_t u, std::size_t v, double x, double y,
                    std::array<double, 3>& w) const noexcept {
        std::array<Vec<double, 2>, 3> c;
        for (std::size_t k = 0; k < 3; ++k) c[k] = {vertices_[face[k]][u] - x, vertices_[face[k]][v] - y};
        const double area = cross(c[1] - c[0], c[2] - c[0]);
        if (area == 0) return false;
        for (std::size_t k = 0; k < 3; ++k) w[k] = cross(c[(k + 1) % 3], c[(k + 2) % 3]) / area;
        return true;
    }
    static std::array<double, 3> clamped(std::array<double, 3> w) noexcept {
        double sum = 0;
        for (double& x : w) sum += (x = std::clamp(x, 0.0, 1.0));
        for (double& x : w) x /= sum;
        return w;
    }

    void add_crossings(std::vector<Crossing<3>>& out, const Face& face, bool turns, std::size_t axis) const {
        const std::size_t u = detail::other_axes[axis][0], v = detail::other_axes[axis][1];
        using Whole = std::array<std::int64_t, 2>;
        constexpr std::int64_t one = std::int64_t{1} << 20;
        std::array<Whole, 3> corner;
        for (std::size_t k = 0; k < 3; ++k) {
            corner[k] = {std::llround(vertices_[face[k]][u] * double(one)),
                         std::llround(vertices_[face[k]][v] * double(one))};
        }
        const auto side = [](const Whole& a, const Whole& b, const Whole& p) {
            return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
        };
        const std::int64_t area = side(corner[0], corner[1], corner[2]);
        if (area == 0) return;
        // On which side of an edge a line lies; both faces of the edge ask in the same way.
        const auto is_left = [&](std::size_t k, std::size_t l, const Whole& p) {
            const bool turned = face[k] > face[l];
            const auto &a = corner[turned ? l : k], &b = corner[turned ? k : l];
            std::int64_t s = side(a, b, p);
            if (s == 0 && !turns) return area > 0; // the rim of a facet belongs to it, on all sides
            if (s == 0)
                s = b[1] != a[1] ? a[1] - b[1] : b[0] - a[0]; // the line aside, along u far more than along v
            return (s > 0) != turned;
        };
        const auto first = [&](std::size_t k) {
            const auto low = std::min({corner[0][k], corner[1][k], corner[2][k]});
            return std::max<std::int64_t>((low + one - 1) >> 20, 0);
        };
        const auto last = [&](std::size_t k, std::size_t of) {
            const auto high = std::max({corner[0][k], corner[1][k], corner[2][k]});
            return std::min<std::int64_t>(high >> 20, std::int64_t(lattice_.cells[of]) - 1);
        };
        double low = vertices_[face[0]][axis], high = low;
        for (const auto i : face) {
            low = std::fmin(low, vertices_[i][axis]);
            high = std::fmax(high, vertices_[i][axis]);
        }
        for (std::int64_t y = first(1); y <= last(1, v); ++y) {
            for (std::int64_t x = first(0); x <= last(0, u); ++x) {
                const Whole p{x * one, y * one};
                const bool left = area > 0;
                if (is_left(0, 1, p) != left || is_left(1, 2, p) != left || is_left(2, 0, p) != left)
                    continue;
                std::array<double, 3> w{};
                if (!weights_at(face, u, v, double(x), double(y), w)) continue;
                double position = 0;
                for (std::size_t k = 0; k < 3; ++k) position += w[k] * vertices_[face[k]][axis];
                out.push_back({std::uint32_t(x) + std::uint32_t(lattice_.cells[u]) * std::uint32_t(y), turns,
                               std::clamp(position, low, high), data(face, clamped(w))});
            }
        }
    }

    /// Whether a face (or bone) lies on the way from `p` along an axis within `limit`, which becomes the distance to it.
    bool meet(std::uint32_t f, const Vec<double, 3>& p, std::size_t axis, double sign, double& limit,
              double& position, BoundaryValue<3>& value) const noexcept {
        if (f >= faces_.size()) return bones_.meet(f - faces_.size(), p, axis, sign, limit, position, value);
        constexpr double rim = 1e-9; // no point may slip between two faces
        const std::size_t u = detail::other_axes[axis][0], v = detail::other_axes[axis][1];
        std::array<double, 3> w{};
        if (!weights_at(faces_[f], u, v, p[u], p[v], w)) return false;
        if (w[0] < -rim || w[1] < -rim || w[2] < -rim) return false;
        w = clamped(w);
        double at = 0;
        for (std::size_t k = 0; k < 3; ++k) at += w[k] * vertices_[faces_[f][k]][axis];
        const double distance = sign * (at - p[axis]);
        if (distance < 0 || distance > limit) return false;
        limit = distance;
        position = at;
        value = data(faces_[f], w);
        return true;
    }

    Lattice<double, 3> lattice_;
    std::vector<Vec<double, 3>> vertices_;
    GridBones<3> bones_;
    std::vector<Face> faces_;  ///< the boundary's, then the facets inside
    std::size_t outer_ = 0;    ///< of the boundary
    std::vector<Pass> passes_; ///< cell and face, sorted
};

template <Scalar T>
struct GridBoundaryOf<TriangleMesh<T>> {
    using type = MeshBoundary<T>;
};
template <Scalar T>
struct GridBoundaryOf<CellComplex<T, 3>> {
    using type = MeshBoundary<T>;
};

} // namespace cageform::inline CAGEFORM_ABI
