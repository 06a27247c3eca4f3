// An edge of a curved cage, with tables for its integrals.
#pragma once

#include <cageform/cage/curved/plane_curve.hpp>
#include <cageform/cage/detail/primitives.hpp>
#include <cageform/coordinates/curved_green/moments.hpp>
#include <cageform/core/detail/complex_roots.hpp>

#include <cstdint>
#include <numbers>

namespace cageform::inline CAGEFORM_ABI::detail {

/// An edge with the inside on its left, and the handles of its posed control points and legs.
struct CurvedEdge {
    /// One end. `away` holds the coefficients of e(t) − e(0) with t = 0 at this end, without leading and
    /// trailing coefficients of rounding size.
    struct End {
        ComplexNumber at;
        Polynomial away;           ///< c_0 is 0
        std::size_t vanishing = 1; ///< r, where e(t) − e(0) ≈ q t^r
        double log_tangent = 0;    ///< ln |q|
        std::uint32_t vertex = 0;
    };
    struct Node {
        ComplexNumber at, along; ///< e and e' at a node of MomentNodes
    };

    PlaneCurve curve;
    std::size_t posed_degree = 3; ///< m
    std::array<End, 2> end;       ///< the start, then the end
    ComplexNumber centre{0, 0};
    double reach = 0; ///< beyond this distance from `centre` no root lies inside the ellipse of the nodes
    std::array<Node, MomentNodes::count> nodes{};
    ComplexNumber middle{0, 0}, rate{0, 0};                   ///< of a line: e(1/2) and 1/e'
    std::array<std::uint32_t, most_posed_degree + 1> point{}; ///< handles of the control points
    std::array<std::uint32_t, most_posed_degree> leg{};       ///< handles of the legs

    CurvedEdge() = default;
    CurvedEdge(const PlaneCurve& of, std::size_t degree)
        : curve(of)
        , posed_degree(degree)
        , end{end_of(of), end_of(of.reversed())} {
        const PlaneCurve slope = of.slope();
        for (std::size_t g = 0; g < nodes.size(); ++g) {
            const double t = MomentNodes::of(0).place[g];
            nodes[g] = {to_number(of.at(t)), to_number(slope.at(t))};
        }
        set_reach();
        if (!is_line()) return;
        middle = 0.5 * (end[0].at + end[1].at);
        rate = inverse(end[0].away.c[1]);
    }

    bool is_line() const noexcept { return end[0].away.degree == 1 && end[1].away.degree == 1; }

private:
    static End end_of(const PlaneCurve& from) noexcept {
        End end;
        end.at = to_number(from.begin());
        const auto powers = from.powers();
        double largest = 0;
        for (std::size_t k = 1; k <= from.degree; ++k) largest = (std::max)(largest, length(powers[k]));
        for (std::size_t k = 1; k <= from.degree; ++k) {
            if (length(powers[k]) <= 0x1p-50 * largest) continue;
            end.away.c[k] = to_number(powers[k]);
            end.away.degree = k;
        }
        while (!(norm(end.away.c[end.vanishing]) > 0)) ++end.vanishing;
        end.log_tangent = std::log(size(end.away.c[end.vanishing]));
        return end;
    }
    /// Sets the radius of a circle around the image of the ellipse |s| + |s − 1| = 5/3.
    void set_reach() noexcept {
        for (const auto& c : curve.points()) centre += (1 / double(curve.degree + 1)) * to_number(c);
        constexpr std::size_t samples = 64;
        for (std::size_t n = 0; n < samples; ++n) {
            const double angle = 2 * std::numbers::pi * double(n) / double(samples);
            const ComplexNumber s{0.5 + 5.0 / 6 * std::cos(angle), 2.0 / 3 * std::sin(angle)};
            reach = (std::max)(reach, size(end[0].at - centre + end[0].away.at(s)));
        }
        reach *= 1.01; // margin for maxima between samples
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
