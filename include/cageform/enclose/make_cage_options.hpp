// The figure that make_cage encloses, its options and its report.
#pragma once

#include <cageform/cage/report.hpp>
#include <cageform/core/result.hpp>
#include <cageform/core/running.hpp>
#include <cageform/core/vec.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <ranges>
#include <span>
#include <utility>

namespace cageform::inline CAGEFORM_ABI {

/// A piece of a drawing: all points within `radius` of the segment from `a` to `b`. A stroke is made of
/// these, with half its width for a radius; an outline has radius 0.
template <Scalar T>
struct DrawnSegment {
    Vec<T, 2> a, b;
    T radius = 0;
};

/// A painted area of a drawing. Segments `begin` … `end` − 1 are its closed outlines.
struct PaintedArea {
    std::size_t begin = 0;
    std::size_t end = 0;
    bool even_odd = false; ///< else non-zero, as in SVG
};

/// A drawing whose painted areas are known, so that a cage can keep their holes.
template <Scalar T>
struct Drawing {
    std::span<const DrawnSegment<T>> segments;
    std::span<const PaintedArea> areas{};
};
template <class Segments>
Drawing(const Segments&) -> Drawing<decltype(std::declval<std::ranges::range_value_t<Segments>>().radius)>;
template <class Segments, class Areas>
Drawing(const Segments&, const Areas&)
    -> Drawing<decltype(std::declval<std::ranges::range_value_t<Segments>>().radius)>;

/// A plane (in 2D: a line) across an axis, in which a cage is its own mirror image.
struct MirrorPlane {
    std::size_t axis = 0;          ///< it stands perpendicular to: 0, 1, 2 for x, y, z
    std::optional<double> place{}; ///< its coordinate on that axis; the middle of the figure unless told
};

/// What a cage follows.
enum class CageShape : std::uint8_t {
    figure, ///< limbs and hollows
    hull,   ///< about the convex hull
    box,    ///< the bounds, widened by the margin: 4 vertices, in space 8
};

/// How a cage is made; see enclose/make_cage.hpp.
struct MakeCageOptions {
    /// As many as the cage gets, in all its loops or shells; met exactly, in a mirrored cage up to the
    /// parity. 0 stands for 24 in the plane and 112 in space.
    std::size_t vertices = 0;
    /// Distance that the cage keeps from the figure, as a share of the diagonal of the figure's bounds.
    /// 0 stands for 0.025 in the plane and 0.02 in space.
    double margin = 0;
    std::optional<MirrorPlane> mirror{};
    CageShape shape = CageShape::figure;
    bool one_cage = true;      ///< parts of the figure are joined by bridges; else a loop or shell for each
    bool holes = false;        ///< in the plane: keep what the figure encloses and leaves free as holes
    bool fill_tunnels = false; ///< in space: the cage gets genus 0; else it has the figure's tunnels
    /// What regular angles and lengths are worth against a tight fit. More makes a looser cage.
    double regular = 1;
};

/// What became of it. `area`: volume in space.
struct MakeCageReport {
    Status status = Status::ok;
    std::size_t culprit = 0;  ///< the segment, vertex or face that `status` is about
    std::size_t vertices = 0; ///< of the cage; more than asked for where no fewer would do
    double margin = 0;        ///< asked for, as a distance
    double clearance = 0;     ///< exact least distance between the cage and the figure
    double area = 0;          ///< of the cage
    double tightest_area =
        0; ///< of the figure grown by the margin, slits closed: that of a cage of very many vertices
    double least_angle = 0;  ///< between edges of the cage, in degrees
    std::size_t parts = 0;   ///< of the figure, grown by the margin; of a box not counted
    std::size_t bridges = 0; ///< that join them
    std::size_t tunnels = 0; ///< of a cage in space: its genus
    CageReport cage;         ///< what `check` says of the cage
    double seconds = 0;
};

} // namespace cageform::inline CAGEFORM_ABI
