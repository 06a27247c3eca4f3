// Barycentric coordinates: one simplex, affine, the coordinates all others reduce to on it.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/core/detail/simd.hpp>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

// Of any dimension, so that a program has them once; templates, so that a program without simplices
// does not have them.

/// The gradients of the barycentric coordinates of a simplex: (D + 1) × D, from its vertices, D ×
/// (D + 1). Empty where the simplex has no volume to working precision.
template <class Number>
Eigen::MatrixX<Number> simplex_gradients(const Eigen::MatrixX<Number>& vertices) {
    const long d = vertices.rows();
    const Eigen::FullPivLU<Eigen::MatrixX<Number>> lu(vertices.leftCols(d).colwise() - vertices.col(d));
    if (!lu.isInvertible()) return {};
    Eigen::MatrixX<Number> gradients(d + 1, d);
    gradients.topRows(d) = lu.inverse();
    gradients.row(d) = -gradients.topRows(d).colwise().sum();
    return gradients;
}

/// The barycentric coordinates of the point on the boundary of a simplex that is nearest to `p`:
/// the least projection of `p` onto the span of a face that lies in the face.
template <class Number>
Eigen::VectorX<Number> nearest_on_simplex_boundary(const Eigen::MatrixX<Number>& vertices,
                                                   const Eigen::MatrixX<Number>& p) {
    const long d = vertices.rows();
    Number least = std::numeric_limits<Number>::max();
    Eigen::VectorX<Number> best = Eigen::VectorX<Number>::Zero(d + 1);
    for (unsigned face = 1; face + 1 < (1u << (d + 1)); ++face) {
        std::vector<long> corner;
        for (long i = 0; i <= d; ++i) {
            if ((face >> i) & 1u) corner.push_back(i);
        }
        const long edges = long(corner.size()) - 1;
        const Eigen::MatrixX<Number> base = vertices.col(corner[0]);
        Eigen::MatrixX<Number> span(d, edges);
        for (long k = 0; k < edges; ++k)
            span.col(k) = vertices.col(corner[std::size_t(k) + 1]) - vertices.col(corner[0]);
        const Eigen::MatrixX<Number> across = span.transpose();
        const Eigen::MatrixX<Number> s =
            Eigen::MatrixX<Number>(across * span)
                .ldlt()
                .solve(Eigen::MatrixX<Number>(across * Eigen::MatrixX<Number>(p - base)));
        if ((edges > 0 && s.minCoeff() < 0) || s.sum() > 1) continue;
        const Number distance = Eigen::MatrixX<Number>(base + span * s - p).stableNorm();
        if (distance >= least) continue;
        least = distance;
        best.setZero();
        best[corner[0]] = 1 - s.sum();
        for (long k = 0; k < edges; ++k) best[corner[std::size_t(k) + 1]] = s(k, 0);
    }
    return best;
}

} // namespace detail

/// Barycentric coordinates in a simplex of `D` dimensions: a triangle, a tetrahedron, …
///
/// The solution β of [C_0 … C_D; 1 … 1] β = [p; 1] (Möbius 1827; Ceva's masses). The inverse is
/// computed once, in double.
///
///   range     sum to 1; all in [0, 1] inside, some negative outside (the same affine functions)
///   cost      O(D²) a point
///   faults    not_a_simplex, vertex_not_finite, degenerate_simplex (a vertex within rounding of
///             the face that the others span)
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
        for (std::size_t i = 0; i < std::size(vertices); ++i) vertices_.push_back(to_vec<T>(vertices[i]));
        prepare();
    }

    /// The cage of the two-dimensional types, so that they can be exchanged.
    explicit BarycentricCoordinates(const Polygon<T>& cage) requires(D == 2)
        : BarycentricCoordinates(cage.vertices()) {
        if (!cage.loops_match()) {
            report_.add(CageFaultKind::loops_do_not_match);
        } else if (cage.loops().size() != 1) {
            report_.add(CageFaultKind::not_a_simplex, cage.size(), 3);
        }
    }

    /// Loops alone: interior_cells_not_supported where there are cells inside.
    template <std::size_t E>
        requires(E == D)
    explicit BarycentricCoordinates(const CellComplex<T, E>& cage)
        : BarycentricCoordinates(cage.boundary().vertices()) {
        refuse_interior_cells(cage, report_);
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

    /// The gradients of all weights at a batch of points: those of affine functions, the same
    /// everywhere.
    ///
    ///   points     as for `evaluate`; so are the states on entry and on return
    ///   gradients  out, row axis · #handles + handle: the derivative along the axis, per unit of
    ///              length
    Evaluation evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                  std::span<PointState> states, const Running& running = {}) const {
        return detail::evaluate_blocks<T>(report_, D * (D + 1), {points, gradients, states}, running,
                                          [&](std::size_t begin, std::size_t end) {
                                              for (std::size_t b = begin; b < end; ++b)
                                                  evaluate_gradient_block(b, points, gradients, states);
                                          });
    }

    Vec<T, D> nearest_boundary(const Vec<T, D>& p, std::span<T> row) const {
        const auto best = detail::nearest_on_simplex_boundary(matrix(handles()), matrix(std::span(&p, 1)));
        Vec<double, D> q{};
        for (std::size_t i = 0; i <= D; ++i) {
            row[i] = static_cast<T>(best[long(i)]);
            q = q + best[long(i)] * vec_cast<double>(vertices_[i]);
        }
        return vec_cast<T>(q);
    }

