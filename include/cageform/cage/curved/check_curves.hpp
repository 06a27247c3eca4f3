// The curves of a cage in one list, and the steps of their check.
#pragma once

#include <cageform/cage/curved/curves_touch.hpp>
#include <cageform/cage/types/report.hpp>
#include <cageform/core/detail/gauss.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T>
class CurvedPolygon; // in cage/curved/curved_polygon.hpp

namespace detail {

/// Whether a ray from q to the right crosses a curve an odd number of times. The distance of q from the
/// curve must exceed the tolerance.
inline bool crosses_ray(const Vec<double, 2>& q, const PlaneCurve& curve, double tolerance) noexcept {
    const auto box = curve.bounds();
    if (box.lower[1] > q[1] || box.upper[1] <= q[1] || box.upper[0] < q[0]) return false;
    if (box.lower[0] > q[0]) return (curve.begin()[1] > q[1]) != (curve.end()[1] > q[1]);
    if (curve.degree == 1 || box.diagonal() <= tolerance) return crosses_ray(q, curve.begin(), curve.end());
    const auto [low, high] = curve.halves();
    return crosses_ray(q, low, tolerance) != crosses_ray(q, high, tolerance);
}

/// The edges of a curved cage; each ends exactly where the next begins.
struct CurveLoops {
    struct Loop {
        std::size_t begin, end; ///< a range of `edges`

        std::size_t next(std::size_t edge) const noexcept { return edge + 1 < end ? edge + 1 : begin; }
    };

    Buffer<PlaneCurve> edges; ///< in units of 1/scale
    Buffer<Loop> loops;
    Bounds<double, 2> bounds{}; ///< of all control points, in units of 1/scale, like the tolerance
    double scale = 1, tolerance = 0;
    bool is_float = false;

    CurveLoops() = default;
    /// Reports edges of unsupported degree and loops that are not closed.
    template <Scalar T>
    CurveLoops(const CurvedPolygon<T>& polygon, CageReport& report)
        : is_float(std::is_same_v<T, float>) {
        using Fault = CageFaultKind;
        if (polygon.loops().empty()) report.add(Fault::too_few_vertices, 0, 0);
        std::vector<Vec<T, 2>> points;
        std::size_t number = 0;
        for (std::size_t k = 0; k < polygon.loops().size(); ++k) {
            if (polygon.loops()[k].empty()) report.add(Fault::too_few_vertices, k, 0);
            for (const auto& edge : polygon.loops()[k]) {
                if (edge.size() < 2 || edge.size() > PlaneCurve::most_degree + 1)
                    report.add(Fault::curve_degree, number, edge.empty() ? 0 : edge.size() - 1);
                for (std::size_t i = 0; i < edge.size(); ++i) {
                    if (!is_finite(edge[i])) report.add(Fault::vertex_not_finite, number, i);
                }
                points.insert(points.end(), edge.begin(), edge.end());
                ++number;
            }
        }
        if (report.status != Status::ok) return;
        const auto box = bounds_of(std::span<const Vec<T, 2>>(points));
        const T unit = is_finite(box.diagonal()) ? unit_scale(box) : T(0);
        constexpr T least = (std::numeric_limits<T>::min)();
        if (!(unit > least)) add_farthest(polygon, report);
        if (!is_finite(unit) || !(box.diagonal() > least / epsilon<T>)) report.add(Fault::no_area, 0);
        if (report.status != Status::ok) return;
        scale = double(unit);
        tolerance = scale * double(coincidence_tolerance(box));
        bounds = {scale * vec_cast<double>(box.lower), scale * vec_cast<double>(box.upper)};
        for (const auto& loop : polygon.loops()) {
            loops.push_back({edges.size(), edges.size() + loop.size()});
            for (const auto& edge : loop) {
                PlaneCurve& curve = edges.push_back({edge.size() - 1, {}});
                for (std::size_t i = 0; i < edge.size(); ++i)
                    curve.control[i] = scale * vec_cast<double>(edge[i]);
            }
        }
        for (std::size_t k = 0; k < loops.size(); ++k) {
            for (std::size_t e = loops[k].begin; e < loops[k].end; ++e) {
                auto& end = edges[e].control[edges[e].degree];
                const auto& begin = edges[loops[k].next(e)].begin();
                if (!(length(end - begin) <= tolerance)) report.add(Fault::loop_not_closed, k, e);
                end = begin;
            }
        }
    }

    /// Whether the inside of the cage is to the left of the edges of loop k. Loops must not touch.
    bool inside_is_left(std::size_t k) const noexcept {
        const auto q = edges[loops[k].begin].begin();
        bool is_hole = false;
        for (std::size_t other = 0; other < loops.size(); ++other) {
            if (other == k) continue;
            for (std::size_t e = loops[other].begin; e < loops[other].end; ++e)
                is_hole = is_hole != crosses_ray(q, edges[e], tolerance);
        }
        return (signed_area(k) > 0) != is_hole;
    }

