// Adds the integrals of an edge to the rows of its handles.
#pragma once

#include <cageform/coordinates/curved_green/curved_edge.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Adds weights: Im J_k for control points and ln(diagonal/|V_end − z|) + Σ_{j>k} Re J_j for legs, times
/// `share` = ±1/2π.
///
///   logarithm   ln(diagonal/|V_end − z|)
///   add         called as add(row, value, whether only this edge writes the row)
template <class R, class Add>
void add_edge_weights(const CurvedEdge& edge, const EdgeMoments<R>& j, const R& logarithm, const R& share,
                      const Add& add) noexcept {
    R after = logarithm;
    for (std::size_t k = edge.posed_degree + 1; k-- > 0;) {
        add(edge.point[k], share * j[k].im, k > 0 && k < edge.posed_degree);
        if (k < edge.posed_degree) add(edge.leg[k], share * after, true);
        after += j[k].re;
    }
}

/// Adds gradients. With h_k = m/2π ∫ b_k/(e − z) dt, of degree m − 1, the gradient of a leg is
/// (Re h_k, −Im h_k), and that of a control point consists of Im and Re of h_{k−1} − h_k.
///
///   sign      signs of the derivatives by x and by y
///   along_y   the first row of the derivatives by y
template <class R, class Add>
void add_edge_slopes(const CurvedEdge& edge, const EdgeMoments<R>& g, const std::array<double, 2>& sign,
                     std::size_t along_y, const Add& add) noexcept {
    const std::size_t m = edge.posed_degree;
    const double share = double(m) / (2 * std::numbers::pi);
    const R share_x(share * sign[0]), share_y(share * sign[1]);
    for (std::size_t k = 0; k < m; ++k) {
        const Complex<R> by_x = share_x * g[k], by_y = share_y * g[k];
        add(edge.leg[k], by_x.re);
        add(along_y + edge.leg[k], -by_y.im);
        add(edge.point[k], -by_x.im);
        add(along_y + edge.point[k], -by_y.re);
        add(edge.point[k + 1], by_x.im);
        add(along_y + edge.point[k + 1], by_y.re);
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail
