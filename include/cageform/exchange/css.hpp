// Parses and writes CSS easing functions (W3C, CSS Easing Functions Level 1).
#pragma once

#include <cageform/exchange/detail/css_reader.hpp>
#include <cageform/exchange/detail/easing.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <span>
#include <string>
#include <string_view>

namespace cageform::inline CAGEFORM_ABI {

/// The result of `parse_css_easing`. The status is
///   input_malformed      if the text is not a supported easing function
///   handle_not_allowed   if x1 or x2 lies outside [0, 1]
///   value_not_finite     if y1 or y2 is too large for a double
struct CssReport {
    Status status = Status::ok;
    std::size_t error_at = 0; ///< byte offset of the error; the text's size if the text ends too early
};

/// Parses `cubic-bezier(x1, y1, x2, y2)`, or one of `linear`, `ease`, `ease-in`, `ease-out` and
/// `ease-in-out`.
///
///   text     one easing function, case-insensitive, with whitespace and comments where CSS allows them.
///            The decimal separator is a point in every locale. Not supported: steps(), linear(), calc(),
///            escapes in names, a missing closing bracket
///   returns  a curve from (0, 0) to (1, 1); `linear` equals cubic-bezier(0, 0, 1, 1)
///   cost     one pass, no allocation
/// CSS Easing Functions Level 1, sec. 2.1 and 2.2; CSS Syntax Module Level 3, sec. 4.3.
inline Result<BezierCurve, CssReport> parse_css_easing(std::string_view text) noexcept {
    struct Keyword {
        std::string_view name;
        double x1, y1, x2, y2;
    };
    static constexpr std::array<Keyword, 5> keywords{{{"linear", 0, 0, 1, 1},
                                                      {"ease", 0.25, 0.1, 0.25, 1},
                                                      {"ease-in", 0.42, 0, 1, 1},
                                                      {"ease-out", 0, 0, 0.58, 1},
                                                      {"ease-in-out", 0.42, 0, 0.58, 1}}};
    const auto failed = [](Status status, std::size_t at) {
        return Result<BezierCurve, CssReport>{{}, {status, at}};
    };
    detail::CssReader reader(text);
    reader.skip_space();
    const std::size_t begin = reader.at();
    const std::string_view name = reader.name();
    Result<BezierCurve, CssReport> result = failed(Status::input_malformed, begin);
    if (detail::equal_ignoring_case(name, "cubic-bezier")) {
        if (!reader.take('(')) return failed(Status::input_malformed, reader.at());
        std::array<double, 4> value{};
        std::array<std::size_t, 4> position{};
        for (std::size_t i = 0; i < 4; ++i) {
            reader.skip_space();
            position[i] = reader.at();
            if (!reader.number(value[i])) return failed(Status::input_malformed, reader.at());
            reader.skip_space();
            if (!reader.take(i < 3 ? ',' : ')')) return failed(Status::input_malformed, reader.at());
        }
        for (std::size_t i = 0; i < 4; ++i) {
            if (i % 2 == 0 && !(value[i] >= 0 && value[i] <= 1))
                return failed(Status::handle_not_allowed, position[i]);
            if (!is_finite(value[i])) return failed(Status::value_not_finite, position[i]);
        }
        result = {detail::unit_curve(value[0], value[1], value[2], value[3]), {}};
    } else {
        for (const Keyword& k : keywords) {
            if (detail::equal_ignoring_case(name, k.name))
                result = {detail::unit_curve(k.x1, k.y1, k.x2, k.y2), {}};
        }
        if (!result) return result;
    }
    reader.skip_space();
    if (!reader.ended()) return failed(Status::input_malformed, reader.at());
    return result;
}

/// Writes a curve, moved and scaled to keys at (0, 0) and (1, 1), as `cubic-bezier(x1, y1, x2, y2)`.
/// Numbers have the fewest digits that parse to the same double.
///
///   level   y1 and y2 of a constant curve become 0 and 1, because any easing between equal values is
///           constant
///   fails   as `check`; handle_not_allowed if a handle's time leaves the interval, which CSS forbids, or if
///           the keys have equal values and a handle has a different value; value_not_finite; out_of_memory
/// CSS Easing Functions Level 1, sec. 2.2.
inline Result<std::string> to_css(const BezierCurve& curve) noexcept {
    Result<std::string> result;
    const auto [unit, status] = detail::unit_handles(curve);
    if (status != Status::ok) return {{}, status};
    std::array<char, 160> buffer{}; // at most 4 numbers of 24 characters, and 21 others
    char* end = buffer.data();
    const auto append = [&](std::string_view s) { end = std::copy(s.begin(), s.end(), end); };
    std::string_view before = "cubic-bezier(";
    for (const double number : {unit.first[0], unit.first[1], unit.second[0], unit.second[1]}) {
        append(before);
        end = std::to_chars(end, buffer.data() + buffer.size(), number).ptr;
        before = ", ";
    }
    append(")");
    result.report = detail::guard_memory([&] { result.value.assign(buffer.data(), end); });
    return result;
}

/// A keyframe of a scalar, with the easing function to the next keyframe.
struct CssKey {
    double time = 0, value = 0;
    std::string_view easing = "linear"; ///< in the syntax of `parse_css_easing`
};

/// Imports all keyframes of a scalar animation, in the time units of the input.
///
///   fails  as `parse_css_easing`; interval_empty; value_not_finite
/// CSS Easing Functions Level 1, sec. 2; CSS Animations Level 1, sec. 3.
inline Result<std::vector<Key>, ExchangeReport> keys_from_css(std::span<const CssKey> keyframes) noexcept {
    return detail::import_keys(keyframes, [](const CssKey& from, const CssKey& to) {
        const auto easing = parse_css_easing(from.easing);
        if (!easing) return detail::refused(easing.status());
        const auto first = detail::position_of(from), second = detail::position_of(to);
        const auto& unit = easing.value.points;
        const auto scaled = [&](const Vec<double, 2>& p) {
            return Vec<double, 2>{std::lerp(first[0], second[0], p[0]), std::lerp(first[1], second[1], p[1])};
        };
        return detail::imported(KeyKind::bezier, {{first, scaled(unit[1]), scaled(unit[2]), second}});
    });
}

} // namespace cageform::inline CAGEFORM_ABI
