// make_cage in 2D, step 4: reduces a contour by collapses that only enlarge the loop (progressive hulls:
// Sander et al., Silhouette clipping, SIGGRAPH 2000, sec. 3).
#pragma once

#include <cageform/enclose/plane/cage_loop.hpp>

#include <queue>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Collapses edges: replaces two adjacent vertices by one, least added area first.
class LoopReduction {
public:
    using Point = Vec<double, 2>;

    /// `contour` has at least three vertices. `farthest` limits the distance of a new vertex from both
    /// vertices it replaces.
    LoopReduction(const CageLoop& contour, const Obstacles& obstacles, double farthest)
        : obstacles_(obstacles)
        , half_(contour.half)
        , farthest_(farthest)
        , point_(contour.points)
        , previous_(contour.size())
        , next_(contour.size())
        , version_(contour.size(), 0)
        , live_(contour.size())
        , count_(contour.size()) {
        std::iota(live_.begin(), live_.end(), std::size_t{0});
        for (std::size_t i = 0; i < contour.size(); ++i) {
            previous_[i] = contour.previous(i);
            next_[i] = contour.next(i);
        }
        for (std::size_t i = 0; i < contour.size(); ++i) propose(i);
    }

    /// Reduces the loop to `vertices`, or as few as possible.
    void reduce_to(std::size_t vertices) {
        while (count_ > std::max<std::size_t>(vertices, 3)) {
            if (queue_.empty()) {
                if (rejected_.empty() || !changed_) return;
                changed_ = false; // the loop has changed: rejected collapses may be valid now
                for (const Collapse& step : rejected_) {
                    if (step.version == version_[step.b]) queue_.push(step);
                }
                rejected_.clear();
                continue;
            }
            const Collapse step = queue_.top();
            queue_.pop();
            if (step.version != version_[step.b]) continue;
            if (is_valid(step)) {
                apply(step);
            } else {
                rejected_.push_back(step);
            }
        }
    }

    CageLoop loop() const {
        CageLoop loop{{}, half_};
        std::size_t i = 0; // the first vertex of a chain is never removed
        while (!is_live(i)) ++i;
        for (std::size_t k = 0; k < count_; ++k, i = next_[i]) loop.points.push_back(point_[i]);
        return loop;
    }

private:
    static constexpr std::size_t removed = ~std::size_t{0};

    /// Replaces vertex `b` and its successor by one vertex at `x`.
    struct Collapse {
        double cost;
        std::size_t b;
        std::uint32_t version; ///< version of the edge from b; if it has changed, the collapse is outdated
        Point x;

        bool operator<(const Collapse& other) const noexcept { // the queue pops the largest
            return cost != other.cost ? cost > other.cost : b > other.b;
        }
    };

    bool is_live(std::size_t i) const noexcept { return next_[i] != removed; }
    bool is_start(std::size_t i) const noexcept { return half_ && i == 0; }
    bool is_end(std::size_t i) const noexcept { return half_ && i + 1 == point_.size(); }
    /// Neighbours of a vertex; at an end of a chain, one is the mirror image of the other.
    Point before(std::size_t i) const noexcept {
        return is_start(i) ? CageLoop::mirrored(point_[next_[i]]) : point_[previous_[i]];
    }
    Point after(std::size_t i) const noexcept {
        return is_end(i) ? CageLoop::mirrored(point_[previous_[i]]) : point_[next_[i]];
    }

