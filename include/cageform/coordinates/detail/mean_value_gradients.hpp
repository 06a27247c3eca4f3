// Gradients of mean value weights: the formulas of both dimensions, differentiated.
#pragma once

#include <cageform/cage/cell_complex.hpp>
#include <cageform/coordinates/detail/dual.hpp>
#include <cageform/coordinates/detail/mean_value_face.hpp>
#include <cageform/core/detail/simd_angle.hpp>
#include <cageform/core/detail/simd_sqrt.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// What both dimensions share. Weights λ = w/Σw are differentiated as ∇λ = (∇w − λ Σ∇w)/Σw. Everything is computed in
/// double, eight points at a time, whatever the scalar of the blocks; next to the boundary and far away, where these
/// differences lose digits, point by point in `Wide` by forward differentiation (detail/dual.hpp).
template <Scalar T, std::size_t D>
struct GradientsInDouble {
    using Simd = detail::Simd<double>;
    using Wide = std::conditional_t<std::is_same_v<T, float>, double, long double>;
    using Number = Dual<Wide, D>;
    static constexpr std::size_t lanes = lane_count<double>;
    static constexpr double far_away = 2; ///< diagonals or half diagonals
    /// Nearer to the boundary than this, in diagonals, Σw divides too much of the digits away.
    static constexpr double near_boundary = sizeof(T) == 8 ? 1e-5 : 0;
    /// Where derivatives are taken for places on the boundary: so far inside, in diagonals.
    static constexpr double step_inside = 0x1p-20;

    /// Lanes [first, first + 8) of a row of either scalar.
    static Simd load(const Lanes<T>& row, std::size_t first) noexcept {
        Lanes<double> eight;
        for (std::size_t lane = 0; lane < lanes; ++lane) eight[lane] = double(row[first + lane]);
        return Simd::load(eight);
    }
    static void store(const Simd& x, Lanes<T>& row, std::size_t first) noexcept {
        Lanes<double> eight;
        x.store(eight);
        for (std::size_t lane = 0; lane < lanes; ++lane) row[first + lane] = static_cast<T>(eight[lane]);
    }
    static void add(Lanes<double>& row, const Simd& x) noexcept { (Simd::load(row) + x).store(row); }

    /// From w and its derivatives (D + 1 rows a handle) to those of w/Σw, times `scale`. Returns Σw.
    static Simd store_quotients(const Lanes<double>* rows, std::size_t handles, double scale, Lanes<T>* out,
                                std::size_t first) noexcept {
        Simd sum[D + 1];
        for (Simd& s : sum) s = Simd(0.0);
        for (std::size_t i = 0; i < handles; ++i) {
            for (std::size_t k = 0; k <= D; ++k) sum[k] = sum[k] + Simd::load(rows[i * (D + 1) + k]);
        }
        const Simd inverse = Simd(1.0) / sum[0];
        for (std::size_t i = 0; i < handles; ++i) {
            const Simd weight = Simd::load(rows[i * (D + 1)]) * inverse;
            for (std::size_t k = 0; k < D; ++k) {
                const Simd slope = Simd::load(rows[i * (D + 1) + k + 1]) - weight * sum[k + 1];
                store(Simd(scale) * (slope * inverse), out[k * handles + i], first);
            }
        }
        return sum[0];
    }

    /// The same of one point, its weights before normalising given; false where that cannot be represented.
    static bool store_quotients(const std::vector<Number>& weights, Wide scale, Lanes<T>* out,
                                std::size_t lane) noexcept {
        Number sum;
        for (const Number& w : weights) sum += w;
        if (!(std::fabs(sum.value) > 0)) return false;
        bool finite = true;
        for (std::size_t i = 0; i < weights.size(); ++i) {
            const Number quotient = weights[i] / sum;
            for (std::size_t k = 0; k < D; ++k) {
                T& x = out[k * weights.size() + i][lane] = static_cast<T>(scale * quotient.gradient[k]);
                finite = finite && is_finite(x);
            }
        }
        return finite;
    }

