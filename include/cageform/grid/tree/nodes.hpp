// The unknowns on a tree of cells: the corners of leaves inside the domain.
#pragma once

#include <cageform/grid/tree/cut_tree.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace detail {

/// Sorts keys: first sorts runs of `least` or more in parallel, then merges pairs of runs. Reports progress
/// after each merge.
template <class Key>
void sort_in_runs(Buffer<Key>& keys, const Running& running, std::size_t least = std::size_t{1} << 20) {
    const std::size_t count = keys.size();
    std::size_t length = (std::max)(least, count / 256 + 1); // of a run
    const auto sort = [&](std::size_t begin, std::size_t end, Key&) {
        std::sort(keys.begin() + begin, keys.begin() + end);
    };
    (void)in_runs<Key>(running.subtask(0, 0.5), count, length, [&] { return sort; });
    const Running merging = running.subtask(0.5, 1);
    const double passes = std::ceil(std::log2((std::max)(1.0, double(count) / double(length))));
    for (double done = 0; length < count; length *= 2) {
        for (std::size_t begin = 0; begin + length < count; begin += 2 * length) {
            const std::size_t end = (std::min)(begin + 2 * length, count);
            std::inplace_merge(keys.begin() + begin, keys.begin() + begin + length, keys.begin() + end);
            done += double(end - begin) / double(count) / passes;
            report_progress(merging, (std::min)(done, 1.0));
        }
    }
}

} // namespace detail

namespace grid {

/// The nodes, in Morton order. Converts between the index in this order and the position of a node.
template <std::size_t D>
class TreeNodes {
public:
    using Index = std::array<std::int32_t, D>;
    using Key = std::uint64_t; ///< the Morton code: interleaved bits of the coordinates, 21 each
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    TreeNodes() = default;
    /// Makes the nodes from ascending, distinct keys.
    explicit TreeNodes(Buffer<Key> keys)
        : keys_(std::move(keys)) {
        keys_.shrink_to_fit();
        while ((std::size_t{1} << bits_) < 2 * keys_.size()) ++bits_;
        table_ = Buffer<std::uint32_t>(std::size_t{1} << bits_, none);
        for (std::uint32_t n = 0; n < keys_.size(); ++n) {
            std::size_t at = slot(keys_[n]);
            while (table_[at] != none) at = (at + 1) & (table_.size() - 1);
            table_[at] = n;
        }
    }

    std::uint32_t count() const noexcept { return std::uint32_t(keys_.size()); }
    std::size_t bytes() const noexcept {
        return keys_.capacity() * sizeof(Key) + table_.capacity() * sizeof(std::uint32_t);
    }
    Index index(std::uint32_t node) const noexcept { return index_of(keys_[node]); }
    /// Returns the index of the node at a position, or `none`.
    std::uint32_t find(const Index& index) const noexcept {
        const Key wanted = key(index);
        for (std::size_t at = slot(wanted);; at = (at + 1) & (table_.size() - 1)) {
            if (table_[at] == none || keys_[table_[at]] == wanted) return table_[at];
        }
    }