    /// Queues the possible collapses of the edge from `b` to its successor c. If c is reflex, b can be kept.
    /// If b is reflex, c can be kept. The intersection of both adjacent edges, extended, can be a new vertex.
    void propose(std::size_t b) {
        ++version_[b];
        if (is_end(b)) return;
        const std::size_t c = next_[b];
        const Point p = point_[b], q = point_[c], a = before(b), d = after(c);
        if (!is_end(c) && cross(q - p, d - q) <= 0) push_candidate(b, p, a, d);
        if (!is_start(b) && cross(p - a, q - p) <= 0) push_candidate(b, q, a, d);
        const bool both_ends = is_start(b) && is_end(c);
        if (both_ends) return;
        const Point into = is_start(b) ? Point{0, 1} : p - a, out_of = is_end(c) ? Point{0, 1} : q - d;
        const double det = cross(into, out_of);
        if (det == 0) return;
        const Point x = p + (cross(q - p, out_of) / det) * into;
        const bool beyond_b = is_start(b) || dot(x - p, into) > 0,
                   beyond_c = is_end(c) || dot(x - q, out_of) > 0;
        if (beyond_b && beyond_c && cross(q - p, x - p) < 0) push_candidate(b, half_end(b, c, x), a, d);
    }
    /// Projects x onto the mirror axis if an end of a chain moves.
    Point half_end(std::size_t b, std::size_t c, const Point& x) const noexcept {
        return is_start(b) || is_end(c) ? Point{0, x[1]} : x;
    }
    void push_candidate(std::size_t b, const Point& x, const Point& a, const Point& d) {
        const std::size_t c = next_[b];
        const Point p = point_[b], q = point_[c];
        if ((length(x - p) > farthest_ && length(x - q) > farthest_) || !obstacles_.in_bounds(x)) return;
        if (half_ && !is_start(b) && !is_end(c) && x[0] < 0.5 * obstacles_.margin) return;
        const Point u = (is_start(b) ? CageLoop::mirrored(d) : a) - x;
        const Point v = (is_end(c) ? CageLoop::mirrored(a) : d) - x;
        const double angle = angle_between(u, v);
        constexpr double sharp = 0.9, least = 0.05; // radians
        if (angle < least) return;
        // Exactly one term is not 0: triangle pqx for a new vertex, apq if b is removed, qdp if c is removed.
        const double area = std::fabs(cross(q - p, x - p)) +
                            std::fabs(cross(p - a, x - a)) * (x == q ? 1 : 0) +
                            std::fabs(cross(q - d, x - d)) * (x == p ? 1 : 0);
        queue_.push({area / 2 * (1 + 12 * (std::max)(sharp - angle, 0.0) / sharp), b, version_[b], x});
    }

    /// True if the new edges are clear of all others and the added area contains no mark.
    bool is_valid(const Collapse& step) const {
        const std::size_t b = step.b, c = next_[b];
        const std::size_t a = previous_[b], d = next_[c];
        const Point p = point_[b], q = point_[c], x = step.x;
        const bool first = is_start(b), last = is_end(c);
        if (!first && !edge_is_free(point_[a], x, b, a)) return false;
        if (!last && !edge_is_free(x, point_[d], b, d)) return false;
        return !obstacles_.any_mark_in(p, q, x) && (first || !obstacles_.any_mark_in(point_[a], p, x)) &&
               (last || !obstacles_.any_mark_in(x, q, point_[d]));
    }
    /// True if a new edge between a moved vertex and its fixed neighbour `end` is clear of the loop. Skips
    /// removed edges and edges at `end`.
    bool edge_is_free(const Point& from, const Point& to, std::size_t b, std::size_t end) const {
        if (obstacles_.is_near_other(from, to, 0)) return false;
        return std::none_of(live_.begin(), live_.end(), [&](std::size_t i) {
            if (!is_live(i) || is_end(i)) return false;
            if (i == previous_[b] || i == b || i == next_[b]) return false;
            if (i == end || next_[i] == end) return false; // shares a vertex
            return Obstacles::segments_near(from, to, point_[i], point_[next_[i]], 0);
        });
    }

    void apply(const Collapse& step) {
        const std::size_t b = step.b, c = next_[b];
        const std::size_t stays = is_end(c) ? c : b, goes = is_end(c) ? b : c;
        point_[stays] = step.x;
        const std::size_t before = previous_[goes], after = next_[goes];
        next_[before] = after;
        previous_[after] = before;
        next_[goes] = removed;
        ++version_[goes];
        --count_;
        changed_ = true;
        if (live_.size() > 2 * count_) std::erase_if(live_, [&](std::size_t i) { return !is_live(i); });
        std::size_t edge = previous_[previous_[stays]];
        for (int k = 0; k < 4; ++k, edge = next_[edge]) propose(edge);
    }

    const Obstacles& obstacles_;
    bool half_;
    double farthest_;
    Loop point_;
    std::vector<std::size_t> previous_, next_;
    std::vector<std::uint32_t> version_;
    std::vector<std::size_t> live_; ///< remaining vertices, and some already removed
    std::size_t count_;
    std::priority_queue<Collapse> queue_;
    std::vector<Collapse> rejected_;
    bool changed_ = false;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
