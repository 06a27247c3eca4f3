// Binds points, figures and vectors to a cage by any type of coordinates, and reports how it went.
#pragma once

#include <cageform/binding/detail/figure_binder.hpp>
#include <cageform/core/detail/stopwatch.hpp>

#include <concepts>
#include <utility>

namespace cageform::inline CAGEFORM_ABI {

/// The type of `bind`. A function object, so that argument-dependent lookup never finds std::bind instead.
struct Bind {
    /// Binds points to the cage of `coordinates`: evaluates all weights, handles points outside,
    /// restores linear precision, and reports.
    ///
    ///   points   any PointRange of the same dimension, converted to the scalar of the coordinates. A float
    ///            rounds places by up to 6e-8 of their distance from the origin: count the cage, its poses
    ///            and the points from near the cage, or take double
    ///   returns  the binding and its report. Unless the report's status is ok the binding is empty. A
    ///            bad *point* is listed and kept in place; the others are bound nevertheless
    ///   cost     that of the coordinates, plus O(#handles) a point; (#handles + D) scalars of memory
    ///            a point
    ///   fails    as the cage's check and the coordinates say; coordinates_empty;
    ///            falloff_not_supported; cancelled; out_of_memory
    template <CageCoordinates C, PointRangeIn<C::dimension> R>
    Result<Binding<typename C::scalar, C::dimension>, BindReport>
    operator()(const C& coordinates, const R& points, const BindOptions& options = {},
               const Running& running = {}) const {
        return (*this)(coordinates, points, options, Binding<typename C::scalar, C::dimension>{}, running);
    }

    /// Binds points as above, into the memory of a binding that is no longer needed. A megabyte of new memory
    /// costs the system as much time as the weights to fill it.
    template <CageCoordinates C, PointRangeIn<C::dimension> R,
              std::same_as<Binding<typename C::scalar, C::dimension>> Recycled>
    Result<Binding<typename C::scalar, C::dimension>, BindReport>
    operator()(const C& coordinates, const R& points, const BindOptions& options, Recycled&& recycled,
               const Running& running = {}) const {
        return detail::bind_points(
            detail::bind_input(coordinates, detail::read_points<typename C::scalar>(points)), options,
            std::forward<Recycled>(recycled), running);
    }

    /// Binds a figure with normals: `bind(coordinates, FigurePoints{points, normals, tangents})`. Points are
    /// bound as above. Normals and tangents are converted by `tangents_of` and bound as by `bind_vectors`,
    /// with the same bits.
    ///
    ///   options  as above, for points and vectors
    ///   returns  the figure and its report. Bad points and vectors are listed; the others are bound
    ///            nevertheless
    ///   cost     that of `bind` and `bind_vectors`. But coordinates with a solver solve only once, if they
    ///            have not before, and keep their functions meanwhile (half of SolverMemory::block for
    ///            each group)
    ///   fails    vectors_do_not_match; as `bind` and `bind_vectors`
    template <CageCoordinates C, class P, class N, class G>
        requires(detail::PointsFor<P, C>&& detail::NormalsFor<N, C>&& detail::TangentsIn<G, N, C::dimension>)
    Result<FigureBinding<typename C::scalar, C::dimension>, FigureBindReport>
    operator()(const C& coordinates, const FigurePoints<P, N, G>& figure, const BindOptions& options = {},
               const Running& running = {}) const {
        using T = typename C::scalar;
        Result<FigureBinding<T, C::dimension>, FigureBindReport> result;
        detail::run_into(result.report, [&] {
            return detail::read_figure<T, C::dimension>(
                figure, [&](detail::FigureInput<T, C::dimension>& input) {
                    return detail::bind_read_figure(detail::figure_input(coordinates, input.points), input,
                                                    options, running, result);
                });
        });
        return result;
    }

    /// Binds by the member `bind` of coordinates that have one, such as AnyCoordinates.
    template <class Figure, detail::BindsByMember<Figure> C, class... More>
    auto operator()(const C& coordinates, const Figure& figure, More&&... more) const {
        return coordinates.bind(figure, std::forward<More>(more)...);
    }

