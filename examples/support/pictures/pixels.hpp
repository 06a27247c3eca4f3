#pragma once

// Pictures as bytes with alpha, as PNG files hold them, and regions of their pixels.

#include "pictures/picture.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cageform_support {

/// A picture of bytes: red, green, blue and alpha of each pixel, the first row first.
struct Pixels {
    std::size_t width = 0, height = 0;
    std::vector<std::uint8_t> bytes = std::vector<std::uint8_t>(4 * width * height);

    std::uint8_t* at(std::size_t x, std::size_t y) { return &bytes[4 * (y * width + x)]; }
    const std::uint8_t* at(std::size_t x, std::size_t y) const { return &bytes[4 * (y * width + x)]; }

    std::string png() const; ///< of the picture; empty where it cannot be encoded
    void write_png(AtomicFile& file) const;
};

/// Reads a PNG file of any kind. Channels of 16 bits keep their upper eight; without alpha, 255 is set.
///
///   fails   where the file cannot be read, is no PNG file, is damaged, or holds more than 100 million
///           pixels, which are not decoded
Expected<Pixels> read_png(const std::string& path);

/// The picture with its longer side at most `most` pixels, at least 1: each pixel is the mean of a block of
/// pixels, by alpha.
Pixels shrunk(const Pixels& picture, std::size_t most);

/// Places pictures side by side, with `gap` white pixels between them.
Pixels side_by_side(const std::vector<Pixels>& pictures, std::size_t gap);

/// The role of a pixel in a region.
enum class PixelKind : std::uint8_t {
    outside,
    outline, ///< in the region; a neighbour over one of its sides is not, or lies beyond the picture
    inside,
};

/// Pixels of a picture, in the least box that holds them.
struct PixelRegion {
    std::size_t left = 0, top = 0; ///< of the box, in the picture
    std::size_t width = 0, height = 0;
    std::vector<PixelKind> kinds;       ///< of the box, the first row first
    std::vector<std::uint32_t> outline; ///< indices of the outline's pixels in the box, ascending
    std::size_t inside = 0;             ///< how many pixels are

    bool is_empty() const { return width == 0; }
};

/// Makes a region of the pixels where the mask is not 0.
///
///   mask   width · height, the first row first
PixelRegion make_region(const std::vector<std::uint8_t>& mask, std::size_t width);

/// Marks the pixels that a picture shows: those at least half as light as white, times alpha.
std::vector<std::uint8_t> mask_of(const Pixels& picture);

/// Marks the pixels of a picture whose centres lie inside closed outlines, by the even-odd rule. Pixel (x, y)
/// has its centre at (x + ½, y + ½).
std::vector<std::uint8_t> mask_of(const std::vector<std::vector<Point2>>& loops, std::size_t width,
                                  std::size_t height);

} // namespace cageform_support
