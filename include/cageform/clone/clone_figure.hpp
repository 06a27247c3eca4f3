// Moves a whole figure every frame: points, normals and tangents in one call.
#pragma once

#include <cageform/clone/detail/check_figure_clone.hpp>
#include <cageform/clone/normals.hpp>
#include <cageform/figure/figure.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The output of a figure's `clone`: `FigureOutput{points, normals, tangents}`. Tangents, or normals
/// and tangents, can be left out. It refers to lvalue arguments and stores views that are temporaries.
///
///   points    as for `clone`
///   normals   any MutablePointRange of at least #points points
///   tangents  likewise; if its points have four numbers, the fourth becomes the handedness of
///             the texture, 1 or −1, as in glTF
template <class Points, class Normals = NoVectors, class Tangents = NoVectors>
struct FigureOutput {
    Points points;
    Normals normals{};
    Tangents tangents{};
};
template <class Points>
FigureOutput(Points&&) -> FigureOutput<Points>;
template <class Points, class Normals>
FigureOutput(Points&&, Normals&&) -> FigureOutput<Points, Normals>;
template <class Points, class Normals, class Tangents>
FigureOutput(Points&&, Normals&&, Tangents&&) -> FigureOutput<Points, Normals, Tangents>;

/// A bound figure: a PackedFigureView, or any type whose view() returns one, such as FigureBinding.
template <class F>
concept AnyFigure = detail::is_figure_view<decltype(detail::view_of(std::declval<const F&>()))>;

/// Moves a figure with a pose of its handles. Points move as `clone` of their binding moves them,
/// normals and tangents as `clone_tangent_frames` moves them, to the bit.
///
///   figure        opened by `open`, or bound by `bind`
///   pose          any PointRange of #handles points
///   out           see FigureOutput. It is indexed as the points were when bound
///   parallel_for  see core/types/parallel_for.hpp; the result does not depend on it
///   returns       vectors_missing, if normals or tangents are requested that were not bound;
///                 bindings_differ; or as `clone`. Nothing is written unless it is ok
///   cost          that of a clone by each binding; no allocation
template <AnyFigure F, PointRangeIn<F::dimension> Pose, class P, class N, class G, class Parallel = SerialFor>
    requires(MutablePointRangeIn<P, F::dimension>&& detail::NormalsOut<N, F::dimension>&&
                 detail::TangentsOut<G, F::dimension>)
Status clone(const F& figure, const Pose& pose, FigureOutput<P, N, G> out, const Parallel& parallel_for = {})
noexcept {
    const auto view = detail::view_of(figure);
    Status status = detail::check_figure_clone(view, pose, out);
    if (status == Status::ok) status = clone(view.points, pose, out.points, {}, parallel_for);
    if constexpr (detail::is_wanted<N>) {
        if (status != Status::ok) return status;
        detail::for_moved_frames(view.tangents, pose, parallel_for, [&](std::size_t i, const auto& frame) {
            store_point(out.normals, i, frame.normal);
            if constexpr (detail::is_wanted<G>)
                detail::SignedTangents<std::remove_reference_t<G>>{out.tangents, view.handedness}.store(
                    i, frame.tangent);
        });
    }
    return status;
}

/// Moves the points of a figure alone.
template <AnyFigure F, PointRangeIn<F::dimension> Pose, MutablePointRangeIn<F::dimension> Points,
          class Parallel = SerialFor>
Status clone(const F& figure, const Pose& pose, Points&& points, const Parallel& parallel_for = {}) noexcept {
    return clone(detail::view_of(figure).points, pose, points, {}, parallel_for);
}

} // namespace cageform::inline CAGEFORM_ABI
