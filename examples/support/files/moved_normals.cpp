#include "files/moved_normals.hpp"

#include <algorithm>
#include <cmath>

namespace cageform_support {

namespace {

/// Rotates `v` by the smallest rotation between two directions. Returns `v` unchanged if they are equal up to
/// rounding, or undefined.
Point3 turned(const Point3& v, const Point3& from, const Point3& to) {
    const auto length = [](const Point3& p) { return std::hypot(p[0], p[1], p[2]); };
    const double from_length = length(from), to_length = length(to);
    if (!(from_length > 0) || !(to_length > 0) || !std::isfinite(from_length + to_length)) return v;
    const Point3 a = (1 / from_length) * from, b = (1 / to_length) * to;
    if (length(b - a) < 1e-12) return v;
    const auto half_turn = [](const Point3& p, const Point3& axis) {
        return (2 * dot(axis, p) / dot(axis, axis)) * axis - p;
    };
    if (length(a + b) < 1e-12) { // opposite: about any perpendicular axis
        Point3 across{};
        across[std::fabs(a[0]) < 0.6 ? 0 : 1] = 1;
        return half_turn(v, across - dot(across, a) * a);
    }
    return half_turn(half_turn(v, a), a + b); // two half turns: a rotation by twice the angle between
}

/// Returns `before` if both are equal up to rounding, so that unchanged vectors keep their digits; else
/// `after`.
Point3 unless_same(const Point3& before, const Point3& after) {
    const Point3 change = after - before;
    return dot(change, change) < 1e-24 * dot(before, before) ? before : after;
}

} // namespace

std::optional<Point3> moved_normal(const Jacobian3& jacobian, const Point3& n) {
    const auto& [a, b, c] = jacobian;
    const Point3 across_a = cross(b, c); // J⁻ᵀ times the determinant is the matrix of cofactors
    const double volume = dot(a, across_a);
    const Point3 moved = n[0] * across_a + n[1] * cross(c, a) + n[2] * cross(a, b);
    const double length = std::hypot(moved[0], moved[1], moved[2]), own = std::hypot(n[0], n[1], n[2]);
    constexpr double flat = 1e-12; // of a volume, relative to a cuboid with the same edge lengths
    if (!(std::fabs(volume) > flat * std::sqrt(dot(a, a) * dot(b, b) * dot(c, c))) || !(length > 0) ||
        !std::isfinite(length))
        return std::nullopt;
    return unless_same(n, (std::copysign(own, volume) / length) * moved);
}

MovedNormals::MovedNormals(const MeshFile& file, const MovedVertices& moved)
    : file_(file)
    , moved_(moved)
    , normals_(file.normals) {
    const std::size_t count = file.normals.size();
    if (count == 0) return;
    std::vector<Point3> before(count), after(count), sum(count);
    std::vector<std::size_t> last(count, file.faces.size()); // the face that was added last
    for (std::size_t f = 0; f < file.faces.size(); ++f) {
        const Point3 rest = detail::area_vector(file.faces[f], file.vertices);
        const Point3 now = detail::area_vector(file.faces[f], moved.places);
        for (const auto& [vertex, normal] : file.faces[f].corners) {
            if (normal == MeshCorner::none) continue;
            if (!moved.jacobians.empty()) {
                if (const auto n = moved_normal(moved.jacobians[vertex], file.normals[normal]))
                    sum[normal] = sum[normal] + *n;
            }
            if (last[normal] == f) continue;
            last[normal] = f;
            before[normal] = before[normal] + rest;
            after[normal] = after[normal] + now;
        }
    }
    const double side = is_mirrored(file.vertices, moved.places) ? -1 : 1;
    const auto length = [](const Point3& v) { return std::hypot(v[0], v[1], v[2]); };
    for (std::size_t i = 0; i < count; ++i) {
        if (const double far = length(sum[i]); far > 0)
            normals_[i] = unless_same(normals_[i], (length(normals_[i]) / far) * sum[i]);
        else if (const Point3 now = side * after[i]; before[i] != now)
            normals_[i] = turned(file.normals[i], before[i], now);
    }
}

Point3 MovedNormals::of_corner(std::uint32_t vertex, std::uint32_t normal) const {
    const auto own = moved_.jacobians.empty() ? std::nullopt
                                              : moved_normal(moved_.jacobians[vertex], file_.normals[normal]);
    return own.value_or(normals_[normal]);
}

std::vector<std::vector<std::uint32_t>> MovedNormals::split() const {
    constexpr double apart = 1e-5; // radians
    if (moved_.jacobians.empty()) return {};
    std::vector<std::vector<std::uint32_t>> vertices(normals_.size());
    std::vector<bool> is_apart(normals_.size());
    bool is_any = false;
    for (const MeshFace& face : file_.faces) {
        for (const auto& [vertex, normal] : face.corners) {
            if (normal == MeshCorner::none) continue;
            const Point3 own = of_corner(vertex, normal), across = cross(own, normals_[normal]);
            vertices[normal].push_back(vertex);
            if (!(std::sqrt(dot(across, across)) > apart * dot(own, normals_[normal]))) continue;
            is_apart[normal] = is_any = true;
        }
    }
    if (!is_any) return {};
    for (std::size_t n = 0; n < vertices.size(); ++n) {
        auto& of_normal = vertices[n];
        if (!is_apart[n]) of_normal.clear();
        std::sort(of_normal.begin(), of_normal.end());
        of_normal.erase(std::unique(of_normal.begin(), of_normal.end()), of_normal.end());
    }
    return vertices;
}

} // namespace cageform_support