    static Index index_of(Key key) noexcept {
        Index index{};
        for (std::size_t k = 0; k < D; ++k) index[k] = std::int32_t(gathered(key >> k));
        return index;
    }
    /// Returns the Morton code of a position with coordinates in [0, 2^20].
    static Key key(const Index& index) noexcept {
        Key key = 0;
        for (std::size_t k = 0; k < D; ++k) key |= spread(std::uint64_t(std::uint32_t(index[k]))) << k;
        return key;
    }

private:
    /// Moves bit n to bit D · n, for D = 2 and 3 by halves (Warren, Hacker's Delight (2002), sec. 7-2).
    static Key spread(Key x) noexcept {
        if constexpr (D == 2) {
            x = (x | x << 16) & 0x0000ffff0000ffff;
            x = (x | x << 8) & 0x00ff00ff00ff00ff;
            x = (x | x << 4) & 0x0f0f0f0f0f0f0f0f;
            x = (x | x << 2) & 0x3333333333333333;
            x = (x | x << 1) & 0x5555555555555555;
        } else if constexpr (D == 3) {
            x = (x | x << 32) & 0x001f00000000ffff;
            x = (x | x << 16) & 0x001f0000ff0000ff;
            x = (x | x << 8) & 0x100f00f00f00f00f;
            x = (x | x << 4) & 0x10c30c30c30c30c3;
            x = (x | x << 2) & 0x1249249249249249;
        }
        return x;
    }
    /// The inverse of `spread`: moves bit D · n to bit n.
    static Key gathered(Key x) noexcept {
        if constexpr (D == 2) {
            x &= 0x5555555555555555;
            x = (x | x >> 1) & 0x3333333333333333;
            x = (x | x >> 2) & 0x0f0f0f0f0f0f0f0f;
            x = (x | x >> 4) & 0x00ff00ff00ff00ff;
            x = (x | x >> 8) & 0x0000ffff0000ffff;
            x = (x | x >> 16) & 0x00000000ffffffff;
        } else if constexpr (D == 3) {
            x &= 0x1249249249249249;
            x = (x | x >> 2) & 0x10c30c30c30c30c3;
            x = (x | x >> 4) & 0x100f00f00f00f00f;
            x = (x | x >> 8) & 0x001f0000ff0000ff;
            x = (x | x >> 16) & 0x001f00000000ffff;
            x = (x | x >> 32) & 0x00000000001fffff;
        }
        return x;
    }
    std::size_t slot(Key key) const noexcept { // Fibonacci hashing (Knuth, TAOCP 3, sec. 6.4)
        return bits_ == 0 ? 0 : std::size_t((key * 0x9e3779b97f4a7c15u) >> (64 - bits_));
    }

    Buffer<Key> keys_;
    unsigned bits_ = 0;
    Buffer<std::uint32_t> table_{1, none}; ///< hash table of node indices, at most half full
};

/// A corner closer to the boundary than this, in units, or within a bone, is not a node.
inline constexpr double on_facet_distance = 1e-6;

/// Returns the nodes of a tree: the distinct corners, inside the domain, of all leaves that are not outside.
/// Corners of inside leaves are inside without a test. Other corners are tested in integer arithmetic.
template <std::size_t D>
TreeNodes<D> nodes_of(const CutTree<D>& tree, const Running& running = {}) {
    using Key = typename TreeNodes<D>::Key;
    using Cell = typename CellTree<D>::Cell;
    Buffer<Key> corners; // twice the key, plus 1 if the boundary cuts the leaf
    const Running listing = running.subtask(0, 0.2);
    std::size_t leaves = 0;
    tree.cells().for_each_leaf([&](const Cell& leaf) {
        if (++leaves % 65536 == 0)
            detail::report_progress(listing, double(leaves) / double(tree.cells().leaves()));
        const CellState state = tree.state(leaf.number);
        if (state == CellState::out) return;
        for (std::size_t n = 0; n < CellTree<D>::children; ++n) {
            corners.push_back(2 * TreeNodes<D>::key(leaf.corner(n)) + (state == CellState::cut ? 1 : 0));
        }
    });
    detail::sort_in_runs(corners, running.subtask(0.2, 0.5));
    const auto is_inside = [&](Key key) {
        const auto index = TreeNodes<D>::index_of(key);
        std::array<std::int64_t, D> line{};
        typename CellTree<D>::Index doubled{}; // in half units, for leaf_at
        for (std::size_t k = 0; k < D; ++k) {
            line[k] = std::int64_t(index[k]) << tree.boundary().fraction();
            doubled[k] = 2 * index[k];
        }
        if (!tree.is_inside(line)) return false;
        const auto facets = tree.facets(tree.cells().leaf_at(doubled).number);
        return tree.boundary().nearest(facets, node_position<D>(index)).distance > on_facet_distance;
    };
    const auto keep = [&](std::size_t begin, std::size_t end, Buffer<Key>& keys) {
        for (std::size_t n = begin; n < end; ++n) {
            const Key key = corners[n] / 2;
            if (n > 0 && key == corners[n - 1] / 2) continue;
            if (corners[n] % 2 == 0 || is_inside(key)) keys.push_back(key);
        }
    };
    Buffer<Key> keys;
    const Running testing = running.subtask(0.5, 1);
    for (const auto& part : detail::in_runs<Buffer<Key>>(testing, corners.size(), 4096, [&] { return keep; }))
        keys.append(part.begin(), part.end());
    return TreeNodes<D>(std::move(keys));
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI
