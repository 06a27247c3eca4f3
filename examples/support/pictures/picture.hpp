#pragma once

// Pictures in memory: colour maps, lines, text, and PNG files (stb_image_write).

#include "io/atomic_file.hpp"
#include "io/point2.hpp"
#include "pictures/plot.hpp"
#include "svg/css_colour.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

inline Colour mix(const Colour& a, const Colour& b, float t) {
    return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}

/// Colour map: white at 0, yellow, orange, dark red at 1; blue for negative values, dark blue at −0.4 and
/// below.
Colour heat(double value);

/// Colour map of boundary values: grey, green, dark green for 0 … 1; distinct from heat().
Colour boundary_hue(double value);

class Picture {
public:
    Picture(std::size_t width, std::size_t height, const Colour& background = {1, 1, 1})
        : width_(width)
        , height_(height)
        , pixels_(width * height, background) {}

    std::size_t width() const { return width_; }
    std::size_t height() const { return height_; }
    Colour& at(std::size_t x, std::size_t y) { return pixels_[y * width_ + x]; }
    const Colour& at(std::size_t x, std::size_t y) const { return pixels_[y * width_ + x]; }

    /// Copies another picture to a position; clipped.
    void place(const Picture& other, std::size_t left, std::size_t top = 0);

    /// Half size: each pixel is the mean of four.
    Picture halved() const;

    /// Draws a line with round ends; thickness in pixels. Pixel (x, y) has its centre at (x + ½, y + ½).
    void line(const Point2& a, const Point2& b, double thickness, const Colour& colour);

    /// Draws ASCII text, 7 · `size` pixels high; `at` is the left end of its centre line.
    void text(const Point2& at, const std::string& words, double size, const Colour& colour);

    /// The bytes of a PNG file; empty if encoding fails.
    std::string png() const;

    /// Writes a PNG file; errors are stored in the file.
    void write_png(AtomicFile& file) const;

private:
    std::size_t width_;
    std::size_t height_;
    std::vector<Colour> pixels_;
};

/// Encodes a PNG file; empty on failure.
///
///   channels   1 grey, 2 grey and alpha, 3 colour, 4 colour and alpha; row-major
std::string encoded_png(std::size_t width, std::size_t height, int channels, const std::string& bytes);

/// Writes encoded_png(); errors as Picture::write_png().
void write_png(AtomicFile& file, std::size_t width, std::size_t height, int channels,
               const std::string& bytes);

/// Writes 16-bit greys as a PNG file: 0 is black, 65535 white.
void write_png_16(AtomicFile& file, std::size_t width, std::span<const std::uint16_t> greys);

/// Draws a colour bar of `width` pixels, with numbers on its right.
///
///   axis    from values to rows
///   marks   positions of numbers
///   size    of the numbers, as in Picture::text()
void draw_colour_bar(Picture& picture, const Axis& axis, const std::vector<AxisMark>& marks, double left,
                     double width, double size, const std::function<Colour(double)>& colour = heat);

} // namespace cageform_support
