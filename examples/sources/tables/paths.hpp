#pragma once

// Coordinates as means over paths from a point to the boundary: mean value coordinates by straight rays,
// harmonic coordinates by Brownian paths (H: Joshi et al., Harmonic Coordinates for Character Articulation,
// 2007, section 2, fig. 3).

#include "svg/path.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <span>
#include <vector>

namespace cageform_sources {

using namespace cageform_support;

/// The edges of a cage's loops, with the numbers of their vertices.
class PathBoundary {
public:
    /// A place on an edge: a share of the way from one vertex to another.
    struct Place {
        Point2 at;
        std::size_t from = 0, to = 0;
        double share = 0;
        double distance = 0; ///< from the given point
    };

    explicit PathBoundary(std::span<const std::vector<Point2>> loops) {
        std::size_t first = 0;
        for (const auto& loop : loops) {
            for (std::size_t k = 0; k < loop.size(); ++k) {
                const std::size_t next = (k + 1) % loop.size();
                edges_.push_back({loop[k], loop[next], first + k, first + next});
            }
            first += loop.size();
        }
        vertices_ = first;
    }

    std::size_t vertices() const { return vertices_; }

    /// The crossings of a ray with the boundary, unordered. From an inner point, the nearest crossing leaves
    /// the inside, the second enters it again, and so on.
    std::vector<Place> crossings(const Point2& p, double angle) const {
        const Point2 along{std::cos(angle), std::sin(angle)};
        std::vector<Place> all;
        for (const Edge& edge : edges_) {
            const double a = side(along, p, edge.a), b = side(along, p, edge.b);
            if ((a > 0) == (b > 0)) continue; // a vertex on the ray belongs to one of its edges
            const double share = a / (a - b);
            const Point2 at = edge.at(share);
            const double distance = (at.x - p.x) * along.x + (at.y - p.y) * along.y;
            if (distance > 0) all.push_back({at, edge.from, edge.to, share, distance});
        }
        return all;
    }

    Place nearest(const Point2& p) const {
        Place best;
        best.distance = HUGE_VAL;
        for (const Edge& edge : edges_) {
            const double ex = edge.b.x - edge.a.x, ey = edge.b.y - edge.a.y;
            const double share = std::fmin(
                std::fmax(((p.x - edge.a.x) * ex + (p.y - edge.a.y) * ey) / (ex * ex + ey * ey), 0), 1);
            const Point2 at = edge.at(share);
            const double distance = std::hypot(at.x - p.x, at.y - p.y);
            if (distance < best.distance) best = {at, edge.from, edge.to, share, distance};
        }
        return best;
    }

private:
    struct Edge {
        Point2 a, b;
        std::size_t from, to;

        Point2 at(double share) const { return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)}; }
    };
    static double side(const Point2& along, const Point2& p, const Point2& q) {
        return along.x * (q.y - p.y) - along.y * (q.x - p.x);
    }

    std::vector<Edge> edges_;
    std::size_t vertices_ = 0;
};

/// Mean value coordinates by rays: the mean of the vertices' hat functions at the crossings, weighted by one
/// over the distance. Crossings at which a ray enters the inside have negative weights. The error falls with
/// the square of the number of rays.
///
///   p      inside
///   cost   O(#rays · #edges)
inline std::vector<double> weights_by_rays(const PathBoundary& boundary, const Point2& p, std::size_t rays) {
    std::vector<double> weights(boundary.vertices(), 0.0);
    double sum = 0;
    for (std::size_t n = 0; n < rays; ++n) {
        const double angle = 2 * std::numbers::pi * (double(n) + 0.5) / double(rays);
        const auto crossings = boundary.crossings(p, angle);
        for (const auto& place : crossings) {
            std::size_t before = 0;
            for (const auto& other : crossings) before += other.distance < place.distance ? 1 : 0;
            const double weight = (before % 2 == 0 ? 1 : -1) / place.distance; // leaves, or enters again
            weights[place.from] += weight * (1 - place.share);
            weights[place.to] += weight * place.share;
            sum += weight;
        }
    }
    for (double& weight : weights) weight /= sum;
    return weights;
}

/// A Brownian path from a point to the boundary, by jumps to random points of circles ("walk on spheres",
/// Muller 1956). Each circle is as large as fits inside, with a radius of at most `longest`. The path ends
/// nearer than `near` to the boundary. The distribution of the ends is exact up to `near`.
///
///   visit   called with every place on the way
template <class Visit>
PathBoundary::Place brownian_end(const PathBoundary& boundary, Point2 p, double near, double longest,
                                 std::mt19937_64& random, Visit&& visit) {
    for (;;) {
        visit(p);
        const auto place = boundary.nearest(p);
        if (place.distance < near) return place;
        const double angle = 2 * std::numbers::pi * double(random() >> 11) * 0x1p-53;
        const double radius = std::fmin(place.distance, longest);
        p = {p.x + radius * std::cos(angle), p.y + radius * std::sin(angle)};
    }
}

/// Means over paths, and their standard errors.
struct PathWeights {
    std::vector<double> mean, error;
};

/// Harmonic coordinates by Brownian paths: the mean of the hat functions at their ends. The errors fall with
/// the square root of the number of paths.
///
///   p      inside
///   near   largest distance of an end from the boundary; 1e-4 of the cage's size biases means by ≤ 1e-4
///   cost   O(#paths · log(1 / near) · #edges)
inline PathWeights weights_by_brownian_paths(const PathBoundary& boundary, const Point2& p, std::size_t paths,
                                             double near, std::mt19937_64& random) {
    PathWeights weights{std::vector<double>(boundary.vertices(), 0.0),
                        std::vector<double>(boundary.vertices(), 0.0)};
    std::vector<double>& squares = weights.error;
    for (std::size_t n = 0; n < paths; ++n) {
        const auto end = brownian_end(boundary, p, near, HUGE_VAL, random, [](const Point2&) {});
        weights.mean[end.from] += 1 - end.share;
        weights.mean[end.to] += end.share;
        squares[end.from] += (1 - end.share) * (1 - end.share);
        squares[end.to] += end.share * end.share;
    }
    for (std::size_t i = 0; i < boundary.vertices(); ++i) {
        const double mean = weights.mean[i] / double(paths);
        weights.mean[i] = mean;
        weights.error[i] = std::sqrt(std::fmax(squares[i] / double(paths) - mean * mean, 0) / double(paths));
    }
    return weights;
}

} // namespace cageform_sources
