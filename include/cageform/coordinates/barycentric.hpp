// Barycentric coordinates of a point in one simplex.
#pragma once

#include <cageform/cage/detail/refuse_interior_cells.hpp>
#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/detail/simplex.hpp>
#include <cageform/core/detail/simd.hpp>

#include <array>
#include <cmath>

namespace cageform::inline CAGEFORM_ABI {

/// Barycentric coordinates in a simplex of `D` dimensions: a triangle, a tetrahedron, ….
///
/// The weights β solve [C_0 … C_D; 1 … 1] β = [p; 1] (Möbius 1827). The matrix is inverted once, in double.
///
///   range     sum to 1; in [0, 1] inside, some negative outside
///   cost      O(D²) a point
///   faults    not_a_simplex, vertex_not_finite, degenerate_simplex (the height of a vertex above the
///             opposite face is within the tolerance)
template <Scalar T, std::size_t D>
class BarycentricCoordinates {
    static_assert(D >= 1 && D <= 8, "the nearest boundary point is searched among all 2^(D+1) faces");

public:
    using scalar = T;
    static constexpr std::size_t dimension = D;
    static constexpr bool has_extension = true;
    static constexpr bool closed_form = true;

    template <PointRange R>
        requires(range_dimension<R> == D)
    explicit BarycentricCoordinates(const R& vertices) {
        const Status status = detail::guard_memory([&] {
            for (std::size_t i = 0; i < std::size(vertices); ++i) vertices_.push_back(to_vec<T>(vertices[i]));
            prepare();
        });
        if (status != Status::ok) report_ = {status, {}};
    }
    template <UnknownPointRange R>
    explicit BarycentricCoordinates(const R&, detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    /// Takes a polygon of one loop and three vertices.
    explicit BarycentricCoordinates(const Polygon<T>& cage)
        requires(D == 2)
        : BarycentricCoordinates(cage.vertices()) {
        if (cage.status() != Status::ok) {
            report_ = {cage.status(), {}};
        } else if (!cage.loops_match()) {
            report_.add(CageFaultKind::loops_do_not_match);
        } else if (cage.loops().size() != 1) {
            report_.add(CageFaultKind::not_a_simplex, cage.size(), 3);
        }
    }

    /// Takes the boundary of a cell complex. Interior cells are the fault interior_cells_not_supported.
    template <std::size_t E>
        requires(E == D)
    explicit BarycentricCoordinates(const CellComplex<T, E>& cage)
        : BarycentricCoordinates(cage.boundary().vertices()) {
        if (cage.status() != Status::ok) report_ = {cage.status(), {}};
        detail::refuse_interior_cells(cage, report_);
    }

    std::span<const Vec<T, D>> handles() const noexcept { return vertices_; }
    const CageReport& cage_report() const noexcept { return report_; }

    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const Running& running = {}) const {
        return detail::evaluate_blocks<T>(report_, D + 1, {points, weights, states}, running,
                                          [&](std::size_t begin, std::size_t end) {
                                              for (std::size_t b = begin; b < end; ++b)
                                                  evaluate_block(b, points, weights, states);
                                          });
    }

    /// Computes the gradients of all weights. They are constant, because the weights are affine.
    ///
    ///   points, states   as for `evaluate`
    ///   gradients        out, row axis · #handles + handle: the derivative along the axis, per unit of
    ///                    length
    Evaluation evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                  std::span<PointState> states, const Running& running = {}) const {
        return detail::evaluate_blocks<T>(report_, D * (D + 1), {points, gradients, states}, running,
                                          [&](std::size_t begin, std::size_t end) {
                                              for (std::size_t b = begin; b < end; ++b)
                                                  evaluate_gradient_block(b, points, gradients, states);
                                          });
    }

    Vec<T, D> nearest_boundary(const Vec<T, D>& p, std::span<T> row) const {
        const auto best = detail::nearest_on_simplex_boundary<D>(in_unit(handles()), in_unit(p));
        Vec<double, D> q{};
        for (std::size_t i = 0; i <= D; ++i) {
            row[i] = static_cast<T>(best[i]);
            q = q + best[i] * vec_cast<double>(vertices_[i]);
        }
        return vec_cast<T>(q);
    }

private:
    using Simd = detail::Simd<T>;

