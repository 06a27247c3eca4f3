#include "model_sheet.hpp"

#include <cmath>
#include <numbers>

namespace cageform_sources {

using namespace cageform_support;

namespace {

constexpr double letter = 2; // size of captions, as of Picture::text()
constexpr std::size_t title_height = 46, caption_height = 50;

constexpr Colour text_ink{0.15f, 0.15f, 0.15f};

void copy_into(Picture& picture, const Picture& part, std::size_t left, std::size_t top) {
    for (std::size_t y = 0; y < part.height(); ++y) {
        for (std::size_t x = 0; x < part.width(); ++x) picture.at(left + x, top + y) = part.at(x, y);
    }
}

} // namespace

void Model::add_rod(const Point3& a, const Point3& b, double radius_a, double radius_b, const Colour& colour,
                    std::uint32_t sides) {
    const Point3 d = b - a;
    const Point3 along = length(d) > 0 ? (1 / length(d)) * d : Point3{0, 0, 1};
    const Point3 other = std::fabs(along[0]) < 0.7 ? Point3{1, 0, 0} : Point3{0, 1, 0};
    const Point3 across = cross(along, other), u = (1 / length(across)) * across, v = cross(along, u);
    const std::uint32_t rings = sides / 2; // a hemisphere at each end
    const auto first = std::uint32_t(vertices.size());
    for (std::uint32_t ring = 0; ring < rings; ++ring) {
        const bool at_b = 2 * ring >= rings;
        const double rise = std::numbers::pi * ((ring - at_b) / double(rings - 2) - 0.5);
        const double radius = at_b ? radius_b : radius_a;
        for (std::uint32_t side = 0; side < sides; ++side) {
            const double angle = 2 * std::numbers::pi * side / sides;
            vertices.push_back((at_b ? b : a) +
                               radius * (std::sin(rise) * along +
                                         std::cos(rise) * (std::cos(angle) * u + std::sin(angle) * v)));
            colours.push_back(colour);
            if (ring == 0) continue;
            const std::uint32_t i = first + ring * sides + side,
                                next = side + 1 < sides ? i + 1 : i + 1 - sides;
            faces.push_back({i, i - sides, next});
            faces.push_back({next, i - sides, next - sides});
        }
    }
}

Picture draw_tiles(const std::vector<Tile>& tiles, std::size_t columns, std::size_t width,
                   std::size_t height) {
    std::vector<MeshScene> scenes;
    for (const Tile& tile : tiles)
        scenes.push_back({{tile.model.vertices, tile.model.faces, tile.model.colours}, tile.cage});
    const Picture drawn = draw_meshes(scenes, width * tiles.size(), height);
    const std::size_t rows = (tiles.size() + columns - 1) / columns;
    Picture sheet(columns * width, rows * (height + caption_height), drawn.at(0, 0));
    for (std::size_t n = 0; n < tiles.size(); ++n) {
        const std::size_t left = n % columns * width, top = n / columns * (height + caption_height);
        for (std::size_t y = 0; y < height; ++y) {
            for (std::size_t x = 0; x < width; ++x)
                sheet.at(left + x, top + caption_height + y) = drawn.at(n * width + x, y);
        }
        sheet.text({double(left) + 16, double(top) + 14}, tiles[n].caption, letter, text_ink);
    }
    return sheet;
}

Picture with_title(const std::string& title, const std::vector<Picture>& parts) {
    std::size_t height = title_height, width = 0;
    for (const Picture& part : parts) {
        height += part.height();
        width = std::max(width, part.width());
    }
    Picture sheet(width, height, parts.front().at(0, 0));
    std::size_t top = title_height;
    for (const Picture& part : parts) {
        copy_into(sheet, part, 0, top);
        top += part.height();
    }
    sheet.text({16, 24}, title, 1.5 * letter, text_ink);
    return sheet;
}

Picture beside(const std::vector<Picture>& parts) {
    std::size_t width = 0;
    for (const Picture& part : parts) width += part.width();
    Picture sheet(width, parts.front().height());
    std::size_t left = 0;
    for (const Picture& part : parts) {
        copy_into(sheet, part, left, 0);
        left += part.width();
    }
    return sheet;
}

Picture with_bar(const Picture& part, double most, const std::string& unit) {
    constexpr std::size_t width = 170;
    Picture bar(width, part.height(), part.at(0, 0));
    const Axis shares{0, 1, double(part.height()) - 40, 80};
    auto marks = marks_of(Axis{0, most, shares.begin, shares.end}, 6);
    for (AxisMark& mark : marks) mark.value /= most;
    draw_colour_bar(bar, shares, marks, 20, 26, letter);
    bar.text({20, 40}, unit, letter, text_ink);
    return beside({part, bar});
}

std::vector<Colour> heat_of(const std::vector<double>& values, double most) {
    std::vector<Colour> colours;
    for (const double value : values) colours.push_back(heat(value / most));
    return colours;
}

void write_caption(Picture& picture, const Point2& at, const std::string& caption) {
    picture.text(at, caption, letter, text_ink);
}

} // namespace cageform_sources
