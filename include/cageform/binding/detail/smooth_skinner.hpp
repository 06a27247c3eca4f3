// Makes a smooth skin: solves for the weights of all points at once, then restores the reproduction of
// each point. smooth_skin.hpp includes this file, unless the program links cageform::compiled.
#pragma once

#include <cageform/binding/detail/near_weights.hpp>
#include <cageform/binding/detail/skinner.hpp>
#include <cageform/binding/detail/smooth_skin.hpp>
#include <cageform/binding/detail/smooth_weights.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

template <Scalar T, std::size_t D>
class SmoothSkinner {
public:
    SmoothSkinner(const BindingView<T, D>& binding, const SkinWeightsOptions& options, const Running& running)
        : binding_(binding)
        , options_(options)
        , running_(running)
        , measure_(binding) {}

    Status run(std::span<const MeshFace> triangles, SkinWeights& skin, SkinWeightsReport& report) {
        for (const auto& triangle : triangles) {
            for (const auto corner : triangle) {
                if (corner == no_vertex) return Status::index_out_of_range;
            }
        }
        weld();
        SmoothWeights<D> weights(handle_positions(), options_.influences);
        for (std::size_t n = 0; n < first_.size(); ++n) {
            const auto& point = points_[first_[n]];
            weights.add_node(measure_.frame_of(point).centre,
                             [&](std::size_t h) { return measure_.unfaded_weight(first_[n], point, h); });
        }
        for (const auto& triangle : triangles) {
            for (std::size_t k = 0; k < 3; ++k)
                weights.add_edge(node_[triangle[k]], node_[triangle[(k + 1) % 3]]);
        }
        const Running solving = running_.subtask(0, 0.9), storing = running_.subtask(0.9, 1);
        if (const Status status = weights.solve(solving); status != Status::ok) return status;

        std::vector<SkinnedPoint> points(binding_.point_count());
        const Status status = for_each_block(points.size(), storing, [&](std::size_t begin, std::size_t end) {
            NearWeights<D> nearest;
            ConvexWeights<D> convex;
            for (std::size_t i = begin; i < end; ++i) {
                if (!points_[i].is_bound) continue;
                points[i] = make(nearest, convex, i, weights, row_of(skin, i));
            }
        });
        if (status == Status::ok) gather_skin(points, report);
        return status;
    }

private:
    std::vector<Vec<double, D>> handle_positions() const {
        std::vector<Vec<double, D>> positions;
        for (std::size_t h = 0; h < binding_.handle_count(); ++h)
            positions.push_back(vec_cast<double>(binding_.rest_handles[h]));
        return positions;
    }

    /// Merges points with equal positions and weights into one node, so that seams stay closed.
    void weld() {
        std::map<std::array<double, D>, std::vector<std::size_t>> at; // nodes at a position
        for (std::size_t i = 0; i < binding_.point_count(); ++i) {
            const auto& point = points_.emplace_back(measure_.point_of(i));
            node_.push_back(SmoothWeights<D>::no_node);
            if (!point.is_bound) continue;
            std::array<double, D> key{};
            for (std::size_t k = 0; k < D; ++k) key[k] = point.p[k];
            auto& nodes = at[key];
            const auto same = std::find_if(nodes.begin(), nodes.end(), [&](std::size_t n) {
                for (std::size_t h = 0; h < binding_.handle_count(); ++h) {
                    if (binding_.weights(i, h) != binding_.weights(first_[n], h)) return false;
                }
                return true;
            });
            if (same == nodes.end()) {
                node_[i] = first_.size();
                nodes.push_back(first_.size());
                first_.push_back(i);
            } else {
                node_[i] = *same;
            }
        }
    }

    /// Returns the smooth weights of a point. If they do not reproduce its position, returns the
    /// closest weights that do, starting from the smooth weights for twice as many handles.
    SkinnedPoint make(NearWeights<D>& nearest, ConvexWeights<D>& convex, std::size_t i,
                      const SmoothWeights<D>& smooth, const SkinRow& row) const {
        const auto frame = measure_.frame_of(points_[i]);
        const auto store = [&](const auto& found, bool is_exact) {
            return measure_.store(i, points_[i], found, is_exact, row);
        };
        nearest.load(smooth.row(node_[i]), binding_.handle_view(), frame);
        if (nearest.reproduce(options_.threshold)) return store(nearest, true);
        if (options_.influences <= D) return store(nearest, false);
        const auto wide = smooth.wide_row(node_[i]);
        convex.load(binding_.handle_view(), frame, [&](std::size_t h) {
            const auto at = std::find_if(wide.begin(), wide.end(),
                                         [&](const HandleWeight& entry) { return entry.handle == h; });
            return at == wide.end() ? 0.0 : at->weight;
        });
        return store(convex, convex.reduce(options_.influences, options_.threshold));
    }

    const BindingView<T, D>& binding_;
    const SkinWeightsOptions& options_;
    const Running& running_;
    SkinMeasure<T, D> measure_;
    std::vector<typename SkinMeasure<T, D>::SkinPoint> points_; // #points
    std::vector<std::size_t> node_;                             // #points
    std::vector<std::size_t> first_;                            // #nodes: a point of each
};

template <class T, std::size_t D>
Status make_smooth_skin(const BindingView<T, D>& binding, std::span<const MeshFace> triangles,
                        const SkinWeightsOptions& options, const Running& running,
                        Result<SkinWeights, SkinWeightsReport>& result) {
    return SmoothSkinner<T, D>(binding, options, running).run(triangles, result.value, result.report);
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
