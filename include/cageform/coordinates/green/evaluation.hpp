// Evaluation of Green coordinates in 2D and 3D. The formulas are in plane.hpp and space.hpp.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/checked_cage.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/detail/fold_rows.hpp>
#include <cageform/coordinates/green/frame.hpp>
#include <cageform/core/detail/face_handles.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The analytic continuation across a facet, which expresses p by the facet's corners and its vector handle.
/// α_k is linear: 1 at corner k, 0 at other corners, constant along the normal. β is the height above the
/// facet; `size` is the length of the handle.
///
///     Σ α_k C_k + (β/size) size n = p,   Σ α_k = 1
template <std::size_t D>
struct FacetContinuation {
    std::array<Vec<double, D>, D> hat; ///< ∇α_k
    Vec<double, D> across;             ///< n/size
    Corners<D> corner;

    explicit FacetContinuation(const Corners<D>& c) noexcept
        : across(outward_normal(c))
        , corner(c) {
        if constexpr (D == 2) {
            const auto e = c[1] - c[0];
            hat[1] = (1 / dot(e, e)) * e;
            hat[0] = -1.0 * hat[1];
            across = (1 / length(e)) * across;
        } else {
            const auto n = cross(c[1] - c[0], c[2] - c[0]);
            for (std::size_t k = 0; k < 3; ++k)
                hat[k] = (1 / dot(n, n)) * cross(n, c[(k + 2) % 3] - c[(k + 1) % 3]);
            across = (1 / std::sqrt(length(n) / 2)) * across;
        }
    }
    /// Returns α and β/size at p, computed relative to the nearest corner.
    std::array<double, D + 1> at(const Vec<double, D>& p) const noexcept {
        std::size_t nearest = 0;
        for (std::size_t k = 1; k < D; ++k) {
            if (length(p - corner[k]) < length(p - corner[nearest])) nearest = k;
        }
        const auto away = p - corner[nearest];
        std::array<double, D + 1> value{};
        value[nearest] = 1;
        for (std::size_t k = 0; k < D; ++k) value[k] += dot(hat[k], away);
        value[D] = dot(across, away);
        return value;
    }
};

/// Calls `integrate` with everything inlined, which keeps numbers in registers.
template <bool gradients, class S, std::size_t D>
CAGEFORM_DETAIL_FLATTEN GreenSum<S> integrate_registers(const GreenFrame<S, D>& frame, S near_distance,
                                                        const Vec<Simd<S>, D>& p, GreenRows<S, D>& memory,
                                                        Lanes<S>* rows) noexcept {
    return integrate<gradients>(frame, near_distance, p, memory, rows);
}

/// The base of GreenCoordinates. Points are evaluated a SIMD register at a time. For points outside and on
/// the boundary, the continuation across a facet is then added, weighted by the missing part of the full
/// angle.
template <class Cage>
class GreenEvaluation : public CheckedCage<Cage> {
public:
    using CheckedCage<Cage>::CheckedCage;
    using scalar = typename Cage::scalar;
    static constexpr std::size_t dimension = Cage::dimension;

    std::span<const Vec<scalar, dimension>> handles() const noexcept { return handles_; }
    std::span<const HandleKind> handle_kinds() const noexcept { return kinds_; }
    std::span<const HandleFace<dimension>> handle_faces() const noexcept { return faces_; }
    /// Returns the table of loops of a HandleView; empty without fans.
    std::span<const std::uint32_t> handle_loops() const noexcept { return loops_; }

    /// See CageCoordinates.
    Evaluation evaluate(BlockView<const scalar> points, BlockView<scalar> weights,
                        std::span<PointState> states, const Running& running = {}) const;
    /// See GradientCoordinates. On the boundary the limits from inside are returned. On vertices, and on
    /// edges in 3D, gradients diverge logarithmically: the gradient 1e-6 diagonals inside is returned.
    Evaluation evaluate_gradients(BlockView<const scalar> points, BlockView<scalar> gradients,
                                  std::span<PointState> states, const Running& running = {}) const;
    /// Returns the nearest boundary point and its weights, the limits from inside. May throw std::bad_alloc.
    Vec<scalar, dimension> nearest_boundary(const Vec<scalar, dimension>& p, std::span<scalar> row) const;

private:
    using CheckedCage<Cage>::cage_;
    using CheckedCage<Cage>::report_;
    using T = scalar;
    static constexpr std::size_t D = dimension;
    static constexpr std::size_t lanes = lane_count<T>;

