// Maximum weight matching in general graphs (Edmonds' blossom algorithm).
#pragma once

#include <cageform/core/status.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <queue>
#include <span>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

struct WeightedEdge {
    std::uint32_t a = 0, b = 0;
    std::int64_t weight = 0; ///< 1 … 2^60; edges with smaller weights are never matched
};

/// Finds a set of edges without common vertices of maximum total weight. Exact, as all arithmetic is in
/// integers.
///
///   cost  typically O(n (m + n) log n) for n vertices and m edges; a search rarely visits the whole graph
///
/// Primal-dual method of Edmonds (Maximum matching and a polyhedron with 0,1-vertices, J. Res. NBS 69B, 1965)
/// as described by Galil (Efficient algorithms for finding maximum matching in graphs, ACM Comput. Surv. 18,
/// 1986), growing one alternating tree at a time from an unmatched vertex. Each vertex has a dual y >= 0.
/// Each blossom, an odd cycle shrunk to a node, has a dual z >= 0. The slack of an edge is y_a + y_b - 2
/// weight. It is >= 0 outside blossoms. It is 0 for edges that are matched, in the tree or in a blossom.
/// While the tree grows, y decreases at even nodes and increases at odd ones, at the same rate. A queue holds
/// the times of events. At an event, one of three numbers reaches 0: the slack of an edge, z of an odd
/// blossom, or y of an even vertex. An even vertex with y = 0 may stay unmatched. At the end y = 0 at all
/// unmatched vertices, which proves optimality.
class Matching {
public:
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    Matching(std::size_t vertices, std::span<const WeightedEdge> edges)
        : edges_(edges)
        , size_(static_cast<std::uint32_t>(vertices))
        , nodes_(vertices)
        , mate_link_(vertices, none)
        , first_(vertices + 1, 0) {
        for (const auto& edge : edges) {
            ++first_[edge.a + 1];
            ++first_[edge.b + 1];
            for (const auto v : {edge.a, edge.b}) nodes_[v].dual = (std::max)(nodes_[v].dual, edge.weight);
        }
        for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];
        links_.resize(2 * edges.size());
        std::vector<std::uint32_t> end(first_.begin(), first_.end() - 1);
        for (std::uint32_t e = 0; e < edges.size(); ++e) {
            links_[end[edges[e].a]++] = 2 * e;
            links_[end[edges[e].b]++] = 2 * e + 1;
        }
        for (std::uint32_t v = 0; v < size_; ++v) nodes_[v].base = v;
        for (std::uint32_t v = 0; v < size_; ++v) {
            if (mate_link_[v] == none && nodes_[v].dual > 0) search(v);
        }
    }

    /// Matched edge of a vertex; `none` if it is unmatched.
    std::uint32_t edge_at(std::size_t v) const noexcept {
        return mate_link_[v] == none ? none : mate_link_[v] / 2;
    }

