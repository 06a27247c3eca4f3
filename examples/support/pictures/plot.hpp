#pragma once

// Axes of plots: positions and numbers of marks.

#include "io/csv.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace cageform_support {

/// Formats a number with a printf() format.
inline std::string text_of(const char* format, double x) {
    return formatted(format, x);
}

/// Formats a multiple of a step (1, 2 or 5 times a power of ten) with the necessary digits.
inline std::string number_on_axis(double x, double step) {
    if (std::fabs(x) < 1e-6 * step) return "0";
    const int last = int(std::floor(std::log10(step) + 1e-9)); // power of ten of the last digit
    if (last >= -4 && std::fabs(x) < 1e6)
        return text_of(("%." + std::to_string(std::max(-last, 0)) + "f").c_str(), x);
    const int digits =
        std::max(int(std::floor(std::log10(std::fabs(x)) + 1e-9)) - last, 0); // after the point
    const std::string text = text_of(("%." + std::to_string(std::min(digits, 17)) + "e").c_str(), x);
    const std::size_t e = text.find('e'); // 1e-7, not 1e-07
    const std::string exponent = std::to_string(std::stoi(text.substr(e + 1)));
    return text.substr(0, e + 1) + exponent;
}

/// Maps the values `from` … `to` to the positions `begin` … `end`.
struct Axis {
    double from = 0, to = 1, begin = 0, end = 1;

    double at(double value) const { return begin + (value - from) / (to - from) * (end - begin); }
};

struct AxisMark {
    double value = 0;
    std::string number;
};

/// At most `most` + 1 marks at round values, with steps of at least `least_step`. None if double precision
/// does not distinguish them.
inline std::vector<AxisMark> marks_of(const Axis& axis, int most, double least_step = 0) {
    const double low = std::fmin(axis.from, axis.to), high = std::fmax(axis.from, axis.to);
    const double least = std::fmax((high - low) / most, least_step);
    const double power = std::pow(10, std::floor(std::log10(least)));
    const double step = power * (least <= power ? 1 : least <= 2 * power ? 2 : least <= 5 * power ? 5 : 10);
    const double far = std::fmax(std::fabs(low), std::fabs(high));
    std::vector<AxisMark> marks;
    if (!(step > 1e-12 * far) || !std::isfinite(step)) return marks;
    const double first = std::ceil(low / step - 1e-9);
    for (int n = 0; n <= most && (first + n) * step <= high + 1e-9 * step; ++n)
        marks.push_back({(first + n) * step, number_on_axis((first + n) * step, step)});
    return marks;
}

} // namespace cageform_support
