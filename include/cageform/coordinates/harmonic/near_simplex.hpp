// The linear functions of a simplex of vertices, for near_rows.hpp.
#pragma once

#include <cageform/cage/detail/primitives.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A tetrahedron with corners among given vertices, or a triangle if all vertices lie in a plane. Its linear
/// functions β_i are 1 at corner i and 0 at the others.
class NearSimplex {
    using Point = Vec<double, 3>;

public:
    /// Sets four vertices as corners. Returns the largest |β_i| at any vertex, or infinity if they are
    /// coplanar.
    double set(std::span<const Point> vertices, const std::array<std::uint32_t, 4>& corners) {
        corners_.assign(corners.begin(), corners.end());
        return set_functions(vertices);
    }
    /// Sets the vertex nearest to the origin, the farthest from it, and those that give the largest triangle
    /// and tetrahedron. Returns false if all vertices lie on a line.
    bool set_largest(std::span<const Point> vertices) {
        const auto best = [&](const auto& measure) {
            std::size_t found = 0;
            double largest = -1;
            for (std::size_t v = 0; v < vertices.size(); ++v) {
                const double m = measure(vertices[v]);
                if (m > largest) {
                    largest = m;
                    found = v;
                }
            }
            return std::pair(std::uint32_t(found), largest);
        };
        const auto first = best([](const Point& p) { return 1 / (1e-9 + dot(p, p)); }).first;
        const auto a = vertices[first];
        const auto [second, size] = best([&](const Point& p) { return length(p - a); });
        const auto b = vertices[second];
        const auto [third, area] = best([&](const Point& p) { return length(cross(b - a, p - a)); });
        if (!(area > 1e-6 * size * size)) return false;
        const auto normal = cross(b - a, vertices[third] - a);
        const auto [fourth, volume] = best([&](const Point& p) { return std::fabs(dot(normal, p - a)); });
        corners_.assign({first, second, third});
        if (volume > 1e-6 * area * size) corners_.push_back(fourth);
        return set_functions(vertices) < std::numeric_limits<double>::infinity();
    }

    /// Turns 2 F(D_v) of all vertices into F(L_v).
    ///
    ///   least  smaller amounts become 0 first, except at corners, so that sums stay zero
    ///   off    F of the position: zero for rows that are exact for linear functions
    void finish(std::span<double> amount, double least, const Point& off) const noexcept {
        for (std::size_t v = 0; v < amount.size(); ++v) {
            const bool is_corner = std::find(corners_.begin(), corners_.end(), v) != corners_.end();
            if (std::fabs(amount[v]) <= least && !is_corner) amount[v] = 0;
        }
        std::array<double, 4> of_corner{};
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            of_corner[i] = dot(slope_[i], off);
            for (std::size_t v = 0; v < beta_.size(); ++v) of_corner[i] -= beta_[v][i] * amount[v];
        }
        for (std::size_t i = 0; i < corners_.size(); ++i) amount[corners_[i]] += of_corner[i];
    }

private:
    double set_functions(std::span<const Point> vertices) {
        const bool is_flat = corners_.size() < 4;
        const auto a = vertices[corners_[0]], u = vertices[corners_[1]] - a, v = vertices[corners_[2]] - a,
                   w = is_flat ? cross(u, v) : vertices[corners_[3]] - a;
        const double volume = dot(cross(u, v), w);
        if (!(std::fabs(volume) > 1e-12)) return std::numeric_limits<double>::infinity();
        slope_ = {Point{}, (1 / volume) * cross(v, w), (1 / volume) * cross(w, u),
                  is_flat ? Point{} : (1 / volume) * cross(u, v)};
        slope_[0] = -1.0 * (slope_[1] + slope_[2] + slope_[3]);
        double largest = 0;
        beta_.resize(vertices.size());
        for (std::size_t n = 0; n < vertices.size(); ++n) {
            auto& beta = beta_[n];
            for (std::size_t i = 1; i < 4; ++i) beta[i] = dot(slope_[i], vertices[n] - a);
            beta[0] = 1 - beta[1] - beta[2] - beta[3];
            for (const double x : beta) largest = (std::max)(largest, std::fabs(x));
        }
        return largest;
    }

    std::vector<std::uint32_t> corners_;
    std::vector<std::array<double, 4>> beta_; ///< by vertex
    std::array<Point, 4> slope_{};            ///< gradients of the linear functions
};

} // namespace cageform::inline CAGEFORM_ABI::detail
