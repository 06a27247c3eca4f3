// Finds the pairs of intersecting facets by recursive bisection of a box around them.
#pragma once

#include <cageform/cage/detail/primitives.hpp>

#include <cstdint>
#include <optional>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the bounds of a facet clipped to a box, or nullopt if the facet lies outside. Clips against one
/// side of the box after the other (Sutherland, Hodgman 1974).
template <std::size_t D>
std::optional<Bounds<double, D>> clipped_bounds(const Corners<D>& corner,
                                                const Bounds<double, D>& box) noexcept {
    // Each of the 2 D sides adds at most one corner, apart from rounding.
    std::array<Vec<double, D>, 4 * D> from{}, to{};
    std::size_t count = D;
    std::copy(corner.begin(), corner.end(), from.begin());
    for (std::size_t side = 0; side < 2 * D; ++side) {
        const std::size_t axis = side / 2;
        const double sign = side % 2 == 0 ? 1 : -1;
        const double limit = sign * (side % 2 == 0 ? box.upper : box.lower)[axis];
        std::size_t kept = 0;
        for (std::size_t k = 0; k < count; ++k) {
            if (kept + 2 > to.size()) return box;
            const auto &a = from[k], &b = from[(k + 1) % count];
            const double beyond_a = sign * a[axis] - limit, beyond_b = sign * b[axis] - limit;
            if (beyond_a <= 0) to[kept++] = a;
            if ((beyond_a < 0 && beyond_b > 0) || (beyond_a > 0 && beyond_b < 0)) {
                to[kept] = a + (beyond_a / (beyond_a - beyond_b)) * (b - a);
                to[kept++][axis] = sign * limit;
            }
        }
        if (kept == 0) return std::nullopt;
        count = kept;
        from = to;
    }
    return bounds_of(std::span<const Vec<double, D>>(from.data(), count));
}

/// Finds the pairs of intersecting facets.
///
/// Recursively divides a box around all facets, at the position that leaves the fewest pairs (`best_split`).
/// Stops when a cell has few pairs, or when no division reduces their number. Facets are clipped to their
/// cells, which separates slivers with overlapping bounds. Usually O(n log n), O(n²) at worst.
template <std::size_t D>
class FacetPairs {
public:
    /// `groups` has the group of each facet. Facets of the same group are not paired, unless the group is
    /// no_group. Facets up to `margin` apart may count as meeting.
    FacetPairs(std::span<const Facet<D>> facets, std::span<const std::uint32_t> groups, double margin)
        : facets_(facets)
        , groups_(groups)
        , margin_(margin)
        , cells_of_(facets.size()) {}

    static constexpr std::uint32_t no_group = ~std::uint32_t{0};

    /// Calls found(m, n), m < n, once for every pair with meet(m, n), in a deterministic order. `meet` may
    /// be called several times for a pair.
    template <class Meet, class Found>
    void for_each(const Meet& meet, const Found& found) {
        std::vector<Item> items;
        items.reserve(facets_.size());
        for (std::uint32_t n = 0; n < facets_.size(); ++n) items.push_back({n, facets_[n].bounds()});
        // Keep groups contiguous; later steps only remove items, which preserves this.
        std::sort(items.begin(), items.end(), [&](const Item& a, const Item& b) {
            return group(a) != group(b) ? group(a) < group(b) : a.facet < b.facet;
        });
        divide(std::move(items), meet, found);
    }

private:
    struct Item {
        std::uint32_t facet;
        Bounds<double, D> bounds; ///< of the clipped facet
    };
    using Items = std::vector<Item>;
    struct InCell {
        std::uint32_t cell;
        Bounds<double, D> bounds;
    };

    std::uint32_t group(const Item& item) const noexcept {
        return groups_.empty() ? no_group : groups_[item.facet];
    }

    /// Counts the pairs among items added one by one, group by group.
    struct PairCount {
        double items = 0, pairs = 0, in_group = 0;
        std::uint32_t last = no_group;
        void add(std::uint32_t group) noexcept {
            in_group = group != no_group && group == last ? in_group + 1 : 0;
            last = group;
            pairs += items - in_group;
            ++items;
        }
    };

    struct Split {
        std::size_t axis = 0;
        double at = 0;
        double pairs = std::numeric_limits<double>::infinity(); ///< in both halves together
    };
    Split split_at(const Items& items, std::size_t axis, double at) const noexcept {
        PairCount lower, upper;
        for (const Item& item : items) {
            if (item.bounds.lower[axis] - margin_ <= at) lower.add(group(item));
            if (item.bounds.upper[axis] + margin_ >= at) upper.add(group(item));
        }
        return {axis, at, lower.pairs + upper.pairs};
    }
    /// Returns the best split over all axes, at the median of the items' centres or at the centre of their
    /// range. The median suits items of many scales, the centre suits two clusters.
    Split best_split(const Items& items) const {
        Split best;
        std::vector<double> middles(items.size());
        for (std::size_t axis = 0; axis < D; ++axis) {
            std::transform(items.begin(), items.end(), middles.begin(), [&](const Item& item) {
                return 0.5 * item.bounds.lower[axis] + 0.5 * item.bounds.upper[axis];
            });
            const auto [least, most] = std::minmax_element(middles.begin(), middles.end());
            const double middle = 0.5 * *least + 0.5 * *most;
            const auto median = middles.begin() + std::ptrdiff_t(middles.size() / 2);
            std::nth_element(middles.begin(), median, middles.end());
            for (const double at : {*median, middle}) {
                const Split split = split_at(items, axis, at);
                if (split.pairs < best.pairs) best = split;
            }
        }
        return best;
    }

