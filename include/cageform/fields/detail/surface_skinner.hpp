// Computes bone weights on a mesh: harmonic weights, and bone heat.
#pragma once

#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/fields/detail/face_tree.hpp>
#include <cageform/fields/surface.hpp>
#include <cageform/fields/types/surface_skin.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

struct NearestBones {
    double distance = std::numeric_limits<double>::infinity();
    std::vector<std::uint32_t> bones; ///< all bones at this distance up to rounding, ascending
};

/// Computes c / d² for distances d. The largest value is clamped to the range in which it affects the
/// weights, so that numbers stay finite.
class HeatScale {
public:
    HeatScale(double heat, std::span<const NearestBones> nearest) noexcept {
        for (const auto& each : nearest) least_ = std::fmin(least_, at_least(each.distance));
        most_ = std::clamp(heat / least_ / least_, 1e-100, 1e200);
    }
    double of(double distance) const noexcept {
        const double ratio = least_ / at_least(distance);
        return most_ * ratio * ratio;
    }

private:
    /// Returns a distance of at least 1e-6. At smaller distances the bone alone determines the weight, up to
    /// rounding.
    static double at_least(double distance) noexcept { return std::fmax(distance, 1e-6); }

    double least_ = std::numeric_limits<double>::infinity();
    double most_ = 0;
};

/// Computes the weights, in units of the mesh's size.
class SurfaceSkinner {
public:
    SurfaceSkinner(std::span<const BoneSegment> bones, const SurfaceSkinOptions& options,
                   SurfaceSkinReport& report)
        : bones_(bones.begin(), bones.end())
        , options_(options)
        , report_(report) {}

    template <class R, class F>
    Status load(const R& points, const F& faces) {
        auto weights = cotangent_weights(points, faces);
        report_.mesh = std::move(weights.report);
        if (report_.mesh.status != Status::ok) return report_.mesh.status;
        mesh_ = std::move(weights.value);
        if (bones_.empty()) return Status::bone_weights_do_not_match;
        for (std::size_t b = 0; b < bones_.size(); ++b) {
            for (auto* end : {&bones_[b].head, &bones_[b].tail}) {
                *end = scaled(*end);
                constexpr double most = 1e200; // so that squares of distances do not overflow
                if (dot(*end, *end) <= most) continue;
                report_.solver.culprit = b;
                return Status::value_not_finite;
            }
        }
        positions_ = positions_in_space(points);
        for (auto& position : positions_) position = scaled(position);
        for (std::size_t f = 0; f < std::size(faces); ++f)
            faces_.push_back(checked_face(faces[f], positions_.size()));
        return Status::ok;
    }

    /// Computes weights that are 1 in the bone's own group, 0 in the groups of other bones, and harmonic
    /// elsewhere.
    Status solve_harmonic(const Running& running) {
        const std::size_t size = positions_.size();
        std::vector<std::uint32_t> groups(options_.groups.begin(), options_.groups.end());
        if (groups.empty()) groups = middle_thirds();
        if (groups.size() != size) return Status::labels_do_not_match;
        std::vector<std::uint8_t> given(size);
        values_.assign(size * bones_.size(), 0.0);
        std::vector<std::uint8_t> busy(bones_.size());
        for (std::size_t i = 0; i < size; ++i) {
            if (groups[i] == no_bone || mesh_.unused[i] != 0) continue;
            if (groups[i] >= bones_.size()) {
                report_.solver.culprit = i;
                return Status::index_out_of_range;
            }
            given[i] = busy[groups[i]] = 1;
            values_[groups[i] * size + i] = 1;
        }
        list_idle(busy);
        const auto evaluation = solve_surface(mesh_, given, std::span(values_), running);
        report_.solver = evaluation.solver;
        return evaluation.status;
    }

    /// Solves (L + M H) w = M H p on a graph with an additional node per bone, linked to its vertices.
    Status solve_heat(const Running& running) {
        if (!is_finite(options_.heat) || !(options_.heat > 0)) return Status::weights_not_positive;
        std::vector<NearestBones> nearest(positions_.size());
        const Status status = find_bones(running.subtask(0, 0.5), nearest);
        if (status != Status::ok) return status;
        const std::size_t size = positions_.size(), nodes = size + bones_.size();
        std::vector<GraphLink> links = mesh_.links;
        std::vector<std::uint8_t> given(mesh_.unused), busy(bones_.size());
        const HeatScale scale(options_.heat, nearest);
        for (std::size_t i = 0; i < size; ++i) {
            if (given[i] != 0) continue;
            const auto& bones = nearest[i].bones;
            if (bones.empty()) ++report_.hidden;
            for (const std::uint32_t b : bones) {
                const double heat = scale.of(nearest[i].distance) * mesh_.areas[i] / double(bones.size());
                links.push_back({std::uint32_t(i), std::uint32_t(size + b), heat});
                busy[b] = 1;
            }
        }
        list_idle(busy);
        given.insert(given.end(), bones_.size(), 1);
        std::vector<double> all(nodes * bones_.size(), 0.0);
        for (std::size_t b = 0; b < bones_.size(); ++b) all[b * nodes + size + b] = 1;
        const GraphOptions graph{.allow_negative = mesh_.has_negative};
        const auto evaluation =
            solve_graph(Graph{nodes, links}, given, std::span(all), graph, running.subtask(0.5, 1));
        report_.solver = evaluation.solver;
        if (evaluation.status != Status::ok) return evaluation.status;
        for (std::size_t b = 0; b < bones_.size(); ++b) {
            const auto field = all.begin() + std::ptrdiff_t(b * nodes);
            values_.insert(values_.end(), field, field + std::ptrdiff_t(size));
        }
        return Status::ok;
    }

