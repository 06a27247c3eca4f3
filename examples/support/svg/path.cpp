#include "svg/path.hpp"

#include "io/csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace cageform_support {

Segment part_of(const Point2& from, const Segment& s, double first, double last) {
    const auto blossom = [&](double a, double b, double c) { // de Casteljau, one parameter per step
        const auto mix = [](const Point2& p, const Point2& q, double t) {
            return Point2{(1 - t) * p.x + t * q.x, (1 - t) * p.y + t * q.y};
        };
        const Point2 p = mix(from, s.p1, a), q = mix(s.p1, s.p2, a), r = mix(s.p2, s.p3, a);
        return mix(mix(p, q, b), mix(q, r, b), c);
    };
    return {blossom(first, first, last), blossom(first, last, last), blossom(last, last, last), s.degree};
}

std::size_t pieces_of(const Point2& from, const Segment& s, double tolerance) {
    if (s.is_line()) return 1;
    // The distance of a cubic from its chord is at most 3/4 of its larger second difference.
    const double bend = std::max(std::hypot(from.x - 2 * s.p1.x + s.p2.x, from.y - 2 * s.p1.y + s.p2.y),
                                 std::hypot(s.p1.x - 2 * s.p2.x + s.p3.x, s.p1.y - 2 * s.p2.y + s.p3.y));
    return std::size_t(std::clamp(std::ceil(std::sqrt(0.75 * bend / tolerance)), 1.0, 1000.0));
}

std::optional<Affine2> inverse(const Affine2& m) {
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

Path transformed(Path path, const Affine2& map) {
    for (Subpath& subpath : path) {
        subpath.start = apply(map, subpath.start);
        for (Segment& s : subpath.segments) {
            for (Point2* const p : {&s.p1, &s.p2, &s.p3}) *p = apply(map, *p);
        }
    }
    return path;
}

namespace detail {

std::string lowered(std::string_view text) {
    std::string result(text);
    for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return result;
}

/// Tokenizer that keeps the first error and its position.
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
            // from_chars does not distinguish overflow from underflow; the latter is zero
            if (!below_one({first, static_cast<std::size_t>(end - first)})) {
                return fail("number out of range");
            }
            value = 0;
        } else if (code != std::errc()) {
            return fail("expected a number");
        }
        const std::size_t point = static_cast<std::size_t>(std::find(first, end, '.') - text_.data());
        at_ = static_cast<std::size_t>(end - text_.data());
        if (point < at_ && !is_digit(text_[std::min(point + 1, text_.size() - 1)])) {
            return fail_at(point, "expected a digit after the point"); // as browsers
        }
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

    const FileError& error() const { return error_; }

private:
    static bool below_one(std::string_view digits) {
        const std::size_t exponent = digits.find_first_of("eE");
        if (exponent != std::string_view::npos) return digits[exponent + 1] == '-';
        return digits.substr(0, digits.find('.')).find_first_not_of('0') == std::string_view::npos;
    }

    std::string_view text_;
    std::size_t at_ = 0;
    FileError error_;
    bool failed_ = false;
};

/// Parser of the `d` attribute.
class PathReader {
public:
    PathReader(std::string_view text, double most_turn)
        : scan_(text)
        , builder_(most_turn) {}

    ReadPath read() {
        ReadPath result;
        for (scan_.skip_space(); !scan_.at_end() && !result.fault; scan_.skip_space()) {
            if (!read_command()) result.fault = scan_.error();
        }
        if (builder_.finite()) result.path = builder_.take();
        return result;
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
        Arc arc;
        Point2 end;
        if (!scan_.number(arc.rx) || !next_number(arc.ry) || !next_number(arc.degrees)) return false;
        scan_.skip_separator();
        if (!scan_.flag(arc.large)) return false;
        scan_.skip_separator();
        if (!scan_.flag(arc.sweep) || !next_point(end)) return false;
        builder_.arc_to(arc, end);
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
    std::optional<Point2> cubic_control_;     // of the last command, if C or S
    std::optional<Point2> quadratic_control_; // of the last command, if Q or T
    char command_ = 'M';
    bool relative_ = false;
    bool started_ = false;
};

} // namespace detail

ReadPath read_path_data(std::string_view text, double most_turn) {
    return detail::PathReader(text, most_turn).read();
}

Expected<Path> parse_path_data(std::string_view text, double most_turn) {
    ReadPath read = read_path_data(text, most_turn);
    if (read.fault) return std::move(*read.fault);
    return std::move(read.path);
}

std::optional<Quantity> read_quantity(std::string_view text) {
    detail::Scanner scan(text);
    double value = 0;
    return scan.number(value) ? std::optional(Quantity{value, scan.rest()}) : std::nullopt;
}

Expected<std::vector<double>> parse_numbers(std::string_view text) {
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

Expected<Affine2> parse_transform(std::string_view text) {
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
                         "no transform " + std::string(name) + " with " + detail::counted(n, "number"));
            return scan.error();
        }
        result = compose(result, step);
        scan.skip_space();
        comma = scan.peek() == ',';
        if (comma) scan.advance();
    }
    const bool in_range = std::isfinite(result.a + result.b + result.c + result.d + result.e + result.f);
    if (!in_range) return FileError{"transform out of range", 1, 1};
    return result;
}

namespace detail {

/// Parser of a length, or calc(), min(), max() or clamp() of lengths and numbers.
class LengthReader {
public:
    LengthReader(std::string_view text, double whole, double em, double root_em)
        : scan_(text)
        , units_{{{"", 1},
                  {"px", 1},
                  {"pt", 96.0 / 72},
                  {"pc", 16},
                  {"mm", 96 / 25.4},
                  {"cm", 96 / 2.54},
                  {"in", 96},
                  {"q", 96 / 101.6},
                  {"em", em},
                  {"ex", em / 2},
                  {"ch", em / 2},
                  {"rem", root_em},
                  {"rex", root_em / 2},
                  {"rch", root_em / 2},
                  {"%", whole / 100}}} {}

