// The boundary values of the handles' functions, for each kind of cage.
#pragma once

#include <cageform/cage/detail/boundary_value.hpp>
#include <cageform/core/detail/blocks.hpp>
#include <cageform/core/status.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The boundary data of harmonic functions. For most cages these are hat functions; a cage with
/// other data specialises this template.
///
///   status()           ok, or why there is no data
///   for_each_weight(value, f)
///                      calls f(handle, weight) for the handles with a non-zero value at the point
///   for_each_handle(value, f)
///                      calls f(handle) for them
///   Table(data, values)
///                      stores the weights at many points; `values` must outlive it
template <class Cage>
class BoundaryData : public HatData<Cage::dimension> {
public:
    using typename HatData<Cage::dimension>::Value;

    BoundaryData() = default;
    template <class Options>
    BoundaryData(const Cage& /*cage*/, const Options& /*options*/) noexcept {}

    static Status status() noexcept { return Status::ok; }

    class Table {
    public:
        Table() = default;
        Table(const BoundaryData& /*data*/, std::span<const Value> values) noexcept
            : values_(values) {}
        template <class F>
        void for_each_weight(std::size_t place, F&& f) const {
            BoundaryData::for_each_weight(values_[place], f);
        }

    private:
        std::span<const Value> values_;
    };
};

/// Writes the boundary data at a point as weights, into a lane of a block with `handles` rows.
template <class T, std::size_t K, class Data = HatData<K>>
void store_boundary_value(const BoundaryValue<K>& value, std::size_t handles, Lanes<T>* rows,
                          std::size_t lane, const Data& data = {}) {
    for (std::size_t i = 0; i < handles; ++i) rows[i][lane] = T(0);
    data.for_each_weight(
        value, [&](std::uint32_t handle, double weight) { rows[handle][lane] += static_cast<T>(weight); });
}

} // namespace cageform::inline CAGEFORM_ABI::detail