    /// Returns points relative to the last vertex, in units of the simplex's diagonal.
    Vec<double, D> in_unit(const Vec<T, D>& p) const noexcept {
        return (1 / unit_) * (vec_cast<double>(p) - vec_cast<double>(vertices_.back()));
    }
    std::vector<Vec<double, D>> in_unit(std::span<const Vec<T, D>> points) const {
        std::vector<Vec<double, D>> positions;
        for (const auto& p : points) positions.push_back(in_unit(p));
        return positions;
    }

    void prepare() {
        if (vertices_.size() != D + 1)
            return report_.add(CageFaultKind::not_a_simplex, vertices_.size(), D + 1);
        for (std::size_t i = 0; i <= D; ++i) {
            if (!is_finite(vertices_[i])) report_.add(CageFaultKind::vertex_not_finite, i);
        }
        if (report_.status != Status::ok) return;
        unit_ = double(bounds_of(handles()).diagonal());
        if (!(unit_ > 0)) return report_.add(CageFaultKind::degenerate_simplex);
        const auto gradients = detail::simplex_gradients<D>(in_unit(handles()));
        if (gradients.empty()) return report_.add(CageFaultKind::degenerate_simplex);
        // |∇β_k| is the reciprocal of the height of vertex k above the opposite face.
        const double tolerance = coincidence_tolerance(bounds_of(handles())) / unit_;
        for (std::size_t k = 0; k <= D; ++k) {
            for (std::size_t axis = 0; axis < D; ++axis)
                gradient_[k][axis] = static_cast<T>(gradients[k][axis] / unit_);
            const double inverse_height = std::sqrt(dot(gradients[k], gradients[k]));
            if (!(tolerance * inverse_height < 1)) return report_.add(CageFaultKind::degenerate_simplex);
            on_face_[k] = static_cast<T>(tolerance * inverse_height);
        }
    }

    void evaluate_block(std::size_t b, BlockView<const T> points, BlockView<T> weights,
                        std::span<PointState> states) const {
        compute_weights(points.block(b), weights.block(b));
        locate(b, points.points, weights.block(b), states);
    }

    void evaluate_gradient_block(std::size_t b, BlockView<const T> points, BlockView<T> gradients,
                                 std::span<PointState> states) const {
        Lanes<T> weights[D + 1];
        compute_weights(points.block(b), weights);
        locate(b, points.points, weights, states);
        auto* const row = gradients.block(b);
        for (std::size_t k = 0; k <= D; ++k) {
            for (std::size_t axis = 0; axis < D; ++axis)
                Simd(gradient_[k][axis]).store(row[axis * (D + 1) + k]);
        }
    }

    void compute_weights(const Lanes<T>* position, Lanes<T>* row) const noexcept {
        // β_k is computed relative to a vertex of the opposite face, for accuracy on that face.
        for (std::size_t k = 0; k <= D; ++k) {
            const Vec<T, D>& from = vertices_[k < D ? D : 0];
            Simd beta(T(0));
            for (std::size_t axis = 0; axis < D; ++axis) {
                beta = beta + Simd(gradient_[k][axis]) * (Simd::load(position[axis]) - Simd(from[axis]));
            }
            beta.store(row[k]);
        }
    }

    void locate(std::size_t b, std::size_t points, const Lanes<T>* row,
                std::span<PointState> states) const noexcept {
        const std::size_t first = b * lane_count<T>;
        const std::size_t used = (std::min)(lane_count<T>, points - first);
        for (std::size_t lane = 0; lane < used; ++lane) {
            PointState& state = states[first + lane];
            if (state == PointState::not_finite) continue;
            state = PointState::inside;
            for (std::size_t k = 0; k <= D; ++k) {
                if (row[k][lane] < -on_face_[k]) {
                    state = PointState::outside;
                    break;
                }
                if (row[k][lane] <= on_face_[k]) state = PointState::on_boundary;
            }
        }
    }

    std::vector<Vec<T, D>> vertices_;
    CageReport report_;
    double unit_ = 1;
    std::array<Vec<T, D>, D + 1> gradient_{};
    std::array<T, D + 1> on_face_{};
};

// `BarycentricCoordinates coordinates(cage)` deduces the scalar and the dimension.
template <PointRange R>
BarycentricCoordinates(const R&) -> BarycentricCoordinates<range_scalar_t<R>, range_dimension<R>>;
template <Scalar T>
BarycentricCoordinates(Polygon<T>) -> BarycentricCoordinates<T, 2>;
template <Scalar T, std::size_t D>
BarycentricCoordinates(CellComplex<T, D>) -> BarycentricCoordinates<T, D>;

} // namespace cageform::inline CAGEFORM_ABI
