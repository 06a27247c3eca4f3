#include "splats/surface_splats.hpp"

#include "splats/harmonics.hpp"

#include <cageform/core/types/bounds.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <span>

namespace cageform_support {

namespace {

/// Twice the area of a triangle, times its normal.
Point3 area_vector(const MeshFile& mesh, std::size_t triangle) {
    const auto& [a, b, c] = mesh.triangles[triangle];
    const auto& v = mesh.vertices;
    return cross(v[b] - v[a], v[c] - v[a]);
}

/// Uniform in [0, 1); the distributions of the standard library differ between implementations.
double uniform(std::mt19937_64& random) {
    return double(random() >> 11) * 0x1p-53;
}

/// The rotation from the third axis to a unit vector, as a quaternion.
std::array<double, 4> turn_to(const Point3& normal) {
    const double w = std::sqrt(std::max(0.0, (1 + normal[2]) / 2));
    if (w < 1e-8) return {0, 1, 0, 0};
    return {w, -normal[1] / (2 * w), normal[0] / (2 * w), 0};
}

/// Clay colour with horizontal bands and a tint from side to side.
std::array<double, 3> paint(const Point3& place, const cageform::Bounds<double, 3>& box) {
    const auto share = [&](std::size_t k) {
        const double size = box.upper[k] - box.lower[k];
        return size > 0 ? (place[k] - box.lower[k]) / size : 0.5;
    };
    constexpr double bands = 14;
    const bool dark = std::fmod(share(1) * bands, 2) < 1;
    const double tint = share(0);
    if (dark) return {0.25 - 0.1 * tint, 0.2 + 0.15 * tint, 0.3 + 0.35 * tint};
    return {0.98 - 0.25 * tint, 0.66 + 0.2 * tint, 0.38 + 0.52 * tint};
}

} // namespace

double area_of(const MeshFile& mesh) {
    double area = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area += length_of(area_vector(mesh, t)) / 2;
    return area;
}

SplatFile splats_on(const MeshFile& mesh, const SurfaceSplatOptions& options) {
    SplatFile scene = empty_scene(options.degree);
    const double area = area_of(mesh), step = area / double(options.count);
    const auto box = cageform::bounds_of(std::span<const Point3>(mesh.vertices));
    const double radius = 1.3 * std::sqrt(step / 3.14159265358979323846); // no holes between the disks
    std::mt19937_64 random(options.seed);
    std::array<double, most_harmonics> gloss{};
    scene.rows.reserve(options.count * scene.layout.row_bytes);
    double reached = 0, next = step * uniform(random);
    std::size_t made = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Point3 across = area_vector(mesh, t);
        const double size = length_of(across);
        reached += size / 2;
        if (!(size > 0)) continue;
        const Point3 normal = (1 / size) * across;
        const auto& [a, b, c] = mesh.triangles[t];
        const bool is_last = t + 1 == mesh.triangles.size();
        for (; made < options.count && (next < reached || is_last); ++made, next += step) {
            const double u = std::sqrt(uniform(random)), v = uniform(random);
            Splat splat;
            splat.place =
                (1 - u) * mesh.vertices[a] + u * (1 - v) * mesh.vertices[b] + u * v * mesh.vertices[c];
            splat.shape = {turn_to(normal), {std::log(radius), std::log(radius), std::log(radius / 20)}};
            splat.opacity = logit_of(0.95);
            const Point3 light{-0.45, 0.75, 0.49};
            const double shade = 0.6 + 0.4 * std::max(0.0, dot(normal, light));
            const auto own = paint(splat.place, box);
            // A lobe around the mirrored light. In files, directions are from the eye to the splat.
            harmonics_at(light - 2 * dot(normal, light) * normal, gloss);
            for (std::size_t channel = 0; channel < 3; ++channel) {
                splat.colour[channel] = (shade * own[channel] - 0.5) / constant_harmonic;
                for (std::size_t k = 0; k < harmonics_of(options.degree); ++k) {
                    const double share = k < harmonics_of(1) ? 0.3 : k < harmonics_of(2) ? 0.22 : 0.12;
                    splat.harmonics[channel].push_back(share * gloss[k]);
                }
            }
            append(scene, splat);
            scene.set(made, scene.layout.normal, normal);
        }
    }
    scene.name = "splats on " + mesh.name;
    return scene;
}

} // namespace cageform_support
