#pragma once

// A value read from a file or a text, or the error with its position.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace cageform_support {

/// An error and its position. Line and column count from one, in bytes; zero means unknown.
struct FileError {
    std::string message;
    std::size_t line = 0;
    std::size_t column = 0;
};

/// "message", "message (line 3)" or "message (line 3, column 7)".
std::string to_string(const FileError& error);

/// An error at a position in a text.
FileError error_in_text(std::string why, std::string_view text, std::size_t position);

/// A value or the reason why there is none; `*` and `->` only where it tests true.
template <class T>
class [[nodiscard]] Expected {
public:
    Expected(T value)
        : content_(std::move(value)) {}
    Expected(FileError error)
        : content_(std::move(error)) {}

    explicit operator bool() const noexcept { return content_.index() == 0; }
    T& operator*() { return std::get<0>(content_); }
    const T& operator*() const { return std::get<0>(content_); }
    T* operator->() { return &std::get<0>(content_); }
    const T* operator->() const { return &std::get<0>(content_); }
    const FileError& error() const { return std::get<1>(content_); }
    T value_or(T otherwise) const { return *this ? **this : std::move(otherwise); }
    std::optional<T> if_any() const { return *this ? std::optional<T>(**this) : std::nullopt; }

private:
    std::variant<T, FileError> content_;
};

} // namespace cageform_support
