// find_parts, step 1: a refined shell of a cage, and geodesic distances on it.
#pragma once

#include <cageform/cage/detail/primitives.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <span>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Normal of a mesh face; its length is twice the area.
inline Vec<double, 3> area_normal(std::span<const Vec<double, 3>> points,
                                  const std::array<std::uint32_t, 3>& face) noexcept {
    return area_normal({points[face[0]], points[face[1]], points[face[2]]});
}

/// A side of an edge: the vertices of the edge in ascending order, a face, and the third vertex of the face.
struct EdgeSide {
    std::uint32_t a, b, face, third;
    friend bool operator<(const EdgeSide& p, const EdgeSide& q) noexcept {
        return p.a != q.a ? p.a < q.a : p.b != q.b ? p.b < q.b : p.face < q.face;
    }
};

/// All sides, sorted by edge. In a closed mesh, edge e has the sides 2e and 2e + 1.
inline std::vector<EdgeSide> edge_sides(std::span<const std::array<std::uint32_t, 3>> faces) {
    std::vector<EdgeSide> sides;
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [a, b] = std::minmax(faces[f][k], faces[f][(k + 1) % 3]);
            sides.push_back({a, b, f, faces[f][(k + 2) % 3]});
        }
    }
    std::sort(sides.begin(), sides.end());
    return sides;
}

/// Index of the edge between two vertices.
inline std::size_t edge_between(std::span<const EdgeSide> sides, std::uint32_t v, std::uint32_t w) {
    const auto [a, b] = std::minmax(v, w);
    return std::size_t(std::lower_bound(sides.begin(), sides.end(), EdgeSide{a, b, 0, 0}) - sides.begin()) /
           2;
}

/// Mirror image of each vertex; empty without a mirror.
using MirrorImages = std::vector<std::uint32_t>;

/// A closed mesh, refined to at least 1,500 faces.
class PartSurface {
public:
    using Point = Vec<double, 3>;
    using Face = std::array<std::uint32_t, 3>;

    ///   faces   must use all points
    ///   images  mirror images of the points, or empty; the faces must be symmetric too
    PartSurface(std::vector<Point> points, std::vector<Face> faces, MirrorImages images)
        : points_(std::move(points))
        , faces_(std::move(faces))
        , images_(std::move(images)) {
        for (std::uint32_t f = 0; f < faces_.size(); ++f) origins_.push_back(f);
        constexpr std::size_t enough = 1500; // more refinement changed no joint of our test cages
        while (faces_.size() < enough) refine();
        link();
        areas_.assign(points_.size(), 0);
        for (const Face& face : faces_) {
            const double area = length(area_normal(points_, face)) / 2;
            total_area_ += area;
            for (const auto v : face) areas_[v] += area / 3;
        }
    }

    std::size_t size() const noexcept { return points_.size(); }
    const Point& operator[](std::size_t v) const noexcept { return points_[v]; }
    std::span<const Face> faces() const noexcept { return faces_; }
    std::uint32_t origin(std::size_t f) const noexcept { return origins_[f]; } ///< the face that was refined
    double area(std::size_t v) const noexcept { return areas_[v]; } ///< a third of the areas of its faces
    double total_area() const noexcept { return total_area_; }
    bool is_mirrored() const noexcept { return !images_.empty(); }
    std::uint32_t image(std::uint32_t v) const noexcept { return images_.empty() ? v : images_[v]; }
    /// Vertices connected to a vertex by an edge.
    std::span<const std::uint32_t> around(std::size_t v) const noexcept {
        return std::span(links_).subspan(first_[v], neighbours_[v]);
    }

    /// Distances from the nearest of several vertices along edges and across unfolded pairs of faces. They
    /// exceed geodesic distances by a few percent. O(n log n).
    std::vector<double> distances(std::span<const std::uint32_t> from) const {
        std::vector<double> distance(size(), std::numeric_limits<double>::infinity());
        using Entry = std::pair<double, std::uint32_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
        for (const auto v : from) {
            distance[v] = 0;
            queue.push({0, v});
        }
        while (!queue.empty()) {
            const auto [d, v] = queue.top();
            queue.pop();
            if (d > distance[v]) continue;
            for (std::size_t n = first_[v]; n < first_[v + 1]; ++n) {
                const double further = d + lengths_[n];
                if (!(further < distance[links_[n]])) continue;
                distance[links_[n]] = further;
                queue.push({further, links_[n]});
            }
        }
        return distance;
    }

