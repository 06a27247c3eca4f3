#pragma once

// Two pictures to clone between: a boat at noon, and the sea in the evening.

#include "pictures/pixels.hpp"
#include "svg/path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace cageform_sources {

using namespace cageform_support;

/// Draws in units of the picture's width: x from 0 to 1, y from 0 to ¾, downwards. Colours are 0 to 255.
class Harbour {
public:
    explicit Harbour(std::size_t width)
        : width_(width) {}

    Pixels noon() const {
        return draw([](double x, double y) { return at_noon(x, y); });
    }
    Pixels evening() const {
        return draw([](double x, double y) { return in_the_evening(x, y); });
    }
    /// The outline of the boat, with some sky and sea around it, as an SVG in pixels.
    std::string boat_outline() const {
        const auto point = [&](double x, double y) {
            return format_number(x * double(width_), 2) + "," + format_number(y * double(width_), 2);
        };
        return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + std::to_string(width_) + " " +
               std::to_string(height()) + "\">\n<path fill=\"none\" stroke=\"red\" d=\"M" + point(0.5, 0.1) +
               " C" + point(0.6, 0.1) + " " + point(0.78, 0.42) + " " + point(0.78, 0.54) + " C" +
               point(0.78, 0.62) + " " + point(0.66, 0.64) + " " + point(0.5, 0.64) + " C" +
               point(0.34, 0.64) + " " + point(0.23, 0.62) + " " + point(0.23, 0.53) + " C" +
               point(0.23, 0.42) + " " + point(0.4, 0.1) + " " + point(0.5, 0.1) + "Z\"/>\n</svg>\n";
    }

private:
    using Light = std::array<double, 3>;
    static constexpr double horizon = 0.45;

    std::size_t height() const { return width_ * 3 / 4; }

    template <class F>
    Pixels draw(const F& light_at) const {
        Pixels picture{width_, height()};
        constexpr std::size_t samples = 3; // along each axis
        for (std::size_t y = 0; y < picture.height; ++y) {
            for (std::size_t x = 0; x < picture.width; ++x) {
                Light sum{};
                for (std::size_t n = 0; n < samples * samples; ++n) {
                    const auto place = [&](std::size_t pixel, std::size_t k) {
                        return (double(pixel) + (double(k) + 0.5) / double(samples)) / double(width_);
                    };
                    const Light light = light_at(place(x, n % samples), place(y, n / samples));
                    for (std::size_t k = 0; k < 3; ++k) sum[k] += light[k] / double(samples * samples);
                }
                for (std::size_t k = 0; k < 3; ++k)
                    picture.at(x, y)[k] = std::uint8_t(std::lround(std::clamp(sum[k], 0.0, 255.0)));
                picture.at(x, y)[3] = 255;
            }
        }
        return picture;
    }

