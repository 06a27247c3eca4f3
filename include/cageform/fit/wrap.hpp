// Wraps one figure onto another: finds a pose of a lattice, or of a cage, that lays a source on a target. The
// map moves all of space, so clothes, hair and joints of the source can follow.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/detail/sampled_coordinates.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/fit/detail/find_wrap.hpp>
#include <cageform/fit/detail/wrap_lattice.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Evaluates the weights of coordinates, or their derivatives along the axes, at points in double.
template <class C>
Status evaluate_for_wrap(const C& coordinates, std::span<const Vec<double, 3>> points, bool derivatives,
                         const Running& running, DenseRows& rows) {
    using T = typename C::scalar;
    std::vector<Vec<T, 3>> places;
    for (const auto& p : points) places.push_back(vec_cast<T>(p));
    const std::size_t handles = handle_view(coordinates).count, count = points.size();
    rows.handles = handles;
    rows.weights.assign((derivatives ? 3 : 1) * count * handles, 0);
    if (count == 0) return Status::ok;
    const Running silent{running.parallel, {}};
    if (!derivatives) {
        const auto [binding, report] = bind(coordinates, places, BindOptions{}, silent);
        for (std::size_t n = 0; report.status == Status::ok && n < count; ++n) {
            for (std::size_t i = 0; i < handles; ++i)
                rows.weights[n * handles + i] = double(binding.weight(n, i));
        }
        return report.status;
    }
    const auto [axes, report] = bind_jacobians(coordinates, places, {}, silent);
    for (std::size_t n = 0; report.status == Status::ok && n < count; ++n) {
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t i = 0; i < handles; ++i)
                rows.weights[(3 * n + k) * handles + i] = double(axes[k].weight(n, i));
        }
    }
    return report.status;
}

} // namespace detail

/// Wraps a source onto a target by a lattice of cubic B-splines. The search needs no landmarks if both
/// figures have about the same pose. No step folds space at the samples, at the vertices of the source, or at
/// the followers.
///
///     const auto [wrap, report] = cageform::wrap({body, body_faces}, {scan, scan_faces});
///     Status status = move(wrap, clothes, clothes_on_scan);
///
///   source, target  triangle meshes of any topology; open, noisy or in parts. Both must have the same
///                   direction of up and front, unless three or more landmarks align them
///   returns         the map, and a report. For cancelled and fit_not_reached, the best map so far
///   cost            see fit/README.md; about 6 s for bodies of 13,000 vertices; memory about 200 MB
///   fails           figure_empty; figure_not_finite (a vertex); index_out_of_range (a face);
///                   figure_has_no_size; value_not_finite (a landmark, a follower or an option);
///                   weights_not_positive (a landmark); fit_not_reached (less than half of the source or of
///                   the target has a match); cancelled; out_of_memory. The report names the culprit
template <Scalar T = double>
Result<Wrap<T>, WrapReport> wrap(const SurfaceMesh& source, const SurfaceMesh& target,
                                 const WrapOptions& options = {}, const Running& running = {}) {
    Result<Wrap<T>, WrapReport> result;
    WrapReport timed;
    detail::run_into(timed,
                     [&] { return detail::find_wrap(source, target, options, nullptr, running, result); });
    result.report.status = timed.status;
    result.report.seconds = timed.seconds;
    return result;
}

/// Wraps by a pose of a cage, then by a lattice behind the cage (WrapOptions::finest; 0: the cage alone). The
/// pose is one for `clone`, with all that is bound to the cage.
///
///   coordinates  any with gradients. Coordinates without weights outside keep points outside near the cage
///   cost         as above, plus the weights of all vertices, followers and samples; O(#handles) memory for
///                each of them
///   fails        as above, and as the cage's check and `bind_jacobians`
template <detail::SampledCoordinates C>
    requires(C::dimension == 3)
