#pragma once

// A picture in memory: colour maps, lines, and PNG files (stb_image_write).

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

/// White at 0; over yellow and orange to dark red at 1, over blues to dark blue at −0.4 and below.
Colour heat(double value);

/// Grey over green to dark green for 0 … 1: boundary values, told from the heat inside by their hue.
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

    /// Copies another picture into this one, its upper left corner at a place; what does not fit is left out.
    void place(const Picture& other, std::size_t left, std::size_t top = 0);

    /// The picture at half its width and height: the mean of four pixels each.
    Picture halved() const;

    /// A line of the given thickness with round ends, in pixels; pixel (x, y) has its centre at (x + ½, y +
    /// ½).
    void line(const Point2& a, const Point2& b, double thickness, const Colour& colour);

    /// Letters of ASCII, 7 · `size` pixels high, the left end of their middle line at a place.
    void text(const Point2& at, const std::string& words, double size, const Colour& colour);

    /// The bytes of a PNG file; none where it cannot be encoded.
    std::string png() const;

    /// Writes a PNG file; a failure is the file's.
    void write_png(AtomicFile& file) const;

private:
    std::size_t width_;
    std::size_t height_;
    std::vector<Colour> pixels_;
};

/// A PNG file of any bytes, empty where it cannot be encoded.
///
///   channels   1 grey, 2 grey and alpha, 3 colour, 4 colour and alpha; the first row first
std::string encoded_png(std::size_t width, std::size_t height, int channels, const std::string& bytes);

/// Writes a PNG file as encoded_png() makes it; fails as Picture::write_png().
void write_png(AtomicFile& file, std::size_t width, std::size_t height, int channels,
               const std::string& bytes);

/// Writes greys of 16 bits as a PNG file: 0 is black, 65535 white.
void write_png_16(AtomicFile& file, std::size_t width, std::span<const std::uint16_t> greys);

/// A bar of colours, `width` pixels from its left side on, with numbers on its right.
///
///   axis   values to rows of pixels
///   marks  where the numbers are
///   size   of the numbers, as of Picture::text()
void draw_colour_bar(Picture& picture, const Axis& axis, const std::vector<AxisMark>& marks, double left,
                     double width, double size, const std::function<Colour(double)>& colour = heat);

} // namespace cageform_support
