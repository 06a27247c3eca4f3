// The overloads of `bind`, as a function object.
#pragma once

#include <cageform/binding/detail/figure_binder.hpp>
#include <cageform/core/detail/stopwatch.hpp>

#include <concepts>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The type of `bind`, which binding/bind.hpp describes.
struct Bind {
    template <CageCoordinates C, PointRangeIn<C::dimension> R>
    Result<Binding<typename C::scalar, C::dimension>, BindReport>
    operator()(const C& coordinates, const R& points, const BindOptions& options = {},
               const Running& running = {}) const {
        return (*this)(coordinates, points, options, Binding<typename C::scalar, C::dimension>{}, running);
    }

    template <CageCoordinates C, PointRangeIn<C::dimension> R,
              std::same_as<Binding<typename C::scalar, C::dimension>> Recycled>
    Result<Binding<typename C::scalar, C::dimension>, BindReport>
    operator()(const C& coordinates, const R& points, const BindOptions& options, Recycled&& recycled,
               const Running& running = {}) const {
        return bind_points(bind_input(coordinates, read_points<typename C::scalar>(points)), options,
                           std::forward<Recycled>(recycled), running);
    }

    template <CageCoordinates C, class P, class N, class G>
        requires(PointsFor<P, C>&& NormalsFor<N, C>&& TangentsIn<G, N, C::dimension>)
    Result<FigureBinding<typename C::scalar, C::dimension>, FigureBindReport>
    operator()(const C& coordinates, const FigurePoints<P, N, G>& figure, const BindOptions& options = {},
               const Running& running = {}) const {
        using T = typename C::scalar;
        Result<FigureBinding<T, C::dimension>, FigureBindReport> result;
        run_into(result.report, [&] {
            return read_figure<T, C::dimension>(figure, [&](FigureInput<T, C::dimension>& input) {
                return bind_read_figure(figure_input(coordinates, input.points), input, options, running,
                                        result);
            });
        });
        return result;
    }

    template <class Figure, BindsByMember<Figure> C, class... More>
    auto operator()(const C& coordinates, const Figure& figure, More&&... more) const {
        return coordinates.bind(figure, std::forward<More>(more)...);
    }

    // Accepts any further arguments, so that the first line that compilers print names the reason.
    template <CageCoordinates C, UnknownPointRange R, class... More>
    ReasonOr<PointTraitsNotSpecialisedForThesePoints,
             Result<Binding<typename C::scalar, C::dimension>, BindReport>>
    operator()(const C&, const R&, const More&...) const = CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;
    template <CageCoordinates C, PointRange R, class... More>
        requires(range_dimension<R> != C::dimension)
    ReasonOr<PointsOfAnotherDimensionThanTheCage,
             Result<Binding<typename C::scalar, C::dimension>, BindReport>>
    operator()(const C&, const R&, const More&...) const = CAGEFORM_DETAIL_DELETE_DIMENSION;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