Result<Wrap<typename C::scalar>, WrapReport> wrap(const C& coordinates, const SurfaceMesh& source,
                                                  const SurfaceMesh& target, const WrapOptions& options = {},
                                                  const Running& running = {}) {
    using T = typename C::scalar;
    Result<Wrap<T>, WrapReport> result;
    WrapReport timed;
    detail::run_into(timed, [&] {
        if (coordinates.cage_report().status != Status::ok) return coordinates.cage_report().status;
        C solved = coordinates; // keeps its functions for all calls
        if constexpr (requires(C& c) { c.solve(running); }) {
            const Status status = solved.solve(running.subtask(0, 0.2)).status;
            if (status != Status::ok) return status;
        }
        const auto handles = handle_view(solved);
        detail::WrapCageInput cage;
        for (std::size_t i = 0; i < handles.count; ++i) {
            cage.rest.push_back(vec_cast<double>(handles.rest[i]));
            cage.is_point.push_back(handles.is_point(i) ? 1 : 0);
        }
        cage.evaluate = [&](std::span<const Vec<double, 3>> points, bool derivatives,
                            detail::DenseRows& rows) {
            return detail::evaluate_for_wrap(solved, points, derivatives, running, rows);
        };
        return detail::find_wrap(source, target, options, &cage, running.subtask(0.2, 1), result);
    });
    result.report.status = timed.status;
    result.report.seconds = timed.seconds;
    return result;
}

