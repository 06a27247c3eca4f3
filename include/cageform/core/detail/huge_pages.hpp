// Requests huge pages (2 MB) for large arrays.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace cageform::inline CAGEFORM_ABI::detail {

/// Asks the system to use huge pages for memory that has not been written yet. The first write to a 4
/// KB page costs one to two microseconds, often more than the computation on it. Works on Linux with
/// transparent huge pages (`madvise` or `always`). Elsewhere, or below 4 MB, it does nothing.
inline void advise_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) noexcept {
#if defined(MADV_HUGEPAGE)
    constexpr std::size_t page = std::size_t{1} << 21;
    if (bytes < 2 * page) return;
    const std::size_t before = (page - reinterpret_cast<std::uintptr_t>(memory) % page) % page;
    (void)::madvise(static_cast<std::byte*>(memory) + before, (bytes - before) / page * page, MADV_HUGEPAGE);
#endif
}

/// Resizes `to` without preserving its values: elements are T() or old ones. Requests huge pages for
/// new memory.
template <class T>
void resize_large(std::vector<T>& to, std::size_t size) {
    if (size > to.capacity()) {
        to = std::vector<T>();
        to.reserve(size);
        advise_huge_pages(to.data(), size * sizeof(T));
    }
    to.resize(size);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
