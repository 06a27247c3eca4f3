// Mean value coordinates in space, for closed triangle meshes.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/coordinates/detail/mean_value_gradients.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/core/detail/simd_angle.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Mean value coordinates in space, for closed triangle meshes of any shape.
///
/// Ju, Schaefer, Warren, Mean value coordinates for closed triangular meshes (SIGGRAPH 2005), sec. 3: a face gives its
/// corners the weights w_k with Σ w_k (C_k − p) = m, m the integral of the unit vectors from p over the face's shadow on the
/// unit sphere; m = ½ Σ θ_e N_e over its edges, θ_e the angle an edge is seen under, N_e the unit normal of the plane through
/// p and it. Here m is taken in the face's own frame. With H the height of the face's plane above p, ρ_k the distance of
/// p's foot point to the edge opposite to corner k (positive inside), R_e the distance of p to the edge's line, g_e = θ_e/R_e,
/// h_k the altitude of corner k and ν_k the outward normal of the edge opposite to it, in the plane:
///
///   S = ½ Σ g_k ρ_k / H,   w_k = (S ρ_k + ½ H Σ_l g_l ν_k·ν_l) / h_k
///
/// which needs g only once an edge, and holds no difference of nearly equal numbers but S next to the plane of a face that
/// p does not face; there the sum is taken by the angles' differences (`beside_face`). On vertices, edges and faces the limits are
/// taken: barycentric weights.
///
///   range     sum to 1; may be negative where the cage is not convex, and outside
///   accuracy  1e-13 inside and near the cage (double), 1e-4 at worst for float; points farther than some diagonals are
///             computed one precision higher, where the platform has one
///   cost      O(#E + #F) a point: a square root and an angle an edge, a division a face, eight (sixteen) points together
template <Scalar T>
class MeanValueCoordinates<T, 3> {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 3;
    static constexpr bool has_extension = true;
    static constexpr bool closed_form = true;

    explicit MeanValueCoordinates(TriangleMesh<T> cage)
        : cage_(std::move(cage))
        , report_(check(cage_)) {
        if (report_.status != Status::ok) return;
        const auto bounds = bounds_of(cage_.vertices());
        tolerance_ = coincidence_tolerance(bounds);
        scale_ = unit_scale(bounds);
        origin_ = cage_[0];
        frame_ = detail::frame_of<T>(cage_, origin_, scale_);
        gradients_ = detail::MeanValueGradients<T, 3>(cage_);
    }

    /// Shells alone: interior_cells_not_supported where there are cells inside.
    explicit MeanValueCoordinates(const CellComplex<T, 3>& cage)
        : MeanValueCoordinates(cage.boundary()) {
        refuse_interior_cells(cage, report_);
    }

    const TriangleMesh<T>& cage() const noexcept { return cage_; }
    std::span<const Vec<T, 3>> handles() const noexcept { return cage_.vertices(); }
    const CageReport& cage_report() const noexcept { return report_; }

    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const Running& running = {}) const {
        return detail::evaluate_blocks<T>(report_, cage_.size(), {points, weights, states}, running,
                                          [&](std::size_t begin, std::size_t end) {
                                              std::vector<Lanes<T>> angles(frame_.edges.size());
                                              for (std::size_t b = begin; b < end; ++b)
                                                  evaluate_block(b, points, weights, states, angles.data());
                                          });
    }

    /// The gradients of all weights at a batch of points, by differentiating the formula.
    ///
    ///   points     as for `evaluate`; so are the states on entry and on return
    ///   gradients  out, row axis · #handles + handle: the derivative along the axis, per unit of length. For a point on the
    ///              boundary, where there are derivatives from one side only, that of a place 1e-6 diagonals inside
    ///   accuracy   double: 1e-9 of one over the diagonal in and next to the cage (2e-10 measured); float: that of rounding
    ///              them. Σ ∇w_i = 0 and Σ C_i ∇w_i = identity likewise; less far away. Nearer to an edge or vertex than
    ///              1e-6 diagonals gradients turn with the direction, on it they are those of one
    ///   cost       twice that of `evaluate` (float: five times, as it is computed in double); hundreds of times for a point on
    ///              the boundary, nearer to it than 1e-5 diagonals (double), or some diagonals away
    Evaluation evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                  std::span<PointState> states, const Running& running = {}) const {
        return detail::evaluate_blocks<T>(report_, 3 * cage_.size(), {points, gradients, states}, running,
                                          [&](std::size_t begin, std::size_t end) {
                                              gradients_.run(cage_, begin, end, points, gradients, states);
                                          });
    }

    Vec<T, 3> nearest_boundary(const Vec<T, 3>& p, std::span<T> row) const noexcept {
        return nearest_boundary_weights(cage_, p, row);
    }