    Status prepare();
    /// Refuses a cage if the vector of a facet overflows.
    void refuse_overflow() {
        for (std::size_t h = cage_.size(); h < handles_.size(); ++h) {
            if (is_finite(handles_[h])) continue;
            std::size_t farthest = 0;
            T largest = -1;
            for_each_vertex(topology_.facets[h - cage_.size()], [&](std::size_t v) {
                if (largest_coordinate(v) > largest) farthest = v;
                largest = std::fmax(largest, largest_coordinate(v));
            });
            report_.add(CageFaultKind::vertex_not_finite, farthest);
        }
    }
    /// Calls f(vertex) for the vertices of a facet, and for the loops of its means.
    template <class F>
    void for_each_vertex(const HandleFace<D>& facet, F&& f) const {
        for (const std::uint32_t corner : facet) {
            if (corner < cage_.size()) {
                f(corner);
            } else if constexpr (requires { cage_.fan_points(); }) {
                for (const std::uint32_t v : cage_.fan_points().corners(corner - cage_.size())) f(v);
            }
        }
    }
    T largest_coordinate(std::size_t vertex) const noexcept {
        T largest = 0;
        for (std::size_t k = 0; k < D; ++k) largest = std::fmax(largest, std::fabs(cage_[vertex][k]));
        return largest;
    }
    void fill_tables() {
        const auto bounds = bounds_of(surface().vertices());
        scale_ = double(unit_scale(bounds));
        tolerance_ = scale_ * double(coincidence_tolerance(bounds));
        middle_ = scale_ * (0.5 * vec_cast<double>(bounds.lower) + 0.5 * vec_cast<double>(bounds.upper));
        for (const auto& v : surface().vertices()) at_.push_back(scale_ * vec_cast<double>(v));
        topology_ = MeanValueTopology<D>(surface());
        frame_ = GreenFrame<T, D>(topology_, at_, scale_ * double(bounds.diagonal()));
        handles_.assign(cage_.vertices().begin(), cage_.vertices().end());
        kinds_.assign(handles_.size(), HandleKind::point);
        for (const auto& facet : topology_.facets) {
            std::array<Vec<T, D>, D> corner;
            for (std::size_t k = 0; k < D; ++k) corner[k] = surface()[facet[k]];
            if constexpr (D == 2) {
                handles_.push_back(edge_handle(corner[0], corner[1]));
            } else {
                handles_.push_back(face_handle(corner, corner));
            }
            kinds_.push_back(HandleKind::vector);
        }
        faces_ = topology_.facets;
        if (folds()) name_loops();
    }
    /// The mesh of the formula. Its points are the cage's vertices, then those of fans.
    const auto& surface() const noexcept { return surface_of(cage_); }
    std::size_t points() const noexcept { return surface().size(); }
    bool folds() const noexcept { return points() != cage_.size(); }
    /// Fills the table of loops and makes faces refer to it.
    void name_loops() {
        if constexpr (requires { cage_.fan_points(); }) {
            const FanPoints& fans = cage_.fan_points();
            loops_.push_back(std::uint32_t(fans.size() + 1));
            for (std::size_t l = 0; l < fans.size(); ++l)
                loops_.push_back(loops_.back() + std::uint32_t(fans.corners(l).size()));
            for (std::size_t l = 0; l < fans.size(); ++l)
                loops_.insert(loops_.end(), fans.corners(l).begin(), fans.corners(l).end());
            for (auto& face : faces_) {
                for (std::uint32_t& corner : face) {
                    if (corner >= cage_.size()) corner += std::uint32_t(handles_.size() - cage_.size());
                }
            }
        }
    }