private:
    using Simd = detail::Simd<T>;

    /// A column a point.
    static Eigen::MatrixXd matrix(std::span<const Vec<T, D>> points) {
        auto columns = Eigen::MatrixXd::Zero(long(D), long(points.size())).eval();
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (std::size_t k = 0; k < D; ++k) columns(long(k), long(i)) = double(points[i][k]);
        }
        return columns;
    }

    void prepare() {
        if (vertices_.size() != D + 1)
            return report_.add(CageFaultKind::not_a_simplex, vertices_.size(), D + 1);
        for (std::size_t i = 0; i <= D; ++i) {
            if (!is_finite(vertices_[i])) report_.add(CageFaultKind::vertex_not_finite, i);
        }
        if (report_.status != Status::ok) return;
        const auto gradients = detail::simplex_gradients(matrix(handles()));
        if (gradients.size() == 0) return report_.add(CageFaultKind::degenerate_simplex);
        // The gradient of β_k is one over the height of vertex k above the opposite face.
        const double tolerance = coincidence_tolerance(bounds_of(handles()));
        for (std::size_t k = 0; k <= D; ++k) {
            for (std::size_t axis = 0; axis < D; ++axis)
                gradient_[k][axis] = static_cast<T>(gradients(long(k), long(axis)));
            const double inverse_height = gradients.row(long(k)).norm();
            if (!(tolerance * inverse_height < 1)) return report_.add(CageFaultKind::degenerate_simplex);
            on_face_[k] = static_cast<T>(tolerance * inverse_height);
        }
    }

    void evaluate_block(std::size_t b, BlockView<const T> points, BlockView<T> weights,
                        std::span<PointState> states) const {
        weigh(points.block(b), weights.block(b));
        locate(b, points.points, weights.block(b), states);
    }

    void evaluate_gradient_block(std::size_t b, BlockView<const T> points, BlockView<T> gradients,
                                 std::span<PointState> states) const {
        Lanes<T> weights[D + 1];
        weigh(points.block(b), weights);
        locate(b, points.points, weights, states);
        auto* const row = gradients.block(b);
        for (std::size_t k = 0; k <= D; ++k) {
            for (std::size_t axis = 0; axis < D; ++axis)
                Simd(gradient_[k][axis]).store(row[axis * (D + 1) + k]);
        }
    }

    void weigh(const Lanes<T>* position, Lanes<T>* row) const noexcept {
        // β_k grows from a vertex of the opposite face, so that it is accurate on that face.
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
        const std::size_t used = std::min(lane_count<T>, points - first);
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
    std::array<Vec<T, D>, D + 1> gradient_{};
    std::array<T, D + 1> on_face_{};
};

using BarycentricCoordinates2f = BarycentricCoordinates<float, 2>;
using BarycentricCoordinates2d = BarycentricCoordinates<double, 2>;
using BarycentricCoordinates3f = BarycentricCoordinates<float, 3>;
using BarycentricCoordinates3d = BarycentricCoordinates<double, 3>;

} // namespace cageform::inline CAGEFORM_ABI
