// Figures, options and reports of make_cage, 2D and 3D.
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
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A capsule: all points within `radius` of the segment from `a` to `b`. Strokes have half their width as
/// radius, outlines 0.
template <Scalar T>
struct DrawnSegment {
    Vec<T, 2> a, b;
    T radius = 0;
};

/// Segments `begin` … `end` − 1 are the closed outlines of a painted area.
struct PaintedArea {
    std::size_t begin = 0;
    std::size_t end = 0;
    bool even_odd = false; ///< fill rule: even-odd, or non-zero as SVG's default
};

/// A drawing with known painted areas, so that a cage can keep their holes.
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

/// Makes the cage symmetric about a plane (2D: a line) perpendicular to an axis.
struct MirrorPlane {
    std::size_t axis = 0;             ///< 0, 1, 2 for x, y, z
    std::optional<double> position{}; ///< coordinate of the plane; default: the middle of the figure
};

/// Shape to enclose.
enum class CageShape : std::uint8_t {
    figure, ///< the figure, with limbs and concavities
    hull,   ///< the convex hull of the figure
    box,    ///< bounds widened by the margin: 4 vertices, 8 in 3D
};

struct MakeCageOptions {
    /// Number of vertices of the whole cage, over all loops or shells. 0: 24 in 2D, 112 in 3D. The cage has
    /// exactly this number, except:
    ///   - a box has 4 vertices, 8 in 3D;
    ///   - a mirrored cage may have one vertex more or less;
    ///   - each loop or shell has at least 4 vertices, so several may need more;
    ///   - collapses stop if every further collapse would touch the figure or the cage;
    ///   - vertices are never inserted in 3D, and a coarse lattice may start with fewer.
    std::size_t vertices = 0;
    /// Distance between cage and figure, relative to the diagonal of the figure's bounds. 0: 0.025 in 2D,
    /// 0.02 in 3D.
    double margin = 0;
    std::optional<MirrorPlane> mirror{};
    CageShape shape = CageShape::figure;
    bool one_cage = true;      ///< connects components by bridges; otherwise each gets its own loop or shell
    bool holes = false;        ///< 2D: keeps large enclosed empty regions as holes
    bool fill_tunnels = false; ///< 3D: makes a cage of genus 0; otherwise the figure's tunnels are kept
    /// 3D: makes a planar closed edge loop around each limb, for selecting and turning the limb. A loop takes
    /// at least four vertices. Loops are made for the largest limbs first, as long as all loops together take
    /// at most a quarter of the vertices. With `looseness`, the number of vertices is first chosen without
    /// loops. It is then raised up to five times, by 5 % each, while the cage with loops is too loose.
    bool rings = false;
    /// Trade-off, ≥ 0: higher values give more regular angles and lengths, and looser cages.
    double regular = 1;
    /// If > 0: uses the fewest vertices whose area (3D: volume) exceeds the tightest by at most this ratio,
    /// e.g. 0.25. `vertices` is then the upper bound; 0: 200 in 2D, 1,000 in 3D. The next smaller number
    /// tried is at most 5 % smaller and too loose. If no smaller number was tried, the collapses stopped at
    /// this number; a smaller value of `vertices` may still work. If even the upper bound is too loose, the
    /// tightest cage tried is returned. Boxes ignore this option.
    double looseness = 0;
};

/// Result of make_cage, in units of the figure. In 3D, `area` and `tightest_area` are volumes.
struct MakeCageReport {
    Status status = Status::ok;
    std::size_t culprit = 0;  ///< index of the segment, area, vertex or face that `status` refers to
    std::size_t vertices = 0; ///< may differ from the request, see MakeCageOptions::vertices
    double margin = 0;        ///< requested margin as a distance
    double clearance = 0;     ///< exact minimum distance between cage and figure
    double area = 0;          ///< of the cage
    /// Area of the figure grown by the margin (3D: 1.12 margins) with narrow gaps closed. This is the limit
    /// of `area` for many vertices.
    double tightest_area = 0;
    /// With options.looseness: all numbers of vertices tried, ascending. The list includes a number that is
    /// too loose, if there is one, and twice the chosen number or more.
    struct Attempt {
        std::size_t vertices;
        double excess; ///< area / tightest_area - 1
        /// Largest distance from the tightest contour to the cage; large where the cage spans a concavity,
        /// such as the gap between two fingers.
        double hollow;
    };
    std::vector<Attempt> attempts;
    double least_angle = 0;     ///< smallest angle between adjacent edges, in degrees
    std::size_t components = 0; ///< connected components of the grown figure; 0 for a box
    std::size_t bridges = 0;    ///< added to connect the components
    std::size_t tunnels = 0;    ///< genus of a 3D cage
    std::size_t triangles = 0;  ///< triangular faces of a 3D cage
    std::size_t quads = 0;      ///< quads, from pair_faces
    double worst_warp = 0;      ///< largest of the quads: distance between diagonals / mean edge length
    /// With options.rings: the parts between the loops; each joint is such a loop. Numbered as by find_parts.
    /// `of_face` refers to the triangles that make_cage returns.
    CageParts parts;
    CageReport cage; ///< result of `check`
    double seconds = 0;
};

} // namespace cageform::inline CAGEFORM_ABI
