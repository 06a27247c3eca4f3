#include "files/cage_file.hpp"

#include "svg/document.hpp"

#include <charconv>
#include <numeric>
#include <sstream>

namespace cageform_examples {

namespace {

/// Formats a number with the fewest digits that restore it.
std::string digits_of(double x) {
    std::array<char, 32> digits;
    return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr};
}
std::string digits_of(const Point2& p) {
    return digits_of(p.x) + ',' + digits_of(p.y);
}

} // namespace

CageFile make_cage(std::string name, std::vector<CageBlock> blocks) {
    CageFile cage{std::move(name), std::move(blocks), {}, {}};
    cageform::CellComplex<double, 2> complex(cage.polygon<double>());
    std::size_t first = 0;
    for (const CageBlock& block : cage.blocks) {
        auto& handles = cage.handles.emplace_back(CageFile::add_cells(complex, block));
        if (block.kind != CageBlock::Kind::loop) continue;
        handles.resize(block.points.size());
        std::iota(handles.begin(), handles.end(), first);
        first += handles.size();
    }
    for (const auto& v : complex.vertices()) cage.vertices.push_back({v[0], v[1]});
    return cage;
}

SvgResult<CageFile> load_cage(const std::string& path) {
    if (path.ends_with(".csv")) {
        auto blocks = read_cage_csv(path);
        if (!blocks) return blocks.error();
        return make_cage(path, std::move(*blocks));
    }
    const auto document = load_svg(path);
    if (!document) return document.error();
    auto loops = first_polygon(*document);
    if (!loops) return loops.error();
    std::vector<CageBlock> blocks;
    for (auto& loop : *loops) blocks.push_back({CageBlock::Kind::loop, 0, std::move(loop)});
    return make_cage(path, std::move(blocks));
}

SvgResult<std::string> to_svg(const CageFile& cage, const ViewBox& view) {
    std::string path;
    for (const CageBlock& block : cage.blocks) {
        if (block.points.front() == block.points.back())
            return SvgError{cage.name + ": two vertices lie at the same position, " +
                            name_points(block.points, {0}) +
                            ", which an SVG file cannot store; a CSV file can"};
        for (const Point2& p : block.points)
            path += (path.empty() || path.back() == 'Z' ? "M" : " ") + digits_of(p);
        path += 'Z';
    }
    const auto numbers = [](double x, double y) { return digits_of(x) + ' ' + digits_of(y); };
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"" + numbers(view.x, view.y) + ' ' +
           numbers(view.width, view.height) + "\">\n<path fill=\"none\" stroke=\"#c2377a\" stroke-width=\"" +
           detail::short_number(std::hypot(view.width, view.height) / 400) +
           "\" stroke-linejoin=\"round\" d=\"" + path + "\"/>\n</svg>\n";
}

std::string to_csv(const CageFile& cage) {
    std::string text;
    for (const CageBlock& block : cage.blocks) {
        if (!text.empty()) text += '\n';
        if (block.kind == CageBlock::Kind::chain) text += "# chain\n";
        if (block.kind == CageBlock::Kind::point) text += "# point " + digits_of(block.radius) + '\n';
        for (const Point2& p : block.points) text += digits_of(p) + '\n';
    }
    return text;
}

void draw_cage(SvgDocument& document, const std::vector<CageBlock>& blocks, double diagonal,
               const std::string& colour) {
    auto group = document.xml.document_element().append_child("g");
    group.append_attribute("fill") = "none";
    group.append_attribute("stroke") = colour.c_str();
    group.append_attribute("stroke-width") = diagonal / 400;
    group.append_attribute("stroke-linejoin") = "round";
    group.append_attribute("stroke-dasharray") = diagonal / 100;
    for (const CageBlock& block : blocks) {
        const Point2& first = block.points.front();
        if (block.kind == CageBlock::Kind::point) {
            auto circle = group.append_child("circle");
            circle.append_attribute("cx") = first.x;
            circle.append_attribute("cy") = first.y;
            if (block.radius > 0) {
                circle.append_attribute("r") = block.radius;
            } else { // a site: a dot
                circle.append_attribute("r") = diagonal / 120;
                circle.append_attribute("fill") = colour.c_str();
                circle.append_attribute("stroke") = "none";
            }
            continue;
        }
        Subpath line;
        line.start = first;
        line.closed = block.kind == CageBlock::Kind::loop;
        for (std::size_t k = 1; k < block.points.size() + (line.closed ? 1 : 0); ++k) {
            const Point2& p = block.points[k % block.points.size()];
            line.segments.push_back({p, p, p, true});
        }
        group.append_child("path").append_attribute("d") = write_path_data({line}, 3).c_str();
    }
}