    // Accepts any further arguments, so that the first line that compilers print names the reason.
    template <CageCoordinates C, UnknownPointRange R, class... More>
    detail::ReasonOr<detail::PointTraitsNotSpecialisedForThesePoints,
                     Result<Binding<typename C::scalar, C::dimension>, BindReport>>
    operator()(const C&, const R&, const More&...) const = CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;
    template <CageCoordinates C, PointRange R, class... More>
        requires(range_dimension<R> != C::dimension)
    detail::ReasonOr<detail::PointsOfAnotherDimensionThanTheCage,
                     Result<Binding<typename C::scalar, C::dimension>, BindReport>>
    operator()(const C&, const R&, const More&...) const = CAGEFORM_DETAIL_DELETE_DIMENSION;
};
inline constexpr Bind bind{};

/// Binds vectors attached to points. A pose moves them as it moves the material around the points:
///
///     t' = t + Σ (t·∇w_i(p)) (C'_i − C_i) = J t,   J the Jacobian of the deformation at p
///
/// The result is a Binding with vectors instead of points and directional derivatives instead of
/// weights. `clone` moves it, and at rest returns the vectors bit for bit. Affine poses x ↦ A x + b
/// give A t to rounding.
///
///   points    as for `bind`
///   vectors   K families in an array, as `tangents_of` returns them, each as many as points, of
///             any length, read as the scalar of the coordinates
///   options   as for `bind`. With nearest_boundary, vectors of points outside move with the material
///             at the nearest boundary point. Without extension, or with keep_in_place, they
///             keep their direction and length. With a falloff f, t' = t + Σ (f t·∇w_i + (t·∇f) w_i)
///             (C'_i − C_i)
///   returns   a binding for each family and the report, as `bind` does: lists of points (not
///             finite: the point or one of its vectors); the largest |Σw| and |Σwc − t|; the
///             changes and the least of these weights
///   cost      that of evaluate_gradients once for all families, plus O(K #handles) a point; closed
///             forms a few points at a time. A solver's gradients are computed all at once, D #handles
///             scalars a point, and again with nearest_boundary if points lie outside
///   fails     as `bind`, and as evaluate_gradients
template <GradientCoordinates C, PointRangeIn<C::dimension> R, PointRangeIn<C::dimension> V, std::size_t K>
Result<std::array<Binding<typename C::scalar, C::dimension>, K>, BindReport>
bind_vectors(const C& coordinates, const R& points, const std::array<V, K>& vectors,
             const BindOptions& options = {}, const Running& running = {}) {
    for ([[maybe_unused]] const V& family : vectors)
        CAGEFORM_ASSERT(std::size(family) == std::size(points), "a vector for every point");
    using T = typename C::scalar;
    std::array<detail::PointReader<T>, K> readers;
    for (std::size_t n = 0; n < K; ++n) readers[n] = detail::read_points<T>(vectors[n]);
    return detail::bind_each_vector(detail::vector_input(coordinates, detail::read_points<T>(points)),
                                    readers, options, running);
}

/// Binds one vector per point, or the same vector for all points.
template <GradientCoordinates C, PointRangeIn<C::dimension> R, class V>
    requires(PointRangeIn<V, C::dimension> ||
             (Point<V> && !PointRange<V> && PointTraits<V>::dimension == C::dimension))
Result<Binding<typename C::scalar, C::dimension>, BindReport> bind_vectors(const C& coordinates,
                                                                           const R& points, const V& vectors,
                                                                           const BindOptions& options = {},
                                                                           const Running& running = {}) {
    using T = typename C::scalar;
    std::array<detail::PointReader<T>, 1> reader;
    [[maybe_unused]] Vec<T, C::dimension> same{};
    if constexpr (PointRange<V>) {
        CAGEFORM_ASSERT(std::size(vectors) == std::size(points), "a vector for every point");
        reader[0] = detail::read_points<T>(vectors);
    } else {
        same = to_vec<T>(vectors);
        reader[0] = detail::repeat_vector(std::size(points), same);
    }
    auto result = detail::bind_each_vector(detail::vector_input(coordinates, detail::read_points<T>(points)),
                                           reader, options, running);
    return {std::move(result.value[0]), std::move(result.report)};
}

/// Binds the D axes at every point, for `clone_jacobians`. Contract and cost are those of
/// `bind_vectors`.
template <GradientCoordinates C, PointRangeIn<C::dimension> R>
Result<std::array<Binding<typename C::scalar, C::dimension>, C::dimension>, BindReport>
bind_jacobians(const C& coordinates, const R& points, const BindOptions& options = {},
               const Running& running = {}) {
    return detail::bind_axes(
        detail::vector_input(coordinates, detail::read_points<typename C::scalar>(points)), options, running);
}

} // namespace cageform::inline CAGEFORM_ABI
