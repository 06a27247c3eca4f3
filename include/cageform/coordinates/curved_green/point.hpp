// Corrections of the integrals at single points: the jump on the boundary, the continuation outside, the
// mirror image in a disk.
#pragma once

#include <cageform/coordinates/curved_green/cage_tables.hpp>
#include <cageform/coordinates/curved_green/curved_edge.hpp>
#include <cageform/coordinates/curved_green/near_sums.hpp>
#include <cageform/coordinates/curved_green/nearest_place.hpp>

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

/// The rows of one point. `along_y` is the offset of the rows of derivatives by y.
struct CurvedRow {
    Lanes<double>* rows;
    std::size_t lane, along_y = 0;

    void add(std::size_t row, double x) const noexcept { rows[row][lane] += x; }
};

/// Adds to the rows of single points, in units of 1/scale.
template <Scalar T>
class CurvedPoint {
public:
    explicit CurvedPoint(const CurvedTables<T>& tables) noexcept
        : tables_(tables) {}

    /// Subtracts the integrals at z* = c₀ + R²/conj(z − c₀), the mirror image of a point of the disk. The
    /// logarithms are ln(|V − z*| |z − c₀|/R), from Green's function of the disk. z* lies outside the cage.
    template <bool gradients>
    void subtract_mirrored(const ComplexNumber& z, const CurvedRow& to) const noexcept {
        const double square = tables_.disk_radius * tables_.disk_radius;
        const ComplexNumber u = (1 / square) * conjugate(z - tables_.disk_centre); // 1/(z* − c₀)
        if (16 * size(u) * tables_.disk_radius < 1) return subtract_far_mirrored<gradients>(u, to);
        const ComplexNumber away = inverse(u), image = tables_.disk_centre + away;
        // dz*/d conj(z), including the derivative of ln |z − c₀|.
        const ComplexNumber rate = (-1 / square) * (away * away);
        EdgeTouch touch;
        double winding = 0;
        const std::size_t vertex = gradients ? tables_.vertices.size() : vertex_at(image);
        for (std::size_t e = 0; e < tables_.edges.size(); ++e) {
            const CurvedEdge& edge = tables_.edges[e];
            EdgeSums<double> of{};
            const bool is_far = norm(image - edge.centre) >= edge.reach * edge.reach;
            if (is_far || !set_near_sums<gradients>(e, image, vertex, touch, of))
                FarSums<gradients, double>::set(edge, image, of);
            winding += of.turning / (2 * std::numbers::pi);
            if constexpr (gradients) {
                auto slopes = of.value;
                for (std::size_t k = 0; k < edge.posed_degree; ++k)
                    slopes[k] = rate * (slopes[k] + (1 / double(edge.posed_degree)) * u);
                add_slopes(edge, slopes, {-1, 1}, to);
            } else {
                const double distance = log_distance(edge, image, vertex) + log_share(size(u));
                add_weights(edge, of.value, distance, -1, to);
            }
        }
        if constexpr (gradients) return;
        if (vertex < tables_.vertices.size()) {
            to.add(tables_.vertices[vertex].handle, winding);
        } else if (winding > 0.5) { // the point lies on the circle, within rounding, and on the cage
            add_jump<false>(tables_.edges[touch.edge], touch.s, to);
        }
    }
    std::size_t vertex_at(const ComplexNumber& z) const noexcept {
        std::size_t v = 0;
        const double reach = tables_.tolerance * tables_.tolerance;
        while (v < tables_.vertices.size() && !(norm(tables_.vertices[v].at - z) <= reach)) ++v;
        return v;
    }
    /// Adds the moments Σ c of a continuation. c holds values for all control points of an edge.
    template <bool gradients>
    void add_continuation(const CurvedEdge& edge, const CurveContinuation& of,
                          const CurvedRow& to) const noexcept {
        if constexpr (gradients) {
            add_values(edge, of.along_x, to, 0);
            add_values(edge, of.along_y, to, to.along_y);
        } else {
            add_values(edge, of.value, to, 0);
        }
    }
    /// Adds the jump of the integrals across an edge: the values b_k(s), or their derivatives by z.
    template <bool gradients>
    void add_jump(const CurvedEdge& edge, const ComplexNumber& s, const CurvedRow& to) const noexcept {
        const std::size_t m = edge.posed_degree, degree = gradients ? m - 1 : m;
        EdgeMoments<double> b{};
        b[0] = {1, 0};
        for (std::size_t d = 1; d <= degree; ++d) {
            b[d] = s * b[d - 1];
            for (std::size_t k = d - 1; k > 0; --k) b[k] = s * b[k - 1] + (ComplexNumber{1, 0} - s) * b[k];
            b[0] = (ComplexNumber{1, 0} - s) * b[0];
        }
        if constexpr (gradients) {
            const ComplexNumber share = ComplexNumber{0, 2 * std::numbers::pi} / edge.end[0].away.slope(s);
            for (auto& x : b) x = share * x;
            add_slopes(edge, b, {1, 1}, to);
        } else {
            add_values(edge, b, to, 0);
        }
    }