private:
    // A link is a directed edge: 2 e leads from a to b, 2 e + 1 from b to a.
    using Link = std::uint32_t;
    using Node = std::uint32_t; ///< a vertex, or a blossom if >= size_
    enum class Label : std::uint8_t { free, even, odd };
    enum class EventKind : std::uint8_t { vertex_at_zero, blossom_at_zero, edge_at_zero };

    struct NodeData {
        Node parent = none; ///< enclosing blossom
        Node base = none;   ///< the only vertex in it that is unmatched or matched to the outside
        std::int64_t dual = 0;
        std::int64_t since = 0; ///< for an outermost node in the tree: when its duals were last updated
        Label label = Label::free;
        Link entry = none; ///< for an odd node: link from the tree into it
        /// Odd cycle of a blossom, starting with the child of the base, and the links from each child to the
        /// next.
        std::vector<Node> children{};
        std::vector<Link> links{};
    };
    struct Event {
        std::int64_t time;
        EventKind what;
        std::uint32_t index; ///< index of the vertex, blossom or link
        friend auto operator<=>(const Event&, const Event&) = default;
    };

    std::uint32_t from(Link link) const noexcept {
        return link % 2 == 0 ? edges_[link / 2].a : edges_[link / 2].b;
    }
    std::uint32_t to(Link link) const noexcept { return from(link ^ 1U); }
    Node outermost(Node node) const noexcept {
        while (nodes_[node].parent != none) node = nodes_[node].parent;
        return node;
    }
    template <class F>
    void for_each_vertex(Node node, const F& f) const {
        if (node < size_) return f(node);
        for (const Node child : nodes_[node].children) for_each_vertex(child, f);
    }

    /// Change of the vertex duals since they were last stored.
    std::int64_t growth(Node outer) const noexcept {
        const NodeData& node = nodes_[outer];
        if (node.label == Label::free) return 0;
        return node.label == Label::odd ? now_ - node.since : node.since - now_;
    }
    std::int64_t dual(std::uint32_t v) const noexcept { return nodes_[v].dual + growth(outermost(v)); }
    std::int64_t blossom_dual(Node outer) const noexcept { return nodes_[outer].dual - 2 * growth(outer); }
    std::int64_t slack(Link link) const noexcept {
        return dual(from(link)) + dual(to(link)) - 2 * edges_[link / 2].weight;
    }
    /// Stores the duals of a node and of its descendants, then sets its label.
    void set_label(Node outer, Label label, Link entry = none) {
        const std::int64_t by = growth(outer);
        if (by != 0) for_each_vertex(outer, [&](std::uint32_t v) { nodes_[v].dual += by; });
        if (outer >= size_) nodes_[outer].dual -= 2 * by;
        nodes_[outer].since = now_;
        nodes_[outer].label = label;
        nodes_[outer].entry = entry;
    }
    void add_to_tree(Node outer, Label label, Link entry = none) {
        set_label(outer, label, entry);
        tree_.push_back(outer);
    }

    void schedule(std::int64_t wait, EventKind what, std::uint32_t index) {
        queue_.push({now_ + wait, what, index});
    }
    /// Schedules the events of a vertex that has become even.
    void schedule_even(std::uint32_t v) {
        schedule(dual(v), EventKind::vertex_at_zero, v);
        const Node inside = outermost(v);
        for (auto k = first_[v]; k < first_[v + 1]; ++k) {
            const Node other = outermost(to(links_[k]));
            if (other == inside || nodes_[other].label == Label::odd) continue;
            const std::int64_t gap = slack(links_[k]);
            schedule(nodes_[other].label == Label::even ? gap / 2 : gap, EventKind::edge_at_zero, links_[k]);
        }
    }
    void schedule_odd(Node outer) {
        if (outer >= size_) schedule(nodes_[outer].dual / 2, EventKind::blossom_at_zero, outer);
    }
    /// Schedules the event at which the tree reaches a vertex that is no longer odd.
    void schedule_free(std::uint32_t v) {
        for (auto k = first_[v]; k < first_[v + 1]; ++k) {
            if (nodes_[outermost(to(links_[k]))].label == Label::even)
                schedule(slack(links_[k]), EventKind::edge_at_zero, links_[k] ^ 1U);
        }
    }
    void make_even(Node outer) {
        add_to_tree(outer, Label::even);
        for_each_vertex(outer, [&](std::uint32_t v) { schedule_even(v); });
    }

    /// Matches `start`, or leaves another vertex unmatched in its place.
    void search(std::uint32_t start) {
        now_ = 0;
        queue_ = {};
        make_even(outermost(start));
        while (!process_event()) {}
        for (const Node node : tree_) {
            if (nodes_[node].label != Label::free && nodes_[node].parent == none)
                set_label(node, Label::free);
        }
        tree_.clear();
    }

    /// Processes an event. Returns true if the search has ended.
    bool process_event() {
        const Event event = queue_.top();
        queue_.pop();
        now_ = event.time;
        if (event.what == EventKind::vertex_at_zero) {
            if (dual(event.index) != 0) return false;
            augment(event.index, none);
            return true;
        }
        if (event.what == EventKind::blossom_at_zero) {
            const NodeData& node = nodes_[event.index];
            const bool is_there = node.parent == none && node.label == Label::odd;
            if (is_there && blossom_dual(event.index) == 0) expand(event.index);
            return false;
        }
        const Link link = event.index;
        const Node left = outermost(from(link)), right = outermost(to(link));
        if (left == right || nodes_[right].label == Label::odd || slack(link) != 0) return false;
        if (nodes_[right].label == Label::even) {
            shrink(link, left, right);
            return false;
        }
        const Link beyond = mate_link_[nodes_[right].base];
        if (beyond == none) {
            augment(from(link), link);
            set_base(right, to(link));
            mate_link_[to(link)] = link ^ 1U;
            return true;
        }
        add_to_tree(right, Label::odd, link);
        schedule_odd(right);
        make_even(outermost(to(beyond)));
        return false;
    }

    /// Path from an even node to the root of the tree: nodes and the links between them.
    struct TreePath {
        std::vector<Node> nodes;
        std::vector<Link> links;
    };
    TreePath path_to_root(Node even) const {
        TreePath path{{even}, {}};
        for (Link up = mate_link_[nodes_[even].base]; up != none;) {
            const Node odd = outermost(to(up));
            path.links.push_back(up);
            path.nodes.push_back(odd);
            path.links.push_back(nodes_[odd].entry ^ 1U);
            path.nodes.push_back(outermost(to(path.links.back())));
            up = mate_link_[nodes_[path.nodes.back()].base];
        }
        return path;
    }

    /// Shrinks the cycle closed by an edge between two even nodes to a blossom.
    void shrink(Link link, Node left, Node right) {
        TreePath here = path_to_root(left), there = path_to_root(right);
        // Remove the common end of both paths, except for the node where they meet.
        while (here.nodes.size() > 1 && there.nodes.size() > 1 &&
               here.nodes[here.nodes.size() - 2] == there.nodes[there.nodes.size() - 2]) {
            for (TreePath* path : {&here, &there}) {
                path->nodes.pop_back();
                path->links.pop_back();
            }
        }
        NodeData made;
        made.base = nodes_[here.nodes.back()].base;
        made.children.assign(here.nodes.rbegin(), here.nodes.rend());
        made.children.insert(made.children.end(), there.nodes.begin(), there.nodes.end() - 1);
        for (auto up = here.links.rbegin(); up != here.links.rend(); ++up) made.links.push_back(*up ^ 1U);
        made.links.push_back(link);
        made.links.insert(made.links.end(), there.links.begin(), there.links.end());

        const Node blossom = new_node();
        std::vector<Node> odd;
        for (const Node child : made.children) {
            if (nodes_[child].label == Label::odd) odd.push_back(child);
            set_label(child, Label::free);
            nodes_[child].parent = blossom;
        }
        nodes_[blossom] = std::move(made);
        add_to_tree(blossom, Label::even);
        for (const Node child : odd) for_each_vertex(child, [&](std::uint32_t v) { schedule_even(v); });
    }

    Node new_node() {
        if (unused_.empty()) {
            nodes_.emplace_back();
            return static_cast<Node>(nodes_.size() - 1);
        }
        const Node node = unused_.back();
        unused_.pop_back();
        return node;
    }

    /// Expands an odd blossom. The part of its cycle with an even number of links from the entry to the base
    /// stays in the tree.
    void expand(Node blossom) {
        const Link entry = nodes_[blossom].entry;
        set_label(blossom, Label::free);
        const NodeData cycle = std::move(nodes_[blossom]);
        nodes_[blossom] = {};
        unused_.push_back(blossom);
        for (const Node child : cycle.children) {
            nodes_[child].parent = none;
            set_label(child, Label::free);
        }
        const std::size_t size = cycle.children.size();
        const std::size_t start = child_index(cycle, to(entry));
        const bool is_down = start % 2 == 0;
        std::vector<Node> even;
        Link entry_link = entry;
        for (std::size_t at = start, step = 0;; ++step) {
            const Node child = cycle.children[at];
            if (step % 2 == 0)
                add_to_tree(child, Label::odd, entry_link);
            else
                even.push_back(child);
            if (at == 0) break;
            entry_link = is_down ? cycle.links[at - 1] ^ 1U : cycle.links[at];
            at = is_down ? at - 1 : (at + 1) % size;
        }
        for (const Node child : even) add_to_tree(child, Label::even);
        for (const Node child : cycle.children) {
            if (nodes_[child].label == Label::odd)
                schedule_odd(child);
            else if (nodes_[child].label == Label::even)
                for_each_vertex(child, [&](std::uint32_t v) { schedule_even(v); });
            else
                for_each_vertex(child, [&](std::uint32_t v) { schedule_free(v); });
        }
    }

    /// Index of the child that contains a vertex.
    std::size_t child_index(const NodeData& cycle, std::uint32_t v) const noexcept {
        for (Node node = v;; node = nodes_[node].parent) {
            const auto found = std::find(cycle.children.begin(), cycle.children.end(), node);
            if (found != cycle.children.end()) return std::size_t(found - cycle.children.begin());
        }
    }

    /// Augments: matches an even vertex by a link (or leaves it unmatched) and swaps matched and unmatched
    /// edges along the path to the root.
    void augment(std::uint32_t v, Link link) {
        for (;;) {
            const Node even = outermost(v);
            const Link up = mate_link_[nodes_[even].base];
            set_base(even, v);
            mate_link_[v] = link;
            if (up == none) return;
            const Node odd = outermost(to(up));
            const Link entry = nodes_[odd].entry;
            set_base(odd, to(entry));
            mate_link_[to(entry)] = entry ^ 1U;
            v = from(entry);
            link = entry;
        }
    }

    /// Makes `v` the base of a node: matches its other vertices in pairs.
    void set_base(Node node, std::uint32_t v) {
        if (node < size_ || nodes_[node].base == v) return;
        NodeData& blossom = nodes_[node];
        const std::size_t size = blossom.children.size(), place = child_index(blossom, v);
        set_base(blossom.children[place], v);
        const std::size_t first = place % 2 == 0 ? 0 : place + 1, last = place % 2 == 0 ? place : size;
        for (std::size_t k = first; k < last; k += 2) {
            const Link link = blossom.links[k];
            set_base(blossom.children[k], from(link));
            set_base(blossom.children[(k + 1) % size], to(link));
            mate_link_[from(link)] = link;
            mate_link_[to(link)] = link ^ 1U;
        }
        using Step = std::ptrdiff_t;
        std::rotate(blossom.children.begin(), blossom.children.begin() + Step(place), blossom.children.end());
        std::rotate(blossom.links.begin(), blossom.links.begin() + Step(place), blossom.links.end());
        blossom.base = v;
    }

    std::span<const WeightedEdge> edges_;
    std::uint32_t size_;
    std::vector<NodeData> nodes_;
    std::vector<Node> unused_;
    std::vector<Link> mate_link_; ///< link from each vertex to its mate
    std::vector<std::uint32_t> first_;
    std::vector<Link> links_; ///< links of vertex v: first_[v] to first_[v + 1]
    std::vector<Node> tree_;  ///< all nodes labelled in this search
    std::int64_t now_ = 0;
    std::priority_queue<Event, std::vector<Event>, std::greater<>> queue_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
