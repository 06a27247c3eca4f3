// Control points without a cage: sites anywhere on, in or around a figure.
#pragma once

#include <cageform/cage/sites/check_sites.hpp>
#include <cageform/cage/types/report.hpp>
#include <cageform/core/view.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A set of sites in 2D or 3D, in any order and without topology. Copies the sites. Construction never
/// fails; `check` reports whether the sites are valid control points.
template <Scalar T, std::size_t D>
class PointSet {
    static_assert(D == 2 || D == 3, "sites lie in the plane or in space");

public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    PointSet() = default;

    template <PointRangeIn<D> R>
    explicit PointSet(const R& sites)
        : status_(detail::guard_memory([&] {
            const std::size_t count = std::size(sites);
            sites_.reserve(count);
            for (std::size_t i = 0; i < count; ++i) sites_.push_back(to_vec<T>(sites[i]));
        })) {
        if (status_ != Status::ok) sites_.clear();
    }

    /// Returns ok, or out_of_memory if the sites did not fit in memory. The set is then empty, and `check`
    /// reports this status. Copying may throw.
    Status status() const noexcept { return status_; }
    std::size_t size() const noexcept { return sites_.size(); }
    std::span<const Vec<T, D>> sites() const noexcept { return sites_; }
    const Vec<T, D>& operator[](std::size_t i) const noexcept { return sites_[i]; }

private:
    std::vector<Vec<T, D>> sites_;
    Status status_ = Status::ok; // declared last: its initialiser fills the other members
};

template <PointRange R>
PointSet(const R&) -> PointSet<range_scalar_t<R>, range_dimension<R>>;

/// Checks whether sites are valid control points. There must be at least D + 1 sites, all finite. No two
/// sites may be closer than the coincidence_tolerance of their bounds. The sites must not all lie within that
/// tolerance of one plane (in 2D, of one line). Each duplicate is reported once, with the first coincident
/// site. O(n log n).
template <Scalar T, std::size_t D>
CageReport check(const PointSet<T, D>& set) {
    return detail::report_on(set.status(), [&](CageReport& report) { detail::check_point_set(set, report); });
}

} // namespace cageform::inline CAGEFORM_ABI
