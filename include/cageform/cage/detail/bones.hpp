// The boundary values of bones at points inside and near them.
#pragma once

#include <cageform/cage/types/boundary_value.hpp>
#include <cageform/cage/types/interior_cells.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T, std::size_t D>
    requires(D == 2 || D == 3)
class CellComplex; // in cage/cell_complex.hpp

namespace detail {

/// A bone with the positions of its end points.
template <std::size_t D>
struct PlacedBone {
    std::uint32_t i, j; ///< handles
    Vec<double, D> a, b;
    double radius;

    bool has(std::uint32_t handle) const noexcept { return handle == i || handle == j; }
    /// Returns the distance of a point from the bone's surface, negative inside.
    double distance(const Vec<double, D>& p) const noexcept { return distance_to_segment(p, a, b) - radius; }
};

/// Returns the boundary value of a bone at the bone's point nearest to `p`.
template <std::size_t D>
BoundaryValue<D> bone_value(const PlacedBone<D>& bone, const Vec<double, D>& p) noexcept {
    const double s = segment_parameter(p, bone.a, bone.b);
    BoundaryValue<D> value;
    value.handle.fill(bone.i);
    value.handle[1] = bone.j;
    value.weight[0] = 1 - s;
    value.weight[1] = s;
    return value;
}

/// The boundary value of bones at a point, and the point's distance.
template <std::size_t D>
struct BoneHit {
    double distance = 0; ///< from the surface of the nearest bone, negative inside
    BoundaryValue<D> value;
};

/// Returns a bone of a complex with the positions of its vertices.
template <Scalar T, std::size_t D>
PlacedBone<D> placed_bone(const CellComplex<T, D>& cage, const Bone& bone) noexcept {
    return {bone.i, bone.j, vec_cast<double>(cage[bone.i]), vec_cast<double>(cage[bone.j]), bone.radius};
}

template <std::size_t D>
struct DeepBone {
    double depth = 0; ///< distance of the point below the bone's surface
    PlacedBone<D> bone{};
};

/// Returns the mean of the values of up to three bones, weighted by the point's depths in these bones.
/// Returns nullopt if the bones have more handles than a value can hold. This happens only for overlapping
/// bones without a common joint, which `check` refuses.
template <std::size_t D>
std::optional<BoundaryValue<D>> mean_value_of(const std::array<DeepBone<D>, 3>& deepest,
                                              const Vec<double, D>& p) noexcept {
    BoundaryValue<D> mean;
    mean.handle.fill(deepest[0].bone.i);
    const double sum = deepest[0].depth + deepest[1].depth + deepest[2].depth;
    auto end = mean.handle.begin();
    for (const auto& [depth, bone] : deepest) {
        if (!(depth > 0)) break;
        const auto value = bone_value(bone, p);
        for (std::size_t n = 0; n < 2; ++n) {
            if (value.weight[n] == 0) continue;
            const auto slot = std::find(mean.handle.begin(), end, value.handle[n]);
            if (slot == mean.handle.end()) return std::nullopt;
            *slot = value.handle[n];
            mean.weight[std::size_t(slot - mean.handle.begin())] += depth / sum * value.weight[n];
            end = (std::max)(end, slot + 1);
        }
    }
    return mean;
}

/// Returns the boundary value of bone(0) … bone(count − 1) at a point, and the distance of the point from the
/// nearest surface, negative inside. Returns nullopt if this distance exceeds `reach`. Where bones overlap,
/// as at joints, the value is a mean of their values. The weights are the point's depths in the bones, so the
/// value is continuous. Only the three deepest bones count.
template <std::size_t D, class Bones>
std::optional<BoneHit<D>> nearest_bone(std::size_t count, const Bones& bone, const Vec<double, D>& p,
                                       double reach) noexcept {
    std::array<DeepBone<D>, 3> deepest{};
    std::optional<PlacedBone<D>> nearest;
    for (std::size_t n = 0; n < count; ++n) {
        const PlacedBone<D> one = bone(n);
        const double distance = one.distance(p);
        if (distance <= reach) {
            reach = distance;
            nearest = one;
        }
        DeepBone<D> candidate{-distance, one};
        for (auto& known : deepest) {
            if (candidate.depth > known.depth) std::swap(candidate, known);
        }
    }
    if (!nearest) return std::nullopt;
    const auto mean = deepest[1].depth > 0 ? mean_value_of(deepest, p) : std::nullopt;
    return BoneHit<D>{reach, mean ? *mean : bone_value(*nearest, p)};
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
