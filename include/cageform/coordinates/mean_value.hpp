// Mean value coordinates: a closed form for the whole plane, smooth, negative in places.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/mean_value_gradients.hpp>
#include <cageform/core/detail/simd_sqrt.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T, std::size_t D>
class MeanValueCoordinates;

/// Mean value coordinates in the plane, for any set of simple loops, holes included.
///
///   w_i = (tan(α_{i−1}/2) + tan(α_i/2)) / |C_i − p|,  m_i = w_i / Σ w,  α_i the signed angle C_i p C_{i+1}
///
/// Floater, Mean value coordinates (CAGD 20, 2003), eq. (2.1); several loops and the plane outside:
/// Hormann & Floater, Mean value coordinates for arbitrary planar polygons (ACM TOG 25, 2006), sec. 3 and 4.
/// On vertices and edges the limits are taken (the unit row; linear along the edge).
///
///   range     sum to 1; may be negative where the cage is not convex, and outside
///   accuracy  a few roundings inside and near the cage; far away the true weights grow like the distance
///             and cancel, so points farther than some hundred diagonals are computed one precision higher,
///             where the platform has one (float always; double where long double is wider)
///   cost      O(#V) a point; one division and one square root per vertex and eight (sixteen) points
template <Scalar T>
class MeanValueCoordinates<T, 2> {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 2;
    static constexpr bool has_extension = true;
    static constexpr bool closed_form = true;

    explicit MeanValueCoordinates(Polygon<T> cage)
        : cage_(std::move(cage))
        , report_(check(cage_)) {
        if (report_.status != Status::ok) return;
        const auto bounds = bounds_of(cage_.vertices());
        tolerance_ = coincidence_tolerance(bounds);
        scale_ = unit_scale(bounds); // products of three lengths stay in range
        gradients_ = detail::MeanValueGradients<T, 2>(cage_);

        corners_.resize(cage_.size());
        for (std::size_t k = 0; k < cage_.loops().size(); ++k) {
            const auto& loop = cage_.loops()[k];
            // Outer loops count counter-clockwise, holes clockwise; any other way is turned by the sign.
            const bool turns_left = signed_area(cage_, loop) > 0;
            const T sign = turns_left == (loop_depth(cage_, k) % 2 == 0) ? T(1) : T(-1);
            for (std::size_t i = loop.begin; i < loop.end; ++i) {
                const auto& c = cage_[i];
                const auto e = cage_[i + 1 < loop.end ? i + 1 : loop.begin] - c;
                corners_[i] = {scale_ * c, (sign * scale_) * e,
                               (scale_ * tolerance_) * (scale_ * (std::fabs(e[0]) + std::fabs(e[1])))};
            }
        }
    }

    template <PointRange R>
        requires(range_dimension<R> == 2)
    explicit MeanValueCoordinates(const R& vertices)
        : MeanValueCoordinates(Polygon<T>(vertices)) {}

    /// Loops alone: interior_cells_not_supported where there are cells inside.
    explicit MeanValueCoordinates(const CellComplex<T, 2>& cage)
        : MeanValueCoordinates(cage.boundary()) {
        refuse_interior_cells(cage, report_);
    }

    const Polygon<T>& cage() const noexcept { return cage_; }
    std::span<const Vec<T, 2>> handles() const noexcept { return cage_.vertices(); }
    const CageReport& cage_report() const noexcept { return report_; }

    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const Running& running = {}) const {
        return detail::evaluate_blocks<T>(report_, cage_.size(), {points, weights, states}, running,
                                          [&](std::size_t begin, std::size_t end) {
                                              for (std::size_t b = begin; b < end; ++b)
                                                  evaluate_block(b, points, weights, states);
                                          });
    }

    /// The gradients of all weights at a batch of points, by differentiating the formula.
    ///
    ///   points     as for `evaluate`; so are the states on entry and on return
    ///   gradients  out, row axis · #handles + handle: the derivative along the axis, per unit of length. For a point on the
    ///              boundary, where there are derivatives from one side only, that of a place 1e-6 diagonals inside
    ///   accuracy   double: 1e-11 of the largest, or of one over the diagonal (3e-12 measured); float: that of rounding them.
    ///              Σ ∇w_i = 0 and Σ C_i ∇w_i = identity likewise. Nearer to a vertex than 1e-6 diagonals gradients turn with
    ///              the direction, on it they are those of one
    ///   cost       two to three times that of `evaluate`; tens of times for a point on the boundary, nearer to it than 1e-5
    ///              diagonals (double), or some diagonals away
    Evaluation evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                  std::span<PointState> states, const Running& running = {}) const {
        return detail::evaluate_blocks<T>(report_, 2 * cage_.size(), {points, gradients, states}, running,
                                          [&](std::size_t begin, std::size_t end) {
                                              gradients_.run(cage_, begin, end, points, gradients, states);
                                          });
    }

    Vec<T, 2> nearest_boundary(const Vec<T, 2>& p, std::span<T> row) const noexcept {
        return nearest_boundary_weights(cage_, p, row);
    }

