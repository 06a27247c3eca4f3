// The order in which sites are inserted into a Delaunay triangulation.
#pragma once

#include <cageform/cage/sites/site_lattice.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Whether `a` precedes `b` on the Morton curve: compares along the axis whose coordinates differ in
/// the highest bit (Chan 2002).
template <std::size_t D>
bool before_on_curve(const LatticePoint<D>& a, const LatticePoint<D>& b) noexcept {
    std::size_t axis = 0;
    std::uint64_t most = 0;
    for (std::size_t k = 0; k < D; ++k) {
        const auto differing = std::uint64_t(a[k]) ^ std::uint64_t(b[k]);
        if (most < differing && most < (most ^ differing)) {
            most = differing;
            axis = k;
        }
    }
    return a[axis] < b[axis];
}

/// Returns the insertion round of a site. A hash of the position decides it: half of the sites are in
/// the last round, a quarter in the round before it, and so on.
template <std::size_t D>
int round_of(const LatticePoint<D>& a) noexcept {
    std::uint64_t z = 0;
    for (const std::int64_t x : a) {
        z = (z ^ std::uint64_t(x)) * 0x9E3779B97F4A7C15u;
        z ^= z >> 29;
    }
    int round = 0;
    while (round < 20 && ((z >> round) & 1u) != 0) ++round;
    return -round;
}

/// Returns the indices of points in the order of their insertion: by rounds, each sorted along the
/// Morton curve (Amenta, Choi, Rote 2003).
template <std::size_t D>
std::vector<std::uint32_t> insertion_order(std::span<const LatticePoint<D>> points) {
    struct Entry {
        int round;
        std::uint32_t site;
    };
    std::vector<Entry> entries(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i) entries[i] = {round_of<D>(points[i]), i};
    std::sort(entries.begin(), entries.end(), [&](const Entry& a, const Entry& b) {
        if (a.round != b.round) return a.round < b.round;
        if (points[a.site] != points[b.site]) return before_on_curve<D>(points[a.site], points[b.site]);
        return a.site < b.site;
    });
    std::vector<std::uint32_t> order;
    order.reserve(entries.size());
    for (const Entry& entry : entries) order.push_back(entry.site);
    return order;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
