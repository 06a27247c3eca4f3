#include "io/messages.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>

#include <fcntl.h>
#include <unistd.h>

namespace cageform_support {

namespace {

std::string program_name; // set once, before a program reads its options

/// Length in bytes of the first character if it may be printed; else 0.
std::size_t printable_bytes(std::string_view text) {
    const auto byte = [&](std::size_t k) { return k < text.size() ? unsigned(std::uint8_t(text[k])) : 0; };
    if (byte(0) < 0x80) return text.starts_with('\t') || (byte(0) >= 0x20 && byte(0) != 0x7f) ? 1 : 0;
    const std::size_t count = byte(0) >= 0xf0 ? 4 : byte(0) >= 0xe0 ? 3 : 2;
    unsigned code = byte(0) & (0x7fU >> count);
    for (std::size_t k = 1; k < count; ++k) {
        if ((byte(k) & 0xc0) != 0x80) return 0;
        code = code << 6 | (byte(k) & 0x3f);
    }
    constexpr std::array least{0x0U, 0x0U, 0xa0U, 0x800U, 0x10000U}; // 0x80 to 0x9f are controls
    const bool is_character = code >= least[count] && code <= 0x10ffff &&
                              !(code >= 0xd800 && code < 0xe000) && code != 0xfffe && code != 0xffff;
    return is_character && byte(0) >= 0xc0 && byte(0) < 0xf8 ? count : 0;
}

/// Opens /dev/null for closed standard streams. Otherwise the next opened file would get that descriptor and
/// receive the program's output.
void keep_streams_apart() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (fcntl(stream, F_GETFD) < 0) (void)open("/dev/null", O_RDONLY); // takes the lowest number
    }
}

void say(const std::string& kind, const std::string& text) {
    std::cerr << program_name << ": " << kind << printable(text) << '\n';
}

} // namespace

std::string printable(std::string_view text) {
    constexpr const char* digits = "0123456789abcdef";
    std::string result;
    while (!text.empty()) {
        const std::size_t count = text.starts_with("\n  ") ? 3 : printable_bytes(text);
        const unsigned byte = std::uint8_t(text.front());
        if (count > 0) {
            result += text.substr(0, count);
        } else {
            result += std::string("\\x") + digits[byte >> 4] + digits[byte & 15];
        }
        text.remove_prefix(std::max<std::size_t>(count, 1));
    }
    return result;
}

int fail(const std::string& message) {
    say("", message);
    return 1;
}

void warn(const std::string& text) {
    if (!text.empty()) say("warning: ", text);
}

void note(const std::string& text) {
    if (!text.empty()) say("note: ", text);
}

void fail_if(const std::string& fault) {
    if (!fault.empty()) throw Failure(fault);
}

void fail_if(const std::optional<std::string>& fault) {
    if (fault) throw Failure(*fault);
}

void fail_if(const std::optional<FileError>& fault) {
    if (fault) throw Failure(to_string(*fault));
}

int guarded(const char* program, const std::function<int()>& run) {
    program_name = program;
    keep_streams_apart();
    try {
        const int code = run();
        if (std::cout.flush() && std::fflush(stdout) == 0) return code;
        return fail("cannot write to standard output");
    } catch (const std::bad_alloc&) {
        std::cerr << program << ": out of memory\n";
        return 1;
    } catch (const std::exception& error) {
        return fail(error.what());
    }
}

} // namespace cageform_support
