// A bounding volume hierarchy for ray, segment and nearest-item queries.
#pragma once

#include <cageform/core/types/bounds.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A bounding volume hierarchy of the items 0, …, n − 1. Boxes are halved along their longest side at the
/// median of the items' centres. Built in O(n log n); a query usually takes O(log n).
template <std::size_t D>
class BoxTree {
public:
    BoxTree() = default;
    ///   bounds_of_item  returns the bounds of an item, all finite
    template <class F>
    BoxTree(std::size_t count, const F& bounds_of_item)
        : order_(count) {
        std::iota(order_.begin(), order_.end(), std::uint32_t{0});
        std::vector<Box> boxes;
        boxes.reserve(count);
        for (std::uint32_t n = 0; n < count; ++n) boxes.push_back(bounds_of_item(n));
        if (count > 0) divide(boxes, 0, std::uint32_t(count));
    }

    bool is_empty() const noexcept { return nodes_.empty(); }
    /// Returns the bounds of all items; there must be at least one.
    const Bounds<double, D>& bounds() const noexcept { return nodes_[0].box; }

    /// Calls visit(item) for all items whose boxes come within `slack` of a segment, and for some others. The
    /// segment ends at from + length · direction; visit returns the new length.
    template <class Visit>
    void for_each_on_ray(const Vec<double, D>& from, const Vec<double, D>& direction, double length,
                         double slack, const Visit& visit) const {
        Vec<double, D> inverse{};
        for (std::size_t k = 0; k < D; ++k) inverse[k] = direction[k] == 0 ? 0 : 1 / direction[k];
        const auto meets = [&](const Box& box) {
            double begin = 0, end = length;
            for (std::size_t k = 0; k < D; ++k) {
                const double low = box.lower[k] - slack - from[k], high = box.upper[k] + slack - from[k];
                if (inverse[k] == 0) {
                    if (low > 0 || high < 0) return false;
                    continue;
                }
                const double a = low * inverse[k], b = high * inverse[k];
                begin = (std::max)(begin, (std::min)(a, b));
                end = (std::min)(end, (std::max)(a, b));
            }
            return begin <= end;
        };
        (void)any(meets, [&](std::uint32_t item) {
            length = visit(item);
            return false;
        });
    }

    /// Whether f(item) is true for any item whose box may meet the segment from p to q.
    template <class F>
    bool any_on_segment(const Vec<double, D>& p, const Vec<double, D>& q, const F& f) const {
        constexpr double least = 1e-290; // keeps the inverse finite
        constexpr double slack = 1e-9;   // in segment lengths, far above rounding
        Box segment{p, p};
        segment.include({q, q});
        Vec<double, D> inverse{}; // 0 along axes with almost no extent
        for (std::size_t k = 0; k < D; ++k) {
            if (segment.upper[k] - segment.lower[k] > least) inverse[k] = 1 / (q[k] - p[k]);
        }
        const auto may_meet = [&](const Box& box) {
            if (!segment.overlaps(box)) return false;
            double first = -slack, last = 1 + slack;
            for (std::size_t k = 0; k < D; ++k) {
                if (inverse[k] == 0) continue;
                const double s = (box.lower[k] - p[k]) * inverse[k], t = (box.upper[k] - p[k]) * inverse[k];
                first = (std::max)(first, (std::min)(s, t) - slack);
                last = (std::min)(last, (std::max)(s, t) + slack);
            }
            return first <= last;
        };
        return any(may_meet, f);
    }

    /// Calls visit(item) for all items whose boxes are at most as far from q as the nearest item so far, and
    /// for some others. Near boxes are visited first. `distance2` is the initial squared distance; visit
    /// returns the squared distance of the nearest item so far.
    template <class Visit>
    void for_each_near(const Vec<double, D>& q, double distance2, const Visit& visit) const {
        if (!nodes_.empty()) find_near(0, q, distance2, visit);
    }

private:
    using Box = Bounds<double, D>;
    struct Node {
        Box box;
        std::uint32_t begin, end; ///< range of items in `order_`
        std::uint32_t second;     ///< the second child; the first is the next node. 0 for a leaf
    };
    static constexpr std::uint32_t leaf = 4; ///< maximum number of items in a leaf

    std::uint32_t divide(const std::vector<Box>& boxes, std::uint32_t begin, std::uint32_t end) {
        Box box = boxes[order_[begin]];
        for (std::uint32_t n = begin + 1; n < end; ++n) box.include(boxes[order_[n]]);
        const auto number = std::uint32_t(nodes_.size());
        nodes_.push_back({box, begin, end, 0});
        if (end - begin <= leaf) return number;
        std::size_t axis = 0;
        for (std::size_t k = 1; k < D; ++k) {
            if (box.upper[k] - box.lower[k] > box.upper[axis] - box.lower[axis]) axis = k;
        }
        const std::uint32_t middle = begin + (end - begin) / 2;
        const auto key = [&](std::uint32_t n) {
            return std::pair(boxes[n].lower[axis] + boxes[n].upper[axis], n);
        };
        std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                         [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
        divide(boxes, begin, middle);
        const std::uint32_t second = divide(boxes, middle, end);
        nodes_[number].second = second;
        return number;
    }

    /// Whether f(item) is true for any item in nodes whose boxes satisfy `meets`.
    template <class Meets, class F>
    bool any(const Meets& meets, const F& f) const {
        std::array<std::uint32_t, 64> stack; // the tree of at most 2^32 items has 32 levels
        stack[0] = 0;
        std::size_t count = nodes_.empty() ? 0 : 1;
        while (count > 0) {
            const std::uint32_t number = stack[--count];
            const Node& node = nodes_[number];
            if (!meets(node.box)) continue;
            if (node.second != 0) {
                stack[count++] = node.second;
                stack[count++] = number + 1;
                continue;
            }
            for (std::uint32_t n = node.begin; n < node.end; ++n) {
                if (f(order_[n])) return true;
            }
        }
        return false;
    }

    static double distance2_to(const Box& box, const Vec<double, D>& q) noexcept {
        double sum = 0;
        for (std::size_t k = 0; k < D; ++k) {
            const double x = (std::max)((std::max)(box.lower[k] - q[k], q[k] - box.upper[k]), 0.0);
            sum += x * x;
        }
        return sum;
    }
    template <class Visit>
    void find_near(std::uint32_t number, const Vec<double, D>& q, double& best, const Visit& visit) const {
        const Node& node = nodes_[number];
        if (node.second == 0) {
            for (std::uint32_t n = node.begin; n < node.end; ++n) best = visit(order_[n]);
            return;
        }
        std::uint32_t nearer = number + 1, farther = node.second;
        double least = distance2_to(nodes_[nearer].box, q), most = distance2_to(nodes_[farther].box, q);
        if (most < least) {
            std::swap(nearer, farther);
            std::swap(least, most);
        }
        if (least <= best) find_near(nearer, q, best, visit);
        if (most <= best) find_near(farther, q, best, visit);
    }

    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
