#pragma once

// The result of reading a file: a value, or an error with its position.

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace cageform_support {

/// An error message and its position. Line and column (in bytes) count from 1; 0 is unknown.
struct FileError {
    std::string message;
    std::size_t line = 0;
    std::size_t column = 0;
};

/// "message", "message (line 3)" or "message (line 3, column 7)".
std::string to_string(const FileError& error);

/// An error at a byte offset of a text.
FileError error_in_text(std::string why, std::string_view text, std::size_t position);

/// A value or an error. `*` and `->` require that it holds a value.
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
    /// The value. Throws std::runtime_error with the message of the error, if any; main() prints it.
    T value() && {
        if (!*this) throw std::runtime_error(to_string(error()));
        return std::move(**this);
    }
    T value_or(T otherwise) const { return *this ? **this : std::move(otherwise); }
    std::optional<T> if_any() const { return *this ? std::optional<T>(**this) : std::nullopt; }

private:
    std::variant<T, FileError> content_;
};

} // namespace cageform_support