    /// Averages a function with its mirror image.
    void make_symmetric(std::vector<double>& f) const {
        for (std::uint32_t v = 0; v < size(); ++v) {
            const auto w = image(v);
            if (w > v) f[v] = f[w] = 0.5 * (f[v] + f[w]);
        }
    }

private:
    void refine() {
        const auto sides = edge_sides(faces_);
        const auto first = std::uint32_t(points_.size());
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            return first + std::uint32_t(edge_between(sides, a, b));
        };
        for (std::size_t e = 0; e < sides.size(); e += 2) {
            points_.push_back(0.5 * (points_[sides[e].a] + points_[sides[e].b]));
            if (!images_.empty()) images_.push_back(middle(images_[sides[e].a], images_[sides[e].b]));
        }
        std::vector<Face> finer;
        std::vector<std::uint32_t> origins;
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            const auto [a, b, c] = faces_[f];
            const auto ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
            origins.insert(origins.end(), 4, origins_[f]);
        }
        faces_ = std::move(finer);
        origins_ = std::move(origins);
    }

    /// Length of the straight path between the tips of two faces unfolded about their common edge; none if
    /// the path does not cross the edge.
    std::optional<double> way_across(const EdgeSide& one, const EdgeSide& other) const {
        const Point edge = points_[one.b] - points_[one.a];
        const double edge_length = length(edge);
        std::array<double, 2> along{}, off{};
        for (std::size_t k = 0; k < 2; ++k) {
            const Point tip = points_[k == 0 ? one.third : other.third] - points_[one.a];
            along[k] = dot(tip, edge) / edge_length;
            off[k] = std::sqrt((std::max)(0.0, dot(tip, tip) - along[k] * along[k]));
        }
        const double both = off[0] + off[1];
        if (!(both > 0)) return std::nullopt;
        const double at = along[0] + (along[1] - along[0]) * off[0] / both;
        if (!(at > 0 && at < edge_length)) return std::nullopt;
        return std::hypot(along[0] - along[1], both);
    }

    void link() {
        struct Link {
            std::uint32_t from, to;
            bool is_across;
            double length;
        };
        std::vector<Link> all;
        const auto add = [&](std::uint32_t v, std::uint32_t w, bool across, double distance) {
            all.push_back({v, w, across, distance});
            all.push_back({w, v, across, distance});
        };
        const auto sides = edge_sides(faces_);
        for (std::size_t e = 0; e < sides.size(); e += 2) {
            const auto [a, b, face, third] = sides[e];
            add(a, b, false, length(points_[b] - points_[a]));
            if (const auto way = way_across(sides[e], sides[e + 1]))
                add(third, sides[e + 1].third, true, *way);
        }
        std::sort(all.begin(), all.end(), [](const Link& p, const Link& q) {
            if (p.from != q.from) return p.from < q.from;
            if (p.is_across != q.is_across) return q.is_across;
            return p.to != q.to ? p.to < q.to : p.length < q.length;
        });
        first_.assign(size() + 1, 0);
        neighbours_.assign(size(), 0);
        for (const Link& link : all) {
            ++first_[link.from + 1];
            neighbours_[link.from] += link.is_across ? 0 : 1;
            links_.push_back(link.to);
            lengths_.push_back(link.length);
        }
        for (std::size_t v = 0; v < size(); ++v) first_[v + 1] += first_[v];
    }

    std::vector<Point> points_;
    std::vector<Face> faces_;
    MirrorImages images_;
    std::vector<std::uint32_t> origins_;
    std::vector<double> areas_;
    double total_area_ = 0;
    // Links of vertex v start at first_[v]; those along edges come first.
    std::vector<std::size_t> first_, neighbours_;
    std::vector<std::uint32_t> links_;
    std::vector<double> lengths_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
