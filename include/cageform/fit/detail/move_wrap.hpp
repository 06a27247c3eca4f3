// Evaluates coordinates for a wrap, and applies a wrap to points.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/pose_samples/pose_sampler.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/fit/detail/find_wrap.hpp>
#include <cageform/fit/detail/wrap_lattice.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

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
    LinearMap<double, 3> box;
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) box.at[r][c] = double(wrap.lattice->box().columns[c][r]);
    }
    const LinearMap<double, 3> to_box = inverse(box);
    std::vector<Point> pose;
    pose.reserve(wrap.lattice_pose.size());
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
        moved.reserve(std::size(points));
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

} // namespace cageform::inline CAGEFORM_ABI::detail
