// make_cage with options.looseness: searches for the fewest vertices. The tight contour is made once; only
// the last steps are repeated for each number.
#pragma once

#include <cageform/cage/detail/primitives.hpp>
#include <cageform/enclose/types/make_cage_options.hpp>

#include <algorithm>
#include <iterator>
#include <map>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Numbers of vertices from `least` to `most`, ascending in steps of 5 % or 1. `base` times powers of two are
/// included.
inline std::vector<std::size_t> vertex_counts(std::size_t least, std::size_t base, std::size_t most) {
    std::vector<std::size_t> counts;
    for (std::size_t n = least; n < most;) {
        counts.push_back(n);
        while (base <= n) base *= 2;
        n = (std::min)((std::max)(n + 1, n + n / 20), base);
    }
    counts.push_back((std::max)(least, most));
    return counts;
}

/// Returns the largest distance from the points to the nearest facet of a cage. Faster if consecutive points
/// are close to each other.
template <std::size_t D>
double deepest_hollow(std::span<const Vec<double, D>> points, std::span<const Corners<D>> facets) noexcept {
    double most = 0;
    std::size_t nearest = 0;
    for (const auto& p : points) {
        double least = distance_to_facet(p, facets[nearest]);
        for (std::size_t k = 0; k < facets.size() && least > most; ++k) {
            const double distance = distance_to_facet(p, facets[k]);
            if (distance < least) nearest = k;
            least = (std::min)(least, distance);
        }
        most = (std::max)(most, least);
    }
    return most;
}

/// Chooses the number of vertices to try next. Doubles or halves the first number until the limit is
/// bracketed, then bisects. Finally tries two and four times the chosen number for the report.
template <class Cage>
class VertexCountSearch {
public:
    struct Attempt {
        MakeCageReport::Attempt result;
        Cage cage;
    };

    ///   counts  ascending, not empty
    VertexCountSearch(std::vector<std::size_t> counts, std::size_t first, double looseness)
        : counts_(std::move(counts))
        , first_(first)
        , looseness_(looseness) {}

    std::size_t count(std::size_t index) const noexcept { return counts_[index]; }

    /// Index of the count to try next; none if the search is over.
    std::optional<std::size_t> next() const {
        if (tried_.empty()) return index_of(first_);
        const auto found = answer();
        std::optional<std::size_t> try_next;
        if (found == tried_.end()) { // all cages tried are too loose
            const std::size_t highest = tried_.rbegin()->first;
            if (highest + 1 < counts_.size())
                try_next = (std::max)(index_of(2 * counts_[highest]), highest + 1);
            return try_next;
        }
        const std::size_t at = found->first;
        if (found == tried_.begin()) {
            if (at > 0) return (std::min)(index_of(counts_[at] / 2), at - 1);
        } else if (const std::size_t below = std::prev(found)->first; below + 1 < at) {
            return below + (at - below) / 2;
        }
        for (const std::size_t times : {2U, 4U}) {
            const std::size_t wanted = times * counts_[at], last = counts_.back();
            if (times == 4 && wanted > 500) break; // this trial would take seconds
            const std::size_t more = index_of((std::min)(wanted + counts_[at] / 20, last));
            if (tried_.count(more) == 0) return more;
        }
        return try_next;
    }
    void add(std::size_t index, Attempt attempt) { tried_.emplace(index, std::move(attempt)); }

    /// Cage of the fewest vertices within the limit; if there is none, the tightest cage.
    Cage best() {
        auto found = answer();
        if (found == tried_.end())
            found = std::min_element(tried_.cbegin(), tried_.cend(), [](const auto& a, const auto& b) {
                return a.second.result.excess < b.second.result.excess;
            });
        return std::move(tried_.at(found->first).cage);
    }
    std::vector<MakeCageReport::Attempt> attempts() const {
        std::vector<MakeCageReport::Attempt> all;
        all.reserve(tried_.size());
        for (const auto& [index, attempt] : tried_) all.push_back(attempt.result);
        return all;
    }

private:
    /// Index of the largest count up to `vertices`, or 0.
    std::size_t index_of(std::size_t vertices) const noexcept {
        const auto above = std::upper_bound(counts_.begin(), counts_.end(), vertices);
        return above == counts_.begin() ? 0 : std::size_t(above - counts_.begin()) - 1;
    }
    auto answer() const {
        return std::find_if(tried_.begin(), tried_.end(),
                            [&](const auto& entry) { return entry.second.result.excess <= looseness_; });
    }

    std::vector<std::size_t> counts_;
    std::size_t first_;
    double looseness_;
    std::map<std::size_t, Attempt> tried_; ///< keys are indices into counts_
};

} // namespace cageform::inline CAGEFORM_ABI::detail
