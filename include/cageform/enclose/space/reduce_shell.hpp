// make_cage in space, step 4: reduces the mesh to few vertices by edge collapses, the cheapest first
// (edge_collapse.hpp). A collapse is only allowed if the new faces stay clear of the figure and of each other
// (as in Calderon & Boubekeur, Bounding proxies for shape approximation, SIGGRAPH 2017).
#pragma once

#include <cageform/enclose/space/edge_collapse.hpp>

#include <queue>
#include <tuple>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Collapses edges until few vertices are left: first in rounds, while faces are of about the lattice's
/// spacing, then by a queue.
class ShellReduction {
public:
    using Point = Vec<double, 3>;

    ShellReduction(Shell& shell, const ShellObstacles& obstacles)
        : shell_(shell)
        , spacing_(obstacles.lattice->spacing())
        , collapse_(shell, obstacles)
        , version_(shell.points.size(), 0)
        , changes_(shell.points.size(), 0)
        , mark_(shell.points.size(), 0)
        , count_(shell.whole_size()) {}

    /// Reduces the whole cage to this many vertices, or as few as possible. Returns false if cancelled. It
    /// may be called again for fewer.
    bool reduce_to(std::size_t vertices, const Running& running) {
        const double first = double(count_);
        const auto keep_going = [&] {
            return running.keep_going(
                std::clamp((first - double(count_)) / (first - double(vertices)), 0.0, 1.0));
        };
        if (count_ <= vertices) return true;
        if (hashed_ == 0) { // the queue has not begun
            if (!merge_pairs(vertices, keep_going)) return false;
            watch_crossings();
            for (std::uint32_t v = 0; v < shell_.points.size(); ++v) {
                for (const auto w : shell_.neighbours(v)) {
                    if (v < w) propose(v, w);
                }
            }
        }
        for (std::size_t step = 0; count_ > vertices; ++step) {
            if (step % 256 == 0 && !keep_going()) return false;
            if (queue_.empty() && !retry()) break;
            if (3 * count_ < hashed_) watch_crossings(); // the faces outgrow the cells of the hash
            const Collapse next = queue_.top();
            queue_.pop();
            if (is_current(next)) attempt(next);
        }
        return true;
    }

    /// Does the first collapses only, in rounds, as `reduce_to` does. Returns false if cancelled.
    bool begin(std::size_t vertices, const Running& running) {
        return merge_pairs(vertices, [&] { return running.keep_going(0); });
    }

private:
    struct Collapse {
        double cost; ///< a lower bound
        std::uint32_t u, v;
        std::uint32_t versions; ///< the sum of both ends; if it has changed, the collapse is out of date
        std::uint32_t changes;  ///< of the faces about both ends, up to when the place was chosen
        EdgeCollapse::Places refused;
        std::uint32_t chosen; ///< the cheapest place that is left, if the cost is that of a place

        bool operator<(const Collapse& other) const noexcept { // the queue has its largest on top
            return std::tie(other.cost, other.u, other.v) < std::tie(cost, u, v);
        }
    };

    /// Collapses cheap edges in rounds. In each, a vertex merges with the neighbour that costs least, at most
    /// once. Edges remain shorter than six spacings, and large faces move by less than one. The sheets of the
    /// mesh are farther apart than one margin, so faces are not tested for crossing each other here; the cage
    /// is tested as a whole at the end.
    template <class KeepGoing>
    bool merge_pairs(std::size_t vertices, const KeepGoing& keep_going) {
        if (has_begun_) return true;
        has_begun_ = true;
        const double unit = spacing_ * spacing_ * spacing_ * spacing_;
        std::vector<std::uint8_t> merged;
        for (double limit = first_limit * unit; limit < last_limit * unit; limit *= 2) {
            if (count_ <= most_by_queue * vertices) break;
            if (!keep_going()) return false;
            merged.assign(shell_.points.size(), 0);
            for (std::uint32_t u = 0; u < shell_.points.size(); ++u) {
                if (shell_.star[u].empty() || merged[u] != 0) continue;
                std::uint32_t partner = EdgeCollapse::none;
                double least = limit;
                const std::uint32_t mark = ++last_mark_;
                for (const auto f : shell_.star[u]) {
                    for (const auto w : shell_.faces[f]) {
                        if (w == u || merged[w] != 0 || mark_[w] == mark) continue;
                        mark_[w] = mark;
                        const double cost = collapse_.least_cost(u, w);
                        if (!(cost < least)) continue;
                        least = cost;
                        partner = w;
                    }
                }
                if (partner == EdgeCollapse::none || !merge(u, partner, limit)) continue;
                merged[u] = 1;
            }
        }
        return true;
    }
    bool merge(std::uint32_t u, std::uint32_t v, double limit) {
        if (!collapse_.look_at(u, v) || !collapse_.keeps_topology()) return false;
        EdgeCollapse::Places refused = 0;
        for (;;) {
            double cost = 0;
            const auto n = collapse_.choose(refused, cost);
            if (n == EdgeCollapse::none || !(cost < limit)) return false;
            if (collapse_.fits(n)) {
                take(n);
                return true;
            }
            refused |= EdgeCollapse::Places{1} << n;
        }
    }
    void watch_crossings() {
        collapse_.watch_crossings();
        hashed_ = count_;
    }
    void take(std::uint32_t n) {
        count_ -= shell_.half && !collapse_.is_along_rim() ? 2 : 1;
        collapse_.take(n);
    }

