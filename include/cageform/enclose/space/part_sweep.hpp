// find_parts, step 2: extremities, and fronts that sweep the surface from them.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/core/detail/disjoint_sets.hpp>
#include <cageform/enclose/space/part_surface.hpp>

#include <numbers>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Mean distance of the surface from each vertex (Hilaga et al., Topology matching, SIGGRAPH 2001, sec. 4.1),
/// estimated from 48 evenly spread samples.
inline std::vector<double> mean_distances(const PartSurface& surface) {
    constexpr std::size_t places = 48;
    const auto farthest = [](const std::vector<double>& distance) {
        return std::uint32_t(std::max_element(distance.begin(), distance.end()) - distance.begin());
    };
    std::vector<std::vector<double>> all;
    std::vector<double> least(surface.size(), std::numeric_limits<double>::infinity());
    std::vector<std::size_t> nearest(surface.size());
    const auto add = [&](std::uint32_t place) {
        all.push_back(surface.distances(std::array{place}));
        for (std::size_t v = 0; v < least.size(); ++v) {
            if (!(all.back()[v] < least[v])) continue;
            least[v] = all.back()[v];
            nearest[v] = all.size() - 1;
        }
    };
    std::uint32_t next = farthest(surface.distances(std::array{std::uint32_t{0}}));
    while (all.size() < places) {
        add(next);
        if (surface.image(next) != next) add(surface.image(next));
        next = farthest(least);
    }
    std::vector<double> weight(all.size());
    for (std::size_t v = 0; v < nearest.size(); ++v)
        weight[nearest[v]] += surface.area(v) / surface.total_area();
    std::vector<double> mean(surface.size());
    for (std::size_t n = 0; n < all.size(); ++n) {
        for (std::size_t v = 0; v < mean.size(); ++v) mean[v] += weight[n] * all[n][v];
    }
    surface.make_symmetric(mean);
    return mean;
}

/// Local maxima of a function with a prominence above `least`, most prominent first; at most `most`.
inline std::vector<std::uint32_t> extremities(const PartSurface& surface, const std::vector<double>& f,
                                              double least, std::size_t most) {
    DisjointSets sets(f.size());
    auto order = first_indices<std::uint32_t>(f.size());
    std::stable_sort(order.begin(), order.end(), [&](auto v, auto w) { return f[v] > f[w]; });
    std::vector<bool> above(f.size());
    std::vector<std::uint32_t> top(f.size()), rank(f.size()); // maximum of each set; position in `order`
    for (std::uint32_t n = 0; n < f.size(); ++n) rank[order[n]] = n;
    std::vector<std::pair<double, std::uint32_t>> found;
    for (const auto v : order) {
        above[v] = true;
        top[v] = v;
        for (const auto w : surface.around(v)) {
            if (!above[w]) continue;
            auto high = top[sets.find(w)], low = top[sets.find(v)];
            if (!sets.join(v, w)) continue;
            if (rank[low] < rank[high]) std::swap(high, low);
            if (f[low] - f[v] > least) found.push_back({f[low] - f[v], low});
            top[sets.find(v)] = high;
        }
    }
    found.push_back({std::numeric_limits<double>::infinity(), order.front()});
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& p, const auto& q) { return p.first > q.first; });
    std::vector<std::uint32_t> places;
    for (std::size_t n = 0; n < (std::min)(most, found.size()); ++n) places.push_back(found[n].second);
    return places;
}

/// A front at a given distance, and the area that it has swept. If the rest of the surface has several
/// pieces, all except the largest piece count as swept.
struct SweptArea {
    double distance = 0, area = 0, border = 0;
    std::vector<bool> rest; ///< vertices not swept

    /// 1 for a disk, 2 for a hemisphere.
    double compactness() const noexcept {
        return border > 0 ? 4 * std::numbers::pi * area / (border * border) : 0;
    }
};