    /// Returns the items that intersect a box, clipped to it. If `only` is a group, clips only the items of
    /// this group and keeps all others.
    Items clipped(const Items& items, const Bounds<double, D>& box, std::uint32_t only) const {
        Items inside;
        for (const Item& item : items) {
            if (only != no_group && group(item) != only) {
                inside.push_back(item);
                continue;
            }
            Bounds<double, D> common = item.bounds;
            for (std::size_t k = 0; k < D; ++k) {
                common.lower[k] = std::fmax(common.lower[k], box.lower[k]);
                common.upper[k] = std::fmin(common.upper[k], box.upper[k]);
            }
            common = common.widened(margin_);
            if (!common.overlaps(common)) continue;
            if (common.covers(item.bounds)) {
                inside.push_back(item);
            } else if (const auto bounds = clipped_bounds(facets_[item.facet].corner, common)) {
                inside.push_back({item.facet, *bounds});
            }
        }
        return inside;
    }

    static Bounds<double, D> everywhere() noexcept {
        Bounds<double, D> box;
        for (std::size_t k = 0; k < D; ++k) {
            box.lower[k] = std::numeric_limits<double>::lowest();
            box.upper[k] = (std::numeric_limits<double>::max)();
        }
        return box;
    }

    /// If one group has more than half of the items, clips this group to the bounds of the other items. Items
    /// of one group form no pairs. Halving alone does not separate slivers at an apex from other faces.
    Items cropped(Items items) const {
        std::size_t begin = 0, end = end_of_group(items, 0);
        while (2 * (end - begin) <= items.size() && end < items.size()) {
            begin = end;
            end = end_of_group(items, begin);
        }
        if (2 * (end - begin) <= items.size()) return items;
        auto others = bounds_of(std::span<const Vec<double, D>>());
        for (std::size_t i = 0; i < items.size(); ++i) {
            if (begin <= i && i < end) continue;
            for (std::size_t k = 0; k < D; ++k) {
                others.lower[k] = std::fmin(others.lower[k], items[i].bounds.lower[k]);
                others.upper[k] = std::fmax(others.upper[k], items[i].bounds.upper[k]);
            }
        }
        return clipped(items, others.widened(margin_), group(items[begin]));
    }

    template <class Meet, class Found>
    void divide(Items items, const Meet& meet, const Found& found) {
        constexpr double few = 8;      // pairs per item: testing them costs about as much as halving
        constexpr double helps = 0.95; // bounds the cost of halving by a small multiple of testing all pairs
        PairCount count;
        for (const Item& item : items) count.add(group(item));
        if (count.pairs == 0) return;
        Split split;
        if (count.pairs > few * count.items) {
            items = cropped(std::move(items));
            split = best_split(items);
        }
        if (!(split.pairs < helps * count.pairs)) return test_pairs(items, meet, found);
        auto lower = everywhere(), upper = everywhere();
        lower.upper[split.axis] = upper.lower[split.axis] = split.at;
        Items lower_items = clipped(items, lower, no_group);
        items = clipped(items, upper, no_group);
        divide(std::move(lower_items), meet, found);
        divide(std::move(items), meet, found);
    }

    template <class Meet, class Found>
    void test_pairs(const Items& items, const Meet& meet, const Found& found) {
        for (std::size_t i = 0, end = 0; i < items.size(); ++i) {
            if (i == end) end = end_of_group(items, i);
            for (std::size_t j = end; j < items.size(); ++j) {
                if (!are_near(items[i].bounds, items[j].bounds)) continue;
                const std::size_t m = (std::min)(items[i].facet, items[j].facet);
                const std::size_t n = (std::max)(items[i].facet, items[j].facet);
                if (meet(m, n) && !found_before(m, n)) found(m, n);
            }
        }
        for (const Item& item : items) cells_of_[item.facet].push_back({cells_, item.bounds});
        ++cells_;
    }
    bool are_near(const Bounds<double, D>& a, const Bounds<double, D>& b) const noexcept {
        return a.widened(2 * margin_).overlaps(b);
    }
    std::size_t end_of_group(const Items& items, std::size_t i) const noexcept {
        std::size_t end = i + 1;
        while (end < items.size() && group(items[i]) != no_group && group(items[end]) == group(items[i]))
            ++end;
        return end;
    }
    /// Whether an earlier cell contained both facets, clipped to bounds near each other, and so tested them.
    bool found_before(std::size_t m, std::size_t n) const noexcept {
        const auto &a = cells_of_[m], &b = cells_of_[n];
        for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
            if (a[i].cell == b[j].cell && are_near(a[i].bounds, b[j].bounds)) return true;
            ++(a[i].cell <= b[j].cell ? i : j);
        }
        return false;
    }

    std::span<const Facet<D>> facets_;
    std::span<const std::uint32_t> groups_;
    double margin_;
    std::vector<std::vector<InCell>> cells_of_; ///< per facet, ascending
    std::uint32_t cells_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
