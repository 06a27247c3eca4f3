#pragma once

// Grammars of SVG attributes: path data, transforms, lengths and lists of numbers. Independent of XML. After
// SVG 2, "Paths" (grammar; implementation notes on elliptical arcs) and "Coordinate systems, transformations
// and units".

#include "io/expected.hpp"
#include "io/point2.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cageform_support {

/// A segment as a cubic; it starts at the end of the segment before. A line has its control points at its
/// thirds, a quadratic has those of the equal cubic.
struct Segment {
    Point2 p1;
    Point2 p2;
    Point2 p3;
    unsigned degree = 3;  // original: 1 to 3
    bool goes_on = false; // continues the arc of the segment before

    bool is_line() const { return degree == 1; }
};

/// The control point of a quadratic, from the equal cubic.
inline Point2 quadratic_control(const Point2& from, const Point2& p1) {
    return {1.5 * p1.x - from.x / 2, 1.5 * p1.y - from.y / 2};
}

/// The segments of a closed subpath include the closing line and end exactly at `start`.
struct Subpath {
    Point2 start;
    std::vector<Segment> segments;
    bool closed = false;
    bool has_closing_line = false; // Z has added the last segment
};

using Path = std::vector<Subpath>;

/// The point of a curve at parameter `t`, 0 to 1; it starts at `from`.
inline Point2 place_on(const Point2& from, const Segment& s, double t) {
    const double u = 1 - t, a = u * u * u, b = 3 * u * u * t, c = 3 * u * t * t, d = t * t * t;
    return {a * from.x + b * s.p1.x + c * s.p2.x + d * s.p3.x,
            a * from.y + b * s.p1.y + c * s.p2.y + d * s.p3.y};
}

/// The part of a curve from one parameter to another.
Segment part_of(const Point2& from, const Segment& s, double first, double last);

/// Number of pieces, equal in t, such that none is farther than `tolerance` from its chord; at most 1000.
std::size_t pieces_of(const Point2& from, const Segment& s, double tolerance);

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

/// The inverse; nothing if the map is singular up to rounding, or out of range.
std::optional<Affine2> inverse(const Affine2& m);

Path transformed(Path path, const Affine2& map);

/// Largest angle of an arc per cubic, in radians. Errors: 2.8e-4 of the radius in figures, 4e-6 in cages.
constexpr double arc_of_figure = std::numbers::pi / 2, arc_of_cage = std::numbers::pi / 4;

/// Elliptical arc of an SVG path.
struct Arc {
    double rx = 0, ry = 0;
    double degrees = 0; ///< rotation of the x axis
    bool large = false, sweep = true;
};

/// Builds absolute subpaths from SVG commands. A drawing command after close() starts a new subpath at the
/// start of the closed one. Overflow is recorded, see finite().
class PathBuilder {
public:
    explicit PathBuilder(double most_turn = arc_of_figure)
        : most_turn_(most_turn) {}

    Point2 current() const { return current_; }
    bool finite() const { return finite_; }
    Path take() { return std::move(path_); }

    void move_to(const Point2& p) {
        path_.push_back({p, {}, false});
        open_ = true;
        current_ = p;
        finite_ = finite_ && is_finite(p);
    }

    void line_to(const Point2& p) { add(third(current_, p), third(p, current_), p, 1); }

    void quadratic_to(const Point2& control, const Point2& p) {
        add(third(control, current_), third(control, p), p, 2);
    }

    void cubic_to(const Point2& p1, const Point2& p2, const Point2& p) { add(p1, p2, p, 3); }

    /// Maps the ellipse to the unit circle. There `h` is half the chord, and its length the sine of half the
    /// angle. If the length exceeds one, the radii are too small and are scaled by the length.
    void arc_to(const Arc& arc, const Point2& end) {
        if (end == current_) return;
        const auto [given_rx, given_ry, degrees, large, sweep] = arc;
        double rx = std::abs(given_rx), ry = std::abs(given_ry);
        if (rx == 0 || ry == 0) return line_to(end);

        const double tilt = std::fmod(degrees, 360.0) * std::numbers::pi / 180;
        const double cosine = std::cos(tilt);
        const double sine = std::sin(tilt);
        const Point2 half{end.x / 2 - current_.x / 2, end.y / 2 - current_.y / 2};
        Point2 h{(cosine * half.x + sine * half.y) / rx, (cosine * half.y - sine * half.x) / ry};
        double length = std::hypot(h.x, h.y);
        if (length == 0 || !std::isfinite(length)) return line_to(end); // below the precision of double
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
        const int count = std::max(1, static_cast<int>(std::ceil(turn / most_turn_ - 1e-6)));
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
                3);
            path_.back().segments.back().goes_on = i > 0;
        }
    }

    /// Closes the subpath; by a line, unless the gap is a rounding error, as after relative steps.
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
            subpath.has_closing_line = true;
        } else if (!segments.empty()) {
            segments.back().p3 = start;
        }
        subpath.closed = true;
        open_ = false;
        current_ = start;
    }

    /// A third of the way to `far`.
    static Point2 third(const Point2& near, const Point2& far) {
        return {near.x * (2.0 / 3.0) + far.x / 3, near.y * (2.0 / 3.0) + far.y / 3};
    }

private:
    void add(const Point2& p1, const Point2& p2, const Point2& p3, unsigned degree) {
        if (!open_) move_to(current_);
        path_.back().segments.push_back({p1, p2, p3, degree});
        current_ = p3;
        finite_ = finite_ && is_finite(p1) && is_finite(p2) && is_finite(p3);
    }

    double most_turn_;
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

/// Converts ASCII letters to lower case.
std::string lowered(std::string_view text);

} // namespace detail

/// Parses path data to absolute subpaths of cubics; empty text is an empty path.
///
///   fails       at the first syntax error, number out of range, or overflow of relative steps
///   most_turn   largest angle per cubic of an arc
Expected<Path> parse_path_data(std::string_view text, double most_turn = arc_of_figure);

/// As parse_path_data(), but returns the path up to the error, as browsers do; an empty path on overflow.
struct ReadPath {
    Path path;
    std::optional<FileError> fault;
};
ReadPath read_path_data(std::string_view text, double most_turn = arc_of_figure);

/// A number and the text after it; nothing if the text does not begin with a number.
struct Quantity {
    double value = 0;
    std::string_view unit;
};
std::optional<Quantity> read_quantity(std::string_view text);

/// Parses numbers separated by white space and at most one comma, as in `points` and `viewBox`.
Expected<std::vector<double>> parse_numbers(std::string_view text);

/// Parses a `transform` attribute to one map; functions of SVG 1.1, angles in degrees.
Expected<Affine2> parse_transform(std::string_view text);

/// Parses a length, or calc(), min(), max() or clamp() of lengths, to user units: 96 per inch; percentages of
/// `whole`; ex and ch are half an em.
///
///   em, root_em   font size of the element and of the root
Expected<double> parse_length(std::string_view text, double whole, double em = 16, double root_em = 16);

/// The shortest text that reads back as `value` rounded to `decimals` digits after the point (0 to 17).
std::string format_number(double value, int decimals);

/// Path data with absolute M, L, C and Z; a final line to the start is left to Z.
std::string write_path_data(const Path& path, int decimals);

/// Compact path data: relative commands; a final line to the start is left to Z. Paths with equal pieces get
/// equal commands. The error of each coordinate is at most half a unit of the last digit.
///
///   decimals   0 to 15
std::string write_short_path_data(const Path& path, int decimals);

} // namespace cageform_support
