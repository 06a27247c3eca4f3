// How many allocations a program has made, and which of them fails, where one of its files includes
// allocations.hpp.
#pragma once

#include <atomic>
#include <cstddef>

namespace cageform_tests {

inline std::atomic<std::size_t> allocations{0};

/// The allocation that fails, counted as they are: 0 for none.
inline std::atomic<std::size_t> failing_allocation{0};

} // namespace cageform_tests
