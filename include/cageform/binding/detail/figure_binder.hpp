// Reads the points, normals and tangents of a figure to bind.
#pragma once

#include <cageform/binding/detail/binders.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Converts tangents of three or four numbers to three numbers and the handedness.
template <class Tangents>
auto without_sign(const Tangents& tangents, std::vector<std::int8_t>& handedness) {
    using S = range_scalar_t<Tangents>;
    std::vector<Vec<S, 3>> result(std::size(tangents));
    handedness.assign(result.size(), 1);
    for (std::size_t i = 0; i < result.size(); ++i) {
        const auto t = to_vec<S>(tangents[i]);
        result[i] = {t[0], t[1], t[2]};
        if constexpr (range_dimension<Tangents> == 4) handedness[i] = t[3] < 0 ? -1 : 1;
    }
    return result;
}

/// Converts the normals of a figure to tangents and calls read(tangents, handedness).
template <Scalar T, class Figure, class Read>
Status read_tangents(const Figure& figure, const Read& read) {
    std::vector<std::int8_t> handedness;
    if (std::size(figure.normals) != std::size(figure.points)) return Status::vectors_do_not_match;
    if constexpr (is_wanted<decltype(figure.tangents)>) {
        if (std::size(figure.tangents) != std::size(figure.points)) return Status::vectors_do_not_match;
        const auto own = without_sign(figure.tangents, handedness);
        const auto tangents = tangents_of(figure.normals, own);
        return read(tangents, std::move(handedness));
    } else {
        const auto tangents = tangents_of(figure.normals);
        return read(tangents, std::move(handedness));
    }
}

/// Reads a figure and calls bind(input), which returns a Status. The input is valid only during the call.
template <Scalar T, std::size_t D, class Figure, class BindFigure>
Status read_figure(const Figure& figure, const BindFigure& bind) {
    FigureInput<T, D> input{read_points<T>(figure.points), {}, {}};
    if constexpr (is_wanted<decltype(figure.normals)>) {
        return read_tangents<T>(figure, [&](const auto& tangents, std::vector<std::int8_t> handedness) {
            for (std::size_t k = 0; k < tangents.size(); ++k) input.tangents[k] = read_points<T>(tangents[k]);
            input.handedness = std::move(handedness);
            return bind(input);
        });
    } else {
        return bind(input);
    }
}

// One concept per argument, so that compilers name the violated one.
template <class P, class C>
concept PointsFor = PointRangeIn<P, C::dimension> && (C::dimension == 2 || C::dimension == 3);
template <class N, class C>
concept NormalsFor = !is_wanted<N> || (GradientCoordinates<C> && PointRangeIn<N, C::dimension>);
template <class N, std::size_t D>
concept NormalsIn = !is_wanted<N> || PointRangeIn<N, D>;
template <class G, class N, std::size_t D>
concept TangentsIn = !is_wanted<G> || (is_wanted<N> && D == 3 && (PointRangeIn<G, 3> || PointRangeIn<G, 4>));

/// Coordinates that bind by a member function; see AnyCoordinates.
template <class C, class Figure>
concept BindsByMember = !CageCoordinates<C> && requires(const C& c, const Figure& figure) { c.bind(figure); };

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
