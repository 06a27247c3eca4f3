#include "cage_file.hpp"

#include "svg_document.hpp"

#include <numeric>
#include <sstream>

namespace cageform_examples {

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