private:
    using Simd = detail::Simd<T>;
    static constexpr std::size_t lanes = lane_count<T>;
    static constexpr T far_away = 64; // diagonals

    struct Corner {
        Vec<T, 2> position; // scaled
        Vec<T, 2> edge;     // to the next vertex, scaled and signed by the loop's orientation
        T on_edge;          // |cross(u, edge)| at most this: within the tolerance of the edge's line
    };

    void evaluate_block(std::size_t b, BlockView<const T> points, BlockView<T> weights,
                        std::span<PointState> states) const {
        const auto* const position = points.block(b);
        auto* const row = weights.block(b);
        const Simd zero(T(0)), one(T(1));
        const Simd px = Simd(scale_) * Simd::load(position[0]);
        const Simd py = Simd(scale_) * Simd::load(position[1]);
        const Simd on_vertex((scale_ * tolerance_) * (scale_ * tolerance_));
        Simd special = zero; // set to one in lanes that need the careful scalar way
        Simd sum = zero;

        // u is the vector to a vertex, r its length, t = tan(α/2) of the edge that starts there. Dividing by
        // the product of the tangent's denominator and the next r serves both the tangent and 1/r.
        for (const auto& loop : cage_.loops()) {
            const Simd ux_first = Simd(corners_[loop.begin].position[0]) - px;
            const Simd uy_first = Simd(corners_[loop.begin].position[1]) - py;
            const Simd rr_first = ux_first * ux_first + uy_first * uy_first;
            const Simd r_first = sqrt(rr_first);
            special = select<T>(rr_first <= on_vertex, one, special);
            special = select<T>(Simd(far_away * far_away) < rr_first, one, special);
            Simd ux = ux_first, uy = uy_first, r = r_first;
            Simd t_before = zero, inverse_r = zero, t_first = zero, inverse_r_first = zero;
            for (std::size_t i = loop.begin; i < loop.end; ++i) {
                const Corner& corner = corners_[i];
                Simd vx = ux_first, vy = uy_first, q = r_first;
                if (i + 1 < loop.end) {
                    vx = Simd(corners_[i + 1].position[0]) - px;
                    vy = Simd(corners_[i + 1].position[1]) - py;
                    const Simd qq = vx * vx + vy * vy;
                    q = sqrt(qq);
                    special = select<T>(qq <= on_vertex, one, special);
                }
                // tan(α/2) = sin/(1 + cos) = (1 − cos)/sin, whichever does not cancel. The cross product is
                // taken with the edge: with v it would cancel far away.
                const Simd c = ux * Simd(corner.edge[1]) - uy * Simd(corner.edge[0]);
                const Simd d = ux * vx + uy * vy;
                const Simd s = r * q + abs<T>(d);
                const auto acute = zero < d;
                special = select<T>((abs<T>(c) <= Simd(corner.on_edge)) & (d <= zero), one, special);
                const Simd numerator = select<T>(acute, c, s);
                const Simd denominator = select<T>(acute, s, c);
                const Simd inverse = one / (denominator * q);
                const Simd t = numerator * q * inverse;
                if (i == loop.begin) {
                    t_first = t;
                } else {
                    const Simd w = (t_before + t) * inverse_r;
                    w.store(row[i]);
                    sum = sum + w;
                }
                t_before = t;
                inverse_r = denominator * inverse;
                ux = vx;
                uy = vy;
                r = q;
                inverse_r_first = inverse_r; // after the last edge: that of the loop's first vertex
            }
            const Simd w = (t_before + t_first) * inverse_r_first;
            w.store(row[loop.begin]);
            sum = sum + w;
        }
        special = select<T>(abs<T>(sum) <= zero, one, special);

        const Simd inverse_sum = one / sum;
        for (std::size_t i = 0; i < cage_.size(); ++i) (Simd::load(row[i]) * inverse_sum).store(row[i]);

        // The sum is positive inside and negative outside (Hormann & Floater 2006, sec. 4.1 and 4.2).
        Lanes<T> sums, specials;
        sum.store(sums);
        special.store(specials);
        const std::size_t first = b * lanes;
        const std::size_t used = std::min(lanes, points.points - first);
        for (std::size_t lane = 0; lane < used; ++lane) {
            PointState& state = states[first + lane];
            if (state == PointState::not_finite) continue;
            if (specials[lane] != T(0)) {
                state = evaluate_carefully({position[0][lane], position[1][lane]}, row, lane);
            } else {
                state = sums[lane] > T(0) ? PointState::inside : PointState::outside;
            }
        }
    }

    /// One point the plain way: limits on the boundary, and one precision higher off it.
    PointState evaluate_carefully(const Vec<T, 2>& p, Lanes<T>* row, std::size_t lane) const {
        using Wide = std::conditional_t<std::is_same_v<T, float>, double, long double>;
        const auto near = nearest_on_boundary(cage_, p);
        if (near.distance <= tolerance_) {
            for (std::size_t i = 0; i < cage_.size(); ++i) row[i][lane] = T(0);
            row[near.i][lane] = T(1) - near.s;
            row[near.j][lane] = near.s;
            return PointState::on_boundary;
        }
        // Lengths are taken relative to the distance, so that nothing overflows.
        const auto u_of = [&](std::size_t i) {
            return Vec<Wide, 2>{(Wide(cage_[i][0]) - Wide(p[0])) / Wide(near.distance),
                                (Wide(cage_[i][1]) - Wide(p[1])) / Wide(near.distance)};
        };
        std::vector<Wide> w(cage_.size(), Wide(0));
        Wide sum = 0;
        cage_.for_each_edge([&](std::size_t i, std::size_t j) {
            const auto u = u_of(i), v = u_of(j);
            const Wide sign = corners_[i].edge[0] * (cage_[j][0] - cage_[i][0]) +
                                          corners_[i].edge[1] * (cage_[j][1] - cage_[i][1]) <
                                      0
                                  ? Wide(-1)
                                  : Wide(1);
            const auto e =
                (sign / Wide(near.distance)) * (vec_cast<Wide>(cage_[j]) - vec_cast<Wide>(cage_[i]));
            const Wide c = cross(u, e), d = dot(u, v);
            const Wide r = std::sqrt(dot(u, u)), q = std::sqrt(dot(v, v));
            const Wide t = d > 0 ? c / (r * q + d) : (r * q - d) / c;
            w[i] += t / r;
            w[j] += t / q;
            sum += t / r + t / q;
        });
        if (sum == 0) return PointState::unreached;
        for (std::size_t i = 0; i < cage_.size(); ++i) {
            row[i][lane] = static_cast<T>(w[i] / sum);
            if (!is_finite(row[i][lane])) return PointState::unreached;
        }
        // Farther than the diagonal is outside, though rounding may turn the sum's sign (from 1e15 diagonals on).
        return sum > 0 && scale_ * near.distance < T(1) ? PointState::inside : PointState::outside;
    }

    Polygon<T> cage_;
    CageReport report_;
    std::vector<Corner> corners_;
    detail::MeanValueGradients<T, 2> gradients_;
    T tolerance_ = 0;
    T scale_ = 1;
};

using MeanValueCoordinates2f = MeanValueCoordinates<float, 2>;
using MeanValueCoordinates2d = MeanValueCoordinates<double, 2>;

} // namespace cageform::inline CAGEFORM_ABI
