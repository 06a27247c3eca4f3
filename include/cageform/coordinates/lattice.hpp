// Free-form deformation by a lattice of spline control points in a box.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/detail/outside_distance.hpp>
#include <cageform/coordinates/lattice/box_around.hpp>
#include <cageform/coordinates/lattice/spline_axis.hpp>
#include <cageform/core/detail/simd.hpp>
#include <cageform/core/result.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Coordinates in a box with a lattice of control points as handles (Sederberg, Parry, Free-form deformation
/// of solid geometric models, SIGGRAPH 1986; B-splines: Griessmair, Purgathofer, Eurographics 1989). The
/// weights at the point o + A u of the box, u in [0, 1]^D, are
///
///     w_i = Π_k N_{i_k}(u_k)       control point i at rest: o + A g_i
///
/// with the splines N of each axis and their Greville abscissae g, so Σ w = 1 and Σ w H = p. Handles are
/// ordered with the first axis fastest.
///
///   range     [0, 1] in the box. Outside, the functions are extended linearly, with both signs
///   smooth    C^(degree − 1) in the box, at most C¹ at its faces
///   falloff   outside, displacements fade to zero at this distance from the box, C¹ at both ends; C⁰ beyond
///             edges of the box if its axes are not orthogonal. D + 1 frame handles, o and o + A_k, then
///             follow the control points, and poses must leave them at rest. BindOptions::falloff fades by
///             the same distance without frame handles; with both, points fade twice
///   zeros     all but (degree + 1)^D weights in the box are exactly zero
///   cost      O(#handles) a point, to write the weights
///   faults    lattice_degree, lattice_knots, frame_not_finite, frame_flat (the axis depends on the others),
///             falloff_negative; too_many_handles above 2^24
template <Scalar T, std::size_t D>
    requires(D == 2 || D == 3)
class LatticeCoordinates {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;
    static constexpr bool has_extension = true;
    static constexpr bool closed_form = true;
    static constexpr bool local = true;
    static constexpr std::size_t most_handles = std::size_t{1} << 24;

    /// Makes a lattice in `box`, the image of [0, 1]^D.
    ///
    ///   falloff  the distance at which displacements are zero, in the units of the box; 0: no falloff
    explicit LatticeCoordinates(const std::array<LatticeAxis, D>& axes, const Transform<T, D>& box,
                                T falloff = 0)
        : box_(box)
        , falloff_(falloff) {
        const Status status = detail::guard_memory([&] { prepare(axes); });
        if (status != Status::ok) report_ = {status, {}};
    }

    std::span<const Vec<T, D>> handles() const noexcept { return handles_; }
    const CageReport& cage_report() const noexcept { return report_; }
    /// Returns the number of frame handles, the last handles, which must stay at rest.
    std::size_t frame_handles() const noexcept {
        return handles_.size() - (std::min)(points_, handles_.size());
    }
    const Transform<T, D>& box() const noexcept { return box_; }
    /// Returns the number of control points along an axis.
    std::size_t points(std::size_t axis) const noexcept { return axes_[axis].points(); }
    /// Returns the Greville abscissa of control point i of an axis, its position at rest, in [0, 1].
    double greville(std::size_t axis, std::size_t i) const noexcept { return axes_[axis].greville(i); }

    /// Returns the knots of an axis in [0, 1]; #points + degree + 1.
    std::span<const double> knots(std::size_t axis) const noexcept { return axes_[axis].knots(); }

