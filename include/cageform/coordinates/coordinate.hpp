// The concept that every coordinate type models, and functions for any such type.
#pragma once

#include <cageform/cage/cell_complex.hpp>
#include <cageform/cage/types/boundary_value.hpp>
#include <cageform/core/types/blocks.hpp>
#include <cageform/core/types/handles.hpp>
#include <cageform/grid/types/solver_report.hpp>
#include <cageform/parallel/running.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The arguments of `evaluate` and `evaluate_gradients`.
template <class T>
struct Batch {
    BlockView<const T> points;
    BlockView<T> rows; ///< out: weights or gradients
    std::span<PointState> states;
};

/// The constants of a coordinate type: scalar, dimension, whether weights are defined outside the cage, and
/// whether batches of any size cost the same per point.
template <class C>
concept CageCoordinateConstants = requires {
    typename C::scalar;
    requires Scalar<typename C::scalar>;
    { C::dimension } -> std::convertible_to<std::size_t>;
    { C::has_extension } -> std::convertible_to<bool>;
    { C::closed_form } -> std::convertible_to<bool>;
};

/// Coordinates of points with respect to a cage: one weight per *handle*. Handles are the cage's vertices;
/// some types have more, for example scaled face normals.
///
///   handles()           the handles at rest. A pose has as many points, in the same order
///   handle_kinds()      optional: the kind of each handle (core/types/handles.hpp). If absent or empty, all
///                       handles are points
///   handle_faces()      optional: the faces of the vector handles, in the order of those handles.
///                       `pose_handles` computes the vectors from a pose of the vertices
///   handle_loops()      optional, with handle_faces(): the table of loops whose means are corners of faces
///                       (HandleView)
///   cage_report()       faults of the cage. If its status is not ok, `evaluate` returns that status
///   has_extension       whether weights are defined outside the cage
///   closed_form         whether `bind` may evaluate small batches, which stay in the caches
///   local               optional: whether most weights of a point are exact zeros. `bind` then keeps the
///                       zeros when it restores linear precision
///   evaluate(points, weights, states, running)
///                       fills a batch: one row of `weights` per handle, and the state of each point. Points
///                       whose state is not_finite on entry are skipped. Weights of not_finite and unreached
///                       points are unspecified, and those of outside points if there is no extension. Every
///                       lane of the last block is written
///   nearest_boundary(p, row)
///                       returns the boundary point nearest to the finite point `p`, and fills its weights
///                       (#handles)
///   distance_outside(p) optional: the distance of an outside point from the cage, and its gradient, for
///                       BindOptions::falloff. Default: the distance from the nearest boundary point
template <class C>
concept CageCoordinates =
    CageCoordinateConstants<C> &&
    requires(const C& c, BlockView<const typename C::scalar> points, BlockView<typename C::scalar> weights,
             std::span<PointState> states, const Running& running,
             const Vec<typename C::scalar, C::dimension>& p, std::span<typename C::scalar> row) {
        { c.handles() } -> std::same_as<std::span<const Vec<typename C::scalar, C::dimension>>>;
        { c.cage_report() } -> std::same_as<const CageReport&>;
        { c.evaluate(points, weights, states, running) } -> std::same_as<Evaluation>;
        { c.nearest_boundary(p, row) } -> std::same_as<Vec<typename C::scalar, C::dimension>>;
    };

/// Coordinates with gradients.
///
///   evaluate_gradients(points, gradients, states, running)
///                       as `evaluate`, but row axis · #handles + handle holds the derivative of the handle's
///                       weight along the axis
template <class C>
concept GradientCoordinates =
    CageCoordinates<C> &&
    requires(const C& c, BlockView<const typename C::scalar> points, BlockView<typename C::scalar> gradients,
             std::span<PointState> states, const Running& running) {
        { c.evaluate_gradients(points, gradients, states, running) } -> std::same_as<Evaluation>;
    };

/// Returns the handles of a coordinate type, with their kinds and faces.
template <CageCoordinates C>
HandleView<typename C::scalar, C::dimension> handle_view(const C& coordinates) noexcept {
    HandleView<typename C::scalar, C::dimension> view(coordinates.handles());
    if constexpr (requires { coordinates.handle_kinds(); }) {
        const std::span<const HandleKind> kinds = coordinates.handle_kinds();
        CAGEFORM_ASSERT(kinds.empty() || kinds.size() == view.count, "a kind for every handle");
        if (!kinds.empty()) view.kinds = kinds.data();
    }
    if constexpr (requires { coordinates.handle_faces(); }) {
        const std::span<const HandleFace<C::dimension>> faces = coordinates.handle_faces();
        CAGEFORM_ASSERT(faces.empty() || faces.size() == view.vector_count(), "a face for every vector");
        if (!faces.empty()) view.faces = faces.data();
    }
    if constexpr (requires { coordinates.handle_loops(); }) {
        const std::span<const std::uint32_t> loops = coordinates.handle_loops();
        if (!loops.empty()) view.loops = loops.data();
    }
    return view;
}

/// Implements `nearest_boundary` for types whose handles are the cage's vertices and whose boundary values
/// are `data`. Returns the nearest boundary point and fills `row` (#V) with its weights.
template <class Cage, class Data = detail::LinearBoundaryData<Cage::dimension>>
Vec<typename Cage::scalar, Cage::dimension>
nearest_boundary_weights(const Cage& cage, const Vec<typename Cage::scalar, Cage::dimension>& p,
                         std::span<typename Cage::scalar> row, const Data& data = {}) noexcept {
    using T = typename Cage::scalar;
    Vec<T, Cage::dimension> position;
    const auto value = nearest_boundary_value(cage, p, position);
    std::fill(row.begin(), row.end(), T(0));
    const auto add = [&](std::uint32_t handle, double weight) { row[handle] += static_cast<T>(weight); };
    const Status status = detail::guard_memory([&] { data.for_each_weight(value, add); });
    if (status != Status::ok) // out of memory: linear on the point's facet
        detail::LinearBoundaryData<Cage::dimension>::for_each_weight(value, add);
    return position;
}

/// Computes the weights of a single point by `evaluate`.
///
///   weights  out, #handles; unchanged for points without weights
///   returns  the state of the point; unreached if `evaluate` fails
template <CageCoordinates C, Point P>
PointState weights_at(const C& coordinates, const P& point, std::span<typename C::scalar> weights) {
    using T = typename C::scalar;
    const std::size_t handles = coordinates.handles().size();
    CAGEFORM_ASSERT(weights.size() == handles, "one weight per handle");
    const auto p = to_vec<T>(point);
    if (!is_finite(p)) return PointState::not_finite;
    Lanes<T> position[C::dimension];
    for (std::size_t k = 0; k < C::dimension; ++k) {
        for (T& x : position[k].v) x = p[k];
    }
    std::vector<Lanes<T>> block;
    PointState state = PointState::unreached;
    const Status status = detail::guard_memory([&] {
        block.resize(handles);
        return coordinates.evaluate({position, C::dimension, 1}, {block.data(), handles, 1}, {&state, 1}, {})
            .status;
    });
    if (status != Status::ok) return PointState::unreached;
    if (state == PointState::unreached || (state == PointState::outside && !C::has_extension)) return state;
    for (std::size_t i = 0; i < handles; ++i) weights[i] = block[i][0];
    return state;
}

} // namespace cageform::inline CAGEFORM_ABI
