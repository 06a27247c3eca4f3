#include "pictures/picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function" // only print() is used
#endif
#include <stb/stb_easy_font.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

namespace cageform_support {

/// Interpolates equidistant stops; t is clamped to [0, 1].
static Colour ramp(std::span<const Colour> stops, double t) {
    const double x = std::clamp(t, 0.0, 1.0) * double(stops.size() - 1);
    const std::size_t i = std::min(std::size_t(x), stops.size() - 2);
    return mix(stops[i], stops[i + 1], float(x - double(i)));
}

Colour heat(double value) {
    static constexpr std::array<Colour, 5> warm{{{1, 1, 0.96f},
                                                 {1, 0.87f, 0.53f},
                                                 {0.99f, 0.6f, 0.25f},
                                                 {0.85f, 0.22f, 0.12f},
                                                 {0.42f, 0.02f, 0.1f}}};
    // Steeper than the positive side, since coordinates are seldom much below zero.
    static constexpr std::array<Colour, 4> cold{
        {warm[0], {0.55f, 0.75f, 0.95f}, {0.2f, 0.42f, 0.8f}, {0.07f, 0.12f, 0.42f}}};
    return value >= 0 ? ramp(warm, value) : ramp(cold, -2.5 * value);
}

Colour boundary_hue(double value) {
    static constexpr std::array<Colour, 4> greens{
        {{0.62f, 0.62f, 0.62f}, {0.55f, 0.8f, 0.45f}, {0.1f, 0.6f, 0.2f}, {0, 0.3f, 0.08f}}};
    return ramp(greens, value);
}

void Picture::place(const Picture& other, std::size_t left, std::size_t top) {
    for (std::size_t y = 0; y < other.height_ && top + y < height_; ++y) {
        for (std::size_t x = 0; x < other.width_ && left + x < width_; ++x)
            at(left + x, top + y) = other.at(x, y);
    }
}

Picture Picture::halved() const {
    Picture half(width_ / 2, height_ / 2);
    for (std::size_t y = 0; y < half.height_; ++y) {
        for (std::size_t x = 0; x < half.width_; ++x) {
            half.at(x, y) = mix(mix(at(2 * x, 2 * y), at(2 * x + 1, 2 * y), 0.5f),
                                mix(at(2 * x, 2 * y + 1), at(2 * x + 1, 2 * y + 1), 0.5f), 0.5f);
        }
    }
    return half;
}

void Picture::line(const Point2& a, const Point2& b, double thickness, const Colour& colour) {
    const double reach = thickness / 2 + 1;
    const auto clip = [](double v, std::size_t n) { return std::size_t(std::clamp(v, 0.0, double(n))); };
    const double ex = b.x - a.x, ey = b.y - a.y;
    const double length2 = ex * ex + ey * ey;
    for (std::size_t y = clip(std::min(a.y, b.y) - reach, height_);
         y < clip(std::max(a.y, b.y) + reach, height_); ++y) {
        for (std::size_t x = clip(std::min(a.x, b.x) - reach, width_);
             x < clip(std::max(a.x, b.x) + reach, width_); ++x) {
            const double px = double(x) + 0.5 - a.x, py = double(y) + 0.5 - a.y;
            const double s = length2 > 0 ? std::clamp((px * ex + py * ey) / length2, 0.0, 1.0) : 0.0;
            const double distance = std::hypot(px - s * ex, py - s * ey);
            const double cover = std::clamp(thickness / 2 + 0.5 - distance, 0.0, 1.0);
            Colour& pixel = at(x, y);
            pixel = mix(pixel, colour, float(cover));
        }
    }
}

void Picture::text(const Point2& at, const std::string& words, double size, const Colour& colour) {
    struct Corner {
        float x, y, z;
        unsigned char rgba[4];
    };
    std::vector<Corner> corners(words.size() * 80 + 4); // 20 quads a letter at most
    std::string copy = words;                           // stb takes char*, but does not change it
    const int quads =
        stb_easy_font_print(0, 0, copy.data(), nullptr, corners.data(), int(corners.size() * sizeof(Corner)));
    for (std::size_t q = 0; q < std::size_t(quads); ++q) {
        const Corner &low = corners[4 * q], &high = corners[4 * q + 2];
        for (double y = low.y; y < high.y; y += 1 / size) {
            for (double x = low.x; x < high.x; x += 1 / size) {
                const double px = at.x + x * size, py = at.y + (y - 3.5) * size;
                if (px >= 0 && py >= 0 && px < double(width_) && py < double(height_))
                    this->at(std::size_t(px), std::size_t(py)) = colour;
            }
        }
    }
}

void draw_colour_bar(Picture& picture, const Axis& axis, const std::vector<AxisMark>& marks, double left,
                     double width, double size, const std::function<Colour(double)>& colour) {
    constexpr Colour ink{0.2f, 0.2f, 0.2f};
    for (std::size_t y = std::size_t(axis.end); double(y) < axis.begin; ++y) {
        const double value =
            axis.from + (double(y) + 0.5 - axis.begin) / (axis.end - axis.begin) * (axis.to - axis.from);
        for (std::size_t x = std::size_t(left); double(x) < left + width; ++x)
            picture.at(x, y) = colour(value);
    }
    const double right = left + width, line = size / 2;
    for (const double x : {left, right}) picture.line({x, axis.begin}, {x, axis.end}, line, ink);
    for (const double y : {axis.begin, axis.end}) picture.line({left, y}, {right, y}, line, ink);
    for (const auto& [value, number] : marks) {
        const double y = axis.at(value);
        picture.line({right, y}, {right + 3 * size, y}, line, ink);
        picture.text({right + 5 * size, y}, number, size, ink);
    }
}

std::string encoded_png(std::size_t width, std::size_t height, int channels, const std::string& bytes) {
    std::string png;
    const auto append = [](void* target, void* data, int size) {
        static_cast<std::string*>(target)->append(static_cast<const char*>(data), std::size_t(size));
    };
    const int done = stbi_write_png_to_func(append, &png, int(width), int(height), channels, bytes.data(),
                                            channels * int(width));
    return done == 0 ? "" : png;
}

static void write_encoded(AtomicFile& file, const std::string& png) {
    png.empty() ? file.refuse("it cannot be encoded") : file.write(png);
}

std::string Picture::png() const {
    std::string bytes;
    bytes.reserve(pixels_.size() * 3);
    for (const Colour& pixel : pixels_) {
        for (const float channel : {pixel.r, pixel.g, pixel.b})
            bytes += char(std::lround(255 * std::clamp(channel, 0.0f, 1.0f)));
    }
    return encoded_png(width_, height_, 3, bytes);
}

void Picture::write_png(AtomicFile& file) const {
    write_encoded(file, png());
}

void write_png(AtomicFile& file, std::size_t width, std::size_t height, int channels,
               const std::string& bytes) {
    write_encoded(file, encoded_png(width, height, channels, bytes));
}

void write_png_16(AtomicFile& file, std::size_t width, std::span<const std::uint16_t> greys) {
    const auto big_endian = [](std::uint32_t number, int bytes) {
        std::string text;
        for (int k = bytes; k-- > 0;) text += char((number >> (8 * k)) & 255u);
        return text;
    };
    std::string rows; // each begins with filter type 2: difference to the row above
    for (std::size_t i = 0; i < greys.size(); ++i) {
        if (i % width == 0) rows += char(2);
        const std::uint16_t above = i < width ? std::uint16_t(0) : greys[i - width];
        rows += char((greys[i] >> 8) - (above >> 8));
        rows += char((greys[i] & 255) - (above & 255));
    }
    int size = 0;
    unsigned char* const packed =
        stbi_zlib_compress(reinterpret_cast<unsigned char*>(rows.data()), int(rows.size()), &size, 8);
    if (packed == nullptr) return file.refuse("it cannot be encoded");
    const std::string data(reinterpret_cast<const char*>(packed), std::size_t(size));
    STBIW_FREE(packed);
    const auto chunk = [&](const std::string& name, const std::string& content) { // PNG specification, sec. 5
        const std::string body = name + content;
        std::uint32_t crc = ~std::uint32_t{0};
        for (const char c : body) {
            crc ^= std::uint32_t(static_cast<unsigned char>(c));
            for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0u);
        }
        return big_endian(std::uint32_t(content.size()), 4) + body + big_endian(~crc, 4);
    };
    const std::string header = big_endian(std::uint32_t(width), 4) +
                               big_endian(std::uint32_t(greys.size() / width), 4) +
                               std::string("\x10\0\0\0\0", 5);
    file.write("\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("IDAT", data) + chunk("IEND", ""));
}

} // namespace cageform_support