    /// Runs eight(b, first, special) for all halves of blocks [begin, end) and one(p, b, lane) for the points it flags. Both
    /// write a block of gradients; `eight` returns Σw, whose sign is the side of the cage.
    template <class Eight, class One>
    static void for_points(std::size_t begin, std::size_t end, BlockView<const T> points,
                           std::span<PointState> states, const Eight& eight, const One& one) {
        for (std::size_t b = begin; b < end; ++b) {
            for (std::size_t first = 0; first < lane_count<T>; first += lanes) {
                Simd special(0.0); // set to one in lanes that need the careful way
                Lanes<double> sums, specials;
                eight(b, first, special).store(sums);
                special.store(specials);
                for (std::size_t lane = 0; lane < lanes; ++lane) {
                    const std::size_t i = b * lane_count<T> + first + lane;
                    if (i >= points.points || states[i] == PointState::not_finite) continue;
                    if (specials[lane] != 0 || !is_finite(sums[lane]) || sums[lane] == 0) {
                        states[i] = one(block_point<D>(points, i), b, first + lane);
                    } else {
                        states[i] = sums[lane] > 0 ? PointState::inside : PointState::outside;
                    }
                }
            }
        }
    }
};

template <Scalar T, std::size_t D>
class MeanValueGradients;

/// In the plane. With u, v the vectors to the ends of an edge e, t = tan(α/2): ∇(t/|u|) = ∇t/|u| + t u/|u|³,
///
///   ∇t = (1 + t²)/2 ∇α,   ∇α = ⟂(v/v² − u/u²) = ⟂(e u² − u (e·(u + v)))/(u² v²),   ⟂(x, y) = (y, −x)
template <Scalar T>
class MeanValueGradients<T, 2> : GradientsInDouble<T, 2> {
public:
    MeanValueGradients() = default;
    explicit MeanValueGradients(const Polygon<T>& polygon) {
        const auto bounds = bounds_of(polygon.vertices());
        tolerance_ = coincidence_tolerance(bounds);
        scale_ = double(unit_scale(bounds));
        near_ = std::max(scale_ * double(tolerance_), Base::near_boundary);
        for (std::size_t k = 0; k < polygon.loops().size(); ++k) {
            const auto& loop = polygon.loops()[k];
            const bool turns_left = signed_area(polygon, loop) > 0;
            const double sign = turns_left == (loop_depth(polygon, k) % 2 == 0) ? 1 : -1;
            for (std::size_t i = loop.begin; i < loop.end; ++i) {
                const std::size_t j = i + 1 < loop.end ? i + 1 : loop.begin;
                const auto a = scale_ * vec_cast<double>(polygon[i]),
                           b = scale_ * vec_cast<double>(polygon[j]);
                const double reach = near_ * (std::fabs(b[0] - a[0]) + std::fabs(b[1] - a[1]));
                edges_.push_back({i, j, a, b, sign * (b - a), sign, reach});
            }
        }
    }

    /// The rows of `gradients` of blocks [begin, end), and the states.
    void run(const Polygon<T>& cage, std::size_t begin, std::size_t end, BlockView<const T> points,
             BlockView<T> gradients, std::span<PointState> states) const {
        std::vector<Lanes<double>> rows(3 * cage.size());
        std::vector<Number> weights(cage.size());
        Base::for_points(
            begin, end, points, states,
            [&](std::size_t b, std::size_t first, Simd& special) {
                return eight(cage, points.block(b), rows.data(), gradients.block(b), first, special);
            },
            [&](const Vec<T, 2>& p, std::size_t b, std::size_t lane) {
                return one(cage, p, weights, gradients.block(b), lane);
            });
    }

private:
    using Base = GradientsInDouble<T, 2>;
    using typename Base::Number;
    using typename Base::Simd;
    using typename Base::Wide;

    struct Edge {
        std::size_t i, j;
        Vec<double, 2> from, to; // scaled
        Vec<double, 2> along;    // signed by the loop's orientation
        double sign;
        double near; // |cross(u, along)| at most this: near the edge's line
    };

