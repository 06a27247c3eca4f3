// The integrals over all edges of a curved cage for a register of points.
#pragma once

#include <cageform/coordinates/curved_green/cage_tables.hpp>
#include <cageform/coordinates/curved_green/point.hpp>
#include <cageform/core/detail/simd_angle.hpp>
#include <cageform/core/detail/simd_log.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Computes the integrals of a block of points: far edges and lines in SIMD registers, near curves point by
/// point.
template <Scalar T>
class CurvedBlock {
    using X = Simd<double>;

public:
    static constexpr std::size_t lanes = lane_count<double>;

    explicit CurvedBlock(const CurvedTables<T>& tables)
        : tables_(tables)
        , logs_(tables.vertices.size()) {}

    Lanes<double> x, y;                      ///< the points, in units of 1/scale
    Lanes<double> winding;                   ///< out: the winding number of the cage, 1 inside
    std::array<EdgeTouch, lanes> touch;      ///< out
    std::array<std::size_t, lanes> vertex{}; ///< the vertex that a point lies on, else #vertices

    /// Sets `rows` to the integrals. For weights, a point within the tolerance of a vertex lies on the
    /// vertex.
    template <bool gradients>
    void integrate(Lanes<double>* rows) {
        touch.fill({});
        if constexpr (gradients) {
            for (std::size_t row = 0; row < 2 * tables_.handles.size(); ++row) X(0.0).store(rows[row]);
        } else {
            for (const auto& v : tables_.vertices) X(0.0).store(rows[v.handle]);
        }
        const Complex<X> z{X::load(x), X::load(y)};
        find_vertices<gradients>(z);
        X turning(0.0);
        for (std::size_t e = 0; e < tables_.edges.size(); ++e) {
            Sums sums;
            set_sums<gradients>(e, z, sums);
            turning += sums.turning;
            if constexpr (gradients) {
                add_slopes(tables_.edges[e], sums, rows);
            } else {
                add_weights(tables_.edges[e], sums, rows);
            }
        }
        (X(1 / (2 * std::numbers::pi)) * turning).store(winding);
    }

private:
    using Sums = EdgeSums<X>;

