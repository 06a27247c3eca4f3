// Functions of cage_file.hpp for cages of curves.
#include "files/cage_file.hpp"

#include "svg/document.hpp"

#include <array>

namespace cageform_support {

namespace {

using detail::counted;

/// The lowest degree of a segment: 1 or 2 if its control points are exactly those of a line or quadratic.
unsigned degree_of(const Point2& from, const Segment& s) {
    if (s.p1 == PathBuilder::third(from, s.p3) && s.p2 == PathBuilder::third(s.p3, from)) return 1;
    const Point2 control = quadratic_control(from, s.p1);
    return s.p1 == PathBuilder::third(control, from) && s.p2 == PathBuilder::third(control, s.p3) ? 2 : 3;
}

/// "a line (L)".
std::string name_of_degree(unsigned n) {
    static constexpr std::array names{"a line (L)", "a quadratic (Q)", "a cubic (C)"};
    return names[n - 1];
}

/// The loops of a polygon as closed paths of lines.
std::vector<Subpath> outline_of(const CageFile& polygon) {
    PathBuilder builder;
    for (const CageBlock& block : polygon.blocks) {
        builder.move_to(block.points.front());
        for (std::size_t k = 1; k < block.points.size(); ++k) builder.line_to(block.points[k]);
        builder.line_to(block.points.front()); // even if shorter than rounding errors
    }
    return builder.take();
}

} // namespace

std::vector<Subpath> CageFile::outline() const {
    std::vector<Subpath> loops;
    for (const CageBlock& block : blocks) {
        const auto& points = block.points;
        Subpath& loop = loops.emplace_back();
        loop.start = points.front();
        loop.closed = true;
        for (std::size_t k = 0; k < points.size(); k += 3) {
            Segment edge{points[k + 1], points[k + 2], points[(k + 3) % points.size()]};
            edge.degree = degree_of(points[k], edge);
            loop.segments.push_back(edge);
        }
    }
    return loops;
}

std::vector<std::vector<Point2>> CageFile::loops(double distance, std::size_t least_pieces) const {
    std::vector<std::vector<Point2>> loops;
    if (!curves) {
        for (const CageBlock& block : blocks) {
            if (block.kind == CageBlock::Kind::loop) loops.push_back(block.points);
        }
        return loops;
    }
    for (const Subpath& path : outline()) {
        auto& loop = loops.emplace_back();
        Point2 from = path.start;
        for (const Segment& edge : path.segments) {
            const std::size_t pieces = std::max(least_pieces, pieces_of(from, edge, distance));
            for (std::size_t n = 0; n < pieces; ++n)
                loop.push_back(place_on(from, edge, double(n) / double(pieces)));
            from = edge.p3;
        }
    }
    return loops;
}

std::vector<std::vector<std::size_t>> CageFile::followers() const {
    std::vector<std::vector<std::size_t>> list(curves ? vertices.size() : 0);
    for (std::size_t b = 0; b < handles.size() && curves; ++b) {
        const auto& around = handles[b];
        for (std::size_t k = 0; k < around.size(); k += 3)
            list[around[k]] = {around[(k + around.size() - 1) % around.size()], around[k + 1]};
    }
    return list;
}

CageFile make_curved_cage(std::string name, const std::vector<Subpath>& loops) {
    std::vector<CageBlock> blocks;
    CageCurves curves;
    for (const Subpath& loop : loops) {
        CageBlock& block = blocks.emplace_back(CageBlock{CageBlock::Kind::loop, 0, {}});
        auto& degrees = curves.degrees.emplace_back();
        Point2 from = loop.start;
        for (const Segment& s : loop.segments) {
            block.points.insert(block.points.end(), {from, s.p1, s.p2});
            degrees.push_back(s.degree);
            from = s.p3;
        }
    }
    CageFile cage = make_cage(std::move(name), std::move(blocks));
    cage.curves = std::move(curves);
    return cage;
}

Expected<CageFile> with_curves(CageFile cage) {
    if (cage.curves || cage.lattice) return cage;
    if (cage.has_cells())
        return FileError{cage.name + ": " +
                         cageform::to_string(cageform::Status::interior_cells_not_supported) +
                         ": --coordinates curved-green supports only loops, harmonic also chains and points"};
    return make_curved_cage(cage.name, outline_of(cage));
}

Expected<CageFile> make_curved_pose(CageFile pose, const CageFile& cage) {
    if (!pose.curves) return FileError{pose.name + ": is no outline, but the cage " + cage.name + " is one"};
    const auto &posed = pose.curves->degrees, &rest = cage.curves->degrees;
    if (posed.size() != rest.size())
        return FileError{pose.name + ": the pose has " + counted(posed.size(), "loop") + ", the cage " +
                         cage.name + " " + counted(rest.size(), "loop")};
    for (std::size_t b = 0; b < rest.size(); ++b) {
        const std::size_t is = posed[b].size(), was = rest[b].size(), both = std::min(is, was);
        std::size_t e = 0;
        while (e < both && posed[b][e] >= rest[b][e]) ++e;
        if (e == both && is == was) continue;
        const auto edge = [e](unsigned n) {
            return "edge " + std::to_string(e) + ", counted from 0, " + name_of_degree(n);
        };
        std::string text = pose.name + ": " + (rest.size() > 1 ? "loop " + std::to_string(b) + ": " : "");
        if (is != was)
            text += "the pose has " + counted(is, "edge") + ", the cage " + cage.name + " " +
                    std::to_string(was) + ": ";
        if (e < both)
            return FileError{text + edge(posed[b][e]) + ", is " + name_of_degree(rest[b][e]) +
                             " in the cage" + (is == was ? ' ' + cage.name : "")};
        return FileError{
            text + (is < was ? edge(rest[b][e]) + ", is missing" : edge(posed[b][e]) + ", is one too many")};
    }
    return pose;
}

} // namespace cageform_support