    Simd eight(const Polygon<T>& cage, const Lanes<T>* position, Lanes<double>* rows, Lanes<T>* out,
               std::size_t first, Simd& special) const noexcept {
        const Simd zero(0.0), one(1.0), half(0.5);
        const Simd px = Simd(scale_) * Base::load(position[0], first);
        const Simd py = Simd(scale_) * Base::load(position[1], first);
        const Simd near(near_ * near_), far(Base::far_away * Base::far_away);
        for (std::size_t n = 0; n < 3 * cage.size(); ++n) zero.store(rows[n]);
        for (const Edge& edge : edges_) {
            const Simd ux = Simd(edge.from[0]) - px, uy = Simd(edge.from[1]) - py;
            const Simd vx = Simd(edge.to[0]) - px, vy = Simd(edge.to[1]) - py;
            const Simd ex(edge.along[0]), ey(edge.along[1]);
            const Simd rr = ux * ux + uy * uy, qq = vx * vx + vy * vy;
            const Simd c = ux * ey - uy * ex, d = ux * vx + uy * vy;
            special = select<double>((rr <= near) | (far < rr), one, special);
            special = select<double>((abs<double>(c) <= Simd(edge.near)) & (d <= zero), one, special);
            const Simd r = sqrt(rr), q = sqrt(qq), s = r * q + abs<double>(d);
            const auto acute = zero < d;
            const Simd t = select<double>(acute, c, s) / select<double>(acute, s, c);
            const Simd inverse = one / (rr * qq), bent = ex * (ux + vx) + ey * (uy + vy);
            const Simd turn = half * (one + t * t) * inverse;
            const Simd tx = turn * (ey * rr - uy * bent), ty = turn * (ux * bent - ex * rr);
            const auto add = [&](std::size_t i, const Simd& x, const Simd& y, const Simd& length,
                                 const Simd& length2) {
                const Simd shorter = one / length, weight = t * shorter, pull = weight / length2;
                Base::add(rows[3 * i], weight);
                Base::add(rows[3 * i + 1], tx * shorter + pull * x);
                Base::add(rows[3 * i + 2], ty * shorter + pull * y);
            };
            add(edge.i, ux, uy, r, rr);
            add(edge.j, vx, vy, q, qq);
        }
        return Base::store_quotients(rows, cage.size(), scale_, out, first);
    }

    PointState one(const Polygon<T>& cage, const Vec<T, 2>& p, std::vector<Number>& weights, Lanes<T>* out,
                   std::size_t lane) const noexcept {
        const T distance = nearest_on_boundary(cage, p).distance;
        Wide unit = Wide(distance);
        PointState state = PointState::on_boundary;
        if (distance > tolerance_) {
            const Wide sum = weigh(cage, vec_cast<Wide>(p), unit, weights);
            state = sum > 0 && scale_ * double(distance) < 1 ? PointState::inside : PointState::outside;
        } else {
            // Between the edges that meet there.
            unit = Wide(Base::step_inside / scale_);
            Vec<double, 2> inwards{};
            for (const Edge& edge : edges_) {
                if (nearest_on_edge(cage, edge.i, edge.j, p).distance > 2 * tolerance_) continue;
                inwards = inwards + (1 / length(edge.along)) * Vec<double, 2>{-edge.along[1], edge.along[0]};
            }
            const Wide size = Wide(length(inwards));
            if (!(size > 0)) return PointState::unreached;
            weigh(cage, vec_cast<Wide>(p) + (unit / size) * vec_cast<Wide>(inwards), unit, weights);
        }
        return Base::store_quotients(weights, 1 / unit, out, lane) ? state : PointState::unreached;
    }

    /// The weights before normalising, lengths in `unit`s so that nothing overflows. Returns their sum.
    Wide weigh(const Polygon<T>& cage, const Vec<Wide, 2>& p, Wide unit,
               std::vector<Number>& weights) const noexcept {
        using Place = std::array<Number, 2>;
        const auto from_p = [&](std::size_t i) {
            const auto c = vec_cast<Wide>(cage[i]);
            return Place{Number((c[0] - p[0]) / unit, {-1, 0}), Number((c[1] - p[1]) / unit, {0, -1})};
        };
        const auto times = [](const Place& a, const Place& b) { return a[0] * b[0] + a[1] * b[1]; };
        std::fill(weights.begin(), weights.end(), Number());
        for (const Edge& edge : edges_) {
            const auto u = from_p(edge.i), v = from_p(edge.j);
            const auto e =
                (Wide(edge.sign) / unit) * (vec_cast<Wide>(cage[edge.j]) - vec_cast<Wide>(cage[edge.i]));
            const Number c = e[1] * u[0] - e[0] * u[1], d = times(u, v);
            const Number r = sqrt(times(u, u)), q = sqrt(times(v, v));
            const Number t = d.value > 0 ? c / (r * q + d) : (r * q - d) / c;
            weights[edge.i] += t / r;
            weights[edge.j] += t / q;
        }
        Wide sum = 0;
        for (const Number& w : weights) sum += w.value;
        return sum;
    }

