#pragma once

// Messages on stderr. Control characters are escaped, so that a file's contents cannot control a terminal.

#include <functional>
#include <string>
#include <string_view>

namespace cageform_support {

/// Escapes control characters, invalid UTF-8 and invalid code points as \x1b and so on. Kept: tabs, and line
/// breaks before two spaces (lists in messages).
std::string printable(std::string_view text);

/// Exit code for a temporary failure: EX_TEMPFAIL of sysexits.h.
inline constexpr int try_again = 75;

/// Prints "program: message", escaped; returns 1, the exit code of a failure.
int fail(const std::string& message);
void warn(const std::string& text); ///< "program: warning: text", escaped
void note(const std::string& text); ///< "program: note: text", escaped

/// Returns the exit code of run(). Exceptions, and a failed write to stdout, give a message and code 1. Sets
/// the program name of all messages.
int guarded(const char* program, const std::function<int()>& run);

} // namespace cageform_support

/// Each program defines this function; main() in cli/main.cpp calls it. Returns the exit code.
int run_program(int argc, char** argv);
