// Makes coordinates of cages in the plane: for the files that compile it, one for each scalar.
#pragma once

#include "cli/coordinates_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cageform_support {

namespace detail {

using Disk = cageform::CurvedGreenDisk<double>;

inline bool holds(const Disk& disk, const Point2& p) {
    return std::hypot(p.x - disk.centre[0], p.y - disk.centre[1]) <= disk.radius * (1 + 1e-12);
}
inline Disk disk_on(const Point2& a, const Point2& b) {
    return {{(a.x + b.x) / 2, (a.y + b.y) / 2}, std::hypot(b.x - a.x, b.y - a.y) / 2};
}
/// Returns the disk with three points on its circle; where they lie on a line, that of the two farthest.
inline Disk disk_on(const Point2& a, const Point2& b, const Point2& c) {
    const double bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
    const double twice = 2 * (bx * cy - by * cx), b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    const double x = (cy * b2 - by * c2) / twice, y = (bx * c2 - cx * b2) / twice;
    if (std::isfinite(x) && std::isfinite(y)) return {{a.x + x, a.y + y}, std::hypot(x, y)};
    const std::array pairs{disk_on(a, b), disk_on(b, c), disk_on(c, a)};
    return *std::max_element(pairs.begin(), pairs.end(),
                             [](const Disk& one, const Disk& other) { return one.radius < other.radius; });
}

/// The smallest disk that holds points. (Welzl 1991, point by point: a point that the disk of those before
/// does not hold lies on the circle of the next.)
inline Disk smallest_disk(const std::vector<Point2>& points) {
    Disk disk{{points.front().x, points.front().y}, 0};
    for (std::size_t i = 1; i < points.size(); ++i) {
        if (holds(disk, points[i])) continue;
        disk = disk_on(points[i], points[0]);
        for (std::size_t j = 1; j < i; ++j) {
            if (holds(disk, points[j])) continue;
            disk = disk_on(points[i], points[j]);
            for (std::size_t k = 0; k < j; ++k) {
                if (!holds(disk, points[k])) disk = disk_on(points[i], points[j], points[k]);
            }
        }
    }
    return disk;
}

template <class T>
ChosenCoordinates<T, 2> curved_coordinates(const CoordinatesChoice& choice, const CageFile& file) {
    cageform::CoordinateOptions<T> options;
    if (choice.in_disk) {
        auto [centre, radius] = smallest_disk(file.vertices);
        constexpr double margin = 1e-6; // of the radius, so that no control point lies on the circle
        radius = choice.disk_radius > 0 ? choice.disk_radius : (1 + margin) * radius;
        options.curved_green.disk = {cageform::vec_cast<T>(centre), static_cast<T>(radius)};
    }
    return cageform::make_coordinates(choice.type(), file.curved_polygon<T>(), options);
}

} // namespace detail

template <class T>
ChosenCoordinates<T, 2> make_coordinates(const CoordinatesChoice& choice, const CageFile& file) {
    if (choice.in_disk && !file.curves)
        warn("--disk is not used: it is for cages of --coordinates curved-green");
    if (file.curves) return detail::curved_coordinates<T>(choice, file);
    if (file.lattice) return lattice_coordinates<T>(choice, *file.lattice);
    return file.visit<T>([&](const auto& cage) -> ChosenCoordinates<T, 2> {
        if (choice.type() == cageform::CoordinateType::harmonic)
            return harmonic(cage, choice.harmonic_options(2));
        return cageform::make_coordinates(choice.type(), cage);
    });
}

} // namespace cageform_support