inline SweptArea swept_area(const PartSurface& surface, const std::vector<double>& distance, double at) {
    SweptArea swept{at, surface.total_area(), 0, std::vector<bool>(surface.size())};
    constexpr std::uint32_t none = ~std::uint32_t{0};
    std::vector<std::uint32_t> piece(surface.size(), none), stack;
    std::vector<double> areas;
    for (std::uint32_t start = 0; start < piece.size(); ++start) {
        if (distance[start] < at || piece[start] != none) continue;
        const auto number = std::uint32_t(areas.size());
        areas.push_back(0);
        piece[start] = number;
        stack.push_back(start);
        while (!stack.empty()) {
            const auto v = stack.back();
            stack.pop_back();
            areas[number] += surface.area(v);
            for (const auto w : surface.around(v)) {
                if (distance[w] < at || piece[w] != none) continue;
                piece[w] = number;
                stack.push_back(w);
            }
        }
    }
    if (areas.empty()) return swept;
    const auto largest = std::uint32_t(std::max_element(areas.begin(), areas.end()) - areas.begin());
    swept.area -= areas[largest];
    for (std::uint32_t v = 0; v < piece.size(); ++v) swept.rest[v] = piece[v] == largest;
    if (surface.is_mirrored()) { // an asymmetric rest would make an asymmetric part
        for (std::uint32_t v = 0; v < piece.size(); ++v) {
            if (swept.rest[v] && distance[v] == distance[surface.image(v)] && !swept.rest[surface.image(v)])
                return swept;
        }
    }
    for (const auto& face : surface.faces()) {
        std::array<Vec<double, 3>, 2> ends;
        std::size_t count = 0;
        bool is_here = false;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto v = face[k], w = face[(k + 1) % 3];
            is_here |= piece[v] == largest;
            if ((distance[v] < at) == (distance[w] < at)) continue;
            const double t = (at - distance[v]) / (distance[w] - distance[v]);
            ends[count++] = surface[v] + t * (surface[w] - surface[v]);
        }
        if (count < 2 || !is_here) continue;
        swept.border += length(ends[1] - ends[0]);
    }
    return swept;
}

/// A joint found by a sweep lies between two fronts.
struct SweptJoint {
    double compactness = 0;
    SweptArea before, behind;
};

/// Minimum compactness of a part.
inline constexpr double least_compactness = 2.6;

/// Joints passed by a front from an extremity: maxima of the compactness after which it falls by the factor
/// `fall`. Areas above half of the surface are no parts.
inline std::vector<SweptJoint> swept_joints(const PartSurface& surface, const std::vector<double>& distance) {
    constexpr int fronts = 96;
    constexpr double fall = 1.6;
    const double end = *std::max_element(distance.begin(), distance.end());
    std::vector<SweptArea> all;
    std::vector<SweptJoint> joints;
    std::size_t best = 0;
    bool rises = true;
    for (int n = 1; n < fronts; ++n) {
        auto swept = swept_area(surface, distance, end * n / fronts);
        if (swept.border == 0) continue;
        all.push_back(std::move(swept));
        const std::size_t last = all.size() - 1;
        const double here = all[last].compactness();
        if (rises ? here > all[best].compactness() : here < all[best].compactness()) best = last;
        if (rises && fall * here < all[best].compactness()) {
            const auto& at = all[best];
            if (at.area > 0.5 * surface.total_area()) break;
            if (at.compactness() >= least_compactness) {
                // The fronts are at least one limb radius before and behind the joint.
                const double thick = at.border / (2 * std::numbers::pi);
                joints.push_back(
                    {at.compactness(), swept_area(surface, distance, at.distance - thick),
                     swept_area(surface, distance, (std::max)(all[last].distance, at.distance + thick))});
            }
            rises = false;
            best = last;
        } else if (!rises && here > fall * all[best].compactness()) {
            rises = true;
            best = last;
        }
    }
    return joints;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