    std::vector<Edge> edges_;
    T tolerance_ = 0;
    double scale_ = 1, near_ = 0;
};

/// In space, with the names of MeanValueCoordinates<T, 3>. For an edge that is seen from b to e along its line, R the vector
/// to the line, τ its direction, r and q the distances to its ends:
///
///   ∇g = τ (1/r² − 1/q²) + R G,   G = (g + e/q² − b/r²)/R²
///
/// and with ∇H = −n, ∇ρ_k = −ν_k all else follows. Next to the plane of a face that p does not face, S is differentiated by the
/// formula of `beside_face`.
template <Scalar T>
class MeanValueGradients<T, 3> : GradientsInDouble<T, 3> {
public:
    MeanValueGradients() = default;
    explicit MeanValueGradients(const TriangleMesh<T>& cage) {
        const auto bounds = bounds_of(cage.vertices());
        tolerance_ = coincidence_tolerance(bounds);
        scale_ = double(unit_scale(bounds));
        near_ = std::max(scale_ * double(tolerance_), Base::near_boundary);
        frame_ = frame_of<double>(cage, cage[0], unit_scale(bounds));
    }

    /// The rows of `gradients` of blocks [begin, end), and the states.
    void run(const TriangleMesh<T>& cage, std::size_t begin, std::size_t end, BlockView<const T> points,
             BlockView<T> gradients, std::span<PointState> states) const {
        std::vector<Lanes<double>> rows(4 * cage.size());
        std::vector<SeenEdge> seen(frame_.edges.size());
        std::vector<Number> weights(cage.size());
        Base::for_points(
            begin, end, points, states,
            [&](std::size_t b, std::size_t first, Simd& special) {
                return eight(cage, points.block(b), seen.data(), rows.data(), gradients.block(b), first,
                             special);
            },
            [&](const Vec<T, 3>& p, std::size_t b, std::size_t lane) {
                return one(cage, p, weights, gradients.block(b), lane);
            });
    }

private:
    using Base = GradientsInDouble<T, 3>;
    using typename Base::Number;
    using typename Base::Simd;
    using typename Base::Wide;
    using Face = typename MeshFrame<double>::Face;
    using Base::lanes;

    struct SeenEdge {
        Lanes<double> g, slope[3];
    };
    /// Faces nearer to p's plane than this (far beside them: than its square times as much) and not faced by p lose too
    /// many digits.
    static constexpr double near_plane = 2e-3;