    bool is_current(const Collapse& c) const noexcept {
        return !shell_.star[c.u].empty() && !shell_.star[c.v].empty() &&
               c.versions == version_[c.u] + version_[c.v];
    }
    void propose(std::uint32_t u, std::uint32_t v) {
        queue_.push({collapse_.least_cost(u, v), (std::min)(u, v), (std::max)(u, v),
                     version_[u] + version_[v], 0, 0, EdgeCollapse::none});
    }
    /// Chooses a place for the merged vertex, tests it and makes the collapse. If the collapse becomes
    /// dearer than another one, it goes back into the queue. Costs need few operations and tests many, so
    /// only the cheapest collapse of all is tested.
    void attempt(Collapse c) {
        if (!collapse_.look_at(c.u, c.v)) {
            waiting_.push_back(c);
            return;
        }
        const std::uint32_t changes = changes_[c.u] + changes_[c.v];
        bool has_choice = c.chosen != EdgeCollapse::none && c.changes == changes;
        if (!has_choice) c.refused = 0;
        c.changes = changes;
        for (;; has_choice = false) {
            if (!has_choice) {
                c.chosen = collapse_.choose(c.refused, c.cost);
                if (c.chosen == EdgeCollapse::none) break;
                if (!queue_.empty() && c.cost > queue_.top().cost) {
                    queue_.push(c);
                    return;
                }
            }
            if (!collapse_.keeps_topology()) break;
            if (collapse_.fits(c.chosen)) {
                take(c.chosen);
                propose_about(c.u);
                return;
            }
            c.refused |= EdgeCollapse::Places{1} << c.chosen;
        }
        waiting_.push_back(c);
    }
    /// Proposes the edges of a vertex that has moved.
    void propose_about(std::uint32_t u) {
        ++version_[u];
        ++changes_[u];
        changed_ = true;
        const std::uint32_t mark = ++last_mark_;
        for (const auto f : shell_.star[u]) {
            for (const auto w : shell_.faces[f]) {
                if (w == u || mark_[w] == mark) continue;
                mark_[w] = mark;
                ++changes_[w];
                propose(u, w);
            }
        }
    }
    /// Puts refused collapses back into the queue, since the mesh has changed around them.
    bool retry() {
        if (!changed_) return false;
        changed_ = false;
        for (const Collapse& c : waiting_) {
            if (is_current(c)) queue_.push(c);
        }
        waiting_.clear();
        return !queue_.empty();
    }

    static constexpr double first_limit = 0.004, last_limit = 1.1; ///< of costs, in spacings to the fourth
    static constexpr std::size_t most_by_queue = 8; ///< times the vertices wanted: the queue reduces these

    Shell& shell_;
    double spacing_;
    EdgeCollapse collapse_;
    std::vector<std::uint32_t> version_;
    std::vector<std::uint32_t> changes_; ///< how often a face about a vertex has changed
    std::vector<std::uint32_t> mark_;    ///< the vertices met by a loop over neighbours
    std::uint32_t last_mark_ = 0;
    std::size_t count_;
    bool has_begun_ = false; ///< whether the rounds have been made
    std::size_t hashed_ = 0; ///< the vertices when faces were last hashed; 0 until the queue begins
    std::priority_queue<Collapse> queue_;
    std::vector<Collapse> waiting_;
    bool changed_ = false;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
