// What bones say about the places in and about them.
#pragma once

#include <cageform/cage/detail/boundary_value.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI {

/// A bone where it lies.
template <std::size_t D>
struct PlacedBone {
    std::uint32_t i, j; ///< handles
    Vec<double, D> a, b;
    double radius;

    bool has(std::uint32_t handle) const noexcept { return handle == i || handle == j; }
    /// The distance of a place from the surface, negative within.
    double distance(const Vec<double, D>& p) const noexcept {
        return detail::distance_to_segment(p, a, b) - radius;
    }
};

/// What a bone says at a place: the value of its nearest place.
template <std::size_t D>
BoundaryValue<D> bone_value(const PlacedBone<D>& bone, const Vec<double, D>& p) noexcept {
    const double s = detail::part_of_segment(p, bone.a, bone.b);
    BoundaryValue<D> value;
    value.handle.fill(bone.i);
    value.handle[1] = bone.j;
    value.weight[0] = 1 - s;
    value.weight[1] = s;
    return value;
}

/// What bones say at a place.
template <std::size_t D>
struct BoneHit {
    double distance = 0; ///< from the surface of the nearest, negative within
    BoundaryValue<D> value;
};

namespace detail {

template <std::size_t D>
struct DeepBone {
    double depth = 0; ///< of a place below the surface
    PlacedBone<D> bone{};
};

/// The mean of what up to three bones say at a place, by the depths. Nullopt where they have more
/// handles together than a value can hold: where they share no joint, which `check` refuses.
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

} // namespace detail

/// What bones bone(0) … bone(count − 1) say at a place no farther than `reach` from the surface of
/// one. Where several overlap, as bones do at joints, the mean of what they say, by how deep the
/// place lies in each, so that it is continuous. (Of more than three bones at a joint, that of the
/// deepest three.)
template <std::size_t D, class Bones>
std::optional<BoneHit<D>> nearest_bone(std::size_t count, const Bones& bone, const Vec<double, D>& p,
                                       double reach) noexcept {
    std::array<detail::DeepBone<D>, 3> deepest{};
    std::optional<PlacedBone<D>> nearest;
    for (std::size_t n = 0; n < count; ++n) {
        const PlacedBone<D> one = bone(n);
        const double distance = one.distance(p);
        if (distance <= reach) {
            reach = distance;
            nearest = one;
        }
        detail::DeepBone<D> candidate{-distance, one};
        for (auto& known : deepest) {
            if (candidate.depth > known.depth) std::swap(candidate, known);
        }
    }
    if (!nearest) return std::nullopt;
    const auto mean = deepest[1].depth > 0 ? detail::mean_value_of(deepest, p) : std::nullopt;
    return BoneHit<D>{reach, mean ? *mean : bone_value(*nearest, p)};
}

} // namespace cageform::inline CAGEFORM_ABI