    template <bool gradients>
    Evaluation evaluate_rows(const Batch<T>& batch, const Running& running) const {
        const std::size_t axes = gradients ? D : 1;
        return evaluate_blocks(report_, axes * handles_.size(), batch, running,
                               [&](std::size_t begin, std::size_t end) {
                                   GreenRows<T, D> memory(frame_);
                                   std::vector<Lanes<T>> of_points(folds() ? axes * row_count() : 0);
                                   for (std::size_t b = begin; b < end; ++b)
                                       evaluate_block<gradients>(batch, b, tolerance_, of_points, memory);
                               });
    }

    /// The rows of the formula: one per point of the surface and one per facet.
    std::size_t row_count() const noexcept { return points() + topology_.facets.size(); }

    /// Evaluates a block. With fans, evaluates into `of_points` and distributes the rows of means to the
    /// vertices.
    template <bool gradients>
    void evaluate_block(const Batch<T>& batch, std::size_t b, double near_distance,
                        std::vector<Lanes<T>>& of_points, GreenRows<T, D>& memory) const {
        if (!folds()) return evaluate_points<gradients>(batch, b, near_distance, batch.rows.block(b), memory);
        evaluate_points<gradients>(batch, b, near_distance, of_points.data(), memory);
        if constexpr (requires { cage_.fan_points(); }) {
            for (std::size_t axis = 0; axis < (gradients ? D : 1); ++axis) {
                const Lanes<T>* const from = of_points.data() + axis * row_count();
                Lanes<T>* const to = batch.rows.block(b) + axis * handles_.size();
                fold_rows(cage_.fan_points(), cage_.size(), from, to);
                std::copy_n(from + points(), topology_.facets.size(), to + cage_.size());
            }
        }
    }