    void check(CageReport& report) const {
        for (std::size_t e = 0; e < edges.size(); ++e) {
            if (edges[e].bounds().diagonal() <= tolerance)
                report.add(CageFaultKind::duplicate_vertices, e, e);
        }
        for (std::size_t k = 0; k < loops.size(); ++k) {
            if (is_flat(k)) report.add(CageFaultKind::no_area, k);
        }
        if (report.status != Status::ok) return;
        check_crossings(report);
        if (report.status != Status::ok) return;
        for (std::size_t e = 0; e < edges.size(); ++e) {
            const double t = cusp_inside(edges[e], tolerance);
            if (t > 0) report.add(CageFaultKind::edge_has_cusp, e, std::size_t(std::lround(1000 * t)));
        }
        for (std::size_t k = 0; k < loops.size(); ++k) {
            if (!inside_is_left(k)) report.add(CageFaultKind::loop_orientation_reversed, k);
        }
    }

private:
    template <Scalar T>
    static void add_farthest(const CurvedPolygon<T>& polygon, CageReport& report) {
        std::size_t number = 0;
        CageFault farthest{CageFaultKind::vertex_not_finite, 0, 0};
        T most = 0;
        for (const auto& loop : polygon.loops()) {
            for (const auto& edge : loop) {
                for (std::size_t i = 0; i < edge.size(); ++i) {
                    const T size = (std::max)(std::fabs(edge[i][0]), std::fabs(edge[i][1]));
                    if (!(size > most)) continue;
                    most = size;
                    farthest = {CageFaultKind::vertex_not_finite, number, i};
                }
                ++number;
            }
        }
        report.add(farthest.kind, farthest.a, farthest.b);
    }
    /// Returns ½ ∫ e × e' over a loop, positive if it is counter-clockwise.
    double signed_area(std::size_t k) const noexcept {
        double twice = 0;
        const auto origin = edges[loops[k].begin].begin();
        for (std::size_t e = loops[k].begin; e < loops[k].end; ++e) {
            const PlaneCurve slope = edges[e].slope();
            twice += Gauss<3>::rule()(0, 1, [&](double t) { // the integrand has degree 5
                return cross(edges[e].at(t) - origin, slope.at(t));
            });
        }
        return twice / 2;
    }
    /// Whether all control points of a loop lie within the tolerance of a line.
    bool is_flat(std::size_t k) const {
        std::vector<Vec<double, 2>> points;
        for (std::size_t e = loops[k].begin; e < loops[k].end; ++e)
            points.insert(points.end(), edges[e].points().begin(), edges[e].points().end());
        return are_collinear<double>(points, tolerance);
    }
    void check_crossings(CageReport& report) const {
        Buffer<std::uint32_t> order(edges.size()), loop_of(edges.size());
        std::iota(order.begin(), order.end(), 0U);
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            return edges[a].bounds().lower[0] < edges[b].bounds().lower[0];
        });
        for (std::size_t k = 0; k < loops.size(); ++k)
            std::fill(loop_of.begin() + loops[k].begin, loop_of.begin() + loops[k].end, std::uint32_t(k));
        CurvesTouch touch(tolerance);
        for (std::size_t i = 0; i < order.size(); ++i) {
            const auto a = order[i];
            const auto box = edges[a].bounds().widened(tolerance);
            const bool joined = loops[loop_of[a]].next(a) == a;
            if (touches_itself(edges[a], joined, tolerance)) report.add(CageFaultKind::edges_cross, a, a);
            for (std::size_t j = i + 1; j < order.size(); ++j) {
                const auto b = order[j];
                const auto other = edges[b].bounds();
                if (other.lower[0] > box.upper[0]) break;
                if (box.overlaps(other) && edges_touch(a, b, loops[loop_of[a]], touch))
                    report.add(CageFaultKind::edges_cross, (std::min)(a, b), (std::max)(a, b));
            }
        }
    }
    bool edges_touch(std::size_t a, std::size_t b, const Loop& loop, CurvesTouch& touch) const {
        std::array<Vec<double, 2>, 2> common{};
        std::size_t count = 0;
        if (b >= loop.begin && b < loop.end) {
            if (loop.next(a) == b) common[count++] = edges[b].begin();
            if (loop.next(b) == a) common[count++] = edges[a].begin();
        }
        const double extent = (std::min)(edges[a].bounds().diagonal(), edges[b].bounds().diagonal());
        const double radius = (std::max)((is_float ? 0x1p-8 : 0x1p-20) * extent, 16 * tolerance);
        return touch(edges[a], edges[b], {common.data(), count}, radius);
    }
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
