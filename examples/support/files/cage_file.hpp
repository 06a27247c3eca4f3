#pragma once

// Cages in the plane and poses of them, as files.

#include "files/lattice_file.hpp"
#include "io/csv.hpp"

#include <cageform/cage/cell_complex.hpp>
#include <cageform/cage/curved/curved_polygon.hpp>
#include <cageform/core/point.hpp>

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

template <>
struct cageform::PointTraits<cageform_support::Point2> {
    using P = cageform_support::Point2;
    using scalar = double;
    static constexpr std::size_t dimension = 2;
    static constexpr double get(const P& p, std::size_t axis) noexcept { return axis == 0 ? p.x : p.y; }
    static constexpr void set(P& p, std::size_t axis, double x) noexcept { (axis == 0 ? p.x : p.y) = x; }
};

namespace cageform_support {

struct SvgDocument;
struct ViewBox;

/// A cage of curves has this beside the control points of its loops.
struct CageCurves {
    std::vector<std::vector<unsigned>> degrees; // of each loop's edges, as drawn: 1 to 3
};

/// A cage in the plane, as read: loops, and perhaps chains and points inside them. The blocks of a lattice
/// are its rows and columns, as chains; the vertices are its control points, then the still handles. A
/// block of curves, which are posed as cubics, has three points for every edge: its start and the control
/// points that follow.
struct CageFile {
    std::string name;
    std::vector<CageBlock> blocks;
    std::vector<std::vector<std::size_t>> handles; // of each block's points
    std::vector<Point2> vertices; // by handle: the loops', then those that chains and points add
    std::optional<LatticeBox<2>> lattice = {};
    std::optional<CageCurves> curves = {};

    bool has(CageBlock::Kind kind) const {
        return std::any_of(blocks.begin(), blocks.end(),
                           [&](const CageBlock& block) { return block.kind == kind; });
    }
    bool has_cells() const { return has(CageBlock::Kind::chain) || has(CageBlock::Kind::point); }

    std::vector<cageform::Vec<double, 2>> places() const; ///< of the vertices

    /// The loops of a cage of curves, each closed. Edges are of the degrees that their control points allow.
    std::vector<Subpath> outline() const;

    /// The loops as polygons. Each curve is cut into at least `least_pieces` lines, and into so many that
    /// they are at most `distance` off it.
    std::vector<std::vector<Point2>> loops(double distance, std::size_t least_pieces = 1) const;

    /// The loops of a cage of curves.
    template <class T>
    cageform::CurvedPolygon<T> curved_polygon() const;

    /// By handle, what moves along with it: of curves, with the end of an edge the control points beside it;
    /// of other cages nothing, and the list is empty.
    std::vector<std::vector<std::size_t>> followers() const;

    /// The loops alone.
    template <class T>
    cageform::Polygon<T> polygon() const {
        std::vector<Point2> points;
        std::vector<std::size_t> sizes;
        for (const CageBlock& block : blocks) {
            if (block.kind != CageBlock::Kind::loop) continue;
            sizes.push_back(block.points.size());
            points.insert(points.end(), block.points.begin(), block.points.end());
        }
        return {points, sizes};
    }

    /// The loops and what is inside them.
    template <class T>
    cageform::CellComplex<T, 2> complex() const {
        cageform::CellComplex<T, 2> cage(polygon<T>());
        for (const CageBlock& block : blocks) add_cells(cage, block);
        return cage;
    }

    /// Calls f(cage) with a Polygon, or with a CellComplex where there are chains or points.
    template <class T, class F>
    auto visit(F&& f) const {
        return has_cells() ? f(complex<T>()) : f(polygon<T>());
    }

    /// Calls f(i, j) with the handles of every edge of a loop or chain, of curves of every leg from a control
    /// point to the next; f(i, i) for a point.
    template <class F>
    void for_each_edge(F&& f) const {
        for (std::size_t b = 0; b < blocks.size(); ++b) {
            const bool closed = blocks[b].kind != CageBlock::Kind::chain;
            for (std::size_t k = closed ? 0 : 1, n = handles[b].size(); k < n; ++k)
                f(handles[b][(k + n - 1) % n], handles[b][k]);
        }
    }

    /// Adds a chain or a point to a cage; returns the handles, none for a loop.
    template <class T>
    static std::vector<std::size_t> add_cells(cageform::CellComplex<T, 2>& cage, const CageBlock& block) {
        if (block.kind == CageBlock::Kind::chain) return cage.add_chain(block.points);
        if (block.kind == CageBlock::Kind::point)
            return {cage.add_point(block.points.front(), T(block.radius))};
        return {};
    }
};

template <class T>
cageform::CurvedPolygon<T> CageFile::curved_polygon() const {
    std::vector<typename cageform::CurvedPolygon<T>::Loop> loops;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        auto& loop = loops.emplace_back();
        const auto& points = blocks[b].points;
        for (std::size_t e = 0; e < curves->degrees[b].size(); ++e) {
            const Point2 &start = points[3 * e], &one = points[3 * e + 1], &other = points[3 * e + 2],
                         &end = points[(3 * e + 3) % points.size()];
            auto& edge = loop.emplace_back();
            const auto add = [&edge](double x, double y) { edge.push_back({T(x), T(y)}); };
            add(start.x, start.y);
            const Point2 control = quadratic_control(start, one);
            if (curves->degrees[b][e] == 2) add(control.x, control.y);
            if (curves->degrees[b][e] == 3) {
                add(one.x, one.y);
                add(other.x, other.y);
            }
            add(end.x, end.y);
        }
    }
    return cageform::CurvedPolygon<T>(std::move(loops));
}