    template <bool gradients>
    void evaluate_points(const Batch<T>& batch, std::size_t b, double near_distance, Lanes<T>* rows,
                         GreenRows<T, D>& memory) const {
        using X = Simd<T>;
        const std::size_t count = (gradients ? D : 1) * row_count();
        for (std::size_t row = 0; row < count; ++row) X(T(0)).store(rows[row]);
        // Beyond this distance the integrals change by less than a rounding error of the continuation.
        constexpr double farthest = sizeof(T) == 8 ? 0x1p24 : 0x1p12;
        Vec<X, D> p;
        for (std::size_t k = 0; k < D; ++k) {
            p[k] = X(T(scale_)) * X::load(batch.points.block(b)[k]);
            p[k] = (max)(X(T(middle_[k] - farthest)), (min)(X(T(middle_[k] + farthest)), p[k]));
        }
        const GreenSum<T> sum = integrate_registers<gradients>(frame_, T(near_distance), p, memory, rows);
        if constexpr (gradients) {
            for (std::size_t row = 0; row < count; ++row)
                (X(T(scale_)) * X::load(rows[row])).store(rows[row]);
        }
        Lanes<T> winding, touched;
        sum.winding.store(winding);
        sum.touched.store(touched);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::size_t i = b * lanes + lane;
            if (i >= batch.points.points || batch.states[i] == PointState::not_finite) continue;
            const auto q = scale_ * vec_cast<double>(block_point<D>(batch.points, i));
            const Lane at{rows, lane};
            if (touched[lane] != T(0)) {
                batch.states[i] = PointState::on_boundary;
                add_on_boundary<gradients>(at, q, near_distance, 1 - double(winding[lane]));
            } else if (winding[lane] > T(0.5)) {
                batch.states[i] = PointState::inside;
            } else {
                batch.states[i] = is_finite(winding[lane]) && add_nearest<gradients>(at, q, 1)
                                      ? PointState::outside
                                      : PointState::unreached;
            }
        }
    }

    /// One lane of a block's rows.
    struct Lane {
        Lanes<T>* rows;
        std::size_t lane;
    };

    Corners<D> corners_of(std::size_t facet) const noexcept {
        Corners<D> corner;
        for (std::size_t k = 0; k < D; ++k) corner[k] = at_[topology_.facets[facet][k]];
        return corner;
    }

    /// Adds `share` times the continuation across a facet at q, or its gradient. Returns whether the result
    /// is finite.
    template <bool gradients>
    bool add_facet(const Lane& to, std::size_t facet, const Vec<double, D>& q, double share) const noexcept {
        const FacetContinuation<D> of(corners_of(facet));
        const std::size_t count = row_count();
        bool finite = true;
        const auto add = [&](std::size_t row, double x) {
            T& weight = to.rows[row][to.lane];
            weight = static_cast<T>(double(weight) + x);
            finite = finite && is_finite(weight);
        };
        const auto value = of.at(q);
        for (std::size_t k = 0; k <= D; ++k) {
            const std::size_t h = k < D ? topology_.facets[facet][k] : points() + facet;
            if constexpr (gradients) {
                const auto& slope = k < D ? of.hat[k] : of.across;
                for (std::size_t axis = 0; axis < D; ++axis)
                    add(axis * count + h, scale_ * share * slope[axis]);
            } else {
                add(h, share * value[k]);
            }
        }
        return finite;
    }

    /// Adds the continuation across the nearest facet. Of facets at the same distance it takes the one whose
    /// plane q lies farthest beyond, then the first.
    template <bool gradients>
    bool add_nearest(const Lane& to, const Vec<double, D>& q, double share) const noexcept {
        const std::size_t facets = topology_.facets.size();
        std::size_t nearest = facets;
        double least = (std::numeric_limits<double>::max)(), farthest_beyond = 0;
        for (std::size_t f = 0; f < facets; ++f) {
            const auto corner = corners_of(f);
            const double distance = distance_to_facet(q, corner);
            // Distances to a common vertex or edge of several facets differ by rounding.
            const double rounding = 64 * epsilon<double> * (1 + largest(middle_) + distance);
            if (!(distance <= least + rounding)) continue;
            const double beyond = dot(outward_normal(corner), q - corner[0]);
            if (distance < least - rounding || beyond > farthest_beyond + rounding) {
                nearest = f;
                farthest_beyond = beyond;
            }
            least = (std::min)(least, distance);
        }
        return nearest < facets && add_facet<gradients>(to, nearest, q, share);
    }

    /// Distributes the missing angle equally over the facets that q lies on. Their true shares depend on the
    /// direction of approach, but the weights of common vertices do not.
    template <bool gradients>
    void add_on_boundary(const Lane& to, const Vec<double, D>& q, double near_distance,
                         double share) const noexcept {
        // The factor 1.25 allows for rounding to the scalar.
        const auto holds = [&](std::size_t f) {
            return distance_to_facet(q, corners_of(f)) <= 1.25 * near_distance;
        };
        std::size_t count = 0;
        for (std::size_t f = 0; f < topology_.facets.size(); ++f) count += holds(f) ? 1 : 0;
        if (count == 0) (void)add_nearest<gradients>(to, q, share);
        for (std::size_t f = 0; f < topology_.facets.size(); ++f) {
            if (holds(f)) (void)add_facet<gradients>(to, f, q, share / double(count));
        }
    }

    static double largest(const Vec<double, D>& v) noexcept {
        double size = 0;
        for (std::size_t k = 0; k < D; ++k) size = (std::max)(size, std::fabs(v[k]));
        return size;
    }

    std::vector<Vec<T, D>> handles_;
    std::vector<HandleKind> kinds_;
    std::vector<HandleFace<D>> faces_; ///< of the vector handles
    std::vector<std::uint32_t> loops_; ///< as in HandleView; empty without fans
    MeanValueTopology<D> topology_;    ///< one facet per vector handle
    Buffer<Vec<double, D>> at_;        ///< the points of the surface, in units of 1/scale
    GreenFrame<T, D> frame_;
    double tolerance_ = 0, scale_ = 1; ///< tolerance in units of 1/scale
    Vec<double, D> middle_{};
    Status prepared_ = prepare(); // declared last: its initialiser fills the other members
};

} // namespace cageform::inline CAGEFORM_ABI::detail
