#include "pictures/splat_picture.hpp"

#include "pictures/camera.hpp"
#include "splats/harmonics.hpp"
#include "splats/splat.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace cageform_support {

namespace {

/// A projected splat.
struct DrawnSplat {
    double x = 0, y = 0, depth = 0;  // depth grows towards the eye
    double xx = 0, xy = 0, yy = 0;   // inverse covariance
    double reach_x = 0, reach_y = 0; // half size of its bounding box
    double opacity = 0;
    Colour colour;
};

constexpr double least_share = 1.0 / 255; // smallest visible alpha

/// The colour of a splat for a viewing ray.
Colour colour_of(const SplatFile& scene, std::size_t splat, const Point3& ray) {
    std::array<double, most_harmonics> values{};
    harmonics_at(ray, values);
    const auto& [layout, count] = std::pair{std::cref(scene.layout), scene.layout.rest.size() / 3};
    std::array<double, 3> colour{};
    for (std::size_t channel = 0; channel < 3; ++channel) {
        double sum = 0.5 + constant_harmonic * scene.number(splat, layout.get().colour[channel]);
        for (std::size_t k = 0; k < count; ++k)
            sum += values[k] * scene.number(splat, layout.get().rest[channel * count + k]);
        colour[channel] = std::max(sum, 0.0);
    }
    return {float(colour[0]), float(colour[1]), float(colour[2])};
}

DrawnSplat drawn(const SplatFile& scene, std::size_t i, const detail::Camera& camera) {
    DrawnSplat splat;
    const Point3 place = scene.place(i), at = camera.project(place);
    const Matrix3 across = transposed(factor_of(scene.shape(i)));
    const auto [right, down] = camera.gradients(place);
    const Point3 a = product(across, right), b = product(across, down);
    constexpr double pixel = 0.3;
    const double xx = dot(a, a) + pixel, yy = dot(b, b) + pixel, xy = dot(a, b);
    const double determinant = xx * yy - xy * xy;
    splat.opacity = opacity_of(scene.number(i, scene.layout.opacity));
    const double reach = std::sqrt(2 * std::log(splat.opacity / least_share)); // deviations
    if (!(splat.opacity > least_share) || !(determinant > 0) || !std::isfinite(determinant)) {
        splat.opacity = 0;
        return splat;
    }
    splat.x = at[0];
    splat.y = at[1];
    splat.depth = at[2];
    splat.xx = yy / determinant;
    splat.xy = -xy / determinant;
    splat.yy = xx / determinant;
    splat.reach_x = reach * std::sqrt(xx);
    splat.reach_y = reach * std::sqrt(yy);
    splat.colour = colour_of(scene, i, detail::unit(place - camera.eye()));
    return splat;
}

/// The first pixel with its centre at or after a position, from 0 to `size`.
std::size_t pixel_from(double place, std::size_t size) {
    return std::size_t(std::clamp(std::ceil(place - 0.5), 0.0, double(size)));
}

/// Draws rows of a picture: splats sorted from front to back.
void draw_rows(const std::vector<const DrawnSplat*>& splats, std::size_t top, std::size_t bottom,
               std::size_t left, Picture& picture) {
    const std::size_t width = picture.width() - left;
    std::vector<float> light(width * (bottom - top), 1); // remaining transmittance
    std::vector<Colour> sums(light.size());
    constexpr float dark = 1e-3f; // below it nothing is visible
    for (const DrawnSplat* splat : splats) {
        const auto first = pixel_from(splat->x - splat->reach_x, width),
                   last = pixel_from(splat->x + splat->reach_x, width);
        const auto begin = std::max(pixel_from(splat->y - splat->reach_y, bottom), top),
                   end = pixel_from(splat->y + splat->reach_y, bottom);
        for (std::size_t y = begin; y < end; ++y) {
            const double dy = double(y) + 0.5 - splat->y;
            for (std::size_t x = first; x < last; ++x) {
                float& left_over = light[(y - top) * width + x];
                if (left_over < dark) continue;
                const double dx = double(x) + 0.5 - splat->x;
                const double square = splat->xx * dx * dx + 2 * splat->xy * dx * dy + splat->yy * dy * dy;
                const auto share = float(std::min(0.99, splat->opacity * std::exp(-0.5 * square)));
                if (share < float(least_share)) continue;
                Colour& sum = sums[(y - top) * width + x];
                const float weight = left_over * share;
                sum = {sum.r + weight * splat->colour.r, sum.g + weight * splat->colour.g,
                       sum.b + weight * splat->colour.b};
                left_over -= weight;
            }
        }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const float behind = light[i];
        const Colour& sum = sums[i];
        picture.at(left + i % width, top + i / width) = {std::min(sum.r + behind * mesh_background.r, 1.0f),
                                                         std::min(sum.g + behind * mesh_background.g, 1.0f),
                                                         std::min(sum.b + behind * mesh_background.b, 1.0f)};
    }
}

} // namespace

Picture draw_splats(const SplatFile& scene, const MeshView* mesh, std::size_t width, std::size_t height,
                    const ViewAngles& sight, const cageform::Running& running) {
    std::vector<Point3> places(scene.size());
    for (std::size_t i = 0; i < places.size(); ++i) places[i] = scene.place(i);
    const std::size_t left = mesh != nullptr ? width / 2 : 0, part = width - left;
    Picture picture(width, height, mesh_background);
    std::vector<std::span<const Point3>> framed{places};
    if (mesh != nullptr) {
        framed.push_back(mesh->vertices);
        const MeshScene beside{*mesh, {places, {}}}; // splats as vertices, for the same frame
        picture.place(draw_meshes(std::span(&beside, 1), part, height, sight), 0);
    }
    const detail::Camera camera(directions_of(sight), detail::Camera::Rays::converging, framed, double(part),
                                double(height));

    std::vector<DrawnSplat> splats(scene.size());
    constexpr std::size_t grain = 1024;
    running.parallel(splats.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) splats[i] = drawn(scene, i, camera);
    });
    std::vector<const DrawnSplat*> order;
    for (const DrawnSplat& splat : splats) {
        if (splat.opacity > 0) order.push_back(&splat);
    }
    std::sort(order.begin(), order.end(), [](const DrawnSplat* a, const DrawnSplat* b) {
        return a->depth != b->depth ? a->depth > b->depth : a < b; // ties in file order
    });
    constexpr std::size_t rows = 16; // per band
    std::vector<std::vector<const DrawnSplat*>> bands((height + rows - 1) / rows);
    for (const DrawnSplat* splat : order) {
        const auto first = pixel_from(splat->y - splat->reach_y, height),
                   last = pixel_from(splat->y + splat->reach_y, height);
        for (std::size_t band = first / rows; band * rows < last; ++band) bands[band].push_back(splat);
    }
    running.parallel(bands.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t band = begin; band < end; ++band)
            draw_rows(bands[band], band * rows, std::min((band + 1) * rows, height), left, picture);
    });
    return picture;
}

} // namespace cageform_support
