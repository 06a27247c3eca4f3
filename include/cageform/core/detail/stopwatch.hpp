// Measures how long a computation takes, and guards it against failed allocations.
#pragma once

#include <cageform/core/detail/guard_memory.hpp>

#include <ctime>
// Uses POSIX's clock where available: <chrono> costs every file a quarter of a second to compile.
// On Windows, mingw-w64 has that clock in a separate library, which not every program links.
#if defined(CLOCK_MONOTONIC) && !defined(_WIN32)
#define CAGEFORM_DETAIL_POSIX_CLOCK
#else
#include <chrono>
#endif

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns wall time in seconds, from a monotonic clock whose origin stays fixed while the program
/// runs.
inline double seconds_now() noexcept {
#if defined(CAGEFORM_DETAIL_POSIX_CLOCK)
    ::timespec now{};
    (void)::clock_gettime(CLOCK_MONOTONIC, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
#else
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
#endif
}

/// Runs `f`, which returns a Status, under the memory guard and a stopwatch; stores both results in
/// `report`.
template <class Report, class F>
void run_into(Report& report, const F& f) {
    const double start = seconds_now();
    report.status = guard_memory(f);
    report.seconds = seconds_now() - start;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