    Simd eight(const TriangleMesh<T>& cage, const Lanes<T>* position, SeenEdge* seen, Lanes<double>* rows,
               Lanes<T>* out, std::size_t first, Simd& special) const noexcept {
        const Simd zero(0.0), one(1.0), half(0.5), least(std::numeric_limits<double>::min() * 1e6);
        const auto origin = vec_cast<double>(cage[0]);
        std::array<Simd, 3> p;
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = Simd(scale_) * (Base::load(position[k], first) - Simd(origin[k]));
        const auto dot_p = [&p](const Vec<double, 3>& v) {
            return Simd(v[0]) * p[0] + (Simd(v[1]) * p[1] + Simd(v[2]) * p[2]);
        };
        for (std::size_t n = 0; n < frame_.edges.size(); ++n) {
            const auto& edge = frame_.edges[n];
            const Simd x = Simd(edge.origin[0]) - p[0], y = Simd(edge.origin[1]) - p[1],
                       z = Simd(edge.origin[2]) - p[2];
            const Simd tx(edge.direction[0]), ty(edge.direction[1]), tz(edge.direction[2]),
                length(edge.length);
            const Simd begin = x * tx + (y * ty + z * tz), end = begin + length;
            const Simd cx = y * tz - z * ty, cy = z * tx - x * tz, cz = x * ty - y * tx;
            const Simd rr = max<double>(cx * cx + (cy * cy + cz * cz), least);
            const Simd r = sqrt(rr);
            const Simd g = angle<double>(r * length, rr + begin * end) / r;
            const Simd ends = length / ((rr + begin * begin) * (rr + end * end));
            const Simd axial = (begin + end) * ends;
            const Simd radial = (g + (rr - begin * end) * ends) / rr;
            g.store(seen[n].g);
            (tx * axial + (x - begin * tx) * radial).store(seen[n].slope[0]);
            (ty * axial + (y - begin * ty) * radial).store(seen[n].slope[1]);
            (tz * axial + (z - begin * tz) * radial).store(seen[n].slope[2]);
            special = select<double>(Simd(Base::far_away * Base::far_away) < rr, one, special);
        }
        for (std::size_t n = 0; n < 4 * cage.size(); ++n) zero.store(rows[n]);
        for (const Face& face : frame_.faces) {
            const Simd height = Simd(face.offset) - dot_p(face.normal);
            std::array<Simd, 3> g, rho, bent;
            Simd m = zero;
            for (std::size_t k = 0; k < 3; ++k) {
                g[k] = Simd::load(seen[face.edge[k]].g);
                rho[k] = Simd(face.across_offset[k]) - dot_p(face.across[k]);
                m = m + g[k] * rho[k];
            }
            m = half * m;
            const Simd distance = abs<double>(height);
            const Simd inmost = min<double>(rho[0], min<double>(rho[1], rho[2]));
            special = select<double>((distance <= Simd(near_)) & (Simd(-near_) <= inmost), one, special);
            const Simd low = Simd(near_plane) * max<double>(one, inmost * inmost);
            const auto beside = (distance < low) & (inmost < zero) & (m < half);
            const Simd inverse = one / select<double>(distance <= least, least, height);
            const Simd s = m * inverse;
            std::array<std::array<Simd, 3>, 4> w; // the weights of the corners, and their derivatives
            for (std::size_t k = 0; k < 3; ++k) {
                bent[k] = half * bend(face, k, g);
                w[0][k] = Simd(face.inverse_altitude[k]) * (s * rho[k] + height * bent[k]);
            }
            for (std::size_t axis = 0; axis < 3; ++axis) {
                std::array<Simd, 3> slope;
                Simd m_slope = zero;
                for (std::size_t k = 0; k < 3; ++k) {
                    slope[k] = Simd::load(seen[face.edge[k]].slope[axis]);
                    m_slope = m_slope + (rho[k] * slope[k] - g[k] * Simd(face.across[k][axis]));
                }
                const Simd normal(face.normal[axis]), s_slope = (half * m_slope + s * normal) * inverse;
                for (std::size_t k = 0; k < 3; ++k) {
                    const Simd flat = rho[k] * s_slope - s * Simd(face.across[k][axis]);
                    w[axis + 1][k] = Simd(face.inverse_altitude[k]) *
                                     (flat + (half * height * bend(face, k, slope) - normal * bent[k]));
                }
            }
            Lanes<double> flags;
            select<double>(beside, one, zero).store(flags);
            bool any = false;
            for (const double flag : flags.v) any = any || flag != 0;
            if (any) correct_lanes(face, flags, height, rho, seen, w);
            for (std::size_t k = 0; k < 3; ++k) {
                for (std::size_t n = 0; n < 4; ++n)
                    Base::add(rows[std::size_t{4} * face.corner[k] + n], w[n][k]);
            }
        }
        return Base::store_quotients(rows, cage.size(), scale_, out, first);
    }

    /// Σ_l g_l ν_k·ν_l.
    static Simd bend(const Face& face, std::size_t k, const std::array<Simd, 3>& g) noexcept {
        const std::size_t l = (k + 1) % 3, n = (k + 2) % 3;
        return g[k] + (Simd(face.cosine[n]) * g[l] + Simd(face.cosine[l]) * g[n]);
    }

