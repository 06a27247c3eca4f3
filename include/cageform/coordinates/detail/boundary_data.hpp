// The values that the functions of handles have on the boundary, by the kind of cage.
#pragma once

#include <cageform/cage/detail/boundary_value.hpp>
#include <cageform/core/status.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The data of harmonic functions; of most cages hat functions. A cage with others has a
/// specialisation.
///
///   status()           ok, or why there is no data
///   for_each_weight(value, f)
///                      f(handle, weight) for the handles whose value at the place is not zero
///   for_each_handle(value, f)
///                      f(handle) for them
///   Table(data, values)
///                      the same for many places, made once; `values` outlive it
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

} // namespace cageform::inline CAGEFORM_ABI::detail
