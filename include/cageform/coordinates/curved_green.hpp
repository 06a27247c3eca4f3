// Green coordinates for cages of Bézier curves in the plane. Deformations preserve angles.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/curved_green/block.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/detail/outside_distance.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Green coordinates in the plane for cages of Bézier curves, in Cauchy's form. With z = x + iy, edges e of
/// degree 1 to 3 at rest, and their posed curves F of degree m ≤ 5,
///
///     f(z) = 1/2πi Σ_edges ∫ F(t) e'(t)/(e(t) − z) dt = Σ c_k(z) P'_k
///
/// where P' are the posed control points. Liu, Liu, Fu, arXiv 2408.06831; for straight edges at rest: Michel,
/// Thiery, Polynomial 2D Green coordinates, 2023.
///
///   handles    first the control points of the edges, degree-elevated to m, around each loop, with shared
///              ends once. Then one vector per leg of the control polygon: the normal, with the leg's length.
///              The weight of a control point is Re c_k, that of a leg a partial sum of Im c_k.
///              `pose_handles` computes the vectors of a pose
///   range      the weights of control points sum to 1. Weights have both signs
///   poses      holomorphic inside for every pose: angles are preserved where the derivative is not zero.
///              Similarities are reproduced; other affine maps and reflections are not
///   boundary   the limits from inside. They do not interpolate the posed curve
///   outside    continued to first order across the nearest point of the cage. Posed figures jump where the
///              nearest point changes to another edge. Near an outward cusp inside an edge, weights grow like
///              1/|e'|, or the point is unreached: split the edge there (warning edge_has_cusp)
///   accuracy   double: 1e-14, also next to edges and ends; 2e-16/√δ at distance δ from a cusp inside an
///              edge. float: 1e-6
///   disk       with the option `disk`, poses are harmonic in the disk, not holomorphic. This is our own
///              variant. On the circle and outside, the continuation is used
///   cost       O(#edges) a point: 16 reciprocals for a far edge; the roots of e(s) = z and a logarithm of
///              each root for a near edge
///   faults     those of the cage; curve_degree (m > 5, m below the degree at rest, or not one degree per
///              edge: CageFault::a is then the number of degrees); disk_too_small
///   gradients  as accurate as the weights. At a vertex: the gradient 1e-6 diagonals inside
template <Scalar T>
class CurvedGreenCoordinates {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 2;
    static constexpr bool has_extension = true;
    static constexpr bool closed_form = true;

    explicit CurvedGreenCoordinates(CurvedPolygon<T> cage, const CurvedGreenOptions<T>& options = {})
        : cage_(std::move(cage)) {
        const Status status = detail::guard_memory([&] { prepare(options); });
        if (status != Status::ok) report_ = {status, {}};
    }

    const CurvedPolygon<T>& cage() const noexcept { return cage_; }
    std::span<const Vec<T, 2>> handles() const noexcept { return tables_.handles; }
    std::span<const HandleKind> handle_kinds() const noexcept { return tables_.kinds; }
    std::span<const HandleFace<2>> handle_faces() const noexcept { return tables_.faces; }
    const CageReport& cage_report() const noexcept { return report_; }

    /// See CageCoordinates.
    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const Running& running = {}) const;
    /// See GradientCoordinates. On the boundary the limits from inside are returned.
    Evaluation evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                  std::span<PointState> states, const Running& running = {}) const;
    /// Returns the nearest boundary point and its weights, the limits from inside. May throw std::bad_alloc.
    Vec<T, 2> nearest_boundary(const Vec<T, 2>& p, std::span<T> row) const;
    /// See CageCoordinates.
    detail::OutsideDistance<2> distance_outside(const Vec<T, 2>& p) const noexcept;

