#include "character/images.hpp"

#include "character/parts.hpp"
#include "io/messages.hpp"
#include "pictures/pixels.hpp"

#include <cmath>
#include <functional>
#include <numbers>

namespace cageform_programs {

namespace {

constexpr double pi = std::numbers::pi;

/// Draws an image.
///
///   colour   of the pixel at a column and a row, from 0 to 1
std::string draw(std::size_t width, std::size_t height,
                 const std::function<Point3(std::size_t, std::size_t)>& colour) {
    cageform_support::Pixels image{width, height};
    for (std::size_t row = 0; row < height; ++row) {
        for (std::size_t column = 0; column < width; ++column) {
            const Point3 c = colour(column, row);
            for (std::size_t k = 0; k < 3; ++k)
                image.at(column, row)[k] = std::uint8_t(std::lround(255 * std::clamp(c[k], 0.0, 1.0)));
            image.at(column, row)[3] = 255;
        }
    }
    std::string png = image.png();
    if (png.empty()) throw cageform_support::Failure("an image cannot be encoded");
    return png;
}

/// The puppet's outermost point on a ray from its axis.
Point3 surface_point(double height, double angle) {
    double inside = 0.08, outside = 0.3;
    const auto at = [&](double radius) {
        return Point3{radius * std::sin(angle), height, radius * std::cos(angle)};
    };
    for (int k = 0; k < 16; ++k) {
        const double middle = (inside + outside) / 2;
        (puppet(at(middle)) < 0 ? inside : outside) = middle;
    }
    return at(inside);
}

} // namespace

std::string cloth_image() {
    return draw(128, 128, [](std::size_t column, std::size_t row) {
        const std::size_t stripe = row % 64;
        const bool is_line = stripe >= 40 && stripe < 46, is_band = stripe < 26;
        const double weave = (row / 2 + column / 2) % 2 == 0 ? 1 : 0.95;
        const double fade = column % 64 < 4 ? 0.86 : 1; // thin lines along the cloth
        return weave * fade *
               (is_line   ? Point3{0.86, 0.42, 0.22}
                : is_band ? Point3{0.14, 0.42, 0.46}
                          : Point3{0.94, 0.90, 0.80});
    });
}

std::string face_image() {
    return draw(256, 128, [](std::size_t column, std::size_t row) {
        constexpr Point3 skin{0.91, 0.74, 0.64}, mouth{0.62, 0.2, 0.19};
        const double angle = 2 * pi * ((double(column) + 0.5) / 256 - 0.5);
        const double height = face_chart.centre[1] - (double(row) + 0.5) / 128 / face_chart.along;
        if (std::fabs(angle) > 1 || height > 1.67 || height < 1.59) return skin;
        const Point3 p = surface_point(height, angle);
        const double off = std::fabs(std::hypot(p[0], p[1] - 1.705) - 0.088);
        const double share = ramp(0.017, 0.011, off) * ramp(1.662, 1.656, height);
        return (1 - share) * skin + share * mouth;
    });
}

std::string knit_image() {
    const auto height = [](double u, double v) { // of two ribs with stitches
        const double rib = std::fabs(std::sin(2 * pi * u));
        return 0.09 * std::sqrt(rib) + 0.012 * std::cos(2 * pi * (4 * v + rib));
    };
    return draw(64, 64, [&](std::size_t column, std::size_t row) {
        constexpr double step = 1.0 / 64;
        const double u = (double(column) + 0.5) * step, v = (double(row) + 0.5) * step;
        // The second component points upwards in the image, where v decreases.
        const Point3 slope{(height(u - step, v) - height(u + step, v)) / (2 * step),
                           (height(u, v + step) - height(u, v - step)) / (2 * step), 1};
        return (0.5 / cageform_support::length(slope)) * slope + Point3{0.5, 0.5, 0.5};
    });
}

} // namespace cageform_programs
