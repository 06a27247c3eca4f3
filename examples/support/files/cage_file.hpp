#pragma once

// Files of planar cages and their poses.

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

/// Additional data of a cage of curves.
struct CageCurves {
    std::vector<std::vector<unsigned>> degrees; // #loops · #edges: original degree, 1 to 3
};

/// A planar cage: loops, and optionally chains and points inside.
///
/// A lattice has its rows and columns as blocks (chains); its vertices are the control points, then the frame
/// handles. A loop of curves, posed as cubics, has three points per edge: the start and the two inner control
/// points.
struct CageFile {
    std::string name;
    std::vector<CageBlock> blocks;
    std::vector<std::vector<std::size_t>> handles; // #blocks · #points: vertex indices
    std::vector<Point2> vertices; // by handle: first those of loops, then those of chains and points
    std::optional<LatticeBox<2>> lattice = {};
    std::optional<CageCurves> curves = {};

    bool has(CageBlock::Kind kind) const {
        return std::any_of(blocks.begin(), blocks.end(),
                           [&](const CageBlock& block) { return block.kind == kind; });
    }
    bool has_cells() const { return has(CageBlock::Kind::chain) || has(CageBlock::Kind::point); }

    std::vector<cageform::Vec<double, 2>> places() const; ///< the vertices

    /// The closed loops of a cage of curves. Edges have the lowest degree that their control points allow.
    std::vector<Subpath> outline() const;

    /// The loops as polygons. Each curve becomes at least `least_pieces` lines, within `distance` of it.
    std::vector<std::vector<Point2>> loops(double distance, std::size_t least_pieces = 1) const;

    /// The loops of a cage of curves.
    template <class T>
    cageform::CurvedPolygon<T> curved_polygon() const;

    /// #vertices: vertices that move with each vertex. For curves, the control points beside the end of an
    /// edge; else empty.
    std::vector<std::vector<std::size_t>> followers() const;

    /// The loops, without chains and points.
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

    /// The loops, chains and points.
    template <class T>
    cageform::CellComplex<T, 2> complex() const {
        cageform::CellComplex<T, 2> cage(polygon<T>());
        for (const CageBlock& block : blocks) add_cells(cage, block);
        return cage;
    }

    /// Calls f(cage) with a Polygon, or a CellComplex if there are chains or points.
    template <class T, class F>
    auto visit(F&& f) const {
        return has_cells() ? f(complex<T>()) : f(polygon<T>());
    }

    /// Calls f(i, j) with the vertices of every edge of loops and chains, and f(i, i) for points. For curves,
    /// edges are pairs of adjacent control points.
    template <class F>
    void for_each_edge(F&& f) const {
        for (std::size_t b = 0; b < blocks.size(); ++b) {
            const bool closed = blocks[b].kind != CageBlock::Kind::chain;
            for (std::size_t k = closed ? 0 : 1, n = handles[b].size(); k < n; ++k)
                f(handles[b][(k + n - 1) % n], handles[b][k]);
        }
    }

    /// Adds a chain or point to a cage; returns its handles; none for a loop.
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

/// Help text on the formats of planar cages and poses.
inline constexpr const char* cage_formats =
    "A cage in the plane is the first closed polygon of an SVG file (a polygon, a rect\n"
    "or a path of lines), or a CSV file (.csv) of blocks of lines x,y with empty lines\n"
    "between them. A block is a loop: the outer one comes first, then holes and islands.\n"
    "For harmonic coordinates a block can also be a chain of points inside, headed by a\n"
    "line \"# chain\", or one point, headed by \"# point RADIUS\". A point of a chain\n"
    "that equals an earlier vertex is that vertex. Other lines that begin with # are\n"
    "comments. A pose is a file of the same blocks with the points moved.\n"
    "For curved coordinates a cage is the first closed outline, which may have curves:\n"
    "an edge has the degree that it is drawn with, an arc becomes cubics of at most 45\n"
    "degrees, and each subpath is a loop. Polygons are outlines too. In poses all edges\n"
    "are cubics, so vertices are control points, three for each edge: its start and the\n"
    "two that follow. A pose is an outline of the same commands, or of commands of a higher\n"
    "degree (C in place of L).\n"
    "Options and messages count vertices and points from 0, blocks from 1.\n";

/// Whether edges are lines or curves.
enum class CageEdges : std::uint8_t {
    lines,   ///< curves are an error
    curves,  ///< lines become curves
    as_drawn ///< curves if the outline has any
};

CageFile make_cage(std::string name, std::vector<CageBlock> blocks);
CageFile make_cage(std::string name, LatticeBox<2> lattice);

/// Reads a cage: the first closed polygon or outline of an SVG file, a CSV file of loops, chains and points,
/// or a lattice file.
Expected<CageFile> load_cage(const std::string& path, CageEdges edges = CageEdges::lines);

/// Makes a cage of curves.
///
///   loops   each ends exactly at its start, as from first_outline()
CageFile make_curved_cage(std::string name, const std::vector<Subpath>& loops);

/// Converts the edges of loops to curves. Cages of curves and lattices are returned unchanged; fails for
/// chains and points.
Expected<CageFile> with_curves(CageFile cage);

/// Writes a cage to SVG or CSV such that load_cage() restores every bit. A lattice is written as load_pose()
/// reads it: rows and columns in SVG, control points in CSV.
///
///   view    viewBox of the document
///   cage    in SVG loops only; in CSV no curves
///   fails   in SVG, if the first and last vertex of a loop coincide, since SVG would merge them
Expected<std::string> to_svg(const CageFile& cage, const ViewBox& view);
std::string to_csv(const CageFile& cage);

/// The text of a pose file, .svg or .csv by the extension of its path.
///
///   fails   as to_svg(); for chains or points in SVG, and curves in CSV
Expected<std::string> pose_text(const CageFile& pose, const std::string& path, const ViewBox& view);

/// Draws a cage into an SVG document, in root user space: loops and chains as dashed lines, points as
/// circles. Ends of curves are squares; inner control points are circles connected to them by thin lines,
/// except on straight edges.
///
///   diagonal   of the picture; determines line widths
void draw_cage(SvgDocument& document, const CageFile& cage, double diagonal, const std::string& colour);

/// The cage with new vertex positions (by handle).
CageFile moved_cage(CageFile cage, std::span<const cageform::Vec<double, 2>> places);

/// "(412, 88), …": the first three points of a list.
std::string name_points(std::span<const Point2> points, const std::vector<std::size_t>& indices);

/// "a chain of 3 points".
std::string describe(const CageBlock& block);

/// Checks a pose, read as a cage, against its cage, and assigns the cage's handles. The blocks have to match,
/// and points of one vertex have to coincide.
Expected<CageFile> make_pose(CageFile pose, const CageFile& cage);

/// Makes a pose of a lattice from its rows along x, then its columns. If a row and a column have different
/// positions of a point, the one that is not at rest is used.
///
///   fails   if the lines do not match the lattice, or a row and a column move a point to different positions
Expected<CageFile> make_lattice_pose(const std::string& name, const std::vector<std::vector<Point2>>& lines,
                                     const CageFile& cage);

/// As make_pose(), for a cage of curves. Each loop must have as many edges as in the cage, none of lower
/// degree; the message names the first edge that differs.
Expected<CageFile> make_curved_pose(CageFile pose, const CageFile& cage);

/// As make_pose(), from a file; fails also as load_cage(). A pose of a lattice is an SVG file of its rows and
/// columns, or a CSV file of its control points.
Expected<CageFile> load_pose(const std::string& path, const CageFile& cage);

} // namespace cageform_support