    /// The weights of a face, and their derivatives, in the lanes flagged.
    static void correct_lanes(const Face& face, const Lanes<double>& flags, const Simd& height,
                              const std::array<Simd, 3>& rho, const SeenEdge* seen,
                              std::array<std::array<Simd, 3>, 4>& w) noexcept {
        using Near = Dual<double, 3>;
        Lanes<double> heights;
        height.store(heights);
        std::array<Lanes<double>, 3> rhos;
        std::array<std::array<Lanes<double>, 3>, 4> ws;
        std::array<double, 3> altitude;
        for (std::size_t k = 0; k < 3; ++k) {
            rho[k].store(rhos[k]);
            altitude[k] = 1 / face.inverse_altitude[k];
            for (std::size_t n = 0; n < 4; ++n) w[n][k].store(ws[n][k]);
        }
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            if (flags[lane] == 0) continue;
            std::array<Near, 3> distance, g;
            for (std::size_t k = 0; k < 3; ++k) {
                const SeenEdge& edge = seen[face.edge[k]];
                distance[k] = {rhos[k][lane], -1.0 * face.across[k]};
                g[k] = {edge.g[lane], {edge.slope[0][lane], edge.slope[1][lane], edge.slope[2][lane]}};
            }
            const Near above(heights[lane], -1.0 * face.normal);
            const auto weights = face_weights<Near, double>(above, distance, g, altitude, face.cosine, true);
            for (std::size_t k = 0; k < 3; ++k) {
                ws[0][k][lane] = weights[k].value;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    ws[axis + 1][k][lane] = weights[k].gradient[axis];
            }
        }
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t n = 0; n < 4; ++n) w[n][k] = Simd::load(ws[n][k]);
        }
    }

    PointState one(const TriangleMesh<T>& cage, const Vec<T, 3>& p, std::vector<Number>& weights,
                   Lanes<T>* out, std::size_t lane) const noexcept {
        Vec<T, 3> place;
        (void)nearest_boundary_value(cage, p, place);
        const auto at = vec_cast<double>(p);
        const double distance = length(vec_cast<double>(place) - at);
        Wide unit = Wide(distance);
        PointState state = PointState::on_boundary;
        if (distance > double(tolerance_)) {
            const Wide sum = weigh(cage, vec_cast<Wide>(p), unit, weights);
            state = sum > 0 && scale_ * distance < 1 ? PointState::inside : PointState::outside;
        } else {
            unit = Wide(Base::step_inside / scale_);
            weigh_inside(cage, at, unit, weights);
        }
        return Base::store_quotients(weights, 1 / unit, out, lane) ? state : PointState::unreached;
    }

    /// The weights a step inside from a place on the boundary: against the mean normal of the faces that meet there; at
    /// corners so bent that this leads outside, from one of them.
    void weigh_inside(const TriangleMesh<T>& cage, const Vec<double, 3>& p, Wide step,
                      std::vector<Number>& weights) const noexcept {
        const auto try_towards = [&](const Vec<double, 3>& way) {
            const double size = length(way);
            if (!(size > 0)) return false;
            const auto q = vec_cast<Wide>(p) + (step / Wide(size)) * vec_cast<Wide>(way);
            return weigh(cage, q, step, weights) > 0;
        };
        const auto for_faces = [&](const auto& body) {
            for (const Face& face : frame_.faces) {
                const auto corner = Facet<3>(face.corner, cage.vertices()).corner;
                const auto nearest = place_on_facet(nearest_on_facet(p, corner), corner);
                if (length(nearest - p) <= 2 * double(tolerance_) && body(face, corner)) return true;
            }
            return false;
        };
        Vec<double, 3> mean{};
        (void)for_faces([&](const Face& face, const auto&) {
            mean = mean - face.normal;
            return false;
        });
        if (try_towards(mean)) return;
        const bool found = for_faces([&](const Face& face, const auto& corner) {
            const auto middle = (1.0 / 3) * (corner[0] + corner[1] + corner[2]) - p;
            return try_towards((1 / length(middle)) * middle - 0.25 * face.normal);
        });
        if (!found) (void)try_towards(mean);
    }

    /// g of an edge from `a` to `a + along`, p at zero, and its gradient.
    static Number see_edge(const Vec<Wide, 3>& a, const Vec<Wide, 3>& along) noexcept {
        const Wide size = std::sqrt(dot(along, along));
        const auto direction = (1 / size) * along;
        const auto to_line = cross(direction, cross(a, direction));
        const Wide begin = dot(a, direction), end = begin + size, rr = dot(to_line, to_line);
        const Wide b2 = begin * begin, e2 = end * end, ends = size / ((rr + b2) * (rr + e2));
        Wide g = 0, radial = 0;
        if (begin * end > 0 && 100 * rr < b2 && 100 * rr < e2) {
            // Near the line, beyond its ends: both arctangents as series.
            Wide b_power = 1 / begin, e_power = 1 / end, power = 1;
            constexpr int terms = sizeof(T) == 8 ? 10 : 8;
            for (int k = 0; k <= terms; ++k) {
                const Wide term = Wide(k % 2 == 0 ? 1 : -1) / Wide(2 * k + 1) * (b_power - e_power);
                g += power * term;
                b_power /= b2;
                e_power /= e2;
                const Wide next =
                    Wide(k % 2 == 0 ? 1 : -1) / Wide(2 * k + 3) * (b_power - e_power); // of rr^(k+1), negated
                radial += 2 * Wide(k + 1) * power * next;
                power *= rr;
            }
        } else {
            const Wide r = std::sqrt(rr);
            g = std::atan2(r * size, rr + begin * end) / r;
            radial = (g + (rr - begin * end) * ends) / rr;
        }
        return {g, ((begin + end) * ends) * direction + radial * to_line};
    }

    /// The weights before normalising, lengths in `unit`s so that nothing overflows. Returns their sum.
    Wide weigh(const TriangleMesh<T>& cage, const Vec<Wide, 3>& p, Wide unit,
               std::vector<Number>& weights) const noexcept {
        std::fill(weights.begin(), weights.end(), Number());
        for (const Face& face : frame_.faces) {
            std::array<Vec<Wide, 3>, 3> c;
            for (std::size_t k = 0; k < 3; ++k)
                c[k] = (1 / unit) * (vec_cast<Wide>(cage[face.corner[k]]) - p);
            auto normal = cross(c[1] - c[0], c[2] - c[0]);
            const Wide area = std::sqrt(dot(normal, normal));
            normal = (1 / area) * normal;
            std::array<Vec<Wide, 3>, 3> across;
            std::array<Wide, 3> altitude, cosine;
            std::array<Number, 3> rho, g;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto &a = c[(k + 1) % 3], &b = c[(k + 2) % 3];
                const auto along = b - a;
                across[k] = (1 / std::sqrt(dot(along, along))) * cross(along, normal);
                rho[k] = {dot(across[k], a), Wide(-1) * across[k]};
                altitude[k] = dot(across[k], a - c[k]);
                g[k] = see_edge(a, along);
            }
            for (std::size_t k = 0; k < 3; ++k) cosine[k] = dot(across[(k + 1) % 3], across[(k + 2) % 3]);
            const Number height(dot(normal, c[0]), Wide(-1) * normal);
            const Wide m = Wide(0.5) * (g[0] * rho[0] + g[1] * rho[1] + g[2] * rho[2]).value;
            const Wide inmost = std::min({rho[0].value, rho[1].value, rho[2].value});
            const Wide low = std::max(Wide(1e-2) * std::sqrt(area), Wide(-0.1) * inmost);
            const bool beside = inmost < 0 && std::fabs(height.value) < low && m < Wide(0.5);
            const auto w = face_weights<Number, Wide>(height, rho, g, altitude, cosine, beside);
            for (std::size_t k = 0; k < 3; ++k) weights[face.corner[k]] += w[k];
        }
        Wide sum = 0;
        for (const Number& w : weights) sum += w.value;
        return sum;
    }

    MeshFrame<double> frame_;
    T tolerance_ = 0;
    double scale_ = 1, near_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
