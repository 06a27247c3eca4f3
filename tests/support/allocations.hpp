// Counts every allocation of a program. Include it in one file of the program only.
#pragma once

#include "allocation_count.hpp"

#include <cstdlib>
#include <new>

namespace cageform_tests {

inline void* counted_or_null(std::size_t size, std::size_t alignment = 1) noexcept {
    if (++allocations == failing_allocation) return nullptr;
    const std::size_t whole = (size + alignment - 1) / alignment * alignment;
    return alignment <= alignof(std::max_align_t) ? std::malloc(size != 0 ? size : 1)
                                                  : std::aligned_alloc(alignment, whole);
}

inline void* counted(std::size_t size, std::size_t alignment) {
    void* const memory = counted_or_null(size, alignment);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

// Not inlined: GNU would else see memory of a `new` passed to `free` and warn.
[[gnu::noinline]] inline void give_back(void* memory) noexcept {
    std::free(memory);
}

} // namespace cageform_tests

void* operator new(std::size_t size) {
    return cageform_tests::counted(size, 1);
}
void* operator new[](std::size_t size) {
    return cageform_tests::counted(size, 1);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
    return cageform_tests::counted(size, std::size_t(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
    return cageform_tests::counted(size, std::size_t(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    return cageform_tests::counted_or_null(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
    return cageform_tests::counted_or_null(size);
}
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
    return cageform_tests::counted_or_null(size, std::size_t(alignment));
}
void operator delete(void* p, const std::nothrow_t&) noexcept {
    cageform_tests::give_back(p);
}
void operator delete[](void* p, const std::nothrow_t&) noexcept {
    cageform_tests::give_back(p);
}
void operator delete(void* p) noexcept {
    cageform_tests::give_back(p);
}
void operator delete[](void* p) noexcept {
    cageform_tests::give_back(p);
}
void operator delete(void* p, std::size_t) noexcept {
    cageform_tests::give_back(p);
}
void operator delete[](void* p, std::size_t) noexcept {
    cageform_tests::give_back(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
    cageform_tests::give_back(p);
}
void operator delete[](void* p, std::align_val_t) noexcept {
    cageform_tests::give_back(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
    cageform_tests::give_back(p);
}
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept {
    cageform_tests::give_back(p);
}
