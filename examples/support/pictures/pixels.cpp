#include "pictures/pixels.hpp"

#include "io/input_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function" // only loading is used
#endif
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#include <stb/stb_image.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace cageform_support {

std::string Pixels::png() const {
    return encoded_png(width, height, 4, {bytes.begin(), bytes.end()});
}

void Pixels::write_png(AtomicFile& file) const {
    cageform_support::write_png(file, width, height, 4, {bytes.begin(), bytes.end()});
}

Expected<Pixels> read_png(const std::string& path) {
    const auto text = read_file(path);
    if (!text) return text.error();
    const auto refuse = [&](const std::string& why) { return FileError{path + ": " + why}; };
    if (text->empty()) return refuse("the file is empty");
    if (!text->starts_with("\x89PNG\r\n\x1a\n"))
        return refuse("is not a PNG file; convert it to one, or name another");
    constexpr std::int64_t most = 100'000'000;
    if (text->size() > std::size_t(most) * 8)
        return refuse("is larger than any picture of 100 million pixels");
    const auto* const data = reinterpret_cast<const stbi_uc*>(text->data());
    const auto number_at = [&](std::size_t at) { // PNG specification, sec. 11.2.2: width and height
        std::int64_t number = 0;
        for (std::size_t k = 0; k < 4 && at + k < text->size(); ++k) number = number << 8 | data[at + k];
        return number;
    };
    if (const std::int64_t width = number_at(16), height = number_at(20); height > 0 && width > most / height)
        return refuse("holds " + std::to_string(width) + " x " + std::to_string(height) +
                      " pixels; 100 million are the most: shrink it");
    int width = 0, height = 0, channels = 0;
    stbi_uc* const decoded = stbi_load_from_memory(data, int(text->size()), &width, &height, &channels, 4);
    if (decoded == nullptr) return refuse("is a damaged PNG file");
    Pixels picture{std::size_t(width), std::size_t(height)};
    std::copy_n(decoded, picture.bytes.size(), picture.bytes.begin());
    stbi_image_free(decoded);
    return picture;
}

Pixels shrunk(const Pixels& picture, std::size_t most) {
    const std::size_t longer = std::max(picture.width, picture.height);
    if (longer <= most) return picture;
    const auto reduced = [&](std::size_t n) { return std::max<std::size_t>(1, n * most / longer); };
    Pixels small{reduced(picture.width), reduced(picture.height)};
    for (std::size_t y = 0; y < small.height; ++y) {
        for (std::size_t x = 0; x < small.width; ++x) {
            std::array<double, 4> sum{};
            std::size_t count = 0;
            const std::size_t end_y = (y + 1) * picture.height / small.height,
                              end_x = (x + 1) * picture.width / small.width;
            for (std::size_t v = y * picture.height / small.height; v < end_y; ++v) {
                for (std::size_t u = x * picture.width / small.width; u < end_x; ++u, ++count) {
                    const std::uint8_t* const pixel = picture.at(u, v);
                    for (std::size_t k = 0; k < 3; ++k) sum[k] += double(pixel[k]) * pixel[3];
                    sum[3] += pixel[3];
                }
            }
            for (std::size_t k = 0; k < 3; ++k)
                small.at(x, y)[k] = std::uint8_t(std::lround(sum[3] > 0 ? sum[k] / sum[3] : 0));
            small.at(x, y)[3] = std::uint8_t(std::lround(sum[3] / double(count)));
        }
    }
    return small;
}

Pixels side_by_side(const std::vector<Pixels>& pictures, std::size_t gap) {
    Pixels strip;
    for (const Pixels& picture : pictures) {
        strip.width += picture.width + (strip.width > 0 ? gap : 0);
        strip.height = std::max(strip.height, picture.height);
    }
    strip.bytes.assign(4 * strip.width * strip.height, 255);
    std::size_t left = 0;
    for (const Pixels& picture : pictures) {
        for (std::size_t y = 0; y < picture.height; ++y)
            std::copy_n(picture.at(0, y), 4 * picture.width, strip.at(left, y));
        left += picture.width + gap;
    }
    return strip;
}

