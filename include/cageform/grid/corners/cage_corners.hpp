// The corners of a cage in 2D and the free radius around them.
#pragma once

#include <cageform/cage/cell_complex.hpp>
#include <cageform/cage/detail/loop_sides.hpp>

#include <numbers>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Inserts j into the neighbours of i counter-clockwise. A vertex with one edge lists its neighbour
/// twice, because the inside is all around the edge.
inline void add_neighbour(std::span<const Vec<double, 2>> vertices, std::vector<std::size_t>& of_i,
                          std::size_t i, std::size_t j) {
    if (of_i.empty()) {
        of_i = {j, j};
        return;
    }
    // The angle from the first edge, counter-clockwise in (0, 2π].
    const auto angle_to = [&](std::size_t k) {
        const auto a = vertices[of_i.front()] - vertices[i], b = vertices[k] - vertices[i];
        const double angle = std::atan2(cross(a, b), dot(a, b));
        return of_i.front() == k || angle <= 0 ? angle + 2 * std::numbers::pi : angle;
    };
    of_i.insert(
        std::find_if(of_i.begin() + 1, of_i.end(), [&](std::size_t k) { return angle_to(k) > angle_to(j); }),
        j);
}

/// Returns the neighbours of every vertex of a Polygon or a CellComplex, counter-clockwise. Two consecutive
/// neighbours define the two edges of a corner of the inside. A vertex without edges has no neighbours.
///
///   vertices  positions of all vertices
template <class Cage>
std::vector<std::vector<std::size_t>> neighbours_of_vertices(const Cage& cage,
                                                             std::span<const Vec<double, 2>> vertices) {
    std::vector<std::vector<std::size_t>> all(vertices.size());
    const auto& polygon = boundary_of(cage);
    for (std::size_t n = 0; n < polygon.loops().size(); ++n) {
        const bool left = inside_is_left(polygon, n);
        polygon.loops()[n].for_each_edge([&](std::size_t i, std::size_t j) {
            all[i].insert(left ? all[i].begin() : all[i].end(), j);
            all[j].insert(left ? all[j].end() : all[j].begin(), i);
        });
    }
    const auto& cells = interior_cells(cage);
    for (const auto& [i, j] : cells.facets) {
        add_neighbour(vertices, all[i], i, j);
        add_neighbour(vertices, all[j], j, i);
    }
    return all;
}

/// Returns the radius, at most `most`, of the disc around a vertex that no other feature of the boundary
/// enters. `vertices` and the result are in units of `spacing`.
template <class Cage>
double free_radius(std::size_t i, const Cage& cage, std::span<const Vec<double, 2>> vertices, double spacing,
                   double most) {
    double radius = most;
    const auto exclude = [&](std::size_t j, std::size_t k, double margin) {
        const auto &p = vertices[i], &a = vertices[j], &b = vertices[k];
        radius = (std::min)(radius, j == i || k == i ? length(a - b) : distance_to_segment(p, a, b) - margin);
    };
    boundary_of(cage).for_each_edge([&](std::size_t j, std::size_t k) { exclude(j, k, 0); });
    const auto& cells = interior_cells(cage);
    for (const auto& [j, k] : cells.facets) exclude(j, k, 0);
    for (const auto& bone : cells.bones) exclude(bone.i, bone.j, bone.radius / spacing);
    return radius;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
