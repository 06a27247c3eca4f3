#pragma once

// RGBA pictures of 8 bits per channel, and regions of their pixels.

#include "io/expected.hpp"
#include "pictures/picture.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cageform_support {

/// An RGBA picture, row-major.
struct Pixels {
    std::size_t width = 0, height = 0;
    std::vector<std::uint8_t> bytes = std::vector<std::uint8_t>(4 * width * height);

    std::uint8_t* at(std::size_t x, std::size_t y) { return &bytes[4 * (y * width + x)]; }
    const std::uint8_t* at(std::size_t x, std::size_t y) const { return &bytes[4 * (y * width + x)]; }

    std::string png() const; ///< empty if encoding fails
    void write_png(AtomicFile& file) const;
};

/// Reads a PNG file of any type. 16-bit channels keep their upper eight bits; missing alpha becomes 255.
///
///   fails   if the file cannot be read, is not PNG, is damaged, or has more than 100 million pixels (checked
///           before decoding)
Expected<Pixels> read_png(const std::string& path);

/// Shrinks a picture so that its longer side is at most `most` pixels (`most` at least 1). Pixels are
/// alpha-weighted means of blocks.
Pixels shrunk(const Pixels& picture, std::size_t most);

/// Places pictures side by side, with `gap` white pixels between them.
Pixels side_by_side(const std::vector<Pixels>& pictures, std::size_t gap);

/// The role of a pixel in a region.
enum class PixelKind : std::uint8_t {
    outside,
    outline, ///< in the region; shares an edge with a pixel outside it
    inside,
};

/// A set of pixels in its bounding box.
struct PixelRegion {
    std::size_t left = 0, top = 0; ///< of the box, in the picture
    std::size_t width = 0, height = 0;
    std::vector<PixelKind> kinds;       ///< width · height, row-major
    std::vector<std::uint32_t> outline; ///< indices into `kinds`, ascending
    std::size_t inside = 0;             ///< number of inner pixels

    bool is_empty() const { return width == 0; }
};

/// Makes a region of the pixels with nonzero mask.
///
///   mask   width · height, row-major
PixelRegion make_region(const std::vector<std::uint8_t>& mask, std::size_t width);

/// Marks pixels with luminance times alpha of at least one half.
std::vector<std::uint8_t> mask_of(const Pixels& picture);

/// Marks pixels whose centres are inside closed loops (even-odd rule). Pixel (x, y) has its centre at (x + ½,
/// y + ½).
std::vector<std::uint8_t> mask_of(const std::vector<std::vector<Point2>>& loops, std::size_t width,
                                  std::size_t height);

} // namespace cageform_support
