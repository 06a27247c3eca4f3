// Checks the arguments of a figure's clone, and stores tangents with their handedness.
#pragma once

#include <cageform/clone/detail/check_clone.hpp>
#include <cageform/core/view.hpp>
#include <cageform/figure/figure.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class V>
inline constexpr bool is_figure_view = false;
template <class T, std::size_t D>
inline constexpr bool is_figure_view<PackedFigureView<T, D>> = true;

template <class Out, std::size_t D>
concept NormalsOut = !is_wanted<Out> || MutablePointRangeIn<Out, D>;
template <class Out, std::size_t D>
concept TangentsOut =
    !is_wanted<Out> || (D == 3 && (MutablePointRangeIn<Out, 3> || MutablePointRangeIn<Out, 4>));

/// Stores tangents of three numbers, or of four with the handedness last.
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

/// Checks all arguments of a figure's clone.
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
        static_assert(normals, "an output with tangents needs normals");
        if (!figure.has_tangents()) return Status::vectors_missing;
        if (std::size(out.tangents) < figure.point_count()) return Status::output_too_small;
    }
    return check_clone(figure.points, pose, out.points);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