    /// Returns the control points within `layers` layers of a face of the box, ascending. If poses leave them
    /// at rest, displacements vanish at the faces to order `layers`.
    std::vector<std::uint32_t> frozen_handles(std::size_t layers) const {
        std::vector<std::uint32_t> list;
        for (std::size_t n = 0; n < points_ && n < handles_.size(); ++n) {
            std::size_t left = n;
            bool is_frozen = false;
            for (const auto& axis : axes_) {
                const std::size_t i = left % axis.points();
                left /= axis.points();
                is_frozen = is_frozen || i < layers || i + layers >= axis.points();
            }
            if (is_frozen) list.push_back(std::uint32_t(n));
        }
        return list;
    }

    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const Running& running = {}) const {
        return detail::evaluate_blocks<T>(report_, handles_.size(), {points, weights, states}, running,
                                          [&](std::size_t begin, std::size_t end) {
                                              Scratch scratch(*this);
                                              for (std::size_t b = begin; b < end; ++b) {
                                                  evaluate_axes(b, points, states, false, scratch);
                                                  multiply(functions_of(scratch.value), weights.block(b));
                                                  apply_falloff(scratch, weights.block(b));
                                              }
                                          });
    }

    /// Computes the gradients of all weights.
    ///
    ///   points, states   as for `evaluate`
    ///   gradients        out, row axis · #handles + handle: the derivative along the axis, per unit of
    ///                    length. At a knot of degree 1: the slope of the span above
    Evaluation evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                  std::span<PointState> states, const Running& running = {}) const {
        return detail::evaluate_blocks<T>(report_, D * handles_.size(), {points, gradients, states}, running,
                                          [&](std::size_t begin, std::size_t end) {
                                              Scratch scratch(*this);
                                              scratch.rows.resize((D + 1) * handles_.size());
                                              for (std::size_t b = begin; b < end; ++b) {
                                                  evaluate_axes(b, points, states, true, scratch);
                                                  differentiate(scratch, gradients.block(b));
                                              }
                                          });
    }

    /// Returns the nearest point of the box, measured along its axes; for a point inside, the foot on the
    /// nearest face.
    Vec<T, D> nearest_boundary(const Vec<T, D>& p, std::span<T> row) const noexcept {
        auto u = in_box(p);
        bool is_inside = true;
        for (std::size_t k = 0; k < D; ++k) {
            is_inside = is_inside && u[k] > 0 && u[k] < 1;
            u[k] = std::clamp(u[k], T(0), T(1));
        }
        if (is_inside) {
            std::size_t nearest = 0;
            double least = (std::numeric_limits<double>::max)();
            for (std::size_t k = 0; k < D; ++k) {
                const double distance =
                    double((std::min)(u[k], 1 - u[k])) / length((1 / scale_) * vec_cast<double>(inverse_[k]));
                if (!(distance < least)) continue;
                least = distance;
                nearest = k;
            }
            u[nearest] = u[nearest] < T(0.5) ? T(0) : T(1);
        }
        std::fill(row.begin(), row.end(), T(0));
        std::array<Values, D> value;
        std::array<std::size_t, D> first{};
        Values slope;
        for (std::size_t k = 0; k < D; ++k) first[k] = axes_[k].evaluate(u[k], value[k], slope);
        std::array<std::size_t, D> at{};
        for (;;) {
            T weight = 1;
            std::size_t handle = 0;
            for (std::size_t k = D; k-- > 0;) {
                weight *= value[k][at[k]];
                handle = handle * axes_[k].points() + first[k] + at[k];
            }
            row[handle] = weight;
            std::size_t k = 0;
            while (k < D && ++at[k] > axes_[k].degree()) at[k++] = 0;
            if (k == D) break;
        }
        return box_.translation + box_.map_vector(u);
    }
    /// Returns the distance of an outside point from `nearest_boundary`, and its gradient.
    detail::OutsideDistance<D> distance_outside(const Vec<T, D>& p) const noexcept {
        auto u = in_box(p);
        (void)state_at(u);
        return distance_at(u);
    }

