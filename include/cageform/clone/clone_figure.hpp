// Moves a whole figure every frame: points, normals and tangents in one call.
#pragma once

#include <cageform/clone/detail/check_figure_clone.hpp>
#include <cageform/clone/normals.hpp>
#include <cageform/figure/figure.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The output of a figure's `clone`: `FigureOutput{points, normals, tangents}`. Tangents, or normals and
/// tangents, may be left out. Refers to lvalue arguments; stores temporary views.
///
///   points    as for `clone`
///   normals   any MutablePointRange of at least #points points
///   tangents  as normals. If its elements have four numbers, the fourth becomes the texture's handedness, 1
///             or −1, as in glTF
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

/// A PackedFigureView, or a type whose view() returns one, such as FigureBinding.
template <class F>
concept AnyFigure = detail::is_figure_view<decltype(detail::view_of(std::declval<const F&>()))>;

/// Moves a figure with a pose of its handles. The results are bitwise those of `clone` for points and of
/// `clone_tangent_frames` for normals and tangents.
///
///   figure        from `open` or `bind`
///   pose          any PointRange of #handles points
///   out           see FigureOutput; in the order of the bound points
///   parallel_for  see core/types/parallel_for.hpp; no effect on the result
///   returns       vectors_missing (`out` has normals or tangents that were not bound); bindings_differ; or
///                 as `clone`. `out` is untouched unless the status is ok
///   cost          one clone per binding; no allocation
template <AnyFigure F, PointRangeIn<F::dimension> Pose, class P, class N, class G, class Parallel = SerialFor>
    requires(MutablePointRangeIn<P, F::dimension> && detail::NormalsOut<N, F::dimension> &&
             detail::TangentsOut<G, F::dimension>)
Status clone(const F& figure, const Pose& pose, FigureOutput<P, N, G> out,
             const Parallel& parallel_for = {}) noexcept {
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

/// Moves only the points of a figure.
template <AnyFigure F, PointRangeIn<F::dimension> Pose, MutablePointRangeIn<F::dimension> Points,
          class Parallel = SerialFor>
Status clone(const F& figure, const Pose& pose, Points&& points, const Parallel& parallel_for = {}) noexcept {
    return clone(detail::view_of(figure).points, pose, points, {}, parallel_for);
}

} // namespace cageform::inline CAGEFORM_ABI
