#pragma once

// The small grammars inside SVG attributes: path data, transforms, lengths and lists of numbers.
// Everything is read into plain values; nothing here knows XML. After SVG 2: "Paths" (grammar, and the
// implementation notes on elliptical arcs) and "Coordinate systems, transformations and units".

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace cageform_examples {

struct Point2 {
    double x = 0;
    double y = 0;
    friend bool operator==(const Point2&, const Point2&) = default;
};

/// What was wrong, and where: both counted from one, in bytes; zero means not known.
struct SvgError {
    std::string message;
    std::size_t line = 0;
    std::size_t column = 0;
};

/// "message", "message (line 3)" or "message (line 3, column 7)".
inline std::string to_string(const SvgError& error) {
    if (error.line == 0) return error.message;
    std::string where = " (line " + std::to_string(error.line);
    if (error.column != 0) where += ", column " + std::to_string(error.column);
    return error.message + where + ")";
}

/// An error at a position in a text.
inline SvgError error_in_text(std::string why, std::string_view text, std::size_t position) {
    const std::string_view before = text.substr(0, position);
    const std::size_t line_start = before.rfind('\n') + 1; // npos + 1 is zero
    const auto line = static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n')) + 1;
    return {std::move(why), line, before.size() - line_start + 1};
}

/// A value or the reason why there is none; `*` and `->` only where it tests true.
template <class T>
class [[nodiscard]] SvgResult {
public:
    SvgResult(T value)
        : content_(std::move(value)) {}
    SvgResult(SvgError error)
        : content_(std::move(error)) {}

    explicit operator bool() const noexcept { return content_.index() == 0; }
    T& operator*() { return std::get<0>(content_); }
    const T& operator*() const { return std::get<0>(content_); }
    T* operator->() { return &std::get<0>(content_); }
    const T* operator->() const { return &std::get<0>(content_); }
    const SvgError& error() const { return std::get<1>(content_); }

private:
    std::variant<T, SvgError> content_;
};

/// One cubic from the end of the one before; a line has its control points at its thirds.
struct Segment {
    Point2 p1;
    Point2 p2;
    Point2 p3;
    bool is_line = false;
};

/// A closed one ends exactly where it starts: its closing line is among the segments.
struct Subpath {
    Point2 start;
    std::vector<Segment> segments;
    bool closed = false;
};

using Path = std::vector<Subpath>;

/// (x, y) -> (a x + c y + e, b x + d y + f), in the order of SVG's matrix().
struct Affine2 {
    double a = 1;
    double b = 0;
    double c = 0;
    double d = 1;
    double e = 0;
    double f = 0;
    friend bool operator==(const Affine2&, const Affine2&) = default;
};

inline Point2 apply(const Affine2& m, const Point2& p) {
    return {m.a * p.x + m.c * p.y + m.e, m.b * p.x + m.d * p.y + m.f};
}

inline bool is_finite(const Point2& p) {
    return std::isfinite(p.x) && std::isfinite(p.y);
}

/// The map that applies `inner` first; a list of transforms reads from the outermost to the innermost.
inline Affine2 compose(const Affine2& outer, const Affine2& inner) {
    const Point2 x{outer.a * inner.a + outer.c * inner.b, outer.b * inner.a + outer.d * inner.b};
    const Point2 y{outer.a * inner.c + outer.c * inner.d, outer.b * inner.c + outer.d * inner.d};
    const Point2 origin = apply(outer, {inner.e, inner.f});
    return {x.x, x.y, y.x, y.y, origin.x, origin.y};
}

/// Nothing for a map that flattens the plane, up to rounding, or is out of range.
inline std::optional<Affine2> inverse(const Affine2& m) {
    const double determinant = m.a * m.d - m.b * m.c;
    const double terms = std::abs(m.a * m.d) + std::abs(m.b * m.c);
    if (!(std::abs(determinant) > 1e-14 * terms)) return std::nullopt; // all digits cancelled
    Affine2 r{m.d / determinant, -m.b / determinant, -m.c / determinant, m.a / determinant, 0, 0};
    const Point2 origin = apply(r, {-m.e, -m.f});
    r.e = origin.x;
    r.f = origin.y;
    const bool in_range = std::isfinite(r.a + r.b + r.c + r.d) && is_finite(origin);
    return in_range ? std::optional<Affine2>(r) : std::nullopt;
}

inline Path transformed(Path path, const Affine2& map) {
    for (Subpath& subpath : path) {
        subpath.start = apply(map, subpath.start);
        for (Segment& s : subpath.segments) {
            s = {apply(map, s.p1), apply(map, s.p2), apply(map, s.p3), s.is_line};
        }
    }
    return path;
}

/// Builds absolute subpaths; the commands have SVG's meaning. A drawing command after close() starts a
/// new subpath where the closed one started. Overflow is remembered, see `finite()`.
class PathBuilder {
public:
    Point2 current() const { return current_; }
    bool finite() const { return finite_; }
    Path take() { return std::move(path_); }

    void move_to(const Point2& p) {
        path_.push_back({p, {}, false});
        open_ = true;
        current_ = p;
        finite_ = finite_ && is_finite(p);
    }

    void line_to(const Point2& p) { add(third(current_, p), third(p, current_), p, true); }

    void quadratic_to(const Point2& control, const Point2& p) {
        add(third(control, current_), third(control, p), p, false);
    }

    void cubic_to(const Point2& p1, const Point2& p2, const Point2& p) { add(p1, p2, p, false); }

    /// At most a quarter turn to a cubic, so that the radius is met to 2.8e-4 of itself. The ellipse is
    /// mapped to the unit circle, where `h` is half the chord: its length is the sine of half the
    /// turn, and beyond one the radii are too small and grow by it.
    void arc_to(double rx, double ry, double degrees, bool large, bool sweep, const Point2& end) {
        if (end == current_) return;
        rx = std::abs(rx);
        ry = std::abs(ry);
        if (rx == 0 || ry == 0) return line_to(end);

        const double tilt = std::fmod(degrees, 360.0) * std::numbers::pi / 180;
        const double cosine = std::cos(tilt);
        const double sine = std::sin(tilt);
        const Point2 half{end.x / 2 - current_.x / 2, end.y / 2 - current_.y / 2};
        Point2 h{(cosine * half.x + sine * half.y) / rx, (cosine * half.y - sine * half.x) / ry};
        double length = std::hypot(h.x, h.y);
        if (length == 0 || !std::isfinite(length)) return line_to(end); // beyond what doubles can tell
        if (length > 1) {
            rx *= length;
            ry *= length;
            h = {h.x / length, h.y / length};
            length = 1;
        }
        const double offset = std::sqrt(std::max(0.0, 1 - length * length)) / length;
        const double side = large == sweep ? -offset : offset;
        const Point2 centre{-side * h.y, side * h.x}; // from the middle of the chord
        const double small_turn = 2 * std::asin(length);
        const double turn = large ? 2 * std::numbers::pi - small_turn : small_turn;
        const double signed_turn = sweep ? turn : -turn;
        const double first = std::atan2(-h.y - centre.y, -h.x - centre.x);
        const int count = std::max(1, static_cast<int>(std::ceil(turn / (std::numbers::pi / 2) - 1e-6)));
        const double step = signed_turn / count;
        const double reach = 4.0 / 3.0 * std::tan(step / 4);

        const auto to_plane = [&](double u, double v) {
            return Point2{cosine * rx * u - sine * ry * v, sine * rx * u + cosine * ry * v};
        };
        const Point2 middle{current_.x + half.x, current_.y + half.y};
        for (int i = 0; i < count; ++i) {
            const double from = first + i * step;
            const double to = first + (i + 1) * step;
            const Point2 leave = to_plane(-reach * std::sin(from), reach * std::cos(from));
            const Point2 arrive = to_plane(-reach * std::sin(to), reach * std::cos(to));
            const Point2 on_ellipse = to_plane(centre.x + std::cos(to), centre.y + std::sin(to));
            const Point2 next =
                i + 1 == count ? end : Point2{middle.x + on_ellipse.x, middle.y + on_ellipse.y};
            add({current_.x + leave.x, current_.y + leave.y}, {next.x - arrive.x, next.y - arrive.y}, next,
                false);
        }
    }

    /// A gap of rounding size, as sums of relative steps leave it, is closed without a line.
    void close() {
        if (!open_) return;
        Subpath& subpath = path_.back();
        std::vector<Segment>& segments = subpath.segments;
        const Point2 start = subpath.start;
        const Point2 before = segments.size() > 1 ? segments[segments.size() - 2].p3 : start;
        const double gap = std::hypot(current_.x - start.x, current_.y - start.y);
        const double size = std::hypot(start.x, start.y) + std::hypot(current_.x, current_.y);
        const double last = std::hypot(current_.x - before.x, current_.y - before.y);
        if (gap > 1e-13 * size || gap > 1e-3 * last) {
            line_to(start);
        } else if (!segments.empty()) {
            segments.back().p3 = start;
        }
        subpath.closed = true;
        open_ = false;
        current_ = start;
    }

private:
    static Point2 third(const Point2& near, const Point2& far) { // a third of the way to `far`
        return {near.x * (2.0 / 3.0) + far.x / 3, near.y * (2.0 / 3.0) + far.y / 3};
    }

    void add(const Point2& p1, const Point2& p2, const Point2& p3, bool is_line) {
        if (!open_) move_to(current_);
        path_.back().segments.push_back({p1, p2, p3, is_line});
        current_ = p3;
        finite_ = finite_ && is_finite(p1) && is_finite(p2) && is_finite(p3);
    }

    Path path_;
    Point2 current_;
    bool open_ = false;
    bool finite_ = true;
};

namespace detail {

inline bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f';
}
inline bool is_digit(char c) {
    return c >= '0' && c <= '9';
}
inline bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/// Reads tokens from left to right and remembers the first failure with its place.
class Scanner {
public:
    explicit Scanner(std::string_view text)
        : text_(text) {}

    bool at_end() const { return at_ >= text_.size(); }
    char peek(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
    void advance() { ++at_; }
    std::size_t position() const { return at_; }
    std::string_view rest() const { return text_.substr(at_); }

    void skip_space() {
        while (!at_end() && is_space(text_[at_])) ++at_;
    }

    void skip_separator() { // white space with at most one comma in it
        skip_space();
        if (peek() == ',') advance();
        skip_space();
    }

    bool starts_number() const {
        const std::size_t sign = peek() == '+' || peek() == '-' ? 1 : 0;
        return is_digit(peek(sign)) || (peek(sign) == '.' && is_digit(peek(sign + 1)));
    }

    bool number(double& value) {
        if (!starts_number()) return fail("expected a number");
        const bool negative = peek() == '-';
        const std::size_t begin = at_ + (negative || peek() == '+' ? 1 : 0);
        const char* const first = text_.data() + begin;
        const auto [end, code] = std::from_chars(first, text_.data() + text_.size(), value);
        if (code == std::errc::result_out_of_range) {
            // from_chars does not tell too large from too small; the latter is as good as zero
            if (!below_one({first, static_cast<std::size_t>(end - first)})) {
                return fail("number out of range");
            }
            value = 0;
        } else if (code != std::errc()) {
            return fail("expected a number");
        }
        at_ = static_cast<std::size_t>(end - text_.data());
        if (negative) value = -value;
        return true;
    }

    bool flag(bool& value) {
        if (peek() != '0' && peek() != '1') return fail("expected a flag, 0 or 1");
        value = peek() == '1';
        advance();
        return true;
    }

    std::string_view word() {
        const std::size_t begin = at_;
        while (is_letter(peek())) advance();
        return text_.substr(begin, at_ - begin);
    }

    bool fail(std::string why) { return fail_at(at_, std::move(why)); }

    bool fail_at(std::size_t position, std::string why) {
        if (failed_) return false;
        failed_ = true;
        error_ = error_in_text(std::move(why), text_, position);
        return false;
    }

    const SvgError& error() const { return error_; }

private:
    static bool below_one(std::string_view digits) {
        const std::size_t exponent = digits.find_first_of("eE");
        if (exponent != std::string_view::npos) return digits[exponent + 1] == '-';
        return digits.substr(0, digits.find('.')).find_first_not_of('0') == std::string_view::npos;
    }

    std::string_view text_;
    std::size_t at_ = 0;
    SvgError error_;
    bool failed_ = false;
};

/// The `d` attribute, one command at a time.
class PathReader {
public:
    explicit PathReader(std::string_view text)
        : scan_(text) {}

    SvgResult<Path> read() {
        for (scan_.skip_space(); !scan_.at_end(); scan_.skip_space()) {
            if (!read_command()) return scan_.error();
        }
        return builder_.take();
    }

private:
    bool read_command() {
        const char letter = scan_.peek();
        if (std::string_view("MmLlHhVvCcSsQqTtAaZz").find(letter) == std::string_view::npos) {
            return scan_.fail("expected a command letter");
        }
        if (!started_ && letter != 'M' && letter != 'm') return scan_.fail("a path begins with M");
        const std::size_t begin = scan_.position();
        scan_.advance();
        relative_ = letter >= 'a';
        command_ = relative_ ? static_cast<char>(letter - 'a' + 'A') : letter;
        if (command_ == 'Z') {
            builder_.close();
            forget_controls();
            return true;
        }
        scan_.skip_space();
        for (std::size_t at = begin;;) {
            if (!read_arguments()) return false;
            if (!builder_.finite()) return scan_.fail_at(at, "coordinates out of range");
            if (command_ == 'M') command_ = 'L'; // further pairs are lines
            scan_.skip_space();
            if (scan_.peek() != ',' && !scan_.starts_number()) return true;
            scan_.skip_separator();
            at = scan_.position();
        }
    }

    bool read_arguments() {
        const Point2 from = builder_.current();
        Point2 p;
        Point2 q;
        Point2 end;
        switch (command_) {
        case 'M':
            if (!point(end)) return false;
            started_ = true;
            builder_.move_to(end);
            break;
        case 'L':
            if (!point(end)) return false;
            builder_.line_to(end);
            break;
        case 'H':
            if (!scan_.number(p.x)) return false;
            builder_.line_to({relative_ ? from.x + p.x : p.x, from.y});
            break;
        case 'V':
            if (!scan_.number(p.y)) return false;
            builder_.line_to({from.x, relative_ ? from.y + p.y : p.y});
            break;
        case 'C':
            if (!point(p) || !next_point(q) || !next_point(end)) return false;
            return cubic(p, q, end);
        case 'S':
            if (!point(q) || !next_point(end)) return false;
            return cubic(reflected(cubic_control_), q, end);
        case 'Q':
            if (!point(p) || !next_point(end)) return false;
            return quadratic(p, end);
        case 'T':
            if (!point(end)) return false;
            return quadratic(reflected(quadratic_control_), end);
        default: return arc();
        }
        forget_controls();
        return true;
    }

    bool cubic(const Point2& p, const Point2& q, const Point2& end) {
        builder_.cubic_to(p, q, end);
        forget_controls();
        cubic_control_ = q;
        return true;
    }

    bool quadratic(const Point2& control, const Point2& end) {
        builder_.quadratic_to(control, end);
        forget_controls();
        quadratic_control_ = control;
        return true;
    }

    bool arc() {
        double rx = 0;
        double ry = 0;
        double degrees = 0;
        bool large = false;
        bool sweep = false;
        Point2 end;
        if (!scan_.number(rx) || !next_number(ry) || !next_number(degrees)) return false;
        scan_.skip_separator();
        if (!scan_.flag(large)) return false;
        scan_.skip_separator();
        if (!scan_.flag(sweep) || !next_point(end)) return false;
        builder_.arc_to(rx, ry, degrees, large, sweep, end);
        forget_controls();
        return true;
    }

    bool next_number(double& value) {
        scan_.skip_separator();
        return scan_.number(value);
    }

    bool point(Point2& p) {
        if (!scan_.number(p.x) || !next_number(p.y)) return false;
        const Point2 from = builder_.current();
        if (relative_) p = {from.x + p.x, from.y + p.y};
        return true;
    }

    bool next_point(Point2& p) {
        scan_.skip_separator();
        return point(p);
    }

    Point2 reflected(const std::optional<Point2>& control) const {
        const Point2 at = builder_.current();
        return control ? Point2{2 * at.x - control->x, 2 * at.y - control->y} : at;
    }

    void forget_controls() {
        cubic_control_.reset();
        quadratic_control_.reset();
    }

    Scanner scan_;
    PathBuilder builder_;
    std::optional<Point2> cubic_control_;     // of the command just before, if that was C or S
    std::optional<Point2> quadratic_control_; // likewise for Q and T
    char command_ = 'M';
    bool relative_ = false;
    bool started_ = false;
};

} // namespace detail

/// Path data as absolute subpaths of cubics; empty text is an empty path.
///
///   fails   at the first place that is not SVG's grammar, with a number beyond double's range, or where
///           a sum of relative steps leaves it; nothing of a malformed path is returned
inline SvgResult<Path> parse_path_data(std::string_view text) {
    return detail::PathReader(text).read();
}

/// Numbers parted by white space with at most one comma, as in `points` and `viewBox`.
inline SvgResult<std::vector<double>> parse_numbers(std::string_view text) {
    detail::Scanner scan(text);
    std::vector<double> numbers;
    for (scan.skip_space(); !scan.at_end(); scan.skip_space()) {
        if (!numbers.empty()) scan.skip_separator();
        double value = 0;
        if (!scan.number(value)) return scan.error();
        numbers.push_back(value);
    }
    return numbers;
}

/// A `transform` attribute as one map; the functions are those of SVG 1.1, angles in degrees.
inline SvgResult<Affine2> parse_transform(std::string_view text) {
    detail::Scanner scan(text);
    Affine2 result;
    bool comma = false;
    for (scan.skip_space(); !scan.at_end() || comma; scan.skip_space()) {
        const std::size_t begin = scan.position();
        const std::string_view name = scan.word();
        scan.skip_space();
        if (name.empty() || scan.peek() != '(') {
            scan.fail_at(begin, "expected a transform such as translate(1 2)");
            return scan.error();
        }
        scan.advance();
        std::vector<double> v;
        for (scan.skip_space(); scan.peek() != ')'; scan.skip_space()) {
            if (!v.empty()) scan.skip_separator();
            double value = 0;
            if (!scan.number(value)) return scan.error();
            v.push_back(value);
        }
        scan.advance();

        const std::size_t n = v.size();
        const double angle = n > 0 ? std::fmod(v[0], 360.0) * std::numbers::pi / 180 : 0;
        Affine2 step;
        if (name == "matrix" && n == 6) {
            step = {v[0], v[1], v[2], v[3], v[4], v[5]};
        } else if (name == "translate" && (n == 1 || n == 2)) {
            step = {1, 0, 0, 1, v[0], n == 2 ? v[1] : 0};
        } else if (name == "scale" && (n == 1 || n == 2)) {
            step = {v[0], 0, 0, n == 2 ? v[1] : v[0], 0, 0};
        } else if (name == "rotate" && (n == 1 || n == 3)) {
            step = {std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle), 0, 0};
            if (n == 3) step = compose(compose({1, 0, 0, 1, v[1], v[2]}, step), {1, 0, 0, 1, -v[1], -v[2]});
        } else if (name == "skewX" && n == 1) {
            step.c = std::tan(angle);
        } else if (name == "skewY" && n == 1) {
            step.b = std::tan(angle);
        } else {
            scan.fail_at(begin,
                         "no transform " + std::string(name) + " with " + std::to_string(n) + " numbers");
            return scan.error();
        }
        result = compose(result, step);
        scan.skip_space();
        comma = scan.peek() == ',';
        if (comma) scan.advance();
    }
    const bool in_range = std::isfinite(result.a + result.b + result.c + result.d + result.e + result.f);
    if (!in_range) return SvgError{"transform out of range", 1, 1};
    return result;
}

