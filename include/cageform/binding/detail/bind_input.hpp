// Type-erased coordinates and points, so that most code of binding is compiled once per scalar and dimension.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/detail/outside_distance.hpp>
#include <cageform/core/view.hpp>

#include <algorithm>
#include <functional>
#include <span>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Reads points a block at a time.
template <Scalar T>
struct PointReader {
    std::size_t size = 0;
    /// Reads the rows of a block; the last block is filled with copies of the last point.
    std::function<void(std::size_t block, Lanes<T>* rows)> read;
};

/// Reads any range, which must outlive the reader.
template <Scalar T, PointRange R>
PointReader<T> read_points(const R& points) {
    return {std::size(points), [&points](std::size_t block, Lanes<T>* rows) {
                for (std::size_t lane = 0; lane < lane_count<T>; ++lane) {
                    const std::size_t i = block * lane_count<T> + lane;
                    const auto p = to_vec<T>(points[(std::min)(i, std::size(points) - 1)]);
                    for (std::size_t k = 0; k < range_dimension<R>; ++k) rows[k][lane] = p[k];
                }
            }};
}

/// Reads the same vector for every point; the vector must outlive the reader.
template <Scalar T, std::size_t D>
PointReader<T> repeat_vector(std::size_t size, const Vec<T, D>& vector) {
    return {size, [&vector](std::size_t, Lanes<T>* rows) {
                for (std::size_t k = 0; k < D; ++k)
                    std::fill(rows[k].v, rows[k].v + lane_count<T>, vector[k]);
            }};
}

/// The points and coordinates of a bind. Owns nothing.
template <Scalar T, std::size_t D>
struct BindInput {
    const CageReport& cage;
    std::function<HandleView<T, D>()> handles; ///< of a valid cage
    bool has_extension = false, closed_form = false, local = false;
    std::function<Evaluation(const Batch<T>&, const Running&)> evaluate;
    std::function<Vec<T, D>(const Vec<T, D>&, std::span<T>)> nearest_boundary;
    std::function<OutsideDistance<D>(const Vec<T, D>&)> distance;
    bool is_within_handles = false; ///< the cage lies within the bounds of its point handles
    PointReader<T> points;
    /// Empty if there are no gradients.
    std::function<Evaluation(const Batch<T>&, const Running&)> evaluate_gradients{};
    /// Solves with a copy of the coordinates, and calls use(evaluation, input of the copy); empty
    /// without a solver.
    std::function<Status(const Running&, const PointReader<T>&,
                         const std::function<Status(const Evaluation&, const BindInput&)>&)>
        with_solved{};
};

/// Whether zero weights must stay zero.
template <class C>
inline constexpr bool has_local_rows = false;
template <class C>
    requires(bool(C::local))
inline constexpr bool has_local_rows<C> = true;

/// Returns the input for binding points.
template <CageCoordinates C>
BindInput<typename C::scalar, C::dimension> bind_input(const C& coordinates,
                                                       PointReader<typename C::scalar> points) {
    using T = typename C::scalar;
    return {coordinates.cage_report(),
            [&coordinates] { return handle_view(coordinates); },
            C::has_extension,
            C::closed_form,
            has_local_rows<C>,
            [&coordinates](const Batch<T>& batch, const Running& running) {
                return coordinates.evaluate(batch.points, batch.rows, batch.states, running);
            },
            [&coordinates](const Vec<T, C::dimension>& p, std::span<T> row) {
                return coordinates.nearest_boundary(p, row);
            },
            [&coordinates](const Vec<T, C::dimension>& p) { return outside_distance(coordinates, p); },
            is_within_handles<C>,
            std::move(points)};
}

/// As above, and for binding vectors if the coordinates have gradients.
template <CageCoordinates C>
BindInput<typename C::scalar, C::dimension> vector_input(const C& coordinates,
                                                         PointReader<typename C::scalar> points) {
    auto input = bind_input(coordinates, std::move(points));
    if constexpr (GradientCoordinates<C>) {
        input.evaluate_gradients = [&coordinates](const auto& batch, const Running& running) {
            return coordinates.evaluate_gradients(batch.points, batch.rows, batch.states, running);
        };
    }
    return input;
}

/// As above, and for binding a figure, for which a solver solves only once.
template <CageCoordinates C>
BindInput<typename C::scalar, C::dimension> figure_input(const C& coordinates,
                                                         PointReader<typename C::scalar> points) {
    auto input = vector_input(coordinates, std::move(points));
    if constexpr (requires(C solved) { solved.solve(Running{}); }) {
        input.with_solved = [&coordinates](const Running& running, const auto& its_points, const auto& use) {
            C solved = coordinates;
            const Evaluation evaluation = solved.solve(running);
            return use(evaluation, vector_input(solved, its_points));
        };
    }
    return input;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
