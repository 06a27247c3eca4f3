// The noise of a surface: how far its vertices are from quadrics through their neighbours.
#pragma once

#include <cageform/fit/closest_places.hpp>

#include <Eigen/Dense>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the standard deviation of the vertices from the quadric through their 18 nearest others: 1.4826
/// times the median of |residual| / √(1 + leverage). Neighbours are near by position and normal.
///
///   edge   the median length of the surface's edges
///   order  the vertices to measure, the first 4,000 with a normal
inline double surface_noise(std::span<const Vec<double, 3>> vertices, std::span<const Vec<double, 3>> normals,
                            double edge, const std::vector<std::uint32_t>& order) {
    constexpr std::size_t most = 4000, neighbours = 18;
    std::vector<std::uint32_t> used;
    for (const std::uint32_t i : order) {
        if (dot(normals[i], normals[i]) > 0) used.push_back(i);
    }
    if (used.size() <= neighbours || !(edge > 0)) return 0;
    const auto six = [&](std::uint32_t i) { return with_normal(vertices[i], normals[i], 3 * edge); };
    const BoxTree<6> tree(used.size(),
                          [&](std::uint32_t n) { return Bounds<double, 6>{six(used[n]), six(used[n])}; });
    std::vector<double> residuals;
    for (std::size_t n = 0; n < used.size() && n < most; ++n) {
        const std::uint32_t i = used[n];
        std::vector<std::pair<double, std::uint32_t>> nearest; // a heap: the farthest first
        tree.for_each_near(six(i), std::numeric_limits<double>::infinity(), [&](std::uint32_t m) {
            const auto e = six(used[m]) - six(i);
            if (used[m] != i) {
                nearest.emplace_back(dot(e, e), used[m]);
                std::push_heap(nearest.begin(), nearest.end());
            }
            if (nearest.size() > neighbours) {
                std::pop_heap(nearest.begin(), nearest.end());
                nearest.pop_back();
            }
            return nearest.size() < neighbours ? std::numeric_limits<double>::infinity()
                                               : nearest.front().first;
        });
        Vec<double, 3> up{};
        double size = 0;
        for (const auto& [square, m] : nearest) {
            up = up + normals[m];
            const auto e = vertices[m] - vertices[i];
            size += std::sqrt(dot(e, e)) / double(nearest.size());
        }
        up = unit_or_zero(up);
        if (dot(up, up) == 0 || !(size > 0)) continue;
        const auto along = unit_or_zero(
            cross(up, std::fabs(up[0]) < 0.9 ? Vec<double, 3>{1, 0, 0} : Vec<double, 3>{0, 1, 0}));
        const auto across = cross(up, along);
        Eigen::Matrix<double, 6, 6> products =
            1e-6 * double(neighbours) * Eigen::Matrix<double, 6, 6>::Identity();
        Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
        for (const auto& [square, m] : nearest) {
            const auto e = vertices[m] - vertices[i];
            const double x = dot(e, along) / size, y = dot(e, across) / size;
            const Eigen::Matrix<double, 6, 1> row{1, x, y, x * x, x * y, y * y};
            products += row * row.transpose();
            right += dot(e, up) * row;
        }
        const Eigen::Matrix<double, 6, 6> inverse = products.inverse();
        residuals.push_back(std::fabs(inverse.row(0).dot(right)) / std::sqrt(1 + inverse(0, 0)));
    }
    if (residuals.empty()) return 0;
    const auto middle = residuals.begin() + std::ptrdiff_t(residuals.size() / 2);
    std::nth_element(residuals.begin(), middle, residuals.end());
    return 1.4826 * *middle;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