    /// Sets the integrals from the roots of e(s) = z. Returns false if all roots are far.
    template <bool gradients>
    bool set_near_sums(std::size_t e, const ComplexNumber& z, std::size_t vertex, EdgeTouch& touch,
                       EdgeSums<double>& sums) const noexcept {
        const CurvedEdge& edge = tables_.edges[e];
        const NearSums near_edge(edge, z, {edge.end[0].vertex == vertex, edge.end[1].vertex == vertex});
        if (near_edge.all_far()) return false;
        near_edge.find_touch(e, touch);
        sums = gradients ? near_edge.slope_sums() : near_edge.sums();
        return true;
    }

private:
    /// Adds real parts to control points and partial sums of imaginary parts to legs.
    static void add_values(const CurvedEdge& edge, const EdgeMoments<double>& c, const CurvedRow& to,
                           std::size_t first) noexcept {
        double after = 0;
        for (std::size_t k = edge.posed_degree + 1; k-- > 0;) {
            to.add(first + edge.point[k], c[k].re);
            if (k < edge.posed_degree) to.add(first + edge.leg[k], -after);
            after += c[k].im;
        }
    }
    /// Returns ln |V_end − z|, or ln |q| of the end if z is the vertex.
    static double log_distance(const CurvedEdge& edge, const ComplexNumber& z, std::size_t vertex) noexcept {
        const auto& end = edge.end[1];
        return end.vertex == vertex ? end.log_tangent : 0.5 * std::log(norm(end.at - z));
    }
    /// Adds `sign` times the weights.
    void add_weights(const CurvedEdge& edge, const EdgeMoments<double>& j, double distance, double sign,
                     const CurvedRow& to) const noexcept {
        add_edge_weights(edge, j, tables_.log_diagonal - distance, sign / (2 * std::numbers::pi),
                         [&](std::size_t row, double x, bool) { to.add(row, x); });
    }
    static void add_slopes(const CurvedEdge& edge, const EdgeMoments<double>& g,
                           const std::array<double, 2>& sign, const CurvedRow& to) noexcept {
        add_edge_slopes(edge, g, sign, to.along_y, [&](std::size_t row, double x) { to.add(row, x); });
    }
    /// Returns ln(|u| R).
    double log_share(double u) const noexcept { return std::log(u * tables_.disk_radius); }
    /// Subtracts the integrals at c₀ + 1/u, where all edges are far; u may be 0. Factors 1/u cancel:
    /// 1/(e − z*) = u/((e − c₀) u − 1).
    template <bool gradients>
    void subtract_far_mirrored(const ComplexNumber& u, const CurvedRow& to) const noexcept {
        const double square = tables_.disk_radius * tables_.disk_radius;
        const ComplexNumber one{1, 0};
        for (const CurvedEdge& edge : tables_.edges) {
            EdgeMoments<double> value{};
            const std::size_t degree = edge.posed_degree - (gradients ? 1 : 0);
            const MomentNodes& table = MomentNodes::of(degree);
            for (std::size_t g = 0; g < MomentNodes::count; ++g) {
                const ComplexNumber place = edge.nodes[g].at - tables_.disk_centre,
                                    share = inverse(place * u - one);
                const ComplexNumber term =
                    gradients ? (-1 / square) * (share * place) : share * (u * edge.nodes[g].along);
                for (std::size_t k = 0; k <= degree; ++k) value[k] += table.value[g][k] * term;
            }
            if constexpr (gradients) {
                add_slopes(edge, value, {-1, 1}, to);
            } else {
                const ComplexNumber end = (edge.end[1].at - tables_.disk_centre) * u - one;
                add_weights(edge, value, 0.5 * std::log(norm(end)) + std::log(tables_.disk_radius), -1, to);
            }
        }
    }

    const CurvedTables<T>& tables_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