/// A length in user units: 96 to the inch; a percentage is of `whole`; an em is taken as 16, an ex as 8.
inline SvgResult<double> parse_length(std::string_view text, double whole) {
    struct Unit {
        std::string_view name;
        double size;
    };
    const std::array<Unit, 10> units = {{{"", 1},
                                         {"px", 1},
                                         {"pt", 96.0 / 72},
                                         {"pc", 16},
                                         {"mm", 96 / 25.4},
                                         {"cm", 96 / 2.54},
                                         {"in", 96},
                                         {"em", 16},
                                         {"ex", 8},
                                         {"%", whole / 100}}};
    detail::Scanner scan(text);
    double value = 0;
    scan.skip_space();
    if (!scan.number(value)) return scan.error();
    std::string_view unit = scan.rest();
    while (!unit.empty() && detail::is_space(unit.back())) unit.remove_suffix(1);
    for (const Unit& known : units) {
        if (unit != known.name) continue;
        if (std::isfinite(value * known.size)) return value * known.size;
        scan.fail_at(0, "length out of range");
        return scan.error();
    }
    scan.fail("unknown unit \"" + std::string(unit) + "\"");
    return scan.error();
}

/// The shortest text that reads back as `value` rounded to `decimals` digits after the point (0 to 17).
inline std::string format_number(double value, int decimals) {
    std::array<char, 400> buffer{}; // 309 digits before the point, 17 after, sign and point
    char* const begin = buffer.data();
    char* const last = begin + buffer.size();
    if (!(std::abs(value) < 1e15)) return {begin, std::to_chars(begin, last, value).ptr};
    const auto rounded =
        std::to_chars(begin, last, value, std::chars_format::fixed, std::clamp(decimals, 0, 17));
    std::string text(begin, rounded.ptr);
    if (text.find('.') != std::string::npos) {
        text.erase(text.find_last_not_of('0') + 1);
        if (text.back() == '.') text.pop_back();
    }
    if (text == "-0") return "0";
    const auto exact = std::to_chars(begin, last, value);
    const auto exact_size = static_cast<std::size_t>(exact.ptr - begin);
    return exact_size < text.size() ? std::string(begin, exact_size) : text;
}

/// Path data with M, L, C and Z, absolute; a last line back to the start is left to Z.
inline std::string write_path_data(const Path& path, int decimals) {
    std::string text;
    const auto put = [&](const Point2& p) {
        text += format_number(p.x, decimals) + ' ' + format_number(p.y, decimals) + ' ';
    };
    for (const Subpath& subpath : path) {
        text += 'M';
        put(subpath.start);
        Point2 from = subpath.start;
        for (std::size_t i = 0; i < subpath.segments.size(); ++i) {
            const Segment& s = subpath.segments[i];
            const bool closing = subpath.closed && s.is_line && i + 1 == subpath.segments.size();
            if (closing && !(from == subpath.start)) break;
            from = s.p3;
            text += s.is_line ? 'L' : 'C';
            if (!s.is_line) {
                put(s.p1);
                put(s.p2);
            }
            put(s.p3);
        }
        if (subpath.closed) text += "Z ";
    }
    if (!text.empty()) text.pop_back();
    return text;
}

} // namespace cageform_examples
