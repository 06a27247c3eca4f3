// What every function returns that makes something.
#pragma once

#include <cageform/core/status.hpp>

#include <type_traits>

namespace cageform::inline CAGEFORM_ABI {

/// What was made, and the report of how it went:
///
///     const auto [binding, report] = bind(coordinates, points);
///     if (const auto packed = pack(binding)) write(packed.value.bytes());
///
/// A report is a Status, or has one as its member `status`. The value is empty unless that is ok.
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