PixelRegion make_region(const std::vector<std::uint8_t>& mask, std::size_t width) {
    const std::size_t height = mask.size() / std::max<std::size_t>(width, 1);
    std::size_t left = width, right = 0, top = height, bottom = 0;
    for (std::size_t y = 0; y < height; ++y) {
        const auto row = mask.begin() + std::ptrdiff_t(y * width), end = row + std::ptrdiff_t(width);
        const auto is_set = [](std::uint8_t mark) { return mark != 0; };
        const auto first = std::find_if(row, end, is_set);
        if (first == end) continue;
        const auto last =
            std::find_if(std::make_reverse_iterator(end), std::make_reverse_iterator(row), is_set);
        left = std::min(left, std::size_t(first - row));
        right = std::max(right, std::size_t(last.base() - row));
        top = std::min(top, y);
        bottom = y + 1;
    }
    PixelRegion region;
    if (bottom == 0) return region;
    region.left = left;
    region.top = top;
    region.width = right - left;
    region.height = bottom - top;
    region.kinds.resize(region.width * region.height);
    for (std::size_t y = 0, i = 0; y < region.height; ++y) {
        const bool at_end = y == 0 || y + 1 == region.height;
        const std::uint8_t* const row = &mask[(top + y) * width + left];
        for (std::size_t x = 0; x < region.width; ++x, ++i) {
            if (row[x] == 0) continue;
            const bool is_outline = at_end || x == 0 || x + 1 == region.width || row[x + 1] == 0 ||
                                    *(row + x - 1) == 0 || row[x + width] == 0 || *(row + x - width) == 0;
            region.kinds[i] = is_outline ? PixelKind::outline : PixelKind::inside;
            if (is_outline)
                region.outline.push_back(std::uint32_t(i));
            else
                ++region.inside;
        }
    }
    return region;
}

std::vector<std::uint8_t> mask_of(const Pixels& picture) {
    std::vector<std::uint8_t> mask(picture.width * picture.height);
    for (std::size_t i = 0; i < mask.size(); ++i) {
        const std::uint8_t* const pixel = &picture.bytes[4 * i];
        const double light = 0.2126 * pixel[0] + 0.7152 * pixel[1] + 0.0722 * pixel[2];
        mask[i] = light * pixel[3] >= 127.5 * 255 ? 1 : 0;
    }
    return mask;
}

std::vector<std::uint8_t> mask_of(const std::vector<std::vector<Point2>>& loops, std::size_t width,
                                  std::size_t height) {
    // On each row that it crosses, an edge toggles all pixels to its right. The parity of crossings before a
    // pixel tells whether it is inside.
    std::vector<std::uint8_t> mask((width + 1) * height);
    for (const auto& loop : loops) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            Point2 a = loop[i], b = loop[(i + 1) % loop.size()];
            if (a.y > b.y) std::swap(a, b);
            const auto row_after = [&](double y) { // the first row with centre at or below y
                return std::size_t(std::clamp(std::ceil(y - 0.5), 0.0, double(height)));
            };
            for (std::size_t y = row_after(a.y), end = row_after(b.y); y < end; ++y) {
                const double x = std::lerp(a.x, b.x, (double(y) + 0.5 - a.y) / (b.y - a.y));
                mask[y * (width + 1) + std::size_t(std::clamp(std::ceil(x - 0.5), 0.0, double(width)))] ^= 1;
            }
        }
    }
    std::size_t to = 0;
    for (std::size_t y = 0; y < height; ++y) {
        std::uint8_t is_inside = 0;
        for (std::size_t x = 0; x < width; ++x, ++to) {
            is_inside ^= mask[y * (width + 1) + x];
            mask[to] = is_inside; // in place: `to` is not ahead of the read position
        }
    }
    mask.resize(to);
    return mask;
}

} // namespace cageform_support
