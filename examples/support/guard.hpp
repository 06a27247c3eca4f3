#pragma once

// What no program does: end without a word.

#include <cstdio>
#include <exception>
#include <iostream>
#include <new>

namespace cageform_examples {

/// The exit code of run(), or 1 and a line on stderr when memory or the standard library gives out, or what was
/// printed cannot be written.
template <class Run>
int guarded(const char* program, Run&& run) {
    try {
        const int code = run();
        if (std::cout.flush() && std::fflush(stdout) == 0) return code;
        std::cerr << program << ": cannot write to standard output\n";
    } catch (const std::bad_alloc&) {
        std::cerr << program << ": out of memory\n";
    } catch (const std::exception& error) {
        std::cerr << program << ": " << error.what() << '\n';
    }
    return 1;
}

} // namespace cageform_examples