    ComplexNumber place(std::size_t lane) const noexcept { return {x[lane], y[lane]}; }
    /// Finds the vertices that points lie on, and the logarithms of the distances from the vertices.
    template <bool gradients>
    void find_vertices(const Complex<X>& z) noexcept {
        vertex.fill(tables_.vertices.size());
        on_vertices_ = false;
        X least((std::numeric_limits<double>::max)());
        if constexpr (gradients) return;
        for (std::size_t v = 0; v < tables_.vertices.size(); ++v) {
            const X square = norm(spread(tables_.vertices[v].at) - z);
            least = (min)(least, square);
            (X(0.5) * log((max)(square, X(1e-300)))).store(logs_[v]);
        }
        Lanes<double> nearest;
        least.store(nearest);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            if (!(nearest[lane] <= tables_.tolerance * tables_.tolerance)) continue;
            vertex[lane] = CurvedPoint<T>(tables_).vertex_at(place(lane));
            on_vertices_ = true;
        }
    }
    static Complex<X> spread(const ComplexNumber& a) noexcept { return {X(a.re), X(a.im)}; }

    template <bool gradients>
    void set_sums(std::size_t e, const Complex<X>& z, Sums& sums) noexcept {
        const CurvedEdge& edge = tables_.edges[e];
        Lanes<double> square;
        norm(z - spread(edge.centre)).store(square);
        std::array<bool, lanes> is_near;
        std::size_t count = 0;
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            is_near[lane] = square[lane] < edge.reach * edge.reach;
            count += is_near[lane] ? 1 : 0;
        }
        const bool is_line = edge.is_line();
        FarSums<gradients, X>::set(edge, z, sums);
        if (count == 0) return;
        if (is_line) add_line<gradients>(e, z, sums);
        if (is_line && !on_vertices_) return;
        const std::size_t degree = edge.posed_degree - (gradients ? 1 : 0);
        Values stored;
        bool is_stored = false;
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            if (!is_near[lane]) continue;
            if (is_line && edge.end[0].vertex != vertex[lane] && edge.end[1].vertex != vertex[lane]) continue;
            EdgeSums<double> of;
            if (!CurvedPoint<T>(tables_).template set_near_sums<gradients>(e, place(lane), vertex[lane],
                                                                           touch[lane], of))
                continue;
            if (!is_stored) stored.load(sums, degree);
            is_stored = true;
            stored.set(lane, of, degree);
        }
        if (is_stored) stored.store(sums, degree);
    }
    /// Sums in memory, for writing single lanes.
    struct Values {
        std::array<Lanes<double>, most_posed_degree + 1> re, im;
        Lanes<double> turning;

        void load(const Sums& sums, std::size_t degree) noexcept {
            for (std::size_t k = 0; k <= degree; ++k) {
                sums.value[k].re.store(re[k]);
                sums.value[k].im.store(im[k]);
            }
            sums.turning.store(turning);
        }
        void set(std::size_t lane, const EdgeSums<double>& of, std::size_t degree) noexcept {
            for (std::size_t k = 0; k <= degree; ++k) {
                re[k][lane] = of.value[k].re;
                im[k][lane] = of.value[k].im;
            }
            turning[lane] = of.turning;
        }
        void store(Sums& sums, std::size_t degree) const noexcept {
            for (std::size_t k = 0; k <= degree; ++k) sums.value[k] = {X::load(re[k]), X::load(im[k])};
            sums.turning = X::load(turning);
        }
    };

    /// Replaces the sums of a line for points inside the ellipse of its nodes. A line has one root.
    template <bool gradients>
    void add_line(std::size_t e, const Complex<X>& z, Sums& sums) noexcept {
        const CurvedEdge& edge = tables_.edges[e];
        const Complex<X> from_start = spread(edge.end[0].at) - z, from_end = spread(edge.end[1].at) - z;
        const auto forward = norm(from_start) <= norm(from_end);
        // s = −c₀/c₁ from the nearer end.
        const X sign = select(forward, X(-1.0), X(1.0));
        const Complex<X> c{sign * select(forward, from_start.re, from_end.re),
                           sign * select(forward, from_start.im, from_end.im)};
        const Complex<X> s = spread(edge.rate) * c, beyond{s.re - X(1.0), s.im};
        const X along = (s.re - X(0.5)) * X(1.2), off = s.im * X(1.5); // half axes 5/6 and 2/3
        const auto is_inside = along * along + off * off < X(1.0);
        const X square = (max)(norm(s), X(1e-300));
        const Complex<X> turned = beyond * Complex<X>{s.re, -s.im};
        const X size = angle(abs(turned.im), turned.re), argument = select(turned.im < X(0.0), -size, size);
        const Complex<X> integral{X(0.5) * log((max)(norm(beyond), X(1e-300)) / square), argument};
        const std::size_t degree = edge.posed_degree - (gradients ? 1 : 0);
        EdgeMoments<X> j;
        raise_moments(CurveRoot<X>{s, beyond}, integral, degree, j);
        // From the other end, the order of values is reversed, and the sign of weights.
        const Complex<X> over = gradients ? spread(edge.rate) : Complex<X>{X(1.0), X(0.0)};
        for (std::size_t k = 0; k <= degree; ++k) {
            const Complex<X> value = over * Complex<X>{select(forward, j[k].re, -j[degree - k].re),
                                                       select(forward, j[k].im, -j[degree - k].im)};
            sums.value[k].re = select(is_inside, value.re, sums.value[k].re);
            sums.value[k].im = select(is_inside, value.im, sums.value[k].im);
        }
        sums.turning = select(is_inside, select(forward, argument, -argument), sums.turning);
        find_touch(e, s, forward);
    }
    /// Finds points on a line.
    void find_touch(std::size_t e, const Complex<X>& s, const typename X::Mask& forward) noexcept {
        const X off_end = s.re - (max)(X(0.0), (min)(X(1.0), s.re));
        Lanes<double> square, re, im, is_forward;
        (off_end * off_end + s.im * s.im).store(square);
        const double length = size(tables_.edges[e].end[0].away.c[1]), reach = 4 * tables_.tolerance / length;
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            if (!(square[lane] <= reach * reach)) continue;
            s.re.store(re);
            s.im.store(im);
            select(forward, X(1.0), X(0.0)).store(is_forward);
            const double distance = length * std::sqrt(square[lane]);
            if (!(distance < touch[lane].distance)) continue;
            const ComplexNumber root{re[lane], im[lane]};
            touch[lane] = {e, is_forward[lane] != 0 ? root : ComplexNumber{1, 0} - root, distance};
        }
    }
    /// See add_edge_weights.
    void add_weights(const CurvedEdge& edge, const Sums& sums, Lanes<double>* rows) const noexcept {
        const X share(1 / (2 * std::numbers::pi));
        const std::uint32_t end = edge.end[1].vertex;
        Lanes<double> distance = logs_[end];
        for (std::size_t lane = 0; lane < lanes && on_vertices_; ++lane) {
            if (vertex[lane] == end) distance[lane] = edge.end[1].log_tangent;
        }
        add_edge_weights(edge, sums.value, X(tables_.log_diagonal) - X::load(distance), share,
                         [&](std::size_t row, const X& weight, bool alone) {
                             alone ? weight.store(rows[row]) : add(weight, rows[row]);
                         });
    }
    void add_slopes(const CurvedEdge& edge, const Sums& sums, Lanes<double>* rows) const noexcept {
        add_edge_slopes(edge, sums.value, {1, 1}, 2 * tables_.points(),
                        [&](std::size_t row, const X& slope) { add(slope, rows[row]); });
    }
    static void add(const X& value, Lanes<double>& row) noexcept { (X::load(row) + value).store(row); }

    const CurvedTables<T>& tables_;
    std::vector<Lanes<double>> logs_; ///< logarithms of the distances from the vertices
    bool on_vertices_ = false;        ///< whether a point of the block lies on a vertex
};

} // namespace cageform::inline CAGEFORM_ABI::detail