    /// Returns the weights, contiguous per vertex. They are normalised, because with negative cotangents
    /// the sums may differ from 1 by 1e-6.
    template <Scalar T>
    std::vector<T> weights() const {
        const std::size_t size = positions_.size(), bones = bones_.size();
        std::vector<T> result(size * bones);
        for (std::size_t i = 0; i < size; ++i) {
            if (mesh_.unused[i] != 0) continue;
            double sum = 0;
            for (std::size_t b = 0; b < bones; ++b) sum += values_[b * size + i];
            for (std::size_t b = 0; b < bones; ++b)
                result[i * bones + b] = static_cast<T>(values_[b * size + i] / sum);
        }
        return result;
    }

private:
    Vec<double, 3> scaled(Vec<double, 3> p) const noexcept {
        for (std::size_t k = 0; k < 3; ++k) p[k] /= mesh_.unit;
        return p;
    }
    Vec<double, 3> foot(std::size_t bone, const Vec<double, 3>& p) const noexcept {
        return nearest_on_segment(p, bones_[bone].head, bones_[bone].tail);
    }

    NearestBones nearest_to(const Vec<double, 3>& p) const {
        constexpr double rounding = 1e-9; // bones at equal distance within this tolerance have equal shares
        NearestBones nearest;
        const auto is_near = [&](double distance) {
            return distance <= nearest.distance + rounding * (std::max)(nearest.distance, 1e-6);
        };
        for (std::uint32_t b = 0; b < bones_.size(); ++b) {
            const double distance = length(foot(b, p) - p);
            if (!is_near(distance)) continue;
            nearest.distance = (std::min)(nearest.distance, distance);
            nearest.bones.push_back(b);
        }
        std::erase_if(nearest.bones, [&](std::uint32_t b) { return !is_near(length(foot(b, p) - p)); });
        return nearest;
    }

    std::vector<std::uint32_t> middle_thirds() const {
        std::vector<std::uint32_t> groups;
        for (const auto& p : positions_) {
            const auto nearest = nearest_to(p);
            const BoneSegment& bone = bones_[nearest.bones.front()];
            const double parameter = segment_parameter(p, bone.head, bone.tail);
            const bool is_middle = bone.head == bone.tail || std::fabs(parameter - 0.5) <= 1.0 / 6;
            groups.push_back(nearest.bones.size() == 1 && is_middle ? nearest.bones.front() : no_bone);
        }
        return groups;
    }

    /// Finds the nearest bones of every vertex, without those that are not visible.
    Status find_bones(const Running& running, std::vector<NearestBones>& nearest) {
        const bool tests_visibility = options_.visibility == BoneVisibility::inside;
        if (tests_visibility && report_.mesh.rim_edges > 0) {
            const auto half_edges = half_edges_of(faces_);
            for_each_edge(half_edges, [&](std::span<const HalfEdge> edge) {
                const auto [low, high] = edge[0].edge();
                if (edge.size() == 1) report_.mesh.mesh.add(CageFaultKind::open_edge, low, high);
            });
            return report_.mesh.mesh.status;
        }
        const FaceTree tree(positions_, tests_visibility ? std::span<const MeshFace>(faces_)
                                                         : std::span<const MeshFace>());
        return for_each_block(positions_.size(), running, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (mesh_.unused[i] != 0) continue;
                nearest[i] = nearest_to(positions_[i]);
                if (!tests_visibility) continue;
                std::erase_if(nearest[i].bones, [&](std::uint32_t b) {
                    const auto q = foot(b, positions_[i]);
                    if (q == positions_[i]) return false;
                    return !tree.is_free(std::uint32_t(i), q) || !tree.encloses(0.5 * (positions_[i] + q));
                });
            }
        });
    }

    void list_idle(const std::vector<std::uint8_t>& busy) {
        for (std::size_t b = 0; b < busy.size(); ++b) {
            if (busy[b] == 0) report_.idle_bones.push_back(b);
        }
    }

    std::vector<BoneSegment> bones_;
    const SurfaceSkinOptions& options_;
    SurfaceSkinReport& report_;
    CotangentWeights mesh_;
    std::vector<Vec<double, 3>> positions_;
    std::vector<MeshFace> faces_;
    std::vector<double> values_; ///< contiguous per bone
};

template <class R, class F, class Solve>
Result<std::vector<range_scalar_t<R>>, SurfaceSkinReport>
surface_skin(const R& points, const F& faces, std::span<const BoneSegment> bones,
             const SurfaceSkinOptions& options, const Solve& solve) {
    Result<std::vector<range_scalar_t<R>>, SurfaceSkinReport> skin;
    run_into(skin.report, [&] {
        SurfaceSkinner skinner(bones, options, skin.report);
        Status status = skinner.load(points, faces);
        if (status == Status::ok) status = solve(skinner);
        if (status == Status::ok) skin.value = skinner.template weights<range_scalar_t<R>>();
        return status;
    });
    return skin;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
