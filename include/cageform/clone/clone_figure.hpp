// Moves a whole figure every frame: points, normals and tangents in one call.
#pragma once

#include <cageform/binding/figure.hpp>
#include <cageform/clone/normals.hpp>

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

namespace detail {

template <class V>
inline constexpr bool is_figure_view = false;
template <class T, std::size_t D>
inline constexpr bool is_figure_view<PackedFigureView<T, D>> = true;

template <class Out, std::size_t D>
concept NormalsOut = !is_wanted<Out> || MutablePointRangeIn<Out, D>;
template <class Out, std::size_t D>
concept TangentsOut =
    !is_wanted<Out> || (D == 3 && (MutablePointRangeIn<Out, 3> || MutablePointRangeIn<Out, 4>));

/// Writes tangents of four numbers, the last of which is the handedness, or of three.
template <class Out>
struct SignedTangents {
    Out& out;
    const std::int8_t* handedness;

    template <class T>
    void store(std::size_t i, const Vec<T, 3>& t) const noexcept {
        if constexpr (range_dimension<Out> == 4) {
            store_point(out, i, Vec<T, 4>{t[0], t[1], t[2], T(handedness[i])});
        } else {
            store_point(out, i, t);
        }
    }
};

/// Checks everything for which a clone of the figure can be refused.
template <Scalar T, std::size_t D, class Pose, class Output>
Status check_figure_clone(const PackedFigureView<T, D>& figure, const Pose& pose,
                          const Output& out) noexcept {
    constexpr bool normals = is_wanted<decltype(out.normals)>, tangents = is_wanted<decltype(out.tangents)>;
    if constexpr (normals) {
        if (!figure.has_normals()) return Status::vectors_missing;
        if (std::size(out.normals) < figure.point_count()) return Status::output_too_small;
        for (const auto& vectors : figure.tangents) {
            if (!bindings_match(figure.points, vectors)) return Status::bindings_differ;
        }
    }
    if constexpr (tangents) {
        static_assert(normals, "tangents are orthogonal to normals, and come with them");
        if (!figure.has_tangents()) return Status::vectors_missing;
        if (std::size(out.tangents) < figure.point_count()) return Status::output_too_small;
    }
    return check_clone(figure.points, pose, out.points);
}

} // namespace detail

/// A bound figure: a PackedFigureView, or any type whose view() returns one, such as FigureBinding.
template <class F>
concept AnyFigure = detail::is_figure_view<decltype(detail::view_of(std::declval<const F&>()))>;

/// Moves a figure with a pose of its handles. Points move as `clone` of their binding moves them,
/// normals and tangents as `clone_tangent_frames` moves them, to the bit.
///
///   figure        opened by `open`, or bound by `bind`
///   pose          any PointRange of #handles points
///   out           see FigureOutput. It is indexed as the points were when bound
///   parallel_for  see core/detail/parallel.hpp; the result does not depend on it
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
