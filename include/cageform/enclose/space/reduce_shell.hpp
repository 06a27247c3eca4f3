// make_cage in 3D, step 4: reduces the mesh by edge collapses, cheapest first (edge_collapse.hpp). A collapse
// is valid if the new faces touch neither the figure nor each other (as in Calderon & Boubekeur, Bounding
// proxies for shape approximation, SIGGRAPH 2017).
#pragma once

#include <cageform/enclose/space/edge_collapse.hpp>

#include <queue>
#include <tuple>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Collapses edges in rounds while faces are about as small as the lattice spacing, then by a priority queue.
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

    /// Reduces the whole cage to `vertices`, or as few as possible. Returns false if cancelled. Can be called
    /// again for fewer.
    bool reduce_to(std::size_t vertices, const Running& running) {
        const double first = double(count_);
        const auto keep_going = [&] {
            return running.keep_going(
                std::clamp((first - double(count_)) / (first - double(vertices)), 0.0, 1.0));
        };
        if (count_ <= vertices) return true;
        if (hashed_ == 0) { // the queue is not filled yet
            if (!merge_pairs(vertices, keep_going)) return false;
            test_crossings();
            for (std::uint32_t v = 0; v < shell_.points.size(); ++v) {
                for (const auto w : shell_.neighbours(v)) {
                    if (v < w) propose(v, w);
                }
            }
        }
        for (std::size_t step = 0; count_ > vertices; ++step) {
            if (step % 256 == 0 && !keep_going()) return false;
            if (queue_.empty() && !retry()) break;
            if (3 * count_ < hashed_) test_crossings(); // faces have outgrown the cells of the hash
            const Collapse next = queue_.top();
            queue_.pop();
            if (is_current(next)) attempt(next);
        }
        return true;
    }

    /// Runs only the rounds of `reduce_to`. Returns false if cancelled.
    bool begin(std::size_t vertices, const Running& running) {
        return merge_pairs(vertices, [&] { return running.keep_going(0); });
    }

private:
    struct Collapse {
        double cost; ///< lower bound
        std::uint32_t u, v;
        std::uint32_t versions; ///< sum over both ends; the collapse is outdated if it has changed
        std::uint32_t changes;  ///< number of face changes at both ends when the candidate was chosen
        EdgeCollapse::CandidateSet rejected;
        std::uint32_t candidate_index; ///< cheapest candidate left, if `cost` is its cost

        bool operator<(const Collapse& other) const noexcept { // the queue pops the largest
            return std::tie(other.cost, other.u, other.v) < std::tie(cost, u, v);
        }
    };

    /// Collapses cheap edges in rounds. In each round, a vertex merges at most once, with the cheapest
    /// neighbour. Edges remain shorter than six spacings, and large faces move by less than one spacing.
    /// Sheets of the mesh are more than one margin apart, so crossings are not tested here; the whole cage is
    /// checked at the end.
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
                        const double cost = collapse_.cost_bound(u, w);
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
        if (!collapse_.select(u, v) || !collapse_.keeps_topology()) return false;
        EdgeCollapse::CandidateSet rejected = 0;
        for (;;) {
            double cost = 0;
            const auto n = collapse_.cheapest(rejected, cost);
            if (n == EdgeCollapse::none || !(cost < limit)) return false;
            if (collapse_.fits(n)) {
                apply(n);
                return true;
            }
            rejected |= EdgeCollapse::CandidateSet{1} << n;
        }
    }
    void test_crossings() {
        collapse_.test_crossings();
        hashed_ = count_;
    }
    void apply(std::uint32_t n) {
        count_ -= shell_.half && !collapse_.is_along_rim() ? 2 : 1;
        collapse_.apply(n);
    }

    bool is_current(const Collapse& c) const noexcept {
        return !shell_.star[c.u].empty() && !shell_.star[c.v].empty() &&
               c.versions == version_[c.u] + version_[c.v];
    }
    void propose(std::uint32_t u, std::uint32_t v) {
        queue_.push({collapse_.cost_bound(u, v), (std::min)(u, v), (std::max)(u, v),
                     version_[u] + version_[v], 0, 0, EdgeCollapse::none});
    }
    /// Chooses a candidate, tests and applies it. If the collapse becomes more expensive than another one, it
    /// returns to the queue. Costs are cheap and tests expensive, so only the cheapest collapse is tested.
    void attempt(Collapse c) {
        if (!collapse_.select(c.u, c.v)) {
            rejected_.push_back(c);
            return;
        }
        const std::uint32_t changes = changes_[c.u] + changes_[c.v];
        bool has_choice = c.candidate_index != EdgeCollapse::none && c.changes == changes;
        if (!has_choice) c.rejected = 0;
        c.changes = changes;
        for (;; has_choice = false) {
            if (!has_choice) {
                c.candidate_index = collapse_.cheapest(c.rejected, c.cost);
                if (c.candidate_index == EdgeCollapse::none) break;
                if (!queue_.empty() && c.cost > queue_.top().cost) {
                    queue_.push(c);
                    return;
                }
            }
            if (!collapse_.keeps_topology()) break;
            if (collapse_.fits(c.candidate_index)) {
                apply(c.candidate_index);
                propose_about(c.u);
                return;
            }
            c.rejected |= EdgeCollapse::CandidateSet{1} << c.candidate_index;
        }
        rejected_.push_back(c);
    }
    /// Queues the edges of a moved vertex.
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
    /// Requeues rejected collapses if the mesh has changed.
    bool retry() {
        if (!changed_) return false;
        changed_ = false;
        for (const Collapse& c : rejected_) {
            if (is_current(c)) queue_.push(c);
        }
        rejected_.clear();
        return !queue_.empty();
    }

    static constexpr double first_limit = 0.004, last_limit = 1.1; ///< costs in spacings^4
    /// The rounds end, and the queue starts, at this multiple of the requested vertices.
    static constexpr std::size_t most_by_queue = 8;

    Shell& shell_;
    double spacing_;
    EdgeCollapse collapse_;
    std::vector<std::uint32_t> version_;
    std::vector<std::uint32_t> changes_; ///< number of changes of faces at each vertex
    std::vector<std::uint32_t> mark_;    ///< scratch for loops over neighbours
    std::uint32_t last_mark_ = 0;
    std::size_t count_;
    bool has_begun_ = false; ///< true after the rounds
    std::size_t hashed_ = 0; ///< vertices when faces were last hashed; 0 before the queue is filled
    std::priority_queue<Collapse> queue_;
    std::vector<Collapse> rejected_;
    bool changed_ = false;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
