// The figure that make_cage encloses, its options and its report, for the plane and for space.
#pragma once

#include <cageform/cage/types/report.hpp>
#include <cageform/core/result.hpp>
#include <cageform/core/types/scalar_range.hpp>
#include <cageform/core/vec.hpp>
#include <cageform/enclose/types/cage_parts.hpp>
#include <cageform/parallel/running.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A piece of a drawing: all points within `radius` of the segment from `a` to `b`. A stroke
/// consists of these, with half its width as the radius; an outline has radius 0.
template <Scalar T>
struct DrawnSegment {
    Vec<T, 2> a, b;
    T radius = 0;
};

/// Segments `begin` … `end` − 1 are closed outlines of one painted area.
struct PaintedArea {
    std::size_t begin = 0;
    std::size_t end = 0;
    bool even_odd = false; ///< the fill rule; otherwise non-zero, as in SVG
};

/// A drawing whose painted areas are known, so that a cage can keep their holes.
template <Scalar T>
struct Drawing {
    std::span<const DrawnSegment<T>> segments;
    std::span<const PaintedArea> areas{};
};
template <class Segments>
Drawing(const Segments&) -> Drawing<decltype(std::remove_cv_t<detail::element_t<const Segments>>::radius)>;
template <class Segments, class Areas>
Drawing(const Segments&, const Areas&)
    -> Drawing<decltype(std::remove_cv_t<detail::element_t<const Segments>>::radius)>;

/// A mirror plane (2D: a mirror line) perpendicular to an axis; the cage is symmetric about it.
struct MirrorPlane {
    std::size_t axis = 0;             ///< the axis that it is perpendicular to: 0, 1, 2 for x, y, z
    std::optional<double> position{}; ///< its coordinate on that axis; by default the middle of the figure
};

/// The shape that a cage follows.
enum class CageShape : std::uint8_t {
    figure, ///< the figure itself, with limbs and hollows
    hull,   ///< the convex hull of the figure
    box,    ///< the bounds, widened by the margin: 4 vertices, 8 in space
};

/// Controls how a cage is made; see enclose/make_cage.hpp.
struct MakeCageOptions {
    /// The number of vertices of the whole cage, in all its loops or shells. 0 stands for 24 in the
    /// plane and 112 in space. It is met except in these cases:
    ///   - a box has 4 vertices in the plane and 8 in space;
    ///   - a mirrored cage may miss it by one;
    ///   - several loops or shells have at least 4 vertices each, so the cage may have more;
    ///   - collapses stop early where none is possible without touching the figure or the cage;
    ///   - in space no vertices are inserted: a coarse lattice may have fewer from the start.
    std::size_t vertices = 0;
    /// The distance that the cage keeps from the figure, as a share of the diagonal of the figure's
    /// bounds. 0 stands for 0.025 in the plane and 0.02 in space.
    double margin = 0;
    std::optional<MirrorPlane> mirror{};
    CageShape shape = CageShape::figure;
    bool one_cage = true;      ///< joins the components by bridges; otherwise each gets a loop or shell
    bool holes = false;        ///< in the plane: keeps large enclosed empty regions as holes
    bool fill_tunnels = false; ///< in space: the cage gets genus 0; otherwise it has the figure's tunnels
    /// In space: makes a flat closed loop of edges about each limb, where it joins the rest, to be turned or
    /// selected by. It takes four vertices or more; the largest limbs have one while at most a quarter of all
    /// vertices are needed. With `looseness` the number of vertices is chosen without loops, and then raised
    /// by steps of 5 %, at most five, while loops make the cage too loose.
    bool rings = false;
    /// The weight of regular angles and lengths against a tight fit. A larger value makes a looser cage.
    double regular = 1;
    /// Above 0: makes the fewest vertices whose area (in space volume) exceeds the tightest by at most this
    /// share, such as 0.25. The next smaller number tried, at most 5 % smaller, is too loose. Where none is
    /// smaller, the reduction came to its end, and a cage made of fewer `vertices` may do. `vertices` is the
    /// most that are tried; 0 stands for 200 in the plane and 1,000 in space. Where these are too loose, the
    /// tightest cage tried is returned. Boxes have their vertices.
    double looseness = 0;
};

/// The outcome of make_cage. In space, `area` and `tightest_area` are volumes.
struct MakeCageReport {
    Status status = Status::ok;
    std::size_t culprit = 0;  ///< index of the segment, area, vertex or face that `status` is about
    std::size_t vertices = 0; ///< of the cage; for when it differs from the request, see the options
    double margin = 0;        ///< the requested margin, as a distance
    double clearance = 0;     ///< exact least distance between the cage and the figure
    double area = 0;          ///< of the cage
    /// The area of the figure grown by the margin (in space by 1.12 margins, so that interpolation cannot
    /// bring the cage too near), slits closed: the limit for very many vertices.
    double tightest_area = 0;
    /// With options.looseness: all numbers of vertices that were tried, increasing, down to one that is too
    /// loose, if there is any, and up to twice the answer or more.
    struct Attempt {
        std::size_t vertices;
        double excess; ///< area / tightest_area - 1
        /// How far the tightest lies below the cage where that spans a hollow, such as the gap between two
        /// fingers: a distance.
        double hollow;
    };
    std::vector<Attempt> attempts;
    double least_angle = 0;     ///< between edges of the cage, in degrees
    std::size_t components = 0; ///< connected components of the figure, grown by the margin; 0 for a box
    std::size_t bridges = 0;    ///< that join the components
    std::size_t tunnels = 0;    ///< of a cage in space: its genus
    std::size_t triangles = 0;  ///< faces of a cage in space with three corners
    std::size_t quads = 0;      ///< those with four, by pair_faces
    double worst_warp = 0;      ///< of a quad: the distance between its diagonals, over its mean edge
    /// With options.rings: the parts that the loops divide the cage into; each joint is such a loop. Numbers
    /// are as from find_parts. `of_face` is of the triangles that make_cage returns.
    CageParts parts;
    CageReport cage; ///< the report of `check` on the cage
    double seconds = 0;
};

} // namespace cageform::inline CAGEFORM_ABI
