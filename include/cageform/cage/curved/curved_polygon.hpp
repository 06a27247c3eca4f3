// A cage in the plane whose edges are Bézier curves: its data and its check.
#pragma once

#include <cageform/cage/curved/check_curves.hpp>
#include <cageform/cage/polygon.hpp>

#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A cage of closed loops of Bézier curves of degree 1, 2 and 3. Outer loops and holes come in any order
/// and direction; the even-odd rule decides what is inside. Edges are numbered through all loops.
///
/// Construction never fails; `check` reports whether the curves can serve as a cage, and coordinates call
/// it.
template <Scalar T>
class CurvedPolygon {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 2;
    /// The control points of an edge, its ends included: 2 of a line, 3 of a quadratic, 4 of a cubic.
    using Edge = std::vector<Vec<T, 2>>;
    /// Edges one after the other. Each begins where the one before it ends, within the tolerance of
    /// `check`; its own start counts.
    using Loop = std::vector<Edge>;

    CurvedPolygon() = default;
    explicit CurvedPolygon(std::vector<Loop> loops) noexcept
        : loops_(std::move(loops)) {}
    /// Takes the edges of a polygon as lines.
    explicit CurvedPolygon(const Polygon<T>& polygon)
        : status_(detail::guard_memory([&] {
            if (polygon.status() != Status::ok || !polygon.loops_match()) return polygon_status(polygon);
            for (const auto& loop : polygon.loops()) {
                Loop& edges = loops_.emplace_back();
                loop.for_each_edge([&](std::size_t i, std::size_t j) {
                    edges.push_back({polygon[i], polygon[j]});
                });
            }
            return Status::ok;
        })) {
        if (status_ != Status::ok) loops_.clear();
    }

    /// Returns why a polygon was not taken; the cage is then empty.
    Status status() const noexcept { return status_; }
    std::span<const Loop> loops() const noexcept { return loops_; }

private:
    static Status polygon_status(const Polygon<T>& polygon) noexcept {
        return polygon.status() != Status::ok ? polygon.status() : Status::loops_do_not_match;
    }

    std::vector<Loop> loops_;
    Status status_ = Status::ok; // declared last: its initialiser fills the other members
};

/// Whether curves can serve as a cage: every loop is closed and has an area, no edge is a point, and no
/// edges cross or touch each other or themselves, except neighbours at their common end. Ends meet if their
/// distance is at most the coincidence_tolerance of all control points; curves touch within that distance.
/// Next to a common end, within 2^-20 of an edge's extent (in float 2^-8), crossings are not looked for.
/// Curves that run so close to each other that 2^17 pieces do not separate them count as touching.
///
/// A cusp inside an edge is a warning: weights next to it lose digits, and outside they may be huge. Usually
/// O(#E log #E), O(#E²) at worst.
template <Scalar T>
CageReport check(const CurvedPolygon<T>& polygon) {
    return detail::report_on(polygon.status(), [&](CageReport& report) {
        const detail::CurveLoops loops(polygon, report);
        if (report.status == Status::ok) loops.check(report);
    });
}

} // namespace cageform::inline CAGEFORM_ABI
