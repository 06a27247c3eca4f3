// A Bézier curve of degree 1 to 3 in the plane.
#pragma once

#include <cageform/core/types/bounds.hpp>

#include <array>
#include <span>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

struct PlaneCurve {
    static constexpr std::size_t most_degree = 3;

    std::size_t degree = 1;
    std::array<Vec<double, 2>, most_degree + 1> control{};

    const Vec<double, 2>& begin() const noexcept { return control[0]; }
    const Vec<double, 2>& end() const noexcept { return control[degree]; }
    std::span<const Vec<double, 2>> points() const noexcept { return {control.data(), degree + 1}; }

    Vec<double, 2> at(double t) const noexcept {
        auto c = control;
        for (std::size_t n = degree; n > 0; --n) {
            for (std::size_t i = 0; i < n; ++i) c[i] = c[i] + t * (c[i + 1] - c[i]);
        }
        return c[0];
    }
    /// Returns e', a curve of one degree less; for a line it is a point.
    PlaneCurve slope() const noexcept {
        PlaneCurve d{degree - 1, {}};
        for (std::size_t i = 0; i < degree; ++i)
            d.control[i] = double(degree) * (control[i + 1] - control[i]);
        return d;
    }
    PlaneCurve reversed() const noexcept {
        PlaneCurve r{degree, {}};
        for (std::size_t i = 0; i <= degree; ++i) r.control[i] = control[degree - i];
        return r;
    }
    /// Returns the curve on [0, 1/2] and on [1/2, 1] (de Casteljau).
    std::pair<PlaneCurve, PlaneCurve> halves() const noexcept {
        PlaneCurve low{degree, {}}, high{degree, control};
        for (std::size_t n = 0; n <= degree; ++n) {
            low.control[n] = high.control[0];
            for (std::size_t i = 0; i < degree - n; ++i)
                high.control[i] = 0.5 * high.control[i] + 0.5 * high.control[i + 1];
        }
        return {low, high};
    }
    /// Returns the coefficients c of e(t) = c_0 + c_1 t + …; all but c_0 are differences of control points.
    std::array<Vec<double, 2>, most_degree + 1> powers() const noexcept {
        const auto& e = control;
        std::array<Vec<double, 2>, most_degree + 1> c{};
        c[0] = e[0];
        const auto first = e[1] - e[0];
        c[1] = double(degree) * first;
        if (degree < 2) return c;
        const auto second = (e[2] - e[1]) - first;
        c[2] = (degree == 2 ? 1.0 : 3.0) * second;
        if (degree == 3) c[3] = ((e[3] - e[2]) - (e[2] - e[1])) - second;
        return c;
    }
    /// Returns the direction of the curve at its start: the offset of the first control point that differs
    /// from the start, or zero.
    Vec<double, 2> leaving() const noexcept {
        for (std::size_t i = 1; i <= degree; ++i) {
            if (control[i] != control[0]) return control[i] - control[0];
        }
        return {};
    }
    Bounds<double, 2> bounds() const noexcept { return bounds_of(points()); }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
