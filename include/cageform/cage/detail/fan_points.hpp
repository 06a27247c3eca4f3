// The points that a polyhedral mesh adds to bind non-planar faces, and the triangles over these points.
#pragma once

#include <cageform/core/detail/face_handles.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The points that a PolyhedralMesh adds after its vertices. Each point is a weighted mean of corners of one
/// face, with positive weights that sum to 1. The weight of a point is distributed to these corners. This
/// preserves the sum of all weights w, and the sum Σ w C over the positions C.
class FanPoints {
public:
    std::size_t size() const noexcept { return ends_.size(); }
    void add(std::span<const std::uint32_t> corners, std::span<const double> weights) {
        corners_.insert(corners_.end(), corners.begin(), corners.end());
        weights_.insert(weights_.end(), weights.begin(), weights.end());
        ends_.push_back(corners_.size());
    }
    /// Returns the vertices whose weighted mean the point is.
    std::span<const std::uint32_t> corners(std::size_t point) const noexcept {
        return {corners_.data() + begin(point), ends_[point] - begin(point)};
    }
    template <class F>
    void for_each_corner(std::size_t point, F&& f) const {
        for (std::size_t n = begin(point); n < ends_[point]; ++n) f(corners_[n], weights_[n]);
    }

private:
    std::size_t begin(std::size_t point) const noexcept { return point == 0 ? 0 : ends_[point - 1]; }

    std::vector<std::uint32_t> corners_; ///< of all points, one after the other
    std::vector<double> weights_;
    std::vector<std::size_t> ends_; ///< end of each point in corners_ and in weights_
};

/// Replaces the faces of a mesh by fans of triangles around the means of their corners. With k divisions, a
/// face of four corners becomes k × k cells of its bilinear patch, each a fan. The edges of this face are
/// divided into k pieces, also in the neighbouring faces.
template <Scalar T>
class FanBuilder {
public:
    using Triangles = std::vector<std::array<std::uint32_t, 3>>;
    using Edge = std::pair<std::uint32_t, std::uint32_t>;

    /// `at` holds the vertices; new points are appended to it and to `points`.
    FanBuilder(std::vector<Vec<T, 3>>& at, FanPoints& points, std::uint32_t divisions) noexcept
        : at_(at)
        , points_(points)
        , k_(divisions) {}

    /// Divides the edges of a face if `add` divides the face. Call this for all faces before `add`.
    void divide_edges(std::span<const std::uint32_t> loop) {
        if (!is_divided(loop)) return;
        const auto corners = from_lowest(loop);
        for (std::size_t c = 0; c < 4; ++c) {
            const Edge edge = std::minmax(corners[c], corners[(c + 1) % 4]);
            const auto [place, is_new] = edges_.insert({edge, std::uint32_t(at_.size())});
            for (std::uint32_t i = 1; is_new && i < k_; ++i) {
                const double t = double(i) / double(k_);
                add_point<2>({edge.first, edge.second}, {1 - t, t});
            }
        }
    }
    /// Returns a face's loop including the points of its divided edges.
    std::vector<std::uint32_t> with_edge_points(std::span<const std::uint32_t> loop) const {
        std::vector<std::uint32_t> longer;
        for (std::size_t c = 0; c < loop.size(); ++c) {
            const auto from = loop[c], to = loop[(c + 1) % loop.size()];
            longer.push_back(from);
            if (!edges_.contains(Edge(std::minmax(from, to)))) continue;
            for (std::uint32_t i = 1; i < k_; ++i) longer.push_back(on_edge(from, to, i));
        }
        return longer;
    }
    /// Adds the triangles of a face of four corners or more.
    void add(std::span<const std::uint32_t> loop, Triangles& triangles) {
        if (is_divided(loop)) return add_cells(from_lowest(loop), triangles);
        const auto corners = from_lowest(loop);
        const auto middle = std::uint32_t(at_.size());
        points_.add(corners, std::vector<double>(corners.size(), 1 / double(corners.size())));
        at_.push_back(mean_of_loop(corners.data(), corners.size(), [&](std::uint32_t i) { return at_[i]; }));
        add_triangles(with_edge_points(loop), middle, triangles);
    }

private:
    bool is_divided(std::span<const std::uint32_t> loop) const noexcept { return k_ > 1 && loop.size() == 4; }
    /// Rotates a loop to begin at its lowest index, so that points do not depend on its first vertex.
    static std::vector<std::uint32_t> from_lowest(std::span<const std::uint32_t> loop) {
        std::vector<std::uint32_t> corners(loop.begin(), loop.end());
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        return corners;
    }
    static void add_triangles(std::span<const std::uint32_t> ring, std::uint32_t middle,
                              Triangles& triangles) {
        for (std::size_t c = 0; c < ring.size(); ++c)
            triangles.push_back({ring[c], ring[(c + 1) % ring.size()], middle});
    }
    template <std::size_t N>
    std::uint32_t add_point(const std::array<std::uint32_t, N>& corners,
                            const std::array<double, N>& weights) {
        Vec<double, 3> sum{};
        for (std::size_t c = 0; c < N; ++c) sum = sum + weights[c] * vec_cast<double>(at_[corners[c]]);
        points_.add(corners, weights);
        at_.push_back(vec_cast<T>(sum));
        return std::uint32_t(at_.size() - 1);
    }
    /// Returns point i, 0 ≤ i ≤ k, of a divided edge in its direction; points 0 and k are its ends.
    std::uint32_t on_edge(std::uint32_t from, std::uint32_t to, std::uint32_t i) const {
        if (i == 0 || i == k_) return i == 0 ? from : to;
        const std::uint32_t first = edges_.at(Edge(std::minmax(from, to)));
        return from < to ? first + i - 1 : first + k_ - 1 - i;
    }
    /// Adds the cells of the patch (1 − u)(1 − v) c₀ + u (1 − v) c₁ + u v c₂ + (1 − u) v c₃.
    void add_cells(const std::vector<std::uint32_t>& c, Triangles& triangles) {
        const auto on_patch = [&](double u, double v) {
            return add_point<4>({c[0], c[1], c[2], c[3]},
                                {(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v});
        };
        const double size = 1 / double(k_);
        const auto inner = std::uint32_t(at_.size()); // the first node inside the patch
        for (std::uint32_t j = 1; j < k_; ++j) {
            for (std::uint32_t i = 1; i < k_; ++i) (void)on_patch(i * size, j * size);
        }
        const auto node = [&](std::uint32_t i, std::uint32_t j) {
            if (j == 0) return on_edge(c[0], c[1], i);
            if (j == k_) return on_edge(c[3], c[2], i);
            if (i == 0) return on_edge(c[0], c[3], j);
            if (i == k_) return on_edge(c[1], c[2], j);
            return inner + (j - 1) * (k_ - 1) + i - 1;
        };
        for (std::uint32_t j = 0; j < k_; ++j) {
            for (std::uint32_t i = 0; i < k_; ++i) {
                const std::array ring{node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)};
                add_triangles(ring, on_patch((i + 0.5) * size, (j + 0.5) * size), triangles);
            }
        }
    }

    std::vector<Vec<T, 3>>& at_;
    FanPoints& points_;
    std::uint32_t k_;
    /// First point of each divided edge; points run from its lower vertex to its higher one.
    std::map<Edge, std::uint32_t> edges_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
