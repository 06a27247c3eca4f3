// Bones (points and edges with a radius) as parts of a boundary on a lattice.
#pragma once

#include <cageform/cage/cell_complex.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/lattice/grid_boundary.hpp>

#include <algorithm>

namespace cageform::inline CAGEFORM_ABI::grid {

/// The bones of a cage: discs or balls around points, capsules around edges. All positions and distances
/// are in units of the lattice.
template <std::size_t D>
class GridBones {
public:
    using Index = typename NodeRuns<D>::Index;

    /// `vertices` are in units of the lattice, the radii of `bones` in units of the cage.
    GridBones(std::span<const Bone> bones, std::span<const Vec<double, D>> vertices,
              const Lattice<double, D>& lattice)
        : lattice_(lattice) {
        for (const auto& [i, j, radius] : bones) {
            // Clamped so that the square of a huge radius stays finite.
            bones_.push_back({i, j, vertices[i], vertices[j], (std::min)(radius / lattice.spacing, 1e100)});
        }
    }

    std::size_t size() const noexcept { return bones_.size(); }

    const detail::PlacedBone<D>& operator[](std::size_t n) const noexcept { return bones_[n]; }

    /// Returns a handle of a bone that is thinner than a cell and has too few nodes, or nullopt.
    std::optional<std::uint32_t> too_thin() const noexcept {
        for (const detail::PlacedBone<D>& bone : bones_) {
            if (bone.radius < 0.5) return bone.i;
        }
        return std::nullopt;
    }

    /// Adds the crossings of lattice lines with the surfaces of bones. O(lines that meet their boxes ·
    /// bones).
    void add_crossings(Crossings<D>& all) const {
        for (std::size_t axis = 0; axis < D; ++axis) {
            for (const detail::PlacedBone<D>& bone : bones_) {
                for_each_node_near(bone, axis, [&](const Index& index) {
                    auto p = node_position<D>(index);
                    const Interval chord = chord_of(bone, p, axis);
                    if (chord.is_empty()) return;
                    for (const double x : {chord.low, chord.high}) {
                        // Clamped to the range of an index.
                        p[axis] = std::fmin(std::fmax(x, -2), double(lattice_.counts()[axis] + 1));
                        all[axis].push_back({lattice_.line(axis, index), false, p[axis], value_on(bone, p)});
                    }
                });
            }
        }
    }

    Buffer<FixedNode<D>> nodes() const {
        Buffer<FixedNode<D>> all;
        for (const detail::PlacedBone<D>& bone : bones_) {
            for_each_node_near(bone, D, [&](const Index& index) {
                if (const auto hit = nearest(node_position<D>(index), on_boundary_distance))
                    all.push_back({index, hit->value});
            });
        }
        const auto by_index = [](const FixedNode<D>& a, const FixedNode<D>& b) { return a.index < b.index; };
        const auto same = [](const FixedNode<D>& a, const FixedNode<D>& b) { return a.index == b.index; };
        std::sort(all.begin(), all.end(), by_index);
        all.erase_from(std::unique(all.begin(), all.end(), same));
        return all;
    }

    /// Returns the distance and the value of the bones at a point if the distance is at most `reach`.
    /// O(bones).
    std::optional<detail::BoneHit<D>> nearest(const Vec<double, D>& p, double reach) const noexcept {
        return detail::nearest_bone<D>(
            bones_.size(), [&](std::size_t n) -> const detail::PlacedBone<D>& { return bones_[n]; }, p,
            reach);
    }

    /// Returns the point where a ray meets bone `n`, or the start of the ray if the start lies within the
    /// bone.
    std::optional<Hit<D>> hit(std::size_t n, const AxisRay<D>& ray) const noexcept {
        const double from = ray.from[ray.axis];
        const Interval chord = chord_of(bones_[n], ray.from, ray.axis);
        if (chord.is_empty() || ray.distance(ray.up ? chord.high : chord.low) < 0) return std::nullopt;
        const double position = ray.up ? std::fmax(chord.low, from) : std::fmin(chord.high, from);
        if (ray.distance(position) > ray.length) return std::nullopt;
        auto p = ray.from;
        p[ray.axis] = position;
        return Hit<D>{position, value_on(bones_[n], p)};
    }

