// The C interface as WebAssembly, for the npm package. Without exceptions no failed allocation can unwind
// what runs. Here the host does: cageform_host_fail() throws in JavaScript, which drops the frames, and
// cageform_call_undo() then frees what the call has allocated so far, as a list of it is kept.

#define CAGEFORM_C_IMPLEMENTATION
#include <cageform/c/cageform.h>

#include "layout_check.hpp" // written by write_module.py: structs are where JavaScript looks for them

#include <cstdarg>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>

#define FROM_HOST(name) __attribute__((import_module("cageform"), import_name(#name)))

extern "C" {
/// Ends the call with a status.
[[noreturn]] FROM_HOST(fail) void cageform_host_fail(cageform_status status);
/// Receives the fraction done; 0 cancels.
FROM_HOST(progress) int cageform_host_progress(void* context, double done);
}

namespace {

/// Stands before each allocation.
struct Block {
    Block* before;
    Block* after;
    void* memory;
    std::uint32_t reserved;
};
static_assert(sizeof(Block) == 16);
Block own_blocks{&own_blocks, &own_blocks, nullptr, 0}; // a ring: those of the call that runs

void take_out(Block& block) {
    block.before->after = block.after;
    block.after->before = block.before;
}

void* allocate(std::size_t size, std::size_t alignment) {
    alignment = alignment < sizeof(Block) ? sizeof(Block) : alignment;
    if (size > PTRDIFF_MAX - 2 * alignment) return nullptr;
    void* const memory = std::malloc(size + alignment);
    if (memory == nullptr) return nullptr;
    const auto place = (reinterpret_cast<std::uintptr_t>(memory) + alignment) & ~(alignment - 1);
    auto* const block = reinterpret_cast<Block*>(place) - 1;
    *block = {&own_blocks, own_blocks.after, memory, 0};
    block->after->before = block;
    own_blocks.after = block;
    return block + 1;
}
void* allocate_or_fail(std::size_t size, std::size_t alignment) {
    void* const memory = allocate(size, alignment);
    if (memory == nullptr) cageform_host_fail(CAGEFORM_OUT_OF_MEMORY);
    return memory;
}
void release(void* given) {
    if (given == nullptr) return;
    Block* const block = static_cast<Block*>(given) - 1;
    take_out(*block);
    std::free(block->memory);
}

constexpr std::size_t usual = sizeof(Block);

} // namespace

void* operator new(std::size_t size) {
    return allocate_or_fail(size, usual);
}
void* operator new[](std::size_t size) {
    return allocate_or_fail(size, usual);
}
void* operator new(std::size_t size, std::align_val_t to) {
    return allocate_or_fail(size, std::size_t(to));
}
void* operator new[](std::size_t size, std::align_val_t to) {
    return allocate_or_fail(size, std::size_t(to));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    return allocate(size, usual);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
    return allocate(size, usual);
}
void* operator new(std::size_t size, std::align_val_t to, const std::nothrow_t&) noexcept {
    return allocate(size, std::size_t(to));
}
void* operator new[](std::size_t size, std::align_val_t to, const std::nothrow_t&) noexcept {
    return allocate(size, std::size_t(to));
}
void operator delete(void* memory) noexcept {
    release(memory);
}
void operator delete[](void* memory) noexcept {
    release(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    release(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
    release(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    release(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
    release(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
    release(memory);
}
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
    release(memory);
}

/// The standard library calls it where it would throw.
[[noreturn]] void std::__libcpp_verbose_abort(const char* format, ...) {
    const bool is_memory =
        std::strncmp(format, "length_error", 12) == 0 || std::strncmp(format, "bad_a", 5) == 0;
    cageform_host_fail(is_memory ? CAGEFORM_OUT_OF_MEMORY : CAGEFORM_FAILED);
}

extern "C" {

/// Precedes every call.
void cageform_call_begin() {
    take_out(own_blocks); // the others stay a ring
    own_blocks.before = own_blocks.after = &own_blocks;
}
/// Frees what the call that failed has allocated.
void cageform_call_undo() {
    while (own_blocks.after != &own_blocks) release(own_blocks.after + 1);
}
/// Returns cageform_running::progress, which asks the host.
void* cageform_call_progress() {
    return reinterpret_cast<void*>(&cageform_host_progress);
}

} // extern "C"