private:
    using Simd = detail::Simd<T>;
    using Values = typename detail::SplineAxis<T>::Values;
    using Fault = CageFaultKind;

    /// The functions of the axes at the points of a block.
    struct Scratch {
        explicit Scratch(const LatticeCoordinates& lattice) {
            for (std::size_t k = 0; k < D; ++k) {
                value[k].resize(lattice.axes_[k].points());
                slope[k].resize(lattice.axes_[k].points());
                Simd(T(0)).store(kept_gradient[k]);
            }
            Simd(T(1)).store(kept);
        }
        Lanes<T> kept;                                     ///< the factor of displacements by the falloff
        std::array<Lanes<T>, D> place, kept_gradient;      ///< u and ∇kept
        std::vector<Lanes<T>> rows;                        ///< weights, then their derivatives by u
        std::array<std::vector<Lanes<T>>, D> value, slope; ///< by axis and control point of the axis
    };

    static double length(const Vec<double, D>& v) noexcept { return std::sqrt(dot(v, v)); }
    Vec<T, D> in_box(const Vec<T, D>& p) const noexcept {
        const auto from_origin = p - box_.translation;
        Vec<T, D> u{};
        for (std::size_t k = 0; k < D; ++k) u[k] = dot(inverse_[k], from_origin);
        return u;
    }

    void prepare(const std::array<LatticeAxis, D>& axes) {
        double handles = 1;
        for (std::size_t k = 0; k < D; ++k) {
            if (const auto fault = detail::SplineAxis<T>::fault_of(axes[k], k))
                report_.add(fault->kind, fault->a, fault->b);
            if (!is_finite(box_.columns[k])) report_.add(Fault::frame_not_finite, k);
            handles *= double(axes[k].points);
        }
        if (!is_finite(box_.translation)) report_.add(Fault::frame_not_finite, D);
        if (!(falloff_ >= 0) || !(falloff_ <= (std::numeric_limits<T>::max)()))
            report_.add(Fault::falloff_negative);
        if (report_.status == Status::ok && handles > double(most_handles))
            report_.status = Status::too_many_handles;
        if (report_.status == Status::ok) set_inverse();
        if (report_.status != Status::ok) return;
        points_ = std::size_t(handles);
        for (std::size_t k = 0; k < D; ++k) axes_[k] = detail::SplineAxis<T>(axes[k]);
        handles_.reserve(points_ + D + 1);
        for (std::size_t n = 0; n < points_; ++n) {
            Vec<double, D> p = vec_cast<double>(box_.translation);
            std::size_t left = n;
            for (std::size_t k = 0; k < D; ++k) {
                const double g = axes_[k].greville(left % axes_[k].points());
                left /= axes_[k].points();
                p = p + g * vec_cast<double>(box_.columns[k]);
            }
            handles_.push_back(vec_cast<T>(p));
        }
        if (falloff_ > 0) {
            handles_.push_back(box_.translation);
            for (const auto& column : box_.columns) handles_.push_back(box_.translation + column);
        }
        if (std::all_of(handles_.begin(), handles_.end(), [](const auto& h) { return is_finite(h); })) return;
        report_.add(Fault::frame_not_finite, D);
        handles_.clear();
    }
    /// Computes A⁻¹ in double and the tolerances of faces. Refuses an axis whose component orthogonal to the
    /// others is 0 to rounding.
    void set_inverse() {
        T largest = 0;
        for (const auto& column : box_.columns) {
            for (const T x : column.v) largest = (std::max)(largest, std::fabs(x));
        }
        int exponent = 0;
        std::frexp(double(largest), &exponent);
        scale_ = std::ldexp(1.0, std::clamp(-exponent, -1000, 1000));
        std::array<Vec<double, D>, D> columns;
        for (std::size_t k = 0; k < D; ++k) columns[k] = scale_ * vec_cast<double>(box_.columns[k]);
        std::array<Vec<double, D>, D> across; // orthogonal to the other axes
        if constexpr (D == 2) {
            across[0] = {-columns[1][1], columns[1][0]};
            across[1] = {-columns[0][1], columns[0][0]};
        } else {
            for (std::size_t k = 0; k < D; ++k) across[k] = cross(columns[(k + 1) % 3], columns[(k + 2) % 3]);
        }
        const auto origin = scale_ * vec_cast<double>(box_.translation);
        auto corner = origin;
        for (const auto& column : columns) corner = corner + column;
        double farthest = 0;
        for (std::size_t k = 0; k < D; ++k)
            farthest = (std::max)({farthest, length(columns[k]), std::fabs(origin[k]), std::fabs(corner[k])});
        const double tolerance = 8 * double(epsilon<T>) * farthest;
        for (std::size_t k = 0; k < D; ++k) {
            const double size = length(across[k]), along = dot(across[k], columns[k]);
            inverse_[k] = vec_cast<T>((scale_ / along) * across[k]);
            if (!(std::fabs(along) > tolerance * size) || !is_finite(inverse_[k]))
                return report_.add(Fault::frame_flat, k);
            on_face_[k] = static_cast<T>(tolerance * size / std::fabs(along));
        }
    }

    /// Sets the states of a block's points, the functions of each axis, and the falloff.
    ///
    ///   sloped   whether the slopes of the functions are wanted
    void evaluate_axes(std::size_t b, BlockView<const T> points, std::span<PointState> states, bool sloped,
                       Scratch& scratch) const noexcept {
        const bool all_inside = place(b, points, states, scratch);
        for (std::size_t k = 0; k < D; ++k)
            axes_[k].evaluate(scratch.place[k], sloped || !all_inside, scratch.value[k].data(),
                              scratch.slope[k].data());
        if (!(falloff_ > 0)) return;
        Simd(T(1)).store(scratch.kept);
        for (auto& lanes : scratch.kept_gradient) Simd(T(0)).store(lanes);
        for (std::size_t lane = 0; lane < lane_count<T> && !all_inside; ++lane) set_falloff(lane, scratch);
    }
    /// Sets the positions u and the states of a block's points. Returns whether all points are inside, none
    /// of them on a face.
    bool place(std::size_t b, BlockView<const T> points, std::span<PointState> states,
               Scratch& scratch) const noexcept {
        std::array<Simd, D> from_origin;
        for (std::size_t k = 0; k < D; ++k)
            from_origin[k] = Simd::load(points.block(b)[k]) - Simd(box_.translation[k]);
        Simd inside(T(1));
        for (std::size_t k = 0; k < D; ++k) {
            Simd u = Simd(inverse_[k][0]) * from_origin[0];
            for (std::size_t axis = 1; axis < D; ++axis) u += Simd(inverse_[k][axis]) * from_origin[axis];
            u.store(scratch.place[k]);
            const auto is_inside = (Simd(on_face_[k]) < u) & (u < Simd(1 - on_face_[k]));
            inside = detail::select<T>(is_inside, inside, Simd(T(0)));
        }
        Lanes<T> is_inside;
        inside.store(is_inside);
        const std::size_t first = b * lane_count<T>;
        std::size_t count = 0;
        for (std::size_t lane = 0; lane < lane_count<T>; ++lane) {
            PointState ignored = PointState::not_finite;
            PointState& state = first + lane < points.points ? states[first + lane] : ignored;
            if (is_inside[lane] != 0 && state != PointState::not_finite) {
                state = PointState::inside;
                ++count;
                continue;
            }
            Vec<T, D> u{};
            for (std::size_t k = 0; k < D; ++k) u[k] = scratch.place[k][lane];
            if (state != PointState::not_finite) state = state_at(u);
            const bool counts = state != PointState::not_finite && state != PointState::unreached;
            for (std::size_t k = 0; k < D; ++k) scratch.place[k][lane] = counts ? u[k] : T(0);
        }
        return count == lane_count<T>;
    }
    /// Returns the state of a position in the box. Snaps it to faces within the tolerance.
    PointState state_at(Vec<T, D>& u) const noexcept {
        // Beyond this distance the spacing of floating-point numbers exceeds an eighth of the box.
        constexpr auto farthest = T(sizeof(T) == 8 ? 1e15 : 1e6);
        auto state = PointState::inside;
        for (std::size_t k = 0; k < D; ++k) {
            if (!(std::fabs(u[k]) <= farthest)) return PointState::unreached;
            for (const T face : {T(0), T(1)}) {
                if (!(std::fabs(u[k] - face) <= on_face_[k])) continue;
                u[k] = face;
                if (state == PointState::inside) state = PointState::on_boundary;
            }
            if (u[k] < 0 || u[k] > 1) state = PointState::outside;
        }
        return state;
    }
    /// Returns the distance |A (u − c)| of a position u from the nearest position c in the box, measured
    /// along the axes, and its gradient. c_k is constant where u_k is outside [0, 1].
    detail::OutsideDistance<D> distance_at(const Vec<T, D>& u) const noexcept {
        Vec<T, D> beyond{};
        for (std::size_t k = 0; k < D; ++k) beyond[k] = u[k] - std::clamp(u[k], T(0), T(1));
        const auto off = box_.map_vector(beyond);
        const auto distance = static_cast<T>(length(scale_ * vec_cast<double>(off)) / scale_);
        detail::OutsideDistance<D> result;
        if (!(distance > 0)) return result;
        result.distance = double(distance);
        for (std::size_t k = 0; k < D; ++k) {
            if (beyond[k] == 0) continue;
            T along = 0;
            for (std::size_t axis = 0; axis < D; ++axis)
                along += box_.columns[k][axis] * (off[axis] / distance);
            result.gradient = result.gradient + double(along) * vec_cast<double>(inverse_[k]);
        }
        return result;
    }
    /// Sets the falloff at a point.
    void set_falloff(std::size_t lane, Scratch& scratch) const noexcept {
        Vec<T, D> u{};
        for (std::size_t k = 0; k < D; ++k) u[k] = scratch.place[k][lane];
        const auto from_box = distance_at(u);
        if (!(from_box.distance > 0)) return;
        const T t = (std::min)(static_cast<T>(from_box.distance) / falloff_, T(1));
        scratch.kept[lane] = 1 - t * t * (3 - 2 * t);
        const double rate = double(-6 * t * (1 - t) / falloff_);
        for (std::size_t axis = 0; axis < D; ++axis)
            scratch.kept_gradient[axis][lane] = static_cast<T>(rate * from_box.gradient[axis]);
    }

    using Functions = std::array<const std::vector<Lanes<T>>*, D>; ///< by axis
    static Functions functions_of(const std::array<std::vector<Lanes<T>>, D>& axes) noexcept {
        Functions of;
        for (std::size_t k = 0; k < D; ++k) of[k] = &axes[k];
        return of;
    }
    /// Multiplies the functions of the axes for every control point.
    static void multiply(const Functions& of, Lanes<T>* row) noexcept {
        std::size_t handle = 0;
        const auto add_rows = [&](const Simd& factor) {
            for (const auto& y : *of[1]) {
                const Simd both = factor * Simd::load(y);
                for (const auto& x : *of[0]) (both * Simd::load(x)).store(row[handle++]);
            }
        };
        if constexpr (D == 2) {
            add_rows(Simd(T(1)));
        } else {
            for (const auto& z : *of[2]) add_rows(Simd::load(z));
        }
    }
    /// Applies the falloff to weights, and sets those of the frame handles.
    void apply_falloff(const Scratch& scratch, Lanes<T>* row) const noexcept {
        if (!(falloff_ > 0)) return;
        const Simd kept = Simd::load(scratch.kept), lost = Simd(T(1)) - kept;
        for (std::size_t n = 0; n < points_; ++n) (kept * Simd::load(row[n])).store(row[n]);
        Simd rest(T(1));
        for (std::size_t k = 0; k < D; ++k) {
            const Simd u = Simd::load(scratch.place[k]);
            rest -= u;
            (lost * u).store(row[points_ + 1 + k]);
        }
        (lost * rest).store(row[points_]);
    }
    void differentiate(Scratch& scratch, Lanes<T>* gradients) const noexcept {
        const std::size_t count = handles_.size();
        Lanes<T>* const weights = scratch.rows.data();
        multiply(functions_of(scratch.value), weights);
        for (std::size_t k = 0; k < D; ++k) {
            auto of = functions_of(scratch.value);
            of[k] = &scratch.slope[k];
            multiply(of, scratch.rows.data() + (k + 1) * count);
        }
        const Simd kept = Simd::load(scratch.kept), lost = Simd(T(1)) - kept;
        for (std::size_t axis = 0; axis < D; ++axis) {
            Lanes<T>* const to = gradients + axis * count;
            const Simd change = Simd::load(scratch.kept_gradient[axis]);
            for (std::size_t n = 0; n < points_; ++n) {
                Simd sum(T(0));
                for (std::size_t k = 0; k < D; ++k)
                    sum += Simd(inverse_[k][axis]) * Simd::load(scratch.rows[(k + 1) * count + n]);
                (kept * sum + change * Simd::load(weights[n])).store(to[n]);
            }
            if (!(falloff_ > 0)) continue;
            Simd rest(T(1)), rest_slope(T(0));
            for (std::size_t k = 0; k < D; ++k) {
                const Simd u = Simd::load(scratch.place[k]), slope(inverse_[k][axis]);
                rest -= u;
                rest_slope -= slope;
                (lost * slope - change * u).store(to[points_ + 1 + k]);
            }
            (lost * rest_slope - change * rest).store(to[points_]);
        }
    }

    Transform<T, D> box_;
    T falloff_;
    std::array<detail::SplineAxis<T>, D> axes_;
    std::array<Vec<T, D>, D> inverse_{}; ///< the rows of A⁻¹
    std::array<T, D> on_face_{};         ///< the tolerance in u
    double scale_ = 1;                   ///< a power of two that makes the box about 1 in size
    std::size_t points_ = 0;             ///< number of control points; frame handles follow
    std::vector<Vec<T, D>> handles_;
    CageReport report_;
};

} // namespace cageform::inline CAGEFORM_ABI