/// The text for --help on the formats of a cage in the plane and its pose.
inline constexpr const char* cage_formats =
    "A cage in the plane is the first closed polygon of an SVG file (a polygon, a rect\n"
    "or a path of lines), or a CSV file (.csv) of blocks of lines x,y with empty lines\n"
    "between them. A block is a loop: the outer one comes first, then holes and islands.\n"
    "For harmonic coordinates a block can also be a chain of points inside, headed by a\n"
    "line \"# chain\", or one point, headed by \"# point RADIUS\". A point of a chain\n"
    "that equals an earlier vertex is that vertex. Other lines that begin with # are\n"
    "comments. A pose is a file of the same blocks with the points moved.\n"
    "For curved coordinates it is the first closed outline, which may have curves: an\n"
    "edge has the degree that it is drawn with, an arc is cubics of at most 45 degrees,\n"
    "and each subpath is a loop. A polygon is an outline too. In poses all edges are\n"
    "cubics, so vertices are control points, three for each edge: its start and the two\n"
    "that follow. A pose is an outline of the same commands, or of commands of a higher\n"
    "degree (C in place of L).\n"
    "Options and messages count vertices and points from 0, blocks from 1.\n";

/// How the edges of a cage are read.
enum class CageEdges {
    lines,   ///< an outline with curves is refused
    curves,  ///< all are curves, lines too
    as_drawn ///< a polygon has lines, an outline with curves has curves
};

CageFile make_cage(std::string name, std::vector<CageBlock> blocks);
CageFile make_cage(std::string name, LatticeBox<2> lattice);

/// Reads a cage: the first closed polygon or outline of an SVG file, a CSV file of loops, chains and points,
/// or a lattice.
Expected<CageFile> load_cage(const std::string& path, CageEdges edges = CageEdges::lines);

/// A cage of curves.
///
///   loops   each ends exactly where it begins, as first_outline() returns them
CageFile make_curved_cage(std::string name, const std::vector<Subpath>& loops);

/// Makes the edges of loops curves. A cage of curves and a lattice stay as they are; fails where there are
/// chains or points.
Expected<CageFile> with_curves(CageFile cage);

/// A cage as the file that load_cage() reads back to the bit: an SVG document, or CSV. A lattice is written
/// as load_pose() reads it: its rows and columns, or in CSV its control points.
///
///   view    the document's viewBox
///   cage    of loops, in SVG; in CSV not of curves
///   fails   in SVG, where the first and the last vertex of a loop lie at one place: there they would be one
Expected<std::string> to_svg(const CageFile& cage, const ViewBox& view);
std::string to_csv(const CageFile& cage);

/// A pose of a cage as the text of a file, .svg or .csv by the ending of its path.
///
///   fails   as to_svg() does, and where the cage has what the format cannot hold: chains or points in SVG,
///           curves in CSV
Expected<std::string> pose_text(const CageFile& pose, const std::string& path, const ViewBox& view);

/// Draws a cage into an SVG document, in root user space: loops and chains as dashed lines, points as
/// circles. Ends of curves are squares, and their control points circles on thin lines to them; an edge that
/// is a line shows none.
///
///   diagonal   of the picture, which thicknesses go by
void draw_cage(SvgDocument& document, const CageFile& cage, double diagonal, const std::string& colour);

/// Returns the cage with its vertices (by handle) at other positions.
CageFile moved_cage(CageFile cage, std::span<const cageform::Vec<double, 2>> places);

/// "(412, 88), …" for the first few of a list of points.
std::string name_points(std::span<const Point2> points, const std::vector<std::size_t>& indices);

/// "a chain of 3 points".
std::string describe(const CageBlock& block);

/// Gives a pose, read as a cage, the handles of the cage it is a pose of. Its blocks have to be those of
/// the cage, and what is one vertex there has to be at one place.
Expected<CageFile> make_pose(CageFile pose, const CageFile& cage);

/// A pose of a lattice, from lines of points: its rows along x, then its columns. Where a row and a column
/// differ, the one that has moved counts.
///
///   fails   where the lines are not those of the lattice, or both have moved a point, to different places
Expected<CageFile> make_lattice_pose(const std::string& name, const std::vector<std::vector<Point2>>& lines,
                                     const CageFile& cage);

/// Works as make_pose(), of a cage of curves. The loops of the pose have to have as many edges as the cage's,
/// none of a lower degree; the message names the first edge that differs.
Expected<CageFile> make_curved_pose(CageFile pose, const CageFile& cage);

/// Works as make_pose(), from a file; fails also as load_cage() does. A pose of a lattice is an SVG file of
/// its rows and columns, or a CSV file of its control points.
Expected<CageFile> load_pose(const std::string& path, const CageFile& cage);

} // namespace cageform_support
