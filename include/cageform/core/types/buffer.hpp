// A vector of trivially copyable elements. The code that reallocates is compiled once, not once per type.
//
// The compiler instantiates about sixty functions per std::vector type, ten per Buffer type. This saves a
// fifth of the compile time of a file that binds with a solver. Buffer is for private memory;
// interfaces use std::vector and spans.
#pragma once

#include <cageform/core/detail/huge_pages.hpp>

#include <cstddef>
#include <cstring>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>

namespace cageform::inline CAGEFORM_ABI {
namespace detail {

/// The untyped memory of a Buffer. Size and alignment of the elements are arguments.
class RawBuffer {
public:
    std::size_t size() const noexcept { return size_; }
    std::size_t capacity() const noexcept { return capacity_; }
    bool empty() const noexcept { return size_ == 0; }
    void clear() noexcept { size_ = 0; }

protected:
    struct Element {
        std::size_t size, alignment;
    };

    RawBuffer() noexcept = default;
    RawBuffer(const RawBuffer&) = delete;
    RawBuffer& operator=(const RawBuffer&) = delete;
    ~RawBuffer() = default;

    void swap(RawBuffer& other) noexcept {
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        std::swap(capacity_, other.capacity_);
    }

    /// Reallocates to exactly `capacity` elements, which must be at least `size()`.
    void move_to(std::size_t capacity, Element element) {
        if (capacity > (std::numeric_limits<std::ptrdiff_t>::max)() / element.size)
            capacity =
                (std::numeric_limits<std::ptrdiff_t>::max)() / element.size; // more than any system has
        void* const moved =
            capacity == 0 ? nullptr
                          : ::operator new(capacity * element.size, std::align_val_t(element.alignment));
        advise_huge_pages(moved, capacity * element.size);
        if (size_ != 0) std::memcpy(moved, data_, size_ * element.size);
        free(element);
        data_ = moved;
        capacity_ = capacity;
    }
    /// Reserves memory for `count` more elements; at least doubles the size when it reallocates.
    void grow(std::size_t count, Element element) {
        if (count <= capacity_ - size_) return;
        const std::size_t most = (std::numeric_limits<std::size_t>::max)() - size_;
        move_to(size_ + (count > most ? most : count > size_ ? count : size_), element);
    }
    /// Appends elements; `from` must not point into this buffer.
    void append_raw(const void* from, std::size_t count, Element element) {
        grow(count, element);
        if (count != 0)
            std::memcpy(static_cast<std::byte*>(data_) + size_ * element.size, from, count * element.size);
        size_ += count;
    }
    void free(Element element) noexcept {
        if (data_ != nullptr) ::operator delete(data_, std::align_val_t(element.alignment));
    }

    void* data_ = nullptr;
    std::size_t size_ = 0, capacity_ = 0;
};

} // namespace detail

/// Contiguous elements, as in a std::vector. Throws bad_alloc if memory runs out.
template <class T>
class Buffer : public detail::RawBuffer {
public:
    using value_type = T;

    Buffer() noexcept = default;
    explicit Buffer(std::size_t size) { resize(size); }
    Buffer(const T* first, const T* last) { append(first, last); }
    Buffer(std::size_t size, const T& value) {
        reserve(size);
        while (size_ < size) push_back(value);
    }
    Buffer(const Buffer& other)
        : Buffer(other.begin(), other.end()) {}
    Buffer(Buffer&& other) noexcept { swap(other); }
    Buffer& operator=(const Buffer& other) {
        if (this == &other) return *this;
        clear();
        append(other.begin(), other.end());
        return *this;
    }
    Buffer& operator=(Buffer&& other) noexcept {
        swap(other);
        return *this;
    }
    ~Buffer() { free(element()); }

    T* data() noexcept { return static_cast<T*>(data_); }
    const T* data() const noexcept { return static_cast<const T*>(data_); }
    T* begin() noexcept { return data(); }
    const T* begin() const noexcept { return data(); }
    T* end() noexcept { return data() + size_; }
    const T* end() const noexcept { return data() + size_; }
    T& operator[](std::size_t i) noexcept { return data()[i]; }
    const T& operator[](std::size_t i) const noexcept { return data()[i]; }
    T& front() noexcept { return *data(); }
    const T& front() const noexcept { return *data(); }
    T& back() noexcept { return data()[size_ - 1]; }
    const T& back() const noexcept { return data()[size_ - 1]; }

    void reserve(std::size_t capacity) {
        if (capacity > capacity_) move_to(capacity, element());
    }
    void shrink_to_fit() {
        if (size_ < capacity_) move_to(size_, element());
    }
    /// Resizes; new elements are T().
    void resize(std::size_t size) {
        if (size > size_) grow(size - size_, element());
        for (; size_ < size; ++size_) ::new (static_cast<void*>(data() + size_)) T();
        size_ = size;
    }
    /// Appends an element and returns it. `value` may refer to an element of this buffer.
    T& push_back(const T& value = T()) {
        const T copy = value;
        grow(1, element());
        return *::new (static_cast<void*>(data() + size_++)) T(copy);
    }
    /// Appends [first, last), which must not lie in this buffer.
    void append(const T* first, const T* last) { append_raw(first, std::size_t(last - first), element()); }
    /// Removes the elements from `first` to the end.
    void erase_from(const T* first) noexcept { size_ = std::size_t(first - data()); }

private:
    static constexpr Element element() noexcept {
        static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
        return {sizeof(T), alignof(T)};
    }
};

} // namespace cageform::inline CAGEFORM_ABI
