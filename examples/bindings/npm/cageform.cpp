// The C interface as WebAssembly, for the npm package. The module has no C++ exceptions. When an allocation
// fails, the host unwinds the call: cageform_host_fail() throws in JavaScript. cageform_call_undo() then
// frees the allocations of the call, which are kept in a list.

#define CAGEFORM_C_IMPLEMENTATION
#include <cageform/c/cageform.h>

#include "layout_check.hpp" // by write_module.py: checks the struct offsets that JavaScript uses

#include <cstdarg>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>

#define FROM_HOST(name) __attribute__((import_module("cageform"), import_name(#name)))

extern "C" {
/// Ends the call with a status.
[[noreturn]] FROM_HOST(fail) void cageform_host_fail(cageform_status status);
/// Receives the completed fraction; returns 0 to cancel.
FROM_HOST(progress) int cageform_host_progress(void* context, double done);
}

namespace {

/// The header of each allocation.
struct Block {
    Block* before;
    Block* after;
    void* memory;
    std::uint32_t reserved;
};
static_assert(sizeof(Block) == 16);
Block own_blocks{&own_blocks, &own_blocks, nullptr, 0}; // circular list: allocations of the current call

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

/// The standard library calls this function instead of throwing.
[[noreturn]] void std::__libcpp_verbose_abort(const char* format, ...) {
    const bool is_memory =
        std::strncmp(format, "length_error", 12) == 0 || std::strncmp(format, "bad_a", 5) == 0;
    cageform_host_fail(is_memory ? CAGEFORM_OUT_OF_MEMORY : CAGEFORM_FAILED);
}

extern "C" {

/// JavaScript calls this function before every call.
void cageform_call_begin() {
    take_out(own_blocks); // earlier allocations stay in a list of their own
    own_blocks.before = own_blocks.after = &own_blocks;
}
/// Frees the allocations of a failed call.
void cageform_call_undo() {
    while (own_blocks.after != &own_blocks) release(own_blocks.after + 1);
}
/// Returns a function for cageform_running::progress that calls the host.
void* cageform_call_progress() {
    return reinterpret_cast<void*>(&cageform_host_progress);
}

} // extern "C"
