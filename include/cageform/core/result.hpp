// The return type of functions that make a value: the value and a report.
#pragma once

#include <cageform/core/status.hpp>

#include <type_traits>

namespace cageform::inline CAGEFORM_ABI {

/// A value and a report:
///
///     const auto [binding, report] = bind(coordinates, points);
///     if (const auto packed = pack(binding)) write(packed.value.bytes());
///
/// A report is a Status, or has one as its member `status`. The value is empty unless that status is ok.
template <class Value, class Report = Status>
struct [[nodiscard]] Result {
    Value value{};
    Report report{};

    Status status() const noexcept {
        if constexpr (std::is_same_v<Report, Status>)
            return report;
        else
            return report.status;
    }
    explicit operator bool() const noexcept { return status() == Status::ok; }
};

} // namespace cageform::inline CAGEFORM_ABI