std::vector<cageform::Vec<double, 2>> CageFile::places() const {
    std::vector<cageform::Vec<double, 2>> places;
    places.reserve(vertices.size());
    for (const Point2& p : vertices) places.push_back({p.x, p.y});
    return places;
}

CageFile moved_cage(CageFile cage, std::span<const cageform::Vec<double, 2>> places) {
    for (std::size_t i = 0; i < places.size(); ++i) cage.vertices[i] = {places[i][0], places[i][1]};
    for (std::size_t b = 0; b < cage.blocks.size(); ++b) {
        for (std::size_t k = 0; k < cage.handles[b].size(); ++k)
            cage.blocks[b].points[k] = cage.vertices[cage.handles[b][k]];
    }
    return cage;
}

std::string name_points(std::span<const Point2> points, const std::vector<std::size_t>& indices) {
    std::ostringstream text;
    for (std::size_t n = 0; n < std::min<std::size_t>(indices.size(), 3); ++n) {
        const Point2& p = points[indices[n]];
        text << (n == 0 ? "" : ", ") << '(' << p.x << ", " << p.y << ')';
    }
    if (indices.size() > 3) text << ", …";
    return text.str();
}

std::string describe(const CageBlock& block) {
    std::ostringstream text;
    switch (block.kind) {
    case CageBlock::Kind::loop: text << "a loop of " << block.points.size() << " vertices"; break;
    case CageBlock::Kind::chain: text << "a chain of " << block.points.size() << " points"; break;
    case CageBlock::Kind::point: text << "a point of radius " << block.radius; break;
    }
    return text.str();
}

SvgResult<CageFile> make_pose(CageFile pose, const CageFile& cage) {
    const auto differ = [&](const std::string& where, const std::string& has, const std::string& expected) {
        return SvgError{pose.name + ": " + where + "the pose has " + has + ", the cage " + cage.name + " " +
                        expected};
    };
    const std::size_t count = cage.blocks.size();
    for (std::size_t b = 0; b < std::min(pose.blocks.size(), count); ++b) {
        const CageBlock &is = pose.blocks[b], &was = cage.blocks[b];
        if (is.kind == was.kind && is.points.size() == was.points.size() && is.radius == was.radius) continue;
        return differ(count > 1 ? "block " + std::to_string(b + 1) + ": " : "", describe(is), describe(was));
    }
    const auto blocks = [](std::size_t n) { return std::to_string(n) + (n == 1 ? " block" : " blocks"); };
    if (pose.blocks.size() != count) return differ("", blocks(pose.blocks.size()), blocks(count));

    pose.handles = cage.handles;
    pose.vertices.resize(cage.vertices.size());
    std::vector<bool> known(cage.vertices.size());
    for (std::size_t b = 0; b < count; ++b) {
        for (std::size_t k = 0; k < pose.handles[b].size(); ++k) {
            const std::size_t i = pose.handles[b][k];
            const Point2& p = pose.blocks[b].points[k];
            if (known[i] && !(p == pose.vertices[i])) {
                std::ostringstream text;
                text << pose.name << ": vertex " << i << " of the cage " << cage.name << " is at ("
                     << pose.vertices[i].x << ", " << pose.vertices[i].y << ") and, in block " << b + 1
                     << ", at (" << p.x << ", " << p.y << ')';
                return SvgError{text.str()};
            }
            pose.vertices[i] = p;
            known[i] = true;
        }
    }
    return pose;
}

SvgResult<CageFile> load_pose(const std::string& path, const CageFile& cage) {
    auto pose = load_cage(path);
    return pose ? make_pose(std::move(*pose), cage) : pose;
}

} // namespace cageform_examples
