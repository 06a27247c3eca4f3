// Converts failed allocations and cancellation to a Status.
#pragma once

#include <cageform/core/status.hpp>

#include <new>
#include <stdexcept>
#include <type_traits>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Thrown if a progress callback cancels work that returns no status.
struct Cancelled {};

/// Runs `f` and returns its status, or ok if `f` returns nothing. A failed allocation becomes
/// Status::out_of_memory, and Cancelled becomes Status::cancelled. (Without exceptions the standard library
/// ends the program at a failed allocation.)
template <class F>
Status guard_memory(F&& f) {
    const auto run = [&]() -> Status {
        if constexpr (std::is_void_v<decltype(f())>) {
            f();
            return Status::ok;
        } else {
            return f();
        }
    };
#if defined(__cpp_exceptions)
    try {
        return run();
    } catch (const std::bad_alloc&) {
        return Status::out_of_memory;
    } catch (const std::length_error&) {
        return Status::out_of_memory;
    } catch (const Cancelled&) {
        return Status::cancelled;
    }
#else
    return run();
#endif
}

} // namespace cageform::inline CAGEFORM_ABI::detail
