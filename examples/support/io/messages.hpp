#pragma once

// Messages of the programs on stderr: no program ends without one, and none of them commands a terminal.

#include <functional>
#include <string>
#include <string_view>

namespace cageform_support {

/// Text as it may be printed and written to a file: control characters, what is no character of Unicode, and
/// bytes that are no UTF-8, become such as \x1b. A tab stays, and a line break before two spaces: our lists
/// have these.
std::string printable(std::string_view text);

/// The exit code that asks for another try: EX_TEMPFAIL of sysexits.h.
inline constexpr int try_again = 75;

/// "program: message", printable; 1, the exit code of a failure.
int fail(const std::string& message);
void warn(const std::string& text); ///< "program: warning: text", printable
void note(const std::string& text); ///< "program: note: text", printable

/// The exit code of run(), or 1 and a line on stderr when memory or the standard library gives out, or what
/// was printed cannot be written. The program is named in all that it says.
int guarded(const char* program, const std::function<int()>& run);

} // namespace cageform_support
