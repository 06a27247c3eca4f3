#include "svg/drawn_figure.hpp"

#include "svg/walk.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cageform_support {

namespace detail {

using Vec2 = cageform::Vec<double, 2>;

Vec2 to_vec(const Point2& p) {
    return {p.x, p.y};
}

/// A flattened subpath. The first point of a closed subpath is not repeated.
struct Outline {
    std::vector<Vec2> points;
    std::vector<bool> is_corner; // not inside a curve
    bool closed = false;
    bool curved = false;
};

Outline flattened(const Subpath& subpath, double tolerance) {
    Outline outline{{to_vec(subpath.start)}, {true}, false, false};
    Point2 from = subpath.start;
    for (const Segment& s : subpath.segments) {
        const std::size_t pieces = pieces_of(from, s, tolerance);
        outline.curved = outline.curved || pieces > 1;
        for (std::size_t k = 1; k <= pieces; ++k) {
            outline.points.push_back(
                to_vec(k < pieces ? place_on(from, s, double(k) / double(pieces)) : s.p3));
            outline.is_corner.push_back(k == pieces);
        }
        from = s.p3;
    }
    outline.closed = subpath.closed;
    if (outline.closed && outline.points.size() > 1) {
        outline.points.pop_back();
        outline.is_corner.pop_back();
    }
    return outline;
}

Vec2 direction(const Vec2& from, const Vec2& to) {
    const Vec2 e = to - from;
    const double size = std::hypot(e[0], e[1]);
    return size > 0 ? (1 / size) * e : Vec2{0, 0};
}

/// Adds the segment from a corner to the tip of its mitre, unless the mitre limit cuts it off (SVG 2, "Line
/// join shape").
void add_miter(const Vec2& before, const Vec2& corner, const Vec2& after, double radius, double limit,
               DrawnFigure& figure) {
    const Vec2 u = direction(before, corner), v = direction(corner, after);
    const Vec2 across = u - v; // points to the outside of the corner
    const double half_sine = std::sqrt(std::max((1 + -dot(u, v)) / 2, 0.0)); // of half the turn
    const double cosine = std::sqrt(std::max((1 + dot(u, v)) / 2, 0.0));     // the sine of half the angle
    if (half_sine < 1e-6 || !(cosine * limit >= 1)) return;
    figure.segments.push_back({corner, corner + (radius / cosine) * direction({0, 0}, across), 0});
}

void add_square_cap(const Vec2& inner, const Vec2& end, double radius, DrawnFigure& figure) {
    Vec2 u = direction(inner, end);
    if (u == Vec2{0, 0}) u = {1, 0};
    const Vec2 side{-u[1], u[0]};
    for (const double sign : {-1.0, 1.0})
        figure.segments.push_back({end, end + radius * u + (sign * radius) * side, 0});
}

void add_stroke(const Outline& outline, const DrawnShape& shape, double radius, DrawnFigure& figure) {
    const auto& p = outline.points;
    const std::size_t n = p.size();
    if (shape.has_miters) {
        for (std::size_t i = outline.closed ? 0 : 1; i + (outline.closed ? 0 : 1) < n; ++i) {
            if (outline.is_corner[i])
                add_miter(p[(i + n - 1) % n], p[i], p[(i + 1) % n], radius, shape.miter_limit, figure);
        }
    }
    if (shape.has_square_caps && !outline.closed) {
        add_square_cap(p[n > 1 ? 1 : 0], p[0], radius, figure);
        add_square_cap(p[n > 1 ? n - 2 : 0], p[n - 1], radius, figure);
    }
}

void add_shape(const DrawnShape& shape, double tolerance, DrawnFigure& figure) {
    const bool filled = shape.is_box || shape.has_fill;
    const double radius =
        shape.has_stroke && !shape.is_box ? shape.stroke_width / 2 * largest_scale(shape.to_root) : 0;
    const std::size_t begin = figure.segments.size();
    std::vector<Outline> outlines;
    for (const Subpath& subpath : shape.path) {
        if (!subpath.segments.empty()) outlines.push_back(flattened(subpath, tolerance));
    }
    for (const Outline& outline : outlines) {
        const double thick = radius + (outline.curved ? tolerance : 0);
        const std::size_t n = outline.points.size();
        if (n == 1) figure.segments.push_back({outline.points[0], outline.points[0], thick});
        for (std::size_t i = 0; i + 1 < n; ++i)
            figure.segments.push_back({outline.points[i], outline.points[i + 1], thick});
        if (n > 1 && (outline.closed || filled)) // fills close open paths
            figure.segments.push_back({outline.points[n - 1], outline.points[0], outline.closed ? thick : 0});
    }
    if (filled) figure.areas.push_back({begin, figure.segments.size(), shape.even_odd});
    if (radius == 0) return;
    for (const Outline& outline : outlines) add_stroke(outline, shape, radius, figure);
}

/// The root's viewBox or size; the whole plane if it has neither.
Box page_of(const SvgDocument& document) {
    const pugi::xml_node root = root_element(document.xml);
    const auto view = view_box(document);
    const auto is_given = [&](const char* name) {
        const auto length = parse_length(attribute_text(root, name), 0); // percentages become 0
        return length && *length > 0;
    };
    constexpr double far = std::numeric_limits<double>::infinity();
    if (!(view_box_of(root) || (is_given("width") && is_given("height")))) return {-far, -far, far, far};
    return box_of(view);
}

} // namespace detail

Expected<DrawnFigure> drawn_figure(const SvgDocument& document) {
    SvgDocument work = detail::copy_of(document);
    std::vector<std::string> warnings;
    detail::StyleSheets styles(work);
    detail::IdTable ids(detail::root_element(work.xml));
    const auto drawing = detail::walk(work, styles, ids, {.boxes = true}, warnings);
    if (!drawing) return drawing.error();
    for (std::string& line : styles.report.lines()) warnings.push_back(std::move(line));
    // Shapes off the page are ignored, unless all are.
    const auto page = detail::page_of(work);
    const auto& all = drawing->shapes;
    const std::vector<detail::Box> seen = detail::seen_boxes(*drawing);
    const bool any = std::any_of(seen.begin(), seen.end(),
                                 [&](const detail::Box& box) { return !box.within(page).empty(); });
    const auto counts = [&](std::size_t i) { return !(any ? seen[i].within(page) : seen[i]).empty(); };
    detail::Box box;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (counts(i)) box.add(detail::bounds(all[i].path));
    }
    const double tolerance = box.empty() ? 0 : 5e-4 * std::hypot(box.width(), box.height());
    DrawnFigure figure;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (counts(i)) detail::add_shape(all[i], tolerance, figure);
    }
    if (figure.segments.empty()) {
        return FileError{document.name + " paints nothing that a cage could enclose" +
                         (warnings.empty() ? "" : "; " + warnings[0])};
    }
    return figure;
}

} // namespace cageform_support
