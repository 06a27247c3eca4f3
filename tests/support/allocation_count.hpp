// How many allocations a program has made, where one of its files includes allocations.hpp.
#pragma once

#include <atomic>
#include <cstddef>

namespace cageform_tests {

inline std::atomic<std::size_t> allocations{0};

} // namespace cageform_tests