namespace detail {

/// Multiplies the Jacobians of points by another map's, J ← K J.
template <Scalar T>
void multiply_from_left(const std::array<Vec<double, 3>, 3>& columns, std::array<Vec<T, 3>, 3>& jacobian) {
    for (auto& image : jacobian) {
        const auto v = vec_cast<double>(image);
        image = vec_cast<T>(v[0] * columns[0] + (v[1] * columns[1] + v[2] * columns[2]));
    }
}

/// Moves points by `first` and the lattice of a wrap. `jacobians` (#points, or empty) are multiplied.
template <Scalar T>
Status move_by_lattice(const Wrap<T>& wrap, std::vector<Vec<T, 3>>& points,
                       std::vector<std::array<Vec<T, 3>, 3>>& jacobians, const Running& running) {
    for (auto& p : points) p = wrap.first.map_vector(p) + wrap.first.translation;
    for (auto& j : jacobians) {
        for (auto& column : j) column = wrap.first.map_vector(column);
    }
    if (!wrap.lattice) return Status::ok;
    if (wrap.lattice_pose.size() != wrap.lattice->handles().size()) return Status::pose_size_differs;
    const WrapLattice lattice(*wrap.lattice);
    const LinearMap<double, 3> to_box = inverse_columns(wrap.lattice->box());
    std::vector<Point> pose;
    for (const auto& p : wrap.lattice_pose) pose.push_back(vec_cast<double>(p));
    return for_each_block((points.size() + 255) / 256, running, [&](std::size_t first, std::size_t last) {
        LatticeRows rows, slopes;
        std::vector<Point> places;
        for (std::size_t b = first; b < last; ++b) {
            const std::size_t begin = 256 * b, end = (std::min)(begin + 256, points.size());
            places.clear();
            for (std::size_t n = begin; n < end; ++n)
                places.push_back(
                    product(to_box, vec_cast<double>(points[n] - wrap.lattice->box().translation)));
            (void)lattice.weights(places, rows);
            if (!jacobians.empty()) (void)lattice.gradients(places, {}, slopes);
            for (std::size_t n = begin; n < end; ++n) {
                points[n] = vec_cast<T>(rows.product(n - begin, pose));
                if (jacobians.empty()) continue;
                std::array<Point, 3> columns{};
                for (std::size_t k = 0; k < 3; ++k) {
                    const Point along = slopes.product(3 * (n - begin) + k, pose);
                    for (std::size_t c = 0; c < 3; ++c) columns[c] = columns[c] + to_box.at[k][c] * along;
                }
                multiply_from_left(columns, jacobians[n]);
            }
        }
    });
}

template <class C, Scalar T>
Status move_by_cage(const Wrap<T>& wrap, const C& coordinates, std::vector<Vec<T, 3>>& points,
                    std::vector<std::array<Vec<T, 3>, 3>>& jacobians, const Running& running) {
    if (wrap.pose.size() != handle_view(coordinates).count) return Status::pose_size_differs;
    const Running silent{running.parallel, {}};
    if (!jacobians.empty()) {
        const auto [axes, bound] = bind_jacobians(coordinates, points, {}, silent);
        if (bound.status != Status::ok) return bound.status;
        std::vector<T> matrices(9 * points.size());
        const Status status =
            clone_jacobians(axes, wrap.pose, StridedMatrices<T, 3>(matrices.data(), points.size()));
        if (status != Status::ok) return status;
        for (std::size_t n = 0; n < 9 * points.size(); ++n) jacobians[n / 9][n / 3 % 3][n % 3] = matrices[n];
    }
    const auto [binding, report] = bind(coordinates, points, BindOptions{}, silent);
    if (report.status != Status::ok) return report.status;
    return clone(binding, wrap.pose, points);
}

/// Reads points, calls map(points, jacobians), and writes the results if its status is ok.
template <Scalar T, class R, class Out, class Map>
Status move_with(const R& points, Out& out, std::span<std::array<Vec<T, 3>, 3>> jacobians, const Map& map) {
    if (std::size(out) < std::size(points) || (!jacobians.empty() && jacobians.size() < std::size(points)))
        return Status::output_too_small;
    return guard_memory([&] {
        std::vector<Vec<T, 3>> moved;
        for (std::size_t i = 0; i < std::size(points); ++i) moved.push_back(to_vec<T>(points[i]));
        std::vector<std::array<Vec<T, 3>, 3>> matrices;
        if (!jacobians.empty()) matrices.assign(moved.size(), {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
        const Status status = map(moved, matrices);
        if (status != Status::ok) return status;
        for (std::size_t i = 0; i < moved.size(); ++i) store_point(out, i, moved[i]);
        std::copy(matrices.begin(), matrices.end(), jacobians.begin());
        return Status::ok;
    });
}

} // namespace detail

/// Moves points by a wrap without a cage.
///
///   points     in the space of the source; may be `out`
///   out        at least #points
///   jacobians  out: the columns of the Jacobian of the map at each point; or empty
///   cost       that of `bind` to the lattice, 64 weights per point: about 2 µs
///   fails      bindings_differ (the wrap has a cage: pass its coordinates); output_too_small; as `bind`;
///              cancelled; out_of_memory. `out` is then unchanged
template <Scalar T, PointRangeIn<3> R, MutablePointRangeIn<3> Out>
Status move(const Wrap<T>& wrap, const R& points, Out&& out,
            std::type_identity_t<std::span<std::array<Vec<T, 3>, 3>>> jacobians = {},
            const Running& running = {}) {
    if (!wrap.pose.empty()) return Status::bindings_differ;
    return detail::move_with<T>(points, out, jacobians, [&](auto& moved, auto& matrices) {
        return detail::move_by_lattice(wrap, moved, matrices, running);
    });
}

/// Moves points by a wrap with a cage.
///
///   coordinates  those of the wrap
///   fails        pose_size_differs (the coordinates have another number of handles); as above
template <detail::SampledCoordinates C, PointRangeIn<3> R, MutablePointRangeIn<3> Out>
Status move(const Wrap<typename C::scalar>& wrap, const C& coordinates, const R& points, Out&& out,
            std::type_identity_t<std::span<std::array<Vec<typename C::scalar, 3>, 3>>> jacobians = {},
            const Running& running = {}) {
    using T = typename C::scalar;
    return detail::move_with<T>(points, out, jacobians, [&](auto& moved, auto& matrices) {
        const Status status = detail::move_by_cage(wrap, coordinates, moved, matrices, running);
        return status == Status::ok ? detail::move_by_lattice(wrap, moved, matrices, running) : status;
    });
}

} // namespace cageform::inline CAGEFORM_ABI
