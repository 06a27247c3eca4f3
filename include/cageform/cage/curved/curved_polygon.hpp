// A 2D cage with Bézier curves as edges: its data and its check.
#pragma once

#include <cageform/cage/curved/check_curves.hpp>
#include <cageform/cage/polygon.hpp>

#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A cage of closed loops of Bézier curves of degree 1 to 3. Outer loops and holes may have any order and
/// orientation; the even-odd rule decides what is inside. Edges are numbered consecutively through all loops.
/// Construction never fails; `check` reports whether the curves are a valid cage, and coordinates call it.
template <Scalar T>
class CurvedPolygon {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 2;
    /// The control points of an edge, ends included: 2 for a line, 3 for a quadratic, 4 for a cubic.
    using Edge = std::vector<Vec<T, 2>>;
    /// Consecutive edges. Each edge begins where the previous edge ends, within the tolerance of `check`. The
    /// start of an edge replaces the end of the previous edge.
    using Loop = std::vector<Edge>;

    CurvedPolygon() = default;
    explicit CurvedPolygon(std::vector<Loop> loops) noexcept
        : loops_(std::move(loops)) {}
    /// Converts a polygon: its edges become curves of degree 1.
    explicit CurvedPolygon(const Polygon<T>& polygon)
        : status_(detail::guard_memory([&] {
            if (polygon.status() != Status::ok || !polygon.loops_match()) return polygon_status(polygon);
            for (const auto& loop : polygon.loops()) {
                Loop& edges = loops_.emplace_back();
                loop.for_each_edge(
                    [&](std::size_t i, std::size_t j) { edges.push_back({polygon[i], polygon[j]}); });
            }
            return Status::ok;
        })) {
        if (status_ != Status::ok) loops_.clear();
    }

    /// Returns why a polygon was refused; the cage is then empty.
    Status status() const noexcept { return status_; }
    std::span<const Loop> loops() const noexcept { return loops_; }

private:
    static Status polygon_status(const Polygon<T>& polygon) noexcept {
        return polygon.status() != Status::ok ? polygon.status() : Status::loops_do_not_match;
    }

    std::vector<Loop> loops_;
    Status status_ = Status::ok; // declared last: its initialiser fills the other members
};

/// Checks whether curves are a valid cage. Every loop must be closed and have an area, and no edge may be a
/// point. No edge may cross or touch another edge or itself, except for neighbours at their common end. Ends
/// meet if their distance is at most the coincidence_tolerance of all control points; curves touch within
/// that distance. Crossings closer to a common end than 2^-20 of an edge's extent (2^-8 for float) are not
/// detected. If the test cannot separate two curves with 2^17 pieces, they count as touching.
///
/// A cusp inside an edge is a warning. Weights at points near the cusp lose digits; weights at points outside
/// the cage may be very large. Usually O(#E log #E), O(#E²) at worst.
template <Scalar T>
CageReport check(const CurvedPolygon<T>& polygon) {
    return detail::report_on(polygon.status(), [&](CageReport& report) {
        const detail::CurveLoops loops(polygon, report);
        if (report.status == Status::ok) loops.check(report);
    });
}

} // namespace cageform::inline CAGEFORM_ABI
