// Converts failed allocations and cancellation to a Status.
#pragma once

#include <cageform/core/status.hpp>

#include <new>
#include <stdexcept>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Thrown when a progress callback cancels a function that returns no Status.
struct Cancelled {};

/// Returns f(). std::bad_alloc becomes Status::out_of_memory, Cancelled becomes Status::cancelled.
/// Without exceptions, a failed allocation ends the program.
template <class F>
Status guard_memory(F&& f) {
#if defined(__cpp_exceptions)
    try {
        return f();
    } catch (const std::bad_alloc&) {
        return Status::out_of_memory;
    } catch (const std::length_error&) {
        return Status::out_of_memory;
    } catch (const Cancelled&) {
        return Status::cancelled;
    }
#else
    return f();
#endif
}

} // namespace cageform::inline CAGEFORM_ABI::detail