    /// Calls f(lower corner) for the cells of the lattice near bone `n`. O(cells in its box).
    template <class F>
    void for_each_cell(std::size_t n, F&& f) const {
        const detail::PlacedBone<D>& bone = bones_[n];
        // Slightly more than half a cell diagonal.
        const double reach = bone.radius + 0.51 * std::sqrt(double(D));
        for_each_node_near(bone, D, [&](const Index& index) {
            auto middle = node_position<D>(index);
            for (std::size_t k = 0; k < D; ++k) middle[k] += 0.5;
            if (detail::distance_to_segment(middle, bone.a, bone.b) <= reach) f(index);
        });
    }

private:
    struct Interval {
        double low = (std::numeric_limits<double>::max)(), high = -low; ///< empty if low > high

        bool is_empty() const noexcept { return low > high; }
        void extend(const Interval& other) noexcept {
            if (other.is_empty()) return;
            low = std::fmin(low, other.low);
            high = std::fmax(high, other.high);
        }
    };

    /// Returns the value at a point on or in a bone: the mean over all bones that overlap there.
    BoundaryValue<D> value_on(const detail::PlacedBone<D>& bone, const Vec<double, D>& p) const noexcept {
        const auto hit = nearest(p, on_boundary_distance);
        return hit ? hit->value : detail::bone_value(bone, p);
    }

    /// Calls f(node) for the nodes of the lattice in a box around a bone: one per line along `axis`, or all
    /// if `axis` is D.
    template <class F>
    void for_each_node_near(const detail::PlacedBone<D>& bone, std::size_t axis, F&& f) const {
        Index low{}, high{};
        const Index counts = lattice_.counts();
        for (std::size_t k = 0; k < D; ++k) {
            if (k == axis) continue;
            const double least = std::fmin(bone.a[k], bone.b[k]) - bone.radius - 1;
            const double most = std::fmax(bone.a[k], bone.b[k]) + bone.radius;
            // Clamped to the range of an index, because a bone may be far away.
            low[k] = std::int32_t(std::fmin(std::fmax(std::floor(least), 0), double(counts[k])));
            high[k] = std::int32_t(std::fmax(std::fmin(std::ceil(most), double(counts[k] - 1)), -1));
            if (low[k] > high[k]) return;
        }
        Index index = low;
        for (std::size_t k = 0; k < D;) {
            f(index);
            for (k = 0; k < D; ++k) {
                if (++index[k] <= high[k]) break;
                index[k] = low[k];
            }
        }
    }

    /// Returns the part of the line through `p` along an axis that lies in a bone. Because a capsule is
    /// convex, this part is the hull of three intersections: with the two balls around the ends, and with the
    /// cylinder between them.
    static Interval chord_of(const detail::PlacedBone<D>& bone, const Vec<double, D>& p,
                             std::size_t axis) noexcept {
        Interval chord;
        for (const auto& end : {bone.a, bone.b}) {
            auto across = p - end;
            across[axis] = 0;
            const double h2 = bone.radius * bone.radius - dot(across, across);
            if (h2 >= 0) chord.extend({end[axis] - std::sqrt(h2), end[axis] + std::sqrt(h2)});
        }
        chord.extend(chord_of_cylinder(bone, p, axis));
        return chord;
    }
    static Interval chord_of_cylinder(const detail::PlacedBone<D>& bone, const Vec<double, D>& p,
                                      std::size_t axis) noexcept {
        const auto e = bone.b - bone.a;
        const double e2 = dot(e, e), across2 = e2 - e[axis] * e[axis];
        // The bone is parallel to the line: the balls contain the intersection, up to rounding.
        if (!(across2 > 1e-12 * e2)) return {};
        auto m = p - bone.a;
        m[axis] = 0; // positions along the line are relative to a
        // At position t the squared distance from the cylinder's axis is |m + t u|² minus the square of its
        // component along e. It equals r² where a t² + 2 b t + c = 0.
        const double me = dot(m, e), a = across2 / e2, b = -me * e[axis] / e2;
        const double c = dot(m, m) - me * me / e2 - bone.radius * bone.radius, root = b * b - a * c;
        if (!(root >= 0)) return {};
        double begin = (-b - std::sqrt(root)) / a, end = (-b + std::sqrt(root)) / a;
        if (e[axis] != 0) { // clip to the planes through the ends
            const double first = -me / e[axis], last = (e2 - me) / e[axis];
            begin = std::fmax(begin, std::fmin(first, last));
            end = std::fmin(end, std::fmax(first, last));
        } else if (me < 0 || me > e2) {
            return {};
        }
        return {bone.a[axis] + begin, bone.a[axis] + end};
    }

    Lattice<double, D> lattice_;
    Buffer<detail::PlacedBone<D>> bones_;
};

} // namespace cageform::inline CAGEFORM_ABI::grid
