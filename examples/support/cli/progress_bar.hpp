#pragma once

// A progress bar on stderr, if that is a terminal.

#include "io/messages.hpp"

#include <chrono>
#include <cstdio>
#include <functional>
#include <string>

#include <unistd.h>

namespace cageform_support {

/// Draws "label [=====     ] 42 %" after the first half second; never cancels.
class ProgressBar {
public:
    explicit ProgressBar(const std::string& label)
        : label_(printable(label)) {}
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;
    ~ProgressBar() {
        if (drawn_ >= 0) std::fputs("\r\033[K", stderr);
    }

    /// The progress callback; empty if stderr is not a terminal.
    std::function<bool(double)> callback() {
        if (isatty(fileno(stderr)) == 0) return {};
        return [this](double done) {
            draw(done);
            return true;
        };
    }

private:
    void draw(double done) {
        using namespace std::chrono;
        const int percent = int(100 * done);
        if (percent == drawn_ || steady_clock::now() - start_ < milliseconds(500)) return;
        drawn_ = percent;
        std::string bar(std::size_t(percent) * 40 / 100, '=');
        bar.resize(40, ' ');
        std::fprintf(stderr, "\r%s [%s] %3d %%", label_.c_str(), bar.c_str(), percent);
    }

    std::string label_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    int drawn_ = -1;
};

} // namespace cageform_support
