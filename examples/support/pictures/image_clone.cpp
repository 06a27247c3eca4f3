#include "pictures/image_clone.hpp"

#include <cageform/fields/dirichlet.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace cageform_support {

namespace {

/// Fixed-point colours: 1/255 is 2¹⁶.
constexpr int fraction_bits = 16;

std::int32_t fixed(float colour) {
    constexpr float most = 16000; // negative weights may give values outside 0 … 255
    return std::int32_t(std::clamp(colour, -most, most) * float(1 << fraction_bits));
}

/// Writes runs of pixels of a region into a picture.
class Paster {
public:
    Paster(const Pixels& source, const PixelRegion& region, const PixelPlace& at, Pixels& picture)
        : source_(source)
        , region_(region)
        , at_(at)
        , picture_(picture) {}

    void operator()(std::size_t first, std::size_t count, const Membrane::Values& start,
                    const Membrane::Values& step) const {
        const std::size_t x = first % region_.width, y = first / region_.width;
        const std::uint8_t* from = source_.at(region_.left + x, region_.top + y);
        std::uint8_t* to = picture_.at(std::size_t(at_.x) + x, std::size_t(at_.y) + y);
        constexpr std::int32_t half = 1 << (fraction_bits - 1);
        std::int32_t r = fixed(start[0]) + half, g = fixed(start[1]) + half, b = fixed(start[2]) + half;
        const std::int32_t dr = fixed(step[0]), dg = fixed(step[1]), db = fixed(step[2]);
        for (std::size_t i = 0; i < count; ++i, from += 4, to += 4) {
            const std::array<std::int32_t, 3> sums{from[0] + (r >> fraction_bits),
                                                   from[1] + (g >> fraction_bits),
                                                   from[2] + (b >> fraction_bits)};
            const std::int32_t alpha = from[3];
            for (std::size_t k = 0; k < 3; ++k) {
                const std::int32_t colour = std::clamp(sums[k], 0, 255);
                to[k] = std::uint8_t(alpha == 255 ? colour
                                                  : (colour * alpha + to[k] * (255 - alpha) + 127) / 255);
            }
            r += dr;
            g += dg;
            b += db;
        }
    }

private:
    const Pixels& source_;
    const PixelRegion& region_;
    PixelPlace at_;
    Pixels& picture_;
};

std::size_t pixel_there(const PixelRegion& region, const PixelPlace& at, std::size_t width, std::size_t i) {
    return (std::size_t(at.y) + i / region.width) * width + std::size_t(at.x) + i % region.width;
}

} // namespace

std::string fault_of_place(const PixelRegion& region, const Pixels& target, const PixelPlace& at) {
    const auto room_x = std::int64_t(target.width) - std::int64_t(region.width),
               room_y = std::int64_t(target.height) - std::int64_t(region.height);
    std::string beyond;
    const auto add = [&](std::int64_t by, const char* side) {
        if (by > 0) beyond += (beyond.empty() ? "" : ", ") + std::to_string(by) + " beyond its " + side;
    };
    add(-at.x, "left side");
    add(at.x - room_x, "right side");
    add(-at.y, "top");
    add(at.y - room_y, "bottom");
    if (beyond.empty()) return {};
    std::string why = "the region, " + std::to_string(region.width) + " x " + std::to_string(region.height) +
                      " pixels, extends beyond the target, " + std::to_string(target.width) + " x " +
                      std::to_string(target.height) + ": " + beyond + "; ";
    if (room_x < 0 || room_y < 0) return why + "the target is too small, so enlarge it or shrink the region";
    return why + "X from 0 to " + std::to_string(room_x) + " and Y from 0 to " + std::to_string(room_y) +
           " fit";
}

std::vector<Membrane::Values> outline_differences(const Pixels& source, const PixelRegion& region,
                                                  const Pixels& target, const PixelPlace& at) {
    std::vector<Membrane::Values> differences;
    differences.reserve(region.outline.size());
    for (const std::uint32_t i : region.outline) {
        const std::uint8_t* const from =
            source.at(region.left + i % region.width, region.top + i / region.width);
        const std::uint8_t* const to = &target.bytes[4 * pixel_there(region, at, target.width, i)];
        differences.push_back({float(to[0] - from[0]), float(to[1] - from[1]), float(to[2] - from[2])});
    }
    return differences;
}

Expected<std::vector<Membrane::Values>> poisson_function(const PixelRegion& region,
                                                         std::span<const Membrane::Values> outline,
                                                         const cageform::Running& running) {
    const std::size_t size = region.kinds.size();
    std::vector<cageform::Cell> cells(size);
    for (std::size_t i = 0; i < size; ++i) {
        cells[i] = region.kinds[i] == PixelKind::inside    ? cageform::Cell::unknown
                   : region.kinds[i] == PixelKind::outline ? cageform::Cell::given
                                                           : cageform::Cell::outside;
    }
    std::vector<float> fields(3 * size);
    for (std::size_t n = 0; n < outline.size(); ++n) {
        for (std::size_t k = 0; k < 3; ++k) fields[k * size + region.outline[n]] = outline[n][k];
    }
    // The error is below a quarter of a colour step. Masks like mazes need many cycles.
    const auto [status, report] = cageform::solve_dirichlet(
        cageform::CellBox<2>{{region.width, region.height}}, std::span<const cageform::Cell>(cells), fields,
        {.tolerance = 1e-4, .max_cycles = 500}, running);
    if (status != cageform::Status::ok)
        return FileError{std::string("the Poisson equation is not solved: ") + cageform::to_string(status)};
    std::vector<Membrane::Values> values(size);
    for (std::size_t i = 0; i < size; ++i) values[i] = {fields[i], fields[size + i], fields[2 * size + i]};
    return values;
}

void paste(const Pixels& source, const PixelRegion& region, const PixelPlace& at,
           std::span<const Membrane::Values> added, Pixels& picture) {
    const Paster paster(source, region, at, picture);
    for (std::size_t i = 0; i < region.kinds.size(); ++i) {
        if (region.kinds[i] == PixelKind::inside) paster(i, 1, added[i], {});
    }
}

void paste(const Pixels& source, const PixelRegion& region, const PixelPlace& at,
           std::span<const Membrane::Values> differences, Membrane& membrane, Pixels& picture) {
    membrane.interpolate(differences, Paster(source, region, at, picture));
}

ColourDifference colour_difference(const Pixels& a, const Pixels& b, const PixelRegion& region,
                                   const PixelPlace& at) {
    ColourDifference difference;
    std::size_t sum = 0;
    for (std::size_t i = 0; i < region.kinds.size(); ++i) {
        if (region.kinds[i] != PixelKind::inside) continue;
        const std::size_t pixel = 4 * pixel_there(region, at, a.width, i);
        for (std::size_t k = 0; k < 3; ++k) {
            const int apart = std::abs(int(a.bytes[pixel + k]) - int(b.bytes[pixel + k]));
            difference.largest = std::max(difference.largest, apart);
            sum += std::size_t(apart);
        }
    }
    if (region.inside > 0) difference.mean = double(sum) / double(3 * region.inside);
    return difference;
}

} // namespace cageform_support
