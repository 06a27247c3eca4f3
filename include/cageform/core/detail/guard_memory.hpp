// Turns failed allocations into a status.
#pragma once

#include <cageform/core/status.hpp>

#include <new>
#include <stdexcept>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Runs `f` and returns its status; a failed allocation becomes Status::out_of_memory. (Without
/// exceptions the standard library ends the program instead.)
template <class F>
Status guard_memory(F&& f) {
#if defined(__cpp_exceptions)
    try {
        return f();
    } catch (const std::bad_alloc&) {
        return Status::out_of_memory;
    } catch (const std::length_error&) {
        return Status::out_of_memory;
    }
#else
    return f();
#endif
}

} // namespace cageform::inline CAGEFORM_ABI::detail