    Expected<double> read() {
        double value = 0;
        if (!factor(value, 0)) return scan_.error();
        const std::size_t end = scan_.position();
        const std::string rest(scan_.rest());
        scan_.skip_space();
        if (!scan_.at_end()) scan_.fail_at(end, "unknown unit \"" + rest + '"');
        if (scan_.at_end() && std::isfinite(value)) return value;
        scan_.fail_at(0, "length out of range");
        return scan_.error();
    }

private:
    struct Unit {
        std::string_view name;
        double size;
    };

    bool factor(double& value, int depth) {
        constexpr int max_depth = 20; // of brackets; reading them is recursive
        scan_.skip_space();
        const std::size_t begin = scan_.position();
        const std::string name = lowered(scan_.word());
        const bool is_limit = name == "min" || name == "max" || name == "clamp";
        const bool opens = name == "calc" || is_limit || (name.empty() && depth > 0);
        if (scan_.peek() == '(' && opens && depth < max_depth) {
            std::vector<double> parts;
            do {
                scan_.advance();
                if (!sum(parts.emplace_back(), depth + 1)) return false;
            } while (is_limit && scan_.peek() == ',');
            if (scan_.peek() != ')') return scan_.fail("expected )");
            scan_.advance();
            if (name == "clamp" && parts.size() != 3) return scan_.fail_at(begin, "clamp() has three parts");
            value = name == "min"   ? *std::min_element(parts.begin(), parts.end())
                    : name == "max" ? *std::max_element(parts.begin(), parts.end())
                    : is_limit      ? std::max(parts[0], std::min(parts[1], parts[2]))
                                    : parts[0];
            return true;
        }
        if (scan_.position() != begin) return scan_.fail_at(begin, "expected a number");
        if (!scan_.number(value)) return false;
        const std::size_t end = scan_.position();
        std::string unit = lowered(scan_.word());
        if (scan_.peek() == '%' && unit.empty()) {
            unit = '%';
            scan_.advance();
        }
        for (const Unit& known : units_) {
            if (unit != known.name) continue;
            value *= known.size;
            return true;
        }
        return scan_.fail_at(end, "unknown unit \"" + unit + '"');
    }

    /// Parses parts separated by one of two operators; `combine` gets whether it is the second.
    template <class Part, class Combine>
    bool chain(double& value, std::string_view operations, const Part& part, const Combine& combine) {
        if (!part(value)) return false;
        for (scan_.skip_space(); operations.find(scan_.peek()) != std::string_view::npos && !scan_.at_end();
             scan_.skip_space()) {
            const bool inverts = scan_.peek() == operations.back();
            scan_.advance();
            double next = 0;
            if (!part(next)) return false;
            value = combine(value, next, inverts);
        }
        return true;
    }

    bool sum(double& value, int depth) {
        const auto product = [&](double& part) {
            return chain(
                part, "*/", [&](double& one) { return factor(one, depth); },
                [](double a, double b, bool divides) { return divides ? a / b : a * b; });
        };
        return chain(value, "+-", product,
                     [](double a, double b, bool minus) { return minus ? a - b : a + b; });
    }

    Scanner scan_;
    std::array<Unit, 15> units_;
};

} // namespace detail

Expected<double> parse_length(std::string_view text, double whole, double em, double root_em) {
    return detail::LengthReader(text, whole, em, root_em).read();
}

std::string format_number(double value, int decimals) {
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

std::string write_path_data(const Path& path, int decimals) {
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
            const bool closing = subpath.closed && s.is_line() && i + 1 == subpath.segments.size();
            if (closing && !(from == subpath.start)) break;
            from = s.p3;
            text += s.is_line() ? 'L' : 'C';
            if (!s.is_line()) {
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

std::string write_short_path_data(const Path& path, int decimals) {
    const double unit = std::pow(10.0, decimals);
    std::string text;
    Point2 at; // in units of the last digit, rounded, so that errors of steps do not accumulate
    char last = 0;
    const auto put = [&](char command, std::initializer_list<Point2> points) {
        const bool repeats = command == last && (command == 'l' || command == 'c');
        bool parted = !repeats && !(command == 'l' && last == 'm'); // the command separates numbers
        if (parted) text += command;
        bool has_point = false; // the number before
        Point2 end = at;
        for (const Point2& p : points) {
            end = {std::round(p.x * unit), std::round(p.y * unit)};
            for (const double step : {end.x - at.x, end.y - at.y}) {
                std::string number = format_number(step / unit, decimals);
                if (number.starts_with("0.")) number.erase(0, 1);
                if (number.starts_with("-0.")) number.erase(1, 1);
                if (!parted && number[0] != '-' && !(number[0] == '.' && has_point)) text += ' ';
                text += number;
                parted = false;
                has_point = number.find_first_of(".e") != std::string::npos;
            }
        }
        at = end;
        last = command;
    };
    for (const Subpath& subpath : path) {
        put(text.empty() ? 'M' : 'm', {subpath.start});
        const Point2 start = at;
        for (std::size_t i = 0; i < subpath.segments.size(); ++i) {
            const Segment& s = subpath.segments[i];
            if (s.is_line() && subpath.closed && i + 1 == subpath.segments.size()) break;
            if (s.is_line())
                put('l', {s.p3});
            else
                put('c', {s.p1, s.p2, s.p3});
        }
        if (!subpath.closed) continue;
        text += 'z';
        last = 'z';
        at = start;
    }
    return text;
}

} // namespace cageform_support
