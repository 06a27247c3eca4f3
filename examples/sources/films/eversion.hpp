#pragma once

// Sphere eversion by formulas: A. and W. Bednorz, "Analytic sphere eversion using ruled surfaces",
// Differential Geometry and its Applications 64 (2019), for n = 2, topologically Morin's eversion.

#include "files/mesh_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace cageform_sources {

using namespace cageform_support;

/// The parameters of a stage. The surface is ruled for `lambda` = 1, and approaches a sphere for smaller
/// values.
struct EversionStage {
    double lambda = 1, t = 0, p = 1, q = 0, xi = 1, alpha = 1, eta = 2;
};

inline constexpr double eversion_q = 2.0 / 3; // the source's Q: the sphere has the radius √Q
inline constexpr double eversion_w = 2;

/// A stage up to the halfway surface, on four legs of length 1. At 0 it is the sphere; at 3.5, the middle of
/// the last leg, the halfway surface. Legs end at parameters of the source. α is quadratic, because the
/// formulas contain its root.
inline EversionStage stage_on_legs(double leg) {
    constexpr double q = eversion_q;
    if (leg <= 1) return {leg, -1 / q, 0, q, 0, 0, 1};
    if (leg <= 2) {
        const double u = leg - 1;
        return {1, -1 / q, 0, q, u, u * u, 1 + u};
    }
    if (leg <= 3) return {1, -1 / q, leg - 2, q * (3 - leg), 1, 1, 2};
    return {1, (2 * (leg - 3) - 1) / q, 1, 0, 1, 1, 2};
}

/// A point of the surface.
///
///   theta, phi   latitude in [−π/2, π/2] and longitude, in radians; poles are no special case
///
/// The source's formulas, each multiplied by the power of cos θ that makes it finite at the poles. The last
/// formula is rearranged to avoid cancellation for small α.
inline Point3 eversion_point(const EversionStage& at, double theta, double phi) {
    const double s = std::sin(theta), c = std::cos(theta), c2 = c * c;
    const double sin = std::sin(phi), cos = std::cos(phi), sin2 = 2 * sin * cos, cos2 = cos * cos - sin * sin;
    const double h = eversion_w * s; // times cos² θ
    const double saddle = h * (sin2 - at.q * at.t) - c2 * (at.t / 2) * cos2;
    if (at.lambda < 1) {
        const double l = at.lambda, rest = at.t * (1 - l + l * c2);
        const double x = rest * cos - l * h * sin, y = rest * sin + l * h * cos, r2 = x * x + y * y;
        const double pole = std::pow(at.eta, 1.25) * at.t * std::sqrt(std::fabs(at.t)) * s;
        const double z = l * c2 * saddle - (1 - l) * pole;
        const double scale = c * std::pow(at.eta, 0.25) / std::pow(r2, 0.75);
        return {scale * x, scale * y, -z / (at.eta * r2)};
    }
    const double x = c2 * (at.t * cos + at.p * sin) - h * sin;
    const double y = c2 * (at.t * sin + at.p * cos) + h * cos;
    const double r2 = x * x + y * y, d = at.xi * c2 * c2 + at.eta * r2, root = std::sqrt(d);
    const double z = saddle * c2 / d, gamma = 2 * std::sqrt(at.alpha);
    const double growth = std::exp(gamma * z), whole = at.alpha * c2 * root + r2;
    const double scale = c * std::sqrt(root) * growth / whole;
    const double sunk = gamma > 0 ? std::expm1(gamma * z) / gamma : z;
    return {scale * x, scale * y,
            std::sqrt(at.alpha) * (c2 * root * growth / whole - 1 / (at.alpha + 1)) - sunk};
}

/// A grid of latitudes and longitudes on the surface of a stage.
struct EversionMesh {
    std::size_t rows = 0, columns = 0;                     ///< of its quads
    std::vector<Point3> vertices;                          ///< (rows + 1) · columns, the south pole first
    std::vector<std::array<std::uint32_t, 3>> triangles{}; ///< two per quad, in sequence
};

