// Measures the wall time of a computation and converts failed allocations to a Status.
#pragma once

#include <cageform/core/detail/guard_memory.hpp>

#include <ctime>
// Uses POSIX's clock where available, as <chrono> takes a quarter of a second to compile. mingw-w64 has
// that clock in a separate library, so Windows uses <chrono>.
#if defined(CLOCK_MONOTONIC) && !defined(_WIN32)
#define CAGEFORM_DETAIL_POSIX_CLOCK
#else
#include <chrono>
#endif

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the wall time in seconds, from a monotonic clock.
inline double seconds_now() noexcept {
#if defined(CAGEFORM_DETAIL_POSIX_CLOCK)
    ::timespec now{};
    (void)::clock_gettime(CLOCK_MONOTONIC, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
#else
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
#endif
}

/// Runs `f`, which returns a Status, under guard_memory; stores status and seconds in `report`.
template <class Report, class F>
void run_into(Report& report, const F& f) {
    const double start = seconds_now();
    report.status = guard_memory(f);
    report.seconds = seconds_now() - start;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
