// A kd-tree that finds the points nearest to a given one.
#pragma once

#include <cageform/core/vec.hpp>

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A kd-tree: points are halved at the median along the longest side, recursively. It compares
/// squared distances, so coordinates should be of order one. Built in O(n log n); a search usually
/// takes O(log n + count).
template <std::size_t D>
class PointTree {
public:
    struct Neighbour {
        double squared = 0; ///< distance
        std::size_t point = 0;

        friend bool operator<(const Neighbour& a, const Neighbour& b) noexcept {
            return a.squared != b.squared ? a.squared < b.squared : a.point < b.point;
        }
    };

    PointTree() = default;
    /// All points must be finite.
    explicit PointTree(const std::vector<Vec<double, D>>& points)
        : axes_(points.size())
        , order_(points.size()) {
        std::iota(order_.begin(), order_.end(), std::size_t{0});
        divide(points, 0, points.size());
        for (const std::size_t i : order_) places_.push_back(points[i]);
    }

    /// Finds the `count` points nearest to `p` for which wanted(point) holds, the nearest first, of
    /// equally near ones the lower index; fewer if there are not enough.
    template <class Wanted>
    void nearest(const Vec<double, D>& p, std::size_t count, const Wanted& wanted,
                 std::vector<Neighbour>& found) const {
        found.clear();
        if (count > 0) search(0, places_.size(), Search<Wanted>{p, count, wanted, found});
        std::sort_heap(found.begin(), found.end());
    }

private:
    static constexpr std::size_t leaf = 8; ///< points of a leaf, searched one by one

    void divide(const std::vector<Vec<double, D>>& points, std::size_t begin, std::size_t end) {
        if (end - begin <= leaf) return;
        std::size_t axis = 0;
        double longest = -1;
        for (std::size_t k = 0; k < D; ++k) {
            double low = points[order_[begin]][k], high = low;
            for (std::size_t n = begin; n < end; ++n) {
                low = (std::min)(low, points[order_[n]][k]);
                high = (std::max)(high, points[order_[n]][k]);
            }
            if (high - low > longest) {
                longest = high - low;
                axis = k;
            }
        }
        const std::size_t middle = begin + (end - begin) / 2;
        const auto at = [this](std::size_t n) { return order_.begin() + std::ptrdiff_t(n); };
        std::nth_element(at(begin), at(middle), at(end), [&](std::size_t a, std::size_t b) {
            const double x = points[a][axis], y = points[b][axis];
            return x != y ? x < y : a < b;
        });
        axes_[middle] = static_cast<unsigned char>(axis);
        divide(points, begin, middle);
        divide(points, middle + 1, end);
    }

    /// A search: a heap of the nearest points found so far, the farthest of them first.
    template <class Wanted>
    struct Search {
        const Vec<double, D>& p;
        std::size_t count;
        const Wanted& wanted;
        std::vector<Neighbour>& found;

        void consider(const Neighbour& next) const {
            if (found.size() == count) {
                if (!(next < found.front()) || !wanted(next.point)) return;
                std::pop_heap(found.begin(), found.end());
                found.back() = next;
            } else {
                if (!wanted(next.point)) return;
                found.push_back(next);
            }
            std::push_heap(found.begin(), found.end());
        }
    };

    template <class Wanted>
    void search(std::size_t begin, std::size_t end, const Search<Wanted>& query) const {
        const auto consider = [&](std::size_t n) {
            const auto d = places_[n] - query.p;
            query.consider({dot(d, d), order_[n]});
        };
        if (end - begin <= leaf) {
            for (std::size_t n = begin; n < end; ++n) consider(n);
            return;
        }
        const std::size_t middle = begin + (end - begin) / 2, axis = axes_[middle];
        const double beyond = query.p[axis] - places_[middle][axis];
        const auto below = std::pair(begin, middle), above = std::pair(middle + 1, end);
        const auto& [nearer, farther] = beyond < 0 ? std::pair(below, above) : std::pair(above, below);
        search(nearer.first, nearer.second, query);
        consider(middle);
        if (query.found.size() < query.count || beyond * beyond <= query.found.front().squared)
            search(farther.first, farther.second, query);
    }

    std::vector<Vec<double, D>> places_; // in the order of the tree
    std::vector<unsigned char> axes_;    // the splitting axis at the middle of each range
    std::vector<std::size_t> order_;     // the number of each point in this order
};

} // namespace cageform::inline CAGEFORM_ABI::detail
