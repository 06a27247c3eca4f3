// The integrals of an edge at far points, by Gauss quadrature.
#pragma once

#include <cageform/coordinates/curved_green/curved_edge.hpp>
#include <cageform/core/detail/simd.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The integrals of an edge at one point or at a register of points.
template <class R>
struct EdgeSums {
    EdgeMoments<R> value; ///< ∫ b_k e'/(e − z) dt; for gradients ∫ b_k/(e − z) dt, of one degree less
    R turning;            ///< the angle by which e − z turns along the edge
};

/// Computes the integrals of an edge for points that are far from the whole edge.
template <bool gradients, class R>
class FarSums {
public:
    static void set(const CurvedEdge& edge, const Complex<R>& z, EdgeSums<R>& sums) noexcept {
        switch (edge.posed_degree - (gradients ? 1 : 0)) {
        case 0: return set_degree<0>(edge, z, sums);
        case 1: return set_degree<1>(edge, z, sums);
        case 2: return set_degree<2>(edge, z, sums);
        case 3: return set_degree<3>(edge, z, sums);
        case 4: return set_degree<4>(edge, z, sums);
        default: return set_degree<5>(edge, z, sums);
        }
    }

private:
    using Four = std::array<R, 4>;

    static Complex<R> spread(const ComplexNumber& a) noexcept { return {R(a.re), R(a.im)}; }
    /// Returns four reciprocals, by one division.
    static Four reciprocals(const Four& x) noexcept {
        const R low = x[0] * x[1], high = x[2] * x[3], share = R(1.0) / (low * high);
        const R over_low = share * high, over_high = share * low;
        return {over_low * x[1], over_low * x[0], over_high * x[3], over_high * x[2]};
    }
    static void add(double weight, const Complex<R>& term, Complex<R>& sum) noexcept {
        const R share(weight);
        sum = {sum.re + share * term.re, sum.im + share * term.im};
    }

    template <std::size_t degree>
    static void set_degree(const CurvedEdge& edge, const Complex<R>& z, EdgeSums<R>& sums) noexcept {
        return edge.is_line() ? set_line<degree>(edge, z, sums) : set_curve<degree>(edge, z, sums);
    }
    template <std::size_t degree>
    static void set_curve(const CurvedEdge& edge, const Complex<R>& z, EdgeSums<R>& sums) noexcept {
        const MomentNodes& table = MomentNodes::of(degree);
        std::array<Complex<R>, degree + 1> value;
        value.fill({R(0.0), R(0.0)});
        R turning(0.0);
        for (std::size_t first = 0; first < MomentNodes::count; first += 4) {
            std::array<Complex<R>, 4> away;
            Four square;
            for (std::size_t n = 0; n < 4; ++n) {
                away[n] = spread(edge.nodes[first + n].at) - z;
                square[n] = norm(away[n]);
            }
            const Four over = reciprocals(square);
            for (std::size_t n = 0; n < 4; ++n) {
                const Complex<R> inverted{over[n] * away[n].re, -(over[n] * away[n].im)};
                const Complex<R> turned = inverted * spread(edge.nodes[first + n].along);
                const Complex<R>& term = gradients ? inverted : turned;
                if constexpr (gradients) turning += R(table.weight[first + n]) * turned.im;
                CAGEFORM_DETAIL_UNROLL
                for (std::size_t k = 0; k <= degree; ++k) add(table.value[first + n][k], term, value[k]);
            }
        }
        for (std::size_t k = 0; k <= degree; ++k) {
            if constexpr (!gradients) turning += value[k].im;
            sums.value[k] = value[k];
        }
        sums.turning = turning;
    }
    /// On a line, with u = s − 1/2, the terms of the nodes 1/2 ± h are −(u ± h)/(u² − h²) and share one
    /// reciprocal.
    template <std::size_t degree>
    static void set_line(const CurvedEdge& edge, const Complex<R>& z, EdgeSums<R>& sums) noexcept {
        const MomentPairs& table = MomentPairs::of(degree);
        constexpr std::size_t half = degree / 2 + 1;
        std::array<Complex<R>, half> even, odd;
        even.fill({R(0.0), R(0.0)});
        odd.fill({R(0.0), R(0.0)});
        const Complex<R> u = spread(edge.rate) * (z - spread(edge.middle)), uu = u * u;
        for (std::size_t first = 0; first < MomentPairs::count; first += 4) {
            std::array<Complex<R>, 4> away;
            Four square;
            for (std::size_t n = 0; n < 4; ++n) {
                away[n] = {uu.re - R(table.square[first + n]), uu.im};
                square[n] = norm(away[n]);
            }
            const Four over = reciprocals(square);
            for (std::size_t n = 0; n < 4; ++n) {
                const Complex<R> term{over[n] * away[n].re, -(over[n] * away[n].im)};
                CAGEFORM_DETAIL_UNROLL
                for (std::size_t k = 0; k < half; ++k) {
                    add(table.even[first + n][k], term, even[k]);
                    if (2 * k != degree) add(table.odd[first + n][k], term, odd[k]);
                }
            }
        }
        R turning(0.0);
        for (std::size_t k = 0; k < half; ++k) {
            const Complex<R> both = u * even[k];
            sums.value[degree - k] = odd[k] - both;
            if (2 * k != degree) sums.value[k] = -odd[k] - both;
        }
        for (std::size_t k = 0; k <= degree; ++k) {
            turning += sums.value[k].im;
            if constexpr (gradients) sums.value[k] = spread(edge.rate) * sums.value[k];
        }
        sums.turning = turning;
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
