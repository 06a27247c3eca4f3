// Reads the tokens of CSS easing functions.
#pragma once

#include <cageform/exchange/detail/easing.hpp>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string_view>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Reads tokens of CSS Syntax Module Level 3, sec. 4, from ASCII text.
class CssReader {
public:
    explicit CssReader(std::string_view text) noexcept
        : text_(text) {}

    std::size_t at() const noexcept { return at_; }
    bool ended() const noexcept { return at_ == text_.size(); }

    void skip_space() noexcept {
        while (!ended()) {
            const char c = text_[at_];
            if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f') {
                ++at_;
            } else if (text_.substr(at_, 2) == "/*") {
                const std::size_t close = text_.find("*/", at_ + 2);
                if (close == std::string_view::npos) return;
                at_ = close + 2;
            } else {
                return;
            }
        }
    }

    bool take(char c) noexcept {
        if (peek(at_) != c || ended()) return false;
        ++at_;
        return true;
    }

    /// Reads letters, digits, hyphens and underscores; returns an empty name if there are none.
    std::string_view name() noexcept {
        const std::size_t begin = at_;
        while (is_name(peek(at_))) ++at_;
        return text_.substr(begin, at_ - begin);
    }

    /// Reads a number-token (sec. 4.3.12). A point must be followed by digits; no unit or percent sign may
    /// follow the number. The value is infinity if the number is too large for a double, and zero if it is
    /// too small. Returns false on failure; `at` is then the position of the error.
    bool number(double& value) noexcept {
        const bool negative = peek(at_) == '-';
        if (negative || peek(at_) == '+') ++at_;
        const std::size_t begin = at_;
        std::size_t first = skip_digits(at_); // digits, then optionally a point and digits
        if (peek(first) == '.' && is_digit(peek(first + 1))) first = skip_digits(first + 1);
        if (first == at_) return false;
        at_ = first;
        const std::size_t sign = at_ + 1, digits = sign + (peek(sign) == '+' || peek(sign) == '-' ? 1 : 0);
        if ((peek(at_) == 'e' || peek(at_) == 'E') && is_digit(peek(digits))) at_ = skip_digits(digits);
        if (is_name(peek(at_)) || peek(at_) == '.' || peek(at_) == '%') return false;
        const std::string_view token = text_.substr(begin, at_ - begin);
        double magnitude = 0;
        if (std::from_chars(token.data(), token.data() + token.size(), magnitude).ec != std::errc())
            magnitude = is_large(token) ? detail::infinite() : 0;
        value = negative ? -magnitude : magnitude;
        return true;
    }

private:
    static bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }
    static bool is_name(char c) noexcept {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '-' || c == '_';
    }
    char peek(std::size_t at) const noexcept { return at < text_.size() ? text_[at] : '\0'; }
    std::size_t skip_digits(std::size_t at) const noexcept {
        while (is_digit(peek(at))) ++at;
        return at;
    }

    /// For a number that std::from_chars rejects as out of range: true if it is too large, false if it is too
    /// small. Decides by the power of ten of the first digit.
    static bool is_large(std::string_view token) noexcept {
        constexpr std::int64_t most = std::int64_t{1} << 56; // above the length of any text
        const std::size_t e = (std::min)(token.find_first_of("eE"), token.size());
        const std::size_t point = (std::min)(token.substr(0, e).find('.'), e);
        const std::size_t first = (std::min)(token.find_first_of("123456789"), e);
        const std::int64_t power = std::int64_t(point) - std::int64_t(first);
        std::int64_t exponent = 0;
        for (const char c : token.substr(e)) {
            if (is_digit(c)) exponent = (std::min)(10 * exponent + (c - '0'), most);
        }
        return power + (token.find('-', e) != std::string_view::npos ? -exponent : exponent) > 0;
    }

    std::string_view text_;
    std::size_t at_ = 0;
};

/// Compares ignoring case; `lower` must be in lower case.
inline bool equal_ignoring_case(std::string_view text, std::string_view lower) noexcept {
    return std::equal(text.begin(), text.end(), lower.begin(), lower.end(), [](char a, char b) {
        return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b;
    });
}

inline BezierCurve unit_curve(double x1, double y1, double x2, double y2) noexcept {
    return {{{{0, 0}, {x1, y1}, {x2, y2}, {1, 1}}}};
}

} // namespace cageform::inline CAGEFORM_ABI::detail