    static Light mix(const Light& a, const Light& b, double t) {
        Light light{};
        for (std::size_t k = 0; k < 3; ++k) light[k] = std::lerp(a[k], b[k], std::clamp(t, 0.0, 1.0));
        return light;
    }
    static double smooth(double low, double high, double x) {
        const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
        return t * t * (3 - 2 * t);
    }
    /// Noise of one octave in [0, 1], smooth between whole numbers.
    static double noise(double x, double y) {
        const auto value = [](double i, double j) {
            auto h =
                std::uint32_t(std::int32_t(i)) * 0x9E3779B1u ^ std::uint32_t(std::int32_t(j)) * 0x85EBCA77u;
            h = (h ^ h >> 15) * 0x2C1B3C6Du;
            h = (h ^ h >> 12) * 0x297A2D39u;
            return double(h ^ h >> 15) / 4294967295.0;
        };
        const double i = std::floor(x), j = std::floor(y), s = smooth(0, 1, x - i), t = smooth(0, 1, y - j);
        return std::lerp(std::lerp(value(i, j), value(i + 1, j), s),
                         std::lerp(value(i, j + 1), value(i + 1, j + 1), s), t);
    }
    static double cloud(double x, double y) {
        double sum = 0, part = 0.5;
        for (int octave = 0; octave < 5; ++octave, part /= 2, x *= 2.03, y *= 2.03) sum += part * noise(x, y);
        return sum;
    }
    /// The brightness of waves, about −1 to 1; waves are finer in the distance.
    static double waves(double x, double y) {
        const double depth = 0.02 + (y - horizon);
        return 2 * cloud(0.9 * (x - 0.5) / depth + 40, 0.32 / depth + 7) - 0.97;
    }
    static bool is_within(const std::vector<std::pair<double, double>>& corners, double x, double y) {
        bool inside = false;
        for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
            const auto& [ax, ay] = corners[i];
            const auto& [bx, by] = corners[j];
            if ((ay > y) != (by > y) && x < ax + (bx - ax) * (y - ay) / (by - ay)) inside = !inside;
        }
        return inside;
    }

    static Light at_noon(double x, double y) {
        static const std::vector<std::pair<double, double>> hull{{0.31, 0.5},   {0.7, 0.5},    {0.665, 0.545},
                                                                 {0.63, 0.565}, {0.38, 0.565}, {0.34, 0.545}};
        static const std::vector<std::pair<double, double>> mast{
            {0.497, 0.15}, {0.505, 0.15}, {0.505, 0.5}, {0.497, 0.5}};
        const double belly = 0.035 * std::sin(std::clamp((y - 0.17) / 0.3, 0.0, 1.0) * 3.14159);
        if (is_within(hull, x, y)) return mix({150, 74, 62}, {70, 40, 44}, (y - 0.5) / 0.06);
        if (y > 0.46 && y < 0.5 && x > 0.42 && x < 0.56) return {232, 214, 170}; // the cabin
        if (is_within(mast, x, y)) return {110, 78, 48};
        if (y > 0.17 && y < 0.455 && x > 0.51 && x < 0.51 + (y - 0.17) * 0.55 + belly)
            return mix({252, 250, 240}, {214, 216, 214}, (x - 0.51) / 0.2);
        if (y > 0.2 && y < 0.455 && x < 0.492 && x > 0.492 - (y - 0.2) * 0.5 - belly)
            return mix({236, 196, 120}, {214, 150, 70}, (0.492 - x) / 0.16);
        if (y < horizon) {
            const Light sky = mix({78, 142, 214}, {186, 216, 238}, y / horizon);
            return mix(sky, {250, 250, 250}, smooth(0.5, 0.75, cloud(5 * x, 9 * y)));
        }
        const Light sea = mix({96, 160, 190}, {24, 92, 132}, (y - horizon) / 0.3);
        const double wave = waves(x, y);
        const double shade = -34 * smooth(0.29, 0.4, x) * (1 - smooth(0.6, 0.71, x)) * smooth(0.47, 0.56, y) *
                             (1 - smooth(0.565, 0.62, y));
        return {sea[0] + 34 * wave + shade, sea[1] + 34 * wave + shade, sea[2] + 30 * wave + shade};
    }

    static Light in_the_evening(double x, double y) {
        constexpr double sun_x = 0.24, sun_y = 0.37;
        const double hill = horizon - 0.09 * std::pow(std::max(0.0, std::sin(3.6 * (x - 0.55))), 1.5) *
                                          (0.8 + 0.4 * cloud(9 * x, 3));
        if (y < horizon) {
            if (y > hill) return mix({70, 44, 74}, {46, 30, 58}, (y - hill) / 0.1);
            const double away = std::hypot(x - sun_x, y - sun_y);
            if (away < 0.032) return {255, 244, 200};
            Light sky = mix({52, 40, 96}, {244, 142, 84}, std::pow(y / horizon, 1.3));
            sky = mix(sky, {255, 206, 120}, 0.75 * std::exp(-away / 0.12));
            return mix(sky, {122, 66, 98}, 0.7 * smooth(0.48, 0.7, cloud(3 * x + 11, 14 * y)));
        }
        const Light sea = mix({190, 108, 90}, {44, 36, 72}, std::sqrt((y - horizon) / 0.3));
        const double wave = waves(x + 0.31, y);
        const double path =
            120 * std::exp(-std::pow((x - sun_x) / (0.03 + 0.3 * (y - horizon)), 2)) * (0.5 + wave);
        return {sea[0] + 26 * wave + path, sea[1] + 22 * wave + 0.75 * path, sea[2] + 24 * wave + 0.4 * path};
    }

    std::size_t width_;
};

} // namespace cageform_sources