private:
    using ComplexNumber = detail::ComplexNumber;

    void prepare(const CurvedGreenOptions<T>& options);
    void set_disk(const CurvedGreenDisk<T>& disk) {
        const auto centre = vec_cast<double>(disk.centre);
        const double radius = double(disk.radius);
        if (!is_finite(centre) || !(radius > 0) || !is_finite(radius))
            return report_.add(CageFaultKind::disk_too_small);
        for (std::size_t i = 0; i < tables_.points(); ++i) {
            const auto off = vec_cast<double>(tables_.handles[i]) - centre;
            if (!(std::hypot(off[0], off[1]) <= radius * (1 + 4 * double(epsilon<T>))))
                report_.add(CageFaultKind::disk_too_small, i);
        }
        tables_.disk_centre = detail::to_number(tables_.scale * centre);
        tables_.disk_radius = tables_.scale * radius;
    }

    template <bool gradients>
    Evaluation evaluate_rows(const Batch<T>& batch, const Running& running) const {
        constexpr std::size_t lanes = detail::CurvedBlock<T>::lanes;
        const std::size_t rows = (gradients ? 2 : 1) * tables_.handles.size();
        return detail::evaluate_blocks(
            report_, rows, batch, running, [&](std::size_t begin, std::size_t end) {
                detail::CurvedBlock<T> block(tables_);
                std::vector<Lanes<double>> values(sizeof(T) == 8 ? 0 : rows);
                std::array<PointState, lanes> states;
                for (std::size_t b = begin; b < end; ++b) {
                    for (std::size_t first = 0; first < lane_count<T>; first += lanes) {
                        for (std::size_t lane = 0; lane < lanes; ++lane) {
                            const std::size_t i = b * lane_count<T> + first + lane;
                            const bool counts =
                                i < batch.points.points && batch.states[i] != PointState::not_finite;
                            states[lane] = counts ? PointState::unreached : PointState::not_finite;
                            block.x[lane] =
                                counts ? tables_.scale * double(batch.points(i, 0)) : tables_.middle[0];
                            block.y[lane] =
                                counts ? tables_.scale * double(batch.points(i, 1)) : tables_.middle[1];
                        }
                        Lanes<double>* out = values.data();
                        if constexpr (sizeof(T) == 8) out = batch.rows.block(b);
                        evaluate_block<gradients>(block, out, states, tables_.tolerance);
                        finish_rows<gradients>(out, rows, states);
                        if constexpr (sizeof(T) == 4) {
                            for (std::size_t row = 0; row < rows; ++row)
                                detail::store_lanes<double, T>(detail::Simd<double>::load(out[row]),
                                                               batch.rows.block(b)[row], first);
                        }
                        for (std::size_t lane = 0; lane < lanes; ++lane) {
                            const std::size_t i = b * lane_count<T> + first + lane;
                            if (i < batch.points.points) batch.states[i] = states[lane];
                        }
                    }
                }
            });
    }
    /// Scales gradients. Marks points whose weights overflow the scalar as unreached.
    template <bool gradients>
    void finish_rows(Lanes<double>* rows, std::size_t count, std::span<PointState> states) const noexcept {
        using X = detail::Simd<double>;
        X sum(0.0);
        for (std::size_t row = 0; row < count; ++row) {
            const X value = X(gradients ? tables_.scale : 1.0) * X::load(rows[row]);
            if constexpr (gradients) value.store(rows[row]);
            sum += detail::abs(value);
        }
        Lanes<double> size;
        sum.store(size);
        for (std::size_t lane = 0; lane < states.size(); ++lane) {
            if (states[lane] != PointState::not_finite && !is_finite(static_cast<T>(size[lane])))
                states[lane] = PointState::unreached;
        }
    }

    /// Evaluates a block. On entry a state is unreached, or not_finite if the point is skipped.
    template <bool gradients>
    void evaluate_block(detail::CurvedBlock<T>& block, Lanes<double>* rows, std::span<PointState> states,
                        double tolerance) const {
        const detail::CurvedPoint<T> point(tables_);
        const std::size_t count = (gradients ? 2 : 1) * tables_.handles.size(),
                          vertices = tables_.vertices.size();
        // Beyond this distance the integrals change by less than a rounding error of the continuation.
        constexpr double farthest = sizeof(T) == 8 ? 0x1p24 : 0x1p12;
        std::array<ComplexNumber, detail::CurvedBlock<T>::lanes> place{};
        std::array<std::size_t, detail::CurvedBlock<T>::lanes> vertex{};
        for (std::size_t lane = 0; lane < states.size(); ++lane) {
            place[lane] = {block.x[lane], block.y[lane]};
            block.x[lane] =
                std::clamp(block.x[lane], tables_.middle[0] - farthest, tables_.middle[0] + farthest);
            block.y[lane] =
                std::clamp(block.y[lane], tables_.middle[1] - farthest, tables_.middle[1] + farthest);
            if constexpr (gradients) {
                vertex[lane] = point.vertex_at(place[lane]);
                if (vertex[lane] == vertices) continue;
                const ComplexNumber at = inside_of(vertex[lane]);
                block.x[lane] = at.re;
                block.y[lane] = at.im;
            }
        }
        block.template integrate<gradients>(rows);
        if constexpr (!gradients) vertex = block.vertex;
        for (std::size_t lane = 0; lane < states.size(); ++lane) {
            if (states[lane] == PointState::not_finite) continue;
            const detail::CurvedRow to{rows, lane, count / 2};
            const ComplexNumber at{block.x[lane], block.y[lane]};
            const Where where{place[lane], vertex[lane] < vertices, block.winding[lane], block.touch[lane]};
            if (tables_.disk_radius > 0) {
                const ComplexNumber& seen = gradients && where.is_vertex ? at : where.z;
                if (!(size(seen - tables_.disk_centre) < tables_.disk_radius)) {
                    for (std::size_t row = 0; row < count; ++row) rows[row][lane] = 0;
                    const double distance = add_nearest<gradients>(where.z, to);
                    states[lane] = distance <= tolerance ? PointState::on_boundary : PointState::outside;
                    continue;
                }
                point.template subtract_mirrored<gradients>(at, to);
            }
            if (!gradients && where.is_vertex)
                to.add(tables_.vertices[vertex[lane]].handle, 1 - where.winding);
            states[lane] = complete<gradients>(where, to, tolerance);
        }
    }
    /// The location of a point, computed from the integrals.
    struct Where {
        ComplexNumber z;
        bool is_vertex;
        double winding;
        detail::EdgeTouch touch;
    };
    /// Adds the jump on the boundary or the continuation outside. Returns the state.
    template <bool gradients>
    PointState complete(const Where& where, const detail::CurvedRow& to, double tolerance) const noexcept {
        if (where.is_vertex && !gradients) return PointState::on_boundary;
        if (where.touch.distance <= tolerance) {
            if (!(where.winding > 0.5))
                detail::CurvedPoint<T>(tables_).template add_jump<gradients>(tables_.edges[where.touch.edge],
                                                                             where.touch.s, to);
            return PointState::on_boundary;
        }
        if (where.is_vertex) return PointState::on_boundary;
        if (where.winding > 0.5) return PointState::inside;
        (void)add_nearest<gradients>(where.z, to);
        return PointState::outside;
    }
    /// Adds the continuation across the nearest boundary point. Returns the distance from that point.
    template <bool gradients>
    double add_nearest(const ComplexNumber& z, const detail::CurvedRow& to) const noexcept {
        const auto nearest = nearest_of({z.re, z.im});
        const auto& edge = tables_.edges[nearest.edge];
        const detail::CurveContinuation continuation(edge, nearest.place.t, z);
        detail::CurvedPoint<T>(tables_).template add_continuation<gradients>(edge, continuation, to);
        return nearest.place.distance;
    }

    /// Returns the point 1e-6 diagonals from a vertex on the bisector of its corner.
    ComplexNumber inside_of(std::size_t vertex) const noexcept {
        const auto& [at, before, after, handle] = tables_.vertices[vertex];
        const auto leaving = [](const detail::CurvedEdge::End& end) {
            const ComplexNumber q = end.away.c[end.vanishing];
            return (1 / size(q)) * q;
        };
        const ComplexNumber next = leaving(tables_.edges[after].end[0]),
                            last = leaving(tables_.edges[before].end[1]);
        const ComplexNumber turned = last * conjugate(next);
        double angle = std::atan2(turned.im, turned.re); // from the next edge to the one before
        if (angle <= 0) angle += 2 * std::numbers::pi;
        const double step = 1e-6 * tables_.diagonal;
        return at + step * (next * ComplexNumber{std::cos(angle / 2), std::sin(angle / 2)});
    }

    struct Nearest {
        std::size_t edge = 0;
        detail::NearestPlace place;
    };
    /// Finds the nearest point of all edges. Of several edges at the same distance it takes the one whose
    /// tangent the point lies farthest beyond, then the first.
    Nearest nearest_of(const Vec<double, 2>& q) const noexcept {
        Nearest best;
        double farthest_beyond = 0;
        for (std::size_t e = 0; e < tables_.edges.size(); ++e) {
            const auto& curve = tables_.edges[e].curve;
            const double rounding =
                64 * epsilon<double> *
                (1 + (std::max)(std::fabs(tables_.middle[0]), std::fabs(tables_.middle[1])) +
                 (best.place.distance < 1e300 ? best.place.distance : 0));
            const auto place = detail::nearest_place(curve, q, best.place.distance + rounding);
            if (!(place.distance <= best.place.distance + rounding)) continue;
            const double beyond = beyond_tangent(tables_.edges[e], place.t, q);
            if (place.distance < best.place.distance - rounding || beyond > farthest_beyond + rounding) {
                best = {e, place};
                farthest_beyond = beyond;
            }
            best.place.distance = (std::min)(best.place.distance, place.distance);
        }
        return best;
    }
    /// Returns the distance of a point to the right of the tangent of an edge at t.
    static double beyond_tangent(const detail::CurvedEdge& edge, double t, const Vec<double, 2>& q) noexcept {
        auto along = edge.curve.slope().at(t);
        if (t == 0) along = edge.curve.leaving();
        if (t == 1) along = -1.0 * edge.curve.reversed().leaving();
        return cross(q - edge.curve.at(t), along) / detail::length(along);
    }

    CurvedPolygon<T> cage_;
    CageReport report_;
    detail::CurvedTables<T> tables_;
};

template <Scalar T>
CurvedGreenCoordinates(CurvedPolygon<T>) -> CurvedGreenCoordinates<T>;

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/coordinates/curved_green/evaluation.impl.hpp>
#endif