/// The triangles of a grid. Front faces are outside at the first stage and inside at the last. At the poles
/// one triangle of each quad has no area.
inline std::vector<std::array<std::uint32_t, 3>> eversion_triangles(std::size_t rows, std::size_t columns) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::size_t row = 0; row < rows; ++row) {
        for (std::size_t column = 0; column < columns; ++column) {
            const auto a = std::uint32_t(row * columns + column),
                       b = std::uint32_t(row * columns + (column + 1) % columns);
            const auto up = std::uint32_t(columns);
            triangles.push_back({a, b + up, b});
            triangles.push_back({a, a + up, b + up});
        }
    }
    return triangles;
}

inline EversionMesh eversion_mesh(const EversionStage& stage, std::size_t rows, std::size_t columns) {
    constexpr double pi = std::numbers::pi;
    EversionMesh mesh{rows, columns, {}, eversion_triangles(rows, columns)};
    mesh.vertices.reserve((rows + 1) * columns);
    for (std::size_t row = 0; row <= rows; ++row) {
        for (std::size_t column = 0; column < columns; ++column)
            mesh.vertices.push_back(eversion_point(stage, pi * double(row) / double(rows) - pi / 2,
                                                   2 * pi * double(column) / double(columns)));
    }
    return mesh;
}

/// The largest distance from the origin.
inline double size_of(const EversionMesh& mesh) {
    double size = 0;
    for (const Point3& v : mesh.vertices) size = std::fmax(size, std::hypot(v[0], v[1], v[2]));
    return size;
}

/// The signed volume: positive for a sphere, negative for an everted sphere.
inline double volume_of(const EversionMesh& mesh) {
    double six = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        six += dot(mesh.vertices[a], cross(mesh.vertices[b], mesh.vertices[c]));
    return six / 6;
}

/// The minimum of |X_θ × X_φ| / cos θ over the centres of quads: 0 if the surface is not an immersion. By
/// finite differences over 2e-5, accurate to about 1e-9.
inline double least_area_factor(const EversionStage& stage, std::size_t rows, std::size_t columns) {
    constexpr double pi = std::numbers::pi, step = 1e-5;
    double least = 1e300;
    for (std::size_t row = 0; row < rows; ++row) {
        const double theta = pi * (double(row) + 0.5) / double(rows) - pi / 2;
        for (std::size_t column = 0; column < columns; ++column) {
            const double phi = 2 * pi * (double(column) + 0.5) / double(columns);
            const Point3 along =
                eversion_point(stage, theta + step, phi) - eversion_point(stage, theta - step, phi);
            const Point3 around =
                eversion_point(stage, theta, phi + step) - eversion_point(stage, theta, phi - step);
            const Point3 area = cross(along, around);
            least =
                std::fmin(least, std::hypot(area[0], area[1], area[2]) / (4 * step * step * std::cos(theta)));
        }
    }
    return least;
}

/// The eversion in time: 0 is the sphere, ½ the halfway surface, 1 the sphere inside out. The
/// speed is constant: the largest displacement per time, relative to the surface's size.
class Eversion {
public:
    Eversion() {
        constexpr std::size_t rows = 24, columns = 48;
        EversionMesh before = eversion_mesh(stage_on_legs(0), rows, columns);
        for (std::size_t n = 1; n <= steps; ++n) {
            EversionMesh after = eversion_mesh(stage_on_legs(half * double(n) / steps), rows, columns);
            double most = 0;
            for (std::size_t i = 0; i < after.vertices.size(); ++i) {
                const Point3 d = after.vertices[i] - before.vertices[i];
                most = std::fmax(most, std::hypot(d[0], d[1], d[2]));
            }
            way_[n] = way_[n - 1] + most / size_of(after);
            before.vertices.swap(after.vertices);
        }
    }

    /// The stage at a time in [0, 1]. The second half is the first half backwards, with the opposite sign of
    /// t.
    EversionStage stage(double time) const {
        const double gone = way_.back() * 2 * std::fmin(time, 1 - time);
        const auto next = std::upper_bound(way_.begin() + 1, way_.end() - 1, gone);
        const double from = *(next - 1), part = std::fmin((gone - from) / (*next - from), 1.0);
        EversionStage at = stage_on_legs(half * (double(next - 1 - way_.begin()) + part) / steps);
        if (time > 0.5) at.t = -at.t;
        return at;
    }

private:
    static constexpr std::size_t steps = 350;
    static constexpr double half = 3.5; // in legs

    std::array<double, steps + 1> way_{}; // sums of the largest displacements, relative to the size
};

} // namespace cageform_sources
