// In which order the nodes of a graph are eliminated.
#pragma once

#include <cageform/core/vec.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The links of every node, side by side.
struct Adjacency {
    std::vector<std::size_t> first{0}; ///< #nodes + 1: where the links of a node begin
    std::vector<std::uint32_t> node;   ///< at the other end
    std::vector<double> conductance;

    std::size_t nodes() const noexcept { return first.size() - 1; }
    std::span<const std::uint32_t> neighbours(std::uint32_t i) const noexcept {
        return std::span(node).subspan(first[i], first[i + 1] - first[i]);
    }
};

/// An order of elimination by nested dissection: a separator's nodes come after the parts that it
/// leaves. Separators are levels of a breadth-first search from a node far out (George, Liu, An
/// automatic nested dissection algorithm for irregular finite element problems, SIAM J. Numer.
/// Anal. 15 (1978)). O(#links log #nodes) where the parts are of like size.
class Dissection {
public:
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    /// Nodes that are eliminated together: a separator, or a part that is not divided further.
    struct Group {
        std::size_t begin, end; ///< in `nodes`
        std::uint32_t parent;   ///< the separator that made the part, a lesser number; or none
    };

    explicit Dissection(const Adjacency& graph)
        : graph_(graph)
        , nodes_(graph.nodes())
        , part_(graph.nodes(), 0)
        , seen_(graph.nodes(), 0) {
        for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i] = std::uint32_t(i);
        waiting_.push_back({{0, nodes_.size(), none}, 0, false});
        while (!waiting_.empty()) {
            const Part part = waiting_.back();
            waiting_.pop_back();
            if (part.range.end - part.range.begin <= undivided) {
                if (part.range.begin != part.range.end) groups_.push_back(part.range);
            } else if (part.connected) {
                divide(part);
            } else if (!separate_hubs(part)) {
                connect(part);
            }
        }
    }

    /// Eliminated from the last to the first: children before their parents, and those of a parent
    /// after all that belongs to its other children.
    std::span<const Group> groups() const noexcept { return groups_; }
    std::span<const std::uint32_t> nodes(const Group& group) const noexcept {
        return std::span(nodes_).subspan(group.begin, group.end - group.begin);
    }

private:
    static constexpr std::size_t undivided = 32; ///< nodes: dense arithmetic is faster than more groups

    struct Part {
        Group range;
        std::uint32_t label; ///< of its nodes in part_
        bool connected;
    };

    /// All nodes of root's part that a path leads to, level by level.
    void search(std::uint32_t root) {
        const std::uint32_t label = part_[root];
        ++searches_;
        reached_.assign(1, root);
        levels_.assign(1, 0);
        seen_[root] = searches_;
        for (std::size_t at = 0; at < reached_.size();) {
            levels_.push_back(reached_.size());
            for (; at < levels_.back(); ++at) {
                for (const std::uint32_t next : graph_.neighbours(reached_[at])) {
                    if (part_[next] != label || seen_[next] == searches_) continue;
                    seen_[next] = searches_;
                    reached_.push_back(next);
                }
            }
        }
    }

    /// Nodes of more neighbours than a separator of a planar graph has nodes, as the tip of a fan, are
    /// separators themselves: a level after one would be as wide as it has neighbours.
    bool separate_hubs(const Part& part) {
        const auto [begin, end, parent] = part.range;
        const double most = std::max(32.0, 2 * std::sqrt(double(end - begin)));
        const auto first = nodes_.begin() + std::ptrdiff_t(begin),
                   last = nodes_.begin() + std::ptrdiff_t(end);
        const auto rest = std::partition(
            first, last, [&](std::uint32_t i) { return double(graph_.neighbours(i).size()) > most; });
        if (rest == first) return false;
        const auto separator = std::uint32_t(groups_.size());
        const auto middle = std::size_t(rest - nodes_.begin());
        groups_.push_back({begin, middle, parent});
        label(begin, middle);
        waiting_.push_back({{middle, end, separator}, part.label, false});
        return true;
    }

    /// Into parts that are connected, the last node of each far from its first.
    void connect(const Part& part) {
        const auto range = nodes_of(part.range);
        const std::vector<std::uint32_t> all(range.begin(), range.end());
        std::size_t end = part.range.begin;
        for (const std::uint32_t node : all) {
            if (part_[node] != part.label) continue;
            search(node);
            std::copy(reached_.begin(), reached_.end(), nodes_.begin() + std::ptrdiff_t(end));
            const std::size_t begin = end;
            end += reached_.size();
            waiting_.push_back({{begin, end, part.range.parent}, label(begin, end), true});
        }
    }

    /// Into two parts and the separator between.
    void divide(const Part& part) {
        const auto [begin, end, parent] = part.range;
        search(nodes_[end - 1]);
        std::copy(reached_.begin(), reached_.end(), nodes_.begin() + std::ptrdiff_t(begin));
        std::size_t best = 0;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t level = 1; level + 2 < levels_.size(); ++level) {
            const double width = double(levels_[level + 1] - levels_[level]);
            const double cost = width / (double(levels_[level]) * double(end - begin - levels_[level + 1]));
            if (cost >= least) continue;
            least = cost;
            best = level;
        }
        if (best == 0) {
            groups_.push_back(part.range);
            return;
        }
        std::size_t first = begin + levels_[best];
        const std::size_t last = begin + levels_[best + 1];
        const std::uint32_t beyond = label(last, end);
        for (std::size_t at = first; at < last; ++at) { // what need not separate
            const auto near = graph_.neighbours(nodes_[at]);
            if (std::none_of(near.begin(), near.end(), [&](std::uint32_t i) { return part_[i] == beyond; }))
                std::swap(nodes_[at], nodes_[first++]);
        }
        const auto separator = std::uint32_t(groups_.size());
        groups_.push_back({first, last, parent});
        label(first, last);
        waiting_.push_back({{begin, first, separator}, label(begin, first), false});
        waiting_.push_back({{last, end, separator}, beyond, false});
    }

    std::uint32_t label(std::size_t begin, std::size_t end) noexcept {
        ++labels_;
        for (std::size_t at = begin; at < end; ++at) part_[nodes_[at]] = labels_;
        return labels_;
    }
    std::span<const std::uint32_t> nodes_of(const Group& range) const noexcept { return nodes(range); }

    const Adjacency& graph_;
    std::vector<std::uint32_t> nodes_;
    std::vector<std::uint32_t> part_; // of every node
    std::vector<std::uint32_t> seen_; // by which search
    std::uint32_t labels_ = 0, searches_ = 0;
    std::vector<Part> waiting_;
    std::vector<Group> groups_;
    std::vector<std::uint32_t> reached_; // by the last search
    std::vector<std::size_t> levels_;    // where its levels begin, and the end
};

} // namespace cageform::inline CAGEFORM_ABI::detail
