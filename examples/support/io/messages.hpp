#pragma once

// Messages on stderr. Control characters are escaped, so that a file's contents cannot control a terminal.

#include "io/expected.hpp"

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace cageform_support {

/// Escapes control characters, invalid UTF-8 and invalid code points as \x1b and so on. Kept: tabs, and line
/// breaks before two spaces (lists in messages).
std::string printable(std::string_view text);

/// Exit code for a temporary failure: EX_TEMPFAIL of sysexits.h.
inline constexpr int exit_temporary_failure = 75;

/// Prints "program: message", escaped; returns 1, the exit code of a failure.
int fail(const std::string& message);
/// Print "program: warning: text" and "program: note: text", escaped; nothing if the text is empty.
void warn(const std::string& text);
void note(const std::string& text);

/// An error that ends the program; guarded() prints its message.
struct Failure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Throws a Failure if there is a fault: a text that is not empty, or an error.
void fail_if(const std::string& fault);
void fail_if(const std::optional<std::string>& fault);
void fail_if(const std::optional<FileError>& fault);

/// The value of a result; throws its error as a Failure.
template <class T>
T value_or_fail(Expected<T> result) {
    if (!result) throw Failure(to_string(result.error()));
    return std::move(*result);
}

/// Returns the exit code of run(). Exceptions, and a failed write to stdout, give a message and code 1. Sets
/// the program name of all messages.
int guarded(const char* program, const std::function<int()>& run);

} // namespace cageform_support

/// Each program defines this function; main() in cli/main.cpp calls it. Returns the exit code.
int run_program(int argc, char** argv);
