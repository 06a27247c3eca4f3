// Binds points, figures and vectors to a cage by any type of coordinates.
#pragma once

#include <cageform/binding/detail/figure_binder.hpp>
#include <cageform/core/detail/stopwatch.hpp>

#include <concepts>
#include <utility>

namespace cageform::inline CAGEFORM_ABI {

/// The type of `bind`: a function object, because argument-dependent lookup would find std::bind.
struct Bind {
    /// Binds points to the cage of `coordinates`: evaluates all weights, treats points outside
    /// as `options` say, restores linear precision, and reports.
    ///
    ///   points   any PointRange of the same dimension, converted to the scalar of the coordinates. float
    ///            rounds positions by up to 6e-8 of their distance from the origin: choose an origin near
    ///            the cage, or use double
    ///   returns  the binding, empty unless the status is ok, and its report. Points without weights are
    ///            listed and do not move
    ///   cost     that of the coordinates, plus O(#handles) per point; (#handles + D) scalars of memory
    ///            per point
    ///   fails    as the cage's check and the coordinates; coordinates_empty;
    ///            falloff_not_supported; cancelled; out_of_memory
    template <CageCoordinates C, PointRangeIn<C::dimension> R>
    Result<Binding<typename C::scalar, C::dimension>, BindReport>
    operator()(const C& coordinates, const R& points, const BindOptions& options = {},
               const Running& running = {}) const {
        return (*this)(coordinates, points, options, Binding<typename C::scalar, C::dimension>{}, running);
    }

    /// Binds points as above and reuses the memory of a binding. Allocating new memory often takes longer
    /// than computing the weights.
    template <CageCoordinates C, PointRangeIn<C::dimension> R,
              std::same_as<Binding<typename C::scalar, C::dimension>> Recycled>
    Result<Binding<typename C::scalar, C::dimension>, BindReport>
    operator()(const C& coordinates, const R& points, const BindOptions& options, Recycled&& recycled,
               const Running& running = {}) const {
        return detail::bind_points(
            detail::bind_input(coordinates, detail::read_points<typename C::scalar>(points)), options,
            std::forward<Recycled>(recycled), running);
    }

    /// Binds a figure with normals: `bind(coordinates, FigurePoints{points, normals, tangents})`.
    /// Points are bound as above. Normals and tangents are converted by `tangents_of` and bound as by
    /// `bind_vectors`, bit for bit.
    ///
    ///   options  as above, for points and vectors
    ///   returns  the figure and its report. Points and vectors without weights are listed and do not move
    ///   cost     that of `bind` and `bind_vectors`. Coordinates with a solver solve at most once and keep
    ///            their functions during the call (half of SolverMemory::block per group)
    ///   fails    vectors_do_not_match; as `bind` and `bind_vectors`
    template <CageCoordinates C, class P, class N, class G>
        requires(detail::PointsFor<P, C> && detail::NormalsFor<N, C> &&
                 detail::TangentsIn<G, N, C::dimension>)
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

    /// Calls the member `bind` of coordinates that have one, such as AnyCoordinates.
    template <class Figure, detail::BindsByMember<Figure> C, class... More>
    auto operator()(const C& coordinates, const Figure& figure, More&&... more) const {
        return coordinates.bind(figure, std::forward<More>(more)...);
    }

    // Accepts any further arguments, so that the first line of a compiler error states the reason.
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

/// Binds vectors attached to points. A pose transforms them as it transforms the neighbourhood of the points:
///
///     t' = t + Σ (t·∇w_i(p)) (C'_i − C_i) = J t,   J the Jacobian of the deformation at p
///
/// The result is a Binding of vectors instead of points, with directional derivatives instead of weights.
/// `clone` returns the posed vectors, at rest bit for bit. Affine poses x ↦ A x + b give A t up to rounding.
///
///   points    as for `bind`
///   vectors   an array of K families, for instance from `tangents_of`; one vector of any length per
///             point, converted to the scalar of the coordinates
///   options   as for `bind`. With nearest_boundary, vectors of points outside transform as at the
///             nearest boundary point. Without extension, or with keep_in_place, they do not change. With
///             a falloff f, t' = t + Σ (f t·∇w_i + (t·∇f) w_i) (C'_i − C_i)
///   returns   a binding per family and a report as of `bind`: lists of points (not_finite: the point or
///             one of its vectors); the largest |Σw| and |Σwc − t|; measures of weights are those of the
///             directional derivatives
///   cost      evaluate_gradients once for all families, plus O(K #handles) per point. Closed forms
///             process a few points at a time. A solver computes all gradients at once, in D #handles
///             scalars per point; with nearest_boundary, twice if points lie outside
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
Result<Binding<typename C::scalar, C::dimension>, BindReport>
bind_vectors(const C& coordinates, const R& points, const V& vectors, const BindOptions& options = {},
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

/// Binds the D axes at every point, for `clone_jacobians`. Contract and cost are those of `bind_vectors`.
template <GradientCoordinates C, PointRangeIn<C::dimension> R>
Result<std::array<Binding<typename C::scalar, C::dimension>, C::dimension>, BindReport>
bind_jacobians(const C& coordinates, const R& points, const BindOptions& options = {},
               const Running& running = {}) {
    return detail::bind_axes(
        detail::vector_input(coordinates, detail::read_points<typename C::scalar>(points)), options, running);
}

} // namespace cageform::inline CAGEFORM_ABI
