#pragma once

// Camera for pictures of meshes and splats.

#include "pictures/mesh_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace cageform_support::detail {

inline Point3 unit(const Point3& v) {
    const double length = std::hypot(v[0], v[1], v[2]);
    return length > 0 ? (1 / length) * v : v;
}

/// Axis-aligned bounding box of lists of points.
struct Box3 {
    Point3 low, high;
};
inline Box3 box_of(const std::vector<std::span<const Point3>>& lists) {
    constexpr double most = std::numeric_limits<double>::max();
    Box3 box{{most, most, most}, {-most, -most, -most}};
    for (const auto& list : lists) {
        for (const Point3& v : list) {
            for (std::size_t k = 0; k < 3; ++k) {
                box.low[k] = std::min(box.low[k], v[k]);
                box.high[k] = std::max(box.high[k], v[k]);
            }
        }
    }
    return box;
}

/// Looks at the centre of all points, which fill a picture of the given size up to a margin.
class Camera {
public:
    enum class Rays : std::uint8_t { converging, parallel };

    Camera(const ViewDirections& view, Rays rays, const std::vector<std::span<const Point3>>& lists,
           double width, double height)
        : view_(view)
        , rays_(rays) {
        const auto [low, high] = box_of(lists);
        middle_ = 0.5 * low + 0.5 * high;
        distance_ = 2 * std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
        if (!(distance_ > 0)) distance_ = 1;

        constexpr double most = std::numeric_limits<double>::max();
        Point2 least{most, most}, greatest{-most, -most};
        for (const auto& list : lists) {
            for (const Point3& v : list) {
                const Point3 p = project(v);
                least = {std::min(least.x, p[0]), std::min(least.y, p[1])};
                greatest = {std::max(greatest.x, p[0]), std::max(greatest.y, p[1])};
            }
        }
        constexpr double filled = 0.9;        // of the width or of the height
        const double flat = 1e-9 * distance_; // a figure of no width or no height
        scale_ = filled * std::min(width / std::max(greatest.x - least.x, flat),
                                   height / std::max(greatest.y - least.y, flat));
        offset_ = {width / 2 - scale_ * (least.x + greatest.x) / 2,
                   height / 2 - scale_ * (least.y + greatest.y) / 2};
    }

    /// Position in the picture, y downwards, and nearness. Nearness is linear in the picture along a line;
    /// with parallel rays it is in pixels.
    Point3 project(const Point3& v) const {
        const Point3 d = seen(v - middle_);
        const bool parallel = rays_ == Rays::parallel;
        const double nearness = parallel ? 1.0 : 1 / (1 - d[2] / distance_);
        return {offset_.x + scale_ * nearness * d[0], offset_.y - scale_ * nearness * d[1],
                parallel ? scale_ * d[2] : nearness};
    }

    /// Increase of a point's nearness if it moves towards the camera by the length of `pixels` pixels.
    double nearer(double pixels, double nearness) const {
        return rays_ == Rays::parallel ? pixels : pixels * nearness * nearness / (scale_ * distance_);
    }

    /// Gradients of the two picture coordinates with respect to `v`.
    std::array<Point3, 2> gradients(const Point3& v) const {
        const Point3 d = seen(v - middle_);
        const bool parallel = rays_ == Rays::parallel;
        const double nearness = parallel ? 1.0 : 1 / (1 - d[2] / distance_);
        const double change = parallel ? 0.0 : nearness * nearness / distance_;
        return {scale_ * (nearness * view_.right + (d[0] * change) * view_.towards),
                -scale_ * (nearness * view_.up + (d[1] * change) * view_.towards)};
    }

    /// The centre of perspective.
    Point3 eye() const { return middle_ + distance_ * view_.towards; }

    /// A direction in camera coordinates: right, up, towards the camera.
    Point3 seen(const Point3& v) const {
        return {dot(v, view_.right), dot(v, view_.up), dot(v, view_.towards)};
    }

private:
    ViewDirections view_;
    Rays rays_;
    Point3 middle_{};
    double distance_ = 1;
    double scale_ = 1;
    Point2 offset_{};
};

} // namespace cageform_support::detail