private:
    using Simd = detail::Simd<T>;
    using Face = typename detail::MeshFrame<T>::Face;
    using Wide = std::conditional_t<std::is_same_v<T, float>, double, long double>;
    static constexpr std::size_t lanes = lane_count<T>;
    static constexpr T far_away = 16; // diagonals

    void evaluate_block(std::size_t b, BlockView<const T> points, BlockView<T> weights,
                        std::span<PointState> states, Lanes<T>* angles) const {
        const auto* const position = points.block(b);
        auto* const row = weights.block(b);
        const Simd zero(T(0)), one(T(1)), half(T(0.5));
        std::array<Simd, 3> p; // from the first vertex, in units about the diagonal
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = Simd(scale_) * (Simd::load(position[k]) - Simd(origin_[k]));
        const auto dot_p = [&p](const Vec<T, 3>& v) {
            return Simd(v[0]) * p[0] + (Simd(v[1]) * p[1] + Simd(v[2]) * p[2]);
        };
        const Simd least(std::numeric_limits<T>::min() * T(1e6));
        Simd special = zero; // set to one in lanes that need the careful way
        for (std::size_t e = 0; e < frame_.edges.size(); ++e) {
            const auto& edge = frame_.edges[e];
            const Simd x = Simd(edge.origin[0]) - p[0], y = Simd(edge.origin[1]) - p[1],
                       z = Simd(edge.origin[2]) - p[2];
            const Simd tx(edge.direction[0]), ty(edge.direction[1]), tz(edge.direction[2]),
                length(edge.length);
            const Simd begin = x * tx + (y * ty + z * tz), end = begin + length;
            const Simd cx = y * tz - z * ty, cy = z * tx - x * tz, cz = x * ty - y * tx;
            const Simd rr = max<T>(cx * cx + (cy * cy + cz * cz), least);
            const Simd r = sqrt(rr);
            (detail::angle<T>(r * length, rr + begin * end) / r).store(angles[e]);
            special = select<T>(Simd(far_away * far_away) < rr, one, special);
        }
        for (std::size_t i = 0; i < cage_.size(); ++i) zero.store(row[i]);
        const Simd near{T(near_plane)}, on{scale_ * tolerance_}, opposite{T(0.5)};
        for (const Face& face : frame_.faces) {
            const Simd height = Simd(face.offset) - dot_p(face.normal);
            std::array<Simd, 3> g, rho;
            Simd m = zero;
            for (std::size_t k = 0; k < 3; ++k) {
                g[k] = Simd::load(angles[face.edge[k]]);
                rho[k] = Simd(face.across_offset[k]) - dot_p(face.across[k]);
                m = m + g[k] * rho[k];
            }
            m = half * m;
            const Simd distance = abs<T>(height);
            const Simd inmost = min<T>(rho[0], min<T>(rho[1], rho[2]));
            special = select<T>((distance <= on) & (zero - on <= inmost), one, special);
            const auto beside = (distance < near) & (inmost < zero) & (m < opposite);
            const Simd s = m / select<T>(distance <= least, least, height);
            std::array<Simd, 3> w;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t l = (k + 1) % 3, n = (k + 2) % 3;
                const Simd bent = g[k] + (Simd(face.cosine[n]) * g[l] + Simd(face.cosine[l]) * g[n]);
                w[k] = Simd(face.inverse_altitude[k]) * (s * rho[k] + half * (height * bent));
            }
            Lanes<T> flags;
            select<T>(beside, one, zero).store(flags);
            bool any = false;
            for (const T flag : flags.v) any = any || flag != T(0);
            if (any) correct_lanes(face, flags, height, rho, g, w);
            for (std::size_t k = 0; k < 3; ++k)
                (Simd::load(row[face.corner[k]]) + w[k]).store(row[face.corner[k]]);
        }
        Simd sum = zero;
        for (std::size_t i = 0; i < cage_.size(); ++i) sum = sum + Simd::load(row[i]);
        special = select<T>(abs<T>(sum) <= zero, one, special);
        const Simd inverse = one / sum;
        for (std::size_t i = 0; i < cage_.size(); ++i) (Simd::load(row[i]) * inverse).store(row[i]);

        // The sum is positive inside and negative outside: of the faces behind each other the nearest counts most.
        Lanes<T> sums, specials;
        sum.store(sums);
        special.store(specials);
        const std::size_t first = b * lanes, used = std::min(lanes, points.points - first);
        for (std::size_t lane = 0; lane < used; ++lane) {
            PointState& state = states[first + lane];
            if (state == PointState::not_finite) continue;
            if (specials[lane] != T(0) || !is_finite(sums[lane])) {
                state =
                    evaluate_carefully({position[0][lane], position[1][lane], position[2][lane]}, row, lane);
            } else {
                state = sums[lane] > T(0) ? PointState::inside : PointState::outside;
            }
        }
    }

    /// Faces nearer to p's plane than this (in diagonals or half diagonals) and not faced by p lose too many digits.
    static constexpr double near_plane = sizeof(T) == 8 ? 5e-4 : 1e-3;

    /// The weights of a face in the lanes flagged.
    void correct_lanes(const Face& face, const Lanes<T>& flags, const Simd& height,
                       const std::array<Simd, 3>& rho, const std::array<Simd, 3>& g,
                       std::array<Simd, 3>& w) const noexcept {
        Lanes<T> heights;
        height.store(heights);
        std::array<Lanes<T>, 3> rhos, gs, ws;
        for (std::size_t k = 0; k < 3; ++k) {
            rho[k].store(rhos[k]);
            g[k].store(gs[k]);
            w[k].store(ws[k]);
        }
        std::array<double, 3> altitude, cosine;
        for (std::size_t k = 0; k < 3; ++k) {
            altitude[k] = 1 / double(face.inverse_altitude[k]);
            cosine[k] = double(face.cosine[k]);
        }
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            if (flags[lane] == T(0)) continue;
            const auto weights = detail::face_weights<double, double>(
                double(heights[lane]), {double(rhos[0][lane]), double(rhos[1][lane]), double(rhos[2][lane])},
                {double(gs[0][lane]), double(gs[1][lane]), double(gs[2][lane])}, altitude, cosine, true);
            for (std::size_t k = 0; k < 3; ++k) ws[k][lane] = static_cast<T>(weights[k]);
        }
        for (std::size_t k = 0; k < 3; ++k) w[k] = Simd::load(ws[k]);
    }

    /// One point the plain way: limits on the boundary, and one precision higher off it.
    PointState evaluate_carefully(const Vec<T, 3>& point, Lanes<T>* row, std::size_t lane) const {
        Vec<T, 3> place;
        const auto value = nearest_boundary_value(cage_, point, place);
        const auto q = vec_cast<double>(place) - vec_cast<double>(point);
        const double distance = detail::length(q);
        if (distance <= double(tolerance_)) {
            for (std::size_t i = 0; i < cage_.size(); ++i) row[i][lane] = T(0);
            for (std::size_t k = 0; k < 3; ++k) row[value.handle[k]][lane] = static_cast<T>(value.weight[k]);
            return PointState::on_boundary;
        }
        // Lengths relative to the distance, so that nothing overflows.
        const auto u_of = [&](std::size_t i) {
            Vec<Wide, 3> u;
            for (std::size_t k = 0; k < 3; ++k) u[k] = (Wide(cage_[i][k]) - Wide(point[k])) / Wide(distance);
            return u;
        };
        const auto length = [](const Vec<Wide, 3>& v) { return std::sqrt(dot(v, v)); };
        std::vector<Wide> w(cage_.size(), Wide(0));
        for (const auto& face : frame_.faces) {
            const auto& corners = face.corner;
            const std::array<Vec<Wide, 3>, 3> c{u_of(corners[0]), u_of(corners[1]), u_of(corners[2])};
            auto normal = cross(c[1] - c[0], c[2] - c[0]);
            const Wide area = length(normal);
            normal = (1 / area) * normal;
            std::array<Wide, 3> g, rho, altitude, cosine;
            std::array<Vec<Wide, 3>, 3> across;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto &a = c[(k + 1) % 3], &b = c[(k + 2) % 3];
                const auto along = b - a, over = cross(a, along);
                const Wide size = length(along), doubled = length(over);
                across[k] = (1 / size) * cross(along, normal);
                rho[k] = dot(across[k], a);
                altitude[k] = dot(across[k], a - c[k]);
                g[k] = doubled > 0 ? std::atan2(doubled, dot(a, b)) * size / doubled : size / dot(a, b);
            }
            for (std::size_t k = 0; k < 3; ++k) cosine[k] = dot(across[(k + 1) % 3], across[(k + 2) % 3]);
            const Wide height = dot(normal, c[0]);
            const Wide m = Wide(0.5) * (g[0] * rho[0] + g[1] * rho[1] + g[2] * rho[2]);
            const bool outside = std::min({rho[0], rho[1], rho[2]}) < 0;
            const bool beside = outside && std::fabs(height) < Wide(1e-2) * std::sqrt(area) && m < Wide(0.5);
            const auto weights = detail::face_weights<Wide, Wide>(height, rho, g, altitude, cosine, beside);
            for (std::size_t k = 0; k < 3; ++k) w[corners[k]] += weights[k];
        }
        Wide sum = 0;
        for (const Wide x : w) sum += x;
        if (!(std::fabs(sum) > 0)) return PointState::unreached;
        for (std::size_t i = 0; i < cage_.size(); ++i) {
            row[i][lane] = static_cast<T>(w[i] / sum);
            if (!is_finite(row[i][lane])) return PointState::unreached;
        }
        return sum > 0 && double(scale_) * distance < 1 ? PointState::inside : PointState::outside;
    }

    TriangleMesh<T> cage_;
    CageReport report_;
    detail::MeshFrame<T> frame_;
    detail::MeanValueGradients<T, 3> gradients_;
    T tolerance_ = 0;
    T scale_ = 1;
    Vec<T, 3> origin_{};
};

using MeanValueCoordinates3f = MeanValueCoordinates<float, 3>;
using MeanValueCoordinates3d = MeanValueCoordinates<double, 3>;

} // namespace cageform::inline CAGEFORM_ABI
